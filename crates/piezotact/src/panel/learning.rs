//! The learning curve of an average: how many people it needs.

use serde::{Deserialize, Serialize};

use super::levels::{Levels, Mean, Own};
use super::prediction::typical_db;
use super::random::Draws;
use super::{Cell, PanelConfig};
use crate::criterion::{Criterion, Limit};
use crate::statistics::mean;
use crate::transfer::BundleAverage;

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

/// What an average of 1 to N − 1 people costs a person who is not in it, for every cell with three or more people.
///
/// Formula: for each person left out and each number n, the mean over sets of n others of the rms over lines of the
/// difference of levels: all sets where there are at most eight others, or else the first n of each of `orders` random
/// orders. Enough: a typical new person is e·√(1 + 1/n) off an average of n, e that person's error by the average of
/// very many people, so that n is enough where e·(√(1 + 1/n) − 1) ≤ `enough_within_db`; its interval from that of e ([`typical_db`]).
///
/// Source: learning curves as in T. Hastie, R. Tibshirani and J. Friedman, *The Elements of Statistical Learning*, 2nd ed.,
/// section 7.10.
pub(super) fn curves(levels: &Levels, config: &PanelConfig) -> Vec<LearningCurve> {
    let cells = levels.cells.iter().enumerate();
    let inside = cells.map(|(i, cell)| (cell, levels.in_cell(i)));
    inside
        .filter(|(_, inside)| inside.len() >= LEAST)
        .map(|(cell, inside)| {
            let people: Vec<&Own> = inside.iter().map(|(_, own)| *own).collect();
            curve(*cell, &people, config)
        })
        .collect()
}

fn curve(cell: Cell, people: &[&Own], config: &PanelConfig) -> LearningCurve {
    let averaging = config.averaging;
    let others = people.len() - 1;
    let orders = match others {
        ..=ALL_SUBSETS => 0,
        _ => config.orders.max(1),
    };
    let mut draws = Draws::new(config.seed);
    // By person left out, then by number in the average.
    let errors_db: Vec<Vec<f64>> = (0..people.len())
        .map(|left_out| {
            let own = people[left_out];
            let rest: Vec<usize> = (0..people.len()).filter(|i| *i != left_out).collect();
            let mut errors_db = vec![Vec::new(); others];
            let sets = if orders == 0 {
                1..1_usize << others
            } else {
                0..0
            };
            for set in sets {
                let members = (0..others).filter(|i| set >> i & 1 == 1);
                let average = Mean::of(averaging, members.map(|i| people[rest[i]]));
                errors_db[average.people - 1].push(average.off_db_rms(own));
            }
            for _ in 0..orders {
                let mut order = rest.clone();
                draws.shuffle(&mut order);
                let mut average = Mean::of(averaging, std::iter::empty());
                for member in order {
                    average.add(people[member]);
                    errors_db[average.people - 1].push(average.off_db_rms(own));
                }
            }
            errors_db.iter().map(|of| mean(of)).collect()
        })
        .collect();
    let of_size = |n: usize| errors_db.iter().map(|of| of[n]).collect::<Vec<f64>>();
    LearningCurve {
        cell,
        averaging,
        points: (0..others)
            .map(|n| LearningPoint {
                people: n + 1,
                mean_db_rms: mean(&of_size(n)),
            })
            .collect(),
        enough: enough(&of_size(others - 1), config.enough_within_db),
        within_db: config.enough_within_db,
        orders,
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
