//! The time frame of a texture: silence before and after, fades, and resampling to the output rate.

use super::{FadeLoss, RenderConfig, RenderError};
use crate::fourier::fade;
use crate::fourier::fast_length;
use crate::quantity::{Band, Decibels, Hertz, Quantity, SampleRate, Seconds};
use crate::resample::Resampler;
use crate::series::Series;
use crate::statistics::{mean, peak, rms, standard_deviation};

/// The drive begins and ends with a fade of this length within the silence around the texture.
const SILENT_FADE: Seconds = Seconds(0.02);
/// A fade that takes so much of the level or of the peak of a texture takes much of it.
const MUCH: Decibels = Decibels(1.0);

/// The time frame of a target: the silence around it that its inverse needs, and the resampling of the result to the output rate.
#[derive(Clone, Debug)]
pub(crate) struct Frame {
    rate: SampleRate,
    /// Samples of silence before the target.
    pub(crate) before: usize,
    /// Samples of the target.
    pub(crate) target: usize,
    after: usize,
    fade: usize,
    band: Band,
    resampler: Option<Resampler>,
}

impl Frame {
    /// The time around `target`.
    ///
    /// # Errors
    /// [`RenderError::Signal`] when what is in the band cannot be brought to the output rate.
    pub(crate) fn of<O: Quantity>(
        target: &Series<O>,
        config: &RenderConfig,
    ) -> Result<Self, RenderError> {
        let rate = target.rate();
        let highest = config.inverse.band.high().0 * (1.0 + config.inverse.edge_ratio);
        let passband = Hertz(highest.min(0.995 * rate.nyquist().0));
        Ok(Self {
            rate,
            before: rate.samples_in(config.modelling_delay),
            target: target.samples().len(),
            after: rate.samples_in(config.tail),
            fade: rate.samples_in(config.fade),
            band: config.inverse.band,
            resampler: (rate != config.output_rate)
                .then(|| Resampler::new(rate, config.output_rate, passband))
                .transpose()?,
        })
    }

    /// Samples from the first of the silence to the last.
    pub(crate) fn length(&self) -> usize {
        self.before + self.target + self.after
    }

    /// Samples of the transform: no fewer than [`Self::length`].
    pub(crate) fn transformed(&self) -> usize {
        fast_length(self.length())
    }

    /// The target without its offset, with faded ends where a fade is stated.
    ///
    /// # Errors
    /// [`RenderError::Silent`] when nothing is left.
    pub(crate) fn faded<O: Quantity>(&self, target: &Series<O>) -> Result<Vec<f64>, RenderError> {
        let offset = offset(target.samples(), self.rate, self.band);
        let mut samples: Vec<f64> = target.samples().iter().map(|x| x - offset).collect();
        if peak(&samples) <= 0.0 {
            return Err(RenderError::Silent);
        }
        fade_ends(&mut samples, self.fade);
        Ok(samples)
    }

    /// By how much the fade changed `target` to `faded`, where that is much.
    pub(crate) fn fade_loss<O: Quantity>(
        &self,
        target: &Series<O>,
        faded: &[f64],
    ) -> Option<FadeLoss> {
        let offset = offset(target.samples(), self.rate, self.band);
        let whole: Vec<f64> = target.samples().iter().map(|x| x - offset).collect();
        let change = |of: fn(&[f64]) -> f64| {
            Decibels::from_amplitude_ratio(of(faded) / of(&whole).max(f64::MIN_POSITIVE))
        };
        let loss = FadeLoss {
            fade: self.rate.duration_of(self.fade),
            level: change(rms),
            peak: change(peak),
        };
        (loss.level.0.min(loss.peak.0) <= -MUCH.0).then_some(loss)
    }

    /// `texture` with the silence around it, as long as the transform.
    pub(crate) fn padded(&self, texture: &[f64]) -> Vec<f64> {
        let mut padded = vec![0.0; self.transformed()];
        padded[self.before..self.before + self.target].copy_from_slice(texture);
        padded
    }

    /// The played part of `samples`, which are as long as the transform: its ends faded within the silence, at the output
    /// rate.
    pub(crate) fn played(&self, mut samples: Vec<f64>) -> Vec<f64> {
        samples.truncate(self.length());
        let fade = self.rate.samples_in(SILENT_FADE);
        fade_ends(&mut samples, fade.min(self.before).min(self.after));
        match &self.resampler {
            Some(resampler) => resampler.process(&samples),
            None => samples,
        }
    }

    /// The rate of the target.
    pub(crate) fn rate(&self) -> SampleRate {
        self.rate
    }
}

/// So many periods of the lowest frequency of a band have a mean of their own that is next to nothing.
const PERIODS: f64 = 10.0;
/// The mean of a short effect is an offset where it exceeds its deviations by this factor.
const OFFSET_RATIO: f64 = 3.0;

/// What is no part of the texture `samples` that is rendered in `band`: its mean (gravity, an offset of the amplifier), which faded or
/// beside silence would become a ramp or a step with power in the band. A short effect has a mean of its own; only a large one is an
/// offset.
pub(crate) fn offset(samples: &[f64], rate: SampleRate, band: Band) -> f64 {
    let mean = mean(samples);
    let periods = rate.duration_of(samples.len()).0 * band.low().0;
    let is_offset = periods >= PERIODS || mean.abs() > OFFSET_RATIO * standard_deviation(samples);
    if is_offset { mean } else { 0.0 }
}

/// Raised-cosine fades over `length` samples at both ends, in place.
pub(crate) fn fade_ends(samples: &mut [f64], length: usize) {
    let n = samples.len();
    let length = length.min(n / 2);
    for i in 0..length {
        let gain = fade((i as f64 + 0.5) / length as f64);
        samples[i] *= gain;
        samples[n - 1 - i] *= gain;
    }
}
