//! A finger that another device follows: the position of a camera at 200 Hz on its own clock, beside a vibration at 5 kHz.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use crate::known_cuts::Random;
use piezotact::quantity::{SampleRate, Seconds, Unit};
use piezotact::recording::{Channel, Clock, Condition, Provenance, Recording};
use piezotact::stroke::Reason;
use piezotact::study::{AnalysedRecording, Naming, Recorded, Stated, cut};

const RATE_HZ: f64 = 5000.0;
const CAMERA_HZ: f64 = 200.0;
const SPEED_M_S: f64 = 0.04;
/// Where the surface moves at [`SPEED_M_S`], s.
const PLATEAUS_S: [[f64; 2]; 3] = [[0.7, 1.9], [2.7, 3.9], [4.7, 5.9]];
/// It takes so long to reach its speed, and to stop, s.
const RAMP_S: f64 = 0.1;
const LASTS_S: f64 = 6.6;

fn speed_m_s(t: f64) -> f64 {
    let of =
        |[from, to]: [f64; 2]| ((t - from + RAMP_S).min(to + RAMP_S - t) / RAMP_S).clamp(0.0, 1.0);
    SPEED_M_S * PLATEAUS_S.into_iter().map(of).fold(0.0, f64::max)
}

/// The place after each of `count` steps at `rate_hz`, the first `from_s` after the start.
fn places_m(rate_hz: f64, from_s: f64, count: usize) -> Vec<f64> {
    const STEP_S: f64 = 1e-4;
    let (mut t, mut place) = (0.0, 0.0);
    let at = |i: usize| from_s + i as f64 / rate_hz;
    let each = (0..count).map(|i| {
        while t < at(i) {
            place += STEP_S * speed_m_s(t + 0.5 * STEP_S);
            t += STEP_S;
        }
        place
    });
    each.collect()
}

fn channel(name: &str, unit: Unit, samples: Vec<f64>) -> Channel {
    Channel {
        name: name.into(),
        unit,
        samples,
    }
}

/// The vibration of a finger held with 0.2 N, with `motion` on its clock.
fn touched(motion: (Channel, Clock)) -> AnalysedRecording {
    let mut random = Random::new(4);
    let count = (LASTS_S * RATE_HZ) as usize;
    let nail = (0..count).map(|i| {
        let share = speed_m_s(i as f64 / RATE_HZ) / SPEED_M_S;
        (0.02 + share) * random.normal()
    });
    let nail = channel("nail", Unit::MetrePerSecondSquared, nail.collect());
    let force = (0..count).map(|i| if i < 500 { 0.0 } else { 0.2 } + 0.001 * random.normal());
    let force = channel("fz", Unit::Newton, force.collect());
    let clock = clock(RATE_HZ, 0.0);
    let recording = Recording::with_clocks(
        vec![(nail, clock), (force, clock), motion],
        Condition::default(),
        Provenance::default(),
    );
    let recorded = Recorded {
        file: "a".into(),
        name: "a".into(),
        recording: recording.unwrap(),
        naming: Naming::default(),
        cuts: None,
        cuts_are_looked_for_in: String::new(),
    };
    cut(recorded, &Stated::nothing()).unwrap()
}

fn clock(hz: f64, start_s: f64) -> Clock {
    Clock {
        rate_hz: SampleRate::new(hz).unwrap(),
        start_s: Seconds(start_s),
    }
}

/// A camera that begins `later_s` after the vibration and sees so many s.
fn seen(later_s: f64, lasts_s: f64) -> AnalysedRecording {
    let count = (lasts_s * CAMERA_HZ) as usize;
    let places = places_m(CAMERA_HZ, later_s, count);
    touched((
        channel("finger x", Unit::Metre, places),
        clock(CAMERA_HZ, later_s),
    ))
}

fn strokes_s(take: &AnalysedRecording) -> Vec<[f64; 2]> {
    let strokes = take.segmentation.strokes.iter().map(|stroke| stroke.steady);
    strokes
        .map(|steady| [take.seconds(steady.start), take.seconds(steady.end)])
        .collect()
}

#[test]
fn strokes_follow_a_camera_with_its_own_clock() {
    let count = (LASTS_S * RATE_HZ) as usize;
    let same = touched((
        channel("finger x", Unit::Metre, places_m(RATE_HZ, 0.0, count)),
        clock(RATE_HZ, 0.0),
    ));
    let expected = strokes_s(&same);
    assert_eq!(expected.len(), 3, "{:?}", same.segmentation.rejected);
    // Were the camera taken to begin with the vibration, its strokes would be off by as much.
    for later_s in [0.0, 0.1373, 0.4] {
        let take = seen(later_s, LASTS_S - later_s);
        let found = strokes_s(&take);
        assert_eq!(found.len(), 3, "{later_s}: {found:?}");
        for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert!(
                (found - expected).abs() < 0.011,
                "{later_s}: {found} for {expected}"
            );
        }
        let warnings = take.warnings();
        let said = warnings.iter().map(ToString::to_string);
        let said: Vec<String> = said
            .filter(|said| said.contains("clock of its own"))
            .collect();
        let [said] = said.as_slice() else {
            panic!("{said:?}")
        };
        assert!(said.contains(&format!("{later_s:.3} s later")), "{said}");
    }
    assert!(
        !same
            .warnings()
            .iter()
            .any(|said| said.to_string().contains("clock of its own"))
    );
}

#[test]
fn strokes_that_the_camera_did_not_see_are_rejected_and_named() {
    // It begins within the first stroke and ends before the last.
    let take = seen(1.2, 3.3);
    let found = strokes_s(&take);
    let whole = found.iter().filter(|[from, to]| to - from > 1.0);
    assert_eq!(whole.count(), 1, "{found:?}");
    assert!(
        found.iter().all(|[from, to]| *from >= 1.19 && *to <= 4.52),
        "{found:?}"
    );
    let warnings = take.warnings();
    let said = warnings.iter().map(ToString::to_string);
    let said: Vec<String> = said
        .filter(|said| said.contains("was measured from"))
        .collect();
    let [said] = said.as_slice() else {
        panic!("{said:?}")
    };
    assert!(said.contains("from 1.195 s to 4.500 s"), "{said}");
}

/// By the force, strokes are found that the camera did not see: their speed is not known.
#[test]
fn strokes_by_force_outside_the_camera_are_rejected() {
    use piezotact::recording::Touch;
    let made =
        crate::known_cuts::recorded(&mut Random::new(3), &[crate::known_cuts::Kind::Plain; 5]);
    let rate = RATE_HZ;
    let last_s = made.truths[3].contact_s.0 - 0.1;
    let places = (0..(last_s * CAMERA_HZ) as usize).map(|i| {
        let t = i as f64 / CAMERA_HZ;
        0.03 * t
    });
    let recording = Recording::with_clocks(
        vec![
            (
                channel(
                    "nail",
                    Unit::MetrePerSecondSquared,
                    made.acceleration.clone(),
                ),
                clock(rate, 0.0),
            ),
            (
                channel("fz", Unit::Newton, made.fz_n.clone()),
                clock(rate, 0.0),
            ),
            (
                channel("x", Unit::Metre, places.collect()),
                clock(CAMERA_HZ, 0.0),
            ),
        ],
        Condition {
            touch: Some(Touch::Active),
            ..Condition::default()
        },
        Provenance::default(),
    );
    let recorded = Recorded {
        file: "a".into(),
        name: "a".into(),
        recording: recording.unwrap(),
        naming: Naming::default(),
        cuts: None,
        cuts_are_looked_for_in: String::new(),
    };
    let take = cut(recorded, &Stated::nothing()).unwrap();
    assert_eq!(take.segmentation.strokes.len(), 3);
    let cut_off = take.segmentation.rejected.iter();
    let cut_off = cut_off.filter(|one| one.reason == Reason::CutByRecording);
    assert_eq!(cut_off.count(), 2);
}

/// A recording of forces alone has no vibration: what was found is named, and not a cable.
#[test]
fn a_recording_without_vibration_says_what_it_has() {
    use piezotact::feature::vibrations;
    let of = |unit: Unit, samples: Vec<f64>| {
        let count = (LASTS_S * RATE_HZ) as usize;
        let force = (0..count).map(|i| if (i / 5000) % 2 == 0 { 0.0 } else { 0.2 });
        let recording = Recording::new(
            vec![
                channel("fz", Unit::Newton, force.collect()),
                channel("other", unit, samples),
            ],
            SampleRate::new(RATE_HZ).unwrap(),
            Condition::default(),
            Provenance::default(),
        )
        .unwrap();
        let (roles, _) = piezotact::roles::Roles::guess(&recording);
        let segmentation =
            piezotact::stroke::whole(&piezotact::stroke::Signals::of(&recording, &roles).unwrap())
                .unwrap();
        let segmentation = piezotact::stroke::Segmentation {
            roles,
            ..segmentation
        };
        vibrations(&recording, &segmentation, None)
            .unwrap_err()
            .to_string()
    };
    let count = (LASTS_S * RATE_HZ) as usize;
    let said = of(Unit::Newton, vec![0.1; count]);
    for part in ["found `fz` (N), `other` (N)", "record the acceleration"] {
        assert!(said.contains(part), "no {part} in {said}");
    }
    let said = of(Unit::MetrePerSecondSquared, vec![0.1; count]);
    for part in ["one value throughout in `other`", "check its cable"] {
        assert!(said.contains(part), "no {part} in {said}");
    }
}
