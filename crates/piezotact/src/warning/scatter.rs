//! The warning that repeats, strokes or participants differ more than usual.

use serde::{Deserialize, Serialize};

use super::Example;
use super::words::percent;
use crate::quantity::Band;

/// Warnings about what differs more than usual.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum ScatterWarning {
    /// Things that should be alike differ more than usual.
    #[error("{of}; {}", of.advice())]
    Scatter {
        #[serde(flatten)]
        of: Scatter,
    },
}

/// What differs more than usual.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "of", rename_all = "snake_case")]
pub enum Scatter {
    /// Strokes of a group.
    #[error(
        "{group}: the rms of the strokes varies by {} of its mean, far more than usual for strokes of one texture",
        percent(*share)
    )]
    Strokes { group: String, share: f64 },
    /// Strokes of a recording, in their order.
    #[error(
        "{what} from the first to the last third of the strokes of a recording{}",
        if *after > 0 { format!(", at once after stroke {after}") } else { String::new() }
    )]
    OverStrokes {
        what: OverStrokes,
        /// The number of strokes before a step; 0 where the change is gradual.
        after: usize,
    },
    /// Repeats of one measurement.
    #[error(
        "repeats differ by up to {db_rms:.1} dB rms: the finger moved or its force changed, or a repeat is from another participant"
    )]
    Repeats { db_rms: f64 },
    /// Repeats of one participant, which differ as much as measurements of different people.
    #[error(
        "{kind} of {participant} differ by up to {db_rms:.1} dB rms, typically by {usual_db_rms:.1} dB: they may be from different participants, or \
            the sensor became loose"
    )]
    RepeatsOfParticipant {
        kind: String,
        participant: String,
        db_rms: f64,
        usual_db_rms: f64,
    },
    /// The transfer function of a participant.
    #[error(
        "{participant} at {at} differs from the mean curve by {db_rms:.1} dB rms, a typical participant by {usual_db_rms:.1} dB"
    )]
    Participant {
        participant: String,
        at: Example,
        db_rms: f64,
        usual_db_rms: f64,
    },
    /// Strokes of a texture.
    #[error(
        "the strokes differ by {spread_db:.1} dB rms from their median in third octaves; the one that is rendered is the closest to it, and others \
            feel different"
    )]
    StrokesOfTexture { texture: String, spread_db: f64 },
    /// Responses to hits.
    #[error(
        "the response to the hit{} at {} is not that to the others: up to {} of its energy differs from what they predict ({} for the median hit); \
            it is used all the same",
        if at_s.len() == 1 { "" } else { "s" },
        at_s.iter().map(|at_s| format!("{at_s:.3} s")).collect::<Vec<_>>().join(", "),
        percent(*share),
        percent(*usual)
    )]
    Hits {
        at_s: Vec<f64>,
        share: f64,
        usual: f64,
    },
    /// Recordings of one sample, which differ by more than their strokes: recordings are compared instead of strokes.
    #[error(
        "recordings of one sample may differ by more than their strokes do (p = {p_value:.3}): recordings are compared instead of strokes"
    )]
    Recordings { p_value: f64 },
    /// The response to a drive while it is measured.
    #[error(
        "over {} of the recording, from {from_s:.1} to {to_s:.1} s, the response to the drive is not that of the rest ({by_db:+.1} dB and {by_deg:+.0}° \
            in {band_hz}{}): the transfer function is a mean of both, and its limits do not hold for either",
        percent(*share),
        match force_n {
            Some([then_n, rest_n]) => format!("; normal force {then_n:.2} N, else {rest_n:.2} N"),
            None => String::new(),
        }
    )]
    Response {
        from_s: f64,
        to_s: f64,
        share: f64,
        band_hz: Band,
        by_db: f64,
        by_deg: f64,
        force_n: Option<[f64; 2]>,
    },
    /// Levels within a recording, which wander by more than noise does.
    #[error(
        "the level or the spectrum varies within a recording by more than stationary noise would: the 95 % limits are computed from the differences \
            between its parts, and later recordings may differ more"
    )]
    Parts,
}

/// What follows the order of strokes.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(rename_all = "snake_case")]
pub enum OverStrokes {
    /// The level.
    #[error("the level of the vibration changes by {} dB", crate::number::signed(*change_db, 1))]
    Level { change_db: f64 },
    /// The coefficient of friction.
    #[error("the coefficient of friction changes by {} %", crate::number::signed(100.0 * share, 0))]
    Friction { share: f64 },
}

impl Scatter {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::OverStrokes { .. } => {
                "check whether the sensor came loose, or the skin, the force or the speed changed"
            }
            Self::Strokes { .. } => "check whether the sensor is loose or the conditions differ",
            Self::Repeats { .. } => "measure again",
            Self::RepeatsOfParticipant { .. } | Self::Participant { .. } => {
                "check sensor, placement and person, and measure again"
            }
            Self::StrokesOfTexture { .. } => {
                "check the rejected parts in the report, and cut the strokes by hand"
            }
            Self::Hits { .. } => {
                "check that all hits were at one point in one direction, and that nothing moved between them"
            }
            Self::Response { .. } => {
                "check whether the finger lifted or moved, or the sensor is loose, and measure again"
            }
            Self::Recordings { .. } | Self::Parts => "record each sample several times",
        }
    }
}
