//! `manipulate` as a black box: what is written, the chain that is kept, what is refused.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::f64::consts::TAU;

use crate::support::{self, Folder, noise, wav};
use piezotact::quantity::Acceleration;
use piezotact::series::Series;
use piezotact::spectrum::{WelchConfig, welch};
use piezotact_dataset::{ReadOptions, read_recording};
use serde_json::Value;

/// Two textures of 4 s at 5 kHz with their scales in sidecars: S2 has 3 m/s² rms, S13 0.6, and more at high frequencies.
fn two_textures() -> Folder {
    let folder = Folder::new();
    let raw: Vec<f64> = noise(20_001).collect();
    let smooth = raw.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    folder.write("S2.wav", wav(smooth, 5_000));
    let rough = raw.windows(2).map(|pair| 0.5 * (pair[0] - pair[1]));
    folder.write("S13.wav", wav(rough, 5_000));
    folder.write(
        "S2.wav.json",
        r#"{"full_scale": "15 m/s2", "condition": {"sample": "S2", "speed_m_s": 0.03}}"#,
    );
    folder.write("S13.wav.json", r#"{"full_scale": "3 m/s2"}"#);
    folder
}

fn series(folder: &Folder, name: &str) -> Series<Acceleration> {
    let contents = read_recording(&folder.path(name), &ReadOptions::default()).unwrap();
    contents.recording.series(None).unwrap()
}

fn shape(folder: &Folder, name: &str) -> Vec<f64> {
    let psd = welch(&series(folder, name), &WelchConfig::thesis_2024()).unwrap();
    let sum: f64 = psd.values.iter().sum();
    psd.values.iter().map(|v| v / sum).collect()
}

fn manipulate(folder: &Folder, arguments: &str) -> support::Done {
    let all: Vec<&str> = ["manipulate"]
        .into_iter()
        .chain(arguments.split(' '))
        .collect();
    folder.run(&all)
}

fn sidecar(folder: &Folder, name: &str) -> Value {
    let text = std::fs::read_to_string(folder.path(&format!("{name}.json"))).unwrap();
    serde_json::from_str(&text).unwrap()
}

/// The names of the operations in a sidecar, in their order.
fn operations(folder: &Folder, name: &str) -> Vec<String> {
    let file = sidecar(folder, name);
    let steps = file["provenance"]["lineage"]["steps"].as_array().unwrap();
    let name = |step: &Value| step["operation"]["name"].as_str().unwrap().to_owned();
    steps.iter().map(name).collect()
}

/// Must show: the rms equal to 0.1 %, the shape of the spectrum unchanged. In the file samples are 32-bit floats.
#[test]
fn s2_takes_the_level_of_s13_and_keeps_its_shape() {
    let folder = two_textures();
    let said = manipulate(
        &folder,
        "S2.wav --rms-of S13.wav --out S2inv.wav --report S2inv.html --json",
    )
    .json();
    let (inverted, other) = (series(&folder, "S2inv.wav"), series(&folder, "S13.wav"));
    assert!(
        (inverted.rms() / other.rms() - 1.0).abs() < 1e-3,
        "{} {}",
        inverted.rms(),
        other.rms()
    );
    let shapes = shape(&folder, "S2inv.wav")
        .into_iter()
        .zip(shape(&folder, "S2.wav"));
    let worst = shapes.map(|(a, b)| (a / b - 1.0).abs()).fold(0.0, f64::max);
    assert!(worst < 1e-4, "{worst:e}");
    assert_eq!(said["lineage"]["source"], "S2.wav");
    assert!(said["text"].as_str().unwrap().contains("rms of S13.wav"));
    assert_eq!(said["condition"]["sample"], "S2 (manipulated)");
    let report = std::fs::read_to_string(folder.path("S2inv.html")).unwrap();
    for part in ["rms of S13.wav", "rms before", "rms after", "<svg"] {
        assert!(report.contains(part), "no {part}");
    }
}

/// A gain before a loop and after it, a shift before and after a tilt: the order is that of the command line.
#[test]
fn operations_are_done_in_the_order_in_which_they_are_given() {
    let folder = two_textures();
    manipulate(
        &folder,
        "S2.wav --shift 20Hz --gain -3dB --tilt -3dB/oct@200Hz --gain +1 --randomise-phases --band 50..100:+6dB --out a.wav",
    )
    .expect_success();
    let expected = [
        "shifted",
        "gain",
        "tilted",
        "gain",
        "phases_randomised",
        "band_changed",
    ];
    assert_eq!(operations(&folder, "a.wav"), expected);
    manipulate(
        &folder,
        "S2.wav --out b.wav --band 50..100:remove --randomise-phases --seed 3 --gain 1dB --warp 1.25 --loop 10s --spectrum-of S13.wav",
    )
    .expect_success();
    let expected = [
        "band_changed",
        "phases_randomised",
        "gain",
        "warped",
        "looped",
        "spectrum_of",
    ];
    assert_eq!(operations(&folder, "b.wav"), expected);
    let b = series(&folder, "b.wav");
    assert_eq!(b.samples().len(), 50_000);
    // After a warp the speed is another.
    assert!(sidecar(&folder, "b.wav")["condition"]["speed_m_s"].is_null());
    // One seed, one texture.
    for (out, seed) in [("c.wav", "7"), ("d.wav", "7"), ("e.wav", "8")] {
        manipulate(
            &folder,
            &format!("S2.wav --randomise-phases --seed {seed} --out {out}"),
        )
        .expect_success();
    }
    assert_eq!(series(&folder, "c.wav"), series(&folder, "d.wav"));
    assert_ne!(series(&folder, "c.wav"), series(&folder, "e.wav"));
}

/// Manipulated again, and rendered: the whole chain is in the drive, with the transfer function and the gain.
#[test]
fn the_chain_is_kept_to_the_drive_and_to_what_was_played() {
    let folder = two_textures();
    manipulate(&folder, "S13.wav --gain -6dB --out S13soft.wav").expect_success();
    manipulate(&folder, "S2.wav --rms-of S13soft.wav --out one.wav").expect_success();
    manipulate(
        &folder,
        "one.wav --band 200..400:-3dB --loop 2s --out two.wav",
    )
    .expect_success();
    assert_eq!(
        operations(&folder, "two.wav"),
        ["rms_of", "band_changed", "looped"]
    );
    folder
        .run(&[
            "characterise",
            "--bench",
            support::BENCH,
            "--seconds",
            "10",
            "--out",
            "tf.json",
        ])
        .expect_success();
    folder
        .run(&[
            "render",
            "two.wav",
            "--transfer",
            "tf.json",
            "--out",
            "drive.wav",
        ])
        .expect_success();
    let expected = ["rms_of", "band_changed", "looped", "rendered"];
    assert_eq!(operations(&folder, "drive.wav"), expected);
    let file = sidecar(&folder, "drive.wav");
    let rendered = &file["provenance"]["lineage"]["steps"][3]["operation"];
    assert_eq!(rendered["transfer"], "tf.json");
    assert_eq!(rendered["gain"], "B3");
    assert_eq!(file["provenance"]["lineage"]["source"], "S2.wav");
    folder
        .run(&[
            "play",
            "drive.wav",
            "--bench",
            support::BENCH,
            "--record",
            "measured.parquet",
        ])
        .expect_success();
    for name in ["drive.wav", "measured.parquet"] {
        let said = folder.run(&["info", name]).out();
        for part in [
            "texture: S2.wav",
            "rms of S13.wav (gain -6.000 dB)",
            "200–400 Hz -3 dB",
            "cut to 2.000 s",
            "rendered over 20–1000 Hz with tf.json, amplifier gain B3",
        ] {
            assert!(said.contains(part), "{name}: no `{part}` in {said}");
        }
    }
}

/// Recordings of touch are cut first; a table without a scale of its own takes --scale, a WAV file with one keeps it.
#[test]
fn strokes_and_tables_are_textures_as_well() {
    let folder = two_textures();
    let record =
        "twin record --bench acttouch --sample S8 --speed 30mm/s --strokes 3 --out S8.parquet";
    folder
        .run(&record.split(' ').collect::<Vec<_>>())
        .expect_success();
    let said = manipulate(
        &folder,
        "S8.parquet --stroke 2 --rms-of S13.wav --of-stroke 1 --out S8b.wav --json",
    )
    .json();
    let first = &said["lineage"]["steps"][0]["operation"];
    assert_eq!(
        (&first["name"], &first["number"]),
        (&"stroke".into(), &2.into())
    );
    assert!(said["duration_s"].as_f64().unwrap() < 2.0);
    let said = manipulate(&folder, "S8.parquet --gain 1dB --out x.wav --json").json();
    assert!(
        said["warnings"].to_string().contains("use a single stroke"),
        "{said}"
    );
    manipulate(&folder, "S8.parquet --stroke 9 --gain 1dB --out x.wav").expect_failure(
        1,
        &[
            "a stroke from 1 to 3",
            "--stroke 9",
            "piezotact strokes --cuts-only",
        ],
    );
    let rows = noise(5_000).enumerate();
    let rows = rows.map(|(i, v)| format!("{},{}\n", i as f64 / 5000.0, 9.0 + v));
    folder.write(
        "own.csv",
        format!("time (s),nail (m/s2)\n{}", rows.collect::<String>()),
    );
    let said = manipulate(&folder, "own.csv --tilt 3dB/oct@200Hz --out own.wav --json").json();
    let mean = said["lineage"]["steps"][0]["operation"]["mean"]
        .as_f64()
        .unwrap();
    assert!((mean - 9.0).abs() < 0.05, "{mean}");
}

/// What gives a warning while a texture was made otherwise stands in its file: whoever opens it later sees it.
#[test]
fn warnings_stay_with_the_file() {
    let folder = two_textures();
    let clipped = noise(20_000).map(|v| (3.0 * v).clamp(-0.9, 0.9));
    folder.write("clipped.wav", wav(clipped, 5_000));
    manipulate(
        &folder,
        "S2.wav --scale 20m/s2 --rate 4000 --shift 400Hz --rms-of clipped.wav --of-scale 3m/s2 --out a.wav",
    )
    .expect_success();
    let said = folder.run(&["info", "a.wav", "--json"]).json();
    let warnings = said["warnings"].as_array().unwrap();
    let names: Vec<&str> = warnings
        .iter()
        .map(|d| match d["code"].as_str().unwrap() {
            "stated_differs" => d["what"].as_str().unwrap(),
            code => code,
        })
        .collect();
    for warning in ["scale", "rate_kept", "left_the_band", "clipped"] {
        assert!(names.contains(&warning), "no {warning} in {names:?}");
    }
    // And with what is made of it.
    manipulate(&folder, "S13.wav --spectrum-of a.wav --out b.wav").expect_success();
    let said = folder.run(&["info", "b.wav"]).out();
    assert!(said.contains("would be outside 0 to 2500 Hz"), "{said}");
    // Export keeps them as well.
    folder
        .run(&["export", "a.wav", "--out", "c.wav"])
        .expect_success();
    let said = folder.run(&["info", "c.wav"]).out();
    assert!(said.contains("would be outside 0 to 2500 Hz"), "{said}");
}

/// A level has no rate; a spectrum is brought to that of the texture, and this is said.
#[test]
fn another_texture_may_have_another_rate() {
    let folder = two_textures();
    let slow = noise(8_000).map(|v| 0.5 * v);
    folder.write("slow.wav", wav(slow, 2_000));
    let said = manipulate(
        &folder,
        "S2.wav --rms-of slow.wav --of-scale 3m/s2 --out a.wav --json",
    )
    .json();
    assert!(
        !said["warnings"].to_string().contains("rate_converted"),
        "{said}"
    );
    let said = manipulate(
        &folder,
        "S2.wav --spectrum-of slow.wav --of-scale 3m/s2 --out b.wav --json",
    )
    .json();
    assert!(
        said["warnings"].to_string().contains("rate_converted"),
        "{said}"
    );
    let b = series(&folder, "b.wav");
    let psd = welch(&b, &WelchConfig::thesis_2024()).unwrap();
    let at = |hz: f64| psd.values[(hz / psd.resolution_hz) as usize];
    assert!(
        at(2000.0) < 1e-6 * at(500.0),
        "{} {}",
        at(2000.0),
        at(500.0)
    );
}

#[test]
fn what_cannot_be_is_refused() {
    let folder = two_textures();
    let tone =
        |hz: f64, rate: f64| (0..8_000).map(move |i| 0.5 * (TAU * hz * f64::from(i) / rate).sin());
    folder.write("other.wav", wav(tone(100.0, 8_000.0), 8_000));
    folder.write("other.wav.json", r#"{"full_scale": "3 m/s2"}"#);
    folder.write("silent.wav", wav(std::iter::repeat_n(0.0, 5_000), 5_000));
    folder.write("silent.wav.json", r#"{"full_scale": "3 m/s2"}"#);
    folder.write("plain.wav", wav(tone(100.0, 5_000.0), 5_000));
    folder.write("two.wav", wav([0.5, -0.5].into_iter(), 5_000));
    folder.write("two.wav.json", r#"{"full_scale": "3 m/s2"}"#);
    for (arguments, code, parts) in [
        (
            "S2.wav --out x.wav",
            2,
            &["expected an operation", "--gain -3dB"][..],
        ),
        (
            "S2.wav --gain loud --out x.wav",
            2,
            &["expected a gain in dB"],
        ),
        (
            "S2.wav --gain nan --out x.wav",
            2,
            &["expected a gain in dB"],
        ),
        (
            "S2.wav --gain 500dB --out x.wav",
            2,
            &["-120 to 120 dB", "500 dB"],
        ),
        ("S2.wav --band 100..50:+6dB --out x.wav", 2, &["low < high"]),
        (
            "S2.wav --band 100..4000:+6dB --out x.wav",
            2,
            &["2500 Hz", "4000 Hz"],
        ),
        ("S2.wav --band 100..200 --out x.wav", 2, &["50..100:remove"]),
        ("S2.wav --tilt 3dB --out x.wav", 2, &["3dB/oct@200Hz"]),
        (
            "S2.wav --tilt 3dB/oct@9000Hz --out x.wav",
            2,
            &["a pivot", "9000 Hz"],
        ),
        (
            "S2.wav --shift 2600Hz --out x.wav",
            2,
            &["-2500 to 2500 Hz"],
        ),
        ("S2.wav --warp 0 --out x.wav", 2, &["0.1 to 10"]),
        (
            "S2.wav --warp 1.25:shorter --out x.wav",
            2,
            &["keep-length", "shorter"],
        ),
        ("S2.wav --warp 1.4142135 --out x.wav", 2, &["few decimals"]),
        (
            "S2.wav --gain 1dB --rms-band 50..100 --out x.wav",
            2,
            &["--rms-of"],
        ),
        (
            "S2.wav --loop 0s --out x.wav",
            2,
            &["a length from", "in between"],
        ),
        (
            "S2.wav --gain 1dB --out x.parquet",
            2,
            &["end in .wav", "found .parquet", "piezotact export"],
        ),
        ("S2.wav --gain 1dB --out x", 2, &["found no ending"]),
        (
            "S2.wav --gain 1dB --of-channel a --out x.wav",
            2,
            &["--rms-of or --spectrum-of with --of-channel"],
        ),
        (
            "S2.wav --gain 1dB --of-stroke 2 --out x.wav",
            2,
            &["leave --of-stroke out"],
        ),
        (
            "two.wav --gain 1dB --out x.wav",
            1,
            &["two.wav", "0.01 s or longer", "2 samples"],
        ),
        (
            "S2.wav --rms-of silent.wav --out x.wav",
            1,
            &["silent.wav", "constant"],
        ),
        (
            "silent.wav --gain 3dB --out x.wav",
            1,
            &["silent.wav", "constant"],
        ),
        ("plain.wav --gain 3dB --out x.wav", 1, &["--scale"]),
        (
            "S2.wav --rms-of missing.wav --out x.wav",
            1,
            &["missing.wav"],
        ),
        ("S2.wav --gain 3dB --out S2.wav", 2, &["would be replaced"]),
        (
            "S2.wav --rms-of S13.wav --out S13.wav",
            2,
            &["would be replaced"],
        ),
    ] {
        manipulate(&folder, arguments).expect_failure(code, parts);
    }
    assert!(!folder.names().contains(&"x.wav".to_owned()));
    // What leaves the band is said, not refused.
    let said = manipulate(&folder, "S13.wav --shift 400Hz --out x.wav --json").json();
    assert!(
        said["warnings"].to_string().contains("left_the_band"),
        "{said}"
    );
}

/// Backwards twice is forwards; once it has the same level and another waveform, and its lineage says so.
#[test]
fn a_texture_backwards() {
    let folder = Folder::new();
    folder
        .run(
            &"twin record --bench triboair --sample S8 --strokes 1 --out S8.wav"
                .split(' ')
                .collect::<Vec<_>>(),
        )
        .expect_success();
    let reversed = |from: &str, to: &str| {
        let done = folder.run(&["manipulate", from, "--reverse", "--out", to, "--json"]);
        done.expect_success();
        done.json()
    };
    let once = reversed("S8.wav", "back.wav");
    assert!(
        once["text"].as_str().unwrap().contains("time reversal"),
        "{once}"
    );
    reversed("back.wav", "forth.wav");
    let samples = |name: &str| {
        let options = ReadOptions::default();
        let contents = read_recording(&folder.path(name), &options).unwrap();
        contents.recording.channels()[0].samples.clone()
    };
    let (x, back, forth) = (samples("S8.wav"), samples("back.wav"), samples("forth.wav"));
    let mut backwards = back.clone();
    backwards.reverse();
    // The mean of the recording is taken away once.
    assert_eq!(backwards, forth);
    assert!(x.len() == back.len() && back != forth);
}

/// Labels and the start are kept; events where they have a place, shifted and cropped, and a step says where they have none.
#[test]
fn annotations_stay_with_a_texture() {
    let folder = two_textures();
    folder.write(
        "S2.wav.json",
        r#"{"full_scale": "15 m/s2", "started_at": "2024-03-01T10:22:33Z", "labels": {"session": "2"},
            "events": [{"onset_s": 0.5, "duration_s": 0.25, "kind": "stimulus"}, {"onset_s": 3.0, "duration_s": 0.0, "kind": "mark"}]}"#,
    );
    let before = sidecar(&folder, "S2.wav");
    for (operation, kept) in [
        ("--gain -3dB", Some(2)),
        ("--loop 2s", Some(1)),
        ("--reverse", None),
    ] {
        manipulate(&folder, &format!("S2.wav {operation} --out out.wav")).expect_success();
        let after = sidecar(&folder, "out.wav");
        for field in ["started_at", "labels"] {
            assert_eq!(after[field], before[field], "{operation}");
        }
        let events = after["events"].as_array().map(Vec::len);
        assert_eq!(events, kept, "{operation}");
        let steps = after["provenance"]["steps"].to_string();
        let said = steps.contains("2 event(s) of the recording were left out");
        assert_eq!(said, kept.is_none(), "{operation}: {steps}");
    }
}
