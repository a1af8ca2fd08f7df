//! Limits of the random error of a transfer function, line by line, from coherence and the number of averages.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::{Estimator, TransferFunction};
use crate::quantity::Quantity;
use crate::statistics::Z_95;

/// More degrees of freedom change no digit that is said.
const MOST_FREEDOM: f64 = 1e6;

/// What limits of a transfer function hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub enum Limits {
    /// The best linear approximation of the system at this level of drive, with 95 % confidence, if the system does not change:
    /// H1 of a random drive or of multisines without noise.
    BestLinear,
    /// The value that this estimator gives on average: the random error alone. Noise on a signal, or distortion, may bias it
    /// by more.
    Scatter,
}

/// Limits of every line of a transfer function, pointwise: the estimate's random error, at a level of 95 %.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Confidence {
    /// What lies within the limits.
    pub of: Limits,
    /// The lower limit of the magnitude, in units of `O` per `I`.
    pub low: Vec<f64>,
    /// The upper limit; infinite where nothing is known.
    pub high: Vec<f64>,
    /// How far the phase may lie on either side, rad; π where nothing is known of it.
    pub phase_reach_rad: Vec<f64>,
}

impl<I: Quantity, O: Quantity> TransferFunction<I, O> {
    /// What the limits of this estimate hold: the best linear approximation for H1 of a lasting drive known without noise, whatever
    /// noise the response has; for any other estimate the bias depends on noise and distortion that one measurement does
    /// not tell from each other.
    #[must_use]
    pub fn limits(&self) -> Limits {
        match (self.estimator, self.known_input, &self.impact) {
            (Estimator::H1, true, None) => Limits::BestLinear,
            _ => Limits::Scatter,
        }
    }

    /// The limits of magnitude and phase of every line; `None` where the number of averages is not known or below 2.
    /// [`Confidence::of`] says what they hold.
    ///
    /// Formula: with n independent averages, ν = 2(n − 1) and Student's t for 95 %. H1 has in each direction of the complex
    /// plane the standard deviation σ = |H|·√((1 − γ²)/γ²/ν): the magnitude is |H| ± t·σ, the phase ± asin(t·σ/|H|). Where
    /// t·σ is above 0.3·|H| the limits are those of Rice's distribution with the deviation t·σ/1.96. 1/H2 scatters as H1
    /// does. Hv = √(Syy/Sxx): |Hv|·exp(± arcosh(1 + 2t²(1 − γ²)/ν)/2). Hv with a noise ratio κ, as an angle
    /// θ = atan(|Hv|/√κ): θ ± asin(2t·√((κ·Sxx·Syy − κ·|Sxy|²)/(ν·((Syy − κ·Sxx)² + 4κ·|Sxy|²))))/2.
    ///
    /// Source: J. S. Bendat and A. G. Piersol, *Random Data*, 4th ed., section 9.2.4, for one real direction in place of
    /// the circle of the complex value; S. O. Rice (1945), Bell Syst. Tech. J. 24(1); E. J. G. Pitman (1939), Biometrika
    /// 31, 9–12 (ratio of two variances); M. A. Creasy (1956), J. R. Stat. Soc. B 18, 65–69 (angle of the major axis).
    #[must_use]
    pub fn confidence(&self) -> Option<Confidence> {
        let n = self.effective_averages;
        let freedom = 2.0 * (n - 1.0);
        // Beyond, Student's t is the normal distribution to six digits, and its quantile is not found.
        let t = StudentsT::new(0.0, 1.0, freedom.min(MOST_FREEDOM))
            .ok()
            .filter(|_| n >= 2.0)?
            .inverse_cdf(0.975);
        let mut confidence = Confidence {
            of: self.limits(),
            low: Vec::with_capacity(self.response.len()),
            high: Vec::with_capacity(self.response.len()),
            phase_reach_rad: Vec::with_capacity(self.response.len()),
        };
        for (h, coherence) in self.response.iter().zip(&self.coherence) {
            let share = reach(*coherence, freedom, t);
            let magnitude = h.norm();
            let (low, high) = match self.estimator {
                Estimator::H1 => rice_limits(share),
                // The reciprocal scatters.
                Estimator::H2 => {
                    let (low, high) = rice_limits(share);
                    (1.0 / high, 1.0 / low)
                }
                Estimator::Hv => variance_ratio_limits(*coherence, freedom, t),
                Estimator::HvAt { noise_ratio } => {
                    let h1 = self.estimator.h1_of(*h, *coherence).norm();
                    let (low, high) = axis_limits(h1, *coherence, noise_ratio, freedom, t);
                    (low / magnitude, high / magnitude)
                }
            };
            let known = magnitude > 0.0 && share.is_finite();
            confidence
                .low
                .push(if known { low * magnitude } else { 0.0 });
            confidence.high.push(if known {
                high * magnitude
            } else {
                f64::INFINITY
            });
            confidence.phase_reach_rad.push(if known && share < 1.0 {
                share.asin()
            } else {
                std::f64::consts::PI
            });
        }
        Some(confidence)
    }
}

/// The limits of √(Syy/Sxx) re its estimate, from the limits of the ratio of two correlated variances.
fn variance_ratio_limits(coherence: f64, freedom: f64, t: f64) -> (f64, f64) {
    let k = 1.0 + 2.0 * t * t * (1.0 - coherence).max(0.0) / freedom;
    let reach = (0.5 * k.acosh()).exp();
    (1.0 / reach, reach)
}

/// The limits of the total least squares, from those of the angle of the major axis of the scatter of √κ·x and y, where H1
/// is `h1` and Sxx = 1.
fn axis_limits(h1: f64, coherence: f64, noise_ratio: f64, freedom: f64, t: f64) -> (f64, f64) {
    if coherence <= 0.0 {
        return (0.0, f64::INFINITY);
    }
    let (x, y) = (noise_ratio, h1 * h1 / coherence);
    let (difference, cross) = (y - x, h1 * h1 * noise_ratio);
    let spread = difference.mul_add(difference, 4.0 * cross);
    let sine = 2.0 * t * ((x * y - cross).max(0.0) / (freedom * spread)).sqrt();
    if sine >= 1.0 {
        return (0.0, f64::INFINITY);
    }
    let (angle, reach) = (0.5 * (2.0 * cross.sqrt()).atan2(x - y), 0.5 * sine.asin());
    let scale = noise_ratio.sqrt();
    let high = if angle + reach < std::f64::consts::FRAC_PI_2 {
        scale * (angle + reach).tan()
    } else {
        f64::INFINITY
    };
    (scale * (angle - reach).tan().max(0.0), high)
}

/// t·σ as a share of the magnitude.
fn reach(coherence: f64, freedom: f64, t: f64) -> f64 {
    if coherence <= 0.0 {
        return f64::INFINITY;
    }
    t * ((1.0 - coherence).max(0.0) / coherence / freedom).sqrt()
}

/// Where t·σ is a smaller share of the magnitude than this, it scatters evenly on both sides.
const EVEN: f64 = 0.3;

/// The limits of a magnitude whose estimate is 1 and which reaches `share` to either side.
fn rice_limits(share: f64) -> (f64, f64) {
    if share <= EVEN {
        return (1.0 - share, 1.0 + share);
    }
    if !share.is_finite() {
        return (0.0, f64::INFINITY);
    }
    let sigma = share / Z_95;
    // The estimate's square over σ², and the probability of one at most as large for a true magnitude.
    let found = 1.0 / (sigma * sigma);
    let below = |truth: f64| noncentral_chi_square_2(found, (truth / sigma).powi(2));
    let limit = |probability: f64| {
        // The probability falls as the truth rises.
        let (mut low, mut high) = (0.0, 1.0 + 2.0 * share);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if below(middle) > probability {
                low = middle;
            } else {
                high = middle;
            }
        }
        0.5 * (low + high)
    };
    let low = if below(0.0) <= 0.975 {
        0.0
    } else {
        limit(0.975)
    };
    // An estimate far below its own noise happens to be small: it does not make the truth smaller than the noise.
    (low, limit(0.025).max(share))
}

/// The probability that noncentral χ² with 2 degrees of freedom is at most `x`.
///
/// Formula: Σⱼ Poisson(j; λ/2)·P(χ²₂₊₂ⱼ ≤ x), where P(χ²₂₊₂ⱼ ≤ x) = 1 − Σᵢ₌₀ʲ Poisson(i; x/2).
fn noncentral_chi_square_2(x: f64, noncentrality: f64) -> f64 {
    let (half, mean) = (0.5 * x, 0.5 * noncentrality);
    let (mut weight, mut term) = ((-mean).exp(), (-half).exp());
    let mut above = term;
    let (mut sum, mut weights) = (0.0, 0.0);
    // Both Poisson means are at most some hundred here, as sigma is at least 0.15 of the magnitude.
    for j in 0..4_000 {
        sum += weight * (1.0 - above).max(0.0);
        weights += weight;
        if weights > 1.0 - 1e-13 {
            break;
        }
        let next = f64::from(j + 1);
        weight *= mean / next;
        term *= half / next;
        above += term;
    }
    sum
}
