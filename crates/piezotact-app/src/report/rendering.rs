//! The report of renderings that were corrected in a closed loop.

use std::collections::BTreeSet;

use maud::{Markup, html};
use piezotact::doubt::merged;
use piezotact::lineage::Mode;
use piezotact::quantity::Band;
use piezotact::render::RenderedDrive;
use piezotact::statistics::mean;
use piezotact_bench::procedure::{LoopEnd, Looped};

use super::{UNKNOWN_BENCH, bench_told, broad_document, figure, figures};
use crate::advice::merged_text;
use crate::failure::Outcome;
use crate::output::{difference_db, headroom_text};
use piezotact::number::signed;
use piezotact::verify::CLOSE_DB;

/// One texture on one finger.
struct Row<'a> {
    called: &'a str,
    level_db: f64,
    drive: &'a RenderedDrive,
    looped: &'a Looped,
}

/// What a report of renderings shows, as it grows: of each what it says, not what was recorded.
pub(crate) struct Page {
    band: Band,
    /// How many are asked for.
    asked: usize,
    aim: Option<Mode>,
    called: Vec<String>,
    benches: BTreeSet<&'static str>,
    figures: Vec<Figures>,
    lines: Vec<Markup>,
    sections: Vec<Markup>,
    origins: Vec<Markup>,
    /// Those that could not be rendered, and why.
    refused: Vec<(String, String)>,
}

/// The numbers of one rendering that are summed up.
struct Figures {
    open_db: f64,
    closed_db: f64,
    most_db: f64,
    close: bool,
    /// Whether the open loop was kept.
    open_kept: bool,
}

impl Page {
    /// A report of renderings over `band`, of which `asked` are asked for.
    pub(crate) fn of(band: Band, asked: usize) -> Self {
        Self {
            band,
            asked,
            aim: None,
            called: Vec::new(),
            benches: BTreeSet::new(),
            figures: Vec::new(),
            lines: Vec::new(),
            sections: Vec::new(),
            origins: Vec::new(),
            refused: Vec::new(),
        }
    }

    /// Adds a rendering.
    pub(crate) fn add(
        &mut self,
        called: &str,
        level_db: f64,
        drive: &RenderedDrive,
        looped: &Looped,
    ) -> Outcome {
        let row = Row {
            called,
            level_db,
            drive,
            looped,
        };
        self.aim = drive.aim;
        self.called.push(called.into());
        let bench = looped.recording.about.provenance.bench;
        self.benches
            .insert(bench_told(bench).unwrap_or(UNKNOWN_BENCH));
        self.figures.push(Figures {
            open_db: looped.iterations[0].verification.judged_error_db(),
            closed_db: looped.told().judged_error_db(),
            most_db: looped.told().error_db_max_achievable(),
            close: looped.is_close(),
            open_kept: looped.kept.is_open(),
        });
        self.lines.push(line(&row));
        self.sections.push(one(&row)?);
        self.origins.push(html! {
            tr { th { (called) } td { ol { @for step in &drive.about.provenance.steps { li { (step) } } } } }
        });
        Ok(())
    }

    /// Adds one that could not be rendered.
    pub(crate) fn refuse(&mut self, called: &str, why: String) {
        self.refused.push((called.into(), why));
    }

    /// The report as HTML text.
    pub(crate) fn html(&self) -> String {
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
    let close = page.figures.iter().filter(|figures| figures.close).count();
    let of = |of: fn(&Figures) -> f64| -> Vec<f64> { page.figures.iter().map(of).collect() };
    let (open, closed, most) = (of(|f| f.open_db), of(|f| f.closed_db), of(|f| f.most_db));
    let largest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
    let number = |value: String, what: &str| html! { div { b { (value) } span { (what) } } };
    let within = format!(
        "within {} dB rms and {} dB on every line",
        CLOSE_DB.0, CLOSE_DB.1
    );
    let told = match (page.asked, close) {
        (1, 1) => format!("It came {within} of its target, over what is reached"),
        (1, _) => format!("It did not come {within} of its target, over what is reached"),
        (all, _) => format!("{close} of {all} came {within} of their target, over what is reached"),
    };
    let kept = page
        .figures
        .iter()
        .filter(|figures| figures.open_kept)
        .count();
    html! {
        section class=(if close == page.asked { "verdict" } else { "verdict failed" }) {
            strong { (told) "." }
            @if kept > 0 {
                p { @if page.asked == 1 { "The open loop is kept: correcting came no closer beyond the spread of the measurements." } @else { (format!("In {kept} of {} the open loop is kept: correcting came no closer beyond the spread of the measurements.", page.asked)) } }
            }
            div.numbers {
                @match page.figures.as_slice() {
                    [] => {}
                    [only] => {
                        (number(format!("{:.2} dB", only.open_db), "rms error open"))
                        (number(format!("{:.2} dB", only.closed_db), if only.open_kept { "rms error of the open loop, measured once more" } else { "rms error closed" }))
                        (number(format!("{:.1} dB", only.most_db), "error of one line, largest"))
                    }
                    _ => {
                        (number(format!("{:.2} dB", mean(&open)), "rms error open, mean"))
                        (number(format!("{:.2} dB", mean(&closed)), "rms error kept, mean"))
                        (number(format!("{:.2} dB", largest(&closed)), "rms error kept, largest"))
                        (number(format!("{:.1} dB", largest(&most)), "error of one line, largest"))
                    }
                }
            }
            @if page.lines.len() + page.refused.len() < page.asked {
                p { (format!("Not all was done yet when this was written: {} of {}.", page.lines.len() + page.refused.len(), page.asked)) }
            }
        }
    }
}

fn table(page: &Page) -> Markup {
    html! {
        section {
            h2 { "How close each came" }
            div.wide {
                table.tight.matrix {
                    tr {
                        th { "texture and finger" }
                        th.n { "level, dB" }
                        th.n { "dB rms" }
                        th.n { "largest line, dB" }
                        th.n { "level error, dB" }
                        th.n { "correlation" }
                        th.n { "reached" }
                        th.n { "at the limit" }
                        th.n { "gain, dB (95 %)" }
                        th.n { "steps" }
                        th { "kept" }
                        th { "ended" }
                    }
                    @for line in &page.lines { (line) }
                }
            }
            p.soft { "Before the arrow the open loop's drive; after it the drive that is kept, measured once more by a measurement that neither corrected nor chose it. Gain: how much closer the best corrected drive came than the open loop in what the loop makes small (spectrum, or NMSE of the waveform), with what the spread of the measurements leaves; without a gain above zero throughout, the open loop is kept. dB rms and largest line: over the part of the band that its drive reaches, in green where within the limits and not worse than open; what was turned down for a drive to fit is not in it. Level: re the texture. Correlation: of the waveforms. At the limit: the share of samples where device or sensor clips. Steps: corrections up to the best. Ended: as often as asked, when there was no improvement in two iterations, when it got clearly worse, or when a measurement could not be believed." }
        }
    }
}

fn line(row: &Row<'_>) -> Markup {
    let open = &row.looped.iterations[0].verification;
    let closed = row.looped.told();
    let width = |bands: &[Band]| bands.iter().map(|b| b.high().0 - b.low().0).sum::<f64>();
    let band = row.drive.config.inverse.band;
    let reached = width(&row.drive.coverage.reached) / width(&[band]);
    html! {
        tr {
            td { (row.called) }
            td.n { (format!("{:+.1}", row.level_db).replace('-', "−").replace("+0.0", "0")) }
            td class=(if row.looped.is_close() { "n near" } else { "n" }) { (then(open.judged_error_db(), closed.judged_error_db(), 2)) }
            td.n { (then(open.error_db_max_achievable(), closed.error_db_max_achievable(), 1)) }
            td.n { (difference_db(closed.level_error_db)) }
            td.n { (then(open.waveform_correlation, closed.waveform_correlation, 3)) }
            td.n { (format!("{:.0} %", reached * 100.0)) }
            td.n { (format!("{:.2} %", closed.clipped_fraction.max(row.looped.iterations[row.looped.best].held) * 100.0)) }
            td.n { (gain(row)) }
            td.n { (row.looped.best) }
            td { (kept(row)) }
            td { (ended(&row.looped.end)) @if row.looped.confirmed.is_none() { ", not measured once more" } }
        }
    }
}

/// How much closer the best corrected drive came, with what the spread of measurements leaves.
fn gain(row: &Row<'_>) -> String {
    let Some(gain) = &row.looped.gain else {
        return "–".into();
    };
    let [aim, _] = &gain.criteria;
    match (aim.found, aim.interval) {
        (Some(found), Some([low, high])) => {
            let [found, low, high] = [found, low, high].map(|db| signed(db, 2));
            format!("{found} ({low} to {high})")
        }
        _ => "–".into(),
    }
}

/// Which drive is kept, in two words.
fn kept(row: &Row<'_>) -> &'static str {
    match row.looped.kept {
        kept if kept.is_open() => "open loop",
        _ if row.looped.got_worse() => "corrected, spectrum worse",
        _ => "corrected",
    }
}

/// Why a loop ended, in two words: the doubts say the rest.
fn ended(end: &LoopEnd) -> &'static str {
    match end {
        LoopEnd::Done => "as asked",
        LoopEnd::NoBetter => "no better",
        LoopEnd::Worse => "worse",
        LoopEnd::Broken(_) => "broken off",
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
    format!("{open:.decimals$} → {closed:.decimals$}").replace('-', "−")
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

fn one(row: &Row<'_>) -> Outcome<Markup> {
    let open = &row.looped.iterations[0].verification;
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
                (format!("{}. ", headroom_text(&row.drive.headroom)))
                (format!("{}. ", capital(&row.looped.kept.to_string())))
                @if bands.is_empty() { "Nothing of the band is given up." } @else { (format!("Given up: {}.", bands.join(", "))) }
            }
            (figure(&figures::open_and_closed(open, row.looped.told())?, "Power spectral densities of the target, of what the first drive made of it, and of what the corrected one does. Shaded: what the inverse reaches."))
            (figure(&figures::error(row.looped.told())?, "What is left in the closed loop, line by line. Red: the limit that its rms is judged by."))
            @if !row.drive.about.doubts.is_empty() {
                ul.doubts { @for doubt in merged(&row.drive.about.doubts) { li { (merged_text(&doubt)) } } }
            }
        }
    })
}

fn method(page: &Page) -> Markup {
    html! {
        section {
            h2 { "How it was done" }
            @if let Some(aim) = page.aim {
                p { (format!(
                    "Aim: {}. Judged over {}. Every drive was played twice with the finger lying as it lay: the second measurement judged it, both together corrected it. The loop stopped when there was no improvement in two iterations, and measured the best once more; it is kept where it came closer than the open loop beyond the spread of the measurements, else the open loop is.",
                    aim.told(), page.band
                )) }
            }
            table {
                @for origin in &page.origins { (origin) }
            }
            p.soft { (concat!("piezotact ", env!("CARGO_PKG_VERSION"))) }
        }
    }
}
