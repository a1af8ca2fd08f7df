//! The actuator with a finger on it: how the fingernail's acceleration answers the actuator's voltage.
//!
//! Four lumped elements (pulp, phalanx with the accelerometer, resting hand, nail bed) on a membrane. The
//! structure follows multi-degree-of-freedom finger models in the literature (Wiertlewski and Hayward 2012,
//! Knez 2017); the values are *chosen* so that bundles over participants, loads and angles come out as in the
//! thesis' chapter 5.

use std::f64::consts::TAU;

use num_complex::Complex;

use crate::random::Random;

type C = Complex<f64>;

/// The load at which the parameters are stated, N (*thesis*).
const REFERENCE_LOAD_N: f64 = 0.2;
/// Loads below this are a finger that hardly touches, N (*chosen*).
const LEAST_LOAD_N: f64 = 0.02;

/// How much each parameter differs from person to person: the standard deviation of its logarithm (*chosen*).
mod spread {
    pub(super) const PULP_STIFFNESS: f64 = 0.18;
    pub(super) const PULP_DAMPING: f64 = 0.15;
    pub(super) const PHALANX_MASS: f64 = 0.06;
    pub(super) const JOINT_STIFFNESS: f64 = 0.14;
    pub(super) const JOINT_DAMPING: f64 = 0.12;
    pub(super) const HAND_MASS: f64 = 0.14;
    pub(super) const NAIL_STIFFNESS: f64 = 0.10;
    pub(super) const GAIN: f64 = 0.11;
    /// dB.
    pub(super) const RIPPLE_DB: f64 = 0.50;
}

/// One person's finger: how it departs from the nominal one, in standard deviations.
#[derive(Clone, Debug)]
pub struct Finger {
    pulp_stiffness: f64,
    pulp_damping: f64,
    phalanx_mass: f64,
    joint_stiffness: f64,
    joint_damping: f64,
    hand_mass: f64,
    nail_stiffness: f64,
    gain: f64,
    /// How mass and stiffness change at 40° (*chosen*: 6 % and 10 % per standard deviation).
    angle_mass: f64,
    angle_stiffness: f64,
    ripple: Ripple,
}

impl Finger {
    /// The nominal finger, without any person's departure.
    #[must_use]
    pub fn nominal() -> Self {
        Self {
            pulp_stiffness: 0.0,
            pulp_damping: 0.0,
            phalanx_mass: 0.0,
            joint_stiffness: 0.0,
            joint_damping: 0.0,
            hand_mass: 0.0,
            nail_stiffness: 0.0,
            gain: 0.0,
            angle_mass: 0.0,
            angle_stiffness: 0.0,
            ripple: Ripple::none(),
        }
    }

    /// The finger of participant `participant` under `seed`; the nominal one for 0.
    #[must_use]
    pub fn of(participant: u64, seed: u64) -> Self {
        if participant == 0 {
            return Self::nominal();
        }
        let mut random = Random::stream(seed, participant, "finger");
        Self {
            pulp_stiffness: random.person(),
            pulp_damping: random.person(),
            phalanx_mass: random.person(),
            joint_stiffness: random.person(),
            joint_damping: random.person(),
            hand_mass: random.person(),
            nail_stiffness: random.person(),
            gain: random.person(),
            angle_mass: random.person(),
            angle_stiffness: random.person(),
            ripple: Ripple::draw(&mut random),
        }
    }

    /// The fingernail's acceleration per volt at the actuator, (m/s²)/V, at `frequency_hz`, with the finger
    /// pressed by `load_n` at `angle_deg`, placed as `placement` says.
    ///
    /// Formula: lp(5 kHz) · s²/D1 · Tn · κ · Zl·ka·d/(Za + Zl), the pulp Zp = k + cs in series with the
    /// phalanx' dynamic stiffness D1, on the membrane Za.
    #[must_use]
    pub fn response(
        &self,
        frequency_hz: f64,
        load_n: f64,
        angle_deg: f64,
        placement: &Placement,
    ) -> C {
        let load_n = load_n.max(LEAST_LOAD_N);
        let harder = load_n / REFERENCE_LOAD_N;
        // People differ less the harder they press.
        let narrower = harder.powf(-0.6);
        let person = |spread: f64, z: f64| (spread * z).exp();
        let tilt = ((angle_deg - 20.0) / 20.0).clamp(-1.0, 2.0);
        let s = C::new(0.0, TAU * frequency_hz);

        let pulp_k = 1100.0
            * harder.powf(0.35)
            * person(spread::PULP_STIFFNESS * narrower, self.pulp_stiffness)
            * (1.0 + 0.10 * self.angle_stiffness * tilt);
        let pulp_c =
            1.6 * harder.powf(0.35) * person(spread::PULP_DAMPING * narrower, self.pulp_damping);
        let pulp = pulp_k + pulp_c * s;

        let phalanx_kg = 7.5e-3
            * person(spread::PHALANX_MASS, self.phalanx_mass)
            * (1.0 + 0.06 * self.angle_mass * tilt);
        let joint = 350.0 * person(spread::JOINT_STIFFNESS, self.joint_stiffness)
            + 1.6 * person(spread::JOINT_DAMPING, self.joint_damping) * s;
        let hand_kg = 40e-3 * person(spread::HAND_MASS, self.hand_mass);
        let hand = hand_kg * s * s + 8.0 * s + 800.0;
        let arm = joint * hand / (joint + hand);

        let (nail_kg, nail_c) = (1.2e-3, 7.0);
        let nail_k = 8e4 * person(spread::NAIL_STIFFNESS, self.nail_stiffness);
        let nail = (nail_k + nail_c * s) / (nail_k + nail_c * s + nail_kg * s * s);
        let phalanx = phalanx_kg * s * s + arm + nail_kg * s * s * nail;

        // The contact area grows with load and couples more of the membrane's motion.
        let coupling = 0.70 + 0.30 * (load_n / 0.45).tanh();
        let finger = pulp * phalanx / (pulp + phalanx);
        // The membrane: stiffness N/m, damping, mass, and free displacement per volt.
        let (membrane_k, metres_per_volt) = (2500.0, 0.65e-6);
        let membrane = membrane_k + 0.35 * s + 0.12e-3 * s * s;
        let low_pass = 1.0 / (1.0 + s / (TAU * 5000.0));

        let ripple_db = spread::RIPPLE_DB * narrower * self.ripple.at(frequency_hz)
            + placement.level_db(frequency_hz);
        let gain = person(spread::GAIN * narrower, self.gain) * 10f64.powf(ripple_db / 20.0);
        low_pass * s * s / phalanx * nail * coupling * finger * membrane_k * metres_per_volt
            / (membrane + finger)
            * gain
    }
}

/// How a finger happens to lie this time. Taking it off and putting it back draws another one.
#[derive(Clone, Debug)]
pub struct Placement {
    gain_db: f64,
    ripple: Ripple,
}

impl Placement {
    /// Standard deviation of the level of a placement, dB (*chosen*: two placements then differ by 0.2 dB).
    const GAIN_DB: f64 = 0.15;
    /// Standard deviation of its shape, dB (*chosen*: likewise).
    const RIPPLE_DB: f64 = 0.15;

    /// The same placement as ever.
    #[must_use]
    pub fn exact() -> Self {
        Self {
            gain_db: 0.0,
            ripple: Ripple::none(),
        }
    }

    /// The placement that participant `participant` finds in the run `label` under `seed`.
    #[must_use]
    pub fn of(participant: u64, seed: u64, label: &str) -> Self {
        let mut random = Random::stream(seed, participant, &format!("placement {label}"));
        Self {
            gain_db: Self::GAIN_DB * random.person(),
            ripple: Ripple::draw(&mut random),
        }
    }

    fn level_db(&self, frequency_hz: f64) -> f64 {
        self.gain_db + Self::RIPPLE_DB * self.ripple.at(frequency_hz)
    }
}

/// A smooth random function of the logarithm of frequency, of variance 1: a Gaussian process of correlation
/// length 0.45 octaves, by random Fourier features (Rahimi and Recht 2007).
#[derive(Clone, Debug)]
struct Ripple {
    waves: Vec<(f64, f64)>,
}

impl Ripple {
    const OCTAVES: f64 = 0.45;
    const WAVES: usize = 64;

    fn none() -> Self {
        Self { waves: Vec::new() }
    }

    fn draw(random: &mut Random) -> Self {
        let waves = (0..Self::WAVES)
            .map(|_| (random.normal() / Self::OCTAVES, TAU * random.uniform()))
            .collect();
        Self { waves }
    }

    fn at(&self, frequency_hz: f64) -> f64 {
        if self.waves.is_empty() {
            return 0.0;
        }
        let octave = frequency_hz.max(1.0).log2();
        let sum: f64 = self
            .waves
            .iter()
            .map(|(rate, phase)| (rate * octave + phase).cos())
            .sum();
        sum * (2.0 / self.waves.len() as f64).sqrt()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::twin::{OutputStage, TwinParameters};
    use piezotact::device::AmplifierGain;

    /// The nominal device with the finger, from the amplifier's input, dB re (m/s²)/V at 0.2, 0.4 and 0.6 N:
    /// values of an independent prototype of the same model in NumPy, stated to 0.1 dB.
    const GOLDEN: [(f64, [f64; 3]); 7] = [
        (20.0, [-5.1, -4.0, -3.4]),
        (50.0, [13.0, 14.6, 15.3]),
        (100.0, [16.1, 18.6, 20.0]),
        (200.0, [17.7, 19.7, 20.7]),
        (300.0, [19.3, 20.9, 21.8]),
        (500.0, [21.2, 22.5, 23.1]),
        (1000.0, [24.0, 25.3, 25.9]),
    ];

    #[test]
    fn the_nominal_device_has_the_prototype_s_magnitudes() {
        let finger = Finger::nominal();
        let output = OutputStage::new(&TwinParameters::built_in().output, AmplifierGain::B3);
        for (frequency_hz, levels_db) in GOLDEN {
            for (load_n, expected_db) in [0.2, 0.4, 0.6].into_iter().zip(levels_db) {
                let h = finger.response(frequency_hz, load_n, 20.0, &Placement::exact())
                    * output.high_pass(frequency_hz)
                    * AmplifierGain::B3.voltage_ratio();
                let found_db = 20.0 * h.norm().log10();
                assert!(
                    (found_db - expected_db).abs() < 0.06,
                    "{frequency_hz} Hz, {load_n} N: {found_db:.2}"
                );
            }
        }
    }

    #[test]
    fn people_differ_and_a_person_stays_the_same() {
        let at = |participant| {
            Finger::of(participant, 5)
                .response(200.0, 0.2, 20.0, &Placement::exact())
                .norm()
        };
        assert_eq!(at(1), at(1));
        assert!((at(1) / at(2) - 1.0).abs() > 1e-3);
    }
}
