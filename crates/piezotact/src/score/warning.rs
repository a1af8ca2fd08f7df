//! What a score leaves open.

use crate::quantity::Band;
use crate::score::ScoreError;
use crate::verify::VerifyError;
use serde::{Deserialize, Serialize};

/// What a score of two vibrations leaves open.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum ScoreWarning {
    /// A vibration below the detection threshold.
    #[error("{signal} is {:.1} dB below the detection threshold: it is not felt; check its unit and scale; raise the level", -level_db)]
    NotFelt { signal: String, level_db: f64 },
    /// Silence around a vibration that is no part of it.
    #[error(
        "{silence_s:.3} s of silence before and after {signal} are left out, and {kept_s:.3} s are scored; check that nothing that is felt was left out"
    )]
    SilenceExcluded {
        signal: String,
        silence_s: f64,
        kept_s: f64,
    },
    /// A recording of touch, of which the strokes alone are looked at.
    #[error(
        "{signal} is a recording of touch: {}, {sliding_s:.2} s of {whole_s:.2} s, are looked at, without landing, lift and rest; check \
            with `strokes` that these are the parts that slide",
        match strokes {
            1 => "its one stroke".to_owned(),
            count => format!("its {count} strokes"),
        }
    )]
    StrokesAlone {
        signal: String,
        strokes: usize,
        sliding_s: f64,
        whole_s: f64,
    },
    /// A value of a score that is not given, or is beyond its range.
    #[error("{what}; {}", what.advice())]
    NotComputed {
        #[serde(flatten)]
        what: NotComputed,
    },
}

/// What a score does not compute.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum NotComputed {
    /// An index of the literature that is not a real number for these signals.
    #[error(
        "ST-SIM is not given: its temporal similarity is {temporal:.3}, and a negative number has no real power 2/3"
    )]
    StSim { temporal: f64 },
    /// An index of the literature above its range.
    #[error(
        "ST-SIM is {value:.3}, above its range of 0 to 1: the published formula does not cover a test that excites more than the reference"
    )]
    StSimBeyondRange { value: f64 },
    /// The indices of the literature could not be computed.
    #[error("ST-SIM and SPQI are not given: {why}")]
    Indices { why: NoIndicesCause },
    /// Two recordings that are one.
    #[error(
        "reference and test have identical samples: a recording is compared with itself, and the score says nothing about two"
    )]
    TwoRecordings,
    /// Waveforms that were not compared.
    #[error("the waveforms are not compared: {why}")]
    Waveform { why: NotComparedCause },
}

impl NotComputed {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::StSimBeyondRange { .. } => {
                "exchange reference and test, or use the score instead"
            }
            Self::TwoRecordings => "give two recordings",
            Self::StSim { .. } | Self::Indices { .. } | Self::Waveform { .. } => {
                "use the score instead"
            }
        }
    }
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
