//! Warnings about what was felt in confused pairs.

use serde::{Deserialize, Serialize};

/// One thing to know before relying on the comparison of confused textures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum FeltWarning {
    /// What was felt is not known.
    #[error("{why}; {}", why.advice())]
    #[serde(rename = "felt_not_known")]
    NotKnown {
        #[serde(flatten)]
        why: FeltUnknown,
    },
}

/// Why it is not known what was felt.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "why", rename_all = "snake_case")]
pub enum FeltUnknown {
    /// Textures of confused pairs without a recording, with the participant where there are several.
    #[error("{}: what was felt is not known, as there is no recording", samples.join(", "))]
    NoRecording { samples: Vec<String> },
    /// A recording that cannot be used.
    #[error("{sample}: what was felt is not known, as its recording cannot be used: {reason}")]
    Unusable { sample: String, reason: String },
    /// A pair that cannot be compared.
    #[error(
        "{pair}: what was felt is not known, as level and spectrum cannot be compared: {reason}"
    )]
    NotCompared { pair: String, reason: String },
    /// Answers of several participants beside one recording of each texture.
    #[error(
        "the answers of {participants} participants stand beside one recording of each texture, so that what each finger felt is not known"
    )]
    OneForAll { participants: usize },
    /// Recordings of people who gave none of the answers.
    #[error("{}: no answer that counts is theirs, so that their recordings are not used", people.join(", "))]
    OfOthers { people: Vec<String> },
}

impl FeltUnknown {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::NoRecording { .. } => "add a recording named as the sample",
            Self::Unusable { .. } => "record it again",
            Self::NotCompared { .. } => "give recordings that can be compared",
            Self::OneForAll { .. } => {
                "give the recordings of each participant in a folder named by the pseudonym"
            }
            Self::OfOthers { .. } => "check the pseudonyms of recordings and answers",
        }
    }
}
