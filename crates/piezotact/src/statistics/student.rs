//! Student's t and the chi-squared distribution, as tests and intervals need them.

use statrs::distribution::{ChiSquared, ContinuousCDF, StudentsT};

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
pub(super) fn two_sided_p(t: f64, freedom: usize) -> Option<f64> {
    if freedom == 0 || t.is_nan() {
        return None;
    }
    let distribution = StudentsT::new(0.0, 1.0, freedom as f64).ok()?;
    Some(2.0 * distribution.cdf(-t.abs()))
}

/// The 95 % confidence interval of a standard deviation `sd` over `n` independent values; `None` for fewer than two.
pub(crate) fn deviation_interval(sd: f64, n: usize) -> Option<[f64; 2]> {
    let freedom = n.checked_sub(1).filter(|freedom| *freedom > 0)? as f64;
    let squares = ChiSquared::new(freedom).ok()?;
    let end = |quantile: f64| sd * (freedom / squares.inverse_cdf(quantile)).sqrt();
    Some([end(0.975), end(0.025)])
}
