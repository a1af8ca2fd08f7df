use super::*;
use crate::eeg::epochs::EpochsError;
use crate::eeg::source::StatedChannel;
use crate::eeg::warning::code_and_cause;
use piezotact::quantity::{Seconds, Unit};
use piezotact::recording::{Channel, Condition, Event, EventValue, Provenance, Recording};

const RATE_HZ: f64 = 100.0;

/// A recording of `seconds` with alpha of two phases, and a force channel.
fn recording(seconds: usize, events: &[(f64, &str, &str)]) -> (Recording, Vec<i64>) {
    let samples = seconds * 100;
    let wave = |phase: f64| {
        (0..samples)
            .map(|i| 1e-5 * (i as f64 * 0.6 + phase).sin() + 1e-6 * (i as f64 * 0.071).cos())
            .collect::<Vec<f64>>()
    };
    let channel = |name: &str, unit: Unit, samples: Vec<f64>| Channel {
        name: name.into(),
        unit,
        samples,
    };
    let channels = vec![
        channel("C3", Unit::Volt, wave(0.0)),
        channel("C4", Unit::Volt, wave(1.0)),
        channel("VEOG", Unit::Volt, wave(2.5)),
        channel("force", Unit::parse("N").0, wave(0.3)),
    ];
    let rate = SampleRate::new(RATE_HZ).unwrap();
    let mut found =
        Recording::new(channels, rate, Condition::default(), Provenance::default()).unwrap();
    found.annotations.events = events
        .iter()
        .map(|(onset_s, kind, value)| Event {
            onset_s: Seconds(*onset_s),
            duration_s: Seconds(0.0),
            kind: (*kind).into(),
            value: Some(EventValue::Text((*value).into())),
        })
        .collect();
    let at = events
        .iter()
        .map(|(s, _, _)| (s * RATE_HZ) as i64)
        .collect();
    (found, at)
}

pub(super) fn config(markers: &[(&str, &str)]) -> PrepareConfig {
    PrepareConfig {
        markers: markers
            .iter()
            .map(|(marker, condition)| MarkerChoice {
                marker: (*marker).into(),
                condition: (*condition).into(),
            })
            .collect(),
        task: None,
        extent: CutConfig {
            start_s: -0.5,
            end_s: 1.0,
        },
        channels: ChannelChoice::AllBut(Vec::new()),
        filters: Vec::new(),
        eog: Vec::new(),
        interpolated: Vec::new(),
        reference: Reference::AsRecorded,
        criteria: Vec::new(),
        min_epochs: 1,
    }
}

/// Two parts of 10 s with a gap of 5 s, surfaces S1 and S2.
fn parts() -> [(Recording, Vec<i64>); 2] {
    [
        recording(
            10,
            &[
                (2.0, "Stimulus", "S  1"),
                (4.0, "Stimulus", "S  2"),
                (9.5, "Stimulus", "S  1"),
            ],
        ),
        recording(10, &[(3.0, "Stimulus", "S  2"), (5.0, "Stimulus", "S  1")]),
    ]
}

fn segments(parts: &[(Recording, Vec<i64>)]) -> Vec<Segment<'_>> {
    let each = parts.iter().enumerate();
    each.map(|(i, (recording, samples))| Segment {
        recording,
        start_s: Seconds(15.0 * i as f64),
        event_samples: samples,
        stated: &[],
    })
    .collect()
}

#[test]
fn epochs_of_parts_are_counted_and_none_crosses_a_gap() {
    let parts = parts();
    let found = prepare(
        &segments(&parts),
        &config(&[("S 1", "flat"), ("S 2", "M8")]),
    )
    .unwrap();
    assert_eq!(found.epochs.channels(), ["C3", "C4"]);
    assert_eq!(found.epochs.conditions(), ["flat", "M8", "M8", "flat"]);
    let counts = &found.counts.conditions;
    assert_eq!(
        (counts[0].markers, counts[0].kept, counts[0].left_out),
        (3, 2, 1)
    );
    let left = &found.counts.not_whole[0];
    assert_eq!((left.onset_s, left.condition.as_str()), (9.5, "flat"));
    // A marker in the gap begins no epoch of the part behind it.
    let mut with_gap = parts.clone();
    let (recording, samples) = &mut with_gap[0];
    let event = Event {
        onset_s: Seconds(12.0),
        ..recording.annotations.events[0].clone()
    };
    recording.annotations.events.push(event);
    samples.push(1200);
    let gap = prepare(
        &segments(&with_gap),
        &config(&[("S 1", "flat"), ("S 2", "M8")]),
    )
    .unwrap();
    assert_eq!(gap.epochs.conditions(), found.epochs.conditions());
    let count = &gap.counts.conditions[0];
    assert_eq!((count.markers, count.kept, count.left_out), (4, 2, 2));
    assert_eq!(
        (
            gap.counts.not_whole[1].onset_s,
            gap.counts.not_whole[1].reason.clone()
        ),
        (12.0, NotCut::AfterEnd)
    );
    // A kind alone: its values are the conditions.
    let by_value = prepare(&segments(&parts), &config(&[("Stimulus", "Stimulus")])).unwrap();
    assert_eq!(by_value.epochs.conditions(), ["S 1", "S 2", "S 2", "S 1"]);
    let named = |count: &ConditionCount| (count.condition.clone(), count.kept);
    let counts_by_value: Vec<_> = by_value.counts.conditions.iter().map(named).collect();
    assert_eq!(
        counts_by_value,
        [("S 1".to_owned(), 2), ("S 2".to_owned(), 2)]
    );
    // The third epoch is 3 s after the start of the second part.
    assert_eq!(
        found.epochs.signal(0, 2)[0],
        parts[1].0.channels()[0].samples[250]
    );
}

#[test]
fn steps_follow_each_other() {
    let parts = parts();
    let asked = PrepareConfig {
        filters: vec![Pass::Below(30.0)],
        eog: vec!["VEOG".into()],
        reference: Reference::Average,
        criteria: vec![Criterion::PeakToPeak { above_v: 1e-4 }],
        ..config(&[("Stimulus", "touch")])
    };
    let found = prepare(&segments(&parts), &asked).unwrap();
    assert_eq!(found.counts.conditions[0].kept, 4);
    let sum: f64 = (0..2)
        .map(|channel| found.epochs.signal(channel, 1)[7])
        .sum();
    assert!(sum.abs() < 1e-15);
    let strict = PrepareConfig {
        eog: Vec::new(),
        reference: Reference::AsRecorded,
        criteria: vec![Criterion::PeakToPeak { above_v: 1e-7 }],
        ..asked
    };
    let error = prepare(&segments(&parts), &strict).unwrap_err();
    assert!(
        matches!(error, PrepareError::Epochs(EpochsError::AllRejected { .. })),
        "{error}"
    );
}

#[test]
fn bad_input_is_named() {
    let all = parts();
    let segments = segments(&all);
    let check = |config: &PrepareConfig, parts: &[&str]| {
        let text = prepare(&segments, config).unwrap_err().to_string();
        for part in parts {
            assert!(text.contains(part), "expected `{part}` in: {text}");
        }
    };
    check(&config(&[]), &["Stimulus/S 1 (3), Stimulus/S 2 (2)"]);
    check(&config(&[("S 3", "x")]), &["`S 3`", "Stimulus/S 1 (3)"]);
    let few = PrepareConfig {
        min_epochs: 3,
        ..config(&[("S 1", "flat")])
    };
    check(
        &few,
        &["at least 3 epochs of flat, found 2 (0 rejected, 1 not whole; of the first"],
    );
    let renamed = PrepareConfig {
        channels: ChannelChoice::Named(vec!["Cz".into()]),
        ..config(&[("S 1", "flat")])
    };
    check(&renamed, &["expected the channel `Cz`, found C3, C4"]);
    let other = PrepareConfig {
        channels: ChannelChoice::Named(vec!["C3".into()]),
        eog: vec!["HEOG".into()],
        ..config(&[("S 1", "flat")])
    };
    check(&other, &["expected the channel `HEOG`"]);
}

#[test]
fn flat_and_saturated_channels_are_refused() {
    let (good, samples) = recording(10, &[(2.0, "touch", "S1")]);
    let with = |change: &dyn Fn(f64) -> f64| {
        let mut channels = good.channels().to_vec();
        channels[1].samples = channels[1].samples.iter().map(|v| change(*v)).collect();
        let rate = SampleRate::new(RATE_HZ).unwrap();
        let mut made =
            Recording::new(channels, rate, Condition::default(), Provenance::default()).unwrap();
        made.annotations = good.annotations.clone();
        made
    };
    let refused = |recording: &Recording| {
        let segment = Segment {
            recording,
            start_s: Seconds(0.0),
            event_samples: &samples,
            stated: &[],
        };
        prepare(&[segment], &config(&[("touch", "S1")])).unwrap_err()
    };
    assert!(
        matches!(refused(&with(&|_| 0.0)), PrepareError::Flat { channels } if channels == "C4")
    );
    let limited = refused(&with(&|v| v.min(8e-6)));
    assert!(
        matches!(&limited, PrepareError::Saturated { channel, .. } if channel == "C4"),
        "{limited}"
    );
}

#[test]
fn epochs_of_one_task_are_taken() {
    let (both, samples) = recording(
        20,
        &[
            (0.0, "task", "control"),
            (2.0, "touch", "S1"),
            (10.0, "task", "imagery"),
            (12.0, "touch", "S1"),
            (14.0, "touch", "S1"),
            (15.0, "touch", "S2"),
        ],
    );
    let segment = [Segment {
        recording: &both,
        start_s: Seconds(0.0),
        event_samples: &samples,
        stated: &[],
    }];
    let of = |task: Option<&str>, marker: &str| PrepareConfig {
        task: task.map(Into::into),
        ..config(&[(marker, "S1")])
    };
    let error = prepare(&segment, &of(None, "S1")).unwrap_err();
    assert!(matches!(error, PrepareError::SeveralTasks { tasks } if tasks == "control, imagery"));
    for (task, count) in [("control", 1), ("imagery", 2)] {
        let found = prepare(&segment, &of(Some(task), "S1")).unwrap();
        assert_eq!((found.epochs.count(), found.task.as_str()), (count, task));
    }
    assert!(matches!(
        prepare(&segment, &of(Some("natural"), "S1")),
        Err(PrepareError::OtherTask { .. })
    ));
    assert!(matches!(
        prepare(&segment, &of(Some("control"), "S2")),
        Err(PrepareError::NoMarkerInTask { .. })
    ));
}

#[test]
fn an_electrode_that_is_off_for_a_while_loses_these_epochs_alone() {
    let events: Vec<(f64, &str, &str)> = (1..=8)
        .map(|i| (2.0 * f64::from(i), "touch", "S1"))
        .collect();
    let (recording, samples) = recording(20, &events);
    let mut channels = recording.channels().to_vec();
    // C4 is off from 7 s to 11 s.
    channels[1].samples[700..1100].fill(3e-6);
    let mut made = Recording::new(
        channels,
        SampleRate::new(RATE_HZ).unwrap(),
        Condition::default(),
        Provenance::default(),
    )
    .unwrap();
    made.annotations = recording.annotations.clone();
    let segment = Segment {
        recording: &made,
        start_s: Seconds(0.0),
        event_samples: &samples,
        stated: &[],
    };
    let found = prepare(&[segment], &config(&[("touch", "S1")])).unwrap();
    let lost: Vec<f64> = found
        .counts
        .not_whole
        .iter()
        .map(|one| one.onset_s)
        .collect();
    assert_eq!(lost, [6.0, 8.0, 10.0]);
    let reason = &found.counts.not_whole[0].reason;
    assert_eq!(reason.to_string(), "C4 holds one value within it");
    assert_eq!(
        (found.epochs.count(), found.counts.conditions[0].left_out),
        (5, 3)
    );
    assert_eq!(found.onsets_s, [2.0, 4.0, 12.0, 14.0, 16.0]);
    let without = PrepareConfig {
        channels: ChannelChoice::AllBut(vec!["C4".into()]),
        ..config(&[("touch", "S1")])
    };
    assert_eq!(prepare(&[segment], &without).unwrap().epochs.count(), 8);
}

#[test]
fn an_electrode_that_loses_its_contact_is_named() {
    let events: Vec<(f64, &str, &str)> = (1..=8)
        .map(|i| (2.0 * f64::from(i), "touch", "S1"))
        .collect();
    let (recording, samples) = recording(20, &events);
    // C4 records the noise of its amplifier at these samples.
    let prepared = |is_off: &dyn Fn(usize) -> bool| {
        let mut channels = recording.channels().to_vec();
        let own = channels[1].samples.iter_mut().enumerate();
        for (i, value) in own.filter(|(i, _)| is_off(*i)) {
            *value = 2e-8 * ((i * 7919 % 13) as f64 - 6.0);
        }
        let rate = SampleRate::new(RATE_HZ).unwrap();
        let about = (Condition::default(), Provenance::default());
        let mut made = Recording::new(channels, rate, about.0, about.1).unwrap();
        made.annotations = recording.annotations.clone();
        let segment = Segment {
            recording: &made,
            start_s: Seconds(0.0),
            event_samples: &samples,
            stated: &[],
        };
        prepare(&[segment], &config(&[("touch", "S1")]))
    };
    // At each touch: no epoch is left, and why is said.
    let said = prepared(&|i| i % 200 < 80).unwrap_err().to_string();
    assert!(said.contains("C4 is off within it"), "{said}");
    // In the last 40 %.
    let found = prepared(&|i| i >= 1200).unwrap();
    assert_eq!(found.onsets_s, [2.0, 4.0, 6.0, 8.0, 10.0]);
    let said: Vec<String> = found.warnings.iter().map(ToString::to_string).collect();
    assert!(
        said.iter()
            .any(|one| one.starts_with("C4: off in 3 of 8 epochs")),
        "{said:?}"
    );
    let clean = prepared(&|_| false).unwrap();
    assert_eq!(clean.onsets_s.len(), 8);
    let said: Vec<String> = clean.warnings.iter().map(ToString::to_string).collect();
    assert!(!said.iter().any(|one| one.contains("off in")), "{said:?}");
}

#[test]
fn what_the_table_beside_the_file_states_is_used() {
    let mut events: Vec<(f64, &str, &str)> = (1..=4)
        .map(|i| (2.0 * f64::from(i), "touch", "S1"))
        .collect();
    // The same marker again.
    events.push(events[0]);
    let (recording, samples) = recording(12, &events);
    let stated = [
        StatedChannel::of_bids("C3", Some("EEG"), Some("good")),
        StatedChannel::of_bids("C4", Some("EEG"), Some("bad")),
        StatedChannel::of_bids("VEOG", Some("EEG"), None),
    ];
    let segment = Segment {
        recording: &recording,
        start_s: Seconds(0.0),
        event_samples: &samples,
        stated: &stated,
    };
    let asked = config(&[("touch", "S1")]);
    let found = prepare(&[segment], &asked).unwrap();
    assert_eq!(found.epochs.channels(), ["C3", "VEOG"]);
    let codes: Vec<String> = found.warnings.iter().map(code_and_cause).collect();
    assert_eq!(
        codes,
        ["eeg_markers/twice", "eeg_electrodes_left_out/called_bad"]
    );
    assert_eq!(found.epochs.count(), 4);
    let named = PrepareConfig {
        channels: ChannelChoice::Named(["C3", "C4"].map(String::from).to_vec()),
        ..asked.clone()
    };
    let warnings = prepare(&[segment], &named).unwrap().warnings;
    assert!(
        warnings
            .iter()
            .any(|warning| code_and_cause(warning) == "eeg_electrodes_doubtful/called_bad"),
        "{warnings:?}"
    );
    // Without the table VEOG is no electrode, and no part of the mean of all.
    let plain = Segment {
        stated: &[],
        ..segment
    };
    let mixed = PrepareConfig {
        channels: ChannelChoice::Named(["C3", "VEOG"].map(String::from).to_vec()),
        reference: Reference::Average,
        ..asked.clone()
    };
    let said = prepare(&[plain], &mixed).unwrap_err().to_string();
    assert!(said.contains("VEOG records EOG"), "{said}");
    // An electrode that all others are referred to would be 0.
    let to_one = PrepareConfig {
        reference: Reference::Channels(vec!["C4".into()]),
        ..asked
    };
    assert_eq!(
        prepare(&[plain], &to_one).unwrap().epochs.channels(),
        ["C3"]
    );
}

#[test]
fn a_part_that_is_called_bad_is_in_no_epoch() {
    let events: Vec<(f64, &str, &str)> = (1..=8)
        .map(|i| (2.0 * f64::from(i), "touch", "S1"))
        .chain([(7.2, "BAD_movement", "")])
        .collect();
    let (mut recording, samples) = recording(20, &events);
    let last = recording.annotations.events.last_mut().unwrap();
    last.duration_s = Seconds(3.0);
    last.value = None;
    let segment = Segment {
        recording: &recording,
        start_s: Seconds(0.0),
        event_samples: &samples,
        stated: &[],
    };
    let found = prepare(&[segment], &config(&[("touch", "S1")])).unwrap();
    let lost: Vec<(f64, String)> = found
        .counts
        .not_whole
        .iter()
        .map(|one| (one.onset_s, one.reason.to_string()))
        .collect();
    let why = "BAD_movement calls a part of it bad".to_owned();
    assert_eq!(lost, [(8.0, why.clone()), (10.0, why)]);
    // Longer than any recording: no number is too large.
    recording.annotations.events.last_mut().unwrap().duration_s = Seconds(1e300);
    let endless = Segment {
        recording: &recording,
        start_s: Seconds(0.0),
        event_samples: &samples,
        stated: &[],
    };
    let found = prepare(&[endless], &config(&[("touch", "S1")])).unwrap();
    assert_eq!(found.epochs.count(), 3);
    // All of it: the reason is said, not that there is no event.
    recording.annotations.events.last_mut().unwrap().duration_s = Seconds(60.0);
    recording.annotations.events.last_mut().unwrap().onset_s = Seconds(0.0);
    let samples: Vec<i64> = samples
        .iter()
        .map(|at| if *at == 720 { 0 } else { *at })
        .collect();
    let segment = Segment {
        recording: &recording,
        start_s: Seconds(0.0),
        event_samples: &samples,
        stated: &[],
    };
    let said = prepare(&[segment], &config(&[("touch", "S1")]))
        .unwrap_err()
        .to_string();
    assert!(
        said.contains("without unusable parts (the first: BAD_movement"),
        "{said}"
    );
}

/// EDF has been written with the unit `.V`.
#[test]
fn electrodes_in_an_unknown_unit_are_named_with_it() {
    let [(first, samples), _] = parts();
    let with = |units: [&str; 2]| {
        let mut channels = first.channels().to_vec();
        for (channel, unit) in channels.iter_mut().zip(units) {
            channel.unit = Unit::parse(unit).0;
        }
        let mut made = Recording::new(
            channels,
            first.rate(),
            Condition::default(),
            Provenance::default(),
        )
        .unwrap();
        made.annotations = first.annotations.clone();
        let segment = Segment {
            recording: &made,
            start_s: Seconds(0.0),
            event_samples: &samples,
            stated: &[],
        };
        prepare(&[segment], &config(&[("S 1", "S1"), ("S 2", "S2")]))
    };
    let said = with([".V", ".V"]).unwrap_err().to_string();
    assert!(said.contains("C3, C4 are in `.V`"), "{said}");
    let found = with([".V", "V"]).unwrap();
    assert_eq!(found.epochs.channels(), ["C4"]);
    let said = found
        .warnings
        .iter()
        .map(ToString::to_string)
        .collect::<String>();
    assert!(
        said.contains("C3: left out, as their unit `.V` is none of a potential"),
        "{said}"
    );
    assert!(
        with(["V", "V"])
            .unwrap()
            .warnings
            .iter()
            .all(|one| one.code != "eeg_electrodes_left_out")
    );
}

#[test]
fn a_high_pass_above_the_low_pass_is_refused() {
    let [(first, samples), _] = parts();
    let segment = Segment {
        recording: &first,
        start_s: Seconds(0.0),
        event_samples: &samples,
        stated: &[],
    };
    let with = |filters: Vec<Pass>| {
        let asked = PrepareConfig {
            filters,
            ..config(&[("S 1", "S1"), ("S 2", "S2")])
        };
        prepare(&[segment], &asked)
    };
    let filters = vec![Pass::Above(30.0), Pass::Below(10.0)];
    let said = with(filters).unwrap_err().to_string();
    assert!(
        said.contains("at 30 Hz is not below the low-pass filter at 10 Hz"),
        "{said}"
    );
    assert!(with(vec![Pass::Above(2.0), Pass::Below(30.0)]).is_ok());
    let names = ["C3", "VEOG"].map(str::to_owned);
    let [among, others] = segment.no_electrodes(&names);
    assert_eq!(
        (among, others),
        (
            vec!["VEOG (EOG)".to_owned()],
            vec!["force (other)".to_owned()]
        )
    );
}

#[test]
fn samples_that_are_no_numbers_lose_their_epochs_alone() {
    let events: Vec<(f64, &str, &str)> = (1..=6)
        .map(|i| (2.0 * f64::from(i), "touch", "S1"))
        .collect();
    let (recording, samples) = recording(16, &events);
    let mut channels = recording.channels().to_vec();
    channels[0].samples[605] = f64::NAN;
    let rate = SampleRate::new(RATE_HZ).unwrap();
    let mut made =
        Recording::new(channels, rate, Condition::default(), Provenance::default()).unwrap();
    made.annotations = recording.annotations.clone();
    let segment = Segment {
        recording: &made,
        start_s: Seconds(0.0),
        event_samples: &samples,
        stated: &[],
    };
    let asked = PrepareConfig {
        filters: vec![Pass::Above(2.0)],
        ..config(&[("touch", "S1")])
    };
    let found = prepare(&[segment], &asked).unwrap();
    let lost: Vec<String> = found
        .counts
        .not_whole
        .iter()
        .map(|one| one.reason.to_string())
        .collect();
    assert_eq!(lost, ["C3 has samples that are no numbers within it"]);
    assert_eq!(found.epochs.count(), 5);
}
