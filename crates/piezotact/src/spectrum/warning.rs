//! Warnings about a spectrum.

use serde::{Deserialize, Serialize};

/// Warnings about a spectrum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum SpectrumWarning {
    /// The signal uses so few steps of the converter that quantisation shows.
    #[error(
        "{channel} is only {rms_in_steps:.1} converter steps rms; quantisation noise is only {:.0} dB below it: record with more gain",
        20.0 * (rms_in_steps * 12f64.sqrt()).max(1.0).log10()
    )]
    CoarseQuantisation { channel: String, rms_in_steps: f64 },
}
