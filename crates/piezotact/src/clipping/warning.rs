//! Warnings about clipping.

use crate::warning::words::percent;
use serde::{Deserialize, Serialize};

/// Samples at or beyond a limit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum ClippingWarning {
    /// Samples of a signal at its limit.
    #[error("{} of the samples of {signal} are at or beyond the limit: lower the level", percent(*fraction))]
    Clipped { signal: String, fraction: f64 },
    /// Samples of the played drive at or beyond the limit of the device.
    #[error("{} of the samples of the played drive are at or beyond the limit: lower the level", percent(*fraction))]
    PlayedDriveClipped { fraction: f64 },
    /// Samples of a rendered drive that were cut at a limit of the device.
    #[error("{} of the samples of the drive were clipped at the limit of {limited_by}: lower the level", percent(*fraction))]
    DriveClipped { limited_by: String, fraction: f64 },
}
