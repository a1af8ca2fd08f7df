//! The spatial period along the way of strokes of any speed, on synthetic hands of known surfaces.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::f64::consts::TAU;

use crate::known_cuts::Random;
use piezotact::compare::{AlongTheWay, PeriodCriterion, SpatialPeriod};
use piezotact::criterion::Outcome;
use piezotact::quantity::{SampleRate, Unit};
use piezotact::recording::{Channel, Condition, Provenance, Recording, Touch};
use piezotact::study::{
    Breadth, Gesture, Naming, Question, Recorded, Stated, StudyAnalysis, StudySettings, analyse,
    cut,
};

const RATE_HZ: f64 = 4000.0;
const STROKES: usize = 12;

/// How the motion is measured.
#[derive(Clone, Copy)]
enum Track {
    Speed,
    /// A tracker with so many images a second, in steps of so many m.
    Position {
        images_hz: f64,
        step_m: f64,
    },
}

const CAMERA: Track = Track::Position {
    images_hz: 200.0,
    step_m: 1e-5,
};

/// A surface under a hand.
#[derive(Clone)]
struct Hand {
    /// Periods, m, each with the amplitudes of its harmonics, m/s².
    combs: Vec<(f64, Vec<f64>)>,
    /// Lines of a machine, Hz, with their amplitudes, m/s².
    lines: Vec<(f64, f64)>,
    noise_m_s2: f64,
    /// The spread of the speed, as a share, between strokes and within each.
    spread: f64,
    track: Track,
    force: bool,
    /// How much later than the vibration the motion is recorded, s.
    late_s: f64,
    /// What a position of 1 m is written as.
    scale: f64,
}

impl Hand {
    fn on(combs: Vec<(f64, Vec<f64>)>) -> Self {
        Self {
            combs,
            lines: Vec::new(),
            noise_m_s2: 0.3,
            spread: 0.3,
            track: CAMERA,
            force: true,
            late_s: 0.0,
            scale: 1.0,
        }
    }

    fn on_machine(lines: &[f64]) -> Self {
        Self {
            lines: lines.iter().map(|hz| (*hz, 1.0)).collect(),
            // Nothing but lines does not show which part is contact.
            force: false,
            ..Self::on(Vec::new())
        }
    }

    /// Strokes of 40 mm, all one way, with rests in the air.
    fn recorded(&self, name: &str, sample: &str, seed: u64) -> Recorded {
        let mut random = Random::new(seed);
        let (mut place_m, mut seen) = (0.0f64, (0.0, 0usize));
        let mut channels = vec![Vec::new(); 4];
        for _ in 0..STROKES {
            let usual_m_s = 0.04 * (1.0 + self.spread * random.uniform(-1.0, 1.0));
            let wander = random.uniform(0.0, TAU);
            let phases: Vec<f64> = (0..40).map(|_| random.uniform(0.0, TAU)).collect();
            let stroke_s = 0.04 / usual_m_s;
            let samples = ((stroke_s + 0.8) * RATE_HZ) as usize;
            for i in 0..samples {
                let t = i as f64 / RATE_HZ - 0.4;
                let up = ((t + 0.05) / 0.05).clamp(0.0, 1.0);
                let down = ((stroke_s + 0.05 - t) / 0.05).clamp(0.0, 1.0);
                let pace = 1.0 + 0.5 * self.spread * (TAU * t + wander).sin();
                let speed = usual_m_s * pace * up * down;
                place_m += speed / RATE_HZ;
                let touches = t > 0.0 && t < stroke_s;
                let mut a = self.noise_m_s2 * random.normal();
                let time_s = channels[0].len() as f64 / RATE_HZ;
                for (hz, amplitude) in &self.lines {
                    a += amplitude * (TAU * hz * time_s).sin();
                }
                if touches {
                    let teeth = self.combs.iter().flat_map(|(period_m, teeth)| {
                        (1..)
                            .zip(teeth)
                            .map(move |(n, a)| (f64::from(n) / period_m, a))
                    });
                    for ((waves, amplitude), phase) in teeth.zip(&phases) {
                        a += amplitude * (TAU * waves * place_m + phase).sin();
                    }
                }
                channels[0].push(a);
                channels[1].push(match self.track {
                    Track::Speed => speed,
                    Track::Position { images_hz, step_m } => {
                        if seen.1 == 0 {
                            seen.0 = (place_m / step_m).round() * step_m;
                        }
                        seen.1 = (seen.1 + 1) % (RATE_HZ / images_hz) as usize;
                        seen.0
                    }
                });
                let contact = ((t / 0.04).min((stroke_s - t) / 0.04)).clamp(0.0, 1.0);
                channels[2].push(0.3 * contact + 0.002 * random.normal());
                channels[3].push(0.15 * contact + 0.002 * random.normal());
            }
        }
        let late = (self.late_s * RATE_HZ) as usize;
        channels[1].rotate_right(late);
        channels[1]
            .iter_mut()
            .for_each(|value| *value *= self.scale);
        let motion = match self.track {
            Track::Speed => ("speed", Unit::MetrePerSecond),
            Track::Position { .. } => ("position", Unit::Metre),
        };
        let named = [
            ("nail", Unit::MetrePerSecondSquared),
            motion,
            ("fz", Unit::Newton),
            ("fx", Unit::Newton),
        ];
        let kept = if self.force { 4 } else { 2 };
        let all = named.into_iter().zip(channels).take(kept);
        let all = all.map(|((name, unit), samples)| Channel {
            name: name.into(),
            unit,
            samples,
        });
        let condition = Condition {
            sample: Some(sample.into()),
            touch: Some(Touch::Active),
            ..Condition::default()
        };
        let rate = SampleRate::new(RATE_HZ).unwrap();
        Recorded {
            file: name.into(),
            name: name.into(),
            recording: Recording::new(all.collect(), rate, condition, Provenance::default())
                .unwrap(),
            naming: Naming::default(),
            cuts: None,
            cuts_are_looked_for_in: String::new(),
        }
    }

    fn study(&self, seeds: std::ops::Range<u64>) -> StudyAnalysis {
        study(seeds.map(|seed| self.recorded(&format!("R{seed}"), "A", seed)))
    }

    /// What one recording says.
    fn way(&self, seed: u64) -> AlongTheWay {
        self.study(seed..seed + 1).groups.remove(0).way.unwrap()
    }
}

fn study(recorded: impl Iterator<Item = Recorded>) -> StudyAnalysis {
    let takes = recorded.map(|one| cut(one, &Stated::nothing()).unwrap());
    let settings = StudySettings {
        gesture: Gesture::Usual,
        segment: None,
        sets: Vec::new(),
        twin_sets: Vec::new(),
        ridge_m: None,
        question: Question::Groups(None),
        breadth: Breadth::Question,
    };
    analyse(takes.collect(), &settings).unwrap()
}

fn outcome(period: &SpatialPeriod, what: PeriodCriterion) -> Outcome {
    let mut criteria = period.criteria.iter();
    criteria.find(|c| c.what == what).unwrap().outcome
}

/// Whatever measures the motion, a grating is found within 1 %, its interval holds it, and its lines move with the speed.
#[test]
fn a_grating_under_a_hand_is_found_along_the_way() {
    let tracks = [
        Track::Speed,
        CAMERA,
        Track::Position {
            images_hz: 60.0,
            step_m: 1e-4,
        },
        // An encoder: as many values as there are samples, in steps of 50 µm.
        Track::Position {
            images_hz: RATE_HZ,
            step_m: 5e-5,
        },
    ];
    for (i, track) in tracks.into_iter().enumerate() {
        for force in [true, false] {
            let hand = Hand {
                track,
                force,
                ..Hand::on(vec![(0.0008, vec![1.0, 0.6, 0.5])])
            };
            let way = hand.way(i as u64 + 1);
            let period = way.period.unwrap();
            assert_eq!(period.outcome, Outcome::Met, "{i}: {}", period.conclusion());
            assert!((period.period_m / 0.0008 - 1.0).abs() < 0.01, "{period:?}");
            let [low, high] = period.interval_m.unwrap();
            assert!(
                low * 0.998 < 0.0008 && 0.0008 < high * 1.002,
                "{low} {high}"
            );
            let first = way.spectrum.peaks.first().unwrap();
            assert!(
                (first.wavenumber_1_m * 0.0008 - 1.0).abs() < 0.03,
                "{first:?}"
            );
        }
    }
}

/// Lines of a machine, whatever their ratios, and what has no period are no period.
#[test]
fn lines_that_stay_and_broad_textures_have_no_period_along_the_way() {
    no_period_along_the_way_of(3);
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_lines_that_stay_and_broad_textures_have_no_period_along_the_way() {
    no_period_along_the_way_of(10);
}

fn no_period_along_the_way_of(hands: u64) {
    let machines: [&[f64]; 4] = [&[50.0], &[50.0, 100.0, 150.0], &[37.0, 74.0, 111.0], &[]];
    for lines in machines {
        for spread in [0.3, 0.1, 0.0] {
            for seed in 0..hands {
                let hand = Hand {
                    spread,
                    ..Hand::on_machine(lines)
                };
                let way = hand.way(40 + seed);
                let met = way.period.filter(|period| period.outcome == Outcome::Met);
                assert_eq!(
                    met.map(|p| p.conclusion()),
                    None,
                    "{lines:?} {spread} {seed}"
                );
            }
        }
    }
    let period = Hand::on_machine(&[50.0]).way(1).period.unwrap();
    assert!(
        period.conclusion().contains("a line at 50.0 Hz stays"),
        "{}",
        period.conclusion()
    );
}

/// A hand that always moves at one speed, one line from one recording, two gratings, and a tracker that lost the finger decide nothing; more
/// recordings of one line do.
#[test]
fn what_a_recording_along_the_way_cannot_decide_is_open() {
    let comb = vec![(0.0008, vec![1.0, 0.6, 0.5])];
    let steady = Hand {
        spread: 0.0,
        ..Hand::on(comb.clone())
    };
    let period = steady.way(3).period.unwrap();
    assert_eq!(
        outcome(&period, PeriodCriterion::Moves),
        Outcome::NotDecided
    );
    assert_eq!(
        period.outcome,
        Outcome::NotDecided,
        "{}",
        period.conclusion()
    );

    let one_line = Hand::on(vec![(0.0008, vec![1.0])]);
    let period = one_line.way(4).period.unwrap();
    assert_eq!(
        outcome(&period, PeriodCriterion::Reach),
        Outcome::NotDecided
    );
    assert!(period.is_imprecise(), "{}", period.conclusion());
    let several = one_line.study(5..9).groups.remove(0).way.unwrap();
    let period = several.period.unwrap();
    assert_eq!(period.outcome, Outcome::Met, "{}", period.conclusion());
    assert!((period.period_m / 0.0008 - 1.0).abs() < 0.01, "{period:?}");

    let two = Hand::on(vec![(0.0008, vec![1.0]), (0.00053, vec![1.0])]);
    for seed in 0..5 {
        let period = two.way(seed).period.unwrap();
        assert_ne!(period.outcome, Outcome::Met, "{}", period.conclusion());
    }

    // Steps of 10 mm: 12 periods.
    let lost = Hand {
        track: Track::Position {
            images_hz: 4.0,
            step_m: 1e-2,
        },
        ..Hand::on(comb)
    };
    for seed in 0..5 {
        let group = lost.study(seed..seed + 1).groups.remove(0);
        let period = group.way.and_then(|way| way.period);
        let met = period.filter(|period| period.outcome == Outcome::Met);
        assert_eq!(met.map(|p| p.conclusion()), None);
    }
}

/// Twice the period of a coarse grating is below what the filter of the gesture leaves of the slowest strokes, and not of the faster ones: they
/// say that it is none, and that a period twice as long is one.
#[test]
fn faster_strokes_hold_longer_periods() {
    for (period_m, teeth) in [
        (0.0014, vec![1.0, 0.6, 0.4]),
        (0.0024, vec![0.7, 1.0, 0.4, 0.4]),
    ] {
        let hand = Hand {
            spread: 0.45,
            ..Hand::on(vec![(period_m, teeth)])
        };
        let found = hand.study(21..24).groups.remove(0).way.unwrap();
        let period = found.period.unwrap();
        let is_near = (period.period_m / period_m - 1.0).abs() < 0.02;
        let said = period.conclusion();
        match period_m < 0.002 {
            true => assert!(is_near && period.outcome == Outcome::Met, "{said}"),
            // Its own line is below the filter where strokes are slow: found, or left open.
            false => assert!(is_near || period.outcome != Outcome::Met, "{said}"),
        }
    }
}

/// A camera that is late gives another period, and a position in mm none: neither is said.
#[test]
fn a_motion_of_another_time_or_unit_decides_nothing() {
    let comb = vec![(0.0008, vec![1.0, 0.6, 0.5])];
    for seed in 0..4 {
        for late_s in [0.02, 0.05, 0.1] {
            let late = Hand {
                late_s,
                ..Hand::on(comb.clone())
            };
            let period = late.way(seed).period.unwrap();
            let right = (period.period_m / 0.0008 - 1.0).abs() < 0.005;
            assert!(
                period.outcome != Outcome::Met || right && late_s < 0.03,
                "{late_s} {seed}: {}",
                period.conclusion()
            );
        }
        let in_mm = Hand {
            scale: 1e3,
            ..Hand::on(comb.clone())
        };
        assert_eq!(in_mm.study(seed..seed + 1).groups[0].way, None);
    }
    let late = Hand {
        late_s: 0.05,
        spread: 0.2,
        ..Hand::on(comb)
    };
    let said: Vec<String> = (0..6)
        .filter_map(|seed| Some(late.way(seed).period?.conclusion()))
        .collect();
    assert!(
        said.iter()
            .any(|text| text.contains("50.0 ms later than the vibration")),
        "{said:?}"
    );
}

/// A period that all samples have may be the finger's or the machine's; where they differ, each has its own.
#[test]
fn a_period_of_all_samples_is_not_decided() {
    let of = |period_m: f64| Hand::on(vec![(period_m, vec![1.0, 0.6, 0.5])]);
    let with = |a_m: f64, b_m: f64| {
        let recorded = [
            of(a_m).recorded("one", "A", 1),
            of(b_m).recorded("two", "B", 2),
        ];
        let groups = study(recorded.into_iter()).groups.into_iter();
        let periods = groups.map(|group| group.way.unwrap().period.unwrap());
        periods.map(|period| period.outcome).collect::<Vec<_>>()
    };
    assert_eq!(with(0.0008, 0.0008), [Outcome::NotDecided; 2]);
    assert_eq!(with(0.0008, 0.0011), [Outcome::Met; 2]);
}

/// Strokes of a hand whose motion is measured are cut by the force, as without: a hand has no plateau of the speed.
#[test]
fn a_measured_motion_takes_no_stroke_of_a_hand_away() {
    for force in [true, false] {
        let hand = Hand {
            force,
            ..Hand::on(vec![(0.0008, vec![1.0])])
        };
        let study = hand.study(1..2);
        assert_eq!(
            study.strokes(),
            STROKES,
            "{:?}",
            study.takes[0].segmentation.rejected
        );
    }
}
