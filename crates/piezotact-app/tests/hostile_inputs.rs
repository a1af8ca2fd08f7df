//! Inputs that are no files, that are huge, or that hold what a terminal would act on; batches with bad files.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::time::{Duration, Instant};

use crate::known_cuts::{Kind, Random, recorded, table};
use crate::support::{Folder, noise, wav};

/// Every command with a place for each kind of input file; `IN` is that file.
#[cfg(unix)]
const WITH_INPUTS: &[&str] = &[
    "info IN",
    "spectrum IN",
    "spectrum IN --rest",
    "transfer IN --drive a --response b --out tf.json",
    "manipulate IN --gain 3dB --out o.wav",
    "manipulate t.wav --scale 1m/s2 --rms-of IN --out o.wav",
    "render IN --transfer tf.json --out o.wav",
    "render t.wav --scale 1m/s2 --transfer IN --out o.wav",
    "score t.wav t.wav --scale 1m/s2 --contact-map IN",
    "play IN --bench twin:participant=1,seed=7 --record r.parquet",
    "play t.wav --bench fake:IN --record r.parquet",
    "play t.wav --bench measured:IN,seed=7 --record r.parquet",
    "verify --target IN --measured t.wav",
    "verify --target t.wav --scale 1m/s2 --measured IN",
    "verify --target t.wav --scale 1m/s2 --measured t.wav --transfer IN",
    "verify --target t.wav --scale 1m/s2 --measured t.wav --drive IN",
    "score IN t.wav --scale 1m/s2",
    "score t.wav IN --scale 1m/s2",
    "strokes IN --cuts-only",
    "strokes t.wav --scale 1m/s2 --cuts IN --cuts-only",
    "strokes IN",
    "strokes t.wav --scale 1m/s2 --by file --set IN",
    "compare IN t.wav --by file",
    "roughness IN",
    "answers IN",
    "campaign design IN",
    "campaign protocol IN --dictionary",
    "panel add p IN",
    "export IN --out o.uff",
    "twin record --bench acttouch --twin IN --sample S8 --out o.wav",
    "twin parameters --twin IN",
];

#[cfg(unix)]
#[test]
fn devices_and_pipes_are_no_inputs_of_any_command() {
    let folder = Folder::new();
    folder.write("t.wav", wav(noise(5000), 5000));
    let made = std::process::Command::new("mkfifo")
        .arg(folder.path("pipe"))
        .status();
    assert!(made.unwrap().success());
    for input in ["/dev/zero", "pipe"] {
        for command in WITH_INPUTS {
            let words: Vec<&str> = command.split(' ').collect();
            let words: Vec<String> = words.iter().map(|word| word.replace("IN", input)).collect();
            let words: Vec<&str> = words.iter().map(String::as_str).collect();
            let mut child = folder
                .command(&words)
                .stdout(std::process::Stdio::null())
                .stderr(std::process::Stdio::piped())
                .spawn()
                .unwrap();
            let begun = Instant::now();
            let status = loop {
                if let Some(status) = child.try_wait().unwrap() {
                    break status;
                }
                if begun.elapsed() > Duration::from_secs(5) {
                    child.kill().unwrap();
                    panic!("{words:?} still reads");
                }
                std::thread::sleep(Duration::from_millis(5));
            };
            let output = child.wait_with_output().unwrap();
            let said = String::from_utf8_lossy(&output.stderr).into_owned();
            // a usage error of clap would hide what is tested here
            assert!(!said.contains("Usage:"), "{words:?}: {said}");
            assert!(
                matches!(status.code(), Some(1 | 2)),
                "{words:?}: {status} {said}"
            );
        }
        let said = folder.run(&["info", input]).err();
        assert!(said.contains("found a device or a pipe"), "{said}");
    }
}

#[cfg(unix)]
#[test]
fn sidecars_and_cuts_that_are_pipes_are_refused_too() {
    let folder = Folder::new();
    folder.write("t.wav", wav(noise(5000), 5000));
    for name in ["t.wav.json", "t.wav.cuts"] {
        let made = std::process::Command::new("mkfifo")
            .arg(folder.path(name))
            .status();
        assert!(made.unwrap().success());
        let done = folder.run(&["strokes", "--cuts-only", "t.wav", "--scale", "1m/s2"]);
        done.expect_failure(1, &["found a device or a pipe", name]);
        std::fs::remove_file(folder.path(name)).unwrap();
    }
}

#[test]
fn a_terminal_gets_no_control_characters() {
    let folder = Folder::new();
    folder.write(
        "t.csv",
        "time (s),a\u{1b}[31mcc\u{7} (m/s2)\n0,1\n0.1,2\n0.2,3\n0.3,\u{1b}]0;x\n",
    );
    let whole = "time (s),a\u{1b}[31mcc\u{9b} (m/s2)\n0,1\n0.1,2\n0.2,3\n0.3,1\n";
    folder.write("w.csv", whole);
    folder.write("s.wav", wav(noise(500), 1000));
    folder.write("s.wav.json", r#"{"full_scale": "1 m/s2", "condition": {"sample": "S\u001b[2J1"}, "channels": ["x\u001b[1m"]}"#);
    for arguments in [
        &["info", "t.csv"][..],
        &["info", "w.csv"],
        &["info", "w.csv", "--json"],
        &["info", "s.wav"],
        &["info", "s.wav", "--json"],
        &["info", "no\u{1b}[31mfile.csv"],
        &["info", "s.wav", "--rate", "\u{1b}[31m"],
        &["spectrum", "w.csv", "--csv", "w-psd.csv", "--segment", "4"],
    ] {
        let done = folder.run(arguments);
        for text in [done.out(), done.err()] {
            let found = text
                .chars()
                .find(|c| c.is_control() && !['\n', '\t'].contains(c));
            assert_eq!(found, None, "{arguments:?}: {text:?}");
        }
    }
    // JSON keeps the name itself
    let name = folder.run(&["info", "w.csv", "--json"]).json()["channels"][0]["name"].clone();
    assert_eq!(name, "a\u{1b}[31mcc\u{9b}");
}

#[test]
fn messages_quote_no_more_than_people_read() {
    let folder = Folder::new();
    let cell = "x".repeat(5_000_000);
    folder.write(
        "cell.csv",
        format!("time (s),acc (m/s2)\n0,1\n0.1,{cell}\n"),
    );
    folder.write(
        "words.csv",
        format!(
            "time (s),acc (m/s2)\n0,1\n0.1,{}\n",
            "x y ".repeat(1_000_000)
        ),
    );
    folder.write(
        "name.csv",
        format!("time (s),{cell} (m/s2)\n0,1\n0.1,oops\n"),
    );
    folder.write("t.wav", wav(noise(500), 1000));
    let digits = "1".repeat(300);
    for arguments in [
        &["info", "cell.csv"][..],
        &["info", "words.csv"],
        &["info", "name.csv"],
        &["info", "t.wav", "--rate", &digits],
        &["roughness", "t.wav", "--cutoff", &format!("{digits}.5mm")],
        &["roughness", "t.wav", "--cutoff", &format!("{digits}x")],
    ] {
        let done = folder.run(arguments);
        assert_ne!(done.code(), Some(0));
        let said = done.err();
        assert!(
            said.len() < 2000 && !said.contains(&"1".repeat(100)),
            "{}: {said:.300}",
            said.len()
        );
    }
}

#[test]
fn one_bad_recording_of_several_does_not_stop_the_others() {
    let folder = Folder::new();
    for (name, seed) in [("S1.csv", 1), ("S2.csv", 2)] {
        folder.write(
            name,
            table(&recorded(&mut Random::new(seed), &[Kind::Plain; 6])),
        );
    }
    folder.write("bad.csv", "time (s),acc (m/s2)\n0,1\n0.1,oops\n");
    for (command, options) in [
        ("strokes", &["--cuts-only", "--report", "r.html"][..]),
        ("strokes", &["--by", "file", "--report", "r.html"]),
        ("compare", &["--by", "file", "--report", "r.html"]),
    ] {
        let files = [command, "S1.csv", "bad.csv", "nowhere.csv", "S2.csv"];
        let done = folder.run(&[&files[..], options].concat());
        done.expect_failure(1, &["2 of 4 files gave no result", "`oops`", "nowhere.csv"]);
        assert!(
            done.out().contains("S1") && done.out().contains("S2"),
            "{command}: {}",
            done.out()
        );
        let html = std::fs::read_to_string(folder.path("r.html")).unwrap();
        assert!(html.contains("Files without a result"), "{command}");
        std::fs::remove_file(folder.path("r.html")).unwrap();
        let (value, code) = folder
            .run(&[&files[..], &options[..options.len() - 2], &["--json"]].concat())
            .json_and_code();
        assert_eq!(code, Some(1));
        assert_eq!(value["failed"].as_array().unwrap().len(), 2, "{command}");
        // without a good one there is nothing
        let question = &options[..options.len() - 2];
        let none = folder.run(&[&[command, "bad.csv", "nowhere.csv"], question].concat());
        none.expect_failure(1, &["none of 2 files"]);
        assert_eq!(none.out(), "");
    }
    folder
        .run(&["strokes", "--cuts-only", "bad.csv"])
        .expect_failure(1, &["`oops`"]);
}
