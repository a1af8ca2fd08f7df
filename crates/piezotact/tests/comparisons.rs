//! Comparisons of recordings in which something else than the texture differs: how long the strokes last, and the noise of the sensor.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::f64::consts::TAU;

use crate::vibrations::Random;
use piezotact::compare::Distinguishability;
use piezotact::discrimination::Model;
use piezotact::quantity::{Band, Hertz, SampleRate, Unit};
use piezotact::recording::{Channel, Condition, Provenance, Recording};
use piezotact::study::{
    AnalysedRecording, Breadth, Discrimination, Factor, Gesture, Naming, Question, Recorded,
    Stated, StudyAnalysis, StudySettings, Trend, analyse, cut,
};

const RATE_HZ: f64 = 2000.0;
/// Between strokes nothing is touched, s.
const REST_S: f64 = 0.6;
/// A stroke begins and ends so slowly, s.
const RAMP_S: f64 = 0.12;

/// Strokes of `lasts_s` each, whose vibration is `texture` of so many samples, by a sensor with `noise_m_s2` rms.
fn recorded(
    (sample, speed_m_s): (&str, f64),
    (strokes, lasts_s): (usize, f64),
    noise_m_s2: f64,
    random: &mut Random,
    texture: &dyn Fn(usize, &mut Random) -> Vec<f64>,
) -> AnalysedRecording {
    let [rest, length, ramp] = [REST_S, lasts_s, RAMP_S].map(|s| (s * RATE_HZ) as usize);
    let (mut nail, mut touched) = (vec![0.0; rest], vec![0.0; rest]);
    for _ in 0..strokes {
        let vibration = texture(length, random);
        for (i, v) in vibration.into_iter().enumerate() {
            let share = (i.min(length - i) as f64 / ramp as f64).min(1.0);
            nail.push(v * share);
            touched.push(share);
        }
        nail.extend(vec![0.0; rest]);
        touched.extend(vec![0.0; rest]);
    }
    let mut with_noise = |samples: &[f64], full: f64, noise: f64| -> Vec<f64> {
        let samples = samples.iter();
        samples
            .map(|v| full * v + noise * random.normal())
            .collect()
    };
    let nail = with_noise(&nail, 1.0, noise_m_s2);
    let fz = with_noise(&touched, 0.5, 0.003);
    let speed = with_noise(&touched, speed_m_s, 0.002 * speed_m_s);
    let channel = |name: &str, unit, samples| Channel {
        name: name.into(),
        unit,
        samples,
    };
    let channels = vec![
        channel("nail", Unit::MetrePerSecondSquared, nail),
        channel("fz", Unit::Newton, fz),
        channel("speed", Unit::MetrePerSecond, speed),
    ];
    let own = Condition {
        sample: Some(sample.into()),
        speed_m_s: Some(speed_m_s),
        ..Condition::default()
    };
    let rate = SampleRate::new(RATE_HZ).unwrap();
    let name = format!("{sample}_{}", random.uniform());
    let recorded = Recorded {
        file: name.clone(),
        name,
        recording: Recording::new(channels, rate, own, Provenance::default()).unwrap(),
        naming: Naming::default(),
        cuts: None,
        cuts_are_looked_for_in: String::new(),
    };
    cut(recorded, &Stated::nothing()).unwrap()
}

fn compared(takes: Vec<AnalysedRecording>, by: Factor) -> StudyAnalysis {
    let band = Band::new(Hertz(20.0), Hertz(900.0)).unwrap();
    let question = Question::Changes {
        by,
        model: Model::over(band),
    };
    let settings = StudySettings {
        gesture: Gesture::Usual,
        segment: None,
        sets: Vec::new(),
        twin_sets: Vec::new(),
        ridge_m: None,
        question,
        breadth: Breadth::Question,
    };
    analyse(takes, &settings).unwrap()
}

/// The two samples of `takes` are compared, and not told apart.
fn assert_alike(takes: Vec<AnalysedRecording>) {
    let study = compared(takes, Factor::Sample);
    let Some(Discrimination::Found(found)) = &study.discrimination else {
        panic!("{:?}", study.discrimination);
    };
    let groups = &found.settings[0];
    let outcomes: Vec<_> = groups.pairs.iter().map(|pair| pair.outcome).collect();
    let told_apart = outcomes.contains(&Distinguishability::ToldApart);
    assert!(
        outcomes.len() == 1 && !told_apart,
        "{:?}",
        groups.sentences()
    );
}

/// Bursts of noise, some three a second, with silence between them.
fn bursts(length: usize, random: &mut Random) -> Vec<f64> {
    let mut from = (0.3 * RATE_HZ * random.uniform()) as usize;
    let mut envelope = vec![0.02; length];
    while from < length {
        let to = (from + 160).min(length);
        envelope[from..to].fill(4.0);
        from += 600;
    }
    envelope.into_iter().map(|e| e * random.normal()).collect()
}

#[test]
fn strokes_of_one_process_that_last_longer_are_not_told_apart() {
    let mut random = Random::new(11);
    for _study in 0..3 {
        let mut takes = Vec::new();
        for (sample, lasts_s) in [("A", 1.0), ("B", 3.0)] {
            for _recording in 0..5 {
                let strokes = (5, lasts_s);
                takes.push(recorded(
                    (sample, 0.03),
                    strokes,
                    0.02,
                    &mut random,
                    &bursts,
                ));
            }
        }
        assert_alike(takes);
    }
}

/// The exponent of the rms on the speed, with its interval, by a sensor with noise of its own at all times: of white noise whose `level`, m/s²,
/// is that of a speed, beside the lines of a machine that runs while the finger slides, each its frequency in Hz and its amplitude in m/s².
fn exponent(
    noise_m_s2: f64,
    random: &mut Random,
    level: fn(f64) -> f64,
    lines: &[[f64; 2]],
) -> Option<(f64, [f64; 2])> {
    let mut takes = Vec::new();
    for speed_m_s in [0.01, 0.015, 0.025, 0.04, 0.06] {
        for _recording in 0..2 {
            let texture = |length: usize, random: &mut Random| {
                let level = level(speed_m_s);
                let from_s = random.uniform();
                let machine = |i: usize| -> f64 {
                    let s = i as f64 / RATE_HZ + from_s;
                    let tones = lines.iter();
                    tones.map(|[hz, high]| high * (TAU * hz * s).sin()).sum()
                };
                (0..length)
                    .map(|i| level * random.normal() + machine(i))
                    .collect()
            };
            let strokes = (6, 1.5);
            let sample = ("A", speed_m_s);
            takes.push(recorded(sample, strokes, noise_m_s2, random, &texture));
        }
    }
    let study = compared(takes, Factor::Speed);
    let trend = study.across(Factor::Speed).first().map(|one| &one.trend);
    let Some(Trend::Speeds(trend)) = trend else {
        panic!("{trend:?}");
    };
    let fit = trend.rms_on_speed.as_ref()?;
    Some((fit.slope, fit.slope_interval?))
}

#[test]
fn the_noise_of_a_sensor_does_not_move_an_exponent_out_of_its_interval() {
    let mut random = Random::new(12);
    let as_the_speed = |speed_m_s: f64| 0.3 * speed_m_s / 0.03;
    let (slope, [low, high]) = exponent(0.3, &mut random, as_the_speed, &[]).unwrap();
    assert!(slope < 0.6, "the noise is in the exponent: {slope}");
    assert!((low..high).contains(&1.0), "{low} to {high}");
    // Of a texture below the noise nothing is known.
    for _study in 0..3 {
        let found = exponent(3.0, &mut random, as_the_speed, &[]);
        assert!(found.is_none(), "{found:?}");
    }
}

/// Two strong lines made the exponent 0.09 (95 %: 0.02 to 0.99) of a texture whose rms follows the speed.
#[test]
fn the_lines_of_a_machine_do_not_move_an_exponent_out_of_its_interval() {
    let mut random = Random::new(15);
    let as_the_speed = |speed_m_s: f64| 0.3 * speed_m_s / 0.03;
    for lines in [[[87.0, 0.4], [174.0, 0.3]], [[71.0, 1.0], [213.0, 0.8]]] {
        let (slope, [low, high]) = exponent(0.01, &mut random, as_the_speed, &lines).unwrap();
        assert!(slope < 0.6, "the lines are in the exponent: {slope}");
        assert!((low..high).contains(&1.0), "{low} to {high}");
    }
}

#[test]
fn a_sensor_that_drifts_by_a_fraction_of_a_db_shows_no_exponent() {
    let mut random = Random::new(13);
    // 0.3 dB from the first to the last of the speeds, which are in order.
    let drifts = |speed_m_s: f64| 0.3 * 10f64.powf(0.3 / 20.0 * (speed_m_s / 0.01).log(6.0));
    for _study in 0..3 {
        let (slope, [low, high]) = exponent(0.001, &mut random, drifts, &[]).unwrap();
        assert!((0.005..0.04).contains(&slope), "{slope}");
        assert!(low < 0.0 && high < 0.06, "{low} to {high}");
    }
    // What is six times as much is said.
    let follows = |speed_m_s: f64| 0.3 * 10f64.powf(1.8 / 20.0 * (speed_m_s / 0.01).log(6.0));
    let (_, [low, _]) = exponent(0.001, &mut random, follows, &[]).unwrap();
    assert!(low > 0.0, "{low}");
}

/// The line of a motor that ran in all recordings of one sample but one is no difference of the textures.
#[test]
fn a_line_that_some_recordings_of_a_sample_lack_tells_nothing_apart() {
    let mut random = Random::new(14);
    for (runs, hz) in [(4, 137.0), (3, 71.0)] {
        let mut takes = Vec::new();
        for sample in ["A", "B"] {
            for recording in 0..5 {
                let level = if sample == "A" && recording < runs {
                    1.0
                } else {
                    0.0
                };
                let texture = |length: usize, random: &mut Random| {
                    let from = random.uniform();
                    let turns = |i: usize| hz * i as f64 / RATE_HZ + from;
                    let motor = (0..length).map(|i| level * (TAU * turns(i)).sin());
                    motor.map(|motor| motor + 0.5 * random.normal()).collect()
                };
                takes.push(recorded(
                    (sample, 0.03),
                    (6, 1.5),
                    0.01,
                    &mut random,
                    &texture,
                ));
            }
        }
        assert_alike(takes);
    }
}
