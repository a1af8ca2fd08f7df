//! Strokes under noise of sensors, hum and a speed that wobbles: kept where the noise at rest explains it, and named otherwise.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::f64::consts::{SQRT_2, TAU};

use crate::known_cuts::{Kind, RATE_HZ, Random, Recorded, recorded};
use piezotact::quantity::SampleRate;
use piezotact::stroke::{
    Expected, ForceFault, ForceRule, ForceWarning, Judging, MotionKind, Reason, Segmentation,
    Signals, SpeedRule, segment_by_force, segment_by_speed,
};

fn made(seed: u64, kind: Kind) -> Recorded {
    recorded(&mut Random::new(seed), &[kind; 24])
}

/// `noise` of a sample's number is added to all three forces.
fn with_force(mut made: Recorded, mut noise: impl FnMut(usize) -> f64) -> Recorded {
    for axis in [&mut made.fx_n, &mut made.fy_n, &mut made.fz_n] {
        for (i, force) in axis.iter_mut().enumerate() {
            *force += noise(i);
        }
    }
    made
}

fn cut(made: &Recorded, vibration: Option<&[f64]>) -> Segmentation {
    let signals = Signals {
        rate: SampleRate::new(RATE_HZ).unwrap(),
        vibration,
        normal_force_n: Some(&made.fz_n),
        tangential_force_n: vec![&made.fx_n, &made.fy_n],
        motion: None,
        contact_sign: None,
    };
    segment_by_force(&signals, &ForceRule::active(None)).unwrap()
}

fn faults(found: &Segmentation) -> Vec<ForceFault> {
    let kinds = found.warnings.iter().filter_map(|one| one.kind());
    kinds
        .map(|ForceWarning::Doubtful { fault }| fault)
        .collect()
}

fn line(hz: f64, rms: f64) -> impl Fn(usize) -> f64 {
    move |i| SQRT_2 * rms * (TAU * hz * i as f64 / RATE_HZ).sin()
}

/// Forces with 0.1 N rms of noise, half of the load: every stroke counts, and what the noise hides is said.
#[test]
fn noise_of_the_forces_is_no_stick_slip() {
    for seed in [1, 2] {
        let mut random = Random::new(100 + seed);
        let noisy = with_force(made(seed, Kind::Plain), |_| 0.1 * random.normal());
        for vibration in [None, Some(noisy.acceleration.as_slice())] {
            let found = cut(&noisy, vibration);
            assert_eq!(found.strokes.len(), 24, "{seed}: {:?}", found.rejected);
            let hidden = |fault: &ForceFault| matches!(fault, ForceFault::SlipsHidden { noise_n, .. } if (noise_n - 0.1).abs() < 0.01);
            assert!(faults(&found).iter().any(hidden), "{:?}", found.warnings);
        }
    }
}

/// Slips that stand above the noise are stick-slip as before, and a quiet cell has no warning.
#[test]
fn slips_above_the_noise_are_stick_slip() {
    let mut random = Random::new(7);
    let noisy = with_force(made(3, Kind::StickSlip), |_| 0.01 * random.normal());
    let found = cut(&noisy, Some(&noisy.acceleration));
    let slips = |r: &&piezotact::stroke::Rejected| matches!(r.reason, Reason::StickSlip { .. });
    assert_eq!(
        found.rejected.iter().filter(slips).count(),
        24,
        "{:?}",
        found.rejected
    );
    let quiet = made(4, Kind::Plain);
    let found = cut(&quiet, Some(&quiet.acceleration));
    assert_eq!(found.strokes.len(), 24, "{:?}", found.rejected);
    let said = |fault: &ForceFault| {
        matches!(
            fault,
            ForceFault::SlipsHidden { .. } | ForceFault::Fluctuates { .. }
        )
    };
    assert!(!faults(&found).iter().any(said), "{:?}", found.warnings);
}

/// Hum and lines of a machine in the forces break no contact up.
#[test]
fn hum_of_the_forces_breaks_no_contact_up() {
    for (hz, fluctuates) in [(50.0, true), (60.0, true), (120.0, false)] {
        let hum = line(hz, 0.1);
        let noisy = with_force(made(5, Kind::Plain), hum);
        let found = cut(&noisy, Some(&noisy.acceleration));
        assert_eq!(found.strokes.len(), 24, "{hz} Hz: {:?}", found.rejected);
        let said = |fault: &ForceFault| matches!(fault, ForceFault::Fluctuates { .. });
        assert_eq!(
            faults(&found).iter().any(said),
            fluctuates,
            "{hz} Hz: {:?}",
            found.warnings
        );
    }
}

/// A machine's line in the vibration that is four times as strong as the texture: the reason states how far it stands above rest, and what is needed.
#[test]
fn a_line_in_the_vibration_is_named() {
    for hz in [83.0, 127.0] {
        let mut noisy = made(6, Kind::Plain);
        let level = piezotact::statistics::rms(&noisy.acceleration);
        let hum = line(hz, 4.0 * level);
        for (i, sample) in noisy.acceleration.iter_mut().enumerate() {
            *sample += hum(i);
        }
        let found = cut(&noisy, Some(&noisy.acceleration));
        assert_eq!(found.strokes.len(), 0);
        for rejected in &found.rejected {
            let Reason::SlidingUnclear { ratio, needed } = rejected.reason else {
                panic!("{hz} Hz: {rejected:?}");
            };
            assert!(ratio > 0.9 && needed == 4.0, "{hz} Hz: {ratio}");
        }
        let rate = SampleRate::new(RATE_HZ).unwrap();
        let said: Vec<String> = found
            .own_warnings(rate)
            .iter()
            .map(ToString::to_string)
            .collect();
        assert!(
            said.iter()
                .any(|one| one.contains("sliding unclear") && one.contains("lines of a machine")),
            "{said:?}"
        );
    }
}

/// Six passes at 20 mm/s whose speed is multiplied by `speed` at a time, with `noise_m_s` of the sensor.
fn passes(speed: impl Fn(f64) -> f64, noise_m_s: f64) -> Segmentation {
    let mut random = Random::new(9);
    let samples = 0..(12.0 * RATE_HZ) as usize;
    let speed_m_s: Vec<f64> = samples
        .map(|i| {
            let t_s = i as f64 / RATE_HZ;
            let moves = t_s % 2.0 > 0.6 && t_s % 2.0 < 1.9;
            let pass = if moves { 0.02 * speed(t_s) } else { 0.0 };
            pass + noise_m_s * random.normal()
        })
        .collect();
    let signals = Signals {
        rate: SampleRate::new(RATE_HZ).unwrap(),
        vibration: None,
        normal_force_n: None,
        tangential_force_n: Vec::new(),
        motion: Some((&speed_m_s, MotionKind::Speed)),
        contact_sign: None,
    };
    let expected = Expected {
        load_n: None,
        speed_m_s: None,
        judging: Judging::Sliding,
    };
    segment_by_speed(&signals, &SpeedRule::trapezoid(expected)).unwrap()
}

/// A speed that wobbles does not stop: how much it varies, for how long and what is allowed stand in the reason.
#[test]
fn a_speed_that_wobbles_is_called_unsteady() {
    for rms in [0.05, 0.08] {
        let found = passes(|t_s| 1.0 + rms * SQRT_2 * (TAU * 7.0 * t_s).sin(), 2e-5);
        assert_eq!(found.rejected.len(), 6, "{rms}: {:?}", found.strokes);
        for rejected in &found.rejected {
            let Reason::UnsteadySpeed {
                deviation_share,
                tolerance_share,
                outside,
            } = rejected.reason
            else {
                panic!("{rms}: {rejected:?}");
            };
            assert!(
                (deviation_share / rms - 1.0).abs() < 0.1,
                "{deviation_share}"
            );
            assert!((tolerance_share - 0.05).abs() < 0.005, "{tolerance_share}");
            assert!(outside > 0.3 && outside < 0.8, "{outside}");
        }
    }
    // One that stops is interrupted.
    let found = passes(
        |t_s| {
            if (1.1..1.4).contains(&(t_s % 2.0)) {
                0.3
            } else {
                1.0
            }
        },
        2e-5,
    );
    let stops =
        |r: &&piezotact::stroke::Rejected| matches!(r.reason, Reason::Interrupted { parts: 2 });
    assert_eq!(
        found.rejected.iter().filter(stops).count(),
        6,
        "{:?}",
        found.rejected
    );
}

/// Noise of the speed that stands at rest too is the sensor's: the passes count.
#[test]
fn noise_of_the_speed_at_rest_is_not_a_change_of_the_speed() {
    let found = passes(|_| 1.0, 8e-3);
    assert_eq!(found.strokes.len(), 6, "{:?}", found.rejected);
}

/// What carries the finger back vibrates more than the texture: contact is where the forces are, with a warning.
#[test]
fn a_way_back_that_vibrates_is_no_contact() {
    for (seed, sign) in [(11, 1.0), (12, -1.0)] {
        let mut random = Random::new(seed);
        let mut robot = made(seed, Kind::Plain);
        let lifted: Vec<bool> = robot.fz_n.iter().map(|n| n.abs() < 0.03).collect();
        for (a, lifted) in robot.acceleration.iter_mut().zip(&lifted) {
            *a += if *lifted { 3.0 * random.normal() } else { 0.0 };
        }
        robot.fz_n.iter_mut().for_each(|n| *n *= sign);
        let found = cut(&robot, Some(&robot.acceleration));
        let zeros = found.force_zeros.as_ref().unwrap();
        assert!((zeros.sign - sign).abs() < 1e-9, "{seed}: {}", zeros.sign);
        let vibrates = |fault: &ForceFault| matches!(fault, ForceFault::LiftsVibrate { ratio } if *ratio > 1.5);
        assert!(faults(&found).iter().any(vibrates), "{:?}", found.warnings);
    }
}

/// A line of 30 Hz, as a grating of 1 mm makes it at 30 mm/s, shows that the finger slides as noise does.
#[test]
fn a_slow_line_shows_sliding() {
    let mut random = Random::new(21);
    let mut grating = made(21, Kind::Plain);
    let wave = line(30.0, 0.7);
    let slides = |i: usize| {
        let at_s = i as f64 / RATE_HZ;
        let mut all = grating.truths.iter().map(|truth| truth.sliding_s);
        all.any(|(from_s, to_s)| (from_s..to_s).contains(&at_s))
    };
    let sliding: Vec<bool> = (0..grating.acceleration.len()).map(slides).collect();
    for (i, slides) in sliding.into_iter().enumerate() {
        let line = if slides { wave(i) } else { 0.0 };
        grating.acceleration[i] = line + 0.03 * random.normal();
    }
    let found = cut(&grating, Some(&grating.acceleration));
    assert_eq!(found.strokes.len(), 24, "{:?}", found.rejected);
}

/// The mean of a ratio to a noisy force has no limit: the coefficient of friction is that of forces without their noise.
#[test]
fn friction_under_noise_is_that_of_the_forces_without_it() {
    let quiet = made(31, Kind::Plain);
    let mean_friction = |recorded: &Recorded, found: &Segmentation| {
        let signals = Signals {
            rate: SampleRate::new(RATE_HZ).unwrap(),
            vibration: None,
            normal_force_n: Some(&recorded.fz_n),
            tangential_force_n: vec![&recorded.fx_n, &recorded.fy_n],
            motion: None,
            contact_sign: None,
        };
        let each = found.strokes.iter().map(|stroke| {
            let forces = piezotact::feature::stroke_forces(&signals, found, stroke.steady).unwrap();
            // The forces belong together, as the figure of a stroke shows them.
            for i in 0..forces.normal_n.len() {
                let ratio = forces.tangential_n[i] / forces.normal_n[i];
                assert!((ratio / forces.friction_coefficient[i] - 1.0).abs() < 1e-9);
            }
            let spread = piezotact::statistics::standard_deviation(&forces.normal_n);
            assert!(spread < 0.065, "{spread} N");
            let friction = forces.friction_coefficient;
            friction.iter().sum::<f64>() / friction.len() as f64
        });
        let each: Vec<f64> = each.collect();
        each.iter().sum::<f64>() / each.len() as f64
    };
    let strokes = cut(&quiet, None);
    let expected = mean_friction(&quiet, &strokes);
    let hum = line(50.0, 0.07);
    let mut random = Random::new(32);
    let noises: [&mut dyn FnMut(usize) -> f64; 2] =
        [&mut |i| hum(i), &mut |_| 0.07 * random.normal()];
    for noise in noises {
        let noisy = with_force(made(31, Kind::Plain), noise);
        let found = mean_friction(&noisy, &strokes);
        assert!((found / expected - 1.0).abs() < 0.05, "{found} {expected}");
    }
}

/// Hum of the mains with harmonics, as strong as the texture, hides no stroke.
#[test]
fn hum_in_the_vibration_hides_no_stroke() {
    for mains_hz in [50.0, 60.0] {
        let mut humming = made(41, Kind::Plain);
        let level = piezotact::statistics::rms(&humming.acceleration);
        for order in [1.0, 2.0, 3.0] {
            let hum = line(order * mains_hz, level);
            let samples = humming.acceleration.iter_mut().enumerate();
            samples.for_each(|(i, sample)| *sample += hum(i));
        }
        let found = cut(&humming, Some(&humming.acceleration));
        assert_eq!(
            found.strokes.len(),
            24,
            "{mains_hz} Hz: {:?}",
            found.rejected
        );
    }
}
