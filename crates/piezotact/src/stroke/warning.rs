//! Warnings that arise from segmentation into strokes.

use crate::number::rounded;
use crate::warning::Counts;
use serde::{Deserialize, Serialize};

/// Warnings about the segmentation into strokes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum StrokeWarning {
    /// Nothing touches in a recording.
    #[error(
        "no stroke: the force rises by {largest_n:.3} N at most and a contact needs {threshold_n} N; check the force channel; state the load",
        threshold_n = rounded(*threshold_n)
    )]
    NoContact { largest_n: f64, threshold_n: f64 },
    /// Parts of a recording that looked like strokes were rejected.
    #[error(
        "{count} of {of} parts that looked like strokes were rejected ({}): check the rejected parts in the report{}; cut the strokes by hand",
        reasons.text(&|code| match code {
        "stick_slip" => "stick-slip".into(),
        "interrupted" => "interrupted sliding".into(),
        "reversed" => "reversed direction".into(),
        "cut_by_recording" => "not recorded whole".into(),
        "by_person" => "excluded by hand".into(),
        other => other.replace('_', " "),
        }),
        advice(reasons)
    )]
    Rejected {
        count: usize,
        of: usize,
        reasons: Counts,
    },
    /// A stroke of unusual length.
    #[error("{what}; {}", what.advice())]
    UnusualStroke {
        #[serde(flatten)]
        what: Unusual,
    },
}

/// What helps against the reasons that a sensor or a drive makes.
fn advice(reasons: &Counts) -> String {
    let helps = |code: &str| match code {
        "sliding_unclear" => Some(
            "; keep noise and lines of a machine away from the vibration channel, or analyse every contact",
        ),
        "interrupted" => {
            Some("; record the position of a finger that moves back and forth without lifting")
        }
        "unsteady_speed" => Some("; steady the drive"),
        _ => None,
    };
    reasons.0.keys().filter_map(|code| helps(code)).collect()
}

/// What is unusual about the length of strokes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum Unusual {
    /// A stroke much longer than others: maybe two.
    #[error(
        "the stroke at {at_s:.2} s lasts {length_s:.1} s, a typical one {usual_s:.1} s: it may be two strokes, or a movement back and forth without \
            lifting the finger"
    )]
    Long {
        at_s: f64,
        length_s: f64,
        usual_s: f64,
    },
    /// Strokes too short for a spectrum with the lines of the others.
    #[error("{count} stroke(s) shorter than a segment of {needed_s:.3} s are left out")]
    LeftOut { count: usize, needed_s: f64 },
    /// The stroke that stands for a texture is short.
    #[error(
        "the rendered stroke lasts only {duration_s:.2} s and contains few periods of its low frequencies"
    )]
    Short { texture: String, duration_s: f64 },
}

impl Unusual {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Long { .. } => "cut the strokes by hand",
            Self::LeftOut { .. } => "use shorter segments",
            Self::Short { .. } => "use a longer stroke, or one with the gesture filtered out",
        }
    }
}
