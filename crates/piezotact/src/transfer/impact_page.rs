//! The hits of an impact test in a report: pulses, responses, windows, spectrum of the force, and a table of what was used.

use super::page::TransferReport;
use super::{ImpactTest, ImpactTraces};
use crate::figure::{Axis, Chart, Line, Tone};
use crate::number::digits;
use crate::page::{Block, Cell, Column, Table};
use crate::quantity::Quantity;

/// The section about the hits; nothing for other drives.
pub(super) fn blocks<I: Quantity, O: Quantity>(
    report: &TransferReport<'_, I, O>,
) -> Option<Vec<Block>> {
    let (test, traces) = (report.function.impact.as_ref()?, report.traces?);
    let force = forces(report, traces).captioned(
        "Force of the hits that were used, time from the beginning of each pulse; the force window is drawn at the height of the \
         largest pulse.",
    );
    let response = responses(report, traces).captioned(
        "Response to the same hits over the segment, before any window; the exponential window, if there is one, is drawn at the \
         height of the largest value.",
    );
    let spectrum = spectrum(report, (test, traces)).captioned(
        "Mean spectrum of the force relative to its highest level. Shaded: the band that was excited, in which it lies above the line.",
    );
    Some(vec![
        Block::text(windows(test)),
        force.into(),
        response.into(),
        spectrum.into(),
        table(test, &report.drive_unit).into(),
    ])
}

/// The windows in words.
fn windows(test: &ImpactTest) -> String {
    let force = match test.force_window_s {
        Some(length_s) => format!(
            "The force is set to zero {:.2} ms after the beginning of the segment, behind its pulse.",
            length_s * 1e3
        ),
        None => "The force has no window.".into(),
    };
    let exponential = if test.added_damping_per_s > 0.0 {
        format!(
            "Force and response are multiplied by exp(−σt) with σ = {} 1/s: the function is H(jω + σ), every resonance has this \
                damping in addition to its own, and a half-power bandwidth read from it is {} Hz too wide.",
            digits(test.added_damping_per_s),
            digits(test.added_bandwidth_hz())
        )
    } else {
        "There is no exponential window: no damping was added (σ = 0).".into()
    };
    let left = test.left.map_or_else(String::new, |left| {
        format!(
            " At its end the response has {:.1} % of its largest level left, in the octave that has decayed least.",
            100.0 * left
        )
    });
    format!(
        "Each hit is one segment of {} s, which begins {:.2} ms before it.{left} {force} {exponential}",
        digits(test.segment_s),
        test.pretrigger_s * 1e3
    )
}

/// The times of hits that were used, for legends.
fn labels(report: &TransferReport<'_, impl Quantity, impl Quantity>) -> Vec<String> {
    let hits = report.function.impact.iter().flat_map(|test| &test.hits);
    let used = hits.filter(|hit| hit.is_used());
    used.map(|hit| format!("hit at {:.2} s", hit.at_s))
        .collect()
}

/// The values of all hits and a window at the height of the largest of them.
fn lines(
    report: &TransferReport<'_, impl Quantity, impl Quantity>,
    traces: &[Vec<(f64, f64)>],
    (window, name): (&[(f64, f64)], &str),
    scale: f64,
) -> (Vec<Line>, [f64; 2]) {
    let scaled = |points: &[(f64, f64)], by: f64| -> Vec<(f64, f64)> {
        points.iter().map(|(t, v)| (t * scale, v * by)).collect()
    };
    let values = traces.iter().flatten().map(|(_, v)| *v);
    let (low, high) = values.fold((0.0_f64, 0.0_f64), |(low, high), v| {
        (low.min(v), high.max(v))
    });
    let largest = if high >= -low { high } else { low };
    let colours = Tone::several(traces.len());
    let mut lines: Vec<Line> = traces
        .iter()
        .zip(labels(report))
        .zip(colours)
        .map(|((points, label), colour)| Line::new(label, colour, scaled(points, 1.0)).thin())
        .collect();
    if !window.is_empty() {
        lines.push(Line::new(name, Tone::Border, scaled(window, largest)));
    }
    let room = 0.1 * (high - low).max(f64::MIN_POSITIVE);
    (lines, [low - room, high + room])
}

/// The first and the last time of traces, scaled.
fn span(traces: &[Vec<(f64, f64)>], scale: f64) -> (f64, f64) {
    let times = traces.iter().flatten().map(|(t, _)| t * scale);
    times.fold((0.0, 0.0), |(low, high), t| (t.min(low), t.max(high)))
}

fn forces(
    report: &TransferReport<'_, impl Quantity, impl Quantity>,
    traces: &ImpactTraces,
) -> Chart {
    let window = (traces.force_window.as_slice(), "force window");
    let (lines, [low, high]) = lines(report, &traces.force, window, 1e3);
    let (from, to) = span(&traces.force, 1e3);
    Chart::new(
        Axis::new("time, ms", from, to),
        Axis::new(format!("force, {}", report.drive_unit), low, high),
        lines,
    )
    .beside()
}

fn responses(
    report: &TransferReport<'_, impl Quantity, impl Quantity>,
    traces: &ImpactTraces,
) -> Chart {
    let window = (traces.exponential.as_slice(), "exponential window");
    let (lines, [low, high]) = lines(report, &traces.response, window, 1.0);
    let (from, to) = span(&traces.response, 1.0);
    Chart::new(
        Axis::new("time, s", from, to),
        Axis::new(format!("response, {}", report.response_unit), low, high),
        lines,
    )
    .beside()
}

fn spectrum(
    report: &TransferReport<'_, impl Quantity, impl Quantity>,
    (test, traces): (&ImpactTest, &ImpactTraces),
) -> Chart {
    let ends = [traces.force_db.first(), traces.force_db.last()];
    let [low, high] = ends.map(|end| end.map_or(1.0, |(hz, _)| *hz));
    let excited = report.function.excited;
    Chart {
        shaded: (excited.iter())
            .map(|band| (band.low().0, band.high().0))
            .collect(),
        levels: vec![-test.excited_within_db],
        ..Chart::new(
            Axis::log("frequency, Hz", low, high.max(2.0 * low)),
            Axis::new("force level, dB", -60.0, 10.0),
            vec![Line::new("", Tone::Main, traces.force_db.clone())],
        )
    }
}

fn table(test: &ImpactTest, unit: &str) -> Table {
    let mut table = Table::new([
        Column::new("time, s", "time_s"),
        Column::new(&format!("peak force, {unit}"), "peak_force"),
        Column::new("duration, ms", "duration_ms"),
        Column::new("used", "used"),
    ]);
    table.rows = (test.hits.iter())
        .map(|hit| {
            let faults: Vec<String> = hit.faults.iter().map(ToString::to_string).collect();
            let used = match hit.is_used() {
                true => "yes".to_owned(),
                false => format!("no: {}", faults.join("; ")),
            };
            vec![
                Cell::rounded(hit.at_s, 4),
                Cell::from(hit.peak),
                Cell::rounded(hit.duration_s * 1e3, 3),
                Cell::Text(used),
            ]
        })
        .collect();
    table
}
