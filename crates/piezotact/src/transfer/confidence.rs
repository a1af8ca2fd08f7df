//! Confidence limits of a transfer function, line by line, from coherence and the number of averages.

use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, StudentsT};

use super::{Estimator, TransferFunction};
use crate::quantity::Quantity;

/// 95 % confidence limits of every line of a transfer function, pointwise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Confidence {
    /// The lower limit of the magnitude, in units of `O` per `I`.
    pub low: Vec<f64>,
    /// The upper limit; infinite where nothing is known.
    pub high: Vec<f64>,
    /// How far the phase may lie on either side, rad; π where nothing is known of it.
    pub phase_reach_rad: Vec<f64>,
}

impl<I: Quantity, O: Quantity> TransferFunction<I, O> {
    /// The 95 % confidence limits of magnitude and phase of every line; `None` where the number of averages is not
    /// known or below 2.
    ///
    /// Formula: the error of the estimate has in each direction of the complex plane the standard deviation
    /// σ = |H|·√((1 − γ²)/γ²/(2(n − 1))) with n independent averages, estimated with 2(n − 1) degrees of freedom. The
    /// magnitude is |H| ± t·σ, the phase ± asin(t·σ/|H|). Where t·σ is above 0.3·|H| the magnitude no longer scatters like
    /// that of a line on a plane: there the limits are those of Rice's distribution with the deviation t·σ/1.96.
    /// H2 divides by the noisy channel: its limits are those of 1/H.
    ///
    /// Source: J. S. Bendat and A. G. Piersol, *Random Data*, 4th ed., section 9.2.4, for one real direction in place of
    /// the circle of the complex value; S. O. Rice (1945), Bell Syst. Tech. J. 24(1).
    #[must_use]
    pub fn confidence(&self) -> Option<Confidence> {
        let n = self.effective_averages;
        let freedom = 2.0 * (n - 1.0);
        let t = StudentsT::new(0.0, 1.0, freedom)
            .ok()
            .filter(|_| n >= 2.0)?
            .inverse_cdf(0.975);
        let mut confidence = Confidence {
            low: Vec::with_capacity(self.response.len()),
            high: Vec::with_capacity(self.response.len()),
            phase_reach_rad: Vec::with_capacity(self.response.len()),
        };
        for (h, coherence) in self.response.iter().zip(&self.coherence) {
            let share = reach(*coherence, freedom, t);
            let (low, high) = match self.estimator {
                // Noise on the drive: the reciprocal scatters.
                Estimator::H2 => {
                    let (low, high) = rice_limits(share);
                    (1.0 / high, 1.0 / low)
                }
                Estimator::H1 | Estimator::Hv => rice_limits(share),
            };
            let magnitude = h.norm();
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

/// t·σ as a share of the magnitude.
fn reach(coherence: f64, freedom: f64, t: f64) -> f64 {
    if coherence <= 0.0 {
        return f64::INFINITY;
    }
    t * ((1.0 - coherence).max(0.0) / coherence / freedom).sqrt()
}

/// Where t·σ is a smaller share of the magnitude than this, it scatters evenly on both sides.
const EVEN: f64 = 0.3;
/// The 97.5 % quantile of the standard normal distribution.
const NORMAL: f64 = 1.959_963_984_540_054;

/// The limits of a magnitude whose estimate is 1 and which reaches `share` to either side.
fn rice_limits(share: f64) -> (f64, f64) {
    if share <= EVEN {
        return (1.0 - share, 1.0 + share);
    }
    if !share.is_finite() {
        return (0.0, f64::INFINITY);
    }
    let sigma = share / NORMAL;
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
