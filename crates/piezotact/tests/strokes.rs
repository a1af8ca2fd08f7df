//! Segmentation on recordings whose cuts are known.
#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test fails where it cannot go on, and reports what it measured"
)]

use piezotact::recording::{MissingChannel, Reached, RecordingWarning, ReversedSign};
use std::collections::BTreeMap;

use crate::known_cuts::{Kind, RATE_HZ, Random, Recorded, active_touch, recorded};
use piezotact::Warning;
use piezotact::criterion::Outcome;
use piezotact::quantity::{Newtons, SampleRate, Unit};
use piezotact::recording::{Channel, Condition, Provenance, Recording};
use piezotact::roles::Roles;
use piezotact::stroke::{
    Expected, ForceFault, ForceRule, ForceWarning, Judging, MotionKind, Reason, Rule, SegmentError,
    Segmentation, Signals, SpeedRule, StrokeCriterion, StrokeWarning, segment, segment_by_force,
    segment_by_speed, whole,
};

fn signals(made: &Recorded) -> Signals<'_> {
    Signals {
        rate: SampleRate::new(RATE_HZ).unwrap(),
        vibration: Some(&made.acceleration),
        normal_force_n: Some(&made.fz_n),
        tangential_force_n: vec![&made.fx_n, &made.fy_n],
        motion: None,
        contact_sign: None,
    }
}

/// The last criterion of every reject is the one that is not met, at the limit and with what the reason says.
fn decided_by(found: &Segmentation, what: StrokeCriterion) {
    assert!(!found.rejected.is_empty());
    for rejected in &found.rejected {
        let (last, before) = rejected.criteria.split_last().unwrap();
        assert!(
            before.iter().all(|c| c.outcome == Outcome::Met),
            "{before:?}"
        );
        assert_eq!((last.what, last.outcome), (what, Outcome::NotMet));
        let (value, limit) = (last.found.unwrap(), last.limit.value());
        match &rejected.reason {
            Reason::Clipped { fraction } => assert_eq!((value, limit), (*fraction, 0.0)),
            Reason::TooLight { peak_n, needed_n } => {
                assert_eq!((value, limit), (*peak_n, *needed_n));
            }
            Reason::ForceOutsideTolerance {
                mean_n,
                low_n,
                high_n,
                ..
            } => {
                assert!((value - (mean_n - 0.5 * (low_n + high_n))).abs() < 1e-12);
                assert!((limit - 0.5 * (high_n - low_n)).abs() < 1e-12);
            }
            other => assert!((value - limit).abs() > 0.0, "{other}"),
        }
    }
}

fn rule() -> ForceRule {
    ForceRule::active(Some(Newtons(0.2)))
}

fn segmented(made: &Recorded) -> Segmentation {
    segment_by_force(&signals(made), &rule()).unwrap()
}

fn plain(seed: u64, strokes: usize) -> Recorded {
    recorded(&mut Random::new(seed), &vec![Kind::Plain; strokes])
}

/// Every valid stroke of recordings with hesitations, double touches, bounces, pauses, drift and stick-slip is
/// found within 20 ms, and nothing else is.
#[test]
fn every_stroke_is_found_within_20_ms_and_nothing_else_is() {
    every_stroke_is_found_of(40);
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_every_stroke_is_found_within_20_ms_and_nothing_else_is() {
    every_stroke_is_found_of(200);
}

fn every_stroke_is_found_of(recordings: u64) {
    let rule = rule();
    let (mut valid, mut found, mut right) = (0, 0, 0);
    let mut worst = (0.0f64, 0.0f64);
    let mut errors_ms = Vec::new();
    let mut fates: BTreeMap<(Kind, String), usize> = BTreeMap::new();
    let mut wrong = Vec::new();
    for seed in 0..recordings {
        let made = active_touch(seed);
        let segmentation = segmented(&made);
        found += segmentation.strokes.len();
        for truth in &made.truths {
            let (on_s, off_s) = truth.contact_s;
            let here = |start: usize, end: usize| {
                let (start_s, end_s) = (start as f64 / RATE_HZ, end as f64 / RATE_HZ);
                start_s < off_s && on_s < end_s
            };
            let stroke = segmentation
                .strokes
                .iter()
                .find(|s| here(s.steady.start, s.steady.end));
            let fate = match stroke {
                Some(_) => "kept".into(),
                None => segmentation
                    .rejected
                    .iter()
                    .find(|r| here(r.interval.start, r.interval.end))
                    .map_or("missed".into(), |r| r.reason.name().to_owned()),
            };
            *fates.entry((truth.kind, fate.clone())).or_default() += 1;
            let Some(cut) = truth.cut_s(rule.landing_s.0, rule.take_off_s.0) else {
                continue;
            };
            valid += 1;
            let Some(stroke) = stroke else {
                wrong.push(format!("seed {seed}: {truth:?} was {fate}"));
                continue;
            };
            let start_s = stroke.steady.start as f64 / RATE_HZ - cut.0;
            let end_s = stroke.steady.end as f64 / RATE_HZ - cut.1;
            worst = (worst.0.max(start_s.abs()), worst.1.max(end_s.abs()));
            errors_ms.extend([start_s.abs() * 1e3, end_s.abs() * 1e3]);
            if start_s.abs() <= 0.02 && end_s.abs() <= 0.02 {
                right += 1;
            } else {
                wrong.push(format!(
                    "seed {seed}: {truth:?} starts {:.1} ms and ends {:.1} ms off",
                    start_s * 1e3,
                    end_s * 1e3
                ));
            }
        }
    }
    errors_ms.sort_by(f64::total_cmp);
    println!(
        "precision {:.4} ({right} of {found}), recall {:.4} ({right} of {valid}); start within {:.1} ms, end within {:.1} ms, median {:.1} ms",
        f64::from(right) / found as f64,
        f64::from(right) / f64::from(valid),
        worst.0 * 1e3,
        worst.1 * 1e3,
        errors_ms[errors_ms.len() / 2],
    );
    for ((kind, fate), count) in &fates {
        println!("  {kind:?}: {fate} {count}");
    }
    assert!(
        wrong.is_empty(),
        "{} wrong:\n{}",
        wrong.len(),
        wrong
            .iter()
            .take(20)
            .cloned()
            .collect::<Vec<_>>()
            .join("\n")
    );
    assert_eq!(found, right as usize, "a stroke was found where none is");
}

#[test]
fn a_force_that_is_negative_in_contact_is_turned_and_said() {
    let mut made = plain(1, 6);
    let upright = segmented(&made);
    for force in &mut made.fz_n {
        *force = -*force;
    }
    let turned = segmented(&made);
    assert_eq!(turned.strokes, upright.strokes);
    assert!(turned.warnings.iter().any(|d| matches!(
        d.kind(),
        Some(RecordingWarning::Sign {
            of: ReversedSign::Contact { .. }
        })
    )));
    assert!((turned.force_zeros.unwrap().sign + 1.0).abs() < 1e-12);
}

#[test]
fn swapped_axes_show_as_more_friction_than_skin_has() {
    let mut made = plain(2, 6);
    std::mem::swap(&mut made.fy_n, &mut made.fz_n);
    let signals = signals(&made);
    let rule = ForceRule {
        tolerance_share: 0.9,
        ..rule()
    };
    let found = segment_by_force(&signals, &rule).unwrap();
    assert!(found.strokes.len() >= 5, "{found:?}");
    assert!(
        found
            .warnings
            .iter()
            .any(|d| matches!(d.kind(), Some(ForceWarning::Doubtful { fault: ForceFault::HighFriction { coefficient } }) if coefficient > 1.2)),
        "{:?}",
        found.warnings
    );
}

#[test]
fn a_dead_force_is_refused_and_a_silent_one_holds_no_stroke() {
    let mut made = plain(3, 3);
    made.fz_n.fill(0.013);
    let dead = segment_by_force(&signals(&made), &rule()).unwrap_err();
    assert!(matches!(dead, SegmentError::Dead { .. }), "{dead}");
    for (i, force) in made.fz_n.iter_mut().enumerate() {
        *force = 0.004 * (i as f64 * 0.9).sin();
    }
    let silent = segmented(&made);
    assert!(silent.strokes.is_empty());
    assert!(
        silent
            .warnings
            .iter()
            .any(|d| matches!(d.kind(), Some(StrokeWarning::NoContact { .. }))),
        "{silent:?}"
    );
}

/// A finger that rests on a device has no strokes: what it felt while the drive played is one, without the time in which only the tails
/// of an inverse filter play, 12 dB below. Strokes beside a drive, as on a shaker, and a drive that is silent change nothing.
#[test]
fn what_was_felt_while_a_drive_played_is_one_stroke() {
    let made = plain(3, 3);
    let length = made.fz_n.len();
    let resting: Vec<f64> = (0..length)
        .map(|i| 0.2 + 0.01 * (i as f64 * 0.9).sin())
        .collect();
    let played = |from: usize, to: usize| {
        let wave = |i: usize| 0.3 * (i as f64 * 0.7 + 0.4).sin();
        (0..length)
            .map(|i| {
                if (from..to).contains(&i) {
                    wave(i)
                } else {
                    0.0
                }
            })
            .collect()
    };
    let segmented = |force: &[f64], drive: Vec<f64>, felt: &[f64]| {
        let channel = |name: &str, unit, samples: &[f64]| Channel {
            name: name.into(),
            unit,
            samples: samples.to_vec(),
        };
        let channels = vec![
            channel("drive", Unit::FullScale, &drive),
            channel("acceleration", Unit::MetrePerSecondSquared, felt),
            channel("normal_force", Unit::Newton, force),
        ];
        let rate = SampleRate::new(RATE_HZ).unwrap();
        let recording =
            Recording::new(channels, rate, Condition::default(), Provenance::default()).unwrap();
        let (roles, _) = Roles::guess(&recording);
        let expected = Expected {
            load_n: Some(Newtons(0.2)),
            speed_m_s: None,
            judging: Judging::Sliding,
        };
        segment(&recording, &roles, expected).unwrap()
    };
    let mut with_tails: Vec<f64> = played(1000, 9000);
    for (i, value) in with_tails.iter_mut().enumerate().skip(200).take(9600) {
        *value += 0.075 * (i as f64 * 0.3).sin();
    }
    // The tails reach the finger 50 dB below the texture, beside the noise of the sensor.
    let mut felt: Vec<f64> = played(1000, 9000);
    for (i, value) in felt.iter_mut().enumerate() {
        *value += 0.001 * (i as f64 * 1.3).sin();
    }
    let found = segmented(&resting, with_tails, &felt);
    assert_eq!((found.rule, found.strokes.len()), (Rule::Played, 1));
    let part = found.strokes[0].steady;
    assert!(
        part.start.abs_diff(1000) <= 10 && part.end.abs_diff(9000) <= 10,
        "{part:?}"
    );
    assert!(segmented(&resting, played(0, 0), &felt).strokes.is_empty());
    let strokes = segmented(&made.fz_n, played(1000, 9000), &made.acceleration);
    assert!(matches!(strokes.rule, Rule::Force(_)) && !strokes.strokes.is_empty());
}

#[test]
fn a_zero_that_drifts_through_the_threshold_is_followed_and_said() {
    let mut made = plain(4, 12);
    let length = made.fz_n.len() as f64;
    let still = segmented(&made);
    for (i, force) in made.fz_n.iter_mut().enumerate() {
        *force += 0.15 * i as f64 / length;
    }
    let drifting = segmented(&made);
    assert_eq!(drifting.strokes.len(), still.strokes.len());
    let said = drifting
        .warnings
        .iter()
        .any(|d| matches!(d.kind(), Some(ForceWarning::Doubtful { fault: ForceFault::ZeroDrifts { to_n, from_n, .. } }) if to_n - from_n > 0.1));
    assert!(said, "{:?}", drifting.warnings);
    // Force and friction are those of the finger, not of the cell's zero.
    let zeros = drifting.force_zeros.unwrap();
    let middle = drifting.strokes[6].steady.start;
    let expected = still.force_zeros.unwrap().at(0, middle) + 0.15 * middle as f64 / length;
    assert!((zeros.at(0, middle) - expected).abs() < 0.005);
}

#[test]
fn saturated_acceleration_and_a_load_off_target_are_rejected() {
    let mut made = plain(5, 6);
    let limit = made
        .acceleration
        .iter()
        .fold(0.0f64, |top, v| top.max(v.abs()))
        * 0.2;
    for sample in &mut made.acceleration {
        *sample = sample.clamp(-limit, limit);
    }
    let saturated = segmented(&made);
    assert!(saturated.strokes.is_empty());
    assert!(
        saturated
            .rejected
            .iter()
            .all(|r| matches!(r.reason, Reason::Clipped { .. })),
        "{:?}",
        saturated.rejected
    );
    decided_by(&saturated, StrokeCriterion::ClippedShare);
    assert!(saturated.rejected[0].criteria.len() > 3);
    let light = ForceRule::active(Some(Newtons(0.6)));
    let light = ForceRule {
        on_n: Newtons(0.1),
        off_n: Newtons(0.01),
        ..light
    };
    let off = segment_by_force(&signals(&plain(6, 6)), &light).unwrap();
    assert!(off.strokes.is_empty());
    assert!(
        off.rejected
            .iter()
            .all(|r| matches!(r.reason, Reason::ForceOutsideTolerance { .. })),
        "{:?}",
        off.rejected
    );
    decided_by(&off, StrokeCriterion::ForceDeviation);
}

#[test]
fn stick_slip_is_kept_only_when_asked_for() {
    let made = recorded(&mut Random::new(7), &[Kind::StickSlip; 6]);
    assert!(segmented(&made).strokes.is_empty());
    let all = ForceRule {
        judging: Judging::ContactOnly,
        ..rule()
    };
    let kept = segment_by_force(&signals(&made), &all).unwrap();
    assert_eq!(kept.strokes.len(), 6);
    assert!(
        kept.warnings
            .contains(&Warning::from(RecordingWarning::ChannelMissing {
                what: MissingChannel::Sliding
            }))
    );
}

/// Without tangential forces stick-slip is seen in the vibration; without vibration, sliding in the friction.
#[test]
fn one_kind_of_channel_is_enough() {
    let mixed = [
        Kind::Plain,
        Kind::StickSlip,
        Kind::Plain,
        Kind::TouchOnly,
        Kind::Plain,
    ];
    let made = recorded(&mut Random::new(8), &mixed);
    for (vibration, tangential) in [(true, false), (false, true)] {
        let mut signals = signals(&made);
        if !vibration {
            signals.vibration = None;
        }
        if !tangential {
            signals.tangential_force_n.clear();
        }
        let found = segment_by_force(&signals, &rule()).unwrap();
        assert_eq!(
            found.strokes.len(),
            3,
            "{vibration}, {tangential}: {:?}",
            found.rejected
        );
    }
}

#[test]
fn rules_that_cannot_be_are_refused() {
    let made = plain(9, 2);
    for bad in [
        ForceRule {
            on_n: Newtons(0.0),
            ..rule()
        },
        ForceRule {
            off_n: Newtons(0.2),
            ..rule()
        },
        ForceRule {
            on_n: Newtons(f64::NAN),
            ..rule()
        },
        ForceRule {
            tolerance_share: -1.0,
            ..rule()
        },
        ForceRule {
            load_n: Some(Newtons(-0.2)),
            ..rule()
        },
    ] {
        assert!(segment_by_force(&signals(&made), &bad).is_err(), "{bad:?}");
    }
    let short = Signals {
        normal_force_n: Some(&made.fz_n[..1000]),
        ..signals(&made)
    };
    assert!(matches!(
        segment_by_force(&short, &rule()),
        Err(SegmentError::TooShort { .. })
    ));
    let nothing = Signals {
        vibration: None,
        normal_force_n: None,
        ..signals(&made)
    };
    assert!(whole(&nothing).is_err());
}

/// A platform that goes and comes back: speed, position, contact, and where its plateaus begin and end, in s.
struct Platform {
    speed_m_s: Vec<f64>,
    position_m: Vec<f64>,
    force_n: Vec<f64>,
    plateaus_s: Vec<(f64, f64)>,
}

fn platform(held_n: f64) -> Platform {
    let mut random = Random::new(11);
    let mut made = Platform {
        speed_m_s: Vec::new(),
        position_m: Vec::new(),
        force_n: Vec::new(),
        plateaus_s: Vec::new(),
    };
    let (mut place_m, mut time_s) = (0.0, 0.0);
    for _ in 0..6 {
        let ramp_s = 0.03 / random.uniform(0.2, 0.5);
        let plateau_s = random.uniform(0.9, 1.3);
        let parts = [
            (0.5, 0.0),
            (ramp_s, 1.0),
            (plateau_s, 0.0),
            (ramp_s, -1.0),
            (0.6, 0.0),
            (1.4, -2.0),
        ];
        made.plateaus_s
            .push((time_s + 0.5 + ramp_s, time_s + 0.5 + ramp_s + plateau_s));
        for (i, (length_s, slope)) in parts.into_iter().enumerate() {
            for step in 0..(length_s * RATE_HZ) as usize {
                let share = step as f64 / (length_s * RATE_HZ);
                let speed = match (i, slope) {
                    (_, s) if s > 0.5 => 0.03 * share,
                    (3, _) => 0.03 * (1.0 - share),
                    (5, _) => -0.025 * (share * std::f64::consts::PI).sin(),
                    (2, _) => 0.03,
                    _ => 0.0,
                };
                place_m += speed / RATE_HZ;
                made.speed_m_s.push(speed + 2e-5 * random.normal());
                made.position_m.push(place_m);
                let down = i < 5 && time_s > 0.2;
                made.force_n
                    .push(if down { held_n } else { 0.0 } + 0.003 * random.normal());
                time_s += 1.0 / RATE_HZ;
            }
        }
    }
    made
}

#[test]
fn plateaus_of_the_speed_are_found_within_20_ms() {
    let made = platform(0.2);
    let rate = SampleRate::new(RATE_HZ).unwrap();
    let expected = Expected {
        load_n: None,
        speed_m_s: Some(0.03),
        judging: Judging::Sliding,
    };
    let rule = SpeedRule::trapezoid(expected);
    for (motion, kind) in [
        (&made.speed_m_s, MotionKind::Speed),
        (&made.position_m, MotionKind::Position),
    ] {
        let signals = Signals {
            rate,
            vibration: None,
            normal_force_n: Some(&made.force_n),
            tangential_force_n: Vec::new(),
            motion: Some((motion, kind)),
            contact_sign: None,
        };
        let found = segment_by_speed(&signals, &rule).unwrap();
        assert_eq!(found.strokes.len(), 6, "{kind:?}: {:?}", found.rejected);
        for (stroke, (from_s, to_s)) in found.strokes.iter().zip(&made.plateaus_s) {
            let start_s = stroke.steady.start as f64 / RATE_HZ;
            let end_s = stroke.steady.end as f64 / RATE_HZ;
            assert!(
                (start_s - from_s).abs() < 0.02 && (end_s - to_s).abs() < 0.02,
                "{kind:?}: {start_s}–{end_s} for {from_s}–{to_s}"
            );
        }
        let slow = SpeedRule {
            speed_m_s: Some(0.02),
            ..rule.clone()
        };
        let slow = segment_by_speed(&signals, &slow).unwrap();
        assert!(slow.warnings.iter().any(|d| matches!(
            d.kind(),
            Some(RecordingWarning::ConditionDiffers {
                what: Reached::Speed { .. }
            })
        )));
    }
    let lifted = platform(0.0);
    let signals = Signals {
        rate,
        vibration: None,
        normal_force_n: Some(&lifted.force_n),
        tangential_force_n: Vec::new(),
        motion: Some((&lifted.speed_m_s, MotionKind::Speed)),
        contact_sign: None,
    };
    let found = segment_by_speed(&signals, &rule).unwrap();
    assert!(found.strokes.is_empty());
    assert!(
        found.rejected.iter().any(|r| r.reason == Reason::NoContact),
        "{:?}",
        found.rejected
    );
    decided_by(&found, StrokeCriterion::TouchShare);
}

/// A tare offset does not decide the polarity: where the finger vibrates it touches.
#[test]
fn an_offset_force_keeps_its_polarity_and_its_zero() {
    for (sign, rest_n) in [(1.0, -0.3), (1.0, 0.3), (-1.0, 0.3), (-1.0, -0.3)] {
        let mut made = plain(12, 6);
        for force in &mut made.fz_n {
            *force = rest_n + sign * *force;
        }
        let found = segmented(&made);
        assert_eq!(found.strokes.len(), 6, "{sign}, {rest_n}: {found:?}");
        let zeros = found.force_zeros.unwrap();
        assert!((zeros.sign - sign).abs() < 1e-12, "{sign}, {rest_n}");
        let zero_n = zeros.at(0, found.strokes[3].steady.start);
        assert!(
            (zero_n - sign * rest_n).abs() < 0.15,
            "{sign}, {rest_n}: {zero_n}"
        );
    }
}

#[test]
fn a_touch_that_is_too_light_is_listed_and_leaves_the_others_alone() {
    let mut made = plain(13, 6);
    let (from_s, to_s) = made.truths[2].contact_s;
    for (i, force) in made.fz_n.iter_mut().enumerate() {
        let t = i as f64 / RATE_HZ;
        if t > from_s && t < to_s {
            *force *= 0.3;
        }
    }
    let found = segmented(&made);
    assert_eq!(found.strokes.len(), 5, "{:?}", found.rejected);
    assert!(
        matches!(found.rejected[..], [ref light] if matches!(light.reason, Reason::TooLight { .. })),
        "{:?}",
        found.rejected
    );
    decided_by(&found, StrokeCriterion::LargestForce);
}

/// Whatever it vibrates at between 30 Hz and 2 kHz, a finger that slides is seen to slide.
#[test]
fn sliding_is_seen_at_every_frequency() {
    for hz in [30.0, 100.0, 250.0, 500.0, 750.0, 1000.0, 2000.0] {
        let mut made = plain(14, 4);
        for (i, sample) in made.acceleration.iter_mut().enumerate() {
            let t = i as f64 / RATE_HZ;
            let sliding = made
                .truths
                .iter()
                .any(|truth| t > truth.sliding_s.0 && t < truth.sliding_s.1);
            let noise = 0.003 * ((i * 7919 % 1000) as f64 / 500.0 - 1.0);
            let tone = (std::f64::consts::TAU * hz * t).sin();
            *sample = noise + if sliding { tone } else { 0.0 };
        }
        assert_eq!(segmented(&made).strokes.len(), 4, "{hz} Hz");
    }
}

/// Passive touch has zeros too: forces with an offset, negative, or held for a minute while the platform strokes.
#[test]
fn a_held_finger_has_its_zeros() {
    let made = platform(0.2);
    let rate = SampleRate::new(RATE_HZ).unwrap();
    let expected = Expected {
        load_n: Some(Newtons(0.2)),
        speed_m_s: None,
        judging: Judging::Sliding,
    };
    let found = |force_n: &[f64]| {
        let signals = Signals {
            rate,
            vibration: None,
            normal_force_n: Some(force_n),
            tangential_force_n: Vec::new(),
            motion: Some((&made.speed_m_s, MotionKind::Speed)),
            contact_sign: None,
        };
        segment_by_speed(&signals, &SpeedRule::trapezoid(expected)).unwrap()
    };
    for (sign, offset_n) in [(1.0, 0.1), (1.0, 0.0), (-1.0, 0.0)] {
        let force_n: Vec<f64> = made.force_n.iter().map(|f| sign * (f + offset_n)).collect();
        let found = found(&force_n);
        assert_eq!(
            found.strokes.len(),
            6,
            "{sign}, {offset_n}: {:?}",
            found.rejected
        );
        let zero_n = found
            .force_zeros
            .unwrap()
            .at(0, found.strokes[2].steady.start);
        assert!(
            (zero_n - offset_n).abs() < 0.01,
            "{sign}, {offset_n}: {zero_n}"
        );
    }
    let held: Vec<f64> = made
        .force_n
        .iter()
        .map(|f| if *f > 0.1 { *f } else { f + 0.2 })
        .collect();
    let held = found(&held);
    assert_eq!(held.strokes.len(), 6);
    assert!(
        held.warnings
            .contains(&Warning::from(ForceWarning::Doubtful {
                fault: ForceFault::ZeroUnknown
            }))
    );
    let heavy: Vec<f64> = made.force_n.iter().map(|f| 3.0 * f).collect();
    let heavy = found(&heavy);
    assert!(
        heavy
            .rejected
            .iter()
            .any(|r| matches!(r.reason, Reason::ForceOutsideTolerance { .. }))
    );
}

#[test]
fn a_stroke_that_turns_back_is_none() {
    let mut made = plain(15, 4);
    let truth = made.truths[1];
    let middle_s = 0.5 * (truth.contact_s.0 + truth.contact_s.1);
    for (i, force) in made.fy_n.iter_mut().enumerate() {
        let t = i as f64 / RATE_HZ;
        if t > middle_s && t < truth.contact_s.1 {
            *force = -*force;
        }
    }
    let found = segmented(&made);
    assert_eq!(found.strokes.len(), 3);
    assert!(
        matches!(found.rejected[..], [ref turned] if turned.reason == Reason::Reversed),
        "{:?}",
        found.rejected
    );
    decided_by(&found, StrokeCriterion::Turns);
}
