//! A panel freed of the artefact of its bench.

use serde::Serialize;

use super::{Artefact, Dip, Entry, Filing, Panel, PanelError, artefact_of};
use crate::quantity::{Band, Uncalibrated};
use crate::transfer::TransferFunction;

/// The dip of one measurement at the artefact, before and after it was taken out.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct CleanedDip {
    /// The measurement.
    pub of: Filing,
    /// Before.
    pub before: Dip,
    /// After.
    pub after: Dip,
}

/// What taking the artefact of a bench out of a panel did.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Cleaning {
    /// The control measurement without a finger.
    #[serde(skip)]
    pub control: TransferFunction<Uncalibrated, Uncalibrated>,
    /// What was found in it.
    #[serde(flatten)]
    pub artefact: Artefact,
    /// The dips of every measurement at the artefact.
    #[serde(rename = "fingers")]
    pub dips: Vec<CleanedDip>,
    /// The first measurement before, as an example.
    #[serde(skip)]
    pub example_before: Option<TransferFunction<Uncalibrated, Uncalibrated>>,
}

/// `panel` with the artefact that `control` shows in `search` taken out of every measurement, and what that did. The warnings of the panel and
/// of the artefact go with it.
///
/// Formula: that of [`artefact_of`] and [`Artefact::remove_from`], measurement by measurement.
///
/// Source: L. Felicetti's thesis (2024), figure 71, for the control measurement.
///
/// # Errors
/// [`PanelError`] where the control shows no artefact or has other lines than the panel.
pub fn without_artefact(
    panel: &Panel<Uncalibrated, Uncalibrated>,
    control: TransferFunction<Uncalibrated, Uncalibrated>,
    search: Band,
) -> Result<(Panel<Uncalibrated, Uncalibrated>, Cleaning), PanelError> {
    let artefact = artefact_of(&control, search)?;
    let mut dips = Vec::new();
    let mut entries = Vec::new();
    for entry in panel.entries() {
        let removed = artefact.remove_from(&entry.function)?;
        dips.push(CleanedDip {
            of: entry.filing.clone(),
            before: removed.before,
            after: removed.after,
        });
        entries.push(Entry {
            filing: entry.filing.clone(),
            function: removed.function,
        });
    }
    let mut cleaned = Panel::new(entries)?;
    cleaned.warnings.extend(panel.warnings.iter().cloned());
    cleaned.warnings.extend(artefact.warnings.iter().cloned());
    let example_before = panel.entries().first().map(|entry| entry.function.clone());
    let cleaning = Cleaning {
        control,
        artefact,
        dips,
        example_before,
    };
    Ok((cleaned, cleaning))
}
