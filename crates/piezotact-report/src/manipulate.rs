//! The report of a texture that was made otherwise: waveforms, spectra and levels, before and after.

use maud::{Markup, html};
use piezotact::Doubt;
use piezotact::doubt::merged;
use piezotact::manipulate::Texture;
use piezotact::quantity::{Acceleration, Decibels, Quantity};
use piezotact::recording::BenchKind;
use piezotact::series::Series;
use piezotact::spectrum::{Spectrum, welch};
use piezotact::statistics::standard_deviation;

use super::{document, figure};
use crate::advice::merged_text;
use crate::commands::manipulate::lines_5_hz_apart;
use crate::failure::Outcome;
use crate::output::digits;
use piezotact::figure::{Axis, Chart, Corner, Line, Tone, range};
use piezotact_report::Draw;
use piezotact_report::chart::HEIGHT;

const BEFORE: Tone = Tone::Pale;
const AFTER: Tone = Tone::Main;
const OTHER: Tone = Tone::Second;

/// The stretch of waveform that is drawn, and the highest frequency, s and Hz.
const DRAWN_S: f64 = 0.5;
const HIGHEST_HZ: f64 = 1000.0;
const LOWEST_HZ: f64 = 10.0;

/// What a report of a texture shows.
pub(crate) struct Page<'a> {
    pub(crate) title: String,
    pub(crate) bench: Option<BenchKind>,
    pub(crate) before: &'a Texture<Acceleration>,
    pub(crate) after: &'a Texture<Acceleration>,
    /// Those that it took something of.
    pub(crate) others: &'a [Texture<Acceleration>],
}

/// The report as HTML text.
pub(crate) fn render(page: &Page<'_>) -> Outcome<String> {
    let waves = waveforms(page)?;
    let body = html! {
        h1 { (page.title) }
        p.soft { (bench_line(page)) }
        (numbers(page))
        (steps(page))
        (doubts(&page.after.doubts))
        section {
            h2 { "Waveforms" }
            (figure(&waves[0], &format!("Before{}: the first {DRAWN_S} s.", and_others(page))))
            (figure(&waves[1], &format!("After: the first {DRAWN_S} s, on the same scale.")))
        }
        section {
            h2 { "Spectra" }
            (figure(&spectra(page)?, "Power spectral densities by Welch's method (Hann, lines about 5 Hz apart, 50 % overlap)."))
        }
        (origin(page))
    };
    Ok(document(&page.title, &body))
}

fn bench_line(page: &Page<'_>) -> String {
    let kind = super::bench_told(page.bench)
        .unwrap_or("The recording does not say which bench it comes from.");
    format!("{kind} What is shown as after was made from it: no finger felt it on a surface.")
}

fn and_others(page: &Page<'_>) -> &'static str {
    if page.others.is_empty() {
        ""
    } else {
        ", with what it took something of"
    }
}

/// The rms about the mean, as in the lineage.
fn level_of(x: &Series<Acceleration>) -> f64 {
    standard_deviation(x.samples())
}

fn label(what: &str, texture: &Texture<Acceleration>) -> String {
    format!("{what}, {} m/s² rms", digits(level_of(&texture.series)))
}

fn other_label(other: &Texture<Acceleration>) -> String {
    label(&other.lineage.source, other)
}

fn numbers(page: &Page<'_>) -> Markup {
    let (before, after) = (&page.before.series, &page.after.series);
    let number = |value: String, what: &str| html! { div { b { (value) } span { (what) } } };
    let level = |x: f64| format!("{} m/s²", digits(x));
    let change = Decibels::from_amplitude_ratio(level_of(after) / level_of(before)).0;
    html! {
        section.verdict {
            strong { (headline(page)) }
            div.numbers {
                (number(level(level_of(before)), "rms before"))
                (number(level(level_of(after)), "rms after"))
                (number(format!("{change:+.2} dB").replace('-', "−"), "change of level"))
                (number(level(after.peak()), &format!("peak after; {} before", level(before.peak()))))
                (number(format!("{:.2}", after.duration()), &format!("long; {:.2} before", before.duration())))
                @for other in page.others {
                    (number(level(level_of(&other.series)), &format!("rms of {}", other.lineage.source)))
                }
            }
        }
    }
}

/// What was done by this command: what came before stands in the table.
fn headline(page: &Page<'_>) -> String {
    let known = page.before.lineage.steps.len();
    let new = page.after.lineage.steps.iter().skip(known);
    let new: Vec<String> = new.map(|step| step.operation.told_briefly()).collect();
    format!("{}: {}", page.after.lineage.source, new.join(", then "))
}

fn steps(page: &Page<'_>) -> Markup {
    html! {
        section {
            h2 { "What was done" }
            table {
                tr { th { "step" } th.n { "rms before" } th.n { "rms after" } }
                @for step in &page.after.lineage.steps {
                    tr {
                        td { (step.operation) }
                        td.n { (digits(step.rms_before.value)) " " (step.rms_before.unit) }
                        td.n { (digits(step.rms_after.value)) " " (step.rms_after.unit) }
                    }
                }
            }
        }
    }
}

fn doubts(doubts: &[Doubt]) -> Markup {
    html! {
        section {
            h2 { "Doubts" }
            @if doubts.is_empty() {
                p.soft { "None: nothing had to be clamped, guessed or left out." }
            } @else {
                ul.doubts { @for doubt in merged(doubts) { li { (merged_text(&doubt)) } } }
            }
        }
    }
}

fn waveforms(page: &Page<'_>) -> Outcome<[String; 2]> {
    let points = |texture: &Texture<Acceleration>| -> Vec<(f64, f64)> {
        let rate_hz = texture.series.rate().hz();
        let samples = texture.series.samples().iter().enumerate();
        samples
            .map(|(i, v)| (i as f64 / rate_hz, *v))
            .take_while(|(t, _)| *t < DRAWN_S)
            .collect()
    };
    let mut before =
        vec![Line::new(label("before", page.before), BEFORE, points(page.before)).thin()];
    before.extend(
        page.others
            .iter()
            .map(|other| Line::new(other_label(other), OTHER, points(other)).thin()),
    );
    let after = vec![Line::new(label("after", page.after), AFTER, points(page.after)).thin()];
    let all = before.iter().chain(&after).flat_map(|line| &line.points);
    // Room for the legend above the lines.
    let reach = all.map(|(_, v)| v.abs()).fold(f64::MIN_POSITIVE, f64::max) * 1.5;
    let drawn = |lines| {
        let seconds = Axis::new("time, s", 0.0, DRAWN_S);
        let level = Axis::new("acceleration, m/s²", -reach, reach);
        Chart::new(seconds, level, lines).svg(HEIGHT - 40)
    };
    Ok([drawn(before)?, drawn(after)?])
}

fn spectra(page: &Page<'_>) -> Outcome<String> {
    let line = |label: String, colour, texture: &Texture<Acceleration>| -> Outcome<Line> {
        let psd: Spectrum<Acceleration> = welch(&texture.series, &lines_5_hz_apart(texture)?)?;
        let points = psd.frequencies_hz().into_iter().zip(&psd.values);
        let points = points.skip(1).filter(|(_, v)| **v > 0.0);
        let points = points.map(|(hz, v)| (hz, Decibels::from_power(*v).0));
        Ok(Line::new(label, colour, points.collect()))
    };
    let mut lines = vec![line(label("before", page.before), BEFORE, page.before)?.thick()];
    for other in page.others {
        lines.push(line(other_label(other), OTHER, other)?.thin());
    }
    lines.push(line(label("after", page.after), AFTER, page.after)?);
    let nyquist = page.after.series.rate().nyquist().0;
    let (from, to) = (LOWEST_HZ.min(nyquist / 10.0), HIGHEST_HZ.min(nyquist));
    let points: Vec<&[(f64, f64)]> = lines.iter().map(|line| line.points.as_slice()).collect();
    let (low, high) = range(&points, from, to, 10.0, 100.0);
    let density = Axis::new(
        format!("PSD, dB re 1 {}", Acceleration::UNIT.of_psd()),
        low,
        high + 15.0,
    );
    let mut chart = Chart::new(Axis::log("frequency, Hz", from, to), density, lines);
    chart.legend = Corner::UpperRight;
    Ok(chart.svg(HEIGHT + 80)?)
}

fn origin(page: &Page<'_>) -> Markup {
    html! {
        section {
            h2 { "Where it comes from" }
            table {
                tr { th { "texture" } td { (page.after.lineage.source) } }
                @for other in page.others { tr { th { "another" } td { (other.lineage) } } }
                tr { th { "program" } td { (concat!("piezotact ", env!("CARGO_PKG_VERSION"))) } }
            }
        }
    }
}
