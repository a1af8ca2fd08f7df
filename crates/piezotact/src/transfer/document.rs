//! An estimated transfer function as it is handed out: what it was estimated from, without its lines.

use std::path::Path;

use serde::Serialize;

use super::{Bias, Estimator, ImpactTest, Limits, TransferFunction};
use crate::document::Content;
use crate::quantity::{Band, Quantity, Unit};
use crate::warning::{Merged, merged};

/// A transfer function that was estimated from two channels of a recording.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct EstimateDocument<'a> {
    /// The file that holds it.
    pub out: &'a Path,
    /// The unit of the drive.
    pub drive_unit: &'a Unit,
    /// The unit of the response.
    pub response_unit: &'a Unit,
    /// How it was estimated.
    pub estimator: Estimator,
    /// What the confidence limits hold.
    pub limits: Limits,
    /// How far H2 lies above H1 from 20 Hz on; absent where no line lies there.
    pub bias: Option<Bias>,
    /// How many segments were averaged.
    pub averages: usize,
    /// From the lowest to the highest line that was excited; absent when not known.
    pub excited_hz: Option<Band>,
    /// The distance of two lines, Hz.
    pub resolution_hz: f64,
    /// The hits and the windows of an impact test; absent for other drives.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub impact: Option<ImpactTest>,
    /// What limits it.
    pub warnings: Vec<Merged>,
}

impl Content for EstimateDocument<'_> {
    const SCHEMA: &'static str = "transfer";
}

impl<'a> EstimateDocument<'a> {
    /// `function` between channels in `units` (drive, response), kept in the file `out`.
    ///
    /// Source: decision 0046 of this project.
    #[must_use]
    pub fn of<I: Quantity, O: Quantity>(
        function: &TransferFunction<I, O>,
        [drive_unit, response_unit]: [&'a Unit; 2],
        out: &'a Path,
    ) -> Self {
        Self {
            out,
            drive_unit,
            response_unit,
            estimator: function.estimator,
            limits: function.limits(),
            bias: function.bias(function.tactile_band()),
            averages: function.averages,
            excited_hz: function.excited,
            resolution_hz: function.resolution_hz(),
            impact: function.impact.clone(),
            warnings: merged(&function.about.warnings),
        }
    }
}
