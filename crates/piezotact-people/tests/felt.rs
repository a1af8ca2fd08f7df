//! What was felt in confused pairs, on vibrations whose differences are known.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::collections::BTreeSet;
use std::f64::consts::TAU;

use piezotact::Warning;
use piezotact::discrimination::Model;
use piezotact::quantity::{Acceleration, Band, Decibels, Hertz, SampleRate};
use piezotact::recording::{BenchKind, Channel, Condition, Provenance, Recording};
use piezotact::score::ScoreWarning;
use piezotact::series::Series;
use piezotact_people::association::{
    Answer, AnswerTable, Association, AssociationConfig, Declared, Felt, FeltCriterion,
    FeltRecording, FeltUnknown, FeltWarning, PairOutcome, Separates, associate, felt_pairs,
    felt_part, felt_samples,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

const RATE_HZ: f64 = 2500.0;
const SECONDS: f64 = 20.0;

fn model() -> Model {
    Model::over(Band::new(Hertz(20.0), Hertz(1000.0)).unwrap())
}

/// Noise of a second-order resonance at `hz`, of 3 m/s² rms.
fn texture(hz: f64, seed: u64) -> Series<Acceleration> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut uniform = || f64::from(random.next_u32()) / f64::from(u32::MAX) - 0.5;
    let (turn, pole) = (TAU * hz / RATE_HZ, 0.93);
    let (mut last, mut before) = (0.0, 0.0);
    let made: Vec<f64> = (0..(SECONDS * RATE_HZ) as usize)
        .map(|_| {
            let now = uniform() + 2.0 * pole * f64::cos(turn) * last - pole * pole * before;
            (before, last) = (last, now);
            now
        })
        .collect();
    let rms = (made.iter().map(|v| v * v).sum::<f64>() / made.len() as f64).sqrt();
    let made = made.into_iter().map(|v| 3.0 * v / rms).collect();
    Series::new(made, SampleRate::new(RATE_HZ).unwrap()).unwrap()
}

/// Five participants, four presentations each of A and B, of which half are confused; C is presented, and always told.
fn answers() -> AnswerTable {
    let mut of = Vec::new();
    for person in 0..5 {
        for (presented, other) in [("A", "B"), ("B", "A"), ("C", "C")] {
            for trial in 0..4 {
                let answered = if trial < 2 { presented } else { other };
                of.push(Answer {
                    participant: format!("P{person}"),
                    task: "3".into(),
                    trial: format!("{presented}{trial}"),
                    presented: presented.into(),
                    answered: answered.into(),
                    offered: ["A", "B", "C"].map(Into::into).to_vec(),
                    ..Answer::default()
                });
            }
        }
    }
    AnswerTable::new(Declared::plain(&["A", "B", "C"]), of).unwrap()
}

fn felt(person: Option<&str>, sample: &str, vibration: Series<Acceleration>) -> FeltRecording {
    FeltRecording {
        participant: person.map(Into::into),
        sample: sample.into(),
        vibration: Ok(vibration),
    }
}

fn with(recordings: &[FeltRecording]) -> Association {
    let table = answers();
    let found = associate(&table, &AssociationConfig::default()).unwrap();
    found.with_felt(&table, recordings, &model())
}

fn of_two(a: Series<Acceleration>, b: Series<Acceleration>) -> Association {
    with(&[felt(None, "A", a), felt(None, "B", b)])
}

fn separates(found: &Association) -> (Separates, Separates) {
    let one = &found.felt.as_ref().unwrap().pairs[0].comparisons[0];
    (one.by_level, one.by_spectrum)
}

fn sentence(found: &Association) -> String {
    found.felt.as_ref().unwrap().pairs[0].sentence()
}

#[test]
fn six_decibels_of_one_spectrum_are_told_by_level_alone() {
    let found = of_two(
        texture(200.0, 1),
        texture(200.0, 2).amplified(Decibels(6.0)),
    );
    assert_eq!(separates(&found), (Separates::Yes, Separates::No));
    let felt = found.felt.as_ref().unwrap();
    let pair = &felt.pairs[0];
    let jnd = pair.median_jnd(FeltCriterion::Level).unwrap();
    // 6 dB of 1.58 dB; two realisations of 20 s scatter by some tenths of a dB.
    assert!((jnd - 6.0 / 1.58).abs() < 0.3, "{jnd}");
    assert!((pair.comparisons[0].level_db - 6.0).abs() < 0.5);
    let text = sentence(&found);
    assert!(
        text.starts_with(
            "A – B: confused although level separates them, spectrum and time course do not"
        ),
        "{text}"
    );
    // Pairs that nobody confused are left out.
    assert_eq!(felt.pairs.len(), 1);
    assert_eq!(felt.spectra.len(), 2);
    // Levels line by line differ by 6 dB on average.
    let [a, b] = ["A", "B"].map(|name| &felt.spectrum(None, name).unwrap().psd_db);
    let mean = b.iter().zip(a).map(|(b, a)| b - a).sum::<f64>() / a.len() as f64;
    assert!((mean - 6.0).abs() < 0.5, "{mean}");
}

#[test]
fn another_spectrum_at_one_level_is_told_by_spectrum_and_not_by_level() {
    let (a, b) = (texture(80.0, 1), texture(400.0, 2));
    // At one sensation level, not at one rms.
    let level_db = |found: &Association| {
        let felt = found.felt.as_ref().unwrap();
        felt.pairs[0].comparisons[0].level_db
    };
    let apart = level_db(&of_two(a.clone(), b.clone()));
    let found = of_two(a, b.amplified(Decibels(-apart)));
    assert!(level_db(&found).abs() < 1e-9);
    assert_eq!(separates(&found), (Separates::No, Separates::Yes));
    let text = sentence(&found);
    assert!(
        text.contains("spectrum and time course separate them, level does not"),
        "{text}"
    );
}

#[test]
fn realisations_of_one_texture_are_told_by_neither() {
    let found = of_two(texture(200.0, 1), texture(200.0, 2));
    assert_eq!(separates(&found), (Separates::No, Separates::No));
    let text = sentence(&found);
    assert!(
        text.contains("confused; neither level, spectrum nor time course separates them"),
        "{text}"
    );
    let same = of_two(texture(200.0, 1), read_again(&texture(200.0, 1)));
    assert_eq!(separates(&same), (Separates::No, Separates::No));
}

/// A large difference that nobody feels separates nothing.
#[test]
fn what_is_not_felt_separates_nothing() {
    let quiet = |hz, seed| texture(hz, seed).amplified(Decibels(-100.0));
    let found = of_two(quiet(80.0, 1), quiet(400.0, 2));
    assert_eq!(separates(&found), (Separates::No, Separates::No));
    let not_felt = found.warnings.iter().filter_map(Warning::kind);
    let names: Vec<String> = not_felt
        .filter_map(|warning| match warning {
            ScoreWarning::NotFelt { signal, .. } => Some(signal),
            _ => None,
        })
        .collect();
    assert_eq!(names, ["A", "B"]);
}

/// What another sensor, with noise of −46 dB, reads of a texture: no copy.
fn read_again(of: &Series<Acceleration>) -> Series<Acceleration> {
    let mut random = ChaCha8Rng::seed_from_u64(77);
    let mut uniform = || f64::from(random.next_u32()) / f64::from(u32::MAX) - 0.5;
    let samples = of.samples().iter().map(|v| v + 0.05 * uniform());
    Series::new(samples.collect(), of.rate()).unwrap()
}

/// Between one JND and the published range nothing is decided.
#[test]
fn a_difference_in_the_range_of_the_jnd_is_not_decided() {
    let found = of_two(
        texture(200.0, 1),
        read_again(&texture(200.0, 1)).amplified(Decibels(2.0)),
    );
    assert_eq!(separates(&found), (Separates::NotDecided, Separates::No));
    assert!(!sentence(&found).contains("although"));
}

fn warnings(found: &[Warning]) -> Vec<FeltWarning> {
    found.iter().filter_map(Warning::kind).collect()
}

#[test]
fn recordings_that_are_missing_or_too_short_are_warnings_and_no_verdict() {
    let rate = SampleRate::new(RATE_HZ).unwrap();
    let short = Series::new(texture(200.0, 2).samples()[..500].to_vec(), rate).unwrap();
    let silent = Series::new(vec![0.0; 50_000], rate).unwrap();
    for (b, said) in [
        (Ok(short), "too short"),
        (Ok(silent), "no vibration"),
        (Err("found no samples".to_owned()), "found no samples"),
    ] {
        let broken = FeltRecording {
            vibration: b,
            ..felt(None, "B", texture(200.0, 2))
        };
        let found = with(&[felt(None, "A", texture(200.0, 1)), broken]);
        let pair = &found.felt.as_ref().unwrap().pairs[0];
        assert!(pair.comparisons.is_empty());
        assert!(pair.sentence().contains("what was felt is not known"));
        let warnings = warnings(&found.warnings);
        let why = warnings.iter().find_map(|warning| match warning {
            FeltWarning::NotKnown {
                why: FeltUnknown::Unusable { sample, reason },
            } if sample == "B" => Some(reason.clone()),
            _ => None,
        });
        assert!(why.as_ref().unwrap().contains(said), "{why:?}");
        assert!(!warnings.iter().any(|d| matches!(
            d,
            FeltWarning::NotKnown {
                why: FeltUnknown::NoRecording { .. }
            }
        )));
    }
    let found = with(&[felt(None, "A", texture(200.0, 1))]);
    assert!(warnings(&found.warnings).contains(&FeltWarning::NotKnown {
        why: FeltUnknown::NoRecording {
            samples: vec!["B".into()]
        }
    }));
}

/// One level and one spectrum, and a modulation that everybody feels: only the time course separates them; two of one modulation are alike.
#[test]
fn a_modulation_of_one_spectrum_separates_by_time_course_alone() {
    let modulated = |seed: u64, depth: f64| {
        let flat = texture(200.0, seed);
        let rate_hz = flat.rate().hz();
        let samples = flat.samples().iter().enumerate();
        let at = |(i, v): (usize, &f64)| {
            let carrier = (TAU * 5.0 * i as f64 / rate_hz).sin();
            v * (1.0 + depth * carrier) / (1.0 + 0.5 * depth * depth).sqrt()
        };
        Series::new(samples.map(at).collect(), flat.rate()).unwrap()
    };
    let found = of_two(modulated(1, 0.0), modulated(2, 1.0));
    assert_eq!(separates(&found), (Separates::No, Separates::No));
    let text = sentence(&found);
    assert!(
        text.starts_with(
            "A – B: confused although time course separates them, level and spectrum do not"
        ),
        "{text}"
    );
    assert!(text.contains("in modulation around 6 Hz"), "{text}");
    let alike = of_two(modulated(1, 1.0), modulated(2, 1.0));
    let one = &alike.felt.as_ref().unwrap().pairs[0].comparisons[0];
    assert_eq!(one.by_time, Separates::No, "{}", sentence(&alike));
}

#[test]
fn participants_are_compared_each_with_their_own() {
    let mut all = Vec::new();
    for (person, louder_db) in [("P0", 0.0), ("P1", 0.0), ("P2", 6.0), ("P9", 6.0)] {
        all.push(felt(Some(person), "A", texture(200.0, 1)));
        let b = texture(200.0, 2).amplified(Decibels(louder_db));
        all.push(felt(Some(person), "B", b));
    }
    let found = with(&all);
    let pair = &found.felt.as_ref().unwrap().pairs[0];
    assert_eq!(pair.comparisons.len(), 3);
    assert_eq!(pair.separated(), [1, 0, 0]);
    let text = pair.sentence();
    assert!(
        text.contains("confused although of 3 participants, level separates them for 1"),
        "{text}"
    );
    let of_others = FeltWarning::NotKnown {
        why: FeltUnknown::OfOthers {
            people: vec!["P9".into()],
        },
    };
    assert!(warnings(&found.warnings).contains(&of_others));
    let cells = found.cells_table();
    let at = |name: &str| cells.columns.iter().position(|c| c.name == name).unwrap();
    let row = |presented: &str, answered: &str| {
        let mut rows = cells.rows.iter();
        let is = |name: &str, row: &[_], wanted: &str| {
            let cell: &piezotact::page::Cell = &row[at(name)];
            cell.text() == wanted
        };
        rows.find(|row| is("presented", row, presented) && is("answered", row, answered))
            .unwrap()
    };
    for [a, b] in [["A", "B"], ["B", "A"]] {
        assert_eq!(row(a, b)[at("felt_level_separates")].whole(), "1");
        assert_eq!(row(a, b)[at("felt_compared")].whole(), "3");
    }
    assert_eq!(row("A", "C")[at("felt_compared")].whole(), "");
}

/// One file under two names used to be "neither level, spectrum nor time course separates them", and a scaled one "level separates them".
#[test]
fn copies_are_not_compared_whatever_their_level_and_delay() {
    let one = texture(200.0, 1);
    let later = |by: usize| {
        let samples = one.samples()[..one.samples().len() - by].to_vec();
        let later = [vec![0.0; by], samples].concat();
        Series::new(later, one.rate()).unwrap()
    };
    for copy in [
        one.clone(),
        one.clone().amplified(Decibels(6.0)),
        later(500),
    ] {
        let found = of_two(one.clone(), copy);
        assert!(found.felt.as_ref().unwrap().pairs[0].comparisons.is_empty());
        let is_said = |warning: &FeltWarning| {
            matches!(warning, FeltWarning::NotKnown { why: FeltUnknown::NotCompared { reason, .. } }
                if reason.contains("a copy"))
        };
        assert!(warnings(&found.warnings).iter().any(is_said));
    }
    let of_two_sensors = of_two(texture(200.0, 1), texture(200.0, 2));
    assert_eq!(of_two_sensors.felt.unwrap().pairs[0].comparisons.len(), 1);
}

#[test]
fn one_recording_for_all_is_a_warning_and_a_document_comes_back() {
    let found = of_two(texture(200.0, 1), texture(200.0, 2));
    assert!(warnings(&found.warnings).contains(&FeltWarning::NotKnown {
        why: FeltUnknown::OneForAll { participants: 5 }
    }));
    let text = serde_json::to_string(&found).unwrap();
    let back: Association = serde_json::from_str(&text).unwrap();
    assert_eq!(back.felt, found.felt);
}

#[test]
fn pairs_that_nobody_confused_or_that_are_told_apart_are_not_looked_at() {
    let table = answers();
    let mut found = associate(&table, &AssociationConfig::default()).unwrap();
    assert_eq!(
        felt_samples(&found.pairs),
        ["A", "B"].map(Into::into).into()
    );
    for pair in &mut found.pairs {
        pair.outcome = PairOutcome::NotConfused;
    }
    let nobody = BTreeSet::new();
    let all = [felt(None, "A", texture(200.0, 1))];
    let (Felt { pairs, spectra, .. }, _) = felt_pairs(&found.pairs, &all, &nobody, &model());
    assert!(pairs.is_empty() && spectra.is_empty());
}

/// A measurement lasts longer than its drive: only what the drive made is felt as the texture.
#[test]
fn silence_around_a_drive_is_not_felt() {
    use piezotact::quantity::Unit;
    let rate = SampleRate::new(RATE_HZ).unwrap();
    let made = |scale: f64| -> Vec<f64> {
        let tone = |i: usize| scale * f64::sin(TAU * 0.1 * (i as f64 + 0.5));
        (0..4000)
            .map(|i| {
                if (1000..3000).contains(&i) {
                    tone(i)
                } else {
                    0.0
                }
            })
            .collect()
    };
    let channel = |name: &str, unit, samples| Channel {
        name: name.into(),
        unit,
        samples,
    };
    let provenance = || Provenance {
        bench: Some(BenchKind::Scripted),
        ..Provenance::default()
    };
    let of = |channels| Recording::new(channels, rate, Condition::default(), provenance()).unwrap();
    let felt = channel("acceleration", Unit::MetrePerSecondSquared, made(2.0));
    let alone = of(vec![felt.clone()]);
    assert_eq!(felt_part("A", &alone).unwrap().0.samples().len(), 4000);
    let drive = channel("drive", Unit::FullScale, made(0.5));
    let (part, left_out) = felt_part("A", &of(vec![drive, felt])).unwrap();
    assert_eq!(left_out, None);
    // The first and the last 0.05 % of its energy are a sample each.
    assert!(
        part.samples().len().abs_diff(2000) <= 2,
        "{}",
        part.samples().len()
    );
}
