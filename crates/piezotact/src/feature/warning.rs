//! Warnings about the features of strokes.

use std::fmt;

use crate::number::rounded;
use crate::warning::words::percent;
use crate::warning::{Advice, WarningKind, warnings};

warnings! {
    /// Warnings about the features of strokes.
    pub enum FeatureWarning {
        /// Strokes too short for a spectrum with the lines of the others.
        ShortStrokes("short_strokes") {
            /// How many.
            count: usize,
            /// What is needed, s.
            needed_s: f64,
        },
        /// Much of the power lies below the band of vibration, and was not filtered out.
        GestureKept("gesture_kept") {
            /// The share of the power, 0–1.
            share: f64,
            /// Below this frequency, Hz.
            below_hz: f64,
        },
    }
}

impl WarningKind for FeatureWarning {
    fn of(warning: &crate::Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        match self {
            Self::ShortStrokes { .. } => vec![Advice::ShorterSegments { to_s: None }],
            Self::GestureKept { below_hz, .. } => vec![Advice::StateHighPass { at_hz: *below_hz }],
        }
    }
}

impl fmt::Display for FeatureWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ShortStrokes { count, needed_s } => write!(
                f,
                "{count} stroke(s) shorter than a segment of {needed_s:.3} s are left out"
            ),
            Self::GestureKept { share, below_hz } => write!(
                f,
                "{} of the power is below {below_hz} Hz, in the range of gestures, and was kept (only accelerations are \
                    filtered by default)",
                percent(*share),
                below_hz = rounded(*below_hz)
            ),
        }
    }
}
