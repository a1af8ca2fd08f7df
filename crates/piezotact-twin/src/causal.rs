//! The impulse response of a device with a finger on it, as a causal filter.
//!
//! The response of [`Finger`] is a product of two kinds of factors. Masses, springs, dampers and the low-pass answer after they are
//! excited. Coupling, level and ripples have a magnitude and no phase, so that half of what they answer comes before the drive: a ripple
//! at 30 Hz that changes within half an octave begins 0.1 s early. A bench that computes whole signals can do that, a stream cannot.
//!
//! What is done: everything comes later by a stated delay, and only what would be earlier than this delay allows is turned in
//! phase so that it comes as much later as it would have come earlier. The magnitude does not change; the phase changes where ripples
//! are narrow, at low frequencies. With 20 ms it is typically 2° at 20 to 40 Hz and 0.3° above 100 Hz (docs/decisions/sound.md).

use std::f64::consts::{PI, TAU};

use num_complex::Complex;
use piezotact::quantity::SampleRate;
use piezotact_fourier::RealPlanner;

use super::finger::{Finger, Placement};

/// Below this frequency, Hz, the factors without a phase are taken as at it: ripples become narrower in Hz the lower they are.
const HELD_BELOW_HZ: f64 = 15.0;
/// The grid of frequencies resolves responses of this length at least, s.
const GRID_S: f64 = 2.0;
/// The longest impulse response after the delay, s.
const LONGEST_S: f64 = 1.0;
/// The share of its energy at the end of an impulse response that is left out.
const LEFT_OUT: f64 = 1e-9;
/// From this share of half the rate on the response falls to nothing at half the rate.
const FADE_FROM: f64 = 0.85;

/// A device with a finger on it, held at one load, whose answer comes late enough to be causal.
#[derive(Debug)]
pub(crate) struct CausalDevice<'a> {
    pub(crate) finger: &'a Finger,
    pub(crate) placement: &'a Placement,
    pub(crate) angle_deg: f64,
    /// The delay from the drive to the answer, s.
    pub(crate) delay_s: f64,
    pub(crate) rate: SampleRate,
}

impl CausalDevice<'_> {
    /// The impulse response from the actuator's voltage to the nail's acceleration under `load_n`, (m/s²)/V a sample.
    pub(crate) fn impulse(&self, load_n: f64) -> Vec<f64> {
        let rate_hz = self.rate.hz();
        let length = ((GRID_S * rate_hz) as usize).next_power_of_two();
        let step_hz = rate_hz / length as f64;
        let mut planner = RealPlanner::new();
        let phaseless =
            |frequency_hz: f64| self.finger.phaseless(frequency_hz, load_n, self.placement);
        let held: Vec<f64> = (0..=length / 2)
            .map(|k| phaseless((k as f64 * step_hz).max(HELD_BELOW_HZ)))
            .collect();
        let reach = (self.delay_s * rate_hz) as usize;
        let mut bins = turned(&held, reach, &mut planner);
        for (k, (bin, held)) in bins.iter_mut().zip(&held).enumerate() {
            let frequency_hz = k as f64 * step_hz;
            let response =
                self.finger
                    .response(frequency_hz, load_n, self.angle_deg, self.placement);
            let share = k as f64 / (length / 2) as f64;
            let fade = match share > FADE_FROM {
                true => 0.5 + 0.5 * (PI * (share - FADE_FROM) / (1.0 - FADE_FROM)).cos(),
                false => 1.0,
            };
            *bin *= response
                * Complex::from_polar(
                    fade * held / phaseless(frequency_hz) / length as f64,
                    -TAU * frequency_hz * self.delay_s,
                );
        }
        let mut impulse = real(bins, &mut planner);
        impulse.truncate(reach + (LONGEST_S * rate_hz) as usize);
        let total: f64 = impulse.iter().map(|tap| tap * tap).sum();
        let mut rest = 0.0;
        let kept = impulse.iter().rposition(|tap| {
            rest += tap * tap;
            rest > LEFT_OUT * total
        });
        impulse.truncate(kept.map_or(1, |last| last + 1));
        impulse
    }
}

/// The factors of magnitude 1 that make a response of the magnitudes `held` answer at most `reach` samples early: what its cepstrum
/// holds before −`reach` moves to the other side of zero (the folding that gives a minimum phase when `reach` is 0).
///
/// Source: Oppenheim and Schafer, *Discrete-Time Signal Processing*, 3rd ed., section 13.5.
fn turned(held: &[f64], reach: usize, planner: &mut RealPlanner) -> Vec<Complex<f64>> {
    let length = 2 * (held.len() - 1);
    let logarithms = held.iter().map(|magnitude| magnitude.ln().into()).collect();
    let mut odd = real(logarithms, planner);
    for (i, value) in odd.iter_mut().enumerate() {
        let early = i > length / 2;
        let far = if early { length - i } else { i };
        *value *= match (far > reach && far < length / 2, early) {
            (false, _) => 0.0,
            (true, true) => -1.0 / length as f64,
            (true, false) => 1.0 / length as f64,
        };
    }
    let forward = planner.plan_fft_forward(length);
    let mut bins = forward.make_output_vec();
    let done = forward.process(&mut odd, &mut bins);
    debug_assert!(done.is_ok());
    for bin in &mut bins {
        *bin = Complex::from_polar(1.0, bin.im);
    }
    bins
}

/// The real signal of `bins`, times its length.
fn real(mut bins: Vec<Complex<f64>>, planner: &mut RealPlanner) -> Vec<f64> {
    let inverse = planner.plan_fft_inverse(2 * (bins.len() - 1));
    if let [first, .., last] = &mut bins[..] {
        (first.im, last.im) = (0.0, 0.0);
    }
    let mut signal = inverse.make_output_vec();
    let done = inverse.process(&mut bins, &mut signal);
    debug_assert!(done.is_ok());
    signal
}
