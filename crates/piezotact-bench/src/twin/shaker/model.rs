//! What the shaker bench does to a voltage: coil, suspension, plate, the finger on it, and the sensing.

use std::f64::consts::TAU;

use num_complex::Complex;

use crate::traits::BenchError;
use crate::twin::finger::{Finger, PLATE_KG, Placement};
use crate::twin::varying::AtLoad;

/// The shaker bench in numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct ShakerParameters {
    /// The moving mass, armature and force cell, kg.
    pub moving_mass_kg: f64,
    /// Where the moving mass resonates on its suspension, Hz.
    pub suspension_hz: f64,
    /// The damping ratio of that resonance: suspension, and the coil on its amplifier.
    pub suspension_damping_ratio: f64,
    /// The bare plate's acceleration per volt from the acquisition, far above the resonance, (m/s²)/V.
    pub gain_m_s2_per_v: f64,
    /// The largest drive, V rms.
    pub most_rms_v: f64,
    /// The ceramic plate and the part of the force cell above its crystal, kg.
    pub plate_kg: f64,
    /// The accelerometer that is waxed to the plate for the control measurement, kg.
    pub accelerometer_kg: f64,
    /// Where the antiresonance of the bench lies, Hz.
    pub artefact_hz: f64,
    /// The damping ratio of its zeros: how narrow the dip is.
    pub artefact_zero_damping_ratio: f64,
    /// The damping ratio of its poles: with the former, how deep the dip is.
    pub artefact_pole_damping_ratio: f64,
    /// The noise of force cell and charge amplifier, N rms.
    pub force_noise_n: f64,
    /// The least that the force cell drifts as the finger warms it, N.
    pub least_drift_n: f64,
    /// The most that it drifts, N.
    pub most_drift_n: f64,
    /// How fast it drifts: the time constant, s.
    pub drift_s: f64,
    /// How fast a hand can change its force: the corner of the muscle's low-pass, Hz.
    pub hand_hz: f64,
}

impl ShakerParameters {
    /// The numbers that the twin has, unless others are measured.
    ///
    /// - Moving mass 0.45 kg (*common knowledge of the field* for the thesis' Modal Shop 2075E, not re-read),
    ///   suspension 25 Hz, damping ratio 0.4 and 12 (m/s²)/V (*chosen*: 6 m/s² and 20 mN rms at 0.5 V).
    /// - 2 V rms (*chosen*: five standard deviations stay within a ±10 V output).
    /// - Plate 0.6 g (*chosen*), accelerometer 0.8 g (*data sheet* of the thesis' PCB 352A24).
    /// - Antiresonance at 265 Hz (*thesis* 5.1.1), 12 dB deep by damping ratios 0.03 and 0.12 (*chosen*).
    /// - Force noise 0.3 mN rms (*chosen* for a charge cell); drift 20–50 mN within 20 s (*chosen*: the thesis says
    ///   that the cell is sensitive to the finger's warmth, and not how much).
    /// - The hand's corner 3 Hz (*common knowledge*: the muscles of the hand pass 2–3 Hz, and less by the square).
    #[must_use]
    pub fn chosen() -> Self {
        Self {
            moving_mass_kg: 0.45,
            suspension_hz: 25.0,
            suspension_damping_ratio: 0.4,
            gain_m_s2_per_v: 12.0,
            most_rms_v: 2.0,
            plate_kg: PLATE_KG,
            accelerometer_kg: 0.8e-3,
            artefact_hz: 265.0,
            artefact_zero_damping_ratio: 0.03,
            artefact_pole_damping_ratio: 0.12,
            force_noise_n: 0.3e-3,
            least_drift_n: 0.02,
            most_drift_n: 0.05,
            drift_s: 20.0,
            hand_hz: 3.0,
        }
    }

    /// What the bench's own dynamics multiply the acceleration with, at `frequency_hz`: an antiresonance.
    ///
    /// The thesis sees it in the control measurement and in every finger's acceleration per force, where the motion
    /// of the shaker itself would cancel. It is therefore modelled in the sensing of the acceleration, with the
    /// finger and without, so that the control measurement can remove it.
    #[must_use]
    pub fn artefact(&self, frequency_hz: f64) -> Complex<f64> {
        let place = frequency_hz / self.artefact_hz;
        let ratio = |damping: f64| Complex::new(1.0 - place * place, 2.0 * damping * place);
        ratio(self.artefact_zero_damping_ratio) / ratio(self.artefact_pole_damping_ratio)
    }

    /// Refuses numbers that make no bench.
    pub(super) fn check(&self) -> Result<(), BenchError> {
        let wrong = |name: &str, expected: &str, value: f64| BenchError::Impossible {
            expected: format!("{name} {expected}"),
            found: value.to_string(),
            todo: "ShakerParameters::chosen() has values that work".into(),
        };
        for (name, value) in [
            ("moving_mass_kg", self.moving_mass_kg),
            ("suspension_hz", self.suspension_hz),
            ("suspension_damping_ratio", self.suspension_damping_ratio),
            ("gain_m_s2_per_v", self.gain_m_s2_per_v),
            ("most_rms_v", self.most_rms_v),
            ("artefact_hz", self.artefact_hz),
            (
                "artefact_zero_damping_ratio",
                self.artefact_zero_damping_ratio,
            ),
            (
                "artefact_pole_damping_ratio",
                self.artefact_pole_damping_ratio,
            ),
            ("drift_s", self.drift_s),
            ("hand_hz", self.hand_hz),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(wrong(name, "above 0", value));
            }
        }
        for (name, value) in [
            ("plate_kg", self.plate_kg),
            ("accelerometer_kg", self.accelerometer_kg),
            ("force_noise_n", self.force_noise_n),
            ("least_drift_n", self.least_drift_n),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(wrong(name, "from 0", value));
            }
        }
        if !(self.most_drift_n.is_finite() && self.most_drift_n >= self.least_drift_n) {
            let expected = format!("from least_drift_n, {}", self.least_drift_n);
            return Err(wrong("most_drift_n", &expected, self.most_drift_n));
        }
        Ok(())
    }
}

/// What stands on the shaker.
#[derive(Clone, Debug)]
pub(super) enum Standing {
    /// A finger, as it lies this time.
    Finger {
        finger: Box<Finger>,
        placement: Placement,
        angle_deg: f64,
    },
    /// The accelerometer.
    Accelerometer,
}

/// The shaker with what stands on it.
#[derive(Clone, Debug)]
pub(super) struct Loaded {
    pub(super) parameters: ShakerParameters,
    pub(super) standing: Standing,
}

impl Loaded {
    /// The dynamic force at the cell per volt, N/V.
    ///
    /// The coil's force moves the moving mass, its suspension and what stands on the cell; the cell feels the last:
    /// F/V = fv·Kl/(m·s² + c·s + k + Kl).
    pub(super) fn force_per_volt(&self, frequency_hz: f64, load_n: f64) -> Complex<f64> {
        let p = &self.parameters;
        let s = Complex::new(0.0, TAU * frequency_hz);
        let resonance = TAU * p.suspension_hz;
        let own = p.moving_mass_kg
            * (s * s + 2.0 * p.suspension_damping_ratio * resonance * s + resonance * resonance);
        let load = match &self.standing {
            Standing::Finger {
                finger, angle_deg, ..
            } => finger.stiffness_on(p.plate_kg, frequency_hz, load_n, *angle_deg),
            Standing::Accelerometer => (p.plate_kg + p.accelerometer_kg) * s * s,
        };
        p.gain_m_s2_per_v * p.moving_mass_kg * load / (own + load)
    }

    /// The acceleration that the accelerometer shows per newton at the cell, (m/s²)/N, with the bench's
    /// antiresonance.
    pub(super) fn acceleration_per_newton(&self, frequency_hz: f64, load_n: f64) -> Complex<f64> {
        let p = &self.parameters;
        let inertance = match &self.standing {
            Standing::Finger {
                finger,
                placement,
                angle_deg,
            } => finger.inertance_on(p.plate_kg, frequency_hz, load_n, *angle_deg, placement),
            Standing::Accelerometer => (1.0 / (p.plate_kg + p.accelerometer_kg)).into(),
        };
        inertance * p.artefact(frequency_hz)
    }
}

/// From the drive to the force at the cell.
pub(super) struct Force(pub(super) Loaded);

impl AtLoad for Force {
    fn at(&self, frequency_hz: f64, load_n: f64) -> Complex<f64> {
        self.0.force_per_volt(frequency_hz, load_n)
    }
}

/// From the drive to the acceleration that is sensed.
pub(super) struct Acceleration(pub(super) Loaded);

impl AtLoad for Acceleration {
    fn at(&self, frequency_hz: f64, load_n: f64) -> Complex<f64> {
        self.0.force_per_volt(frequency_hz, load_n)
            * self.0.acceleration_per_newton(frequency_hz, load_n)
    }
}
