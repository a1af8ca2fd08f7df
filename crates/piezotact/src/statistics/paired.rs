//! Two conditions of the same people.

use serde::{Deserialize, Serialize};
use statrs::distribution::{Binomial, ContinuousCDF, DiscreteCDF, StudentsT};

use super::{mean, t_quantile};

/// How two conditions differ over people who took part in both; `u` is the unit of the values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PairedDifference {
    /// The mean of b − a, u.
    pub mean: f64,
    /// Its 95 % confidence interval, u.
    pub interval: [f64; 2],
    /// Student's t of it.
    pub t: f64,
    /// The probability, two-sided, of a difference at least as large were there none.
    pub p_value: f64,
    /// The number of pairs.
    pub pairs: usize,
}

/// The mean difference b − a over pairs, with its interval and Student's paired t test; `None` for fewer than two
/// pairs, lists of different lengths, or differences that are all the same.
///
/// Formula: t = `d̄/(s_d/√n)` with n − 1 degrees of freedom.
///
/// Source: Student (1908), Biometrika 6(1).
///
/// ```
/// use piezotact::statistics::paired_difference;
/// let d = paired_difference(&[1.0, 2.0, 3.0], &[2.0, 4.0, 3.0]).unwrap();
/// assert!((d.mean - 1.0).abs() < 1e-12 && (d.t - 3f64.sqrt()).abs() < 1e-12);
/// ```
#[must_use]
pub fn paired_difference(a: &[f64], b: &[f64]) -> Option<PairedDifference> {
    if a.len() != b.len() || a.len() < 2 {
        return None;
    }
    let differences: Vec<f64> = a.iter().zip(b).map(|(a, b)| b - a).collect();
    let n = differences.len() as f64;
    let mean = mean(&differences);
    let squares: f64 = differences.iter().map(|d| (d - mean) * (d - mean)).sum();
    let error = (squares / (n - 1.0) / n).sqrt();
    if !(error > 0.0 && error.is_finite()) {
        return None;
    }
    let t = mean / error;
    let freedom = differences.len() - 1;
    let reach = t_quantile(freedom)? * error;
    let distribution = StudentsT::new(0.0, 1.0, freedom as f64).ok()?;
    Some(PairedDifference {
        mean,
        interval: [mean - reach, mean + reach],
        t,
        p_value: 2.0 * distribution.cdf(-t.abs()),
        pairs: differences.len(),
    })
}

/// The 95 % confidence interval of the mean of `values`, in their unit; `None` for fewer than two.
///
/// Formula: mean ± t·s/√n with n − 1 degrees of freedom.
///
/// Source: Student (1908), Biometrika 6(1).
#[must_use]
pub fn mean_interval(values: &[f64]) -> Option<[f64; 2]> {
    let n = values.len() as f64;
    let t = t_quantile(values.len().checked_sub(1)?)?;
    let mean = mean(values);
    let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    let reach = t * (squares / (n - 1.0) / n).sqrt();
    Some([mean - reach, mean + reach])
}

/// The two-sided probability that, of pairs which rise or fall with equal chance, as many or more of one kind are found as
/// among `differences`; those of zero do not count. `None` without a difference.
///
/// Formula: min(1, 2·P(X ≥ max(rising, falling))) with X binomial of one half.
///
/// Source: J. Arbuthnot (1710), Phil. Trans. 27; as SciPy's `binomtest(k, n, 0.5)`.
///
/// ```
/// use piezotact::statistics::sign_test;
/// // 2·(1 + 8)/2^8
/// let p = sign_test(&[1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, -1.0]).unwrap();
/// assert!((p - 0.0703125).abs() < 1e-12);
/// ```
#[must_use]
pub fn sign_test(differences: &[f64]) -> Option<f64> {
    let rising = differences.iter().filter(|d| **d > 0.0).count() as u64;
    let falling = differences.iter().filter(|d| **d < 0.0).count() as u64;
    let pairs = rising + falling;
    let most = rising.max(falling);
    let binomial = Binomial::new(0.5, pairs).ok().filter(|_| pairs > 0)?;
    // P(X ≥ most) = P(X > most − 1).
    let tail = most.checked_sub(1).map_or(1.0, |below| binomial.sf(below));
    Some((2.0 * tail).min(1.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signs_that_are_even_say_nothing() {
        assert_eq!(sign_test(&[1.0, -1.0]), Some(1.0));
        assert_eq!(sign_test(&[0.0]), None);
        // SciPy 1.17.1: binomtest(15, 20).pvalue
        let mut differences = vec![1.0; 15];
        differences.extend([-1.0; 5]);
        assert!((sign_test(&differences).unwrap() - 0.041_389_465_332_031_25).abs() < 1e-12);
    }

    #[test]
    fn what_cannot_be_tested_is_not() {
        assert_eq!(paired_difference(&[1.0], &[2.0]), None);
        assert_eq!(paired_difference(&[1.0, 2.0], &[2.0]), None);
        assert_eq!(paired_difference(&[1.0, 2.0], &[2.0, 3.0]), None);
        assert_eq!(paired_difference(&[1.0, f64::NAN], &[2.0, 3.0]), None);
    }
}
