//! What noise leaves open, in fields and in words.

use serde::{Deserialize, Serialize};

/// What noise leaves open.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum NoiseWarning {
    /// Something moved.
    #[error(
        "`{channel}` was not at rest: knocks, strokes or changes of level are in the recording, and its numbers are not those of the sensor's \
            noise; record again"
    )]
    NotAtRest { channel: String },
    /// Something may have moved.
    #[error("the recording does not show whether `{channel}` was at rest: record again")]
    PerhapsNotAtRest { channel: String },
}
