//! The report of renderings that were corrected in a closed loop.

use std::collections::BTreeSet;

use maud::{Markup, html};
use piezotact::correct::{CorrectedRendering as Row, RenderingSums};
use piezotact::document::Words;
use piezotact::lineage::Mode;
use piezotact::number::{difference_db, plus, signed};
use piezotact::quantity::Band;
use piezotact::verify::{CLOSE_DB, open_and_closed};
use piezotact::warning::merged;

use crate::chart::HEIGHT;
use crate::{Draw, DrawError, UNKNOWN_BENCH, bench_text, broad_document, figure, origin};

/// What a report of renderings shows, as it grows: of each what it says, not what was recorded.
#[derive(Debug)]
pub struct Page {
    band: Band,
    /// How many are asked for.
    asked: usize,
    aim: Option<Mode>,
    called: Vec<String>,
    benches: BTreeSet<&'static str>,
    sums: RenderingSums,
    lines: Vec<Markup>,
    sections: Vec<Markup>,
    origins: Vec<Markup>,
    /// Those that could not be rendered, and why.
    refused: Vec<(String, String)>,
    /// Which drive is kept and why, of each.
    kept: Vec<String>,
    /// How many have no confirmation measurement.
    unconfirmed: usize,
}

impl Page {
    /// A report of renderings over `band`, of which `asked` are asked for.
    #[must_use]
    pub fn of(band: Band, asked: usize) -> Self {
        Self {
            band,
            asked,
            aim: None,
            called: Vec::new(),
            benches: BTreeSet::new(),
            sums: RenderingSums::default(),
            lines: Vec::new(),
            sections: Vec::new(),
            origins: Vec::new(),
            refused: Vec::new(),
            kept: Vec::new(),
            unconfirmed: 0,
        }
    }

    /// Adds a rendering, with warnings in `words`.
    ///
    /// # Errors
    /// [`DrawError`] where a figure cannot be drawn.
    pub fn add(&mut self, row: &Row<'_>, words: &dyn Words) -> Result<(), DrawError> {
        self.aim = row.drive.aim;
        self.called.push(row.called.into());
        self.benches
            .insert(bench_text(row.bench).unwrap_or(UNKNOWN_BENCH));
        self.sums.add(row);
        self.kept.push(row.kept.clone());
        self.unconfirmed += usize::from(!row.is_confirmed);
        self.lines.push(line(row));
        self.sections.push(one(row, words)?);
        let steps = &row.drive.about.provenance.steps;
        self.origins
            .push(origin::row(row.called, &origin::steps(steps)));
        Ok(())
    }

    /// Adds one that could not be rendered.
    pub fn refuse(&mut self, called: &str, why: String) {
        self.refused.push((called.into(), why));
    }

    /// The report as HTML.
    #[must_use]
    pub fn html(&self) -> String {
        let title = match self.called.as_slice() {
            [only] if self.asked == 1 => format!("Rendering of {only} in a closed loop"),
            _ => format!(
                "Rendering in a closed loop: {} textures and fingers",
                self.asked
            ),
        };
        let benches: Vec<&str> = self.benches.iter().copied().collect();
        let body = html! {
            h1 { (title) }
            p.soft { (benches.join(" ")) }
            (summary(self))
            (table(self))
            (refused(self))
            @for section in &self.sections { (section) }
            (method(self))
        };
        broad_document(&title, &body)
    }
}

fn summary(page: &Page) -> Markup {
    let (sums, close) = (&page.sums, page.sums.close);
    let number = |value: String, what: &str| html! { div { b { (value) } span { (what) } } };
    let within = format!(
        "within {} dB rms and {} dB on every line",
        CLOSE_DB.0, CLOSE_DB.1
    );
    let unconfirmed = page.unconfirmed;
    let told = match (page.asked, close) {
        (1, 0) if unconfirmed > 0 => format!(
            "It is not decided whether the result is {within} of its target: the confirmation measurement failed"
        ),
        (1, 1) => format!(
            "The result is {within} of its target, over the part of the band that is reached"
        ),
        (1, _) => format!(
            "The result is not {within} of its target, over the part of the band that is reached"
        ),
        (all, _) => format!(
            "{close} of {all} results are {within} of their target, over the part of the band that is reached"
        ),
    };
    let kept = sums.open_kept;
    html! {
        section class=(if close == page.asked { "verdict" } else { "verdict failed" }) {
            strong { (told) "." }
            @if unconfirmed > 0 && page.asked > 1 {
                p { (format!("Of {unconfirmed} the confirmation measurement failed: it is not decided whether they are close.")) }
            }
            @if kept > 0 {
                p { @if let ([kept], 1) = (page.kept.as_slice(), page.asked) { (sentence(kept)) } @else { (format!("In {kept} of {} the open-loop drive is kept.", page.asked)) } }
            }
            div.numbers {
                @match sums.count {
                    0 => {}
                    1 => {
                        (number(format!("{:.2} dB", sums.open_db_mean), "rms error, open loop"))
                        (number(format!("{:.2} dB", sums.closed_db_mean), match (kept > 0, unconfirmed > 0) { (true, false) => "rms error, open loop, confirmation measurement", (true, true) => "rms error, open loop, measurement in the loop", (false, false) => "rms error, closed loop, confirmation measurement", (false, true) => "rms error, closed loop, measurement in the loop" }))
                        (number(format!("{:.1} dB", sums.line_db_largest), "largest error of a spectral line"))
                    }
                    _ => {
                        (number(format!("{:.2} dB", sums.open_db_mean), "rms error, open loop, mean"))
                        (number(format!("{:.2} dB", sums.closed_db_mean), "rms error of the kept drive, mean"))
                        (number(format!("{:.2} dB", sums.closed_db_largest), "rms error of the kept drive, largest"))
                        (number(format!("{:.1} dB", sums.line_db_largest), "largest error of a spectral line"))
                    }
                }
            }
            @if page.lines.len() + page.refused.len() < page.asked {
                p { (format!("This report was written before the run was complete: {} of {} done.", page.lines.len() + page.refused.len(), page.asked)) }
            }
        }
    }
}

/// A clause as a sentence.
fn sentence(clause: &str) -> String {
    let mut letters = clause.chars();
    let first = letters
        .next()
        .map(|letter| letter.to_uppercase().to_string());
    format!("{}{}.", first.unwrap_or_default(), letters.as_str())
}

fn table(page: &Page) -> Markup {
    html! {
        section {
            h2 { "Error of each rendering" }
            div.wide {
                table.tight.matrix {
                    tr {
                        th { "texture and finger" }
                        th.n { "level, dB" }
                        th.n { "error, dB rms" }
                        th.n { "largest error of a line, dB" }
                        th.n { "level error, dB" }
                        th.n { "correlation" }
                        th.n { "band reached" }
                        th.n { "samples at a limit" }
                        th.n { "improvement, dB (95 %)" }
                        th.n { "corrections" }
                        th { "drive kept" }
                        th { "stopped" }
                    }
                    @for line in &page.lines { (line) }
                }
            }
            p.soft { "Before the arrow: the open-loop drive. After the arrow: the drive that is kept, from a confirmation \
                measurement that was used neither to correct nor to select it, where the last column does not say that there is none. Improvement: how much smaller the error of the \
                best corrected drive is than that of the open loop, in the quantity that the loop minimises (spectrum, or NMSE \
                of the waveform), with its 95 % interval from the scatter of the measurements; if this interval is not entirely \
                above zero, the open-loop drive is kept. Error and largest error of a line: over the part of the band that the \
                drive reaches; green if within the limits and not worse than with the open loop; bands that were attenuated so \
                that the drive fits are left out. Level: relative to the texture. Correlation: of the waveforms. Samples at a \
                limit: the share of samples at which the device or the sensor clips. Corrections: the number up to the best \
                drive. Stopped: after the requested number of corrections, when there was no improvement in two iterations, \
                when the error became clearly larger, or when a measurement was invalid." }
        }
    }
}

fn line(row: &Row<'_>) -> Markup {
    let (open, closed) = (row.open, row.closed);
    html! {
        tr {
            td { (row.called) }
            td.n { (plus(row.level_db, 1)) }
            td class=(if row.is_close { "n near" } else { "n" }) { (then(open.judged_error_db(), closed.judged_error_db(), 2)) }
            td.n { (then(open.error_db_max_achievable(), closed.error_db_max_achievable(), 1)) }
            td.n { (difference_db(closed.level_error_db)) }
            td.n { (then(open.waveform_correlation, closed.waveform_correlation, 3)) }
            td.n { (format!("{:.0} %", row.reached_share() * 100.0)) }
            td.n { (format!("{:.2} %", row.share_at_limit() * 100.0)) }
            td.n { (gain(row)) }
            td.n { (row.best) }
            td { (kept(row)) }
            td { (row.ended) @if !row.is_confirmed { ", no confirmation measurement" } }
        }
    }
}

/// How much closer the best corrected drive came, with what the spread of measurements leaves.
fn gain(row: &Row<'_>) -> String {
    let Some((found, [low, high])) = row.gain_db else {
        return "–".into();
    };
    let [found, low, high] = [found, low, high].map(|db| signed(db, 2));
    format!("{found} ({low} to {high})")
}

/// Which drive is kept, in two words.
fn kept(row: &Row<'_>) -> &'static str {
    match row {
        row if row.is_open_kept => "open loop",
        row if row.got_worse => "corrected, spectrum worse",
        _ => "corrected",
    }
}

/// A sentence with its first letter as one begins.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

/// A number of the open loop and what became of it.
fn then(open: f64, closed: f64, decimals: usize) -> String {
    let [open, closed] = [open, closed].map(|value| signed(value, decimals));
    format!("{open} → {closed}")
}

fn refused(page: &Page) -> Markup {
    html! {
        @if !page.refused.is_empty() {
            section {
                h2 { "Not rendered" }
                table {
                    @for (called, why) in &page.refused { tr { th { (called) } td { (why) } } }
                }
            }
        }
    }
}

fn one(row: &Row<'_>, words: &dyn Words) -> Result<Markup, DrawError> {
    let bands: Vec<String> = row
        .drive
        .coverage
        .given_up
        .iter()
        .map(ToString::to_string)
        .collect();
    Ok(html! {
        section {
            h2 { (row.called) }
            p {
                (format!("{}. ", row.drive.headroom.text()))
                (format!("{}. ", capital(&row.kept)))
                @if bands.is_empty() { "No part of the band is given up." } @else { (format!("Given up: {}.", bands.join(", "))) }
            }
            (figure(&open_and_closed(row.open, row.closed).svg(HEIGHT + 40)?, "Power spectral densities of the target and of the \
                measured responses in open and closed loop, and below the remaining error in the closed loop at each spectral line. \
                Shaded: the bands that the inverse reaches. Red: the limit for the rms of the error."))
            @if !row.drive.about.warnings.is_empty() {
                ul.warnings { @for warning in merged(&row.drive.about.warnings) { li { (words.merged(&warning)) } } }
            }
        }
    })
}

fn method(page: &Page) -> Markup {
    html! {
        section {
            h2 { "Methods" }
            @if let Some(aim) = page.aim {
                p { (format!(
                    "Aim: {}. Evaluated over {}. Every drive was played twice without moving the finger: the second measurement \
                        was used to evaluate it, and both together to correct it. The loop stops after the requested number of corrections, or when there was no \
                        improvement in two iterations. The best drive was then measured once more (confirmation measurement). \
                        It is kept if its error is smaller than that of the open loop beyond the scatter of the measurements; \
                        otherwise the open-loop drive is kept.",
                    aim.text(), page.band
                )) }
            }
            table {
                @for origin in &page.origins { (origin) }
            }
            p.soft { (concat!("piezotact ", env!("CARGO_PKG_VERSION"))) }
        }
    }
}
