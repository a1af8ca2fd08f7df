use piezotact::lineage::Level;
use piezotact::manipulate::Texture;
use piezotact::quantity::{Degrees, Newtons, SampleRate};
use piezotact::statistics::random::Random;

use super::*;
use crate::campaign::chain::Sha;
use crate::campaign::plan::{PlanRequest, plan};
use crate::campaign::protocol::{Stimulus, from_library};

const NOW: i64 = 1_800_000_000_000;
const HOUR: i64 = 3_600_000;

fn planned(protocol: &Protocol, session: &str) -> Plan {
    let request = PlanRequest {
        seed: 1,
        participant: "P01",
        session,
        completed: &[],
    };
    plan(protocol, Sha::of(b"protocol"), request).unwrap()
}

/// The stroke on `sample`, at a level of its own.
fn stroke(sample: &str) -> Texture<Acceleration> {
    let number: f64 = sample.trim_start_matches('S').parse().unwrap();
    let mut random = Random::stream(1, number as u64, "strokes");
    let samples = (0..4000).map(|_| random.normal() / number).collect();
    let rate = SampleRate::new(4000.0).unwrap();
    let series = Series::new(samples, rate).unwrap();
    Texture::of(format!("{sample}.parquet"), series)
}

/// The texture of `stimulus`, made as the protocol states it.
fn texture_of(stimulus: &Stimulus) -> Texture<Acceleration> {
    let strokes: Vec<_> = stimulus.samples().map(|s| (s, stroke(s))).collect();
    let of = |sample: &str| strokes.iter().find(|(name, _)| *name == sample);
    let within = Level::Within("20..1000".parse().unwrap());
    stimulus
        .texture(|sample| of(sample).map(|(_, stroke)| stroke), within)
        .unwrap()
}

fn fits(protocol: &Protocol, plan: &Plan) -> Vec<RenderingFacts> {
    let origin = Origin {
        bench: Some(BenchKind::Twin),
        condition: Condition {
            participant: Some("P01".to_owned()),
            twin_seed: Some(7),
            load_n: Some(Newtons(0.2)),
            angle_deg: Some(Degrees(20.0)),
            ..Condition::default()
        },
        at_ms: Some(NOW - 20 * HOUR),
    };
    let facts = |(i, stimulus): (usize, &str)| RenderingFacts {
        stimulus: stimulus.to_owned(),
        file: format!("drives/{stimulus}.wav"),
        sha: Sha::of(stimulus.as_bytes()),
        samples: Checksum::of([i as f64]),
        lineage: None,
        sample: protocol.sample_of(stimulus).map(str::to_owned),
        target_file: format!("targets/{stimulus}.wav"),
        texture: texture_of(&protocol.stimulus(stimulus).unwrap()).series,
        target_lineage: None,
        changed_since_measured: None,
        made_with: vec![Checksum::of([1.0])],
        level_error_db: Some(0.2),
        level_db: -1.5,
        drive_s: 1.5,
        strokes: origin.clone(),
        transfer_function: origin.clone(),
        measurement: origin.clone(),
        rendered_with: Whose::Of("P01".to_owned()),
        verified: Outcome::Met,
        measured: MeasuredDrive::This,
        refused: Vec::new(),
    };
    let stimuli = stimuli_of(plan).into_iter().enumerate();
    stimuli.map(facts).collect()
}

fn found(protocol: &Protocol, plan: &Plan, drives: &[RenderingFacts], hours: i64) -> Vec<NotReady> {
    let earlier = [EarlierSession {
        session: "measurement",
        ended_ms: Some(NOW - hours * HOUR),
    }];
    let known = Known {
        renderings: drives,
        incomplete: &[],
        played: &BTreeMap::new(),
        earlier: &earlier,
        panels: &[],
        bench: None,
        sensor: None,
        now_ms: NOW,
    };
    not_ready(protocol, plan, known)
}

#[test]
fn a_session_with_everything_begins_and_each_thing_that_is_wrong_is_said() {
    let protocol = from_library("isotropic_triplets").unwrap().unwrap();
    let plan = planned(&protocol, "discrimination");
    let drives = fits(&protocol, &plan);
    assert!(!drives.is_empty());
    assert_eq!(found(&protocol, &plan, &drives, 20), []);
    let first = drives[0].stimulus.clone();
    let with = |change: &dyn Fn(&mut RenderingFacts)| {
        let mut drives = drives.clone();
        change(&mut drives[0]);
        found(&protocol, &plan, &drives, 20)
    };
    assert_eq!(
        found(&protocol, &plan, &drives[1..], 20),
        [NotReady::Missing {
            stimulus: first.clone()
        }]
    );
    let incomplete = [(first.clone(), "measured/S2.parquet".to_owned())];
    let known = Known {
        renderings: &[],
        incomplete: &incomplete,
        played: &BTreeMap::new(),
        earlier: &[],
        panels: &[],
        bench: None,
        sensor: None,
        now_ms: NOW,
    };
    let without = not_ready(&protocol, &plan, known);
    assert!(without.iter().any(|one| {
        one.to_string()
            .contains("expected measured/S2.parquet beside")
    }));
    let somebody = |one: &mut RenderingFacts| {
        one.strokes.condition.participant = Some("P02".to_owned());
    };
    assert!(matches!(with(&somebody)[..], [NotReady::Strokes { .. }]));
    let nobody = |one: &mut RenderingFacts| one.strokes.condition.participant = None;
    assert!(matches!(with(&nobody)[..], [NotReady::Strokes { .. }]));
    let average = |one: &mut RenderingFacts| one.rendered_with = Whose::Average;
    assert!(matches!(
        with(&average)[..],
        [NotReady::TransferFunction { .. }]
    ));
    let open = |one: &mut RenderingFacts| one.verified = Outcome::NotDecided;
    assert!(matches!(with(&open)[..], [NotReady::NotPassed { .. }]));
    let swapped = |one: &mut RenderingFacts| one.measured = MeasuredDrive::Another;
    assert!(matches!(with(&swapped)[..], [NotReady::Measured { .. }]));
    let elsewhere = |one: &mut RenderingFacts| one.measured = MeasuredDrive::Unstated;
    assert_eq!(with(&elsewhere), []);
    let old = |one: &mut RenderingFacts| one.measurement.at_ms = Some(NOW - 800 * HOUR);
    assert!(matches!(with(&old)[..], [NotReady::TooOld { .. }]));
    let future = |one: &mut RenderingFacts| one.measurement.at_ms = Some(NOW + HOUR);
    assert!(matches!(with(&future)[..], [NotReady::Undated { .. }]));
    let no_time = |one: &mut RenderingFacts| one.measurement.at_ms = Some(i64::MIN);
    assert!(matches!(with(&no_time)[..], [NotReady::TooOld { .. }]));
    let is_undated = |one: &NotReady| matches!(one, NotReady::Undated { .. });
    let undated = |one: &mut RenderingFacts| {
        (one.measurement.at_ms, one.measurement.bench) = (None, Some(BenchKind::Hardware));
    };
    assert!(with(&undated).iter().any(is_undated));
    // What is simulated has no time of day, and does not age.
    let simulated = |one: &mut RenderingFacts| {
        (one.measurement.at_ms, one.measurement.bench) = (None, Some(BenchKind::Twin));
    };
    assert!(!with(&simulated).iter().any(is_undated));
}

#[test]
fn the_second_session_waits_for_the_first_and_for_another_day() {
    let protocol = from_library("isotropic_triplets").unwrap().unwrap();
    let plan = planned(&protocol, "discrimination");
    let drives = fits(&protocol, &plan);
    assert!(matches!(
        found(&protocol, &plan, &drives, 3)[..],
        [NotReady::SameDay { .. }]
    ));
    let known = Known {
        renderings: &drives,
        incomplete: &[],
        played: &BTreeMap::new(),
        earlier: &[],
        panels: &[],
        bench: None,
        sensor: None,
        now_ms: NOW,
    };
    assert!(matches!(
        not_ready(&protocol, &plan, known)[..],
        [NotReady::Earlier { .. }]
    ));
    let first = planned(&protocol, "measurement");
    assert_eq!(not_ready(&protocol, &first, known), []);
    // Chapter 6 allows both in one session.
    let chapter6 = from_library("touch_control_imagery").unwrap().unwrap();
    let same_day = chapter6
        .sessions
        .iter()
        .all(|one| one.when == When::AnyTime);
    assert!(same_day);
}

#[test]
fn panels_that_must_not_overlap_are_stated_and_looked_up() {
    let protocol = from_library("averaged_transfer_function").unwrap().unwrap();
    let session = &protocol.sessions[0].name;
    let plan = planned(&protocol, session);
    let with = |panels: &[(String, BTreeSet<String>)]| {
        let known = Known {
            renderings: &[],
            incomplete: &[],
            played: &BTreeMap::new(),
            earlier: &[],
            panels,
            bench: None,
            sensor: None,
            now_ms: NOW,
        };
        let found = not_ready(&protocol, &plan, known);
        let of_panels =
            |one: &NotReady| matches!(one, NotReady::Panel { .. } | NotReady::UnknownPanel { .. });
        found.into_iter().filter(of_panels).collect::<Vec<_>>()
    };
    let names = &protocol.panel.disjoint_from;
    assert_eq!(names.len(), 3);
    assert_eq!(with(&[]).len(), 3);
    let stated = |member: &str| {
        let members = BTreeSet::from([member.to_owned()]);
        let each = names.iter().map(|name| (name.clone(), members.clone()));
        each.collect::<Vec<_>>()
    };
    assert_eq!(with(&stated("P07")), []);
    assert_eq!(with(&stated("P01")).len(), 3);
    assert_eq!(with(&stated("p01")).len(), 3);
}

fn on(kind: BenchKind, person: Option<&str>) -> BenchNow {
    BenchNow {
        kind,
        condition: Condition {
            participant: person.map(str::to_owned),
            twin_seed: (kind == BenchKind::Twin).then_some(7),
            load_n: Some(Newtons(0.2)),
            angle_deg: Some(Degrees(20.0)),
            ..Condition::default()
        },
    }
}

fn found_on(bench: &BenchNow, change: &dyn Fn(&mut RenderingFacts)) -> Vec<NotReady> {
    let protocol = from_library("isotropic_triplets").unwrap().unwrap();
    let plan = planned(&protocol, "discrimination");
    let mut drives = fits(&protocol, &plan);
    change(&mut drives[0]);
    let earlier = [EarlierSession {
        session: "measurement",
        ended_ms: Some(NOW - 20 * HOUR),
    }];
    let known = Known {
        renderings: &drives,
        incomplete: &[],
        played: &BTreeMap::new(),
        earlier: &earlier,
        panels: &[],
        bench: Some(bench),
        sensor: None,
        now_ms: NOW,
    };
    not_ready(&protocol, &plan, known)
}

#[test]
fn who_feels_what_is_played_is_the_participant() {
    let with = |bench: &BenchNow| {
        found_on(bench, &|one| {
            for part in [
                &mut one.strokes,
                &mut one.transfer_function,
                &mut one.measurement,
            ] {
                part.bench = None;
            }
        })
        .into_iter()
        .filter(|one| one.stimulus().is_none())
        .collect::<Vec<_>>()
    };
    assert_eq!(with(&on(BenchKind::Hardware, None)), []);
    assert_eq!(with(&on(BenchKind::Hardware, Some("P01"))), []);
    assert_eq!(with(&on(BenchKind::Twin, Some("P01"))), []);
    for kind in [BenchKind::Twin, BenchKind::Hardware] {
        assert_eq!(
            with(&on(kind, Some("P02"))),
            [NotReady::OtherFinger {
                participant: "P01".to_owned(),
                found: "P02".to_owned()
            }]
        );
    }
    for bench in [BenchKind::Measured, BenchKind::Scripted, BenchKind::Twin] {
        assert_eq!(
            with(&on(bench, None)),
            [NotReady::NoFinger {
                participant: "P01".to_owned(),
                bench
            }]
        );
    }
    // A scripted fake names whom it likes.
    assert_eq!(with(&on(BenchKind::Scripted, Some("P01"))).len(), 1);
}

#[test]
fn a_drive_that_does_not_fit_the_bench_is_refused_with_a_sentence_for_each_fault() {
    let bench = on(BenchKind::Twin, Some("P01"));
    let said = |change: &dyn Fn(&mut RenderingFacts)| -> Vec<String> {
        let found = found_on(&bench, change).into_iter();
        found
            .map(|one| {
                let text = one.to_string();
                text[one.stimulus().unwrap().len()..].to_owned()
            })
            .collect()
    };
    assert_eq!(said(&|_| {}), [""; 0]);
    let gain = |one: &mut RenderingFacts| one.refused.push("the gain; set it".to_owned());
    assert_eq!(said(&gain), [": the gain; set it"]);
    let elsewhere = |one: &mut RenderingFacts| one.measurement.bench = Some(BenchKind::Hardware);
    assert_eq!(
        said(&elsewhere),
        [
            ": expected a measurement of the drive on the digital twin, found real devices; prepare it on the bench of the session"
        ]
    );
    let seed = |one: &mut RenderingFacts| {
        one.strokes.condition.twin_seed = Some(9);
        one.transfer_function.condition.twin_seed = Some(9);
    };
    assert_eq!(
        said(&seed),
        ["strokes", "a transfer function"].map(|part| format!(
            ": expected {part} of the twin of seed 7, which is on the bench, found the twin of seed 9; name that bench, or prepare it on this one"
        ))
    );
    let lies = |one: &mut RenderingFacts| {
        one.transfer_function.condition.load_n = Some(Newtons(0.5));
        one.measurement.condition.angle_deg = Some(Degrees(30.0));
        // Strokes have loads of their own.
        one.strokes.condition.load_n = Some(Newtons(0.5));
    };
    assert_eq!(
        said(&lies),
        [
            ": expected a transfer function with the finger at 0.2 N as in this session, found 0.5 N; place the finger so, or prepare it again",
            ": expected a measurement of the drive with the finger at 20° as in this session, found 30°; place the finger so, or prepare it again"
        ]
    );
    let old = |one: &mut RenderingFacts| {
        one.transfer_function.at_ms = Some(NOW - 800 * HOUR);
        one.strokes.at_ms = Some(NOW - 801 * HOUR);
    };
    assert_eq!(
        said(&old),
        [
            ": expected strokes of the last 720 h, found an age of 801.0 h; measure the participant again",
            ": expected a transfer function of the last 720 h, found an age of 800.0 h; measure the participant again"
        ]
    );
    // Other systems do not say when they measured, nor on what.
    let bare = |one: &mut RenderingFacts| {
        one.transfer_function = Origin::default();
        one.strokes.at_ms = None;
        one.strokes.bench = None;
    };
    assert_eq!(said(&bare), [""; 0]);
    let ahead = |one: &mut RenderingFacts| one.measurement.at_ms = Some(NOW + 2 * HOUR);
    assert_eq!(
        said(&ahead),
        [
            ": expected a measurement of the drive with its date, found a date 2.0 h ahead of this computer's clock; set the clock, or prepare it again"
        ]
    );
}

#[test]
fn a_sensor_that_does_not_read_as_it_did_is_not_ready() {
    use piezotact::criterion::{Criterion, Limit};
    use piezotact::transfer::AtRestCriterion;

    let protocol = from_library("isotropic_triplets").unwrap().unwrap();
    let plan = planned(&protocol, "discrimination");
    let drives = fits(&protocol, &plan);
    let said = |level_db: f64, shape_db: f64, at_ms: Option<i64>, kind: BenchKind| {
        let level = Limit::Within { reach: 1.5 };
        let shape = Limit::at_most(1.0);
        let sensor = SensorNow {
            against_stored: AtRest {
                lines: 100,
                criteria: vec![
                    Criterion::new(AtRestCriterion::Level, "dB", level_db, None, level),
                    Criterion::new(AtRestCriterion::Shape, "dB", shape_db, None, shape),
                ],
            },
            at_ms,
        };
        let earlier = [EarlierSession {
            session: "measurement",
            ended_ms: Some(NOW - 20 * HOUR),
        }];
        let known = Known {
            renderings: &drives,
            incomplete: &[],
            played: &BTreeMap::new(),
            earlier: &earlier,
            panels: &[],
            bench: Some(&on(kind, Some("P01"))),
            sensor: Some(&sensor),
            now_ms: NOW,
        };
        let found = not_ready(&protocol, &plan, known).into_iter();
        let found = found.filter(|one| one.stimulus().is_none());
        found.map(|one| one.to_string()).collect::<Vec<_>>()
    };
    let today = Some(NOW - HOUR);
    assert_eq!(said(0.5, 0.1, today, BenchKind::Twin), [""; 0]);
    assert_eq!(said(0.5, 0.1, None, BenchKind::Twin), [""; 0]);
    assert_eq!(
        said(6.02, 0.1, today, BenchKind::Twin),
        [
            "expected the level of the sensor relative to its stored response within ±1.5 dB, found +6.0 dB; set its amplifier back, or calibrate it and measure the stored response again"
        ]
    );
    assert_eq!(
        said(0.2, 3.0, today, BenchKind::Twin),
        [
            "expected the distance of the lines from that change of at most 1.0 dB, found +3.0 dB; take the finger off the device, fasten the sensor, and measure it again"
        ]
    );
    let old = said(0.5, 0.1, Some(NOW - 30 * HOUR), BenchKind::Twin);
    assert!(
        old.len() == 1 && old[0].contains("an age of 30.0 h"),
        "{old:?}"
    );
    let undated = said(0.5, 0.1, None, BenchKind::Hardware);
    assert!(
        undated.len() == 1 && undated[0].contains("without a date"),
        "{undated:?}"
    );
}

mod confusions;
