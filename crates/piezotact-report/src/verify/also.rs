//! Further measurements of the same target beside the one that is judged.

use maud::{Markup, html};
use piezotact::Doubt;
use piezotact::doubt::merged;
use piezotact::verify::Verification;

use super::Page;
use crate::advice::merged_text;
use crate::failure::Outcome;
use crate::output::difference_db;
use crate::report::{figure, figures};

/// A measurement with the name that it has in the report.
pub(crate) struct Also<'a> {
    pub(crate) label: &'a str,
    pub(crate) verification: &'a Verification,
    /// What is doubted of it alone.
    pub(crate) doubts: Vec<&'a Doubt>,
    /// Whether it says how it was rendered.
    pub(crate) rendering: Told,
}

/// Whether a measurement says how the drive was rendered that played.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Told {
    Rendering,
    Nothing,
}

fn row(label: &str, v: &Verification, told: Told) -> Markup {
    let level = match told {
        Told::Rendering => format!("{:+.1} dB", v.level_db).replace('-', "−"),
        Told::Nothing => "not said".into(),
    };
    html! {
        tr {
            td { (label) }
            td.n { (level) }
            td.n { (format!("{:.2}", v.error_db_rms)) }
            td.n { (v.error_db_rms_achievable.map_or("–".into(), |db| format!("{db:.2}"))) }
            td.n { (format!("{:.2} at {:.0} Hz", v.error_db_max, v.error_max_at_hz)) }
            td.n { (difference_db(v.level_error_db)) }
            td.n { (format!("{:.3}", v.waveform_correlation).replace('-', "−")) }
            td.n { (format!("{:.2} %", v.clipped_fraction * 100.0)) }
            td { (v.verdict.word()) }
        }
    }
}

pub(super) fn section(page: &Page<'_>) -> Outcome<Markup> {
    if page.also.is_empty() {
        return Ok(html! {});
    }
    let v = page.verification;
    let told = page.rendering.map_or(Told::Nothing, |_| Told::Rendering);
    let figure = figure(
        &figures::all_spectra(page)?,
        &format!(
            "PSDs of the target and of every measurement, each as it was measured and brought onto the target's time. The target stands at the level at which {} was to play. Shaded: what is judged of {}.",
            page.measured, page.measured
        ),
    );
    Ok(html! {
        section {
            h2 { "Further measurements of the same target" }
            p { (format!("Each is verified in the same way over {}, at the level that it says it was rendered with. The verdict above is that of {}.", v.band_hz, page.measured)) }
            div.wide {
                table.tight.matrix {
                    tr {
                        th { "measurement" }
                        th.n { "rendered at" }
                        th.n { "error, dB rms" }
                        th.n { "achievable part, dB rms" }
                        th.n { "largest error, dB" }
                        th.n { "level error, dB" }
                        th.n { "waveform correlation" }
                        th.n { "samples at a limit" }
                        th { "verdict by itself" }
                    }
                    (row(page.measured, v, told))
                    @for also in page.also { (row(also.label, also.verification, also.rendering)) }
                }
            }
            (figure)
            h3 { "Doubts about them" }
            @for also in page.also {
                p { b { (also.label) } @if also.doubts.is_empty() { ": none beside those about the target." } }
                @if !also.doubts.is_empty() { ul.doubts { @for doubt in merged(also.doubts.iter().copied()) { li { (merged_text(&doubt)) } } } }
            }
        }
    })
}
