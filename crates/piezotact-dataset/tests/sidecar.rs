//! What stands beside a WAV file: believed of the samples that it was written for, and refused with what to do.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact::recording::{
    About, BrokenPlayback, Channel, Condition, Losses, MissingChannel, Provenance, Recording,
    RecordingWarning, Stated,
};
use std::path::Path;

use piezotact::Warning;
use piezotact::quantity::{SampleRate, Unit};
use piezotact_dataset::sidecar::{Sidecar, sidecar_path};
use piezotact_dataset::wav::{SampleFormat, write_wav, write_wav_with_sidecar};
use piezotact_dataset::{ReadOptions, read_recording, write_recording};

fn of_scale(value: f64) -> Sidecar {
    Sidecar {
        full_scale: Some(format!("{value} m/s2").parse().unwrap()),
        ..Sidecar::default()
    }
}

fn refused(path: &Path, parts: &[&str]) {
    let error = read_recording(path, &ReadOptions::default())
        .unwrap_err()
        .to_string();
    for part in parts {
        assert!(error.contains(part), "no `{part}` in {error}");
    }
}

/// The sidecar takes its place first: killed before the samples do, the old ones stand beside a new scale.
#[test]
fn a_scale_beside_other_samples_is_not_believed() {
    let folder = tempfile::tempdir().unwrap();
    let [old, new] = ["a.wav", "b.wav"].map(|name| folder.path().join(name));
    for format in [SampleFormat::Pcm24, SampleFormat::Float32] {
        for (path, scale) in [(&old, 10.0), (&new, 200.0)] {
            let samples: Vec<f64> = (0..77_777).map(|i| (f64::from(i) / scale).sin()).collect();
            write_wav_with_sidecar(path, &[&samples], 5_000, format, &of_scale(scale)).unwrap();
            read_recording(path, &ReadOptions::default()).unwrap();
        }
        std::fs::copy(sidecar_path(&new), sidecar_path(&old)).unwrap();
        refused(
            &old,
            &[
                "a.wav",
                "the samples that",
                "interrupted",
                "write the file again",
                "remove `samples`",
            ],
        );
    }
    // An older sidecar, or one of a person, has no fingerprint.
    std::fs::write(sidecar_path(&old), r#"{"full_scale": "3 m/s2"}"#).unwrap();
    read_recording(&old, &ReadOptions::default()).unwrap();
}

#[test]
fn warnings_about_samples_are_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.wav");
    let samples: Vec<f64> = (0..500).map(|i| f64::from(i).sin()).collect();
    let mut sidecar = of_scale(2.0);
    sidecar.about.warnings = vec![Warning::from(RecordingWarning::ChannelMissing {
        what: MissingChannel::Cutting,
    })];
    write_wav_with_sidecar(&path, &[&samples], 5_000, SampleFormat::Float32, &sidecar).unwrap();
    let rate = SampleRate::new(1_000.0).ok();
    let read = read_recording(
        &path,
        &ReadOptions {
            scale: None,
            rate,
            ..ReadOptions::default()
        },
    )
    .unwrap();
    let expected = [
        Warning::from(RecordingWarning::ChannelMissing {
            what: MissingChannel::Cutting,
        }),
        Warning::from(RecordingWarning::StatedDiffers {
            what: Stated::RateKept {
                stated_hz: 1_000.0,
                found_hz: 5_000.0,
            },
        }),
    ];
    assert_eq!(read.recording.about.warnings, expected);
}

#[test]
fn what_is_no_sidecar_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.wav");
    write_wav(&path, &[&[0.5, -0.5, 0.1]], 5_000, SampleFormat::Float32).unwrap();
    for (text, parts) in [
        ("[]", &["a sidecar such as", "a list"][..]),
        (r#"{"channels": []}"#, &["1 name(s)", "found 0"]),
        (
            r#"{"channels": ["a", "b"]}"#,
            &["1 name(s)", "found 2", "correct `channels`"],
        ),
    ] {
        std::fs::write(sidecar_path(&path), text).unwrap();
        refused(&path, parts);
    }
    std::fs::write(sidecar_path(&path), r#"{"channels": ["a"]}"#).unwrap();
    read_recording(&path, &ReadOptions::default()).unwrap();
}

#[test]
fn labels_events_and_a_start_come_back_and_are_absent_when_empty() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.wav");
    let mut sidecar = of_scale(2.0);
    let write = |sidecar: &Sidecar| {
        write_wav_with_sidecar(&path, &[&[0.5; 8]], 5_000, SampleFormat::Float32, sidecar).unwrap();
        std::fs::read_to_string(sidecar_path(&path)).unwrap()
    };
    let text = write(&sidecar);
    for name in ["started_at", "labels", "events"] {
        assert!(!text.contains(name), "{text}");
    }
    sidecar.annotations = serde_json::from_str(
        r#"{"started_at": "2024-03-01T10:22:33Z", "labels": {"session": "2"},
            "events": [{"onset_s": 0.5, "duration_s": 0.0, "kind": "answer", "value": "rough"}]}"#,
    )
    .unwrap();
    write(&sidecar);
    let read = read_recording(&path, &ReadOptions::default()).unwrap();
    assert_eq!(read.recording.annotations, sidecar.annotations);
    let wrong = std::fs::read_to_string(sidecar_path(&path)).unwrap();
    let wrong = wrong.replace("2024-03-01T10:22:33Z", "at noon");
    std::fs::write(sidecar_path(&path), wrong).unwrap();
    refused(&path, &["expected a date and time", "`at noon`"]);
}

/// What a person writes wrongly is named by its entry, with how it is written; what nothing reads is a warning.
#[test]
fn entries_that_people_write_wrongly_are_named() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.wav");
    write_wav(&path, &[&[0.5; 5000]], 5_000, SampleFormat::Float32).unwrap();
    for (text, parts) in [
        (
            r#"{"full_scale": 3}"#,
            &["`full_scale` as in", "found 3"][..],
        ),
        (
            r#"{"full_scale": {"value": 3}}"#,
            &["`full_scale` as in", r#"{"value":3}"#],
        ),
        (
            r#"{"labels": {"session": 2}}"#,
            &["`labels` as in", r#"{"session":2}"#],
        ),
        (r#"{"units": ["N"]}"#, &["`units` as in", r#""fz": "2 N""#]),
        (
            r#"{"channels": "acc"}"#,
            &["`channels` as in", r#"["acc", "fz"]"#],
        ),
        (
            r#"{"condition": {"load_n": "0.4 N"}}"#,
            &["`condition.load_n` as in", r#"found "0.4 N""#],
        ),
        (
            r#"{"condition": {"touch": "sliding"}}"#,
            &["`condition.touch`", "passive"],
        ),
        (
            r#"{"condition": "S4"}"#,
            &["`condition` as in", r#""sample": "S4""#],
        ),
        (
            r#"{"events": {"onset_s": 1}}"#,
            &["`events` as in", r#"[{"onset_s": 1.2"#],
        ),
        (
            r#"{"events": [{"onset_s": 1, "kind": "a"}]}"#,
            &[
                "event 1 as in",
                "none called `duration_s`",
                r#""kind": "answer"}"#,
            ],
        ),
        (
            r#"{"events": [{"onset_s": "1", "duration_s": 0, "kind": "a"}]}"#,
            &["event 1 as in", r#"`onset_s`: "1""#],
        ),
        ("{\n\"labels\": {,}}", &["not JSON", "line 2"]),
        ("3", &["a sidecar such as", "found 3"]),
    ] {
        std::fs::write(sidecar_path(&path), text).unwrap();
        refused(&path, parts);
        let error = read_recording(&path, &ReadOptions::default())
            .unwrap_err()
            .to_string();
        for word in ["untagged", "variant", "invalid type", "missing field"] {
            assert!(!error.contains(word), "{error}");
        }
    }
    let warnings = |text: &str| {
        std::fs::write(sidecar_path(&path), text).unwrap();
        let read = read_recording(&path, &ReadOptions::default()).unwrap();
        let warnings = read
            .recording
            .about
            .warnings
            .iter()
            .map(ToString::to_string);
        warnings.collect::<Vec<_>>().join("; ")
    };
    let said = warnings(
        r#"{"full_scale": "3 g", "ful_scale": 1, "condition": {"smaple": "S4", "labels": {}}, "events": [{"onset_s": 0.5, "duration_s": 0, "kind": "a", "note": 1}]}"#,
    );
    for part in [
        "`ful_scale`",
        "`condition.smaple`",
        "`condition.labels`",
        "`events[0].note`",
    ] {
        assert!(said.contains(part), "{said}");
    }
    let event = |onset_s: f64, duration_s: f64| {
        warnings(&format!(
            r#"{{"full_scale": "3 g", "events": [{{"onset_s": {onset_s}, "duration_s": {duration_s}, "kind": "a"}}]}}"#
        ))
    };
    assert_eq!([event(0.0, 1.0), event(1.0, 0.0)], ["", ""]);
    for (onset_s, duration_s) in [(-0.5, 0.0), (1.5, 0.0), (0.5, 1.0), (0.5, -0.1)] {
        let said = event(onset_s, duration_s);
        assert!(
            said.contains("1 event(s) are outside") && said.contains(&onset_s.to_string()),
            "{said}"
        );
    }
}

/// A channel may have a unit of its own: force beside acceleration in one file.
#[test]
fn channels_have_units_of_their_own() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.wav");
    write_wav(
        &path,
        &[&[0.5; 50], &[0.25; 50]],
        5_000,
        SampleFormat::Float32,
    )
    .unwrap();
    let text = r#"{"full_scale": "3 m/s2", "channels": ["acc", "fz"], "units": {"fz": "2 N"}}"#;
    std::fs::write(sidecar_path(&path), text).unwrap();
    let r = read_recording(&path, &ReadOptions::default())
        .unwrap()
        .recording;
    assert_eq!(r.about.warnings, []);
    let peak = |i: usize| (r.channels()[i].samples[0], r.channels()[i].unit.to_string());
    assert_eq!(
        [peak(0), peak(1)],
        [(1.5, "m/s²".into()), (0.5, "N".into())]
    );
}

/// A factor that is none is refused, and not taken for the name of a unit.
#[test]
fn a_unit_with_an_impossible_value_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.wav");
    write_wav(&path, &[&[0.5; 50]], 5_000, SampleFormat::Float32).unwrap();
    for unit in ["-2 N", "0 N", "1e400 N", "nan N", "0,5 N", "-2N"] {
        let text = format!(r#"{{"channels": ["fz"], "units": {{"fz": "{unit}"}}}}"#);
        std::fs::write(sidecar_path(&path), text).unwrap();
        let said = read_recording(&path, &ReadOptions::default()).unwrap_err();
        let said = said.to_string();
        assert!(said.contains("above zero") && said.contains(unit), "{said}");
    }
}

/// The sidecar that the guide shows is read whole.
#[test]
fn the_sidecar_of_the_guide_is_read() {
    let guide = include_str!("../../../docs/guide/files.md");
    let mut examples = guide
        .split("```json")
        .skip(1)
        .filter_map(|rest| rest.split("```").next());
    let example = examples.find(|text| text.contains("full_scale")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.wav");
    write_wav(
        &path,
        &[&[0.5; 8000], &[0.25; 8000]],
        5_000,
        SampleFormat::Float32,
    )
    .unwrap();
    std::fs::write(sidecar_path(&path), example).unwrap();
    let r = read_recording(&path, &ReadOptions::default())
        .unwrap()
        .recording;
    assert_eq!(r.about.warnings, []);
    assert_eq!(
        (r.channels()[0].samples[0], r.channels()[1].samples[0]),
        (100.0, 0.5)
    );
    assert_eq!(
        (
            r.annotations.events.len(),
            r.about.condition.load_n.map(|n| n.0)
        ),
        (1, Some(0.4))
    );
}

/// What a recording lacks of its run comes back from a Parquet file and from the sidecar of a WAV file.
#[test]
fn losses_come_back() {
    let folder = tempfile::tempdir().unwrap();
    let losses = Losses {
        samples: 25,
        stretches_s: vec![[0.5, 0.505]],
        playback: Some(BrokenPlayback {
            played: 900,
            expected: 1000,
            underruns: 2,
        }),
        is_interrupted: false,
    };
    let samples: Vec<f64> = (0..5000).map(|i| (f64::from(i) / 10.0).sin()).collect();
    let provenance = Provenance {
        losses: losses.clone(),
        ..Provenance::default()
    };
    let channel = Channel {
        name: "acc".into(),
        unit: Unit::MetrePerSecondSquared,
        samples: samples.clone(),
    };
    let rate = SampleRate::new(5000.0).unwrap();
    let recording = Recording::new(
        vec![channel],
        rate,
        Condition::default(),
        provenance.clone(),
    )
    .unwrap();
    let stored = folder.path().join("r.parquet");
    write_recording(&stored, &recording).unwrap();
    let wav = folder.path().join("r.wav");
    let sidecar = Sidecar {
        about: About::new(Condition::default(), provenance),
        ..of_scale(1.0)
    };
    write_wav_with_sidecar(&wav, &[&samples], 5000, SampleFormat::Float32, &sidecar).unwrap();
    for path in [stored, wav] {
        let read = read_recording(&path, &ReadOptions::default()).unwrap();
        assert_eq!(read.recording.about.provenance.losses, losses, "{path:?}");
    }
}
