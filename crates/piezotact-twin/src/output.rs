//! From the digital drive to the voltage at the actuator: the PC's sound output and the amplifier.

use std::f64::consts::TAU;

use num_complex::Complex;
use piezotact::device::{Coupling, DeviceAtGain, DriveSetup};
use piezotact::quantity::{SampleRate, Volts};

use super::parameters::OutputParameters;
use piezotact_bench::random::Random;

/// The level of the output's noise is that at this rate, Hz: over a band of 24 kHz.
const NOISE_RATE_HZ: f64 = 48_000.0;

/// A sound output and an amplifier.
#[derive(Clone, Debug)]
pub struct OutputStage {
    setup: DriveSetup,
    /// The corners of the high-passes on the way: of the PC's output, and of the amplifier's input where it has one.
    corners_hz: Vec<f64>,
    noise_db: f64,
    quadratic: f64,
}

impl OutputStage {
    /// The output in front of the amplifier and the actuator of `set`. At full scale a laptop's output overdrives the 0.9 V input
    /// of the thesis' amplifier, as in the real setup.
    #[must_use]
    pub fn new(parameters: &OutputParameters, set: &DeviceAtGain) -> Self {
        let device = set.device();
        let behind = match device.input().coupling {
            Coupling::Direct => None,
            Coupling::HighPassHz(corner_hz) => Some(corner_hz),
        };
        let volts = Volts(parameters.volts_per_full_scale);
        Self {
            setup: DriveSetup::new(set.clone(), volts, device.actuator().capacitance_f)
                .unwrap_or_else(|_| {
                    unreachable!("parameters and descriptions stay within what a set-up may be")
                }),
            corners_hz: std::iter::once(parameters.corner_hz)
                .chain(behind)
                .collect(),
            noise_db: parameters.noise_db,
            quadratic: parameters.quadratic,
        }
    }

    /// The result of a calibration.
    #[must_use]
    pub fn setup(&self) -> &DriveSetup {
        &self.setup
    }

    /// The high-pass of the output's coupling, and of the amplifier's, at `frequency_hz`.
    #[must_use]
    pub fn high_pass(&self, frequency_hz: f64) -> Complex<f64> {
        let of = |corner_hz: &f64| {
            let place = Complex::new(0.0, frequency_hz / corner_hz);
            place / (1.0 + place)
        };
        self.corners_hz
            .iter()
            .map(of)
            .reduce(|a, b| a * b)
            .unwrap_or(Complex::ONE)
    }

    /// The effective voltage at the actuator, V, for a drive (full scale = 1) at `rate`:
    /// converter limit, coupling, gain, clipping, slew limit, quadratic term.
    pub(crate) fn voltage(&self, drive: &[f64], rate: SampleRate, random: &mut Random) -> Vec<f64> {
        let mut stream = self.stream(rate);
        drive
            .iter()
            .map(|sample| stream.next(*sample, random))
            .collect()
    }

    /// The same, sample by sample, from rest. The noise has the same density at every rate.
    pub(crate) fn stream(&self, rate: SampleRate) -> OutputStream {
        let volts = self.setup.volts_per_full_scale;
        let wider = (rate.hz() / NOISE_RATE_HZ).sqrt();
        OutputStream {
            volts,
            noise_v: volts * 10f64.powf(self.noise_db / 20.0) * wider,
            gain: self.setup.gain.voltage_ratio() * self.setup.device().input().divider,
            limit_v: self.setup.gain.full_scale_output().0,
            step_v: self.setup.slew_limit_v_per_s().unwrap_or(f64::INFINITY) / rate.hz(),
            quadratic: self.quadratic,
            // First-order high-pass by the bilinear transform, its corner where the analogue one has it.
            couplings: self
                .corners_hz
                .iter()
                .map(|corner_hz| HighPass::at(*corner_hz, rate))
                .collect(),
            out: 0.0,
        }
    }
}

/// An output that plays: what it remembers from one sample to the next.
#[derive(Clone, Debug)]
pub(crate) struct OutputStream {
    volts: f64,
    noise_v: f64,
    gain: f64,
    limit_v: f64,
    step_v: f64,
    quadratic: f64,
    couplings: Vec<HighPass>,
    out: f64,
}

impl OutputStream {
    /// The effective voltage at the actuator, V, for the next sample of the drive (full scale = 1).
    pub(crate) fn next(&mut self, sample: f64, random: &mut Random) -> f64 {
        let dac = sample.clamp(-1.0, 1.0) * self.volts + self.noise_v * random.normal();
        let coupled = (self.couplings.iter_mut()).fold(dac, |v, pass| pass.next(v));
        let wanted = (coupled * self.gain).clamp(-self.limit_v, self.limit_v);
        self.out += (wanted - self.out).clamp(-self.step_v, self.step_v);
        self.out + self.quadratic * self.out * self.out / self.limit_v
    }
}

/// A high-pass of first order, sample by sample.
#[derive(Clone, Debug)]
struct HighPass {
    a: f64,
    b: f64,
    before: f64,
    out: f64,
}

impl HighPass {
    fn at(corner_hz: f64, rate: SampleRate) -> Self {
        let k = (TAU * corner_hz / rate.hz() / 2.0).tan();
        Self {
            a: (1.0 - k) / (1.0 + k),
            b: 1.0 / (1.0 + k),
            before: 0.0,
            out: 0.0,
        }
    }

    fn next(&mut self, sample: f64) -> f64 {
        self.out = self.b * (sample - self.before) + self.a * self.out;
        self.before = sample;
        self.out
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::parameters::TwinParameters;
    use piezotact::device::DeviceDescription;

    fn stage() -> OutputStage {
        let set = DeviceDescription::drv2667().at_usual_gain();
        OutputStage::new(&TwinParameters::built_in().output, &set)
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

    /// A device of one's own is played as it describes itself: its divider, its gain, its coupling, its limits.
    #[test]
    fn another_device_is_played_as_described() {
        let text = "name = 'own'\n[amplifier]\n[[amplifier.gains]]\nname = 'x10'\ngain = { ratio = 10 }\n\
            limit_v = 2.0\nslew = { v_per_s = 1e9 }\n[actuator]\ncapacitance_f = 1e-6\n\
            [input]\ndivider = 0.5\ncoupling = { high_pass_hz = 200 }\n";
        let own = DeviceDescription::from_toml(text).unwrap();
        let stage = OutputStage::new(&TwinParameters::built_in().output, &own.at_usual_gain());
        let played = |amplitude: f64| -> Vec<f64> {
            let drive: Vec<f64> = (0..48_000)
                .map(|i| amplitude * (TAU * 200.0 * f64::from(i) / 48_000.0).sin())
                .collect();
            let mut random = Random::stream(1, 1, "test");
            stage.voltage(&drive, SampleRate::new(48_000.0).unwrap(), &mut random)
        };
        let small = harmonic(&played(0.1)[24_000..], 200.0);
        // Half of √2 V times 10 times 1/√2 at the corner: 5 V at full scale, but for the corner of the PC's output.
        let expected = 0.1 * 5.0 * (1.0 + (8.0_f64 / 200.0).powi(2)).sqrt().recip();
        assert!((small / expected - 1.0).abs() < 1e-3, "{small}");
        let loud = played(1.0);
        assert!((piezotact::statistics::peak(&loud) - 2.0 * 1.02).abs() < 1e-6);
        assert_eq!(stage.setup().load_f, Some(1e-6));
        assert!((stage.setup().drive_limit() - 0.2 / (2f64.sqrt() * 0.5)).abs() < 1e-12);
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
