//! The score of recordings of touch, with landings and lifts between the strokes.
#![allow(
    clippy::print_stderr,
    clippy::unwrap_used,
    reason = "a test prints what it measured, and fails where it cannot go on"
)]

use crate::known_cuts::{self, Kind, recorded};
use crate::vibrations::{RATE_HZ, Random, scored};
use piezotact::quantity::{Acceleration, SampleRate, Unit};
use piezotact::recording::{Channel, Condition, Provenance, Recording};
use piezotact::score::{ScoreWarning, sliding_part};

/// Landings and lifts that are ten times as hard gave 2.60 JND where the strokes are equal.
#[test]
fn landing_and_lift_are_no_part_of_a_texture() {
    for seed in 1..=3 {
        let made = recorded(&mut known_cuts::Random::new(seed), &[Kind::Plain; 6]);
        let mut random = Random::new(seed + 50);
        let beside = |t_s: f64, [from, to]: [f64; 2]| from <= t_s && t_s < to;
        let hard = made.acceleration.iter().enumerate().map(|(i, value)| {
            let t_s = i as f64 / RATE_HZ;
            let lands = made.truths.iter().any(|truth| {
                let (begins_s, ends_s) = truth.contact_s;
                beside(t_s, [begins_s, begins_s + 0.06]) || beside(t_s, [ends_s - 0.03, ends_s])
            });
            value * if lands { 10.0 } else { 1.0 } + 0.01 * random.normal()
        });
        let hard: Vec<f64> = hard.collect();
        let of = |acceleration: &[f64]| {
            let channel = |name: &str, unit: Unit, samples: &[f64]| Channel {
                name: name.into(),
                unit,
                samples: samples.to_vec(),
            };
            let channels = vec![
                channel("nail", Unit::MetrePerSecondSquared, acceleration),
                channel("fx", Unit::Newton, &made.fx_n),
                channel("fy", Unit::Newton, &made.fy_n),
                channel("fz", Unit::Newton, &made.fz_n),
            ];
            let rate = SampleRate::new(RATE_HZ).unwrap();
            let (condition, provenance) = (Condition::default(), Provenance::default());
            Recording::new(channels, rate, condition, provenance).unwrap()
        };
        let [soft, hard] = [of(&made.acceleration), of(&hard)];
        let whole = |of: &Recording| of.series::<Acceleration>(None).unwrap();
        let before = scored(&whole(&soft), &whole(&hard));
        let part = |of: &Recording| sliding_part("the reference", of, None).unwrap();
        let (a, warning) = part(&soft);
        let (b, _) = part(&hard);
        let found = scored(&a, &b);
        eprintln!(
            "lifts, seed {seed}: {:.2} JND with them, {:.3} JND of the strokes",
            before.spectral.jnd, found.spectral.jnd
        );
        assert!(
            before.spectral.jnd > 1.0,
            "seed {seed}: {}",
            before.sentence
        );
        assert!(found.spectral.jnd < 0.1, "seed {seed}: {}", found.sentence);
        // 0.18 s of each of six strokes of 0.8 to 1.5 s are landing and lift.
        let warning = warning.unwrap();
        let Some(ScoreWarning::StrokesAlone {
            strokes, sliding_s, ..
        }) = warning.kind()
        else {
            panic!("{warning}");
        };
        assert!(strokes >= 5 && (sliding_s - a.duration().0).abs() < 1e-9);
    }
}
