//! The spectra of target and measurement line by line, with the variance of each line and the sensor's noise in it.

use num_complex::Complex;

use super::VerifyError;
use super::alike::{self, Bins, IndependentShare};
use crate::fourier::RealTransform;
use crate::quantity::{Acceleration, Band, SampleRate};
use crate::render::{PartLost, RenderWarning, fade_ends};
use crate::spectrum::{EstimateError, WelchConfig, WelchPlan, segments_in};
use crate::statistics::{Z_95, median};
use crate::warning::Warning;

/// dB of a power whose natural logarithm changes by 1.
const DB_PER_NEPER: f64 = 4.342_944_819_032_518;
/// A line is hidden by the sensor's noise when its power is below this multiple of the noise.
const HIDDEN_RATIO: f64 = 3.0;
/// The noise spectrum is smoothed over this range on either side of a line, Hz, so that tones do not count as noise.
const SMOOTH_HZ: f64 = 40.0;
/// The factor by which the correlation of neighbouring lines of a Hann window increases the variance of a sum.
const LINE_CORRELATION_FACTOR: f64 = 1.4;

/// The PSDs of two aligned signals, and their statistical dependence.
pub(super) struct Pair {
    pub(super) target: Vec<f64>,
    pub(super) measured: Vec<f64>,
    /// The variance of 10·log10(measured/target) of each line by the coherence alone, dB².
    pub(super) variance_db2: Vec<f64>,
    /// For each line, the share of that variance which remains although the two estimates are not independent.
    pub(super) alike: Vec<IndependentShare>,
    pub(super) resolution_hz: f64,
}

/// The share of a signal over which its ends are tapered before it is transformed as a whole.
const TAPER_SHARE: f64 = 0.1;
/// The fewest bins over which coherence is estimated.
const COHERENCE_BINS: usize = 12;

/// Sums over the bins of a line.
#[derive(Clone, Copy, Default)]
struct Sums {
    count: usize,
    target: f64,
    measured: f64,
    cross: Complex<f64>,
}

impl Sums {
    fn add(&mut self, other: &Self) {
        self.count += other.count;
        self.target += other.target;
        self.measured += other.measured;
        self.cross += other.cross;
    }

    /// The coherence of the bins, less what unrelated signals have, 0–1.
    fn coherence(&self) -> f64 {
        let both = self.target * self.measured;
        if self.count < 2 || both <= 0.0 {
            return 0.0;
        }
        let chance = 1.0 / self.count as f64;
        // Unbiased for unrelated signals (as often negative as positive), so that the errors do not add up over lines.
        ((self.cross.norm_sqr() / both - chance) / (1.0 - chance)).clamp(-1.0, 1.0)
    }
}

/// `x` with its ends tapered, transformed as a whole.
fn tapered(x: &[f64], transform: &mut RealTransform) -> Vec<Complex<f64>> {
    let mut samples = x.to_vec();
    fade_ends(&mut samples, (TAPER_SHARE * x.len() as f64) as usize);
    transform.forward(&samples)
}

impl Pair {
    /// The PSDs of `target` and `measured` on lines as far apart as those of `welch`, with the variance of each line's ratio. A line
    /// is the mean of the bins of one transform of all samples: a gap between lines stays a gap, whereas the window of a short
    /// segment would fill it by leakage.
    ///
    /// Formula: `(10/ln 10)²·(c_t² + c_m²)·(1 − γ²)/n` with c the coefficient of variation of a line's power over segments
    /// (1 for noise, 0 for a tone), γ² the coherence of the two less what unrelated signals have, and n the number of bins.
    ///
    /// Source: P. J. Daniell (1946), J. R. Stat. Soc. Suppl. 8(1), for the average over bins; J. S. Bendat and A. G. Piersol,
    /// *Random Data*, 4th ed., section 9.2, for the variances and the coherence.
    pub(super) fn of(
        target: &[f64],
        measured: &[f64],
        welch: &WelchConfig,
        rate: SampleRate,
    ) -> Result<Self, EstimateError> {
        let resolution_hz = rate.hz() / welch.segment as f64;
        let n = target.len().min(measured.len());
        let mut transform = RealTransform::new(n.max(1));
        let (a, b) = (
            tapered(&target[..n], &mut transform),
            tapered(&measured[..n], &mut transform),
        );
        drop(transform);
        let mut sums = vec![Sums::default(); welch.segment / 2 + 1];
        for (i, (a, b)) in a.iter().zip(&b).enumerate() {
            let hz = i as f64 * rate.hz() / n as f64;
            let line = (hz / resolution_hz).round() as usize;
            if let Some(sum) = sums.get_mut(line) {
                sum.add(&Sums {
                    count: 1,
                    target: a.norm_sqr(),
                    measured: b.norm_sqr(),
                    cross: a.conj() * b,
                });
            }
        }
        let bins = Bins::of(&a, &b, |i| {
            (i as f64 * rate.hz() / n as f64 / resolution_hz).round() as usize
        });
        drop((a, b));
        let varies = [varies(&target[..n], welch)?, varies(&measured[..n], welch)?];
        // The taper takes a little of the power.
        let mut window = vec![1.0; n];
        fade_ends(&mut window, (TAPER_SHARE * n as f64) as usize);
        let power: f64 = window.iter().map(|w| w * w).sum();
        let fourth: f64 = window.iter().map(|w| w.powi(4)).sum();
        let independent = power * power / (fourth * n.max(1) as f64);
        // The coherence of the bins near a line, and how far those reach.
        let near = |k: usize| {
            let mut near = sums[k];
            let mut reach = 1;
            while near.count < COHERENCE_BINS && reach < sums.len() {
                for beside in [k.checked_sub(reach), k.checked_add(reach)]
                    .into_iter()
                    .flatten()
                {
                    if let Some(sum) = sums.get(beside) {
                        near.add(sum);
                    }
                }
                reach += 1;
            }
            (near.coherence(), reach - 1)
        };
        let near: Vec<(f64, usize)> = (0..sums.len()).map(near).collect();
        let variance = |k: usize| {
            let relative = varies[0][k] + varies[1][k];
            // Tapered, neighbouring bins are not independent; the logarithm of a mean of n scatters as the trigamma function of n.
            let averages = (sums[k].count as f64 * independent).max(1.0);
            let scatter = 1.0 / averages + 0.5 / averages.powi(2);
            DB_PER_NEPER.powi(2) * relative * (1.0 - near[k].0) * scatter
        };
        let scaled = |sum: f64, count: usize| 2.0 * sum / (rate.hz() * power * count.max(1) as f64);
        let strongest = sums.iter().map(|sum| sum.target).fold(0.0, f64::max);
        let least = strongest * 10f64.powf(NO_POWER_DB / 10.0);
        let holds: Vec<usize> = (0..sums.len())
            .filter(|k| sums[*k].count > 0 && sums[*k].target > 0.0 && sums[*k].target >= least)
            .collect();
        let alike = alike::alike(
            [&target[..n], &measured[..n]],
            welch,
            &bins,
            &near,
            &holds,
            independent,
        )?;
        Ok(Self {
            alike,
            variance_db2: (0..sums.len()).map(variance).collect(),
            target: sums
                .iter()
                .map(|sum| scaled(sum.target, sum.count))
                .collect(),
            measured: sums
                .iter()
                .map(|sum| scaled(sum.measured, sum.count))
                .collect(),
            resolution_hz,
        })
    }
}

/// The squared coefficient of variation of each line's power over segments: 1 for noise, 0 for a tone.
fn varies(x: &[f64], welch: &WelchConfig) -> Result<Vec<f64>, EstimateError> {
    let (segment, hop) = (welch.segment, welch.hop()?);
    let count = segments_in(x.len(), segment, hop);
    let window = welch.window.coefficients(segment, welch.symmetry);
    let mut transform = RealTransform::new(segment);
    let mut sums = vec![(0.0, 0.0); segment / 2 + 1];
    let mut cut = vec![0.0; segment];
    for j in 0..count {
        for ((place, w), v) in cut.iter_mut().zip(&window).zip(&x[j * hop..]) {
            *place = w * v;
        }
        for ((sum, squares), bin) in sums.iter_mut().zip(transform.forward(&cut)) {
            let power = bin.norm_sqr();
            *sum += power;
            *squares += power * power;
        }
    }
    let n = count as f64;
    let of = |(sum, squares): (f64, f64)| {
        // Too few segments to estimate the variation of a line: noise is assumed.
        if count < 4 || sum <= 0.0 {
            return 1.0;
        }
        (n / (n - 1.0) * (n * squares / (sum * sum) - 1.0)).clamp(0.0, 2.0)
    };
    Ok(sums.into_iter().map(of).collect())
}

/// The smoothed PSD of a sensor's noise while nothing is played, unit²/Hz, one value every `resolution_hz` from 0 Hz.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Floor {
    values: Vec<f64>,
    resolution_hz: f64,
}

/// The shortest stretch from which noise is estimated, s.
const SHORTEST_S: f64 = 0.1;

impl Floor {
    /// The noise of the stretches of a response that come before and after what was played; `None` when they are too short.
    ///
    /// Formula: Welch's PSD in segments of 64 ms, then the median over 40 Hz on either side: a tone occupies few lines and does
    /// not change a median.
    pub(super) fn of(quiet: &[&[f64]], rate: SampleRate) -> Option<Self> {
        let shortest = (SHORTEST_S * rate.hz()) as usize;
        let segment = 2usize
            .pow((0.064 * rate.hz()).log2().round() as u32)
            .max(16);
        let quiet: Vec<&[f64]> = quiet
            .iter()
            .copied()
            .filter(|x| x.len() >= shortest.max(segment))
            .collect();
        let welch = WelchConfig::hann(segment);
        let mut values = vec![0.0; segment / 2 + 1];
        // The unit plays no part in it.
        let mut plan = WelchPlan::new(&welch, rate).ok()?;
        let mut count = 0;
        for x in &quiet {
            let n = segments_in(x.len(), segment, segment / 2);
            let psd = plan.estimate::<Acceleration>(&[x]).ok()?;
            for (value, p) in values.iter_mut().zip(&psd.values) {
                *value += p * n as f64;
            }
            count += n;
        }
        if count < 2 {
            return None;
        }
        values.iter_mut().for_each(|value| *value /= count as f64);
        let resolution_hz = rate.hz() / segment as f64;
        let reach = ((SMOOTH_HZ / resolution_hz) as usize).max(1);
        let smooth = (0..values.len())
            .map(|k| {
                let mut near: Vec<f64> =
                    values[k.saturating_sub(reach)..(k + reach + 1).min(values.len())].to_vec();
                median(&mut near).unwrap_or(0.0)
            })
            .collect();
        Some(Self {
            values: smooth,
            resolution_hz,
        })
    }

    /// At `frequency_hz`, unit²/Hz.
    pub(super) fn at(&self, frequency_hz: f64) -> f64 {
        let k = (frequency_hz / self.resolution_hz).round() as usize;
        self.values
            .get(k.min(self.values.len().saturating_sub(1)))
            .copied()
            .unwrap_or(0.0)
    }

    /// Its power within `band`, unit².
    pub(super) fn power(&self, band: Band) -> f64 {
        let lines = self.values.iter().enumerate();
        lines
            .map(|(k, value)| {
                let centre_hz = k as f64 * self.resolution_hz;
                let low_hz = (centre_hz - 0.5 * self.resolution_hz).max(band.low().0);
                let high_hz = (centre_hz + 0.5 * self.resolution_hz).min(band.high().0);
                value * (high_hz - low_hz).max(0.0)
            })
            .sum()
    }
}

/// One line that is compared.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub(super) frequency_hz: f64,
    /// 10·log10 of measured, less the noise, over target, dB.
    pub(super) error_db: f64,
    variance_db2: f64,
    /// The half-width of the 95 % interval of that variance, dB².
    variance_half_width_db2: f64,
    /// How much smaller that variance may be, dB².
    variance_less_db2: f64,
    /// The power of the target, unit².
    pub(super) target_power: f64,
}

impl Line {
    /// The mean power of target and measurement, unit²: a weight from the target alone would be biased by its own scatter.
    pub(super) fn pooled_power(&self) -> f64 {
        0.5 * self.target_power * (1.0 + 10f64.powf(self.error_db / 10.0))
    }
}

/// The lines of a band that are compared, and those that are not.
pub(super) struct Lines {
    pub(super) compared: Vec<Line>,
    /// How many lines hold no target.
    pub(super) without_target: usize,
    /// How many lines hold target that the noise hides.
    pub(super) hidden: usize,
    /// The power of the target on those, unit².
    pub(super) hidden_power: f64,
    /// The power of the measurement, less the noise, on lines without target, unit².
    pub(super) added: f64,
}

/// Lines below this level re the strongest line of the band count as without target power, dB: sensor noise lies there.
pub(super) const NO_POWER_DB: f64 = -50.0;
/// The smallest ratio of measured to target power of a line: smaller values are rounding errors.
const LOWEST_RATIO: f64 = 1e-6;

impl Lines {
    /// The lines of `pair` within `band`; the strongest line of the band decides which hold target.
    pub(super) fn of(pair: &Pair, floor: Option<&Floor>, band: Band) -> Self {
        let step_hz = pair.resolution_hz;
        let within = |k: &usize| band.contains(*k as f64 * step_hz);
        let all: Vec<usize> = (0..pair.target.len()).filter(within).collect();
        let strongest = all.iter().map(|k| pair.target[*k]).fold(0.0, f64::max);
        let least = strongest * 10f64.powf(NO_POWER_DB / 10.0);
        let mut lines = Self {
            compared: Vec::with_capacity(all.len()),
            without_target: 0,
            hidden: 0,
            hidden_power: 0.0,
            added: 0.0,
        };
        for k in all {
            let frequency_hz = k as f64 * step_hz;
            let (target, measured) = (pair.target[k], pair.measured[k]);
            let noise = floor.map_or(0.0, |floor| floor.at(frequency_hz));
            let left = measured - noise;
            if target < least || target <= 0.0 {
                lines.without_target += 1;
                lines.added += left.max(0.0) * step_hz;
            } else if target < HIDDEN_RATIO * noise && measured < 2.0 * HIDDEN_RATIO * noise {
                lines.hidden += 1;
                lines.hidden_power += target * step_hz;
            } else {
                let ratio = (left / target).max(LOWEST_RATIO);
                // The scatter of the noise weighs more the less power of the line remains after subtracting it.
                let more = (measured / left.max(0.1 * measured)).powi(2);
                let unrelated_db2 = pair.variance_db2[k] * more.min(9.0);
                let alike = pair.alike[k];
                lines.compared.push(Line {
                    frequency_hz,
                    error_db: 10.0 * ratio.log10(),
                    variance_db2: unrelated_db2 * alike.share,
                    variance_half_width_db2: unrelated_db2.max(0.0) * alike.ci_half_width,
                    variance_less_db2: unrelated_db2.max(0.0) * alike.share * (1.0 - alike.share),
                    target_power: target * step_hz,
                });
            }
        }
        lines
    }
}

/// The rms error over lines without the part explained by the scatter of the estimates, with its 95 % confidence interval, dB.
/// Errors below the scatter cannot be resolved: the upper limit is at least half of the interval's half-width.
///
/// Formula: e² = Σw·(d² − v)/Σw with v the variance of a line's d; the variance of e² is 1.4·Σw²·(2v² + 4·(d² − v)·v)/(Σw)²,
/// its half-width is combined with that of v. The upper end is e² plus the half-width, at least half of the half-width, plus by
/// how much v may be smaller.
///
/// Source: moments of a normal variable; lines of a Hann window go together as 4/9 and 1/36; docs/decisions/verification.md.
pub(super) fn rms_error(lines: &[Line], weight: impl Fn(&Line) -> f64) -> Option<(f64, [f64; 2])> {
    let (mut sum, mut squares, mut varies) = (0.0, 0.0, 0.0);
    let (mut of_variance, mut less) = (0.0, 0.0);
    for line in lines {
        let w = weight(line);
        let (d2, v) = (line.error_db.powi(2), line.variance_db2);
        sum += w;
        squares += w * (d2 - v);
        varies += w * w * (2.0 * v * v + 4.0 * (d2 - v).max(0.0) * v);
        of_variance += w * line.variance_half_width_db2;
        less += w * line.variance_less_db2;
    }
    if !(sum > 0.0 && sum.is_finite()) {
        return None;
    }
    let found = squares / sum;
    let reach =
        (Z_95.powi(2) * LINE_CORRELATION_FACTOR * varies + of_variance.powi(2)).sqrt() / sum;
    let root = |v: f64| v.max(0.0).sqrt();
    let highest = (found + reach).max(0.5 * reach) + less / sum;
    Some((root(found), [root(found - reach), root(highest)]))
}

fn ratio_db(measured: f64, target: f64) -> f64 {
    if target > 0.0 {
        10.0 * (measured.max(target * 1e-12) / target).log10()
    } else {
        0.0
    }
}

pub(crate) fn rms_of(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0usize), |(sum, count), value| {
        (sum + value * value, count + 1)
    });
    (sum / count.max(1) as f64).sqrt()
}

/// The errors of the lines of a band.
pub(crate) struct LineErrors {
    /// Frequency in Hz and error in dB of every line with target power.
    pub(crate) compared: Vec<(f64, f64)>,
    /// How many lines hold none.
    pub(crate) without_target: usize,
    /// The sum of the measured values on those.
    pub(crate) added: f64,
}

impl LineErrors {
    /// Frequency in Hz and error in dB of the line with the largest absolute error.
    pub(super) fn largest(&self) -> Option<(f64, f64)> {
        let lines = self.compared.iter().copied();
        lines.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))
    }

    /// The rms error after the mean error of the lines is removed, dB.
    pub(super) fn level_matched_db(&self) -> f64 {
        let errors = self.compared.iter().map(|(_, error)| error);
        let mean_db = errors.clone().sum::<f64>() / self.compared.len() as f64;
        rms_of(errors.map(|error| error - mean_db))
    }

    /// The rms error of the lines within `bands`, dB.
    pub(super) fn rms_db_within(&self, bands: &[Band]) -> Option<f64> {
        let lines = self.compared.iter();
        let within: Vec<f64> = lines
            .filter(|(frequency_hz, _)| bands.iter().any(|band| band.contains(*frequency_hz)))
            .map(|(_, error)| *error)
            .collect();
        (!within.is_empty()).then(|| rms_of(within.iter().copied()))
    }

    /// The warning that a part of the band has no target.
    pub(super) fn no_target(&self) -> Option<Warning> {
        let all = self.without_target + self.compared.len();
        (self.without_target > 0).then(|| {
            Warning::from(RenderWarning::BandPartLost {
                share: self.without_target as f64 / all as f64,
                bands: Vec::new(),
                why: PartLost::NoTarget,
            })
        })
    }
}

pub(crate) fn errors_in_band(
    target: &[f64],
    measured: &[f64],
    resolution_hz: f64,
    band: Band,
) -> Result<LineErrors, VerifyError> {
    let lines: Vec<(f64, f64, f64)> = target
        .iter()
        .zip(measured)
        .enumerate()
        .map(|(k, (t, m))| (k as f64 * resolution_hz, *t, *m))
        .filter(|(frequency_hz, ..)| band.contains(*frequency_hz))
        .collect();
    if lines.is_empty() {
        return Err(VerifyError::NoLine {
            band,
            resolution_hz,
        });
    }
    let strongest = lines
        .iter()
        .fold(0.0, |strongest: f64, (_, t, _)| strongest.max(*t));
    if strongest <= 0.0 {
        return Err(VerifyError::Silent {
            what: "the target",
            band,
        });
    }
    let least = strongest * 10f64.powf(NO_POWER_DB / 10.0);
    let compared: Vec<(f64, f64)> = lines
        .iter()
        .filter(|(_, t, _)| *t >= least)
        .map(|(f, t, m)| (*f, ratio_db(*m, *t)))
        .collect();
    Ok(LineErrors {
        without_target: lines.len() - compared.len(),
        added: lines
            .iter()
            .filter(|(_, t, _)| *t < least)
            .map(|(.., m)| m)
            .sum(),
        compared,
    })
}
