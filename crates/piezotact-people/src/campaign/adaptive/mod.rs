//! Adaptive methods: which level comes next follows from the answers so far.
//!
//! Both are functions of rule and answers alone; nothing is drawn. Levels are in the unit of the rule, as a rule dB.

mod quest;
mod run;
mod staircase;

use serde::{Deserialize, Serialize};

pub use quest::{QuestEstimate, QuestPlus, QuestRule, weibull};
pub use run::{AdaptiveRule, AdaptiveRun, GUESS_SHARE, ThresholdCriterion, ThresholdEstimate};
pub use staircase::{Staircase, StaircaseEstimate, StaircaseRule, Start};

/// A rule that cannot be followed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{rule}: {what} must be {expected}, found {found}")]
pub struct AdaptiveRuleError {
    rule: &'static str,
    what: &'static str,
    expected: &'static str,
    found: f64,
}

/// Whether an answer was correct; for a task without a right answer: whether it was "yes".
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Response {
    /// Correct, or "yes".
    Correct,
    /// Wrong, or "no".
    Wrong,
}
