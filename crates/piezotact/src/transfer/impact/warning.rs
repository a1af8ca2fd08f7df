//! Warnings about an impact test.

use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

use super::fault::HitFault;
use crate::number::{counted, digits};
use crate::warning::words::percent;

/// Warnings about an impact test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum ImpactWarning {
    /// A hit that was left out.
    #[error("the hit at {at_s:.3} s is not used: {fault}; {}", fault.advice())]
    HitNotUsed {
        at_s: f64,
        #[serde(flatten)]
        fault: HitFault,
    },
    /// A response that has not come to rest, or that a window brought to rest.
    #[error("{how}; {}", how.advice())]
    #[serde(rename = "response_not_decayed")]
    NotDecayed {
        #[serde(flatten)]
        how: NotDecayed,
    },
    /// Nothing states what a drive with short pulses is: it is evaluated as an impact test, or by segments.
    #[error("{}", match as_impact { true => as_impact_test(*hits, *share), false => by_segments(*hits, *share) })]
    PulsesInDrive {
        hits: usize,
        share: f64,
        as_impact: bool,
    },
    /// The baseline of the force or of the response drifts, and was subtracted.
    #[error(
        "the baseline drifts by up to {} of the {signal}'s peak and was subtracted; the lowest frequency lines are uncertain: check the channels \
            and the sensor",
        percent(*share)
    )]
    BaselineDrifts { signal: String, share: f64 },
}

/// A drive of short pulses that is evaluated as an impact test.
fn as_impact_test(hits: usize, share: f64) -> String {
    format!(
        "the drive is {} in {} of the recording: it is evaluated as an impact test; state what the drive is",
        counted(hits, "short pulse"),
        percent(share)
    )
}

/// A drive with short pulses that is evaluated by segments.
fn by_segments(hits: usize, share: f64) -> String {
    format!(
        "the drive contains {} with {} of its energy, and is evaluated by segments, which is wrong for hits of a hammer; evaluate it as an impact \
         test, or leave these parts out",
        counted(hits, "short pulse"),
        percent(share)
    )
}

/// How a response did not decay by itself.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "how", rename_all = "snake_case")]
pub enum NotDecayed {
    /// It is left at the end of the segment, and no window brings it down.
    #[error(
        "{} of the response{} is left at the end of the segment of {segment_s:.3} s: what lasts there is underestimated at its resonances, and \
            leaks into neighbouring lines",
        percent(*left),
        octave_hz.map_or_else(String::new, |[low, high]| format!(" between {low:.0} and {high:.0} Hz"))
    )]
    End {
        left: f64,
        octave_hz: Option<[f64; 2]>,
        segment_s: f64,
    },
    /// An exponential window added damping to every resonance.
    #[error(
        "an exponential window adds a damping of σ = {} 1/s to every resonance, whose half-power bandwidth is {} Hz wider and whose height is \
            lower: without it {} of the response would remain at the end of the segment",
        digits(*damping_per_s),
        digits(damping_per_s / PI),
        percent(*left)
    )]
    Window { damping_per_s: f64, left: f64 },
    /// It is left when the next hit comes, and the hits are used.
    #[error(
        "up to {} of the response to the hit before is left when {hits} of the hits come: the function scatters by as much from hit to hit",
        percent(*share)
    )]
    Before { hits: usize, share: f64 },
}

impl NotDecayed {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::End { .. } => "record longer, or use an exponential window",
            Self::Window { .. } => {
                "subtract it from the damping of every resonance, or record longer"
            }
            Self::Before { .. } => "hit again only after the response has come to rest",
        }
    }
}
