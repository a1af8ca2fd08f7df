//! Folders of panels as they are handed out.

use std::path::Path;

use piezotact::document::Content;
use piezotact::panel::{ArtefactDocument, Cell, Cleaning, Filing, PanelAnalysis, PanelKind};
use serde::Serialize;

use crate::{PanelEntry, PanelFolder};

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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PanelRunCounts {
    pub measured: usize,
    pub there_already: usize,
}

/// A panel that was measured on a bench.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PanelRunDocument<'a> {
    /// The folder of the panel.
    pub out: &'a Path,
    /// How many measurements were made now.
    pub measured: usize,
    /// How many were there already.
    pub there_already: usize,
    /// How many there are now.
    pub measurements: usize,
    /// Those that were judged when they were made.
    pub accepted: Vec<&'a PanelEntry>,
    /// The participants.
    pub participants: &'a [String],
    /// The loads, N.
    pub loads_n: &'a [f64],
    /// The angles, degrees.
    pub angles_deg: &'a [f64],
    /// Which bench measures it; absent where nothing says it.
    pub bench: Option<&'a str>,
}

impl Content for PanelRunDocument<'_> {
    const SCHEMA: &'static str = "panel_run";
}

impl<'a> PanelRunDocument<'a> {
    /// The panel `folder`, which stands in `out`, with what was measured.
    #[must_use]
    pub fn of(folder: &'a PanelFolder, out: &'a Path, counts: PanelRunCounts) -> Self {
        let index = &folder.index;
        Self {
            out,
            measured: counts.measured,
            there_already: counts.there_already,
            measurements: index.entries.len(),
            accepted: folder.accepted(),
            participants: &index.participants,
            loads_n: &index.loads_n,
            angles_deg: &index.angles_deg,
            bench: index.bench.as_deref(),
        }
    }
}

/// What the panel in a folder says.
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
    pub artefact: Option<ArtefactDocument<'a>>,
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
            artefact: cleaning.map(ArtefactDocument::from),
        }
    }
}
