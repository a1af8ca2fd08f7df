//! The accelerometer on the fingernail, the force cell under the actuator, and the hand that presses.

use piezotact::series::{mean, standard_deviation};

use crate::random::Random;
use crate::traits::SensorCalibration;

/// What a calibration finds in what the channels read at rest: mean, and rms about it.
pub(super) fn at_rest(channels: &[Vec<f64>]) -> SensorCalibration {
    let of_all = |of: fn(&[f64]) -> f64| channels.iter().map(|x| of(x)).collect();
    SensorCalibration {
        offset: of_all(mean),
        noise_rms: of_all(standard_deviation),
    }
}

/// A PCB 352A24 on the nail: white noise of 2 mm/s² rms over the acquisition band (*data sheet*: broadband
/// resolution 2e-4 g) and flicker below about 10 Hz.
#[derive(Clone, Debug)]
pub(crate) struct Accelerometer {
    random: Random,
    flicker: f64,
}

impl Accelerometer {
    const WHITE_M_S2: f64 = 2e-3;
    /// Slow noise, rms (*chosen*: 80 µg/√Hz at 1 Hz).
    const FLICKER_M_S2: f64 = 1e-3;
    const FLICKER_CORNER_HZ: f64 = 2.0;

    pub(crate) fn new(random: Random) -> Self {
        Self {
            random,
            flicker: 0.0,
        }
    }

    /// What it reads, m/s², for the true acceleration.
    pub(crate) fn read(&mut self, acceleration_m_s2: f64, rate_hz: f64) -> f64 {
        let forget = (-std::f64::consts::TAU * Self::FLICKER_CORNER_HZ / rate_hz).exp();
        self.flicker = forget * self.flicker
            + Self::FLICKER_M_S2 * (1.0 - forget * forget).sqrt() * self.random.normal();
        acceleration_m_s2 + self.flicker + Self::WHITE_M_S2 * self.random.normal()
    }
}

/// A K3D60 force cell: 3 mN rms (*common knowledge*: 2–5 mN).
#[derive(Clone, Debug)]
pub(crate) struct ForceCell {
    random: Random,
}

impl ForceCell {
    const NOISE_N: f64 = 3e-3;

    pub(crate) fn new(random: Random) -> Self {
        Self { random }
    }

    /// What it reads, N, for the true force.
    pub(crate) fn read(&mut self, force_n: f64) -> f64 {
        force_n + Self::NOISE_N * self.random.normal()
    }
}

/// A person holding a force: an Ornstein–Uhlenbeck process of 0.03 N and 0.3 s around the load asked for
/// (*chosen* within the 0.03–0.06 N of free touch; on the device the person watches the force on a screen).
#[derive(Clone, Debug)]
pub(crate) struct HeldForce {
    random: Random,
    load_n: f64,
    departure_n: f64,
}

impl HeldForce {
    const SPREAD_N: f64 = 0.03;
    const MEMORY_S: f64 = 0.3;

    pub(crate) fn new(load_n: f64, mut random: Random) -> Self {
        let departure_n = Self::SPREAD_N * random.normal();
        Self {
            random,
            load_n,
            departure_n,
        }
    }

    /// The force now, N, and then `step_s` passes.
    pub(crate) fn next(&mut self, step_s: f64) -> f64 {
        let now = (self.load_n + self.departure_n).max(0.0);
        let forget = (-step_s / Self::MEMORY_S).exp();
        self.departure_n = forget * self.departure_n
            + Self::SPREAD_N * (1.0 - forget * forget).sqrt() * self.random.normal();
        now
    }
}

/// A hand that holds a force: [`HeldForce`] through the muscle, critically damped. The process alone falls with the
/// square of frequency and would shake the finger at 25 Hz, where no hand can.
#[derive(Clone, Debug)]
pub(crate) struct SlowHand {
    held: HeldForce,
    corner_hz: f64,
    stages_n: Option<[f64; 2]>,
}

impl SlowHand {
    pub(crate) fn new(load_n: f64, corner_hz: f64, random: Random) -> Self {
        Self {
            held: HeldForce::new(load_n, random),
            corner_hz,
            stages_n: None,
        }
    }

    /// The force now, N, and then `step_s` passes.
    pub(crate) fn next(&mut self, step_s: f64) -> f64 {
        let wanted_n = self.held.next(step_s);
        let [first_n, second_n] = self.stages_n.get_or_insert([wanted_n; 2]);
        let follow = 1.0 - (-std::f64::consts::TAU * self.corner_hz * step_s).exp();
        *first_n += follow * (wanted_n - *first_n);
        *second_n += follow * (*first_n - *second_n);
        *second_n
    }
}

/// A charge cell that a finger warms: the reading drifts towards `drift_n` with the time constant `drift_s`.
#[derive(Clone, Debug)]
pub(crate) struct ChargeCell {
    random: Random,
    noise_n: f64,
    drift_n: f64,
    drift_s: f64,
}

impl ChargeCell {
    pub(crate) fn new(noise_n: f64, drift_n: f64, drift_s: f64, random: Random) -> Self {
        Self {
            random,
            noise_n,
            drift_n,
            drift_s,
        }
    }

    /// What warmth has added to the reading `after_s` from the first touch, N.
    pub(crate) fn warmth_n(&self, after_s: f64) -> f64 {
        self.drift_n * -(-after_s / self.drift_s).exp_m1()
    }

    /// What it reads, N, for the true force `after_s` from the first touch.
    pub(crate) fn read(&mut self, force_n: f64, after_s: f64) -> f64 {
        force_n + self.warmth_n(after_s) + self.noise_n * self.random.normal()
    }
}
