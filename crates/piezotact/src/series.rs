//! One channel of samples: a physical quantity at a uniform rate.

use std::marker::PhantomData;

use crate::number::{digits, rounded};
use crate::quantity::{Decibels, Measure, Quantity, SampleRate, Seconds};
use crate::statistics::{peak, rms, standard_deviation};

/// The largest magnitude of a sample, in any unit: squares and sums of what lies below stay finite.
pub const LARGEST_SAMPLE: f64 = 1e100;

/// One channel of a physical quantity `Q`, in its SI unit, at a uniform rate; every sample is a number within
/// ±[`LARGEST_SAMPLE`], and there is at least one.
#[derive(Clone, Debug, PartialEq)]
pub struct Series<Q: Quantity> {
    samples: Vec<f64>,
    rate: SampleRate,
    quantity: PhantomData<Q>,
}

impl<Q: Quantity> Series<Q> {
    /// A series of `samples` in the SI unit of `Q`, taken at `rate`.
    ///
    /// # Errors
    /// [`SeriesError::Empty`] without samples; [`SeriesError::NotFinite`] with the place of the first
    /// sample that is NaN, infinite or beyond ±1e100.
    pub fn new(samples: Vec<f64>, rate: SampleRate) -> Result<Self, SeriesError> {
        if samples.is_empty() {
            return Err(SeriesError::Empty { quantity: Q::NAME });
        }
        if let Some(at) = samples.iter().position(|v| !is_sample(*v)) {
            return Err(SeriesError::NotFinite {
                quantity: Q::NAME,
                at,
                time: rate.duration_of(at),
                found: samples[at],
            });
        }
        Ok(Self {
            samples,
            rate,
            quantity: PhantomData,
        })
    }

    /// The samples, in the SI unit of `Q`.
    #[must_use]
    pub fn samples(&self) -> &[f64] {
        &self.samples
    }

    /// Gives the samples away, in the SI unit of `Q`.
    #[must_use]
    pub fn into_samples(self) -> Vec<f64> {
        self.samples
    }

    /// The sampling rate.
    #[must_use]
    pub fn rate(&self) -> SampleRate {
        self.rate
    }

    /// The length in time.
    #[must_use]
    pub fn duration(&self) -> Seconds {
        self.rate.duration_of(self.samples.len())
    }

    /// The root mean square about zero, in the SI unit of `Q`.
    #[must_use]
    pub fn rms(&self) -> f64 {
        rms(&self.samples)
    }

    /// The largest absolute sample, in the SI unit of `Q`.
    #[must_use]
    pub fn peak(&self) -> f64 {
        peak(&self.samples)
    }

    /// The root mean square about the mean, with the SI unit of `Q`.
    #[must_use]
    pub fn rms_about_mean(&self) -> Measure {
        Measure {
            value: standard_deviation(&self.samples),
            unit: Q::UNIT,
        }
    }

    /// The samples in shares of their largest magnitude, and that magnitude with the SI unit of `Q`; zeros in shares of the
    /// smallest positive number where all are 0.
    #[must_use]
    pub fn in_shares_of_peak(&self) -> (Vec<f64>, Measure) {
        let peak = self.peak().max(f64::MIN_POSITIVE);
        let share = |v: &f64| v / peak;
        let full_scale = Measure {
            value: peak,
            unit: Q::UNIT,
        };
        (self.samples.iter().map(share).collect(), full_scale)
    }

    /// The series at another level: every sample times 10^(dB/20).
    #[must_use]
    pub fn amplified(mut self, level: Decibels) -> Self {
        let factor = level.amplitude_ratio();
        for sample in &mut self.samples {
            *sample *= factor;
        }
        self
    }
}

/// Whether `value` can be a sample: a number within ±[`LARGEST_SAMPLE`].
///
/// Source: house rule; NaN, infinities and numbers whose squares overflow are none.
#[must_use]
pub fn is_sample(value: f64) -> bool {
    value.abs() <= LARGEST_SAMPLE
}

/// The `missing` samples between `before` and `after` on the straight line between the two, which are left out; in their unit.
///
/// Formula: x(k) = before + (after − before)·k/(n + 1), k = 1 … n.
///
/// Source: house rule; what stands in the place of lost samples keeps the time of what follows, and a warning says where it stands.
///
/// ```
/// use piezotact::series::filled;
///
/// assert_eq!(filled([1.0, 3.0], 3).collect::<Vec<_>>(), [1.5, 2.0, 2.5]);
/// ```
pub fn filled([before, after]: [f64; 2], missing: u64) -> impl Iterator<Item = f64> {
    let steps = (missing + 1) as f64;
    (1..=missing).map(move |k| before + (after - before) * k as f64 / steps)
}

/// Samples that make no series, or that cannot be filtered, resampled, convolved or scaled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SeriesError {
    /// There is not one sample.
    #[error(
        "there are no samples of {quantity}; check that the recording was not stopped before it began"
    )]
    Empty {
        /// The quantity that was wanted.
        quantity: &'static str,
    },
    /// A sample is NaN or infinite.
    #[error(
        "expected finite samples of {quantity} within ±1e100, found {found} at sample {at} ({time:.3}); cut that part or repair the export",
        found = rounded(*found)
    )]
    NotFinite {
        /// The quantity that was wanted.
        quantity: &'static str,
        /// The index of the first such sample.
        at: usize,
        /// Its time from the start.
        time: Seconds,
        found: f64,
    },
    /// An order that is not even or too high.
    #[error("expected an even filter order from 2 to 12, found {found}; 4 is usual")]
    Order { found: usize },
    /// A cut-off outside the band of the signal.
    #[error(
        "expected a cut-off above 0 and below half the rate ({nyquist_hz} Hz), found {found_hz} Hz; state another, or none",
        nyquist_hz = rounded(*nyquist_hz),
        found_hz = rounded(*found_hz)
    )]
    Cutoff {
        /// What was found, Hz.
        found_hz: f64,
        /// Half the rate, Hz.
        nyquist_hz: f64,
    },
    /// A rate that cannot be.
    #[error(transparent)]
    Rate(#[from] crate::quantity::QuantityError),
    /// The band does not fit.
    #[error(
        "expected a band that ends below half of {from} and of {to}, found one up to {passband}; lower the band's end or use a \
            higher rate"
    )]
    Passband {
        passband: crate::quantity::Hertz,
        /// The rate that goes in.
        from: SampleRate,
        /// The rate that comes out.
        to: SampleRate,
    },
    /// No common cycle.
    #[error(
        "expected two rates with a simple ratio, found {from} and {to}; use a rate such as 5000, 10000, 44100 or 48000 Hz"
    )]
    Ratio {
        /// The rate that goes in.
        from: SampleRate,
        /// The rate that comes out.
        to: SampleRate,
    },
    /// More samples than are made.
    #[error(
        "expected at most 536870912 samples at the new rate, found {found:.0} ({duration_s} s at {to}); cut the signal, or check its rate",
        duration_s = rounded(*duration_s)
    )]
    TooLong {
        /// How many it would be.
        found: f64,
        /// How long it lasts, s.
        duration_s: f64,
        /// The rate that comes out.
        to: SampleRate,
    },
    /// Nothing is left.
    #[error("the signal is shorter than one sample at the new rate: record longer")]
    TooShort,
    /// A full scale that is no number above zero.
    #[error(
        "expected a full scale above zero, found {found}; the signal is silent or the scale is wrong",
        found = rounded(*found)
    )]
    FullScale { found: f64 },
    /// A drive that is larger than full scale.
    #[error(
        "expected a drive within ±1 of full scale, found a peak of {}; lower its level",
        digits(*peak)
    )]
    Drive { peak: f64 },
    /// A drive of zeros.
    #[error("the signal is silent: there is nothing to export")]
    Silence,
    /// The block has no sample, or too many.
    #[error(
        "expected a block of 1 to 65536 samples, found {found}; state how many samples the device takes at a time"
    )]
    Block { found: usize },
    /// The impulse response is empty.
    #[error("the impulse response has no sample: give its samples")]
    NoImpulse,
    /// A sample of the impulse response is no finite number.
    #[error(
        "expected finite samples in an impulse response, found {found} at sample {at}; compute it again without"
    )]
    ImpulseNotFinite {
        /// Which one, from 0.
        at: usize,
        found: f64,
    },
    /// A block, or the partitions of an impulse response, of another length than planned.
    #[error(
        "expected {} block(s) of {} samples, found {} of {}; cut both impulse responses for one block, and fill the shorter one with zeros",
        expected[0], expected[1], found[0], found[1]
    )]
    Lengths {
        /// How many blocks, and how many samples in each.
        expected: [usize; 2],
        /// The same of what was given.
        found: [usize; 2],
    },
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::Acceleration;

    #[test]
    fn a_series_is_finite_or_is_not() {
        let rate = SampleRate::new(1000.0).unwrap();
        assert!(Series::<Acceleration>::new(vec![], rate).is_err());
        let error = Series::<Acceleration>::new(vec![0.0, f64::NAN], rate).unwrap_err();
        assert!(error.to_string().contains("sample 1 (0.001 s)"), "{error}");
    }

    #[test]
    fn a_gap_is_filled_by_a_straight_line() {
        assert_eq!(filled([2.0, -1.0], 2).collect::<Vec<_>>(), [1.0, 0.0]);
        assert_eq!(filled([5.0, 7.0], 0).count(), 0);
        // A part of a long gap is what the whole holds there.
        let whole: Vec<f64> = filled([0.1, 0.7], 1000).collect();
        let part: Vec<f64> = filled([0.1, 0.7], 1000).skip(400).take(100).collect();
        assert_eq!(part, whole[400..500]);
    }

    #[test]
    fn the_peak_of_a_series_is_one_in_shares() {
        let rate = SampleRate::new(1000.0).unwrap();
        let of = |samples: &[f64]| {
            let series = Series::<Acceleration>::new(samples.to_vec(), rate).unwrap();
            series.in_shares_of_peak()
        };
        let (shares, full_scale) = of(&[1.0, -4.0]);
        assert_eq!((shares, full_scale.value), (vec![0.25, -1.0], 4.0));
        assert_eq!(full_scale.unit, Acceleration::UNIT);
        let (shares, full_scale) = of(&[0.0]);
        assert!(shares == [0.0] && full_scale.value > 0.0);
    }

    #[test]
    fn the_rms_of_a_sine_is_its_amplitude_over_root_two() {
        let rate = SampleRate::new(1000.0).unwrap();
        let sine = (0..1000).map(|i| 2.0 * (i as f64 * 0.1 * std::f64::consts::TAU).sin());
        let series = Series::<Acceleration>::new(sine.collect(), rate).unwrap();
        assert!((series.rms() - 2f64.sqrt()).abs() < 1e-12);
    }
}
