//! Halves of one recording are one vibration: `score` does not call them distinguishable.
#![allow(
    clippy::disallowed_methods,
    clippy::print_stderr,
    clippy::unwrap_used,
    reason = "a test reads measured files, prints what it measured, and fails where it cannot go on"
)]

use crate::shared_data::shared;
use crate::vibrations::{RATE_HZ, Random, config, humps, read_wav, scored, texture};
use piezotact::Series;
use piezotact::quantity::{Acceleration, SampleRate};
use piezotact::score::{ScoreConfig, Verdict, score};

/// The halves of `x`.
fn halves(x: &[f64], rate_hz: f64) -> [Series<Acceleration>; 2] {
    let rate = SampleRate::new(rate_hz).unwrap();
    let (first, second) = x.split_at(x.len() / 2);
    [first, &second[..first.len()]].map(|half| Series::new(half.to_vec(), rate).unwrap())
}

/// Strokes that begin and end softly are no stationary noise.
#[test]
fn halves_of_measured_recordings_are_not_distinguishable() {
    let (mut scored, mut told) = (0, Vec::new());
    for texture in ["text3", "text9"] {
        for part in ["ref", "v1", "v2", "v3", "v4"] {
            let Some(path) = shared(&format!("data/vibration/textsense/{texture}_{part}.wav"))
            else {
                return;
            };
            let (samples, rate_hz) = read_wav(&path);
            let mean = piezotact::statistics::mean(&samples);
            // Full scale is not stated: they are brought to 2 m/s² rms.
            let gain = 2.0 / piezotact::statistics::standard_deviation(&samples);
            let all: Vec<f64> = samples.iter().map(|v| gain * (v - mean)).collect();
            let [a, b] = halves(&all, rate_hz);
            let config = ScoreConfig::over(config().band, rate_hz);
            // Halves of the shortest last 0.43 s.
            let s = score(&a, &b, &config).unwrap();
            eprintln!(
                "halves of {texture}_{part}, {:.2} s each: {}",
                a.duration().0,
                s.sentence
            );
            if matches!(s.verdict, Verdict::Distinguishable { .. }) {
                told.push((texture, part));
            }
            scored += 1;
        }
    }
    assert!(told.is_empty(), "{told:?}");
    assert_eq!(scored, 10);
}

/// Noise whose level wanders, as a random walk does or in one direction, is not told apart from itself; noise that does not
/// wander is still below the JND.
#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_halves_of_noise_that_wanders_are_not_distinguishable() {
    let wandering = |seed: u64, seconds: usize, walk_db: f64, drift_db: f64| -> Vec<f64> {
        let x = texture(seed, seconds * 5000, 3.0, humps);
        let mut random = Random::new(seed + 900);
        let mut level_db = 0.0;
        let steps = 20.0 * seconds as f64;
        let mut out = Vec::with_capacity(x.samples().len());
        for (i, cut) in x.samples().chunks(250).enumerate() {
            level_db += walk_db * random.normal() / steps.sqrt();
            let gain = 10f64.powf((level_db + drift_db * i as f64 / steps) / 20.0);
            out.extend(cut.iter().map(|v| v * gain));
        }
        out
    };
    for (what, walk_db, drift_db, most) in [
        ("steady", 0.0, 0.0, 0),
        ("a walk of 6 dB", 6.0, 0.0, 3),
        ("a drift of 8 dB", 0.0, 8.0, 1),
    ] {
        for seconds in [4, 10] {
            let (mut told, mut below) = (0, 0);
            for seed in 0..30 {
                let x = wandering(seed, seconds, walk_db, drift_db);
                let [a, b] = halves(&x, RATE_HZ);
                let s = scored(&a, &b);
                told += usize::from(matches!(s.verdict, Verdict::Distinguishable { .. }));
                below += usize::from(s.verdict == Verdict::BelowJnd);
            }
            eprintln!(
                "halves of {seconds} s, {what}: distinguishable in {told}, below the JND in {below} of 30"
            );
            assert!(told <= most, "{what}, {seconds} s: {told} of 30");
            if most == 0 && seconds == 10 {
                assert!(below >= 20, "{below} of 30");
            }
        }
    }
}
