//! What chance makes of the differences between samples: permutation tests of every pair of samples over all settings.

use std::collections::BTreeMap;

use super::DiscriminationConfig;
use super::distinguishability::Groups;
use super::groups::{Sample, mean_sums};
use crate::discrimination::{Excitation, Model};
use crate::statistics::{Draws, permutation_test_within};

/// The largest number of divisions drawn for one pair.
const MOST_DRAWS: usize = 200_000;

/// The pairs of samples by name, each with its places: setting and pair.
pub(super) fn by_name(found: &[Groups]) -> BTreeMap<[&str; 2], Vec<(usize, usize)>> {
    let mut places: BTreeMap<[&str; 2], Vec<(usize, usize)>> = BTreeMap::new();
    for (setting, groups) in found.iter().enumerate() {
        for (place, pair) in groups.pairs.iter().enumerate() {
            let mut names = [pair.a, pair.b].map(|i| groups.names[i].as_str());
            names.sort_unstable();
            places.entry(names).or_default().push((setting, place));
        }
    }
    places
}

/// The probability that recordings of one sample differ as they do were it chance which stroke belongs to which, from `shuffles` divisions;
/// `None` where no sample has several recordings of which one has several strokes.
///
/// `counts` are the strokes of the recordings of each sample; `distance` that of a sample's strokes `all` from those of one recording, by
/// their indices. The statistic is the sum over recordings of strokes times that.
pub(super) fn recordings_differ(
    counts: &[Vec<usize>],
    (shuffles, seed): (usize, u64),
    mut distance: impl FnMut(usize, &[usize], &[usize]) -> f64,
) -> Option<f64> {
    let several = |of: &Vec<usize>| of.len() > 1 && of.iter().any(|strokes| *strokes > 1);
    let places: Vec<usize> = (0..counts.len()).filter(|i| several(&counts[*i])).collect();
    if places.is_empty() {
        return None;
    }
    let all = places
        .iter()
        .map(|i| (0..counts[*i].iter().sum()).collect());
    let mut orders: Vec<Vec<usize>> = all.collect();
    let mut statistic = |orders: &[Vec<usize>]| -> f64 {
        let mut sum = 0.0;
        for (place, order) in places.iter().zip(orders) {
            let mut at = 0;
            for count in &counts[*place] {
                sum += *count as f64 * distance(*place, order, &order[at..at + count]);
                at += count;
            }
        }
        sum
    };
    let observed = statistic(&orders);
    let mut random = Draws::new(seed);
    let mut larger = 0usize;
    for _ in 0..shuffles {
        for order in &mut orders {
            random.shuffle(order);
        }
        larger += usize::from(statistic(&orders) >= observed * (1.0 - 1e-9));
    }
    Some((larger + 1) as f64 / (shuffles + 1) as f64)
}

/// How far the halves of `count` units lie apart in so many divisions, the least first: `distance` is that of two halves, by their indices.
pub(super) fn halves_apart(
    count: usize,
    (divisions, seed): (usize, u64),
    mut distance: impl FnMut(&[usize], &[usize]) -> f64,
) -> Vec<f64> {
    if count < 2 {
        return Vec::new();
    }
    let mut order: Vec<usize> = (0..count).collect();
    let mut random = Draws::new(seed);
    let mut found: Vec<f64> = (0..divisions)
        .map(|_| {
            random.shuffle(&mut order);
            let (first, second) = order.split_at(count / 2);
            distance(first, second)
        })
        .collect();
    found.sort_by(f64::total_cmp);
    found
}

/// Tests every pair of samples over all settings in which both have several units, and how many pairs there are.
pub(super) fn permute(
    found: &mut [Groups],
    samples: &[Vec<Sample>],
    config: &DiscriminationConfig,
) -> usize {
    let places: Vec<Vec<(usize, usize)>> = by_name(found).into_values().collect();
    let family = places.len();
    for mut places in places {
        places.retain(|(setting, place)| found[*setting].pairs[*place].interval_jnd.is_some());
        let strata: Vec<Stratum<'_>> = places
            .iter()
            .map(|(setting, place)| {
                let pair = &found[*setting].pairs[*place];
                Stratum::of([pair.a, pair.b].map(|i| &samples[*setting][i]))
            })
            .collect();
        if strata.is_empty() {
            continue;
        }
        let draws = (200 * family).clamp(2000, MOST_DRAWS) - 1;
        let counts: Vec<[usize; 2]> = strata.iter().map(|s| [s.units.len(), s.first]).collect();
        let (mut one, mut other) = (Vec::new(), Vec::new());
        let permuted = permutation_test_within(&counts, draws, config.seed, &mut |chosen| {
            let each = strata.iter().zip(chosen);
            each.map(|(stratum, chosen)| {
                stratum.distance_jnd(chosen, &config.model, (&mut one, &mut other))
            })
            .sum()
        });
        for (setting, place) in places {
            found[setting].pairs[place].permuted = Some(permuted);
        }
    }
    family
}

/// The units of two samples in one setting, among which they are divided.
struct Stratum<'u> {
    units: Vec<&'u Excitation>,
    /// How many of them are of the first sample.
    first: usize,
    /// The mean of all.
    whole: Vec<f64>,
}

impl<'u> Stratum<'u> {
    fn of([first, second]: [&'u Sample; 2]) -> Self {
        let units: Vec<&Excitation> = first.units.iter().chain(&second.units).collect();
        let mut whole = Vec::new();
        let everybody: Vec<usize> = (0..units.len()).collect();
        mean_sums(&units, &everybody, &mut whole);
        Self {
            first: first.units.len(),
            units,
            whole,
        }
    }

    /// The distance of the `chosen` units from the others.
    fn distance_jnd(
        &self,
        chosen: &[usize],
        model: &Model,
        (one, other): (&mut Vec<f64>, &mut Vec<f64>),
    ) -> f64 {
        let count = self.units.len();
        let rest = (count - chosen.len()) as f64;
        mean_sums(&self.units, chosen, one);
        other.clear();
        other.extend(
            self.whole.iter().zip(&*one).map(|(all, part)| {
                (all * count as f64 - part * chosen.len() as f64).max(0.0) / rest
            }),
        );
        model.distance_jnd(one, other)
    }
}
