//! Comparisons: across samples, speeds, participants, and between active and passive touch.

mod groups;
mod lines;
mod paired;
mod period;
mod permutation;
mod rank;
mod summary;
mod telling;
mod trends;

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

pub use groups::{AcrossSamples, DiscriminationConfig, Texture, Withheld, discriminate};
pub use lines::{CommonLine, LineOrigin, LinesOf, common_lines, set_apart};
pub use paired::{PairedDifference, mean_interval, paired_difference, sign_test};
pub use period::{
    GroupPeriod, PeriodRule, PeriodUnit, Sliding, SpatialPeriod, SpeedPeak, spatial_period,
};
pub use permutation::{Permuted, holm, permutation_test};
pub use rank::{RankCorrelation, rank_correlation};
pub use summary::{Fingerprint, Periods, Summary, Tooth, summarise};
pub use telling::{Groups, Pair, PairCriterion, Sampled, Telling};
pub(crate) use trends::deviation_interval;
pub use trends::{
    ActivePassive, ActivePassivePair, LevelSpread, RoughnessTrend, across_participants,
    across_roughness, active_against_passive, friction_against_rms, rms_on_speed,
};

use crate::quantity::Band;

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
/// use piezotact::compare::spearman;
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

/// Which way one quantity goes with another, as far as the data carry it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Direction {
    /// It rises with the other: the 95 % interval lies above 0.
    Rises,
    /// It falls with the other: the 95 % interval lies below 0.
    Falls,
    /// The 95 % interval holds 0, or there is none.
    NotShown,
}

impl Direction {
    /// The direction of a slope or a difference within `interval`.
    #[must_use]
    pub fn of(interval: Option<[f64; 2]>) -> Self {
        match interval {
            Some([low, _]) if low > 0.0 => Self::Rises,
            Some([_, high]) if high < 0.0 => Self::Falls,
            _ => Self::NotShown,
        }
    }
}

/// A straight line through the logarithms of two positive quantities: y ∝ x^slope.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct LogFit {
    /// The exponent.
    pub slope: f64,
    /// Its 95 % confidence interval; absent for fewer than three points.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub slope_interval: Option<[f64; 2]>,
    /// The probability, two-sided, of a slope at least as steep were there none; absent for fewer than three points.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub p_value: Option<f64>,
    /// log10(y) at x = 1.
    pub intercept: f64,
    /// The share of the variance of log y that the line explains.
    pub r_squared: f64,
    /// The number of points, which the interval and p are over.
    pub points: usize,
}

impl LogFit {
    /// Whether y rises or falls with x.
    #[must_use]
    pub fn direction(&self) -> Direction {
        Direction::of(self.slope_interval)
    }
}

/// The least-squares line of log10 `y` on log10 `x`; `None` for fewer than two points above zero, or when x never
/// changes.
///
/// Formula: ordinary least squares; the interval and p from Student's t with n − 2 degrees of freedom.
///
/// Source: N. R. Draper and H. Smith, *Applied Regression Analysis*, 3rd ed., chapter 1.
#[must_use]
pub fn log_fit(x: &[f64], y: &[f64]) -> Option<LogFit> {
    let points: Vec<(f64, f64)> = x
        .iter()
        .zip(y)
        .filter(|(x, y)| **x > 0.0 && **y > 0.0 && x.is_finite() && y.is_finite())
        .map(|(x, y)| (x.log10(), y.log10()))
        .collect();
    let n = points.len() as f64;
    if points.len() < 2 {
        return None;
    }
    let mean = |value: fn(&(f64, f64)) -> f64| points.iter().map(value).sum::<f64>() / n;
    let (mx, my) = (mean(|p| p.0), mean(|p| p.1));
    let sums = points.iter().fold((0.0, 0.0, 0.0), |(xx, xy, yy), (x, y)| {
        let (x, y) = (x - mx, y - my);
        (xx + x * x, xy + x * y, yy + y * y)
    });
    let (xx, xy, yy) = sums;
    if xx <= 0.0 {
        return None;
    }
    let slope = xy / xx;
    let left = (yy - slope * xy).max(0.0);
    let freedom = points.len().saturating_sub(2);
    let error = (left / (n - 2.0) / xx).sqrt();
    let slope_interval = t_quantile(freedom).map(|t| [slope - t * error, slope + t * error]);
    Some(LogFit {
        slope,
        slope_interval,
        p_value: two_sided_p(slope / error, freedom),
        intercept: my - slope * mx,
        r_squared: if yy > 0.0 { 1.0 - left / yy } else { 1.0 },
        points: points.len(),
    })
}

/// The 97.5 % quantile of Student's t with `freedom` degrees of freedom; `None` without one.
///
/// Source: Student (1908), Biometrika 6(1); as SciPy's `t.ppf(0.975, freedom)`.
#[must_use]
pub fn t_quantile(freedom: usize) -> Option<f64> {
    if freedom == 0 {
        return None;
    }
    let t = StudentsT::new(0.0, 1.0, freedom as f64).ok()?;
    Some(t.inverse_cdf(0.975))
}

/// The two-sided probability of Student's t at least as far from 0; `None` without a degree of freedom.
fn two_sided_p(t: f64, freedom: usize) -> Option<f64> {
    if freedom == 0 || t.is_nan() {
        return None;
    }
    let distribution = StudentsT::new(0.0, 1.0, freedom as f64).ok()?;
    Some(2.0 * distribution.cdf(-t.abs()))
}

/// The rms over the lines of `band` of the difference of two PSDs with the same lines, `resolution_hz` apart from
/// 0 Hz, in dB; `None` when they share no line above zero there.
///
/// Formula: √(mean (10·log10(a/b))²), unweighted.
///
/// Source: the spectrum error of [`crate::verify`], between two measurements.
#[must_use]
pub fn difference_db_rms(a: &[f64], b: &[f64], resolution_hz: f64, band: Band) -> Option<f64> {
    let squares: Vec<f64> = a
        .iter()
        .zip(b)
        .enumerate()
        .filter(|(k, (a, b))| band.contains(*k as f64 * resolution_hz) && **a > 0.0 && **b > 0.0)
        .map(|(_, (a, b))| (10.0 * (a / b).log10()).powi(2))
        .collect();
    (!squares.is_empty()).then(|| (squares.iter().sum::<f64>() / squares.len() as f64).sqrt())
}

/// Whether groups can be compared: all in one unit.
///
/// Source: values combine only where their units match.
///
/// # Errors
/// [`CompareError::NotTogether`] naming two units.
pub fn comparable(groups: &[&Summary]) -> Result<(), CompareError> {
    let mut units = groups.iter().map(|group| &group.unit);
    let first = units.next();
    match units.find(|unit| Some(*unit) != first) {
        Some(other) => Err(CompareError::NotTogether {
            what: "the unit of the vibration",
            one: first.map_or(String::new(), ToString::to_string),
            other: other.to_string(),
        }),
        None => Ok(()),
    }
}

/// Why groups cannot be compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CompareError {
    /// There is nothing.
    #[error(
        "expected strokes to compare, found none; look at what was rejected with `piezotact segment`"
    )]
    Nothing,
    /// Recordings that cannot be averaged.
    #[error(
        "cannot average recordings: {what} is {one} in one and {other} in another; compare those apart"
    )]
    NotTogether {
        /// What differs.
        what: &'static str,
        /// In one.
        one: String,
        /// In another.
        other: String,
    },
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

    #[test]
    fn a_power_law_is_a_line() {
        let x = [1.0, 2.0, 4.0, 8.0];
        let fit = log_fit(&x, &x.map(|x: f64| 3.0 * x.powf(1.2))).unwrap();
        assert!((fit.slope - 1.2).abs() < 1e-12 && (fit.r_squared - 1.0).abs() < 1e-12);
        assert!((10f64.powf(fit.intercept) - 3.0).abs() < 1e-9);
        assert_eq!(log_fit(&[1.0, 1.0], &[2.0, 3.0]), None);
        assert_eq!(log_fit(&[0.0, 1.0], &[2.0, 3.0]), None);
    }
}
