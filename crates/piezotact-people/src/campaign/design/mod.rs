//! The check of a campaign's design before the first volunteer: sets, orders, sequences, chance, precision, time, and faults.

mod chance;
mod construct;
mod coverage;
mod description;
mod error;
mod fault;
mod findings;
mod orders;
mod power;
mod precision;
mod sequence;
mod sets;

pub use chance::{Matches, permutation_matches, rule_matches, tau_null_sd, trial_matches};
pub use construct::{
    Blocks, Method, balanced_blocks, covering, schonheim_bound, shares, steiner_triples,
};
pub use coverage::{PairCoverage, Together};
pub use description::{
    Aims, CampaignDescription, CompareAim, Comparison, Factor, PairsWanted, Scoring,
    TaskDescription, TaskKind,
};
pub use error::DesignError;
pub use fault::{BetterPlan, Change, DesignCriterion, Fault, FoundFault, SampleSetCount};
pub use findings::{
    ComparisonPower, DesignReport, PowerPoint, PowerQuestion, PowerStudy, RatingPrecision,
    SampleCount, TaskChance, TaskTime, ThresholdShare, design_findings, power_study, task_times,
};
pub use orders::{Crossing, balanced_latin_square, crossing, only_positions, williams_orders};
pub use power::{FoundShare, PowerPlan, found_share};
pub use precision::{
    CellPlan, CellPrecision, cell_precision, paired_power, participants_for_power,
};
pub use sequence::{SequenceDistribution, SequenceRule, sequence_distribution};
