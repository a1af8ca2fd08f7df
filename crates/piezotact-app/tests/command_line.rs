//! The command as a black box: what it prints, what it writes, how it ends.
#![allow(
    clippy::print_stderr,
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test prints what it measured, and fails where it cannot"
)]

use std::process::Stdio;
use std::time::{Duration, Instant};

use crate::support::{BENCH, COMMANDS, Folder, RENDER, noise, prepared, wav};

#[test]
fn the_demo_ends_with_a_report_and_a_verdict() {
    let folder = Folder::new();
    let done = folder.run(&["demo", "--out", "demo", "--seed", "3"]);
    done.expect_success();
    let out = done.out();
    assert!(out.starts_with("passed over 30–500 Hz: level "), "{out}");
    let last = out.lines().next_back().unwrap();
    let report = last.strip_prefix("report: ").unwrap();
    let html = std::fs::read_to_string(folder.path(report)).unwrap();
    for part in [
        "Negative control",
        "sent directly, unscaled",
        "level-matched",
        "coherence",
        "Drive and its headroom",
        "<svg",
    ] {
        assert!(html.contains(part), "the report lacks {part}");
    }
    // Self-contained: nothing is fetched.
    crate::support::self_contained(&html);
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
        number("uncompensated", "error_db_rms") > 10.0,
        "{}",
        demo["uncompensated"]
    );
    assert!(number("uncompensated", "error_db_rms_level_matched") > 1.0);
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
        "warnings",
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
        .run(&[
            "spectrum",
            "measured.parquet",
            "--csv",
            "psd.csv",
            "--report",
            "spectrum.html",
            "--figures",
            "spectrum",
        ])
        .expect_success();
    assert!(
        std::fs::read_to_string(folder.path("spectrum/01-power-spectral-density.svg"))
            .unwrap()
            .starts_with("<svg")
    );
    let csv = std::fs::read_to_string(folder.path("psd.csv")).unwrap();
    assert_eq!(csv.lines().count(), 514);
    assert!(csv.starts_with("frequency_hz,psd ((m/s²)²/Hz)"), "{csv}");

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
    // Segments without a line in the excited band show nothing of it.
    let short = [&transfer[..], &["--segment", "2"]].concat();
    folder
        .run(&short)
        .expect_failure(2, &["a segment of 5 samples or more", "found 2"]);
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
    assert_eq!(info["warnings"][0]["code"], "interrupted");
    // A spectrum of what is there can be had.
    folder.run(&["spectrum", "raw.parquet"]).expect_success();
    // It does not block the next recording of that name, and is kept beside it.
    let mut shorter = arguments;
    shorter[4] = "5";
    let again = folder.run(&shorter);
    again.expect_success();
    let aside = "raw.parquet.interrupted-1.part";
    assert!(again.err().contains(aside), "{}", again.err());
    let info = folder.run(&["info", aside, "--json"]).json();
    assert_eq!(info["samples"].as_f64().unwrap(), read);
}

/// Allowed clipping is played, measured, and reported.
#[test]
fn allowed_clipping_is_reported() {
    let folder = prepared();
    let render = [&RENDER[..], &["60 m/s2", "--allow-clipping", "--json"]].concat();
    let rendered = folder.run(&render).json();
    assert!(rendered["headroom"]["clipped_fraction"].as_f64().unwrap() > 0.0);
    assert!(
        rendered["warnings"].to_string().contains("clipped"),
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
        (verified["level_db"].as_f64().unwrap() + 6.0).abs() < 1e-9,
        "{verified}"
    );
    let said = verified["sentence"].as_str().unwrap();
    assert!(
        said.contains("rendered at −6.0 dB and compared at that level"),
        "{said}"
    );
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
fn another_finger_is_reported() {
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
        verified["warnings"]
            .to_string()
            .contains(r#""what":"rendered_for""#),
        "{verified}"
    );
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
    // Without units it is taken as what rendering needs, and said.
    let rows = noise(20_000).map(|v| format!("{},{}\n", 0.5 * v, 3.0 * v));
    folder.write(
        "bench.csv",
        format!("drive,nail\n{}", rows.collect::<String>()),
    );
    folder
        .run(&[&transfer[..], &["--rate", "5000"]].concat())
        .expect_success();
    let warnings = folder
        .run(&[&render[..], &["--gain", "B3"]].concat())
        .json()["warnings"]
        .to_string();
    assert!(
        warnings.contains("has no unit") && warnings.contains("device_not_described"),
        "{warnings}"
    );
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
fn the_program_has_one_name_completions_and_man_pages() {
    let folder = Folder::new();
    let version = folder.run(&["--version"]).out();
    let expected = concat!("piezotact ", env!("CARGO_PKG_VERSION"));
    assert_eq!(version.trim_end(), expected);
    folder.run(&["manual", "."]).expect_success();
    let read = |name: &str| std::fs::read_to_string(folder.path(name)).unwrap();
    for name in ["piezotact.bash", "piezotact.fish", "_piezotact"] {
        let script = read(&format!("completions/{name}"));
        for word in ["characterise", "noise-ratio"] {
            assert!(script.contains(word), "{name} does not complete {word}");
        }
    }
    // A lean build has no manuals of what is below the commands that it lacks.
    let all = if cfg!(feature = "every-command") {
        COMMANDS
    } else {
        &["demo"]
    };
    for command in all {
        let name = format!("man/piezotact-{}.1", command.replace(' ', "-"));
        let page = read(&name);
        assert!(
            page.starts_with(".ie") && page.contains("SYNOPSIS"),
            "{name}"
        );
    }
    let refused = folder.run(&["manual", "man/piezotact.1"]);
    assert_eq!(refused.code(), Some(1));
    assert!(
        refused.err().contains("man/piezotact.1"),
        "{}",
        refused.err()
    );
}
