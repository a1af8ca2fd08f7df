//! Warnings about a change of rate.

use serde::{Deserialize, Serialize};

/// Warnings about a change of rate.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum ResampleWarning {
    /// A signal was brought to another rate.
    #[error(
        "{signal} is sampled at {from_hz} Hz and was resampled to {to_hz} Hz: frequencies above 0.45 of the lower rate are attenuated; keep the \
            band below {:.0} Hz",
        0.45 * from_hz.min(*to_hz)
    )]
    RateConverted {
        signal: String,
        from_hz: f64,
        to_hz: f64,
    },
}
