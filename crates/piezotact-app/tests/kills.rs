//! Killed at any moment, a command loses at most the last second: what was acquired is readable, nothing is half-written under a
//! final name, nothing blocks the next run, and panels and closed loops continue to the same result.
#![cfg(unix)]
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]
#![allow(clippy::print_stdout, reason = "what was found stands in the log")]

mod campaign_kills;
mod support;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Stdio;
use std::time::{Duration, Instant};

use piezotact_dataset::{ReadOptions, read_recording, read_transfer};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};
use support::Folder;

/// A command that acquires, the files that it needs first, and whether it goes on where it was killed.
struct Case {
    name: &'static str,
    prepare: &'static [&'static str],
    command: &'static str,
}

const CASES: [Case; 8] = [
    Case {
        name: "twin record",
        prepare: &[],
        command: "twin record --bench acttouch --sample S8 --strokes 4 --out touch.parquet",
    },
    Case {
        name: "characterise",
        prepare: &[],
        command: "characterise --bench twin:participant=1,seed=7 --seconds 12 --repeats 2 --out tf.json",
    },
    Case {
        name: "panel run",
        prepare: &[],
        command: "panel run --bench twin:seed=7 --participants 1 --loads 0.2 --angles 20,40 --seconds 10 --out panel",
    },
    Case {
        name: "render --mode texture",
        prepare: &[
            "twin record --bench triboair --sample S8 --strokes 1 --out S8.wav",
            "characterise --bench twin:participant=1,seed=7 --seconds 12 --out tf.json",
        ],
        command: "render S8.wav --transfer tf.json --mode texture --bench twin:participant=1,seed=7 --level fit --out drive.wav",
    },
    Case {
        name: "render of a batch",
        prepare: &[
            "twin record --bench triboair --sample S8 --strokes 1 --out S8.wav",
            "twin record --bench triboair --sample S3 --strokes 1 --out S3.wav",
            "characterise --bench twin:participant=1,seed=7 --seconds 12 --out tf.json",
        ],
        command: "render S8.wav S3.wav --transfer tf.json --mode texture --bench twin:participant=1,seed=7 --level fit --iterations 2 --out drives",
    },
    Case {
        name: "characterise, repeated and recorded",
        prepare: &[],
        command: "characterise --bench twin:participant=1,seed=7 --seconds 8 --repeats 3 --record raw.parquet --out tf.json",
    },
    Case {
        name: "prepare",
        prepare: &TOUCHED,
        command: "prepare S1.parquet S11.parquet --transfer tf.json --bench twin:participant=2,seed=7 --out ready",
    },
    Case {
        name: "prepare in a closed loop",
        prepare: &TOUCHED,
        command: "prepare S1.parquet S11.parquet --transfer tf.json --bench twin:participant=2,seed=7 --mode texture --iterations 1 --out ready",
    },
];
/// The strokes of somebody on two samples, and the transfer function of the finger.
const TOUCHED: [&str; 3] = [
    "twin record --bench acttouch --sample S1 --participant 2 --seed 7 --strokes 4 --out S1.parquet",
    "twin record --bench acttouch --sample S11 --participant 2 --seed 7 --strokes 4 --out S11.parquet",
    "characterise --bench twin:participant=2,seed=7 --seconds 20 --out tf.json",
];

impl Case {
    /// Whether it continues with what it measured before it was killed.
    fn continues(&self) -> bool {
        ["panel", "render"]
            .iter()
            .any(|name| self.command.starts_with(name))
            || self.command.starts_with("prepare") && self.command.contains("--mode")
    }
}

/// A journal has fewer bytes than this as long as its first chunk is not whole: 0.5 s of three channels, and its start.
const FIRST_BYTES: u64 = 100_000;

fn words(text: &str) -> Vec<&str> {
    text.split_whitespace().collect()
}

impl Case {
    fn folder(&self) -> Folder {
        let folder = Folder::new();
        for command in self.prepare {
            folder.run_as_given(&words(command)).expect_success();
        }
        folder
    }
}

/// All files below a folder, by their path in it.
fn files(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![folder.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true => open.push(path),
                false => found.push(path),
            }
        }
    }
    found.sort();
    found
}

/// The bytes of all results: not what an interrupted run left under a name of its own, nor locks.
fn results(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut all = BTreeMap::new();
    for path in files(folder) {
        let name = path
            .strip_prefix(folder)
            .unwrap()
            .to_string_lossy()
            .into_owned();
        let left = name.contains(".interrupted-") || name.contains(".before-");
        if !left && !name.ends_with("panel.lock") {
            all.insert(name, std::fs::read(&path).unwrap());
        }
    }
    all
}

/// What a kill may leave: final files that are whole, journals that are readable.
fn check_left(folder: &Path, said: &str) -> (usize, f64) {
    let (mut journals, mut seconds) = (0, 0.0);
    for path in files(folder) {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        let text = format!("{said}: {}", path.display());
        match name.as_str() {
            _ if name.ends_with(".part") => {
                let read = read_recording(&path, &ReadOptions::default());
                match read {
                    Ok(contents) => {
                        journals += 1;
                        seconds += contents.recording.duration().0;
                        let warnings = contents.recording.about.warnings.iter();
                        let warnings: Vec<String> = warnings.map(ToString::to_string).collect();
                        // Killed between its end, where the force is judged, and its removal, the journal is whole.
                        let judged = |warning: &String| warning.contains("mean normal force");
                        let whole = path.with_extension("").exists()
                            || warnings.is_empty()
                            || warnings.iter().any(judged);
                        assert!(
                            whole || warnings.iter().any(|d| d.contains("interrupted")),
                            "{text}: {warnings:?}"
                        );
                    }
                    // Killed before its first samples were on the disk, or within the write of them.
                    Err(error) => {
                        let length = std::fs::metadata(&path).unwrap().len();
                        assert!(length < FIRST_BYTES, "{text}, {length} bytes: {error}");
                    }
                }
            }
            _ if name.ends_with(".parquet") => {
                read_recording(&path, &ReadOptions::default())
                    .unwrap_or_else(|e| panic!("{text}: {e}"));
            }
            "panel.json" => {
                piezotact_dataset::PanelFolder::open(path.parent().unwrap())
                    .unwrap_or_else(|e| panic!("{text}: {e}"));
            }
            _ if name.ends_with(".wav") => {
                read_recording(&path, &ReadOptions::default())
                    .unwrap_or_else(|e| panic!("{text}: {e}"));
            }
            _ if name.ends_with(".json") && !name.ends_with(".wav.json") => {
                read_transfer(&path).unwrap_or_else(|e| panic!("{text}: {e}"));
            }
            _ => {}
        }
    }
    (journals, seconds)
}

/// Kills `case` at `times` random moments, each in a folder of its own.
fn kill(case: &Case, times: usize, seed: u64) {
    let reference = case.folder();
    let begun = Instant::now();
    reference
        .run_as_given(&words(case.command))
        .expect_success();
    let whole = begun.elapsed();
    let wanted = results(&reference.path(""));
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let (mut killed, mut with_journal, mut kept_s, mut continued) = (0, 0, 0.0, 0);
    let folder = case.folder();
    let prepared = results(&folder.path(""));
    for number in 0..times {
        // A fresh folder with what the command needs.
        let folder = Folder::new();
        for (name, bytes) in &prepared {
            folder.write(name, bytes);
        }
        let share = random.next_u32() as f64 / f64::from(u32::MAX);
        let after = Duration::from_secs_f64(whole.as_secs_f64() * share);
        let mut child = folder
            .command(&words(case.command))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
        std::thread::sleep(after);
        let said = format!(
            "{}, kill {number} of seed {seed} after {after:.3?}",
            case.name
        );
        child.kill().unwrap();
        let status = child.wait().unwrap();
        killed += usize::from(!status.success());
        let (journals, seconds) = check_left(&folder.path(""), &said);
        with_journal += usize::from(journals > 0);
        kept_s += seconds;
        // Nothing blocks the next run, and it comes to the same.
        let again = folder.run_as_given(&words(case.command));
        again.expect_success();
        continued += usize::from(again.err().contains("taken from"));
        let found = results(&folder.path(""));
        let names =
            |all: &BTreeMap<String, Vec<u8>>| -> Vec<String> { all.keys().cloned().collect() };
        assert_eq!(names(&found), names(&wanted), "{said}\n{}", again.err());
        for (name, bytes) in &wanted {
            assert!(found[name] == *bytes, "{said}: {name} differs");
        }
        check_left(&folder.path(""), &format!("{said}, again"));
    }
    println!(
        "{}: {killed} of {times} killed before the end ({whole:.2?}); {with_journal} left a journal, {kept_s:.1} s in all; {continued} continued with what was measured",
        case.name
    );
    // With so many kills some come between two runs.
    assert!(!case.continues() || times < 40 || continued > 0);
}

#[test]
fn killed_at_any_moment_nothing_is_lost() {
    for (case, seed) in CASES.iter().zip(1..) {
        kill(case, 4, seed);
    }
}

/// 40 kills of each command but those that prepare and repeat.
#[test]
#[ignore = "takes minutes: ./x soak kill"]
fn soak_kill_commands() {
    for (case, seed) in CASES.iter().zip(101..).take(5) {
        kill(case, 40, seed);
    }
}

/// 40 kills of `prepare`, with and without a closed loop, and of measurements that are repeated and recorded.
#[test]
#[ignore = "takes minutes: ./x soak kill"]
fn soak_kill_preparations() {
    for (case, seed) in CASES.iter().zip(101..).skip(5) {
        kill(case, 40, seed);
    }
}
