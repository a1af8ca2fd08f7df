//! The figures of verifications.

use super::super::{Beside, Tones, UncompensatedPrediction, Verification};
use crate::figure::{Axis, Chart, Figure, Line, Panels, Tone, range};
use crate::quantity::{Band, Decibels, Drive};
use crate::series::Series;

/// The target: the measurement lies over it.
pub(super) const UNDER: Tone = Tone::Pale;
pub(super) const MEASURED: Tone = Tone::Main;
const OTHER: Tone = Tone::Second;
/// What is compared as well.
const THIRD: Tone = Tone::Signal;

/// Above this the textures of the thesis hold next to nothing, Hz.
const TEXTURES_END_HZ: f64 = 500.0;
/// How much of a waveform is drawn, s.
const STRETCH_S: f64 = 0.15;
/// The range of levels that is drawn, dB.
pub(super) const DEPTH_DB: f64 = 70.0;

/// Powers by frequency as levels, dB.
pub(super) fn decibels(frequencies_hz: &[f64], powers: &[f64]) -> Vec<(f64, f64)> {
    let pairs = frequencies_hz.iter().zip(powers);
    pairs
        .map(|(hz, power)| (*hz, Decibels::from_power(*power).0))
        .collect()
}

/// The span of frequencies that figures of a band show, Hz: a little more on both sides.
pub(super) fn span(band: Band) -> (f64, f64) {
    ((band.low().0 * 0.6).max(1.0), band.high().0 * 1.4)
}

/// What is judged: the achievable parts of the band where they are known, or all of it.
fn judged(verification: &Verification) -> Vec<(f64, f64)> {
    let bands = match verification.achievable_band_hz.as_slice() {
        [] => std::slice::from_ref(&verification.band_hz),
        achievable => achievable,
    };
    let ends = bands.iter().map(|band| (band.low().0, band.high().0));
    ends.collect()
}

/// PSDs around the band that is judged.
fn spectra_chart(verification: &Verification, lines: Vec<Line>) -> Chart {
    let (from, to) = span(verification.band_hz);
    let points: Vec<&[(f64, f64)]> = lines.iter().map(|line| line.points.as_slice()).collect();
    let (low, high) = range(&points, from, to, 10.0, DEPTH_DB);
    let label = format!("PSD, dB re 1 {}", verification.psd_unit);
    Chart {
        shaded: judged(verification),
        ..Chart::new(
            Axis::log("frequency, Hz", from, to),
            Axis::new(label, low, high),
            lines,
        )
    }
}

fn target_line(verification: &Verification) -> Line {
    let points = decibels(&verification.frequency_hz, &verification.target_psd);
    Line::new("target", UNDER, points).thick()
}

fn measured_line(label: &str, tone: Tone, verification: &Verification) -> Line {
    let points = decibels(&verification.frequency_hz, &verification.measured_psd);
    Line::new(label, tone, points)
}

/// Target and measured PSD, and below them the error of every line that is judged.
pub(super) fn spectra(verification: &Verification) -> Figure {
    let measured = measured_line("measured on the finger", MEASURED, verification);
    let mut lines = vec![target_line(verification), measured];
    if verification.is_of_a_part() {
        let whole = decibels(&verification.frequency_hz, &verification.texture_psd);
        lines.push(Line::new("whole texture", OTHER, whole).thin());
    }
    let psds = spectra_chart(verification, lines);
    Panels::new(vec![psds, error(verification)]).captioned(
        "Power spectral densities of the target and of the acceleration measured on the fingernail, and below the error at each \
         spectral line. Shaded: the evaluated band. Red: the limit for the rms of the error; single lines may exceed it.",
    )
}

/// The PSDs of the target and of what an open and a closed loop made of it, and below them the error of the closed one.
///
/// Source: docs/decisions/verification.md.
#[must_use]
pub fn open_and_closed(open: &Verification, closed: &Verification) -> Panels {
    let lines = vec![
        target_line(closed),
        measured_line("open loop", OTHER, open).thin(),
        measured_line("closed loop", MEASURED, closed),
    ];
    Panels::new(vec![spectra_chart(closed, lines), error(closed)])
}

/// The target's PSD, that of the measurement called `measured`, and those of further measurements.
pub(super) fn all_spectra(
    (measured, verification): (&str, &Verification),
    also: &[(&str, &Verification)],
) -> Figure {
    let mut lines = vec![
        target_line(verification),
        measured_line(measured, MEASURED, verification),
    ];
    for ((label, also), tone) in also.iter().zip(others(also.len())) {
        lines.push(measured_line(label, tone, also).thin());
    }
    spectra_chart(verification, lines).captioned(format!(
        "PSDs of the target and of all measurements, as measured and aligned in time with the target. The target is shown at the \
         level requested for {measured}. Shaded: the evaluated band of {measured}."
    ))
}

/// Colours of `count` lines beside the one of the measurement.
pub(super) fn others(count: usize) -> Vec<Tone> {
    match count {
        0..=2 => vec![OTHER, THIRD],
        // The third of them is as green as the measurement.
        3..=6 => {
            let mut colours = Tone::several(7);
            colours.remove(2);
            colours
        }
        more => Tone::several(more),
    }
}

/// The texture sent directly to the device, measured: as it stands, and turned down until nothing clips.
pub(super) fn uncompensated(as_it_stands: &Verification, turned_down: &Verification) -> Figure {
    let lines = vec![
        target_line(as_it_stands),
        measured_line("sent directly, unscaled", OTHER, as_it_stands),
        measured_line("sent directly, attenuated", THIRD, turned_down).thin(),
    ];
    spectra_chart(as_it_stands, lines)
        .captioned("Measured response to the texture sent directly: unscaled, and attenuated.")
}

/// The target's PSD, and what the transfer function makes of it.
pub(super) fn predicted(verification: &Verification, predicted: &UncompensatedPrediction) -> Chart {
    let hz = &predicted.frequency_hz;
    let lines = vec![
        Line::new("target", UNDER, decibels(hz, &predicted.target_psd)).thick(),
        Line::new(
            "sent directly, computed, level-matched",
            OTHER,
            decibels(hz, &predicted.answer_psd),
        ),
    ];
    spectra_chart(verification, lines)
}

/// The highest frequency of the amplitude spectra that is drawn, Hz: textures have their tones below.
pub(super) fn amplitudes_end_hz(band: Band) -> f64 {
    match band.high().0 {
        high if high > TEXTURES_END_HZ && band.low().0 < TEXTURES_END_HZ => TEXTURES_END_HZ,
        high => high,
    }
}

/// Amplitude spectra up to where textures hold most of their power, or to the end of the band.
pub(super) fn amplitudes(verification: &Verification, tones: &Tones) -> Chart {
    let to = amplitudes_end_hz(verification.band_hz);
    let points = |values: &[f64]| -> Vec<(f64, f64)> {
        let lines = tones.frequency_hz.iter().copied();
        let lines = lines.zip(values.iter().copied());
        lines.filter(|(hz, _)| *hz <= to).collect()
    };
    let (target, measured) = (points(&tones.target), points(&tones.measured));
    let both = target.iter().chain(&measured).map(|(_, v)| *v);
    let top = both.fold(f64::MIN_POSITIVE, f64::max) * 1.08;
    let lines = vec![
        Line::new("target", UNDER, target).thick(),
        Line::new("measured on the finger", MEASURED, measured).thin(),
    ];
    Chart::new(
        Axis::new("frequency, Hz", 0.0, to),
        Axis::new("amplitude, m/s²", 0.0, top),
        lines,
    )
}

/// The error of every line that is judged.
fn error(verification: &Verification) -> Chart {
    let (from, to) = span(verification.band_hz);
    let hz = verification.error_frequency_hz.iter().copied();
    let points: Vec<(f64, f64)> = hz.zip(verification.error_db.iter().copied()).collect();
    let (low, high) = range(&[&points], from, to, 1.0, 40.0);
    let reach = low.abs().max(high.abs()).max(2.0);
    let limit_db = verification.limits.error_db_rms;
    Chart {
        shaded: judged(verification),
        levels: vec![-limit_db, limit_db],
        ..Chart::new(
            Axis::log("frequency, Hz", from, to),
            Axis::new("measured − target, dB", -reach, reach),
            vec![Line::new("", MEASURED, points)],
        )
    }
}

/// The PSDs of a texture and of its drive, each over its own mean square.
pub(super) fn beside_spectra(verification: &Verification, both: &Beside) -> Chart {
    let target = decibels(&both.frequency_hz, &both.target_psd);
    let drive = decibels(&both.frequency_hz, &both.drive_psd);
    // What lies outside the band was taken away.
    let (from, to) = (verification.band_hz.low().0, verification.band_hz.high().0);
    let (low, high) = range(&[&target, &drive], from, to, 10.0, DEPTH_DB);
    Chart {
        shaded: judged(verification),
        ..Chart::new(
            Axis::log("frequency, Hz", from, to),
            Axis::new("PSD divided by mean square, dB re 1/Hz", low, high),
            vec![
                Line::new("texture", UNDER, target).thick(),
                Line::new("drive", OTHER, drive),
            ],
        )
    }
}

/// A short stretch of a texture and its drive, from the middle, over their rms.
pub(super) fn beside_waveforms(verification: &Verification, both: &Beside) -> Chart {
    let waveforms = [&both.target, &both.drive].map(Vec::as_slice);
    stretch(
        (verification.rate_hz, "value divided by its rms"),
        waveforms,
        [("texture", UNDER), ("drive", OTHER)],
    )
}

/// A short stretch of the target and the aligned measurement, from the middle.
pub(super) fn waveforms(verification: &Verification) -> Chart {
    let waveforms = [&verification.target, &verification.aligned].map(Vec::as_slice);
    stretch(
        (verification.rate_hz, "acceleration, m/s²"),
        waveforms,
        [("target", UNDER), ("measured, aligned", MEASURED)],
    )
}

/// The middle of two waveforms of one length, the first below the second.
fn stretch(
    (rate_hz, label): (f64, &str),
    waveforms: [&[f64]; 2],
    names: [(&str, Tone); 2],
) -> Chart {
    let shown = (STRETCH_S * rate_hz) as usize;
    let count = waveforms[0].len().min(waveforms[1].len());
    let start = count.saturating_sub(shown) / 2;
    let line = |i: usize| {
        let (name, tone) = names[i];
        let places = start..count.min(start + shown);
        let points = places.map(|at| (at as f64 / rate_hz, waveforms[i][at]));
        Line::new(name, tone, points.collect())
    };
    let lines = vec![line(0).thick(), line(1).thin()];
    let points = lines.iter().flat_map(|line| &line.points);
    let sizes = points.map(|(_, y)| y.abs());
    let reach = sizes.fold(f64::MIN_POSITIVE, f64::max) * 1.08;
    let seconds = |samples: usize| samples as f64 / rate_hz;
    Chart::new(
        Axis::new("time, s", seconds(start), seconds(start + shown)),
        Axis::new(label, -reach, reach),
        lines,
    )
}

/// The drive with the level at which the device clips.
pub(super) fn drive(drive: &Series<Drive>, limit: f64) -> Chart {
    let rate_hz = drive.rate().hz();
    let samples = drive.samples().iter().enumerate();
    let points = samples.map(|(i, v)| (i as f64 / rate_hz, *v)).collect();
    let reach = drive.peak().max(limit) * 1.15;
    Chart {
        levels: vec![-limit, limit],
        ..Chart::new(
            Axis::new("time, s", 0.0, drive.duration().0),
            Axis::new("drive, full scale = 1", -reach, reach),
            vec![Line::new("", OTHER, points).thin()],
        )
    }
}
