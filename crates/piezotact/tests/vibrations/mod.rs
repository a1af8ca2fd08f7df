//! Vibrations to score: noise with a shape, and measured ones.
#![allow(dead_code, reason = "its two users need other parts of it")]
#![allow(
    clippy::disallowed_methods,
    clippy::unwrap_used,
    reason = "a test reads measured files, and fails where it cannot go on"
)]

use std::f64::consts::TAU;

use num_complex::Complex;
use piezotact::Series;
use piezotact::quantity::{Acceleration, Band, Hertz, SampleRate};
use piezotact::score::{Score, ScoreConfig, ScoreModel, score};
use piezotact_fourier::ComplexPlanner;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

pub(crate) const RATE_HZ: f64 = 5000.0;
pub(crate) const THIRTY_S: usize = 150_000;

pub(crate) fn series(samples: Vec<f64>) -> Series<Acceleration> {
    Series::new(samples, SampleRate::new(RATE_HZ).unwrap()).unwrap()
}

pub(crate) fn config() -> ScoreConfig {
    let band = Band::new(Hertz(20.0), Hertz(1000.0)).unwrap();
    ScoreConfig::over(band, RATE_HZ)
}

pub(crate) fn scored(reference: &Series<Acceleration>, test: &Series<Acceleration>) -> Score {
    score(reference, test, &config()).unwrap()
}

/// By the difference of the spectra.
pub(crate) fn scored_by_spectra(
    reference: &Series<Acceleration>,
    test: &Series<Acceleration>,
) -> Score {
    let config = ScoreConfig {
        judged_by: ScoreModel::Spectral,
        ..config()
    };
    score(reference, test, &config).unwrap()
}

pub(crate) struct Random(ChaCha8Rng);

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    pub(crate) fn uniform(&mut self) -> f64 {
        ((self.0.next_u64() >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    }

    pub(crate) fn normal(&mut self) -> f64 {
        (-2.0 * self.uniform().ln()).sqrt() * (TAU * self.uniform()).cos()
    }
}

/// Sets the bins above 0 Hz of a real signal: `change(f, bin)`.
pub(crate) fn filtered(
    samples: &[f64],
    mut change: impl FnMut(f64, Complex<f64>) -> Complex<f64>,
) -> Vec<f64> {
    let n = samples.len();
    let mut planner = ComplexPlanner::new();
    let mut bins: Vec<Complex<f64>> = samples.iter().map(|v| Complex::new(*v, 0.0)).collect();
    planner.plan_fft_forward(n).process(&mut bins);
    for k in 1..n.div_ceil(2) {
        bins[k] = change(k as f64 * RATE_HZ / n as f64, bins[k]);
        bins[n - k] = bins[k].conj();
    }
    planner.plan_fft_inverse(n).process(&mut bins);
    bins.iter().map(|bin| bin.re / n as f64).collect()
}

/// The amplitude of a texture: two broad humps, as sliding fingers make, over a floor.
pub(crate) fn humps(f: f64) -> f64 {
    let hump = |centre: f64, width: f64| (-((f / centre).ln() / width).powi(2)).exp();
    0.03 + hump(70.0, 0.5) + 0.8 * hump(210.0, 0.4)
}

/// Gaussian noise with the amplitudes `shape(f)`, `rms_m_s2` strong in the mean over realisations.
pub(crate) fn texture(
    seed: u64,
    samples: usize,
    rms_m_s2: f64,
    shape: impl Fn(f64) -> f64,
) -> Series<Acceleration> {
    let mut random = Random::new(seed);
    let white: Vec<f64> = (0..samples).map(|_| random.normal()).collect();
    let mut power = 0.0;
    let coloured = filtered(&white, |f, bin| {
        let gain = if f > 15.0 { shape(f) } else { 0.0 };
        power += 2.0 * gain * gain / samples as f64;
        bin * gain
    });
    let gain = rms_m_s2 / power.sqrt();
    series(coloured.iter().map(|v| v * gain).collect())
}

/// A mono WAV file of 16-bit integers as shares of full scale, and its rate.
pub(crate) fn read_wav(path: &std::path::Path) -> (Vec<f64>, f64) {
    let bytes = std::fs::read(path).unwrap();
    let number = |at: usize| u32::from_le_bytes(bytes[at..at + 4].try_into().unwrap());
    assert_eq!(bytes[20..24], [1, 0, 1, 0], "mono, integers");
    let data = bytes.windows(4).position(|w| w == b"data").unwrap();
    let end = (data + 8 + number(data + 4) as usize).min(bytes.len());
    let samples = bytes[data + 8..end].chunks_exact(2);
    let samples = samples.map(|b| f64::from(i16::from_le_bytes([b[0], b[1]])) / 32_768.0);
    (samples.collect(), f64::from(number(24)))
}
