//! The ratios of spectra that estimate a transfer function, and how they follow from each other.

use std::fmt;

use num_complex::Complex;
use serde::{Deserialize, Serialize};

use super::cross::total_least_squares;

/// Which ratio of spectra estimates the transfer function. In documents it is a text: `H1`, `H2`, `Hv` or `Hv(4)`, the last
/// with its noise ratio.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schemas", schemars(with = "String"))]
pub enum Estimator {
    /// Sxy/Sxx: unbiased by noise on the response.
    H1,
    /// Syy/Syx: unbiased by noise on the drive.
    H2,
    /// √(Syy/Sxx)·Sxy/|Sxy|: between the two, for noise with the same share of power in both signals.
    Hv,
    /// Total least squares for noise on both signals, unbiased if the ratio of their powers is known.
    HvAt {
        /// The power of the noise on the response over that on the drive, (units of y per x)², from 1e-30 to 1e30.
        noise_ratio: f64,
    },
}

/// The ratios that leave digits in the least squares.
const NOISE_RATIOS: std::ops::RangeInclusive<f64> = 1e-30..=1e30;

impl Estimator {
    /// The estimator of this name (`H1`, `H2`, `Hv`, or `Hv(4)` with its noise ratio), in letters of any case; `None` for any
    /// other, and for a noise ratio that is not above 0.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        let name = name.trim();
        let plain = [Self::H1, Self::H2, Self::Hv]
            .into_iter()
            .find(|estimator| estimator.to_string().eq_ignore_ascii_case(name));
        plain.or_else(|| {
            let (kind, ratio) = name.strip_suffix(')')?.split_once('(')?;
            let ratio: f64 = ratio.trim().parse().ok()?;
            Self::hv_at(ratio).filter(|_| kind.trim().eq_ignore_ascii_case("Hv"))
        })
    }

    /// Hv for a `noise_ratio` ((units of y per x)²); `None` unless it is from 1e-30 to 1e30.
    #[must_use]
    pub fn hv_at(noise_ratio: f64) -> Option<Self> {
        NOISE_RATIOS
            .contains(&noise_ratio)
            .then_some(Self::HvAt { noise_ratio })
    }

    /// What this estimator gives on a line where H1 is `h1`, in units of y per x, and the coherence is `coherence`, 0–1.
    ///
    /// Formula: with Sxx = 1, Sxy = H1 and Syy = |H1|²/γ²: H2 = H1/γ², Hv = H1/γ, and the total least squares of the three.
    pub(super) fn of_h1(self, h1: Complex<f64>, coherence: f64) -> Complex<f64> {
        if coherence <= 0.0 {
            return Complex::default();
        }
        match self {
            Self::H1 => h1,
            Self::H2 => h1 / coherence,
            Self::Hv => h1 / coherence.sqrt(),
            Self::HvAt { noise_ratio } => {
                total_least_squares(h1, 1.0, h1.norm_sqr() / coherence, noise_ratio)
            }
        }
    }

    /// H1 on a line where this estimator gives `value`, in units of y per x, and the coherence is `coherence`, 0–1: the inverse
    /// of [`Self::of_h1`].
    ///
    /// Formula: for total least squares with v = |value| and the noise ratio κ, H1/Hv = 2κ/(κ − v² + √((v² − κ)² + 4κ·v²/γ²)).
    pub(super) fn h1_of(self, value: Complex<f64>, coherence: f64) -> Complex<f64> {
        match self {
            Self::H1 => value,
            Self::H2 => value * coherence,
            Self::Hv => value * coherence.sqrt(),
            Self::HvAt { noise_ratio: ratio } => {
                if coherence <= 0.0 {
                    return Complex::default();
                }
                let power = value.norm_sqr();
                let difference = power - ratio;
                let root = difference
                    .mul_add(difference, 4.0 * ratio * power / coherence)
                    .sqrt();
                // The form of the root without cancellation.
                if difference <= 0.0 {
                    value * (2.0 * ratio / (root - difference))
                } else {
                    value * (coherence * (root + difference) / (2.0 * power))
                }
            }
        }
    }
}

impl fmt::Display for Estimator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::H1 => f.write_str("H1"),
            Self::H2 => f.write_str("H2"),
            Self::Hv => f.write_str("Hv"),
            Self::HvAt { noise_ratio } => write!(f, "Hv({noise_ratio:?})"),
        }
    }
}

impl From<Estimator> for String {
    fn from(estimator: Estimator) -> Self {
        estimator.to_string()
    }
}

impl TryFrom<String> for Estimator {
    type Error = String;

    fn try_from(name: String) -> Result<Self, String> {
        Self::named(&name).ok_or_else(|| {
            format!(
                "expected an estimator (H1, H2, Hv, or Hv(4) with its noise ratio), found `{name}`"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Estimator; 5] = [
        Estimator::H1,
        Estimator::H2,
        Estimator::Hv,
        Estimator::HvAt { noise_ratio: 4.0 },
        Estimator::HvAt { noise_ratio: 1e-3 },
    ];

    #[test]
    fn a_name_is_read_back() {
        for estimator in ALL {
            assert_eq!(Estimator::named(&estimator.to_string()), Some(estimator));
            let json = serde_json::to_string(&estimator).unwrap();
            assert_eq!(serde_json::from_str::<Estimator>(&json).unwrap(), estimator);
        }
        assert_eq!(Estimator::named(" hV "), Some(Estimator::Hv));
        for wrong in [
            "H3", "Hv(", "Hv()", "Hv(0)", "Hv(-1)", "Hv(inf)", "Hv(1e31)", "Hv(nan)", "H1(4)", "",
        ] {
            assert_eq!(Estimator::named(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn h1_and_each_estimator_follow_from_each_other() {
        for estimator in ALL {
            for magnitude in [1e-6, 0.3, 2.0, 40.0] {
                for coherence in [1.0, 0.97, 0.4, 0.01] {
                    let h1 = Complex::from_polar(magnitude, 0.7);
                    let value = estimator.of_h1(h1, coherence);
                    let back = estimator.h1_of(value, coherence);
                    assert!(
                        (back - h1).norm() < 1e-9 * magnitude,
                        "{estimator} {h1} {coherence}: {back}"
                    );
                    // Every estimate lies between H1 and H2.
                    let between = magnitude * (1.0 - 1e-9)..=magnitude / coherence * (1.0 + 1e-9);
                    assert!(
                        between.contains(&value.norm()),
                        "{estimator} {h1} {coherence}: {value}"
                    );
                }
            }
        }
    }
}
