//! Warnings that arise from segmentation into strokes.

use crate::number::rounded;
use crate::warning::Counts;
use serde::{Deserialize, Serialize};

/// Warnings about the segmentation into strokes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum StrokeWarning {
    /// No channel says where strokes are: the whole recording is taken as one.
    #[error(
        "no channel of force or speed was recorded: the whole recording is analysed as one stroke; cut the strokes by hand"
    )]
    NothingCut,
    /// Nothing touches in a recording.
    #[error(
        "no stroke: the force rises by {largest_n:.3} N at most and a contact needs {threshold_n} N; check the force channel; state the load",
        threshold_n = rounded(*threshold_n)
    )]
    NoContact { largest_n: f64, threshold_n: f64 },
    /// Neither vibration nor friction says whether the finger slides.
    #[error(
        "every contact is analysed as a stroke: hesitations and stick-slip are not detected (because vibration and tangential force are missing, or \
            as requested)"
    )]
    SlidingAssumed,
    /// No force says whether the finger touches.
    #[error(
        "no normal force was recorded: the finger is assumed to touch whenever the surface moves; measure the force together with the acceleration"
    )]
    ContactAssumed,
    /// A stroke much longer than others: maybe two.
    #[error(
        "the stroke at {at_s:.2} s lasts {length_s:.1} s, a typical one {usual_s:.1} s: it may be two strokes, or a movement back and forth without \
            lifting the finger; cut the strokes by hand"
    )]
    LongStroke {
        at_s: f64,
        length_s: f64,
        usual_s: f64,
    },
    /// Parts of a recording that looked like strokes were rejected.
    #[error(
        "{count} of {of} parts that looked like strokes were rejected ({}): check the rejected parts in the report; cut the strokes by hand",
        reasons.text(&|code| match code {
        "stick_slip" => "stick-slip".into(),
        "interrupted" => "interrupted sliding".into(),
        "reversed" => "reversed direction".into(),
        "cut_by_recording" => "cut by the recording's end".into(),
        "by_person" => "excluded by hand".into(),
        other => other.replace('_', " "),
        })
    )]
    Rejected {
        count: usize,
        of: usize,
        reasons: Counts,
    },
}
