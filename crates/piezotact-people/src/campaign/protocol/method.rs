//! How the stimuli of a comparison are chosen, and the trials beside the counted ones.

use serde::{Deserialize, Serialize};

use super::super::adaptive::AdaptiveRule;

/// What a comparison asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Question {
    /// The same or different.
    SameDifferent,
    /// Which is rougher, the first or the second.
    Rougher,
    /// Which is stronger, the first or the second.
    Stronger,
}

impl Question {
    /// The two possible answers.
    #[must_use]
    pub fn choices(self) -> [&'static str; 2] {
        match self {
            Self::SameDifferent => ["same", "different"],
            Self::Rougher | Self::Stronger => ["first", "second"],
        }
    }
}

/// How the stimuli of a comparison are chosen.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "how", rename_all = "snake_case", deny_unknown_fields)]
pub enum Method {
    /// Constant stimuli: all pairs are planned.
    Constant {
        /// The pairs, each presented in both orders.
        pairs: Vec<[String; 2]>,
        /// How often each order of each pair is presented.
        repeats: u32,
    },
    /// A standard is compared with levels that follow from the answers so far.
    Adaptive(Adaptive),
}

/// An adaptive comparison: a standard, and stimuli with more of what is asked for than the standard.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Adaptive {
    /// The standard stimulus; its place, first or second, is drawn for each trial.
    pub standard: String,
    /// The comparison stimuli in the order of their increasing levels.
    pub levels: Vec<Level>,
    /// The rule that chooses among them.
    pub rule: AdaptiveRule,
    /// The largest standard deviation with which a threshold is decided, in the unit of the levels, above 0.
    pub largest_sd: f64,
}

impl Adaptive {
    /// The levels as numbers, in the unit of the rule.
    #[must_use]
    pub fn levels(&self) -> Vec<f64> {
        self.levels.iter().map(|level| level.level).collect()
    }
}

/// A comparison stimulus.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Level {
    /// The stimulus.
    pub stimulus: String,
    /// How far it is from the standard, in the unit of the rule, as a rule dB.
    pub level: f64,
}

/// Trials before the counted ones, once in a session. They are not analysed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Training {
    /// How many.
    pub trials: u32,
    /// Whether the right answer is shown after each.
    #[serde(default)]
    pub feedback: bool,
}

/// Trials whose answer is known and easy, at random places among the counted ones. They are counted apart.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Catch {
    /// How many beside the counted ones of each set, or of the task where it has no sets.
    pub trials: u32,
    /// The stimuli of a catch trial, one of these lists each time. For `same_different` a pair; for `rougher` and `stronger` a
    /// pair, the rougher or stronger one first, which is presented in random order; for associations a sequence within a set.
    pub known: Vec<Vec<String>>,
    /// How many wrong answers in a session raise no warning.
    pub failures_allowed: u32,
}
