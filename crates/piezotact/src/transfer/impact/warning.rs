//! Warnings about an impact test.

use serde::{Deserialize, Serialize};
use std::f64::consts::PI;

use super::fault::HitFault;
use crate::number::digits;
use crate::warning::words::percent;

/// Warnings about an impact test.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum ImpactWarning {
    /// Nothing states that the drive is an impact: it was found to consist of short pulses.
    #[error(
        "the drive is {hits} short pulse{} in {} of the recording: it is evaluated as an impact test; state what the drive is",
        if *hits == 1 { "" } else { "s" },
        percent(*share)
    )]
    TakenAsImpact { hits: usize, share: f64 },
    /// An exponential window added damping to every resonance.
    #[error(
        "an exponential window adds a damping of σ = {} 1/s to every resonance, whose half-power bandwidth is {} Hz wider and whose height is \
            lower: without it {} of the response would remain at the end of the segment; subtract it from the damping of every resonance; record \
            longer",
        digits(*damping_per_s),
        digits(damping_per_s / PI),
        percent(*left)
    )]
    AddedDamping { damping_per_s: f64, left: f64 },
    /// The response has not decayed at the end of the segment, and no window brings it down.
    #[error(
        "{} of the response{} is left at the end of the segment of {segment_s:.3} s: what lasts there is underestimated at its resonances, and \
            leaks into neighbouring lines; record longer; use an exponential window",
        percent(*left),
        octave_hz.map_or_else(String::new, |[low, high]| format!(" between {low:.0} and {high:.0} Hz"))
    )]
    #[serde(rename = "response_not_decayed")]
    NotDecayed {
        left: f64,
        octave_hz: Option<[f64; 2]>,
        segment_s: f64,
    },
    /// A hit that was left out.
    #[error("the hit at {at_s:.3} s is not used: {fault}; {}", fault.advice())]
    HitNotUsed {
        at_s: f64,
        #[serde(flatten)]
        fault: HitFault,
    },
    /// The response to the hit before has not come to rest, and the hits are used.
    #[error(
        "up to {} of the response to the hit before is left when {hits} of the hits come: the function scatters by as much from hit to hit; hit \
            again only after the response has come to rest",
        percent(*share)
    )]
    EarlierResponse { hits: usize, share: f64 },
    /// The response consists of short pulses, and the drive does not.
    #[error(
        "the response consists of {hits} short pulse{}, which the drive does not: they look like the force of a hammer; exchange drive and response",
        if *hits == 1 { "" } else { "s" }
    )]
    PulsesInResponse { hits: usize },
    /// The baseline of the response drifts, and was subtracted.
    #[error(
        "the baseline of the response drifts by up to {} of its largest value; it was subtracted, and the lowest lines are uncertain: check the \
            channels and the sensor",
        percent(*share)
    )]
    ResponseDrifts { share: f64 },
    /// A drive that is averaged by segments contains short pulses.
    #[error(
        "the drive contains {hits} short pulse{} with {} of its energy: if {} of a hammer, an average by segments weights each by where it lies and \
            is wrong by any amount; if not, it is a disturbance; evaluate it as an impact test; leave these parts out",
        if *hits == 1 { "" } else { "s" },
        percent(*energy),
        if *hits == 1 { "it is a hit" } else { "they are hits" }
    )]
    PulsesInDrive { hits: usize, energy: f64 },
    /// The baseline of the force drifts, and was subtracted.
    #[error("the baseline of the force drifts by up to {} of the largest hit; it was subtracted: check the force channel", percent(*share))]
    ForceDrifts { share: f64 },
}
