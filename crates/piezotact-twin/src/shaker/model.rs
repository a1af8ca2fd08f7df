//! What the shaker bench does to a voltage: coil, suspension, plate, the finger on it, and the sensing.

use std::f64::consts::TAU;

use num_complex::Complex;

use crate::finger::{Finger, Placement};
use crate::parameters::ShakerParameters;
use crate::varying::LoadDependent;

impl ShakerParameters {
    /// The factor of the bench's own dynamics on the acceleration at `frequency_hz`: an antiresonance.
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
}

/// The load on the shaker.
#[derive(Clone, Debug)]
pub(super) enum Standing {
    /// A finger in one placement.
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
            } => finger.inertance(p.plate_kg, frequency_hz, load_n, *angle_deg, placement),
            Standing::Accelerometer => (1.0 / (p.plate_kg + p.accelerometer_kg)).into(),
        };
        inertance * p.artefact(frequency_hz)
    }
}

/// From the drive to the force at the cell.
pub(super) struct Force(pub(super) Loaded);

impl LoadDependent for Force {
    fn at(&self, frequency_hz: f64, load_n: f64) -> Complex<f64> {
        self.0.force_per_volt(frequency_hz, load_n)
    }
}

/// From the drive to the acceleration that is sensed.
pub(super) struct Acceleration(pub(super) Loaded);

impl LoadDependent for Acceleration {
    fn at(&self, frequency_hz: f64, load_n: f64) -> Complex<f64> {
        self.0.force_per_volt(frequency_hz, load_n)
            * self.0.acceleration_per_newton(frequency_hz, load_n)
    }
}
