//! Statistical tests of whether drive and response are related, and of the delay between them, against the distribution for
//! unrelated signals.

use crate::fourier::hann;
use num_complex::Complex;
use piezotact_fourier::ComplexPlanner;
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Gamma};

use super::{CrossSpectra, TransferFunction, TransferWarning};
use crate::fourier::{RealTransform, fast_length};
use crate::quantity::{Band, Hertz, Quantity, SampleRate};
use crate::statistics::mean;
use crate::warning::Warning;

/// The significance level of a relation: the share of unrelated pairs taken for related ones.
const FALSE_RELATED: f64 = 0.05;
/// The significance level of a delay: the share of unrelated pairs in which a peak of the correlation is taken for a delay.
const FALSE_DELAY: f64 = 0.01;
/// The coherence of a line is limited to the value that this share of unrelated lines exceeds, so that a tone in both channels,
/// such as hum, does not count as a relation.
const HELD_BEYOND: f64 = 0.05;
/// With fewer independent averages every pair is coherent.
const LEAST_AVERAGES: f64 = 1.5;
/// As many excited lines are needed.
const LEAST_LINES: usize = 4;
/// The number of lines on either side to which a window leaks.
const LEAKS_TO: usize = 4;
/// The largest lag, as a share of the recording: beyond it too few samples overlap.
const FARTHEST_LAG: f64 = 0.9;

/// The test of whether drive and response are related, from the excited lines.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Relation {
    /// The mean coherence of the excited lines, 0–1, each held at what 5 % of unrelated lines exceed.
    pub coherence: f64,
    /// The expected value of that mean for unrelated signals.
    pub chance: f64,
    /// The value that the mean exceeds in 5 % of unrelated pairs.
    pub limit: f64,
    /// Independent averages.
    pub averages: f64,
    /// Lines that were excited.
    pub lines: usize,
}

impl Relation {
    /// Whether the coherence is significantly above that of unrelated signals.
    #[must_use]
    pub fn is_shown(&self) -> bool {
        self.coherence > self.limit
    }
}

impl<I: Quantity, O: Quantity> CrossSpectra<I, O> {
    /// Whether the excited lines are more coherent than those of unrelated signals; `None` with fewer than 1.5 independent
    /// averages or 4 excited lines, which show nothing.
    ///
    /// Formula: of unrelated Gaussian signals P(γ² > x) = (1 − x)^(n − 1) with n independent averages. Each line counts
    /// with min(γ², c), P(γ² > c) = 5 %; the mean over lines is compared with the 95 % quantile of the gamma distribution
    /// of the same mean and variance, the variance taken larger by the correlation of neighbouring lines, 1 + 2·Σ ρₖ⁴ with
    /// ρₖ = Σw²·exp(−2πikj/N)/Σw² of the window w.
    ///
    /// Source: N. R. Goodman (1957), for the distribution; G. C. Carter, C. H. Knapp and A. H. Nuttall (1973), IEEE Trans.
    /// Audio Electroacoust. 21(4); P. D. Welch (1967), IEEE Trans. Audio Electroacoust. 15(2), for overlapping segments.
    #[must_use]
    pub fn relation(&self) -> Option<Relation> {
        let n = self.effective_averages;
        // The real-valued lines at both ends have another distribution.
        let inner = 1..self.drive_power.len().saturating_sub(1);
        let (excited, coherence) = (self.excited(), self.coherence());
        let found: Vec<f64> = inner
            .filter(|k| excited[*k])
            .map(|k| coherence[k])
            .collect();
        if n < LEAST_AVERAGES || found.len() < LEAST_LINES {
            return None;
        }
        let held = 1.0 - HELD_BEYOND.powf(1.0 / (n - 1.0));
        let held_mean = mean(&found.iter().map(|g| g.min(held)).collect::<Vec<_>>());
        // ∫S and ∫2x·S from 0 to c with S = (1 − x)^(n − 1).
        let upto = |power: f64| (1.0 - (1.0 - held).powf(power)) / power;
        let first = upto(n);
        let variance = 2.0 * (upto(n) - upto(n + 1.0)) - first * first;
        let independent = found.len() as f64 / self.line_correlation.max(1.0);
        let of_mean = variance / independent;
        let null = Gamma::new(first * first / of_mean, first / of_mean).ok()?;
        Some(Relation {
            coherence: held_mean,
            chance: first,
            limit: null.inverse_cdf(1.0 - FALSE_RELATED),
            averages: n,
            lines: found.len(),
        })
    }
}

/// An autocorrelation above this at a lag of a segment and more is that of a drive that repeats itself. Of independent noise it
/// stays below 0.5 in all but the shortest recordings.
const REPEATS: f64 = 0.5;

/// Whether a drive comes back after a lag of half of `segment` samples or more, up to half of its length: its autocorrelation
/// reaches 0.5 there.
///
/// Formula: ρ(k) = Σx(t)·x(t + k)/√(Σx(t)²·Σx(t + k)²) over the samples that both have, of the drive without its mean.
///
/// Source: J. S. Bendat and A. G. Piersol, *Random Data*, 4th ed., section 5.1.
pub(super) fn repeats_itself(drive: &[f64], segment: usize) -> bool {
    let (from, to) = (segment / 2, drive.len() / 2);
    if from == 0 || to <= from {
        return false;
    }
    let middle = mean(drive);
    let centred: Vec<f64> = drive.iter().map(|x| x - middle).collect();
    let mut transform = RealTransform::new(fast_length(drive.len() + to));
    let mut bins = transform.forward(&centred);
    for bin in &mut bins {
        *bin = Complex::from(bin.norm_sqr());
    }
    let correlation = transform.inverse(bins);
    // The power up to a sample, for those that both have at a lag.
    let mut power = vec![0.0];
    for x in &centred {
        power.push(power[power.len() - 1] + x * x);
    }
    let all = drive.len();
    (from..=to).any(|lag| {
        let (early, late) = (power[all - lag], power[all] - power[lag]);
        let scale = (early * late).sqrt();
        scale > 0.0 && correlation[lag] > REPEATS * scale
    })
}

/// How much larger the variance of the mean coherence over lines is, as neighbouring lines share what `window` leaks.
pub(super) fn line_correlation(window: &[f64]) -> f64 {
    let all: f64 = window.iter().map(|w| w * w).sum();
    let farthest = LEAKS_TO.min(window.len().saturating_sub(1) / 2);
    let overlap = |k: usize| -> f64 {
        let turn = -std::f64::consts::TAU * k as f64 / window.len() as f64;
        let (step, mut turned) = (Complex::from_polar(1.0, turn), Complex::from(1.0));
        let mut sum = Complex::from(0.0);
        for w in window {
            sum += turned * (w * w);
            turned *= step;
        }
        sum.norm() / all
    };
    1.0 + (1..=farthest)
        .map(|k| 2.0 * overlap(k).powi(4))
        .sum::<f64>()
}

/// The delay of a response re its drive.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Delay {
    /// The delay, s; below zero where the response comes first.
    pub delay_s: f64,
    /// How far it may be off to either side, s.
    pub ci_half_width_s: f64,
}

impl Delay {
    /// Whether two delays agree within their uncertainties.
    #[must_use]
    pub fn agrees(&self, other: &Self) -> bool {
        (self.delay_s - other.delay_s).abs() <= self.ci_half_width_s + other.ci_half_width_s
    }

    /// Whether the response comes before its drive by more than may be the uncertainty.
    #[must_use]
    pub fn is_early(&self) -> bool {
        self.delay_s < -self.ci_half_width_s
    }

    /// The warning about a response that comes first.
    pub(super) fn acausal(&self) -> Warning {
        TransferWarning::Acausal {
            lead_s: -self.delay_s,
            ci_half_width_s: self.ci_half_width_s,
        }
        .into()
    }
}

/// Squared values of an envelope over lags, each over what it is expected to be of unrelated signals but for one common
/// factor; the lags rise from `first` in samples.
struct Lags {
    squares: Vec<f64>,
    first: i64,
}

impl Lags {
    /// The peak's delay, where it stands out.
    ///
    /// Formula: of unrelated signals the squared envelope is exponentially distributed, its mean its median/ln 2; a peak
    /// over L lags stands out when it exceeds ln(L/1 %) means. Its reach is where the envelope lies within two standard
    /// deviations of its peak, and half of what the band resolves.
    fn delay(&self, step_s: f64, width_hz: f64) -> Option<Delay> {
        let at =
            (0..self.squares.len()).max_by(|a, b| self.squares[*a].total_cmp(&self.squares[*b]))?;
        let usual = crate::statistics::median(&mut self.squares.clone())? / std::f64::consts::LN_2;
        let peak = self.squares[at];
        let stands_out = peak > usual * (self.squares.len() as f64 / FALSE_DELAY).ln();
        if !stands_out || width_hz <= 0.0 {
            return None;
        }
        let sigma = (0.5 * usual).sqrt();
        let least = (peak.sqrt() - 2.0 * sigma).max(0.0).powi(2);
        let run = |lags: &mut dyn Iterator<Item = &f64>| {
            lags.take_while(|square| **square >= least).count()
        };
        let reach =
            run(&mut self.squares[at + 1..].iter()).max(run(&mut self.squares[..at].iter().rev()));
        Some(Delay {
            delay_s: (self.first + at as i64) as f64 * step_s,
            ci_half_width_s: reach as f64 * step_s + 0.5 / width_hz,
        })
    }
}

/// The squared envelope over the lags −n/2…n/2 of one-sided `bins` of a transform of `n`, those of `band` with a Hann taper
/// over it so that its ends do not ring.
fn squared_envelope(
    n: usize,
    step_hz: f64,
    band: Band,
    bin: &mut dyn FnMut(usize) -> Complex<f64>,
) -> Vec<f64> {
    let (low, width) = (band.low().0, band.high().0 - band.low().0);
    let mut bins = vec![Complex::default(); n];
    let first = (low / step_hz).ceil().max(0.0) as usize;
    let last = ((band.high().0 / step_hz).floor() as usize).min(n / 2);
    for (line, value) in bins.iter_mut().enumerate().take(last + 1).skip(first) {
        let place = (line as f64 * step_hz - low) / width;
        *value = bin(line) * hann(place);
    }
    ComplexPlanner::new().plan_fft_inverse(n).process(&mut bins);
    // Negative lags first.
    bins.rotate_right(n / 2);
    bins.iter().map(Complex::norm_sqr).collect()
}

impl<I: Quantity, O: Quantity> TransferFunction<I, O> {
    /// The delay of the response re the drive, s: the time of the maximum of the envelope of the impulse response,
    /// each line weighted with its coherence, and lines known not to be excited with zero; `None` when no maximum is
    /// significant. It lies within half a segment, 1/(2·resolution): a later response wraps around and appears as an early
    /// one.
    #[must_use]
    pub fn delay(&self) -> Option<Delay> {
        let n = 2 * (self.response.len() - 1);
        let band = self
            .excited
            .or_else(|| Band::new(Hertz(0.0), Hertz(self.highest_hz())).ok())?;
        let squares = squared_envelope(n, self.resolution_hz, band, &mut |line| {
            self.response[line] * self.coherence[line].clamp(0.0, 1.0)
        });
        let lags = Lags {
            squares,
            first: -((n / 2) as i64),
        };
        let step_s = 1.0 / (n as f64 * self.resolution_hz);
        lags.delay(step_s, band.high().0 - band.low().0)
    }
}

/// The delay of `response` re `drive`, samples taken together at `rate`, from the whole signals and independent of the segment
/// length; `None` when no lag is significant.
pub(super) fn delay_of_signals(
    drive: &[f64],
    response: &[f64],
    rate: SampleRate,
    band: Band,
) -> Option<Delay> {
    let samples = drive.len().min(response.len());
    let n = fast_length(2 * samples);
    let centred = |signal: &[f64]| {
        let offset = mean(&signal[..samples]);
        let mut all: Vec<f64> = signal[..samples].iter().map(|v| v - offset).collect();
        all.resize(n, 0.0);
        all
    };
    let mut plan = RealTransform::new(n);
    let (x, y) = (
        plan.forward(&centred(drive)),
        plan.forward(&centred(response)),
    );
    let step_hz = rate.hz() / n as f64;
    let squares = squared_envelope(n, step_hz, band, &mut |line| x[line].conj() * y[line]);
    // Fewer samples overlap at longer lags.
    let farthest = (FARTHEST_LAG * samples as f64) as usize;
    let (middle, whole) = (n / 2, samples as f64);
    let from = middle - farthest.min(middle);
    let squares: Vec<f64> = (from..(middle + farthest + 1).min(n))
        .map(|at| squares[at] / (1.0 - middle.abs_diff(at) as f64 / whole))
        .collect();
    let lags = Lags {
        squares,
        first: from as i64 - middle as i64,
    };
    lags.delay(1.0 / rate.hz(), band.high().0 - band.low().0)
}
