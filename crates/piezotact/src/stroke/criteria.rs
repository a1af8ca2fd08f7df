//! The criteria that decide whether a part of a recording is a stroke.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::{Interval, Reason, Rejected, Stroke};
use crate::criterion::{Criterion, Limit, Outcome};

/// The quantities judged to accept or reject a stroke.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum StrokeCriterion {
    /// Ends of the contact that lie outside the recording.
    EndsOutside,
    /// The length of the steady part, s.
    SteadyPart,
    /// How often the finger leaves the surface.
    Gaps,
    /// The rate of sudden slips, Hz.
    SlipRate,
    /// Parts in which the finger slides.
    SlidingParts,
    /// The share of the time in which the speed is outside of its tolerance, 0–1.
    UnsteadyShare,
    /// The number of reversals of the finger's direction.
    Turns,
    /// The share of samples at a limit, 0–1.
    ClippedShare,
    /// The level of the vibration, as a share of the usual one of the recording.
    VibrationShare,
    /// The largest force, N.
    LargestForce,
    /// The mean force minus the target, N.
    ForceDeviation,
    /// The share of the time in contact, 0–1.
    TouchShare,
    /// The number of times a person excluded it.
    LeftOut,
}

impl StrokeCriterion {
    /// The unit of what is found; empty for a count or a share.
    #[must_use]
    pub fn unit(self) -> &'static str {
        match self {
            Self::SteadyPart => "s",
            Self::SlipRate => "Hz",
            Self::LargestForce | Self::ForceDeviation => "N",
            Self::EndsOutside
            | Self::Gaps
            | Self::SlidingParts
            | Self::UnsteadyShare
            | Self::Turns
            | Self::ClippedShare
            | Self::VibrationShare
            | Self::TouchShare
            | Self::LeftOut => "",
        }
    }
}

impl fmt::Display for StrokeCriterion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::EndsOutside => "ends outside the recording",
            Self::SteadyPart => "steady part",
            Self::Gaps => "losses of contact",
            Self::SlipRate => "slip rate",
            Self::SlidingParts => "sliding parts",
            Self::UnsteadyShare => "share of time outside of the speed's tolerance",
            Self::Turns => "reversals of direction",
            Self::ClippedShare => "share of samples at a limit",
            Self::VibrationShare => "vibration relative to a typical stroke",
            Self::LargestForce => "largest force",
            Self::ForceDeviation => "mean force minus requested force",
            Self::TouchShare => "share of time in contact",
            Self::LeftOut => "excluded by hand",
        })
    }
}

/// The criteria judged for one part of a recording, in order, until one is not met.
#[derive(Clone, Debug, Default)]
pub(super) struct JudgedPart(Vec<Criterion<StrokeCriterion>>);

impl JudgedPart {
    /// Evaluates the criterion on `found`, replacing an earlier evaluation of the same criterion; `reason` is returned if it is
    /// not met.
    pub(super) fn require(
        &mut self,
        what: StrokeCriterion,
        found: f64,
        limit: Limit,
        reason: impl FnOnce() -> Reason,
    ) -> Result<(), Reason> {
        let criterion = Criterion::new(what, what.unit(), found, None, limit);
        let outcome = criterion.outcome;
        self.0.retain(|before| before.what != what);
        self.0.push(criterion);
        match outcome {
            Outcome::NotMet => Err(reason()),
            Outcome::Met | Outcome::NotDecided => Ok(()),
        }
    }

    /// What was judged of a stroke before more is asked of it.
    pub(super) fn of(stroke: &Stroke) -> Self {
        Self(stroke.criteria.clone())
    }

    /// What was judged.
    pub(super) fn criteria(self) -> Vec<Criterion<StrokeCriterion>> {
        self.0
    }

    /// Rejects the part because of the criterion on `what`, which is not met, whatever was judged before.
    pub(super) fn not_met(
        mut self,
        what: StrokeCriterion,
        found: f64,
        limit: Limit,
        (interval, reason): (Interval, Reason),
    ) -> Rejected {
        self.0.push(Criterion {
            outcome: Outcome::NotMet,
            ..Criterion::new(what, what.unit(), found, None, limit)
        });
        self.rejects(interval, reason)
    }

    /// The part that is rejected by what was judged.
    pub(super) fn rejects(self, interval: Interval, reason: Reason) -> Rejected {
        Rejected {
            interval,
            reason,
            criteria: self.0,
        }
    }
}
