//! Estimators against SciPy on cases that the reference files do not hold; made by `golden/spectrum.py`.
#![allow(
    clippy::unwrap_used,
    clippy::print_stderr,
    reason = "a test fails where it cannot go on"
)]

use piezotact::quantity::{Acceleration, SampleRate};
use piezotact::series::Series;
use piezotact::spectrum::{
    Averaging, Cells, Detrend, Scaling, SpectrogramConfig, Symmetry, WelchConfig, Window,
    amplitude_spectrum, spectrogram, welch,
};
use serde::Deserialize;

#[derive(Deserialize)]
struct Golden {
    rate_hz: f64,
    x: Vec<f64>,
    cases: Vec<Case>,
    spectrograms: Vec<SpectrogramCase>,
    symmetric: std::collections::BTreeMap<String, Vec<f64>>,
    amplitude_spectrum_of_399: Vec<f64>,
}

#[derive(Deserialize)]
struct Case {
    window: String,
    segment: usize,
    overlap: f64,
    detrend: Detrend,
    averaging: Averaging,
    scaling: Scaling,
    values: Vec<f64>,
}

#[derive(Deserialize)]
struct SpectrogramCase {
    window: String,
    segment: usize,
    overlap: f64,
    detrend: Detrend,
    frequencies_hz: Vec<f64>,
    times_s: Vec<f64>,
    values: Vec<f64>,
}

fn golden() -> Golden {
    serde_json::from_str(include_str!("golden/spectrum.json")).unwrap()
}

/// The worst error relative to each value; values below 1e-12 of the largest are rounding of a bin that
/// detrending has emptied, and are compared with the largest.
fn worst(got: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(got.len(), expected.len());
    let largest = expected
        .iter()
        .fold(0.0f64, |largest, v| largest.max(v.abs()));
    got.iter()
        .zip(expected)
        .map(|(g, e)| (g - e).abs() / e.abs().max(1e-12 * largest))
        .fold(0.0, f64::max)
}

#[test]
fn every_setting_equals_scipy() {
    let golden = golden();
    let x =
        Series::<Acceleration>::new(golden.x, SampleRate::new(golden.rate_hz).unwrap()).unwrap();
    for case in golden.cases {
        let config = WelchConfig {
            window: case.window.parse().unwrap(),
            symmetry: Symmetry::Periodic,
            segment: case.segment,
            overlap: case.overlap,
            detrend: case.detrend,
            averaging: case.averaging,
            scaling: case.scaling,
        };
        let error = worst(&welch(&x, &config).unwrap().values, &case.values);
        eprintln!("{config:?}: {error:.1e}");
        // Two FFTs that sum in another order, on numbers of one size.
        assert!(error < 1e-10, "{config:?}: {error:e}");
    }
}

#[test]
fn spectrograms_equal_scipy() {
    let golden = golden();
    let x =
        Series::<Acceleration>::new(golden.x, SampleRate::new(golden.rate_hz).unwrap()).unwrap();
    for case in golden.spectrograms {
        let config = SpectrogramConfig {
            window: case.window.parse().unwrap(),
            symmetry: Symmetry::Periodic,
            segment: case.segment,
            overlap: case.overlap,
            detrend: case.detrend,
            cells: Cells::All,
        };
        let result = spectrogram(&x, &config).unwrap();
        let error = worst(&result.values, &case.values);
        eprintln!("{config:?}: {error:.1e}");
        // Two FFTs that sum in another order: 1e-16 of the largest amplitude, on cells of 3e-4 of it (1e-7 in
        // power) and more, of which none is averaged.
        assert!(error < 1e-11, "{config:?}: {error:e}");
        // The same quotients, but for their last digit.
        assert!(worst(&result.times_s, &case.times_s) < 1e-15);
        assert!(worst(&result.frequencies_hz[1..], &case.frequencies_hz[1..]) < 1e-15);
    }
}

#[test]
fn windows_equal_scipy() {
    for (name, expected) in golden().symmetric {
        let window: Window = name.parse().unwrap();
        let coefficients = window.coefficients(9, Symmetry::Symmetric);
        // Values between 0 and 1: compared as they are, the ends of a Hann window are 0 but for rounding.
        let error = coefficients
            .iter()
            .zip(&expected)
            .map(|(w, e)| (w - e).abs())
            .fold(0.0, f64::max);
        assert!(error < 1e-15, "{name}: {error:e}");
    }
}

#[test]
fn the_amplitude_spectrum_equals_numpy() {
    let golden = golden();
    let rate = SampleRate::new(golden.rate_hz).unwrap();
    let x = Series::<Acceleration>::new(golden.x[..399].to_vec(), rate).unwrap();
    let (frequencies_hz, amplitudes) = amplitude_spectrum(&x);
    assert!((frequencies_hz[1] - 1000.0 / 399.0).abs() < 1e-12);
    assert!(worst(&amplitudes, &golden.amplitude_spectrum_of_399) < 1e-10);
}
