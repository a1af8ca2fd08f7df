//! How often participants meet both of what is compared, by the rules from which their sequences are drawn.

use std::collections::BTreeMap;

use super::super::description::{TaskDescription, TaskKind};
use super::super::error::DesignError;
use super::super::sequence::{SequenceRule, enumerated};
use super::Work;
use crate::campaign::random::Stream;
use crate::difference::Difference;

/// Participants that are drawn where sequences are.
const DRAWN: usize = 1000;

/// How often both are met in one test: by its possible lengths, each as probable, the possible sequences, each as probable.
type Lengths = Vec<Vec<[usize; 2]>>;

/// A test of a participant, and what may be met in it.
struct Test {
    /// Its set, by which participants who share the sets have it or not.
    set: usize,
    /// How often each participant does it.
    repeats: usize,
    lengths: Lengths,
}

/// How often participants meet both.
pub(super) struct Met<'a> {
    work: &'a Work<'a>,
    tests: Vec<Test>,
}

impl Work<'_> {
    /// How often participants meet both of `difference` in `tasks`: of samples, in sets that have both; of tasks, the answers of the
    /// first and of the second; of groups and of the same people again, the answers of the tasks twice.
    pub(super) fn met(
        &self,
        difference: &Difference,
        tasks: [&[&TaskDescription]; 2],
    ) -> Result<Met<'_>, DesignError> {
        let mut tests = Vec::new();
        match difference {
            Difference::Samples(both) => {
                for task in tasks[0] {
                    let counted = |names: &[&str]| {
                        both.each_ref()
                            .map(|own| names.iter().filter(|name| **name == own.as_str()).count())
                    };
                    tests.extend(self.tests_of(task, &counted)?);
                }
                let has_both =
                    |test: &Test| self.has(test.set, &both[0]) && self.has(test.set, &both[1]);
                tests.retain(has_both);
            }
            Difference::Tasks(_) => {
                for (place, tasks) in tasks.into_iter().enumerate() {
                    for task in tasks {
                        let counted = |names: &[&str]| {
                            let mut counts = [0; 2];
                            counts[place] = names.len();
                            counts
                        };
                        tests.extend(self.tests_of(task, &counted)?);
                    }
                }
            }
            Difference::People(_) | Difference::Again(_) => {
                for task in tasks[0] {
                    tests.extend(self.tests_of(task, &|names| [names.len(); 2])?);
                }
            }
        }
        Ok(Met { work: self, tests })
    }

    /// Whether a set has a sample.
    pub(super) fn has(&self, set: usize, sample: &str) -> bool {
        let samples = &self.campaign.samples;
        self.blocks[set].iter().any(|i| samples[*i] == sample)
    }

    /// The tests of a task of which answers name samples.
    fn tests_of(
        &self,
        task: &TaskDescription,
        counted: &dyn Fn(&[&str]) -> [usize; 2],
    ) -> Result<Vec<Test>, DesignError> {
        if self.blocks.is_empty() {
            return Err(DesignError::NoSets);
        }
        let samples = &self.campaign.samples;
        let of_set = |set: usize, places: &[usize]| {
            let names: Vec<&str> = places
                .iter()
                .map(|place| samples[self.blocks[set][*place]].as_str())
                .collect();
            counted(&names)
        };
        let mut sequences: BTreeMap<usize, Vec<Vec<Vec<usize>>>> = BTreeMap::new();
        let mut tests = Vec::new();
        for (set, block) in self.blocks.iter().enumerate() {
            let mut test = |lengths| {
                let repeats = task.repeats;
                tests.push(Test {
                    set,
                    repeats,
                    lengths,
                });
            };
            match &task.task {
                TaskKind::Associate {
                    sequence: SequenceRule::Fixed { tests, stimuli },
                } => {
                    for (number, names) in tests.get(set).into_iter().flatten().enumerate() {
                        let own = stimuli.get(set).and_then(|of| of.get(number));
                        let own = own.filter(|own| !own.is_empty()).unwrap_or(names);
                        let names: Vec<&str> = own.iter().map(String::as_str).collect();
                        test(vec![vec![counted(&names)]]);
                    }
                }
                TaskKind::Associate { sequence } => {
                    let of_size = match sequences.get(&block.len()) {
                        Some(known) => known,
                        None => sequences
                            .entry(block.len())
                            .or_insert(enumerated(sequence, block.len())?),
                    };
                    let lengths = of_size.iter();
                    test(
                        lengths
                            .map(|all| all.iter().map(|places| of_set(set, places)).collect())
                            .collect(),
                    );
                }
                TaskKind::IdentifyFromMemory => {
                    let all: Vec<usize> = (0..block.len()).collect();
                    test(vec![vec![of_set(set, &all)]]);
                }
                _ => {}
            }
        }
        Ok(tests)
    }
}

impl Met<'_> {
    /// The mean for one participant.
    pub(super) fn mean(&self) -> [f64; 2] {
        let shares = self.work.campaign.sets_shared_over as f64;
        let mut sum = [0.0; 2];
        for test in &self.tests {
            for all in &test.lengths {
                let weight =
                    test.repeats as f64 / (test.lengths.len() * all.len().max(1)) as f64 / shares;
                for counts in all {
                    sum = [0, 1].map(|i| sum[i] + weight * counts[i] as f64);
                }
            }
        }
        sum
    }

    /// What participants may meet with `times` as many repeats: one for each where sequences are drawn, each as probable.
    pub(super) fn drawn(&self, times: usize) -> Vec<[usize; 2]> {
        let sets = self.work.blocks.len().max(1);
        let shares = self.work.campaign.sets_shared_over.max(1);
        let is_drawn = |test: &Test| test.lengths.len() > 1 || test.lengths[0].len() > 1;
        let people = match self.tests.iter().any(is_drawn) {
            true => DRAWN,
            false => shares,
        };
        let mut draws = Stream::of(self.work.seed, &["power", "presented"]);
        let one = |person: usize| {
            let mut met = [0; 2];
            for test in &self.tests {
                // Those who share the sets have neighbouring ones.
                if test.set * shares / sets != person % shares {
                    continue;
                }
                for _ in 0..test.repeats * times {
                    let all = &test.lengths[draws.below(test.lengths.len())];
                    let counts = all[draws.below(all.len())];
                    met = [0, 1].map(|i| met[i] + counts[i]);
                }
            }
            met
        };
        (0..people).map(one).collect()
    }
}
