//! Files and folders as they are handed out: what is in them, and what was written.

mod info;
mod panel;

use piezotact::Warning;
use piezotact::document::Content;
use piezotact::quantity::{Measure, SampleRate};
use piezotact::warning::serialize_merged;
use serde::Serialize;

pub use info::{
    ChannelSummary, ClockSummary, DeviceInfo, InfoDocument, PanelIndexInfo, RecordingInfo, RunInfo,
    RunsInfo, TransferInfo, clock_summaries, event_counts,
};
pub use panel::{PanelAddDocument, PanelRun, PanelRunCounts};

/// A file for other programs that was written.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Written {
    /// What kind of file it is.
    pub format: String,
    /// Its rate, Hz; absent where it has none.
    pub rate_hz: Option<SampleRate>,
    /// What the number 1 stands for; absent where nothing says it.
    pub full_scale: Option<Measure>,
    /// What limits it, and what the format cannot hold.
    #[serde(serialize_with = "serialize_merged")]
    #[cfg_attr(
        feature = "schemas",
        schemars(with = "Vec<piezotact::warning::Merged>")
    )]
    pub warnings: Vec<Warning>,
}

impl Content for Written {
    const SCHEMA: &'static str = "export";
}
