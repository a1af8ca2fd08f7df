//! Warnings about what was felt in confused pairs.

use std::fmt;

use piezotact::Warning;
use piezotact::warning::{Advice, FieldValue, WarningKind};

/// One thing to know before relying on the comparison of confused textures.
#[derive(Clone, Debug, PartialEq)]
pub enum FeltWarning {
    /// Textures of confused pairs without a recording.
    NotRecorded {
        /// Their names, with the participant where there are several.
        samples: Vec<String>,
    },
    /// A recording that cannot be used.
    NotUsed {
        /// The texture, with the participant where there are several.
        sample: String,
        reason: String,
    },
    /// A pair that cannot be compared.
    NotCompared {
        /// The pair, with the participant where there are several.
        pair: String,
        reason: String,
    },
    /// Answers of several participants beside one recording of each texture.
    OneForAll { participants: usize },
    /// Recordings of people who gave none of the answers.
    OfOthers { people: Vec<String> },
}

const NOT_RECORDED: &str = "felt_not_recorded";
const NOT_USED: &str = "felt_not_used";
const NOT_COMPARED: &str = "felt_not_compared";
const ONE_FOR_ALL: &str = "felt_one_for_all";
const OF_OTHERS: &str = "felt_of_others";

impl From<FeltWarning> for Warning {
    fn from(kind: FeltWarning) -> Self {
        use FeltWarning as Kind;
        let (code, fields) = match kind {
            Kind::NotRecorded { samples } => {
                (NOT_RECORDED, vec![("samples", samples.into_value())])
            }
            Kind::NotUsed { sample, reason } => (
                NOT_USED,
                vec![
                    ("sample", sample.into_value()),
                    ("reason", reason.into_value()),
                ],
            ),
            Kind::NotCompared { pair, reason } => (
                NOT_COMPARED,
                vec![("pair", pair.into_value()), ("reason", reason.into_value())],
            ),
            Kind::OneForAll { participants } => (
                ONE_FOR_ALL,
                vec![("participants", participants.into_value())],
            ),
            Kind::OfOthers { people } => (OF_OTHERS, vec![("people", people.into_value())]),
        };
        Self::of_fields(code, fields, None, Vec::new())
    }
}

impl WarningKind for FeltWarning {
    fn of(warning: &Warning) -> Option<Self> {
        Some(match warning.code.as_ref() {
            NOT_RECORDED => Self::NotRecorded {
                samples: warning.field("samples", None)?,
            },
            NOT_USED => Self::NotUsed {
                sample: warning.field("sample", None)?,
                reason: warning.field("reason", None)?,
            },
            NOT_COMPARED => Self::NotCompared {
                pair: warning.field("pair", None)?,
                reason: warning.field("reason", None)?,
            },
            ONE_FOR_ALL => Self::OneForAll {
                participants: warning.field("participants", None)?,
            },
            OF_OTHERS => Self::OfOthers {
                people: warning.field("people", None)?,
            },
            _ => return None,
        })
    }

    fn advice(&self) -> Vec<Advice> {
        Vec::new()
    }
}

impl fmt::Display for FeltWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotRecorded { samples } => write!(
                f,
                "no recording of {}: what was felt in their pairs is not known; add a recording named as the sample",
                samples.join(", ")
            ),
            Self::NotUsed { sample, reason } => {
                write!(f, "the recording of {sample} is not used: {reason}")
            }
            Self::NotCompared { pair, reason } => {
                write!(f, "{pair}: level and spectrum are not compared: {reason}")
            }
            Self::OneForAll { participants } => write!(
                f,
                "the answers of {participants} participants stand beside one recording of each texture: what each finger felt is not \
                    known; give the recordings of each participant in a folder named by the pseudonym"
            ),
            Self::OfOthers { people } => write!(
                f,
                "recordings of {} are not used: no answer that counts is theirs",
                people.join(", ")
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_warning_comes_back() {
        for kind in [
            FeltWarning::NotRecorded {
                samples: vec!["S1".into(), "S2".into()],
            },
            FeltWarning::NotUsed {
                sample: "S1".into(),
                reason: "empty".into(),
            },
            FeltWarning::NotCompared {
                pair: "S1 – S2".into(),
                reason: "too short".into(),
            },
            FeltWarning::OneForAll { participants: 3 },
            FeltWarning::OfOthers {
                people: vec!["P9".into()],
            },
        ] {
            assert_eq!(Warning::from(kind.clone()).kind(), Some(kind));
        }
    }
}
