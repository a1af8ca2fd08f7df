//! The learning curve of an average: how many people it needs.

use num_complex::Complex;
use serde::{Deserialize, Serialize};

use super::Cell;
use super::levels::Levels;
use super::prediction::typical_db;
use super::random::Draws;
use crate::criterion::{Criterion, Limit};
use crate::quantity::{Band, Quantity};
use crate::statistics::{mean, rms};
use crate::transfer::BundleAverage;
use crate::transfer::level_db;

/// The largest number of other people for which every subset is averaged; random orders are drawn for more.
const ALL_SUBSETS: usize = 8;
/// The fewest people for a learning curve.
const LEAST: usize = 3;

/// The penalty of an average for a person who is not in it, by the number of people in the average.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct LearningCurve {
    /// Load and angle.
    pub cell: Cell,
    /// Which average.
    pub averaging: BundleAverage,
    /// From one person to all but one.
    pub points: Vec<LearningPoint>,
    /// The number of people beyond which a larger average gains less than `within_db`, with its interval over people,
    /// compared with the number of people measured.
    pub enough: Criterion<LearningCriterion>,
    /// The tolerance of `enough`, dB.
    pub within_db: f64,
    /// Random orders of the others that were drawn for each person; 0 where every subset was averaged.
    pub orders: usize,
}

/// What a [`LearningCurve`] is judged by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum LearningCriterion {
    /// How many people are enough; the limit is how many were measured.
    PeopleEnough,
}

/// One point of a [`LearningCurve`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct LearningPoint {
    /// How many people are in the average.
    pub people: usize,
    /// The mean over people left out, and over averages of that many others, of the rms penalty, dB.
    pub mean_db_rms: f64,
}

/// What an average of 1 to N − 1 people costs a person who is not in it, for every cell with three or more people, over
/// `band`; `within_db` is the tolerance for how many are enough.
///
/// Formula: for each person left out and each number n, the mean over sets of n others of the rms over lines of the
/// difference of levels: all sets where there are at most eight others, or else the first n of each of `orders` random
/// orders drawn by `seed`. Enough: a typical new person is e·√(1 + 1/n) off an average of n, e that person's error by the average of
/// very many people, so that n is enough where e·(√(1 + 1/n) − 1) ≤ `within_db`; its interval from that of e ([`typical_db`]).
///
/// Source: learning curves as in T. Hastie, R. Tibshirani and J. Friedman, *The Elements of Statistical Learning*, 2nd ed.,
/// section 7.10.
pub(super) fn curves<I: Quantity, O: Quantity>(
    levels: &Levels<I, O>,
    averaging: BundleAverage,
    band: Band,
    within_db: f64,
    orders: usize,
    seed: u64,
) -> Vec<LearningCurve> {
    levels
        .cells
        .iter()
        .enumerate()
        .filter_map(|(i, cell)| {
            let inside = levels.in_cell(i);
            if inside.len() < LEAST {
                return None;
            }
            let people: Vec<Summand> = inside
                .iter()
                .map(|(_, own)| Summand {
                    db: &own.db,
                    terms: match averaging {
                        BundleAverage::LogMagnitude => {
                            own.db.iter().map(|db| Complex::new(*db, 0.0)).collect()
                        }
                        BundleAverage::Complex => {
                            let lines = own.function.lines_in(band);
                            lines
                                .map(|(line, _)| own.function.response()[line])
                                .collect()
                        }
                    },
                })
                .collect();
            Some(curve(*cell, &people, averaging, within_db, orders, seed))
        })
        .collect()
}

/// One person: the level that an average is compared with, and the terms that are summed for averages.
struct Summand<'a> {
    db: &'a [f64],
    terms: Vec<Complex<f64>>,
}

fn curve(
    cell: Cell,
    people: &[Summand<'_>],
    averaging: BundleAverage,
    within_db: f64,
    orders: usize,
    seed: u64,
) -> LearningCurve {
    let others = people.len() - 1;
    let every = others <= ALL_SUBSETS;
    let mut draws = Draws::new(seed);
    // By person left out, then by number in the average.
    let costs: Vec<Vec<f64>> = (0..people.len())
        .map(|left_out| {
            let rest: Vec<usize> = (0..people.len()).filter(|i| *i != left_out).collect();
            let own = people[left_out].db;
            let mut costs = Costs::new(others, averaging);
            if every {
                for set in 1..1_usize << others {
                    let members = (0..others).filter(|i| set >> i & 1 == 1);
                    costs.add_set(people, own, members.map(|i| rest[i]));
                }
            } else {
                for _ in 0..orders.max(1) {
                    let mut order = rest.clone();
                    draws.shuffle(&mut order);
                    costs.add_order(people, own, &order);
                }
            }
            costs.means()
        })
        .collect();
    let points: Vec<LearningPoint> = (0..others)
        .map(|n| {
            let each: Vec<f64> = costs.iter().map(|of_person| of_person[n]).collect();
            LearningPoint {
                people: n + 1,
                mean_db_rms: mean(&each),
            }
        })
        .collect();
    let left_out: Vec<f64> = costs
        .iter()
        .map(|of_person| of_person[others - 1])
        .collect();
    LearningCurve {
        cell,
        averaging,
        points,
        enough: enough(&left_out, within_db),
        within_db,
        orders: if every { 0 } else { orders.max(1) },
    }
}

/// How many people an average needs, by the errors `left_out_db` of the average of all others.
fn enough(left_out_db: &[f64], within_db: f64) -> Criterion<LearningCriterion> {
    // e·(√(1 + 1/n) − 1) = d solved for n, in whole people.
    let needed = |error_db: f64| -> f64 {
        let ratio = 1.0 + within_db / error_db;
        (1.0 / (ratio * ratio - 1.0)).ceil().max(1.0)
    };
    let what = LearningCriterion::PeopleEnough;
    let limit = Limit::at_most(left_out_db.len() as f64);
    match typical_db(left_out_db) {
        Some((error_db, interval)) => Criterion::new(
            what,
            "people",
            needed(error_db),
            Some(interval.map(needed)),
            limit,
        ),
        None => Criterion::unmeasured(what, "people", limit),
    }
}

/// Penalties by number of people in the average.
struct Costs {
    averaging: BundleAverage,
    sums: Vec<f64>,
    counts: Vec<usize>,
}

impl Costs {
    fn new(others: usize, averaging: BundleAverage) -> Self {
        Self {
            averaging,
            sums: vec![0.0; others],
            counts: vec![0; others],
        }
    }

    fn add_set(
        &mut self,
        people: &[Summand<'_>],
        own: &[f64],
        members: impl Iterator<Item = usize>,
    ) {
        let mut sum = vec![Complex::ZERO; own.len()];
        let mut count = 0;
        for member in members {
            add(&mut sum, &people[member].terms);
            count += 1;
        }
        self.add(&sum, own, count);
    }

    fn add_order(&mut self, people: &[Summand<'_>], own: &[f64], order: &[usize]) {
        let mut sum = vec![Complex::ZERO; own.len()];
        for (i, member) in order.iter().enumerate() {
            add(&mut sum, &people[*member].terms);
            self.add(&sum, own, i + 1);
        }
    }

    fn add(&mut self, sum: &[Complex<f64>], own: &[f64], count: usize) {
        let n = count as f64;
        let off: Vec<f64> = sum
            .iter()
            .zip(own)
            .map(|(sum, own)| match self.averaging {
                BundleAverage::LogMagnitude => sum.re / n - own,
                BundleAverage::Complex => level_db(sum / n) - own,
            })
            .collect();
        self.sums[count - 1] += rms(&off);
        self.counts[count - 1] += 1;
    }

    fn means(&self) -> Vec<f64> {
        let pairs = self.sums.iter().zip(&self.counts);
        pairs
            .map(|(sum, count)| sum / (*count).max(1) as f64)
            .collect()
    }
}

fn add(sum: &mut [Complex<f64>], terms: &[Complex<f64>]) {
    for (sum, term) in sum.iter_mut().zip(terms) {
        *sum += term;
    }
}
