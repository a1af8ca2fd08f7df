//! Warnings about what was felt in confused pairs.

use serde::{Deserialize, Serialize};

/// One thing to know before relying on the comparison of confused textures.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum FeltWarning {
    /// Textures of confused pairs without a recording, with the participant where there are several.
    #[error("no recording of {}: what was felt in their pairs is not known; add a recording named as the sample", samples.join(", "))]
    #[serde(rename = "felt_not_recorded")]
    NotRecorded { samples: Vec<String> },
    /// A recording that cannot be used.
    #[error("the recording of {sample} is not used: {reason}")]
    #[serde(rename = "felt_not_used")]
    NotUsed { sample: String, reason: String },
    /// A pair that cannot be compared.
    #[error("{pair}: level and spectrum are not compared: {reason}")]
    #[serde(rename = "felt_not_compared")]
    NotCompared { pair: String, reason: String },
    /// Answers of several participants beside one recording of each texture.
    #[error(
        "the answers of {participants} participants stand beside one recording of each texture: what each finger felt is not known; give the \
            recordings of each participant in a folder named by the pseudonym"
    )]
    #[serde(rename = "felt_one_for_all")]
    OneForAll { participants: usize },
    /// Recordings of people who gave none of the answers.
    #[error("recordings of {} are not used: no answer that counts is theirs", people.join(", "))]
    #[serde(rename = "felt_of_others")]
    OfOthers { people: Vec<String> },
}
