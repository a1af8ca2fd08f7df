//! Closed-loop correction: a drive is played, what comes of it is measured, and the drive is corrected by what is missing.
//!
//! Two things can be wanted. To *replicate*: the waveform itself, corrected sample by sample through the inverse of the
//! transfer function, each frequency as far as it can be believed. Or the *texture*: its power spectrum alone, corrected line
//! by line where the response stands out of the noise; phases are free then, and are used to make the drive less peaked.

mod answer;
mod crest;
mod doubt;
mod heard;
mod summary;

pub use doubt::{LoopDoubt, LoopStop, MishapDoubt};
use num_complex::Complex;
use serde::{Deserialize, Serialize};
pub use summary::{CorrectedRendering, RenderingSums};

use crate::device::DriveSetup;
use crate::doubt::Doubt;
use crate::fourier::RealTransform;
use crate::lineage::Mode;
use crate::quantity::{Band, Decibels, Drive, Quantity};
use crate::render::{
    Coverage, Frame, Inverse, InverseConfig, InversePlan, Overload, PhaseForm, RenderConfig,
    RenderError, coverage, cut, floored, runs,
};
use crate::series::{Series, SeriesError};
use crate::spectrum::{Spectrum, WelchConfig, WelchPlan};
use crate::statistics::peak;
use crate::transfer::TransferFunction;
use crate::verify::{VerifyConfig, VerifyError};
use heard::Heard;

/// How a drive is corrected.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct CorrectConfig {
    /// What is to be met.
    pub mode: Mode,
    /// The share of what is missing that one step goes for, above 0 up to 1.
    pub learning: f64,
    /// No line changes by more than this in one step, dB.
    pub step_db: f64,
    /// A line is believed when its power is at least so many times that of the noise.
    pub noise_ratio: f64,
    /// A line is corrected when its coherence was at least this.
    pub least_coherence: f64,
}

impl CorrectConfig {
    /// Seven tenths of what is missing, 6 dB a step at most, four times the noise, a coherence of 0.5.
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

/// What a line costs is averaged over so many hertz on either side.
const SMOOTH_HZ: f64 = 4.0;
/// What is left of a line is taken for at least this when its error is learned from.
const LEAST_SHARE: f64 = 0.05;
/// A line whose response is what was meant by less than this share of its power, 0–1, is disturbed by others.
const UNDISTURBED: f64 = 0.8;
/// A line that keeps this much, all but half a decibel, counts as reached.
const KEPT: f64 = 0.944;
/// A drive whose crests are pressed further than to this correlation is another one.
const LIKE: f64 = 0.95;
/// Between samples a drive is a little higher than on them.
const BETWEEN: f64 = 0.97;
/// Halvings between a level that fits and one that does not.
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
    /// What a line of the error is multiplied with to become drive; nothing outside the band.
    inverse: Vec<Complex<f64>>,
    /// How far a line belongs to the band, 0–1.
    weights: Vec<f64>,
    /// Whether a line is corrected: within the band, driven and understood.
    corrected: Vec<bool>,
    /// Whether the inverse reaches a line.
    inverse_reaches: Vec<bool>,
    /// What of the band the inverse reaches.
    inverse_coverage: Coverage,
    /// The drive's lines before anything was measured.
    first: Vec<Complex<f64>>,
    /// The drive's lines as they are asked for, before anything limits them.
    drive: Vec<Complex<f64>>,
    limit: f64,
    /// The steepest that the amplifier follows, full scale = 1 per second, where a drive may not be steeper.
    slope: Option<f64>,
    last: Fit,
}

/// What came of the drive that was last made to fit.
#[derive(Clone, Debug)]
struct Fit {
    /// What is left of every line, as a share of what was asked, 0–1.
    shares: Vec<f64>,
    /// How strongly lines were turned down for it; none where nothing had to be.
    strength: Option<f64>,
    /// Its lines.
    lines: Vec<Complex<f64>>,
    /// The share of samples that had to be held at the limit, 0–1.
    held: f64,
    /// The correlation of what is played with what would be, were there room for its crests.
    likeness: f64,
}

/// What one step found.
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
        let driven = |hz: f64| function.driven.is_none_or(|driven| driven.contains(hz));
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
                    && driven(hz)
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
                likeness: 1.0,
            },
            first: drive.clone(),
            drive,
            limit: function.drive.as_ref().map_or(1.0, DriveSetup::drive_limit),
            slope: {
                let kept = render.steep == Overload::Refuse
                    || render.inverse.inverse == Inverse::DriveLimited;
                let setup = function.drive.as_ref().filter(|_| kept);
                setup.map(DriveSetup::slew_limit_per_s)
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

    /// The correlation of the last drive with what it would be were there room for its crests: below 1 they were pressed
    /// down.
    #[must_use]
    pub fn likeness(&self) -> f64 {
        self.last.likeness
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

    /// The parts of the band that the inverse reaches, whatever has to be taken for a drive to fit, and those that it gives up.
    #[must_use]
    pub fn inverse_coverage(&self) -> &Coverage {
        &self.inverse_coverage
    }

    /// The parts of the band from which more than half a decibel had to be taken for the last drive to fit, and their share of
    /// the lines; `None` where nothing had to be.
    #[must_use]
    pub fn turned_down(&self) -> Option<(Vec<Band>, f64)> {
        let lines = self.lines(|k| self.last.shares[k] < KEPT);
        let lost = lines.iter().filter(|(_, lost)| *lost).count();
        let share = lost as f64 / lines.len().max(1) as f64;
        let [bands, _] = self.runs(&lines);
        (!bands.is_empty()).then_some((bands, share))
    }

    /// Lines of the band as far apart as shares are smooth, in Hz, and what is true of each.
    fn lines(&self, of: impl Fn(usize) -> bool) -> Vec<(f64, bool)> {
        let step_hz = self.step_hz();
        (0..self.last.shares.len())
            .step_by(self.cell())
            .map(|k| (k as f64 * step_hz, of(k)))
            .filter(|(hz, _)| self.render.inverse.band.contains(*hz))
            .collect()
    }

    /// Whether the last drive fits with nothing turned down and crests pressed no further than to a correlation of 0.95.
    #[must_use]
    pub fn fits(&self) -> bool {
        self.last.likeness >= LIKE && self.last.shares.iter().all(|share| *share >= 1.0)
    }

    /// The largest sample of the drive as it is asked for, full scale = 1.
    #[must_use]
    pub fn asked(&mut self) -> f64 {
        peak(&self.transform.inverse(self.drive.clone()))
    }

    /// The steepest slope of the drive as it is asked for, full scale = 1 per second, where it exceeds what the amplifier
    /// follows and may not.
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
        pressed.is_some_and(|pressed| pressed.likeness >= LIKE)
    }

    fn step_hz(&self) -> f64 {
        self.frame.rate().hz() / self.transform.length() as f64
    }

    /// Lines within [`SMOOTH_HZ`].
    fn smooth(&self) -> usize {
        (SMOOTH_HZ / self.step_hz()) as usize
    }

    fn room(&self) -> crest::Room {
        crest::Room {
            limit: self.limit * BETWEEN,
            slope: self
                .slope
                .map(|slope| slope * BETWEEN / self.frame.rate().hz()),
            length: self.frame.length(),
            smooth: self.smooth(),
            mode: self.config.mode,
        }
    }

    /// The drive as it stands, at the output rate, within what the device can play: its crests are pressed down as far as
    /// costs next to nothing, and what still does not fit is turned down where it costs most.
    ///
    /// # Errors
    /// [`RenderError::Drive`] when what comes out is no signal.
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
            likeness: fitted.likeness,
            shares: fitted.shares,
            strength: fitted.strength,
            lines,
        };
        Ok(Series::new(samples, self.render.output_rate)?)
    }

    /// Corrects the drive by `responses`, what was measured of the last one, once or more, at the target's rate, however late,
    /// given the noise's PSD as [`Self::welch`] estimates it.
    ///
    /// Formula: replicate: U ← U + μ·w·C·(s·T − Y)/s, C the inverse, Y the mean of the responses, w = 1 − V/|s·T − Y|² with V the
    /// variance of that mean; texture: |U| ← |U|·(s²·T²/Y²)^(μ/2) of the PSDs, and where others distort a line,
    /// U ← U + μ·w·((1 − |b|)·b/|b|·M − (C·Y − b·M))/s, M the drive that was meant there and b what of it came; s what was left of
    /// the line when the drive was made to fit (so what was taken is not asked for louder and louder); on lines with Y above
    /// the noise, by no more than the step.
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
        let heard = Heard::of(responses, &aim, &self.welch, self.render.inverse.band)?;
        let (as_drive, spread) = self.as_drive(&heard, aim.samples());
        let lines = heard.got.values.len();
        let noise_at = |line: usize| noise.values.get(line).copied().unwrap_or(0.0);
        let believed = |line: usize| {
            heard.got.values[line] > self.config.noise_ratio * noise_at(line)
                && heard.wanted.values[line] > 0.0
        };
        // What is missing of the power, as a factor.
        let ratio = |line: usize| {
            if believed(line) {
                heard.wanted.values[line] / heard.got.values[line]
            } else {
                1.0
            }
        };
        let answers = answer::answers(&self.meant(), &as_drive, self.smooth());
        let missing = match self.config.mode {
            Mode::Replicate => as_drive,
            Mode::Texture => (0..as_drive.len())
                .map(|k| answers.missing(k) * self.turned_back(k))
                .collect(),
        };
        let sure = answer::sure(&missing, &spread, self.smooth());
        let spacing = self.step_hz() / heard.got.resolution_hz;
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
            let others = (1.0 - answers.meant_share(k)) * heard.got.values[line];
            // What others put on a line no magnitude of its own takes away: its opposite does.
            let disturbed = answers.meant_share(k) < UNDISTURBED
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

    /// What was measured, or for a waveform what is missing of it, as drive: the mean of what was heard, and the variance of
    /// that mean.
    fn as_drive(&mut self, heard: &Heard<O>, aim: &[f64]) -> (Vec<Complex<f64>>, Vec<f64>) {
        let count = heard.measured.len() as f64;
        let begins = self.frame.before + heard.shared.start;
        let all: Vec<Vec<Complex<f64>>> = heard
            .measured
            .iter()
            .map(|measured| {
                let mut padded = vec![0.0; self.transform.length()];
                let places = padded[begins..].iter_mut();
                for ((place, t), y) in places.zip(&aim[heard.shared.clone()]).zip(measured) {
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

    /// Changes the drive, by no more than a step where a line is averaged with its neighbours; the rms of the change, dB.
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

    /// The drive whose answer, on a device that did as it was measured, would be the target: as far as the drive that was
    /// last made to fit goes for it, with the phases that pressing its crests gave it.
    fn meant(&self) -> Vec<Complex<f64>> {
        let lines = self.first.iter().zip(&self.last.shares).enumerate();
        lines
            .map(|(k, (first, share))| first * *share * self.turned_back(k).conj())
            .collect()
    }

    /// By what the last drive's line has to be turned to be where it was asked for.
    fn turned_back(&self, line: usize) -> Complex<f64> {
        let turn = self.drive[line] * self.last.lines[line].conj();
        if turn.norm() > 0.0 {
            turn / turn.norm()
        } else {
            Complex::from(1.0)
        }
    }

    /// The target within the band, as far as the drive that was last made to fit goes for it.
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

    /// The lines of the target that `noise`, estimated as [`Self::welch`] says, hides, so that they are neither corrected nor
    /// judged fairly; `None` where there are none.
    ///
    /// # Errors
    /// [`VerifyError::Estimate`] when the target is shorter than a segment.
    pub fn hidden(&self, noise: &Spectrum<O>) -> Result<Option<Doubt>, VerifyError> {
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
            Doubt::from(LoopDoubt::TargetInNoise {
                share: hidden as f64 / lines.len() as f64,
                bands,
            })
        }))
    }

    /// How spectra are estimated here: Hann segments of about 5 Hz.
    #[must_use]
    pub fn welch(&self) -> &WelchConfig {
        &self.welch
    }
}
