//! A campaign as its design sees it: plain data.

use serde::{Deserialize, Serialize};

use super::super::adaptive::AdaptiveRule;
use super::sequence::SequenceRule;

/// Which pairs the sets are meant to compare.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum PairsWanted {
    /// Every pair of the samples of the sets.
    All,
    /// Those that stand in the sets, and no others.
    WithinSets,
}

/// How declared orders are scored.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Scoring {
    /// By the matrix of samples and positions alone.
    ByPosition,
    /// By that matrix, with pairwise dominance and Kendall's τ beside it.
    ByPositionAndDominance,
}

/// What comparisons are to find.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "find", rename_all = "snake_case", deny_unknown_fields)]
pub enum CompareAim {
    /// The share of answers to each pair.
    Shares {
        /// How many pairs.
        pairs: usize,
    },
    /// The threshold of each participant.
    Threshold {
        /// The levels, in the unit of the rule.
        levels: Vec<f64>,
        /// The rule that chooses among them.
        rule: AdaptiveRule,
        /// The largest standard deviation with which a threshold is decided.
        largest_sd: f64,
    },
}

/// What a participant does in a task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "kind", rename_all = "snake_case", deny_unknown_fields)]
pub enum TaskKind {
    /// Orders all of a number of samples.
    OrderAll {
        /// How many samples.
        samples: usize,
        /// How the order is scored.
        scoring: Scoring,
    },
    /// Orders the samples of each set.
    OrderSet {
        /// How the order is scored.
        scoring: Scoring,
    },
    /// Associates a sequence of stimuli to the samples of each set.
    Associate {
        /// How the sequence is chosen.
        sequence: SequenceRule,
    },
    /// Learns the samples of each set, then names each once.
    IdentifyFromMemory,
    /// Compares pairs.
    Compare {
        /// The number of possible answers.
        alternatives: usize,
        /// Trials of one participant.
        trials: usize,
        /// What is to be found.
        aim: CompareAim,
    },
    /// Assigns stimuli to categories.
    Categorise {
        /// The number of categories.
        categories: usize,
        /// Trials of one participant.
        trials: usize,
    },
    /// Touches samples: nothing is answered.
    Touch {
        /// Trials of one participant.
        trials: usize,
    },
    /// Rates stimuli on a scale: no answer is right.
    Rate {
        /// Trials of one participant.
        trials: usize,
        /// From the lowest value of the scale to the highest, in whole numbers.
        range: u64,
    },
}

impl TaskKind {
    /// Whether it is done once for each set.
    #[must_use]
    pub fn uses_sets(&self) -> bool {
        matches!(
            self,
            Self::OrderSet { .. } | Self::IdentifyFromMemory | Self::Associate { .. }
        )
    }
}

/// A task of a campaign.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct TaskDescription {
    /// Its name.
    pub name: String,
    /// What is done.
    pub task: TaskKind,
    /// How often each participant does all of it.
    pub repeats: usize,
    /// Seconds of one trial, with what is played: one order, one stimulus of a sequence, one sample named, one pair, one rating.
    pub seconds_per_trial: f64,
    /// Seconds of it in which textures play, each once in full; 0 of textures that last as long as their stroke, which no design knows.
    pub played_s: f64,
    /// Trials beside the counted ones, of one participant: training and catch trials, which take time and say nothing else.
    pub uncounted_trials: f64,
}

/// Tasks whose results are compared within participants.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Comparison {
    /// The names of the tasks.
    pub tasks: Vec<String>,
    /// The smallest standardised mean difference that must not be missed.
    pub smallest_effect_ratio: f64,
}

/// A factor whose orders are crossed with those of others over participants.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Factor {
    /// Its name.
    pub name: String,
    /// The number of its orders.
    pub orders: usize,
}

/// What the campaign must be able to show.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Aims {
    /// The power of comparisons, as a share.
    pub power_share: f64,
    /// The largest half-width of the 95 % interval of a cell, as a share.
    pub half_width_share: f64,
    /// The expected share of answers in a cell of interest, of the median participant.
    pub cell_share: f64,
    /// The expected standard deviation over participants, of the logit of that share.
    pub logit_sd: f64,
}

/// A campaign as its design sees it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct CampaignDescription {
    /// Its name.
    pub name: String,
    /// The samples that sets are made of.
    pub samples: Vec<String>,
    /// The sets; none where no task uses sets.
    pub sets: Vec<Vec<String>>,
    /// How many samples the tray holds.
    pub tray: usize,
    /// Over how many participants the sets are shared: 1 where each participant has all of them.
    pub sets_shared_over: usize,
    /// Which pairs the sets are meant to compare.
    pub pairs_wanted: PairsWanted,
    /// The tasks.
    pub tasks: Vec<TaskDescription>,
    /// The orders of tasks that participants have, by name; none where no tasks are compared.
    pub task_orders: Vec<Vec<String>>,
    /// Which tasks are compared.
    pub comparisons: Vec<Comparison>,
    /// Factors whose orders are crossed over participants.
    pub counterbalanced: Vec<Factor>,
    /// The number of participants planned.
    pub participants: usize,
    /// What it must be able to show.
    pub aims: Aims,
}
