//! Paired contrasts over people, with their size.

use crate::eeg::cluster::ClusterError;
use piezotact::statistics::{PairedDifference, paired_difference};
use serde::{Deserialize, Serialize};
use statrs::distribution::{Continuous, ContinuousCDF, Gamma, Normal};

/// Differences that scatter by less than this, re the largest value, are the same but for rounding.
const SAME: f64 = 1e-9;

/// A contrast of two conditions of the same people.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Contrast {
    /// The mean of b − a, with its 95 % interval and Student's t.
    pub difference: PairedDifference,
    /// Cohen's `d_z`: the mean of the differences in their standard deviations.
    pub d_z: f64,
    /// Its 95 % interval.
    pub d_z_interval: [f64; 2],
}

/// The contrast b − a over people who have both values, in their unit; each list has one value of each person, in one order.
///
/// Formula: `d_z` = t/√n; its interval holds the δ/√n for which a noncentral t of n − 1 degrees of freedom is as small or as large as the one
/// found with a probability of 2.5 %.
///
/// Source: J. Cohen (1988), *Statistical Power Analysis*, section 2.3.5; M. R. Steiger and R. T. Fouladi (1997), in *What if there were no
/// significance tests?*, for the interval.
///
/// # Errors
/// [`ClusterError`] for lists of different lengths, fewer than 3 people, a value that is no finite number, or differences that are all the
/// same.
pub fn paired(a: &[f64], b: &[f64]) -> Result<Contrast, ClusterError> {
    if a.len() != b.len() || a.len() < 3 {
        return Err(ClusterError::FewPairs {
            a: a.len(),
            b: b.len(),
        });
    }
    // In an order of their own, so that the order of people changes no digit.
    let mut pairs: Vec<(f64, f64)> = a.iter().copied().zip(b.iter().copied()).collect();
    pairs.sort_by(|x, y| {
        let of = |pair: &(f64, f64)| (pair.1 - pair.0).abs();
        of(x).total_cmp(&of(y))
    });
    let differences = pairs.iter().map(|(a, b)| b - a);
    let [least, most] = differences.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], d| {
        [low.min(d), high.max(d)]
    });
    let size = pairs.iter().map(|(a, b)| a.abs().max(b.abs()));
    if most - least <= SAME * size.fold(0.0, f64::max) {
        return Err(ClusterError::NoSpread);
    }
    let (a, b): (Vec<f64>, Vec<f64>) = pairs.into_iter().unzip();
    let difference = paired_difference(&a, &b).ok_or(ClusterError::NoSpread)?;
    let n = a.len() as f64;
    let freedom = n - 1.0;
    let at = |share: f64| noncentrality(difference.t, freedom, share) / n.sqrt();
    Ok(Contrast {
        difference,
        d_z: difference.t / n.sqrt(),
        d_z_interval: [at(0.975), at(0.025)],
    })
}

/// The noncentrality for which a noncentral t is at most `t` with the probability `share`.
fn noncentrality(t: f64, freedom: f64, share: f64) -> f64 {
    let reach = 12.0 + 6.0 * t.abs() / freedom.sqrt();
    let (mut low, mut high) = (t - reach, t + reach);
    for _ in 0..80 {
        let middle = 0.5 * (low + high);
        if noncentral_t(t, freedom, middle) > share {
            low = middle;
        } else {
            high = middle;
        }
    }
    0.5 * (low + high)
}

/// The probability of a noncentral t up to `t`: ∫ Φ(t·u − δ)·f(u) du over u = √(χ²/ν), by Simpson's rule.
fn noncentral_t(t: f64, freedom: f64, delta: f64) -> f64 {
    let (Ok(normal), Ok(gamma)) = (Normal::new(0.0, 1.0), Gamma::new(freedom / 2.0, 0.5)) else {
        return f64::NAN;
    };
    let reach = 9.0 / (2.0 * freedom).sqrt();
    let (from, to) = ((1.0 - reach).max(0.0), 1.0 + reach);
    let steps = 600;
    let width = (to - from) / f64::from(steps);
    let sum: f64 = (0..=steps)
        .map(|i| {
            let u = from + f64::from(i) * width;
            let density = if u > 0.0 {
                gamma.pdf(freedom * u * u) * 2.0 * freedom * u
            } else {
                0.0
            };
            let weight = match i {
                0 => 1.0,
                i if i == steps => 1.0,
                i if i % 2 == 1 => 4.0,
                _ => 2.0,
            };
            weight * density * normal.cdf(t * u - delta)
        })
        .sum();
    sum * width / 3.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_are_those_of_the_noncentral_t() {
        // SciPy 1.17.1: scipy.stats.nct.cdf(t, freedom, delta).
        for (t, freedom, delta, expected) in CDF {
            let found = noncentral_t(t, freedom, delta);
            assert!(
                (found - expected).abs() < 1e-7,
                "{t} {freedom} {delta}: {found}"
            );
        }
    }

    const CDF: [(f64, f64, f64, f64); 3] = [
        (2.5, 9.0, 1.2, NCT[0]),
        (-1.0, 4.0, 0.5, NCT[1]),
        (6.0, 2.0, 3.0, NCT[2]),
    ];
    const NCT: [f64; 3] = [
        0.856_758_195_877_115_9,
        0.086_149_569_036_562_82,
        0.768_074_587_052_531_7,
    ];

    #[test]
    fn the_order_of_people_and_conditions_changes_nothing() {
        let a = [1.0, 2.5, 3.0, 2.2, 0.7];
        let b = [1.5, 2.7, 4.2, 2.1, 1.9];
        let found = paired(&a, &b).unwrap();
        let turned = |x: &[f64; 5]| [x[3], x[0], x[4], x[2], x[1]];
        assert_eq!(paired(&turned(&a), &turned(&b)).unwrap(), found);
        let back = paired(&b, &a).unwrap();
        assert_eq!(back.d_z, -found.d_z);
        assert!((back.d_z_interval[0] + found.d_z_interval[1]).abs() < 1e-6);
        assert!(found.d_z_interval[0] < found.d_z && found.d_z < found.d_z_interval[1]);
        assert!(paired(&a[..2], &b[..2]).is_err() && paired(&a, &b[..4]).is_err());
        assert_eq!(paired(&a, &a), Err(ClusterError::NoSpread));
        // The same difference of all people, but for rounding.
        let moved = a.map(|value| (value + 0.1) - 0.3 + 0.4);
        assert_eq!(paired(&a, &moved), Err(ClusterError::NoSpread));
    }
}
