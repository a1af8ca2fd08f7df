//! What stands beside a WAV file: believed of the samples that it was written for, and refused with what to do.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact::recording::RecordingDoubt;
use piezotact::stroke::StrokeDoubt;
use std::path::Path;

use piezotact::Doubt;
use piezotact::quantity::SampleRate;
use piezotact_dataset::sidecar::{Sidecar, sidecar_path};
use piezotact_dataset::wav::{SampleFormat, write_wav, write_wav_with_sidecar};
use piezotact_dataset::{ReadOptions, read_recording};

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
fn doubts_about_samples_are_read_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.wav");
    let samples: Vec<f64> = (0..500).map(|i| f64::from(i).sin()).collect();
    let mut sidecar = of_scale(2.0);
    sidecar.about.doubts = vec![Doubt::from(StrokeDoubt::NothingCut)];
    write_wav_with_sidecar(&path, &[&samples], 5_000, SampleFormat::Float32, &sidecar).unwrap();
    let rate = SampleRate::new(1_000.0).ok();
    let read = read_recording(&path, &ReadOptions { scale: None, rate }).unwrap();
    let expected = [
        Doubt::from(StrokeDoubt::NothingCut),
        Doubt::from(RecordingDoubt::RateNotUsed {
            stated_hz: 1_000.0,
            found_hz: 5_000.0,
        }),
    ];
    assert_eq!(read.recording.about.doubts, expected);
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
