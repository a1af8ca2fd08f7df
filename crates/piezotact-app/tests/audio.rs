//! Sound devices, on the loop within the program: calibration, latency, the steps from characterising to verifying, and what fails.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use serde_json::Value;

use crate::support::{Folder, noise, wav};

/// The README's set-up, with `more` in its loop.
pub(crate) fn setup(more: &str) -> String {
    format!(
        r#"host = "loop"
rate_hz = 48000
buffer_frames = 1024
gain = "B3"
play = {{ drive = [1] }}
record = [
  {{ channel = 1, measures = "drive" }},
  {{ channel = 2, measures = "acceleration", mv_per_m_s2 = 10.2 }},
  {{ channel = 3, measures = "force", mv_per_n = 500 }},
]

[loop]
finger = "twin:participant=1,seed=7"
input_v_per_full_scale = 2.8284
{more}
"#
    )
}

fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap()
}

fn calibrated(more: &str) -> Folder {
    let folder = Folder::new();
    folder.write("setup.toml", setup(more));
    let done = folder.run(&[
        "sound",
        "calibrate",
        "setup.toml",
        "--input-volts",
        "2.8284",
        "--wires",
    ]);
    done.expect_success();
    folder
}

#[test]
fn the_steps_of_the_demo_run_on_a_sound_device() {
    let folder = calibrated("");
    folder.write("texture.wav", wav(noise(20_000).map(|v| v * 0.01), 5_000));
    let bench = "--bench=audio:setup.toml";
    let run = |args: &[&str]| folder.run(args).expect_success();
    run(&["characterise", bench, "--seconds", "20", "--out", "tf.json"]);
    let twin = "--bench=twin:participant=1,seed=7";
    run(&[
        "characterise",
        twin,
        "--seconds",
        "20",
        "--out",
        "twin.json",
    ]);
    let at_hz: Vec<f64> = (1..=20).map(|i| 48.0 * f64::from(i)).collect();
    let [sound, alone] = ["tf.json", "twin.json"].map(|file| {
        let text = std::fs::read_to_string(folder.path(file)).unwrap();
        crate::levels::levels_db(&text, &at_hz)
    });
    // Another noise of the sensor, and lines of 2.40 and 2.44 Hz.
    let apart = sound
        .iter()
        .zip(&alone)
        .map(|(a, b)| (a - b).abs())
        .fold(0.0, f64::max);
    assert!(apart < 0.25, "{apart}: {sound:?} {alone:?}");
    let render = [
        "render",
        "texture.wav",
        "--scale",
        "200 m/s2",
        "--transfer",
        "tf.json",
    ];
    run(&[
        &render[..],
        &["--mode", "texture", bench, "--out", "drive.wav"],
    ]
    .concat());
    run(&["play", "drive.wav", bench, "--record", "measured.parquet"]);
    let told = folder.run(&["info", "measured.parquet"]).out();
    for part in [
        "calibrated on",
        "latency not measured",
        "playback_onset",
        "digital twin",
    ] {
        assert!(told.contains(part), "{part}: {told}");
    }
    let verify = ["verify", "--target", "texture.wav", "--scale", "200 m/s2"];
    let done = folder.run(&[&verify[..], &["--measured", "measured.parquet", "--json"]].concat());
    let verified = json(&done.out());
    let rms_db = verified["error_db_rms"].as_f64().unwrap();
    assert!(rms_db < 0.5, "{rms_db}");
}

#[test]
fn a_panel_runs_on_a_sound_device() {
    let folder = calibrated("");
    let done = folder.run(&[
        "panel",
        "run",
        "--bench",
        "audio:setup.toml",
        "--participants",
        "1,2",
        "--loads",
        "0.2",
        "--seconds",
        "8",
        "--out",
        "panel",
    ]);
    done.expect_success();
    let analysed = folder.run(&["panel", "analyse", "panel", "--json"]);
    let text = analysed.out();
    assert!(text.contains("P01") && text.contains("P02"), "{text}");
}

#[test]
fn latency_stands_beside_the_set_up_and_in_later_recordings() {
    let folder = calibrated("");
    let done = folder.run(&[
        "sound",
        "latency",
        "setup.toml",
        "--restarts",
        "10",
        "--json",
    ]);
    done.expect_success();
    let found = json(&done.out());
    let median_s = found["latency"]["median_s"].as_f64().unwrap();
    // 1500 frames of the loop and three of its line, the finger's 20 ms, and a buffer that the input is behind.
    let expected_s = 1_503.0 / 48_000.0 + 0.02;
    assert!(
        (median_s - expected_s).abs() <= 1_024.0 / 48_000.0,
        "{median_s}"
    );
    assert_eq!(found["runs"].as_array().unwrap().len(), 10);
    folder.write("drive.wav", wav(noise(48_000).map(|v| 0.2 * v), 48_000));
    let play = [
        "play",
        "drive.wav",
        "--bench",
        "audio:setup.toml",
        "--gain",
        "B3",
        "--record",
        "m.parquet",
    ];
    folder.run(&play).expect_success();
    assert!(
        folder
            .run(&["info", "m.parquet"])
            .out()
            .contains("output to input in")
    );
}

#[test]
fn a_level_that_changed_is_refused_and_other_devices_too() {
    let folder = calibrated("");
    folder.write("drive.wav", wav(noise(48_000).map(|v| 0.2 * v), 48_000));
    let play = [
        "play",
        "drive.wav",
        "--bench",
        "audio:setup.toml",
        "--gain",
        "B3",
        "--record",
        "m.parquet",
    ];
    for (more, part) in [
        ("gain = 0.49", "dB off"),
        ("gain = -0.5", "inverted"),
        ("gain = 0.0", "loopback cable"),
    ] {
        folder.write("setup.toml", setup(more));
        let done = folder.run(&play);
        assert_eq!(done.code(), Some(1), "{}", done.err());
        assert!(done.err().contains(part), "{more}: {}", done.err());
        assert!(!folder.path("m.parquet").exists());
    }
    folder.write("setup.toml", setup("gain = 0.5"));
    folder.run(&play).expect_success();
    folder.write("setup.toml", setup("").replace("48000", "44100"));
    let done = folder.run(&[
        "characterise",
        "--bench",
        "audio:setup.toml",
        "--out",
        "tf.json",
    ]);
    assert!(
        done.err().contains("calibrate this device"),
        "{}",
        done.err()
    );
}

#[test]
fn sensors_and_cables_are_calibrated() {
    let folder = Folder::new();
    folder.write("setup.toml", setup("on_calibrator = 2"));
    let done = folder.run(&[
        "sound",
        "calibrate",
        "setup.toml",
        "--exciter",
        "2",
        "--voltmeter",
        "0.4999",
        "--json",
    ]);
    done.expect_success();
    let found = json(&done.out());
    let per_full_scale = found["inputs"][0]["per_full_scale"].as_f64().unwrap();
    // 10.2 mV per m/s² into 2.8284 V at full scale.
    assert!(
        (per_full_scale / (2.8284 / 0.0102) - 1.0).abs() < 1e-3,
        "{per_full_scale}"
    );
    // 0.5 of full scale: 0.35355 of it rms.
    let volts = found["output"]["v_per_full_scale"].as_f64().unwrap();
    assert!((volts - 0.4999 / 0.353_553).abs() < 1e-4, "{volts}");
    // No calibrator on it.
    let done = folder.run(&["sound", "calibrate", "setup.toml", "--exciter", "3"]);
    assert!(
        done.err().contains("switch the calibrator on"),
        "{}",
        done.err()
    );
    let done = folder.run(&["sound", "calibrate", "setup.toml", "--exciter", "1"]);
    assert_eq!(done.code(), Some(2), "{}", done.err());
    // A loopback on another input.
    let wrong = setup("").replace("channel = 1, measures", "channel = 4, measures");
    folder.write(
        "crossed.toml",
        wrong.replace("channel = 2, measures", "channel = 1, measures"),
    );
    let done = folder.run(&["sound", "calibrate", "crossed.toml", "--wires"]);
    assert!(
        done.code() == Some(0) || done.err().contains("loopback"),
        "{}",
        done.err()
    );
}

#[test]
fn faults_of_a_device_end_in_order_and_stand_in_the_record() {
    let folder = Folder::new();
    folder.write("drive.wav", wav(noise(96_000).map(|v| 0.2 * v), 48_000));
    let play = |more: &str, record: &str| {
        folder.write("setup.toml", setup(more));
        folder.run(&[
            "play",
            "drive.wav",
            "--bench",
            "audio:setup.toml",
            "--record",
            record,
        ])
    };
    let done = play(
        "faults = [{ what = \"underrun\", at_s = 1.5, for_s = 0.02 }]",
        "a.parquet",
    );
    done.expect_success();
    let told = folder.run(&["info", "a.parquet"]).out();
    assert!(told.contains("playback_ran_dry"), "{told}");
    let done = play("faults = [{ what = \"removed\", at_s = 1.5 }]", "b.parquet");
    assert_eq!(done.code(), Some(1), "{}", done.err());
    assert!(done.err().contains("no longer answers"), "{}", done.err());
    // What was recorded until then is there.
    let told = folder.run(&["info", "b.parquet"]).out();
    assert!(told.contains("acceleration"), "{told}");
}

#[test]
fn devices_are_listed_and_unknown_hosts_named() {
    let folder = Folder::new();
    let done = folder.run(&["sound", "devices", "--json"]);
    done.expect_success();
    assert_eq!(json(&done.out())["schema"], "sound_devices");
    let done = folder.run(&["sound", "devices", "--host", "asio"]);
    assert!(
        done.err().contains("without the host `asio`"),
        "{}",
        done.err()
    );
    folder.write("setup.toml", "host = \"alsa\"\noutput = \"hw:9,9\"\ninput = \"hw:9,9\"\nrate_hz = 48000\nplay = { drive = [1] }\nrecord = [{ channel = 1, measures = \"drive\" }]\n");
    let done = folder.run(&["sound", "latency", "setup.toml"]);
    assert_eq!(done.code(), Some(1), "{}", done.err());
    assert!(done.err().contains("hw:9,9"), "{}", done.err());
}
