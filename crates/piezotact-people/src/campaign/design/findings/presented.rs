//! The tests of association that participants are presented with.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

use super::super::chance::{Matches, permutation_matches, rule_matches, trial_matches};
use super::super::error::DesignError;
use super::super::sequence::{SequenceRule, is_permutation, sequence_distribution};

/// One test of association.
#[derive(Clone)]
pub(super) struct Test {
    pub(super) set: usize,
    pub(super) mean_length: f64,
    pub(super) chance: Matches,
    pub(super) independent: Matches,
    /// What people reach who answer each sample once wherever each is presented once.
    pub(super) each_once: Matches,
    pub(super) forced_share: f64,
    pub(super) permutation_share: f64,
    /// Mean presentations of each sample of the set.
    pub(super) presentations: Vec<f64>,
    /// The stimuli presented by their own names, each as often as it is; none where they are the samples of the set.
    pub(super) stimuli: Vec<String>,
}

/// The tests of association of all sets. Fixed sequences leave the last answer to exclusion where all of them are
/// permutations: one that repeats a sample shows participants that they cannot rely on it.
pub(super) fn tests(
    names: &[Vec<String>],
    rule: &SequenceRule,
    blocks: &[Vec<usize>],
) -> Result<Vec<Test>, DesignError> {
    if blocks.is_empty() {
        return Err(DesignError::NoSets);
    }
    let SequenceRule::Fixed { tests, stimuli } = rule else {
        // Once for each size: sets of the same size have the same sequences.
        let mut of_size: BTreeMap<usize, Test> = BTreeMap::new();
        for (set, size) in blocks.iter().map(Vec::len).enumerate() {
            if let Entry::Vacant(free) = of_size.entry(size) {
                free.insert(drawn_test(rule, set, size)?);
            }
        }
        let of_set = |(set, block): (usize, &Vec<usize>)| {
            let test = of_size.get(&block.len())?;
            Some(Test {
                set,
                ..test.clone()
            })
        };
        return Ok(blocks.iter().enumerate().filter_map(of_set).collect());
    };
    if tests.len() != blocks.len() || tests.iter().any(Vec::is_empty) {
        let found = tests.iter().filter(|of| !of.is_empty()).count();
        return Err(DesignError::FixedSequences {
            found,
            expected: blocks.len(),
        });
    }
    let mut all: Vec<(usize, Vec<usize>, Vec<String>)> = Vec::new();
    for (set, of_set) in tests.iter().enumerate() {
        for (number, test) in of_set.iter().enumerate() {
            let place = |sample: &String| {
                names[set]
                    .iter()
                    .position(|own| own == sample)
                    .ok_or_else(|| DesignError::UnknownSample {
                        set: set + 1,
                        sample: sample.clone(),
                    })
            };
            let places = test.iter().map(place).collect::<Result<Vec<_>, _>>()?;
            if places.is_empty() {
                return Err(DesignError::ImpossibleLengths {
                    shortest: 0,
                    longest: 0,
                });
            }
            let own = stimuli.get(set).and_then(|of| of.get(number));
            all.push((set, places, own.cloned().unwrap_or_default()));
        }
    }
    let permuted =
        |(set, test, _): &(usize, Vec<usize>, _)| is_permutation(test, blocks[*set].len());
    let exclusion = all.iter().all(permuted);
    let test = |one: &(usize, Vec<usize>, Vec<String>)| {
        let (set, places, own) = one;
        let size = blocks[*set].len();
        let independent = trial_matches(size, places.len());
        let count = |place: usize| places.iter().filter(|at| **at == place).count() as f64;
        Test {
            each_once: match permuted(one) {
                true => permutation_matches(size),
                false => independent.clone(),
            },
            set: *set,
            mean_length: places.len() as f64,
            chance: if exclusion {
                permutation_matches(size)
            } else {
                independent.clone()
            },
            independent,
            forced_share: if exclusion { 1.0 } else { 0.0 },
            permutation_share: if permuted(one) { 1.0 } else { 0.0 },
            presentations: (0..size).map(count).collect(),
            stimuli: own.clone(),
        }
    };
    Ok(all.iter().map(test).collect())
}

fn drawn_test(rule: &SequenceRule, set: usize, size: usize) -> Result<Test, DesignError> {
    let distribution = sequence_distribution(rule, size)?;
    let chance = rule_matches(rule, size)?;
    let independent = match *rule {
        SequenceRule::Independent { .. } => chance.clone(),
        SequenceRule::AtMost {
            shortest, longest, ..
        } => rule_matches(&SequenceRule::Independent { shortest, longest }, size)?,
        _ => trial_matches(size, size),
    };
    Ok(Test {
        set,
        mean_length: distribution.mean_length,
        each_once: chance.clone(),
        chance,
        independent,
        forced_share: distribution.forced_share,
        permutation_share: distribution.permutation_share,
        // By symmetry, all samples of a set are presented equally often.
        presentations: vec![distribution.mean_length / size as f64; size],
        stimuli: Vec::new(),
    })
}
