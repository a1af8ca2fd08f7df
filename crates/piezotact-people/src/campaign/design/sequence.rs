//! Sequences of stimuli from a set, with repeats and omissions, so that no answer follows from the others.

use serde::{Deserialize, Serialize};

use super::error::DesignError;

/// The largest number of sequences of one length that is enumerated.
const MOST_SEQUENCES: usize = 100_000;

/// How the stimuli of one test are chosen from its set.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "rule", rename_all = "snake_case", deny_unknown_fields)]
pub enum SequenceRule {
    /// Every sample of the set once, in random order. The last answer follows from the others.
    Permutation,
    /// A length from `shortest` to `longest`, all equally probable; each stimulus is drawn from the whole set, whatever was drawn
    /// before. So earlier answers tell nothing about later ones.
    Independent {
        /// The shortest length.
        shortest: usize,
        /// The longest length.
        longest: usize,
    },
    /// A length from `shortest` to `longest`, all equally probable; then one of all sequences with at most `of_one` of each
    /// sample, all equally probable.
    AtMost {
        /// The shortest length.
        shortest: usize,
        /// The longest length.
        longest: usize,
        /// The largest number of one sample.
        of_one: usize,
    },
    /// The same for every participant: for each set its tests, each a sequence of samples of the set.
    Fixed {
        /// The tests of each set.
        tests: Vec<Vec<Vec<String>>>,
        /// The stimuli of the same tests by their own names, where manipulated textures are among them; none where all are samples.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        stimuli: Vec<Vec<Vec<String>>>,
    },
}

/// The exact distribution of the sequences of a rule: the lengths are equally probable, and so are the sequences of a length.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SequenceDistribution {
    /// The mean length.
    pub mean_length: f64,
    /// The share of sequences that hold every sample exactly once.
    pub permutation_share: f64,
    /// The share of sequences whose last answer follows from the others.
    pub forced_share: f64,
}

/// The lengths of a drawn rule and the largest number of one sample.
fn lengths(rule: &SequenceRule, set_size: usize) -> Result<(usize, usize, usize), DesignError> {
    let (shortest, longest, of_one) = match *rule {
        SequenceRule::Permutation => return Ok((set_size, set_size, 1)),
        SequenceRule::Independent { shortest, longest } => (shortest, longest, usize::MAX),
        SequenceRule::AtMost {
            shortest,
            longest,
            of_one,
        } => (shortest, longest, of_one),
        SequenceRule::Fixed { .. } => return Err(DesignError::FixedNotDrawn),
    };
    if shortest == 0 || shortest > longest {
        return Err(DesignError::ImpossibleLengths { shortest, longest });
    }
    if of_one.saturating_mul(set_size) <= longest {
        return Err(DesignError::ImpossibleRepeats {
            set_size,
            length: longest,
            of_one,
        });
    }
    Ok((shortest, longest, of_one))
}

/// All sequences of `length` of `set_size` samples with at most `of_one` of each, in lexical order.
fn allowed(set_size: usize, length: usize, of_one: usize) -> Result<Vec<Vec<usize>>, DesignError> {
    let mut all: Vec<Vec<usize>> = vec![Vec::new()];
    for _ in 0..length {
        let mut longer = Vec::with_capacity(all.len() * set_size);
        for sequence in &all {
            for next in 0..set_size {
                if sequence.iter().filter(|i| **i == next).count() < of_one {
                    let mut one = sequence.clone();
                    one.push(next);
                    longer.push(one);
                }
            }
            // At once: a large set has millions of sequences one stimulus later.
            if longer.len() > MOST_SEQUENCES {
                return Err(DesignError::TooManySequences {
                    set_size,
                    length,
                    most: MOST_SEQUENCES,
                });
            }
        }
        all = longer;
    }
    Ok(all)
}

/// The sequences of `rule` by length, each with its list.
pub(super) fn enumerated(
    rule: &SequenceRule,
    set_size: usize,
) -> Result<Vec<Vec<Vec<usize>>>, DesignError> {
    if set_size < 2 {
        return Err(DesignError::SetTooSmall {
            set: 1,
            found: set_size,
        });
    }
    let (shortest, longest, of_one) = lengths(rule, set_size)?;
    (shortest..=longest)
        .map(|length| allowed(set_size, length, of_one))
        .collect()
}

/// Whether `sequence` holds each of `set_size` samples exactly once.
pub(super) fn is_permutation(sequence: &[usize], set_size: usize) -> bool {
    sequence.len() == set_size && (0..set_size).all(|i| sequence.contains(&i))
}

/// The distribution of the sequences of `rule` from a set of `set_size`, counted over all of them.
///
/// # Errors
///
/// Fixed sequences, lengths or repeats that cannot be, a set of fewer than two, or more than 100 000 sequences of a length.
///
/// Source: enumerated; docs/decisions/campaigns.md.
pub fn sequence_distribution(
    rule: &SequenceRule,
    set_size: usize,
) -> Result<SequenceDistribution, DesignError> {
    let by_length = enumerated(rule, set_size)?;
    let mean = |of: &dyn Fn(&[Vec<usize>]) -> f64| {
        by_length.iter().map(|all| of(all)).sum::<f64>() / by_length.len() as f64
    };
    let share = |count: fn(&[Vec<usize>], usize) -> usize| {
        mean(&|all| count(all, set_size) as f64 / all.len() as f64)
    };
    Ok(SequenceDistribution {
        mean_length: mean(&|all| all.first().map_or(0, Vec::len) as f64),
        permutation_share: share(|all, n| all.iter().filter(|one| is_permutation(one, n)).count()),
        // In lexical order, sequences that differ in the last stimulus alone stand side by side.
        forced_share: share(|all, _| {
            let alike = all.chunk_by(|a, b| a[..a.len() - 1] == b[..b.len() - 1]);
            alike.filter(|same| same.len() == 1).count()
        }),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIPLETS: SequenceRule = SequenceRule::Independent {
        shortest: 3,
        longest: 4,
    };

    #[test]
    fn sequences_are_counted() {
        let stated = sequence_distribution(&TRIPLETS, 3).unwrap();
        let counts = enumerated(&TRIPLETS, 3).unwrap();
        assert_eq!([counts[0].len(), counts[1].len()], [27, 81]);
        assert!((stated.permutation_share - 0.5 * 6.0 / 27.0).abs() < 1e-15);
        assert!(stated.forced_share.abs() < 1e-15);
    }

    #[test]
    fn exclusion_is_counted() {
        let forced = |rule| sequence_distribution(&rule, 3).unwrap().forced_share;
        assert!((forced(SequenceRule::Permutation) - 1.0).abs() < 1e-15);
        let two = |shortest, longest| SequenceRule::AtMost {
            shortest,
            longest,
            of_one: 2,
        };
        assert!(forced(two(3, 3)).abs() < 1e-15);
        // aabb leaves c for the fifth stimulus: 3 choices of c, 6 orders, of 90 sequences.
        assert!((forced(two(5, 5)) - 18.0 / 90.0).abs() < 1e-15);
    }

    #[test]
    fn impossible_demands_are_refused() {
        let of = |rule: &SequenceRule, n| sequence_distribution(rule, n).map(|_| ());
        let at_most = |shortest, longest, of_one| SequenceRule::AtMost {
            shortest,
            longest,
            of_one,
        };
        assert!(matches!(
            of(&at_most(3, 3, 1), 3),
            Err(DesignError::ImpossibleRepeats { .. })
        ));
        assert!(matches!(
            of(&at_most(5, 7, 2), 3),
            Err(DesignError::ImpossibleRepeats { .. })
        ));
        assert!(matches!(
            of(&at_most(4, 3, 2), 3),
            Err(DesignError::ImpossibleLengths { .. })
        ));
        assert!(matches!(
            of(&at_most(0, 3, 2), 3),
            Err(DesignError::ImpossibleLengths { .. })
        ));
        let long = SequenceRule::Independent {
            shortest: 40,
            longest: 40,
        };
        assert!(matches!(
            of(&long, 3),
            Err(DesignError::TooManySequences { .. })
        ));
        assert!(matches!(
            of(&TRIPLETS, 1),
            Err(DesignError::SetTooSmall { .. })
        ));
        let fixed = SequenceRule::Fixed {
            tests: Vec::new(),
            stimuli: Vec::new(),
        };
        assert_eq!(of(&fixed, 3), Err(DesignError::FixedNotDrawn));
    }
}
