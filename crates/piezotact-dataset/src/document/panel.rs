//! Folders of panels as they are handed out.

use std::path::Path;

use piezotact::document::Content;
use piezotact::panel::Filing;
use serde::Serialize;

use crate::PanelIndex;

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
