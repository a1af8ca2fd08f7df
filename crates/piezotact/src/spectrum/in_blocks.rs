//! Spectra of signals that come in blocks, as those of recordings larger than memory.

use super::{Averaging, EstimateError, Spectrum, WelchConfig, WelchPlan};
use crate::quantity::{Quantity, SampleRate};

/// The samples of signals that are together, from the first segment that is not complete on.
#[derive(Clone, Debug)]
pub(crate) struct Held {
    samples: Vec<f64>,
    segment: usize,
    hop: usize,
}

impl Held {
    pub(crate) fn new(segment: usize, hop: usize) -> Self {
        Self {
            samples: Vec::new(),
            segment,
            hop,
        }
    }

    /// Appends `block`, and gives every two segments that are complete and follow each other to `take`, in the order of time.
    pub(crate) fn add(&mut self, block: &[f64], mut take: impl FnMut(&[f64], &[f64])) {
        self.samples.extend_from_slice(block);
        let (both, mut at) = (self.segment + self.hop, 0);
        while let Some(pair) = self.samples.get(at..at + both) {
            take(&pair[..self.segment], &pair[self.hop..]);
            at += 2 * self.hop;
        }
        self.samples.drain(..at);
    }

    /// The last segment, where it has no other beside it.
    pub(crate) fn last(&self) -> Option<&[f64]> {
        self.samples.get(..self.segment)
    }
}

/// A Welch estimate of a signal that comes in blocks: that of the whole signal, bit for bit.
#[derive(Clone, Debug)]
pub struct WelchInBlocks {
    plan: WelchPlan,
    held: Held,
    samples: usize,
}

impl WelchInBlocks {
    /// An estimate of a signal at `rate`.
    ///
    /// # Errors
    /// [`EstimateError::Config`] when the configuration cannot be, and for the median of segments, which needs all of them.
    pub fn new(config: &WelchConfig, rate: SampleRate) -> Result<Self, EstimateError> {
        if config.averaging == Averaging::Median {
            return Err(EstimateError::Config {
                what: "the mean over the segments of a signal in blocks",
                found: "their median".into(),
            });
        }
        let plan = WelchPlan::new(config, rate)?;
        Ok(Self {
            held: Held::new(config.segment, plan.hop),
            plan,
            samples: 0,
        })
    }

    /// Takes the next samples of the signal.
    pub fn add(&mut self, block: &[f64]) {
        self.samples += block.len();
        if let super::Average::Mean(sum) = &mut self.plan.average {
            self.held.add(block, |a, b| sum.add_pair(a, b));
        }
    }

    /// The one-sided spectrum of all samples, as [`super::welch`] gives it.
    ///
    /// # Errors
    /// [`EstimateError::TooShort`] when they hold no segment.
    pub fn spectrum<Q: Quantity>(mut self) -> Result<Spectrum<Q>, EstimateError> {
        self.plan.config.fits(self.samples)?;
        let averages = self.plan.segments_in(self.samples);
        let mut values = Vec::new();
        if let super::Average::Mean(sum) = &mut self.plan.average {
            if let Some(last) = self.held.last() {
                sum.add_single(last);
            }
            values = super::mean_of(sum, averages);
        }
        Ok(self.plan.spectrum(values, averages))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Acceleration;
    use crate::series::Series;
    use crate::spectrum::{Cells, Detrend, SpectrogramConfig, SpectrogramInBlocks};
    use crate::spectrum::{spectrogram, welch};
    use crate::statistics::random::Random;

    /// Segments that overlap by half, by more, by less and not at all; an even and an odd number of them.
    #[test]
    fn spectra_in_blocks_are_those_of_the_whole_signal() {
        let rate = SampleRate::new(5000.0).unwrap();
        let mut random = Random::stream(7, 0, "blocks");
        let samples: Vec<f64> = (0..9001).map(|_| random.normal() + 0.3).collect();
        for (segment, overlap, detrend) in [
            (1024, 0.5, Detrend::Constant),
            (256, 0.875, Detrend::Constant),
            (300, 0.0, Detrend::Linear),
            (301, 0.25, Detrend::None),
        ] {
            for length in [9001, 9001 - segment / 2, segment] {
                let series = Series::<Acceleration>::new(samples[..length].to_vec(), rate);
                let series = series.unwrap();
                let config = WelchConfig {
                    overlap,
                    detrend,
                    ..WelchConfig::hann(segment)
                };
                let cells = Cells::AtMost {
                    columns: 7,
                    rows: 50,
                    highest: crate::quantity::Hertz(900.0),
                };
                let over_time = SpectrogramConfig {
                    overlap,
                    detrend,
                    cells,
                    ..SpectrogramConfig::hann(segment)
                };
                let whole = welch(&series, &config).unwrap();
                let whole_over_time = spectrogram(&series, &over_time).unwrap();
                for block in [1, 97, 1024, 5000, 20_000] {
                    let mut sums = WelchInBlocks::new(&config, rate).unwrap();
                    let mut cells = SpectrogramInBlocks::new(&over_time, rate, length).unwrap();
                    for part in series.samples().chunks(block) {
                        sums.add(part);
                        cells.add(part);
                    }
                    assert_eq!(sums.spectrum::<Acceleration>().unwrap(), whole, "{block}");
                    let cells = cells.spectrogram::<Acceleration>();
                    assert_eq!(cells, whole_over_time, "{block}");
                }
            }
        }
        let short = WelchInBlocks::new(&WelchConfig::hann(64), rate).unwrap();
        let error = short.spectrum::<Acceleration>().unwrap_err();
        assert_eq!(
            error,
            EstimateError::TooShort {
                expected: 64,
                found: 0
            }
        );
        let median = WelchConfig {
            averaging: Averaging::Median,
            ..WelchConfig::hann(64)
        };
        assert!(WelchInBlocks::new(&median, rate).is_err());
    }
}
