//! What goes to other devices and programs: each ending end to end, what each loses is said, and what cannot be carried
//! is refused in a sentence.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test fails where it cannot go on"
)]

use crate::support::{self, BENCH, Folder, noise, shared, wav};
use piezotact::Warning;
use piezotact::quantity::{Acceleration, Drive, SampleRate};
use piezotact::recording::RecordingWarning;
use piezotact::resample::resample;
use piezotact_dataset::haptic::{parse_hjif, read_haptic};
use piezotact_dataset::{ReadOptions, holds_transfer, read_recording, read_transfer};
use serde_json::Value;

const SCALE: [&str; 2] = ["--scale", "20 m/s2"];

fn tone(seconds: usize, rate_hz: u32) -> impl Iterator<Item = f64> {
    (0..seconds * rate_hz as usize).map(move |i| {
        let t = i as f64 / f64::from(rate_hz);
        0.4 * (1.0 + 0.3 * (5.0 * t).sin()) * (std::f64::consts::TAU * 150.0 * t).sin()
    })
}

fn folder() -> Folder {
    let folder = Folder::new();
    folder.write("texture.wav", wav(tone(2, 5_000), 5_000));
    folder
}

fn export(folder: &Folder, input: &str, out: &str, extra: &[&str]) -> support::Done {
    folder.run(&[&["export", input, "--out", out], extra].concat())
}

/// What the JSON says is lost.
fn lost(json: &Value) -> Vec<String> {
    json["warnings"]
        .as_array()
        .unwrap()
        .iter()
        .filter(|warning| warning["code"] == "format_loses")
        .map(|warning| warning["text"].as_str().unwrap().to_owned())
        .collect()
}

#[test]
fn a_texture_goes_to_a_sound_output_and_back() {
    let folder = folder();
    let done = export(&folder, "texture.wav", "out.wav", &SCALE);
    done.expect_success();
    assert!(
        done.err().contains("5000") && done.err().contains("48000"),
        "{}",
        done.err()
    );
    let bytes = std::fs::read(folder.path("out.wav")).unwrap();
    // 32-bit float, one channel, 48 kHz.
    assert_eq!((bytes[20], bytes[22], bytes[34]), (3, 1, 32));
    assert_eq!(
        u32::from_le_bytes(bytes[24..28].try_into().unwrap()),
        48_000
    );
    let options = ReadOptions {
        scale: Some("20 m/s2".parse().unwrap()),
        rate: None,
        ..ReadOptions::default()
    };
    let original = read_recording(&folder.path("texture.wav"), &options)
        .unwrap()
        .recording;
    let original = original.series::<Acceleration>(None).unwrap();
    let original = resample(&original, SampleRate::new(48_000.0).unwrap()).unwrap();
    // The sidecar says what full scale is.
    let back = read_recording(&folder.path("out.wav"), &ReadOptions::default()).unwrap();
    let back = back.recording.series::<Acceleration>(None).unwrap();
    assert_eq!(back.samples().len(), original.samples().len());
    for (a, b) in back.samples().iter().zip(original.samples()) {
        // Single precision of 10 m/s², and the mean of a tone that is cut off.
        assert!((a - b).abs() < 2e-2, "{a} {b}");
    }
}

#[test]
fn a_texture_goes_into_a_clip_and_comes_back_with_its_level() {
    let folder = folder();
    let json = export(
        &folder,
        "texture.wav",
        "out.haptic",
        &[&SCALE[..], &["--json"]].concat(),
    )
    .json();
    let said = lost(&json);
    assert_eq!(said.len(), 3, "{said:?}");
    for (said, part) in said
        .iter()
        .zip(["the waveform", "frequencies in Hz", "a physical unit"])
    {
        assert!(said.contains(part), "{said}");
    }
    let full_scale = json["full_scale"]["value"].as_f64().unwrap();
    assert!((10.0..11.0).contains(&full_scale), "{full_scale}");
    let clip = read_haptic(&folder.path("out.haptic")).unwrap();
    // 25 breakpoints a second for 2 s.
    assert_eq!(clip.envelopes.amplitude().len(), 51);
    assert_eq!(clip.metadata.source, "texture.wav");
    let scale = format!("{full_scale} m/s2");
    let info = folder
        .run(&["info", "out.haptic", "--scale", &scale, "--json"])
        .json();
    assert_eq!(info["kind"], "haptic clip");
    assert_eq!(info["rate_hz"], 8000.0);
    let original = folder
        .run(&["info", "texture.wav", "--scale", "20 m/s2", "--json"])
        .json();
    let level = |json: &Value| json["channels"][0]["standard_deviation"].as_f64().unwrap();
    let ratio = level(&info) / level(&original);
    // Envelopes under windows of 80 ms follow a swing of 1.26 s.
    assert!((ratio - 1.0).abs() < 0.02, "{ratio}");
    // Played at another rate.
    let info = folder
        .run(&["info", "out.haptic", "--rate", "4000", "--json"])
        .json();
    assert_eq!(info["rate_hz"], 4000.0);
    let console = export(&folder, "texture.wav", "again.haptic", &SCALE);
    assert!(
        console
            .err()
            .contains("warning: .haptic cannot store the waveform"),
        "{}",
        console.err()
    );
    assert!(
        console.out().contains("haptic clip, 1 corresponds to 10."),
        "{}",
        console.out()
    );
    // And on to an iPhone.
    let json = export(
        &folder,
        "texture.wav",
        "out.ahap",
        &[&SCALE[..], &["--json"]].concat(),
    )
    .json();
    assert!(
        lost(&json).iter().all(|said| said.starts_with("AHAP")),
        "{json}"
    );
    let pattern: Value =
        serde_json::from_slice(&std::fs::read(folder.path("out.ahap")).unwrap()).unwrap();
    // 51 points in curves of 16 that share their ends, twice, and one event of 2 s.
    assert_eq!(pattern["Pattern"].as_array().unwrap().len(), 9);
    assert_eq!(pattern["Pattern"][8]["Event"]["EventDuration"], 2.0);
}

#[test]
fn a_clip_becomes_the_ahap_that_its_makers_expect() {
    let (Some(clip), Some(expected)) = (
        shared("data/haptic/haptic/valid_v1_multiple_emphasis.haptic"),
        shared("data/haptic/haptic/valid_v1_multiple_transients.ahap"),
    ) else {
        return;
    };
    let folder = Folder::new();
    let json = export(&folder, clip.to_str().unwrap(), "out.ahap", &["--json"]).json();
    assert!(
        lost(&json)
            .iter()
            .any(|said| said.contains("the first breakpoint"))
    );
    let ours: Value =
        serde_json::from_slice(&std::fs::read(folder.path("out.ahap")).unwrap()).unwrap();
    let theirs: Value = serde_json::from_slice(&std::fs::read(expected).unwrap()).unwrap();
    let count = |json: &Value| json["Pattern"].as_array().unwrap().len();
    assert_eq!((count(&ours), count(&theirs)), (22, 22));
    for (ours, theirs) in ours["Pattern"]
        .as_array()
        .unwrap()
        .iter()
        .zip(theirs["Pattern"].as_array().unwrap())
    {
        let intensity = "/Event/EventParameters/0/ParameterValue";
        if let (Some(a), Some(b)) = (ours.pointer(intensity), theirs.pointer(intensity)) {
            assert!((a.as_f64().unwrap() - b.as_f64().unwrap()).abs() < 1e-7);
        }
    }
    // A clip as a target: what it holds is analysed.
    folder
        .run(&["spectrum", clip.to_str().unwrap(), "--json"])
        .expect_success();
}

#[test]
fn a_drive_goes_into_hjif_for_the_device_it_was_made_for() {
    let folder = folder();
    let characterise = [
        "characterise",
        "--bench",
        BENCH,
        "--seconds",
        "10",
        "--out",
        "tf.json",
    ];
    folder.run(&characterise).expect_success();
    folder
        .run(&[
            "render",
            "texture.wav",
            "--transfer",
            "tf.json",
            "--scale",
            "2 m/s2",
            "--out",
            "drive.wav",
        ])
        .expect_success();
    let json = export(
        &folder,
        "drive.wav",
        "out.hjif",
        &["--transfer", "tf.json", "--json"],
    )
    .json();
    assert_eq!(json["rate_hz"], 8000.0);
    let said = lost(&json);
    assert!(
        said.iter()
            .any(|said| said.contains("here positions are times")),
        "{said:?}"
    );
    let path = folder.path("out.hjif");
    let file = parse_hjif(&path, &std::fs::read(&path).unwrap()).unwrap();
    assert_eq!(file.departures(), Vec::<String>::new());
    let perception = &file.perceptions[0];
    assert_eq!(perception.perception_modality, "Vibrotactile Texture");
    let device = &perception.reference_devices[0];
    assert_eq!(
        (device.kind.as_deref(), device.maximum_voltage),
        (Some("Piezo"), Some(75.0))
    );
    assert_eq!(
        (device.minimum_frequency, device.maximum_frequency),
        (Some(20.0), Some(1000.0))
    );
    assert!(
        device
            .resonance_frequency
            .is_some_and(|hz| (20.0..=1000.0).contains(&hz))
    );
    // Below its rate of 48 kHz a drive of at most 1 kHz is the same.
    let drive = |name: &str| {
        let recording = read_recording(&folder.path(name), &ReadOptions::default())
            .unwrap()
            .recording;
        recording.series::<Drive>(None).unwrap()
    };
    let original = resample(&drive("drive.wav"), SampleRate::new(8000.0).unwrap()).unwrap();
    for (a, b) in drive("out.hjif").samples().iter().zip(original.samples()) {
        assert!((a - b).abs() < 1e-5, "{a} {b}");
    }
    let info = folder.run(&["info", "out.hjif", "--json"]).json();
    assert_eq!(info["kind"], "MPEG haptics JSON (HJIF)");
    // Without the transfer function, what the drive itself says.
    export(&folder, "drive.wav", "alone.hjif", &[]).expect_success();
    let path = folder.path("alone.hjif");
    let file = parse_hjif(&path, &std::fs::read(&path).unwrap()).unwrap();
    let device = &file.perceptions[0].reference_devices[0];
    assert_eq!(
        (device.maximum_voltage, device.resonance_frequency),
        (Some(75.0), None)
    );
    // The drive as audio keeps how it was made.
    export(&folder, "drive.wav", "audio.wav", &[]).expect_success();
    let audio = read_recording(&folder.path("audio.wav"), &ReadOptions::default()).unwrap();
    assert!(audio.rendering.is_some());
}

#[test]
fn signals_and_transfer_functions_go_into_universal_files() {
    let folder = folder();
    let rows = noise(3_000)
        .enumerate()
        .map(|(i, v)| format!("{},{},{}\n", i as f64 / 5000.0, v, 3.0 * v));
    folder.write(
        "bench.csv",
        format!(
            "time (s),drive (FS),nail (m/s2)\n{}",
            rows.collect::<String>()
        ),
    );
    let json = export(&folder, "bench.csv", "bench.uff", &["--json"]).json();
    assert!(lost(&json)[0].contains("the condition"), "{json}");
    let info = folder.run(&["info", "bench.uff", "--json"]).json();
    assert_eq!(info["rate_hz"], 5000.0);
    let names: Vec<&str> = info["channels"]
        .as_array()
        .unwrap()
        .iter()
        .map(|c| c["name"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["drive", "nail"]);
    export(&folder, "bench.csv", "one.uff", &["--channel", "nail"]).expect_success();
    let one = folder.run(&["info", "one.uff", "--json"]).json();
    assert_eq!(one["channels"].as_array().unwrap().len(), 1);
    folder
        .run(&[
            "transfer",
            "bench.csv",
            "--drive",
            "drive",
            "--response",
            "nail",
            "--segment",
            "256",
            "--out",
            "tf.json",
        ])
        .expect_success();
    let json = export(&folder, "tf.json", "tf.uff", &["--json"]).json();
    assert!(lost(&json)[0].contains("the device"), "{json}");
    assert!(holds_transfer(&folder.path("tf.uff")));
    let (a, b) = (
        read_transfer(&folder.path("tf.json")).unwrap(),
        read_transfer(&folder.path("tf.uff")).unwrap(),
    );
    assert_eq!(a.frequency_hz, b.frequency_hz);
}

/// Gravity stands still: where it begins and ends with the file there is no click, and full scale is the texture's.
#[test]
fn a_mean_goes_before_the_rate_changes() {
    let folder = folder();
    let plain: Vec<f64> = tone(2, 10_000).map(|v| 10.0 * v).collect();
    for (name, mean) in [("plain.csv", 0.0), ("gravity.csv", 9.81)] {
        let rows: Vec<String> = plain.iter().map(|v| format!("{}", v + mean)).collect();
        folder.write(name, format!("acc (m/s^2)\n{}\n", rows.join("\n")));
    }
    for out in ["wav", "hjif"] {
        let scale = |input: &str| {
            let out = format!("{input}.{out}");
            let json = export(&folder, input, &out, &["--rate", "10000", "--json"]).json();
            json["full_scale"]["value"].as_f64().unwrap()
        };
        let (plain, gravity) = (scale("plain.csv"), scale("gravity.csv"));
        // A mean in double precision.
        assert!((plain / gravity - 1.0).abs() < 1e-9, "{out}: {gravity}");
    }
    folder.write("one.csv", "acc (m/s^2)\n9.81\n");
    for out in ["one.wav", "one.hjif"] {
        export(&folder, "one.csv", out, &["--rate", "10000"])
            .expect_failure(1, &["one.csv", "full scale above zero"]);
    }
}

#[test]
fn what_cannot_be_carried_is_refused_and_nothing_is_written() {
    let folder = folder();
    folder.write("silent.wav", wav(std::iter::repeat_n(0.0, 5_000), 5_000));
    folder.write("short.wav", wav(noise(20), 5_000));
    folder.write(
        "loud.csv",
        "time (s),drive (FS)\n0,0.5\n0.001,1.5\n0.002,0\n0.003,0\n",
    );
    folder.write(
        "two.csv",
        "time (s),a (N),b (N)\n0,1,2\n0.001,2,1\n0.002,0,1\n",
    );
    let clip = |points: &str| {
        format!(
            r#"{{"version": {{"major": 1}}, "signals": {{"continuous": {{"envelopes": {{"amplitude": {points}}}}}}}}}"#
        )
    };
    folder.write("negative.haptic", clip(r#"[{"time": -1, "amplitude": 0}]"#));
    folder.write(
        "beyond.haptic",
        clip(r#"[{"time": 0, "amplitude": 0}, {"time": 1, "amplitude": 1.5}]"#),
    );
    folder.write("empty.haptic", clip("[]"));
    folder.write(
        "clip.haptic",
        clip(r#"[{"time": 0, "amplitude": 0}, {"time": 1, "amplitude": 0.5}]"#),
    );
    folder.write(
        "cut.hjif",
        r#"{"version": "2025", "perceptions": [{"id": 0"#,
    );
    folder.write(
        "tf.json",
        r#"{"frequency_hz": [0, 1], "real": [1, 1], "imaginary": [0, 0], "coherence": [1, 1]}"#,
    );
    let before = folder.names();
    for (input, out, extra, code, parts) in [
        (
            "texture.wav",
            "out.mp3",
            &[][..],
            2,
            &[".wav, .hjif, .haptic, .ahap or .uff", "found .mp3"][..],
        ),
        ("texture.wav", "out", &[], 2, &["found none"]),
        ("texture.wav", "texture.wav", &[], 2, &["would be replaced"]),
        (
            "texture.wav",
            "out.wav",
            &["--transfer", "tf.json"],
            2,
            &["--transfer", ".hjif"],
        ),
        ("texture.wav", "none/out.wav", &[], 1, &["folder"]),
        ("absent.wav", "out.wav", &[], 1, &["absent.wav"]),
        (
            "tf.json",
            "out.haptic",
            &[],
            2,
            &[".uff for a transfer function"],
        ),
        (
            "tf.json",
            "out.uff",
            &["--channel", "a"],
            2,
            &["no channels"],
        ),
        (
            "silent.wav",
            "out.haptic",
            &[],
            1,
            &["silent", "nothing to export"],
        ),
        (
            "silent.wav",
            "out.hjif",
            &SCALE,
            1,
            &["silent.wav", "silent"],
        ),
        (
            "short.wav",
            "out.haptic",
            &SCALE,
            1,
            &["a duration above 0 s is needed", "0.004 s"],
        ),
        (
            "loud.csv",
            "out.hjif",
            &[],
            1,
            &["within ±1", "1.5", "lower its level"],
        ),
        (
            "clip.haptic",
            "out.ahap",
            &["--rate", "100"],
            2,
            &["clip.haptic is a haptic clip", "leave --rate out"],
        ),
        ("two.csv", "out.wav", &[], 1, &["--channel"]),
        (
            "two.csv",
            "out.wav",
            &["--channel", "c"],
            1,
            &["`c`", "a [N], b [N]"],
        ),
        (
            "negative.haptic",
            "out.ahap",
            &[],
            1,
            &["a time from 0", "-1"],
        ),
        ("beyond.haptic", "out.ahap", &[], 1, &["from 0 to 1", "1.5"]),
        (
            "empty.haptic",
            "out.wav",
            &[],
            1,
            &["no breakpoint of amplitude"],
        ),
        ("cut.hjif", "out.wav", &[], 1, &["MPEG haptics JSON", "EOF"]),
    ] {
        export(&folder, input, out, extra).expect_failure(code, parts);
    }
    assert_eq!(folder.names(), before);
}

#[test]
fn what_a_warning_says_is_read_again() {
    let loss = Warning::from(RecordingWarning::FormatLoses {
        format: "AHAP".into(),
        what: "hertz".into(),
    });
    let text = serde_json::to_string(&loss).unwrap();
    assert_eq!(serde_json::from_str::<Warning>(&text).unwrap(), loss);
    assert_eq!(
        loss.to_string(),
        "AHAP cannot store hertz: keep the original file as well"
    );
}
