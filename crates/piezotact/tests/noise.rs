//! The noise of a sensor at rest: SciPy's numbers, and signals of which the sentence that it was at rest would be false.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::f64::consts::TAU;

use piezotact::criterion::{Criterion, Outcome};
use piezotact::noise::{Noise, NoiseConfig, NoiseCriterion, NoiseError, NoiseWarning, noise};
use piezotact::quantity::{Band, Hertz, SampleRate, Unit};
use piezotact::recording::{Channel, Condition, Provenance, Recording, Touch};
use piezotact::statistics::Direction;
use serde_json::Value;

const RATE: usize = 2500;

/// The generator of golden/noise.py.
struct Random(u64);

impl Random {
    fn uniform(&mut self) -> f64 {
        self.0 = (self.0.wrapping_mul(6_364_136_223_846_793_005))
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 11) as f64 / (1u64 << 53) as f64
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.uniform()).sum::<f64>() - 6.0
    }
}

fn white(seed: u64, seconds: usize) -> Vec<f64> {
    let mut random = Random(seed);
    (0..RATE * seconds)
        .map(|_| 0.01 * random.normal())
        .collect()
}

fn time_s(i: usize) -> f64 {
    i as f64 / RATE as f64
}

fn with(mut x: Vec<f64>, add: impl Fn(f64) -> f64) -> Vec<f64> {
    for (i, v) in x.iter_mut().enumerate() {
        *v += add(time_s(i));
    }
    x
}

fn tone(hz: f64, amplitude: f64) -> impl Fn(f64) -> f64 {
    move |t| amplitude * (TAU * hz * t).sin()
}

fn recorded(samples: Vec<f64>, condition: Condition) -> Recording {
    let channel = Channel {
        name: "acc".into(),
        unit: Unit::MetrePerSecondSquared,
        samples,
    };
    let rate = SampleRate::new(RATE as f64).unwrap();
    Recording::new(vec![channel], rate, condition, Provenance::default()).unwrap()
}

fn try_of(samples: Vec<f64>, condition: Condition) -> Result<Noise, NoiseError> {
    let recording = recorded(samples, condition);
    let config = NoiseConfig::usual(recording.rate()).unwrap();
    noise(&recording, None, &config)
}

fn of(samples: Vec<f64>) -> Noise {
    try_of(samples, Condition::default()).unwrap()
}

fn outcome(found: &Noise, what: NoiseCriterion) -> Outcome {
    found
        .criteria
        .iter()
        .find(|c| c.what == what)
        .unwrap()
        .outcome
}

fn standing_out(found: &Noise) -> Vec<f64> {
    let lines = found.mains.iter().filter(|line| line.rms.is_some());
    lines
        .map(|line| line.mains_hz * line.harmonic as f64)
        .collect()
}

fn not_at_rest(found: &Noise) -> bool {
    let warnings = &found.warnings;
    let reported = warnings
        .iter()
        .any(|d| matches!(d.kind(), Some(NoiseWarning::NotAtRest { .. })));
    assert_eq!(reported, found.at_rest() == Outcome::NotMet);
    assert_eq!(reported, found.sentence().contains("was not at rest"));
    reported
}

#[test]
fn the_numbers_are_those_of_scipy() {
    let golden: Value = serde_json::from_str(include_str!("golden/noise.json")).unwrap();
    let x = with(white(7, 20), |t| 0.02 + 1e-4 * t + tone(50.0, 0.004)(t));
    let found = of(x);
    let same = |what: &str, ours: f64, theirs: &Value| {
        let theirs = theirs.as_f64().unwrap();
        assert!(
            (ours / theirs - 1.0).abs() < 1e-9,
            "{what}: {ours}, SciPy {theirs}"
        );
    };
    same("rms", found.rms, &golden["rms"]);
    same("floor", found.floor_rms, &golden["floor_rms"]);
    for (i, density) in found.densities.iter().enumerate() {
        same("density", density.value, &golden["densities"][i]);
    }
    for (i, psd) in found.psd.iter().step_by(50).enumerate() {
        same("psd", *psd, &golden["psd"][i]);
    }
    same(
        "line",
        found.mains[0].above_db.unwrap(),
        &golden["above_db"],
    );
    let drift = found.drift.unwrap();
    same("slope", drift.slope, &golden["slope"]);
    let interval = drift.slope_interval.unwrap();
    same("low", interval[0], &golden["slope_interval"][0]);
    same("high", interval[1], &golden["slope_interval"][1]);
    same(
        "independent parts",
        drift.independent,
        &golden["independent"],
    );
    same("range", drift.range, &golden["range"]);
}

#[test]
fn white_noise_is_at_rest_without_hum_or_drift() {
    let mut drifting = 0;
    for seed in 1..=10 {
        let found = of(white(seed, 20));
        assert_eq!(
            found.at_rest(),
            Outcome::Met,
            "seed {seed}: {:?}",
            found.criteria
        );
        assert!(
            found.warnings.is_empty() && !not_at_rest(&found),
            "seed {seed}"
        );
        assert_eq!(standing_out(&found), [0.0; 0], "seed {seed}");
        assert_eq!(outcome(&found, NoiseCriterion::Drift), Outcome::Met);
        drifting += usize::from(found.drift.unwrap().direction() != Direction::NotShown);
        // White noise of 0.01 over 1250 Hz: 0.01·√(990/1250) in the band.
        assert!((found.rms / (0.01 * (990.0_f64 / 1250.0).sqrt()) - 1.0).abs() < 0.02);
    }
    assert!(
        drifting <= 2,
        "95 % intervals: {drifting} of 10 without the truth"
    );
}

#[test]
fn hum_stands_out_with_its_level_and_a_tone_beside_it_does_not() {
    let hum = with(white(1, 20), |t| {
        tone(50.0, 0.003)(t) + tone(150.0, 0.002)(t)
    });
    let found = of(hum);
    assert_eq!(standing_out(&found), [50.0, 150.0]);
    for (line, amplitude) in [(0, 0.003_f64), (2, 0.002)] {
        let rms = found.mains[line].rms.unwrap();
        assert!((rms / (amplitude / 2f64.sqrt()) - 1.0).abs() < 0.1, "{rms}");
    }
    assert_eq!(
        found.at_rest(),
        Outcome::Met,
        "hum is steady: {:?}",
        found.criteria
    );
    assert_eq!(
        standing_out(&of(with(white(2, 20), tone(60.0, 0.003)))),
        [60.0]
    );
    for hz in [51.0, 51.5, 48.7, 55.0, 61.3, 98.0] {
        let found = of(with(white(3, 20), tone(hz, 0.01)));
        assert_eq!(standing_out(&found), [0.0; 0], "{hz} Hz");
    }
}

/// A tremor, a fan, a periodic texture under a finger, hum of 36 dB: what is in the recording is in the rms and not in the floor.
#[test]
fn a_steady_line_does_not_show_rest_and_does_not_lift_the_floor() {
    let quiet = of(white(8, 20)).floor_rms;
    for (hz, amplitude) in [
        (3.0, 0.1),
        (8.0, 0.05),
        (47.0, 0.02),
        (22.0, 0.05),
        (213.0, 0.03),
    ] {
        let found = of(with(white(8, 20), tone(hz, amplitude)));
        assert_eq!(found.at_rest(), Outcome::NotDecided, "{hz} Hz");
        let line =
            |c: &&Criterion<NoiseCriterion>| matches!(c.what, NoiseCriterion::OtherLine { .. });
        let lines: Vec<_> = found.criteria.iter().filter(line).collect();
        assert_eq!(lines.len(), 1, "{hz} Hz: {lines:?}");
        assert_eq!(lines[0].what, NoiseCriterion::OtherLine { at_hz: hz });
        assert!((found.floor_rms / quiet - 1.0).abs() < 0.03, "{hz} Hz");
        let whole = if hz < 10.0 {
            0.0
        } else {
            amplitude * amplitude / 2.0
        };
        let whole = (quiet * quiet + whole).sqrt();
        assert!(
            (found.rms / whole - 1.0).abs() < 0.02,
            "{hz} Hz: {} {whole}",
            found.rms
        );
    }
    let hum = of(with(white(9, 20), |t| {
        tone(50.0, 0.02)(t) + tone(150.0, 0.008)(t)
    }));
    assert_eq!(hum.at_rest(), Outcome::Met, "hum shows no motion");
    let whole = (quiet * quiet + (0.02_f64.powi(2) + 0.008_f64.powi(2)) / 2.0).sqrt();
    assert!((hum.rms / whole - 1.0).abs() < 0.02, "{} {whole}", hum.rms);
    assert!(
        hum.mains_sentence().contains("50 Hz 0.014")
            && hum.mains_sentence().contains("150 Hz 0.00")
    );
}

#[test]
fn what_moves_is_not_called_rest_and_does_not_lift_the_floor() {
    let quiet = of(white(4, 20)).floor_rms;
    let knock = |t: f64| {
        if t >= 7.3 {
            0.5 * (-(t - 7.3) / 0.004).exp() * (TAU * 180.0 * t).sin()
        } else {
            0.0
        }
    };
    let stroke = |t: f64| {
        if (5.0..6.5).contains(&t) {
            tone(213.0, 0.08)(t)
        } else {
            0.0
        }
    };
    for moved in [with(white(4, 20), knock), with(white(4, 20), stroke)] {
        let found = of(moved);
        assert!(not_at_rest(&found), "{:?}", found.criteria);
        assert!(
            (found.floor_rms / quiet - 1.0).abs() < 0.05 && found.rms > 1.03 * quiet,
            "{} {} {quiet}",
            found.rms,
            found.floor_rms
        );
    }
    // Half of it 3 dB louder: no part stands out, and yet the level is not one.
    let mut louder = white(5, 20);
    for v in &mut louder[RATE * 10..] {
        *v *= 1.41;
    }
    assert!(not_at_rest(&of(louder)));
    // The level goes away for a second.
    let mut lull = white(6, 20);
    for v in &mut lull[RATE * 10..RATE * 11] {
        *v *= 0.1;
    }
    assert!(not_at_rest(&of(lull)));
}

/// Noise of few Hz scatters by itself: it is not said to move, and not said to be at rest where that cannot be known.
#[test]
fn narrow_noise_is_not_accused() {
    for seed in 1..=5 {
        let mut random = Random(seed);
        let (mut a, mut b) = (0.0, 0.0);
        // A resonance at 40 Hz, 4 Hz wide.
        let (r, turn) = (
            (-std::f64::consts::PI * 4.0 / RATE as f64).exp(),
            TAU * 40.0 / RATE as f64,
        );
        let narrow = (0..RATE * 30).map(|_| {
            let next = 2.0 * r * turn.cos() * a - r * r * b + 1e-3 * random.normal();
            (a, b) = (next, a);
            next
        });
        let found = of(narrow.collect());
        assert_ne!(
            found.at_rest(),
            Outcome::NotMet,
            "seed {seed}: {:?}",
            found.criteria
        );
    }
}

#[test]
fn drift_is_found_where_it_is_and_not_decided_where_the_recording_is_short() {
    let found = of(with(white(8, 30), |t| 0.001 * t));
    let drift = found.drift.unwrap();
    let [low, high] = drift.slope_interval.unwrap();
    assert!(low < 0.001 && 0.001 < high && low > 0.0009, "{drift:?}");
    assert_eq!(drift.direction(), Direction::Rises);
    assert_eq!(outcome(&found, NoiseCriterion::Drift), Outcome::NotMet);
    assert_eq!(found.at_rest(), Outcome::Met, "drift is no motion");
    let short = of(with(white(8, 8), |t| 0.001 * t));
    assert_eq!(short.drift, None);
    assert_eq!(outcome(&short, NoiseCriterion::Drift), Outcome::NotDecided);
    assert!(short.drift_sentence().contains("not decided"));
    // A random walk goes up and down without a trend.
    let mut wrong = 0;
    for seed in 1..=20 {
        let (mut random, mut walk) = (Random(100 + seed), 0.0);
        let x = (0..RATE * 30).map(|_| {
            walk += 2e-4 * random.normal();
            walk + 0.01 * random.normal()
        });
        let drift = of(x.collect()).drift.unwrap();
        wrong += usize::from(drift.direction() != Direction::NotShown);
    }
    assert!(wrong <= 4, "a trend claimed in {wrong} of 20 random walks");
}

#[test]
fn a_recording_that_states_a_sliding_finger_is_not_at_rest() {
    let sliding = Condition {
        speed_m_s: Some(0.03),
        ..Condition::default()
    };
    assert!(not_at_rest(&try_of(white(9, 10), sliding).unwrap()));
    let touched = Condition {
        touch: Some(Touch::Active),
        ..Condition::default()
    };
    let found = try_of(white(9, 10), touched).unwrap();
    assert_eq!(found.at_rest(), Outcome::NotDecided);
    assert!(
        found
            .warnings
            .iter()
            .any(|d| matches!(d.kind(), Some(NoiseWarning::PerhapsNotAtRest { .. })))
    );
}

#[test]
fn what_cannot_be_analysed_is_named() {
    let refused = |samples| {
        try_of(samples, Condition::default())
            .unwrap_err()
            .to_string()
    };
    let short = refused(white(1, 3));
    assert!(
        short.contains("4 s") && short.contains("record longer"),
        "{short}"
    );
    assert!(refused(vec![0.5; RATE * 10]).contains("never changes"));
    let recording = recorded(white(1, 10), Condition::default());
    let config = NoiseConfig {
        band_hz: Band::new(Hertz(10.0), Hertz(2000.0)).unwrap(),
        ..NoiseConfig::usual(recording.rate()).unwrap()
    };
    let beyond = noise(&recording, None, &config).unwrap_err().to_string();
    assert!(beyond.contains("1250"), "{beyond}");
    assert!(NoiseConfig::usual(SampleRate::new(20.0).unwrap()).is_err());
}

/// Random walks without a trend: a 95 % interval that leaves out 0 in a third of them would be none.
#[test]
fn a_random_walk_is_not_said_to_drift() {
    for seconds in [10, 20, 60] {
        let missed = (0..200).filter(|seed| {
            let mut sum = 0.0;
            let steps = white(1000 + *seed, 1);
            let means: Vec<f64> = (steps.iter().step_by(RATE / seconds).take(seconds))
                .map(|step| {
                    sum += step;
                    sum
                })
                .collect();
            let found = piezotact::statistics::trend(&means, 1.0).unwrap();
            found
                .slope_interval
                .is_some_and(|[low, high]| low > 0.0 || high < 0.0)
        });
        let missed = missed.count();
        assert!(
            missed <= 24,
            "{seconds} s: {missed} of 200 without the truth"
        );
    }
}
