//! Samples whose strokes have one spectrum and another time course, and such as have both alike.

#![allow(
    clippy::unwrap_used,
    reason = "helpers of tests fail where they cannot go on"
)]

use std::f64::consts::TAU;

use piezotact::compare::{
    AcrossSamples, DiscriminationConfig, Distinguishability, PairCriterion, PerceivedStrokes,
    Texture, add_over_time, discriminate,
};
use piezotact::discrimination::Model;
use piezotact::perception::{Feature, Parameters, PerceivedVibration};
use piezotact::quantity::{Acceleration, Band, Decibels, Hertz, Unit};
use piezotact::series::Series;
use piezotact::spectrum::{WelchConfig, welch};

use crate::vibrations::{RATE_HZ, Random, humps, series, texture};

/// Strokes of 1.5 s, `recordings` times six: noise of one spectrum, modulated at `hz` to `depth`, each 0.3 dB away from its level.
fn sample(
    random: &mut Random,
    seed: u64,
    recordings: usize,
    (hz, depth): (f64, f64),
) -> Vec<Vec<Series<Acceleration>>> {
    let mut stroke = |place: u64| {
        let noise = texture(seed + place, 7500, 3.0, humps);
        let phase = TAU * random.uniform();
        let gain = 10f64.powf(0.3 * random.normal() / 20.0) / (1.0 + 0.5 * depth * depth).sqrt();
        let samples = noise.samples().iter().enumerate();
        let at = |(i, v): (usize, &f64)| {
            let carrier = (TAU * hz * i as f64 / RATE_HZ + phase).sin();
            gain * v * (1.0 + depth * carrier)
        };
        series(samples.map(at).collect())
    };
    let mut recording = |number: u64| (0..6).map(|i| stroke(10 * number + i)).collect();
    (0..recordings as u64).map(&mut recording).collect()
}

type Strokes = Vec<Vec<Series<Acceleration>>>;

fn by_spectra(samples: &[(&str, Strokes)]) -> AcrossSamples {
    let lines = WelchConfig::hann(1024);
    let textures = samples.iter().map(|(name, recordings)| Texture {
        name: (*name).into(),
        recordings: recordings
            .iter()
            .map(|strokes| {
                let psd = |stroke| welch(stroke, &lines).unwrap().values;
                strokes.iter().map(psd).collect()
            })
            .collect(),
        resolution_hz: RATE_HZ / 1024.0,
        unit: Unit::MetrePerSecondSquared,
        highest_hz: RATE_HZ / 2.0,
    });
    let model = Model::over(Band::new(Hertz(20.0), Hertz(1000.0)).unwrap());
    let config = DiscriminationConfig::usual(model);
    discriminate(&[textures.collect()], &config).unwrap()
}

fn perceived(recordings: &Strokes) -> PerceivedStrokes {
    let parameters = Parameters::published();
    let of = |x| PerceivedVibration::of("the stroke", x, &parameters, &|_| Decibels(0.0)).unwrap();
    let recordings = recordings.iter();
    recordings
        .map(|strokes| strokes.iter().map(of).collect())
        .collect()
}

fn compared(samples: &[(&str, Strokes)]) -> AcrossSamples {
    let mut found = by_spectra(samples);
    let strokes = samples.iter().map(|(_, all)| Some(perceived(all)));
    add_over_time(&mut found, &[strokes.collect()]);
    found
}

#[test]
fn one_spectrum_and_another_modulation_is_not_below_the_jnd() {
    let mut random = Random::new(1);
    for (hz, depth) in [(6.0, 1.0), (12.0, 0.9), (3.0, 0.8)] {
        let flat = sample(&mut random, 100, 2, (0.0, 0.0));
        let modulated = sample(&mut random, 200, 2, (hz, depth));
        let samples = [("flat", flat), ("modulated", modulated)];
        let spectra = by_spectra(&samples);
        assert_eq!(
            spectra.settings[0].pairs[0].outcome,
            Distinguishability::BelowJnd,
            "{:?}",
            spectra.settings[0].sentences()
        );
        let found = compared(&samples);
        let pair = &found.settings[0].pairs[0];
        let said = found.settings[0].sentences();
        assert_eq!(pair.outcome, Distinguishability::ToldApart, "{said:?}");
        assert_eq!(pair.felt_in[0].feature, Feature::Modulation, "{said:?}");
        assert!(found.settings[0].below_jnd.is_empty());
    }
}

/// A course within each stroke and its reverse: a swell of 12 dB, a loud second half.
#[test]
fn a_course_and_its_reverse_are_not_below_the_jnd() {
    let mut random = Random::new(6);
    let courses: [fn(f64) -> f64; 3] = [
        |share| 24.0 * (share - 0.5),
        |share| 12.0 * (share - 0.5),
        |share| if share < 0.5 { -6.0 } else { 6.0 },
    ];
    for (i, course) in courses.into_iter().enumerate() {
        let shaped = |seed: u64, reversed: bool, random: &mut Random| -> Strokes {
            let flat = sample(random, seed, 2, (0.0, 0.0));
            let shape = |stroke: &Series<Acceleration>| {
                let n = stroke.samples().len() as f64;
                let samples = stroke.samples().iter().enumerate().map(|(i, v)| {
                    let share = i as f64 / n;
                    let db = course(if reversed { 1.0 - share } else { share });
                    v * 10f64.powf(db / 20.0)
                });
                series(samples.collect())
            };
            flat.iter()
                .map(|all| all.iter().map(shape).collect())
                .collect()
        };
        let samples = [
            ("rising", shaped(7000 + i as u64, false, &mut random)),
            ("falling", shaped(8000 + i as u64, true, &mut random)),
        ];
        let found = compared(&samples);
        let said = found.settings[0].sentences();
        let outcome = found.settings[0].pairs[0].outcome;
        assert_ne!(outcome, Distinguishability::BelowJnd, "{said:?}");
        assert!(said[0].contains("course of level"), "{said:?}");
    }
}

/// Alike in spectrum and time course, modulated or not: nothing is said to differ, and what is below stays below.
#[test]
fn equal_time_courses_are_never_told_apart() {
    let mut random = Random::new(2);
    let (mut below, mut still_below, mut pairs) = (0, 0, 0);
    for study in 0..8u64 {
        let course = [(0.0, 0.0), (4.0, 0.6), (11.0, 1.0), (30.0, 0.5)][study as usize % 4];
        let of = |name, place: u64, random: &mut Random| {
            let seed = 10_000 * (study + 1) + 1000 * place;
            (name, sample(random, seed, 1 + study as usize % 2, course))
        };
        let samples = [
            of("A", 1, &mut random),
            of("B", 2, &mut random),
            of("C", 3, &mut random),
        ];
        let spectra = by_spectra(&samples);
        let found = compared(&samples);
        let said = found.settings[0].sentences();
        for (before, after) in spectra.settings[0]
            .pairs
            .iter()
            .zip(&found.settings[0].pairs)
        {
            assert_ne!(after.outcome, Distinguishability::ToldApart, "{said:?}");
            let is_below = |one| usize::from(one == Distinguishability::BelowJnd);
            below += is_below(before.outcome);
            still_below += is_below(after.outcome);
            pairs += 1;
        }
    }
    assert!(
        below > pairs / 2 && still_below + 1 >= below,
        "{still_below} of {below} of {pairs}"
    );
}

/// Without the time course, as of recordings below 1 kHz, nobody knows whether people feel a difference.
#[test]
fn without_a_time_course_nothing_is_below_the_jnd() {
    let mut random = Random::new(3);
    let [a, b] = [300, 400].map(|seed| sample(&mut random, seed, 2, (0.0, 0.0)));
    let samples = [("A", a), ("B", b)];
    let mut found = by_spectra(&samples);
    assert_eq!(
        found.settings[0].pairs[0].outcome,
        Distinguishability::BelowJnd
    );
    add_over_time(&mut found, &[vec![None, None]]);
    let pair = &found.settings[0].pairs[0];
    assert_eq!(pair.outcome, Distinguishability::NotDecided);
    let time = pair
        .criteria
        .iter()
        .find(|c| c.what == PairCriterion::OverTime);
    assert!(time.unwrap().found.is_none());
    let said = found.settings[0].sentences();
    assert!(said[0].contains("the time course is not known"), "{said:?}");
}

/// A comb whose phases are others in every recording, as of other traces over one surface: its modulation is another one from recording to
/// recording, in all strokes of one alike.
#[test]
fn other_phases_of_one_comb_are_not_told_apart() {
    let mut random = Random::new(5);
    for recordings in [1, 3] {
        let of = |name, seed: u64, random: &mut Random| {
            let recording = |number: u64, random: &mut Random| {
                let turns: Vec<f64> = (0..6).map(|_| TAU * random.uniform()).collect();
                let stroke = |place: u64| {
                    let noise = texture(seed + 10 * number + place, 7500, 1.5, humps);
                    let samples = noise.samples().iter().enumerate();
                    let comb = |i: usize| -> f64 {
                        let each = turns.iter().enumerate().map(|(n, turn)| {
                            (TAU * 14.0 * (n + 2) as f64 * i as f64 / RATE_HZ + turn).sin()
                        });
                        each.sum()
                    };
                    series(samples.map(|(i, v)| v + 1.5 * comb(i)).collect())
                };
                (0..6).map(stroke).collect()
            };
            let all: Strokes = (0..recordings).map(|i| recording(i, random)).collect();
            (name, all)
        };
        for study in 1..5 {
            let samples = [
                of("A", 10_000 * study, &mut random),
                of("B", 10_000 * study + 5000, &mut random),
            ];
            let found = compared(&samples);
            let said = found.settings[0].sentences();
            let outcome = found.settings[0].pairs[0].outcome;
            assert_ne!(outcome, Distinguishability::ToldApart, "{said:?}");
        }
    }
}

/// One stroke does not say by how much strokes of its sample differ.
#[test]
fn one_stroke_of_a_sample_tells_nothing_apart() {
    let mut random = Random::new(4);
    let single = |seed: u64, course, random: &mut Random| {
        let mut all = sample(random, seed, 1, course);
        all[0].truncate(1);
        all
    };
    let samples = [
        ("flat", single(500, (0.0, 0.0), &mut random)),
        ("modulated", single(600, (12.0, 1.0), &mut random)),
    ];
    let found = compared(&samples);
    let outcome = found.settings[0].pairs[0].outcome;
    assert_eq!(outcome, Distinguishability::NotDecided);
}
