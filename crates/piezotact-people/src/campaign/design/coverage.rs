//! Which pairs of samples are presented together, counted.

use serde::{Deserialize, Serialize};

/// How many pairs are together in a number of sets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Together {
    /// The number of sets.
    pub sets: usize,
    /// The number of pairs.
    pub pairs: usize,
}

/// The pairs of samples that sets put together. Samples are indices.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PairCoverage {
    /// The number of sets.
    pub sets: usize,
    /// The number of sets that hold each sample.
    pub presentations: Vec<usize>,
    /// The number of sets that hold both samples; symmetric, 0 on the diagonal.
    pub counts: Vec<Vec<usize>>,
    /// The number of all pairs.
    pub pairs: usize,
    /// The number of pairs that are together in a set.
    pub together: usize,
    /// The pairs by the number of sets that hold both.
    pub times: Vec<Together>,
    /// The pairs that no set holds.
    pub never: Vec<[usize; 2]>,
}

impl PairCoverage {
    /// Counts the pairs of `points` samples in `sets` of indices. Indices from `points` on do not count.
    ///
    /// Source: counted; for a balanced design, Fisher and Yates (1938), Statistical Tables, "balanced incomplete blocks".
    #[must_use]
    pub fn of(points: usize, sets: &[Vec<usize>]) -> Self {
        let mut counts = vec![vec![0; points]; points];
        let mut presentations = vec![0; points];
        for set in sets {
            for (i, &a) in set.iter().enumerate().filter(|(_, a)| **a < points) {
                presentations[a] += 1;
                for &b in set[..i].iter().filter(|b| **b < points && **b != a) {
                    counts[a][b] += 1;
                    counts[b][a] += 1;
                }
            }
        }
        let mut never = Vec::new();
        let mut times: Vec<Together> = Vec::new();
        for (a, row) in counts.iter().enumerate() {
            for (b, &sets) in row.iter().enumerate().skip(a + 1) {
                if sets == 0 {
                    never.push([a, b]);
                }
                match times.iter_mut().find(|of| of.sets == sets) {
                    Some(of) => of.pairs += 1,
                    None => times.push(Together { sets, pairs: 1 }),
                }
            }
        }
        times.sort_by_key(|of| of.sets);
        let pairs = points * points.saturating_sub(1) / 2;
        Self {
            sets: sets.len(),
            presentations,
            counts,
            pairs,
            together: pairs - never.len(),
            times,
            never,
        }
    }

    /// Whether every pair is together in the same number of sets, 1 or more, and every sample in as many.
    #[must_use]
    pub fn is_balanced(&self) -> bool {
        let even = self
            .presentations
            .iter()
            .all(|n| Some(n) == self.presentations.first());
        even && matches!(self.times[..], [Together { sets, .. }] if sets > 0)
    }

    /// Whether every pair is together at least once.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        self.never.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_are_counted() {
        let found = PairCoverage::of(4, &[vec![0, 1, 2], vec![0, 1]]);
        assert_eq!((found.pairs, found.together), (6, 3));
        assert_eq!(found.never, [[0, 3], [1, 3], [2, 3]]);
        assert_eq!(found.presentations, [2, 2, 1, 0]);
        assert_eq!(found.counts[1][0], 2);
        assert!(!found.is_complete() && !found.is_balanced());
        assert!(PairCoverage::of(3, &[vec![0, 1, 2]]).is_balanced());
        // Complete and not balanced.
        let uneven = PairCoverage::of(3, &[vec![0, 1, 2], vec![0, 1]]);
        assert!(uneven.is_complete() && !uneven.is_balanced());
    }
}
