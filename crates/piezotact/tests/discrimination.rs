//! Which samples are distinguishable: what must not be said of samples that are alike, and what must be of those that differ.
#![allow(
    clippy::print_stderr,
    clippy::unwrap_used,
    reason = "a test prints what it measured, and fails where it cannot go on"
)]

use crate::studies::{Change, Random, sample, spectrum, spectrum_apart};
use piezotact::compare::{
    AcrossSamples, DiscriminationConfig, Distinguishability, SampleUnit, Texture, WithheldCause,
    discriminate,
};
use piezotact::discrimination::{ContactMap, DiscriminationWarning, Model};
use piezotact::quantity::{Acceleration, Band, Hertz, SampleRate, Unit};
use piezotact::score::{ScoreConfig, Verdict, score};
use piezotact::spectrum::{WelchConfig, welch};
use piezotact::statistics::{holm, permutation_test, sign_flip_test};
use piezotact::warning::{Few, FewWarning, Scatter, ScatterWarning};
use piezotact::{Series, Warning};
use serde::Deserialize;

fn config() -> DiscriminationConfig {
    DiscriminationConfig::usual(Model::over(Band::new(Hertz(20.0), Hertz(1000.0)).unwrap()))
}

fn study(textures: Vec<Texture>) -> AcrossSamples {
    discriminate(&[textures], &config()).unwrap()
}

fn told_apart(study: &AcrossSamples) -> usize {
    study
        .settings
        .iter()
        .map(|g| g.with(Distinguishability::ToldApart).count())
        .sum()
}

fn differ(study: &AcrossSamples) -> bool {
    let mut pairs = study.settings.iter().flat_map(|g| &g.pairs);
    pairs.any(|p| p.p_adjusted.unwrap() <= 0.05)
}

/// Strokes of one sample under four names.
#[test]
fn a_hundred_null_studies_tell_nothing_apart() {
    let (mut told, mut chance) = (0, 0);
    for seed in 0..100 {
        let mut random = Random::new(seed);
        let texture = spectrum(Change::Level, 0.0);
        let textures = (0..4)
            .map(|i| {
                let strokes = 8 + (random.uniform() * 8.0) as usize;
                sample(&mut random, &format!("N{i}"), &texture, [1, strokes], 0.0)
            })
            .collect();
        let found = study(textures);
        told += usize::from(told_apart(&found) > 0);
        chance += usize::from(differ(&found));
    }
    eprintln!("100 null studies: told apart in {told}; a difference beyond chance in {chance}");
    assert_eq!(told, 0);
    // 5 % and three standard deviations of a count.
    assert!(chance <= 12, "{chance}");
}

/// Three samples at three speeds, `jnd` between the first two, so many recordings of six strokes each that differ by `session_db`.
fn at_three_speeds(
    random: &mut Random,
    jnd: f64,
    (recordings, session_db): (usize, f64),
) -> AcrossSamples {
    let other = spectrum_apart(&config().model, Change::Level, jnd);
    let plain = spectrum(Change::Level, 0.0);
    let setting = |random: &mut Random| {
        let named = [("A", &other), ("B", &plain), ("C", &plain)];
        named.map(|(name, texture)| sample(random, name, texture, [recordings, 6], session_db))
    };
    let settings: Vec<Vec<Texture>> = (0..3).map(|_| setting(random).to_vec()).collect();
    discriminate(&settings, &config()).unwrap()
}

/// Pairs are tested over all settings together: equal samples are told apart no more often for it, at any of the speeds.
#[test]
fn null_studies_of_three_speeds_tell_nothing_apart() {
    let (mut told, mut chance) = (0, 0);
    for seed in 0..100 {
        let found = at_three_speeds(&mut Random::new(500 + seed), 0.0, (1, 0.0));
        assert_eq!(found.family, 3);
        told += usize::from(told_apart(&found) > 0);
        chance += usize::from(differ(&found));
    }
    eprintln!("100 null studies of three speeds: told apart in {told}; beyond chance in {chance}");
    assert_eq!(told, 0);
    assert!(chance <= 12, "{chance}");
}

/// Three recordings against three decide nothing at one speed (p is 0.1 at least), and do at three.
#[test]
fn three_recordings_at_three_speeds_decide() {
    let found = at_three_speeds(&mut Random::new(700), 8.0, (3, 1.0));
    assert_eq!(found.units, SampleUnit::Recordings);
    for groups in &found.settings {
        let p = groups.pair(0, 1).unwrap().p_adjusted.unwrap();
        assert!(p <= 0.05, "{p}");
        let equal = groups.pair(1, 2).unwrap();
        assert_ne!(equal.outcome, Distinguishability::ToldApart, "{equal:?}");
    }
}

#[test]
fn fifteen_strokes_tell_two_jnd_apart() {
    let model = config().model;
    for change in Change::ALL {
        let (mut told, mut below) = (0, 0);
        // Two of the JND that counts as the limit, 2.5 dB.
        let other = spectrum_apart(&model, change, 2.0 * 2.5 / 1.58);
        for seed in 0..20 {
            let mut random = Random::new(1000 + seed);
            let plain = spectrum(change, 0.0);
            let found = study(vec![
                sample(&mut random, "A", &plain, [1, 15], 0.0),
                sample(&mut random, "B", &other, [1, 15], 0.0),
                sample(&mut random, "C", &plain, [1, 15], 0.0),
            ]);
            let groups = &found.settings[0];
            let is = |i, j, outcome| usize::from(groups.pair(i, j).unwrap().outcome == outcome);
            told += is(0, 1, Distinguishability::ToldApart);
            below += is(0, 2, Distinguishability::BelowJnd);
        }
        eprintln!(
            "{}: told apart in {told} of 20; the same sample below the JND in {below} of 20",
            change.name()
        );
        assert!(
            told >= 16 && below >= 10,
            "{}: {told}, {below}",
            change.name()
        );
    }
}

/// What differs between the two ends of the published range is not decided, however many strokes there are.
#[test]
fn between_1_6_and_2_5_db_nothing_is_decided() {
    let model = config().model;
    let other = spectrum_apart(&model, Change::Level, 2.0 / 1.58);
    let mut random = Random::new(5);
    let found = study(vec![
        sample(
            &mut random,
            "A",
            &spectrum(Change::Level, 0.0),
            [1, 60],
            0.0,
        ),
        sample(&mut random, "B", &other, [1, 60], 0.0),
    ]);
    let pair = &found.settings[0].pairs[0];
    assert!(pair.p_adjusted.unwrap() < 0.01, "{pair:?}");
    assert_eq!(pair.outcome, Distinguishability::NotDecided, "{pair:?}");
    assert!(
        (pair.distance_jnd - 2.0 / 1.58).abs() < 0.25,
        "{}",
        pair.distance_jnd
    );
}

/// Recordings of one sample that lie 4 dB apart: strokes are not independent.
#[test]
fn recordings_that_differ_are_the_units() {
    let (mut told, mut by_recording) = (0, 0);
    for seed in 0..30 {
        let mut random = Random::new(200 + seed);
        let texture = spectrum(Change::Level, 0.0);
        let textures = (0..4)
            .map(|i| sample(&mut random, &format!("N{i}"), &texture, [2, 8], 4.0))
            .collect();
        let found = study(textures);
        told += told_apart(&found);
        by_recording += usize::from(found.units == SampleUnit::Recordings);
        assert!(
            found.units == SampleUnit::Strokes
                || found.warnings.iter().any(|d| matches!(
                    d.kind(),
                    Some(ScatterWarning::Scatter {
                        of: Scatter::Recordings { .. }
                    })
                ))
        );
    }
    eprintln!(
        "sessions 4 dB apart: {told} pairs told apart, recordings are the units in {by_recording} of 30"
    );
    assert_eq!((told, by_recording), (0, 30));
    // Recordings that do not differ count stroke by stroke, nine times of ten.
    let by_stroke = (0..30).filter(|seed| {
        let mut random = Random::new(400 + seed);
        let texture = spectrum(Change::Level, 0.0);
        let alike = (0..3).map(|i| sample(&mut random, &format!("N{i}"), &texture, [3, 5], 0.0));
        study(alike.collect()).units == SampleUnit::Strokes
    });
    let by_stroke = by_stroke.count();
    eprintln!("recordings that do not differ: strokes are the units in {by_stroke} of 30");
    assert!(by_stroke >= 22, "{by_stroke}");
}

#[test]
fn one_stroke_decides_nothing() {
    let mut random = Random::new(9);
    let loud = spectrum_apart(&config().model, Change::Level, 8.0);
    let found = study(vec![
        sample(&mut random, "A", &spectrum(Change::Level, 0.0), [1, 1], 0.0),
        sample(&mut random, "B", &loud, [1, 12], 0.0),
    ]);
    let pair = &found.settings[0].pairs[0];
    assert_eq!(
        (pair.outcome, pair.interval_jnd),
        (Distinguishability::NotDecided, None)
    );
    assert!(pair.distance_jnd > 6.0);
    let text = found.warnings.iter().find(|d| {
        matches!(
            d.kind(),
            Some(FewWarning::Few {
                what: Few::StrokesOfSample { .. },
                ..
            })
        )
    });
    assert!(text.unwrap().to_string().starts_with("A: only 1 stroke,"));
    // Three strokes of each of two cannot show it either, and that is said.
    let found = study(vec![
        sample(&mut random, "A", &spectrum(Change::Level, 0.0), [1, 3], 0.0),
        sample(&mut random, "B", &loud, [1, 3], 0.0),
    ]);
    assert_eq!(told_apart(&found), 0);
    assert!(
        found.warnings.iter().any(|d| matches!(
            d.kind(),
            Some(FewWarning::Few {
                recommended: 4,
                what: Few::Units { .. },
                ..
            })
        )),
        "{:?}",
        found.warnings
    );
}

#[test]
fn without_a_unit_it_is_withheld_and_below_threshold_it_is_said() {
    let mut random = Random::new(2);
    let mut counts = sample(
        &mut random,
        "cotton",
        &spectrum(Change::Level, 0.0),
        [1, 9],
        0.0,
    );
    counts.unit = Unit::Other("count".into());
    let why = discriminate(&[vec![counts.clone(), counts]], &config()).unwrap_err();
    assert!(matches!(why, WithheldCause::NotAnAcceleration { .. }));
    assert!(
        why.to_string().contains("not computed") && why.to_string().contains("cotton is in count"),
        "{why}"
    );

    let faint = |gain: f64| {
        spectrum(Change::Level, 0.0)
            .iter()
            .map(|v| v * gain)
            .collect::<Vec<f64>>()
    };
    let found = study(vec![
        sample(&mut random, "A", &faint(1e-5), [1, 9], 0.0),
        sample(&mut random, "B", &faint(1e-6), [1, 9], 0.0),
    ]);
    let pair = &found.settings[0].pairs[0];
    assert!(
        pair.neither_felt && pair.outcome == Distinguishability::BelowJnd,
        "{pair:?}"
    );
    // A nail that moves a fiftieth of what the skin does: then they are felt.
    let mut mapped = config();
    mapped.model.contact = Some(ContactMap::new(&[(10.0, 34.0), (1200.0, 34.0)], "test").unwrap());
    let textures = vec![
        sample(&mut random, "A", &faint(1e-3), [1, 15], 0.0),
        sample(&mut random, "B", &faint(1e-5), [1, 15], 0.0),
    ];
    let plain = discriminate(std::slice::from_ref(&textures), &config()).unwrap();
    let with = discriminate(&[textures], &mapped).unwrap();
    let of = |s: &AcrossSamples| s.settings[0].pairs[0].distance_jnd;
    assert!(of(&with) > of(&plain) + 3.0, "{} {}", of(&with), of(&plain));
    assert!(
        plain
            .warnings
            .contains(&Warning::from(DiscriminationWarning::ThresholdsOfSkin))
            && !with
                .warnings
                .contains(&Warning::from(DiscriminationWarning::ThresholdsOfSkin))
    );
}

/// The 95 % limits of the distance hold the truth of it.
#[test]
fn limits_hold_the_truth() {
    let model = config().model;
    let (mut held, mut low, mut all) = (0u64, 0, 0);
    for change in Change::ALL {
        for jnd in [1.0, 3.0] {
            let other = spectrum_apart(&model, change, jnd);
            for seed in 0..80 {
                let mut random = Random::new(7000 + 100 * all + seed);
                let found = study(vec![
                    sample(&mut random, "A", &spectrum(change, 0.0), [1, 12], 0.0),
                    sample(&mut random, "B", &other, [1, 9], 0.0),
                ]);
                let [from, to] = found.settings[0].pairs[0].interval_jnd.unwrap();
                all += 1;
                held += u64::from(from <= jnd && jnd <= to);
                low += usize::from(from > jnd);
            }
            eprintln!(
                "{} {jnd} JND: {held} of {all} so far, {low} above",
                change.name()
            );
        }
    }
    eprintln!("the limits hold the truth in {held} of {all}; {low} lie above it");
    assert!(held as f64 >= 0.92 * all as f64, "{held} of {all}");
}

#[derive(Deserialize)]
struct Golden {
    scipy: String,
    exhaustive: Vec<Case>,
    sampled: Vec<Case>,
    holm: Vec<[Vec<f64>; 2]>,
    welch: Vec<Welch>,
    signs: Vec<Signs>,
}

/// Differences of pairs, and the probability of their mean.
#[derive(Deserialize)]
struct Signs {
    d: Vec<f64>,
    p: f64,
}

#[derive(Deserialize)]
struct Case {
    a: Vec<f64>,
    b: Vec<f64>,
    p: f64,
}

#[derive(Deserialize)]
struct Welch {
    a: Vec<f64>,
    b: Vec<f64>,
    reach: f64,
}

#[test]
fn permutation_holm_and_limits_are_those_of_scipy() {
    let golden: Golden = serde_json::from_str(include_str!("golden/discrimination.json")).unwrap();
    let of = |case: &Case| {
        let all: Vec<f64> = case.a.iter().chain(&case.b).copied().collect();
        let sum: f64 = all.iter().sum();
        let (n, m) = (case.a.len() as f64, case.b.len() as f64);
        permutation_test(
            all.len(),
            case.a.len(),
            9_999,
            1,
            &mut |chosen: &[usize]| {
                let part: f64 = chosen.iter().map(|i| all[*i]).sum();
                (part / n - (sum - part) / m).abs()
            },
        )
    };
    for case in &golden.exhaustive {
        let ours = of(case);
        assert!(
            ours.exhaustive && (ours.p_value - case.p).abs() < 1e-12,
            "{ours:?}, SciPy {}",
            case.p
        );
    }
    for case in &golden.sampled {
        let ours = of(case);
        // Two samples of 9 999 and 99 999 divisions: four standard deviations of a share.
        let apart = 4.0 * (case.p * (1.0 - case.p) / 9_999.0).sqrt() + 1e-4;
        eprintln!(
            "SciPy {}: {} divisions give {:.4}, SciPy's {:.4}",
            golden.scipy, ours.divisions, ours.p_value, case.p
        );
        assert!(
            !ours.exhaustive && (ours.p_value - case.p).abs() < apart,
            "{ours:?}, SciPy {}",
            case.p
        );
    }
    for case in &golden.signs {
        let ours = sign_flip_test(&case.d, 9_999, 1).unwrap();
        // As above; all signs are tried of up to 15.
        let apart = match ours.exhaustive {
            true => 1e-12,
            false => 4.0 * (case.p * (1.0 - case.p) / 9_999.0).sqrt() + 1e-4,
        };
        assert_eq!(ours.exhaustive, case.d.len() <= 15);
        assert!(
            (ours.p_value - case.p).abs() < apart,
            "{ours:?}, SciPy {}",
            case.p
        );
    }
    for [p, adjusted] in &golden.holm {
        for (ours, theirs) in holm(p).iter().zip(adjusted) {
            assert!((ours - theirs).abs() < 1e-12, "{ours} {theirs}");
        }
    }
    // Strokes of one line at 100 Hz, whose power alone differs: the limits of the level are Welch's, by the delta method in dB.
    for case in &golden.welch {
        let model = Model::over(Band::new(Hertz(20.0), Hertz(1000.0)).unwrap());
        let strokes = |powers: &[f64]| -> Vec<Vec<f64>> {
            powers
                .iter()
                .map(|p| (0..201).map(|k| if k == 20 { *p } else { 0.0 }).collect())
                .collect()
        };
        let texture = |name: &str, powers: &[f64]| Texture {
            name: name.into(),
            recordings: vec![strokes(powers)],
            resolution_hz: 5.0,
            unit: Unit::MetrePerSecondSquared,
            highest_hz: 1000.0,
        };
        let found = discriminate(
            &[vec![texture("a", &case.a), texture("b", &case.b)]],
            &DiscriminationConfig::usual(model),
        )
        .unwrap();
        let pair = &found.settings[0].pairs[0];
        let [_, high] = pair.interval_jnd.unwrap();
        let ours = high - pair.distance_jnd;
        assert!(
            (ours / case.reach - 1.0).abs() < 1e-6,
            "{ours} {}",
            case.reach
        );
    }
}

/// Strokes of white noise by their spectra, and the same one after the other by their waveform.
#[test]
fn a_score_and_a_comparison_of_the_same_data_do_not_contradict_each_other() {
    let rate = SampleRate::new(5000.0).unwrap();
    let lines = WelchConfig::hann(1000);
    let strokes = |seed: u64, gain_db: f64| -> Vec<Series<Acceleration>> {
        let mut random = Random::new(seed);
        (0..12)
            .map(|_| {
                let wander_db = 0.5 * random.normal();
                let gain = 3.0 * 10f64.powf((gain_db + wander_db) / 20.0);
                let samples = (0..5000).map(|_| gain * random.normal()).collect();
                Series::new(samples, rate).unwrap()
            })
            .collect()
    };
    let (mut told, mut below) = (0, 0);
    for (seed, level_db, louder_db) in [
        (1, 0.0, 0.0),
        (2, 0.0, 1.2),
        (3, 0.0, 2.0),
        (4, 0.0, 3.2),
        (5, 0.0, 6.0),
        (6, -60.0, 9.0),
    ] {
        let [a, b] = [(seed, level_db), (seed + 50, level_db + louder_db)]
            .map(|(seed, gain_db)| strokes(seed, gain_db));
        let textures = [("A", &a), ("B", &b)].map(|(name, strokes)| Texture {
            name: name.into(),
            recordings: vec![
                strokes
                    .iter()
                    .map(|s| welch(s, &lines).unwrap().values)
                    .collect(),
            ],
            resolution_hz: 5.0,
            unit: Unit::MetrePerSecondSquared,
            highest_hz: 2500.0,
        });
        let found = study(textures.to_vec());
        let pair = &found.settings[0].pairs[0];
        let whole = |strokes: &[Series<Acceleration>]| {
            let samples = strokes.iter().flat_map(|s| s.samples().to_vec()).collect();
            Series::<Acceleration>::new(samples, rate).unwrap()
        };
        let band = Band::new(Hertz(20.0), Hertz(1000.0)).unwrap();
        let scored = score(&whole(&a), &whole(&b), &ScoreConfig::over(band, 5000.0)).unwrap();
        eprintln!(
            "{louder_db} dB louder: {}; {}",
            found.settings[0].sentences().join(""),
            scored.sentence
        );
        // Windows of 0.8 s do not weigh the strokes alike: the standard error of a mean of twelve is 0.1 JND.
        assert!(
            (pair.distance_jnd - scored.spectral.jnd).abs() < 0.3,
            "{} {}",
            pair.distance_jnd,
            scored.spectral.jnd
        );
        let contradict = matches!(
            (&scored.verdict, pair.outcome),
            (Verdict::BelowJnd, Distinguishability::ToldApart)
                | (
                    Verdict::Distinguishable { .. },
                    Distinguishability::BelowJnd
                )
        );
        assert!(!contradict);
        let neither = "neither reaches the detection threshold";
        assert_eq!(
            scored.sentence.contains(neither),
            found.settings[0].sentences().join("").contains(neither)
        );
        told += usize::from(pair.outcome == Distinguishability::ToldApart);
        below += usize::from(pair.outcome == Distinguishability::BelowJnd);
    }
    assert!(told >= 1 && below >= 2, "{told} {below}");
}

#[test]
fn warnings_come_back_from_json_and_results_are_written_whole() {
    for warning in [
        Warning::from(DiscriminationWarning::ThresholdsOfSkin),
        Warning::from(FewWarning::Few {
            found: 1,
            recommended: 10,
            what: Few::StrokesOfSample {
                samples: vec!["A".into()],
            },
        }),
        Warning::from(ScatterWarning::Scatter {
            of: Scatter::Recordings { p_value: 0.01 },
        }),
    ] {
        let text = serde_json::to_string(&warning).unwrap();
        assert!(text.contains("\"code\":"), "{text}");
        assert_eq!(serde_json::from_str::<Warning>(&text).unwrap(), warning);
    }
    let mut random = Random::new(1);
    let texture = spectrum(Change::Level, 0.0);
    let found = study(vec![
        sample(&mut random, "A", &texture, [1, 5], 0.0),
        sample(&mut random, "B", &texture, [1, 1], 0.0),
    ]);
    let written = serde_json::to_value(&found).unwrap();
    let (groups, setting) = (&found.settings[0], &written["settings"][0]);
    assert_eq!(setting["names"], serde_json::json!(["A", "B"]));
    assert_eq!(setting["units"], serde_json::json!(groups.units));
    assert_eq!(setting["within_jnd"], serde_json::json!(groups.within_jnd));
    assert_eq!(setting["pairs"], serde_json::json!(groups.pairs));
    assert_eq!(written["family"], found.family);
    assert_eq!(written["config"], serde_json::json!(found.config));
    assert_eq!(written["sentence"], found.sentence);
    assert!(found.sentence.contains("permutation test, 5 % over 1 pair"));
}
