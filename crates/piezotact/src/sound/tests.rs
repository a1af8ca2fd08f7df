use std::f64::consts::TAU;

use super::*;
use crate::quantity::{Hertz, SampleRate, Seconds, Unit};
use crate::statistics::random::Random;

fn rate() -> SampleRate {
    SampleRate::new(48_000.0).unwrap()
}

fn noise(count: usize, seed: u64) -> Vec<f64> {
    let mut random = Random::stream(seed, 0, "sound");
    (0..count).map(|_| random.normal()).collect()
}

#[test]
fn a_tone_is_found_beside_its_mean_another_tone_and_noise() {
    let hz = 159.2;
    let noise = noise(48_000, 1);
    let sample = |i: usize| {
        let t = i as f64 / 48_000.0;
        0.3 + 0.5 * (TAU * hz * t + 0.7).cos() + 0.02 * (TAU * 1000.0 * t).sin() + 1e-3 * noise[i]
    };
    let samples: Vec<f64> = (0..48_000).map(sample).collect();
    let found = tone(&samples, rate(), Hertz(hz)).unwrap();
    // 1 mV of noise over 48,000 samples moves an amplitude by 1e-3·√(2/48,000) = 6e-6; five times that.
    assert!((found.rms - 0.5 / 2f64.sqrt()).abs() < 3e-5, "{found:?}");
    assert!((found.phase_rad - 0.7).abs() < 1e-4, "{found:?}");
    assert!((found.mean - 0.3).abs() < 3e-5, "{found:?}");
    let left = (0.02f64.powi(2) / 2.0 + 1e-6).sqrt();
    assert!((found.residual_rms / left - 1.0).abs() < 0.01, "{found:?}");
    for (bad, hz) in [
        (&samples[..100], 159.2),
        (&samples[..], 24_000.0),
        (&samples[..], 0.0),
    ] {
        assert!(tone(bad, rate(), Hertz(hz)).is_err());
    }
    assert_eq!(
        tone(&[f64::NAN; 4800], rate(), Hertz(1000.0)),
        Err(SoundError::NotFinite { what: "signal" })
    );
}

#[test]
fn a_delay_is_found_to_the_sample_with_its_gain_and_polarity() {
    let drive = noise(5_000, 2);
    for (lag, gain) in [(0_i64, 1.0), (713, 0.5), (-250, -0.8), (4_000, 2.0)] {
        let at = |n: i64| {
            usize::try_from(n - lag)
                .ok()
                .and_then(|i| drive.get(i))
                .copied()
        };
        let recorded: Vec<f64> = (0..9_500).map(|n| gain * at(n).unwrap_or(0.0)).collect();
        let found = delay(&drive, &recorded).unwrap();
        assert_eq!(found.samples, lag, "{found:?}");
        assert!((found.gain - gain).abs() < 1e-12, "{found:?}");
        let residual = loop_residual(&drive, &recorded, &found, 1e-6);
        assert!(
            residual.largest < 1e-12 && residual.different == 0,
            "{residual:?}"
        );
    }
}

#[test]
fn another_signal_is_no_loopback() {
    let (drive, other) = (noise(5_000, 3), noise(9_000, 4));
    assert!(matches!(
        delay(&drive, &other),
        Err(SoundError::NotFound { .. })
    ));
    assert!(matches!(
        delay(&drive, &[0.0; 9_000]),
        Err(SoundError::Silent { what: "recording" })
    ));
}

#[test]
fn what_a_loopback_changed_is_counted() {
    let drive = noise(5_000, 5);
    let mut recorded = [vec![0.0; 100], drive.clone()].concat();
    recorded[1_100..1_270].fill(0.0);
    let found = delay(&drive, &recorded).unwrap();
    let residual = loop_residual(&drive, &recorded, &found, 0.01);
    // The gain of the whole is a little below 1, so that all samples differ a little.
    assert_eq!(found.samples, 100);
    assert!(residual.different > 100, "{residual:?}");
    assert_eq!(silent_runs(&recorded, 16), [[1_100, 1_270]]);
    assert!(silent_runs(&drive, 16).is_empty());
    assert!(silent_runs(&[0.0; 500], 16).is_empty());
}

#[test]
fn a_pulse_is_found_on_its_own_input() {
    let mut inputs: Vec<Vec<f64>> = (0..3)
        .map(|i| noise(4_800, 6 + i).iter().map(|v| 1e-4 * v).collect())
        .collect();
    inputs[1][2_500] = -0.25;
    let slices: Vec<&[f64]> = inputs.iter().map(Vec::as_slice).collect();
    let wire = wiring(2, 0.5, &slices, 2_400).unwrap();
    assert_eq!((wire.output, wire.input, wire.at_sample), (2, 2, 2_500));
    // Noise of 1e-4 rms on a peak of 0.25.
    assert!((wire.gain + 0.5).abs() < 2e-3, "{wire:?}");
    let quiet: Vec<&[f64]> = vec![&inputs[0], &inputs[2]];
    assert_eq!(
        wiring(2, 0.5, &quiet, 2_400),
        Err(SoundError::Nowhere { output: 2 })
    );
    let twice: Vec<&[f64]> = vec![&inputs[1], &inputs[0], &inputs[1]];
    assert_eq!(
        wiring(2, 0.5, &twice, 2_400),
        Err(SoundError::Several {
            output: 2,
            inputs: vec![1, 3]
        })
    );
}

#[test]
fn sensitivities_come_from_a_calibrator_or_a_data_sheet() {
    let of = || (2, "acceleration", Unit::MetrePerSecondSquared);
    let heard = Tone {
        rms: 0.05,
        phase_rad: 0.0,
        residual_rms: 1e-3,
        mean: 0.0,
    };
    let found = InputCalibration::by_exciter(of(), Exciter::handheld(), &heard, 0.08).unwrap();
    assert!((found.per_full_scale - 200.0).abs() < 1e-9, "{found:?}");
    // 10.2 mV per m/s² into 2 V at full scale.
    let stated = InputCalibration::stated(of(), 0.0102, 2.0).unwrap();
    assert!(
        (stated.per_full_scale - 196.078_431).abs() < 1e-6,
        "{stated:?}"
    );
    // 8 dB above the rest; 12 dB are enough.
    let weak = Tone {
        residual_rms: 0.02,
        ..heard
    };
    assert!(matches!(
        InputCalibration::by_exciter(of(), Exciter::handheld(), &weak, 0.08),
        Err(SoundError::NoTone { channel: 2, .. })
    ));
    assert!(matches!(
        InputCalibration::by_exciter(of(), Exciter::handheld(), &heard, 1.0),
        Err(SoundError::Clipped { .. })
    ));
    assert!(InputCalibration::stated(of(), 0.0, 2.0).is_err());
    let volts = OutputCalibration::by(VoltsMethod::Voltmeter {
        read_v_rms: 0.495,
        played_rms: 0.5,
    });
    assert!((volts.unwrap().v_per_full_scale - 0.99).abs() < 1e-12);
    let nothing = VoltsMethod::Loopback {
        input_v_per_full_scale: 0.0,
        gain: 1.0,
    };
    assert!(OutputCalibration::by(nothing).is_err());
}

fn calibration() -> SoundCalibration {
    SoundCalibration {
        device: "alsa hw:1".into(),
        made_on_day: 20_000,
        made_on: "2024-10-04".into(),
        rate_hz: rate(),
        output: None,
        loopback: Some(LoopbackLevel {
            frequency_hz: Hertz(1000.0),
            gain: 0.5,
        }),
        inputs: Vec::new(),
        wires: Vec::new(),
        warnings: Vec::new(),
    }
}

#[test]
fn a_level_that_changed_by_more_than_a_tenth_of_a_decibel_is_refused() {
    let stored = calibration();
    let off = |db: f64| 0.5 * 10f64.powf(db / 20.0);
    assert!(stored.level_holds(off(0.099)).is_ok());
    assert!(stored.level_holds(off(-0.099)).is_ok());
    assert!(stored.level_holds(off(0.101)).is_err());
    assert!(stored.level_holds(off(-0.101)).is_err());
    assert_eq!(stored.level_holds(-0.5), Err(SoundError::Inverted));
    assert!(stored.level_holds(0.0).is_err() && stored.level_holds(f64::NAN).is_err());
    assert!(stored.holds_for("alsa hw:1", rate()).is_ok());
    assert!(stored.holds_for("alsa hw:2", rate()).is_err());
    let [fresh, old, wrong] = [20_090, 20_091, 19_999].map(|day| stored.warnings_on(day).len());
    assert_eq!([fresh, old, wrong], [0, 1, 1]);
}

/// What was found with a calibrator in spring is as old in autumn, whatever was measured beside it.
#[test]
fn each_part_of_a_calibration_has_its_own_day() {
    let of = |channel| (channel, "acceleration", Unit::MetrePerSecondSquared);
    let mut stored = calibration();
    stored.inputs = vec![InputCalibration::stated(of(2), 0.0102, 2.0).unwrap()];
    let today = MadeOn {
        day: 20_100,
        date: "2025-01-12".into(),
    };
    let mut later = stored.renewed(today.clone());
    let said: Vec<String> = later
        .warnings_on(20_100)
        .iter()
        .map(ToString::to_string)
        .collect();
    assert!(
        said.len() == 1 && said[0].contains("input 2") && said[0].contains("2024-10-04"),
        "{said:?}"
    );
    // Renewed once more, it keeps the first day; made again, it has the new one.
    later = later.renewed(MadeOn {
        day: 20_101,
        ..today
    });
    assert_eq!(later.warnings_on(20_101).len(), 1);
    later.inputs = vec![InputCalibration::stated(of(2), 0.0102, 2.0).unwrap()];
    assert!(later.warnings_on(20_101).is_empty());
}

#[test]
fn a_sensitivity_that_is_not_the_calibrated_one_is_refused() {
    let of = (2, "acceleration", Unit::MetrePerSecondSquared);
    let mut stored = calibration();
    stored.inputs = vec![InputCalibration::stated(of, 0.0102, 2.0).unwrap()];
    assert!(stored.sensor_holds(2, Some(0.0102)).is_ok());
    assert!(stored.sensor_holds(3, Some(0.5)).is_ok(), "another input");
    for now in [Some(0.102), Some(-0.0102), Some(0.010_201), None] {
        let said = stored.sensor_holds(2, now).unwrap_err().to_string();
        assert!(said.contains("10.2 mV"), "{said}");
    }
    // A sensor on a calibrator needs no data sheet.
    let heard = Tone {
        rms: 0.05,
        phase_rad: 0.0,
        residual_rms: 1e-4,
        mean: 0.0,
    };
    let of = (2, "acceleration", Unit::MetrePerSecondSquared);
    let exciter = Exciter::handheld();
    stored.inputs = vec![InputCalibration::by_exciter(of, exciter, &heard, 0.1).unwrap()];
    assert!(stored.sensor_holds(2, None).is_ok());
}

#[test]
fn two_ways_that_contradict_each_other_are_a_warning() {
    let of = |found, other| {
        SoundCalibration::disagreement("volts", ("the voltmeter", found), ("the loopback", other))
    };
    assert!(of(1.0, 1.1).is_none() && of(-1.0, 1.0).is_none());
    let said = of(0.987, 10.0).unwrap().to_string();
    assert!(said.contains("−20.1 dB"), "{said}");
    assert!(of(1.0, 0.0).is_some() && of(f64::NAN, 1.0).is_some());
}

#[test]
fn a_latency_that_changed_is_a_warning() {
    let run = |ms: f64| LatencyRun {
        latency_s: Some(Seconds(ms * 1e-3)),
        gain: 1.0,
        drop_outs: 0,
    };
    let summary = LatencySummary::of("x", "2026-01-01", rate(), 256, vec![run(40.0), run(60.0)]);
    let changed = |ms: f64| summary.changed(Seconds(1e-3 * ms), Seconds(0.01)).is_some();
    assert_eq!(
        [29.0, 31.0, 50.0, 69.0, 71.0].map(changed),
        [true, false, false, false, true]
    );
    // Of one restart nothing is known of the spread; of equal ones, half a sample.
    let of = |runs: Vec<LatencyRun>| {
        LatencySummary::of("x", "2026-01-01", rate(), 256, runs).scatter_s()
    };
    assert_eq!(of(vec![run(40.0)]), None);
    assert_eq!(of(vec![run(40.0); 9]), Some(Seconds(0.5 / 48_000.0)));
}

#[test]
fn percentiles_of_latency_are_those_of_the_restarts() {
    let run = |ms: f64| LatencyRun {
        latency_s: Some(Seconds(ms * 1e-3)),
        gain: 1.0,
        drop_outs: 0,
    };
    let runs: Vec<LatencyRun> = (1..=100).rev().map(|i| run(f64::from(i))).collect();
    let summary = LatencySummary::of("loop", "2026-01-01", rate(), 256, runs);
    let found = summary.latency.unwrap();
    let ms = [found.median_s, found.p95_s, found.p99_s].map(|s| s.0 * 1e3);
    assert!(
        ms.iter()
            .zip([50.0, 95.0, 99.0])
            .all(|(a, b)| (a - b).abs() < 1e-9),
        "{ms:?}"
    );
    assert!(summary.warnings.is_empty());
    let lost = LatencyRun {
        latency_s: None,
        gain: 0.0,
        drop_outs: 2,
    };
    // A start that lost samples does not count beside others, and alone it does.
    let late = LatencyRun {
        drop_outs: 6,
        ..run(64.0)
    };
    let of = |runs: Vec<LatencyRun>| LatencySummary::of("loop", "2026-01-01", rate(), 256, runs);
    let mixed = of(vec![run(2.0), late, run(3.0)]);
    assert_eq!(mixed.latency.map(|all| all.range_s[1].0), Some(3e-3));
    assert_eq!((mixed.found(), of(vec![late]).found()), (2, 1));
    let few = LatencySummary::of("loop", "2026-01-01", rate(), 256, vec![lost; 3]);
    assert!(few.latency.is_none() && few.scatter_s().is_none());
    assert_eq!(few.warnings.len(), 2);
}
