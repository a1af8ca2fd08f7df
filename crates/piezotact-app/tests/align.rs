//! A drive with bursts, and what another system recorded of it on its clock.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::f64::consts::TAU;

use piezotact::recording::Recording;
use piezotact_dataset::{ReadOptions, read_recording};
use serde_json::Value;

use crate::support::{Folder, results, wav};

const DRIVE_HZ: u32 = 48_000;
/// The other system records from here on, by a clock that runs so much faster.
const FROM_S: f64 = 0.1234567;
const PPM: f64 = 85.0;

fn tone(seconds: f64) -> Vec<u8> {
    let count = (seconds * f64::from(DRIVE_HZ)) as usize;
    let at = |i: usize| 0.3 * (TAU * 250.0 * i as f64 / f64::from(DRIVE_HZ)).sin();
    wav((0..count).map(at), DRIVE_HZ)
}

fn recording(folder: &Folder, name: &str) -> Recording {
    let options = ReadOptions::default();
    read_recording(&folder.path(name), &options)
        .unwrap()
        .recording
}

/// `drive` as the other system samples it at `rate_hz` from [`FROM_S`] to `to_s`: by the line between samples, as 48 kHz is 48 times the highest
/// frequency.
fn other(drive: &Recording, rate_hz: f64, to_s: f64) -> Vec<f64> {
    let x = &drive.channels()[0].samples;
    let step_s = 1.0 / (rate_hz * (1.0 + 1e-6 * PPM));
    let count = ((to_s - FROM_S) / step_s) as usize;
    (0..count)
        .map(|i| {
            let at = (FROM_S + i as f64 * step_s) * f64::from(DRIVE_HZ);
            let (base, late) = (at as usize, at.fract());
            let value = |i: usize| x.get(i).copied().unwrap_or(0.0);
            value(base) * (1.0 - late) + value(base + 1) * late
        })
        .collect()
}

/// The drive with bursts, and a table of the other system at 5 kHz with noise, a second channel and the nail at 20 m/s² of full scale.
fn played() -> (Folder, Recording) {
    let folder = Folder::new();
    folder.write("drive.wav", tone(8.0));
    folder
        .run(&["sound", "burst", "drive.wav", "--out", "with.wav"])
        .expect_success();
    let drive = recording(&folder, "with.wav");
    let mut draw = crate::support::noise(1_000_000);
    let rows = other(&drive, 5000.0, 9.9);
    let rows = rows.iter().enumerate().map(|(i, v)| {
        let noisy = 20.0 * v + 0.2 * draw.next().unwrap();
        let force = 0.4 + 0.01 * (TAU * 2.0 * i as f64 / 5000.0).sin();
        format!("{:.7},{noisy:.6},{force:.6}\n", i as f64 / 5000.0)
    });
    let rows: String = rows.collect();
    let head = "time (s),nail (m/s2),force (N)\n";
    folder.write("other.csv", format!("{head}{rows}"));
    (folder, drive)
}

#[track_caller]
fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[test]
fn the_drive_is_kept_with_its_bursts_and_its_notes() {
    let folder = Folder::new();
    folder.write("drive.wav", tone(3.0));
    folder.write(
        "drive.wav.json",
        r#"{"channels": ["drive"], "labels": {"session": "2"}, "events": [{"onset_s": 1.5, "duration_s": 0.5, "kind": "mark"}]}"#,
    );
    let done = folder.run(&["sound", "burst", "drive.wav", "--out", "with.wav", "--json"]);
    let found = done.json();
    assert_eq!(found["schema"], "burst");
    // 0.25 s, the burst, 0.25 s.
    assert!((number(&found["bursts"]["drive"]["from_s"]) - 1.0).abs() < 1e-9);
    assert!((number(&found["length_s"]) - 5.0).abs() < 1e-9);
    let peak = number(&found["config"]["peak"]);
    assert!((peak - 0.3).abs() < 1e-4, "{peak}");
    let (before, with) = (
        recording(&folder, "drive.wav"),
        recording(&folder, "with.wav"),
    );
    assert_eq!(
        with.channels()[0].samples[48_000..4 * 48_000],
        before.channels()[0].samples
    );
    assert_eq!(with.annotations.labels["session"], "2");
    let events = with.annotations.events.iter();
    let events: Vec<(f64, &str)> = events.map(|e| (e.onset_s.0, e.kind.as_str())).collect();
    let expected = [
        (0.25, "sync_burst_first"),
        (1.0, "drive"),
        (2.5, "mark"),
        (4.25, "sync_burst_last"),
    ];
    assert_eq!(events, expected);
    // Once is enough.
    folder
        .run(&["sound", "burst", "with.wav", "--out", "more.wav"])
        .expect_failure(1, &["with.wav", "has bursts already"]);
}

#[test]
fn a_tone_recorded_elsewhere_is_placed_by_its_bursts() {
    let (folder, _) = played();
    let line = [
        "sound",
        "align",
        "with.wav",
        "other.csv",
        "--out",
        "aligned.parquet",
        "--report",
        "align.html",
    ];
    let done = folder.run(&line);
    done.expect_success();
    assert!(done.out().contains("By both bursts"), "{}", done.out());
    let found = folder.run(&[&line[..], &["--json"]].concat()).json();
    assert_eq!(
        (&found["schema"], &found["by"]),
        (&"align".into(), &"bursts".into())
    );
    let inputs: Vec<&str> = found["invocation"]["inputs"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|input| input["path"].as_str())
        .collect();
    assert!(
        inputs.contains(&"with.wav") && inputs.contains(&"other.csv"),
        "{inputs:?}"
    );
    let (offset_s, drift_ppm) = (number(&found["offset_s"]), number(&found["drift_ppm"]));
    // 0.1 ms at both ends.
    assert!((offset_s - FROM_S).abs() < 1e-4, "{offset_s}");
    let end_s = 9.7;
    let drift_s = 1e-6 * (drift_ppm - PPM) * end_s;
    assert!(
        (offset_s - FROM_S - drift_s).abs() < 1e-4,
        "{offset_s} {drift_ppm}"
    );
    let [low, high] = [0, 1].map(|i| number(&found["offset_interval_s"][i]));
    assert!(
        low < FROM_S && FROM_S < high && high - low < 2e-4,
        "{low} {high}"
    );
    let report = std::fs::read_to_string(folder.path("align.html")).unwrap();
    assert!(report.contains("Residuals from the line") && report.contains("Bursts"));
    folder.run(&["rerun", "align.html"]).expect_success();
    folder
        .run(&[&line[..4], &["--csv", "rows.csv"]].concat())
        .expect_success();
    let rows = std::fs::read_to_string(folder.path("rows.csv")).unwrap();
    assert!(
        rows.starts_with("what,recorded_s,drive_s,residual_us,correlation,used\n"),
        "{rows}"
    );
    assert!(
        rows.contains("\nfirst burst,") && rows.contains("\nlast burst,"),
        "{rows}"
    );
}

/// All channels, and the drive at their rate; the drive that was recorded lies on it.
#[test]
fn the_recording_on_the_clock_of_the_drive_holds_all_channels_and_the_drive() {
    let (folder, _) = played();
    let line = [
        "sound",
        "align",
        "with.wav",
        "other.csv",
        "--out",
        "aligned.parquet",
    ];
    let found = folder.run(&[&line[..], &["--json"]].concat()).json();
    let [from_s, to_s] = [0, 1].map(|i| number(&found["covered_s"][i]));
    assert!((from_s - FROM_S).abs() < 1e-3, "{from_s}");
    assert!(to_s < number(&found["drive_length_s"]), "{to_s}");
    let placed = recording(&folder, "aligned.parquet");
    let names: Vec<&str> = placed.channels().iter().map(|c| c.name.as_str()).collect();
    assert_eq!(names, ["nail", "force", "drive"]);
    assert!((placed.rate().hz() - 5000.0).abs() < 1e-9);
    let [nail, force, drive] = placed.channels() else {
        panic!("{names:?}")
    };
    let n = nail.samples.len();
    let (mut worst, mut rest) = (0.0f64, 0.0);
    for i in 500..n - 500 {
        let away = nail.samples[i] / 20.0 - drive.samples[i];
        rest += away * away;
        worst = worst.max(away.abs());
    }
    let rms = (rest / (n - 1000) as f64).sqrt();
    // The noise has an rms below 0.006 of full scale; 20 µs at 1 kHz and 0.3 of full scale add 0.04 at most.
    assert!(rms < 0.012 && worst < 0.08, "{rms} {worst}");
    assert!(force.samples.iter().all(|v| (v - 0.4).abs() < 0.011));
    let first_s: f64 = placed.annotations.labels["first_sample_on_drive_s"]
        .parse()
        .unwrap();
    assert!((first_s - FROM_S).abs() < 3e-4, "{first_s}");
    let kinds = placed.annotations.events.iter().map(|e| e.kind.as_str());
    assert_eq!(
        kinds.collect::<Vec<_>>(),
        ["sync_burst_first", "drive", "sync_burst_last"]
    );
    let steps = &placed.about.provenance.steps;
    assert!(
        steps
            .iter()
            .any(|step| step.contains("placed on the clock")),
        "{steps:?}"
    );
    // The sweeps drive from 100 to 1000 Hz: 20 m/s² of full scale.
    let transfer = [
        "transfer",
        "aligned.parquet",
        "--drive",
        "drive",
        "--response",
        "nail",
    ];
    folder
        .run(&[&transfer[..], &["--out", "tf.json"]].concat())
        .expect_success();
}

/// A recording with events, a label and a time, of which the channel has to be named, at a rate of its own.
#[test]
fn events_and_labels_are_placed_too() {
    let (folder, drive) = played();
    let own = other(&drive, 8000.0, 9.9);
    let mut both = Vec::new();
    for v in &own {
        both.extend([*v, -0.5 * v]);
    }
    let mut bytes = wav(both.into_iter(), 8000);
    // Two channels: block align, and bytes a second.
    bytes[22] = 2;
    bytes[32] = 4;
    bytes[28..32].copy_from_slice(&32_000u32.to_le_bytes());
    folder.write("other.wav", bytes);
    folder.write(
        "other.wav.json",
        r#"{"channels": ["a", "b"], "units": {"a": "20 m/s2", "b": "20 m/s2"}, "labels": {"run": "3"}, "started_at": "2026-03-01T10:00:00Z",
            "condition": {"participant": "P07"},
            "events": [{"onset_s": 5.0, "duration_s": 1.0, "kind": "answer", "value": "rough"}]}"#,
    );
    folder
        .run(&["sound", "align", "with.wav", "other.wav"])
        .expect_failure(
            1,
            &["other.wav", "name the one to use", "a [m/s²], b [m/s²]"],
        );
    folder
        .run(&["sound", "align", "with.wav", "other.wav", "--channel", "c"])
        .expect_failure(1, &["other.wav", "`c`"]);
    folder
        .run(&[
            "sound",
            "align",
            "with.wav",
            "other.wav",
            "--channel",
            "b",
            "--out",
            "aligned.parquet",
        ])
        .expect_success();
    let placed = recording(&folder, "aligned.parquet");
    assert_eq!(placed.annotations.labels["run"], "3");
    assert_eq!(placed.about.condition.participant.as_deref(), Some("P07"));
    let first_s: f64 = placed.annotations.labels["first_sample_on_drive_s"]
        .parse()
        .unwrap();
    let answer = placed.annotations.events.iter();
    let answer = answer.clone().find(|e| e.kind == "answer").unwrap();
    // 5 s by the clock of the other system.
    let truth_s = FROM_S + 5.0 / (1.0 + 1e-6 * PPM);
    assert!(
        (first_s + answer.onset_s.0 - truth_s).abs() < 1e-4,
        "{answer:?}"
    );
    let started = placed.annotations.started_at.unwrap().to_string();
    assert!(started.starts_with("2026-03-01T10:00:00.0000"), "{started}");
}

#[test]
fn what_cannot_be_aligned_is_named() {
    let (folder, _) = played();
    let align = |more: &[&str]| folder.run(&[&["sound", "align"], more].concat());
    align(&["with.wav", "with.wav"]).expect_failure(2, &["with.wav twice"]);
    align(&["other.csv", "with.wav"])
        .expect_failure(1, &["other.csv", "in shares of full scale", "nail [m/s²]"]);
    align(&["with.wav", "none.csv"]).expect_failure(1, &["none.csv"]);
    align(&["with.wav", "other.csv", "--band", "100..3000"])
        .expect_failure(2, &["2250 Hz", "3000 Hz"]);
    align(&["with.wav", "other.csv", "--block", "nan"]).expect_failure(2, &["block"]);
    align(&["with.wav", "other.csv", "--largest-drift", "0"]).expect_failure(2, &["drift"]);
    align(&["with.wav", "other.csv", "--out", "other.csv"])
        .expect_failure(2, &["other.csv is read"]);
    align(&["with.wav", "other.csv", "--out", "a.csv"]).expect_failure(2, &[".parquet"]);
    align(&["with.wav", "other.csv", "--report", "a.txt"]).expect_failure(2, &[".html"]);
    folder.write("here.parquet", "not ours");
    folder
        .run_as_given(&[
            "sound",
            "align",
            "with.wav",
            "other.csv",
            "--out",
            "here.parquet",
        ])
        .expect_failure(2, &["already exists"]);
    // A drive that repeats, without its bursts.
    align(&["drive.wav", "other.csv"]).expect_failure(1, &["other.csv"]);
    let table = std::fs::read_to_string(folder.path("other.csv")).unwrap();
    let lines: Vec<&str> = table.lines().collect();
    folder.write("short.csv", lines[..5000].join("\n"));
    align(&["with.wav", "short.csv"]).expect_failure(1, &["short.csv"]);
    folder.write("one.csv", lines[..30_000].join("\n"));
    align(&["with.wav", "one.csv"]).expect_failure(1, &["one.csv", "only the first one"]);
    let broken = [&lines[..20_000], &["3.9998,nan,0.4"], &lines[20_001..]].concat();
    folder.write("broken.csv", broken.join("\n"));
    align(&["with.wav", "broken.csv"]).expect_failure(1, &["broken.csv"]);
    let still = lines.iter().enumerate().map(|(i, line)| match i {
        0 => (*line).to_owned(),
        _ => format!("{},0,0.4", line.split(',').next().unwrap()),
    });
    folder.write("still.csv", still.collect::<Vec<_>>().join("\n"));
    align(&["with.wav", "still.csv"]).expect_failure(1, &["still.csv"]);
    folder.write("slow.csv", format!("nail (m/s2)\n{}", "0.5\n".repeat(900)));
    align(&["with.wav", "slow.csv", "--rate", "90"])
        .expect_failure(1, &["slow.csv", "90 Hz", "156 Hz"]);
    align(&["with.wav", "slow.csv", "--rate=-3"]).expect_failure(2, &["rate"]);
}

#[test]
fn bursts_that_cannot_be_are_named() {
    let folder = Folder::new();
    folder.write("drive.wav", tone(2.0));
    let burst = |more: &[&str]| folder.run(&[&["sound", "burst", "drive.wav"], more].concat());
    burst(&["--out", "drive.wav"]).expect_failure(2, &["drive.wav is read"]);
    burst(&["--out", "with.parquet"]).expect_failure(2, &[".wav"]);
    burst(&["--out", "with.wav", "--band", "100..30000"]).expect_failure(2, &["21600 Hz"]);
    burst(&["--out", "with.wav", "--duration", "0.01"]).expect_failure(2, &["longer"]);
    burst(&["--out", "with.wav", "--guard", "0"]).expect_failure(2, &["silence"]);
    burst(&["--out", "with.wav", "--peak", "1.5"]).expect_failure(2, &["1.5"]);
    folder.write("silent.wav", wav((0..48_000).map(|_| 0.0), DRIVE_HZ));
    folder
        .run(&["sound", "burst", "silent.wav", "--out", "with.wav"])
        .expect_failure(1, &["silent.wav", "--peak"]);
    folder.write("texture.wav", tone(2.0));
    folder.write("texture.wav.json", r#"{"full_scale": "20 m/s2"}"#);
    folder
        .run(&["sound", "burst", "texture.wav", "--out", "with.wav"])
        .expect_failure(1, &["texture.wav", "m/s²"]);
    folder.write(
        "drive.csv",
        "time (s),drive (V)\n0,0.1\n0.001,0.2\n0.002,0.1\n",
    );
    folder
        .run(&["sound", "burst", "drive.csv", "--out", "with.wav"])
        .expect_failure(1, &["drive.csv", "WAV"]);
    assert!(!folder.names().contains(&"with.wav".to_owned()));
    // The same drive gives the same bytes.
    folder
        .run(&["sound", "burst", "drive.wav", "--out", "a.wav", "--json"])
        .expect_success();
    let done = folder.run(&["sound", "burst", "drive.wav", "--out", "a.wav", "--json"]);
    let again = results(done.json());
    assert_eq!(again["out"], "a.wav");
}
