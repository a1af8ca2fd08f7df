//! The command as a black box: what it prints, what it writes, how it ends.
#![allow(
    clippy::print_stderr,
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test prints what it measured, and fails where it cannot"
)]

mod support;

use std::process::Stdio;
use std::time::{Duration, Instant};

use support::Folder;

const BENCH: &str = "twin:participant=1,seed=7";

/// A mono WAV file of 16-bit integers.
fn wav(samples: impl Iterator<Item = f64>, rate_hz: u32) -> Vec<u8> {
    let data: Vec<u8> = samples
        .flat_map(|v| ((v * 32_767.0).round() as i16).to_le_bytes())
        .collect();
    let mut bytes = b"RIFF".to_vec();
    bytes.extend((36 + data.len() as u32).to_le_bytes());
    bytes.extend(b"WAVEfmt ");
    bytes.extend(16u32.to_le_bytes());
    bytes.extend([1, 0, 1, 0]);
    bytes.extend(rate_hz.to_le_bytes());
    bytes.extend((rate_hz * 2).to_le_bytes());
    bytes.extend([2, 0, 16, 0]);
    bytes.extend(b"data");
    bytes.extend((data.len() as u32).to_le_bytes());
    bytes.extend(data);
    bytes
}

/// Noise-like samples of about 0.3 rms that hold something at every frequency.
fn noise(count: usize) -> impl Iterator<Item = f64> {
    let mut state = 1u64;
    (0..count).map(move |_| {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
    })
}

/// A folder with a texture, the transfer function of a twin, and what is wrong in one way or another.
fn prepared() -> Folder {
    let folder = Folder::new();
    folder.write("texture.wav", wav(noise(20_000), 5_000));
    folder
        .run(&[
            "characterise",
            "--bench",
            BENCH,
            "--seconds",
            "10",
            "--out",
            "tf.json",
        ])
        .expect_success();
    folder
}

const RENDER: [&str; 7] = [
    "render",
    "texture.wav",
    "--transfer",
    "tf.json",
    "--out",
    "drive.wav",
    "--scale",
];

#[test]
fn the_demo_ends_with_a_report_and_a_verdict() {
    let folder = Folder::new();
    let done = folder.run(&["demo", "--out", "demo", "--seed", "3"]);
    done.expect_success();
    let out = done.out();
    let last: Vec<&str> = out.lines().rev().take(2).collect();
    assert!(last[0].starts_with("passed: spectrum error "), "{out}");
    let report = last[1].strip_prefix("report: ").unwrap();
    let html = std::fs::read_to_string(folder.path(report)).unwrap();
    for part in [
        "Negative control",
        "device's own scale",
        "level-matched",
        "coherence",
        "Drive and its headroom",
        "<svg",
    ] {
        assert!(html.contains(part), "the report lacks {part}");
    }
    // Self-contained: nothing is fetched.
    for outside in ["<script", "<link", "src=", "http://", "https://", "url("] {
        let found = html
            .match_indices(outside)
            .filter(|(at, _)| !html[*at..].starts_with("http://www.w3.org/"));
        assert_eq!(found.count(), 0, "the report reaches for {outside}");
    }
    let demo = folder
        .run(&["demo", "--out", "demo", "--seed", "3", "--json"])
        .json();
    let number = |part: &str, key: &str| demo[part][key].as_f64().unwrap();
    assert!(number("verification", "error_db_rms") <= 1.0);
    assert!(number("verification", "waveform_correlation") >= 0.95);
    assert_eq!(
        demo["verification"]["band_hz"],
        serde_json::json!([30.0, 500.0])
    );
    // The wrong strategy of the thesis' figures 41–42 is wrong.
    assert!(
        number("straight", "error_db_rms") > 10.0,
        "{}",
        demo["straight"]
    );
    assert!(number("straight", "error_db_rms_level_matched") > 1.0);
}

#[test]
fn one_seed_gives_one_result() {
    let folder = Folder::new();
    for out in ["a", "b"] {
        folder
            .run(&["demo", "--out", out, "--seed", "9"])
            .expect_success();
    }
    for name in ["target.wav", "drive.wav", "measured.parquet", "tf.json"] {
        let (a, b) = (format!("a/{name}"), format!("b/{name}"));
        assert_eq!(
            std::fs::read(folder.path(&a)).unwrap(),
            std::fs::read(folder.path(&b)).unwrap(),
            "{name}"
        );
    }
}

#[test]
fn the_chain_of_commands_keeps_its_promises() {
    let folder = prepared();
    folder
        .run(&[&RENDER[..], &["2 m/s2"]].concat())
        .expect_success();
    folder
        .run(&[
            "play",
            "drive.wav",
            "--bench",
            BENCH,
            "--record",
            "measured.parquet",
        ])
        .expect_success();
    let verify = [
        "verify",
        "--target",
        "texture.wav",
        "--scale",
        "2 m/s2",
        "--measured",
        "measured.parquet",
        "--json",
    ];
    let verified = folder
        .run(
            &[
                &verify[..],
                &["--report", "report.html", "--transfer", "tf.json"],
            ]
            .concat(),
        )
        .json();
    for key in [
        "band_hz",
        "error_db_rms",
        "error_db_max",
        "level_error_db",
        "waveform_correlation",
        "clipped_fraction",
        "doubts",
    ] {
        assert!(!verified[key].is_null(), "{key}");
    }
    assert!(
        verified["error_db_rms"].as_f64().unwrap() < 1.0,
        "{verified}"
    );
    assert!(
        std::fs::read_to_string(folder.path("report.html"))
            .unwrap()
            .contains("Transfer function")
    );

    let spectrum = folder
        .run(&[
            "spectrum",
            "measured.parquet",
            "--channel",
            "acceleration",
            "--json",
        ])
        .json();
    assert_eq!(spectrum["frequency_hz"].as_array().unwrap().len(), 513);
    assert_eq!(spectrum["psd"].as_array().unwrap().len(), 513);
    assert_eq!(spectrum["unit"], "(m/s²)²/Hz");
    folder
        .run(&["spectrum", "measured.parquet", "--svg", "psd.svg"])
        .expect_success();
    assert!(
        std::fs::read_to_string(folder.path("psd.svg"))
            .unwrap()
            .starts_with("<svg")
    );
    let csv = folder.run(&["spectrum", "measured.parquet", "--csv"]).out();
    assert_eq!(csv.lines().count(), 514);

    let transfer: serde_json::Value =
        serde_json::from_slice(&std::fs::read(folder.path("tf.json")).unwrap()).unwrap();
    for key in ["frequency_hz", "real", "imaginary", "coherence"] {
        assert_eq!(transfer[key].as_array().unwrap().len(), 1025, "{key}");
    }
    assert_eq!(transfer["drive"]["gain"], "B3");
    let info = folder.run(&["info", "measured.parquet", "--json"]).json();
    assert_eq!(info["channels"].as_array().unwrap().len(), 3);
    assert_eq!(info["provenance"]["bench"], "twin");
    assert_eq!(info["rendering"]["headroom"]["limited_by"], "the amplifier");
    folder.run(&["info", "tf.json"]).expect_success();
    folder.run(&["info", "texture.wav"]).expect_success();
}

/// The transfer function from a kept recording is the one that was written while recording.
#[test]
fn a_kept_recording_gives_the_same_transfer_function() {
    let folder = Folder::new();
    let characterise = [
        "characterise",
        "--bench",
        BENCH,
        "--seconds",
        "10",
        "--out",
        "tf.json",
        "--record",
        "raw.parquet",
    ];
    folder.run(&characterise).expect_success();
    let transfer = [
        "transfer",
        "raw.parquet",
        "--drive",
        "drive",
        "--response",
        "acceleration",
        "--out",
        "again.json",
    ];
    folder.run(&transfer).expect_success();
    let read = |name: &str| -> serde_json::Value {
        serde_json::from_slice(&std::fs::read(folder.path(name)).unwrap()).unwrap()
    };
    let (first, again) = (read("tf.json"), read("again.json"));
    for key in [
        "real",
        "imaginary",
        "coherence",
        "drive",
        "drive_unit",
        "response_unit",
        "condition",
    ] {
        assert_eq!(first[key], again[key], "{key}");
    }
}

/// A run that is killed leaves a journal that can be read, and loses less than a second of what it had
/// acquired; the next run does not overwrite it.
#[cfg(unix)]
#[test]
fn a_killed_recording_is_readable() {
    let folder = Folder::new();
    let arguments = [
        "characterise",
        "--bench",
        BENCH,
        "--seconds",
        "600",
        "--out",
        "tf.json",
        "--record",
        "raw.parquet",
    ];
    let mut child = folder
        .command(&arguments)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let journal = folder.path("raw.parquet.part");
    let patience = Instant::now();
    // Three chunks of 2500 samples in three channels of 8 bytes.
    while std::fs::metadata(&journal).map_or(0, |file| file.len()) < 3 * 2500 * 3 * 8 {
        assert!(
            patience.elapsed() < Duration::from_secs(120),
            "the recording does not begin"
        );
        assert!(
            child.try_wait().unwrap().is_none(),
            "the recording ended before it could be killed"
        );
        std::thread::sleep(Duration::from_millis(1));
    }
    child.kill().unwrap();
    child.wait().unwrap();
    assert_eq!(
        folder.names(),
        ["raw.parquet.part"],
        "nothing half written but the journal"
    );
    let on_disk = std::fs::metadata(&journal).unwrap().len();
    let info = folder.run(&["info", "raw.parquet", "--json"]).json();
    let read = info["samples"].as_f64().unwrap();
    assert!(
        read >= 7500.0 && read * 24.0 > on_disk as f64 - 5000.0 * 24.0 - 8192.0,
        "{read} samples of {on_disk} bytes"
    );
    assert_eq!(info["doubts"][0]["doubt"], "interrupted");
    folder
        .run(&arguments)
        .expect_failure(1, &["raw.parquet.part", "interrupted", "moving it away"]);
    // A spectrum of what is there can be had.
    folder.run(&["spectrum", "raw.parquet"]).expect_success();
}

#[test]
fn a_file_that_cannot_be_read_is_named_with_what_to_do() {
    let folder = Folder::new();
    let whole = wav(noise(5_000), 5_000);
    folder.write("empty.wav", []);
    folder.write("cut.wav", &whole[..whole.len() / 2]);
    folder.write("head.wav", &whole[..20]);
    folder.write("other.wav", b"MATLAB 5.0 MAT-file, and more of it");
    folder.write("binary.dat", [7, 0, 1, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0]);
    folder.write("words.csv", "once upon a time\nthere was a finger\n");
    folder.write("nan.csv", "time (s),acc (m/s2)\n0,1\n0.001,NaN\n0.002,1\n");
    folder.write("decimal.csv", "time (ms),acc (g)\n0,1,5\n1,1,6\n");
    folder.write(
        "gap.csv",
        "time (s),acc (g)\n0,1\n0.001,1\n0.002,1\n0.9,1\n0.901,1\n",
    );
    folder.write("cut.parquet", b"PAR1 and then nothing");
    folder.write("notes.json", "{\"hello\": 1}");
    folder.write("scale.wav", &whole);
    folder.write(
        "scale.wav.json",
        "{\"full_scale\": {\"value\": 200, \"unit\": \"bananas\"}}",
    );
    let mut float_nan = whole.clone();
    // 32-bit float, one sample that is not a number.
    float_nan[20] = 3;
    float_nan[32] = 4;
    float_nan[34] = 32;
    float_nan[44..48].copy_from_slice(&f32::NAN.to_le_bytes());
    folder.write("nan.wav", float_nan);
    for (file, parts) in [
        (
            "absent.wav",
            &["absent.wav", "expected a file, found none"][..],
        ),
        (".", &["folder"]),
        ("empty.wav", &["an empty file"]),
        ("cut.wav", &["10000 bytes of samples", "cut short"]),
        ("head.wav", &["damaged"]),
        ("other.wav", &["a MATLAB file", "CSV"]),
        ("binary.dat", &["binary file of an unknown kind"]),
        ("words.csv", &["rows of numbers", "check the export"]),
        (
            "decimal.csv",
            &["one more, `5`, in row 2", "decimal commas"],
        ),
        ("gap.csv", &["a gap from 0.002 to 0.9"]),
        ("nan.csv", &["`NaN` in row 3, column `acc`"]),
        ("nan.wav", &["NaN at sample 0"]),
        ("cut.parquet", &["Parquet", "copy it again"]),
        ("notes.json", &["transfer function", "frequency_hz"]),
        ("scale.wav", &["scale.wav.json", "bananas"]),
    ] {
        folder.run(&["info", file]).expect_failure(1, parts);
    }
}

#[test]
fn what_does_not_go_together_is_refused_and_nothing_is_written() {
    let folder = prepared();
    folder.write(
        "words.json",
        "{\"frequency_hz\": [0, 1], \"real\": [1], \"imaginary\": [0, 0], \"coherence\": [1, 1]}",
    );
    folder.write("slow.wav", wav(noise(4_000), 1_000));
    folder.write("mono.csv", "time (s),acc (m/s2)\n0,1\n0.001,2\n0.002,1\n");
    folder.write("short.wav", wav(noise(300), 5_000));
    let before = folder.names();
    let render = |extra: &[&str]| {
        folder.run(
            &[
                &["render", "--transfer", "tf.json", "--out", "drive.wav"],
                extra,
            ]
            .concat(),
        )
    };
    // No physical scale is guessed.
    render(&["texture.wav"]).expect_failure(1, &["physical scale", "--scale", "texture.wav.json"]);
    render(&["texture.wav", "--scale", "200 N"]).expect_failure(1, &["m/s²", "in N"]);
    render(&["texture.wav", "--scale", "200"]).expect_failure(2, &["200 m/s2"]);
    // Another gain than the transfer function's.
    render(&["texture.wav", "--scale", "2 m/s2", "--gain", "B2"])
        .expect_failure(1, &["B3", "B2", "characterise at B2"]);
    // Another rate, whose half is below the band.
    render(&["slow.wav", "--scale", "2 m/s2"]).expect_failure(2, &["20–1000 Hz", "500 Hz"]);
    render(&["texture.wav", "--scale", "2 m/s2", "--band", "20..3000"])
        .expect_failure(2, &["2500 Hz"]);
    render(&["texture.wav", "--scale", "2 m/s2", "--band", "1000..20"])
        .expect_failure(2, &["20..1000"]);
    // More than full scale.
    render(&["texture.wav", "--scale", "200 m/s2"])
        .expect_failure(1, &["--level -", "--allow-clipping", "amplifier"]);
    folder
        .run(&[
            "render",
            "texture.wav",
            "--scale",
            "2 m/s2",
            "--transfer",
            "words.json",
            "--out",
            "drive.wav",
        ])
        .expect_failure(1, &["2 values in `real`", "found 1"]);
    folder
        .run(&[
            "render",
            "texture.wav",
            "--scale",
            "2 m/s2",
            "--transfer",
            "absent.json",
            "--out",
            "drive.wav",
        ])
        .expect_failure(1, &["absent.json"]);
    // One channel too few.
    folder
        .run(&[
            "transfer",
            "mono.csv",
            "--drive",
            "force",
            "--response",
            "acc",
            "--out",
            "new.json",
        ])
        .expect_failure(1, &["`force`", "acc [m/s²]"]);
    folder
        .run(&["spectrum", "short.wav"])
        .expect_failure(1, &["1024", "300", "shorter segment"]);
    folder
        .run(&["spectrum", "texture.wav", "--overlap", "1"])
        .expect_failure(2, &["overlap"]);
    folder
        .run(&["spectrum", "texture.wav", "--window", "hat"])
        .expect_failure(2, &["hann"]);
    folder
        .run(&[
            "characterise",
            "--bench",
            "twin:participant=one",
            "--out",
            "new.json",
        ])
        .expect_failure(2, &["participant=one"]);
    folder
        .run(&[
            "characterise",
            "--bench",
            BENCH,
            "--load",
            "-1",
            "--out",
            "new.json",
        ])
        .expect_failure(2, &["0.05 to 2", "-1"]);
    folder
        .run(&[
            "characterise",
            "--bench",
            BENCH,
            "--load",
            "9",
            "--out",
            "new.json",
        ])
        .expect_failure(2, &["0.05 to 2"]);
    assert_eq!(folder.names(), before, "a refusal writes nothing");
}

#[test]
fn a_drive_goes_only_to_the_device_it_was_made_for() {
    let folder = prepared();
    folder
        .run(&[&RENDER[..], &["2 m/s2"]].concat())
        .expect_success();
    let play = |drive: &str, bench: &str| {
        folder.run(&["play", drive, "--bench", bench, "--record", "m.parquet"])
    };
    play("drive.wav", "twin:gain=B2").expect_failure(1, &["B3", "B2"]);
    // Without its sidecar nobody knows which gain it is for.
    play("texture.wav", BENCH).expect_failure(1, &["gain", "--gain"]);
    folder
        .run(&[&RENDER[..], &["2 m/s2", "--rate", "44100"]].concat())
        .expect_success();
    play("drive.wav", BENCH).expect_failure(1, &["44100 Hz", "48000 Hz"]);
    assert!(
        !folder
            .names()
            .iter()
            .any(|name| name.starts_with("m.parquet"))
    );
}

/// Allowed clipping is played, measured, and doubted.
#[test]
fn allowed_clipping_is_doubted() {
    let folder = prepared();
    let render = [&RENDER[..], &["60 m/s2", "--allow-clipping", "--json"]].concat();
    let rendered = folder.run(&render).json();
    assert!(rendered["headroom"]["clipped_fraction"].as_f64().unwrap() > 0.0);
    assert!(
        rendered["doubts"].to_string().contains("clipped"),
        "{rendered}"
    );
    folder
        .run(&[
            "play",
            "drive.wav",
            "--bench",
            BENCH,
            "--record",
            "m.parquet",
        ])
        .expect_success();
    let verified = folder
        .run(&[
            "verify",
            "--target",
            "texture.wav",
            "--scale",
            "60 m/s2",
            "--measured",
            "m.parquet",
            "--json",
        ])
        .json_and_code();
    let (verified, code) = verified;
    assert_eq!(code, Some(3), "done, and not passed: {verified}");
    assert!(verified["clipped_fraction"].as_f64().unwrap() > 0.0);
    assert_eq!(verified["passed"], false);
}

/// A level that was changed on purpose is compared at that level, and said.
#[test]
fn a_changed_level_is_said() {
    let folder = prepared();
    folder
        .run(&[&RENDER[..], &["2 m/s2", "--level", "-6"]].concat())
        .expect_success();
    folder
        .run(&[
            "play",
            "drive.wav",
            "--bench",
            BENCH,
            "--record",
            "m.parquet",
        ])
        .expect_success();
    let verify = [
        "verify",
        "--target",
        "texture.wav",
        "--scale",
        "2 m/s2",
        "--measured",
        "m.parquet",
        "--json",
    ];
    let verified = folder.run(&verify).json();
    assert!(
        verified["level_error_db"].as_f64().unwrap().abs() < 1.0,
        "{verified}"
    );
    assert!(
        verified["doubts"]
            .to_string()
            .contains("-6.0 dB on purpose")
    );
}

/// What is advised on a refusal works when it is followed, whatever the level was.
#[test]
fn the_level_that_is_advised_fits() {
    let folder = prepared();
    let refused = folder.run(&[&RENDER[..], &["2 m/s2", "--level", "30"]].concat());
    refused.expect_failure(1, &["--level"]);
    let text = refused.err();
    let advised = text
        .split("--level ")
        .nth(1)
        .unwrap()
        .split(' ')
        .next()
        .unwrap();
    folder
        .run(&[&RENDER[..], &["2 m/s2", "--level", advised]].concat())
        .expect_success();
    let louder = (advised.parse::<f64>().unwrap() + 0.3).to_string();
    folder
        .run(&[&RENDER[..], &["2 m/s2", "--level", &louder]].concat())
        .expect_failure(1, &["--level"]);
}

/// Gravity on an accelerometer is no texture: it changes neither the drive nor the verification.
#[test]
fn an_offset_changes_nothing() {
    let folder = prepared();
    let table = |offset: f64| {
        let rows = noise(20_000)
            .enumerate()
            .map(|(i, v)| format!("{},{}\n", i as f64 / 5000.0, v + offset));
        format!("time (s),acc (m/s2)\n{}", rows.collect::<String>())
    };
    folder.write("plain.csv", table(0.0));
    folder.write("gravity.csv", table(9.80665));
    let peak = |target: &str| {
        let render = [
            "render",
            target,
            "--transfer",
            "tf.json",
            "--out",
            "drive.wav",
            "--json",
        ];
        folder.run(&render).json()["headroom"]["peak"]
            .as_f64()
            .unwrap()
    };
    let (gravity, plain) = (peak("gravity.csv"), peak("plain.csv"));
    assert!((gravity / plain - 1.0).abs() < 1e-6, "{gravity} {plain}");
    folder
        .run(&[
            "play",
            "drive.wav",
            "--bench",
            BENCH,
            "--record",
            "m.parquet",
        ])
        .expect_success();
    let verified = |target: &str| {
        let verified = folder
            .run(&[
                "verify",
                "--target",
                target,
                "--measured",
                "m.parquet",
                "--json",
            ])
            .json();
        (
            verified["waveform_correlation"].as_f64().unwrap(),
            verified["error_db_rms"].as_f64().unwrap(),
        )
    };
    let (a, b) = (verified("plain.csv"), verified("gravity.csv"));
    assert!(
        (a.0 - b.0).abs() < 1e-6 && (a.1 - b.1).abs() < 1e-3,
        "{a:?} {b:?}"
    );
}

/// A drive for one finger, played to another and under another load: played, and said.
#[test]
fn another_finger_is_doubted() {
    let folder = prepared();
    folder
        .run(&[&RENDER[..], &["2 m/s2"]].concat())
        .expect_success();
    let other = [
        "play",
        "drive.wav",
        "--bench",
        "twin:participant=5,seed=7",
        "--load",
        "0.6",
        "--record",
        "m.parquet",
    ];
    let played = folder.run(&other);
    played.expect_success();
    assert!(
        played.err().contains("participant P01") && played.err().contains("load 0.2 N"),
        "{}",
        played.err()
    );
    let verify = [
        "verify",
        "--target",
        "texture.wav",
        "--scale",
        "2 m/s2",
        "--measured",
        "m.parquet",
        "--json",
    ];
    let (verified, _) = folder.run(&verify).json_and_code();
    assert!(
        verified["doubts"].to_string().contains("other_condition"),
        "{verified}"
    );
}

/// No output takes the place of an input, and a measurement is not made when it could not be kept.
#[test]
fn outputs_are_looked_at_before_anything_is_done() {
    let folder = prepared();
    let characterise = |extra: &[&str]| {
        folder.run(&[&["characterise", "--bench", BENCH, "--seconds", "5"], extra].concat())
    };
    characterise(&["--out", "none/tf.json"]).expect_failure(1, &["none", "make it"]);
    characterise(&["--out", "a.json", "--record", "a.json"]).expect_failure(2, &["written twice"]);
    characterise(&["--out", "a.json", "--record", "r.parquet", "--segment", "1"])
        .expect_failure(2, &["segment"]);
    characterise(&["--out", "a.json", "--record", "r.parquet", "--peak", "1.5"])
        .expect_failure(2, &["1.5", "0.8"]);
    characterise(&[
        "--out",
        "a.json",
        "--record",
        "r.parquet",
        "--band",
        "10..4000",
    ])
    .expect_failure(2, &["5000 Hz"]);
    folder
        .run(&[
            "render",
            "texture.wav",
            "--scale",
            "2 m/s2",
            "--transfer",
            "tf.json",
            "--out",
            "tf.json",
        ])
        .expect_failure(2, &["would be replaced"]);
    assert_eq!(folder.names(), ["texture.wav", "tf.json"]);
    folder
        .run(&[
            "spectrum",
            "texture.wav",
            "--segment",
            "18446744073709551615",
        ])
        .expect_failure(1, &["20000"]);
    folder
        .run(&[
            "render",
            "texture.wav",
            "--transfer",
            "tf.json",
            "--out",
            "d.wav",
            "--rate",
            "4000000000",
        ])
        .expect_failure(2, &["768000"]);
}

/// A measurement of one's own, in a table, of a drive that was rendered at another level.
#[test]
fn a_drive_is_verified_with_a_measurement_of_one_s_own() {
    let folder = prepared();
    folder
        .run(&[&RENDER[..], &["2 m/s2", "--level", "-3"]].concat())
        .expect_success();
    folder
        .run(&[
            "play",
            "drive.wav",
            "--bench",
            BENCH,
            "--record",
            "m.parquet",
        ])
        .expect_success();
    let table = piezotact_dataset::read_recording(
        &folder.path("m.parquet"),
        &piezotact_dataset::ReadOptions::default(),
    );
    let recording = table.unwrap().recording;
    let rows = recording.channels()[1]
        .samples
        .iter()
        .enumerate()
        .map(|(i, v)| format!("{};{:.9};0\n", i as f64 / 5000.0, v));
    folder.write(
        "own.csv",
        format!(
            "time (s);nail (m/s2);palm (m/s2)\n{}",
            rows.collect::<String>()
        ),
    );
    let verify = [
        "verify",
        "--target",
        "texture.wav",
        "--scale",
        "2 m/s2",
        "--measured",
        "own.csv",
        "--json",
    ];
    folder
        .run(&verify)
        .expect_failure(1, &["nail [m/s²], palm [m/s²]"]);
    let with = [
        &verify[..],
        &["--measured-channel", "nail", "--drive", "drive.wav"],
    ]
    .concat();
    assert!(
        folder.run(&with).json()["level_error_db"]
            .as_f64()
            .unwrap()
            .abs()
            < 1.0
    );
}

/// A drive channel in volts becomes a drive when the output is described, and headroom knows the amplifier.
#[test]
fn a_device_of_one_s_own_is_described() {
    let folder = prepared();
    let rows = noise(20_000)
        .enumerate()
        .map(|(i, v)| format!("{},{},{}\n", i as f64 / 5000.0, v, 3.0 * v));
    folder.write(
        "bench.csv",
        format!(
            "time (s),drive (V),nail (m/s2)\n{}",
            rows.collect::<String>()
        ),
    );
    let transfer = [
        "transfer",
        "bench.csv",
        "--drive",
        "drive",
        "--response",
        "nail",
        "--out",
        "own.json",
    ];
    let described = [
        &transfer[..],
        &["--gain", "B2", "--volts-per-full-scale", "2"],
    ]
    .concat();
    folder.run(&described).expect_success();
    let render = [
        "render",
        "texture.wav",
        "--scale",
        "2 m/s2",
        "--transfer",
        "own.json",
        "--out",
        "d.wav",
        "--json",
    ];
    let rendered = folder.run(&render).json();
    assert_eq!(rendered["headroom"]["limited_by"], "the amplifier");
    // 3 m/s² a volt and 2 V a full scale: 6 m/s² a full scale, for a texture that peaks at about 1 m/s².
    let peak = rendered["headroom"]["peak"].as_f64().unwrap();
    assert!((0.1..0.25).contains(&peak), "{peak}");
    folder.run(&transfer).expect_success();
    folder.run(&render).expect_failure(1, &["found V"]);
}

/// Reading stops early, as in `piezotact spectrum … --json | head`: no panic, no error.
#[test]
fn a_reader_that_leaves_is_no_error() {
    let folder = Folder::new();
    folder.write("texture.wav", wav(noise(200_000), 5_000));
    let mut child = folder
        .command(&["spectrum", "texture.wav", "--segment", "100000", "--json"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let done = child.wait_with_output().unwrap();
    assert!(
        done.status.success(),
        "{}",
        String::from_utf8_lossy(&done.stderr)
    );
    assert!(!String::from_utf8_lossy(&done.stderr).contains("panicked"));
}

#[test]
fn every_command_has_help_with_an_example_and_json() {
    let folder = Folder::new();
    for command in [
        "demo",
        "info",
        "spectrum",
        "characterise",
        "transfer",
        "render",
        "play",
        "verify",
    ] {
        let help = folder.run(&[command, "--help"]).out();
        assert!(
            help.contains("Example:") && help.contains("--json"),
            "{command}: {help}"
        );
    }
}
