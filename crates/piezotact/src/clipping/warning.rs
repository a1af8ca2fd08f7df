//! Warnings about clipping.

use std::fmt;

use crate::warning::words::percent;
use crate::warning::{Advice, WarningKind, warnings};

warnings! {
    /// Samples at or beyond a limit.
    pub enum ClippingWarning {
        /// Samples of a signal at its limit.
        Clipped("clipped") of Signal(what) {
            /// The signal: a channel, or what it stands for.
            what: String,
            /// The share of samples at the limit, 0–1.
            fraction: f64,
        },
        /// Samples of the played drive at or beyond the limit of the device.
        PlayedDriveClipped("played_drive_clipped") {
            /// The share of samples at the limit, 0–1.
            fraction: f64,
        },
        /// Samples of a rendered drive that were cut at a limit of the device.
        DriveClipped("drive_clipped") {
            /// The limit.
            limited_by: String,
            /// The share of samples that were cut, 0–1.
            fraction: f64,
        },
    }
}

impl WarningKind for ClippingWarning {
    fn of(warning: &crate::Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        vec![Advice::LowerLevel { to_db: None }]
    }
}

impl fmt::Display for ClippingWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Clipped { what, fraction } => {
                let share = percent(*fraction);
                write!(
                    f,
                    "{share} of the samples of {what} are at or beyond the limit"
                )
            }
            Self::PlayedDriveClipped { fraction } => {
                let share = percent(*fraction);
                write!(
                    f,
                    "{share} of the samples of the played drive are at or beyond the limit"
                )
            }
            Self::DriveClipped {
                limited_by,
                fraction,
            } => {
                let share = percent(*fraction);
                write!(
                    f,
                    "{share} of the samples of the drive were clipped at the limit of {limited_by}"
                )
            }
        }
    }
}
