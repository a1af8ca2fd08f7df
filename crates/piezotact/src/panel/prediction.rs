//! What the errors of participants who were left out in turn say about a participant who was not measured.

use crate::statistics::{mean, t_quantile};

/// The fewest people for an interval. Of three, the upper end is three times the error that one new person in forty exceeds.
const ENOUGH: usize = 4;

/// The square roots of leave-one-out errors: for one degree of freedom as for many, they are nearly normal.
struct Roots {
    people: f64,
    mean: f64,
    /// How far one value may lie from the mean of the population, 95 %, divided by √(1 + 1/n).
    reach: f64,
}

impl Roots {
    fn of(left_out_db: &[f64]) -> Option<Self> {
        let t = t_quantile(left_out_db.len().checked_sub(1)?)?;
        if left_out_db.len() < ENOUGH {
            return None;
        }
        let people = left_out_db.len() as f64;
        let roots: Vec<f64> = left_out_db.iter().map(|db| db.sqrt()).collect();
        let middle = mean(&roots);
        let squares: f64 = roots.iter().map(|root| (root - middle).powi(2)).sum();
        let deviation = (squares / (people - 1.0)).sqrt();
        Some(Self {
            people,
            mean: middle,
            reach: t * deviation * (people / (people - 1.0)).sqrt(),
        })
    }
}

/// The interval that holds the rms error of the average of n people for one new person with a probability of 95 %, dB, from the
/// rms errors `left_out_db` of those n people, each by the average of the others; `None` for fewer than four.
///
/// Formula: (m·(1 − 1/n²)^¼ ± t·s·√((n + 1)/(n − 1)))², the lower root at least 0, with m and s the mean and the standard deviation
/// of √e over people and Student's t with n − 1 degrees of freedom. The average of n is a little closer to a new person than that of
/// n − 1 to the person left out: by √(1 − 1/n²). s is multiplied by √(1 + 1/n), as for every prediction, and by √(n/(n − 1)), as the averages
/// share people.
///
/// Source: D. M. Hawkins and R. A. J. Wixley (1986), The American Statistician 40(4), for the fourth root of squares; the last factor and the
/// share of new people that the interval holds: docs/decisions/transfer-functions.md.
pub(super) fn new_person_db(left_out_db: &[f64]) -> Option<[f64; 2]> {
    let Roots {
        people: n,
        mean,
        reach,
    } = Roots::of(left_out_db)?;
    let middle = mean * (1.0 - 1.0 / (n * n)).powf(0.25);
    let reach = reach * (1.0 + 1.0 / n).sqrt();
    Some([(middle - reach).max(0.0), middle + reach].map(|root| root * root))
}

/// The error of the average of very many people for a typical new person, dB rms, and its 95 % confidence interval, from leave-one-out
/// errors as in [`new_person_db`]; `None` for fewer than four.
///
/// Formula: m²·√(1 − 1/n), and (m ± t·s·√((n + 1)/(n − 1))/√n)² in place of m²: a typical person is the mean of √e.
///
/// Source: as [`new_person_db`].
pub(super) fn typical_db(left_out_db: &[f64]) -> Option<(f64, [f64; 2])> {
    let Roots {
        people: n,
        mean,
        reach,
    } = Roots::of(left_out_db)?;
    let reach = reach * ((1.0 + 1.0 / n) / n).sqrt();
    let to_db = |root: f64| root * root * (1.0 - 1.0 / n).sqrt();
    Some((
        to_db(mean),
        [(mean - reach).max(0.0), mean + reach].map(to_db),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As SciPy 1.17.1 has them: `golden/panel.py`.
    #[test]
    fn intervals_are_as_scipy_has_them() {
        let errors = [1.2, 0.4, 2.6, 1.9, 0.8, 1.1];
        let [low, high] = new_person_db(&errors).unwrap();
        let (typical, [least, most]) = typical_db(&errors).unwrap();
        let found = [low, high, typical, least, most];
        let expected = [
            0.002_144_275_217_520_132_3,
            4.660_302_931_725_814,
            1.125_421_570_240_883_2,
            0.421_027_923_679_048_7,
            2.169_290_424_743_428_6,
        ];
        for (found, expected) in found.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }

    #[test]
    fn three_people_are_too_few() {
        assert_eq!(new_person_db(&[1.0, 2.0, 3.0]), None);
        assert_eq!(typical_db(&[]), None);
        // Everybody alike.
        assert_eq!(new_person_db(&[0.0; 4]), Some([0.0; 2]));
    }
}
