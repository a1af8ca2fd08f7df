//! Spectra: windows, Welch's averaged periodograms, spectrograms, and the Fourier amplitude spectrum.
//!
//! The scaling is a field of the value: a power spectral density cannot be taken for a power spectrum.

mod document;
mod in_blocks;
mod page;
mod spectrogram;
mod warning;
mod window;

pub use document::SpectrumDocument;
pub(crate) use in_blocks::Held;
pub use in_blocks::WelchInBlocks;
use std::marker::PhantomData;
pub use warning::SpectrumWarning;

use num_complex::Complex;
use serde::{Deserialize, Serialize};

pub(crate) use piezotact_fourier::{CrossSum, Folded, segments_in};
pub use spectrogram::{Cells, Spectrogram, SpectrogramConfig, SpectrogramInBlocks, spectrogram};
pub use window::{Symmetry, UnknownWindow, Window};

use crate::quantity::{Hertz, Quantity, SampleRate};
use crate::series::Series;
use crate::statistics::median;
use crate::warning::{Few, FewWarning, Warning};
use piezotact_fourier::{PowerSum, SegmentTransform};

/// What is taken away from every segment before the window.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Detrend {
    /// Nothing.
    None,
    /// The mean.
    Constant,
    /// The least-squares line.
    Linear,
}

impl From<Detrend> for piezotact_fourier::Detrend {
    fn from(detrend: Detrend) -> Self {
        match detrend {
            Detrend::None => Self::None,
            Detrend::Constant => Self::Constant,
            Detrend::Linear => Self::Linear,
        }
    }
}

/// How the periodograms of the segments become one spectrum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Averaging {
    /// Their mean.
    Mean,
    /// Their median, corrected for its bias: robust against single disturbed segments.
    Median,
}

/// What the values of a one-sided spectrum are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Scaling {
    /// Power spectral density, unit²/Hz: for noise-like signals.
    Density,
    /// Power spectrum, unit²: for the mean square of single tones.
    Spectrum,
}

/// How a spectrum is estimated. There is no default: it is stated, and goes into the result.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct WelchConfig {
    /// The window.
    pub window: Window,
    /// Its form.
    pub symmetry: Symmetry,
    /// The segment's length in samples.
    pub segment: usize,
    /// The share of a segment that the next one repeats, 0 ≤ overlap < 1.
    pub overlap: f64,
    /// The detrending of every segment.
    pub detrend: Detrend,
    /// How segments are averaged.
    pub averaging: Averaging,
    /// What the values are.
    pub scaling: Scaling,
}

impl WelchConfig {
    /// Hann, 50 % overlap, constant detrend, mean, density, over segments of `segment` samples.
    #[must_use]
    pub fn hann(segment: usize) -> Self {
        Self {
            window: Window::Hann,
            symmetry: Symmetry::Periodic,
            segment,
            overlap: 0.5,
            detrend: Detrend::Constant,
            averaging: Averaging::Mean,
            scaling: Scaling::Density,
        }
    }

    /// For the amplitudes of tones: flat top, 75 % overlap, constant detrend, mean, power spectrum, over segments of `segment`
    /// samples.
    #[must_use]
    pub fn tones(segment: usize) -> Self {
        Self {
            window: Window::FlatTop,
            overlap: 0.75,
            scaling: Scaling::Spectrum,
            ..Self::hann(segment)
        }
    }

    /// The setting that goes with the 2024 thesis' recordings: Hann, 1024 samples at 5 kHz (4.9 Hz), 50 %.
    #[must_use]
    pub fn thesis_2024() -> Self {
        Self::hann(1024)
    }

    /// The equivalent number of independent segments, with the same scatter as `segments` overlapping ones, for noise.
    ///
    /// Formula: n/(1 + 2·Σₖ(1 − k/n)·ρₖ²) with ρₖ = Σw(t)w(t + k·hop)/Σw².
    ///
    /// Source: P. D. Welch (1967), IEEE Trans. Audio Electroacoust. 15(2), equation 7.
    ///
    /// # Errors
    /// Those of [`Self::hop`].
    ///
    /// ```
    /// use piezotact::spectrum::WelchConfig;
    /// // Hann at 50 %: ρ₁ = 1/6.
    /// let n = WelchConfig::hann(1024).effective_averages(1_000).unwrap();
    /// assert!((n - 1_000.0 / (1.0 + 2.0 * 0.999 / 36.0)).abs() < 1e-6);
    /// ```
    pub fn effective_averages(&self, segments: usize) -> Result<f64, EstimateError> {
        let hop = self.hop()?;
        let window = self.window.coefficients(self.segment, self.symmetry);
        let power: f64 = window.iter().map(|w| w * w).sum();
        let n = segments as f64;
        let shared: f64 = (1..segments)
            .take_while(|k| k * hop < self.segment)
            .map(|k| {
                let both: f64 = window
                    .iter()
                    .zip(&window[k * hop..])
                    .map(|(a, b)| a * b)
                    .sum();
                (1.0 - k as f64 / n) * (both / power).powi(2)
            })
            .sum();
        Ok(n / (1.0 + 2.0 * shared))
    }

    /// The segments of `samples` samples; none where there is none.
    pub(crate) fn cuts(&self, samples: usize) -> Vec<std::ops::Range<usize>> {
        let count = |hop: &usize| segments_in(samples, self.segment, *hop);
        let hop = self.hop().unwrap_or(1);
        let all = self.hop().as_ref().map_or(0, count);
        (0..all).map(|i| i * hop..i * hop + self.segment).collect()
    }

    /// Checks, before anything is planned, that `samples` hold a segment.
    pub(crate) fn fits(&self, samples: usize) -> Result<(), EstimateError> {
        self.hop()?;
        if samples < self.segment {
            return Err(EstimateError::TooShort {
                expected: self.segment,
                found: samples,
            });
        }
        Ok(())
    }

    /// The step between segments in samples.
    ///
    /// # Errors
    /// [`EstimateError::Config`] when the segment is shorter than 2 or the overlap is not in 0 ≤ overlap < 1.
    pub fn hop(&self) -> Result<usize, EstimateError> {
        if self.segment < 2 {
            return Err(EstimateError::Config {
                what: "a segment of 2 samples or more",
                found: self.segment.to_string(),
            });
        }
        if !(0.0..1.0).contains(&self.overlap) {
            return Err(EstimateError::Config {
                what: "an overlap from 0 up to, not including, 1",
                found: self.overlap.to_string(),
            });
        }
        let repeated = (self.segment as f64 * self.overlap).floor() as usize;
        Ok((self.segment - repeated).max(1))
    }
}

/// A one-sided spectrum of a quantity `Q`: segment/2 + 1 values from 0 Hz to half the rate, in unit²/Hz or
/// unit² as `scaling` says.
#[derive(Clone, Debug, PartialEq)]
pub struct Spectrum<Q: Quantity> {
    /// The values, from 0 Hz up.
    pub values: Vec<f64>,
    /// The step between values, Hz.
    pub resolution_hz: f64,
    /// The number of segments averaged.
    pub averages: usize,
    /// How it was made.
    pub config: WelchConfig,
    /// What a person should know before relying on it.
    pub warnings: Vec<Warning>,
    quantity: PhantomData<Q>,
}

impl<Q: Quantity> Spectrum<Q> {
    /// The frequency of every value, Hz.
    #[must_use]
    pub fn frequencies_hz(&self) -> Vec<f64> {
        frequency_axis(self.resolution_hz, self.values.len())
    }

    /// The peak amplitude of the sine whose power each line holds, in the unit of `Q`: √(2·P), and √P at 0 Hz and half the rate.
    /// That of a tone, under a flat-top window, within 0.1 % wherever it falls; that of noise grows with the width of a line.
    ///
    /// Source: G. Heinzel, A. Rüdiger and R. Schilling, *Spectrum and spectral density estimation by the DFT* (2002), sections
    /// 9 and D.
    ///
    /// ```
    /// use piezotact::quantity::{Acceleration, SampleRate};
    /// use piezotact::spectrum::{Scaling, WelchConfig, welch};
    /// let rate = SampleRate::new(5000.0).unwrap();
    /// let tone = (0..50_000).map(|i| 1.3 * (std::f64::consts::TAU * 123.4 * i as f64 / 5000.0).sin());
    /// let tone = piezotact::Series::<Acceleration>::new(tone.collect(), rate).unwrap();
    /// for scaling in [Scaling::Spectrum, Scaling::Density] {
    ///     let config = WelchConfig { scaling, ..WelchConfig::tones(4096) };
    ///     let amplitudes = welch(&tone, &config).unwrap().amplitudes();
    ///     let highest = amplitudes.into_iter().fold(0.0, f64::max);
    ///     assert!((highest / 1.3 - 1.0).abs() < 2e-3);
    /// }
    /// ```
    #[must_use]
    pub fn amplitudes(&self) -> Vec<f64> {
        let n = self.config.segment;
        let width_hz = match self.config.scaling {
            Scaling::Spectrum => 1.0,
            Scaling::Density => {
                let window = self.config.window.coefficients(n, self.config.symmetry);
                let sum: f64 = window.iter().sum();
                let power: f64 = window.iter().map(|w| w * w).sum();
                self.resolution_hz * n as f64 * power / (sum * sum)
            }
        };
        let amplitude = |(k, value): (usize, &f64)| {
            let alone = k == 0 || 2 * k == n;
            (if alone { 1.0 } else { 2.0 } * value * width_hz).sqrt()
        };
        self.values.iter().enumerate().map(amplitude).collect()
    }

    /// The strongest line above 0 Hz: its frequency in Hz and its value.
    #[must_use]
    pub fn strongest(&self) -> (f64, f64) {
        let strongest = self
            .values
            .iter()
            .enumerate()
            .skip(1)
            .max_by(|a, b| a.1.total_cmp(b.1));
        strongest.map_or((0.0, 0.0), |(k, value)| {
            (k as f64 * self.resolution_hz, *value)
        })
    }
}

/// `bins` frequencies from 0 Hz in steps of `resolution_hz`.
pub(crate) fn frequency_axis(resolution_hz: f64, bins: usize) -> Vec<f64> {
    (0..bins).map(|k| k as f64 * resolution_hz).collect()
}

/// Fewer segments than this in an average is a warning: the PSD of a random signal then scatters by more
/// than 1.4 dB (4.34·√(1/10)).
pub const RECOMMENDED_SEGMENTS: usize = 10;

/// A planned Welch estimate: window, transform and memory, made once and used for many signals.
#[derive(Clone, Debug)]
pub struct WelchPlan {
    config: WelchConfig,
    rate: SampleRate,
    hop: usize,
    average: Average,
    window_power: f64,
    window_sum: f64,
}

/// What an average over segments needs.
#[derive(Clone, Debug)]
enum Average {
    /// Their sum.
    Mean(PowerSum),
    /// Every one by itself.
    Median(SegmentTransform, Vec<Complex<f64>>),
}

impl WelchPlan {
    /// A plan for signals at `rate`.
    ///
    /// # Errors
    /// [`EstimateError::Config`] when the configuration cannot be.
    pub fn new(config: &WelchConfig, rate: SampleRate) -> Result<Self, EstimateError> {
        let hop = config.hop()?;
        let window = config.window.coefficients(config.segment, config.symmetry);
        Ok(Self {
            window_power: window.iter().map(|w| w * w).sum(),
            window_sum: window.iter().sum(),
            average: match config.averaging {
                Averaging::Mean => Average::Mean(PowerSum::new(&window, config.detrend.into())),
                Averaging::Median => Average::Median(
                    SegmentTransform::new(window, config.detrend.into()),
                    vec![Complex::default(); config.segment],
                ),
            },
            config: config.clone(),
            rate,
            hop,
        })
    }

    /// The one-sided spectrum of each of `records` taken together: the average runs over the segments of
    /// all of them, and no segment spans two records. segment/2 + 1 values in unit²/Hz or unit².
    ///
    /// # Errors
    /// [`EstimateError::TooShort`] when no record holds a segment.
    pub fn estimate<Q: Quantity>(
        &mut self,
        records: &[&[f64]],
    ) -> Result<Spectrum<Q>, EstimateError> {
        let averages: usize = records
            .iter()
            .map(|record| self.segments_in(record.len()))
            .sum();
        if averages == 0 {
            return Err(EstimateError::TooShort {
                expected: self.config.segment,
                found: records.iter().map(|record| record.len()).max().unwrap_or(0),
            });
        }
        let (n, hop) = (self.config.segment, self.hop);
        let values = match &mut self.average {
            Average::Mean(sum) => mean_power(sum, records, n, hop, averages),
            Average::Median(transform, z) => median_power(transform, z, records, hop, averages),
        };
        Ok(self.spectrum(values, averages))
    }

    /// The spectrum whose two-sided average over segments is `values`, not scaled.
    fn spectrum<Q: Quantity>(&self, mut values: Vec<f64>, averages: usize) -> Spectrum<Q> {
        let scale = match self.config.scaling {
            Scaling::Density => 1.0 / (self.rate.hz() * self.window_power),
            Scaling::Spectrum => 1.0 / (self.window_sum * self.window_sum),
        };
        one_sided(&mut values, self.config.segment, scale);
        let mut warnings = Vec::new();
        if averages < RECOMMENDED_SEGMENTS {
            warnings.push(Warning::from(FewWarning::Few {
                found: averages,
                recommended: RECOMMENDED_SEGMENTS,
                what: Few::Segments,
            }));
        }
        Spectrum {
            values,
            resolution_hz: self.rate.hz() / self.config.segment as f64,
            averages,
            config: self.config.clone(),
            warnings,
            quantity: PhantomData,
        }
    }

    fn segments_in(&self, samples: usize) -> usize {
        segments_in(samples, self.config.segment, self.hop)
    }
}

fn mean_power(
    sum: &mut PowerSum,
    records: &[&[f64]],
    segment: usize,
    hop: usize,
    averages: usize,
) -> Vec<f64> {
    sum.clear();
    for record in records {
        let count = segments_in(record.len(), segment, hop);
        let cut = |i: usize| &record[i * hop..i * hop + segment];
        for i in (1..count).step_by(2) {
            sum.add_pair(cut(i - 1), cut(i));
        }
        if count % 2 == 1 {
            sum.add_single(cut(count - 1));
        }
    }
    mean_of(sum, averages)
}

fn mean_of(sum: &PowerSum, averages: usize) -> Vec<f64> {
    let mut values = sum.folded();
    for value in &mut values {
        *value /= averages as f64;
    }
    values
}

fn median_power(
    transform: &mut SegmentTransform,
    z: &mut [Complex<f64>],
    records: &[&[f64]],
    hop: usize,
    averages: usize,
) -> Vec<f64> {
    let mut columns = vec![Vec::with_capacity(averages); z.len() / 2 + 1];
    for record in records {
        transform.each_pair(record, hop, z, |z, both| {
            piezotact_fourier::split_power(z, |k, a, b| {
                columns[k].push(a);
                if both {
                    columns[k].push(b);
                }
            });
        });
    }
    let bias = median_bias(averages);
    columns
        .iter_mut()
        .map(|column| median(column).unwrap_or(0.0) / bias)
        .collect()
}

/// Scales two-sided power to one-sided: every bin that stands for two frequencies counts twice.
pub(crate) fn one_sided(values: &mut [f64], segment: usize, scale: f64) {
    let last = values.len() - 1;
    for (k, value) in values.iter_mut().enumerate() {
        let alone = k == 0 || (k == last && segment.is_multiple_of(2));
        *value *= if alone { scale } else { 2.0 * scale };
    }
}

/// The ratio of the median to the mean of `n` periodograms of noise, dimensionless.
///
/// Source: B. Allen et al. (2012), FINDCHIRP, appendix B: 1 + Σ 1/(2i+1) − 1/(2i), as SciPy corrects it.
pub(crate) fn median_bias(n: usize) -> f64 {
    (1..=(n.saturating_sub(1)) / 2)
        .map(|i| 2.0 * i as f64)
        .fold(1.0, |bias, even| bias + 1.0 / (even + 1.0) - 1.0 / even)
}

/// One-sided spectrum of `x` by Welch's method, segment/2 + 1 values from 0 Hz to half the rate, in
/// unit²/Hz (or unit², as the configuration says).
///
/// Formula: mean over segments of |FFT(w·(x − trend))|² / (rate·Σw²), doubled except at 0 Hz and Nyquist.
///
/// Source: P. D. Welch (1967), IEEE Trans. Audio Electroacoust. 15(2).
///
/// # Errors
/// [`EstimateError::TooShort`] when `x` holds no segment, [`EstimateError::Config`] when the configuration
/// cannot be.
///
/// ```
/// use piezotact::quantity::{Acceleration, SampleRate};
/// use piezotact::spectrum::{WelchConfig, welch};
/// let rate = SampleRate::new(5000.0).unwrap();
/// let tone = (0..50_000).map(|i| (std::f64::consts::TAU * 250.0 * i as f64 / 5000.0).sin());
/// let tone = piezotact::Series::<Acceleration>::new(tone.collect(), rate).unwrap();
/// let psd = welch(&tone, &WelchConfig::thesis_2024()).unwrap();
/// let power: f64 = psd.values.iter().sum::<f64>() * psd.resolution_hz;
/// assert!((power - 0.5).abs() < 1e-3); // the mean square of a sine of amplitude 1
/// ```
pub fn welch<Q: Quantity>(
    x: &Series<Q>,
    config: &WelchConfig,
) -> Result<Spectrum<Q>, EstimateError> {
    config.fits(x.samples().len())?;
    WelchPlan::new(config, x.rate())?.estimate(&[x.samples()])
}

/// One-sided amplitude spectrum of the whole of `x`: frequencies in Hz and peak amplitudes in the unit of
/// `Q`, n/2 + 1 of each. This is the "FFT" of the thesis' figures.
///
/// Formula: 2|FFT(x)|/n, half of that at 0 Hz and Nyquist.
///
/// Source: Oppenheim and Schafer, Discrete-Time Signal Processing, chapter 8.
#[must_use]
pub fn amplitude_spectrum<Q: Quantity>(x: &Series<Q>) -> (Vec<f64>, Vec<f64>) {
    let n = x.samples().len();
    let spectrum = crate::fourier::RealTransform::new(n).forward(x.samples());
    let amplitudes = spectrum.iter().enumerate().map(|(k, bin)| {
        let alone = k == 0 || 2 * k == n;
        bin.norm() * if alone { 1.0 } else { 2.0 } / n as f64
    });
    (
        frequency_axis(x.rate().hz() / n as f64, spectrum.len()),
        amplitudes.collect(),
    )
}

/// The warning about a channel whose `samples` (full scale = 1) are less than 50 converter steps rms, where one
/// step is `step_ratio` of full scale: quantisation noise, step²/12, then lies less than 45 dB below the signal.
///
/// Source: B. Widrow (1956), IRE Trans. Circuit Theory 3(4).
#[must_use]
pub fn quantisation_warning(channel: &str, samples: &[f64], step_ratio: f64) -> Option<Warning> {
    let rms_in_steps = crate::statistics::rms(samples) / step_ratio;
    (rms_in_steps < 50.0).then(|| {
        Warning::from(SpectrumWarning::CoarseQuantisation {
            channel: channel.into(),
            rms_in_steps,
        })
    })
}

/// Why a spectrum or a transfer function cannot be estimated.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EstimateError {
    /// The configuration is not possible.
    #[error(
        "expected {what}, found {found}; a Hann window, 1024 samples and an overlap of 0.5 are usual"
    )]
    Config { what: &'static str, found: String },
    /// The signal holds no segment.
    #[error(
        "expected at least one segment of {expected} samples, found {found}; use a shorter segment or a longer recording"
    )]
    TooShort {
        expected: usize,
        /// The longest record's length.
        found: usize,
    },
    /// A highest frequency that the segments cannot show.
    #[error(
        "expected a highest frequency from the first line, {lowest}, to half the rate, {highest}, found {found}; choose one in between, or a longer segment for a lower line"
    )]
    Frequency {
        /// The first line above 0 Hz.
        lowest: Hertz,
        highest: Hertz,
        /// What was asked for.
        found: Hertz,
    },
    /// Two signals that do not belong together.
    #[error(
        "cannot relate {left} to {right}: {what} is {left_value} in one and {right_value} in the other; use both from one \
            recording"
    )]
    Mismatch {
        left: &'static str,
        right: &'static str,
        what: &'static str,
        /// Its value in the first.
        left_value: String,
        /// Its value in the second.
        right_value: String,
    },
    /// A signal that is silent where it is needed.
    #[error(
        "expected {signal} to contain a signal, found silence; check the cable and the channel"
    )]
    Silent { signal: &'static str },
}
