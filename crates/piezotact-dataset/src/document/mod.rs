//! Files and folders as they are handed out: what is in them, and what was written.

mod info;
mod panel;

use std::path::Path;

use piezotact::Warning;
use piezotact::document::Content;
use piezotact::quantity::{Measure, SampleRate};
use piezotact::warning::{Merged, merged};
use serde::Serialize;

pub use info::{
    ChannelSummary, ClockSummary, DeviceInfo, InfoDocument, PanelIndexInfo, RecordingInfo, RunInfo,
    RunsInfo, TransferInfo, clock_summaries,
};
pub use panel::{PanelAddDocument, PanelAnalysisDocument, PanelRunCounts, PanelRunDocument};

/// A file for other programs that was written.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ExportDocument<'a> {
    /// The file.
    pub out: &'a Path,
    /// What kind of file it is.
    pub format: String,
    /// Its rate, Hz; absent where it has none.
    pub rate_hz: Option<SampleRate>,
    /// What a sample of 1 stands for; absent where nothing says it.
    pub full_scale: Option<&'a Measure>,
    /// What limits it, and what the format cannot hold.
    pub warnings: Vec<Merged>,
}

impl Content for ExportDocument<'_> {
    const SCHEMA: &'static str = "export";
}

impl<'a> ExportDocument<'a> {
    /// The file `out` of the kind `format` with what limits it.
    #[must_use]
    pub fn of(
        (out, format): (&'a Path, String),
        (rate_hz, full_scale): (Option<SampleRate>, Option<&'a Measure>),
        warnings: &[Warning],
    ) -> Self {
        Self {
            out,
            format,
            rate_hz,
            full_scale,
            warnings: merged(warnings),
        }
    }
}
