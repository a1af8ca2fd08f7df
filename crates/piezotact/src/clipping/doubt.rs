//! What clipping leaves open.

use std::fmt;

use crate::doubt::words::percent;
use crate::doubt::{Advice, DoubtKind, doubts};

doubts! {
    /// Samples at or beyond a limit.
    pub enum ClippingDoubt {
        /// Samples of a signal at its limit.
        Clipped("clipped") of Signal(what) {
            /// The signal: a channel, or what it stands for.
            what: String,
            /// The share of samples at the limit, 0–1.
            fraction: f64,
        },
        /// Samples of the drive that was played at or beyond what the device can do.
        PlayedDriveClipped("played_drive_clipped") {
            /// The share of samples at the limit, 0–1.
            fraction: f64,
        },
        /// Samples of a rendered drive at or beyond a limit of the device.
        DriveClipped("drive_clipped") {
            /// The limit.
            limited_by: String,
            /// The share of samples at the limit, 0–1.
            fraction: f64,
        },
    }
}

impl DoubtKind for ClippingDoubt {
    fn of(doubt: &crate::Doubt) -> Option<Self> {
        Self::of_doubt(doubt)
    }

    fn advice(&self) -> Vec<Advice> {
        vec![Advice::LowerLevel { to_db: None }]
    }
}

impl fmt::Display for ClippingDoubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (what, fraction) = match self {
            Self::Clipped { what, fraction } => (what.clone(), fraction),
            Self::PlayedDriveClipped { fraction } => ("the drive that was played".into(), fraction),
            Self::DriveClipped {
                limited_by,
                fraction,
            } => (format!("the drive ({limited_by})"), fraction),
        };
        write!(
            f,
            "{} of {what} lies at or beyond the limit",
            percent(*fraction)
        )
    }
}
