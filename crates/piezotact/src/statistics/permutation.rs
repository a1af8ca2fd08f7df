//! Permutation tests: what a statistic of two groups is where it does not matter which value belongs to which.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use serde::{Deserialize, Serialize};

/// Up to as many divisions are all tried; of more a sample is drawn.
const EXHAUSTIVE: u128 = 20_000;
/// Statistics that differ by less than this share are the same number, computed in another order.
const SAME: f64 = 1e-9;

/// Draws without a preference, from a seed.
pub(crate) struct Draws(ChaCha8Rng);

impl Draws {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// A whole number below `count`.
    fn below(&mut self, count: usize) -> usize {
        // The multiply-and-shift of D. Lemire; the bias is below 2⁻³² of what is drawn here.
        ((u128::from(self.0.next_u64()) * count as u128) >> 64) as usize
    }

    /// Brings `values` into an order of which every one is as likely as every other.
    pub(crate) fn shuffle<T>(&mut self, values: &mut [T]) {
        for i in (1..values.len()).rev() {
            values.swap(i, self.below(i + 1));
        }
    }
}

/// The result of a permutation test.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Permuted {
    /// The share of divisions whose statistic is at least the one observed.
    pub p_value: f64,
    /// The divisions looked at.
    pub divisions: usize,
    /// Whether they are all that there are.
    pub exhaustive: bool,
}

/// The number of ways to choose `chosen` of `all`, at most `u128::MAX`.
fn divisions(all: usize, chosen: usize) -> u128 {
    let chosen = chosen.min(all - chosen);
    (0..chosen).fold(1u128, |ways, i| {
        ways.saturating_mul((all - i) as u128) / (i as u128 + 1)
    })
}

/// The probability of a `statistic` of the first `first` of `count` units and the others at least as large as observed, were it
/// chance which unit belongs to which group. The statistic gets the indices of the first group, ascending or not.
///
/// Formula: over all divisions when there are 20 000 or fewer, the share of those at least as large; or else (k + 1)/(n + 1) with k
/// of n = `draws` divisions drawn with `ChaCha8` from `seed`.
///
/// Source: R. A. Fisher (1935), *The Design of Experiments*; B. Phipson and G. K. Smyth (2010), Stat. Appl. Genet. Mol. Biol. 9(1)
/// for the counts; equal to `scipy.stats.permutation_test` with `alternative="greater"`.
///
/// ```
/// use piezotact::statistics::permutation_test;
/// let values = [1.0, 2.0, 3.0, 11.0, 12.0, 13.0];
/// let sum: f64 = values.iter().sum();
/// let test = permutation_test(6, 3, 999, 1, &mut |first: &[usize]| {
///     let part: f64 = first.iter().map(|i| values[*i]).sum();
///     (sum - 2.0 * part).abs()
/// });
/// assert!(test.exhaustive && (test.p_value - 2.0 / 20.0).abs() < 1e-12);
/// ```
#[must_use]
pub fn permutation_test(
    count: usize,
    first: usize,
    draws: usize,
    seed: u64,
    statistic: &mut dyn FnMut(&[usize]) -> f64,
) -> Permuted {
    let first = first.min(count);
    let mut chosen: Vec<usize> = (0..first).collect();
    let observed = statistic(&chosen);
    let least = observed - SAME * observed.abs();
    if divisions(count, first) <= EXHAUSTIVE {
        let (mut all, mut larger) = (0usize, 0usize);
        loop {
            all += 1;
            larger += usize::from(statistic(&chosen) >= least);
            if !next_combination(&mut chosen, count) {
                break;
            }
        }
        return Permuted {
            p_value: larger as f64 / all as f64,
            divisions: all,
            exhaustive: true,
        };
    }
    let mut random = Draws::new(seed);
    let mut order: Vec<usize> = (0..count).collect();
    let mut larger = 0usize;
    for _ in 0..draws {
        random.shuffle(&mut order);
        larger += usize::from(statistic(&order[..first]) >= least);
    }
    Permuted {
        p_value: (larger + 1) as f64 / (draws + 1) as f64,
        divisions: draws,
        exhaustive: false,
    }
}

/// As [`permutation_test`] of units that are exchanged within strata only, such as speeds: each of `strata` is how many units it has, and how many
/// of them are of the first group. The statistic gets the indices of the first group in every stratum. Divisions of several strata are drawn.
///
/// Formula: (k + 1)/(n + 1) with k of n = `draws` divisions drawn with `ChaCha8` from `seed`; one stratum as [`permutation_test`].
///
/// Source: as [`permutation_test`]; E. S. Edgington and P. Onghena (2007), *Randomization Tests*, 4th ed., chapter 5, for strata.
///
/// ```
/// use piezotact::statistics::permutation_test_within;
/// // Two speeds with two units of each sample: 4 of 36 divisions are as far apart.
/// let values = [1.0f64, 2.0, 11.0, 12.0];
/// let test = permutation_test_within(&[[4, 2], [4, 2]], 9_999, 1, &mut |chosen| {
///     let apart = |first: &&[usize]| {
///         let part: f64 = first.iter().map(|i| values[*i]).sum();
///         (values.iter().sum::<f64>() - 2.0 * part).abs()
///     };
///     chosen.iter().map(apart).sum()
/// });
/// assert!((test.p_value - 4.0 / 36.0).abs() < 0.01);
/// ```
#[must_use]
pub fn permutation_test_within(
    strata: &[[usize; 2]],
    draws: usize,
    seed: u64,
    statistic: &mut dyn FnMut(&[&[usize]]) -> f64,
) -> Permuted {
    if let [[count, first]] = strata {
        return permutation_test(*count, *first, draws, seed, &mut |chosen| {
            statistic(&[chosen])
        });
    }
    let mut orders: Vec<Vec<usize>> = strata.iter().map(|[n, _]| (0..*n).collect()).collect();
    let chosen = |orders: &[Vec<usize>], statistic: &mut dyn FnMut(&[&[usize]]) -> f64| {
        let each = orders.iter().zip(strata);
        let each: Vec<&[usize]> = each.map(|(o, [n, k])| &o[..*k.min(n)]).collect();
        statistic(&each)
    };
    let observed = chosen(&orders, statistic);
    let least = observed - SAME * observed.abs();
    let mut random = Draws::new(seed);
    let mut larger = 0usize;
    for _ in 0..draws {
        orders.iter_mut().for_each(|order| random.shuffle(order));
        larger += usize::from(chosen(&orders, statistic) >= least);
    }
    Permuted {
        p_value: (larger + 1) as f64 / (draws + 1) as f64,
        divisions: draws,
        exhaustive: false,
    }
}

/// The probability of a mean of `differences` at least as far from zero as observed, were it chance which sign each has: a paired
/// test, in which each person is one difference. `None` where there is none, or one is not a number.
///
/// Formula: over all signs of up to 15 differences, the share of absolute means at least as large; or else (k + 1)/(n + 1) with k of n =
/// `draws` signs drawn with `ChaCha8` from `seed`.
///
/// Source: as [`permutation_test`]; equal to `scipy.stats.permutation_test` with `permutation_type="samples"` and the absolute mean.
///
/// ```
/// use piezotact::statistics::sign_flip_test;
/// // Six people who all differ in one direction: 2 of 2⁶ signs.
/// let test = sign_flip_test(&[0.1, 0.3, 0.2, 0.1, 0.4, 0.2], 999, 1).unwrap();
/// assert!(test.exhaustive && (test.p_value - 2.0 / 64.0).abs() < 1e-12);
/// ```
#[must_use]
pub fn sign_flip_test(differences: &[f64], draws: usize, seed: u64) -> Option<Permuted> {
    if differences.is_empty() || differences.iter().any(|d| !d.is_finite()) {
        return None;
    }
    let observed = differences.iter().sum::<f64>().abs();
    let all: f64 = differences.iter().map(|d| d.abs()).sum();
    let least = observed - SAME * all;
    // The sum and its opposite are as large: the last sign stays.
    let free = differences.len() - 1;
    if 1u128 << free.min(100) <= EXHAUSTIVE {
        let divisions = 1usize << free;
        let larger = (0..divisions).filter(|signs| {
            let signed = differences.iter().enumerate();
            let sum: f64 = signed
                .map(|(i, d)| if signs >> i & 1 == 1 { -d } else { *d })
                .sum();
            sum.abs() >= least
        });
        return Some(Permuted {
            p_value: larger.count() as f64 / divisions as f64,
            divisions,
            exhaustive: true,
        });
    }
    let mut random = Draws::new(seed);
    let mut larger = 0usize;
    for _ in 0..draws {
        let mut signs = 0u64;
        let mut sum = 0.0;
        for (i, d) in differences.iter().enumerate() {
            if i % 64 == 0 {
                signs = random.0.next_u64();
            }
            sum += if signs & 1 == 1 { -d } else { *d };
            signs >>= 1;
        }
        larger += usize::from(sum.abs() >= least);
    }
    Some(Permuted {
        p_value: (larger + 1) as f64 / (draws + 1) as f64,
        divisions: draws,
        exhaustive: false,
    })
}

/// The next of all sets of as many numbers below `count`, in order; false after the last.
fn next_combination(chosen: &mut [usize], count: usize) -> bool {
    let size = chosen.len();
    let movable = (0..size).rev().find(|i| chosen[*i] < count - size + i);
    let Some(at) = movable else {
        return false;
    };
    chosen[at] += 1;
    for i in at + 1..size {
        chosen[i] = chosen[i - 1] + 1;
    }
    true
}

/// The smallest probability that divisions of groups of `a` and `b` units can give; of groups of one size both ways to name them count.
///
/// Formula: 1 over the number of divisions, twice that for groups of one size.
///
/// Source: as [`permutation_test`].
#[must_use]
pub fn smallest_p(a: usize, b: usize) -> f64 {
    let same = if a == b { 2.0 } else { 1.0 };
    same / divisions(a + b, a) as f64
}

/// The smallest number of units in each of two groups, in each of `strata` strata, with which a permutation test can show a difference at `alpha`
/// over `pairs` pairs.
pub(crate) fn units_needed(pairs: usize, strata: usize, alpha: f64) -> usize {
    let shows = |n: usize| smallest_p(n, n).powi(strata.max(1) as i32) * pairs as f64 <= alpha;
    (2..64).find(|n| shows(*n)).unwrap_or(64)
}

/// Probabilities adjusted for all of them being looked at, in their order: those at most α are wrong, any of them, with a probability
/// of at most α.
///
/// Formula: the k-th smallest of n times n − k + 1, not below the one before, at most 1.
///
/// Source: S. Holm (1979), Scand. J. Stat. 6(2).
///
/// ```
/// use piezotact::statistics::holm;
/// assert_eq!(holm(&[0.01, 0.5, 0.02]), [0.03, 0.5, 0.04]);
/// ```
#[must_use]
pub fn holm(p_values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p_values.len()).collect();
    order.sort_by(|a, b| p_values[*a].total_cmp(&p_values[*b]));
    let mut adjusted = vec![1.0; p_values.len()];
    let mut last = 0.0f64;
    for (rank, &i) in order.iter().enumerate() {
        last = last.max((p_values[i] * (p_values.len() - rank) as f64).min(1.0));
        adjusted[i] = last;
    }
    adjusted
}
