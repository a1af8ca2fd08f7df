//! Warnings about clipping.

use crate::number::counted;
use crate::warning::words::percent;
use serde::{Deserialize, Serialize};

/// Warnings about clipping.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum ClippingWarning {
    /// Samples of a signal are at or beyond a limit.
    #[error("{}; {}", at.sentence(signal), at.advice())]
    Clipped {
        signal: String,
        #[serde(flatten)]
        at: ClippedAt,
    },
}

/// At which limit samples are.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "at", rename_all = "snake_case")]
pub enum ClippedAt {
    /// Samples of a recording at its limit.
    Recorded { fraction: f64 },
    /// Samples of the played drive at or beyond the limit of the device.
    Played { fraction: f64 },
    /// Samples of a rendered drive that were cut at a limit of the device.
    Rendered { fraction: f64, limited_by: String },
    /// Samples of an input at its full scale.
    Input { samples: u64 },
    /// Samples of an output beyond its full scale, which were limited.
    Output { samples: u64 },
    /// Samples at the limit of an amplifier of EEG.
    Amplifier { fraction: f64 },
}

impl ClippedAt {
    /// What of `signal` is at which limit.
    fn sentence(&self, signal: &str) -> String {
        let of = |samples: u64| counted(samples as usize, "sample");
        match self {
            Self::Recorded { fraction } | Self::Played { fraction } => format!(
                "{} of the samples of {signal} are at or beyond the limit",
                percent(*fraction)
            ),
            Self::Rendered {
                fraction,
                limited_by,
            } => format!(
                "{} of the samples of {signal} were clipped at the limit of {limited_by}",
                percent(*fraction)
            ),
            Self::Input { samples } => {
                format!("{signal} reached its full scale in {}", of(*samples))
            }
            Self::Output { samples } => {
                format!(
                    "{signal} exceeded full scale in {}, which were limited",
                    of(*samples)
                )
            }
            Self::Amplifier { fraction } => format!(
                "{signal}: {} of the samples are at the limit of the amplifier, and power is wrong there",
                percent(*fraction)
            ),
        }
    }

    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Recorded { .. }
            | Self::Played { .. }
            | Self::Rendered { .. }
            | Self::Output { .. } => "lower the level",
            Self::Input { .. } => "lower the level, and record again",
            Self::Amplifier { .. } => {
                "reject these epochs by their amplitude, or record with a lower gain"
            }
        }
    }
}
