//! What a score leaves open.

use crate::quantity::Band;
use crate::score::ScoreError;
use crate::verify::VerifyError;
use serde::{Deserialize, Serialize};

/// What a score of two vibrations leaves open.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum ScoreWarning {
    /// The short-time levels of two textures vary differently, which spectra do not show.
    #[error(
        "the spread of short-time levels is {reference_db:.1} dB in the reference and {test_db:.1} dB in the test: the level of one varies more \
            over time, or has more bursts; spectra and the score do not show this; compare them by hand"
    )]
    OtherModulation { reference_db: f64, test_db: f64 },
    /// A vibration below the detection threshold.
    #[error("{signal} is {:.1} dB below the detection threshold: it is not felt; check its unit and scale; raise the level", -level_db)]
    NotFelt { signal: String, level_db: f64 },
    /// An index of the literature that is not a real number for these signals.
    #[error(
        "ST-SIM has no value: the temporal similarity is {temporal:.3}, and a negative number has no real power 2/3 (vibromaf 0.0.8 gives a complex \
            one); use the score instead"
    )]
    NoRealIndex { temporal: f64 },
    /// An index of the literature above its range.
    #[error(
        "ST-SIM is {value:.3}, above its range of 0 to 1: the published formula does not cover a test that excites more than the reference; \
            exchange reference and test; use the score instead"
    )]
    IndexBeyondRange { value: f64 },
    /// The indices of the literature could not be computed.
    #[error("ST-SIM and SPQI are left out: {why}")]
    NoIndices { why: NoIndicesCause },
    /// Waveforms that were not compared.
    #[error("the waveforms are not compared: {why}")]
    WaveformNotCompared { why: NotComparedCause },
}

/// Why the indices of the literature could not be computed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum NoIndicesCause {
    /// There is not one block.
    #[error("{}", ScoreError::FewSamples { expected: *expected, found: *found })]
    TooShort { expected: usize, found: usize },
    /// No full scale.
    #[error("{}", ScoreError::NoFullScale { found: *found_m_s2 })]
    FullScale { found_m_s2: f64 },
    /// A cause in words, as of a rate that cannot be brought to 8 kHz.
    #[error("{text}")]
    Said { text: String },
}

/// Why waveforms were not compared.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum NotComparedCause {
    /// The rates differ.
    #[error("{}", VerifyError::Rate { target_hz: *target_hz, measured_hz: *measured_hz })]
    #[serde(rename = "rates_differ")]
    Rates { target_hz: f64, measured_hz: f64 },
    /// The band holds no line of the spectra.
    #[error("{}", VerifyError::NoLine { band: *band, resolution_hz: *resolution_hz })]
    NoLine { band: Band, resolution_hz: f64 },
    /// Too little in common.
    #[error("{}", VerifyError::TooShort { expected: *expected, found: *found })]
    TooShort { expected: usize, found: usize },
    /// A cause in words, as of a rate that cannot be converted.
    #[error("{text}")]
    Said { text: String },
}

impl From<ScoreError> for NoIndicesCause {
    fn from(error: ScoreError) -> Self {
        match error {
            ScoreError::FewSamples { expected, found } => Self::TooShort { expected, found },
            ScoreError::NoFullScale { found } => Self::FullScale { found_m_s2: found },
            other => Self::Said {
                text: other.to_string(),
            },
        }
    }
}

impl From<VerifyError> for NotComparedCause {
    fn from(error: VerifyError) -> Self {
        match error {
            VerifyError::Rate {
                target_hz,
                measured_hz,
            } => Self::Rates {
                target_hz,
                measured_hz,
            },
            VerifyError::NoLine {
                band,
                resolution_hz,
            } => Self::NoLine {
                band,
                resolution_hz,
            },
            VerifyError::TooShort { expected, found } => Self::TooShort { expected, found },
            other => Self::Said {
                text: other.to_string(),
            },
        }
    }
}
