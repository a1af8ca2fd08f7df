//! Cluster permutation tests over channels × frequencies × times.
//!
//! A test says that the conditions differ somewhere; it does not say that they differ at every node of a cluster, nor when an effect
//! begins (J. Sassenhagen and D. Draschkow 2019, Psychophysiology 56).

mod components;
mod flips;
mod grid;

use piezotact::Warning;
use piezotact::statistics::t_quantile;
use piezotact::warning::{Few, FewWarning};
use serde::{Deserialize, Serialize};

use components::Components;
use flips::{Flips, Sums};

pub use grid::Grid;

/// No p below this can be shown: fewer people cannot decide.
const LEVEL: f64 = 0.05;
/// Masses that differ by less than this share are the same number, computed in another order.
const SAME: f64 = 1e-9;
/// Values whose spread is below this share of their size have none, but for rounding.
const NO_SPREAD: f64 = 1e-12;

/// The direction of the clusters that are looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tail {
    /// Positive and negative ones.
    Both,
    /// Positive ones: b above a.
    Positive,
    /// Negative ones: b below a.
    Negative,
}

/// How clusters are made and tested.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClusterConfig {
    /// Nodes whose t is further from 0 than this form clusters.
    pub threshold_t: f64,
    pub tail: Tail,
    /// The number of sign flips, the observed signs among them. Where there are no more different ones, all of them are taken.
    pub flips: usize,
    /// The seed of random flips.
    pub seed: u64,
}

impl ClusterConfig {
    /// Both directions, with the two-sided 5 % point of Student's t of `people` as the threshold; `None` for fewer than 2 people.
    #[must_use]
    pub fn two_sided(people: usize, flips: usize, seed: u64) -> Option<Self> {
        Some(Self {
            threshold_t: t_quantile(people.checked_sub(1)?)?,
            tail: Tail::Both,
            flips,
            seed,
        })
    }
}

/// Which sign flips were made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Tried {
    /// All that there are; p is exact.
    All,
    /// Random ones of a seed, and the observed signs.
    Drawn {
        /// The seed.
        seed: u64,
    },
}

/// Connected nodes of one sign.
#[derive(Clone, Debug, PartialEq)]
pub struct Cluster {
    /// The nodes in ascending order; [`Grid::place`] says where each is.
    pub nodes: Vec<usize>,
    /// The sum of their t.
    pub mass: f64,
    /// The share of sign flips with a cluster whose mass is at least as large.
    pub p_value: f64,
}

/// The result of a cluster permutation test.
#[derive(Clone, Debug, PartialEq)]
pub struct ClusterTest {
    /// How clusters were made.
    pub config: ClusterConfig,
    /// How many people there are.
    pub people: usize,
    /// Student's t of each node; 0 where people do not differ at all.
    pub t: Vec<f64>,
    /// The clusters, the largest mass first.
    pub clusters: Vec<Cluster>,
    /// How many sign flips were made, the observed signs among them.
    pub flips: usize,
    pub tried: Tried,
    /// The smallest p that these flips can give.
    pub smallest_p: f64,
    /// The largest mass of each flip, ascending: what chance gives.
    pub chance: Vec<f64>,
    /// What to know before relying on it.
    pub warnings: Vec<Warning>,
}

/// The differences b − a of each person, people × nodes, in the unit of both.
///
/// Source: the paired design of E. Maris and R. Oostenveld (2007), J. Neurosci. Methods 164.
///
/// # Errors
/// [`ClusterError::Shape`] unless each person has as many nodes in both.
pub fn differences(a: &[Vec<f64>], b: &[Vec<f64>]) -> Result<Vec<Vec<f64>>, ClusterError> {
    let pairs = a.len() == b.len() && a.iter().zip(b).all(|(a, b)| a.len() == b.len());
    if !pairs {
        return Err(ClusterError::Shape {
            expected: "the same people and nodes in both conditions".to_owned(),
            found: format!("{} and {} people", a.len(), b.len()),
        });
    }
    let of = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| b - a).collect();
    Ok(a.iter().zip(b).map(of).collect())
}

/// The clusters of nodes at which `people` differ from 0, with their probabilities under random signs of people. Each person has one value
/// for each node of `grid`: a difference of conditions, or a change from a baseline. The order of people changes nothing.
///
/// Formula: t = mean/(s/√n) at each node; clusters are connected nodes of one sign beyond the threshold; their mass is Σt. p is the share of
/// sign flips whose largest |mass| (or mass in the direction of the tail) is at least as large, the observed signs included. Up to the number of flips
/// asked for, all are made (2ⁿ⁻¹ for both directions, as opposite signs give opposite masses; 2ⁿ for one); of more, `ChaCha8` draws
/// from the seed.
///
/// Source: E. Maris and R. Oostenveld (2007), J. Neurosci. Methods 164; as MNE-Python's `permutation_cluster_1samp_test`.
///
/// # Errors
/// [`ClusterError`] for fewer than 2 people, a person without one finite value for each node, a threshold that is not above 0, or no flip.
pub fn test(
    people: &[Vec<f64>],
    grid: &Grid,
    config: &ClusterConfig,
) -> Result<ClusterTest, ClusterError> {
    check(people, grid, config)?;
    let n = people.len();
    // Sorted by size, not by sign: exchanging the conditions changes nothing either.
    let mut sorted: Vec<&[f64]> = people.iter().map(Vec::as_slice).collect();
    sorted.sort_by(|a, b| {
        let sizes = a.iter().zip(*b).map(|(a, b)| a.abs().total_cmp(&b.abs()));
        sizes
            .into_iter()
            .find(|order| order.is_ne())
            .unwrap_or_else(|| compare(a, b))
    });
    let t = statistics(&sorted, grid.nodes());
    let mut components = Components::new(grid);
    let found = components.clusters(&t, config.threshold_t, config.tail);
    let flips = Flips::new(n, config);
    let mut chance = Vec::with_capacity(flips.count());
    let observed = |mass: f64| strength(config.tail, mass);
    // The observed signs are one of the flips, with the masses that are compared.
    chance.push(found.iter().map(|c| observed(c.mass)).fold(0.0, f64::max));
    let mut sums = Sums::new(&sorted, config.threshold_t);
    flips.for_each(|signs| {
        let active = sums.active(&sorted, signs);
        chance.push(components.largest(&active, &sums, config.tail));
        sums.give_back(active);
    });
    chance.sort_by(f64::total_cmp);
    let count = chance.len();
    let clusters = found
        .into_iter()
        .map(|cluster| {
            let least = observed(cluster.mass) * (1.0 - SAME);
            let smaller = chance.partition_point(|mass| *mass < least);
            Cluster {
                p_value: (count - smaller) as f64 / count as f64,
                ..cluster
            }
        })
        .collect();
    let smallest_p = 1.0 / count as f64;
    let warning = FewWarning::Few {
        found: n,
        recommended: people_for(1),
        what: Few::ParticipantsOfClusters {
            flips: count,
            smallest_p,
            tests: 1,
        },
    };
    Ok(ClusterTest {
        config: *config,
        people: n,
        t,
        clusters,
        flips: count,
        tried: flips.tried(),
        smallest_p,
        chance,
        warnings: (smallest_p > LEVEL)
            .then(|| warning.into())
            .into_iter()
            .collect(),
    })
}

fn compare(a: &[f64], b: &[f64]) -> std::cmp::Ordering {
    let orders = a.iter().zip(b).map(|(a, b)| a.total_cmp(b));
    orders
        .into_iter()
        .find(|order| order.is_ne())
        .unwrap_or(std::cmp::Ordering::Equal)
}

/// How much a mass counts in the direction of the tail.
fn strength(tail: Tail, mass: f64) -> f64 {
    match tail {
        Tail::Both => mass.abs(),
        Tail::Positive => mass,
        Tail::Negative => -mass,
    }
}

/// Student's t of each node over people, in two passes.
fn statistics(people: &[&[f64]], nodes: usize) -> Vec<f64> {
    let n = people.len() as f64;
    let mut means = vec![0.0; nodes];
    for person in people {
        for (mean, value) in means.iter_mut().zip(*person) {
            *mean += value / n;
        }
    }
    let (mut squares, mut all) = (vec![0.0; nodes], vec![0.0; nodes]);
    for person in people {
        for (i, value) in person.iter().enumerate() {
            squares[i] += (value - means[i]) * (value - means[i]);
            all[i] += value * value;
        }
    }
    (0..nodes)
        .map(|i| {
            if squares[i] <= NO_SPREAD * all[i] {
                return 0.0;
            }
            means[i] / (squares[i] / (n - 1.0) / n).sqrt()
        })
        .collect()
}

fn check(people: &[Vec<f64>], grid: &Grid, config: &ClusterConfig) -> Result<(), ClusterError> {
    if people.len() < 2 {
        return Err(ClusterError::FewPeople {
            found: people.len(),
        });
    }
    if let Some(person) = people
        .iter()
        .position(|values| values.len() != grid.nodes())
    {
        return Err(ClusterError::Shape {
            expected: format!("{} nodes of each person", grid.nodes()),
            found: format!("{} of person {person} (from 0)", people[person].len()),
        });
    }
    let broken = |values: &Vec<f64>| values.iter().any(|v| !v.is_finite());
    if let Some(person) = people.iter().position(broken) {
        return Err(ClusterError::NotFinite { person });
    }
    if !(config.threshold_t > 0.0 && config.threshold_t.is_finite()) {
        return Err(ClusterError::Shape {
            expected: "a threshold above 0".to_owned(),
            found: config.threshold_t.to_string(),
        });
    }
    if config.flips == 0 {
        return Err(ClusterError::NoFlip);
    }
    Ok(())
}

/// A test over people that cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ClusterError {
    /// Too few people.
    #[error(
        "expected at least 2 people, found {found}; measure more (at least 6 are needed to reach p < 0.05)"
    )]
    FewPeople { found: usize },
    /// Values, nodes or neighbours of another number than the rest.
    #[error("internal error: expected {expected}, found {found}; please report it")]
    Shape { expected: String, found: String },
    /// A value that is no number.
    #[error(
        "person {person} (from 0) has a value that is not finite: leave the channel out for everybody"
    )]
    NotFinite {
        /// The index of the person.
        person: usize,
    },
    /// No flip.
    #[error("expected at least 1 sign flip, found 0; 1000 or more are usual")]
    NoFlip,
    /// Lists of different people, or too few.
    #[error(
        "expected one value in each condition of at least 3 people, found {a} and {b}; leave out people without both"
    )]
    FewPairs {
        /// Values of the first condition.
        a: usize,
        /// Values of the second.
        b: usize,
    },
    /// Differences without spread.
    #[error(
        "the differences of people are all the same, or not finite: check that the conditions are different measurements"
    )]
    NoSpread,
}

/// The fewest people with whom one of `tests` clusters can be below 5 % after Holm: 2ⁿ⁻¹ sign flips.
pub(super) fn people_for(tests: usize) -> usize {
    ((20.0 * tests as f64).log2().ceil() as usize) + 1
}

#[cfg(test)]
mod tests;
