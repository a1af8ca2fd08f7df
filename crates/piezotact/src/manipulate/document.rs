//! A manipulated texture as it is handed out, without its samples.

use std::path::Path;

use serde::Serialize;

use super::BeforeAndAfter;
use crate::document::Content;
use crate::lineage::Lineage;
use crate::quantity::{Acceleration, Quantity, SampleRate, Seconds, Unit};
use crate::recording::Condition;
use crate::statistics::standard_deviation;
use crate::warning::{Merged, merged};

/// A texture that was manipulated: what it was before and what it is after.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ManipulateDocument<'a> {
    /// The file that holds it.
    pub out: &'a Path,
    /// Its rate, Hz.
    pub rate_hz: SampleRate,
    /// How long it is, s.
    pub duration_s: Seconds,
    /// Its root mean square about the mean before, in `unit`.
    pub rms_before: f64,
    /// The same after, in `unit`.
    pub rms_after: f64,
    /// Its unit.
    pub unit: Unit,
    /// What still holds of how it was recorded.
    pub condition: &'a Condition,
    /// What was done.
    pub lineage: &'a Lineage,
    /// What was done, in words.
    pub text: String,
    /// What limits it.
    pub warnings: Vec<Merged>,
    /// What its report shows.
    #[serde(skip)]
    pub shown: BeforeAndAfter<'a>,
}

impl Content for ManipulateDocument<'_> {
    const SCHEMA: &'static str = "manipulate";
}

impl<'a> ManipulateDocument<'a> {
    /// The texture after its manipulation, kept in the file `out`.
    ///
    /// Source: docs/decisions/documents.md.
    #[must_use]
    pub fn of(shown: BeforeAndAfter<'a>, condition: &'a Condition, out: &'a Path) -> Self {
        let (before, after) = (shown.before, shown.after);
        Self {
            out,
            rate_hz: after.series.rate(),
            duration_s: after.series.duration(),
            rms_before: standard_deviation(before.series.samples()),
            rms_after: standard_deviation(after.series.samples()),
            unit: Acceleration::UNIT,
            condition,
            lineage: &after.lineage,
            text: after.lineage.to_string(),
            warnings: merged(&after.warnings),
            shown,
        }
    }
}
