//! Folders of panels as they are handed out.

use std::path::Path;

use piezotact::document::Content;
use piezotact::number::counted;
use piezotact::page::{Block, Number, Page, Shown};
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

impl Shown for PanelAddDocument<'_> {
    fn page(&self) -> Page {
        let added = self.filed.iter();
        let added = added.map(|filing| Block::conclusion(format!("Added as {filing}."), None));
        let number = Number::new(self.measurements.to_string(), "measurements in the panel");
        let blocks = added.chain([Block::numbers([number])]);
        Page::new("Panel", self.folder.display().to_string()).section("", blocks)
    }
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

impl Shown for PanelRun<'_> {
    fn page(&self) -> Page {
        let text = format!(
            "{} made, {} in all of {}.",
            counted(self.counts.measured, "measurement"),
            self.measurements,
            counted(self.index.participants.len(), "participant")
        );
        let bench = self.index.bench.clone().unwrap_or_default();
        Page::new("Panel", bench).section("", [Block::conclusion(text, None)])
    }
}
