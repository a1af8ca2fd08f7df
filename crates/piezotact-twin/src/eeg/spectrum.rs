//! The spectra of what an EEG is made of, and Gaussian noise of a given spectrum.

use std::sync::Arc;

use num_complex::Complex;
use piezotact::quantity::Band;
use piezotact_bench::random::Random;
use piezotact_fourier::{ComplexToReal, RealPlanner};

use crate::parameters::{EegBackground, EegMuscle};

/// The band in which the rms of a background is stated, Hz.
const BACKGROUND_HZ: [f64; 2] = [0.5, 100.0];
/// The midpoint rule of power in a band, steps.
const STEPS: usize = 2_000;

/// The one-sided PSD of a background of 1 V rms from 0.5 to 100 Hz at `frequency_hz`, V²/Hz: 1/f^β, flat below the knee.
pub(super) fn background(model: &EegBackground) -> impl Fn(f64) -> f64 + use<> {
    let (knee_hz, exponent) = (model.knee_hz, model.exponent);
    let shape = move |frequency_hz: f64| frequency_hz.max(knee_hz).powf(-exponent);
    let power = integral(BACKGROUND_HZ, shape);
    move |frequency_hz| shape(frequency_hz) / power
}

/// The one-sided PSD of alpha of 1 V rms, V²/Hz: white noise behind a band-pass of the second order,
/// (bf)²/((f₀² − f²)² + (bf)²), whose integral is πb/2.
pub(super) fn alpha(centre_hz: f64, bandwidth_hz: f64) -> impl Fn(f64) -> f64 {
    let power = std::f64::consts::FRAC_PI_2 * bandwidth_hz;
    move |frequency_hz| {
        let damping = (bandwidth_hz * frequency_hz).powi(2);
        let off = (centre_hz * centre_hz - frequency_hz * frequency_hz).powi(2);
        damping / (off + damping) / power
    }
}

/// The one-sided PSD of muscles of 1 V rms, V²/Hz: flat in their band.
pub(super) fn muscle(model: &EegMuscle) -> impl Fn(f64) -> f64 + use<> {
    let band = model.least_hz..=model.most_hz;
    let density = 1.0 / (model.most_hz - model.least_hz).max(1.0);
    move |frequency_hz| {
        if band.contains(&frequency_hz) {
            density
        } else {
            0.0
        }
    }
}

fn integral([low, high]: [f64; 2], density: impl Fn(f64) -> f64) -> f64 {
    let step = (high - low) / STEPS as f64;
    (0..STEPS)
        .map(|i| density(low + (i as f64 + 0.5) * step) * step)
        .sum()
}

/// The power in `band`, V².
pub(super) fn power_in(band: Band, density: impl Fn(f64) -> f64) -> f64 {
    integral([band.low().0, band.high().0], density)
}

/// Gaussian noise of one length and rate: the transform is planned once, and all draws share its buffers.
pub(super) struct Noise {
    length: usize,
    period: usize,
    rate_hz: f64,
    inverse: Arc<dyn ComplexToReal<f64>>,
    bins: Vec<Complex<f64>>,
    samples: Vec<f64>,
    scratch: Vec<Complex<f64>>,
}

/// The standard deviations of the two parts of each bin, for [`Noise::draw`].
pub(super) struct Amplitudes(Vec<f64>);

impl Noise {
    /// Noise of `length` samples at `rate_hz`.
    pub(super) fn of(length: usize, rate_hz: f64) -> Self {
        // Shorter than the period, so that its end does not continue at its beginning.
        let period = (length + 1).next_power_of_two();
        let inverse = RealPlanner::new().plan_fft_inverse(period);
        Self {
            length,
            period,
            rate_hz,
            bins: inverse.make_input_vec(),
            samples: inverse.make_output_vec(),
            scratch: inverse.make_scratch_vec(),
            inverse,
        }
    }

    /// The number of samples.
    pub(super) fn length(&self) -> usize {
        self.length
    }

    /// The amplitudes for the one-sided PSD `density`, V²/Hz; nothing at 0 Hz and half the rate.
    pub(super) fn amplitudes(&self, density: impl Fn(f64) -> f64) -> Amplitudes {
        let resolution_hz = self.rate_hz / self.period as f64;
        let inner = 1..self.period / 2;
        // A bin of two parts adds 4·sd² to the variance.
        Amplitudes(
            inner
                .map(|i| (density(i as f64 * resolution_hz) * resolution_hz).sqrt() / 2.0)
                .collect(),
        )
    }

    /// The noise of `amplitudes` that `random` draws, V.
    pub(super) fn draw(&mut self, mut random: Random, amplitudes: &Amplitudes) -> &[f64] {
        self.bins.fill(Complex::default());
        for (bin, sd) in self.bins.iter_mut().skip(1).zip(&amplitudes.0) {
            *bin = Complex::new(random.normal(), random.normal()) * *sd;
        }
        let done =
            self.inverse
                .process_with_scratch(&mut self.bins, &mut self.samples, &mut self.scratch);
        debug_assert!(done.is_ok());
        &self.samples[..self.length]
    }
}
