//! The report on a design.

use piezotact::criterion::Criterion;
use serde::{Deserialize, Serialize};

use super::super::coverage::PairCoverage;
use super::super::fault::{DesignCriterion, FoundFault};
use super::super::orders::Crossing;
use super::super::precision::CellPrecision;

/// What chance reaches in a task over all its sets: those of one participant, or of the participants who share them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct TaskChance {
    /// The task.
    pub task: String,
    /// The number of answers; a mean where sequences have several lengths.
    pub answers: f64,
    /// The mean number of right answers by chance.
    pub mean: f64,
    /// Its standard deviation.
    pub sd: f64,
    /// What the standard deviation would be for independent answers.
    pub sd_independent: f64,
    /// The smallest possible number of right answers that chance reaches with 5 % at most, also where people repeat answers; absent
    /// where there is none.
    pub beyond_chance_from: Option<usize>,
    /// The same of all participants together; of those who share the sets in groups, of all groups.
    pub beyond_chance_together_from: Option<usize>,
    /// The probability by chance of each number of right answers, from 0 on.
    pub probability: Vec<f64>,
    /// The probability by chance of a whole order, for tasks of order.
    pub whole_order_share: Option<f64>,
    /// The standard deviation of Kendall's τ by chance, for tasks of order.
    pub tau_sd: Option<f64>,
    /// The share of sequences whose last answer follows from the others, for tasks of association.
    pub forced_share: Option<f64>,
    /// The share of sequences that are permutations of their set, for tasks of association.
    pub permutation_share: Option<f64>,
}

/// Trials and time of a task, for one participant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct TaskTime {
    /// The task.
    pub task: String,
    /// The mean number of trials.
    pub trials: f64,
    /// Training and catch trials beside them.
    pub uncounted: f64,
    /// Seconds, with them.
    pub time_s: f64,
    /// Seconds of them in which textures play.
    pub played_s: f64,
}

/// A stimulus and how often one participant meets it in a task of association.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SampleCount {
    /// The task.
    pub task: String,
    /// The stimulus that is presented least often: a sample, or a manipulated texture.
    pub sample: String,
    /// The mean number of its presentations to one participant.
    pub presentations: f64,
    /// The precision of one of its cells.
    pub precision: CellPrecision,
}

/// The precision of a mean rating over the participants.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RatingPrecision {
    /// The task.
    pub task: String,
    /// From the lowest value of the scale to the highest.
    pub range: u64,
    /// The half-width of the 95 % interval of a mean rating, as a share of the scale.
    pub half_width_share: f64,
}

/// How many adaptive runs decide a threshold, by simulation.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ThresholdShare {
    /// The task.
    pub task: String,
    /// The number of simulated runs.
    pub runs: usize,
    /// The share of them that decide.
    pub decided_share: f64,
    /// The thresholds that were assumed: from and to.
    pub thresholds: [f64; 2],
}

/// The power of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ComparisonPower {
    /// The tasks compared.
    pub tasks: Vec<String>,
    /// The smallest effect that must not be missed.
    pub effect_ratio: f64,
    /// The power.
    pub power_share: f64,
}

/// What a design can show.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct DesignReport {
    /// The campaign.
    pub name: String,
    /// The samples; the coverage counts by their indices.
    pub samples: Vec<String>,
    /// The pairs that the sets put together; absent without sets.
    pub coverage: Option<PairCoverage>,
    /// The pairs never together, by name.
    pub never: Vec<[String; 2]>,
    /// What chance reaches in each task in which answers are right or wrong.
    pub chance: Vec<TaskChance>,
    /// The time of each task.
    pub time: Vec<TaskTime>,
    /// Seconds of one participant.
    pub participant_s: f64,
    /// How participants fill the cells of crossed factors; absent without such factors.
    pub crossing: Option<Crossing>,
    /// The power of each comparison.
    pub power: Vec<ComparisonPower>,
    /// The precision of the least presented sample of each task of association.
    pub precision: Vec<SampleCount>,
    /// The precision of mean ratings.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ratings: Vec<RatingPrecision>,
    /// How many adaptive runs decide a threshold.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub thresholds: Vec<ThresholdShare>,
    /// Every rule that was judged.
    pub criteria: Vec<Criterion<DesignCriterion>>,
    /// The faults: criteria that are not met.
    pub faults: Vec<FoundFault>,
    /// The seed of simulations and searches.
    pub seed: u64,
}
