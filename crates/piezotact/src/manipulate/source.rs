//! Textures before they are manipulated: a stroke of a recording, and other rates.

use super::{Manipulated, Texture};
use crate::feature::{FeatureError, vibrations};
use crate::filter::HighPass;
use crate::lineage::{Operation, Step};
use crate::quantity::{Acceleration, Quantity, SampleRate};
use crate::recording::Recording;
use crate::resample::converted;
use crate::series::Series;
use crate::series::SeriesError;
use crate::stroke::{Segmentation, Stroke};

/// Time stamps give rates that are whole but for their last digits, a share of this.
const WHOLE_RATE_SHARE: f64 = 1e-5;

/// The steady part of stroke `number` (from 1) of `recording` in m/s², without the gesture, and its step from the `whole`
/// vibration; the warnings are those of the segmentation and of the filter. `None` where there is no such stroke.
///
/// Formula: that of [`textures_of_strokes`].
///
/// Source: thesis 3.3.1; [`vibrations`].
///
/// # Errors
/// Those of [`textures_of_strokes`].
pub fn texture_of_stroke(
    whole: &Series<Acceleration>,
    cut: (&Recording, &Segmentation),
    number: usize,
) -> Result<Option<Manipulated<Acceleration>>, FeatureError> {
    let mut textures = textures_of_strokes(whole, cut)?;
    let index = number.checked_sub(1).filter(|i| *i < textures.len());
    Ok(index.map(|index| textures.swap_remove(index)))
}

/// The steady part of every stroke of `recording` in m/s², without the gesture, each with its step from the `whole` vibration and
/// with the warnings of the segmentation and of the filter.
///
/// Formula: [`HighPass::gesture`] forwards and backwards over the whole recording, then the samples of the steady parts.
///
/// Source: thesis 3.3.1; [`vibrations`].
///
/// # Errors
/// Those of [`vibrations`]; [`FeatureError::Series`] where a steady part has no sample.
pub fn textures_of_strokes(
    whole: &Series<Acceleration>,
    (recording, segmentation): (&Recording, &Segmentation),
) -> Result<Vec<Manipulated<Acceleration>>, FeatureError> {
    let gesture = HighPass::gesture();
    let freed = vibrations(recording, segmentation, Some(gesture))?;
    let warnings = [segmentation.warnings.as_slice(), freed.warnings.as_slice()].concat();
    let rate = recording.rate();
    let texture = |(i, stroke): (usize, &Stroke)| {
        let steady = &stroke.steady;
        let samples = freed.channels.first().map(|channel| steady.of(channel));
        let samples = samples.map(<[f64]>::to_vec).unwrap_or_default();
        let series = Series::new(samples, rate)?;
        let operation = Operation::Stroke {
            number: i + 1,
            from_s: rate.duration_of(steady.start).0,
            to_s: rate.duration_of(steady.end).0,
            high_pass_hz: gesture.cutoff_hz.0,
        };
        Ok(Manipulated {
            step: Step::between(operation, whole.rms_about_mean(), series.rms_about_mean()),
            series,
            warnings: warnings.clone(),
        })
    };
    segmentation
        .strokes
        .iter()
        .enumerate()
        .map(texture)
        .collect()
}

impl<Q: Quantity> Texture<Q> {
    /// The texture, called `what`, at the rate `to`, with the warning that it was converted.
    ///
    /// # Errors
    /// Those of [`crate::resample::resample`].
    pub fn at_rate(mut self, what: &str, to: SampleRate) -> Result<Self, SeriesError> {
        let at_rate = converted(what, self.series, to)?;
        self.series = at_rate.series;
        self.warnings.extend(at_rate.warning);
        Ok(self)
    }

    /// The texture at a whole number of samples a second, as files state it; as it is where its rate differs from that by
    /// rounding.
    ///
    /// # Errors
    /// Those of [`crate::resample::resample`].
    pub fn at_whole_rate(self, what: &str) -> Result<Self, SeriesError> {
        let from_hz = self.series.rate().hz();
        let whole_hz = from_hz.round();
        if (from_hz - whole_hz).abs() <= WHOLE_RATE_SHARE * from_hz {
            return Ok(self);
        }
        self.at_rate(what, SampleRate::new(whole_hz)?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texture(rate_hz: f64) -> Texture<Acceleration> {
        let wave = (0..2000).map(|i| (f64::from(i) * 0.3).sin()).collect();
        let rate = SampleRate::new(rate_hz).unwrap();
        Texture::of("S8", Series::new(wave, rate).unwrap())
    }

    /// A rate that is whole but for rounding stays; another becomes the nearest whole one, and is named as converted.
    #[test]
    fn only_a_rate_that_is_not_whole_is_converted() {
        let near = texture(5000.01);
        assert_eq!(near.clone().at_whole_rate("it").unwrap(), near);
        let found = texture(1000.25).at_whole_rate("it").unwrap();
        assert_eq!(found.series.rate(), SampleRate::new(1000.0).unwrap());
        assert_eq!(found.warnings.len(), 1);
        let level = |t: &Texture<Acceleration>| t.series.rms_about_mean().value;
        let ratio = level(&found) / level(&texture(1000.25));
        assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
    }
}
