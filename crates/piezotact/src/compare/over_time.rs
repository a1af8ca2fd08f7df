//! Whether samples are distinguishable over time and channels, beside the spectra of their strokes.

use std::collections::BTreeMap;

use super::chance::{self, by_name, halves_apart};
use super::distinguishability::{Distinguishability, PairCriterion, SampleUnit};
use super::groups::{AcrossSamples, POOLED_FROM, below_jnd};
use crate::criterion::{Criterion, Limit, Outcome};
use crate::perception::{Parameters, PerceivedVibration};
use crate::statistics::{holm, permutation_test_within};

/// The divisions of a sample's units into halves that are looked at.
const HALVINGS: usize = 99;
/// The divisions of strokes among recordings that are looked at.
const SHUFFLES: usize = 199;
/// The largest number of divisions drawn for one pair.
const MOST_DRAWS: usize = 8000;

/// What is felt of the strokes of a sample, by recording.
pub type PerceivedStrokes = Vec<Vec<PerceivedVibration>>;

/// `found` with what is felt over time and channels of `settings`, the strokes of each sample in the order of its names; `None` for a
/// sample of which it cannot be computed.
///
/// A pair stays *below the just-noticeable difference* only where the difference over time and channels of the means of its strokes is
/// below 1 JND too; it is *distinguishable* by it where the interval lies above 1 JND and above what halves of either sample differ by,
/// and where a permutation test over all settings, adjusted for all pairs, shows a difference; only where each sample has several recordings.
/// Recordings are the units where they differ by more than their strokes do.
///
/// Source: [`crate::perception`]; units and tests as [`super::discriminate`].
pub fn add_over_time(found: &mut AcrossSamples, settings: &[Vec<Option<PerceivedStrokes>>]) {
    let parameters = Parameters::published();
    let seed = found.config.seed;
    let known: Vec<&PerceivedStrokes> = settings.iter().flatten().flatten().collect();
    let units = match found.units {
        SampleUnit::Strokes if recordings_differ(&known, seed, &parameters) => {
            SampleUnit::Recordings
        }
        units => units,
    };
    let samples: Vec<Vec<Option<Sample>>> = settings
        .iter()
        .map(|all| {
            let of = |one: &Option<PerceivedStrokes>| Sample::of(one.as_ref()?, units);
            all.iter().map(of).collect()
        })
        .collect();
    for (groups, samples) in found.settings.iter_mut().zip(&samples) {
        let within: Vec<f64> = samples
            .iter()
            .map(|one| {
                one.as_ref()
                    .map_or(0.0, |one| one.within(seed, &parameters))
            })
            .collect();
        for pair in &mut groups.pairs {
            let [a, b] = [pair.a, pair.b].map(|i| samples.get(i).and_then(Option::as_ref));
            let limit = |halves: f64| Limit::AtMost {
                met: 1.0,
                not_met: halves.max(1.0),
            };
            let Some((a, b)) = a.zip(b) else {
                let unknown = Criterion::unmeasured(PairCriterion::OverTime, "JND", limit(1.0));
                pair.criteria.push(unknown);
                continue;
            };
            let apart = a.mean.difference(&b.mean, &parameters);
            let several = a.recordings > 1 && b.recordings > 1;
            let within = within[pair.a].max(within[pair.b]);
            let criterion = apart.judged(PairCriterion::OverTime, limit(within));
            // One recording does not say what recordings of a sample differ by, in the phases of its lines above all.
            pair.criteria.push(match criterion.outcome {
                Outcome::NotMet if !several => Criterion {
                    outcome: Outcome::NotDecided,
                    ..criterion
                },
                _ => criterion,
            });
            pair.felt_in = apart.main_contributions();
        }
    }
    test(found, &samples, &parameters);
    for groups in &mut found.settings {
        for pair in &mut groups.pairs {
            pair.outcome = Distinguishability::of(&pair.criteria);
        }
        groups.below_jnd = below_jnd(groups);
    }
}

/// What is felt of a sample.
struct Sample {
    recordings: usize,
    units: Vec<PerceivedVibration>,
    mean: PerceivedVibration,
}

impl Sample {
    fn of(recordings: &PerceivedStrokes, units: SampleUnit) -> Option<Self> {
        let units: Vec<PerceivedVibration> = match units {
            SampleUnit::Strokes => recordings.iter().flatten().cloned().collect(),
            SampleUnit::Recordings => recordings
                .iter()
                .filter_map(|strokes| PerceivedVibration::mean(&strokes.iter().collect::<Vec<_>>()))
                .collect(),
        };
        let mean = PerceivedVibration::mean(&units.iter().collect::<Vec<_>>())?;
        let recordings = recordings.iter().filter(|strokes| !strokes.is_empty());
        Some(Self {
            recordings: recordings.count(),
            units,
            mean,
        })
    }

    /// How far halves of the units lie apart in 95 % of divisions, JND; 0 for one unit.
    fn within(&self, seed: u64, parameters: &Parameters) -> f64 {
        let of = |indices: &[usize]| indices.iter().map(|i| &self.units[*i]).collect::<Vec<_>>();
        let found = halves_apart(self.units.len(), (HALVINGS, seed), |first, second| {
            apart_jnd(&of(first), &of(second), parameters).unwrap_or(0.0)
        });
        let place = (0.95 * found.len().saturating_sub(1) as f64).round() as usize;
        found.get(place).copied().unwrap_or(0.0)
    }
}

/// Whether recordings of one sample differ over time by more than their strokes do, as [`super::discriminate`] asks of spectra.
fn recordings_differ(samples: &[&PerceivedStrokes], seed: u64, parameters: &Parameters) -> bool {
    let counts: Vec<Vec<usize>> = samples
        .iter()
        .map(|all| all.iter().map(Vec::len).collect())
        .collect();
    let strokes: Vec<Vec<&PerceivedVibration>> = samples
        .iter()
        .map(|all| all.iter().flatten().collect())
        .collect();
    let p_value = chance::recordings_differ(&counts, (SHUFFLES, seed), |place, order, of| {
        let [all, one] = [order, of].map(|indices| {
            indices
                .iter()
                .map(|i| strokes[place][*i])
                .collect::<Vec<_>>()
        });
        apart_jnd(&all, &one, parameters).unwrap_or(0.0)
    });
    p_value.is_some_and(|p_value| p_value < POOLED_FROM)
}

fn apart_jnd(
    first: &[&PerceivedVibration],
    second: &[&PerceivedVibration],
    parameters: &Parameters,
) -> Option<f64> {
    let [a, b] = [first, second].map(PerceivedVibration::mean);
    Some(a?.difference(&b?, parameters).jnd.value)
}

/// Adds the permutation test to the pairs that differ over time in some setting; a pair that is not tested counts as one that shows nothing.
fn test(found: &mut AcrossSamples, samples: &[Vec<Option<Sample>>], parameters: &Parameters) {
    let (alpha, seed) = (found.config.alpha, found.config.seed);
    let places: Vec<Vec<(usize, usize)>> = by_name(&found.settings).into_values().collect();
    let draws = (40 * places.len()).clamp(2000, MOST_DRAWS) - 1;
    let mut p_values = vec![1.0; places.len()];
    let mut tested = BTreeMap::new();
    for (family, places) in places.iter().enumerate() {
        let differs = |(setting, place): &&(usize, usize)| {
            let mut criteria = found.settings[*setting].pairs[*place].criteria.iter();
            criteria.any(|c| c.what == PairCriterion::OverTime && c.outcome == Outcome::NotMet)
        };
        if !places.iter().any(|place| differs(&place)) {
            continue;
        }
        let strata: Vec<(Vec<&PerceivedVibration>, usize)> = places
            .iter()
            .filter_map(|(setting, place)| {
                let pair = &found.settings[*setting].pairs[*place];
                let [a, b] = [pair.a, pair.b].map(|i| samples[*setting][i].as_ref());
                let (a, b) = a.zip(b)?;
                let several = a.recordings > 1 && b.recordings > 1;
                several.then(|| (a.units.iter().chain(&b.units).collect(), a.units.len()))
            })
            .collect();
        let counts: Vec<[usize; 2]> = strata.iter().map(|(u, first)| [u.len(), *first]).collect();
        let permuted = permutation_test_within(&counts, draws, seed, &mut |chosen| {
            let each = strata
                .iter()
                .zip(chosen)
                .filter_map(|((units, _), chosen)| {
                    let (mut one, mut other) = (Vec::new(), Vec::new());
                    for (i, unit) in units.iter().enumerate() {
                        if chosen.contains(&i) {
                            one.push(*unit);
                        } else {
                            other.push(*unit);
                        }
                    }
                    apart_jnd(&one, &other, parameters)
                });
            each.sum()
        });
        p_values[family] = permuted.p_value;
        tested.insert(family, places);
    }
    let adjusted = holm(&p_values);
    let limit = Limit::AtMost {
        met: alpha,
        not_met: 1.0,
    };
    for (family, places) in tested {
        let p = adjusted[family];
        for (setting, place) in places {
            let criterion = Criterion::new(PairCriterion::ChanceOverTime, "", p, None, limit);
            found.settings[*setting].pairs[*place]
                .criteria
                .push(criterion);
        }
    }
}
