//! The figures of verifications, one function for each.

use piezotact::quantity::{Acceleration, Band, Decibels, Drive};
use piezotact::series::Series;
use piezotact::statistics::{mean, standard_deviation};
use piezotact::verify::{Beside, Tones, UncompensatedPrediction, Verification};

use crate::chart::{self, HEIGHT};
use crate::verify::{Page, Uncompensated};
use crate::{Draw, DrawError};
use piezotact::figure::{Axis, Chart, Legend, Line, Panels, Tone, range};
use piezotact::number::digits;

/// The target: the measurement lies over it.
const UNDER: Tone = Tone::Pale;
const MEASURED: Tone = Tone::Main;
const OTHER: Tone = Tone::Second;
/// What is compared as well.
const THIRD: Tone = Tone::Signal;

/// Above this the textures of the thesis hold next to nothing, Hz.
const TEXTURES_END_HZ: f64 = 500.0;
/// How much of a waveform is drawn, s.
const STRETCH_S: f64 = 0.15;

fn decibels(frequencies_hz: &[f64], powers: &[f64]) -> Vec<(f64, f64)> {
    frequencies_hz
        .iter()
        .zip(powers)
        .map(|(f, p)| (*f, Decibels::from_power(*p).0))
        .collect()
}

/// The PSD of one channel, as a file of its own: `title` says what it is and how it was estimated.
///
/// # Errors
/// [`DrawError`] where it cannot be drawn.
pub fn psd(
    title: &str,
    unit: &str,
    frequencies_hz: &[f64],
    values: &[f64],
) -> Result<String, DrawError> {
    let points = decibels(&frequencies_hz[1..], &values[1..]);
    let last = frequencies_hz[frequencies_hz.len() - 1];
    let (low, high) = range(&[&points], 0.0, last, 10.0, 120.0);
    let chart = Chart {
        title: title.into(),
        x: Axis::log("frequency, Hz", frequencies_hz[1], last),
        y: Axis::new(format!("PSD, dB re 1 {unit}"), low, high),
        lines: vec![Line::new("", MEASURED, points)],
        shaded: Vec::new(),
        levels: Vec::new(),
        rejected: Vec::new(),
        notes: Vec::new(),
        legend: Legend::Above,
    };
    chart::file(&chart, HEIGHT + 120)
}

/// The span of frequencies that figures of a band show: a little more on both sides.
fn span(band: Band) -> (f64, f64) {
    ((band.low().0 * 0.6).max(1.0), band.high().0 * 1.4)
}

/// What is judged: the achievable parts of the band where they are known, or all of it.
fn judged(verification: &Verification) -> Vec<(f64, f64)> {
    let bands = match verification.achievable_band_hz.as_slice() {
        [] => std::slice::from_ref(&verification.band_hz),
        achievable => achievable,
    };
    bands
        .iter()
        .map(|band| (band.low().0, band.high().0))
        .collect()
}

/// Target and measured PSD around the band that is judged, and below them the error of every line that is judged.
pub(crate) fn spectra(verification: &Verification) -> Result<String, DrawError> {
    let f = &verification.frequency_hz;
    let target = decibels(f, &verification.target_psd);
    let measured = decibels(f, &verification.measured_psd);
    let lines = vec![
        Line::new("target", UNDER, target).thick(),
        Line::new("measured on the finger", MEASURED, measured),
    ];
    Panels::new(vec![psds(verification, lines), error(verification)]).svg(HEIGHT + 40)
}

/// The target's PSD, and those of what an open and a closed loop made of it; below, the error of the closed one.
pub(crate) fn open_and_closed(
    open: &Verification,
    closed: &Verification,
) -> Result<String, DrawError> {
    let f = &closed.frequency_hz;
    let lines = vec![
        Line::new("target", UNDER, decibels(f, &closed.target_psd)).thick(),
        Line::new(
            "open loop",
            OTHER,
            decibels(&open.frequency_hz, &open.measured_psd),
        )
        .thin(),
        Line::new("closed loop", MEASURED, decibels(f, &closed.measured_psd)),
    ];
    Panels::new(vec![psds(closed, lines), error(closed)]).svg(HEIGHT + 40)
}

/// The target's PSD, that of the measurement, and those of further measurements.
pub(crate) fn all_spectra(page: &Page<'_>) -> Result<String, DrawError> {
    let v = page.verification;
    let mut lines = vec![
        Line::new("target", UNDER, decibels(&v.frequency_hz, &v.target_psd)).thick(),
        Line::new(
            page.measured,
            MEASURED,
            decibels(&v.frequency_hz, &v.measured_psd),
        ),
    ];
    for (also, colour) in page.also.iter().zip(others(page.also.len())) {
        let v = also.verification;
        let points = decibels(&v.frequency_hz, &v.measured_psd);
        lines.push(Line::new(also.label, colour, points).thin());
    }
    spectra_chart(v, lines)
}

/// Colours of `count` lines beside the one of the measurement.
fn others(count: usize) -> Vec<Tone> {
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

/// The target's PSD, and what the transfer function makes of it.
pub(crate) fn predicted(
    verification: &Verification,
    predicted: &UncompensatedPrediction,
) -> Result<String, DrawError> {
    let f = &predicted.frequency_hz;
    let lines = vec![
        Line::new("target", UNDER, decibels(f, &predicted.target_psd)).thick(),
        Line::new(
            "sent directly, computed, level-matched",
            OTHER,
            decibels(f, &predicted.answer_psd),
        ),
    ];
    spectra_chart(verification, lines)
}

/// Amplitude spectra up to where textures hold most of their power, or to the end of the band.
pub(crate) fn amplitudes(verification: &Verification, tones: &Tones) -> Result<String, DrawError> {
    let band = verification.band_hz;
    let to = match band.high().0 {
        high if high > TEXTURES_END_HZ && band.low().0 < TEXTURES_END_HZ => TEXTURES_END_HZ,
        high => high,
    };
    let points = |values: &[f64]| -> Vec<(f64, f64)> {
        let lines = tones
            .frequency_hz
            .iter()
            .copied()
            .zip(values.iter().copied());
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
    .svg(HEIGHT + 20)
}

/// The PSDs of a texture and of its drive, each over its own mean square.
pub(crate) fn beside_spectra(
    verification: &Verification,
    both: &Beside,
) -> Result<String, DrawError> {
    let f = &both.frequency_hz;
    let target = decibels(f, &both.target_psd);
    let drive = decibels(f, &both.drive_psd);
    // What lies outside the band was taken away.
    let (from, to) = (verification.band_hz.low().0, verification.band_hz.high().0);
    let (low, high) = range(&[&target, &drive], from, to, 10.0, 70.0);
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
    .svg(HEIGHT + 40)
}

/// A short stretch of a texture and its drive, from the middle, over their rms.
pub(crate) fn beside_waveforms(
    verification: &Verification,
    both: &Beside,
) -> Result<String, DrawError> {
    let lines = vec![
        ("texture", UNDER, both.target.as_slice(), Stroke::Thick),
        ("drive", OTHER, &both.drive, Stroke::Thin),
    ];
    stretch(verification.rate_hz, "value divided by its rms", lines)
}

/// The stretch of textures that is drawn before and after, s.
pub(crate) const BEFORE_DRAWN_S: f64 = 0.5;

/// The waveforms before, and that of the target, on one scale.
pub(crate) fn before_waveforms(page: &Page<'_>) -> Result<String, DrawError> {
    let points = |series: &Series<Acceleration>| -> Vec<(f64, f64)> {
        let (rate_hz, mean) = (series.rate().hz(), mean(series.samples()));
        let drawn = (BEFORE_DRAWN_S * rate_hz) as usize;
        let samples = series.samples().iter().take(drawn).enumerate();
        samples
            .map(|(i, v)| (i as f64 / rate_hz, v - mean))
            .collect()
    };
    let before: Vec<Line> = page
        .before
        .iter()
        .zip(before_colours(page))
        .map(|(before, colour)| {
            let label = level_label(before.label, before.changed.rms_before);
            Line::new(label, colour, points(before.series)).thin()
        })
        .collect();
    let label = level_label("target", standard_deviation(page.texture.samples()));
    let after = vec![Line::new(label, MEASURED, points(page.texture)).thin()];
    let all = before.iter().chain(&after).flat_map(|line| &line.points);
    let reach = all.map(|(_, v)| v.abs()).fold(f64::MIN_POSITIVE, f64::max) * 1.08;
    let drawn = |lines| {
        Chart::new(
            Axis::new("time, s", 0.0, BEFORE_DRAWN_S),
            Axis::new("acceleration, m/s²", -reach, reach),
            lines,
        )
    };
    Panels::new(vec![drawn(before), drawn(after)]).svg(HEIGHT - 20)
}

/// The PSDs before, and that of the target.
pub(crate) fn before_spectra(page: &Page<'_>) -> Result<String, DrawError> {
    let mut lines: Vec<Line> = page
        .before
        .iter()
        .zip(before_colours(page))
        .map(|(before, colour)| {
            let label = level_label(before.label, before.changed.rms_before);
            let changed = before.changed;
            Line::new(
                label,
                colour,
                decibels(&changed.frequency_hz, &changed.psd_before),
            )
        })
        .collect();
    if let Some(before) = page.before.first() {
        let changed = before.changed;
        let label = level_label("target", changed.rms_after);
        let points = decibels(&changed.frequency_hz, &changed.psd_after);
        lines.push(Line::new(label, MEASURED, points));
    }
    let band = page.verification.band_hz;
    let (from, to) = span(band);
    let points: Vec<&[(f64, f64)]> = lines.iter().map(|line| line.points.as_slice()).collect();
    let (low, high) = range(&points, from, to, 10.0, 70.0);
    let label = format!("PSD, dB re 1 {}", page.verification.psd_unit);
    Chart {
        shaded: vec![(band.low().0, band.high().0)],
        ..Chart::new(
            Axis::log("frequency, Hz", from, to),
            Axis::new(label, low, high),
            lines,
        )
    }
    .svg(HEIGHT + 60)
}

fn before_colours(page: &Page<'_>) -> Vec<Tone> {
    match page.before.len() {
        1 => vec![UNDER],
        many => others(many),
    }
}

fn level_label(what: &str, rms: f64) -> String {
    format!("{what}, {} m/s² rms", digits(rms))
}

/// The target's PSD, and the result of sending the texture directly to the device: as it stands, and turned
/// down until nothing clips.
pub(crate) fn uncompensated(
    uncompensated: &Uncompensated<Verification>,
) -> Result<String, DrawError> {
    let loud = &uncompensated.as_it_stands;
    let quiet = &uncompensated.turned_down;
    let lines = vec![
        Line::new(
            "target",
            UNDER,
            decibels(&loud.frequency_hz, &loud.target_psd),
        )
        .thick(),
        Line::new(
            "sent directly, unscaled",
            OTHER,
            decibels(&loud.frequency_hz, &loud.measured_psd),
        ),
        Line::new(
            "sent directly, attenuated",
            THIRD,
            decibels(&quiet.frequency_hz, &quiet.measured_psd),
        )
        .thin(),
    ];
    spectra_chart(loud, lines)
}

fn spectra_chart(verification: &Verification, lines: Vec<Line>) -> Result<String, DrawError> {
    psds(verification, lines).svg(HEIGHT + 40)
}

fn psds(verification: &Verification, lines: Vec<Line>) -> Chart {
    let (from, to) = span(verification.band_hz);
    let points: Vec<&[(f64, f64)]> = lines.iter().map(|line| line.points.as_slice()).collect();
    let (low, high) = range(&points, from, to, 10.0, 70.0);
    Chart {
        title: String::new(),
        x: Axis::log("frequency, Hz", from, to),
        y: Axis::new(format!("PSD, dB re 1 {}", verification.psd_unit), low, high),
        shaded: judged(verification),
        levels: Vec::new(),
        rejected: Vec::new(),
        notes: Vec::new(),
        legend: Legend::Above,
        lines,
    }
}

/// The error of every line that is judged.
fn error(verification: &Verification) -> Chart {
    let (from, to) = span(verification.band_hz);
    let points: Vec<(f64, f64)> = verification
        .error_frequency_hz
        .iter()
        .copied()
        .zip(verification.error_db.iter().copied())
        .collect();
    let (low, high) = range(&[&points], from, to, 1.0, 40.0);
    let reach = low.abs().max(high.abs()).max(2.0);
    let limit_db = verification.limits.error_db_rms;
    Chart {
        title: String::new(),
        x: Axis::log("frequency, Hz", from, to),
        y: Axis::new("measured − target, dB", -reach, reach),
        shaded: judged(verification),
        levels: vec![-limit_db, limit_db],
        rejected: Vec::new(),
        notes: Vec::new(),
        legend: Legend::Above,
        lines: vec![Line::new("", MEASURED, points)],
    }
}

/// A short stretch of the target and the aligned measurement, from the middle.
pub(crate) fn waveforms(verification: &Verification) -> Result<String, DrawError> {
    let lines = vec![
        (
            "target",
            UNDER,
            verification.target.as_slice(),
            Stroke::Thick,
        ),
        (
            "measured, aligned",
            MEASURED,
            &verification.aligned,
            Stroke::Thin,
        ),
    ];
    stretch(verification.rate_hz, "acceleration, m/s²", lines)
}

/// How a waveform is drawn.
#[derive(Clone, Copy)]
enum Stroke {
    Thick,
    Thin,
}

/// The middle of waveforms of one length, each with its name.
fn stretch(
    rate_hz: f64,
    label: &str,
    waveforms: Vec<(&str, Tone, &[f64], Stroke)>,
) -> Result<String, DrawError> {
    let shown = (STRETCH_S * rate_hz) as usize;
    let count = waveforms
        .iter()
        .map(|(_, _, samples, _)| samples.len())
        .min();
    let count = count.unwrap_or(0);
    let start = count.saturating_sub(shown) / 2;
    let lines: Vec<Line> = waveforms
        .into_iter()
        .map(|(name, colour, samples, stroke)| {
            let points =
                (start..count.min(start + shown)).map(|i| (i as f64 / rate_hz, samples[i]));
            let line = Line::new(name, colour, points.collect());
            match stroke {
                Stroke::Thick => line.thick(),
                Stroke::Thin => line.thin(),
            }
        })
        .collect();
    let points = lines.iter().flat_map(|line| &line.points);
    let reach = points
        .map(|(_, y)| y.abs())
        .fold(f64::MIN_POSITIVE, f64::max)
        * 1.08;
    let seconds = |samples: usize| samples as f64 / rate_hz;
    Chart::new(
        Axis::new("time, s", seconds(start), seconds(start + shown)),
        Axis::new(label, -reach, reach),
        lines,
    )
    .svg(HEIGHT - 20)
}

/// The drive with the level at which the device clips.
pub(crate) fn drive(drive: &Series<Drive>, limit: f64) -> Result<String, DrawError> {
    let rate_hz = drive.rate().hz();
    let points = drive
        .samples()
        .iter()
        .enumerate()
        .map(|(i, v)| (i as f64 / rate_hz, *v))
        .collect();
    let reach = drive.peak().max(limit) * 1.15;
    Chart {
        title: String::new(),
        x: Axis::new("time, s", 0.0, drive.duration().0),
        y: Axis::new("drive, full scale = 1", -reach, reach),
        shaded: Vec::new(),
        levels: vec![-limit, limit],
        rejected: Vec::new(),
        notes: Vec::new(),
        legend: Legend::Above,
        lines: vec![Line::new("", OTHER, points).thin()],
    }
    .svg(HEIGHT - 60)
}
