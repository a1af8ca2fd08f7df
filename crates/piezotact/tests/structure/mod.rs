//! The structure of six degrees of freedom of `golden/impact.py`, its motion under half-sine hits, and its noise.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::f64::consts::{PI, TAU};

use num_complex::Complex;
use piezotact::quantity::{Acceleration, Force, SampleRate};
use piezotact::series::Series;
use piezotact::transfer::{
    Estimator, ImpactConfig, ImpactEstimate, Known, TransferError, estimate_impacts,
};
use serde::Deserialize;

#[derive(Deserialize)]
pub(crate) struct Golden {
    pub(crate) rate_hz: f64,
    /// Natural frequency in Hz, damping ratio, modal constant in 1/kg.
    pub(crate) modes: Vec<(f64, f64, f64)>,
    /// Onset in s, duration in s, peak in N.
    pub(crate) hits: Vec<Pulse>,
    pub(crate) seconds: f64,
    pub(crate) noise: NoiseLevels,
    pub(crate) single_noise: NoiseLevels,
    pub(crate) segment: usize,
    pub(crate) short_segment: usize,
    pub(crate) damping_per_s: f64,
    pub(crate) clean_force: Vec<f64>,
    pub(crate) clean_response: Vec<f64>,
    pub(crate) noisy_force_sum: f64,
    pub(crate) rectangular: Lines,
    pub(crate) exponential: Lines,
}

pub(crate) type Pulse = (f64, f64, f64);

#[derive(Clone, Copy, Deserialize)]
pub(crate) struct NoiseLevels {
    pub(crate) force_n: f64,
    pub(crate) response_m_per_s2: f64,
}

#[derive(Deserialize)]
pub(crate) struct Lines {
    pub(crate) hz: Vec<f64>,
    pub(crate) real: Vec<f64>,
    pub(crate) imaginary: Vec<f64>,
    #[serde(default)]
    pub(crate) coherence: Vec<f64>,
    pub(crate) true_real: Vec<f64>,
    pub(crate) true_imaginary: Vec<f64>,
}

impl Lines {
    pub(crate) fn found(&self, k: usize) -> Complex<f64> {
        Complex::new(self.real[k], self.imaginary[k])
    }

    pub(crate) fn truth(&self, k: usize) -> Complex<f64> {
        Complex::new(self.true_real[k], self.true_imaginary[k])
    }
}

pub(crate) fn golden() -> Golden {
    serde_json::from_str(include_str!("../golden/impact.json")).unwrap()
}

/// The generator of the golden script.
pub(crate) struct Noise(pub(crate) u64);

impl Noise {
    pub(crate) fn uniform(&mut self) -> f64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 * 2f64.powi(-53)
    }

    pub(crate) fn normal(&mut self) -> f64 {
        let sum: f64 = (0..4).map(|_| self.uniform()).sum();
        (sum - 2.0) * 3f64.sqrt()
    }
}

/// Force and acceleration, sample by sample.
#[derive(Clone)]
pub(crate) struct Recorded {
    pub(crate) rate_hz: f64,
    pub(crate) force: Vec<f64>,
    pub(crate) response: Vec<f64>,
}

impl Recorded {
    /// The structure under half-sine pulses, in closed form: q'' + 2ζωq' + ω²q = F of every mode.
    pub(crate) fn of(golden: &Golden, hits: &[Pulse], seconds: f64) -> Self {
        let rate_hz = golden.rate_hz;
        let count = (seconds * rate_hz).round() as usize;
        let mut all = Self {
            rate_hz,
            force: vec![0.0; count],
            response: vec![0.0; count],
        };
        for (onset, duration, peak) in hits.iter().copied() {
            let turn = PI / duration;
            let first = (onset * rate_hz).ceil() as usize;
            let within = ((onset + duration) * rate_hz).ceil() as usize;
            for (i, force) in all.force.iter_mut().enumerate().take(within).skip(first) {
                *force += peak * (turn * (i as f64 / rate_hz - onset)).sin();
            }
            for (hz, damping_ratio, constant) in golden.modes.iter().copied() {
                let omega = TAU * hz;
                let delta = damping_ratio * omega;
                let pole =
                    Complex::new(-delta, omega * (1.0 - damping_ratio * damping_ratio).sqrt());
                let gain = 1.0 / Complex::new(omega * omega - turn * turn, 2.0 * delta * turn);
                // q = Im(G·e^{jΩt})·P + Re(c·e^{pt}) from rest.
                let forced = |t: f64, order: i32| {
                    let value = gain * Complex::from_polar(peak, turn * t);
                    (value * Complex::new(0.0, turn).powi(order)).im
                };
                let free = |at: f64, speed: f64| {
                    // Re(c) = at, Re(c·p) = speed.
                    Complex::new(at, (pole.re * at - speed) / pole.im)
                };
                let before = free(-forced(0.0, 0), -forced(0.0, 1));
                let end = pole * duration;
                let at_end = forced(duration, 0) + (before * end.exp()).re;
                let speed_at_end = forced(duration, 1) + (before * pole * end.exp()).re;
                let after = free(at_end, speed_at_end) * pole * pole;
                for i in first..within.min(count) {
                    let t = i as f64 / rate_hz - onset;
                    let free = (before * pole * pole * (pole * t).exp()).re;
                    all.response[i] += constant * (forced(t, 2) + free);
                }
                let mut value = after * (pole * (within as f64 / rate_hz - onset - duration)).exp();
                let step = (pole / rate_hz).exp();
                for response in all.response.iter_mut().skip(within) {
                    *response += constant * value.re;
                    value *= step;
                }
            }
        }
        all
    }

    pub(crate) fn noisy(mut self, levels: NoiseLevels, noise: &mut Noise) -> Self {
        for (force, response) in self.force.iter_mut().zip(&mut self.response) {
            *force += levels.force_n * noise.normal();
            *response += levels.response_m_per_s2 * noise.normal();
        }
        self
    }

    pub(crate) fn rate(&self) -> SampleRate {
        SampleRate::new(self.rate_hz).unwrap()
    }

    pub(crate) fn series(&self) -> (Series<Force>, Series<Acceleration>) {
        (
            Series::new(self.force.clone(), self.rate()).unwrap(),
            Series::new(self.response.clone(), self.rate()).unwrap(),
        )
    }

    pub(crate) fn evaluated(
        &self,
        config: &ImpactConfig,
    ) -> Result<ImpactEstimate<Force, Acceleration>, TransferError> {
        let (force, response) = self.series();
        estimate_impacts(&force, &response, config, Estimator::H1, Known::default())
    }
}

pub(crate) fn db(found: Complex<f64>, expected: Complex<f64>) -> f64 {
    20.0 * (found / expected).norm().log10()
}

/// The analytic inertance at s.
pub(crate) fn inertance(golden: &Golden, s: Complex<f64>) -> Complex<f64> {
    let modes = golden.modes.iter();
    modes
        .map(|(hz, damping_ratio, constant)| {
            let omega = TAU * hz;
            s * s * *constant / (s * s + s * (2.0 * damping_ratio * omega) + omega * omega)
        })
        .sum()
}
