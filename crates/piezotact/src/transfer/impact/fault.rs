//! Why a hit is not used.

use std::fmt;

use serde::{Deserialize, Serialize};

use crate::warning::words::percent;
use crate::warning::{Advice, Subject};

/// Why a hit is not used.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "fault", rename_all = "snake_case")]
pub enum HitFault {
    /// The hammer hit twice.
    Double {
        /// How much later the second pulse begins, s.
        after_s: f64,
        /// Its peak re that of the larger one, 0–1.
        share: f64,
    },
    /// The pulse of the force is cut off at a limit.
    ForceOverload {
        /// The samples at the limit.
        samples: usize,
    },
    /// The response is cut off at a limit.
    ResponseOverload {
        /// The samples at the limit.
        samples: usize,
    },
    /// The next hit comes before the end of the segment, or before the response has decayed.
    NextTooClose {
        /// How long after this one it comes, s.
        after_s: f64,
        /// How long a hit has to last, s.
        needed_s: f64,
    },
    /// The recording ends before the segment, or before the response has decayed.
    AtTheEnd {
        /// How much of the recording is left after the hit, s.
        left_s: f64,
        /// How long a hit has to last, s.
        needed_s: f64,
    },
    /// The recording begins within the hit.
    AtTheBeginning,
    /// The response moves already when the hit comes: that to the hit before, or to something else.
    StillMoving {
        /// Its level re its largest after the hit, 0–1.
        share: f64,
    },
    /// The response begins before the hit.
    ResponseFirst {
        /// How much before, s.
        lead_s: f64,
    },
    /// The force has the opposite sign of that of the other hits.
    Opposite,
    /// The response does not stand out of its noise.
    NoResponse,
    /// Samples were lost within its segment.
    LostSamples,
    /// The response stops while it moves, as when a cable has no contact.
    ResponseStops {
        /// How long after the hit, s.
        after_s: f64,
        /// For how long, s.
        lasts_s: f64,
    },
}

impl HitFault {
    /// What a person can do.
    pub(super) fn advice(self) -> Vec<Advice> {
        match self {
            Self::Double { .. } | Self::LostSamples => vec![Advice::MeasureAgain],
            Self::ResponseStops { .. } => vec![Advice::Check(Subject::CableAndRange)],
            Self::ForceOverload { .. } | Self::ResponseOverload { .. } => {
                vec![Advice::Check(Subject::CableAndRange), Advice::MeasureAgain]
            }
            Self::NextTooClose { .. } | Self::StillMoving { .. } => vec![Advice::HitLater],
            Self::AtTheEnd { .. } => vec![Advice::RecordLonger, Advice::ExponentialWindow],
            Self::AtTheBeginning => vec![Advice::RecordBeforeHit],
            Self::ResponseFirst { .. } => vec![Advice::Check(Subject::Channels)],
            Self::Opposite => vec![Advice::Check(Subject::Polarity)],
            Self::NoResponse => vec![Advice::Check(Subject::ChannelsAndSensor)],
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

impl fmt::Display for HitFault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Double { after_s, share } => write!(
                f,
                "double hit, a second pulse of {} of the larger one {} later",
                percent(*share),
                time(*after_s)
            ),
            Self::ForceOverload { samples } => {
                write!(f, "force overloaded, {samples} samples at a limit")
            }
            Self::ResponseOverload { samples } => {
                write!(f, "response overloaded, {samples} samples at a limit")
            }
            Self::NextTooClose { after_s, needed_s } => write!(
                f,
                "the next hit comes {} later, {} are needed for the response to decay",
                time(*after_s),
                time(*needed_s)
            ),
            Self::AtTheEnd { left_s, needed_s } => write!(
                f,
                "the recording ends {} later, {} are needed for the response to decay",
                time(*left_s),
                time(*needed_s)
            ),
            Self::AtTheBeginning => f.write_str("the recording begins within the pulse"),
            Self::StillMoving { share } => write!(
                f,
                "the response has not come to rest when the hit comes, {} of its largest level remain",
                percent(*share)
            ),
            Self::ResponseFirst { lead_s } => {
                write!(f, "the response begins {} before the hit", time(*lead_s))
            }
            Self::Opposite => {
                f.write_str("the force has the opposite sign of that of the other hits")
            }
            Self::NoResponse => f.write_str("the response does not stand out of its noise"),
            Self::LostSamples => f.write_str("samples were lost"),
            Self::ResponseStops { after_s, lasts_s } => write!(
                f,
                "the response drops out {} after the hit, for {}",
                time(*after_s),
                time(*lasts_s)
            ),
        }
    }
}
