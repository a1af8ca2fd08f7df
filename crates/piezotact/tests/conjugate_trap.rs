//! The conjugate trap: with the transfer function's conjugate, as the thesis' eq. 7 writes it, the spectrum of
//! what is felt overlaps its target and the waveform is lost. Verification must see it.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use num_complex::Complex;
use piezotact::quantity::{Acceleration, Band, Drive, Hertz, SampleRate};
use piezotact::render::{InverseConfig, invert};
use piezotact::series::Series;
use piezotact::transfer::{Estimator, TransferFunction};
use piezotact::verify::{Measured, VerifyConfig, verify};
use piezotact_fourier::RealPlanner;
use proptest::prelude::*;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

const RATE_HZ: f64 = 5000.0;
const SAMPLES: usize = 20_000;
/// Lines every 0.25 Hz: the plant is known exactly where the texture has its bins.
const LINES: usize = SAMPLES / 2 + 1;

/// A resonance inside the band, so that the phase turns, with a delay.
#[derive(Clone, Copy, Debug)]
struct Plant {
    resonance_hz: f64,
    damping: f64,
    delay_s: f64,
}

impl Plant {
    fn at(&self, frequency_hz: f64) -> Complex<f64> {
        let s = Complex::new(0.0, frequency_hz / self.resonance_hz);
        let mode = 1.0 / (s * s + 2.0 * self.damping * s + 1.0);
        mode * Complex::from_polar(1.0, -std::f64::consts::TAU * frequency_hz * self.delay_s)
    }

    fn function(&self, conjugate: Conjugate) -> TransferFunction<Drive, Acceleration> {
        let lines = (0..LINES).map(|k| self.at(k as f64 * RATE_HZ / SAMPLES as f64));
        let lines = lines
            .map(|h| {
                if conjugate == Conjugate::Yes {
                    h.conj()
                } else {
                    h
                }
            })
            .collect();
        let rate = SampleRate::new(RATE_HZ).unwrap();
        let step_hz = RATE_HZ / SAMPLES as f64;
        TransferFunction::from_lines(lines, vec![1.0; LINES], step_hz, rate, Estimator::H1, 100)
            .unwrap()
    }

    /// What the plant does with a drive, circular as the drive is.
    fn feel(&self, drive: &[f64]) -> Vec<f64> {
        let mut planner = RealPlanner::new();
        let (forward, inverse) = (
            planner.plan_fft_forward(SAMPLES),
            planner.plan_fft_inverse(SAMPLES),
        );
        let (mut input, mut bins) = (drive.to_vec(), forward.make_output_vec());
        forward.process(&mut input, &mut bins).unwrap();
        for (k, bin) in bins.iter_mut().enumerate() {
            *bin *= self.at(k as f64 * RATE_HZ / SAMPLES as f64) / SAMPLES as f64;
        }
        bins[0].im = 0.0;
        bins[SAMPLES / 2].im = 0.0;
        let mut out = inverse.make_output_vec();
        inverse.process(&mut bins, &mut out).unwrap();
        out
    }
}

#[derive(Clone, Copy, PartialEq)]
enum Conjugate {
    Yes,
    No,
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]
    #[test]
    fn a_conjugate_keeps_the_spectrum_and_fails(
        resonance_hz in 150.0..400.0f64,
        damping in 0.08..0.4f64,
        delay_s in 0.0..4e-3f64,
        seed: u64,
    ) {
        let plant = Plant { resonance_hz, damping, delay_s };
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut noise = || (random.next_u64() >> 11) as f64 / (1u64 << 53) as f64 - 0.5;
        let rate = SampleRate::new(RATE_HZ).unwrap();
        let texture: Vec<f64> = (0..SAMPLES).map(|_| noise()).collect();
        let target = Series::<Acceleration>::new(texture, rate).unwrap();
        let band = Band::new(Hertz(20.0), Hertz(600.0)).unwrap();
        let judge = |conjugate| {
            let function = plant.function(conjugate);
            let drive = invert(target.samples(), rate, &function, &InverseConfig::over(band)).unwrap();
            let felt = Series::new(plant.feel(&drive), rate).unwrap();
            let config = VerifyConfig::over(Band::new(Hertz(30.0), Hertz(500.0)).unwrap(), RATE_HZ);
            verify(&target, Measured::alone(&felt), &config).unwrap()
        };
        let (right, wrong) = (judge(Conjugate::No), judge(Conjugate::Yes));
        prop_assert!(right.passed(), "{plant:?}: {}", right.sentence());
        prop_assert!(right.waveform_correlation > 0.999);
        prop_assert!(!wrong.passed(), "{plant:?}: {}", wrong.sentence());
        prop_assert!(wrong.waveform_correlation < 0.95);
        // And the spectrum alone would have passed.
        prop_assert!(wrong.error_db_rms < 1.0, "{plant:?}: {}", wrong.sentence());
    }
}
