//! The textures from which a manipulated target was made.

use maud::{Markup, html};
use piezotact::lineage::{Lineage, Operation};
use piezotact::quantity::Acceleration;
use piezotact::series::Series;
use piezotact::verify::Changed;

use super::Page;
use crate::{DrawError, figure, figures, origin};
use piezotact::number::{difference_db, digits};

/// A texture that the target was made from, or that it took something of.
#[derive(Clone, Copy, Debug)]
pub struct Before<'a> {
    pub label: &'a str,
    /// The texture, m/s².
    pub series: &'a Series<Acceleration>,
    /// What it differs by from the target.
    pub changed: &'a Changed,
}

/// What was done to the texture before it was rendered: the target says it, or else the drive that was rendered from it.
fn made_from<'a>(page: &Page<'a>) -> Option<&'a Lineage> {
    let own = page.target.about.provenance.lineage.as_ref();
    own.or_else(|| {
        let rendering = page.rendering?;
        let known = rendering.about.provenance.lineage.as_ref();
        // A texture that was only rendered was made from nothing else.
        known.filter(|lineage| lineage.source != rendering.target)
    })
}

/// Whether a step of `lineage` takes a property of the texture called `label`, or of one that was made from it.
fn takes_from(lineage: &Lineage, label: &str) -> bool {
    lineage.steps.iter().any(|step| match &step.operation {
        Operation::RmsOf { of, .. } | Operation::SpectrumOf { of, .. } => {
            of.source == label || takes_from(of, label)
        }
        _ => false,
    })
}

/// What the lineage of the target says of a texture called `label`.
fn place_in(lineage: Option<&Lineage>, label: &str) -> &'static str {
    match lineage {
        None => "the target does not state what it was made from",
        Some(lineage) if lineage.source == label => "source of the target",
        Some(lineage) if takes_from(lineage, label) => "one of its properties was used",
        Some(_) => "not named in the processing steps",
    }
}

pub(super) fn section(page: &Page<'_>) -> Result<Markup, DrawError> {
    if page.before.is_empty() {
        return Ok(html! {});
    }
    let lineage = made_from(page);
    let level = |x: f64| format!("{} m/s²", digits(x));
    let waves = figures::before_waveforms(page)?;
    let band = page.verification.band_hz;
    Ok(html! {
        section {
            h2 { "Texture manipulation: before and after" }
            @if let Some(lineage) = lineage {
                p { "Processing steps, from " (lineage.source) ":" }
                (origin::steps(&lineage.steps))
            }
            div.wide {
                table.tight.matrix {
                    tr {
                        th { "before" }
                        th { "role in the processing" }
                        th.n { "rms before" }
                        th.n { "rms after" }
                        th.n { "level, after re before" }
                        th.n { (format!("difference of shape, dB rms over {band}")) }
                    }
                    @for before in &page.before {
                        tr {
                            td { (before.label) }
                            td { (place_in(lineage, before.label)) }
                            td.n { (level(before.changed.rms_before)) }
                            td.n { (level(before.changed.rms_after)) }
                            td.n { (difference_db(before.changed.level_db)) " dB"  }
                            td.n { (format!("{:.2}", before.changed.shape_error_db_rms)) }
                        }
                    }
                }
            }
            p.soft { "Levels are rms about the mean at all frequencies. Shape: the difference of the PSDs after subtracting \
                their mean difference over the band; 0 if only the level was changed." }
            (figure(&waves, &format!("Before, and below after: the target that was rendered. The first {} s, on the same \
                scale.", figures::BEFORE_DRAWN_S)))
            (figure(&figures::before_spectra(page)?, "PSDs before and after, by Welch's method as above, of whole textures. A \
                change of level alone shifts the curve up or down and keeps its shape. Shaded: the band over which shapes are \
                compared."))
        }
    })
}
