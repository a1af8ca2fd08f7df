//! The report of a manipulated texture: waveforms, spectra and levels, before and after.

use maud::{Markup, html};
use piezotact::document::Words;
use piezotact::manipulate::Texture;
use piezotact::quantity::{Acceleration, Decibels, Quantity};
use piezotact::recording::BenchKind;
use piezotact::spectrum::Spectrum;
use piezotact::warning::merged;

use crate::Draw;
use crate::chart::HEIGHT;
use crate::report::warnings_section;
use crate::{DrawError, bench_text, document, figure, origin};
use piezotact::figure::{Axis, Chart, Line, Tone, range};
use piezotact::number::{digits, plus};

const BEFORE: Tone = Tone::Pale;
const AFTER: Tone = Tone::Main;
const OTHER: Tone = Tone::Second;

/// The stretch of waveform that is drawn, and the highest frequency, s and Hz.
const DRAWN_S: f64 = 0.5;
const HIGHEST_HZ: f64 = 1000.0;
const LOWEST_HZ: f64 = 10.0;

/// What a report of a texture shows.
#[derive(Clone, Debug)]
pub struct Page<'a> {
    pub title: String,
    /// Which bench it comes from; absent where that is not known.
    pub bench: Option<BenchKind>,
    pub before: &'a Texture<Acceleration>,
    pub after: &'a Texture<Acceleration>,
    /// Those that it took something of.
    pub others: &'a [Texture<Acceleration>],
    /// The PSDs of the texture before, of the others, and of the texture after.
    pub spectra: &'a [Spectrum<Acceleration>],
}

/// The report as HTML, with warnings in `words`.
///
/// # Errors
/// [`DrawError`] where a figure cannot be drawn.
pub fn html(page: &Page<'_>, words: &dyn Words) -> Result<String, DrawError> {
    let waves = waveforms(page)?;
    let body = html! {
        h1 { (page.title) }
        p.soft { (bench_line(page)) }
        (numbers(page))
        (steps(page))
        (warnings_section(&merged(&page.after.warnings), words))
        section {
            h2 { "Waveforms" }
            (figure(&waves[0], &format!("Before{}: the first {DRAWN_S} s.", and_others(page))))
            (figure(&waves[1], &format!("After: the first {DRAWN_S} s, on the same scale.")))
        }
        section {
            h2 { "Spectra" }
            (figure(&spectra(page)?, "Power spectral densities by Welch's method (Hann, lines about 5 Hz apart, 50 % overlap)."))
        }
        (origin_of(page))
    };
    Ok(document(&page.title, &body))
}

fn bench_line(page: &Page<'_>) -> String {
    let kind =
        bench_text(page.bench).unwrap_or("The recording does not say which bench it comes from.");
    format!(
        "{kind} The signal “after” was computed from this recording: it was not measured with a finger on a surface."
    )
}

fn and_others(page: &Page<'_>) -> &'static str {
    if page.others.is_empty() {
        ""
    } else {
        ", and the other textures that were used"
    }
}

fn label(what: &str, texture: &Texture<Acceleration>) -> String {
    format!(
        "{what}, {} m/s² rms",
        digits(texture.series.rms_about_mean().value)
    )
}

fn other_label(other: &Texture<Acceleration>) -> String {
    label(&other.lineage.source, other)
}

fn numbers(page: &Page<'_>) -> Markup {
    let (before, after) = (&page.before.series, &page.after.series);
    let number = |value: String, what: &str| html! { div { b { (value) } span { (what) } } };
    let level = |x: f64| format!("{} m/s²", digits(x));
    let change = page.after.level_re_db(page.before);
    html! {
        section.verdict {
            strong { (headline(page)) }
            div.numbers {
                (number(level(before.rms_about_mean().value), "rms before"))
                (number(level(after.rms_about_mean().value), "rms after"))
                (number(format!("{} dB", plus(change, 2)), "change of level"))
                (number(level(after.peak()), &format!("peak after ({} before)", level(before.peak()))))
                (number(format!("{:.2}", after.duration()), &format!("duration after ({:.2} before)", before.duration())))
                @for other in page.others {
                    (number(level(other.series.rms_about_mean().value), &format!("rms of {}", other.lineage.source)))
                }
            }
        }
    }
}

/// What was done by this command: what came before stands in the table.
fn headline(page: &Page<'_>) -> String {
    let known = page.before.lineage.steps.len();
    let new = page.after.lineage.steps.iter().skip(known);
    let new: Vec<String> = new.map(|step| step.operation.brief_text()).collect();
    format!("{}: {}", page.after.lineage.source, new.join(", then "))
}

fn steps(page: &Page<'_>) -> Markup {
    html! {
        section {
            h2 { "Processing steps" }
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

fn waveforms(page: &Page<'_>) -> Result<[String; 2], DrawError> {
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
    let reach = all.map(|(_, v)| v.abs()).fold(f64::MIN_POSITIVE, f64::max) * 1.08;
    let drawn = |lines| {
        let seconds = Axis::new("time, s", 0.0, DRAWN_S);
        let level = Axis::new("acceleration, m/s²", -reach, reach);
        Chart::new(seconds, level, lines).svg(HEIGHT - 40)
    };
    Ok([drawn(before)?, drawn(after)?])
}

fn spectra(page: &Page<'_>) -> Result<String, DrawError> {
    let line = |label: String, colour, psd: &Spectrum<Acceleration>| {
        let points = psd.frequencies_hz().into_iter().zip(&psd.values);
        let points = points.skip(1).filter(|(_, v)| **v > 0.0);
        let points = points.map(|(hz, v)| (hz, Decibels::from_power(*v).0));
        Line::new(label, colour, points.collect())
    };
    let labels = std::iter::once((label("before", page.before), BEFORE))
        .chain(page.others.iter().map(|other| (other_label(other), OTHER)))
        .chain([(label("after", page.after), AFTER)]);
    let lines = labels.zip(page.spectra).enumerate();
    let lines: Vec<Line> = lines
        .map(
            |(i, ((label, tone), psd))| match (i, line(label, tone, psd)) {
                (0, first) => first.thick(),
                (i, other) if i <= page.others.len() => other.thin(),
                (_, last) => last,
            },
        )
        .collect();
    let nyquist = page.after.series.rate().nyquist().0;
    let (from, to) = (LOWEST_HZ.min(nyquist / 10.0), HIGHEST_HZ.min(nyquist));
    let points: Vec<&[(f64, f64)]> = lines.iter().map(|line| line.points.as_slice()).collect();
    let (low, high) = range(&points, from, to, 10.0, 100.0);
    let density = Axis::new(
        format!("PSD, dB re 1 {}", Acceleration::UNIT.of_psd()),
        low,
        high,
    );
    Chart::new(Axis::log("frequency, Hz", from, to), density, lines).svg(HEIGHT + 80)
}

fn origin_of(page: &Page<'_>) -> Markup {
    let rows = html! {
        (origin::row("texture", &page.after.lineage.source))
        @for other in page.others { (origin::row("other texture", &other.lineage.to_string())) }
    };
    origin::section("Origin of the data", &rows)
}
