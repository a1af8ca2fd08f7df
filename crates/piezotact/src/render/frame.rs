//! The time frame of a texture: the silence before and after that its inverse needs, and resampling to the output rate.

use super::{InversePlan, RenderConfig, RenderError};
use crate::fourier::fade;
use crate::fourier::fast_length;
use crate::quantity::{Band, Decibels, Hertz, Quantity, SampleRate, Seconds};
use crate::resample::Resampler;
use crate::series::Series;
use crate::statistics::{mean, peak, rms, standard_deviation};
use crate::transfer::TransferFunction;

/// The drive begins and ends with a fade of this length within the silence around the texture.
const SILENT_FADE: Seconds = Seconds(0.02);
/// The silence holds the ringing of the inverse but for this share of its energy (−40 dB).
const RINGING_LOST: f64 = 1e-4;
/// The longest silence before and after a texture, and the longest ringing that is looked at.
const LONGEST_SILENCE: Seconds = Seconds(1.0);

impl RenderConfig {
    /// The same with as much silence before and after the texture as the inverse of `function` rings, at the rate of the texture:
    /// all but 1e-4 of the energy of its impulse response, and the fade of the drive; no less than is stated, no more than 1 s.
    ///
    /// # Errors
    /// Those of [`super::invert`].
    pub(crate) fn padded_for<O: Quantity>(
        &self,
        function: &TransferFunction<crate::quantity::Drive, O>,
        rate: SampleRate,
    ) -> Result<Self, RenderError> {
        let n = fast_length(2 * rate.samples_in(LONGEST_SILENCE));
        let mut impulse = vec![0.0; n];
        impulse[0] = 1.0;
        let inverse = InversePlan::new(n).invert(&impulse, rate, function, &self.inverse)?;
        let energy: f64 = inverse.iter().map(|x| x * x).sum();
        let (late, early) = inverse.split_at(n / 2);
        let needed = |stated: Seconds, ringing: usize| {
            let ringing_s = rate.duration_of(ringing).0 + SILENT_FADE.0;
            // Whole hundredths, so that equal devices give equal delays.
            let silence_s = ((ringing_s * 100.0).ceil() / 100.0).min(LONGEST_SILENCE.0);
            Seconds(stated.0.max(silence_s))
        };
        let before = length_of(early.iter(), 0.5 * RINGING_LOST * energy);
        let after = length_of(late.iter().rev(), 0.5 * RINGING_LOST * energy);
        Ok(Self {
            modelling_delay: needed(self.modelling_delay, before),
            tail: needed(self.tail, after),
            ..self.clone()
        })
    }
}

/// How many of `samples`, which come from their far end, remain when the first with an energy of `lost` are left out.
fn length_of<'a>(samples: impl ExactSizeIterator<Item = &'a f64>, lost: f64) -> usize {
    let all = samples.len();
    let mut sum = 0.0;
    let left_out = samples
        .take_while(|x| {
            sum += **x * **x;
            sum <= lost
        })
        .count();
    all - left_out
}

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

    /// The target without its offset, with faded ends where a fade is asked for.
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

    /// The fade that was asked for, and by how much it changed the level of `target` to that of `faded`; `None` without one.
    pub(crate) fn fade_loss<O: Quantity>(
        &self,
        target: &Series<O>,
        faded: &[f64],
    ) -> Option<(Seconds, Decibels)> {
        let offset = offset(target.samples(), self.rate, self.band);
        let whole: Vec<f64> = target.samples().iter().map(|x| x - offset).collect();
        let ratio = rms(faded) / rms(&whole).max(f64::MIN_POSITIVE);
        (self.fade > 0).then(|| {
            (
                self.rate.duration_of(self.fade),
                Decibels::from_amplitude_ratio(ratio),
            )
        })
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

/// What is no part of the texture `samples` that is rendered in `band`: its mean (gravity, an offset of the amplifier), which beside
/// silence would become a step with power in the band. A short effect has a mean of its own; only a large one is an offset.
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
