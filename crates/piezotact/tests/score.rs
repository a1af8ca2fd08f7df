//! The score in JND: what it must not depend on, what it must see, and the literature's indices against vibromaf
//! (made by `golden/score.py`).
#![allow(
    clippy::disallowed_methods,
    clippy::print_stderr,
    clippy::unwrap_used,
    reason = "a test reads measured files, prints what it measured, and fails where it cannot go on"
)]

use piezotact::criterion::Outcome;
use piezotact::verify::VerifyWarning;
use std::collections::BTreeMap;
use std::f64::consts::TAU;

use crate::shared_data::shared;
use crate::vibrations::{
    RATE_HZ, Random, THIRTY_S, config, filtered, humps, read_wav, scored, scored_by_spectra,
    series, texture,
};
use num_complex::Complex;
use piezotact::Series;
use piezotact::Warning;
use piezotact::discrimination::DiscriminationWarning;
use piezotact::feature::Weighting;
use piezotact::quantity::{Acceleration, Band, Decibels, Hertz, SampleRate};
use piezotact::score::literature::{LevelCurve, literature, spqi, st_sim};
use piezotact::score::{
    Extent, How, LiteratureConfig, NotComputed, Score, ScoreConfig, ScoreError, ScoreModel,
    ScoreWarning, Verdict, score,
};
use serde::Deserialize;

/// The same magnitudes with other phases.
fn twin(x: &Series<Acceleration>, seed: u64) -> Series<Acceleration> {
    let mut random = Random::new(seed);
    series(filtered(x.samples(), |_, bin| {
        Complex::from_polar(bin.norm(), TAU * random.uniform())
    }))
}

fn later(x: &Series<Acceleration>, samples: usize) -> Series<Acceleration> {
    let mut moved = x.samples().to_vec();
    moved.rotate_right(samples);
    series(moved)
}

#[test]
fn a_texture_and_its_phase_randomised_twin_score_below_a_tenth() {
    for (seed, rms_m_s2) in [(1, 0.7), (2, 2.0), (3, 5.0), (4, 20.0), (5, 2.0)] {
        let x = texture(seed, THIRTY_S, rms_m_s2, humps);
        let s = scored(&x, &twin(&x, seed + 100));
        eprintln!(
            "twin, seed {seed}, {rms_m_s2} m/s²: score {:.4} JND ({:.3}–{:.3}), spectrum {:.4}, level {:.4}, balance {:.4}; modulation {:?} dB; waveform {:?}; ST-SIM {:?}, SPQI {:.3}",
            s.spectral.jnd,
            s.spectral.low_jnd,
            s.spectral.high_jnd,
            s.spectrum.jnd,
            s.level.jnd,
            s.balance.jnd,
            s.modulation_db,
            s.waveform.as_ref().map(|w| w.correlation),
            s.literature.as_ref().unwrap().st_sim.value,
            s.literature.as_ref().unwrap().spqi
        );
        assert!(s.spectral.jnd < 0.1, "seed {seed}: {}", s.sentence);
        assert_eq!(s.verdict, Verdict::BelowJnd, "seed {seed}: {}", s.sentence);
    }
}

#[test]
fn a_texture_and_itself_5_ms_later_score_below_a_tenth() {
    for seed in 1..=3 {
        let x = texture(seed, THIRTY_S, 2.0, humps);
        let s = scored(&x, &later(&x, 25));
        eprintln!("5 ms later, seed {seed}: {}", s.sentence);
        assert!(s.spectral.jnd < 0.1, "seed {seed}: {}", s.sentence);
        assert_eq!(s.extent, Extent::SharedPart);
        let waveform = s.waveform.unwrap();
        assert!((waveform.delay_s - 0.005).abs() < 1e-5 && waveform.correlation > 0.99);
        assert!(waveform.nmse_db < -20.0, "{}", waveform.nmse_db);
    }
}

/// What the lowest bands hold is known least: 30 s of a rumble hold few of its swings.
#[test]
fn twins_of_other_spectra_score_below_a_tenth() {
    twins_of_other_spectra_score_below_a_tenth_in(1..=1);
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_twins_of_other_spectra_score_below_a_tenth() {
    twins_of_other_spectra_score_below_a_tenth_in(1..=3);
}

fn twins_of_other_spectra_score_below_a_tenth_in(seeds: std::ops::RangeInclusive<u64>) {
    type Shape = fn(f64) -> f64;
    let shapes: [(&str, Shape); 4] = [
        ("white", |_| 1.0),
        ("rumble", |f| 1.0 / (1.0 + (f / 40.0).powi(2))),
        ("pink", |f| f.powf(-0.5)),
        ("narrow", |f| (-((f / 150.0).ln() / 0.06).powi(2)).exp()),
    ];
    for (name, shape) in shapes {
        for seed in seeds.clone() {
            let x = texture(seed, THIRTY_S, 2.0, shape);
            let s = scored(&x, &twin(&x, seed + 30));
            let other = texture(seed + 60, THIRTY_S, 2.0, shape).amplified(Decibels(1.58));
            let apart = scored(&x, &other).spectral;
            eprintln!(
                "{name}, seed {seed}: twin {:.3} ({:.2}–{:.2}) JND; another realisation 1 JND louder {:.3} ({:.2}–{:.2})",
                s.spectral.jnd,
                s.spectral.low_jnd,
                s.spectral.high_jnd,
                apart.jnd,
                apart.low_jnd,
                apart.high_jnd
            );
            assert!(s.spectral.jnd < 0.1, "{name}, seed {seed}: {}", s.sentence);
            assert!(
                apart.low_jnd <= 1.0 && apart.high_jnd >= 1.0,
                "{name}, seed {seed}: {apart:?}"
            );
        }
    }
}

/// What is measured while a drive plays begins before it and ends after it.
#[test]
fn silence_around_a_measurement_is_left_out() {
    let x = texture(1, 50_000, 2.0, humps);
    let around = [vec![0.0; 4_000], x.samples().to_vec(), vec![0.0; 9_000]].concat();
    let s = scored(&x, &series(around));
    eprintln!("with silence around: {}", s.sentence);
    assert!(
        s.spectral.jnd < 1e-3
            && s.warnings.to_vec() == [Warning::from(DiscriminationWarning::ThresholdsOfSkin)],
        "{} {:?}",
        s.sentence,
        s.warnings
    );
    assert!(s.literature.unwrap().st_sim.value.unwrap() > 0.999);
    // A measurement that ends early is compared as far as it goes, and that is said.
    let s = scored(&x, &series(x.samples()[..30_000].to_vec()));
    assert!(
        s.warnings
            .iter()
            .any(|d| matches!(d.kind(), Some(VerifyWarning::Cut { .. })))
            && s.spectral.jnd < 0.05
    );
}

#[test]
fn two_textures_one_jnd_apart_in_level_score_1() {
    for (seed, rms_m_s2, sign) in [
        (1, 0.7, 1.0),
        (2, 2.0, -1.0),
        (3, 10.0, 1.0),
        (4, 10.0, -1.0),
    ] {
        let x = texture(seed, THIRTY_S, rms_m_s2, humps);
        let other = texture(seed + 50, THIRTY_S, rms_m_s2, humps).amplified(Decibels(1.58 * sign));
        let (own, other) = (
            scored(&x, &x.clone().amplified(Decibels(1.58 * sign))),
            scored(&x, &other),
        );
        eprintln!(
            "1 JND apart, {rms_m_s2} m/s², {sign:+}: one realisation {:.4}; two {:.4} ({:.2}–{:.2})",
            own.spectral.jnd, other.spectral.jnd, other.spectral.low_jnd, other.spectral.high_jnd
        );
        assert!((own.spectral.jnd - 1.0).abs() < 0.1, "{}", own.sentence);
        assert!((other.spectral.jnd - 1.0).abs() < 0.1, "{}", other.sentence);
    }
    let x = texture(9, THIRTY_S, 2.0, humps);
    let s = scored(
        &x,
        &texture(10, THIRTY_S, 2.0, humps).amplified(Decibels(3.2)),
    );
    eprintln!("2 JND apart: {}", s.sentence);
    let Verdict::Distinguishable { how } = &s.verdict else {
        panic!("{}", s.sentence)
    };
    assert_eq!(how[0], How::Louder);
    assert_eq!(s.extent, Extent::WholeOfEach);
}

/// Measured textures, as they are and looped to 30 s.
#[test]
fn measured_textures_score_below_a_tenth_against_their_twins() {
    for name in ["text3_ref", "text9_ref", "text3_v1", "text9_v1"] {
        let Some(path) = shared(&format!("data/vibration/textsense/{name}.wav")) else {
            return;
        };
        let (samples, rate_hz) = read_wav(&path);
        let rate = SampleRate::new(rate_hz).unwrap();
        let mean = piezotact::statistics::mean(&samples);
        // Full scale is not stated: they are brought to 2 m/s² rms.
        let gain = 2.0 / piezotact::statistics::standard_deviation(&samples);
        let once: Vec<f64> = samples.iter().map(|v| gain * (v - mean)).collect();
        let times = (30.0 * rate_hz / once.len() as f64).ceil() as usize;
        let looped = once.repeat(times.max(1));
        for (how, samples) in [("as it is", once), ("looped", looped)] {
            let x = Series::new(samples, rate).unwrap();
            let config = ScoreConfig::over(config().band, rate_hz);
            let say = |what: &str, other: Series<Acceleration>| {
                let s = score(&x, &other, &config).unwrap();
                eprintln!(
                    "{name} {how} ({:.1} s at {rate_hz} Hz, {:.2} m/s² rms), {what}: {} (spectrum {:.3}, level {:.3}, balance {:.3}), modulation {:.1?} dB",
                    x.duration().0,
                    x.rms(),
                    s.sentence,
                    s.spectrum.jnd,
                    s.level.jnd,
                    s.balance.jnd,
                    s.modulation_db.unwrap()
                );
                s
            };
            let twin = Series::new(twin(&x, 7).into_samples(), rate).unwrap();
            let five_ms = (0.005 * rate_hz).round() as usize;
            let later = Series::new(later(&x, five_ms).into_samples(), rate).unwrap();
            let (against_twin, against_later) = (say("twin", twin), say("5 ms later", later));
            assert!(
                against_later.spectral.jnd < 0.1,
                "{}",
                against_later.sentence
            );
            // Two seconds that begin and end softly are no stationary noise: the limits say so. Repeated, their level swings as that of no
            // twin does, and that is all there is between them.
            let by_spectrum = match &against_twin.verdict {
                Verdict::Distinguishable { how } => {
                    !how.iter().all(|one| matches!(one, How::DiffersIn(_)))
                }
                _ => false,
            };
            assert!(!by_spectrum, "{}", against_twin.sentence);
            if how == "looped" {
                assert!(against_twin.spectral.jnd < 0.1, "{}", against_twin.sentence);
            }
        }
    }
}

#[test]
fn what_lies_below_threshold_makes_no_difference() {
    // Loud below 300 Hz; above 400 Hz far below threshold, and there 20 dB apart.
    let threshold = |f: f64| Weighting::DetectionThreshold.threshold_m_s2(Hertz(f));
    let low = |f: f64| if f < 300.0 { humps(f) } else { 0.0 };
    let loud = texture(1, THIRTY_S, 3.0, low);
    let with = |rms_m_s2: f64| {
        let hiss = texture(2, THIRTY_S, rms_m_s2, |f| {
            if (400.0..1000.0).contains(&f) {
                1.0
            } else {
                0.0
            }
        });
        series(
            loud.samples()
                .iter()
                .zip(hiss.samples())
                .map(|(a, b)| a + b)
                .collect(),
        )
    };
    let quiet = 0.3 * threshold(450.0);
    let s = scored(&with(quiet), &with(0.1 * quiet));
    let largest = s
        .bands
        .iter()
        .map(|b| b.difference_db.abs())
        .fold(0.0, f64::max);
    eprintln!(
        "below threshold: {} (largest difference of a band {largest:.1} dB)",
        s.sentence
    );
    assert!(largest > 15.0 && s.spectral.jnd < 0.05, "{}", s.sentence);

    // Neither is felt, wherever in the spectrum the two are: 0. Just above threshold: next to nothing.
    for (power, most_jnd) in [(0.95f64, 1e-12), (1.05, 0.3)] {
        let [a, b] = [40.0, 500.0].map(|hz| {
            let at = |i: usize| (2.0 * power).sqrt() * (TAU * hz * i as f64 / RATE_HZ).sin();
            series((0..THIRTY_S).map(|i| threshold(hz) * at(i)).collect())
        });
        assert!(scored(&a, &b).spectrum.jnd <= most_jnd, "{power}");
    }
    let faint = texture(3, THIRTY_S, 0.01, humps);
    let s = scored(&faint, &faint.clone().amplified(Decibels(-12.0)));
    assert!(
        s.spectral.jnd < 1e-12 && s.sentence.contains("neither"),
        "{}",
        s.sentence
    );
    assert_eq!(
        s.warnings
            .iter()
            .filter(|d| matches!(d.kind(), Some(ScoreWarning::NotFelt { .. })))
            .count(),
        2
    );
}

#[test]
fn a_tilt_is_seen_though_the_level_is_the_same() {
    let x = texture(1, THIRTY_S, 3.0, humps);
    for (db_per_octave, apart) in [(0.3, false), (4.0, true)] {
        let tilted = texture(2, THIRTY_S, 3.0, |f| {
            humps(f) * 10f64.powf(db_per_octave * (f / 120.0).log2() / 20.0)
        });
        // At the same level over threshold: what is left is shape.
        let level_db =
            scored(&x, &tilted).test_sensation_db - scored(&x, &tilted).reference_sensation_db;
        let s = scored(&x, &tilted.amplified(Decibels(-level_db)));
        eprintln!(
            "{db_per_octave} dB per octave: {} (spectrum {:.2}, level {:.2}, balance {:.2})",
            s.sentence, s.spectrum.jnd, s.level.jnd, s.balance.jnd
        );
        assert_eq!(
            apart,
            matches!(s.verdict, Verdict::Distinguishable { .. }),
            "{}",
            s.sentence
        );
    }
}

#[test]
fn a_tone_moved_by_one_jnd_of_frequency_scores_1() {
    let tone = |f: f64| {
        series(
            (0..THIRTY_S)
                .map(|i| 3.0 * (TAU * f * i as f64 / RATE_HZ).sin())
                .collect(),
        )
    };
    let s = scored(&tone(113.0), &tone(113.0 * 1.2));
    eprintln!(
        "113 Hz and 135.6 Hz: {} (balance {:.3})",
        s.sentence, s.balance.jnd
    );
    assert!((s.balance.jnd - 1.0).abs() < 0.02, "{}", s.balance.jnd);
    assert!((s.spectral.jnd - 1.0).abs() < 0.1, "{}", s.sentence);
    // Across the border of two third octaves, by next to nothing.
    let s = scored(&tone(111.0), &tone(113.0));
    eprintln!("111 Hz and 113 Hz: {}", s.sentence);
    assert!(s.spectral.jnd < 0.15, "{}", s.sentence);
}

#[test]
fn bursts_have_the_spectrum_of_a_hiss_and_are_named() {
    let x = texture(1, THIRTY_S, 3.0, humps);
    let bursts = series(
        x.samples()
            .iter()
            .enumerate()
            .map(|(i, v)| v * if (i / 2500) % 2 == 0 { 1.38 } else { 0.3 })
            .collect(),
    );
    let s = scored(&x, &bursts);
    eprintln!("bursts: {} modulation {:?}", s.sentence, s.modulation_db);
    let in_time = |score: &Score| score.criteria[0].outcome;
    assert_eq!(in_time(&s), Outcome::NotMet);
    assert!(s.spectral.jnd < 1.0, "{:?}", s.spectral);
    assert!(
        s.sentence.contains("distinguishable") && s.sentence.contains("modulation"),
        "{}",
        s.sentence
    );
    assert_eq!(in_time(&scored(&x, &twin(&x, 4))), Outcome::Met);
}

/// Decaying oscillations of 2.8 m/s², at times drawn with `seed`.
fn sparse_taps(seed: u64) -> Series<Acceleration> {
    let mut samples = vec![0.0; 20_000];
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
    for _ in 0..4 {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        let at = (state % 19_000) as usize;
        for (i, sample) in samples[at..].iter_mut().take(400).enumerate() {
            let t_s = i as f64 / 5000.0;
            *sample += 2.8 * (-t_s / 0.01).exp() * (TAU * 200.0 * t_s).sin();
        }
    }
    series(samples)
}

/// Few taps have a small long-time level, and are felt all the same; two draws of them that happen to coincide in part are not
/// cut to that part.
#[test]
fn sparse_events_are_not_below_the_threshold_for_being_rare() {
    let loud = sparse_taps(1);
    let faint = loud.clone().amplified(Decibels(-6.0));
    // Their own energy counts: they are felt, and so is what makes them softer; nothing warns that they are not felt.
    let s = scored(&loud, &faint);
    assert!(!matches!(s.verdict, Verdict::BelowJnd), "{}", s.sentence);
    let fainter = scored(&loud, &loud.clone().amplified(Decibels(-12.0)));
    assert!(
        matches!(fainter.verdict, Verdict::Distinguishable { .. }),
        "{}",
        fainter.sentence
    );
    let unfelt = |s: &Score| {
        let mut warnings = s.warnings.iter();
        warnings.any(|one| {
            matches!(one.kind(), Some(ScoreWarning::NotFelt { signal, .. }) if signal == "the reference")
        })
    };
    assert!(!unfelt(&s), "{:?}", s.warnings);
    let s = scored_by_spectra(&loud, &faint);
    assert!(
        s.reference_sensation_db <= 0.0,
        "{}",
        s.reference_sensation_db
    );
    assert!(
        matches!(s.verdict, Verdict::NotDecided { .. }),
        "{}",
        s.sentence
    );
    assert!(
        s.sentence.contains("the loudest 0.1 s do"),
        "{}",
        s.sentence
    );
    for seed in 2..12 {
        let s = scored(&loud, &sparse_taps(seed));
        assert_eq!(
            s.extent,
            Extent::WholeOfEach,
            "seed {seed}: {:?}",
            s.waveform
        );
    }
    // What nobody feels at any moment is below the threshold.
    let nothing = loud.amplified(Decibels(-40.0));
    let s = scored(&nothing, &nothing.clone().amplified(Decibels(-6.0)));
    assert!(
        matches!(s.verdict, Verdict::BelowJnd) && unfelt(&s),
        "{}",
        s.sentence
    );
}

#[test]
fn what_cannot_be_scored_is_refused_with_what_to_do() {
    let x = texture(1, 20_000, 1.0, humps);
    let other_rate = Series::new(x.samples().to_vec(), SampleRate::new(6000.0).unwrap()).unwrap();
    let says = |error: ScoreError, parts: &[&str]| {
        let text = error.to_string();
        assert!(parts.iter().all(|part| text.contains(part)), "{text}");
    };
    says(
        score(&x, &other_rate, &config()).unwrap_err(),
        &["5000 Hz", "6000 Hz", "one rate"],
    );
    says(
        score(&x, &series(vec![0.0; 20_000]), &config()).unwrap_err(),
        &["the test has no signal"],
    );
    let spectral = ScoreConfig {
        judged_by: ScoreModel::Spectral,
        ..config()
    };
    for (samples, config, parts) in [
        (
            1_000,
            config(),
            ["the test", "0.30 s", "0.200 s", "record longer"],
        ),
        (
            2_000,
            spectral,
            ["the test", "0.82 s", "0.400 s", "record longer"],
        ),
    ] {
        says(
            score(&x, &texture(2, samples, 1.0, humps), &config).unwrap_err(),
            &parts,
        );
    }
    let slow = |n: usize| {
        let samples = (0..n).map(|i| (TAU * 60.0 * i as f64 / 500.0).sin());
        Series::<Acceleration>::new(samples.collect(), SampleRate::new(500.0).unwrap()).unwrap()
    };
    let band = Band::new(Hertz(20.0), Hertz(200.0)).unwrap();
    says(
        score(&slow(2_000), &slow(1_999), &ScoreConfig::over(band, 500.0)).unwrap_err(),
        &["1000 Hz", "500 Hz", "spectra alone"],
    );
    let mut wrong = config();
    wrong.level_jnd = Decibels(0.0);
    says(
        score(&x, &x, &wrong).unwrap_err(),
        &["just-noticeable", "level", "1.58"],
    );
    let mut high = config();
    high.band = Band::new(Hertz(20.0), Hertz(3000.0)).unwrap();
    says(score(&x, &x, &high).unwrap_err(), &["2500 Hz", "lower"]);
}

#[derive(Deserialize)]
struct Golden {
    vibromaf: String,
    thresholds_every_50: BTreeMap<String, Vec<f64>>,
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    name: String,
    curve: String,
    st_sim: Option<f64>,
    temporal: f64,
    spectral: f64,
    spqi: f64,
}

fn hashed(n: u64, seed: u64) -> Vec<f64> {
    (0..n)
        .map(|i| {
            let mut h = (i * 2_654_435_761 + seed * 40_503 + 12_345) & 0xFFFF_FFFF;
            h ^= h >> 16;
            h = (h * 2_246_822_519) & 0xFFFF_FFFF;
            h ^= h >> 13;
            h = (h * 3_266_489_917) & 0xFFFF_FFFF;
            h ^= h >> 16;
            h as f64 / 4_294_967_296.0 - 0.5
        })
        .collect()
}

fn sines(n: usize, later_s: f64) -> Vec<f64> {
    (0..n)
        .map(|i| i as f64 / 8000.0 - later_s)
        .map(|t| {
            0.3 * (TAU * 55.0 * t).sin()
                + 0.2 * (TAU * 180.0 * t + 1.0).sin()
                + 0.1 * (TAU * 411.0 * t + 2.0).sin()
        })
        .collect()
}

fn sum(a: &[f64], factor: f64, b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| a + factor * b).collect()
}

/// The signals of `golden/score.py`.
fn pair(name: &str) -> (Vec<f64>, Vec<f64>) {
    let n = 8000;
    let base = sum(&sines(n, 0.0), 0.2, &hashed(8000, 1));
    let times = |factor: f64| base.iter().map(|v| v * factor).collect::<Vec<f64>>();
    let test = match name {
        "equal" => base.clone(),
        "little noise" => sum(&base, 0.01, &hashed(8000, 2)),
        "much noise" => sum(&base, 0.8, &hashed(8000, 2)),
        "louder" => times(1.2),
        "much softer" => times(1e-3),
        "later by 5 ms" => sum(&sines(n, 0.005), 0.2, &hashed(8000, 1)),
        "other noise" => return (hashed(8000, 3), hashed(8000, 4)),
        "longer" => [sum(&base, 0.05, &hashed(8000, 5)), hashed(777, 6)].concat(),
        "one block" => {
            let block = base[..512].to_vec();
            let other = sum(&block, 0.1, &hashed(512, 7));
            return (block, other);
        }
        "reversed" => times(-0.9),
        "with a pause" => {
            let paused = (0..n)
                .map(|i| if i < 4096 { base[i] } else { 0.0 })
                .collect();
            return (paused, base);
        }
        other => panic!("no signal called {other}"),
    };
    (base, test)
}

#[test]
fn st_sim_and_spqi_are_those_of_vibromaf() {
    let golden: Golden = serde_json::from_str(include_str!("golden/score.json")).unwrap();
    assert_eq!(golden.vibromaf, "0.0.8");
    let (mut worst, mut without): (f64, usize) = (0.0, 0);
    for case in &golden.cases {
        let curve = match case.curve.as_str() {
            "vibromaf" => LevelCurve::Vibromaf,
            _ => LevelCurve::Mpeg,
        };
        let found = curve.thresholds_db();
        for (k, expected) in golden.thresholds_every_50[&case.curve].iter().enumerate() {
            worst = worst.max((found[50 * k] - expected).abs());
        }
        let (reference, test) = pair(&case.name);
        let ours = st_sim(&reference, &test, curve).unwrap();
        let mut apart = vec![
            ours.temporal - case.temporal,
            ours.spectral - case.spectral,
            spqi(&reference, &test, curve).unwrap() - case.spqi,
        ];
        match (ours.value, case.st_sim) {
            (Some(ours), Some(theirs)) => apart.push(ours - theirs),
            // vibromaf gives a complex number here.
            (None, None) => without += 1,
            other => panic!("{}: {other:?}", case.name),
        }
        let largest = apart.iter().map(|d| d.abs()).fold(0.0, f64::max);
        assert!(
            largest < 1e-9,
            "{} with {}: {largest:e}",
            case.name,
            case.curve
        );
        worst = worst.max(largest);
    }
    eprintln!(
        "vibromaf 0.0.8: largest difference {worst:.1e}, {without} cases without a real value"
    );
    assert!(worst < 1e-9 && without >= 2);
}

#[test]
fn the_literature_s_indices_are_computed_at_8_khz_and_say_when_they_have_no_value() {
    let x = texture(1, 20_000, 1.0, humps);
    let reversed = series(x.samples().iter().map(|v| -v).collect());
    let config = LiteratureConfig::vibromaf();
    let found = literature(&x, &reversed, config).unwrap();
    assert_eq!(found.st_sim.value, None);
    assert!(
        found.warnings[0].to_string().contains("negative"),
        "{}",
        found.warnings[0]
    );
    assert_eq!(literature(&x, &x, config).unwrap().spqi, 1.0);
    let louder = x.clone().amplified(Decibels(40.0));
    let warnings = literature(&x, &louder, config).unwrap().warnings;
    assert!(
        matches!(&warnings[..], [warning] if matches!(warning.kind(), Some(ScoreWarning::NotComputed { what: NotComputed::StSimBeyondRange { value } }) if value > 1.0))
    );
    // Tones that both rates hold give the same at 5 and at 8 kHz, but for the filter's ends.
    let at = |rate_hz: f64, gain: f64| {
        let tones = (0..(4.0 * rate_hz) as usize).map(|i| {
            let t = i as f64 / rate_hz;
            (TAU * 60.0 * t).sin() + gain * (TAU * 230.0 * t).sin()
        });
        Series::<Acceleration>::new(tones.collect(), SampleRate::new(rate_hz).unwrap()).unwrap()
    };
    let [low, high] = [5000.0, 8000.0]
        .map(|rate_hz| literature(&at(rate_hz, 0.3), &at(rate_hz, 0.5), config).unwrap());
    eprintln!("at 5 kHz {low:?}, at 8 kHz {high:?}");
    assert!((low.spqi - high.spqi).abs() < 0.01);
    assert!((low.st_sim.value.unwrap() - high.st_sim.value.unwrap()).abs() < 0.01);
    let louder = LiteratureConfig {
        full_scale_m_s2: 0.0,
        ..config
    };
    assert!(
        literature(&x, &x, louder)
            .unwrap_err()
            .to_string()
            .contains("full scale")
    );
}
