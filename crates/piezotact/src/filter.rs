//! Butterworth filters in second-order sections, run forwards and backwards so that they shift nothing in time.
//!
//! The gesture of a hand lies below some 5 Hz and dwarfs the vibration that friction makes: it is taken away
//! before anything is measured, by a filter that is stated with the result.

use crate::series::SeriesError;
use num_complex::Complex;
use serde::{Deserialize, Serialize};

use crate::quantity::{Hertz, SampleRate};

/// A zero-phase Butterworth high-pass: the order of one pass, and where it is 3 dB down. Forwards and backwards
/// together it is 6 dB down there, and of twice the order.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct HighPass {
    /// The order of one pass, even.
    pub order: usize,
    /// The −3 dB frequency of one pass.
    pub cutoff_hz: Hertz,
}

impl HighPass {
    /// What separates gesture from vibration unless stated: 5 Hz, fourth order in each pass.
    #[must_use]
    pub fn gesture() -> Self {
        Self {
            order: 4,
            cutoff_hz: Hertz(5.0),
        }
    }

    /// The share of a tone's amplitude that both passes together leave, 0–1.
    ///
    /// Formula: 1/(1 + (tan(πf₀/r)/tan(πf/r))²ⁿ), f₀ the cut-off, n the order and r the rate.
    ///
    /// Source: Oppenheim & Schafer, *Discrete-Time Signal Processing*, 3rd ed., section 7.3.
    #[must_use]
    pub fn gain(&self, tone: Hertz, rate: SampleRate) -> f64 {
        let warped = |hz: f64| (std::f64::consts::PI * hz / rate.hz()).tan();
        let ratio = warped(self.cutoff_hz.0) / warped(tone.0);
        1.0 / (1.0 + ratio.powi(2 * self.order as i32))
    }
}

impl std::fmt::Display for HighPass {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "high-pass at {} (Butterworth, order {}, forwards and backwards)",
            self.cutoff_hz, self.order
        )
    }
}

/// One section: numerator b0, b1, b2 and denominator 1, a1, a2, in powers of z⁻¹.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Section {
    b: [f64; 3],
    a: [f64; 2],
}

/// The side of its cut-off that a filter passes.
#[derive(Clone, Copy)]
enum Side {
    #[cfg(feature = "modal")]
    Low,
    High,
}

impl Side {
    /// The Butterworth sections of an even `order`.
    fn sections(self, order: usize, cutoff: Hertz, rate: SampleRate) -> Vec<Section> {
        let warped = (std::f64::consts::PI * cutoff.0 / rate.hz()).tan();
        (0..order / 2)
            .map(|pair| {
                let turn = std::f64::consts::PI * (2 * pair + 1) as f64 / (2 * order) as f64;
                // A pole of the low-pass prototype, and s = warped · pole or warped / pole; z = (1 + s)/(1 − s).
                let prototype = Complex::new(-turn.sin(), turn.cos());
                let (pole, level, middle) = match self {
                    #[cfg(feature = "modal")]
                    Self::Low => (warped * prototype, warped * warped, 2.0),
                    Self::High => (Complex::from(warped) / prototype, 1.0, -2.0),
                };
                let one = Complex::from(1.0);
                let z = (one + pole) / (one - pole);
                let gain = level / (one - pole).norm_sqr();
                Section {
                    b: [gain, middle * gain, gain],
                    a: [-2.0 * z.re, z.norm_sqr()],
                }
            })
            .collect()
    }
}

/// One sample of a signal through sections with their `states`.
fn through(sections: &[Section], states: &mut [[f64; 2]], sample: f64) -> f64 {
    let mut value = sample;
    for (Section { b, a }, state) in sections.iter().zip(states) {
        let answer = b[0] * value + state[0];
        state[0] = b[1] * value - a[0] * answer + state[1];
        state[1] = b[2] * value - a[1] * answer;
        value = answer;
    }
    value
}

/// A causal Butterworth band-pass of one octave, which says nothing of what comes later: second order below it, fourth above.
#[cfg(feature = "modal")]
#[derive(Clone, Debug)]
pub(crate) struct Octave {
    sections: Vec<Section>,
}

#[cfg(feature = "modal")]
impl Octave {
    /// The octave above `low`; all above `low` where the octave would reach half the rate.
    pub(crate) fn above(low: Hertz, rate: SampleRate) -> Self {
        let mut sections = Side::High.sections(2, low, rate);
        let high = Hertz(2.0 * low.0);
        if high < rate.nyquist() {
            sections.extend(Side::Low.sections(4, high, rate));
        }
        Self { sections }
    }

    /// `signal` without `rest`, filtered from rest into `filtered`.
    pub(crate) fn run(&self, signal: &[f64], rest: f64, filtered: &mut Vec<f64>) {
        let mut states = vec![[0.0; 2]; self.sections.len()];
        filtered.clear();
        filtered.extend(
            signal
                .iter()
                .map(|v| through(&self.sections, &mut states, v - rest)),
        );
    }
}

/// A planned filter: its sections, and their state after a step has passed for ever.
#[derive(Clone, Debug)]
pub struct ZeroPhase {
    sections: Vec<Section>,
    settled: Vec<[f64; 2]>,
    shortest: usize,
    padding: usize,
    edge: usize,
}

impl ZeroPhase {
    /// A plan of `high_pass` for signals at `rate`.
    ///
    /// Formula: the analogue prototype's poles, mapped by the bilinear transform with the cut-off prewarped.
    /// Source: Oppenheim & Schafer, *Discrete-Time Signal Processing*, 3rd ed., section 7.3.
    ///
    /// # Errors
    /// [`SeriesError::Order`] unless the order is even and from 2 to 12, [`SeriesError::Cutoff`] unless the
    /// cut-off lies above 0 and below half the rate.
    pub fn high_pass(high_pass: HighPass, rate: SampleRate) -> Result<Self, SeriesError> {
        let HighPass { order, cutoff_hz } = high_pass;
        if !(2..=12).contains(&order) || !order.is_multiple_of(2) {
            return Err(SeriesError::Order { found: order });
        }
        if !(cutoff_hz.0 > 0.0 && cutoff_hz.0 < rate.nyquist().0) {
            return Err(SeriesError::Cutoff {
                found_hz: cutoff_hz.0,
                nyquist_hz: rate.nyquist().0,
            });
        }
        let sections = Side::High.sections(order, cutoff_hz, rate);
        let mut level = 1.0;
        let settled = sections
            .iter()
            .map(|section| {
                let Section { b, a } = section;
                let answer = level * (b[0] + b[1] + b[2]) / (1.0 + a[0] + a[1]);
                let state = [answer - b[0] * level, b[2] * level - a[1] * answer];
                level = answer;
                state
            })
            .collect();
        Ok(Self {
            // As many samples as SciPy's sosfiltfilt takes for sections with two zeros at z = 1.
            shortest: 3 * (2 * sections.len() + 1),
            // What the filter takes to settle, and half a period of its cut-off.
            padding: (0.5 * order as f64 * rate.hz() / cutoff_hz.0).ceil() as usize,
            edge: (0.5 * rate.hz() / cutoff_hz.0).round() as usize,
            sections,
            settled,
        })
    }

    /// `signal` filtered forwards and backwards, of the same length and unit. A signal of a few samples is only freed of its mean.
    ///
    /// The ends are continued for as long as the filter takes to settle, by point reflection about the value at the end of a
    /// straight line through the last half period of the cut-off. The last sample itself would be no such value: it holds vibration,
    /// and a reflection about it adds a step of twice that to what has no low frequency.
    ///
    /// Formula: e = the value of the least-squares line at the end; beyond it 2·e − x.
    ///
    /// Source: SciPy's `sosfiltfilt` for the passes (its extension is `odd`, about the last sample); docs/decisions/strokes.md for
    /// the line.
    #[must_use]
    pub fn apply(&self, signal: &[f64]) -> Vec<f64> {
        let n = signal.len();
        if n <= self.shortest {
            let mean = signal.iter().sum::<f64>() / n.max(1) as f64;
            return signal.iter().map(|v| v - mean).collect();
        }
        let pad = self.padding.max(self.shortest).min(n - 1);
        let edge = self.edge.max(self.shortest).min(n);
        let first = line_at_start(signal[..edge].iter());
        let last = line_at_start(signal[n - edge..].iter().rev());
        let mut work = Vec::with_capacity(n + 2 * pad);
        work.extend((1..=pad).rev().map(|i| 2.0 * first - signal[i]));
        work.extend_from_slice(signal);
        work.extend((2..pad + 2).map(|i| 2.0 * last - signal[n - i]));
        self.pass(work.iter_mut());
        self.pass(work.iter_mut().rev());
        work.drain(..pad);
        work.truncate(n);
        work
    }

    fn pass<'a>(&self, samples: impl ExactSizeIterator<Item = &'a mut f64>) {
        let mut samples = samples.peekable();
        let Some(first) = samples.peek().map(|sample| **sample) else {
            return;
        };
        let mut states: Vec<[f64; 2]> = self
            .settled
            .iter()
            .map(|state| state.map(|s| s * first))
            .collect();
        for sample in samples {
            *sample = through(&self.sections, &mut states, *sample);
        }
    }
}

/// The value at the first of `samples` of the least-squares line through them.
fn line_at_start<'a>(samples: impl ExactSizeIterator<Item = &'a f64>) -> f64 {
    let count = samples.len() as f64;
    let middle = (count - 1.0) / 2.0;
    let (mut sum, mut moment) = (0.0, 0.0);
    for (i, sample) in samples.enumerate() {
        sum += sample;
        moment += (i as f64 - middle) * sample;
    }
    let squares = count * (count * count - 1.0) / 12.0;
    sum / count - middle * moment / squares
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(order: usize, cutoff_hz: f64) -> Result<ZeroPhase, SeriesError> {
        let rate = SampleRate::new(5000.0).unwrap();
        ZeroPhase::high_pass(
            HighPass {
                order,
                cutoff_hz: Hertz(cutoff_hz),
            },
            rate,
        )
    }

    /// A tone far above passes, the gesture goes, and the tone at the cut-off is halved by the two passes.
    #[test]
    fn tones_are_weighed_by_the_squared_response() {
        let plan = plan(4, 5.0).unwrap();
        for (tone_hz, gain) in [(50.0, 1.0), (5.0, 0.5), (1.0, 0.0)] {
            let tone: Vec<f64> = (0..50_000)
                .map(|i| (i as f64 / 5000.0 * tone_hz * std::f64::consts::TAU).sin() + 3.0)
                .collect();
            let filtered = plan.apply(&tone);
            let inner = &filtered[15_000..35_000];
            let rms = (inner.iter().map(|v| v * v).sum::<f64>() / inner.len() as f64).sqrt();
            let expected: f64 = gain / 2f64.sqrt();
            assert!((rms - expected).abs() < 0.002, "{tone_hz} Hz: {rms}");
        }
    }

    /// A signal that begins and ends in the middle of its vibration: reflected about its last sample, it came back with up to 6 % more rms.
    #[test]
    fn ends_of_a_signal_add_nothing() {
        let plan = plan(4, 5.0).unwrap();
        for start in 0..12 {
            let turn = f64::from(start) / 12.0;
            let signal: Vec<f64> = (0..4000)
                .map(|i| {
                    let t = f64::from(i) / 5000.0;
                    let tone = |hz: f64| (std::f64::consts::TAU * (hz * t + turn)).cos();
                    tone(60.0) + 0.7 * tone(171.0)
                })
                .collect();
            let rms = |x: &[f64]| (x.iter().map(|v| v * v).sum::<f64>() / x.len() as f64).sqrt();
            let share = rms(&plan.apply(&signal)) / rms(&signal);
            assert!((share - 1.0).abs() < 5e-3, "{start}: {share}");
            // A gesture ten times as strong has to go.
            let moved: Vec<f64> = signal
                .iter()
                .enumerate()
                .map(|(i, v)| {
                    let t = i as f64 / 5000.0;
                    v + 9.81 + 10.0 * (std::f64::consts::TAU * (1.2 * t + turn)).sin()
                })
                .collect();
            let share = rms(&plan.apply(&moved)) / rms(&signal);
            assert!(
                (share - 1.0).abs() < 5e-3,
                "{start} with a gesture: {share}"
            );
        }
    }

    #[test]
    fn what_cannot_be_is_refused_and_short_signals_lose_their_mean() {
        assert!(plan(3, 5.0).is_err() && plan(0, 5.0).is_err());
        assert!(plan(4, 2500.0).is_err() && plan(4, 0.0).is_err() && plan(4, f64::NAN).is_err());
        let plan = plan(4, 5.0).unwrap();
        assert_eq!(plan.apply(&[1.0, 3.0]), [-1.0, 1.0]);
        assert!(plan.apply(&[]).is_empty());
    }
}
