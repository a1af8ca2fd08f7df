//! What makes a part of a recording a stroke, as criteria.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::{Interval, Reason, Rejected, Stroke};
use crate::criterion::{Criterion, Limit, Outcome};

/// What is looked at to tell a stroke from what is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
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
    /// How often the finger turns back.
    Turns,
    /// The share of samples at a limit, 0–1.
    ClippedShare,
    /// The level of the vibration, as a share of the usual one of the recording.
    VibrationShare,
    /// The largest force, N.
    LargestForce,
    /// The mean force less the one that was asked for, N.
    ForceDeviation,
    /// The share of the time in which something touches, 0–1.
    TouchShare,
    /// How often a person left it out.
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
            Self::Gaps => "moments off the surface",
            Self::SlipRate => "rate of slips",
            Self::SlidingParts => "sliding parts",
            Self::Turns => "turns back",
            Self::ClippedShare => "share of samples at a limit",
            Self::VibrationShare => "vibration re the usual one",
            Self::LargestForce => "largest force",
            Self::ForceDeviation => "mean force less the one asked for",
            Self::TouchShare => "share of time in contact",
            Self::LeftOut => "left out by a person",
        })
    }
}

/// What was judged of one part of a recording, rule by rule, until one is not met.
#[derive(Clone, Debug, Default)]
pub(super) struct JudgedPart(Vec<Criterion<StrokeCriterion>>);

impl JudgedPart {
    /// Judges `found`, and keeps it in place of what was judged of the same before; `reason` where it is not met.
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

    /// What is not met, whatever was judged before.
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
