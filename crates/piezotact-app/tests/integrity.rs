//! Recordings that broke on their way, through every command that reads one; and sound ones, which raise nothing.
#![allow(
    clippy::print_stderr,
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test prints what it measured, and fails where it cannot"
)]

use std::fmt::Write as _;

use crate::support::{Folder, noise, shared, wav};
use serde_json::Value;

/// The kinds of warnings that say that a signal broke.
const BROKEN: [&str; 9] = [
    "channel_doubtful/frozen",
    "channel_doubtful/drop_outs",
    "channel_doubtful/mains_hum",
    "channel_doubtful/copied",
    "channel_doubtful/beyond_limit",
    "channel_doubtful/dead_while_driven",
    "channel_doubtful/clipped",
    "clipped",
    "channel_doubtful/dead",
];

fn broken(said: &Value) -> Vec<String> {
    let warnings = said["warnings"].as_array().unwrap();
    let kind = |warning: &Value| {
        let code = warning["code"].as_str()?;
        Some(match warning["fault"].as_str() {
            Some(fault) => format!("{code}/{fault}"),
            None => code.to_owned(),
        })
    };
    let kinds = warnings.iter().filter_map(kind);
    kinds
        .filter(|kind| BROKEN.contains(&kind.as_str()))
        .collect()
}

/// Active strokes, a platform, the shaker and a device of the twin: nothing broke.
#[test]
fn what_the_twin_records_is_whole() {
    let folder = Folder::new();
    for (bench, more) in [
        ("acttouch", "--sample S3 --strokes 3"),
        ("acttouch", "--sample M7 --strokes 2 --free"),
        ("triboair", "--sample S9 --strokes 2"),
        ("triboair", "--sample NO --strokes 2"),
        ("shaker", "--seconds 10"),
    ] {
        let call = format!("twin record --bench {bench} {more} --seed 5 --out run.parquet");
        let call: Vec<&str> = call.split(' ').collect();
        folder.run(&call).expect_success();
        let said = folder.run(&["info", "run.parquet", "--json"]).json();
        assert!(broken(&said).is_empty(), "{bench} {more}: {said}");
        std::fs::remove_file(folder.path("run.parquet")).unwrap();
    }
}

/// Every real recording: an instrumented fingertip, a skin of taxels, a hand-held tool, an analyser.
#[test]
fn real_recordings_are_whole() {
    let Some(data) = shared("data") else {
        return;
    };
    let folder = Folder::new();
    let mut looked_at = 0;
    for part in [
        "vibration/textsense",
        "vibration/fabricslide",
        "vibration/hapmat",
        "frf/lvm",
    ] {
        let mut files: Vec<_> = std::fs::read_dir(data.join(part))
            .unwrap()
            .map(|entry| entry.unwrap().path())
            .collect();
        files.sort();
        for file in files {
            let done = folder.run(&["info", file.to_str().unwrap(), "--json"]);
            // Some are damaged on purpose, and some are licences.
            let (true, Ok(said)) = (done.code() == Some(0), serde_json::from_str(&done.out()))
            else {
                continue;
            };
            looked_at += 1;
            assert!(broken(&said).is_empty(), "{}: {said}", file.display());
        }
    }
    assert!(looked_at > 20, "{looked_at}");
}

/// A table of `drive` and `response` at 5 kHz.
fn table(pairs: impl Iterator<Item = (f64, f64)>) -> String {
    let mut text = String::from("time (s),out (FS),nail (m/s2)\n");
    for (i, (drive, response)) in pairs.enumerate() {
        writeln!(text, "{},{drive},{response}", i as f64 / 5_000.0).unwrap();
    }
    text
}

/// A drive of noise within ±0.4, and what answers it.
fn measured(count: usize) -> Vec<(f64, f64)> {
    let drive: Vec<f64> = noise(count).map(|v| 0.8 * v).collect();
    (0..count)
        .map(|i| {
            let at = |k: usize| if i >= k { drive[i - k] } else { 0.0 };
            (
                drive[i],
                5.0 * at(3) + 3.0 * at(4) - 2.0 * at(6) + 1.0 * at(9),
            )
        })
        .collect()
}

/// What each defect of a table makes `info` and `transfer` say.
#[test]
fn what_broke_is_said_by_every_command() {
    let folder = Folder::new();
    let whole = measured(30_000);
    let peak = whole.iter().fold(0.0_f64, |peak, (_, y)| peak.max(y.abs()));
    type Defect<'a> = (
        &'a str,
        &'a str,
        &'a str,
        Box<dyn Fn(usize, (f64, f64)) -> (f64, f64) + 'a>,
    );
    let hum = |i: usize| {
        let line = |k: f64| (std::f64::consts::TAU * 50.0 * k * i as f64 / 5_000.0).sin();
        line(1.0) + 0.3 * line(2.0) + 0.5 * line(3.0)
    };
    let defects: [Defect<'_>; 6] = [
        ("whole", "", "", Box::new(|_, pair| pair)),
        (
            "dead",
            "channel_doubtful/drop_outs",
            "channel_doubtful/dead_while_driven",
            Box::new(|i, (x, y)| (x, if (8_000..15_500).contains(&i) { 0.0 } else { y })),
        ),
        (
            "clipped",
            "clipped",
            "channel_doubtful/clipped",
            Box::new(move |_, (x, y)| (x, y.clamp(-0.2 * peak, 0.2 * peak))),
        ),
        (
            "hum",
            "channel_doubtful/mains_hum",
            "channel_doubtful/mains_hum",
            Box::new(move |i, (x, y)| (x, y + 10.0 * hum(i))),
        ),
        (
            "copy",
            "channel_doubtful/copied",
            "channel_doubtful/copied",
            Box::new(|_, (x, _)| (x, 7.0 * x)),
        ),
        (
            "loud",
            "channel_doubtful/beyond_limit",
            "channel_doubtful/beyond_limit",
            Box::new(|_, (x, y)| (x * 8.7 / 0.4, y)),
        ),
    ];
    let mut texts = String::new();
    for (name, alone, as_pair, defect) in &defects {
        let pairs = whole.iter().enumerate().map(|(i, pair)| defect(i, *pair));
        folder.write("run.csv", table(pairs));
        let expected = |kind: &str| -> Vec<String> {
            Some(kind.to_owned())
                .filter(|kind| !kind.is_empty())
                .into_iter()
                .collect()
        };
        for command in [
            "info run.csv --json",
            "spectrum run.csv --channel nail --json",
            "score run.csv run.csv --channel nail --json",
        ] {
            let said = folder.run(&command.split(' ').collect::<Vec<_>>()).json();
            assert!(
                expected(alone)
                    .iter()
                    .all(|kind| broken(&said).contains(kind))
                    && (!alone.is_empty() || broken(&said).is_empty()),
                "{name}, {command}: {:?}",
                broken(&said)
            );
        }
        let command = "transfer run.csv --drive out --response nail --out tf.json --json";
        let said = folder.run(&command.split(' ').collect::<Vec<_>>()).json();
        assert_eq!(broken(&said), expected(as_pair), "{name}: {said}");
        for warning in said["warnings"].as_array().unwrap() {
            writeln!(texts, "{}", warning["text"].as_str().unwrap()).unwrap();
        }
    }
    eprintln!("{texts}");
    for sentence in [
        "`nail` has no signal once, longest for 1.50 s, while 25 % of the drive is played: the transfer function is about 2.5 dB too low; record again",
        "`nail` is `out` times 7.000: the same signal was recorded twice",
        "`out` reaches 8.70 of full scale, but only 1.00 can be played",
        "`nail` contains spectral lines of constant phase at 50, 100, 150 Hz",
    ] {
        assert!(texts.contains(sentence), "{sentence}\n{texts}");
    }
}

/// A channel of zeros, and one that never leaves one value, have no transfer function; `info` names them.
#[test]
fn a_dead_channel_is_refused_by_its_name() {
    let folder = Folder::new();
    let whole = measured(10_000);
    for value in [0.0, 9.81] {
        folder.write("run.csv", table(whole.iter().map(|(x, _)| (*x, value))));
        let said = folder.run(&["info", "run.csv", "--json"]).json();
        assert_eq!(broken(&said), ["channel_doubtful/dead"]);
        folder
            .run(&[
                "transfer",
                "run.csv",
                "--drive",
                "out",
                "--response",
                "nail",
                "--out",
                "tf.json",
            ])
            .expect_failure(
                1,
                &[
                    "expected the channel `nail` to hold a signal",
                    "check its cable",
                ],
            );
        assert!(!folder.path("tf.json").exists());
    }
}

/// Clipping is found in every format, once.
#[test]
fn clipping_is_said_once_whatever_the_format() {
    let folder = Folder::new();
    let clipped = || noise(20_000).map(|v| (2.0 * v).clamp(-0.6, 0.6));
    folder.write("run.wav", wav(clipped(), 5_000));
    let rows: String = clipped().map(|v| format!("{v}\n")).collect();
    folder.write("run.csv", format!("acceleration (m/s2)\n{rows}"));
    for call in [
        "info run.wav --scale 1m/s2 --json",
        "info run.csv --rate 5000 --json",
    ] {
        let said = folder.run(&call.split(' ').collect::<Vec<_>>()).json();
        assert_eq!(broken(&said), ["clipped"], "{call}: {said}");
        let warnings = said["warnings"].as_array().unwrap();
        let fraction = warnings
            .iter()
            .find_map(|warning| warning["fraction"].as_f64())
            .unwrap();
        assert!((fraction - 0.4).abs() < 0.01, "{call}: {fraction}");
    }
}
