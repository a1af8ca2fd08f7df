//! Ticks, clicks and short noises that begin at full level in their first sample.

use std::f64::consts::TAU;

use super::verdict_tests::{RATE_HZ, band, noise, recorded, series, usual};
use super::*;
use crate::criterion::Outcome;
use crate::render::fade_ends;

const DURATIONS_S: [f64; 6] = [0.005, 0.012, 0.03, 0.08, 0.17, 0.3];

/// Short effects of `seconds`, 5 m/s² at their beginning.
fn effects(seconds: f64) -> [(&'static str, Vec<f64>); 3] {
    let count = (seconds * RATE_HZ) as usize;
    let decay = |i: usize| (-(i as f64) / (0.3 * count as f64)).exp();
    let tone = |hz: f64| move |i: usize| (TAU * hz * i as f64 / RATE_HZ).cos();
    let tick = (0..count).map(|i| 5.0 * decay(i) * tone(220.0)(i));
    let burst = (0..count).map(|i| 3.0 * tone(150.0)(i));
    let rough = noise(count, 7).into_iter().map(|v| 3.0 * v);
    [
        ("tick", tick.collect()),
        ("burst", burst.collect()),
        ("noise", rough.collect()),
    ]
}

/// Silence before and after what is delivered, samples.
const SILENCE: usize = 1250;

fn judged(target: &[f64], delivered: &[f64], seed: u64) -> Verification {
    judged_as(Mode::Replicate, target, delivered, seed)
}

/// `delivered` within the band, as a rendering delivers it, judged against `target`.
fn judged_as(mode: Mode, target: &[f64], delivered: &[f64], seed: u64) -> Verification {
    let mut played = vec![0.0; delivered.len() + 2 * SILENCE];
    played[SILENCE..SILENCE + delivered.len()].copy_from_slice(delivered);
    let played = in_band(&played, series(played.clone()).rate(), band());
    let config = VerifyConfig {
        rendered: Some(RenderedBand {
            band: band(),
            edge_ratio: 0.1,
        }),
        mode,
        ..usual()
    };
    let measured = recorded(&played, seed);
    verify(
        &series(target.to_vec()),
        Measured::alone(&measured),
        &config,
    )
    .unwrap()
}

/// 0.2 s used to be the least that could be compared.
#[test]
fn effects_of_5_to_300_ms_are_verified() {
    for seconds in DURATIONS_S {
        for (name, target) in effects(seconds) {
            for seed in 1..4 {
                let v = judged(&target, &target, seed);
                assert_eq!(
                    v.verdict,
                    Verdict::Passed,
                    "{name}, {seconds} s: {}",
                    v.sentence()
                );
                assert!(
                    (v.delay_s - 0.55).abs() < 2e-4,
                    "{name}, {seconds} s: {}",
                    v.delay_s
                );
            }
        }
    }
}

/// Of short effects too, what came back otherwise does not pass.
#[test]
fn wrong_short_effects_do_not_pass() {
    for seconds in DURATIONS_S {
        for (name, target) in effects(seconds) {
            let scaled = |gain: f64| target.iter().map(|v| gain * v).collect::<Vec<f64>>();
            let mut faded = target.clone();
            fade_ends(&mut faded, (0.02 * RATE_HZ) as usize);
            let mut cut = target.clone();
            let half = cut.len() / 2;
            if name == "tick" {
                cut[..half].fill(0.0);
            } else {
                cut[half..].fill(0.0);
            }
            let mut twice = target.clone();
            twice.resize(2 * target.len() + 200, 0.0);
            let again: Vec<f64> = target.clone();
            let later = twice.len() - again.len();
            twice[later..].copy_from_slice(&again);
            let mut wrong = vec![
                ("6 dB lower", scaled(0.5)),
                ("3 dB higher", scaled(1.41)),
                ("half of it", cut),
                (
                    "another noise",
                    noise(target.len(), 99)
                        .into_iter()
                        .map(|v| 2.0 * v)
                        .collect(),
                ),
            ];
            if seconds < 0.1 {
                wrong.push(("faded", faded));
                wrong.push(("twice", twice));
            }
            for (what, delivered) in wrong {
                let v = judged(&target, &delivered, 1);
                assert!(
                    !matches!(v.verdict, Verdict::Passed | Verdict::PassedInPart { .. }),
                    "{name}, {seconds} s, {what}: {}",
                    v.sentence()
                );
            }
        }
    }
}

/// Half a period late, the end of a tone was an event that the target does not have.
#[test]
fn the_spectrum_alone_of_a_short_effect_may_have_another_phase() {
    for seconds in [0.03, 0.08] {
        let [_, (_, burst), _] = effects(seconds);
        let inverted: Vec<f64> = burst.iter().map(|v| -v).collect();
        let reversed: Vec<f64> = burst.iter().rev().copied().collect();
        for (what, delivered) in [("inverted", inverted), ("reversed", reversed)] {
            let v = judged_as(Mode::Texture, &burst, &delivered, 1);
            let mut criteria = v.criteria.iter();
            let added = criteria.find(|c| c.what == VerifyCriterion::AddedEvent);
            assert_eq!(
                added.unwrap().outcome,
                Outcome::Met,
                "{what}, {seconds} s: {}",
                v.sentence()
            );
            assert_ne!(v.verdict, Verdict::NotPassed, "{what}, {seconds} s");
        }
        let mut louder = burst.clone();
        louder.extend([0.0; 60]);
        louder.extend(burst.iter().map(|v| 2.5 * v));
        let v = judged_as(Mode::Texture, &burst, &louder, 1);
        assert_eq!(v.verdict, Verdict::NotPassed, "twice, {seconds} s");
    }
}

/// An event counts by the level of the effect, not by that of the silence around it.
#[test]
fn what_is_20_db_below_a_short_effect_is_no_event() {
    let (_, burst) = effects(0.08)[1].clone();
    let with_echo = |gain: f64| {
        let mut delivered = burst.clone();
        delivered.extend([0.0; 60]);
        delivered.extend(burst[..75].iter().map(|v| gain * v));
        let v = judged_as(Mode::Replicate, &burst, &delivered, 1);
        let mut criteria = v.criteria.iter();
        criteria
            .find(|c| c.what == VerifyCriterion::AddedEvent)
            .unwrap()
            .outcome
    };
    assert_eq!(with_echo(0.1), Outcome::Met);
    assert_eq!(with_echo(0.5), Outcome::NotMet);
}
