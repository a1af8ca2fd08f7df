//! Zero-phase filters of finite length, as MNE-Python designs them by default.

use crate::eeg::epochs::EpochsError;
use std::f64::consts::PI;
use std::fmt;

use piezotact::Warning;
use piezotact::fourier::{Complex, RealPlanner};
use piezotact::number::rounded;
use piezotact::quantity::SampleRate;
use serde::{Deserialize, Serialize};

use super::{EegWarning, Smeared};

/// Length of a Hamming-windowed filter, in periods of its transition bandwidth.
const HAMMING: f64 = 3.3;
/// The transition bandwidth of a notch, Hz, both sides together.
const NOTCH_TRANSITION_HZ: f64 = 1.0;
/// The longest filter, samples.
const LONGEST: usize = 10_000_000;
/// A notch is its frequency divided by this wide.
const NOTCH_QUALITY: f64 = 200.0;

/// What a filter passes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Pass {
    /// Frequencies above this one, Hz.
    Above(f64),
    /// Frequencies below this one, Hz.
    Below(f64),
    /// Frequencies between these two, Hz.
    Between(f64, f64),
    /// All but these, such as the mains and its harmonics, Hz; each notch is 1/200 of its frequency wide.
    AllBut(Vec<f64>),
}

impl fmt::Display for Pass {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let hz = |hz: &f64| rounded(*hz);
        match self {
            Self::Above(low) => write!(f, "High-pass at {} Hz, zero phase", hz(low)),
            Self::Below(high) => write!(f, "Low-pass at {} Hz, zero phase", hz(high)),
            Self::Between(low, high) => {
                write!(f, "Band-pass {} to {} Hz, zero phase", hz(low), hz(high))
            }
            Self::AllBut(notches) => {
                let notches: Vec<String> = notches.iter().map(hz).collect();
                write!(f, "Notches at {} Hz, zero phase", notches.join(", "))
            }
        }
    }
}

/// A planned filter: a symmetric impulse response of odd length.
#[derive(Clone, Debug, PartialEq)]
pub struct Fir {
    pass: Pass,
    rate: SampleRate,
    taps: Vec<f64>,
}

/// Where the gain changes: a transition from `low_hz` to `high_hz`.
#[derive(Clone, Copy, Debug)]
struct Edge {
    low_hz: f64,
    high_hz: f64,
    rises: bool,
}

impl Fir {
    /// A plan of a filter for signals at `rate`. Edges of the pass band are as stated; the gain is one half in the middle of each
    /// transition, which lies outside the pass band.
    ///
    /// Formula: each edge is a Hamming-windowed sinc of 3.3/transition length. Transitions are min(max(f/4, 2 Hz), f) below a high-pass
    /// edge and min(max(f/4, 2 Hz), rate/2 − f) above a low-pass edge, and 0.5 Hz on either side of a notch.
    ///
    /// Source: MNE-Python's `create_filter` and `notch_filter` with their defaults (`firwin`, Hamming, `auto`); A. Widmann, E. Schröger and
    /// B. Maess (2015), J. Neurosci. Methods 250.
    ///
    /// # Errors
    /// [`EpochsError`] for an edge outside 0 to half the rate, a band that is not ascending, notches that overlap, or an
    /// edge so near to an end of the band that the filter would be too long.
    pub fn plan(pass: &Pass, rate: SampleRate) -> Result<Self, EpochsError> {
        let edges = edges_of(pass, rate)?;
        let narrowest = edges
            .iter()
            .map(|edge| edge.high_hz - edge.low_hz)
            .fold(f64::INFINITY, f64::min);
        let periods = HAMMING / widths(pass, rate, narrowest);
        if periods * rate.hz() > LONGEST as f64 {
            return Err(EpochsError::TooLong { length_s: periods });
        }
        let length = odd((periods * rate.hz()).ceil() as usize);
        let mut taps = vec![0.0; length];
        let passes_highest = edges.last().is_some_and(|edge| edge.rises);
        if passes_highest {
            taps[length / 2] = 1.0;
        }
        for edge in edges.iter().rev() {
            let width = (edge.high_hz - edge.low_hz) / rate.hz();
            let own = odd((HAMMING / width).round_ties_even() as usize).min(length);
            let offset = (length - own) / 2;
            let cutoff = (edge.low_hz + edge.high_hz) / rate.hz();
            // Going down in frequency, a rising edge takes away what is below it.
            let sign = if edge.rises { -1.0 } else { 1.0 };
            for (tap, value) in taps[offset..].iter_mut().zip(low_pass(own, cutoff)) {
                *tap += sign * value;
            }
        }
        Ok(Self {
            pass: pass.clone(),
            rate,
            taps,
        })
    }

    /// What it passes.
    #[must_use]
    pub fn pass(&self) -> &Pass {
        &self.pass
    }

    /// The impulse response, of odd length and symmetric about its middle; no unit.
    #[must_use]
    pub fn taps(&self) -> &[f64] {
        &self.taps
    }

    /// Its length, s.
    #[must_use]
    pub fn length_s(&self) -> f64 {
        self.taps.len() as f64 / self.rate.hz()
    }

    /// The gain at `frequency_hz`: negative where the phase is turned by 180°.
    #[must_use]
    pub fn gain(&self, frequency_hz: f64) -> f64 {
        let middle = (self.taps.len() / 2) as f64;
        let turn = 2.0 * PI * frequency_hz / self.rate.hz();
        self.taps
            .iter()
            .enumerate()
            .map(|(i, tap)| tap * (turn * (i as f64 - middle)).cos())
            .sum()
    }

    /// `signal` filtered without delay, of the same length and unit. The ends are continued for the length of the filter, or of the
    /// signal where that is shorter, by point reflection about the first and the last sample; zeros beyond.
    #[must_use]
    pub fn apply(&self, signal: &[f64]) -> Vec<f64> {
        let mut filtered = vec![0.0; signal.len()];
        self.with_plan(signal.len(), |run| run(signal, &mut filtered));
        filtered
    }

    /// What to know of the filter on a signal of `samples`.
    #[must_use]
    pub fn warnings(&self, samples: usize) -> Vec<Warning> {
        if samples >= self.taps.len() {
            return Vec::new();
        }
        vec![
            EegWarning::Smeared {
                by: Smeared::LongFilter {
                    filter_s: self.length_s(),
                    signal_s: samples as f64 / self.rate.hz(),
                },
            }
            .into(),
        ]
    }

    /// Calls `use_of` with a function that filters signals of `samples` into a buffer of as many: transforms are planned once.
    fn with_plan(&self, samples: usize, use_of: impl FnOnce(&mut dyn FnMut(&[f64], &mut [f64]))) {
        let taps = self.taps.len();
        if samples == 0 {
            return;
        }
        let edge = taps.min(samples) - 1;
        let extended = samples + 2 * edge;
        // Blocks of four times the filter (overlap-save), or all at once.
        let block = (4 * taps).max(1024).min(extended + taps - 1);
        let block = block.next_power_of_two();
        let step = block - taps + 1;
        let mut planner = RealPlanner::new();
        let forward = planner.plan_fft_forward(block);
        let inverse = planner.plan_fft_inverse(block);
        let mut input = forward.make_input_vec();
        let mut bins = forward.make_output_vec();
        let mut scratch = forward.make_scratch_vec();
        scratch.resize(
            scratch.len().max(inverse.get_scratch_len()),
            Complex::default(),
        );
        let mut response = forward.make_output_vec();
        input[..taps].copy_from_slice(&self.taps);
        // The only error is a wrong length, and every buffer has the plan's.
        let done = forward.process_with_scratch(&mut input, &mut response, &mut scratch);
        debug_assert!(done.is_ok());
        for value in &mut response {
            *value /= block as f64;
        }
        let mut line = vec![0.0; extended + 2 * taps + block];
        use_of(&mut |signal: &[f64], out: &mut [f64]| {
            line.fill(0.0);
            // taps − 1 zeros, then the signal with its ends continued.
            let start = taps - 1 + edge;
            let (first, last) = (signal[0], signal[samples - 1]);
            for i in 1..=edge {
                line[start - i] = 2.0 * first - signal[i];
                line[start + samples - 1 + i] = 2.0 * last - signal[samples - 1 - i];
            }
            line[start..start + samples].copy_from_slice(signal);
            // Output k of the convolution with the line is where the filter's middle is at k − taps/2.
            let mut written = 0;
            while written < samples {
                let from = edge + taps / 2 + written;
                input.copy_from_slice(&line[from..from + block]);
                let done = forward.process_with_scratch(&mut input, &mut bins, &mut scratch);
                debug_assert!(done.is_ok());
                for (bin, gain) in bins.iter_mut().zip(&response) {
                    *bin *= gain;
                }
                bins[0].im = 0.0;
                bins[block / 2].im = 0.0;
                let done = inverse.process_with_scratch(&mut bins, &mut input, &mut scratch);
                debug_assert!(done.is_ok());
                let count = step.min(samples - written);
                out[written..written + count].copy_from_slice(&input[taps - 1..taps - 1 + count]);
                written += count;
            }
        });
    }
}

fn odd(length: usize) -> usize {
    length + 1 - length % 2
}

/// The bandwidth that sets the length: that which was asked for, as a difference of edges is rounded.
fn widths(pass: &Pass, rate: SampleRate, narrowest: f64) -> f64 {
    match pass {
        Pass::Above(low) => below(*low),
        Pass::Below(high) => above(*high, rate),
        Pass::Between(low, high) => below(*low).min(above(*high, rate)),
        Pass::AllBut(_) => narrowest.max(NOTCH_TRANSITION_HZ / 2.0),
    }
}

/// The transition below a high-pass edge, Hz.
fn below(low_hz: f64) -> f64 {
    (0.25 * low_hz).max(2.0).min(low_hz)
}

/// The transition above a low-pass edge, Hz.
fn above(high_hz: f64, rate: SampleRate) -> f64 {
    (0.25 * high_hz).max(2.0).min(rate.nyquist().0 - high_hz)
}

/// The edges in ascending order.
fn edges_of(pass: &Pass, rate: SampleRate) -> Result<Vec<Edge>, EpochsError> {
    let nyquist_hz = rate.nyquist().0;
    let inside = |found_hz: f64| {
        let is = found_hz > 0.0 && found_hz < nyquist_hz;
        is.then_some(found_hz).ok_or(EpochsError::Edge {
            found_hz,
            nyquist_hz,
        })
    };
    let rising = |low_hz: f64| Edge {
        low_hz: low_hz - below(low_hz),
        high_hz: low_hz,
        rises: true,
    };
    let falling = |high_hz: f64| Edge {
        low_hz: high_hz,
        high_hz: high_hz + above(high_hz, rate),
        rises: false,
    };
    Ok(match pass {
        Pass::Above(low) => vec![rising(inside(*low)?)],
        Pass::Below(high) => vec![falling(inside(*high)?)],
        Pass::Between(low, high) => {
            let (low_hz, high_hz) = (inside(*low)?, inside(*high)?);
            if low_hz >= high_hz {
                return Err(EpochsError::EdgeOrder { low_hz, high_hz });
            }
            vec![rising(low_hz), falling(high_hz)]
        }
        Pass::AllBut(notches) => {
            let mut sorted = notches.clone();
            sorted.sort_by(f64::total_cmp);
            let mut edges = Vec::with_capacity(2 * sorted.len());
            for &hz in &sorted {
                let half = hz / NOTCH_QUALITY / 2.0;
                let transition = NOTCH_TRANSITION_HZ / 2.0;
                edges.push(Edge {
                    low_hz: inside(hz - half - transition)?,
                    high_hz: hz - half,
                    rises: false,
                });
                edges.push(Edge {
                    low_hz: hz + half,
                    high_hz: inside(hz + half + transition)?,
                    rises: true,
                });
            }
            if edges.is_empty() {
                return Err(EpochsError::NoNotch);
            }
            if let Some(pair) = edges
                .windows(2)
                .find(|pair| pair[0].high_hz > pair[1].low_hz)
            {
                return Err(EpochsError::EdgeOrder {
                    low_hz: pair[0].high_hz,
                    high_hz: pair[1].low_hz,
                });
            }
            edges
        }
    })
}

/// A low-pass of `length` taps (odd) with a gain of 1 at 0 Hz; `cutoff` in units of half the rate.
fn low_pass(length: usize, cutoff: f64) -> Vec<f64> {
    let middle = (length / 2) as f64;
    let mut taps: Vec<f64> = (0..length)
        .map(|i| {
            let m = i as f64 - middle;
            let x = PI * cutoff * m;
            let sinc = if m == 0.0 { 1.0 } else { x.sin() / x };
            let turn = 2.0 * PI * i as f64 / (length.max(2) - 1) as f64;
            cutoff * sinc * (0.54 - 0.46 * turn.cos())
        })
        .collect();
    let sum: f64 = taps.iter().sum();
    for tap in &mut taps {
        *tap /= sum;
    }
    taps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gains_are_one_in_the_band_and_half_in_the_transition() {
        let rate = SampleRate::new(500.0).unwrap();
        let of = |pass| Fir::plan(&pass, rate).unwrap();
        let band = of(Pass::Between(8.0, 12.0));
        for (hz, gain) in [
            (10.0, 1.0),
            (7.0, 0.5),
            (13.5, 0.5),
            (3.0, 0.0),
            (20.0, 0.0),
        ] {
            // The Hamming window leaves 0.2 %.
            assert!(
                (band.gain(hz) - gain).abs() < 4e-3,
                "{hz}: {}",
                band.gain(hz)
            );
        }
        let notch = of(Pass::AllBut(vec![50.0, 100.0]));
        for (hz, gain) in [
            (0.0, 1.0),
            (45.0, 1.0),
            (50.0, 0.0),
            (75.0, 1.0),
            (100.0, 0.0),
        ] {
            assert!(
                (notch.gain(hz) - gain).abs() < 6e-3,
                "{hz}: {}",
                notch.gain(hz)
            );
        }
        assert!((of(Pass::Above(1.0)).gain(0.0)).abs() < 1e-12);
    }

    #[test]
    fn blocks_add_up_to_the_convolution() {
        let rate = SampleRate::new(100.0).unwrap();
        let fir = Fir::plan(&Pass::Below(10.0), rate).unwrap();
        let signal: Vec<f64> = (0..3000)
            .map(|i| (f64::from(i * i) * 0.01).sin() + 2.0)
            .collect();
        let got = fir.apply(&signal);
        let at = |i: isize| match i {
            i if i < 0 => 2.0 * signal[0] - signal[(-i) as usize],
            i if i >= 3000 => 2.0 * signal[2999] - signal[(2 * 2999 - i) as usize],
            i => signal[i as usize],
        };
        let half = (fir.taps().len() / 2) as isize;
        for t in [0isize, 1, 500, 871, 1500, 2998, 2999] {
            let sum: f64 = (-half..=half)
                .map(|k| fir.taps()[(k + half) as usize] * at(t - k))
                .sum();
            assert!((got[t as usize] - sum).abs() < 1e-12, "{t}");
        }
        assert!(fir.apply(&[]).is_empty());
        assert_eq!(fir.apply(&[2.0]).len(), 1);
        assert_eq!(fir.warnings(10).len(), 1);
    }

    #[test]
    fn what_cannot_be_is_refused() {
        let rate = SampleRate::new(100.0).unwrap();
        for pass in [
            Pass::Above(0.0),
            Pass::Above(1e-9),
            Pass::Below(50.0),
            Pass::Below(f64::NAN),
            Pass::Between(12.0, 8.0),
            Pass::AllBut(vec![]),
            Pass::AllBut(vec![20.0, 20.5]),
        ] {
            assert!(Fir::plan(&pass, rate).is_err(), "{pass:?}");
        }
    }
}
