//! What a vibration excites, band by band and as a whole, and how well its length lets that be known.

use statrs::distribution::{ContinuousCDF, StudentsT};

use super::REACH;
use crate::feature::Weighting;
use crate::quantity::{Acceleration, Band, Hertz, Seconds};
use crate::series::Series;
use crate::spectrum::{EstimateError, RECOMMENDED_SEGMENTS, WelchConfig, WelchPlan, segments_in};

/// dB of a power whose natural logarithm changes by 1.
const DB_PER_NEPER: f64 = 4.342_944_819_032_518;

/// A line's share of a band, and what it excites.
struct Part {
    line: usize,
    band: usize,
    /// How much of the line lies in the band, Hz.
    width_hz: f64,
    /// One over the squared threshold, (m/s²)⁻².
    sensitivity: f64,
    log_frequency: f64,
    /// The share of its excitation that each band feels; together 1.
    felt: Vec<f64>,
}

/// How the excitation of a line spreads over bands: by a normal distribution of `ln f` as wide as `width`, so that
/// what moves by a hair from one band to the next makes a hair's difference.
fn spreading(bands: &[Band], log_frequency: f64, width: f64) -> Vec<f64> {
    let weights: Vec<f64> = bands
        .iter()
        .map(|band| {
            let (low, high) = (band.low().0.ln(), band.high().0.ln());
            let away = (0.5 * (low + high) - log_frequency) / width;
            (high - low) * (-0.5 * away * away).exp()
        })
        .collect();
    let sum: f64 = weights.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    weights.iter().map(|w| w / sum).collect()
}

/// What each of the bands holds of a line, for spectra of `bins` lines.
fn parts(
    bands: &[Band],
    weighting: Weighting,
    width: f64,
    bins: usize,
    resolution_hz: f64,
) -> Vec<Part> {
    let mut parts = Vec::new();
    for (band, limits) in bands.iter().enumerate() {
        for line in 1..bins {
            let centre_hz = line as f64 * resolution_hz;
            let low_hz = (centre_hz - 0.5 * resolution_hz).max(limits.low().0);
            let high_hz = (centre_hz + 0.5 * resolution_hz).min(limits.high().0);
            if low_hz < high_hz {
                parts.push(Part {
                    line,
                    band,
                    width_hz: high_hz - low_hz,
                    sensitivity: weighting.threshold_m_s2(Hertz(centre_hz)).powi(-2),
                    log_frequency: centre_hz.ln(),
                    felt: spreading(bands, centre_hz.ln(), width),
                });
            }
        }
    }
    parts
}

/// The sums over one spectrum that everything else is made of.
#[derive(Clone, Debug, Default, PartialEq)]
struct Sums {
    /// Of each band, (m/s²)².
    power: Vec<f64>,
    /// What each band feels, multiples of threshold power.
    excitation: Vec<f64>,
    /// Of all bands together.
    total: f64,
    /// Σ excitation·ln f over all bands.
    moment: f64,
}

impl Sums {
    fn of(psd: &[f64], parts: &[Part], bands: usize) -> Self {
        let mut sums = Self {
            power: vec![0.0; bands],
            excitation: vec![0.0; bands],
            total: 0.0,
            moment: 0.0,
        };
        for part in parts {
            let power = psd[part.line] * part.width_hz;
            let excitation = power * part.sensitivity;
            sums.power[part.band] += power;
            for (sum, share) in sums.excitation.iter_mut().zip(&part.felt) {
                *sum += excitation * share;
            }
            sums.total += excitation;
            sums.moment += excitation * part.log_frequency;
        }
        sums
    }
}

/// What a vibration excites, with the standard errors of its levels.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Excitation {
    /// Mean power of each band, (m/s²)².
    pub(super) power: Vec<f64>,
    /// What each band feels, its neighbours' share with it, as a multiple of threshold power.
    pub(super) bands: Vec<f64>,
    /// Their sum.
    pub(super) total: f64,
    /// The standard error of each band's level, dB.
    pub(super) band_error_db: Vec<f64>,
    /// That of the sum's level, dB.
    pub(super) total_error_db: f64,
    /// The mean of ln(f/Hz), weighed by excitation.
    pub(super) log_centroid: f64,
    /// Its standard error.
    pub(super) log_centroid_error: f64,
    /// The segments averaged.
    pub(super) segments: usize,
}

/// What `x` excites in each of `bands`, spread over its neighbours by `width` in ln f.
///
/// The variances are those of the segments where there are [`RECOMMENDED_SEGMENTS`] of them, and else those that
/// Gaussian noise of this spectrum would have.
pub(super) fn excitation(
    x: &Series<Acceleration>,
    bands: &[Band],
    (weighting, width): (Weighting, f64),
    welch: &WelchConfig,
) -> Result<Excitation, EstimateError> {
    welch.fits(x.samples().len())?;
    let mut plan = WelchPlan::new(welch, x.rate())?;
    let hop = welch.hop()?;
    let segments = segments_in(x.samples().len(), welch.segment, hop);
    let bins = welch.segment / 2 + 1;
    let parts = parts(
        bands,
        weighting,
        width,
        bins,
        x.rate().hz() / welch.segment as f64,
    );
    let mut psd = vec![0.0; bins];
    let mut each = Vec::with_capacity(segments);
    for i in 0..segments {
        let cut = &x.samples()[i * hop..i * hop + welch.segment];
        let one = plan.estimate::<Acceleration>(&[cut])?.values;
        for (sum, value) in psd.iter_mut().zip(&one) {
            *sum += value / segments as f64;
        }
        each.push(Sums::of(&one, &parts, bands.len()));
    }
    let mean = Sums::of(&psd, &parts, bands.len());
    let total = mean.total;
    let log_centroid = if total > 0.0 {
        mean.moment / total
    } else {
        0.0
    };
    let averages = welch.effective_averages(segments)?;
    let seen = segments >= RECOMMENDED_SEGMENTS;
    let widened = if seen { widening(averages) } else { 1.0 };
    let scatter = if seen {
        Scatter::Seen {
            each: &each,
            averages,
        }
    } else {
        Scatter::Gaussian {
            psd: &psd,
            parts: &parts,
            kinship: line_kinship(welch),
            averages,
        }
    };
    let in_db = |variance: f64, value: f64| {
        if value > 0.0 {
            widened * DB_PER_NEPER * variance.max(0.0).sqrt() / value
        } else {
            0.0
        }
    };
    let band_error_db = (0..bands.len())
        .map(|b| {
            in_db(
                scatter.variance(&|part| part.sensitivity * part.felt[b], &|s: &Sums| {
                    s.excitation[b]
                }),
                mean.excitation[b],
            )
        })
        .collect();
    let total_error_db = in_db(
        scatter.variance(&|part| part.sensitivity, &|s| s.total),
        total,
    );
    let about_centroid = scatter.variance(
        &|part| part.sensitivity * (part.log_frequency - log_centroid),
        &|s| s.moment - log_centroid * s.total,
    );
    Ok(Excitation {
        power: mean.power,
        bands: mean.excitation,
        total,
        band_error_db,
        total_error_db,
        log_centroid,
        log_centroid_error: widened * about_centroid.max(0.0).sqrt() / total.max(f64::MIN_POSITIVE),
        segments,
    })
}

/// How much wider than the normal distribution's the limits of a mean are whose variance was estimated from
/// `averages` independent values.
fn widening(averages: f64) -> f64 {
    StudentsT::new(0.0, 1.0, (averages - 1.0).max(1.0))
        .map_or(1.0, |t| t.inverse_cdf(0.975) / REACH)
}

/// Where the variance of a mean over segments comes from.
enum Scatter<'a> {
    /// From how the segments differ.
    Seen { each: &'a [Sums], averages: f64 },
    /// From the mean spectrum, for noise.
    Gaussian {
        psd: &'a [f64],
        parts: &'a [Part],
        kinship: [f64; 3],
        averages: f64,
    },
}

impl Scatter<'_> {
    /// The variance of the mean of `of_sums`, which is Σ density·width·`weight` over the parts.
    fn variance(&self, weight: &dyn Fn(&Part) -> f64, of_sums: &dyn Fn(&Sums) -> f64) -> f64 {
        match self {
            Self::Seen { each, averages } => {
                let values: Vec<f64> = each.iter().map(of_sums).collect();
                let sd = crate::series::standard_deviation(&values);
                let n = values.len() as f64;
                sd * sd * n / (n - 1.0).max(1.0) / averages
            }
            Self::Gaussian {
                psd,
                parts,
                kinship,
                averages,
            } => {
                // A line on the edge of two bands is one line.
                let mut lines = vec![0.0; psd.len()];
                for part in *parts {
                    lines[part.line] += psd[part.line] * part.width_hz * weight(part);
                }
                let shared = |apart: usize| -> f64 {
                    lines
                        .iter()
                        .zip(lines.iter().skip(apart))
                        .map(|(a, b)| a * b)
                        .sum()
                };
                let sum = kinship[0] * shared(0)
                    + 2.0 * (kinship[1] * shared(1) + kinship[2] * shared(2));
                sum / averages
            }
        }
    }
}

/// How far the powers of lines 0, 1 and 2 apart go together in one segment of noise, 0–1.
///
/// Formula: |Σ w²·e^(−2πijt/n)|²/(Σ w²)²; 1, 4/9 and 1/36 for Hann.
fn line_kinship(welch: &WelchConfig) -> [f64; 3] {
    let window = welch.window.coefficients(welch.segment, welch.symmetry);
    let power: f64 = window.iter().map(|w| w * w).sum();
    [0usize, 1, 2].map(|apart| {
        let turn = std::f64::consts::TAU * apart as f64 / welch.segment as f64;
        let (re, im) = window
            .iter()
            .enumerate()
            .fold((0.0, 0.0), |(re, im), (t, w)| {
                let (sin, cos) = (turn * t as f64).sin_cos();
                (re + w * w * cos, im + w * w * sin)
            });
        (re * re + im * im) / (power * power)
    })
}

/// How much short-time levels spread.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Spread {
    /// Their standard deviation, dB.
    pub(super) db: f64,
    /// Its standard error, dB.
    pub(super) error_db: f64,
}

/// The spread of the excitation's level over windows of `window`; `None` with fewer than three of them.
pub(super) fn spread(
    x: &Series<Acceleration>,
    band: Band,
    weighting: Weighting,
    window: Seconds,
) -> Result<Option<Spread>, EstimateError> {
    let segment = x.rate().samples_in(window).max(16);
    let welch = WelchConfig {
        overlap: 0.0,
        ..WelchConfig::hann(segment)
    };
    let count = segments_in(x.samples().len(), segment, welch.hop()?);
    if count < 3 {
        return Ok(None);
    }
    let mut plan = WelchPlan::new(&welch, x.rate())?;
    let parts = parts(
        &[band],
        weighting,
        1.0,
        segment / 2 + 1,
        x.rate().hz() / segment as f64,
    );
    let mut levels_db = Vec::with_capacity(count);
    for cut in x.samples().chunks_exact(segment) {
        let psd = plan.estimate::<Acceleration>(&[cut])?.values;
        let total = Sums::of(&psd, &parts, 1).total;
        // A pause is as quiet as a tenth of the threshold's power, not infinitely quiet.
        levels_db.push(10.0 * total.max(0.1).log10());
    }
    let n = levels_db.len() as f64;
    let db = crate::series::standard_deviation(&levels_db) * (n / (n - 1.0)).sqrt();
    Ok(Some(Spread {
        db,
        error_db: db / (2.0 * (n - 1.0)).sqrt(),
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lines_of_a_hann_window_go_together_as_they_should() {
        let [own, next, second] = line_kinship(&WelchConfig::hann(1024));
        assert!((own - 1.0).abs() < 1e-12);
        assert!((next - 4.0 / 9.0).abs() < 1e-12 && (second - 1.0 / 36.0).abs() < 1e-12);
    }
}
