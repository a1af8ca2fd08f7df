//! The report of a manipulated texture: waveforms, spectra and levels, before and after.

use super::{ManipulateDocument, Texture};
use crate::figure::{Axis, Chart, Figure, Line, Panels, Tone, range};
use crate::lineage::Operation;
use crate::number::{digits, plus};
use crate::page::{Block, Cell, Column, Fact, Number, Page, Shown, Table};
use crate::quantity::{Acceleration, Decibels, Quantity};
use crate::recording::BenchKind;
use crate::spectrum::Spectrum;

const BEFORE: Tone = Tone::Pale;
const AFTER: Tone = Tone::Main;
const OTHER: Tone = Tone::Second;

/// The stretch of waveform that is drawn, s.
const DRAWN_S: f64 = 0.5;
/// The frequencies that are drawn, Hz.
const LOWEST_HZ: f64 = 10.0;
const HIGHEST_HZ: f64 = 1000.0;

/// A texture before and after, with those that it took something of: what a report shows.
#[derive(Clone, Debug)]
pub struct BeforeAndAfter<'a> {
    /// The title of the report.
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

impl Shown for ManipulateDocument<'_> {
    fn page(&self) -> Page {
        let shown = &self.shown;
        Page::new(&shown.title, shown.origin_line())
            .section(
                "",
                [
                    Block::conclusion(shown.headline(), None),
                    Block::numbers(shown.numbers()),
                ],
            )
            .section("Processing steps", [shown.steps().into()])
            .section("Waveforms", [shown.waveforms().into()])
            .section("Spectra", [shown.spectra_figure().into()])
            .warnings(&shown.after.warnings)
            .section("Origin of the data", [Block::facts(shown.origin())])
    }
}

fn rms(texture: &Texture<Acceleration>) -> String {
    format!("{} m/s²", digits(texture.series.rms_about_mean().value))
}

fn label(what: &str, texture: &Texture<Acceleration>) -> String {
    format!("{what}, {} rms", rms(texture))
}

fn other_label(other: &Texture<Acceleration>) -> String {
    label(&other.lineage.source, other)
}

impl BeforeAndAfter<'_> {
    fn origin_line(&self) -> String {
        let unknown = "The recording does not say which bench it comes from.";
        let kind = self.bench.map_or(unknown, BenchKind::sentence);
        format!(
            "{kind} The signal “after” was computed from this recording: it was not measured with a finger on a surface."
        )
    }

    /// What was done by this command: what came before stands in the table.
    fn headline(&self) -> String {
        let known = self.before.lineage.steps.len();
        let new = self.after.lineage.steps.iter().skip(known);
        let new: Vec<String> = new.map(|step| step.operation.brief_text()).collect();
        format!("{}: {}", self.after.lineage.source, new.join(", then "))
    }

    fn numbers(&self) -> Vec<Number> {
        let (before, after) = (&self.before.series, &self.after.series);
        let peak = |x: f64| format!("{} m/s²", digits(x));
        let mut numbers = vec![
            Number::new(rms(self.before), "rms before"),
            Number::new(rms(self.after), "rms after"),
            Number::new(
                format!("{} dB", plus(self.after.level_re_db(self.before), 2)),
                "change of level",
            ),
            Number::new(
                peak(after.peak()),
                format!("peak after ({} before)", peak(before.peak())),
            ),
            Number::new(
                format!("{:.2}", after.duration()),
                format!("duration after ({:.2} before)", before.duration()),
            ),
        ];
        numbers.extend(
            self.others
                .iter()
                .map(|other| Number::new(rms(other), format!("rms of {}", other.lineage.source))),
        );
        numbers
    }

    /// Everything that was done to the texture: one row a step.
    fn steps(&self) -> Table {
        let unit = Acceleration::UNIT;
        let mut table = Table::new([
            Column::new("step", "step"),
            Column::new(&format!("rms before, {unit}"), "rms_before_m_s2"),
            Column::new(&format!("rms after, {unit}"), "rms_after_m_s2"),
        ]);
        let rows = self.after.lineage.steps.iter().map(|step| {
            // Before a cut is the whole recording, with what is no sliding.
            let is_cut = matches!(step.operation, Operation::Stroke { .. });
            vec![
                Cell::Text(step.operation.to_string()),
                Cell::from((!is_cut).then_some(step.rms_before.value)),
                Cell::from(step.rms_after.value),
            ]
        });
        table.rows = rows.collect();
        table
    }

    /// The texture before, with the others, and below it the texture after.
    fn waveforms(&self) -> Figure {
        let points = |texture: &Texture<Acceleration>| -> Vec<(f64, f64)> {
            let rate_hz = texture.series.rate().hz();
            let samples = texture.series.samples().iter().enumerate();
            samples
                .map(|(i, v)| (i as f64 / rate_hz, *v))
                .take_while(|(t, _)| *t < DRAWN_S)
                .collect()
        };
        let line = |label, tone, texture| Line::new(label, tone, points(texture)).thin();
        let mut before = vec![line(label("before", self.before), BEFORE, self.before)];
        let others = self.others.iter();
        before.extend(others.map(|other| line(other_label(other), OTHER, other)));
        let after = vec![line(label("after", self.after), AFTER, self.after)];
        let all = before.iter().chain(&after).flat_map(|line| &line.points);
        let reach = all.map(|(_, v)| v.abs()).fold(f64::MIN_POSITIVE, f64::max) * 1.08;
        let chart = |lines| {
            let seconds = Axis::new("time, s", 0.0, DRAWN_S);
            let level = Axis::new("acceleration, m/s²", -reach, reach);
            Chart::new(seconds, level, lines)
        };
        let and_others = match self.others {
            [] => "",
            _ => ", with the other textures that were used",
        };
        Panels::new(vec![chart(before), chart(after)]).captioned(format!(
            "Top: before{and_others}. Bottom: after. The first {DRAWN_S} s, on the same scale."
        ))
    }

    fn spectra_figure(&self) -> Figure {
        let line = |label: String, colour, psd: &Spectrum<Acceleration>| {
            let points = psd.frequencies_hz().into_iter().zip(&psd.values);
            let points = points.skip(1).filter(|(_, v)| **v > 0.0);
            let points = points.map(|(hz, v)| (hz, Decibels::from_power(*v).0));
            Line::new(label, colour, points.collect())
        };
        let others = self.others.iter();
        let labels = std::iter::once((label("before", self.before), BEFORE))
            .chain(others.map(|other| (other_label(other), OTHER)))
            .chain([(label("after", self.after), AFTER)]);
        let lines = labels.zip(self.spectra).enumerate();
        let lines: Vec<Line> = lines
            .map(
                |(i, ((label, tone), psd))| match (i, line(label, tone, psd)) {
                    (0, first) => first.thick(),
                    (i, other) if i <= self.others.len() => other.thin(),
                    (_, last) => last,
                },
            )
            .collect();
        let nyquist = self.after.series.rate().nyquist().0;
        let (from, to) = (LOWEST_HZ.min(nyquist / 10.0), HIGHEST_HZ.min(nyquist));
        let points: Vec<&[(f64, f64)]> = lines.iter().map(|line| line.points.as_slice()).collect();
        let (low, high) = range(&points, from, to, 10.0, 100.0);
        let density = Axis::new(
            format!("PSD, dB re 1 {}", Acceleration::UNIT.of_psd()),
            low,
            high,
        );
        Chart::new(Axis::log("frequency, Hz", from, to), density, lines).captioned(
            "Power spectral densities by Welch's method (Hann, lines about 5 Hz apart, 50 % overlap).",
        )
    }

    fn origin(&self) -> Vec<Fact> {
        let mut facts = vec![Fact::new("texture", &self.after.lineage.source)];
        let others = self.others.iter();
        facts.extend(others.map(|other| Fact::new("other texture", other.lineage.to_string())));
        facts
    }
}
