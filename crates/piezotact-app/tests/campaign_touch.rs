//! Trials of touch on a bench with sensors: what is recorded and counted, what withdrawal erases, and what a kill leaves.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use piezotact::recording::Recording;
use piezotact_dataset::{ReadOptions, read_recording};

use crate::campaign_session::{holds, line_for, run, session, until};
use crate::support::Folder;
use crate::support::session::two_sets;

/// A study whose participants make three strokes on each of four samples.
fn study() -> Folder {
    let folder = Folder::new();
    let strokes = "strokes = 10";
    assert!(two_sets().contains(strokes));
    folder.write("protocol.toml", two_sets().replace(strokes, "strokes = 3"));
    let line = "campaign new study --protocol protocol.toml --seed 7";
    run(&folder, line).expect_success();
    folder
}

fn read(file: &Path) -> Recording {
    let read = read_recording(file, &ReadOptions::default());
    read.unwrap_or_else(|error| panic!("{}: {error}", file.display()))
        .recording
}

/// Waits until a file is there.
fn waited(file: &Path) {
    let begun = Instant::now();
    while !file.exists() {
        assert!(begun.elapsed() < Duration::from_secs(60), "{file:?}");
        std::thread::sleep(Duration::from_millis(20));
    }
}

fn runs(folder: &Folder) -> PathBuf {
    folder.path("study/participants/P01/measurement/runs")
}

/// The recordings of touches in `runs`, those under way included.
fn recordings(runs: &Path) -> Vec<PathBuf> {
    let files = std::fs::read_dir(runs).unwrap();
    let mut files: Vec<PathBuf> = files.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

const MEASURE: &str = "campaign run study P01 measurement --bench twin:participant=1,seed=7";

#[test]
fn a_touch_on_the_twin_is_recorded_and_its_strokes_are_counted() {
    let folder = study();
    let mut typed = session(&folder, MEASURE);
    let mut files = 0;
    while let Some(text) = typed.prompt() {
        if text.contains("3 strokes; Enter when it is done") {
            // The person of the twin does not take its time: the file stands there when the strokes are over.
            files += 1;
            let begun = Instant::now();
            let is_there = || {
                let ended = recordings(&runs(&folder));
                let ended = ended
                    .iter()
                    .filter(|file| file.extension().is_some_and(|e| e == "parquet"));
                ended.count() == files
            };
            while !is_there() {
                assert!(begun.elapsed() < Duration::from_secs(60));
                std::thread::sleep(Duration::from_millis(20));
            }
        }
        typed.type_line(&line_for(&text));
    }
    let seen = typed.seen.clone();
    let (status, said) = typed.end();
    assert!(status.success(), "{seen}\n{said}");
    holds(
        &seen,
        &["strokes found: 3 of 3; recorded as runs/", "is complete"],
    );
    assert!(!seen.contains("NOT COMPLETE"), "{seen}");
    let recorded = recordings(&runs(&folder));
    assert_eq!(recorded.len(), 4, "{recorded:?}");
    for file in &recorded {
        let recording = read(file);
        let condition = &recording.about.condition;
        let sample = condition.sample.as_deref().unwrap();
        assert!(file.to_string_lossy().contains(&format!("{sample}-1-1-1")));
        assert_eq!(condition.participant.as_deref(), Some("P01"));
        let segment = folder.run(&[
            "strokes",
            "--cuts-only",
            &file.display().to_string(),
            "--json",
        ]);
        segment.expect_success();
    }
    holds(
        &run(&folder, "campaign verify study").out(),
        &["whole, with the 4 recordings"],
    );
    // Withdrawal erases them with the session.
    let line = "campaign withdraw study P01";
    let done = run(&folder, line);
    assert!(done.code() == Some(0), "{}", done.err());
    assert!(!runs(&folder).exists());
}

#[test]
fn a_touch_that_is_confirmed_too_early_is_said_not_to_be_complete() {
    let folder = study();
    folder.write("fake.toml", "chunks_s = [0.1]");
    let mut typed = session(
        &folder,
        "campaign run study P01 measurement --bench fake:fake.toml",
    );
    until(&mut typed, "3 strokes; Enter when it is done");
    holds(
        &typed.type_and_read(""),
        &[
            "not complete: expected 3 strokes, found 0",
            "confirm once more",
        ],
    );
    holds(
        &typed.type_and_read(""),
        &["strokes found: 0 of 3; NOT COMPLETE; recorded as runs/"],
    );
}

/// Killed in mid-touch: what was recorded is readable, and the trial is begun again under another name.
#[cfg(unix)]
#[test]
fn a_kill_in_mid_touch_leaves_a_recording_that_is_readable() {
    let folder = study();
    folder.write("fake.toml", "chunks_s = [0.1]");
    let line = "campaign run study P01 measurement --bench fake:fake.toml";
    let mut typed = session(&folder, line);
    until(&mut typed, "3 strokes; Enter when it is done");
    std::thread::sleep(Duration::from_millis(1500));
    typed.kill();
    let left = recordings(&runs(&folder));
    assert_eq!(left.len(), 1, "{left:?}");
    let part = &left[0];
    assert!(
        part.to_string_lossy().ends_with("-1-1-1.parquet.part"),
        "{left:?}"
    );
    let interrupted = read(part);
    assert!(interrupted.duration().0 > 0.4, "{interrupted:?}");
    assert!(interrupted.about.condition.sample.is_some());
    let mut typed = session(&folder, line);
    let text = until(&mut typed, "3 strokes; Enter when it is done");
    assert!(typed.seen.contains("attempt 2"), "{text}");
    let name = part
        .to_string_lossy()
        .replace("-1-1-1.parquet.part", "-2-1-1.parquet.part");
    waited(Path::new(&name));
    std::thread::sleep(Duration::from_millis(500));
    typed.type_line("");
    until(&mut typed, "recorded as runs/");
    // The first stays as it is.
    assert!(read(part).duration() == interrupted.duration());
}
