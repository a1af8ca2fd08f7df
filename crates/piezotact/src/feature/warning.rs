//! Warnings about the features of strokes.

use crate::number::rounded;
use crate::warning::words::percent;
use serde::{Deserialize, Serialize};

/// Warnings about the features of strokes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum FeatureWarning {
    /// Much of the power lies below the band of vibration, and was not filtered out.
    #[error(
        "{} of the power is below {below_hz} Hz, in the range of gestures, and was kept (only accelerations are filtered by default); state a \
            high-pass filter at {below_hz} Hz",
        percent(*share),
        below_hz = rounded(*below_hz)
    )]
    GestureKept { share: f64, below_hz: f64 },
}
