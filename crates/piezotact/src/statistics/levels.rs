//! How levels scatter over time.

use super::moments::standard_deviation;

/// How short-time levels scatter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LevelSpread {
    pub loudest_db: f64,
    /// Their standard deviation, n − 1 in the denominator, dB.
    pub db: f64,
    /// Its standard error, dB.
    pub error_db: f64,
}

impl LevelSpread {
    /// The spread of `levels_db`, dB; `None` for fewer than three.
    ///
    /// Formula: the standard error of a standard deviation s of n normal values is s/√(2(n − 1)).
    ///
    /// Source: S. Ahn and J. A. Fessler (2003), *Standard errors of mean, variance, and standard deviation estimators*.
    #[must_use]
    pub fn of(levels_db: &[f64]) -> Option<Self> {
        if levels_db.len() < 3 {
            return None;
        }
        let n = levels_db.len() as f64;
        let db = standard_deviation(levels_db) * (n / (n - 1.0)).sqrt();
        Some(Self {
            loudest_db: levels_db.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            db,
            error_db: db / (2.0 * (n - 1.0)).sqrt(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_spread_by_their_standard_deviation() {
        let found = LevelSpread::of(&[-3.0, 0.0, 3.0]).unwrap();
        assert!((found.db - 3.0).abs() < 1e-12 && (found.error_db - 1.5).abs() < 1e-12);
        assert_eq!(found.loudest_db, 3.0);
        assert_eq!(LevelSpread::of(&[1.0, 2.0]), None);
    }
}
