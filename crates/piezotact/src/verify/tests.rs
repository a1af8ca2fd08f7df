//! Tests with known delays, signs, levels and limits.

use crate::recording::{RecordingWarning, ReversedSign};
use crate::verify::VerifyWarning;
use std::f64::consts::TAU;

use num_complex::Complex;

use super::*;
use crate::clipping::flat_top_fraction;
use crate::quantity::{Acceleration, Drive, Hertz, SampleRate, Seconds};
use crate::transfer::{Estimator, TransferFunction};

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
    for delay_s in [0.01234, 0.00005, -0.00777] {
        let mut measured = texture(20_000, delay_s, 1.0).into_samples();
        // No sensor is without noise: what has none is a copy.
        for (i, v) in measured.iter_mut().enumerate() {
            *v += 0.05 * (i as f64 * i as f64 * 0.37).sin();
        }
        let v = judged(&texture(20_000, 0.0, 1.0), &series(measured));
        assert!(
            (v.delay_s - delay_s).abs() < 2e-6,
            "{delay_s}: {}",
            v.delay_s
        );
        // A measurement that starts or ends elsewhere lacks a part: what is shared is the same.
        assert!(
            v.verdict == Verdict::Passed && v.waveform_correlation > 0.999,
            "{delay_s}: {}",
            v.sentence()
        );
    }
}

/// A target of 31 to 497 Hz has no lines in half of the band up to 970 Hz: the conclusion says so, whatever the verdict.
#[test]
fn the_conclusion_says_how_much_of_the_band_could_not_be_evaluated() {
    let (target, measured) = (texture(20_000, 0.0, 1.0), texture(20_000, 0.003, 1.0));
    let over = |high_hz: f64| {
        let band = Band::new(Hertz(30.0), Hertz(high_hz)).unwrap();
        let config = VerifyConfig::over(band, RATE_HZ);
        verify(&target, Measured::alone(&measured), &config).unwrap()
    };
    let [all, half] = [500.0, 970.0].map(over);
    assert!(
        !all.sentence().contains("could not be evaluated"),
        "{}",
        all.sentence()
    );
    assert!((0.45..0.55).contains(&half.left_out), "{}", half.left_out);
    let share = format!(
        " over 30–970 Hz ({:.0} % of the lines of the band could not be evaluated): ",
        half.left_out * 100.0
    );
    assert!(half.sentence().contains(&share), "{}", half.sentence());
}

#[test]
fn a_level_is_a_level_and_not_a_shape() {
    let v = judged(&texture(20_000, 0.0, 1.0), &texture(20_000, 0.0, 2.0));
    let doubled_db = 20.0 * 2f64.log10();
    assert!((v.level_error_db - doubled_db).abs() < 1e-9);
    assert!((v.error_db_rms - doubled_db).abs() < 1e-9 && v.error_db_rms_level_matched < 1e-9);
    assert!(!v.passed() && (v.waveform_correlation - 1.0).abs() < 1e-9);
}

/// A tone delayed by half a sample has its minimum on a sample and its maximum between two.
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
            v.sentence()
        );
    }
}

#[test]
fn a_reversed_sign_is_said() {
    let v = judged(&texture(20_000, 0.0, 1.0), &texture(20_000, 0.004, -1.0));
    assert!(v.waveform_correlation < -0.99 && !v.passed());
    assert!(v.warnings.iter().any(|warning| matches!(
        warning.kind(),
        Some(RecordingWarning::Sign {
            of: ReversedSign::Measurement { .. }
        })
    )));
}

#[test]
fn a_measurement_that_ends_early_is_cut_and_said() {
    let v = judged(&texture(20_000, 0.0, 1.0), &texture(12_000, 0.0, 1.0));
    assert!(
        v.warnings
            .iter()
            .any(|warning| matches!(warning.kind(), Some(VerifyWarning::Cut { .. }))),
        "{:?}",
        v.warnings
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
    // Silence that flickers between two steps of a converter.
    let flicker: Vec<f64> = (0..5_000_u64)
        .map(|i| if i * i * 7919 % 1000 < 300 { 1e-3 } else { 0.0 })
        .collect();
    let found = flat_top_fraction(&[&flicker, clipped.as_slice(), &clipped].concat());
    assert!((found - share * 2.0 / 3.0).abs() < 1e-12, "{found}");
    // A coarse converter holds still on every step, at the limit and elsewhere.
    for steps in [1.0, 2.0, 5.0, 40.0] {
        let coarse: Vec<f64> = sine.iter().map(|v| (v * steps).round()).collect();
        assert_eq!(flat_top_fraction(&coarse), 0.0, "{steps} steps");
    }
}

/// A direct path and one echo, the second five samples later: a filter that is known without any transform.
const ECHO: (f64, f64, usize) = (0.8, 0.6, 5);

fn echoed(samples: &[f64]) -> Vec<f64> {
    let (direct, echo, later) = ECHO;
    let at = |i: usize| if i < samples.len() { samples[i] } else { 0.0 };
    (0..samples.len() + later)
        .map(|i| {
            direct * at(i)
                + if i >= later {
                    echo * at(i - later)
                } else {
                    0.0
                }
        })
        .collect()
}

fn echoing() -> TransferFunction<Drive, Acceleration> {
    let resolution_hz = RATE_HZ / 4096.0;
    let response: Vec<Complex<f64>> = (0..=2048)
        .map(|k| {
            let phase = -TAU * f64::from(k) * resolution_hz * ECHO.2 as f64 / RATE_HZ;
            ECHO.0 + Complex::from_polar(ECHO.1, phase)
        })
        .collect();
    let coherence = vec![1.0; response.len()];
    let rate = SampleRate::new(RATE_HZ).unwrap();
    TransferFunction::from_lines(response, coherence, resolution_hz, rate, Estimator::H1, 100)
        .unwrap()
}

/// Sent through the filter in time, sample by sample, and compared: the same error, level and correlation.
#[test]
fn what_is_sent_uncompensated_is_what_the_filter_makes_of_it() {
    let target = texture(40_000, 0.0, 1.0);
    let band = Band::new(Hertz(30.0), Hertz(500.0)).unwrap();
    let mut config = VerifyConfig::over(band, RATE_HZ);
    let filtered = series(echoed(target.samples()));
    let found = predict_uncompensated(&target, &echoing(), &config).unwrap();
    let v = verify(&target, Measured::alone(&filtered), &config).unwrap();
    let close = |a: f64, b: f64| (a - b).abs() < 5e-3;
    assert!(
        close(
            found.error_db_rms_level_matched,
            v.error_db_rms_level_matched
        ),
        "{} {}",
        found.error_db_rms_level_matched,
        v.error_db_rms_level_matched
    );
    assert!(found.error_db_rms_level_matched > 1.0);
    assert!(close(found.waveform_correlation, v.waveform_correlation));
    let mean_db = v.error_db.iter().sum::<f64>() / v.error_db.len() as f64;
    assert!(close(found.level_difference_db, mean_db));
    // Matching removes an intentional change of level.
    config.level = Decibels(-12.0);
    assert_eq!(
        predict_uncompensated(&target, &echoing(), &config).unwrap(),
        found
    );
    // Where only a part is judged, that part is matched and judged.
    config.reached = vec![Band::new(Hertz(30.0), Hertz(60.0)).unwrap()];
    let part = predict_uncompensated(&target, &echoing(), &config).unwrap();
    assert!(part.error_db_rms_level_matched < 0.1, "{part:?}");
}

#[test]
fn nothing_is_predicted_beyond_what_was_excited() {
    let target = texture(20_000, 0.0, 1.0);
    let mut function = echoing();
    let band = |low, high| Band::new(Hertz(low), Hertz(high)).unwrap();
    function.excited = Some(band(100.0, 300.0));
    let over = |asked| {
        let config = VerifyConfig::over(asked, RATE_HZ);
        predict_uncompensated(&target, &function, &config)
    };
    assert_eq!(over(band(30.0, 500.0)).unwrap().band_hz, band(100.0, 300.0));
    assert!(matches!(
        over(band(400.0, 500.0)),
        Err(VerifyError::OutOfReach { .. })
    ));
}

/// The drive for a filter that only delays and doubles is the texture itself, aligned in time and at half the rms.
#[test]
fn a_drive_stands_on_the_time_of_its_texture() {
    let target = texture(20_000, 0.0, 1.0);
    let v = judged(&target, &texture(20_000, 0.02, 1.0));
    let rate = SampleRate::new(RATE_HZ).unwrap();
    let mut samples = vec![0.0; 1250];
    samples.extend(target.samples().iter().map(|v| 0.5 * v));
    samples.extend([0.0; 1250]);
    let drive = Series::<Drive>::new(samples, rate).unwrap();
    let both = beside(&v, &drive, Seconds(0.25)).unwrap();
    assert!((both.drive_rms / both.target_rms - 0.5).abs() < 1e-3);
    let worst = |a: &[f64], b: &[f64]| {
        let apart = a.iter().zip(b).map(|(a, b)| (a - b).abs());
        apart.fold(0.0, f64::max)
    };
    // What the band-pass does to silence and sound at the ends differs.
    let middle = 1000..19_000;
    assert!(worst(&both.target[middle.clone()], &both.drive[middle]) < 0.02);
    assert!((rms(&both.target) - 1.0).abs() < 1e-9);
    assert!(matches!(
        beside(&v, &drive, Seconds(5.0)),
        Err(VerifyError::TooShort { .. })
    ));
}

/// A sine stands at its amplitude, wherever it falls between the lines and however long the signal is.
#[test]
fn a_tone_stands_at_its_amplitude() {
    for (frequency_hz, samples) in [
        (100.0, 20_000),
        (123.456, 20_000),
        (61.7, 6_000),
        (480.3, 50_001),
    ] {
        let target = tones(&[frequency_hz], samples, 0.0, 1.3);
        let measured = tones(&[frequency_hz], samples, 0.0, 0.65);
        let found = super::tones(&judged(&target, &measured)).unwrap();
        let highest = |values: &[f64]| values.iter().copied().fold(0.0, f64::max);
        // 0.1 % of the window between two lines; the rest is what the band-pass takes at both ends.
        for (values, amplitude) in [(&found.target, 1.3), (&found.measured, 0.65)] {
            let ratio = highest(values) / amplitude;
            assert!((ratio - 1.0).abs() < 4e-3, "{frequency_hz} Hz: {ratio}");
        }
        let at = found
            .target
            .iter()
            .position(|v| *v >= highest(&found.target));
        let hz = found.frequency_hz[at.unwrap()];
        assert!((hz - frequency_hz).abs() <= found.frequency_hz[1]);
    }
}

#[test]
fn a_change_of_level_alone_keeps_the_shape() {
    let config = VerifyConfig::over(Band::new(Hertz(30.0), Hertz(500.0)).unwrap(), RATE_HZ);
    let before = texture(20_000, 0.0, 1.0);
    let louder = changed(&before, &texture(20_000, 0.0, 2.0), &config).unwrap();
    assert!((louder.level_db - 20.0 * 2f64.log10()).abs() < 1e-9);
    assert!(louder.shape_error_db_rms < 1e-9);
    assert!((louder.rms_after / louder.rms_before - 2.0).abs() < 1e-9);
    let other = series(echoed(before.samples()));
    assert!(
        changed(&before, &other, &config)
            .unwrap()
            .shape_error_db_rms
            > 1.0
    );
    let silent = changed(&series(vec![0.0; 20_000]), &before, &config);
    assert!(matches!(
        silent,
        Err(VerifyError::Silent {
            what: "the texture before",
            ..
        })
    ));
}
