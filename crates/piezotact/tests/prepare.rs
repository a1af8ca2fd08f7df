//! Prepared drives: SciPy's numbers for the typical stroke, levels that keep differences, and verdicts that would be false.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::f64::consts::TAU;

use num_complex::Complex;
use piezotact::criterion::Outcome;
use piezotact::prepare::{
    ChosenStroke, PrepareWarning, Prepared, PreparedDrives, State, TextureStrokes, common_level,
    typical_stroke,
};
use piezotact::quantity::{Acceleration, Band, Decibels, Drive, Hertz, SampleRate, Seconds};
use piezotact::render::{RenderConfig, render};
use piezotact::series::Series;
use piezotact::transfer::{Estimator, TransferFunction};
use piezotact::warning::{Scatter, ScatterWarning, Warnings};

const RATE_HZ: f64 = 5000.0;

fn rate() -> SampleRate {
    SampleRate::new(RATE_HZ).unwrap()
}

fn band() -> Band {
    Band::new(Hertz(20.0), Hertz(1000.0)).unwrap()
}

/// The generator of golden/prepare.py.
struct Random(u64);

impl Random {
    fn normal(&mut self) -> f64 {
        let uniform = |state: &mut u64| {
            *state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (*state >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..12).map(|_| uniform(&mut self.0)).sum::<f64>() - 6.0
    }
}

fn stroke(
    random: &mut Random,
    (samples, level, tone_hz): (usize, f64, f64),
) -> Series<Acceleration> {
    let noise: Vec<f64> = (0..samples).map(|_| random.normal()).collect();
    let tone = |i: usize| (TAU * tone_hz * i as f64 / RATE_HZ).sin();
    let samples = noise.iter().enumerate();
    let samples = samples.map(|(i, noise)| level * (0.5 * noise + 2.0 * tone(i)) + 0.3);
    Series::new(samples.collect(), rate()).unwrap()
}

fn strokes(each: &[(usize, f64, f64)]) -> Vec<Series<Acceleration>> {
    let mut random = Random(11);
    each.iter().map(|one| stroke(&mut random, *one)).collect()
}

const GOLDEN: [(usize, f64, f64); 5] = [
    (5000, 1.0, 180.0),
    (4400, 1.05, 180.0),
    (6000, 0.97, 180.0),
    (5200, 2.0, 180.0),
    (4800, 1.0, 420.0),
];

#[test]
fn the_typical_stroke_is_that_of_scipy() {
    let golden: serde_json::Value =
        serde_json::from_str(include_str!("golden/prepare.json")).unwrap();
    let found = typical_stroke(&strokes(&GOLDEN), band()).unwrap();
    assert_eq!(found.index as u64, golden["closest"].as_u64().unwrap());
    let bands = golden["bands_hz"].as_array().unwrap();
    assert_eq!(found.bands.len(), bands.len());
    for (ours, theirs) in found.bands.iter().zip(bands) {
        assert!((ours.low().0 - theirs[0].as_f64().unwrap()).abs() < 1e-9);
    }
    for (ours, theirs) in
        (found.distances_db.iter()).zip(golden["distances_db"].as_array().unwrap())
    {
        // Both transform the same samples; sums of some hundred lines differ by rounding.
        assert!((ours.unwrap() - theirs.as_f64().unwrap()).abs() < 1e-9);
    }
    assert!((found.spread_db() - golden["spread_db"].as_f64().unwrap()).abs() < 1e-9);
}

/// Neither the strongest stroke nor the one with another tone stands for the others, wherever it is.
#[test]
fn an_unusual_stroke_is_not_chosen() {
    for odd in [(5000, 2.0, 180.0), (5000, 0.4, 180.0), (5000, 1.0, 600.0)] {
        for at in 0..4 {
            let mut each = vec![(5000, 1.0, 180.0), (4900, 1.02, 180.0), (5100, 0.98, 180.0)];
            each.insert(at, odd);
            let found = typical_stroke(&strokes(&each), band()).unwrap();
            assert_ne!(found.index, at, "{odd:?}");
            let own = found.distances_db[at].unwrap();
            let others = (0..4).filter(|i| *i != at);
            assert!(
                others
                    .map(|i| found.distances_db[i].unwrap())
                    .all(|db| db < own)
            );
        }
    }
}

#[test]
fn short_and_single_strokes_are_reported() {
    // A stroke of 0.1 s is not compared beside longer ones.
    let found = typical_stroke(&strokes(&[(500, 1.0, 180.0), (5000, 1.0, 180.0)]), band()).unwrap();
    assert_eq!((found.index, found.distances_db[0]), (1, None));
    let only = typical_stroke(&strokes(&[(500, 1.0, 180.0)]), band()).unwrap();
    let codes = |seconds: f64| -> Vec<String> {
        let warnings = only.warnings("S8", Seconds(seconds));
        warnings
            .iter()
            .map(|warning| warning.code.to_string())
            .collect()
    };
    assert_eq!(codes(0.1), ["few", "unusual_stroke"]);
    assert_eq!(codes(1.0), ["few"]);
    // Strokes at 1, 10 and 100 times the level are not one texture.
    let wide = [(5000, 0.1, 180.0), (5000, 1.0, 300.0), (5000, 10.0, 90.0)];
    let wide = typical_stroke(&strokes(&wide), band()).unwrap();
    let warnings = wide.warnings("S8", Seconds(1.0));
    assert!(matches!(
        warnings[0].kind(),
        Some(ScatterWarning::Scatter { of: Scatter::StrokesOfTexture { spread_db, .. } }) if spread_db > 6.0
    ));
    assert!(typical_stroke(&[], band()).is_err());
}

/// A device that answers with one m/s² at full scale.
fn function(gain: f64) -> TransferFunction<Drive, Acceleration> {
    let response = vec![Complex::new(gain, 0.0); 1025];
    let coherence = vec![1.0; 1025];
    TransferFunction::from_lines(
        response,
        coherence,
        RATE_HZ / 2048.0,
        rate(),
        Estimator::H1,
        100,
    )
    .unwrap()
}

#[test]
fn one_level_fits_all_textures_and_is_set_by_the_most_demanding_one() {
    let targets = strokes(&[(5000, 0.1, 180.0), (5000, 1.0, 180.0), (5000, 0.3, 180.0)]);
    let config = RenderConfig::over(band(), SampleRate::new(48_000.0).unwrap());
    let found = common_level(&targets, &function(1.0), &config, Decibels(0.0));
    assert_eq!(found.limited_by, Some(1));
    assert!((-14.0..-6.0).contains(&found.level_db), "{found:?}");
    for target in &targets {
        let target = target.clone().amplified(Decibels(found.level_db));
        assert!(render(&target, &function(1.0), &config).is_ok());
    }
    // A tenth more does not fit.
    let more = targets[1].clone().amplified(Decibels(found.level_db + 0.1));
    assert!(render(&more, &function(1.0), &config).is_err());
    // With a margin it is lower by as much.
    let lower = common_level(&targets, &function(1.0), &config, Decibels(0.3));
    assert!((found.level_db - lower.level_db - 0.3).abs() < 0.051);
    // Where all fit, nothing is lowered, margin or not.
    let strong = common_level(&targets, &function(100.0), &config, Decibels(0.3));
    assert_eq!((strong.level_db, strong.limited_by), (0.0, None));
}

fn prepared(texture: &str, state: State, level_db: f64) -> Prepared {
    let strokes = TextureStrokes {
        texture: texture.into(),
        recordings: 1,
        strokes: 6,
        rejected: 0,
        spread_db: 1.0,
        stroke: ChosenStroke {
            file: "S.parquet".into(),
            number: 1,
            from_s: 0.0,
            to_s: 1.0,
            rms_m_s2: 1.0,
            distance_db: Some(1.0),
        },
    };
    Prepared {
        drive: Some("S.wav".into()),
        level_db: Some(level_db),
        state,
        sentence: state.word().into(),
        ..Prepared::not_rendered(strokes, "S.wav".into(), "")
    }
}

fn concluded(textures: Vec<Prepared>) -> PreparedDrives {
    PreparedDrives {
        participant: None,
        transfer: "tf.json".into(),
        bench: None,
        band_hz: band(),
        mode: None,
        level_db: None,
        level_set_by: None,
        outcome: Outcome::Met,
        sentence: String::new(),
        not_good_enough: Vec::new(),
        textures,
        failed: Vec::new(),
        warnings: Warnings::default(),
    }
    .concluded()
}

/// Only drives that were measured and passed make a preparation that can be used.
#[test]
fn nothing_but_a_passed_verification_is_good_enough() {
    let open = [
        (State::PassedInPart, Outcome::NotDecided),
        (State::NotPassed, Outcome::NotMet),
        (State::NotDecided, Outcome::NotDecided),
        (State::Rehearsed, Outcome::NotDecided),
        (State::NotMeasured, Outcome::NotDecided),
        (State::NotRendered, Outcome::NotMet),
    ];
    for (state, outcome) in open {
        let found = concluded(vec![
            prepared("S1", State::Passed, 0.0),
            prepared("S8", state, 0.0),
        ]);
        assert_eq!(found.outcome, outcome, "{state:?}");
        assert_eq!(found.not_good_enough[0].texture, "S8");
        let said = format!("1 of 2 drives passed; S8 {}", state.word());
        assert_eq!(found.sentence, said);
        let alone = concluded(vec![prepared("S8", state, 0.0)]);
        assert_eq!(
            alone.sentence,
            format!("No drive passed; S8 {}", state.word())
        );
    }
    let both = concluded(vec![
        prepared("S1", State::Passed, -1.0),
        prepared("S8", State::Passed, -1.0),
    ]);
    assert_eq!(
        (both.outcome, both.sentence.as_str()),
        (Outcome::Met, "All 2 drives passed")
    );
    assert!(both.not_good_enough.is_empty() && both.warnings.is_empty());
    assert_eq!(concluded(Vec::new()).outcome, Outcome::NotDecided);
}

#[test]
fn levels_that_differ_are_reported() {
    let found = concluded(vec![
        prepared("S1", State::Passed, -4.0),
        prepared("S8", State::Passed, 0.0),
    ]);
    let warnings: Vec<_> = found.warnings.iter().collect();
    assert!(matches!(
        warnings[0].kind(),
        Some(PrepareWarning::LevelsDiffer { lowest_db, highest_db }) if lowest_db == -4.0 && highest_db == 0.0
    ));
}
