//! The averaged auto- and cross-spectra of two channels, from one pass over the segments.

use std::marker::PhantomData;
use std::ops::Range;

use num_complex::Complex;

use super::Estimator;
use super::related::line_correlation;
use crate::quantity::{Hertz, Quantity, SampleRate};
use crate::series::Series;
use crate::spectrum::{
    Averaging, CrossSum, EstimateError, Folded, Scaling, WelchConfig, one_sided, segments_in,
};

/// The averaged one-sided auto- and cross-spectra of a drive x (`I`) and a response y (`O`), segment/2 + 1
/// values from 0 Hz to half the rate, in units of x², y² and x·y per Hz.
#[derive(Clone, Debug, PartialEq)]
pub struct CrossSpectra<I: Quantity, O: Quantity> {
    /// Sxx, E[|X|²].
    pub drive_power: Vec<f64>,
    /// Syy, E[|Y|²].
    pub response_power: Vec<f64>,
    /// Sxy, E[conj(X)·Y].
    pub cross: Vec<Complex<f64>>,
    /// The step between values, Hz.
    pub resolution_hz: f64,
    /// The number of segments averaged.
    pub averages: usize,
    /// The equivalent number of independent segments, with the same scatter.
    pub effective_averages: f64,
    /// How much larger the variance of a mean over lines is, as neighbouring lines are correlated.
    pub(super) line_correlation: f64,
    quantities: PhantomData<(I, O)>,
}

/// The same factor for a Hann window, used when the window is not known.
const HANN_CORRELATION: f64 = 1.4;

impl<I: Quantity, O: Quantity> CrossSpectra<I, O> {
    /// Spectra that another program averaged, on a uniform axis from 0 Hz.
    ///
    /// # Errors
    /// [`EstimateError::Mismatch`] when they differ in length; [`EstimateError::TooShort`] for fewer than 2
    /// lines.
    pub fn from_parts(
        drive_power: Vec<f64>,
        response_power: Vec<f64>,
        cross: Vec<Complex<f64>>,
        resolution_hz: f64,
        averages: usize,
    ) -> Result<Self, EstimateError> {
        for (name, found) in [
            ("response power", response_power.len()),
            ("cross-spectrum", cross.len()),
        ] {
            if found != drive_power.len() {
                return Err(EstimateError::Mismatch {
                    left: "drive power",
                    right: name,
                    what: "the number of lines",
                    left_value: drive_power.len().to_string(),
                    right_value: found.to_string(),
                });
            }
        }
        if drive_power.len() < 2 {
            return Err(EstimateError::TooShort {
                expected: 2,
                found: drive_power.len(),
            });
        }
        Ok(Self {
            drive_power,
            response_power,
            cross,
            resolution_hz,
            averages,
            effective_averages: averages as f64,
            line_correlation: HANN_CORRELATION,
            quantities: PhantomData,
        })
    }

    /// H1 = Sxy/Sxx, one complex value a line, in units of y per x; 0 where the drive has no power.
    #[must_use]
    pub fn h1(&self) -> Vec<Complex<f64>> {
        let ratio = |(cross, power): (&Complex<f64>, &f64)| {
            if *power > 0.0 {
                cross / power
            } else {
                Complex::default()
            }
        };
        self.cross
            .iter()
            .zip(&self.drive_power)
            .map(ratio)
            .collect()
    }

    /// H2 = Syy/Syx with Syx = conj(Sxy), in units of y per x; 0 where the two share nothing.
    #[must_use]
    pub fn h2(&self) -> Vec<Complex<f64>> {
        let ratio = |(power, cross): (&f64, &Complex<f64>)| {
            if cross.norm_sqr() > 0.0 {
                *power / cross.conj()
            } else {
                Complex::default()
            }
        };
        self.response_power
            .iter()
            .zip(&self.cross)
            .map(ratio)
            .collect()
    }

    /// Hv, the total least squares of noise on both channels, in units of y per x; 0 where the two share nothing.
    /// `noise_ratio` is the power of the noise on the response over that on the drive, in (units of y per x)².
    ///
    /// Formula: (Syy − κ·Sxx + √((κ·Sxx − Syy)² + 4κ·|Sxy|²))/(2·Syx).
    ///
    /// Source: K. Shin and J. K. Hammond (2008), *Fundamentals of Signal Processing*, section 9.3; as pyFRF.
    #[must_use]
    pub fn hv_for(&self, noise_ratio: f64) -> Vec<Complex<f64>> {
        let ratio = |((cross, x), y): ((&Complex<f64>, &f64), &f64)| {
            total_least_squares(*cross, *x, *y, noise_ratio)
        };
        self.lines().map(ratio).collect()
    }

    /// Hv where noise has the same share of both channels' power on every line: the geometric mean of H1 and H2, which
    /// depends on no choice of units; 0 where the two share nothing.
    ///
    /// Formula: [`Self::hv_for`] with κ = Syy/Sxx, that is √(Syy/Sxx)·Sxy/|Sxy|.
    ///
    /// Source: as [`Self::hv_for`].
    #[must_use]
    pub fn hv(&self) -> Vec<Complex<f64>> {
        self.lines()
            .map(|((cross, x), y)| {
                total_least_squares(*cross, *x, *y, if *x > 0.0 { y / x } else { 0.0 })
            })
            .collect()
    }

    /// The transfer function by `estimator`, one complex value a line, in units of y per x.
    ///
    /// Formula: that of the estimator.
    ///
    /// Source: as [`Self::h1`], [`Self::h2`], [`Self::hv`] and [`Self::hv_for`].
    #[must_use]
    pub fn ratio(&self, estimator: Estimator) -> Vec<Complex<f64>> {
        match estimator {
            Estimator::H1 => self.h1(),
            Estimator::H2 => self.h2(),
            Estimator::Hv => self.hv(),
            Estimator::HvAt { noise_ratio } => self.hv_for(noise_ratio),
        }
    }

    fn lines(&self) -> impl Iterator<Item = ((&Complex<f64>, &f64), &f64)> {
        self.cross
            .iter()
            .zip(&self.drive_power)
            .zip(&self.response_power)
    }

    /// Coherence γ² = |Sxy|²/(Sxx·Syy), one value a line, 0–1; 0 where either has no power.
    #[must_use]
    pub fn coherence(&self) -> Vec<f64> {
        self.lines()
            .map(|((cross, x), y)| {
                if *x > 0.0 && *y > 0.0 {
                    cross.norm_sqr() / (x * y)
                } else {
                    0.0
                }
            })
            .collect()
    }
}

/// Lines this far below the strongest are not excited: 40 dB.
pub(super) const EXCITED: f64 = 1e-4;

impl<I: Quantity, O: Quantity> CrossSpectra<I, O> {
    /// Whether each line is excited, that is within 40 dB of the strongest.
    #[must_use]
    pub fn excited(&self) -> Vec<bool> {
        let strongest = self.drive_power.iter().copied().fold(0.0, f64::max);
        let least = EXCITED * strongest;
        self.drive_power.iter().map(|p| *p > least).collect()
    }

    /// The median coherence of the lines from `lowest` up that are excited; `None` when there are none.
    #[must_use]
    pub fn excited_coherence(&self, lowest: Hertz) -> Option<f64> {
        let lines = self.coherence().into_iter().zip(self.excited()).enumerate();
        let high = |line: usize| line as f64 * self.resolution_hz >= lowest.0;
        let mut excited: Vec<f64> = lines
            .filter(|(line, (_, excited))| *excited && high(*line))
            .map(|(_, (coherence, _))| coherence)
            .collect();
        crate::statistics::median(&mut excited)
    }
}

/// As [`CrossSpectra::hv_for`], of one line.
pub(super) fn total_least_squares(
    cross: Complex<f64>,
    x: f64,
    y: f64,
    noise_ratio: f64,
) -> Complex<f64> {
    if cross.norm_sqr() <= 0.0 {
        return Complex::default();
    }
    let difference = noise_ratio * x - y;
    let root = difference
        .mul_add(difference, 4.0 * noise_ratio * cross.norm_sqr())
        .sqrt();
    // The form of the root without cancellation.
    if difference <= 0.0 {
        (root - difference) / (2.0 * cross.conj())
    } else {
        2.0 * noise_ratio * cross / (root + difference)
    }
}

/// A planned estimate of cross-spectra, made once and used for many pairs of channels.
#[derive(Clone, Debug)]
pub struct CrossPlan {
    config: WelchConfig,
    sums: CrossSum,
    segment: usize,
    rate: SampleRate,
    hop: usize,
    scale: f64,
    line_correlation: f64,
}

impl CrossPlan {
    /// A plan for pairs of channels at `rate`.
    ///
    /// # Errors
    /// [`EstimateError::Config`] when the configuration is not possible: the median of a complex cross-spectrum is
    /// not defined, and ratios of spectra need densities.
    pub fn new(config: &WelchConfig, rate: SampleRate) -> Result<Self, EstimateError> {
        let hop = config.hop()?;
        if config.averaging != Averaging::Mean || config.scaling != Scaling::Density {
            return Err(EstimateError::Config {
                what: "the mean of densities for a transfer function",
                found: format!("{:?} of {:?}", config.averaging, config.scaling),
            });
        }
        let n = config.segment;
        let window = config.window.coefficients(n, config.symmetry);
        let scale = 1.0 / (rate.hz() * window.iter().map(|w| w * w).sum::<f64>());
        Ok(Self {
            sums: CrossSum::new(&window, config.detrend.into()),
            line_correlation: line_correlation(&window),
            segment: n,
            config: config.clone(),
            rate,
            hop,
            scale,
        })
    }

    /// The cross-spectra of `drive` and `response`, samples taken together in their SI units.
    ///
    /// # Errors
    /// [`EstimateError::Mismatch`] when they differ in length, [`EstimateError::TooShort`] when they hold no
    /// segment.
    pub fn estimate<I: Quantity, O: Quantity>(
        &mut self,
        drive: &[f64],
        response: &[f64],
    ) -> Result<CrossSpectra<I, O>, EstimateError> {
        self.estimate_of(drive, response, &|_| true)
    }

    /// As [`Self::estimate`], using only the segments for which `counts` is true.
    fn estimate_of<I: Quantity, O: Quantity>(
        &mut self,
        drive: &[f64],
        response: &[f64],
        counts: &dyn Fn(&Range<usize>) -> bool,
    ) -> Result<CrossSpectra<I, O>, EstimateError> {
        if drive.len() != response.len() {
            return Err(EstimateError::Mismatch {
                left: I::NAME,
                right: O::NAME,
                what: "the number of samples",
                left_value: drive.len().to_string(),
                right_value: response.len().to_string(),
            });
        }
        let n = self.segment;
        let cuts =
            (0..segments_in(drive.len(), n, self.hop)).map(|i| i * self.hop..i * self.hop + n);
        let cuts: Vec<Range<usize>> = cuts.filter(counts).collect();
        let averages = cuts.len();
        if averages == 0 {
            return Err(EstimateError::TooShort {
                expected: n,
                found: drive.len(),
            });
        }
        self.sums.clear();
        for pair in cuts.chunks(2) {
            match pair {
                [a, b] => self.sums.add_pair(
                    [&drive[a.clone()], &drive[b.clone()]],
                    [&response[a.clone()], &response[b.clone()]],
                ),
                [last] => self
                    .sums
                    .add_single(&drive[last.clone()], &response[last.clone()]),
                _ => {}
            }
        }
        self.spectra(averages)
    }

    /// The spectra of what was summed over so many segments.
    fn spectra<I: Quantity, O: Quantity>(
        &self,
        averages: usize,
    ) -> Result<CrossSpectra<I, O>, EstimateError> {
        let n = self.segment;
        let scale = self.scale / averages as f64;
        let Folded {
            xx: mut drive_power,
            yy: mut response_power,
            xy: mut cross,
        } = self.sums.folded();
        one_sided(&mut drive_power, n, scale);
        one_sided(&mut response_power, n, scale);
        let last = cross.len() - 1;
        for (k, value) in cross.iter_mut().enumerate() {
            let alone = k == 0 || (k == last && n.is_multiple_of(2));
            *value *= if alone { scale } else { 2.0 * scale };
        }
        Ok(CrossSpectra {
            drive_power,
            response_power,
            cross,
            resolution_hz: self.rate.hz() / n as f64,
            averages,
            effective_averages: self.config.effective_averages(averages)?,
            line_correlation: self.line_correlation,
            quantities: PhantomData,
        })
    }
}

/// Cross-spectra of two signals that come part by part: those of the whole signals, bit for bit.
#[derive(Debug)]
pub(super) struct CrossInParts {
    plan: CrossPlan,
    held: [Vec<f64>; 2],
    /// A segment that counts and has no other beside it yet.
    alone: Option<[Vec<f64>; 2]>,
    /// The sample with which the next segment begins.
    next: usize,
    averages: usize,
}

impl CrossInParts {
    pub(super) fn new(config: &WelchConfig, rate: SampleRate) -> Result<Self, EstimateError> {
        let mut plan = CrossPlan::new(config, rate)?;
        plan.sums.clear();
        Ok(Self {
            plan,
            held: [Vec::new(), Vec::new()],
            alone: None,
            next: 0,
            averages: 0,
        })
    }

    /// Takes the next samples of both, as many of each; only the segments for which `counts` is true are used.
    pub(super) fn add(
        &mut self,
        drive: &[f64],
        response: &[f64],
        counts: &dyn Fn(&Range<usize>) -> bool,
    ) {
        self.held[0].extend_from_slice(drive);
        self.held[1].extend_from_slice(response);
        let (n, mut from) = (self.plan.segment, 0);
        while let (Some(x), Some(y)) = (
            self.held[0].get(from..from + n),
            self.held[1].get(from..from + n),
        ) {
            if counts(&(self.next..self.next + n)) {
                self.averages += 1;
                match self.alone.take() {
                    Some([a, b]) => self.plan.sums.add_pair([&a, x], [&b, y]),
                    None => self.alone = Some([x.to_vec(), y.to_vec()]),
                }
            }
            from += self.plan.hop;
            self.next += self.plan.hop;
        }
        for held in &mut self.held {
            held.drain(..from);
        }
    }

    /// The spectra of all `samples`.
    pub(super) fn spectra<I: Quantity, O: Quantity>(
        mut self,
        samples: usize,
    ) -> Result<CrossSpectra<I, O>, EstimateError> {
        if let Some([x, y]) = &self.alone {
            self.plan.sums.add_single(x, y);
        }
        match self.averages {
            0 => Err(EstimateError::TooShort {
                expected: self.plan.segment,
                found: samples,
            }),
            averages => self.plan.spectra(averages),
        }
    }
}

/// The cross-spectra of `drive` and `response`, segment/2 + 1 lines from 0 Hz to half the rate.
///
/// Source: Bendat and Piersol, Random Data, chapter 7; Sxy = E[conj(X)·Y].
///
/// # Errors
/// [`EstimateError::Mismatch`] when rate or length differ, [`EstimateError::Silent`] when either is silent,
/// [`EstimateError::TooShort`] when they hold no segment, [`EstimateError::Config`] when the configuration
/// cannot be.
pub fn cross_spectra<I: Quantity, O: Quantity>(
    drive: &Series<I>,
    response: &Series<O>,
    config: &WelchConfig,
) -> Result<CrossSpectra<I, O>, EstimateError> {
    cross_spectra_of(drive, response, config, &|_| true)
}

/// As [`cross_spectra`], using only the segments for which `counts` is true.
pub(super) fn cross_spectra_of<I: Quantity, O: Quantity>(
    drive: &Series<I>,
    response: &Series<O>,
    config: &WelchConfig,
    counts: &dyn Fn(&Range<usize>) -> bool,
) -> Result<CrossSpectra<I, O>, EstimateError> {
    if drive.rate() != response.rate() {
        return Err(EstimateError::Mismatch {
            left: I::NAME,
            right: O::NAME,
            what: "the rate",
            left_value: drive.rate().to_string(),
            right_value: response.rate().to_string(),
        });
    }
    for (signal, samples) in [
        ("the drive", drive.samples()),
        ("the response", response.samples()),
    ] {
        if samples.iter().all(|v| *v == samples[0]) {
            return Err(EstimateError::Silent { signal });
        }
    }
    config.fits(drive.samples().len().min(response.samples().len()))?;
    CrossPlan::new(config, drive.rate())?.estimate_of(drive.samples(), response.samples(), counts)
}
