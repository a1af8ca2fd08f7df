//! The figures of a verification report, one function for each.

use piezotact::quantity::{Band, Decibels, Drive, Quantity};
use piezotact::series::Series;
use piezotact::transfer::{Distortion, DistortionLevels, TransferFunction};
use piezotact::verify::Verification;
use plotters::style::RGBColor;

use super::axis::Axis;
use super::chart::{Chart, Corner, HEIGHT, Line, Mark, WIDTH, range};
use crate::failure::Outcome;
use crate::report::verify::Straight;

const TARGET: RGBColor = RGBColor(30, 30, 30);
/// The target where the measurement lies over it.
const UNDER: RGBColor = RGBColor(172, 180, 188);
const MEASURED: RGBColor = RGBColor(0, 121, 107);
const OTHER: RGBColor = RGBColor(198, 83, 26);

fn decibels(frequencies_hz: &[f64], powers: &[f64]) -> Vec<(f64, f64)> {
    frequencies_hz
        .iter()
        .zip(powers)
        .map(|(f, p)| (*f, Decibels::from_power(*p).0))
        .collect()
}

/// The PSD of one channel, as a file of its own: `title` says what it is and how it was estimated.
pub(crate) fn psd(
    title: &str,
    unit: &str,
    frequencies_hz: &[f64],
    values: &[f64],
) -> Outcome<String> {
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
        legend: Corner::UpperRight,
    };
    let svg = chart.svg(HEIGHT + 120)?;
    // In a page a figure takes the width there is; a file of its own needs its size.
    let size = format!("width=\"{WIDTH}\" height=\"{}\"", HEIGHT + 120);
    Ok(svg.replacen("role=\"img\"", &size, 1))
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

/// Target and measured PSD around the band that is judged.
pub(crate) fn spectra(verification: &Verification) -> Outcome<String> {
    let f = &verification.frequency_hz;
    let target = decibels(f, &verification.target_psd);
    let measured = decibels(f, &verification.measured_psd);
    let lines = vec![
        Line::new("target", UNDER, target).thick(),
        Line::new("measured on the finger", MEASURED, measured),
    ];
    spectra_chart(verification, lines)
}

/// The target's PSD, and what comes of sending the texture straight to the device: as it stands, and turned
/// down until nothing clips.
pub(crate) fn straight(straight: &Straight<Verification>) -> Outcome<String> {
    let loud = &straight.as_it_stands;
    let quiet = &straight.turned_down;
    let lines = vec![
        Line::new(
            "target",
            UNDER,
            decibels(&loud.frequency_hz, &loud.target_psd),
        )
        .thick(),
        Line::new(
            "sent straight, device's own scale",
            OTHER,
            decibels(&loud.frequency_hz, &loud.measured_psd),
        ),
        Line::new(
            "sent straight, turned down",
            TARGET,
            decibels(&quiet.frequency_hz, &quiet.measured_psd),
        )
        .thin(),
    ];
    spectra_chart(loud, lines)
}

fn spectra_chart(verification: &Verification, lines: Vec<Line>) -> Outcome<String> {
    let (from, to) = span(verification.band_hz);
    let points: Vec<&[(f64, f64)]> = lines.iter().map(|line| line.points.as_slice()).collect();
    let (low, high) = range(&points, from, to, 10.0, 70.0);
    Chart {
        title: String::new(),
        x: Axis::log("frequency, Hz", from, to),
        // Room for the legend above the lines.
        y: Axis::new(
            format!("PSD, dB re 1 {}", verification.psd_unit),
            low,
            high + 12.0,
        ),
        shaded: judged(verification),
        levels: Vec::new(),
        rejected: Vec::new(),
        notes: Vec::new(),
        legend: Corner::UpperRight,
        lines,
    }
    .svg(HEIGHT + 40)
}

/// The error of every line that is judged.
pub(crate) fn error(verification: &Verification) -> Outcome<String> {
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
        legend: Corner::UpperRight,
        lines: vec![Line::new("", MEASURED, points)],
    }
    .svg(HEIGHT - 60)
}

/// A short stretch of the target and the aligned measurement, from the middle.
pub(crate) fn waveforms(verification: &Verification) -> Outcome<String> {
    let rate_hz = verification.rate_hz;
    let shown = (0.15 * rate_hz) as usize;
    let count = verification.target.len().min(verification.aligned.len());
    let start = count.saturating_sub(shown) / 2;
    let points = |samples: &[f64]| -> Vec<(f64, f64)> {
        (start..count.min(start + shown))
            .map(|i| (i as f64 / rate_hz, samples[i]))
            .collect()
    };
    let (wanted, got) = (points(&verification.target), points(&verification.aligned));
    let reach = wanted
        .iter()
        .chain(&got)
        .map(|(_, y)| y.abs())
        .fold(f64::MIN_POSITIVE, f64::max)
        * 1.5;
    Chart {
        title: String::new(),
        x: Axis::new(
            "time, s",
            start as f64 / rate_hz,
            (start + shown) as f64 / rate_hz,
        ),
        y: Axis::new("acceleration, m/s²", -reach, reach),
        shaded: Vec::new(),
        levels: Vec::new(),
        rejected: Vec::new(),
        notes: Vec::new(),
        legend: Corner::UpperRight,
        lines: vec![
            Line::new("target", UNDER, wanted).thick(),
            Line::new("measured, aligned", MEASURED, got).thin(),
        ],
    }
    .svg(HEIGHT - 20)
}

/// Magnitude, phase and coherence of a transfer function in `unit`: three figures over one axis, the first two with their
/// 95 % confidence where it is known.
pub(crate) fn transfer<I: Quantity, O: Quantity>(
    function: &TransferFunction<I, O>,
    band: Band,
    unit: &str,
) -> Outcome<Vec<String>> {
    let (from, to) = span(band);
    let db = |magnitude: f64| Decibels::from_amplitude_ratio(magnitude).0;
    // What nothing drove is not drawn.
    let driven = |hz: &f64| function.driven.is_none_or(|driven| driven.contains(*hz));
    let lines: Vec<(usize, f64)> = (1..)
        .zip(function.frequencies_hz().into_iter().skip(1))
        .filter(|(_, hz)| driven(hz))
        .collect();
    let drawn = |value: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        lines.iter().map(|(line, hz)| (*hz, value(*line))).collect()
    };
    let phase_of = |line: usize| function.response()[line].arg().to_degrees();
    let magnitude = drawn(&|line| db(function.response()[line].norm()));
    let phase = drawn(&phase_of);
    let coherence = drawn(&|line| function.coherence()[line]);
    let (low, high) = range(&[&magnitude], from, to, 10.0, 80.0);
    let limits = function.confidence();
    let (mut magnitudes, mut phases) = (Vec::new(), Vec::new());
    if let Some(limits) = &limits {
        for (line, hz) in lines.iter().copied() {
            magnitudes.push((hz, db(limits.low[line]), db(limits.high[line])));
            let reach = limits.phase_reach_rad[line].to_degrees();
            phases.push((hz, phase_of(line) - reach, phase_of(line) + reach));
        }
    }
    // A coherence of 0.98 and one of 0.999 are worlds apart: the axis begins below the lowest in the band.
    let lowest = function
        .coherence_in(band)
        .map_or(0.0, |summary| summary.lowest.clamp(0.0, 1.0));
    let floor = ((lowest * 10.0).floor() / 10.0).min(0.9);
    let chart = |label: &str, (low, high): (f64, f64), line: Line| Chart {
        shaded: vec![(band.low().0, band.high().0)],
        ..Chart::new(
            Axis::log("frequency, Hz", from, to),
            Axis::new(label, low, high),
            vec![line.thin()],
        )
    };
    Ok(vec![
        chart(
            &format!("|H|, dB re 1 {unit}"),
            (low, high),
            Line::new("", MEASURED, magnitude).ribbon(magnitudes),
        )
        .svg(HEIGHT - 20)?,
        chart(
            "phase with delay, °",
            (-180.0, 180.0),
            Line::new("", TARGET, phase).ribbon(phases),
        )
        .svg(HEIGHT - 80)?,
        chart(
            "coherence",
            (floor, 1.0 + 0.05 * (1.0 - floor)),
            Line::new("", OTHER, coherence),
        )
        .svg(HEIGHT - 80)?,
    ])
}

/// The answer, noise and distortion by third octave.
pub(crate) fn distortion(distortion: &Distortion, unit: &str) -> Outcome<String> {
    let levels = &distortion.levels;
    let centre = |l: &DistortionLevels| (l.band_hz.low().0 * l.band_hz.high().0).sqrt();
    let of = |value: &dyn Fn(&DistortionLevels) -> Option<f64>| -> Vec<(f64, f64)> {
        let told = levels.iter().filter_map(|l| Some((centre(l), value(l)?)));
        told.filter(|(_, v)| *v > 0.0)
            .map(|(f, v)| (f, Decibels::from_amplitude_ratio(v).0))
            .collect()
    };
    let lines = vec![
        Line::new("answer", MEASURED, of(&|l| Some(l.linear))).marked(Mark::Joined),
        Line::new("noise of one period", UNDER, of(&|l| Some(l.noise))).marked(Mark::Joined),
        Line::new("even distortion", OTHER, of(&|l| l.even)).marked(Mark::Joined),
        Line::new("odd distortion", TARGET, of(&|l| l.odd)).marked(Mark::Joined),
    ];
    let (from, to) = match (levels.first(), levels.last()) {
        (Some(first), Some(last)) => (first.band_hz.low().0, last.band_hz.high().0),
        _ => (20.0, 1000.0),
    };
    let points: Vec<&[(f64, f64)]> = lines.iter().map(|line| line.points.as_slice()).collect();
    let (low, high) = range(&points, from, to, 10.0, 120.0);
    Chart::new(
        Axis::log("frequency, Hz", from, to),
        Axis::new(format!("level of a line, dB re 1 {unit} rms"), low, high),
        lines,
    )
    .svg(HEIGHT + 20)
}

/// The drive with the level at which the device clips.
pub(crate) fn drive(drive: &Series<Drive>, limit: f64) -> Outcome<String> {
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
        legend: Corner::UpperRight,
        lines: vec![Line::new("", MEASURED, points).thin()],
    }
    .svg(HEIGHT - 60)
}
