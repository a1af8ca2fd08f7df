//! What chance alone reaches, enumerated.

use super::error::DesignError;
use super::sequence::{SequenceRule, enumerated};

/// The largest number of pairs of sequences that are compared.
const MOST_PAIRS: usize = 4_000_000;
/// Up to so many answers of all people together, their distribution is computed exactly.
const MOST_TOGETHER: usize = 5000;
/// The standard normal quantile of 95 %.
const Z95: f64 = 1.644_853_626_951_472_2;

/// The distribution of the number of answers that are right by chance.
#[derive(Clone, Debug, PartialEq)]
pub struct Matches {
    probability: Vec<f64>,
}

impl Matches {
    /// No test at all: 0 of 0 are right.
    #[must_use]
    pub fn none() -> Self {
        Self {
            probability: vec![1.0],
        }
    }

    /// The probability of each number of right answers, from 0 on.
    #[must_use]
    pub fn probability(&self) -> &[f64] {
        &self.probability
    }

    /// The mean number.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.probability
            .iter()
            .enumerate()
            .map(|(n, p)| n as f64 * p)
            .sum()
    }

    /// The standard deviation of the number.
    #[must_use]
    pub fn standard_deviation(&self) -> f64 {
        let mean = self.mean();
        let square = |(n, p): (usize, &f64)| (n as f64 - mean).powi(2) * p;
        self.probability
            .iter()
            .enumerate()
            .map(square)
            .sum::<f64>()
            .sqrt()
    }

    /// The probability of `number` right answers or more.
    #[must_use]
    pub fn at_least(&self, number: usize) -> f64 {
        self.probability.iter().skip(number).sum()
    }

    /// The smallest possible number that chance reaches with a probability of 5 % at most; `None` where even all right is more
    /// probable.
    #[must_use]
    pub fn beyond_chance_from(&self) -> Option<usize> {
        let possible = |n: &usize| self.probability[*n] > 0.0;
        let numbers = (0..self.probability.len()).filter(possible);
        numbers.into_iter().find(|n| self.at_least(*n) <= 0.05)
    }

    /// The same for the sum over `people` independent people. Above 5000 answers in all it is the next whole number from the 95th
    /// percentile of the normal distribution with the same mean and variance on.
    #[must_use]
    pub fn beyond_chance_together(&self, people: usize) -> Option<usize> {
        let most = (self.probability.len() - 1).saturating_mul(people);
        if most <= MOST_TOGETHER {
            return self.repeated(people).beyond_chance_from();
        }
        let spread = self.standard_deviation() * (people as f64).sqrt();
        let from = (self.mean() * people as f64 + Z95 * spread + 0.5).ceil();
        (from <= most as f64).then_some(from as usize)
    }

    /// The sum over this and another, independent test.
    #[must_use]
    pub fn and(&self, other: &Self) -> Self {
        let mut probability = vec![0.0; self.probability.len() + other.probability.len() - 1];
        for (i, p) in self.probability.iter().enumerate() {
            for (j, q) in other.probability.iter().enumerate() {
                probability[i + j] += p * q;
            }
        }
        Self { probability }
    }

    /// The sum over `tests` independent tests of this kind.
    #[must_use]
    pub fn repeated(&self, tests: usize) -> Self {
        (0..tests).fold(Self::none(), |sum, _| sum.and(self))
    }
}

/// Right answers of a random order of n = `samples`, each answered once: the probability of n − d fixed points of a
/// permutation. Nearly Poisson with mean 1 for a large n; for three 2/6, 3/6, 0, 1/6.
///
/// Source: Montmort (1713), Essay d'analyse sur les jeux de hazard; P(m) = 1/m! Σ (−1)^j/j!, j = 0 … n − m.
#[must_use]
pub fn permutation_matches(samples: usize) -> Matches {
    let mut inverse_factorials = vec![1.0; samples + 1];
    for i in 1..=samples {
        inverse_factorials[i] = inverse_factorials[i - 1] / i as f64;
    }
    let none_of = |n: usize| -> f64 {
        // The sum alternates to exactly 0 for one sample left.
        let term = |j: usize| {
            if j.is_multiple_of(2) {
                inverse_factorials[j]
            } else {
                -inverse_factorials[j]
            }
        };
        (0..=n).map(term).sum()
    };
    let probability = (0..=samples)
        .map(|m| inverse_factorials[m] * none_of(samples - m))
        .collect();
    Matches { probability }
}

/// Right answers of `trials` independent answers, each one of `alternatives`; none for no alternative.
///
/// Source: binomial distribution with p = 1/`alternatives`.
#[must_use]
pub fn trial_matches(alternatives: usize, trials: usize) -> Matches {
    let p = if alternatives == 0 {
        0.0
    } else {
        1.0 / alternatives as f64
    };
    let one = Matches {
        probability: vec![1.0 - p, p],
    };
    one.repeated(trials)
}

/// Right answers in one test of `rule` from a set of `set_size` by a person who answers with a random sequence of the same
/// rule: a permutation for permutations, and independent answers where stimuli are independent.
///
/// # Errors
///
/// A rule that cannot be, fixed sequences, or more than 4 000 000 pairs of sequences.
///
/// Source: enumerated over all pairs of sequences of one length; docs/decisions/campaigns.md.
pub fn rule_matches(rule: &SequenceRule, set_size: usize) -> Result<Matches, DesignError> {
    let by_length = enumerated(rule, set_size)?;
    let mut probability: Vec<f64> = Vec::new();
    let share = 1.0 / by_length.len() as f64;
    for all in &by_length {
        let length = all.first().map_or(0, Vec::len);
        let one = match rule {
            SequenceRule::Permutation => permutation_matches(set_size),
            SequenceRule::Independent { .. } => trial_matches(set_size, length),
            _ => pairs(all, set_size, length)?,
        };
        probability.resize(probability.len().max(length + 1), 0.0);
        for (sum, p) in probability.iter_mut().zip(&one.probability) {
            *sum += share * p;
        }
    }
    Ok(Matches { probability })
}

fn pairs(all: &[Vec<usize>], set_size: usize, length: usize) -> Result<Matches, DesignError> {
    let pairs = all.len().saturating_mul(all.len());
    if pairs > MOST_PAIRS {
        return Err(DesignError::TooManySequences {
            set_size,
            length,
            most: 2000,
        });
    }
    let mut counts = vec![0_usize; length + 1];
    for presented in all {
        for answered in all {
            counts[presented
                .iter()
                .zip(answered)
                .filter(|(a, b)| a == b)
                .count()] += 1;
        }
    }
    let probability = counts.iter().map(|n| *n as f64 / pairs as f64).collect();
    Ok(Matches { probability })
}

/// The standard deviation of Kendall's τ of a random order of n = `samples`: √(2(2n + 5)/(9n(n − 1))); `None` below two.
///
/// Source: Kendall (1938), Biometrika 30, 81.
#[must_use]
pub fn tau_null_sd(samples: usize) -> Option<f64> {
    let n = samples as f64;
    (samples >= 2).then(|| (2.0 * (2.0 * n + 5.0) / (9.0 * n * (n - 1.0))).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::association::kendall_tau_b;

    fn within(found: f64, truth: f64) {
        // Rounding of sums of a few hundred terms.
        assert!((found - truth).abs() < 1e-12, "{found} {truth}");
    }

    #[test]
    fn the_order_of_a_triplet() {
        let three = permutation_matches(3);
        for (found, truth) in three
            .probability()
            .iter()
            .zip([2.0 / 6.0, 0.5, 0.0, 1.0 / 6.0])
        {
            within(*found, truth);
        }
        within(three.mean(), 1.0);
        within(three.standard_deviation(), 1.0);
        within(permutation_matches(14).mean(), 1.0);
        assert_eq!(permutation_matches(3).beyond_chance_from(), None);
    }

    /// The closed forms against all pairs of sequences.
    #[test]
    fn closed_forms_are_those_of_the_enumeration() {
        for (rule, closed) in [
            (SequenceRule::Permutation, permutation_matches(4)),
            (
                SequenceRule::Independent {
                    shortest: 5,
                    longest: 5,
                },
                trial_matches(4, 5),
            ),
        ] {
            let all = enumerated(&rule, 4).unwrap();
            let counted = pairs(&all[0], 4, all[0][0].len()).unwrap();
            for (a, b) in counted.probability().iter().zip(closed.probability()) {
                within(*a, *b);
            }
        }
    }

    #[test]
    fn lengths_are_mixed() {
        let mixed = rule_matches(
            &SequenceRule::Independent {
                shortest: 3,
                longest: 4,
            },
            3,
        )
        .unwrap();
        within(mixed.mean(), 3.5 / 3.0);
        within(mixed.probability().iter().sum(), 1.0);
        within(mixed.at_least(4), 0.5 / 81.0);
    }

    /// Two orders of three have 0 to 4 or 6 right, never 5.
    #[test]
    fn a_threshold_is_a_number_that_can_be_reached() {
        let two = permutation_matches(3).repeated(2);
        assert_eq!(two.probability()[5], 0.0);
        within(two.at_least(5), 1.0 / 36.0);
        assert_eq!(two.beyond_chance_from(), Some(6));
    }

    /// The normal approximation where both are at hand: within one answer.
    #[test]
    fn the_threshold_of_many_people_is_that_of_the_exact_distribution() {
        let one = permutation_matches(3).repeated(8);
        for people in [1, 10, 208] {
            let exact = one.repeated(people).beyond_chance_from().unwrap();
            assert_eq!(one.beyond_chance_together(people), Some(exact), "{people}");
            let spread = one.standard_deviation() * (people as f64).sqrt();
            let normal = one.mean() * people as f64 + Z95 * spread + 0.5;
            assert!(
                (normal.ceil() - exact as f64).abs() <= 1.0,
                "{people}: {normal} {exact}"
            );
        }
    }

    #[test]
    fn spread_of_tau_by_enumeration() {
        let all = enumerated(&SequenceRule::Permutation, 6).unwrap().remove(0);
        let ranks = |one: &[usize]| one.iter().map(|rank| *rank as f64).collect::<Vec<_>>();
        let key = ranks(&[0, 1, 2, 3, 4, 5]);
        let tau = |one: &Vec<usize>| kendall_tau_b(&ranks(one), &key).unwrap();
        let squares: f64 = all.iter().map(|one| tau(one).powi(2)).sum();
        within((squares / 720.0).sqrt(), tau_null_sd(6).unwrap());
    }
}
