//! How different vibrations feel: the pairs of the literature, realisations of one texture, and the prototype's values.
#![allow(
    clippy::print_stderr,
    clippy::unwrap_used,
    reason = "a test prints what it measured, and fails where it cannot go on"
)]

mod signals;

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use piezotact::criterion::Outcome;
use piezotact::perception::{
    Feature, PARAMETERS, Parameters, PerceivedDifference, PerceptionError, perceived_difference,
    perceived_through, sensitivity,
};
use piezotact::quantity::{Acceleration, Band, Decibels, Hertz, SampleRate};
use piezotact::score::{ScoreConfig, Verdict, score};
use piezotact::series::Series;
use serde::Deserialize;
use signals::{
    FS, equal_energy, louder, modulated, noise, padded, pair, place, ramp, series, taps, threshold,
    tone, tone_of,
};

fn compared(a: &[f64], b: &[f64]) -> PerceivedDifference {
    perceived_difference(&series(a), &series(b), &Parameters::published()).unwrap()
}

fn of(key: &str) -> PerceivedDifference {
    let [a, b] = pair(key);
    compared(&a, &b)
}

struct Expected {
    key: &'static str,
    low: f64,
    high: f64,
}

/// The pairs of `expected.txt`.
fn expected() -> Vec<Expected> {
    let lines = include_str!("expected.txt").lines();
    let rows = lines.filter(|line| !line.starts_with('#'));
    rows.map(|row| {
        let cells: Vec<&str> = row.split('|').map(str::trim).collect();
        Expected {
            key: cells[0],
            low: cells[3].parse().unwrap(),
            high: cells[4].parse().unwrap_or(f64::INFINITY),
        }
    })
    .collect()
}

/// No pair that people tell apart is called below the JND or the reverse, every value lies where it is expected, and few of those that
/// people decide are not decided.
#[test]
fn the_pairs_of_the_literature_are_as_far_apart_as_people_find_them() {
    let (mut outside, mut undecided, mut all) = (Vec::new(), 0, 0);
    for Expected { key, low, high } in expected() {
        let found = of(key);
        let outcome = found.criterion.outcome;
        let jnd = found.jnd;
        eprintln!(
            "{key:10} {:6.2} [{:.2}, {:.2}] expected {low}..{high}: {}",
            jnd.value,
            jnd.low,
            jnd.high,
            outcome.word()
        );
        if low >= 1.0 {
            assert_ne!(outcome, Outcome::Met, "{key}");
        }
        if high <= 1.0 {
            assert_ne!(outcome, Outcome::NotMet, "{key}");
        }
        all += 1;
        undecided += usize::from(outcome == Outcome::NotDecided && (low >= 1.0 || high <= 1.0));
        if !(low..=high).contains(&jnd.value) {
            outside.push(key);
        }
    }
    eprintln!("{all} pairs, outside {outside:?}, not decided {undecided}");
    assert!(outside.is_empty(), "{outside:?}");
    assert!(all == 53 && undecided <= 2);
}

fn over_the_band() -> ScoreConfig {
    ScoreConfig::over(Band::new(Hertz(20.0), Hertz(1000.0)).unwrap(), FS)
}

/// The verdicts of `score` on the same pairs: none says "below" of what people tell apart, or "distinguishable" of what they do not, and
/// most values lie where they are expected.
#[test]
fn the_score_says_nothing_false_of_the_pairs_of_the_literature() {
    let config = over_the_band();
    let (mut right, mut undecided, mut all) = (0, Vec::new(), 0);
    for Expected { key, low, high } in expected() {
        let [a, b] = pair(key).map(|x| series(&x));
        let found = score(&a, &b, &config).unwrap();
        let jnd = found.perceived.as_ref().unwrap().difference.jnd.value;
        let alone = of(key).jnd.value;
        eprintln!(
            "{key:10} expected {low}..{high}, alone {alone:.2}: {}",
            found.sentence
        );
        match found.verdict {
            Verdict::BelowJnd => assert!(low < 1.0, "{key}: {}", found.sentence),
            Verdict::Distinguishable { .. } => assert!(high > 1.0, "{key}: {}", found.sentence),
            Verdict::NotDecided { .. } if low >= 1.0 || high <= 1.0 => undecided.push(key),
            Verdict::NotDecided { .. } => {}
        }
        right += usize::from((low..=high).contains(&jnd));
        all += 1;
    }
    eprintln!("{right} of {all} right, not decided {undecided:?}");
    assert!(
        all == 53 && right >= 50 && undecided.len() <= 5,
        "{right} {undecided:?}"
    );
}

#[test]
fn relations_of_pairs_are_as_people_find_them() {
    let jnd = |key: &str| of(key).jnd.value;
    assert!(of("10.35").pitch_jnd < of("10.20").pitch_jnd);
    assert!(jnd("11") < jnd("1.80"));
    for rate in ["15", "30", "45"] {
        assert!(
            jnd(&format!("14.{rate}")) < 0.5 * jnd(&format!("13.{rate}")),
            "{rate}"
        );
    }
    // Lines below threshold are felt through the receptors' rectification.
    let [unfelt, felt] = of("15").sensation_level;
    assert!(unfelt.0 < 0.0 && felt.0 > 0.0, "{unfelt} {felt}");
    let both = of("25").felt_level.0;
    assert!((3.0..=5.0).contains(&both), "{both}");
    let burst = of("II.18a").pitch_jnd;
    assert!(burst < 1.0 && burst < of("II.18b").pitch_jnd && burst < of("II.18c").pitch_jnd);
    assert!(of("II.19").pitch_jnd < 1.0);
    assert!(jnd("II.23") < 0.5 * jnd("II.24"));
    assert!(of("II.30.250").felt_level.0 > 3.0);
    assert!(of("II.30.20").felt_level.0.abs() < 1.5);
    assert!(jnd("II.34.500") > jnd("II.34.20"));
}

/// Two realisations of a noise, flat, narrow and modulated, with and without ramps.
#[test]
fn realisations_of_one_texture_are_equal() {
    let mut found = Vec::new();
    let bands = [(20.0, 600.0), (60.0, 400.0), (89.0, 112.0), (15.0, 80.0)];
    for case in 0..48usize {
        let (low, high) = bands[case % 4];
        let seconds = [1.0, 2.0, 3.0][case / 4 % 3];
        let one = |seed| {
            let x = noise(low, high, 22.0, seconds, 2 * case as u64 + seed);
            match case / 12 {
                0 => ramp(x, 0.010),
                1 => modulated(&x, 7.0, 0.6),
                _ => x,
            }
        };
        found.push(compared(&one(100), &one(101)).jnd.value);
    }
    found.sort_by(f64::total_cmp);
    eprintln!("realisations: {found:.2?}");
    assert!(found[24] < 0.1 && found[46] < 0.5, "{found:?}");
}

/// A stroke that begins later is the same, and a modulated one from another moment.
#[test]
fn a_delay_is_not_felt() {
    let x = tone(150.0, 25.0);
    let silence = vec![0.0; 1200];
    let later = [silence.clone(), x.clone()].concat();
    let sooner = [x, silence].concat();
    assert!(compared(&later, &sooner).jnd.value < 0.05);
    let long = modulated(&noise(40.0, 400.0, 22.0, 3.0, 9), 9.0, 0.8);
    let jnd = compared(&long[..16_000], &long[5_300..21_300]).jnd.value;
    assert!(jnd < 0.5, "{jnd}");
}

/// More depth is never less felt, full modulation is never below the JND, and 125 Hz is hardly felt beside 25 Hz.
#[test]
fn modulation_is_felt_the_more_the_deeper_it_is() {
    let carriers = [tone(60.0, 25.0), tone(100.0, 25.0), tone(300.0, 25.0)];
    let noises = [noise(60.0, 400.0, 25.0, 1.0, 5)];
    for (i, x) in carriers.iter().chain(&noises).enumerate() {
        for rate in [5.0, 12.0, 30.0, 60.0, 80.0] {
            let of = |depth: f64| {
                let y = equal_energy(modulated(x, rate, depth), x);
                compared(x, &y).jnd.value
            };
            let found = [0.1, 0.35, 0.7, 1.0].map(of);
            assert!(
                found.windows(2).all(|w| w[1] > w[0] - 0.05),
                "{i} {rate} {found:?}"
            );
            assert!(found[3] >= 1.0, "{i} {rate} {found:?}");
        }
    }
    let x = tone(250.0, 25.0);
    let [slow, fast] = [25.0, 125.0].map(|rate| {
        compared(&x, &equal_energy(modulated(&x, rate, 1.0), &x))
            .jnd
            .value
    });
    assert!(fast < 0.25 * slow, "{slow} {fast}");
}

/// What makes the difference is named.
/// Also where it comes close to the next one.
#[test]
fn a_tap_is_felt_the_more_the_later_it_comes() {
    for (tap_s, gap_s, most) in [(0.05, 0.2, 7), (0.08, 0.2, 5), (0.15, 0.3, 6)] {
        let tap = tone_of(250.0, 25.0, tap_s, 1.0);
        let taps = |later_s: f64| {
            let at = |i: usize| 0.05 + i as f64 * gap_s + if i == 3 { later_s } else { 0.0 };
            let parts: Vec<(f64, &[f64])> = (0..6).map(|i| (at(i), tap.as_slice())).collect();
            place(0.1 + 6.0 * gap_s, &parts)
        };
        let even = taps(0.0);
        let mut felt = 0.0;
        for step in 1..most {
            let found = compared(&even, &taps(0.020 * step as f64));
            assert_eq!(found.contributions[0].feature, Feature::Rhythm);
            assert!(
                found.jnd.value > felt,
                "{tap_s} s, {step}: {}",
                found.jnd.value
            );
            felt = found.jnd.value;
        }
        assert!(felt > 1.0, "{tap_s} s: {felt}");
    }
}

#[test]
fn the_strongest_feature_is_the_one_that_was_changed() {
    let first = |key: &str| of(key).contributions[0];
    assert_eq!(first("1.200").feature, Feature::Level);
    assert_eq!(first("18").feature, Feature::Duration);
    assert_eq!(first("20").feature, Feature::Accents);
    assert_eq!(first("II.2").feature, Feature::Pitch);
    let rhythm = first("13.30");
    assert_eq!(rhythm.feature, Feature::Modulation);
    assert_eq!(rhythm.modulation_hz.unwrap().0, 24.0);
    assert_eq!(rhythm.to_string(), "modulation around 24 Hz (Pacini)");
    let shares: f64 = of("II.24").contributions.iter().map(|c| c.share).sum();
    assert!((shares - 1.0).abs() < 1e-9);
}

/// The order, the rate and silence around change nothing; a threefold level changes little.
#[test]
fn the_difference_does_not_depend_on_how_it_is_recorded() {
    let [a, b] = pair("6");
    let jnd = compared(&a, &b).jnd.value;
    assert!((compared(&b, &a).jnd.value - jnd).abs() < 1e-9);
    assert!((compared(&padded(&a), &padded(&b)).jnd.value - jnd).abs() < 0.05);
    let louder = compared(&louder(a.clone(), 9.5), &louder(b.clone(), 9.5));
    assert!((louder.jnd.value - jnd).abs() < 0.31, "{louder:?} {jnd}");
    let twice = |x: &[f64]| {
        let between = x.iter().zip(x[1..].iter().chain([&0.0]));
        let samples = between.flat_map(|(a, b)| [*a, 0.5 * (a + b)]).collect();
        Series::<Acceleration>::new(samples, SampleRate::new(2.0 * FS).unwrap()).unwrap()
    };
    let fast = perceived_difference(&twice(&a), &series(&b), &Parameters::published()).unwrap();
    assert!((fast.jnd.value - jnd).abs() < 0.05, "{fast:?}");
}

#[test]
fn what_is_felt_is_said_in_words() {
    let says = |key: &str, parts: &[&str]| {
        let text = of(key).sentence();
        assert!(parts.iter().all(|part| text.contains(part)), "{text}");
    };
    says(
        "13.30",
        &[
            "distinguishable",
            "100 %",
            "modulation around 24 Hz (Pacini), 4",
        ],
    );
    says("3.80", &["below the just-noticeable difference: 0.44 JND"]);
    says("1.80", &["not decided: 1.0", "level (Pacini), 94 %"]);
    let quiet = compared(&tone(250.0, -10.0), &tone(250.0, -20.0));
    assert!(
        quiet.sentence().contains("neither reaches"),
        "{}",
        quiet.sentence()
    );
    assert_eq!(of("II.24").blocks().len(), 3);
    let loud = compared(&tone(250.0, 60.0), &tone(250.0, 60.0));
    assert_eq!(loud.limitations.len(), 2);
    assert!(
        loud.limitations[0].to_string().contains("59.4 dB"),
        "{:?}",
        loud.limitations
    );
}

/// The JND of level moves a difference of level, and nothing else of what concerns time; a map from nail to skin is a filter.
#[test]
fn what_the_difference_depends_on() {
    let [a, b] = pair("1.80");
    let (a, b) = (series(&a), series(&b));
    let published = Parameters::published();
    let all = sensitivity(&published, |changed| perceived_difference(&a, &b, changed)).unwrap();
    assert_eq!(all.len(), PARAMETERS.len());
    let of = |name| all.iter().find(|one| one.parameter == name).unwrap();
    // A threshold 35 dB higher leaves nothing to be felt.
    assert_eq!(all[0].parameter, "threshold_offset_db");
    assert_eq!(all[1].parameter, "level_jnd_20_db");
    let level = all[1].jnd;
    assert!((level[0] / level[1] - 3.0 / 1.8).abs() < 0.15, "{level:?}");
    let rate = of("rate_jnd");
    assert_eq!(rate.jnd[0], rate.jnd[1]);
    let plain = perceived_difference(&a, &b, &published).unwrap();
    let softer = perceived_through(&a, &b, &published, &|_| Decibels(-10.0)).unwrap();
    let apart = plain.sensation_level[0].0 - softer.sensation_level[0].0;
    assert!((apart - 10.0).abs() < 0.1, "{apart}");
}

#[test]
fn below_threshold_nothing_differs() {
    let quiet = compared(&tone(250.0, -10.0), &tone(60.0, -12.0));
    assert_eq!(quiet.criterion.outcome, Outcome::Met, "{quiet:?}");
    let silent = compared(&vec![0.0; 8000], &vec![0.0; 4000]);
    assert_eq!(silent.jnd.value, 0.0);
    assert!(compared(&vec![0.0; 8000], &tone(250.0, 25.0)).jnd.low > 5.0);
    let alike = compared(&taps(2), &taps(2));
    assert!(alike.jnd.high < 1.0 && alike.jnd.value == 0.0);
    assert!((alike.percent_correct.value - 50.0).abs() < 1e-9);
}

#[test]
fn what_cannot_be_compared_is_refused() {
    let published = Parameters::published();
    let at = |rate, n| {
        Series::<Acceleration>::new(vec![1.0; n], SampleRate::new(rate).unwrap()).unwrap()
    };
    let good = at(8000.0, 8000);
    let says = |x: &Series<Acceleration>, p: &Parameters, parts: &[&str]| {
        let text = perceived_difference(&good, x, p).unwrap_err().to_string();
        assert!(parts.iter().all(|part| text.contains(part)), "{text}");
    };
    says(
        &at(500.0, 8000),
        &published,
        &["the test", "1000 Hz", "500 Hz"],
    );
    says(
        &at(8000.0, 100),
        &published,
        &["the test", "0.05 s", "0.0125"],
    );
    let unheard = Parameters {
        level_jnd_20_db: 9.0,
        ..published
    };
    says(&good, &unheard, &["level_jnd_20_db", "1.8", "3", "9"]);
    let error = unheard.checked().unwrap_err();
    assert!(matches!(error, PerceptionError::Parameter { found, .. } if found == 9.0));
}

#[test]
fn every_parameter_lies_within_its_range_and_has_a_source() {
    Parameters::published().checked().unwrap();
    assert!(
        PARAMETERS
            .iter()
            .all(|p| !p.source.is_empty() && p.range[0] < p.range[1])
    );
}

#[derive(Deserialize)]
struct Golden {
    cases: Vec<Case>,
}

#[derive(Deserialize)]
struct Case {
    key: String,
    jnd: f64,
    low: f64,
    high: f64,
    pitch_jnd: f64,
    felt_level_db: f64,
    percent_correct: f64,
    contributions: BTreeMap<String, f64>,
}

/// The values of `golden/perception.py`, an independent program.
#[test]
fn values_are_those_of_the_prototype() {
    let golden: Golden = serde_json::from_str(include_str!("../golden/perception.json")).unwrap();
    assert!(golden.cases.len() >= 12);
    let mut worst = 0.0f64;
    for case in &golden.cases {
        let found = of(&case.key);
        let mut apart = vec![
            found.jnd.value - case.jnd,
            found.jnd.low - case.low,
            found.jnd.high - case.high,
            found.pitch_jnd - case.pitch_jnd,
            found.felt_level.0 - case.felt_level_db,
            found.percent_correct.value - case.percent_correct,
        ];
        for one in &found.contributions {
            let name = match one.modulation_hz {
                Some(band) => format!("modulation {}", band.0),
                None => one.feature.name().into(),
            };
            apart.push(one.jnd - case.contributions.get(&name).copied().unwrap_or(0.0));
        }
        let largest = apart.iter().map(|d| d.abs()).fold(0.0, f64::max);
        eprintln!("{:10} {largest:.1e}", case.key);
        worst = worst.max(largest);
    }
    assert!(worst < 1e-6, "{worst:e}");
}

/// Silence around a vibration that begins and ends by itself changes nothing, at any frequency and whatever its ramps.
#[test]
fn silence_around_a_vibration_is_not_felt() {
    for hz in [20.0, 30.0, 50.0, 80.0, 250.0] {
        for ramp_s in [0.01, 0.05] {
            let n = FS as usize;
            let ramp = ramp_s * FS;
            let samples = (0..n).map(|i| {
                let inside = (i.min(n - 1 - i) as f64 / ramp).min(1.0);
                threshold(hz, 1.0) * 20.0 * inside * (TAU * hz * i as f64 / FS).sin()
            });
            let x: Vec<f64> = samples.collect();
            let found = compared(&x, &padded(&x));
            assert!(found.jnd.high < 0.3, "{hz} Hz, {ramp_s} s: {found:?}");
            // Neither is it by a score, whose band has edges that ring.
            let scored = score(&series(&x), &series(&padded(&x)), &over_the_band()).unwrap();
            let scored = scored.perceived.unwrap().difference;
            assert!(scored.jnd.value < 0.1, "{hz} Hz, {ramp_s} s: {scored:?}");
        }
    }
}

/// An offset of the sensor is not felt, whatever its size, with ramps and with silence around.
#[test]
fn an_offset_is_not_felt() {
    let silence = vec![0.0; 4000];
    let texture = noise(50.0, 500.0, 25.0, 1.0, 11);
    let vibrations = [
        ramp(tone(250.0, 25.0), 0.020),
        [silence.as_slice(), &texture, &silence].concat(),
    ];
    for x in vibrations {
        let rms = (x.iter().map(|v| v * v).sum::<f64>() / x.len() as f64).sqrt();
        for share in [0.05, 0.1, 0.2, 1.0, 10.0] {
            let moved: Vec<f64> = x.iter().map(|v| v + share * rms).collect();
            let found = score(&series(&x), &series(&moved), &over_the_band()).unwrap();
            let jnd = found.perceived.unwrap().difference.jnd.value;
            assert!(jnd < 0.1, "{share}: {jnd}, {}", found.sentence);
        }
    }
}

/// What is cut in the same way is compared in time: a texture of which a part is silent, or softer, is not a copy of it.
#[test]
fn a_copy_that_stops_is_told_apart() {
    let x = noise(40.0, 400.0, 30.0, 4.0, 21);
    let n = x.len();
    let changed = |from: usize, to: usize, gain: f64| -> Vec<f64> {
        let gain = |i: usize| if (from..to).contains(&i) { gain } else { 1.0 };
        x.iter().enumerate().map(|(i, v)| v * gain(i)).collect()
    };
    for (name, test) in [
        ("ends", changed(n / 2, n, 0.0)),
        ("begins", changed(0, n / 2, 0.0)),
        ("is missing", changed(n / 4, n / 2, 0.0)),
        ("softer", changed(n / 2, n, 0.25)),
    ] {
        let found = score(&series(&x), &series(&test), &over_the_band()).unwrap();
        assert!(
            matches!(found.verdict, Verdict::Distinguishable { .. }),
            "{name}: {}",
            found.sentence
        );
    }
}

/// Two realisations of textures that begin and end softly are as near as others; 3 dB between two of them are not below the JND.
#[test]
fn ramps_and_chance_decide_nothing() {
    let (mut below, mut hidden) = (0, 0);
    for seed in 0..8 {
        let of = |seed: u64| ramp(noise(40.0, 400.0, 25.0, 3.0, seed), 0.020);
        let verdict = |test: &[f64]| {
            let found = score(&series(&of(seed)), &series(test), &over_the_band()).unwrap();
            assert!(
                !matches!(found.verdict, Verdict::Distinguishable { .. }),
                "{}",
                found.sentence
            );
            found.verdict
        };
        below += usize::from(verdict(&of(seed + 100)) == Verdict::BelowJnd);
        let short = |seed: u64| noise(50.0, 500.0, 30.0, 0.4, seed);
        let found = score(
            &series(&short(seed)),
            &series(&louder(short(seed + 50), -4.0)),
            &over_the_band(),
        );
        hidden += usize::from(found.unwrap().verdict == Verdict::BelowJnd);
    }
    eprintln!("realisations below {below} of 8, 4 dB below {hidden} of 8");
    assert!(below >= 6 && hidden == 0, "{below} {hidden}");
}

/// The difference grows with the level of a copy, near threshold too.
#[test]
fn more_gain_is_never_felt_less() {
    for seed in 0..6 {
        let slow = noise(2.0, 12.0, 25.0, 4.0, seed);
        let size = slow.iter().fold(0.0f64, |most, v| most.max(v.abs()));
        let carrier = noise(150.0, 350.0, 14.0, 4.0, seed + 30);
        let x: Vec<f64> = carrier
            .iter()
            .zip(&slow)
            .map(|(v, s)| v * (4.0 * s / size).exp())
            .collect();
        let mut before = 0.0;
        for db in [0.8, 1.2, 1.6, 2.0, 2.4, 3.0, 3.6] {
            let found = score(
                &series(&x),
                &series(&louder(x.clone(), db)),
                &over_the_band(),
            );
            let jnd = found.unwrap().perceived.unwrap().difference.jnd.value;
            assert!(jnd > before - 0.1, "{seed}, {db} dB: {jnd} after {before}");
            before = jnd;
        }
    }
}

/// A texture and a copy of it have their chance in common: another level of the copy is felt as that of a tone, whatever the length.
#[test]
fn a_copy_has_no_chance_of_its_own() {
    for seconds in [0.5, 1.0, 3.0] {
        let x = noise(40.0, 500.0, 30.0, seconds, 7);
        let jnd = |test: &[f64]| {
            let found = score(&series(&x), &series(test), &over_the_band()).unwrap();
            found.perceived.unwrap().difference.jnd.value
        };
        let [one, two] = [1.2, 2.4].map(|db| jnd(&louder(x.clone(), db)));
        assert!((0.9..1.25).contains(&two), "{seconds} s: {two}");
        assert!((0.4..0.65).contains(&one), "{seconds} s: {one}");
        // Another realisation is not farther away for that.
        let other = noise(40.0, 500.0, 30.0, seconds, 8);
        assert!(jnd(&other) < 0.5, "{seconds} s");
    }
}

/// What is felt after a much stronger event is not compared, and not said to be alike; nor are events in another order, or one less of many.
#[test]
fn what_the_features_do_not_show_is_not_below_the_jnd() {
    let burst = tone(250.0, 60.0)[..800].to_vec();
    let quiet = tone(250.0, 25.0);
    let silence = vec![0.0; 4000];
    let alone = [&burst[..], &silence, &vec![0.0; 3 * quiet.len()]].concat();
    let followed = [&burst[..], &silence, &quiet, &quiet, &quiet].concat();
    let bursts = |missing: usize| -> Vec<f64> {
        let one = [&tone(250.0, 30.0)[..400], &vec![0.0; 600]].concat();
        let each = (0..64).map(|i| match i == missing {
            true => vec![0.0; 1000],
            false => one.clone(),
        });
        padded(&each.collect::<Vec<_>>().concat())
    };
    let crescendo = |grows: bool| -> Vec<f64> {
        let x = tone(250.0, 30.0);
        let n = x.len();
        let one: Vec<f64> = x
            .iter()
            .enumerate()
            .map(|(i, v)| {
                let share = i as f64 / n as f64;
                v * if grows { share } else { 1.0 - share }
            })
            .collect();
        padded(&vec![one; 8].concat())
    };
    let pairs = [
        ("left out", alone, followed),
        ("a burst less", bursts(64), bursts(30)),
        ("reversed", crescendo(true), crescendo(false)),
    ];
    for (name, a, b) in pairs {
        let found = compared(&a, &b);
        eprintln!("{name}: {}", found.sentence());
        assert_ne!(
            found.criterion.outcome,
            Outcome::Met,
            "{name}: {}",
            found.sentence()
        );
    }
    // What is one vibration is below the just-noticeable difference, delayed and at another phase of its modulation too.
    let x = bursts(64);
    let late = [&vec![0.0; 800], &x[..]].concat();
    assert_eq!(compared(&x, &late).criterion.outcome, Outcome::Met);
    let swelling = |phase: f64| -> Vec<f64> {
        let x = tone(250.0, 30.0);
        let at =
            |(i, v): (usize, &f64)| v * (1.0 + 0.8 * (TAU * 6.0 * i as f64 / FS + phase).sin());
        x.iter().enumerate().map(at).collect()
    };
    let found = compared(&swelling(0.0), &swelling(2.0));
    assert!(found.jnd.value < 1.0, "{}", found.sentence());
}
