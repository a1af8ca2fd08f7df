//! Warnings about a transfer function.

use crate::number::{counted, rounded};
use crate::quantity::Band;
use crate::warning::words::{bands as list, percent};
use serde::{Deserialize, Serialize};

/// Warnings about a transfer function.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum TransferWarning {
    /// Coherence is below what the estimate needs in part of the band.
    #[error(
        "coherence is below {asked} on {} of the band (lowest {lowest:.3} at {at_hz:.0} Hz): measure longer; raise the level; narrow the band",
        percent(*share),
        asked = rounded(*asked)
    )]
    LowCoherence {
        asked: f64,
        lowest: f64,
        at_hz: f64,
        share: f64,
    },
    /// The response comes so late after the drive that segments no longer hold the same event.
    #[error(
        "the response comes {:.1} ± {:.1} ms after the drive, {} of a segment: the magnitude is underestimated; use longer segments; align the \
            channels",
        delay_s * 1e3,
        ci_half_width_s * 1e3,
        percent(delay_s / segment_s)
    )]
    LateResponse {
        delay_s: f64,
        segment_s: f64,
        ci_half_width_s: f64,
    },
    /// The response comes before the drive.
    #[error(
        "the response comes {:.2} ± {:.2} ms before the drive, which is impossible: drive and response are swapped, or their channels are out of \
            step; check whether drive and response are swapped, or their channels out of step",
        lead_s * 1e3,
        ci_half_width_s * 1e3
    )]
    Acausal { lead_s: f64, ci_half_width_s: f64 },
    /// Part of the band was not excited.
    #[error(
        "{} of the band ({}) is not excited: the transfer function has no meaning there; drive the whole band; narrow the band",
        percent(*share),
        list(bands)
    )]
    NotExcited { bands: Vec<Band>, share: f64 },
    /// A resonance that is narrower than segments of this length resolve.
    #[error(
        "the resonance at {at_hz:.1} Hz has {lines:.1} lines of {resolution_hz:.2} Hz within its half-power bandwidth, and 6 or more are needed: \
            its height is underestimated; use longer segments"
    )]
    UnresolvedResonance {
        at_hz: f64,
        lines: f64,
        resolution_hz: f64,
    },
    /// The device distorts.
    #[error(
        "distortion reaches {level_db:.0} dB of the response at {band_hz}: the transfer function is valid only for this level of drive; \
            characterise at the level that will be played"
    )]
    Nonlinear { level_db: f64, band_hz: Band },
    /// Drive and response are no more coherent than two unrelated signals.
    #[error(
        "the mean coherence of the excited lines is {coherence:.3}, and unrelated signals reach {limit:.3} with {averages:.0} averages: no relation \
            between drive and response is shown; check the channels and the sensor; measure longer"
    )]
    Unrelated {
        coherence: f64,
        limit: f64,
        averages: f64,
    },
    /// A stored transfer function that cannot be right as it is.
    #[error("{fault}; {}", fault.advice())]
    #[serde(rename = "stored_function_doubtful")]
    Stored {
        #[serde(flatten)]
        fault: StoredFault,
    },
    /// Drive and response are probably swapped.
    #[error("{by}: drive and response are probably swapped; exchange them")]
    #[serde(rename = "channels_swapped")]
    Swapped {
        #[serde(flatten)]
        by: Swapped,
    },
}

/// What shows that drive and response are swapped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "by", rename_all = "snake_case")]
pub enum Swapped {
    /// The drive has the unit of a response, and the response has the unit of a drive.
    #[error("the drive is in {drive} and the response in {response}")]
    Units { drive: String, response: String },
    /// The response consists of short pulses, and the drive does not.
    #[error("the response consists of {}, which look like the force of a hammer, and the drive does not", counted(*hits, "short pulse"))]
    Pulses { hits: usize },
}

/// What is wrong with a stored transfer function.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "fault", rename_all = "snake_case")]
pub enum StoredFault {
    /// A coherence outside 0–1, which no pair of signals can have.
    #[error(
        "coherence is {found:.3} at {at_hz:.1} Hz ({lines} lines in all), which is impossible for any pair of signals"
    )]
    Coherence {
        at_hz: f64,
        found: f64,
        lines: usize,
    },
    /// Every line is real and positive: the phase is missing.
    #[error(
        "all {lines} lines are real and positive: the phase is missing: rendered drives do not reproduce waveforms and begin before the texture"
    )]
    NoPhase { lines: usize },
    /// Limits that were stored do not follow from coherence and averages.
    #[error(
        "the limits stored with the transfer function are {ratio:.3} times those that follow from its coherence and averages: one of them was \
            changed after the measurement"
    )]
    Limits { ratio: f64 },
    /// A stored transfer function does not follow from the spectra stored beside it.
    #[error(
        "the stored transfer function and coherence do not follow from the stored spectra: errors up to {difference:.1e} (relative, at {at_hz:.1} \
            Hz) and {coherence_difference:.1e}; another method was used, or the file was changed"
    )]
    Spectra {
        difference: f64,
        at_hz: f64,
        coherence_difference: f64,
    },
}

impl StoredFault {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Coherence { .. } => {
                "leave these parts out, or ask the author of the program that exported it"
            }
            Self::NoPhase { .. } => {
                "ask the author of the program that exported it, or measure again"
            }
            Self::Limits { .. } => "check which value is correct, or measure again",
            Self::Spectra { .. } => "ask the author of the program that exported it",
        }
    }
}
