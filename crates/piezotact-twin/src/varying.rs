//! The response of a load-dependent linear system while the load drifts.

use std::collections::BTreeMap;
use std::sync::Arc;

use num_complex::Complex;
use piezotact::spectrum::{Symmetry, Window};
use piezotact_fourier::{ComplexToReal, RealPlanner, RealToComplex};

use super::RATE_HZ;

/// A linear system whose response depends on the load.
pub(super) trait LoadDependent {
    /// The response at `frequency_hz` under `load_n`.
    fn at(&self, frequency_hz: f64, load_n: f64) -> Complex<f64>;
}

/// The answer to an input while the load drifts: frames of 0.2 s, half overlapping, each through the transfer
/// function that holds at its load. With a constant load this is the exact linear response. The input is fed as it
/// arrives and discarded after its response was computed.
pub(super) struct VaryingResponse<R> {
    response: R,
    window: Vec<f64>,
    forward: Arc<dyn RealToComplex<f64>>,
    inverse: Arc<dyn ComplexToReal<f64>>,
    /// Transfer functions by load, in steps of [`Self::LOAD_STEP_N`].
    known: BTreeMap<i64, Vec<Complex<f64>>>,
    /// Input and load, from input sample `forgotten` on.
    input: Vec<f64>,
    load_n: Vec<f64>,
    forgotten: usize,
    last_load_n: f64,
    next_frame: isize,
    /// Sums of frames, from output sample `emitted` on.
    pending: Vec<f64>,
    emitted: usize,
    buffer: Vec<f64>,
    bins: Vec<Complex<f64>>,
}

impl<R: LoadDependent> VaryingResponse<R> {
    /// Before output sample n is taken, the input up to n + `LOOKAHEAD` must have been fed, or there is none.
    pub(super) const LOOKAHEAD: usize = Self::EARLY + Self::FRAME;
    const FRAME: usize = 1024;
    const HOP: usize = Self::FRAME / 2;
    const LENGTH: usize = 4096;
    /// Zero padding in front of a frame for the acausal part of the response to the smooth ripple.
    const EARLY: usize = 1024;
    const LOAD_STEP_N: f64 = 0.002;

    pub(super) fn new(response: R) -> Self {
        let mut planner = RealPlanner::new();
        let forward = planner.plan_fft_forward(Self::LENGTH);
        Self {
            response,
            window: Window::Hann.coefficients(Self::FRAME, Symmetry::Periodic),
            inverse: planner.plan_fft_inverse(Self::LENGTH),
            bins: forward.make_output_vec(),
            forward,
            known: BTreeMap::new(),
            input: Vec::new(),
            load_n: Vec::new(),
            forgotten: 0,
            last_load_n: 0.0,
            next_frame: -(Self::HOP as isize),
            pending: vec![0.0; Self::LENGTH],
            emitted: 0,
            buffer: vec![0.0; Self::LENGTH],
        }
    }

    /// More input, and the load in N at each of its samples.
    pub(super) fn feed(&mut self, input: &[f64], load_n: &[f64]) {
        self.input.extend_from_slice(input);
        self.load_n.extend_from_slice(load_n);
        self.last_load_n = load_n.last().copied().unwrap_or(self.last_load_n);
    }

    /// The next `count` samples of the answer. Where no input was fed it is taken as zero, under the last load.
    pub(super) fn take(&mut self, count: usize) -> Vec<f64> {
        let end = self.emitted + count;
        while self.next_frame < (end + Self::EARLY) as isize {
            self.add_frame();
        }
        let out = self.pending[..count].to_vec();
        self.pending.drain(..count);
        self.emitted = end;
        let answered = usize::try_from(self.next_frame).unwrap_or(0);
        let forget = answered
            .saturating_sub(self.forgotten)
            .min(self.input.len());
        self.input.drain(..forget);
        self.load_n.drain(..forget);
        self.forgotten += forget;
        out
    }

    fn add_frame(&mut self) {
        let start = self.next_frame;
        self.next_frame += Self::HOP as isize;
        let fed = |at: isize| usize::try_from(at - self.forgotten as isize).ok();
        self.buffer.fill(0.0);
        for (i, w) in self.window.iter().enumerate() {
            if let Some(v) = fed(start + i as isize).and_then(|at| self.input.get(at)) {
                self.buffer[Self::EARLY + i] = v * w;
            }
        }
        let middle = fed((start + Self::HOP as isize).max(0));
        let load_n = middle
            .and_then(|at| self.load_n.get(at))
            .unwrap_or(&self.last_load_n);
        let step = (load_n / Self::LOAD_STEP_N).round() as i64;
        let at_load = &self.response;
        let response = self.known.entry(step).or_insert_with(|| {
            let load_n = step as f64 * Self::LOAD_STEP_N;
            (0..=Self::LENGTH / 2)
                .map(|k| {
                    let frequency_hz = k as f64 * RATE_HZ / Self::LENGTH as f64;
                    at_load.at(frequency_hz, load_n)
                })
                .collect()
        });
        let done = self.forward.process(&mut self.buffer, &mut self.bins);
        debug_assert!(done.is_ok());
        for (bin, h) in self.bins.iter_mut().zip(response.iter()) {
            *bin *= h / Self::LENGTH as f64;
        }
        self.bins[0].im = 0.0;
        self.bins[Self::LENGTH / 2].im = 0.0;
        let done = self.inverse.process(&mut self.bins, &mut self.buffer);
        debug_assert!(done.is_ok());
        let first = start - Self::EARLY as isize - self.emitted as isize;
        let needed = usize::try_from(first + Self::LENGTH as isize).unwrap_or(0);
        if self.pending.len() < needed {
            self.pending.resize(needed, 0.0);
        }
        for (i, value) in self.buffer.iter().enumerate() {
            if let Ok(at) = usize::try_from(first + i as isize) {
                self.pending[at] += value;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;
    use crate::{Finger, Placement, TwinParameters};

    struct Nominal(Finger);

    fn nominal() -> Nominal {
        Nominal(Finger::nominal(&TwinParameters::built_in()))
    }

    impl LoadDependent for Nominal {
        fn at(&self, frequency_hz: f64, load_n: f64) -> Complex<f64> {
            self.0
                .response(frequency_hz, load_n, 20.0, &Placement::exact())
                * Complex::from_polar(1.0, -TAU * frequency_hz * 1.5e-3)
        }
    }

    /// With the force held exactly, a long tone is answered with the transfer function at its frequency.
    #[test]
    fn a_constant_force_is_a_linear_system() {
        let frequency_hz = 212.0;
        let voltage: Vec<f64> = (0..20_000)
            .map(|i| (TAU * frequency_hz * f64::from(i) / RATE_HZ).sin())
            .collect();
        let mut response = VaryingResponse::new(nominal());
        response.feed(&voltage, &[0.2; 20_000]);
        let mut y = Vec::new();
        for count in [700, 2500, 2500, 1, 9299] {
            y.extend(response.take(count));
        }
        let h = nominal().at(frequency_hz, 0.2);
        let worst = (5_000..15_000)
            .map(|i| {
                let phase = TAU * frequency_hz * i as f64 / RATE_HZ;
                (y[i] - (h * Complex::from_polar(1.0, phase)).im).abs()
            })
            .fold(0.0, f64::max);
        // The response is sampled at 1.2 Hz steps: what rings longer than 0.6 s would wrap.
        assert!(worst < 1e-3 * h.norm(), "{:e}", worst / h.norm());
    }

    /// What is fed in pieces, as late as is allowed, is answered bit by bit as what is fed at once.
    #[test]
    fn pieces_are_answered_as_the_whole() {
        let input: Vec<f64> = (0..9_000).map(|i| f64::from(i % 37) - 18.0).collect();
        let load_n: Vec<f64> = (0..9_000).map(|i| 0.2 + 1e-5 * f64::from(i)).collect();
        let mut whole = VaryingResponse::new(nominal());
        whole.feed(&input, &load_n);
        let whole = whole.take(9_000);
        let mut pieces = VaryingResponse::new(nominal());
        let (mut fed, mut answer) = (0, Vec::new());
        for count in [1, 999, 2500, 13, 5487] {
            let until =
                (answer.len() + count + VaryingResponse::<Nominal>::LOOKAHEAD).min(input.len());
            pieces.feed(&input[fed..until], &load_n[fed..until]);
            fed = until;
            answer.extend(pieces.take(count));
        }
        assert!(answer == whole);
    }
}
