//! A finger on the actuator or on a shaker's plate: the fingernail's acceleration in response to the actuator's
//! voltage, or to the force at the plate.
//!
//! Four lumped elements (pulp, phalanx with the accelerometer, resting hand, nail bed) on a membrane or a plate. The
//! structure follows multi-degree-of-freedom finger models in the literature (Wiertlewski and Hayward 2012,
//! Knez 2017); the values are *chosen* so that bundles over participants, loads and angles come out as in the
//! thesis' chapter 5.
//!
//! The contact couples the share κ = 1/(1 + ℓ) of the motion, with the loss ℓ = ℓ₀·e^(−F/F₀)·e^(σ·z + ρ·r(f)). People differ
//! in the loss (z is the person, r the person's own variation with frequency), so a firmer touch raises everybody's gain and
//! narrows the bundle at once: "Lower loads can increase the variability in the effective contact area as the fingertip is less
//! deformed" (*thesis* 5.1.1). That the contact area grows with force and saturates: E. R. Serina and others (1998),
//! J. Biomech. 31. The form and its four numbers are *chosen* (docs/decisions/twin.md).

use std::f64::consts::TAU;

use num_complex::Complex;

use super::parameters::{ActuatorParameters, FingerParameters, TwinParameters};
use piezotact_bench::random::Random;

type C = Complex<f64>;

/// The middle of the two angles of the thesis (5.1.2), 20° and 40°, and the step between them, degrees.
const MIDDLE_ANGLE_DEG: f64 = 30.0;
const ANGLE_STEP_DEG: f64 = 20.0;

/// One person's finger: its deviation from the nominal finger, in standard deviations.
#[derive(Clone, Debug)]
pub struct Finger {
    parameters: FingerParameters,
    actuator: ActuatorParameters,
    pulp_stiffness: f64,
    pulp_damping: f64,
    phalanx_mass: f64,
    joint_stiffness: f64,
    joint_damping: f64,
    hand_mass: f64,
    nail_stiffness: f64,
    /// The loss of coupling at the contact.
    contact_loss: f64,
    /// How mass and stiffness change with the angle.
    angle_mass: f64,
    angle_stiffness: f64,
    /// How the loss of coupling varies with frequency.
    contact_ripple: Ripple,
    skin_mass: f64,
    /// What does not depend on the contact: level and shape.
    gain: f64,
    shape: Ripple,
}

/// The finger's elements at one frequency and load.
struct Elements {
    s: C,
    /// Dynamic stiffness of the pulp Zp, N/m.
    pulp: C,
    /// Dynamic stiffness of the phalanx with nail, accelerometer, joint and hand D1, N/m.
    phalanx: C,
    /// From the phalanx' motion to the nail's, Tn.
    nail: C,
    /// The share of the motion coupled through the contact area, κ.
    coupling: f64,
}

impl Finger {
    /// The nominal finger, without any person's departure.
    #[must_use]
    pub fn nominal(parameters: &TwinParameters) -> Self {
        Self {
            parameters: parameters.finger.clone(),
            actuator: parameters.actuator.clone(),
            pulp_stiffness: 0.0,
            pulp_damping: 0.0,
            phalanx_mass: 0.0,
            joint_stiffness: 0.0,
            joint_damping: 0.0,
            hand_mass: 0.0,
            nail_stiffness: 0.0,
            contact_loss: 0.0,
            angle_mass: 0.0,
            angle_stiffness: 0.0,
            contact_ripple: Ripple::none(),
            skin_mass: 0.0,
            gain: 0.0,
            shape: Ripple::none(),
        }
    }

    /// The finger of participant `participant` under `seed`; participant 0 is the nominal finger.
    #[must_use]
    pub fn of(parameters: &TwinParameters, participant: u64, seed: u64) -> Self {
        if participant == 0 {
            return Self::nominal(parameters);
        }
        let octaves = parameters.finger.ripple_octaves;
        let mut random = Random::stream(seed, participant, "finger");
        Self {
            parameters: parameters.finger.clone(),
            actuator: parameters.actuator.clone(),
            pulp_stiffness: random.person(),
            pulp_damping: random.person(),
            phalanx_mass: random.person(),
            joint_stiffness: random.person(),
            joint_damping: random.person(),
            hand_mass: random.person(),
            nail_stiffness: random.person(),
            contact_loss: random.person(),
            angle_mass: random.person(),
            angle_stiffness: random.person(),
            contact_ripple: Ripple::draw(octaves, &mut random),
            // Drawn last, so that the numbers above stay the same for stored seeds.
            skin_mass: random.person(),
            gain: random.person(),
            shape: Ripple::draw(octaves, &mut random),
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
        let Elements {
            s,
            pulp,
            phalanx,
            nail,
            coupling,
        } = self.elements(frequency_hz, load_n, angle_deg);
        let finger = pulp * phalanx / (pulp + phalanx);
        let ActuatorParameters {
            membrane_stiffness_n_m,
            membrane_damping_n_s_m,
            membrane_kg,
            free_m_per_v,
            low_pass_hz,
            ..
        } = self.actuator;
        let membrane = membrane_stiffness_n_m + membrane_damping_n_s_m * s + membrane_kg * s * s;
        let low_pass = 1.0 / (1.0 + s / (TAU * low_pass_hz));
        low_pass * s * s / phalanx
            * nail
            * coupling
            * finger
            * membrane_stiffness_n_m
            * free_m_per_v
            / (membrane + finger)
            * self.gain(frequency_hz, placement)
    }

    /// The inertance on the shaker: the fingernail's acceleration per newton at the force cell under the plate,
    /// (m/s²)/N, at `frequency_hz` on a plate of `plate_kg`, with the finger pressed by `load_n` at `angle_deg`, placed
    /// as `placement` says. It is the finger's and the plate's; what the bench's sensing adds is not in it.
    ///
    /// Formula: s²/D1 · Tn · κ / (1 + ms·s²·(1/D1 + 1/Zp)), the cell below the mass ms of plate and skin.
    #[must_use]
    pub fn inertance(
        &self,
        plate_kg: f64,
        frequency_hz: f64,
        load_n: f64,
        angle_deg: f64,
        placement: &Placement,
    ) -> C {
        let Elements {
            s,
            pulp,
            phalanx,
            nail,
            coupling,
        } = self.elements(frequency_hz, load_n, angle_deg);
        let above_kg = self.above_cell_kg(plate_kg, load_n);
        s * s / phalanx * nail * coupling / (1.0 + above_kg * s * s * (1.0 / phalanx + 1.0 / pulp))
            * self.gain(frequency_hz, placement)
    }

    /// The dynamic stiffness of finger, skin and a plate of `plate_kg` at the force cell: the force at the cell per
    /// displacement, N/m.
    ///
    /// Formula: ms·s² + Zp·D1/(Zp + D1).
    pub(super) fn stiffness_on(
        &self,
        plate_kg: f64,
        frequency_hz: f64,
        load_n: f64,
        angle_deg: f64,
    ) -> C {
        let Elements {
            s, pulp, phalanx, ..
        } = self.elements(frequency_hz, load_n, angle_deg);
        self.above_cell_kg(plate_kg, load_n) * s * s + pulp * phalanx / (pulp + phalanx)
    }

    /// The moving mass above the force cell: a plate of `plate_kg` and the skin on it, kg.
    fn above_cell_kg(&self, plate_kg: f64, load_n: f64) -> f64 {
        let p = &self.parameters;
        (plate_kg + p.skin_kg) * person(p.skin_mass_spread * self.narrower(load_n), self.skin_mass)
    }

    /// The factor of [`Self::response`] that has no phase, a ratio above 0: coupling, level and ripples. A factor that changes with
    /// frequency and has no phase answers before it is excited.
    pub(super) fn phaseless(&self, frequency_hz: f64, load_n: f64, placement: &Placement) -> f64 {
        let load_n = load_n.max(self.parameters.least_load_n);
        self.coupling(frequency_hz, load_n) * self.gain(frequency_hz, placement)
    }

    fn elements(&self, frequency_hz: f64, load_n: f64, angle_deg: f64) -> Elements {
        let p = &self.parameters;
        let load_n = load_n.max(p.least_load_n);
        let stiffer = (load_n / p.reference_load_n).powf(p.pulp_load_exponent);
        let narrower = self.narrower(load_n);
        // The reference lies between the two angles of the thesis: a shape of one's own belongs to neither of them alone.
        let tilt = ((angle_deg - MIDDLE_ANGLE_DEG) / ANGLE_STEP_DEG).clamp(-1.0, 2.0);
        let s = C::new(0.0, TAU * frequency_hz);

        let pulp_k = p.pulp_stiffness_n_m
            * stiffer
            * person(p.pulp_stiffness_spread * narrower, self.pulp_stiffness)
            * (1.0 + p.angle_stiffness * self.angle_stiffness * tilt);
        let pulp_c = p.pulp_damping_n_s_m
            * stiffer
            * person(p.pulp_damping_spread * narrower, self.pulp_damping);

        let phalanx_kg = p.phalanx_kg
            * person(p.phalanx_mass_spread, self.phalanx_mass)
            * (1.0 + p.angle_mass * self.angle_mass * tilt);
        let joint = p.joint_stiffness_n_m * person(p.joint_stiffness_spread, self.joint_stiffness)
            + p.joint_damping_n_s_m * person(p.joint_damping_spread, self.joint_damping) * s;
        let hand_kg = p.hand_kg * person(p.hand_mass_spread, self.hand_mass);
        let hand = hand_kg * s * s + p.hand_damping_n_s_m * s + p.hand_stiffness_n_m;
        let arm = joint * hand / (joint + hand);

        let nail_k = p.nail_stiffness_n_m * person(p.nail_stiffness_spread, self.nail_stiffness);
        let held = nail_k + p.nail_damping_n_s_m * s;
        let nail = held / (held + p.nail_kg * s * s);
        Elements {
            s,
            pulp: pulp_k + pulp_c * s,
            phalanx: phalanx_kg * s * s + arm + p.nail_kg * s * s * nail,
            nail,
            coupling: self.coupling(frequency_hz, load_n),
        }
    }

    /// The share of the motion that the contact couples: κ = 1/(1 + ℓ), see the head of this file.
    fn coupling(&self, frequency_hz: f64, load_n: f64) -> f64 {
        let p = &self.parameters;
        let own = p.coupling_loss_spread * self.contact_loss
            + p.coupling_loss_ripple * self.contact_ripple.at(frequency_hz);
        let lost = p.coupling_loss * (own - load_n / p.coupling_loss_load_n).exp();
        1.0 / (1.0 + lost)
    }

    /// How much less people differ at `load_n` than at the load that is stated.
    fn narrower(&self, load_n: f64) -> f64 {
        let p = &self.parameters;
        (load_n.max(p.least_load_n) / p.reference_load_n).powf(p.spread_load_exponent)
    }

    fn gain(&self, frequency_hz: f64, placement: &Placement) -> f64 {
        let p = &self.parameters;
        let shape_db = p.ripple_db * self.shape.at(frequency_hz) + placement.level_db(frequency_hz);
        person(p.gain_spread, self.gain) * 10f64.powf(shape_db / 20.0)
    }
}

/// A person's departure of `z` standard deviations, as a factor.
fn person(spread: f64, z: f64) -> f64 {
    (spread * z).exp()
}

/// The random variation of one placement of a finger. Lifting the finger and placing it again draws another one.
#[derive(Clone, Debug)]
pub struct Placement {
    gain_db: f64,
    ripple_db: f64,
    ripple: Ripple,
}

impl Placement {
    /// The nominal placement, without variation.
    #[must_use]
    pub fn exact() -> Self {
        Self {
            gain_db: 0.0,
            ripple_db: 0.0,
            ripple: Ripple::none(),
        }
    }

    /// The placement that participant `participant` finds in the run `label` under `seed`.
    #[must_use]
    pub fn of(parameters: &TwinParameters, participant: u64, seed: u64, label: &str) -> Self {
        let p = &parameters.placement;
        let mut random = Random::stream(seed, participant, &format!("placement {label}"));
        Self {
            gain_db: p.gain_db * random.person(),
            ripple_db: p.ripple_db,
            ripple: Ripple::draw(parameters.finger.ripple_octaves, &mut random),
        }
    }

    fn level_db(&self, frequency_hz: f64) -> f64 {
        self.gain_db + self.ripple_db * self.ripple.at(frequency_hz)
    }
}

/// A smooth random function of the logarithm of frequency, of variance 1: a Gaussian process with a correlation
/// length in octaves, by random Fourier features (Rahimi and Recht 2007), interpolated linearly between points so close
/// that the error is a ten-thousandth.
#[derive(Clone, Debug)]
struct Ripple {
    /// From 1 Hz on.
    points: Vec<f64>,
}

impl Ripple {
    const WAVES: usize = 64;
    const PER_OCTAVE: f64 = 64.0;
    /// To 8192 Hz.
    const OCTAVES: f64 = 13.0;

    fn none() -> Self {
        Self { points: Vec::new() }
    }

    fn draw(octaves: f64, random: &mut Random) -> Self {
        let waves: Vec<(f64, f64)> = (0..Self::WAVES)
            .map(|_| (random.normal() / octaves, TAU * random.uniform()))
            .collect();
        let scale = (2.0 / Self::WAVES as f64).sqrt();
        let at = |octave: f64| -> f64 {
            let wave = |(rate, phase): &(f64, f64)| (rate * octave + phase).cos();
            scale * waves.iter().map(wave).sum::<f64>()
        };
        let count = (Self::OCTAVES * Self::PER_OCTAVE) as usize;
        Self {
            points: (0..=count)
                .map(|i| at(i as f64 / Self::PER_OCTAVE))
                .collect(),
        }
    }

    fn at(&self, frequency_hz: f64) -> f64 {
        let Some(last) = self.points.len().checked_sub(2) else {
            return 0.0;
        };
        let place = frequency_hz.max(1.0).log2() * Self::PER_OCTAVE;
        let i = (place as usize).min(last);
        let share = (place - i as f64).min(1.0);
        self.points[i] + share * (self.points[i + 1] - self.points[i])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::OutputStage;
    use piezotact::device::DeviceDescription;

    const PLATE_KG: f64 = 0.6e-3;

    /// The nominal device with the finger, from the amplifier's input, dB re (m/s²)/V at 0.2, 0.4 and 0.6 N:
    /// values of an independent prototype of the same model in NumPy, stated to 0.1 dB.
    const GOLDEN: [(f64, [f64; 3]); 7] = [
        (20.0, [-6.3, -5.0, -4.1]),
        (50.0, [11.8, 13.6, 14.6]),
        (100.0, [14.9, 17.7, 19.3]),
        (200.0, [16.5, 18.7, 20.0]),
        (300.0, [18.0, 20.0, 21.1]),
        (500.0, [19.9, 21.5, 22.5]),
        (1000.0, [22.8, 24.3, 25.2]),
    ];

    #[test]
    fn the_nominal_device_has_the_prototype_s_magnitudes() {
        let twin = TwinParameters::built_in();
        let finger = Finger::nominal(&twin);
        let output = OutputStage::new(&twin.output, &DeviceDescription::drv2667().at_usual_gain());
        for (frequency_hz, levels_db) in GOLDEN {
            for (load_n, expected_db) in [0.2, 0.4, 0.6].into_iter().zip(levels_db) {
                let h = finger.response(frequency_hz, load_n, 20.0, &Placement::exact())
                    * output.high_pass(frequency_hz)
                    * output.setup().gain.voltage_ratio();
                let found_db = 20.0 * h.norm().log10();
                assert!(
                    (found_db - expected_db).abs() < 0.06,
                    "{frequency_hz} Hz, {load_n} N: {found_db:.2}"
                );
            }
        }
    }

    /// The bench's antiresonance as the prototype has it: −12 dB at 265 Hz.
    fn antiresonance(frequency_hz: f64) -> C {
        let (s, w) = (C::new(0.0, TAU * frequency_hz), TAU * 265.0);
        (s * s + 2.0 * 0.03 * w * s + w * w) / (s * s + 2.0 * 0.12 * w * s + w * w)
    }

    /// The nominal finger on the shaker, dB re 1 kg⁻¹, of the same prototype. Its numbers are of the measured
    /// ratio, with the bench's antiresonance: without it 300 Hz would be at 37.3, 39.1 and 40.0 dB.
    #[test]
    fn the_nominal_inertance_has_the_prototype_s_magnitudes() {
        const GOLDEN: [(f64, [f64; 3]); 7] = [
            (20.0, [34.0, 35.1, 35.8]),
            (50.0, [38.8, 39.8, 40.5]),
            (100.0, [39.1, 40.0, 40.6]),
            (200.0, [38.2, 39.3, 40.0]),
            (300.0, [34.7, 36.5, 37.4]),
            (500.0, [34.4, 36.9, 38.3]),
            (1000.0, [31.5, 34.5, 36.3]),
        ];
        let finger = Finger::of(&TwinParameters::built_in(), 0, 8);
        for (frequency_hz, levels_db) in GOLDEN {
            for (load_n, expected_db) in [0.2, 0.4, 0.6].into_iter().zip(levels_db) {
                let h = finger.inertance(PLATE_KG, frequency_hz, load_n, 20.0, &Placement::exact())
                    * antiresonance(frequency_hz);
                let found_db = 20.0 * h.norm().log10();
                assert!(
                    (found_db - expected_db).abs() < 0.06,
                    "{frequency_hz} Hz, {load_n} N: {found_db:.2}"
                );
            }
        }
    }

    /// What the cell and the nail say of one motion of the plate is one finger: inertance times force is the nail's
    /// acceleration, Zp/(Zp + D1)·Tn·κ of the plate's.
    #[test]
    fn inertance_and_stiffness_are_of_one_finger() {
        let twin = TwinParameters::built_in();
        let finger = Finger::of(&twin, 4, 2);
        let placement = Placement::of(&twin, 4, 2, "x");
        for frequency_hz in [10.0, 80.0, 700.0] {
            let e = finger.elements(frequency_hz, 0.3, 35.0);
            let nail = finger.inertance(PLATE_KG, frequency_hz, 0.3, 35.0, &placement)
                * finger.stiffness_on(PLATE_KG, frequency_hz, 0.3, 35.0);
            let direct = e.s * e.s * e.pulp / (e.pulp + e.phalanx)
                * e.nail
                * e.coupling
                * finger.gain(frequency_hz, &placement);
            assert!((nail / direct - 1.0).norm() < 1e-12, "{frequency_hz}");
        }
    }

    /// A firmer touch loses less of the motion at every frequency, whoever it is, and people differ less.
    #[test]
    fn a_firmer_touch_couples_more_of_everybody() {
        let twin = TwinParameters::built_in();
        let people: Vec<Finger> = (1..=40).map(|n| Finger::of(&twin, n, 7)).collect();
        let spread = |load_n: f64| {
            let coupled = people.iter().map(|f| f.coupling(150.0, load_n).ln());
            piezotact::statistics::standard_deviation(&coupled.collect::<Vec<f64>>())
        };
        assert!(
            spread(0.2) > 1.5 * spread(0.6),
            "{} {}",
            spread(0.2),
            spread(0.6)
        );
        for finger in &people {
            for frequency_hz in [20.0, 100.0, 265.0, 1000.0] {
                let at = |load_n| finger.coupling(frequency_hz, load_n);
                assert!(at(0.2) < at(0.4) && at(0.4) < at(0.6) && at(0.6) < 1.0);
            }
        }
    }

    /// Between 20° and 40° neither angle is the reference: over people both shapes lie as far from the mean finger.
    #[test]
    fn both_angles_have_shapes_of_their_own() {
        let twin = TwinParameters::built_in();
        let apart = |angle_deg: f64| {
            let people = (1..=40).map(|n| Finger {
                angle_mass: Finger::of(&twin, n, 3).angle_mass,
                angle_stiffness: Finger::of(&twin, n, 3).angle_stiffness,
                ..Finger::nominal(&twin)
            });
            let reference = Finger::nominal(&twin);
            let level = |f: &Finger| {
                f.response(200.0, 0.2, angle_deg, &Placement::exact())
                    .norm()
                    .ln()
            };
            let off: Vec<f64> = people.map(|f| level(&f) - level(&reference)).collect();
            piezotact::statistics::rms(&off)
        };
        let (flat, steep) = (apart(20.0), apart(40.0));
        assert!(
            flat > 0.0 && (flat / steep - 1.0).abs() < 0.05,
            "{flat} {steep}"
        );
    }

    #[test]
    fn people_differ_and_a_person_stays_the_same() {
        let at = |participant| {
            Finger::of(&TwinParameters::built_in(), participant, 5)
                .response(200.0, 0.2, 20.0, &Placement::exact())
                .norm()
        };
        assert_eq!(at(1), at(1));
        assert!((at(1) / at(2) - 1.0).abs() > 1e-3);
    }
}
