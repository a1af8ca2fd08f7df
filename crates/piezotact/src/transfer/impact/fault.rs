//! Why a hit is not used.

use serde::{Deserialize, Serialize};

use crate::warning::words::percent;

/// Why a hit is not used.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "fault", rename_all = "snake_case")]
pub enum HitFault {
    /// The hammer hit twice.
    #[error("double hit, a second pulse of {} of the larger one {} later", percent(*share), time(*after_s))]
    Double {
        /// How much later the second pulse begins, s.
        after_s: f64,
        /// Its peak re that of the larger one, 0–1.
        share: f64,
    },
    /// The pulse of the force is cut off at a limit.
    #[error("force overloaded, {samples} samples at a limit")]
    ForceOverload {
        /// The samples at the limit.
        samples: usize,
    },
    /// The response is cut off at a limit.
    #[error("response overloaded, {samples} samples at a limit")]
    ResponseOverload {
        /// The samples at the limit.
        samples: usize,
    },
    /// The next hit comes before the end of the segment, or before the response has decayed.
    #[error("the next hit comes {} later, {} are needed for the response to decay", time(*after_s), time(*needed_s))]
    NextTooClose {
        /// How long after this one it comes, s.
        after_s: f64,
        /// How long a hit has to last, s.
        needed_s: f64,
    },
    /// The recording ends before the segment, or before the response has decayed.
    #[error("the recording ends {} later, {} are needed for the response to decay", time(*left_s), time(*needed_s))]
    AtTheEnd {
        /// How much of the recording is left after the hit, s.
        left_s: f64,
        /// How long a hit has to last, s.
        needed_s: f64,
    },
    /// The recording begins within the hit.
    #[error("the recording begins within the pulse")]
    AtTheBeginning,
    /// The response moves already when the hit comes: that to the hit before, or to something else.
    #[error("the response has not come to rest when the hit comes, {} of its largest level remain", percent(*share))]
    StillMoving {
        /// Its level re its largest after the hit, 0–1.
        share: f64,
    },
    /// The response begins before the hit.
    #[error("the response begins {} before the hit", time(*lead_s))]
    ResponseFirst {
        /// How much before, s.
        lead_s: f64,
    },
    /// The force has the opposite sign of that of the other hits.
    #[error("the force has the opposite sign of that of the other hits")]
    Opposite,
    /// The response does not stand out of its noise.
    #[error("the response does not stand out of its noise")]
    NoResponse,
    /// Samples were lost within its segment.
    #[error("samples were lost")]
    LostSamples,
    /// The response stops while it moves, as when a cable has no contact.
    #[error("the response drops out {} after the hit, for {}", time(*after_s), time(*lasts_s))]
    ResponseStops {
        /// How long after the hit, s.
        after_s: f64,
        /// For how long, s.
        lasts_s: f64,
    },
}

impl HitFault {
    /// What a person can do.
    pub(in crate::transfer) fn advice(self) -> &'static str {
        match self {
            Self::Double { .. } | Self::LostSamples => "measure again",
            Self::ResponseStops { .. } => "check its cable and its range",
            Self::ForceOverload { .. } | Self::ResponseOverload { .. } => {
                "check its cable and its range; measure again"
            }
            Self::NextTooClose { .. } | Self::StillMoving { .. } => {
                "hit again only after the response has come to rest"
            }
            Self::AtTheEnd { .. } => "record longer; use an exponential window",
            Self::AtTheBeginning => "begin to record before the hit",
            Self::ResponseFirst { .. } => {
                "check whether drive and response are swapped, or their channels out of step"
            }
            Self::Opposite => "check the polarity of the sensors and the actuator",
            Self::NoResponse => "check the channels and the sensor",
        }
    }
}

/// A time as text.
fn time(seconds: f64) -> String {
    if seconds < 1.0 {
        format!("{:.1} ms", seconds * 1e3)
    } else {
        format!("{seconds:.2} s")
    }
}
