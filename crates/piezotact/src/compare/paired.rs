//! Two conditions of the same people.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::t_quantile;

/// How two conditions differ over people who took part in both; `u` is the unit of the values.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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
/// use piezotact::compare::paired_difference;
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
    let mean = crate::series::mean(&differences);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cannot_be_tested_is_not() {
        assert_eq!(paired_difference(&[1.0], &[2.0]), None);
        assert_eq!(paired_difference(&[1.0, 2.0], &[2.0]), None);
        assert_eq!(paired_difference(&[1.0, 2.0], &[2.0, 3.0]), None);
        assert_eq!(paired_difference(&[1.0, f64::NAN], &[2.0, 3.0]), None);
    }
}
