//! A replay as a value: what the report shows and what is handed out as JSON.

use piezotact::document::Content;
use serde::Serialize;

use crate::Chapter;
use crate::count::PanelCount;

/// The measurements of the thesis again, on the twin.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Replay {
    /// The name of the report.
    pub report: String,
    /// What everything was drawn with.
    pub seed: u64,
    /// The name of the file that changes the parameters of the twin; absent without one.
    pub twin: Option<String>,
    /// What it changes.
    pub changes: Vec<String>,
    /// The chapters, with what was found of their claims.
    pub chapters: Vec<Chapter>,
    /// How many panels meet each claim; absent where one panel alone was measured.
    pub panels: Option<PanelCount>,
}

impl Content for Replay {
    const SCHEMA: &'static str = "replay";
    const VERSION: u32 = 2;
}
