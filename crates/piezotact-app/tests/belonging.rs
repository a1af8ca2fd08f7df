//! Files that do not belong together, or were edited: what contradicts is named.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use crate::known_cuts::{Kind, Random, recorded, table};
use crate::support::{BENCH, Folder, noise, prepared, wav};
use serde_json::Value;

fn recording(seed: u64) -> String {
    table(&recorded(&mut Random::new(seed), &[Kind::Plain; 3]))
}

#[test]
fn cuts_of_an_earlier_recording_are_not_applied() {
    let folder = Folder::new();
    folder.write("a.csv", recording(1));
    folder
        .run(&[
            "strokes",
            "--cuts-only",
            "a.csv",
            "--write-cuts",
            "a.csv.cuts",
        ])
        .expect_success();
    let text = std::fs::read_to_string(folder.path("a.csv.cuts")).unwrap();
    assert!(text.contains("\n# recording "), "{text}");
    let own = folder.run(&["strokes", "--cuts-only", "a.csv"]);
    own.expect_success();
    assert!(!own.err().contains("a.csv.cuts"), "{}", own.err());
    // an edited line keeps the cuts with their recording
    let edited = format!("{text}leave-out 0.1 0.2 a remark\n");
    folder.write("a.csv.cuts", &edited);
    folder
        .run(&["strokes", "--cuts-only", "a.csv"])
        .expect_success();
    // a new recording of that name
    folder.write("a.csv", recording(2));
    let refused = ["cuts of a.csv", "earlier recording", "# recording"];
    folder
        .run(&["strokes", "--cuts-only", "a.csv"])
        .expect_failure(1, &refused);
    folder
        .run(&["strokes", "a.csv", "--by", "file"])
        .expect_failure(1, &refused);
    // cuts without a checksum still apply, with a warning that gives the line
    let old: String = text
        .lines()
        .filter(|line| !line.contains("recording "))
        .map(|line| format!("{line}\n"))
        .collect();
    folder.write("a.csv.cuts", &old);
    let value = folder
        .run(&["strokes", "--cuts-only", "a.csv", "--json"])
        .json();
    let warnings = value["recordings"][0]["warnings"].as_array().unwrap();
    let warning = warnings
        .iter()
        .find(|d| d["code"] == "cuts_unconfirmed")
        .unwrap();
    let said = warning["text"].as_str().unwrap();
    let line = said.split('`').nth(1).unwrap();
    folder.write("a.csv.cuts", format!("{line}\n{old}"));
    let done = folder.run(&["strokes", "--cuts-only", "a.csv"]);
    done.expect_success();
    assert!(
        !done.err().contains("does not say for which recording"),
        "{}",
        done.err()
    );
}

#[test]
fn a_header_with_another_rate_than_the_sidecars_is_refused() {
    let folder = Folder::new();
    folder.write("t.wav", wav(noise(5000), 5000));
    folder
        .run(&[
            "manipulate",
            "t.wav",
            "--scale",
            "1m/s2",
            "--gain",
            "0dB",
            "--out",
            "m.wav",
        ])
        .expect_success();
    let mut bytes = std::fs::read(folder.path("m.wav")).unwrap();
    let at = bytes.windows(4).position(|four| four == b"fmt ").unwrap() + 12;
    assert_eq!(bytes[at..at + 4], 5000u32.to_le_bytes());
    bytes[at..at + 4].copy_from_slice(&500u32.to_le_bytes());
    folder.write("m.wav", bytes);
    folder
        .run(&["info", "m.wav"])
        .expect_failure(1, &["5000 Hz", "500 Hz", "m.wav.json"]);
    // a person may state the rate, too
    folder.write("t.wav.json", r#"{"full_scale": "1 m/s2", "rate_hz": 4000}"#);
    folder
        .run(&["info", "t.wav"])
        .expect_failure(1, &["4000 Hz", "5000 Hz"]);
}

/// The JSON of a transfer function, changed.
fn changed(folder: &Folder, change: impl Fn(&mut Value)) -> crate::support::Done {
    let text = std::fs::read(folder.path("tf.json")).unwrap();
    let mut value: Value = serde_json::from_slice(&text).unwrap();
    change(&mut value);
    folder.write("edited.json", serde_json::to_vec(&value).unwrap());
    folder.run(&[
        "render",
        "texture.wav",
        "--scale",
        "1m/s2",
        "--transfer",
        "edited.json",
        "--level",
        "-40",
        "--out",
        "d.wav",
        "--json",
    ])
}

fn scale(value: &mut Value, names: &[&str], factor: f64) {
    for name in names {
        for number in value[*name].as_array_mut().unwrap() {
            *number = (number.as_f64().unwrap() * factor).into();
        }
    }
}

fn has(value: &Value, code: &str) -> bool {
    value["warnings"]
        .as_array()
        .unwrap()
        .iter()
        .any(|warning| warning["code"] == code)
}

#[test]
fn edited_transfer_functions_are_not_believed() {
    let folder = prepared();
    let whole = changed(&folder, |_| ()).json();
    assert!(
        !has(&whole, "acausal") && !has(&whole, "stored_function_doubtful"),
        "{whole}"
    );
    changed(&folder, |value| scale(value, &["real", "imaginary"], 1e90))
        .expect_failure(1, &["edited.json", "largest magnitude"]);
    changed(&folder, |value| value["rate_hz"] = 1000.into())
        .expect_failure(1, &["edited.json", "half the rate"]);
    changed(&folder, |value| value["averages"] = 2.into())
        .expect_failure(1, &["edited.json", "effective averages"]);
    // the conjugate comes before the drive
    let conjugate = changed(&folder, |value| scale(value, &["imaginary"], -1.0)).json();
    assert!(has(&conjugate, "acausal"), "{conjugate}");
    // many more averages than were measured, and narrower limits
    let more = changed(&folder, |value| {
        value["averages"] = 100_000.into();
        value["effective_averages"] = 100_000.0.into();
    });
    let more = more.json();
    let mut warnings = more["warnings"].as_array().unwrap().iter();
    let limits =
        |one: &Value| one["code"] == "stored_function_doubtful" && one["fault"] == "limits";
    assert!(warnings.any(limits), "{more}");
}

#[test]
fn a_drive_that_was_not_played_is_refused() {
    let folder = prepared();
    for (level, out) in [("-30", "one.wav"), ("-36", "other.wav")] {
        folder
            .run(&[
                "render",
                "texture.wav",
                "--scale",
                "1m/s2",
                "--transfer",
                "tf.json",
                "--level",
                level,
                "--out",
                out,
            ])
            .expect_success();
    }
    folder
        .run(&[
            "play",
            "one.wav",
            "--bench",
            BENCH,
            "--record",
            "measured.parquet",
        ])
        .expect_success();
    let verify = |drive: &str| {
        folder.run(&[
            "verify",
            "--target",
            "texture.wav",
            "--scale",
            "1m/s2",
            "--measured",
            "measured.parquet",
            "--drive",
            drive,
            "--json",
        ])
    };
    assert!(
        matches!(verify("one.wav").code(), Some(0 | 3 | 4 | 5)),
        "{}",
        verify("one.wav").err()
    );
    verify("other.wav").expect_failure(1, &["--drive", "−30.00 dB", "−36.00 dB"]);
}

#[test]
fn a_gain_that_the_recording_contradicts_is_refused() {
    let folder = prepared();
    folder
        .run(&[
            "render",
            "texture.wav",
            "--scale",
            "1m/s2",
            "--transfer",
            "tf.json",
            "--level",
            "-30",
            "--out",
            "d.wav",
        ])
        .expect_success();
    folder
        .run(&[
            "play",
            "d.wav",
            "--bench",
            BENCH,
            "--record",
            "played.parquet",
        ])
        .expect_success();
    let info = folder.run(&["info", "played.parquet", "--json"]).json();
    let names: Vec<&str> = (info["channels"].as_array().unwrap().iter())
        .map(|c| c["name"].as_str().unwrap())
        .collect();
    let stated = info["setup"]["gain"].to_string() + &info.to_string();
    let other = if stated.contains("B3") { "B1" } else { "B3" };
    let estimate = |gain: &str| {
        folder.run(&[
            "transfer",
            "played.parquet",
            "--drive",
            names[0],
            "--response",
            names[1],
            "--gain",
            gain,
            "--volts-per-full-scale",
            "1.41",
            "--out",
            "estimated.json",
        ])
    };
    estimate(other).expect_failure(1, &["the device that the recording states", "--gain"]);
}

#[test]
fn a_matlab_rate_that_the_option_contradicts_is_a_warning() {
    let folder = Folder::new();
    folder.write("a.mat", mat_with_rate("sr", 50_000.0));
    let value = folder.run(&["info", "a.mat", "--json"]).json();
    assert_eq!(value["rate_hz"], 50_000.0, "{value}");
    let value = folder
        .run(&["info", "a.mat", "--rate", "5000", "--json"])
        .json();
    let mut warnings = value["warnings"].as_array().unwrap().iter();
    let stated = |one: &Value| one["code"] == "stated_differs" && one["what"] == "rate";
    assert!(warnings.any(stated), "{value}");
}

/// A MATLAB file of level 5 with a vector `acc` of 100 numbers and a number called `name`.
fn mat_with_rate(name: &str, value: f64) -> Vec<u8> {
    let mut bytes = vec![b' '; 116];
    bytes[..10].copy_from_slice(b"MATLAB 5.0");
    bytes.extend([0; 8]);
    bytes.extend([0, 1, b'I', b'M']);
    let mut matrix = |name: &str, values: &[f64]| {
        let mut body: Vec<u8> = Vec::new();
        let mut element = |kind: u32, data: &[u8]| {
            body.extend(kind.to_le_bytes());
            body.extend((data.len() as u32).to_le_bytes());
            body.extend(data);
            body.resize(body.len().div_ceil(8) * 8, 0);
        };
        element(6, &[6, 0, 0, 0, 0, 0, 0, 0]);
        let dims = [values.len() as i32, 1].map(i32::to_le_bytes).concat();
        element(5, &dims);
        element(1, name.as_bytes());
        let data: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        element(9, &data);
        bytes.extend(14u32.to_le_bytes());
        bytes.extend((body.len() as u32).to_le_bytes());
        bytes.extend(body);
    };
    let signal: Vec<f64> = noise(100).collect();
    matrix("acc", &signal);
    matrix(name, &[value]);
    bytes
}

/// Participants of one number and two seeds are two people: a function that does not say whose it is joins no panel.
#[test]
fn transfer_function_of_a_twin_without_its_seed_is_refused() {
    let folder = prepared();
    let text = std::fs::read_to_string(folder.path("tf.json")).unwrap();
    let mut document: Value = serde_json::from_str(&text).unwrap();
    let seed = document["condition"]
        .as_object_mut()
        .unwrap()
        .remove("twin_seed");
    assert_eq!(seed, Some(7.into()));
    folder.write("of_whom.json", document.to_string());
    for line in ["panel add filed of_whom.json", "info of_whom.json"] {
        let words: Vec<&str> = line.split(' ').collect();
        folder
            .run(&words)
            .expect_failure(1, &["of_whom.json", "condition.twin_seed", "make it again"]);
    }
}
