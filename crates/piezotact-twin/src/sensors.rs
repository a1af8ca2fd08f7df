//! The accelerometer on the fingernail, the force cells, and the hand that presses.

use super::RATE_HZ;
use super::parameters::{
    AccelerometerParameters, ForceCellParameters, HandParameters, PiezoCellParameters,
};
use super::wander::Wander;
use piezotact::statistics::{mean, standard_deviation};

use piezotact_bench::SensorCalibration;
use piezotact_bench::random::Random;

/// The calibration from `channels` recorded at rest: mean, and rms about it.
pub(super) fn at_rest(channels: &[Vec<f64>]) -> SensorCalibration {
    let of_all = |of: fn(&[f64]) -> f64| channels.iter().map(|x| of(x)).collect();
    SensorCalibration {
        offset: of_all(mean),
        noise_rms: of_all(standard_deviation),
    }
}

/// The factor on the rms of white noise read at `rate_hz`. The parameters state it at the rate of the acquisition; at another rate
/// the density is the same, and the band is wider or narrower.
fn wider(rate_hz: f64) -> f64 {
    (rate_hz / RATE_HZ).sqrt()
}

/// An accelerometer on the nail: white noise over the acquisition band and flicker below a corner, a sensitivity
/// that is not quite the stated one, and a range.
#[derive(Clone, Debug)]
pub(crate) struct Accelerometer {
    parameters: AccelerometerParameters,
    random: Random,
    white_m_s2: f64,
    flicker: f64,
    forget: f64,
    kept: f64,
    sensitivity: f64,
}

impl Accelerometer {
    pub(crate) fn new(parameters: &AccelerometerParameters, rate_hz: f64, random: Random) -> Self {
        let forget = (-std::f64::consts::TAU * parameters.flicker_hz / rate_hz).exp();
        Self {
            white_m_s2: parameters.white_m_s2 * wider(rate_hz),
            kept: parameters.flicker_m_s2 * (1.0 - forget * forget).sqrt(),
            parameters: parameters.clone(),
            random,
            flicker: 0.0,
            forget,
            sensitivity: 1.0,
        }
    }

    /// The same sensor with the sensitivity drawn by `seed`: the same for every participant and bench.
    pub(crate) fn calibrated(mut self, seed: u64) -> Self {
        let mut random = Random::stream(seed, 0, "accelerometer");
        self.sensitivity = 1.0 + self.parameters.sensitivity_spread * random.person();
        self
    }

    /// The reading, m/s², for the true acceleration.
    pub(crate) fn read(&mut self, acceleration_m_s2: f64) -> f64 {
        self.flicker = self.forget * self.flicker + self.kept * self.random.normal();
        let reading = self.sensitivity * acceleration_m_s2
            + self.flicker
            + self.white_m_s2 * self.random.normal();
        reading.clamp(-self.parameters.range_m_s2, self.parameters.range_m_s2)
    }
}

/// One axis of a strain-gauge cell under the actuator.
#[derive(Clone, Debug)]
pub(crate) struct ForceCell {
    random: Random,
    noise_n: f64,
}

impl ForceCell {
    pub(crate) fn new(parameters: &ForceCellParameters, rate_hz: f64, random: Random) -> Self {
        Self {
            random,
            noise_n: parameters.noise_n * wider(rate_hz),
        }
    }

    /// What it reads, N, for the true force.
    pub(crate) fn read(&mut self, force_n: f64) -> f64 {
        force_n + self.noise_n * self.random.normal()
    }
}

/// Three axes of force with crosstalk, noise, and slow drift.
#[derive(Clone, Debug)]
pub(crate) struct TriaxialCell {
    random: Random,
    mixing: [[f64; 3]; 3],
    noise_n: f64,
    range_n: f64,
    slow: Slow,
}

/// The slow drift of a cell over minutes.
#[derive(Clone, Debug)]
enum Slow {
    /// A strain gauge: an offset that drifts.
    Drift {
        offset_n: [f64; 3],
        step_n: [f64; 3],
    },
    /// A charge amplifier: the reading of a constant force decays.
    Discharge { lost_n: [f64; 3], share: f64 },
}

impl TriaxialCell {
    /// A strain-gauge cell: `body` draws what it is, `noise` what it adds in one run.
    pub(crate) fn strain_gauge(
        parameters: &ForceCellParameters,
        rate_hz: f64,
        mut body: Random,
        noise: Random,
    ) -> Self {
        let mixing = mixing(parameters.crosstalk, &mut body);
        let offset_n = [(); 3].map(|()| parameters.offset_n * body.person());
        let step_n = [(); 3].map(|()| parameters.drift_n_s * body.person() / rate_hz);
        Self {
            random: noise,
            mixing,
            noise_n: parameters.noise_n,
            range_n: parameters.range_n,
            slow: Slow::Drift { offset_n, step_n },
        }
    }

    /// Piezoelectric cells with a charge amplifier; likewise.
    pub(crate) fn piezoelectric(
        parameters: &PiezoCellParameters,
        rate_hz: f64,
        mut body: Random,
        noise: Random,
    ) -> Self {
        let mixing = mixing(parameters.crosstalk, &mut body);
        Self {
            random: noise,
            mixing,
            noise_n: parameters.noise_n,
            range_n: parameters.range_n,
            slow: Slow::Discharge {
                lost_n: [0.0; 3],
                share: 1.0 / (rate_hz * parameters.discharge_s),
            },
        }
    }

    /// What the three axes read, N, for the true forces.
    pub(crate) fn read(&mut self, force_n: [f64; 3]) -> [f64; 3] {
        let mut reading = self
            .mixing
            .map(|row| row[0] * force_n[0] + row[1] * force_n[1] + row[2] * force_n[2]);
        match &mut self.slow {
            Slow::Drift { offset_n, step_n } => {
                for axis in 0..3 {
                    offset_n[axis] += step_n[axis];
                    reading[axis] += offset_n[axis];
                }
            }
            Slow::Discharge { lost_n, share } => {
                for axis in 0..3 {
                    reading[axis] -= lost_n[axis];
                    lost_n[axis] += *share * reading[axis];
                }
            }
        }
        reading.map(|axis| {
            (axis + self.noise_n * self.random.normal()).clamp(-self.range_n, self.range_n)
        })
    }
}

fn mixing(crosstalk: f64, random: &mut Random) -> [[f64; 3]; 3] {
    let mut mixing = [[0.0; 3]; 3];
    for (i, row) in mixing.iter_mut().enumerate() {
        for (j, part) in row.iter_mut().enumerate() {
            *part = if i == j {
                1.0
            } else {
                crosstalk * (2.0 * random.uniform() - 1.0)
            };
        }
    }
    mixing
}

/// A hand that holds a force: a wandering intention, low-pass filtered by the muscle, critically damped. The intention alone falls
/// only with the square of frequency and would press, and so move the finger, at 25 Hz, which no hand can do.
#[derive(Clone, Debug)]
pub(crate) struct SlowHand {
    wander: Wander,
    load_n: f64,
    least_n: f64,
    follow: f64,
    stages_n: Option<[f64; 2]>,
}

impl SlowHand {
    /// A hand that means to press with `load_n`; the force itself has the standard deviation of the parameters.
    ///
    /// Formula: two equal low-passes of the rate a pass a·(2a + b)/(2·(a + b)²) of the variance of a process that forgets at the
    /// rate b.
    pub(crate) fn new(
        parameters: &HandParameters,
        load_n: f64,
        rate_hz: f64,
        random: Random,
    ) -> Self {
        let slow = std::f64::consts::TAU * parameters.force_hz;
        let forgets = 1.0 / parameters.force_memory_s;
        let passed = slow * (2.0 * slow + forgets) / (2.0 * (slow + forgets).powi(2));
        Self {
            wander: Wander::new(
                parameters.force_spread_n / passed.sqrt(),
                parameters.force_memory_s,
                rate_hz,
                random,
            ),
            load_n,
            least_n: parameters.least_force_n.min(load_n),
            follow: 1.0 - (-slow / rate_hz).exp(),
            stages_n: None,
        }
    }

    /// The force now, N; then a step of time passes.
    pub(crate) fn next(&mut self) -> f64 {
        let wanted_n = (self.load_n + self.wander.next()).max(self.least_n);
        let follow = self.follow;
        let [first_n, second_n] = self.stages_n.get_or_insert([wanted_n; 2]);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::TwinParameters;
    use piezotact::statistics::{mean, rms};

    #[test]
    fn an_accelerometer_is_noisy_and_ends_at_its_range() {
        let parameters = TwinParameters::built_in().accelerometer;
        let random = |name| Random::stream(1, 1, name);
        let mut sensor = Accelerometer::new(&parameters, 5_000.0, random("a"));
        let quiet: Vec<f64> = (0..50_000).map(|_| sensor.read(0.0)).collect();
        // √(2² + 1²) mm/s² of white and slow noise; the slow half has some 250 independent values.
        assert!((rms(&quiet) - 2.24e-3).abs() < 0.15e-3, "{}", rms(&quiet));
        assert!(sensor.read(1e6) <= 490.0);
        let mut off = sensor.calibrated(3);
        let level: Vec<f64> = (0..1_000).map(|_| off.read(10.0)).collect();
        assert!((mean(&level) / 10.0 - 1.0).abs() < 0.061);
    }

    /// A hand has the spread of its parameters, and no force to speak of at 25 Hz: two poles at 3 Hz leave 2e-4 of the power there,
    /// where the intention alone has 5e-4 of its own. 400 s hold some 650 independent values: four standard errors are 11 %.
    #[test]
    fn a_hand_is_slow() {
        let parameters = TwinParameters::built_in().hand;
        let mut hand = SlowHand::new(&parameters, 1.0, 5_000.0, Random::stream(1, 1, "hand"));
        let force_n: Vec<f64> = (0..2_000_000).map(|_| hand.next() - 1.0).collect();
        let found = rms(&force_n) / parameters.force_spread_n;
        assert!((found - 1.0).abs() < 0.11, "{found}");
        // The change within 1 ms, which a raw process of this memory makes as large as sd·√(2·1 ms/0.3 s) = 2.4 mN.
        let steps: Vec<f64> = force_n.windows(6).map(|w| w[5] - w[0]).collect();
        assert!(rms(&steps) < 0.5e-3, "{}", rms(&steps));
    }

    /// A force on one axis shows on the others by at most the stated crosstalk, and on a charge amplifier it fades.
    #[test]
    fn cells_mix_drift_and_fade() {
        let parameters = TwinParameters::built_in();
        let mut gauge = TriaxialCell::strain_gauge(
            &parameters.force_cell,
            5_000.0,
            Random::stream(1, 1, "g"),
            Random::stream(1, 1, "n"),
        );
        let mut at = |force: [f64; 3]| -> [f64; 3] {
            let all: Vec<[f64; 3]> = (0..5_000).map(|_| gauge.read(force)).collect();
            [0, 1, 2].map(|axis| mean(&all.iter().map(|r| r[axis]).collect::<Vec<f64>>()))
        };
        let (rest, pressed) = (at([0.0; 3]), at([0.0, 0.0, 1.0]));
        // 3 mN of noise over 5,000 samples, and a second of drift.
        for axis in [0, 1] {
            assert!(
                (pressed[axis] - rest[axis]).abs() < 0.01 + 3e-4,
                "{pressed:?}"
            );
        }
        assert!((pressed[2] - rest[2] - 1.0).abs() < 3e-4);
        assert!(rest.iter().any(|offset| offset.abs() > 1e-3));
        let mut piezo = TriaxialCell::piezoelectric(
            &parameters.piezo_cells,
            5_000.0,
            Random::stream(1, 1, "p"),
            Random::stream(1, 1, "n"),
        );
        let held: Vec<f64> = (0..250_000)
            .map(|_| piezo.read([0.0, 0.0, 1.0])[2])
            .collect();
        // After 49.5 s of a time constant of 1000 s.
        let left = mean(&held[245_000..]);
        assert!((left - (-0.0495f64).exp()).abs() < 2e-3, "{left}");
    }
}
