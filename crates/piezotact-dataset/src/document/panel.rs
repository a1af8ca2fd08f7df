//! Folders of panels as they are handed out.

use std::path::Path;

use piezotact::document::Content;
use piezotact::panel::{Cell, Cleaning, Filing, PanelAnalysis, PanelKind};
use serde::Serialize;

use crate::{PanelEntry, PanelFolder, PanelIndex};

/// Transfer functions that were filed in a panel.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PanelAddDocument<'a> {
    /// The folder of the panel.
    pub folder: &'a Path,
    /// Under what they are filed.
    pub filed: Vec<&'a Filing>,
    /// How many measurements the panel has now.
    pub measurements: usize,
}

impl Content for PanelAddDocument<'_> {
    const SCHEMA: &'static str = "panel_add";
}

/// How many measurements there were before and are new.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PanelRunCounts {
    /// How many measurements were made now.
    pub measured: usize,
    /// How many were there already.
    pub there_already: usize,
}

/// A panel that was measured on a bench.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PanelRun<'a> {
    #[serde(flatten)]
    pub counts: PanelRunCounts,
    /// How many measurements there are now.
    pub measurements: usize,
    #[serde(flatten)]
    pub index: &'a PanelIndex,
}

impl Content for PanelRun<'_> {
    const SCHEMA: &'static str = "panel_run";
    const VERSION: u32 = 2;
}

/// What the panel in a folder says. It differs from the analysis by what the folder knows of its measurements.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PanelAnalysisDocument<'a> {
    /// The analysis.
    #[serde(flatten)]
    pub analysis: &'a PanelAnalysis,
    /// What its transfer functions are of; absent where nothing says it.
    pub kind: Option<PanelKind>,
    /// The measurements that were judged when they were made.
    pub accepted: Vec<&'a PanelEntry>,
    /// The load and angle by which it is judged; absent where there is none.
    pub judged: Option<Cell>,
    /// Whether the average will do there for a new person: "yes", "no" or "not decided".
    pub will_the_average_do: Option<&'static str>,
    /// What was taken out; absent without a control measurement.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub artefact: Option<&'a Cleaning>,
}

impl Content for PanelAnalysisDocument<'_> {
    const SCHEMA: &'static str = "panel_analysis";
}

impl<'a> PanelAnalysisDocument<'a> {
    /// What `analysis` says of the panel in `folder`.
    #[must_use]
    pub fn of(
        analysis: &'a PanelAnalysis,
        folder: &'a PanelFolder,
        cleaning: Option<&'a Cleaning>,
    ) -> Self {
        let judged = analysis.judged();
        let costs = judged.and_then(|cell| analysis.penalties_at(cell));
        Self {
            analysis,
            kind: folder.index.kind,
            accepted: folder.accepted(),
            judged,
            will_the_average_do: costs.map(|costs| costs.verdict.outcome.answer()),
            artefact: cleaning,
        }
    }
}
