//! The experiment of the table that closed loops are measured against: a plant with two resonances, a deep notch, a
//! high-pass, a delay, a weak distortion, a clip at full scale and noise; five seeds, three levels.
#![allow(
    clippy::print_stdout,
    clippy::unwrap_used,
    reason = "a test stops where something is missing, and prints what it measured"
)]

use std::f64::consts::TAU;

use num_complex::Complex;
use piezotact::correct::{CorrectConfig, Correction, Mode};
use piezotact::quantity::{Acceleration, Band, Drive, Hertz, SampleRate};
use piezotact::render::{Inverse, RenderConfig, render};
use piezotact::series::{Series, peak, rms};
use piezotact::spectrum::{WelchConfig, WelchPlan};
use piezotact::transfer::{Estimator, TransferFunction, estimate};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use rustfft::FftPlanner;

const RATE_HZ: f64 = 5_000.0;

fn rate() -> SampleRate {
    SampleRate::new(RATE_HZ).unwrap()
}

fn band() -> Band {
    Band::new(Hertz(20.0), Hertz(1_000.0)).unwrap()
}

struct Noise(ChaCha8Rng);

impl Noise {
    fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    fn uniform(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 * 2f64.powi(-53)
    }

    fn next(&mut self) -> f64 {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        radius * (TAU * self.uniform()).cos()
    }
}

/// `x` with every line multiplied by `by` of its frequency; circular.
fn shaped(x: &[f64], by: &dyn Fn(f64) -> Complex<f64>) -> Vec<f64> {
    let n = x.len();
    let mut plan = FftPlanner::new();
    let mut bins: Vec<Complex<f64>> = x.iter().map(|x| Complex::from(*x)).collect();
    plan.plan_fft_forward(n).process(&mut bins);
    for (k, bin) in bins.iter_mut().enumerate() {
        let signed = if 2 * k <= n {
            k as f64
        } else {
            k as f64 - n as f64
        };
        let hz = signed * RATE_HZ / n as f64;
        let h = by(hz.abs());
        *bin *= if hz < 0.0 { h.conj() } else { h };
    }
    plan.plan_fft_inverse(n).process(&mut bins);
    bins.iter().map(|b| b.re / n as f64).collect()
}

/// Resonances at 180 and 620 Hz, a notch of −35 dB at 420 Hz, a high-pass at 30 Hz, 0.6 ms of delay.
fn plant(hz: f64) -> Complex<f64> {
    let s = Complex::new(0.0, TAU * hz);
    let second = |f: f64, zeta: f64| {
        let w = TAU * f;
        Complex::from(w * w) / (s * s + s * (2.0 * zeta * w) + w * w)
    };
    let notch = {
        let w = TAU * 420.0;
        (s * s + s * (2.0 * 0.04 * 0.0178 * w) + w * w) / (s * s + s * (2.0 * 0.04 * w) + w * w)
    };
    let high = s / (s + TAU * 30.0);
    GAIN * (1.0 + second(180.0, 0.08) + second(620.0, 0.08))
        * notch
        * high
        * Complex::from_polar(1.0, -TAU * hz * 0.6e-3)
}

/// So that plain division asks for 4.2 times full scale at the highest level, as the table says.
const GAIN: f64 = 0.22;

/// What the plant answers: clip, weak square and cube, the linear part, noise.
fn answer(drive: &[f64], noise: &mut Noise) -> Vec<f64> {
    let bent: Vec<f64> = drive
        .iter()
        .map(|u| u.clamp(-1.0, 1.0))
        .map(|u| u + 0.02 * u * u - 0.02 * u * u * u)
        .collect();
    shaped(&bent, &plant)
        .iter()
        .map(|y| y + 1e-3 * noise.next())
        .collect()
}

/// Eight seconds of random drive.
fn characterised(seed: u64) -> TransferFunction<Drive, Acceleration> {
    let mut noise = Noise::new(seed);
    let white: Vec<f64> = (0..40_000).map(|_| noise.next()).collect();
    let drive = shaped(&white, &|hz| {
        Complex::from(if (2.0..1_200.0).contains(&hz) {
            1.0
        } else {
            0.0
        })
    });
    let scale = 0.8 / peak(&drive);
    let drive: Vec<f64> = drive.iter().map(|x| x * scale).collect();
    let response = answer(&drive, &mut noise);
    estimate(
        &Series::<Drive>::new(drive, rate()).unwrap(),
        &Series::<Acceleration>::new(response, rate()).unwrap(),
        &WelchConfig::hann(2_048),
        Estimator::H1,
    )
    .unwrap()
}

/// Ten seconds of a broad texture with a rms of `level`.
fn texture(level: f64, seed: u64) -> Series<Acceleration> {
    let mut noise = Noise::new(1_000 + seed);
    let white: Vec<f64> = (0..50_000).map(|_| noise.next()).collect();
    let shape = |hz: f64| {
        let (low, high) = ((hz / 45.0).powi(2), (hz / 220.0).powi(4));
        Complex::from(if band().contains(hz) {
            (low / (1.0 + low) / (1.0 + high)).sqrt()
        } else {
            0.0
        })
    };
    let x = shaped(&white, &shape);
    let scale = level / rms(&x);
    Series::new(x.iter().map(|x| x * scale).collect(), rate()).unwrap()
}

/// The error of the PSD within the band, dB: rms and largest, on Hann segments of 1024.
fn error(target: &[f64], measured: &[f64]) -> (f64, f64) {
    let mut plan = WelchPlan::new(&WelchConfig::hann(1_024), rate()).unwrap();
    let wanted = plan.estimate::<Acceleration>(&[target]).unwrap();
    let got = plan.estimate::<Acceleration>(&[measured]).unwrap();
    let errors: Vec<f64> = wanted
        .frequencies_hz()
        .iter()
        .zip(wanted.values.iter().zip(&got.values))
        .filter(|(hz, _)| band().contains(**hz))
        .map(|(_, (t, m))| 10.0 * (m / t).log10())
        .collect();
    (
        rms(&errors),
        errors.iter().fold(0.0, |most: f64, e| most.max(e.abs())),
    )
}

fn played(drive: &Series<Drive>, lead: usize, length: usize, noise: &mut Noise) -> Vec<f64> {
    let response = answer(drive.samples(), noise);
    response[lead..lead + length].to_vec()
}

/// Ten steps of a loop: the best of what a second measurement of each drive says, dB rms and largest.
fn looped(mode: Mode, level: f64, seed: u64) -> (f64, f64) {
    let function = characterised(seed);
    let target = texture(level, seed);
    let mut config = RenderConfig::over(band(), rate());
    config.inverse.inverse = Inverse::Plain;
    let mut correction =
        Correction::new(&target, &function, &config, &CorrectConfig::usual(mode)).unwrap();
    let mut noise = Noise::new(7_000 + seed);
    let silence = answer(&vec![0.0; 50_000], &mut noise);
    let quiet = WelchPlan::new(correction.welch(), rate())
        .unwrap()
        .estimate::<Acceleration>(&[&silence])
        .unwrap();
    let (lead, length) = (correction.lead(), target.samples().len());
    let mut best = (f64::INFINITY, f64::INFINITY);
    for _ in 0..=10 {
        let drive = correction.drive().unwrap();
        let measured = played(&drive, lead, length, &mut noise);
        let again = played(&drive, lead, length, &mut noise);
        let found = error(correction.target(), &again);
        if found.0 < best.0 {
            best = found;
        }
        correction.learn(&measured, &quiet.values).unwrap();
    }
    best
}

/// The table's own figures, dB rms and largest: the best closed loop, at 0.25, 0.10 and 0.05.
const TABLE: [(f64, f64, f64); 3] = [(0.25, 3.1, 17.7), (0.10, 1.4, 8.6), (0.05, 0.21, 1.3)];

/// The plant is written from the table's description, which leaves widths and noise open: plain division does better on it
/// than in the table (2.3 dB rms for 5.6 at the highest level), so it is the milder one.
#[test]
fn closed_loops_beat_the_table_on_its_own_plant() {
    for (level, table_rms, table_max) in TABLE {
        let (mut sums, mut plain) = ([(0.0, 0.0); 2], (0.0, 0.0, 0.0));
        for seed in 1..=5 {
            for (sum, mode) in sums.iter_mut().zip([Mode::Replicate, Mode::Texture]) {
                let (rms_db, max_db) = looped(mode, level, seed);
                sum.0 += rms_db / 5.0;
                sum.1 += max_db / 5.0;
            }
            let (function, target) = (characterised(seed), texture(level, seed));
            let mut config = RenderConfig::over(band(), rate());
            config.inverse.inverse = Inverse::Plain;
            config.clipping = piezotact::render::Clipping::Allow;
            let rendered = render(&target, &function, &config).unwrap();
            let lead = rate().samples_in(config.modelling_delay);
            let measured = played(
                &rendered.drive,
                lead,
                target.samples().len(),
                &mut Noise::new(seed),
            );
            let (rms_db, max_db) = error(target.samples(), &measured);
            plain.0 += rms_db / 5.0;
            plain.1 += max_db / 5.0;
            plain.2 += rendered.headroom.peak / 5.0;
        }
        println!(
            "{level}: plain division {:.2}/{:.1} dB asks for {:.1} of full scale; replicate {:.2}/{:.1}; texture {:.2}/{:.1}; table {table_rms}/{table_max}",
            plain.0, plain.1, plain.2, sums[0].0, sums[0].1, sums[1].0, sums[1].1
        );
        assert!(sums[1].0 < table_rms && sums[1].1 < table_max, "{sums:?}");
    }
}
