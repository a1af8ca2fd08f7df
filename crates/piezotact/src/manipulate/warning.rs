//! Warnings about a manipulation of a texture.

use std::fmt;

use crate::number::rounded;
use crate::warning::words::percent;
use crate::warning::{Advice, WarningKind, warnings};

warnings! {
    /// Warnings about a manipulation of a texture.
    pub enum ManipulateWarning {
        /// Part of a texture was shifted beyond half of its sampling rate.
        LeftTheBand("left_the_band") {
            /// The operation.
            operation: String,
            /// The share of the power, 0–1.
            share: f64,
            /// Half the rate, Hz.
            nyquist_hz: f64,
        },
        /// A texture joined with itself has a noticeable join.
        JoinShows("join_shows") {
            /// The correlation of the two ends, −1 to 1.
            correlation: f64,
            /// The largest step between two samples at the join, relative to the largest of the texture.
            step_ratio: f64,
            /// The strongest short-time spectrum at the join, relative to the strongest of the texture, dB.
            spectrum_db: f64,
        },
        /// The level of a texture jumps where it is joined with itself.
        LevelJumps("level_jumps") {
            /// The change of its short-time level there, dB.
            jump_db: f64,
            /// The largest within the texture, dB.
            own_db: f64,
        },
    }
}

impl WarningKind for ManipulateWarning {
    fn of(warning: &crate::Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        match self {
            Self::LeftTheBand { .. } => vec![Advice::SmallerChange],
            Self::JoinShows { .. } => vec![Advice::LongerStroke],
            Self::LevelJumps { .. } => vec![Advice::SteadyStroke],
        }
    }
}

impl fmt::Display for ManipulateWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LeftTheBand {
                operation,
                share,
                nyquist_hz,
            } => write!(
                f,
                "{operation}: {} of the power would be outside 0 to {nyquist_hz} Hz and is lost",
                percent(*share),
                nyquist_hz = rounded(*nyquist_hz)
            ),
            Self::JoinShows {
                correlation,
                step_ratio,
                spectrum_db,
            } => write!(
                f,
                "where the texture is looped, the joined ends have a correlation of {correlation:.2}, the largest step \
                    is {step_ratio:.2} times that of the texture, and the short-time spectrum is {spectrum_db:+.1} dB re its \
                    strongest: the join may be felt"
            ),
            Self::LevelJumps { jump_db, own_db } => write!(
                f,
                "where the texture is looped, its level changes by {jump_db:.1} dB, and by {own_db:.1} dB at most elsewhere: \
                    this may be felt as a beat"
            ),
        }
    }
}
