//! `--bench measured:FILE` as a black box: a rendering rehearsed on a hand that was measured before.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::f64::consts::TAU;

use crate::support::{Done, Folder, noise, wav};
use serde_json::{Value, json};

/// A hand of two resonances, 501 lines to 2.5 kHz, with what is stated beside them.
fn hand(stated: Value) -> String {
    let frequency_hz: Vec<f64> = (0..=500).map(|k| 5.0 * f64::from(k)).collect();
    // a = −h·r²/(1 − r² + 2jζr), 0.6 ms late.
    let of = |f: f64| -> [f64; 2] {
        let (mut re, mut im) = (0.0, 0.0);
        for (resonance_hz, damping, height) in [(180.0, 0.3, 60.0), (420.0, 0.2, 25.0)] {
            let r: f64 = f / resonance_hz;
            let (a, b) = (1.0 - r * r, 2.0 * damping * r);
            let scale = -height * r * r / (a * a + b * b);
            re += scale * a;
            im -= scale * b;
        }
        let (sin, cos) = (-TAU * f * 0.6e-3).sin_cos();
        [re * cos - im * sin, re * sin + im * cos]
    };
    let lines: Vec<[f64; 2]> = frequency_hz.iter().map(|f| of(*f)).collect();
    let mut document = json!({
        "frequency_hz": frequency_hz,
        "real": lines.iter().map(|l| l[0]).collect::<Vec<f64>>(),
        "imaginary": lines.iter().map(|l| l[1]).collect::<Vec<f64>>(),
        "coherence": vec![0.999; 501],
        "excited_hz": [2.0, 1200.0],
        "averages": 100,
    });
    for (key, value) in stated.as_object().unwrap() {
        document[key] = value.clone();
    }
    document.to_string()
}

fn described() -> Value {
    json!({
        "condition": { "participant": "P07", "load_n": 0.4, "angle_deg": 30.0 },
        "drive": { "gain": "B3", "volts_per_full_scale": 1.0, "load_f": 80e-9 },
        "provenance": { "source": "the hand of a test", "bench": "hardware", "steps": [] },
    })
}

fn folder(stated: Value) -> Folder {
    let folder = Folder::new();
    folder.write("hand.json", hand(stated));
    folder.write("texture.wav", wav(noise(20_000), 5_000));
    folder
}

fn run(folder: &Folder, line: &str) -> Done {
    let words: Vec<&str> = line.split_whitespace().collect();
    folder.run(&words)
}

fn warnings(said: &Value) -> String {
    said["warnings"].to_string()
}

/// Characterise, render in a loop, play and verify, on a hand whose device is described.
#[test]
fn a_rendering_is_rehearsed_on_a_measured_hand() {
    let folder = folder(described());
    let bench = "--bench measured:hand.json,noise=0.003,seed=7";
    let said = run(
        &folder,
        &format!(
            "characterise {bench} --seconds 20 --segment 1000 --out tf.json --report tf.html --json"
        ),
    )
    .json();
    // The bench follows what was measured: its load, its angle, its device.
    assert_eq!(said["condition"]["load_n"], 0.4);
    assert_eq!(said["condition"]["angle_deg"], 30.0);
    assert_eq!(said["drive_setup"]["gain"], "B3");
    assert_eq!(said["provenance"]["bench"], "measured");
    let text = warnings(&said);
    for part in [
        "no finger was involved",
        "the hand of a test",
        "no force was measured",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let page = std::fs::read_to_string(folder.path("tf.html")).unwrap();
    assert!(page.contains("Played through a measured transfer function: no finger was involved."));

    let scale = "--scale 10m/s2";
    let render = format!("render texture.wav {scale} --transfer tf.json --out drive.wav --json");
    let render = format!("{render} --band 60..800 --mode texture --iterations 2 --level -6");
    let said = run(&folder, &format!("{render} {bench}")).json();
    let each = said["loop"]["iterations"].as_array().unwrap();
    let error = |i: usize| each[i]["error_db_rms_achievable"].as_f64().unwrap();
    let confirmed = said["loop"]["confirmed"]["error_db_rms_achievable"].as_f64();
    assert!(
        confirmed.unwrap() <= error(0) + 0.05 && confirmed.unwrap() < 0.5,
        "{said}"
    );
    assert!(warnings(&said).contains("no finger was involved"), "{said}");

    let play = format!("play drive.wav {bench} --record felt.parquet --json");
    let said = run(&folder, &play).json();
    assert!(warnings(&said).contains("no finger was involved"), "{said}");
    assert!(!warnings(&said).contains("rendered for"), "{said}");
    let verify = format!("verify --target texture.wav {scale} --measured felt.parquet");
    run(
        &folder,
        &format!("{verify} --band 60..800 --report report.html"),
    )
    .expect_success();
    let page = std::fs::read_to_string(folder.path("report.html")).unwrap();
    for part in [
        "Played through a measured transfer function: no finger was involved.",
        "load 0.4 N",
        "P07",
    ] {
        assert!(page.contains(part), "{part}");
    }
    let info = run(&folder, "info felt.parquet");
    info.expect_success();
    assert!(
        info.out().contains("no finger was involved"),
        "{}",
        info.out()
    );

    // Another load, angle or gain than that of the hand is refused.
    run(&folder, &format!("{play} --load 0.2")).expect_failure(
        2,
        &["0.4 N at which hand.json was measured", "leave --load"],
    );
    run(&folder, &format!("{play} --angle 20"))
        .expect_failure(2, &["30 ° at which hand.json was measured"]);
    let mut other = described();
    other["drive"]["gain"] = json!("B1");
    folder.write("other.json", hand(other));
    run(
        &folder,
        "play drive.wav --bench measured:other.json --record x.parquet",
    )
    .expect_failure(1, &["gain B3", "is set to B1"]);
}

/// A response that others published says nothing of device, load and angle: it is rehearsed on, and that is said.
#[test]
fn a_response_that_says_nothing_is_played_through_with_warnings() {
    let folder = folder(json!({}));
    let render = "render texture.wav --scale 10m/s2 --transfer hand.json --band 60..800 --level -12 --out drive.wav";
    run(&folder, render).expect_success();
    let play = "play drive.wav --bench measured:hand.json --record felt.parquet --json";
    let said = run(&folder, play).json();
    let text = warnings(&said);
    for part in [
        "does not state the load and angle",
        "states neither amplifier gain",
        "does not state whether a finger was measured",
    ] {
        assert!(text.contains(part), "{part}: {text}");
    }
    assert!(!text.contains("no force was measured"), "{text}");
    run(&folder, &format!("{play} --gain B3"))
        .expect_failure(2, &["expected no --gain", "leave it out"]);
    // Settings that are refused as on any bench.
    run(
        &folder,
        "characterise --bench measured:hand.json --seconds 10 --band 2..2600 --out tf.json",
    )
    .expect_failure(2, &["below half of the acquisition's 5000 Hz"]);
}

#[test]
fn what_is_no_measured_hand_is_refused() {
    let folder = folder(described());
    let of = |what: &str, value: Value| {
        let mut stated = described();
        stated[what] = value;
        hand(stated)
    };
    folder.write("force.json", of("response_unit", json!("N")));
    folder.write("zero.json", {
        let mut stated = described();
        stated["real"] = json!(vec![0.0; 501]);
        stated["imaginary"] = json!(vec![0.0; 501]);
        hand(stated)
    });
    folder.write("nan.json", hand(described()).replacen("0.999", "NaN", 1));
    folder.write("huge.json", hand(described()).replacen("0.999", "1e999", 1));
    folder.write("text.json", "no transfer function");
    let characterise = |bench: &str| {
        let line = format!("characterise --bench {bench} --seconds 10 --out tf.json");
        run(&folder, &line)
    };
    for (file, parts) in [
        ("none.json", ["none.json", ""]),
        ("text.json", ["text.json", "transfer function"]),
        ("texture.wav", ["texture.wav", "transfer function"]),
        ("force.json", ["force.json", "response is in m/s²"]),
        ("zero.json", ["zero.json", "zero at every frequency"]),
        ("nan.json", ["nan.json", "transfer function"]),
        ("huge.json", ["huge.json", "transfer function"]),
        ("hand.json,typo", ["hand.json,typo", ""]),
    ] {
        characterise(&format!("measured:{file}")).expect_failure(1, &parts);
    }
    for (bench, part) in [
        ("measured", "measured:FILE"),
        ("measured:", "measured:FILE"),
        ("measured:hand.json,noise=-1", "a noise from 0"),
        ("measured:hand.json,colour=red", "noise=M_S2"),
        ("shaker:hand.json", "(twin, measured, audio, fake)"),
    ] {
        characterise(bench).expect_failure(2, &[part]);
    }
    // What is read is not replaced, and a campaign needs people.
    run(
        &folder,
        "characterise --bench measured:hand.json --seconds 10 --out hand.json",
    )
    .expect_failure(2, &["hand.json is read and would be replaced"]);
    run(
        &folder,
        "panel run --bench measured:hand.json --participants 1..2 --out panel",
    )
    .expect_failure(2, &["one finger at one placement", "panel add"]);
    assert!(!folder.path("panel").exists() && !folder.path("tf.json").exists());
}

/// The hand put down otherwise: a level in dB, and a tilt in dB from 0 to 2.5 kHz.
fn placed(level_db: f64, tilt_db: f64) -> String {
    let mut document: Value = serde_json::from_str(&hand(described())).unwrap();
    for part in ["real", "imaginary"] {
        for (k, value) in document[part]
            .as_array_mut()
            .unwrap()
            .iter_mut()
            .enumerate()
        {
            let db = level_db + tilt_db * k as f64 / 500.0;
            *value = json!(value.as_f64().unwrap() * 10f64.powf(db / 20.0));
        }
    }
    document.to_string()
}

/// A drive that is played through the very transfer function that it was rendered with proves nothing, whatever the file is
/// called; through another placement, drawn from a panel, it may.
#[test]
fn a_drive_played_through_its_own_transfer_function_is_no_proof() {
    let folder = folder(described());
    folder.write("copy.json", hand(described()));
    for (number, level_db, tilt_db) in
        [(1, 0.0, 0.0), (2, 2.0, 4.0), (3, -1.5, 8.0), (4, 1.0, -6.0)]
    {
        let name = format!("placed{number}.json");
        folder.write(&name, placed(level_db, tilt_db));
        run(
            &folder,
            &format!("panel add people {name} --placement {number} --repeat 1"),
        )
        .expect_success();
    }
    let scale = "--scale 2m/s2";
    let render = "--transfer hand.json --out drive.wav --band 60..800 --level fit";
    run(&folder, &format!("render texture.wav {scale} {render}")).expect_success();
    let error_of = |bench: &str| -> (f64, String) {
        let play = format!("play drive.wav --bench measured:{bench} --record felt.parquet --json");
        let said = run(&folder, &play).json();
        let verify = format!("verify --target texture.wav {scale} --measured felt.parquet");
        let verified = run(&folder, &format!("{verify} --band 60..800 --json"));
        let verified: Value = serde_json::from_str(&verified.out()).unwrap();
        // What is said when it is played is said when it is read.
        let own = |said: &Value| warnings(said).contains("played_through_its_own");
        assert_eq!(own(&said), own(&verified), "{verified}");
        (verified["error_db_rms"].as_f64().unwrap(), said.to_string())
    };
    for bench in ["hand.json,seed=3", "copy.json"] {
        let (error_db, said) = error_of(bench);
        assert!(error_db < 0.3, "{error_db}");
        assert!(
            said.contains("the target is reproduced whatever the device and the finger do"),
            "{said}"
        );
    }
    // A drive that was made with another transfer function does not stand for the one that was played.
    for (transfer, out) in [("hand.json", "own.wav"), ("placed2.json", "other.wav")] {
        let line = format!(
            "render texture.wav {scale} --transfer {transfer} --out {out} --band 60..800 --level -20"
        );
        run(&folder, &line).expect_success();
    }
    run(
        &folder,
        "play own.wav --bench measured:hand.json --record own.parquet",
    )
    .expect_success();
    let verify = format!(
        "verify --target texture.wav {scale} --measured own.parquet --band 60..800 --drive"
    );
    let verified: Value =
        serde_json::from_str(&run(&folder, &format!("{verify} own.wav --json")).out()).unwrap();
    assert_eq!(verified["is_rehearsal"], true, "{verified}");
    run(&folder, &format!("{verify} other.wav"))
        .expect_failure(1, &["own.parquet", "found another", "checksum"]);
    let mut errors = Vec::new();
    for number in 1..=4 {
        let (error_db, said) = error_of(&format!("hand.json,panel=people,placement={number}"));
        assert!(!said.contains("played_through_its_own"), "{said}");
        assert!(
            said.contains("drawn from the differences between placements for 1 combinations of participant and condition"),
            "{said}"
        );
        errors.push(error_db);
    }
    let largest = errors.iter().copied().fold(0.0, f64::max);
    assert!(largest > 0.5, "{errors:?}");
    run(
        &folder,
        "play drive.wav --bench measured:hand.json,placement=2 --record felt.parquet",
    )
    .expect_failure(2, &["panel=FOLDER with placement=N"]);
}

/// P02 of the twin of seed 7 and P02 of the twin of seed 8 are two people.
#[test]
fn a_twin_s_participant_of_another_seed_is_somebody_else() {
    let mut stated = described();
    stated["condition"] =
        json!({ "participant": "P02", "twin_seed": 7, "load_n": 0.2, "angle_deg": 20.0 });
    stated["provenance"] = json!({ "source": "twin", "bench": "twin", "seed": 7, "steps": [] });
    stated["drive"]["volts_per_full_scale"] = json!(1.41);
    let folder = folder(stated);
    let render = "--transfer hand.json --out drive.wav --band 60..800 --level fit";
    run(
        &folder,
        &format!("render texture.wav --scale 2m/s2 {render}"),
    )
    .expect_success();
    for (seed, others) in [(7, false), (8, true)] {
        let bench = format!("--bench twin:participant=2,seed={seed}");
        let said = run(
            &folder,
            &format!("play drive.wav {bench} --record felt.parquet --json"),
        );
        let text = warnings(&said.json());
        assert_eq!(
            text.contains("P02 (twin of seed 7), but measured with P02 (twin of seed 8)"),
            others,
            "{text}"
        );
        assert_eq!(text.contains("rendered for participant"), others, "{text}");
    }
}
