//! Warnings about a spectrum.

use serde::{Deserialize, Serialize};

/// Warnings about a spectrum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum SpectrumWarning {
    /// A signal with few segments: too short for a stable spectrum.
    #[error(
        "the spectrum is the mean of {segments} segment(s): its standard deviation is about {:.1} dB; record longer",
        4.34 * (1.0 / (*segments).max(1) as f64).sqrt()
    )]
    ShortSignal { segments: usize },
    /// The signal uses so few steps of the converter that quantisation shows.
    #[error(
        "{channel} is only {rms_in_steps:.1} converter steps rms; quantisation noise is only {:.0} dB below it: record with more gain",
        20.0 * (rms_in_steps * 12f64.sqrt()).max(1.0).log10()
    )]
    CoarseQuantisation { channel: String, rms_in_steps: f64 },
}
