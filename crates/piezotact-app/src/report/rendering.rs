//! The report of renderings that were corrected in a closed loop.

use maud::{Markup, html};
use piezotact::quantity::Band;
use piezotact::render::RenderedDrive;
use piezotact_bench::procedure::{LoopEnd, Looped};

use super::{UNKNOWN_BENCH, bench_told, broad_document, figure, figures};
use crate::failure::Outcome;
use crate::output::{difference_db, headroom_text};

/// What counts as close, dB: the rms over what the inverse reaches, and the largest of its lines.
const CLOSE_DB: (f64, f64) = (1.0, 3.0);

/// One texture on one finger.
pub(crate) struct Row<'a> {
    pub(crate) called: &'a str,
    pub(crate) level_db: f64,
    pub(crate) drive: &'a RenderedDrive,
    pub(crate) looped: &'a Looped,
}

/// What a report of renderings shows.
pub(crate) struct Page<'a> {
    pub(crate) rows: &'a [Row<'a>],
    /// Those that could not be rendered, and why.
    pub(crate) refused: &'a [(String, String)],
    pub(crate) band: Band,
}

/// The report as HTML text.
pub(crate) fn render(page: &Page<'_>) -> Outcome<String> {
    let title = match page.rows {
        [only] => format!("Rendering of {} in a closed loop", only.called),
        rows => format!(
            "Rendering in a closed loop: {} textures and fingers",
            rows.len()
        ),
    };
    let body = html! {
        h1 { (title) }
        p.soft { (bench_line(page)) }
        (summary(page))
        (table(page))
        (refused(page))
        @for row in page.rows { (one(row)?) }
        (method(page))
    };
    Ok(broad_document(&title, &body))
}

fn bench_line(page: &Page<'_>) -> String {
    let mut kinds: Vec<&str> = page
        .rows
        .iter()
        .map(|row| bench_told(row.looped.recording.provenance.bench).unwrap_or(UNKNOWN_BENCH))
        .collect();
    kinds.sort_unstable();
    kinds.dedup();
    kinds.join(" ")
}

fn is_close(row: &Row<'_>) -> bool {
    let v = &row.looped.confirmed;
    v.judged_error_db() <= CLOSE_DB.0 && v.error_db_max_achievable() <= CLOSE_DB.1
}

fn summary(page: &Page<'_>) -> Markup {
    let close = page.rows.iter().filter(|row| is_close(row)).count();
    let most = |of: &dyn Fn(&Row<'_>) -> f64| page.rows.iter().map(of).fold(0.0, f64::max);
    let mean = |of: &dyn Fn(&Row<'_>) -> f64| {
        page.rows.iter().map(of).sum::<f64>() / page.rows.len().max(1) as f64
    };
    let open = |row: &Row<'_>| row.looped.iterations[0].verification.judged_error_db();
    let closed = |row: &Row<'_>| row.looped.confirmed.judged_error_db();
    let number = |value: String, what: &str| html! { div { b { (value) } span { (what) } } };
    let all = page.rows.len() + page.refused.len();
    let told = match (all, close) {
        (1, 1) => format!(
            "It came within {} dB rms and {} dB of its target over what is reached",
            CLOSE_DB.0, CLOSE_DB.1
        ),
        (1, _) => format!(
            "It did not come within {} dB rms and {} dB of its target over what is reached",
            CLOSE_DB.0, CLOSE_DB.1
        ),
        _ => format!(
            "{close} of {all} came within {} dB rms and {} dB of their target over what is reached",
            CLOSE_DB.0, CLOSE_DB.1
        ),
    };
    html! {
        section class=(if close == page.rows.len() && page.refused.is_empty() { "verdict" } else { "verdict failed" }) {
            strong { (told) }
            div.numbers {
                @if let [only] = page.rows {
                    (number(format!("{:.2} dB", open(only)), "rms error open"))
                    (number(format!("{:.2} dB", closed(only)), "rms error closed"))
                } @else {
                    (number(format!("{:.2} dB", mean(&open)), "rms error open, mean"))
                    (number(format!("{:.2} dB", mean(&closed)), "rms error closed, mean"))
                    (number(format!("{:.2} dB", most(&closed)), "rms error closed, largest"))
                }
                (number(format!("{:.1} dB", most(&|row| row.looped.confirmed.error_db_max_achievable())), "error of one line, largest"))
            }
        }
    }
}

fn table(page: &Page<'_>) -> Markup {
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
                        th.n { "steps" }
                        th { "ended" }
                    }
                    @for row in page.rows { (line(row)) }
                }
            }
            p.soft { "Before the arrow the open loop's drive; after it the best of the closed loop, measured once more by a measurement that neither corrected nor chose it. dB rms and largest line: over the part of the band that is reached, in green where within the limits. Level: re the texture. Correlation: of the waveforms. At the limit: the share of samples where device or sensor clips. Steps: corrections up to the best. Ended: as often as asked, when it got no better twice in a row, when it got clearly worse, or when a measurement could not be believed." }
        }
    }
}

fn line(row: &Row<'_>) -> Markup {
    let open = &row.looped.iterations[0].verification;
    let closed = &row.looped.confirmed;
    let width = |bands: &[Band]| bands.iter().map(|b| b.high().0 - b.low().0).sum::<f64>();
    let band = row.drive.config.inverse.band;
    let reached = width(&row.drive.achievable) / width(&[band]);
    html! {
        tr {
            td { (row.called) }
            td.n { (format!("{:+.1}", row.level_db).replace('-', "−").replace("+0.0", "0")) }
            td class=(if is_close(row) { "n near" } else { "n" }) { (then(open.judged_error_db(), closed.judged_error_db(), 2)) }
            td.n { (then(open.error_db_max_achievable(), closed.error_db_max_achievable(), 1)) }
            td.n { (difference_db(closed.level_error_db)) }
            td.n { (then(open.waveform_correlation, closed.waveform_correlation, 3)) }
            td.n { (format!("{:.0} %", reached * 100.0)) }
            td.n { (format!("{:.2} %", closed.clipped_fraction.max(row.looped.iterations[row.looped.best].held) * 100.0)) }
            td.n { (row.looped.best) }
            td { (ended(&row.looped.end)) }
        }
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

/// A number of the open loop and what became of it.
fn then(open: f64, closed: f64, decimals: usize) -> String {
    format!("{open:.decimals$} → {closed:.decimals$}").replace('-', "−")
}

fn refused(page: &Page<'_>) -> Markup {
    html! {
        @if !page.refused.is_empty() {
            section {
                h2 { "Not rendered" }
                table {
                    @for (called, why) in page.refused { tr { th { (called) } td { (why) } } }
                }
            }
        }
    }
}

fn one(row: &Row<'_>) -> Outcome<Markup> {
    let open = &row.looped.iterations[0].verification;
    let bands: Vec<String> = row.drive.given_up.iter().map(ToString::to_string).collect();
    Ok(html! {
        section {
            h2 { (row.called) }
            p {
                (format!("{}. ", headroom_text(&row.drive.headroom)))
                @if bands.is_empty() { "Nothing of the band is given up." } @else { (format!("Given up: {}.", bands.join(", "))) }
            }
            (figure(&figures::open_and_closed(open, &row.looped.confirmed)?, "Power spectral densities of the target, of what the first drive made of it, and of what the corrected one does. Shaded: what the inverse reaches."))
            (figure(&figures::error(&row.looped.confirmed)?, "What is left in the closed loop, line by line. Red: the limit that its rms is judged by."))
            @if !row.drive.doubts.is_empty() {
                ul.doubts { @for doubt in &row.drive.doubts { li { (doubt) } } }
            }
        }
    })
}

fn method(page: &Page<'_>) -> Markup {
    let aim = page.rows.first().and_then(|row| row.drive.aim);
    html! {
        section {
            h2 { "How it was done" }
            @if let Some(aim) = aim {
                p { (format!(
                    "Aim: {}. Judged over {}. Every drive was played twice with the finger lying as it lay: the second measurement judged it, both together corrected it. The loop kept the best, stopped when it got no better, and measured that one once more.",
                    aim.told(), page.band
                )) }
            }
            table {
                @for row in page.rows {
                    tr { th { (row.called) } td { ol { @for step in &row.drive.provenance.steps { li { (step) } } } } }
                }
            }
            p.soft { (concat!("piezotact ", env!("CARGO_PKG_VERSION"))) }
        }
    }
}
