//! Closed-loop correction: a drive is played, what comes of it is measured, and the drive is corrected by what is missing.
//!
//! Two things can be wanted. To *replicate*: the waveform itself, corrected sample by sample through the inverse of the
//! transfer function, each frequency as far as it can be believed. Or the *texture*: its power spectrum alone, corrected line
//! by line where the response stands out of the noise; phases are free then, and are used to make the drive less peaked.

mod crest;

use num_complex::Complex;
use serde::{Deserialize, Serialize};

use crate::device::DriveSetup;
use crate::fourier::{RealTransform, fast_length};
use crate::quantity::{Band, Drive, Hertz, Quantity, SampleRate};
use crate::render::{InverseConfig, InversePlan, RenderConfig, RenderError};
use crate::resample::Resampler;
use crate::series::{Series, mean, peak};
use crate::spectrum::{EstimateError, WelchConfig, WelchPlan};
use crate::transfer::TransferFunction;

/// What is to be met.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Mode {
    /// The waveform.
    Replicate,
    /// The power spectrum.
    Texture,
}

impl Mode {
    /// The name as it is written on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Replicate => "replicate",
            Self::Texture => "texture",
        }
    }
}

/// How a drive is corrected.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
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

/// A drive that is being corrected.
#[derive(Clone, Debug)]
pub struct Correction {
    config: CorrectConfig,
    render: RenderConfig,
    rate: SampleRate,
    welch: WelchConfig,
    /// The texture, its mean taken away and its ends faded.
    target: Vec<f64>,
    before: usize,
    transform: RealTransform,
    /// What a line of the error is multiplied with to become drive; nothing outside the band.
    inverse: Vec<Complex<f64>>,
    /// Weight and believability of every line, 0–1.
    corrected: Vec<f64>,
    /// The drive's lines before anything limits it.
    drive: Vec<Complex<f64>>,
    /// What had to be taken from every line so far, as a share of what was asked, 0–1.
    shares: Vec<f64>,
    limit: f64,
    held: f64,
}

/// What one step found.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Step {
    /// The share of the band's lines that were corrected, 0–1.
    pub corrected: f64,
    /// The rms over those lines of how much they changed, dB.
    pub change_db: f64,
}

impl Correction {
    /// A correction of the drive for `target` through `function`, beginning with its inverse.
    ///
    /// # Errors
    /// Those of [`crate::render::invert`]; [`RenderError::Silent`] when the target holds nothing.
    pub fn new<O: Quantity>(
        target: &Series<O>,
        function: &TransferFunction<Drive, O>,
        render: &RenderConfig,
        config: &CorrectConfig,
    ) -> Result<Self, RenderError> {
        let rate = target.rate();
        let (before, after) = (
            rate.samples_in(render.modelling_delay),
            rate.samples_in(render.tail),
        );
        let mean = mean(target.samples());
        let mut faded: Vec<f64> = target.samples().iter().map(|x| x - mean).collect();
        if peak(&faded) <= 0.0 {
            return Err(RenderError::Silent);
        }
        crate::render::fade_ends(&mut faded, rate.samples_in(render.fade));
        let n = fast_length(before + faded.len() + after);
        let mut padded = vec![0.0; n];
        padded[before..before + faded.len()].copy_from_slice(&faded);
        let mut plan = InversePlan::new(n);
        let drive = plan.invert(&padded, rate, function, &render.inverse)?;
        // The inverse as it acts on an error: no stronger than where the device answers, as the first drive's is.
        let impulse: Vec<f64> = std::iter::once(1.0)
            .chain(std::iter::repeat_n(0.0, n - 1))
            .collect();
        let gentle = InverseConfig {
            regularisation: render.inverse.regularisation.max(1e-6),
            ..render.inverse.clone()
        };
        let response = plan.invert(&impulse, rate, function, &gentle)?;
        let mut transform = RealTransform::new(n);
        let inverse = transform.forward(&response);
        let band = render.inverse.band;
        let corrected = (0..=n / 2)
            .map(|k| {
                let hz = k as f64 * rate.hz() / n as f64;
                let believed = function.coherence_at(hz) >= config.least_coherence;
                if believed {
                    band.weight(hz, render.inverse.edge_ratio)
                } else {
                    0.0
                }
            })
            .collect();
        let drive = transform.forward(&drive);
        let segment = 2f64.powf((rate.hz() / 5.0).log2().round()).max(16.0) as usize;
        Ok(Self {
            config: config.clone(),
            render: render.clone(),
            rate,
            welch: WelchConfig::hann(segment.min(faded.len()).max(2)),
            target: faded,
            before,
            transform,
            inverse,
            corrected,
            shares: vec![1.0; drive.len()],
            drive,
            limit: function.drive.as_ref().map_or(1.0, DriveSetup::drive_limit),
            held: 0.0,
        })
    }

    /// The target's samples as they are to be met, at its rate.
    #[must_use]
    pub fn target(&self) -> &[f64] {
        &self.target
    }

    /// How long after the start of the drive the texture begins, samples at the target's rate.
    #[must_use]
    pub fn lead(&self) -> usize {
        self.before
    }

    /// The share of the samples of the last drive that had to be held at the device's limit, 0–1.
    #[must_use]
    pub fn held(&self) -> f64 {
        self.held
    }

    /// The parts of the band from which no more than half a decibel had to be taken for the drive to fit, and those that
    /// were given up.
    #[must_use]
    pub fn reached(&self) -> [Vec<Band>; 2] {
        const KEPT: f64 = 0.944;
        let step_hz = self.rate.hz() / self.transform.length() as f64;
        let band = self.render.inverse.band;
        let inside: Vec<(f64, bool)> = self
            .shares
            .iter()
            .zip(&self.corrected)
            .enumerate()
            .map(|(k, (share, corrected))| (k as f64 * step_hz, *share >= KEPT && *corrected > 0.0))
            .filter(|(hz, _)| band.contains(*hz))
            .collect();
        [true, false].map(|wanted| {
            let runs = inside
                .chunk_by(|a, b| a.1 == b.1)
                .filter(|run| run[0].1 == wanted);
            runs.filter_map(|run| Band::new(Hertz(run[0].0), Hertz(run[run.len() - 1].0)).ok())
                .collect()
        })
    }

    /// The drive as it stands, at the output rate, within what the device can play: its crests are pressed down as far as
    /// costs nothing, and what still does not fit is turned down where it costs most.
    ///
    /// # Errors
    /// [`RenderError::Rate`] when it cannot be brought to the output rate.
    pub fn drive(&mut self) -> Result<Series<Drive>, RenderError> {
        let length = self.before + self.target.len() + self.rate.samples_in(self.render.tail);
        let band = self.render.inverse.band;
        let passband = (band.high().0 * (1.0 + self.render.inverse.edge_ratio))
            .min(0.995 * self.rate.nyquist().0);
        let resampler = (self.rate != self.render.output_rate)
            .then(|| Resampler::new(self.rate, self.render.output_rate, Hertz(passband)))
            .transpose()?;
        // Between samples a drive is a little higher than on them.
        let room = self.limit * 0.97;
        let crest::Fitted {
            mut samples,
            shares,
        } = crest::fitted(&mut self.transform, &self.drive, room);
        // What was taken is given up: a line that cannot be had is not asked for louder and louder.
        for (line, share) in self.drive.iter_mut().zip(&shares) {
            *line *= *share;
        }
        for (kept, share) in self.shares.iter_mut().zip(&shares) {
            *kept *= share;
        }
        samples.truncate(length);
        crate::render::fade_ends(
            &mut samples,
            self.rate.samples_in(self.render.fade).min(self.before),
        );
        let mut samples = match resampler {
            Some(resampler) => resampler.process(&samples),
            None => samples,
        };
        let beyond = samples.iter().filter(|x| x.abs() > self.limit).count();
        self.held = beyond as f64 / samples.len().max(1) as f64;
        for sample in &mut samples {
            *sample = sample.clamp(-self.limit, self.limit);
        }
        Ok(Series::new(samples, self.render.output_rate)?)
    }

    /// Corrects the drive by `measured`, the response at the target's rate from the first sample of the texture on, given
    /// the noise's PSD on the lines of [`Self::welch`].
    ///
    /// Formula: replicate: U ← U + μ·C·(T − Y), C the inverse; texture: |U| ← |U|·(T²/Y²)^(μ/2) of the PSDs; on lines with
    /// Y above the noise, by no more than the step.
    ///
    /// Source: S. Arimoto, S. Kawamura and F. Miyazaki (1984), J. Robotic Systems 1(2), for learning; the spectrum equalisation
    /// of random-vibration control for textures.
    ///
    /// # Errors
    /// [`EstimateError::TooShort`] when it holds less than a segment.
    pub fn learn(&mut self, measured: &[f64], noise_psd: &[f64]) -> Result<Step, EstimateError> {
        let shared = measured.len().min(self.target.len());
        let measured = &measured[..shared];
        let mut plan = WelchPlan::new(&self.welch, self.rate)?;
        let wanted = plan.estimate::<Drive>(&[&self.target[..shared]])?;
        let got = plan.estimate::<Drive>(&[measured])?;
        let believed = |line: usize| {
            let noise = noise_psd.get(line).copied().unwrap_or(0.0);
            got.values[line] > self.config.noise_ratio * noise && wanted.values[line] > 0.0
        };
        let lines = got.values.len();
        let step = 10f64.powf(self.config.step_db / 20.0);
        let factors: Vec<f64> = (0..lines)
            .map(|line| {
                if !believed(line) {
                    return 1.0;
                }
                let ratio =
                    (wanted.values[line] / got.values[line]).powf(0.5 * self.config.learning);
                ratio.clamp(1.0 / step, step)
            })
            .collect();
        let error = (self.config.mode == Mode::Replicate).then(|| {
            let mut error = vec![0.0; self.transform.length()];
            for ((place, t), y) in error[self.before..]
                .iter_mut()
                .zip(&self.target)
                .zip(measured)
            {
                *place = t - y;
            }
            self.transform.forward(&error)
        });
        let spacing = self.rate.hz() / self.transform.length() as f64 / got.resolution_hz;
        let (mut changed, mut weights, mut all) = (0.0, 0.0, 0.0);
        for k in 0..self.drive.len() {
            let weight = self.corrected[k];
            if weight <= 0.0 {
                continue;
            }
            all += weight;
            let place = (k as f64 * spacing).min((lines - 1) as f64);
            let line = (place.round() as usize).min(lines - 1);
            if !believed(line) {
                continue;
            }
            let old = self.drive[k];
            let new = match &error {
                Some(error) => {
                    let change = error[k] * self.inverse[k] * (self.config.learning * weight);
                    // A step turns and stretches a line; none becomes more than `step` times what it was.
                    let most = old.norm() * (step - 1.0);
                    let norm = change.norm();
                    old + if norm > most && norm > 0.0 {
                        change * (most / norm)
                    } else {
                        change
                    }
                }
                None => {
                    let low = (place as usize).min(lines - 2);
                    let part = place - low as f64;
                    let factor = factors[low] * (1.0 - part) + factors[low + 1] * part;
                    let most = if self.shares[k] < 0.99 {
                        1.0
                    } else {
                        f64::INFINITY
                    };
                    old * (1.0 + weight * (factor.min(most) - 1.0))
                }
            };
            if old.norm() > 0.0 && new.norm() > 0.0 {
                let change_db = 20.0 * (new.norm() / old.norm()).log10();
                changed += weight * change_db * change_db;
                weights += weight;
            }
            self.drive[k] = new;
        }
        Ok(Step {
            corrected: weights / f64::max(all, f64::MIN_POSITIVE),
            change_db: (changed / f64::max(weights, f64::MIN_POSITIVE)).sqrt(),
        })
    }

    /// How spectra are estimated here: Hann segments of about 5 Hz.
    #[must_use]
    pub fn welch(&self) -> &WelchConfig {
        &self.welch
    }

    /// The band that is corrected.
    #[must_use]
    pub fn band(&self) -> Band {
        self.render.inverse.band
    }
}
