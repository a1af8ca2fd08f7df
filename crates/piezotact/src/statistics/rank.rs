//! Ranks, and Spearman's rank correlation with its significance.

use serde::{Deserialize, Serialize};

use super::Direction;
use super::student::two_sided_p;

/// With no more pairs than this, every order of them is counted.
const COUNTED: usize = 9;
/// A probability below this shows a direction.
const SIGNIFICANT: f64 = 0.05;

/// The ranks of `values` from 1, equal values sharing the mean of their ranks.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|a, b| values[*a].total_cmp(&values[*b]));
    let mut ranks = vec![0.0; values.len()];
    let mut at = 0;
    for ties in order.chunk_by(|a, b| values[*a].total_cmp(&values[*b]).is_eq()) {
        let shared = at as f64 + 0.5 * (ties.len() as f64 + 1.0);
        for &i in ties {
            ranks[i] = shared;
        }
        at += ties.len();
    }
    ranks
}

/// Spearman's rank correlation of two lists of the same length, −1–1; `None` for fewer than three pairs or when one
/// of the lists never changes.
///
/// Formula: Pearson's correlation of the ranks, ties sharing their mean rank.
///
/// Source: C. Spearman (1904), Am. J. Psychol. 15(1).
///
/// ```
/// use piezotact::statistics::spearman;
/// let rho = spearman(&[1.0, 2.0, 3.0, 4.0], &[10.0, 30.0, 20.0, 40.0]).unwrap();
/// assert!((rho - 0.8).abs() < 1e-12);
/// ```
#[must_use]
pub fn spearman(a: &[f64], b: &[f64]) -> Option<f64> {
    if a.len() != b.len() || a.len() < 3 || a.iter().chain(b).any(|v| v.is_nan()) {
        return None;
    }
    let (a, b) = (ranks(a), ranks(b));
    let middle = 0.5 * (a.len() as f64 + 1.0);
    let product = |x: &[f64], y: &[f64]| -> f64 {
        x.iter()
            .zip(y)
            .map(|(x, y)| (x - middle) * (y - middle))
            .sum()
    };
    let spread = product(&a, &a) * product(&b, &b);
    (spread > 0.0).then(|| product(&a, &b) / spread.sqrt())
}

/// How two quantities rank together over n pairs.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RankCorrelation {
    /// Spearman's rank correlation, −1–1.
    pub rho: f64,
    /// The probability, two-sided, of a correlation at least as strong had neither to do with the other.
    pub p_value: f64,
    /// The least that this probability can be with so many pairs, tied as they are.
    pub least_p: f64,
    /// The number of pairs.
    pub pairs: usize,
}

impl RankCorrelation {
    /// Whether one rises or falls with the other, at p < 0.05.
    #[must_use]
    pub fn direction(&self) -> Direction {
        match self.p_value < SIGNIFICANT {
            true if self.rho > 0.0 => Direction::Rises,
            true => Direction::Falls,
            false => Direction::NotShown,
        }
    }

    /// Whether there are too few pairs for any order of them to show a direction.
    #[must_use]
    pub fn too_few(&self) -> bool {
        self.least_p >= SIGNIFICANT
    }
}

/// Spearman's rank correlation of two lists of the same length with its probability; `None` where [`spearman`] has none.
///
/// Formula: up to nine pairs the share of all n! orders in which |ρ| is at least as large; beyond, Student's
/// t = ρ·√((n − 2)/(1 − ρ²)) with n − 2 degrees of freedom.
///
/// Source: C. Spearman (1904), Am. J. Psychol. 15(1); M. G. Kendall, *Rank Correlation Methods*, 4th ed., chapter 4; as
/// SciPy's `permutation_test` of `spearmanr` (pairings, all of them) and `spearmanr`.
///
/// ```
/// use piezotact::statistics::rank_correlation;
/// // One order of 24 is as strong, and its opposite.
/// let found = rank_correlation(&[1.0, 2.0, 3.0, 4.0], &[1.0, 4.0, 9.0, 16.0]).unwrap();
/// assert!((found.p_value - 2.0 / 24.0).abs() < 1e-12 && found.too_few());
/// ```
#[must_use]
pub fn rank_correlation(a: &[f64], b: &[f64]) -> Option<RankCorrelation> {
    let rho = spearman(a, b)?;
    let pairs = a.len();
    if pairs > COUNTED {
        let t = rho * ((pairs as f64 - 2.0) / (1.0 - rho * rho)).sqrt();
        return Some(RankCorrelation {
            rho,
            p_value: two_sided_p(t, pairs - 2)?,
            least_p: 0.0,
            pairs,
        });
    }
    let middle = 0.5 * (pairs as f64 + 1.0);
    let centred =
        |values: &[f64]| -> Vec<f64> { ranks(values).iter().map(|r| r - middle).collect() };
    let (a, b) = (centred(a), centred(b));
    let own: f64 = a.iter().zip(&b).map(|(a, b)| a * b).sum();
    let mut sums = Vec::new();
    all_orders(&a, &b, 0, 0.0, &mut sums);
    // Sums of halves of whole numbers: equal ones are equal but for rounding.
    let share = |least: f64| {
        let as_strong = sums.iter().filter(|sum| sum.abs() >= least - 1e-9).count();
        as_strong as f64 / sums.len() as f64
    };
    let strongest = sums.iter().fold(0.0, |most: f64, sum| most.max(sum.abs()));
    Some(RankCorrelation {
        rho,
        p_value: share(own.abs()),
        least_p: share(strongest),
        pairs,
    })
}

/// The sum of the products of `a` with every order of the values of `b` that `taken`, a bit each, leaves.
fn all_orders(a: &[f64], b: &[f64], taken: u32, sum: f64, sums: &mut Vec<f64>) {
    let Some((first, rest)) = a.split_first() else {
        sums.push(sum);
        return;
    };
    for (i, value) in b.iter().enumerate().filter(|(i, _)| taken >> i & 1 == 0) {
        all_orders(rest, b, taken | 1 << i, sum + first * value, sums);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ties_share_their_rank() {
        assert_eq!(ranks(&[3.0, 1.0, 3.0, 2.0]), [3.5, 1.0, 3.5, 2.0]);
        assert_eq!(spearman(&[1.0, 2.0, 3.0], &[2.0, 2.0, 2.0]), None);
        assert_eq!(spearman(&[1.0, 2.0], &[2.0, 2.0]), None);
    }
}
