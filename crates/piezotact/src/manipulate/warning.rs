//! Warnings about a manipulation of a texture.

use crate::number::rounded;
use crate::warning::words::percent;
use serde::{Deserialize, Serialize};

/// Warnings about a manipulation of a texture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum ManipulateWarning {
    /// Part of a texture was shifted beyond half of its sampling rate.
    #[error(
        "{operation}: {} of the power would be outside 0 to {nyquist_hz} Hz and is lost; use a smaller change, or record at another rate",
        percent(*share),
        nyquist_hz = rounded(*nyquist_hz)
    )]
    LeftTheBand {
        operation: String,
        share: f64,
        nyquist_hz: f64,
    },
    /// A texture joined with itself has a noticeable join.
    #[error(
        "where the texture is looped, {by}: the join may be felt; use a longer stroke of constant level"
    )]
    JoinShows {
        #[serde(flatten)]
        by: NoticeableJoin,
    },
}

/// What makes a join noticeable.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "by", rename_all = "snake_case")]
pub enum NoticeableJoin {
    /// The ends differ.
    #[error(
        "the joined ends have a correlation of {correlation:.2}, the largest step is {step_ratio:.2} times that of the texture, and the short-time \
            spectrum is {spectrum_db:+.1} dB re its strongest"
    )]
    Waveform {
        correlation: f64,
        step_ratio: f64,
        spectrum_db: f64,
    },
    /// The level jumps.
    #[error("the level changes by {jump_db:.1} dB, and by {own_db:.1} dB at most elsewhere")]
    Level { jump_db: f64, own_db: f64 },
}
