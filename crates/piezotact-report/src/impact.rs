//! The hits of an impact test: pulses, responses, windows, spectrum of the force, and a table of what was used.

use maud::{Markup, html};
use piezotact::figure::{Axis, Chart, Line, Tone};
use piezotact::number::digits;
use piezotact::quantity::Quantity;
use piezotact::transfer::{ImpactTest, ImpactTraces};

use crate::chart::HEIGHT;
use crate::transfer::Page;
use crate::{Draw, DrawError, figure};

/// The section about the hits; nothing for other drives.
pub(crate) fn section<I: Quantity, O: Quantity>(
    page: &Page<'_, I, O>,
) -> Result<Markup, DrawError> {
    let (Some(test), Some(traces)) = (&page.function.impact, page.traces) else {
        return Ok(html! {});
    };
    let [force, response, spectrum] = [
        forces(page, traces)?,
        responses(page, traces)?,
        spectrum(page, (test, traces))?,
    ];
    Ok(html! {
        section {
            h2 { "Hits" }
            p { (windows(test)) }
            (figure(&force, "Force of the hits that were used, time re the beginning of each pulse; the force window is drawn at the \
                height of the largest pulse."))
            (figure(&response, "Response to the same hits over the segment, before any window; the exponential window, if there is \
                one, is drawn at the height of the largest value."))
            (figure(&spectrum, "Mean spectrum of the force re its highest level. Shaded: the band that was excited, in which \
                it lies above the line."))
            (table(test, &page.drive_unit))
        }
    })
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
fn labels(page: &Page<'_, impl Quantity, impl Quantity>) -> Vec<String> {
    let hits = page.function.impact.iter().flat_map(|test| &test.hits);
    let used = hits.filter(|hit| hit.is_used());
    used.map(|hit| format!("hit at {:.2} s", hit.at_s))
        .collect()
}

/// The values of all hits and a window at the height of the largest of them.
fn lines(
    page: &Page<'_, impl Quantity, impl Quantity>,
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
        .zip(labels(page))
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
    page: &Page<'_, impl Quantity, impl Quantity>,
    traces: &ImpactTraces,
) -> Result<String, DrawError> {
    let window = (traces.force_window.as_slice(), "force window");
    let (lines, [low, high]) = lines(page, &traces.force, window, 1e3);
    let (from, to) = span(&traces.force, 1e3);
    Chart::new(
        Axis::new("time, ms", from, to),
        Axis::new(format!("force, {}", page.drive_unit), low, high),
        lines,
    )
    .beside()
    .svg(HEIGHT - 20)
}

fn responses(
    page: &Page<'_, impl Quantity, impl Quantity>,
    traces: &ImpactTraces,
) -> Result<String, DrawError> {
    let window = (traces.exponential.as_slice(), "exponential window");
    let (lines, [low, high]) = lines(page, &traces.response, window, 1.0);
    let (from, to) = span(&traces.response, 1.0);
    Chart::new(
        Axis::new("time, s", from, to),
        Axis::new(format!("response, {}", page.response_unit), low, high),
        lines,
    )
    .beside()
    .svg(HEIGHT - 20)
}

fn spectrum(
    page: &Page<'_, impl Quantity, impl Quantity>,
    (test, traces): (&ImpactTest, &ImpactTraces),
) -> Result<String, DrawError> {
    let ends = [traces.force_db.first(), traces.force_db.last()];
    let [low, high] = ends.map(|end| end.map_or(1.0, |(hz, _)| *hz));
    let excited = page.function.excited;
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
    .svg(HEIGHT - 60)
}

fn table(test: &ImpactTest, unit: &str) -> Markup {
    html! {
        table {
            tr {
                th { "time, s" }
                th { (format!("peak force, {unit}")) }
                th { "duration, ms" }
                th { "used" }
            }
            @for hit in &test.hits {
                tr {
                    td { (format!("{:.4}", hit.at_s)) }
                    td { (digits(hit.peak).replace('-', "−")) }
                    td { (format!("{:.3}", hit.duration_s * 1e3)) }
                    td {
                        @if hit.is_used() { "yes" } @else {
                            "no: " (hit.faults.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))
                        }
                    }
                }
            }
        }
    }
}
