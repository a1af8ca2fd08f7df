//! EEG files that are written here, read back.
#![allow(
    clippy::unwrap_used,
    reason = "a test that fails where it cannot go on"
)]

use std::path::PathBuf;

use piezotact::quantity::{SampleRate, Seconds, Unit};
use piezotact::recording::{
    Channel, Clock, Condition, Event, EventValue, Provenance, Recording, StartTime,
};
use piezotact_dataset::eeg::{
    EegKind, EegMarker, markers_of, read_eeg, write_brainvision, write_edf,
};

fn recording(count: usize, rate_hz: f64) -> Recording {
    let channel = |name: &str, unit: Unit, size: f64| Channel {
        name: name.into(),
        unit,
        samples: (0..count)
            .map(|k| size * ((k as f64 * 0.37).sin() + 0.2))
            .collect(),
    };
    let channels = vec![
        channel("Cz", Unit::Volt, 80e-6),
        channel("small", Unit::Volt, 3e-8),
        channel("large", Unit::Volt, 2.5),
        channel("acc", Unit::MetrePerSecondSquared, 12.5),
        Channel {
            name: "flat".into(),
            unit: Unit::Volt,
            samples: vec![7e-6; count],
        },
    ];
    let mut recording = Recording::new(
        channels,
        SampleRate::new(rate_hz).unwrap(),
        Condition::default(),
        Provenance::default(),
    )
    .unwrap();
    let event = |sample: usize, kind: &str, value: Option<EventValue>, duration_s: f64| Event {
        onset_s: Seconds(sample as f64 / rate_hz),
        duration_s: Seconds(duration_s),
        kind: kind.into(),
        value,
    };
    recording.annotations.started_at =
        StartTime::try_from("2024-03-01T10:22:33.125".to_owned()).ok();
    recording.annotations.events = vec![
        event(0, "first", None, 0.0),
        event(
            count / 3,
            "Stimulus",
            Some(EventValue::Text("S  1".into())),
            0.0,
        ),
        event(count / 2, "touch µ", None, 0.25),
        event(count - 1, "Response", Some(EventValue::Number(3.0)), 0.0),
    ];
    recording
}

#[test]
fn edf_is_read_back_to_half_a_step() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.edf");
    for (count, rate_hz, added) in [
        (5000, 500.0, 0),
        (4096, 512.0, 0),
        (1001, 250.0, 0),
        (1009, 1000.0, 1),
        (3, 256.0, 1),
        (999, 1000.0 / 3.0, 0),
    ] {
        let written = recording(count, rate_hz);
        let warnings = write_edf(&path, &written).unwrap();
        let file = read_eeg(&path).unwrap();
        assert_eq!(file.kind, EegKind::EdfPlus);
        let part = &file.segments[0];
        let found = part.recording.len() - count;
        let added_to = warnings
            .iter()
            .filter(|warning| warning.to_string().contains("were added at the end"));
        assert_eq!(added_to.count(), usize::from(found > 0), "{warnings:?}");
        assert!(found <= added, "{count} {rate_hz}: {found} added");
        assert!((part.recording.rate().hz() - rate_hz).abs() < 1e-9 * rate_hz);
        assert_eq!(
            part.recording.annotations.started_at,
            written.annotations.started_at
        );
        for (read, own) in part.recording.channels().iter().zip(written.channels()) {
            assert_eq!((&read.name, &read.unit), (&own.name, &own.unit));
            let bounds = own
                .samples
                .iter()
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), v| {
                    (a.min(*v), b.max(*v))
                });
            // The range is rounded outwards to 8 characters.
            let step = match bounds.1 > bounds.0 {
                true => (bounds.1 - bounds.0) * 1.01 / 65_534.0,
                false => 2e-6 * 1.01 / 65_534.0,
            };
            for (a, b) in read.samples.iter().zip(&own.samples) {
                assert!(
                    (a - b).abs() <= step / 2.0 + 1e-12 * b.abs(),
                    "{}: {a} {b}",
                    own.name
                );
            }
        }
        let expected = [0, count / 3, count / 2, count - 1].map(|at| at as i64);
        assert_eq!(part.event_samples, expected);
        let kinds: Vec<&str> = part
            .recording
            .annotations
            .events
            .iter()
            .map(|e| e.kind.as_str())
            .collect();
        assert_eq!(kinds, ["first", "Stimulus/S  1", "touch µ", "Response/3"]);
        assert_eq!(part.recording.annotations.events[2].duration_s.0, 0.25);
    }
}

#[test]
fn edf_holds_channels_of_several_rates() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.edf");
    let channel = |name: &str, count: usize| Channel {
        name: name.into(),
        unit: Unit::Volt,
        samples: (0..count).map(|k| 1e-5 * (k as f64 * 0.2).cos()).collect(),
    };
    let clock = |hz: f64, start_s: f64| Clock {
        rate_hz: SampleRate::new(hz).unwrap(),
        start_s: Seconds(start_s),
    };
    let of = |start_s: f64, slow: usize| {
        let channels = vec![
            (channel("fast", 1000), clock(500.0, 0.0)),
            (channel("slow", slow), clock(50.0, start_s)),
        ];
        Recording::with_clocks(channels, Condition::default(), Provenance::default()).unwrap()
    };
    write_edf(&path, &of(0.0, 100)).unwrap();
    let read = read_eeg(&path).unwrap();
    let lengths: Vec<usize> = read.segments[0]
        .recording
        .channels()
        .iter()
        .map(|c| c.samples.len())
        .collect();
    assert_eq!(lengths, [1000, 100]);
    for (refused, part) in [
        (of(0.5, 100), "begin together"),
        (of(0.0, 60), "end together"),
    ] {
        let error = write_edf(&path, &refused).unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
}

#[test]
fn brainvision_is_read_back() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("sub-01_eeg.vhdr");
    let written = recording(997, 512.0);
    let mut markers = markers_of(&written);
    assert_eq!(markers.len(), 4);
    markers.push(EegMarker {
        kind: "Comment".into(),
        description: "a, b".into(),
        sample: 996,
        samples: 0,
    });
    for _ in 0..2 {
        write_brainvision(&path, &written, &markers).unwrap();
        let file = read_eeg(&path).unwrap();
        let part = &file.segments[0];
        assert_eq!(
            (file.segments.len(), part.recording.rate()),
            (1, written.rate())
        );
        assert_eq!(
            part.recording
                .annotations
                .started_at
                .as_ref()
                .unwrap()
                .to_string(),
            "2024-03-01T10:22:33.125000"
        );
        for (read, own) in part.recording.channels().iter().zip(written.channels()) {
            assert_eq!((&read.name, &read.unit), (&own.name, &own.unit));
            for (a, b) in read.samples.iter().zip(&own.samples) {
                assert!((a - b).abs() <= 6e-8 * b.abs(), "{a} {b}");
            }
        }
        assert_eq!(part.event_samples, [0, 0, 332, 498, 996, 996]);
        let last = part.recording.annotations.events.last().unwrap();
        assert_eq!(last.value, Some(EventValue::Text("a, b".into())));
        let names = std::fs::read_dir(folder.path()).unwrap().count();
        assert_eq!(names, 3);
    }
    for (refused, part) in [
        (
            write_brainvision(&folder.path().join("a.eeg"), &written, &[]),
            "ends with .vhdr",
        ),
        (
            write_brainvision(
                &path,
                &written,
                &[EegMarker {
                    kind: "S".into(),
                    description: String::new(),
                    sample: 997,
                    samples: 1,
                }],
            ),
            "samples 0 to 996",
        ),
    ] {
        let error = refused.unwrap_err().to_string();
        assert!(error.contains(part), "{error}");
    }
    // A refusal leaves the files as they were.
    assert!(read_eeg(&path).is_ok());
}

/// MNE, edfio and pybv's rules read what is written here: `WRITE_EEG_TO=FOLDER`, then `golden/eeg_files.py read FOLDER`.
#[test]
fn others_read_what_is_written() {
    let Some(folder) = std::env::var_os("WRITE_EEG_TO")
        .map(PathBuf::from)
        .filter(|f| f.is_dir())
    else {
        return;
    };
    let written = recording(4096, 512.0);
    write_edf(&folder.join("written.edf"), &written).unwrap();
    write_brainvision(
        &folder.join("written.vhdr"),
        &written,
        &markers_of(&written),
    )
    .unwrap();
    let samples: Vec<&[f64]> = written
        .channels()
        .iter()
        .map(|c| c.samples.as_slice())
        .collect();
    let events: Vec<(usize, &str)> = vec![
        (0, "first"),
        (1365, "Stimulus/S  1"),
        (2048, "touch µ"),
        (4095, "Response/3"),
    ];
    let json = serde_json::json!({"samples": samples, "events": events});
    std::fs::write(folder.join("written.json"), json.to_string()).unwrap();
}
