//! From one sampling rate to another, without moving the signal in time.
//!
//! A polyphase filter with a Kaiser-windowed sinc. It knows the band that must come through, so that it is
//! as short as that band allows: a drive that ends at 1 kHz needs 15 taps where a resampler that must keep
//! everything needs hundreds.

mod warning;

pub use warning::ResampleWarning;

use crate::series::SeriesError;
use std::f64::consts::PI;
use std::ops::Range;

use crate::quantity::{Hertz, Quantity, SampleRate};
use crate::series::Series;
use crate::warning::Warning;

/// The stop-band attenuation after resampling, dB. Residuals are below the quantisation
/// noise of 16 bits and of every sensor here.
pub const REJECTION_DB: f64 = 120.0;

/// Outputs that are computed side by side.
const LANES: usize = 32;
/// The most samples that a change of rate makes, 4 GB.
const MOST_SAMPLES: f64 = 536_870_912.0;
/// The largest table of coefficients, in numbers (128 MB).
const LARGEST_TABLE: usize = 1 << 24;

/// A planned change of rate.
#[derive(Clone)]
pub struct Resampler {
    from: SampleRate,
    to: SampleRate,
    /// Outputs and inputs of one cycle; the cycle then repeats.
    outputs: usize,
    inputs: usize,
    /// Inputs before the first of a cycle that its outputs need.
    reach: usize,
    runs: Vec<Run>,
    simd: pulp::Arch,
}

impl std::fmt::Debug for Resampler {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Resampler")
            .field("from", &self.from)
            .field("to", &self.to)
            .finish_non_exhaustive()
    }
}

/// [`LANES`] neighbouring outputs of a cycle and the coefficients that make them.
#[derive(Clone)]
struct Run {
    /// The first input it needs, counted from `reach` before the cycle's first.
    first: usize,
    /// The coefficient of every input for every lane.
    taps: Vec<[f64; LANES]>,
}

impl Resampler {
    /// A plan that keeps 0 Hz to `passband` within 1e-5 and puts everything that would fold into it below
    /// −120 dB ([`REJECTION_DB`]).
    ///
    /// # Errors
    /// [`SeriesError::Passband`] when the band does not fit both rates, [`SeriesError::Ratio`] when the
    /// rates have no common cycle that fits into memory.
    pub fn new(from: SampleRate, to: SampleRate, passband: Hertz) -> Result<Self, SeriesError> {
        let nyquist = if from.hz() < to.hz() {
            from.nyquist()
        } else {
            to.nyquist()
        };
        if !(passband.0 > 0.0 && passband.0 < nyquist.0) {
            return Err(SeriesError::Passband { passband, from, to });
        }
        // What folds onto the passband starts as far above Nyquist as the passband ends below it.
        let stop_hz = 2.0 * nyquist.0 - passband.0;
        let cutoff_hz = 0.5 * (passband.0 + stop_hz);
        // Kaiser's estimates of length and shape for a given rejection and transition.
        let length_s = (REJECTION_DB - 7.95) / (2.285 * 2.0 * PI * (stop_hz - passband.0));
        let beta = 0.1102 * (REJECTION_DB - 8.7);
        let (up, down) = ratio(to.hz() / from.hz()).ok_or(SeriesError::Ratio { from, to })?;
        // As many cycles as fill the lanes.
        let cycles = LANES / gcd(up, LANES);
        let (outputs, inputs) = (up * cycles, down * cycles);
        let half_taps = (0.5 * length_s * from.hz()).ceil().max(1.0) as usize;
        if outputs.saturating_mul(2 * half_taps + 2) > LARGEST_TABLE {
            return Err(SeriesError::Ratio { from, to });
        }
        let kernel = |t_s: f64| {
            let place = 2.0 * t_s / length_s;
            if place.abs() >= 1.0 {
                return 0.0;
            }
            let x = 2.0 * cutoff_hz * t_s;
            let sinc = if x.abs() < 1e-12 {
                1.0
            } else {
                (PI * x).sin() / (PI * x)
            };
            sinc * bessel_i0(beta * (1.0 - place * place).sqrt())
        };
        let reach = half_taps;
        let runs = (0..outputs)
            .step_by(LANES)
            .map(|start| {
                let input_of = |output: usize| output * down / up;
                let first = input_of(start) + 1;
                let span = input_of(start + LANES - 1) + 2 * half_taps + 1 - first;
                let mut taps = vec![[0.0; LANES]; span];
                let mut own = Vec::with_capacity(2 * half_taps);
                for (lane, output) in (start..start + LANES).enumerate() {
                    let (base, late) = (input_of(output), output * down % up);
                    let at = |j: usize| {
                        let ahead = j as f64 - half_taps as f64 - late as f64 / up as f64;
                        kernel(ahead / from.hz())
                    };
                    own.clear();
                    own.extend((1..=2 * half_taps).map(at));
                    let sum: f64 = own.iter().sum();
                    for (j, tap) in (1..).zip(&own) {
                        taps[base + j - first][lane] = tap / sum;
                    }
                }
                Run { first, taps }
            })
            .collect();
        Ok(Self {
            from,
            to,
            outputs,
            inputs,
            reach,
            runs,
            simd: pulp::Arch::new(),
        })
    }

    /// The signal at the new rate, ⌈n·to/from⌉ samples in the unit of `samples`; before its start and after
    /// its end it is taken to be zero.
    #[must_use]
    pub fn process(&self, samples: &[f64]) -> Vec<f64> {
        self.of_padded(samples, |_padded, _own| {})
    }

    /// As [`Self::process`] for a part of a longer signal: beyond its ends it goes on, turned about its last sample by half a turn. Taken to
    /// be zero there, a part that ends far from zero overshoots.
    fn process_part(&self, samples: &[f64]) -> Vec<f64> {
        self.of_padded(samples, |padded, own| {
            let (Some(first), Some(last)) = (samples.first(), samples.last()) else {
                return;
            };
            let turned = |end: f64, inwards: usize, from_end: bool| {
                let inwards = inwards.min(samples.len() - 1);
                let at = if from_end {
                    samples.len() - 1 - inwards
                } else {
                    inwards
                };
                2.0 * end - samples[at]
            };
            for (back, value) in (1..).zip(padded[..own.start].iter_mut().rev()) {
                *value = turned(*first, back, false);
            }
            for (on, value) in (1..).zip(&mut padded[own.end..]) {
                *value = turned(*last, on, true);
            }
        })
    }

    /// The signal at the new rate, of `samples` with what `beyond` writes beyond the place that it is given, where zeros stand.
    fn of_padded(&self, samples: &[f64], beyond: impl Fn(&mut [f64], Range<usize>)) -> Vec<f64> {
        let n = samples.len();
        let wanted = (n * self.outputs).div_ceil(self.inputs);
        let cycles = wanted.div_ceil(self.outputs);
        let after = self
            .runs
            .iter()
            .map(|run| run.first + run.taps.len())
            .max()
            .unwrap_or(0)
            + self.inputs;
        let mut padded = vec![0.0; self.reach + n.max(cycles * self.inputs) + after];
        let own = self.reach..self.reach + n;
        padded[own.clone()].copy_from_slice(samples);
        beyond(&mut padded, own);
        let mut out = Vec::with_capacity(cycles * self.outputs);
        self.simd.dispatch(Cycles {
            resampler: self,
            padded: &padded,
            cycles,
            out: &mut out,
        });
        out.truncate(wanted);
        out
    }
}

/// The inner loop of [`Resampler::process`], with the widest instructions that the machine has.
struct Cycles<'a> {
    resampler: &'a Resampler,
    padded: &'a [f64],
    cycles: usize,
    out: &'a mut Vec<f64>,
}

impl pulp::WithSimd for Cycles<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, simd: S) {
        let Self {
            resampler,
            padded,
            cycles,
            out,
        } = self;
        // The registers that hold the lanes: four with AVX-512, eight with AVX2.
        let registers = LANES / S::F64_LANES;
        let mut lanes = [0.0; LANES];
        for cycle in 0..cycles {
            for run in &resampler.runs {
                let start = cycle * resampler.inputs + run.first;
                let mut sums = [simd.splat_f64s(0.0); LANES];
                for (x, taps) in padded[start..start + run.taps.len()].iter().zip(&run.taps) {
                    let (x, (taps, _)) = (simd.splat_f64s(*x), S::as_simd_f64s(taps));
                    for (sum, tap) in sums[..registers].iter_mut().zip(taps) {
                        *sum = simd.mul_add_f64s(x, *tap, *sum);
                    }
                }
                S::as_mut_simd_f64s(&mut lanes)
                    .0
                    .copy_from_slice(&sums[..registers]);
                out.extend_from_slice(&lanes);
            }
        }
    }
}

/// `x` at the rate `to`, in the same unit and at the same times; the lowest 90 % of the narrower of the two
/// bands come through unchanged. Beyond its ends the signal goes on as its point reflection there.
///
/// Source: J. F. Kaiser (1974); polyphase form, Crochiere and Rabiner, Multirate Digital Signal Processing.
///
/// # Errors
/// [`SeriesError::Ratio`] when the rates have no common cycle; [`SeriesError::TooShort`] when nothing is left;
/// [`SeriesError::TooLong`] when it would be more than half a thousand million samples.
pub fn resample<Q: Quantity>(x: &Series<Q>, to: SampleRate) -> Result<Series<Q>, SeriesError> {
    if x.rate() == to {
        return Ok(x.clone());
    }
    resample_over(x, to, Hertz(0.9 * x.rate().nyquist().0.min(to.nyquist().0)))
}

/// As [`resample`], with everything up to `passband` unchanged, below half the lower of the two rates.
///
/// Source: as [`resample`].
///
/// # Errors
/// Those of [`resample`]; [`SeriesError::Passband`] when the passband reaches beyond.
pub fn resample_over<Q: Quantity>(
    x: &Series<Q>,
    to: SampleRate,
    passband: Hertz,
) -> Result<Series<Q>, SeriesError> {
    if x.rate() == to {
        return Ok(x.clone());
    }
    let wanted = x.duration().0 * to.hz();
    if wanted > MOST_SAMPLES {
        return Err(SeriesError::TooLong {
            found: wanted,
            duration_s: x.duration().0,
            to,
        });
    }
    let samples = Resampler::new(x.rate(), to, passband)?.process_part(x.samples());
    Series::new(samples, to).map_err(|_nothing_left| SeriesError::TooShort)
}

/// A series that was brought to a rate.
#[derive(Clone, Debug, PartialEq)]
pub struct Converted<Q: Quantity> {
    pub series: Series<Q>,
    /// That it was converted; none where it had the rate before.
    pub warning: Option<Warning>,
}

/// `x`, called `what`, at the rate `to`, in the same unit, with the warning that it was converted; as it is where that is
/// its rate.
///
/// Source: [`resample`].
///
/// # Errors
/// Those of [`resample`].
pub fn converted<Q: Quantity>(
    what: &str,
    x: Series<Q>,
    to: SampleRate,
) -> Result<Converted<Q>, SeriesError> {
    let from = x.rate();
    if from == to {
        return Ok(Converted {
            series: x,
            warning: None,
        });
    }
    let warning = Warning::from(ResampleWarning::RateConverted {
        signal: what.into(),
        from_hz: from.hz(),
        to_hz: to.hz(),
    });
    Ok(Converted {
        series: resample(&x, to)?,
        warning: Some(warning),
    })
}

/// Two series at one rate, so that they can be compared.
#[derive(Clone, Debug, PartialEq)]
pub struct CommonRate<Q: Quantity> {
    pub first: Series<Q>,
    pub second: Series<Q>,
    /// Which of them was converted, if one was.
    pub warning: Option<Warning>,
}

/// Two series, each with the name it has for people, at the lower of their two rates; as they are when their
/// rates are equal.
///
/// Source: [`resample`].
///
/// # Errors
/// Those of [`resample`].
pub fn to_common_rate<Q: Quantity>(
    first: (&str, Series<Q>),
    second: (&str, Series<Q>),
) -> Result<CommonRate<Q>, SeriesError> {
    let (from, to) = (first.1.rate(), second.1.rate());
    let lower = if from.hz() > to.hz() { to } else { from };
    let first = converted(first.0, first.1, lower)?;
    let second = converted(second.0, second.1, lower)?;
    Ok(CommonRate {
        first: first.series,
        second: second.series,
        warning: first.warning.or(second.warning),
    })
}

/// The smallest whole numbers whose ratio is `value` to 1e-10, by continued fractions.
fn ratio(value: f64) -> Option<(usize, usize)> {
    let (mut before, mut now) = ((0usize, 1usize), (1usize, 0usize));
    let mut rest = value;
    for _ in 0..40 {
        let whole = rest.floor();
        if !(0.0..1e9).contains(&whole) {
            return None;
        }
        let next = (
            (whole as usize).checked_mul(now.0)?.checked_add(before.0)?,
            (whole as usize).checked_mul(now.1)?.checked_add(before.1)?,
        );
        (before, now) = (now, next);
        if ((now.0 as f64 / now.1 as f64) / value - 1.0).abs() < 1e-10 {
            return (now.0 > 0).then_some(now);
        }
        if rest <= whole {
            return None;
        }
        rest = 1.0 / (rest - whole);
    }
    None
}

fn gcd(a: usize, b: usize) -> usize {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// The modified Bessel function of the first kind and order 0, by its power series.
pub(crate) fn bessel_i0(x: f64) -> f64 {
    let quarter = x * x / 4.0;
    let (mut term, mut sum) = (1.0, 1.0);
    for k in 1..200 {
        term *= quarter / (k * k) as f64;
        sum += term;
        if term < sum * 1e-17 {
            break;
        }
    }
    sum
}

/// Half the samples that one between them is made of.
pub(crate) const REACH: i64 = 24;

/// `samples` at `place(i)` for each of `count` places, in samples; nothing beyond the ends.
///
/// Formula: sinc interpolation under a squared cosine of 48 samples.
pub(crate) fn at_places(samples: &[f64], count: usize, place: impl Fn(usize) -> f64) -> Vec<f64> {
    use std::f64::consts::PI;
    (0..count)
        .map(|i| {
            let at = place(i);
            let whole = at.floor();
            let part = at - whole;
            let from = whole as i64;
            let near = (1 - REACH..=REACH).filter_map(|k| {
                let sample = usize::try_from(from + k)
                    .ok()
                    .and_then(|i| samples.get(i))?;
                let x = part - k as f64;
                let sinc = if x.abs() < 1e-9 {
                    1.0
                } else {
                    (PI * x).sin() / (PI * x)
                };
                let edge = (0.5 * PI * x / REACH as f64).cos();
                Some(sample * sinc * edge * edge)
            });
            near.sum()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn hz(rate_hz: f64) -> SampleRate {
        SampleRate::new(rate_hz).unwrap()
    }

    /// A tone in the passband comes out as the same tone, sample for sample.
    #[test]
    fn a_tone_stays_where_it_is() {
        for (from, to, passband, tone_hz) in [
            (5000.0, 48000.0, 1100.0, 997.0),
            (48000.0, 5000.0, 2200.0, 150.0),
            (10000.0, 1300.0, 585.0, 500.0),
            (1300.0, 48000.0, 600.0, 590.0),
            (5000.0, 44100.0, 2250.0, 2240.0),
            (5000.0, 5000.0, 2000.0, 1999.0),
            (35.714_285_714_285_715, 100.0, 12.0, 7.0),
        ] {
            let x: Vec<f64> = (0..6000)
                .map(|i| (2.0 * PI * tone_hz * i as f64 / from).sin())
                .collect();
            let y = Resampler::new(hz(from), hz(to), Hertz(passband))
                .unwrap()
                .process(&x);
            assert_eq!(
                y.len(),
                (6000.0 * to / from).ceil() as usize,
                "{from} → {to}"
            );
            let middle = y.len() / 4..3 * y.len() / 4;
            let worst = middle
                .map(|m| (y[m] - (2.0 * PI * tone_hz * m as f64 / to).sin()).abs())
                .fold(0.0, f64::max);
            assert!(worst < 1e-5, "{from} → {to}: {worst:e}");
        }
    }

    /// What would fold into the passband is gone: 120 dB, with 3 dB for the ripple of Kaiser's estimate.
    #[test]
    fn what_would_fold_is_gone() {
        let x: Vec<f64> = (0..96_000)
            .map(|i| (2.0 * PI * 2900.0 * i as f64 / 48000.0).sin())
            .collect();
        let y = Resampler::new(hz(48000.0), hz(5000.0), Hertz(2000.0))
            .unwrap()
            .process(&x);
        let peak = crate::statistics::peak(&y[2000..8000]);
        // 2.9 kHz folds to 2.1 kHz, above the passband: the filter is in its transition there.
        assert!(peak < 0.2, "{peak}");
        let x: Vec<f64> = (0..96_000)
            .map(|i| (2.0 * PI * 3100.0 * i as f64 / 48000.0).sin())
            .collect();
        let y = Resampler::new(hz(48000.0), hz(5000.0), Hertz(2000.0))
            .unwrap()
            .process(&x);
        let peak_db = 20.0 * crate::statistics::peak(&y[2000..8000]).log10();
        assert!(peak_db < -REJECTION_DB + 3.0, "{peak_db}");
    }

    /// A part of a signal that ends far from zero does not overshoot: a ramp stays a ramp to its ends.
    #[test]
    fn a_ramp_stays_within_its_ends() {
        let ramp: Vec<f64> = (0..4000)
            .map(|i| 15.0 * (i as f64 / 2000.0 - 1.0))
            .collect();
        let x: Series<crate::quantity::Acceleration> = Series::new(ramp, hz(4000.0)).unwrap();
        for to in [48_000.0, 44_100.0, 1300.0] {
            let y = resample(&x, hz(to)).unwrap();
            let off = |(i, y): (usize, &f64)| (y - 15.0 * (2.0 * i as f64 / to - 1.0)).abs();
            let worst = y.samples().iter().enumerate().map(off).fold(0.0, f64::max);
            assert!(worst < 15.0 * 1e-3, "{to}: {worst}");
        }
        // Shorter than the filter reaches.
        let short: Series<crate::quantity::Acceleration> =
            Series::new(vec![1.0; 3], hz(4000.0)).unwrap();
        let held = resample(&short, hz(48_000.0)).unwrap();
        assert!(held.samples().iter().all(|y| (y - 1.0).abs() < 1e-9));
    }

    #[test]
    fn rates_without_a_common_cycle_are_refused() {
        let error = Resampler::new(hz(5000.0), hz(5_000.000_123), Hertz(1000.0)).unwrap_err();
        assert!(matches!(error, SeriesError::Ratio { .. }), "{error}");
        assert!(Resampler::new(hz(5000.0), hz(1000.0), Hertz(1000.0)).is_err());
    }
}
