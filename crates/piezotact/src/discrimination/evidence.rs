//! The uncertainty of a difference, from the variation between the averaged units at every available time scale.

use statrs::distribution::{ContinuousCDF, FisherSnedecor, StudentsT};

use super::excitation::{Excitation, ExcitationPlan};

/// Values that were averaged, as few of them as count for independent ones.
#[derive(Clone, Debug)]
pub(crate) struct Units {
    pub(crate) each: Vec<Excitation>,
    /// How many independent values they are worth.
    pub(crate) effective: f64,
}

impl Units {
    /// Units that do not share anything.
    pub(crate) fn independent(each: Vec<Excitation>) -> Self {
        Self {
            effective: each.len() as f64,
            each,
        }
    }
}

/// Where the variance of Σ gradient·sums of A plus the same of B comes from.
#[derive(Clone, Debug)]
pub(crate) enum Evidence<'a> {
    /// From how the units of either differ.
    Apart([Units; 2]),
    /// From how units that belong together differ in common: those of A and of B at one time.
    Together([Units; 2]),
    /// From the mean spectra, for Gaussian noise: the plan, the spectra, how far lines of one segment go together, and the
    /// independent segments of each.
    Noise {
        plan: &'a ExcitationPlan,
        psd: [&'a [f64]; 2],
        kinship: [f64; 3],
        averages: [f64; 2],
    },
}

/// A variance and the degrees of freedom that it was estimated with.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Variance {
    value: f64,
    freedom: f64,
}

fn dot(excitation: &Excitation, gradient: &[f64]) -> f64 {
    let sums = excitation.sums.iter();
    sums.zip(gradient).map(|(s, g)| s * g).sum()
}

/// The variance of the mean of `values`, which are worth `effective` independent ones.
fn of_mean(values: &[f64], effective: f64) -> Variance {
    let n = values.len() as f64;
    if values.len() < 2 || effective <= 1.0 {
        return Variance {
            value: f64::INFINITY,
            freedom: 1.0,
        };
    }
    let mean = values.iter().sum::<f64>() / n;
    let squares: f64 = values.iter().map(|v| (v - mean) * (v - mean)).sum();
    Variance {
        value: squares / (n - 1.0) / effective,
        freedom: (effective - 1.0).max(1.0),
    }
}

impl Evidence<'_> {
    fn variance(&self, gradients: [&[f64]; 2]) -> Variance {
        match self {
            Self::Apart(units) => {
                let [a, b] = [0, 1].map(|i| {
                    let values: Vec<f64> =
                        units[i].each.iter().map(|e| dot(e, gradients[i])).collect();
                    of_mean(&values, units[i].effective)
                });
                let value = a.value + b.value;
                // Welch and Satterthwaite.
                let spread = a.value * a.value / a.freedom + b.value * b.value / b.freedom;
                let freedom = if value.is_finite() && spread > 0.0 {
                    value * value / spread
                } else {
                    a.freedom.min(b.freedom)
                };
                Variance { value, freedom }
            }
            Self::Together([a, b]) => {
                let pairs = a.each.iter().zip(&b.each);
                let values: Vec<f64> = pairs
                    .map(|(a, b)| dot(a, gradients[0]) + dot(b, gradients[1]))
                    .collect();
                of_mean(&values, a.effective.min(b.effective))
            }
            Self::Noise {
                plan,
                psd,
                kinship,
                averages,
            } => {
                let value = (0..2)
                    .map(|i| {
                        let lines = plan.line_terms(psd[i], gradients[i]);
                        let shared = |apart: usize| -> f64 {
                            let later = lines.iter().skip(apart);
                            lines.iter().zip(later).map(|(a, b)| a * b).sum()
                        };
                        let sum = kinship[0] * shared(0)
                            + 2.0 * (kinship[1] * shared(1) + kinship[2] * shared(2));
                        sum / averages[i]
                    })
                    .sum();
                Variance {
                    value,
                    freedom: f64::INFINITY,
                }
            }
        }
    }
}

/// A standard error and how far a value may be off with 95 % confidence.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Uncertainty {
    pub(crate) error: f64,
    pub(crate) ci_half_width: f64,
    /// Whether a coarser scale makes it more than twice what the first one does.
    pub(crate) wanders: bool,
}

/// The 97.5 % quantile of Student's t; the normal distribution's for many degrees of freedom.
fn t_quantile(freedom: f64) -> f64 {
    if freedom > 1e4 {
        return crate::statistics::Z_95;
    }
    StudentsT::new(0.0, 1.0, freedom.max(1.0)).map_or(f64::INFINITY, |t| t.inverse_cdf(0.975))
}

/// The confidence level of the stationarity test: the share of stationary recordings that pass it.
const STEADY: f64 = 0.975;
/// The same where nothing but the spectrum of noise says how segments scatter.
const STEADY_NOISE: f64 = 0.8;
/// With fewer independent segments than this, the uncertainty follows from parts alone, not from a noise model.
const LEAST_AVERAGES: f64 = 2.5;

/// Whether `coarse` is larger than `fine` by more than chance makes it.
fn exceeds(coarse: Variance, fine: Variance, steady: f64) -> bool {
    if !(coarse.value.is_finite() && coarse.value > fine.value) {
        return false;
    }
    if fine.value <= 0.0 {
        return true;
    }
    let quantile = FisherSnedecor::new(coarse.freedom, fine.freedom.min(1e4))
        .map_or(f64::INFINITY, |f| f.inverse_cdf(steady));
    coarse.value / fine.value > quantile
}

/// How far Σ gradient·sums of A plus that of B may be off, from `scales`: the first as it is; where a coarser one scatters by more than
/// chance makes it, as what wanders does, or where the first is no more than what noise of one or two segments would do, the largest of all.
pub(crate) fn uncertainty(scales: &[Evidence<'_>], gradients: [&[f64]; 2]) -> Uncertainty {
    let mut variances = scales.iter().map(|scale| scale.variance(gradients));
    let Some(fine) = variances.next() else {
        return Uncertainty::default();
    };
    let of = |v: Variance| {
        let error = v.value.max(0.0).sqrt();
        let half_width = if error > 0.0 {
            error * t_quantile(v.freedom)
        } else {
            0.0
        };
        (error, half_width)
    };
    let first = of(fine);
    let mut found = Uncertainty {
        error: first.0,
        ci_half_width: first.1,
        wanders: false,
    };
    let coarser: Vec<Variance> = variances.collect();
    let (steady, believed) = match scales.first() {
        Some(Evidence::Noise { averages, .. }) => {
            (STEADY_NOISE, averages[0].min(averages[1]) >= LEAST_AVERAGES)
        }
        _ => (STEADY, true),
    };
    let wanders = coarser.iter().any(|coarse| exceeds(*coarse, fine, steady));
    if wanders || !believed {
        for (error, half_width) in coarser.into_iter().map(of) {
            if half_width > found.ci_half_width {
                (found.error, found.ci_half_width) = (error, half_width);
            }
        }
        found.wanders = wanders && found.ci_half_width > 2.0 * first.1;
    }
    found
}
