//! Closed-loop correction: a drive is played, the response is measured, and the drive is corrected by the remaining error.
//!
//! There are two aims. *Replicate*: the waveform itself, corrected through the inverse of the transfer function, each
//! frequency weighted by its reliability. *Texture*: the power spectrum alone, corrected line by line where the response
//! exceeds the noise; the phases are then free and are chosen to lower the crest factor of the drive.

mod aligned;
mod answer;
mod crest;
mod summary;
mod warning;

use num_complex::Complex;
use serde::{Deserialize, Serialize};
pub use summary::{CorrectedRendering, RenderingSums};
pub use warning::{LoopStop, LoopWarning, MeasurementFault, MeasurementFaultWarning};

use crate::device::DriveSetup;
use crate::fourier::RealTransform;
use crate::lineage::Mode;
use crate::quantity::{Band, Decibels, Drive, Quantity};
use crate::render::{
    Coverage, Frame, Inverse, InverseConfig, InversePlan, Overload, PartLost, PhaseForm,
    RenderConfig, RenderError, RenderWarning, coverage, cut, floored, runs,
};
use crate::series::{Series, SeriesError};
use crate::spectrum::{Spectrum, WelchConfig, WelchPlan};
use crate::statistics::peak;
use crate::transfer::TransferFunction;
use crate::verify::{VerifyConfig, VerifyError};
use crate::warning::Warning;
use aligned::AlignedResponses;

/// How a drive is corrected.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct CorrectConfig {
    /// The aim of the correction: waveform or spectrum.
    pub mode: Mode,
    /// The learning gain: the share of the remaining error that one step corrects, above 0 up to 1.
    pub learning: f64,
    /// The largest change of a line in one step, dB.
    pub step_db: f64,
    /// The lowest ratio of signal to noise power at which a line is corrected.
    pub noise_ratio: f64,
    /// A line is corrected when its coherence was at least this.
    pub least_coherence: f64,
}

impl CorrectConfig {
    /// A learning gain of 0.7, at most 6 dB a step, four times the noise, a coherence of 0.5.
    #[must_use]
    pub fn usual(mode: Mode) -> Self {
        Self {
            mode,
            learning: 0.7,
            step_db: 6.0,
            noise_ratio: 4.0,
            least_coherence: 0.5,
        }
    }
}

/// The range on either side of a line over which its cost in drive is averaged, Hz.
const SMOOTH_HZ: f64 = 4.0;
/// The lowest share of a line assumed in a correction step; smaller shares count as this.
const LEAST_SHARE: f64 = 0.05;
/// A line is disturbed by other lines when less than this share of its power, 0–1, is explained by the intended drive.
const MIN_EXPLAINED_SHARE: f64 = 0.8;
/// A line counts as reached when it keeps at least this share of its amplitude (a loss of 0.5 dB).
const KEPT: f64 = 0.944;
/// The lowest correlation between the drive with limited crests and the requested one at which the drive still fits.
const MIN_CREST_CORRELATION: f64 = 0.95;
/// Margin for peaks between the samples of a drive: its samples are kept below this share of the limit.
const BETWEEN: f64 = 0.97;
/// Bisection steps between a level that fits and one that does not.
const HALVINGS: usize = 10;

/// A drive that is being corrected.
#[derive(Clone, Debug)]
pub struct Correction<O: Quantity> {
    config: CorrectConfig,
    render: RenderConfig,
    welch: WelchConfig,
    frame: Frame,
    /// The texture, its mean taken away and its ends faded.
    target: Series<O>,
    transform: RealTransform,
    /// The factor of each line from error to drive; zero outside the band.
    inverse: Vec<Complex<f64>>,
    /// The weight of each line in the band, 0–1.
    weights: Vec<f64>,
    /// Whether a line is corrected: within the band, excited, and coherent enough.
    corrected: Vec<bool>,
    /// Whether the inverse reaches a line.
    inverse_reaches: Vec<bool>,
    /// The parts of the band that the inverse reaches, and those that it gives up.
    inverse_coverage: Coverage,
    /// The drive's lines before anything was measured.
    first: Vec<Complex<f64>>,
    /// The drive's requested lines, before any limitation.
    drive: Vec<Complex<f64>>,
    limit: f64,
    /// The slew limit of the amplifier, full scale = 1 per second; none where steeper drives are allowed.
    slope: Option<f64>,
    last: Fit,
}

/// The result of fitting the last drive into the limits of the device.
#[derive(Clone, Debug)]
struct Fit {
    /// The share of each requested line that remains in the fitted drive, 0–1.
    shares: Vec<f64>,
    /// How strongly lines were attenuated to make the drive fit; none if no attenuation was needed.
    strength: Option<f64>,
    lines: Vec<Complex<f64>>,
    /// The share of samples that had to be held at the limit, 0–1.
    held: f64,
    /// The correlation of the drive with limited crests with the same drive before limiting.
    crest_correlation: f64,
}

/// The change of the drive in one correction step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct LineChange {
    /// The share of the band's lines that were corrected, 0–1.
    pub corrected: f64,
    /// The rms over those lines of how much they changed, dB.
    pub change_db: f64,
}

impl<O: Quantity> Correction<O> {
    /// A correction of the drive for `target` through `function`, beginning with its inverse.
    ///
    /// # Errors
    /// Those of [`crate::render::invert`]; [`RenderError::Silent`] when the target holds nothing; [`RenderError::Phase`] when a
    /// waveform is wanted of the minimum phase.
    pub fn new(
        target: &Series<O>,
        function: &TransferFunction<Drive, O>,
        render: &RenderConfig,
        config: &CorrectConfig,
    ) -> Result<Self, RenderError> {
        if config.mode == Mode::Replicate && render.inverse.phase == PhaseForm::Minimum {
            return Err(RenderError::Phase);
        }
        let rate = target.rate();
        let frame = Frame::of(target, render)?;
        let faded = frame.faded(target)?;
        let n = frame.transformed();
        let mut plan = InversePlan::new(n);
        let drive = plan.invert(&frame.padded(&faded), rate, function, &render.inverse)?;
        // The inverse as it acts on an error: no stronger than where the device answers, as the first drive's is.
        let mut impulse = vec![0.0; n];
        impulse[0] = 1.0;
        let gentle = InverseConfig {
            regularisation: render.inverse.regularisation.max(1e-6),
            ..render.inverse.clone()
        };
        let response = plan.invert(&impulse, rate, function, &gentle)?;
        let mut transform = RealTransform::new(n);
        let inverse = transform.forward(&response);
        let band = render.inverse.band;
        let coverage = coverage(function, render)?;
        let lines_hz: Vec<f64> = (0..=n / 2)
            .map(|k| k as f64 * rate.hz() / n as f64)
            .collect();
        let excited = |hz: f64| function.excited.is_none_or(|excited| excited.contains(hz));
        let lines = |of: &dyn Fn(f64) -> bool| lines_hz.iter().map(|hz| of(*hz)).collect();
        let drive = transform.forward(&drive);
        let welch = VerifyConfig::over(band, rate.hz()).welch;
        Ok(Self {
            weights: lines_hz
                .iter()
                .map(|hz| band.weight(*hz, render.inverse.edge_ratio))
                .collect(),
            corrected: lines(&|hz| {
                band.contains(hz)
                    && excited(hz)
                    && function.coherence_at(hz) >= config.least_coherence
            }),
            inverse_reaches: lines(&|hz| coverage.reaches(hz)),
            inverse_coverage: coverage,
            config: config.clone(),
            render: render.clone(),
            welch: WelchConfig {
                segment: welch.segment.min(faded.len()).max(2),
                ..welch
            },
            target: Series::new(faded, rate)?,
            frame,
            transform,
            inverse,
            last: Fit {
                shares: vec![1.0; drive.len()],
                strength: None,
                lines: drive.clone(),
                held: 0.0,
                crest_correlation: 1.0,
            },
            first: drive.clone(),
            drive,
            limit: function.drive.as_ref().map_or(1.0, DriveSetup::drive_limit),
            slope: {
                let kept = render.clipping == Overload::Refuse
                    || render.inverse.inverse == Inverse::DriveLimited;
                let setup = function.drive.as_ref().filter(|_| kept);
                setup.and_then(DriveSetup::slew_limit_per_s)
            },
        })
    }

    /// The target as it is to be met: about its mean, its ends faded.
    #[must_use]
    pub fn target(&self) -> &Series<O> {
        &self.target
    }

    /// The share of the samples of the last drive that had to be held at the device's limit, 0–1.
    #[must_use]
    pub fn held(&self) -> f64 {
        self.last.held
    }

    /// The correlation of the last drive with the same drive before its crests were limited; below 1 they were limited.
    #[must_use]
    pub fn crest_correlation(&self) -> f64 {
        self.last.crest_correlation
    }

    /// The parts of the band that the last drive reaches (the inverse does, and no more than half a decibel had to be taken
    /// for the drive to fit), and those that were given up.
    #[must_use]
    pub fn coverage(&self) -> Coverage {
        if self.turned_down().is_none() {
            return self.inverse_coverage.clone();
        }
        let lines = self.lines(|k| self.inverse_reaches[k] && self.last.shares[k] >= KEPT);
        let [reached, given_up] = self.runs(&lines);
        Coverage { reached, given_up }
    }

    /// The parts of the band that the inverse reaches, regardless of the attenuation needed to make a drive fit, and those it
    /// gives up.
    #[must_use]
    pub fn inverse_coverage(&self) -> &Coverage {
        &self.inverse_coverage
    }

    /// The parts of the band that were attenuated by more than 0.5 dB to make the last drive fit, and their share of
    /// the lines; `None` if there are none.
    #[must_use]
    pub fn turned_down(&self) -> Option<(Vec<Band>, f64)> {
        let lines = self.lines(|k| self.last.shares[k] < KEPT);
        let lost = lines.iter().filter(|(_, lost)| *lost).count();
        let share = lost as f64 / lines.len().max(1) as f64;
        let [bands, _] = self.runs(&lines);
        (!bands.is_empty()).then_some((bands, share))
    }

    /// Lines of the band at the spacing over which shares are smooth, each with its frequency in Hz and the value of `of`.
    fn lines(&self, of: impl Fn(usize) -> bool) -> Vec<(f64, bool)> {
        let step_hz = self.step_hz();
        (0..self.last.shares.len())
            .step_by(self.cell())
            .map(|k| (k as f64 * step_hz, of(k)))
            .filter(|(hz, _)| self.render.inverse.band.contains(*hz))
            .collect()
    }

    /// Whether the last drive fits without attenuated lines and with its crests limited to a correlation of 0.95 or more.
    #[must_use]
    pub fn fits(&self) -> bool {
        self.last.crest_correlation >= MIN_CREST_CORRELATION
            && self.last.shares.iter().all(|share| *share >= 1.0)
    }

    /// The largest sample of the requested drive, before any limitation, full scale = 1.
    #[must_use]
    pub fn asked(&mut self) -> f64 {
        peak(&self.transform.inverse(self.drive.clone()))
    }

    /// The steepest slope of the requested drive, full scale = 1 per second, when it exceeds the slew limit of the amplifier
    /// and steep drives are refused.
    #[must_use]
    pub fn too_steep(&mut self) -> Option<f64> {
        let room = self.room();
        let taken = room.slope_taken(&mut self.transform, &self.drive);
        (taken > 1.0).then(|| taken * BETWEEN * self.slope.unwrap_or(0.0))
    }

    /// The level, re the target, up to which [`Self::fits`] holds, to the tenth of a decibel; no more than 0 dB.
    #[must_use]
    pub fn fits_at(&mut self) -> Decibels {
        if self.fits_at_gain(1.0) {
            return Decibels(0.0);
        }
        let room = self.room();
        let steep = room.slope_taken(&mut self.transform, &self.drive);
        let loud = self.asked() / room.limit;
        let least = 1.0 / loud.max(steep).max(f64::MIN_POSITIVE);
        let (mut low, mut high) = (Decibels::from_amplitude_ratio(least).0, 0.0);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.fits_at_gain(Decibels(middle).amplitude_ratio()) {
                low = middle;
            } else {
                high = middle;
            }
        }
        floored(Decibels(low))
    }

    /// Lines over which shares are smooth, fewer in a narrow band.
    fn cell(&self) -> usize {
        let band = self.render.inverse.band;
        let cell_hz = SMOOTH_HZ.min((band.high().0 - band.low().0) / 8.0);
        ((cell_hz / self.step_hz()) as usize).max(1)
    }

    fn runs(&self, lines: &[(f64, bool)]) -> [Vec<Band>; 2] {
        let step_hz = self.step_hz() * self.cell() as f64;
        runs(lines, self.render.inverse.band, step_hz)
    }

    fn fits_at_gain(&mut self, gain_ratio: f64) -> bool {
        let room = self.room();
        let bins: Vec<Complex<f64>> = self.drive.iter().map(|bin| bin * gain_ratio).collect();
        let pressed = crest::pressed(&mut self.transform, &bins, &room);
        pressed.is_some_and(|pressed| pressed.crest_correlation >= MIN_CREST_CORRELATION)
    }

    fn step_hz(&self) -> f64 {
        self.frame.rate().hz() / self.transform.length() as f64
    }

    /// Lines within [`SMOOTH_HZ`].
    fn smooth(&self) -> usize {
        (SMOOTH_HZ / self.step_hz()) as usize
    }

    fn room(&self) -> crest::DriveLimits {
        crest::DriveLimits {
            limit: self.limit * BETWEEN,
            slope: self
                .slope
                .map(|slope| slope * BETWEEN / self.frame.rate().hz()),
            length: self.frame.length(),
            smooth: self.smooth(),
            mode: self.config.mode,
        }
    }

    /// The current drive at the output rate, within the limits of the device: its crests are limited as far as the lines hardly
    /// change, and if it still does not fit, the lines that cost most drive are attenuated.
    ///
    /// # Errors
    /// [`RenderError::Signal`] when the result is not a valid signal.
    pub fn drive(&mut self) -> Result<Series<Drive>, RenderError> {
        let room = self.room();
        let strength = self.last.strength;
        let fitted = crest::fitted(&mut self.transform, &self.drive, &room, strength);
        let lines = self.transform.forward(&fitted.samples);
        let mut samples = self.frame.played(fitted.samples);
        let beyond = samples.iter().filter(|x| x.abs() > self.limit).count();
        cut(&mut samples, self.limit);
        self.last = Fit {
            held: beyond as f64 / samples.len().max(1) as f64,
            crest_correlation: fitted.crest_correlation,
            shares: fitted.shares,
            strength: fitted.strength,
            lines,
        };
        Ok(Series::new(samples, self.render.output_rate)?)
    }

    /// Corrects the drive from `responses`: one or more measured responses to the last drive, at the target's rate and with any
    /// delay. `noise` is the PSD of the noise as estimated with [`Self::welch`].
    ///
    /// Formula: replicate: U ← U + μ·w·C·(s·T − Y)/s, C the inverse, Y the mean of the responses, w = 1 − V/|s·T − Y|² with V the
    /// variance of that mean; texture: |U| ← |U|·(s²·T²/Y²)^(μ/2) of the PSDs, and where others distort a line,
    /// U ← U + μ·w·((1 − |b|)·b/|b|·M − (C·Y − b·M))/s, M the intended drive of that line and b the gain with which it arrived;
    /// s is the share of the line left when the drive was made to fit (so that attenuated lines are not raised again and
    /// again). Only lines with Y above the noise are corrected, each by no more than the step.
    ///
    /// Source: S. Arimoto, S. Kawamura and F. Miyazaki (1984), J. Robotic Systems 1(2), for learning; the spectrum equalisation
    /// of random-vibration control for textures; Wiener's filter for w.
    ///
    /// # Errors
    /// [`VerifyError::Rate`] when a response has another rate than the target, [`VerifyError::Silent`] when it holds nothing,
    /// [`VerifyError::TooShort`] when they share less than a segment with it.
    pub fn learn(
        &mut self,
        responses: &[&Series<O>],
        noise: &Spectrum<O>,
    ) -> Result<LineChange, VerifyError> {
        let aim = self.aim()?;
        let aligned = AlignedResponses::of(responses, &aim, &self.welch, self.render.inverse.band)?;
        let (as_drive, spread) = self.as_drive(&aligned, aim.samples());
        let lines = aligned.got.values.len();
        let noise_at = |line: usize| noise.values.get(line).copied().unwrap_or(0.0);
        let believed = |line: usize| {
            aligned.got.values[line] > self.config.noise_ratio * noise_at(line)
                && aligned.wanted.values[line] > 0.0
        };
        // The missing power, as a factor.
        let ratio = |line: usize| {
            if believed(line) {
                aligned.wanted.values[line] / aligned.got.values[line]
            } else {
                1.0
            }
        };
        let answers = answer::answers(&self.meant(), &as_drive, self.smooth());
        let missing = match self.config.mode {
            Mode::Replicate => as_drive,
            Mode::Texture => (0..as_drive.len())
                .map(|k| answers.missing(k) * self.phase_correction(k))
                .collect(),
        };
        let sure = answer::sure(&missing, &spread, self.smooth());
        let spacing = self.step_hz() / aligned.got.resolution_hz;
        let mut changes = vec![Complex::default(); self.drive.len()];
        let (mut corrected, mut all) = (0usize, 0usize);
        for (k, change) in changes.iter_mut().enumerate() {
            let old = self.drive[k];
            if !self.corrected[k] || old.norm() <= 0.0 {
                continue;
            }
            all += 1;
            let place = (k as f64 * spacing).min((lines - 1) as f64);
            let line = (place.round() as usize).min(lines - 1);
            if !believed(line) {
                continue;
            }
            corrected += 1;
            let others = (1.0 - answers.explained_share(k)) * aligned.got.values[line];
            // Distortion products of other lines cannot be removed by changing the magnitude: their opposite has to be added.
            let disturbed = answers.explained_share(k) < MIN_EXPLAINED_SHARE
                && others > self.config.noise_ratio * noise_at(line);
            *change = if self.config.mode == Mode::Replicate || disturbed {
                let share = self.last.shares[k].max(LEAST_SHARE);
                missing[k] * (self.config.learning * sure[k] / share)
            } else {
                let low = (place as usize).min(lines - 2);
                let part = place - low as f64;
                let missing = ratio(low) * (1.0 - part) + ratio(low + 1) * part;
                old * (missing.powf(0.5 * self.config.learning) - 1.0)
            };
        }
        Ok(LineChange {
            corrected: corrected as f64 / all.max(1) as f64,
            change_db: self.change(&changes),
        })
    }

    /// The measured responses (for a waveform: their error) expressed as drive, line by line: the mean over the responses, and
    /// the variance of that mean.
    fn as_drive(
        &mut self,
        aligned: &AlignedResponses<O>,
        aim: &[f64],
    ) -> (Vec<Complex<f64>>, Vec<f64>) {
        let count = aligned.measured.len() as f64;
        let begins = self.frame.before + aligned.shared.start;
        let all: Vec<Vec<Complex<f64>>> = aligned
            .measured
            .iter()
            .map(|measured| {
                let mut padded = vec![0.0; self.transform.length()];
                let places = padded[begins..].iter_mut();
                for ((place, t), y) in places.zip(&aim[aligned.shared.clone()]).zip(measured) {
                    *place = match self.config.mode {
                        Mode::Texture => *y,
                        Mode::Replicate => t - y,
                    };
                }
                let mut lines = self.transform.forward(&padded);
                for (line, inverse) in lines.iter_mut().zip(&self.inverse) {
                    *line *= *inverse;
                }
                lines
            })
            .collect();
        let mean: Vec<Complex<f64>> = (0..self.drive.len())
            .map(|k| all.iter().map(|lines| lines[k]).sum::<Complex<f64>>() / count)
            .collect();
        let pairs = (count * (count - 1.0)).max(1.0);
        let spread = mean
            .iter()
            .enumerate()
            .map(|(k, mean)| {
                let off = all.iter().map(|lines| (lines[k] - mean).norm_sqr());
                off.sum::<f64>() / pairs
            })
            .collect();
        (mean, spread)
    }

    /// Changes the drive by at most one step per line, averaged over neighbouring lines; returns the rms of the change, dB.
    fn change(&mut self, changes: &[Complex<f64>]) -> f64 {
        let step = 10f64.powf(self.config.step_db / 20.0);
        let smooth = self.smooth();
        let rms_of = |lines: &[Complex<f64>]| -> Vec<f64> {
            let mut power = crest::smoothed(lines.iter().map(Complex::norm_sqr), smooth);
            power
                .iter_mut()
                .for_each(|power| *power = power.max(0.0).sqrt());
            power
        };
        let (old, asked) = (rms_of(&self.drive), rms_of(changes));
        let new: Vec<Complex<f64>> = self
            .drive
            .iter()
            .zip(changes)
            .zip(old.iter().zip(&asked))
            .map(|((line, change), (old, asked))| {
                line + change * ((step - 1.0) * old / asked.max(f64::MIN_POSITIVE)).min(1.0)
            })
            .collect();
        let grown = rms_of(&new);
        let (mut sum, mut count) = (0.0, 0usize);
        for k in 0..self.drive.len() {
            if changes[k].norm() <= 0.0 || old[k] <= 0.0 {
                continue;
            }
            let ratio = (grown[k] / old[k]).max(f64::MIN_POSITIVE);
            let within = ratio.clamp(1.0 / step, step);
            self.drive[k] = new[k] * (within / ratio);
            let change_db = 20.0 * within.log10();
            sum += change_db * change_db;
            count += 1;
        }
        (sum / count.max(1) as f64).sqrt()
    }

    /// The intended drive: the one whose response would be the target if the device matched its transfer function, with the
    /// shares of the last fitted drive and the phases that crest limiting gave it.
    fn meant(&self) -> Vec<Complex<f64>> {
        let lines = self.first.iter().zip(&self.last.shares).enumerate();
        lines
            .map(|(k, (first, share))| first * *share * self.phase_correction(k).conj())
            .collect()
    }

    /// The phase factor that turns a line of the last fitted drive back to its requested phase.
    fn phase_correction(&self, line: usize) -> Complex<f64> {
        let turn = self.drive[line] * self.last.lines[line].conj();
        if turn.norm() > 0.0 {
            turn / turn.norm()
        } else {
            Complex::from(1.0)
        }
    }

    /// The target within the band, with the shares of the last fitted drive.
    fn aim(&mut self) -> Result<Series<O>, SeriesError> {
        let padded = self.frame.padded(self.target.samples());
        let mut lines = self.transform.forward(&padded);
        for ((line, share), weight) in lines.iter_mut().zip(&self.last.shares).zip(&self.weights) {
            *line *= *share * *weight;
        }
        let mut aim = self.transform.inverse(lines);
        aim.truncate(self.frame.before + self.frame.target);
        Series::new(aim.split_off(self.frame.before), self.frame.rate())
    }

    /// The warning about lines of the target hidden by `noise` (estimated with [`Self::welch`]), which can be neither corrected nor
    /// judged reliably; `None` if there are none.
    ///
    /// # Errors
    /// [`VerifyError::Estimate`] when the target is shorter than a segment.
    pub fn hidden(&self, noise: &Spectrum<O>) -> Result<Option<Warning>, VerifyError> {
        let mut plan = WelchPlan::new(&self.welch, self.frame.rate())?;
        let wanted = plan.estimate::<O>(&[self.target.samples()])?;
        let band = self.render.inverse.band;
        let lines: Vec<(f64, bool)> = wanted
            .frequencies_hz()
            .into_iter()
            .zip(wanted.values.iter().zip(&noise.values))
            .filter(|(hz, _)| band.contains(*hz))
            .map(|(hz, (wanted, noise))| (hz, *wanted < self.config.noise_ratio * noise))
            .collect();
        let hidden = lines.iter().filter(|(_, hidden)| *hidden).count();
        let [bands, _] = runs(&lines, band, wanted.resolution_hz);
        Ok((hidden > 0).then(|| {
            Warning::from(RenderWarning::BandPartLost {
                share: hidden as f64 / lines.len() as f64,
                bands,
                why: PartLost::TargetInNoise,
            })
        }))
    }

    /// How spectra are estimated here: Hann segments of about 5 Hz.
    #[must_use]
    pub fn welch(&self) -> &WelchConfig {
        &self.welch
    }
}
