//! Contact by force and vibration together, and limits of sensors, on recordings that look like others.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use crate::known_cuts::{Kind, RATE_HZ, Random, Recorded, recorded};
use piezotact::quantity::{Newtons, SampleRate};
use piezotact::stroke::{
    Expected, ForceFault, ForceRule, ForceWarning, Judging, MotionKind, Reason, Segmentation,
    Signals, SpeedRule, segment_by_force, segment_by_speed,
};

/// A tribometer that goes and comes back: in contact one way and lifted on the way back, pressed while it stands still before it goes.
struct Tribometer {
    speed_m_s: Vec<f64>,
    force_n: Vec<f64>,
    vibration: Vec<f64>,
    /// Where it goes in contact, and where it comes back without, s.
    there_s: Vec<(f64, f64)>,
    back_s: Vec<(f64, f64)>,
}

/// What the force cell shows.
#[derive(Clone, Copy, Debug)]
struct Cell {
    sign: f64,
    offset_n: f64,
    /// On the way back, by cross-talk.
    back_n: f64,
}

/// Passes at 20 mm/s that vibrate by `levels` m/s² there and back.
fn tribometer(seed: u64, cell: Cell, levels: [f64; 2]) -> Tribometer {
    let mut random = Random::new(seed);
    let mut made = Tribometer {
        speed_m_s: Vec::new(),
        force_n: Vec::new(),
        vibration: Vec::new(),
        there_s: Vec::new(),
        back_s: Vec::new(),
    };
    let mut time_s = 0.0;
    for _ in 0..6 {
        let press_n = random.uniform(1.1, 1.4);
        // Length, speed, force and vibration of a part; pressed at rest it pushes more than while it slides.
        let parts = [
            (0.4, 0.0, 0.0, 0.0),
            (1.2, 0.0, press_n + 0.3, 0.0),
            (1.3, 0.02, press_n, levels[0]),
            (0.4, 0.0, press_n + 0.3, 0.0),
            (0.4, 0.0, 0.0, 0.0),
            (1.3, -0.02, cell.back_n, levels[1]),
        ];
        for (part, (length_s, speed, press_n, level)) in parts.into_iter().enumerate() {
            let span = (time_s, time_s + length_s);
            match part {
                2 => made.there_s.push(span),
                5 => made.back_s.push(span),
                _ => {}
            }
            for _ in 0..(length_s * RATE_HZ) as usize {
                made.speed_m_s.push(speed + 2e-5 * random.normal());
                let noise_n = 0.01 * random.normal();
                made.force_n
                    .push(cell.sign * (press_n + noise_n) + cell.offset_n);
                made.vibration.push((level + 0.02) * random.normal());
                time_s += 1.0 / RATE_HZ;
            }
        }
    }
    made
}

fn cut(made: &Tribometer) -> Segmentation {
    let signals = Signals {
        rate: SampleRate::new(RATE_HZ).unwrap(),
        vibration: Some(&made.vibration),
        normal_force_n: Some(&made.force_n),
        tangential_force_n: Vec::new(),
        motion: Some((&made.speed_m_s, MotionKind::Speed)),
        contact_sign: None,
    };
    let expected = Expected {
        load_n: None,
        speed_m_s: None,
        judging: Judging::Sliding,
    };
    segment_by_speed(&signals, &SpeedRule::trapezoid(expected)).unwrap()
}

fn contradicts(found: &Segmentation) -> bool {
    found.warnings.iter().any(|warning| {
        matches!(
            warning.kind(),
            Some(ForceWarning::Doubtful {
                fault: ForceFault::VibrationContradicts { .. }
            })
        )
    })
}

/// The pass in contact vibrates almost three times as much as the motor alone, and that decides: with either sign of the cell, an offset, and
/// cross-talk that shows 0.58 N on the way back.
#[test]
fn the_pass_in_contact_is_analysed_whatever_the_sign_and_the_zero_of_the_cell() {
    for (seed, (sign, offset_n, back_n)) in [
        (1.0, 0.0, 0.0),
        (-1.0, 0.0, 0.0),
        (-1.0, 2.0, 0.0),
        (1.0, -3.0, 0.0),
        (1.0, 0.0, 0.58),
        (-1.0, 1.0, 0.58),
    ]
    .into_iter()
    .enumerate()
    {
        let cell = Cell {
            sign,
            offset_n,
            back_n,
        };
        let made = tribometer(seed as u64, cell, [1.25, 0.44]);
        let found = cut(&made);
        assert_eq!(found.strokes.len(), 6, "{cell:?}: {:?}", found.rejected);
        for (stroke, (from_s, to_s)) in found.strokes.iter().zip(&made.there_s) {
            let middle_s = 0.5 * (stroke.steady.start + stroke.steady.end) as f64 / RATE_HZ;
            assert!(
                middle_s > *from_s && middle_s < *to_s,
                "{cell:?}: {middle_s}"
            );
        }
        let none = |r: &&piezotact::stroke::Rejected| r.reason == Reason::NoContact;
        assert_eq!(found.rejected.iter().filter(none).count(), 6, "{cell:?}");
        assert_eq!(found.force_zeros.as_ref().unwrap().sign, sign, "{cell:?}");
        assert!(!contradicts(&found), "{cell:?}: {:?}", found.warnings);
    }
}

/// Both ways in contact are both analysed, however much they differ in level or in force alone.
#[test]
fn both_ways_in_contact_are_kept() {
    for (back_n, level) in [(1.2, 1.2), (1.2, 0.4), (0.4, 1.2)] {
        let cell = Cell {
            sign: 1.0,
            offset_n: 0.0,
            back_n,
        };
        let made = tribometer(7, cell, [1.25, level]);
        let found = cut(&made);
        assert_eq!(
            found.strokes.len(),
            12,
            "{back_n}, {level}: {:?}",
            found.rejected
        );
        assert!(!contradicts(&found), "{:?}", found.warnings);
    }
}

/// A finger that is never lifted, and presses a little more in the direction in which it vibrates less, is not turned.
#[test]
fn a_held_finger_that_vibrates_more_one_way_keeps_its_sign() {
    for sign in [1.0, -1.0] {
        let mut made = tribometer(
            8,
            Cell {
                sign: 1.0,
                offset_n: 0.0,
                back_n: 1.5,
            },
            [1.25, 0.5],
        );
        for force in &mut made.force_n {
            // At rest between the passes it presses less.
            *force = sign * if *force < 0.5 { *force + 1.0 } else { *force };
        }
        let found = cut(&made);
        assert_eq!(found.strokes.len(), 12, "{sign}: {:?}", found.rejected);
        assert_eq!(found.force_zeros.unwrap().sign, sign);
    }
}

/// A force that is zero in the passes that vibrate more, and the vibration not clear enough to turn it: said.
#[test]
fn more_vibration_where_the_force_shows_no_contact_is_a_warning() {
    let mut made = tribometer(
        9,
        Cell {
            sign: 1.0,
            offset_n: 0.0,
            back_n: 0.0,
        },
        [0.9, 1.25],
    );
    let found = cut(&made);
    assert_eq!(found.strokes.len(), 6, "{:?}", found.rejected);
    assert!(contradicts(&found), "{:?}", found.warnings);
    // A way back twice as fast makes a motor vibrate more.
    for (i, speed) in made.speed_m_s.iter_mut().enumerate() {
        let t_s = i as f64 / RATE_HZ;
        let back = made
            .back_s
            .iter()
            .any(|(from, to)| t_s > *from && t_s < *to);
        *speed *= if back { 2.0 } else { 1.0 };
    }
    assert!(!contradicts(&cut(&made)));
}

fn plain(seed: u64, strokes: usize) -> Recorded {
    recorded(&mut Random::new(seed), &vec![Kind::Plain; strokes])
}

fn by_force(made: &Recorded, load: Option<Newtons>) -> Segmentation {
    let signals = Signals {
        rate: SampleRate::new(RATE_HZ).unwrap(),
        vibration: Some(&made.acceleration),
        normal_force_n: Some(&made.fz_n),
        tangential_force_n: vec![&made.fx_n, &made.fy_n],
        motion: None,
        contact_sign: None,
    };
    segment_by_force(&signals, &ForceRule::active(load)).unwrap()
}

/// Whether the moment lies in one of the contacts of `made` whose number `counts`.
fn in_contact(made: &Recorded, t_s: f64, counts: impl Fn(usize) -> bool) -> bool {
    let mut all = made.truths.iter().enumerate();
    all.any(|(i, truth)| counts(i) && t_s > truth.contact_s.0 && t_s < truth.contact_s.1)
}

/// Without a motion, of contacts that differ threefold in force and in vibration the loud ones are the strokes, though they are fewer.
#[test]
fn the_usual_force_is_that_of_the_contacts_that_vibrate() {
    let mut made = plain(21, 10);
    let faint = |i: usize| i % 5 < 3;
    let (mut nail, mut force_n) = (made.acceleration.clone(), made.fz_n.clone());
    for i in 0..nail.len() {
        let t_s = i as f64 / RATE_HZ;
        let loud = in_contact(&made, t_s, |number| !faint(number));
        nail[i] *= if loud { 3.0 } else { 1.0 };
        force_n[i] *= if loud { 3.5 } else { 1.0 };
    }
    (made.acceleration, made.fz_n) = (nail, force_n);
    let found = by_force(&made, None);
    assert_eq!(found.strokes.len(), 4, "{:?}", found.rejected);
    for stroke in &found.strokes {
        let t_s = 0.5 * (stroke.steady.start + stroke.steady.end) as f64 / RATE_HZ;
        assert!(in_contact(&made, t_s, |number| !faint(number)));
    }
}

/// Contacts that are too light for the load and vibrate more than those that are kept.
#[test]
fn light_touches_that_vibrate_more_than_strokes_are_a_warning() {
    let mut made = plain(22, 8);
    assert!(!contradicts(&by_force(&made, Some(Newtons(0.2)))));
    let (mut nail, mut force_n) = (made.acceleration.clone(), made.fz_n.clone());
    for i in 0..nail.len() {
        if in_contact(&made, i as f64 / RATE_HZ, |number| number % 2 == 0) {
            nail[i] *= 2.0;
            force_n[i] *= 0.35;
        }
    }
    (made.acceleration, made.fz_n) = (nail, force_n);
    let found = by_force(&made, Some(Newtons(0.2)));
    assert_eq!(found.strokes.len(), 4, "{:?}", found.rejected);
    assert!(contradicts(&found), "{:?}", found.warnings);
}

/// A cell at its upper limit for most of a stroke does not show the force: friction would come out too high.
#[test]
fn a_force_cell_at_its_upper_limit_gives_no_stroke() {
    for (seed, rail_n) in [(31, 0.55), (32, 0.6), (33, 0.65)] {
        let mut made = plain(seed, 8);
        let mut force_n = made.fz_n.clone();
        for (i, force) in force_n.iter_mut().enumerate() {
            let heavy = in_contact(&made, i as f64 / RATE_HZ, |number| number > 2);
            *force = (*force + if heavy { 0.8 } else { 0.0 }).min(rail_n);
        }
        made.fz_n = force_n;
        let found = by_force(&made, None);
        assert_eq!(found.strokes.len(), 3, "{rail_n} N: {:?}", found.strokes);
        for stroke in &found.strokes {
            let force_n = stroke.steady.of(&made.fz_n);
            assert!(force_n.iter().all(|force| *force < rail_n), "{rail_n} N");
        }
        let clipped = |r: &&piezotact::stroke::Rejected| matches!(r.reason, Reason::Clipped { fraction } if fraction > 0.5);
        let clipped = found.rejected.iter().filter(clipped).count();
        assert_eq!(clipped, 5, "{rail_n} N: {:?}", found.rejected);
    }
}

/// Of strokes that are clipped more and less, the most clipped ones look like a square wave by themselves.
#[test]
fn no_stroke_at_the_limits_of_the_accelerometer_is_kept() {
    let mut made = plain(41, 12);
    let mut nail = made.acceleration.clone();
    let limit = 0.5 * piezotact::statistics::rms(&nail);
    for (i, sample) in nail.iter_mut().enumerate() {
        let hard = in_contact(&made, i as f64 / RATE_HZ, |number| number % 4 == 0);
        *sample = (*sample * if hard { 8.0 } else { 1.0 }).clamp(-limit, limit);
    }
    made.acceleration = nail;
    let found = by_force(&made, None);
    assert_eq!(found.strokes.len(), 0, "{:?}", found.strokes);
    let clipped = |r: &&piezotact::stroke::Rejected| matches!(r.reason, Reason::Clipped { .. });
    assert_eq!(
        found.rejected.iter().filter(clipped).count(),
        12,
        "{:?}",
        found.rejected
    );
}
