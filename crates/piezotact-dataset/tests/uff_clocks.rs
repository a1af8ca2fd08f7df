//! Universal files whose channels have clocks of their own, and the start that their date lines say.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use crate::shared_data;
use std::path::{Path, PathBuf};

use piezotact::quantity::{SampleRate, Seconds, Unit};
use piezotact::recording::{Channel, Clock, Condition, Provenance, Recording};
use piezotact_dataset::uff::write_uff_recording;
use piezotact_dataset::{Contents, ReadOptions, read_recording};

fn measured(name: &str) -> Option<PathBuf> {
    shared_data::shared(&format!("data/frf/uff/{name}"))
}

fn recording(path: &Path) -> Contents {
    read_recording(path, &ReadOptions::default()).unwrap()
}

/// A small file of channels of two clocks.
pub(crate) fn small() -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("two.uff");
    write_uff_recording(&path, &of_two_clocks()).unwrap();
    std::fs::read(&path).unwrap()
}

fn of_two_clocks() -> Recording {
    let channel = |name: &str, count: usize| Channel {
        name: name.into(),
        unit: Unit::Newton,
        samples: (0..count).map(|k| k as f64).collect(),
    };
    let clock = |hz: f64, start_s: f64| Clock {
        rate_hz: SampleRate::new(hz).unwrap(),
        start_s: Seconds(start_s),
    };
    Recording::with_clocks(
        vec![
            (channel("fast", 400), clock(1000.0, 0.0)),
            (channel("slow", 30), clock(100.0, 0.125)),
            (channel("fast too", 400), clock(1000.0, 0.0)),
        ],
        Condition::default(),
        Provenance::default(),
    )
    .unwrap()
}

/// Two clocks go out and come in again, with their starts; the date line of a file of others is the start.
#[test]
fn channels_of_two_clocks_come_back() {
    let written = of_two_clocks();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("two.uff");
    write_uff_recording(&path, &written).unwrap();
    let read = recording(&path).recording;
    assert_eq!(read.clocks(), written.clocks());
    assert_eq!(read.channels(), written.channels());
    assert_eq!(read.annotations.started_at, None);

    let text = std::fs::read_to_string(&path).unwrap();
    for (date, expected) in [
        ("13-Apr-23 09:57:51", Some("2023-04-13T09:57:51")),
        ("01-MAR-1998 23:00:01", Some("1998-03-01T23:00:01")),
        ("05-Mar-88 10:22:33", Some("1988-03-05T10:22:33")),
        ("yesterday", None),
        ("31-Foo-24 10:00:00", None),
        ("05-Mar-24", None),
    ] {
        // The third line of free text is by custom the date.
        let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
        lines[4] = format!("{date:80}");
        std::fs::write(&path, lines.join("\n") + "\n").unwrap();
        let read = recording(&path).recording;
        let started = read.annotations.started_at.map(|start| start.to_string());
        assert_eq!(started.as_deref(), expected, "{date}");
    }
}

/// A measured file with a date line.
#[test]
fn the_date_of_a_measured_file_is_its_start() {
    let Some(path) = measured("Sample_UFF58_ascii.uff") else {
        return;
    };
    let started = recording(&path).recording.annotations.started_at;
    // Its date line is `18-Apr-16 13:49:58`.
    let started = started.map(|start| start.to_string());
    assert_eq!(started.as_deref(), Some("2016-04-18T13:49:58"));
}
