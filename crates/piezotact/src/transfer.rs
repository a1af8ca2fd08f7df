//! Transfer functions between two channels: H1, H2 and coherence from one pass over the segments.
//!
//! The cross-spectrum is Sxy = E[conj(X)·Y], so that Y = H·X gives Sxy/Sxx = H. Its conjugate has the same
//! magnitude and a mirrored phase: a drive computed with it has the right spectrum and the wrong waveform.

mod bundle;

pub use bundle::{
    Bundle, BundleAverage, BundleError, LeaveOneOut, Penalty, average, bundle, leave_one_out,
};

use std::marker::PhantomData;

use num_complex::Complex;
use serde::{Deserialize, Serialize};

use crate::device::DriveSetup;
use crate::doubt::Doubt;
use crate::fourier;
use crate::quantity::{Band, Quantity, SampleRate, Seconds};
use crate::recording::{Condition, Provenance};
use crate::series::Series;
use crate::spectrum::{
    Averaging, EstimateError, RECOMMENDED_SEGMENTS, Scaling, SegmentTransform, WelchConfig,
    fold_cross, fold_power, frequency_axis, one_sided, segments_in,
};

/// Which ratio of spectra estimates the transfer function.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Estimator {
    /// Sxy/Sxx: unbiased by noise on the response.
    H1,
    /// Syy/Syx: unbiased by noise on the drive.
    H2,
}

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
    quantities: PhantomData<(I, O)>,
}

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

    /// Coherence γ² = |Sxy|²/(Sxx·Syy), one value a line, 0–1; 0 where either has no power.
    #[must_use]
    pub fn coherence(&self) -> Vec<f64> {
        self.cross
            .iter()
            .zip(&self.drive_power)
            .zip(&self.response_power)
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

impl<I: Quantity, O: Quantity> CrossSpectra<I, O> {
    /// The median coherence of the lines that are driven, that is within 40 dB of the strongest; `None` when
    /// the drive has no power.
    #[must_use]
    pub fn driven_coherence(&self) -> Option<f64> {
        let strongest = self.drive_power.iter().copied().fold(0.0, f64::max);
        let coherence = self.coherence();
        let mut driven: Vec<f64> = coherence
            .into_iter()
            .zip(&self.drive_power)
            .filter(|(_, power)| **power > 1e-4 * strongest)
            .map(|(coherence, _)| coherence)
            .collect();
        driven.sort_by(f64::total_cmp);
        driven.get(driven.len() / 2).copied()
    }
}

/// A planned estimate of cross-spectra, made once and used for many pairs of channels.
#[derive(Clone, Debug)]
pub struct CrossPlan {
    transform: SegmentTransform,
    rate: SampleRate,
    hop: usize,
    scale: f64,
    zx: Vec<Complex<f64>>,
    zy: Vec<Complex<f64>>,
    drive_power: Vec<f64>,
    response_power: Vec<f64>,
    cross: Vec<Complex<f64>>,
}

impl CrossPlan {
    /// A plan for pairs of channels at `rate`.
    ///
    /// # Errors
    /// [`EstimateError::Config`] when the configuration cannot be: the median of a complex cross-spectrum is
    /// not defined, and ratios of spectra are made of densities.
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
            transform: SegmentTransform::new(window, config.detrend),
            rate,
            hop,
            scale,
            zx: vec![Complex::default(); n],
            zy: vec![Complex::default(); n],
            drive_power: vec![0.0; 2 * n],
            response_power: vec![0.0; 2 * n],
            cross: vec![Complex::default(); n],
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
        if drive.len() != response.len() {
            return Err(EstimateError::Mismatch {
                left: I::NAME,
                right: O::NAME,
                what: "the number of samples",
                left_value: drive.len().to_string(),
                right_value: response.len().to_string(),
            });
        }
        let n = self.transform.segment();
        let averages = segments_in(drive.len(), n, self.hop);
        if averages == 0 {
            return Err(EstimateError::TooShort {
                expected: n,
                found: drive.len(),
            });
        }
        self.drive_power.fill(0.0);
        self.response_power.fill(0.0);
        self.cross.fill(Complex::default());
        for i in (0..averages).step_by(2) {
            let (a, b) = (i * self.hop, (i + 1) * self.hop);
            if i + 1 < averages {
                self.transform
                    .transform_pair(&drive[a..a + n], &drive[b..b + n], &mut self.zx);
                self.transform.transform_pair(
                    &response[a..a + n],
                    &response[b..b + n],
                    &mut self.zy,
                );
            } else {
                self.transform
                    .transform_single(&drive[a..a + n], &mut self.zx);
                self.transform
                    .transform_single(&response[a..a + n], &mut self.zy);
            }
            self.transform.add_power(&self.zx, &mut self.drive_power);
            self.transform.add_power(&self.zy, &mut self.response_power);
            self.transform
                .add_cross(&self.zx, &self.zy, &mut self.cross);
        }
        let scale = self.scale / averages as f64;
        let mut drive_power = fold_power(&self.drive_power);
        let mut response_power = fold_power(&self.response_power);
        one_sided(&mut drive_power, n, scale);
        one_sided(&mut response_power, n, scale);
        let mut cross = fold_cross(&self.cross);
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
            quantities: PhantomData,
        })
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
    CrossPlan::new(config, drive.rate())?.estimate(drive.samples(), response.samples())
}

/// The transfer function from a drive `I` to a response `O`: one complex value and one coherence a line, on
/// a uniform axis from 0 Hz to half the rate, in units of `O` per `I`, with all that it holds for.
#[derive(Clone, Debug, PartialEq)]
pub struct TransferFunction<I: Quantity, O: Quantity> {
    response: Vec<Complex<f64>>,
    coherence: Vec<f64>,
    resolution_hz: f64,
    /// The rate of the recording it was estimated from.
    pub rate: SampleRate,
    /// How it was estimated.
    pub estimator: Estimator,
    /// The number of segments averaged.
    pub averages: usize,
    /// Who touched how.
    pub condition: Condition,
    /// Gain and level of the device it was measured through; absent for a plant that is no PIEZOTACT.
    pub drive: Option<DriveSetup>,
    /// Where it comes from.
    pub provenance: Provenance,
    /// What a person should know before relying on it.
    pub doubts: Vec<Doubt>,
    quantities: PhantomData<(I, O)>,
}

/// Coherence over a band.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CoherenceSummary {
    /// The band.
    pub band_hz: Band,
    /// The lowest coherence, 0–1.
    pub lowest: f64,
    /// Where it is lowest, Hz.
    pub lowest_at_hz: f64,
    /// The median coherence, 0–1.
    pub median: f64,
}

/// A drive that explains less than half of the response's power at most of its lines is another signal's.
const UNRELATED: f64 = 0.5;

/// Coherence above 1 by more than this is no rounding: the pair of signals cannot have it.
pub(crate) const COHERENCE_ROUNDING: f64 = 1e-6;

impl<I: Quantity, O: Quantity> TransferFunction<I, O> {
    /// The transfer function that `spectra` estimate.
    ///
    /// # Errors
    /// Those of [`Self::from_lines`].
    pub fn from_spectra(
        spectra: &CrossSpectra<I, O>,
        estimator: Estimator,
        rate: SampleRate,
    ) -> Result<Self, TransferError> {
        let response = match estimator {
            Estimator::H1 => spectra.h1(),
            Estimator::H2 => spectra.h2(),
        };
        let mut function = Self::from_lines(
            response,
            spectra.coherence(),
            spectra.resolution_hz,
            rate,
            estimator,
            spectra.averages,
        )?;

        if let Some(median_coherence) = spectra
            .driven_coherence()
            .filter(|median| *median < UNRELATED)
        {
            // A delay between two unrelated signals is the place of a random peak: nothing is said of it.
            function.doubts.push(Doubt::Unrelated { median_coherence });
            return Ok(function);
        }
        let segment = Seconds(1.0 / spectra.resolution_hz);
        let delay = function.delay();
        if delay.0 > 0.05 * segment.0 {
            function.doubts.push(Doubt::LateResponse {
                delay_s: delay.0,
                segment_s: segment.0,
            });
        }
        Ok(function)
    }

    /// A transfer function from its lines: complex values and coherence from 0 Hz in steps of
    /// `resolution_hz`. Coherence above 1 is kept as it is and comes back as a doubt.
    ///
    /// # Errors
    /// [`TransferError::Lines`] when there are fewer than 2 lines, the two lists differ in length, or the
    /// axis does not rise; [`TransferError::NotFinite`] with the line that is NaN or infinite;
    /// [`TransferError::Zero`] when the device does not answer at all.
    pub fn from_lines(
        response: Vec<Complex<f64>>,
        coherence: Vec<f64>,
        resolution_hz: f64,
        rate: SampleRate,
        estimator: Estimator,
        averages: usize,
    ) -> Result<Self, TransferError> {
        if response.len() < 2 || response.len() != coherence.len() {
            return Err(TransferError::Lines {
                response: response.len(),
                coherence: coherence.len(),
            });
        }
        if !(resolution_hz.is_finite() && resolution_hz > 0.0) {
            return Err(TransferError::Resolution {
                found: resolution_hz,
            });
        }
        let finite =
            |(h, c): (&Complex<f64>, &f64)| h.re.is_finite() && h.im.is_finite() && c.is_finite();
        if let Some(line) = response
            .iter()
            .zip(&coherence)
            .position(|pair| !finite(pair))
        {
            return Err(TransferError::NotFinite {
                frequency_hz: line as f64 * resolution_hz,
            });
        }
        if response.iter().all(|h| h.norm_sqr() == 0.0) {
            return Err(TransferError::Zero);
        }
        let mut doubts = coherence_doubts(&coherence, resolution_hz);
        // 0 stands for a number that the file does not say.
        if averages > 0 && averages < RECOMMENDED_SEGMENTS {
            doubts.push(Doubt::FewAverages {
                averages,
                recommended: RECOMMENDED_SEGMENTS,
            });
        }
        Ok(Self {
            response,
            coherence,
            resolution_hz,
            rate,
            estimator,
            averages,
            condition: Condition::default(),
            drive: None,
            provenance: Provenance::default(),
            doubts,
            quantities: PhantomData,
        })
    }

    /// One complex value a line, in units of `O` per `I`.
    #[must_use]
    pub fn response(&self) -> &[Complex<f64>] {
        &self.response
    }

    /// Coherence of every line, 0–1.
    #[must_use]
    pub fn coherence(&self) -> &[f64] {
        &self.coherence
    }

    /// The step between lines, Hz.
    #[must_use]
    pub fn resolution_hz(&self) -> f64 {
        self.resolution_hz
    }

    /// The frequency of every line, Hz.
    #[must_use]
    pub fn frequencies_hz(&self) -> Vec<f64> {
        frequency_axis(self.resolution_hz, self.response.len())
    }

    /// The highest line's frequency, Hz.
    #[must_use]
    pub fn highest_hz(&self) -> f64 {
        self.resolution_hz * (self.response.len() - 1) as f64
    }

    /// The value at any frequency up to the highest line, real and imaginary part interpolated linearly.
    #[must_use]
    pub fn at(&self, frequency_hz: f64) -> Complex<f64> {
        let place = (frequency_hz / self.resolution_hz).max(0.0);
        let line = (place as usize).min(self.response.len() - 2);
        let between = (place - line as f64).min(1.0);
        let (below, above) = (self.response[line], self.response[line + 1]);
        below + (above - below) * between
    }

    /// The lines that lie in `band`: index and frequency in Hz.
    pub fn lines_in(&self, band: Band) -> impl Iterator<Item = (usize, f64)> + '_ {
        (0..self.response.len())
            .map(|k| (k, k as f64 * self.resolution_hz))
            .filter(move |(_, frequency_hz)| band.contains(*frequency_hz))
    }

    /// The largest magnitude in `band`, in units of `O` per `I`; 0 when no line lies in it.
    #[must_use]
    pub fn peak_magnitude(&self, band: Band) -> f64 {
        self.lines_in(band)
            .fold(0.0, |peak, (k, _)| self.response[k].norm().max(peak))
    }

    /// How late the response comes: the time of the largest value of the impulse response, each line weighted
    /// with its coherence so that what is not driven has no say; 0 when the largest value lies at a negative
    /// time.
    #[must_use]
    pub fn delay(&self) -> Seconds {
        let n = 2 * (self.response.len() - 1);
        let weighted = self
            .response
            .iter()
            .zip(&self.coherence)
            .map(|(h, coherence)| h * coherence.clamp(0.0, 1.0))
            .collect();
        let impulse = fourier::RealTransform::new(n).inverse(weighted);
        let largest = (0..n)
            .max_by(|&a, &b| impulse[a].abs().total_cmp(&impulse[b].abs()))
            .unwrap_or(0);
        // The second half stands for negative times.
        let late = if largest <= n / 2 { largest } else { 0 };
        Seconds(late as f64 / (n as f64 * self.resolution_hz))
    }

    /// The lowest coherence in `band`, where it is in Hz, and the median; `None` when no line lies in it.
    #[must_use]
    pub fn coherence_in(&self, band: Band) -> Option<CoherenceSummary> {
        let mut lines: Vec<(f64, f64)> = self
            .lines_in(band)
            .map(|(k, f)| (self.coherence[k], f))
            .collect();
        lines.sort_by(|a, b| a.0.total_cmp(&b.0));
        let (lowest, lowest_at_hz) = *lines.first()?;
        Some(CoherenceSummary {
            band_hz: band,
            lowest,
            lowest_at_hz,
            median: lines[lines.len() / 2].0,
        })
    }

    /// The doubt about coherence below `least_coherence` in `band`, if there is one.
    #[must_use]
    pub fn low_coherence(&self, band: Band, least_coherence: f64) -> Option<Doubt> {
        let lines: Vec<(f64, f64)> = self
            .lines_in(band)
            .map(|(k, frequency_hz)| (self.coherence[k], frequency_hz))
            .collect();
        let below = lines
            .iter()
            .filter(|(coherence, _)| *coherence < least_coherence)
            .count();
        let (lowest, at_hz) = lines.iter().copied().min_by(|a, b| a.0.total_cmp(&b.0))?;
        (below > 0).then(|| Doubt::LowCoherence {
            asked: least_coherence,
            lowest,
            at_hz,
            share: below as f64 / lines.len() as f64,
        })
    }
}

fn coherence_doubts(coherence: &[f64], resolution_hz: f64) -> Vec<Doubt> {
    let possible = -COHERENCE_ROUNDING..=1.0 + COHERENCE_ROUNDING;
    let impossible: Vec<(usize, f64)> = coherence
        .iter()
        .copied()
        .enumerate()
        .filter(|(_, found)| !possible.contains(found))
        .collect();
    let worst = impossible
        .iter()
        .max_by(|a, b| (a.1 - 0.5).abs().total_cmp(&(b.1 - 0.5).abs()));
    worst
        .map(|(line, found)| Doubt::ImpossibleCoherence {
            at_hz: *line as f64 * resolution_hz,
            found: *found,
            lines: impossible.len(),
        })
        .into_iter()
        .collect()
}

/// The transfer function from `drive` to `response` with its coherence.
///
/// Formula: H1 = Sxy/Sxx or H2 = Syy/Syx, γ² = |Sxy|²/(Sxx·Syy), with Sxy = E[conj(X)·Y].
///
/// Source: Bendat and Piersol, Random Data, chapters 6 and 7. (The thesis' eq. 7 writes the conjugate.)
///
/// # Errors
/// [`TransferError::Estimate`] when the spectra cannot be estimated; those of
/// [`TransferFunction::from_lines`].
pub fn estimate<I: Quantity, O: Quantity>(
    drive: &Series<I>,
    response: &Series<O>,
    config: &WelchConfig,
    estimator: Estimator,
) -> Result<TransferFunction<I, O>, TransferError> {
    let spectra = cross_spectra(drive, response, config)?;
    let mut function = TransferFunction::from_spectra(&spectra, estimator, drive.rate())?;
    function.provenance.steps.push(format!(
        "transfer function {estimator:?}, {} window, segments of {} samples, {} % overlap, {} averages",
        config.window.name(),
        config.segment,
        (config.overlap * 100.0).round(),
        spectra.averages
    ));
    Ok(function)
}

/// Why there is no transfer function.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TransferError {
    /// The spectra cannot be estimated.
    #[error(transparent)]
    Estimate(#[from] EstimateError),
    /// The lines do not make an axis.
    #[error(
        "expected the same number of values and coherences, 2 or more, found {response} and {coherence}; export the transfer function whole"
    )]
    Lines {
        /// The number of complex values.
        response: usize,
        /// The number of coherences.
        coherence: usize,
    },
    /// The step between lines is not above zero.
    #[error(
        "expected frequencies that rise evenly from 0 Hz, found a step of {found} Hz; export the transfer function on a uniform axis"
    )]
    Resolution {
        /// The step found.
        found: f64,
    },
    /// A line is NaN or infinite.
    #[error(
        "expected finite values, found none at {frequency_hz:.2} Hz; measure again or cut the band"
    )]
    NotFinite {
        /// The line's frequency.
        frequency_hz: f64,
    },
    /// Nothing comes through.
    #[error(
        "expected a device that answers its drive, found a response of zero at every frequency; check the sensor and the amplifier"
    )]
    Zero,
}
