//! What prepared drives leave open.

use crate::number::rounded;
use serde::{Deserialize, Serialize};

/// What prepared drives leave open.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum PrepareWarning {
    /// A texture with one stroke: whether it is typical is not known.
    #[error("there is only one stroke: whether it is typical is not known; record 3 or more")]
    #[serde(rename = "one_stroke_of_texture")]
    OneStroke { texture: String },
    /// The strokes of a texture differ widely.
    #[error(
        "the strokes differ by {spread_db:.1} dB rms from their median in third octaves; the one that is rendered is the closest to it, and others \
            feel different: check the rejected parts in the report; cut the strokes by hand"
    )]
    StrokesDiffer { texture: String, spread_db: f64 },
    /// The stroke that stands for a texture is short.
    #[error(
        "the stroke that is rendered lasts only {duration_s:.2} s; its low frequencies are a few periods: use a longer stroke, or one with the \
            gesture filtered out"
    )]
    ShortStroke { texture: String, duration_s: f64 },
    /// Strokes of one texture were recorded under different conditions.
    #[error(
        "strokes of different {what} ({values}) count as one texture: the one that is rendered is typical of none of them; give recordings that \
            differ only in the compared factor"
    )]
    #[serde(rename = "conditions_of_texture_differ")]
    ConditionsDiffer {
        texture: String,
        what: String,
        values: String,
    },
    /// The strokes were made at another load than the transfer function.
    #[error(
        "the strokes were made at {} N, the transfer function was measured at {} N: repeat while holding the stated force",
        rounded(*strokes_n),
        rounded(*transfer_n)
    )]
    #[serde(rename = "strokes_at_other_load")]
    OtherLoad {
        texture: String,
        strokes_n: f64,
        transfer_n: f64,
    },
    /// Textures were rendered at different levels re their strokes.
    #[error(
        "the textures were rendered at different levels, {lowest_db:+.1} to {highest_db:+.1} dB: differences in level between them are not those of \
            the samples; lower the level"
    )]
    LevelsDiffer { lowest_db: f64, highest_db: f64 },
}
