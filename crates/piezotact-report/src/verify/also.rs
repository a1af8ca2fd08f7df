//! Further measurements of the same target beside the one that is judged.

use maud::{Markup, html};
use piezotact::document::Words;
use piezotact::number::{difference_db, plus, signed};
use piezotact::verify::Verification;
use piezotact::warning::Merged;

use super::Page;
use crate::{DrawError, figure, figures};

/// A measurement with the name that it has in the report.
#[derive(Clone, Debug)]
pub struct Also<'a> {
    pub label: &'a str,
    pub verification: &'a Verification,
    /// The warnings about it alone.
    pub warnings: Vec<Merged>,
    /// Whether it says how it was rendered.
    pub rendering: Stated,
}

/// Whether a measurement says how the drive was rendered that played.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stated {
    /// It says how.
    Rendering,
    /// It says nothing.
    Nothing,
}

fn row(label: &str, v: &Verification, stated: Stated) -> Markup {
    let level = match stated {
        Stated::Rendering => format!("{} dB", plus(v.level_db, 1)),
        Stated::Nothing => "not stated".into(),
    };
    html! {
        tr {
            td { (label) }
            td.n { (level) }
            td.n { (format!("{:.2}", v.error_db_rms)) }
            td.n { (v.error_db_rms_achievable.map_or("–".into(), |db| format!("{db:.2}"))) }
            td.n { (format!("{:.2} at {:.0} Hz", v.error_db_max, v.error_max_at_hz)) }
            td.n { (difference_db(v.level_error_db)) }
            td.n { (signed(v.waveform_correlation, 3)) }
            td.n { (format!("{:.2} %", v.clipped_fraction * 100.0)) }
            td { (v.verdict.word()) }
        }
    }
}

pub(super) fn section(page: &Page<'_>, words: &dyn Words) -> Result<Markup, DrawError> {
    if page.also.is_empty() {
        return Ok(html! {});
    }
    let v = page.verification;
    let stated = page
        .rendering
        .map_or(Stated::Nothing, |_| Stated::Rendering);
    let figure = figure(
        &figures::all_spectra(page)?,
        &format!(
            "PSDs of the target and of all measurements, as measured and aligned in time with the target. The target is shown \
                at the level requested for {}. Shaded: the evaluated band of {}.",
            page.measured, page.measured
        ),
    );
    Ok(html! {
        section {
            h2 { "Further measurements of the same target" }
            p { (format!("Each is verified in the same way over {}, at its own stated rendering level. The verdict above is \
                that of {}.", v.band_hz, page.measured)) }
            div.wide {
                table.tight.matrix {
                    tr {
                        th { "measurement" }
                        th.n { "rendering level" }
                        th.n { "error, dB rms" }
                        th.n { "error over the reached part, dB rms" }
                        th.n { "largest error, dB" }
                        th.n { "level error, dB" }
                        th.n { "waveform correlation" }
                        th.n { "samples at a limit" }
                        th { "own verdict" }
                    }
                    (row(page.measured, v, stated))
                    @for also in &page.also { (row(also.label, also.verification, also.rendering)) }
                }
            }
            (figure)
            h3 { "Warnings about these measurements" }
            @for also in &page.also {
                p { b { (also.label) } @if also.warnings.is_empty() { ": none, except those about the target." } }
                @if !also.warnings.is_empty() { ul.warnings { @for warning in &also.warnings { li { (words.merged(warning)) } } } }
            }
        }
    })
}
