//! Desynchronisation over people: contrasts of tasks, the order of tasks, and clusters over electrodes, frequencies and times.

mod clusters;
mod contrasts;
mod error;
mod page;
mod people;
mod power;
mod scalp;

use std::fmt;

use piezotact::Warning;
use piezotact::criterion::{Criterion, Outcome};
use piezotact::document::Content;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::contrast::Contrast;
use super::erd::Mode;
use super::person::{EegErd, Electrode, PersonConfig};
use people::People;

pub use clusters::{ClusterPlace, TaskClusters};
pub use error::GroupError;
pub use power::PowerLevel;
pub use scalp::{Scalp, Shown};

/// What the mean over all surfaces is called.
pub const ALL_SURFACES: &str = "mean of surfaces";
/// The level of tests.
pub const LEVEL: f64 = 0.05;

/// How people are compared. There is no default: it is stated, and goes into the result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct GroupConfig {
    /// The unit of changes.
    pub unit: Mode,
    /// The tasks from the most to the least desynchronised one, as it is claimed; empty for no claim.
    pub gradient: Vec<String>,
    /// Tasks that differ by less, in the unit, are alike; absent where no margin was stated before.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub margin: Option<f64>,
    /// The angle up to which electrodes are neighbours, degrees.
    pub neighbours_deg: f64,
    /// The number of sign flips of the cluster test.
    pub flips: usize,
    /// The seed of random flips.
    pub seed: u64,
}

/// The change of one person.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PersonChange {
    /// The participant.
    pub participant: String,
    /// The change in the unit.
    pub change: f64,
    /// The power in the baseline, dB re 1 µV².
    pub baseline_db: f64,
    /// The power in the window, dB re 1 µV².
    pub window_db: f64,
}

/// How many epochs there are in one task.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct TaskEpochs {
    /// The task.
    pub task: String,
    /// The fewest of one person on one surface.
    pub fewest: usize,
    /// The most of one person on one surface.
    pub most: usize,
    /// The mean over people and surfaces.
    pub mean: f64,
}

/// The changes of all people in one task, on one surface or on all, in one region and band.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct TaskChanges {
    /// The task.
    pub task: String,
    /// The surface, or the mean of all.
    pub surface: String,
    /// The region.
    pub region: String,
    /// The name of the band.
    pub band: String,
    /// Each person.
    pub people: Vec<PersonChange>,
    /// Their mean, in the unit.
    pub mean: f64,
    /// Its 95 % interval; absent of one person.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub interval: Option<[f64; 2]>,
    /// The power in the baseline.
    pub baseline: PowerLevel,
    /// The power in the window.
    pub window: PowerLevel,
}

/// A contrast of two tasks of the same people.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct TaskContrast {
    /// The tasks: the second less the first.
    pub tasks: [String; 2],
    /// The surface, or the mean of all.
    pub surface: String,
    /// The region.
    pub region: String,
    /// The name of the band.
    pub band: String,
    /// Who took part in both.
    pub people: Vec<String>,
    /// The contrast; absent for fewer than 3 people, or differences that are all the same.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub contrast: Option<Contrast>,
    /// The probability after Holm, over the contrasts of the same kind (means of surfaces, or single ones).
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p_holm: Option<f64>,
    /// How many contrasts it is adjusted over.
    pub holm_over: usize,
    /// The contrast of the power in the baseline, dB; absent as the contrast of changes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub baseline: Option<Contrast>,
    /// The contrast of the power in the window, dB; absent as the contrast of changes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub window: Option<Contrast>,
    /// The contrast of the power in the window less that in the baseline, % of the mean baseline of both tasks; absent as the contrast of
    /// changes. What adds power to both, such as noise in one task, leaves it at 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step: Option<Contrast>,
    /// The larger probability that [`Self::window`] and [`Self::step`] differ so far by chance in the direction in which the changes differ
    /// (one side), after Holm over the same contrasts.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub power_p_holm: Option<f64>,
    /// What was decided.
    pub criteria: Vec<Criterion<GroupCriterion>>,
}

/// What is decided.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum GroupCriterion {
    /// Two tasks differ: the probability of the difference, after Holm; decided only where [`Self::PowerDiffers`] is met.
    Differ {
        /// The tasks.
        tasks: [String; 2],
        /// Where: surface, region and band.
        place: String,
    },
    /// The power in the window differs by itself, in the direction of the changes: the probability, after Holm. Where it does not, the
    /// baselines may carry the difference.
    PowerDiffers {
        /// The tasks.
        tasks: [String; 2],
        /// Where.
        place: String,
    },
    /// Two tasks are alike: their difference lies within the margin.
    Alike {
        /// The tasks.
        tasks: [String; 2],
        /// Where.
        place: String,
    },
    /// The first task is more desynchronised than the second: the difference, second less first.
    Below {
        /// The tasks.
        tasks: [String; 2],
        /// Where.
        place: String,
    },
    /// Two tasks differ somewhere: the probability of the largest cluster, after Holm over the pairs of tasks; decided only where
    /// [`Self::ClusterOfPower`] is met.
    Cluster {
        /// The tasks.
        tasks: [String; 2],
    },
    /// Power itself differs in a cluster of changes, in the same direction: the larger of the probabilities of both clusters, after Holm
    /// over the pairs of tasks. Where it does not, the baselines may carry the cluster.
    ClusterOfPower {
        /// The tasks.
        tasks: [String; 2],
    },
}

impl fmt::Display for GroupCriterion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Differ {
                tasks: [a, b],
                place,
            } => write!(f, "{a} and {b} differ, {place}: p after Holm"),
            Self::PowerDiffers {
                tasks: [a, b],
                place,
            } => write!(
                f,
                "{a} and {b} differ in power, in the window and from the baseline to it, in the same direction, {place}: p after Holm"
            ),
            Self::Alike {
                tasks: [a, b],
                place,
            } => write!(f, "{a} and {b} are alike, {place}: {b} − {a}"),
            Self::Below {
                tasks: [a, b],
                place,
            } => write!(f, "{a} more desynchronised than {b}, {place}: {b} − {a}"),
            Self::Cluster { tasks: [a, b] } => {
                write!(
                    f,
                    "{a} and {b} differ somewhere: p of the largest cluster, after Holm"
                )
            }
            Self::ClusterOfPower { tasks: [a, b] } => {
                write!(
                    f,
                    "{a} and {b} differ in power itself within a cluster, in the same direction: p after Holm"
                )
            }
        }
    }
}

/// The order of tasks in one region and band.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Gradient {
    /// The tasks from the most to the least desynchronised one, as it is claimed.
    pub tasks: Vec<String>,
    /// The region.
    pub region: String,
    /// The name of the band.
    pub band: String,
    /// Each step of it.
    pub criteria: Vec<Criterion<GroupCriterion>>,
}

impl Gradient {
    /// Whether every step of it holds.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        Outcome::of_all(self.criteria.iter().map(|criterion| criterion.outcome))
    }
}

impl TaskContrast {
    /// Whether the tasks differ: met, or not decided.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        let mut all = self.criteria.iter();
        let own = all.find(|one| matches!(one.what, GroupCriterion::Differ { .. }));
        own.map_or(Outcome::NotDecided, |one| one.outcome)
    }

    /// Whether the changes differ while power itself is not told apart: the baselines, or added noise, may carry the difference.
    #[must_use]
    pub fn may_be_of_baselines(&self) -> bool {
        let mut all = self.criteria.iter();
        let of_power = all.find(|one| matches!(one.what, GroupCriterion::PowerDiffers { .. }));
        self.p_holm.is_some_and(|p| p <= LEVEL)
            && of_power.is_some_and(|one| one.outcome != Outcome::Met)
    }

    /// Whether the difference lies within the margin; absent where no margin was stated.
    #[must_use]
    pub fn within_margin(&self) -> Option<Outcome> {
        let mut all = self.criteria.iter();
        let own = all.find(|one| matches!(one.what, GroupCriterion::Alike { .. }));
        own.map(|one| one.outcome)
    }
}

/// What differs over people.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct EegStats {
    /// How people were compared.
    pub config: GroupConfig,
    /// What was compared in each person.
    pub measured: PersonConfig,
    /// How many documents it is of.
    pub documents: usize,
    /// The participants.
    pub participants: Vec<String>,
    /// The tasks.
    pub tasks: Vec<String>,
    /// The surfaces.
    pub surfaces: Vec<String>,
    /// The epochs of each task.
    pub epochs: Vec<TaskEpochs>,
    /// The changes by task, surface, region and band.
    pub changes: Vec<TaskChanges>,
    /// The contrasts of tasks.
    pub contrasts: Vec<TaskContrast>,
    /// The order of tasks, where one is claimed.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub gradients: Vec<Gradient>,
    /// The cluster tests.
    pub clusters: Vec<TaskClusters>,
    /// The electrodes of the scalp maps.
    pub electrodes: Vec<Electrode>,
    /// The means over people on the scalp.
    pub scalps: Vec<Scalp>,
    /// What to know before relying on it.
    #[serde(alias = "doubts")]
    pub warnings: Vec<Warning>,
}

impl Content for EegStats {
    const SCHEMA: &'static str = "eeg_stats";
    const VERSION: u32 = 3;

    fn outdated(version: u64, _: &Map<String, Value>) -> Option<String> {
        (version < 3)
            .then(|| "make it again with `piezotact eeg erd` and `piezotact eeg stats`".to_owned())
    }
}

/// What differs between tasks over people, of one document for each person and task; changes in % or dB.
///
/// Formula: contrasts are those of [`super::contrast::paired`], of each surface and of the mean over surfaces; probabilities are adjusted by
/// Holm, means of surfaces and single surfaces apart. Two tasks differ where p ≤ 0.05, and p ≤ 0.05 for the power in the window by itself, in the
/// same direction: both have to hold, as a change also differs where baselines alone do. Where not, it is not decided. Whether the 95 % interval
/// lies within a margin that was stated is another question, answered beside it. Clusters are those of [`super::cluster::test`] on differences in
/// dB, averaged over surfaces, after the baseline; the p of the largest one of each pair of tasks is adjusted by Holm over the pairs; a cluster
/// decides where power itself has one that overlaps it, in the same direction. A step of
/// a claimed order holds where the contrast differs in its direction. Tasks stand in the claimed order, then by name; people and surfaces by name:
/// the order of the documents changes nothing.
///
/// Source: S. Holm (1979), Scand. J. Stat. 6(2); R. L. Berger (1982), Technometrics 24 (both tests have to hold); E. Maris and R. Oostenveld (2007), J. Neurosci. Methods 164; docs/decisions/eeg.md.
///
/// # Errors
/// [`GroupError`] for fewer than two documents, two documents of one person and task, documents of other settings, and a gradient of
/// tasks that are not there.
pub fn compare(documents: &[EegErd], config: &GroupConfig) -> Result<EegStats, GroupError> {
    let people = People::of(documents, &config.gradient)?;
    check(config, &people)?;
    let changes = people.changes(config.unit);
    let contrasts = contrasts::contrasts(&people, &changes, config);
    let gradients = contrasts::gradients(&people, &contrasts, config);
    let (clusters, mut warnings) = clusters::clusters(&people, config)?;
    warnings.extend(contrasts::too_alike(&contrasts));
    Ok(EegStats {
        config: config.clone(),
        measured: people.first.config.clone(),
        documents: documents.len(),
        participants: people.participants.clone(),
        tasks: people.tasks.clone(),
        surfaces: people.surfaces.clone(),
        epochs: people.epochs(),
        electrodes: people.electrodes.clone(),
        scalps: scalp::scalps(&people, config.unit),
        changes,
        contrasts,
        gradients,
        clusters,
        warnings: [people.warnings(), warnings].concat(),
    })
}

fn check(config: &GroupConfig, people: &People<'_>) -> Result<(), GroupError> {
    let missing = config
        .gradient
        .iter()
        .find(|task| !people.tasks.contains(task));
    if let Some(task) = missing {
        return Err(GroupError::NoTask {
            task: task.clone(),
            tasks: people.tasks.join(", "),
        });
    }
    let twice = |(at, task): (usize, &String)| config.gradient[..at].contains(task);
    if config.gradient.len() == 1 || config.gradient.iter().enumerate().any(twice) {
        return Err(GroupError::OneStep);
    }
    if config
        .margin
        .is_some_and(|margin| !(margin > 0.0 && margin.is_finite()))
    {
        return Err(GroupError::Margin);
    }
    Ok(())
}

#[cfg(test)]
mod power_tests;
#[cfg(test)]
mod tests;
