//! What prepared drives leave open.

use serde::{Deserialize, Serialize};

/// What prepared drives leave open.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum PrepareWarning {
    /// Textures were rendered at different levels relative to their strokes.
    #[error(
        "the textures were rendered at different levels, {lowest_db:+.1} to {highest_db:+.1} dB: differences in level between them are not those of \
            the samples; lower the level"
    )]
    LevelsDiffer { lowest_db: f64, highest_db: f64 },
}
