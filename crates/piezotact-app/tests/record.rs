//! `piezotact record`: what a bench acquires while nothing plays, with what is stated of it.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::io::Read as _;
use std::process::Stdio;

use crate::audio::setup;
use crate::support::{BENCH, Folder};

#[test]
fn what_is_stated_stands_in_the_recording() {
    let folder = Folder::new();
    folder.write("setup.toml", setup("pace = \"real_time\""));
    folder
        .run(&[
            "sound",
            "calibrate",
            "setup.toml",
            "--input-volts",
            "2.8284",
        ])
        .expect_success();
    let done = folder.run(&[
        "record",
        "--bench=audio:setup.toml",
        "--seconds=2",
        "--sample=S8",
        "--speed=30mm/s",
        "--direction=distal",
        "--load=0.2",
        "--metronome=0.5",
        "--strokes=4",
        "--out=S8.parquet",
        "--json",
    ]);
    done.expect_success();
    let found = done.json();
    assert!((found["duration_s"].as_f64().unwrap() - 2.0).abs() < 0.01);
    let condition = &found["condition"];
    assert_eq!(condition["sample"], "S8");
    assert_eq!(condition["touch"], "active");
    assert_eq!(condition["direction"], "distal");
    assert!((condition["speed_m_s"].as_f64().unwrap() - 0.03).abs() < 1e-12);
    let told = folder.run(&["info", "S8.parquet"]).out();
    for part in ["sample S8", "speed 0.03 m/s", "normal_force", "AC-coupled"] {
        let is_there =
            told.contains(part) || part == "AC-coupled" && told.contains("does not pass 0 Hz");
        assert!(is_there, "{part}: {told}");
    }
}

/// Without a duration a signal ends the recording in order, and it is no failure.
#[test]
fn a_recording_without_an_end_ends_with_a_signal() {
    let folder = Folder::new();
    folder.write("setup.toml", setup("pace = \"real_time\""));
    let mut command = folder.command(&["record", "--bench=audio:setup.toml", "--out=a.parquet"]);
    let mut child = command
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let place = folder.path("a.parquet");
    // It has begun once there is something of it.
    let begun = || {
        let names = folder.names();
        names
            .iter()
            .any(|name| name.starts_with("a.parquet") || name.contains("a.parquet"))
    };
    while !begun() {
        assert!(child.try_wait().unwrap().is_none(), "it ended by itself");
        std::thread::sleep(std::time::Duration::from_millis(50));
    }
    std::thread::sleep(std::time::Duration::from_millis(1_500));
    let pid = child.id().to_string();
    let sent = std::process::Command::new("kill")
        .args(["-INT", &pid])
        .status();
    assert!(sent.unwrap().success());
    let status = child.wait().unwrap();
    let mut said = String::new();
    child
        .stderr
        .take()
        .unwrap()
        .read_to_string(&mut said)
        .unwrap();
    assert!(status.success(), "{said}");
    assert!(place.is_file());
    let told = folder.run(&["info", "a.parquet"]).out();
    assert!(told.contains("acceleration"), "{told}");
}

#[test]
fn what_cannot_be_is_refused_before_a_file_is_begun() {
    let folder = Folder::new();
    for (option, part) in [
        ("--seconds=0", "--seconds"),
        ("--seconds=nan", "--seconds"),
        ("--metronome=0", "--metronome"),
        ("--load=-1", "--load"),
        ("--sample= ", "sample"),
        ("--speed=30", "speed"),
    ] {
        let bench = format!("--bench={BENCH}");
        let done = folder.run(&["record", &bench, option, "--out=a.parquet"]);
        done.expect_failure(2, &[part]);
        assert!(folder.names().is_empty(), "{option}");
    }
}
