//! What prepared drives leave open.

use std::fmt;

use crate::number::rounded;
use crate::warning::{Advice, Subject, WarningKind, warnings};

warnings! {
    /// What prepared drives leave open.
    pub enum PrepareWarning {
        /// A texture with one stroke: whether it is typical is not known.
        OneStroke("one_stroke_of_texture") of Group(texture) {
            /// The texture.
            texture: String,
        },
        /// The strokes of a texture differ widely.
        StrokesDiffer("strokes_differ") of Group(texture) {
            /// The texture.
            texture: String,
            /// Their median distance from the median stroke, dB.
            spread_db: f64,
        },
        /// The stroke that stands for a texture is short.
        ShortStroke("short_stroke") of Group(texture) {
            /// The texture.
            texture: String,
            /// Its duration, s.
            duration_s: f64,
        },
        /// Strokes of one texture were recorded under different conditions.
        ConditionsDiffer("conditions_of_texture_differ") of Group(texture) {
            /// The texture.
            texture: String,
            /// What differs: touch, direction, speed, load.
            what: String,
            /// The values.
            values: String,
        },
        /// The strokes were made at another load than the transfer function.
        OtherLoad("strokes_at_other_load") of Group(texture) {
            /// The texture.
            texture: String,
            /// The load of the strokes, N.
            strokes_n: f64,
            /// That of the transfer function, N.
            transfer_n: f64,
        },
        /// Textures were rendered at different levels re their strokes.
        LevelsDiffer("levels_differ") {
            /// The lowest level, dB.
            lowest_db: f64,
            /// The highest level, dB.
            highest_db: f64,
        },
    }
}

impl WarningKind for PrepareWarning {
    fn of(warning: &crate::Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        match self {
            Self::OneStroke { .. } => vec![Advice::RecordMore { count: 3 }],
            Self::StrokesDiffer { .. } => vec![Advice::Check(Subject::Strokes), Advice::CutByHand],
            Self::ShortStroke { .. } => vec![Advice::LongerStroke],
            Self::ConditionsDiffer { .. } => vec![Advice::CompareLike],
            Self::OtherLoad { .. } => vec![Advice::HoldForce],
            Self::LevelsDiffer { .. } => vec![Advice::LowerLevel { to_db: None }],
        }
    }
}

impl fmt::Display for PrepareWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OneStroke { .. } => {
                write!(
                    f,
                    "there is only one stroke: whether it is typical is not known"
                )
            }
            Self::StrokesDiffer { spread_db, .. } => write!(
                f,
                "the strokes differ by {spread_db:.1} dB rms from their median in third octaves; the one that is rendered is the \
                 closest to it, and others feel different"
            ),
            Self::ShortStroke { duration_s, .. } => write!(
                f,
                "the stroke that is rendered lasts only {duration_s:.2} s; its low frequencies are a few periods"
            ),
            Self::ConditionsDiffer { what, values, .. } => write!(
                f,
                "strokes of different {what} ({values}) count as one texture: the one that is rendered is typical of none of them"
            ),
            Self::OtherLoad {
                strokes_n,
                transfer_n,
                ..
            } => write!(
                f,
                "the strokes were made at {} N, the transfer function was measured at {} N",
                rounded(*strokes_n),
                rounded(*transfer_n)
            ),
            Self::LevelsDiffer {
                lowest_db,
                highest_db,
            } => write!(
                f,
                "the textures were rendered at different levels, {lowest_db:+.1} to {highest_db:+.1} dB: differences in level \
                 between them are not those of the samples"
            ),
        }
    }
}
