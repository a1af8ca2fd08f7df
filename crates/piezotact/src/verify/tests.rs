//! Delays, signs, levels and limits that are known.

use std::f64::consts::TAU;

use super::*;
use crate::quantity::{Acceleration, SampleRate};

const RATE_HZ: f64 = 5000.0;

fn series(samples: Vec<f64>) -> Series<Acceleration> {
    Series::new(samples, SampleRate::new(RATE_HZ).unwrap()).unwrap()
}

/// A sum of tones inside the band, later by `delay_s`, so that any delay is exact.
fn tones(frequencies_hz: &[f64], samples: usize, delay_s: f64, gain: f64) -> Series<Acceleration> {
    let at = |i: usize| {
        let t_s = i as f64 / RATE_HZ - delay_s;
        frequencies_hz
            .iter()
            .enumerate()
            .map(|(j, f)| (TAU * f * t_s + j as f64).sin())
            .sum::<f64>()
            * gain
    };
    series((0..samples).map(at).collect())
}

fn texture(samples: usize, delay_s: f64, gain: f64) -> Series<Acceleration> {
    let frequencies_hz: Vec<f64> = (0..160).map(|j| 31.0 + 2.93 * f64::from(j)).collect();
    tones(&frequencies_hz, samples, delay_s, gain)
}

fn judged(target: &Series<Acceleration>, measured: &Series<Acceleration>) -> Verification {
    let config = VerifyConfig::over(Band::new(Hertz(30.0), Hertz(500.0)).unwrap(), RATE_HZ);
    verify(target, Measured::alone(measured), &config).unwrap()
}

#[test]
fn delays_are_found_to_a_fraction_of_a_sample_either_way() {
    for delay_s in [0.0, 0.01234, 0.00005, -0.00777] {
        let v = judged(&texture(20_000, 0.0, 1.0), &texture(20_000, delay_s, 1.0));
        assert!(
            (v.delay_s - delay_s).abs() < 2e-6,
            "{delay_s}: {}",
            v.delay_s
        );
        // A measurement that starts or ends elsewhere lacks a part: what is shared is the same.
        assert!(
            v.passed && v.waveform_correlation > 0.999,
            "{delay_s}: {}",
            v.verdict()
        );
    }
}

#[test]
fn a_level_is_a_level_and_not_a_shape() {
    let v = judged(&texture(20_000, 0.0, 1.0), &texture(20_000, 0.0, 2.0));
    let doubled_db = 20.0 * 2f64.log10();
    assert!((v.level_error_db - doubled_db).abs() < 1e-9);
    assert!((v.error_db_rms - doubled_db).abs() < 1e-9 && v.error_db_rms_level_matched < 1e-9);
    assert!(!v.passed && (v.waveform_correlation - 1.0).abs() < 1e-9);
}

/// Half a sample late, a tone has a trough on a sample beside its crest between two.
#[test]
fn a_tone_between_samples_is_not_taken_for_its_inverse() {
    for frequency_hz in [330.0, 440.0, 499.0] {
        let v = judged(
            &tones(&[frequency_hz], 20_000, 0.0, 1.0),
            &tones(&[frequency_hz], 20_000, 0.5 / RATE_HZ, 1.0),
        );
        assert!(
            v.waveform_correlation > 0.99,
            "{frequency_hz}: {}",
            v.verdict()
        );
    }
}

#[test]
fn a_reversed_sign_is_said() {
    let v = judged(&texture(20_000, 0.0, 1.0), &texture(20_000, 0.004, -1.0));
    assert!(v.waveform_correlation < -0.99 && !v.passed);
    assert!(
        v.doubts
            .iter()
            .any(|doubt| matches!(doubt, Doubt::Inverted { .. }))
    );
}

#[test]
fn a_measurement_that_ends_early_is_cut_and_said() {
    let v = judged(&texture(20_000, 0.0, 1.0), &texture(12_000, 0.0, 1.0));
    assert!(
        v.doubts
            .iter()
            .any(|doubt| matches!(doubt, Doubt::Cut { .. })),
        "{:?}",
        v.doubts
    );
    assert!(v.waveform_correlation > 0.99);
}

#[test]
fn flat_tops_are_counted_and_crests_are_not() {
    let sine: Vec<f64> = (0..5000)
        .map(|i| (TAU * 7.3 * f64::from(i) / 5000.0).sin())
        .collect();
    assert_eq!(flat_top_fraction(&sine), 0.0);
    let clipped: Vec<f64> = sine.iter().map(|v| v.clamp(-0.8, 0.8)).collect();
    let share = clipped.iter().filter(|v| v.abs() >= 0.8).count() as f64 / 5000.0;
    assert!((flat_top_fraction(&clipped) - share).abs() < 1e-12);
    assert_eq!(flat_top_fraction(&[0.0; 10]), 0.0);
    // Digital silence before and after, longer than all that is clipped.
    let silence = vec![0.0; 10_000];
    let found = flat_top_fraction(&[&silence, clipped.as_slice(), &silence].concat());
    assert!((found - share / 5.0).abs() < 1e-12, "{found}");
    // A coarse converter holds still on every step, at the limit and elsewhere.
    for steps in [1.0, 2.0, 5.0, 40.0] {
        let coarse: Vec<f64> = sine.iter().map(|v| (v * steps).round()).collect();
        assert_eq!(flat_top_fraction(&coarse), 0.0, "{steps} steps");
    }
}
