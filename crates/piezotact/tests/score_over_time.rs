//! What the score hears over time, at equal spectra, and in a short time.
#![allow(clippy::print_stderr, reason = "a test prints what it measured")]

use std::f64::consts::TAU;

use piezotact::Warning;
use piezotact::quantity::Decibels;
use piezotact::score::{Score, Verdict};
use piezotact::warning::{Few, FewWarning};

use crate::vibrations::{THIRTY_S, humps, scored, scored_by_spectra, series, texture};

/// The same energy, flat or modulated at 30 Hz: people tell them apart in more than 90 % (Cao and Konyo 2018), and spectra do not. What is
/// modulated alike, or not at all, is not told apart.
#[test]
fn amplitude_modulation_of_equal_energy_is_distinguishable() {
    let tone = |depth: f64, phase: f64| {
        let samples = (0..10_000).map(|i| {
            let t_s = i as f64 / 5000.0;
            let envelope = 1.0 + depth * (TAU * 30.0 * t_s + phase).sin();
            4.0 * envelope / (1.0 + depth * depth / 2.0).sqrt() * (TAU * 300.0 * t_s + phase).sin()
        });
        series(samples.collect())
    };
    let noise = |seed: u64, depth: f64| {
        let flat = texture(seed, 25_000, 3.0, humps);
        let samples = flat.samples().iter().enumerate().map(|(i, v)| {
            let envelope = 1.0 + depth * (TAU * 10.0 * i as f64 / 5000.0).sin();
            v * envelope / (1.0 + depth * depth / 2.0).sqrt()
        });
        series(samples.collect())
    };
    let modulated = |s: &Score| match &s.verdict {
        Verdict::Distinguishable { how } => {
            how.iter().any(|one| one.to_string().contains("modulation"))
        }
        _ => false,
    };
    for (a, b) in [
        (tone(0.0, 0.0), tone(1.0, 0.0)),
        (noise(1, 0.0), noise(2, 1.0)),
    ] {
        let s = scored(&a, &b);
        assert!(s.spectral.jnd < 1.0 && modulated(&s), "{}", s.sentence);
        // The spectra know nothing of it, and say whose verdict it is.
        let spectral = scored_by_spectra(&a, &b);
        assert!(spectral.sentence.starts_with("by the spectra alone"));
        assert!(spectral.perceived.is_none() && !modulated(&spectral));
    }
    for (a, b) in [
        (tone(0.0, 0.0), tone(0.0, 1.0)),
        (tone(1.0, 0.0), tone(1.0, 2.0)),
        (tone(0.0, 0.0), tone(0.03, 0.0)),
    ] {
        let s = scored(&a, &b);
        assert_eq!(s.verdict, Verdict::BelowJnd, "{}", s.sentence);
    }
    for depth in [0.0, 1.0] {
        let s = scored(&noise(3, depth), &noise(4, depth));
        assert!(
            !matches!(s.verdict, Verdict::Distinguishable { .. }),
            "{}",
            s.sentence
        );
    }
}

#[test]
fn realisations_of_one_texture_are_not_distinguishable_in_30_s_and_the_limits_hold_the_truth() {
    realisations_are_not_distinguishable_in(4);
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_realisations_of_one_texture_are_not_distinguishable_in_30_s() {
    realisations_are_not_distinguishable_in(12);
}

fn realisations_are_not_distinguishable_in(pairs: u64) {
    let (mut below, mut wrong) = (0, 0);
    for seed in 0..pairs {
        let s = scored(
            &texture(seed, THIRTY_S, 2.0, humps),
            &texture(seed + 70, THIRTY_S, 2.0, humps),
        );
        eprintln!("two realisations: {}", s.sentence);
        below += u64::from(s.verdict == Verdict::BelowJnd);
        wrong += u64::from(s.spectral.low_jnd > 0.0);
    }
    assert_eq!(below, pairs);
    assert!(
        wrong <= pairs.div_ceil(6),
        "{wrong} of {pairs} intervals exclude 0"
    );
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_the_limits_hold_the_truth_nineteen_times_of_twenty() {
    for (samples, pairs) in [(10_000, 150), (30_000, 60)] {
        let held = (0..pairs)
            .filter(|seed| {
                let a = texture(1000 + 2 * seed, samples, 2.0, humps);
                let b = texture(1001 + 2 * seed, samples, 2.0, humps);
                let s = scored(&a, &b.amplified(Decibels(1.58)));
                s.level.low_jnd <= 1.0 && 1.0 <= s.level.high_jnd
            })
            .count();
        eprintln!(
            "{} s: the limits of the level hold the truth in {held} of {pairs}",
            samples / 5000
        );
        // 95 %, less three standard deviations of a count and what few segments cost.
        assert!(held as f64 >= 0.87 * pairs as f64, "{held} of {pairs}");
    }
}

/// Realisations of one texture are never told apart, and such as are 4.5 dB apart, two JND, are never below it, however short.
#[test]
fn a_short_recording_says_nothing_false() {
    a_short_recording_says_nothing_false_of(5);
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_a_short_recording_says_nothing_false() {
    a_short_recording_says_nothing_false_of(12);
}

fn a_short_recording_says_nothing_false_of(pairs: u64) {
    for samples in [1_500, 2_500, 5_000, 10_000, 20_000] {
        let (mut below, mut told) = ([0; 2], [0; 2]);
        for seed in 0..pairs {
            for (i, louder_db) in [0.0, 4.5].into_iter().enumerate() {
                let test = texture(seed + 40, samples, 2.0, humps).amplified(Decibels(louder_db));
                let s = scored(&texture(seed, samples, 2.0, humps), &test);
                below[i] += usize::from(s.verdict == Verdict::BelowJnd);
                told[i] += usize::from(matches!(s.verdict, Verdict::Distinguishable { .. }));
                let few = |d: &Warning| {
                    let what = Few::Segments;
                    matches!(d.kind(), Some(FewWarning::Few { what: few, .. }) if few == what)
                };
                assert!(samples > 5_000 || s.warnings.iter().any(few));
            }
        }
        eprintln!("{samples} samples: below {below:?}, told apart {told:?} of {pairs}");
        assert!(
            told[0] == 0 && below[1] == 0,
            "{samples}: {told:?} {below:?}"
        );
    }
}

/// The halves of a sweep and of a sequence differ by nature: that does not hide that people tell them from their reverse.
#[test]
fn stimuli_without_chance_are_judged_by_the_difference_alone() {
    let tone = |hz: f64| {
        move |i: usize| {
            let inside = (i.min(4999 - i) as f64 / 250.0).min(1.0);
            3.0 * inside * (TAU * hz * i as f64 / 5000.0).sin()
        }
    };
    let one = |hz: f64| (0..5000).map(tone(hz)).collect::<Vec<f64>>();
    let joined = |first: f64, second: f64| series([one(first), one(second)].concat());
    for (a, b) in [
        (series(one(200.0)), series(one(300.0))),
        (joined(100.0, 200.0), joined(200.0, 100.0)),
    ] {
        let found = scored(&a, &b);
        assert!(
            matches!(found.verdict, Verdict::Distinguishable { .. }),
            "{}",
            found.sentence
        );
    }
    let again = scored(&joined(100.0, 200.0), &joined(100.0, 204.0));
    assert_eq!(again.verdict, Verdict::BelowJnd, "{}", again.sentence);
}
