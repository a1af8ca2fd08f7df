//! From the digital drive to the voltage at the actuator: the PC's sound output and the amplifier.

use std::f64::consts::TAU;

use num_complex::Complex;
use piezotact::device::{AmplifierGain, DriveSetup};
use piezotact::quantity::SampleRate;

use super::parameters::OutputParameters;
use piezotact_bench::random::Random;

/// A sound output and an amplifier.
#[derive(Clone, Debug)]
pub struct OutputStage {
    setup: DriveSetup,
    corner_hz: f64,
    noise_db: f64,
    quadratic: f64,
}

impl OutputStage {
    /// The output with the amplifier set to `gain`. At full scale a laptop's output overdrives the amplifier's
    /// 0.9 V, as it does on a table.
    #[must_use]
    pub fn new(parameters: &OutputParameters, gain: AmplifierGain) -> Self {
        Self {
            setup: DriveSetup {
                gain,
                volts_per_full_scale: parameters.volts_per_full_scale,
                load_f: parameters.load_f,
            },
            corner_hz: parameters.corner_hz,
            noise_db: parameters.noise_db,
            quadratic: parameters.quadratic,
        }
    }

    /// What a calibration of it finds.
    #[must_use]
    pub fn setup(&self) -> &DriveSetup {
        &self.setup
    }

    /// The high-pass of the output's coupling at `frequency_hz`.
    #[must_use]
    pub fn high_pass(&self, frequency_hz: f64) -> Complex<f64> {
        let place = Complex::new(0.0, frequency_hz / self.corner_hz);
        place / (1.0 + place)
    }

    /// The voltage at the actuator, as the actuator feels it, for a drive (full scale = 1) at `rate`:
    /// converter limit, coupling, gain, clipping, slew limit, quadratic term.
    pub(crate) fn voltage(&self, drive: &[f64], rate: SampleRate, random: &mut Random) -> Vec<f64> {
        let volts = self.setup.volts_per_full_scale;
        let noise_v = volts * 10f64.powf(self.noise_db / 20.0);
        let gain = self.setup.gain.voltage_ratio();
        let limit_v = self.setup.gain.full_scale_output().0;
        let step_v = self.setup.slew_limit_v_per_s() / rate.hz();
        // First-order high-pass by the bilinear transform, its corner where the analogue one has it.
        let k = (TAU * self.corner_hz / rate.hz() / 2.0).tan();
        let (b, a) = (1.0 / (1.0 + k), (1.0 - k) / (1.0 + k));
        let (mut before_in, mut coupled, mut out) = (0.0, 0.0, 0.0);
        drive
            .iter()
            .map(|sample| {
                let dac = sample.clamp(-1.0, 1.0) * volts + noise_v * random.normal();
                coupled = b * (dac - before_in) + a * coupled;
                before_in = dac;
                let wanted = (coupled * gain).clamp(-limit_v, limit_v);
                out += (wanted - out).clamp(-step_v, step_v);
                out + self.quadratic * out * out / limit_v
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::TwinParameters;

    fn stage() -> OutputStage {
        OutputStage::new(&TwinParameters::built_in().output, AmplifierGain::B3)
    }

    fn tone(amplitude: f64, frequency_hz: f64) -> Vec<f64> {
        let drive: Vec<f64> = (0..48_000)
            .map(|i| amplitude * (TAU * frequency_hz * f64::from(i) / 48_000.0).sin())
            .collect();
        let mut random = Random::stream(1, 1, "test");
        stage().voltage(&drive, SampleRate::new(48_000.0).unwrap(), &mut random)
    }

    /// The amplitude of one harmonic of a tone that fills whole periods.
    fn harmonic(x: &[f64], frequency_hz: f64) -> f64 {
        let sum: Complex<f64> = x
            .iter()
            .enumerate()
            .map(|(i, v)| Complex::from_polar(*v, -TAU * frequency_hz * i as f64 / 48_000.0))
            .sum();
        2.0 * sum.norm() / x.len() as f64
    }

    #[test]
    fn a_small_tone_is_amplified_and_a_large_one_clips() {
        let small = tone(0.1, 200.0);
        let expected = 0.1 * 2f64.sqrt() * 83.18 * stage().high_pass(200.0).norm();
        assert!((harmonic(&small[24_000..], 200.0) / expected - 1.0).abs() < 1e-3);
        let large = tone(1.0, 50.0);
        assert!((piezotact::statistics::peak(&large) - 75.0 * 1.02).abs() < 1e-6);
    }

    /// At the amplifier's full scale the second harmonic is 40 dB down: 0.02·V²/2 over V.
    #[test]
    fn the_second_harmonic_is_40_db_down() {
        let x = tone(0.6, 200.0);
        let ratio_db =
            20.0 * (harmonic(&x[24_000..], 400.0) / harmonic(&x[24_000..], 200.0)).log10();
        assert!((ratio_db + 40.5).abs() < 0.2, "{ratio_db}");
    }

    #[test]
    fn the_slope_is_limited() {
        let x = tone(0.6, 950.0);
        let steepest = x
            .windows(2)
            .map(|p| (p[1] - p[0]).abs())
            .fold(0.0, f64::max)
            * 48_000.0;
        // The quadratic term steepens by up to 4 %.
        assert!(steepest <= 2.65e5 * 1.045, "{steepest:e}");
    }
}
