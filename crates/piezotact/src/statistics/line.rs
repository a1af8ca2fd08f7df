//! Straight lines, through logarithms and through what follows in time, and which way one quantity goes with another.

use serde::{Deserialize, Serialize};

use super::{
    standard_deviation,
    student::{t_quantile, two_sided_p},
};

/// Which way one quantity goes with another, as far as the data carry it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
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
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
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

    /// The same with an interval that reaches to each side by `reach` at least, and the p that goes with it: what is known of the points
    /// beside their scatter.
    #[must_use]
    pub(crate) fn reaching(self, reach: f64) -> Self {
        let freedom = self.points.saturating_sub(2);
        let (Some([low, high]), Some(t)) = (self.slope_interval, t_quantile(freedom)) else {
            return self;
        };
        if 0.5 * (high - low) >= reach {
            return self;
        }
        Self {
            slope_interval: Some([self.slope - reach, self.slope + reach]),
            p_value: two_sided_p(t * self.slope / reach, freedom),
            ..self
        }
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

/// Fewer values than these do not show whether one goes together with the next.
const FEWEST_FOR_CORRELATION: usize = 20;

/// A straight line through values that may go together with the next, as slow noise does.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Trend {
    /// The slope, in the unit of the values over that of their step.
    pub slope: f64,
    /// Its 95 % confidence interval; absent where fewer than three of the values are independent.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub slope_interval: Option<[f64; 2]>,
    /// How many values are independent.
    pub independent: f64,
    /// The largest value less the smallest.
    pub range: f64,
}

impl Trend {
    /// Whether the values rise or fall.
    #[must_use]
    pub fn direction(&self) -> Direction {
        Direction::of(self.slope_interval)
    }
}

/// The least-squares line through `values`, which stand `step_s` s apart; `None` for fewer than three values, or no step.
///
/// Formula: the interval is that of Student's t with m − 2 degrees of freedom, and the variance of the residuals over m − 2, where
/// m = n·(1 − r)/(1 + r) values are independent, r the correlation of a residual with the next, 0 where that is below 0. Where
/// r exceeds 1/√n, or cannot show it (fewer than 20 values), the values may wander as a random walk does, and the half-width is at least t·s·√(6/(5n)), s the standard
/// deviation of the steps from a value to the next: the scatter of a least-squares slope through a random walk.
///
/// Source: B. D. Santer et al. (2000), J. Geophys. Res. 105(D6), 7337–7356, equations 4 to 6; C. R. Nelson and H. Kang (1984),
/// Econometrica 52(1), 73–82, for the slope through a random walk.
///
/// ```
/// use piezotact::statistics::trend;
/// let found = trend(&[1.0, 3.0, 5.0, 7.0], 0.5).unwrap();
/// assert!((found.slope - 4.0).abs() < 1e-12 && (found.range - 6.0).abs() < 1e-12);
/// ```
#[must_use]
pub fn trend(values: &[f64], step_s: f64) -> Option<Trend> {
    if values.len() < 3 || step_s <= 0.0 {
        return None;
    }
    let n = values.len() as f64;
    let middle = values.iter().sum::<f64>() / n;
    let x = |i: usize| (i as f64 - 0.5 * (n - 1.0)) * step_s;
    let points = || values.iter().enumerate().map(|(i, y)| (x(i), y - middle));
    let xx: f64 = points().map(|(x, _)| x * x).sum();
    let slope = points().map(|(x, y)| x * y).sum::<f64>() / xx;
    let left: Vec<f64> = points().map(|(x, y)| y - slope * x).collect();
    let squares: f64 = left.iter().map(|r| r * r).sum();
    let next: f64 = left.windows(2).map(|pair| pair[0] * pair[1]).sum();
    let together = (next / squares.max(f64::MIN_POSITIVE)).clamp(0.0, 0.99);
    let independent = n * (1.0 - together) / (1.0 + together);
    let freedom = independent - 2.0;
    let steps: Vec<f64> = values.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let wanders = values.len() < FEWEST_FOR_CORRELATION || together > 1.0 / n.sqrt();
    let walk = if wanders {
        standard_deviation(&steps) / step_s * (1.2 / n).sqrt()
    } else {
        0.0
    };
    let walk_reach = t_quantile(values.len() - 2).map_or(0.0, |t| t * walk);
    let reach = (freedom >= 1.0).then(|| {
        let t = t_quantile(freedom.floor() as usize)?;
        Some((t * (squares / freedom / xx).sqrt()).max(walk_reach))
    });
    let (low, high) = values.iter().fold((f64::MAX, f64::MIN), |(low, high), v| {
        (low.min(*v), high.max(*v))
    });
    Some(Trend {
        slope,
        slope_interval: reach.flatten().map(|reach| [slope - reach, slope + reach]),
        independent,
        range: high - low,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

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
