//! Transfer functions between two channels: H1, H2 and coherence from one pass over the segments.
//!
//! The cross-spectrum is Sxy = E[conj(X)·Y], so that Y = H·X gives Sxy/Sxx = H. Its conjugate has the same
//! magnitude and a mirrored phase: a drive computed with it has the right spectrum and the wrong waveform.

mod at_rest;
mod between;
mod bias;
mod broken;
mod bundle;
mod change;
mod clock;
mod coherence;
mod confidence;
mod cross;
mod error;
mod estimator;
mod impact;
#[cfg(feature = "modal")]
mod impact_page;
mod in_parts;
mod in_time;
mod judge;
mod multisine;
mod page;
mod periodic;
mod plausible;
mod related;
mod repeats;
mod stored;
mod warning;

pub use at_rest::{AtRest, AtRestCriterion, at_rest};
pub use between::{BetweenChannels, BetweenConfig, between_channels};
pub use bias::Bias;
pub use broken::pair_warnings;
pub(crate) use bundle::level_db;
pub use bundle::{BundleAverage, Ensemble, average};
pub use change::Change;
pub use clock::{OneClock, on_one_clock, prepared};
pub(crate) use coherence::COHERENCE_ROUNDING;
pub use coherence::CoherenceSummary;
pub use confidence::{Confidence, Limits};
pub use cross::{CrossPlan, CrossSpectra, cross_spectra};
pub use error::TransferError;
pub use estimator::Estimator;
pub(crate) use impact::short_pulses;
pub use impact::{
    Excitation, ExponentialWindow, ForceWindow, Hit, HitFault, ImpactConfig, ImpactSegment,
    ImpactTest, ImpactTraces, ImpactWarning, NotDecayed, Transient, transient,
};
#[cfg(feature = "modal")]
pub use impact::{ImpactEstimate, estimate_impacts};
pub use in_parts::between_in_parts;
pub use multisine::{BestLinear, Distortion, DistortionLevels, SEGMENTS_OF_A_PERIOD, best_linear};
pub use page::{TransferReport, figure};
pub use periodic::{Blocks, estimate_sweeps};
pub use related::{Delay, Relation};
pub use repeats::{max_pair_difference_db, pooled};
pub use stored::StoredIdentities;
pub use warning::{StoredFault, Swapped, TransferWarning};

use judge::{Found, Unexcited};
use std::marker::PhantomData;
use std::ops::Range;

use num_complex::Complex;
use serde::Serialize;

use crate::checksum::Checksum;
use crate::device::DriveSetup;
use crate::fourier;
use crate::quantity::{Band, Hertz, Quantity, SampleRate};
use crate::recording::{About, LostBy, RecordingWarning};
use crate::series::{Series, is_sample};
use crate::spectrum::{RECOMMENDED_SEGMENTS, WelchConfig, frequency_axis};
use crate::statistics::median;
use crate::warning::{Few, FewWarning, Warning};

/// The transfer function from a drive `I` to a response `O`: one complex value and one coherence a line, on
/// a uniform axis from 0 Hz to half the rate, in units of `O` per `I`, with the condition and device it is valid for. Documents leave
/// the lines out, which have a file of their own.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct TransferFunction<I: Quantity, O: Quantity> {
    #[serde(skip)]
    response: Vec<Complex<f64>>,
    #[serde(skip)]
    coherence: Vec<f64>,
    /// The distance of two lines, Hz.
    resolution_hz: f64,
    /// The rate of the recording it was estimated from.
    #[serde(rename = "rate_hz")]
    pub rate: SampleRate,
    /// How it was estimated.
    pub estimator: Estimator,
    /// Whether the drive is known without noise, as the signal that was sent and not a measurement of it, and does not repeat
    /// itself but in realisations.
    pub known_input: bool,
    /// The number of segments averaged.
    pub averages: usize,
    /// The equivalent number of independent segments, with the same scatter; 0 when not known.
    pub effective_averages: f64,
    /// From the lowest to the highest line that was excited; absent when not known.
    #[serde(rename = "excited_hz")]
    pub excited: Option<Band>,
    /// Condition, provenance and warnings.
    #[serde(flatten, serialize_with = "About::merged")]
    #[cfg_attr(
        feature = "schemas",
        schemars(with = "crate::recording::MergedAbout<'static>")
    )]
    pub about: About,
    /// Gain and level of the device it was measured with; absent for a system that is not a PIEZOTACT.
    #[serde(rename = "drive_setup")]
    pub drive: Option<DriveSetup>,
    /// The hits and the windows of an impact test, with the damping that an exponential window added; absent for other
    /// drives.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub impact: Option<ImpactTest>,
    /// How the response changed while it was measured: the transfer function is a mean of several states then. Absent where no change is
    /// shown.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub change: Option<Change>,
    #[serde(skip)]
    quantities: PhantomData<(I, O)>,
}

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
        let (mut function, found) = Self::of_spectra(spectra, estimator, rate)?;
        let warnings = found.warnings(&function);
        function.about.warnings.extend(warnings);
        Ok(function)
    }

    /// The transfer function that `spectra` estimate, and what its lines show.
    fn of_spectra(
        spectra: &CrossSpectra<I, O>,
        estimator: Estimator,
        rate: SampleRate,
    ) -> Result<(Self, Found), TransferError> {
        let ratio = spectra.ratio(estimator);
        // One segment agrees with itself, whatever it holds.
        let coherence = match spectra.averages {
            1 => vec![0.0; ratio.len()],
            _ => spectra.coherence(),
        };
        let mut function = Self::from_lines(
            ratio,
            coherence,
            spectra.resolution_hz,
            rate,
            estimator,
            spectra.averages,
        )?;
        let few = function.few_averages();
        function.about.warnings.extend(few);
        function.effective_averages = spectra.effective_averages;
        let excited = spectra.excited();
        function.excited =
            judge::excited_band(&excited, &spectra.drive_power, spectra.resolution_hz);
        let found = Found::of(spectra, &function);
        Ok((function, found))
    }

    /// The transfer function that `spectra` estimate of the two signals they come from, of which the band `driven` is known to be
    /// driven, and what its lines show.
    fn estimated(
        spectra: &CrossSpectra<I, O>,
        estimator: Estimator,
        (drive, response): (&Series<I>, &Series<O>),
        driven: Option<Band>,
    ) -> Result<(Self, Found), TransferError> {
        let (mut function, mut found) = Self::of_spectra(spectra, estimator, drive.rate())?;
        judge::timing(&function, &mut found, drive, response);
        if let Some(driven) = driven {
            let inside = judge::driven_within(function.excited, driven, function.resolution_hz);
            function.excited = Some(inside);
            found.narrow(inside);
        }
        let warnings = found.warnings(&function);
        function.about.warnings.extend(warnings);
        Ok((function, found))
    }

    /// The same with how its response changed while it was measured, and the warning about it.
    #[must_use]
    pub fn with_change(mut self, change: Option<Change>) -> Self {
        let warning = change.as_ref().map(Change::warning);
        self.about.warnings.extend(warning);
        self.change = change;
        self
    }

    /// The warnings about its averages and coherence, which those of another estimate of the same system do not share.
    fn warnings_of_estimate(&self) -> Vec<Warning> {
        let mut warnings = coherence::impossible(&self.coherence, self.resolution_hz);
        warnings.extend(self.few_averages());
        warnings.extend(judge::weak_warning(self));
        warnings
    }

    /// The warning that few segments were averaged. Hits are counted by other standards, and 0 stands for a number that a file does
    /// not state.
    #[must_use]
    pub fn few_averages(&self) -> Option<Warning> {
        let is_few = (1..RECOMMENDED_SEGMENTS).contains(&self.averages);
        let few = FewWarning::Few {
            found: self.averages,
            recommended: RECOMMENDED_SEGMENTS,
            what: Few::Averages,
        };
        (is_few && self.impact.is_none()).then(|| few.into())
    }

    /// A transfer function from its lines: complex values and coherence from 0 Hz in steps of
    /// `resolution_hz`. Coherence above 1 is kept as it is and comes back as a warning.
    ///
    /// # Errors
    /// [`TransferError::Lines`] when there are fewer than 2 lines, the two lists differ in length, or the
    /// axis does not rise; [`TransferError::NotFinite`] with the line that is NaN, infinite or beyond 1e100;
    /// [`TransferError::Zero`] when the response is zero at every line.
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
            |(h, c): (&Complex<f64>, &f64)| is_sample(h.re) && is_sample(h.im) && c.is_finite();
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
        let warnings = coherence::impossible(&coherence, resolution_hz);
        Ok(Self {
            response,
            coherence,
            resolution_hz,
            rate,
            estimator,
            known_input: false,
            averages,
            about: About {
                warnings,
                ..About::default()
            },
            drive: None,
            impact: None,
            change: None,
            effective_averages: averages as f64,
            excited: None,
            quantities: PhantomData,
        })
    }

    /// One complex value a line, in units of `O` per `I`.
    #[must_use]
    pub fn response(&self) -> &[Complex<f64>] {
        &self.response
    }

    /// Coherence of every line, 0–1; 0 where there is none, as of one average.
    #[must_use]
    pub fn coherence(&self) -> &[f64] {
        &self.coherence
    }

    /// Whether there is a coherence: one segment, or one hit of an impact test, has none.
    #[must_use]
    pub fn has_coherence(&self) -> bool {
        match &self.impact {
            Some(test) => test.used() > 1,
            None => self.averages != 1,
        }
    }

    /// The checksum of the lines: equal checksums mean the same measurement.
    #[must_use]
    pub fn checksum(&self) -> Checksum {
        let lines = self.response.iter().flat_map(|h| [h.re, h.im]);
        Checksum::of(std::iter::once(self.resolution_hz).chain(lines))
    }

    /// The same measurement with every line multiplied by `factor`, a complex number by frequency in Hz.
    #[must_use]
    pub fn times(mut self, factor: impl Fn(f64) -> Complex<f64>) -> Self {
        for (line, h) in self.response.iter_mut().enumerate() {
            *h *= factor(line as f64 * self.resolution_hz);
        }
        self
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

    /// The coherence at any frequency up to the highest line, interpolated linearly.
    #[must_use]
    pub fn coherence_at(&self, frequency_hz: f64) -> f64 {
        let place = (frequency_hz / self.resolution_hz).max(0.0);
        let line = (place as usize).min(self.coherence.len() - 2);
        let between = (place - line as f64).min(1.0);
        self.coherence[line] + (self.coherence[line + 1] - self.coherence[line]) * between
    }

    /// The lines that lie in `band`: index and frequency in Hz.
    pub fn lines_in(&self, band: Band) -> impl Iterator<Item = (usize, f64)> + '_ {
        (0..self.response.len())
            .map(|k| (k, k as f64 * self.resolution_hz))
            .filter(move |(_, frequency_hz)| band.contains(*frequency_hz))
    }

    /// The parts of the band `asked` that were not excited, and their share of it, 0–1; none where what was excited is not known.
    fn unexcited(&self, asked: Band) -> Unexcited {
        let outside = |excited| judge::outside(excited, asked, self.resolution_hz);
        self.excited.map(outside).unwrap_or_default()
    }

    /// The share of the band `asked` that was not excited, 0–1; 0 where what was excited is not known.
    #[must_use]
    pub fn unexcited_share(&self, asked: Band) -> f64 {
        self.unexcited(asked).1
    }

    /// The warning about the part of the band `asked` that was not excited, if there is one.
    #[must_use]
    pub fn not_excited(&self, asked: Band) -> Option<Warning> {
        judge::not_excited(self.unexcited(asked))
    }

    /// The largest magnitude in `band`, in units of `O` per `I`; 0 when no line lies in it.
    #[must_use]
    pub fn peak_magnitude(&self, band: Band) -> f64 {
        self.lines_in(band)
            .fold(0.0, |peak, (k, _)| self.response[k].norm().max(peak))
    }

    /// The frequency of the largest magnitude in `band`, Hz; `None` when no line lies in it.
    #[must_use]
    pub fn strongest_hz(&self, band: Band) -> Option<f64> {
        self.lines_in(band)
            .max_by(|a, b| {
                let magnitude = |k: usize| self.response[k].norm();
                magnitude(a.0).total_cmp(&magnitude(b.0))
            })
            .map(|(_, hertz)| hertz)
    }

    /// Frequency in Hz and phase in radians of every line of `band`, the phase without jumps from −π to π, that of the first line
    /// within them.
    ///
    /// Formula: the multiple of 2π that brings each phase nearest to the one before it is added.
    ///
    /// Source: A. V. Oppenheim and R. W. Schafer, Discrete-Time Signal Processing (2010), 13.6.
    #[must_use]
    pub fn unwrapped_phase_rad(&self, band: Band) -> Vec<(f64, f64)> {
        let lines = || self.lines_in(band);
        let phases = unwrapped(lines().map(|(line, _)| self.response[line]));
        lines().map(|(_, hz)| hz).zip(phases).collect()
    }

    /// The impulse response at twice the highest line, as many samples as twice the lines less one, in units of `O` per
    /// `I`; the second half stands for negative times. Lines known not to be excited are set to zero, and of the
    /// lines at 0 Hz and at the upper end only the real parts are kept.
    #[must_use]
    pub fn impulse_response(&self) -> Vec<f64> {
        let excited = |line: usize| {
            let frequency_hz = line as f64 * self.resolution_hz;
            self.excited.is_none_or(|band| band.contains(frequency_hz))
        };
        let lines = self.response.iter().enumerate();
        let bins = lines
            .map(|(line, h)| {
                if excited(line) {
                    *h
                } else {
                    Complex::default()
                }
            })
            .collect();
        fourier::RealTransform::new(2 * (self.response.len() - 1)).inverse(bins)
    }

    /// The part of the excited band from 20 Hz on, Hz, in which textures are felt; all of it where it ends below. Where what was
    /// excited is not known it is everything.
    #[must_use]
    pub fn tactile_band(&self) -> Band {
        let whole = Band::up_to(Hertz(self.highest_hz()));
        let shown = self.excited.unwrap_or(whole);
        Band::new(Hertz(shown.low().0.max(20.0)), shown.high()).unwrap_or(shown)
    }

    /// The median of half the width of the limits ([`Self::confidence`]) over the lines of `band`, dB; infinite where most have no lower
    /// limit, `None` where none are known.
    #[must_use]
    pub fn median_reach_db(&self, band: Band) -> Option<f64> {
        let limits = self.confidence()?;
        let of = |(line, _): (usize, f64)| {
            // A lower limit of 0 is infinitely far below.
            10.0 * (limits.high[line] / limits.low[line].max(0.0)).log10()
        };
        let mut reach: Vec<f64> = self.lines_in(band).map(of).collect();
        median(&mut reach)
    }
}

/// The phase of each of `response` without jumps, radians.
pub(crate) fn unwrapped(response: impl Iterator<Item = Complex<f64>>) -> Vec<f64> {
    use std::f64::consts::TAU;
    let mut phase = 0.0;
    response
        .map(|h| {
            let own = h.arg();
            phase = own + TAU * ((phase - own) / TAU).round();
            phase
        })
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
    let mut function = estimate_without(drive, response, config, estimator, Known::default())?;
    let broken = pair_warnings(drive, response);
    function.about.warnings.extend(broken);
    Ok(function)
}

/// What is known of two signals beside their samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Known<'a> {
    /// From when to when samples are lost, s: segments that touch these stretches are left out.
    pub lost_s: &'a [[f64; 2]],
    /// The band that is driven: lines outside it count as not excited, even if the ends of a drive have power there, and gaps in the
    /// drive are only reported within it. Absent where it is not known.
    pub driven: Option<Band>,
}

/// As [`estimate`], with what is `known` of the signals beside their samples, and without the warnings of [`pair_warnings`].
///
/// Source: as [`estimate`]; docs/decisions/transfer-functions.md: straight lines in the place of samples are no measurement.
///
/// # Errors
/// Those of [`estimate`]; [`TransferError::FewLeft`] when fewer than four segments are left of more; [`TransferError::Transient`]
/// for a drive of short pulses, which a window weights by their place in the segment.
pub fn estimate_without<I: Quantity, O: Quantity>(
    drive: &Series<I>,
    response: &Series<O>,
    config: &WelchConfig,
    estimator: Estimator,
    known: Known<'_>,
) -> Result<TransferFunction<I, O>, TransferError> {
    Ok(estimate_with_findings(drive, response, config, estimator, known)?.function)
}

/// An estimate with what its lines show and the spectra it was made from.
struct Estimate<I: Quantity, O: Quantity> {
    function: TransferFunction<I, O>,
    found: Found,
    spectra: CrossSpectra<I, O>,
}

/// As [`estimate_without`], with all of it.
fn estimate_with_findings<I: Quantity, O: Quantity>(
    drive: &Series<I>,
    response: &Series<O>,
    config: &WelchConfig,
    estimator: Estimator,
    known: Known<'_>,
) -> Result<Estimate<I, O>, TransferError> {
    let rate = drive.rate();
    if let Some(Transient { hits, share }) = transient(drive.samples(), rate) {
        return Err(TransferError::Transient { hits, share });
    }
    // With hum, or noise, between them they hold less of the energy: what they are is not decided.
    let pulses = pulses_in(drive.samples(), rate);
    let lost = |cut: &Range<usize>| touches(cut, known.lost_s, rate);
    let of = config.cuts(drive.samples().len());
    let left_out = of.iter().filter(|cut| lost(cut)).count();
    let left = few_left(of.len(), left_out)?;
    let spectra = cross::cross_spectra_of(drive, response, config, &|cut| !lost(cut))?;
    let said = left.into_iter().chain(pulses);
    of_spectra(spectra, (drive, response), config, (estimator, known), said)
}

/// The estimate that `spectra` give, with the delay and what else the lines show of `signals`, and what is `said` of their segments.
fn of_spectra<I: Quantity, O: Quantity>(
    spectra: CrossSpectra<I, O>,
    signals: (&Series<I>, &Series<O>),
    config: &WelchConfig,
    (estimator, known): (Estimator, Known<'_>),
    said: impl Iterator<Item = Warning>,
) -> Result<Estimate<I, O>, TransferError> {
    let (mut function, found) =
        TransferFunction::estimated(&spectra, estimator, signals, known.driven)?;
    function.about.provenance.steps.push(format!(
        "transfer function {estimator}, {} window, segments of {} samples, {} % overlap, {} averages",
        config.window.name(),
        config.segment,
        (config.overlap * 100.0).round(),
        spectra.averages
    ));
    function.about.warnings.extend(said);
    Ok(Estimate {
        function,
        found,
        spectra,
    })
}

/// The warning about pulses that hold most of a drive.
fn pulses_in(drive: &[f64], rate: SampleRate) -> Option<Warning> {
    short_pulses(drive, rate).map(|found| {
        let (hits, energy) = (found.pulses.hits, found.energy);
        Warning::from(ImpactWarning::PulsesInDrive {
            hits,
            share: energy,
            as_impact: false,
        })
    })
}

/// Whether the samples `cut` touch one of the stretches `lost_s`.
fn touches(cut: &Range<usize>, lost_s: &[[f64; 2]], rate: SampleRate) -> bool {
    let hz = rate.hz();
    let overlap = |[from, to]: &[f64; 2]| from * hz < cut.end as f64 && to * hz > cut.start as f64;
    lost_s.iter().any(overlap)
}

/// The fewest segments that must be left when some are left out.
const FEWEST_LEFT: usize = 4;

/// The warning about `left_out` of `of` segments, where there are any.
fn few_left(of: usize, left_out: usize) -> Result<Option<Warning>, TransferError> {
    match left_out {
        0 => Ok(None),
        most if of < most + FEWEST_LEFT => Err(TransferError::FewLeft {
            left: of - most,
            of,
        }),
        _ => Ok(Some(Warning::from(RecordingWarning::SamplesLost {
            by: LostBy::Segments { left_out, of },
        }))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A delay turns the phase in a straight line, however often it goes around.
    #[test]
    fn an_unwrapped_phase_has_no_jumps() {
        for turn in [-2.9, -0.4, 0.1, 3.0] {
            let lines = (0..200).map(|line| Complex::from_polar(1.5, turn * f64::from(line)));
            for (line, phase) in unwrapped(lines).into_iter().enumerate() {
                assert!((phase - turn * line as f64).abs() < 1e-9, "{turn}: {line}");
            }
        }
    }
}
