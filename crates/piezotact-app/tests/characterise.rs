//! `characterise` and `transfer` as black boxes: excitations, repeats, the gate, files of three formats, and measurements
//! that were made badly.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::f64::consts::TAU;
use std::fmt::Write as _;

use crate::support::{self, Folder};

const BENCH: &str = "twin:participant=1,seed=7";

fn characterise(folder: &Folder, arguments: &str) -> support::Done {
    let all: Vec<&str> = ["characterise", "--bench", BENCH]
        .into_iter()
        .chain(arguments.split(' '))
        .collect();
    folder.run(&all)
}

#[test]
fn repeats_are_one_estimate_and_their_recordings_are_kept() {
    let folder = Folder::new();
    let said = characterise(
        &folder,
        "--seconds 12 --repeats 2 --record raw.parquet --out tf.json --report tf.html --json",
    )
    .json();
    assert_eq!(said["repeats"], 2);
    assert_eq!(said["averages"], 120);
    assert!(
        said["repeats_apart_db_rms"].as_f64().unwrap() < 0.3,
        "{said}"
    );
    assert_eq!(said["refused"].as_array().unwrap().len(), 0);
    let names = folder.names();
    for kept in ["raw-1.parquet", "raw-2.parquet", "tf.json", "tf.html"] {
        assert!(names.iter().any(|name| name == kept), "{kept}: {names:?}");
    }
    let report = std::fs::read_to_string(folder.path("tf.html")).unwrap();
    assert!(report.contains("95 % confidence") && report.contains("2 repeats"));
    // Every line says how far it may be off.
    let text = std::fs::read_to_string(folder.path("tf.json")).unwrap();
    let file: serde_json::Value = serde_json::from_str(&text).unwrap();
    let column = |name: &str| file["confidence"][name].as_array().unwrap();
    assert_eq!(column("low").len(), 1025);
    let at_100_hz = [&column("low")[41], &column("high")[41]].map(|v| v.as_f64().unwrap());
    let magnitude = file["real"][41]
        .as_f64()
        .unwrap()
        .hypot(file["imaginary"][41].as_f64().unwrap());
    assert!(
        at_100_hz[0] < magnitude && magnitude < at_100_hz[1],
        "{at_100_hz:?} {magnitude}"
    );
    assert!(at_100_hz[1] / at_100_hz[0] < 1.1, "{at_100_hz:?}");
}

/// Sweeps and multisines give what renders; multisines tell noise from distortion.
#[test]
fn other_excitations_give_transfer_functions_that_render() {
    let folder = support::prepared();
    for excitation in ["sweep", "multisine"] {
        let said = characterise(
            &folder,
            &format!("--excitation {excitation} --seconds 20 --out {excitation}.json --json"),
        )
        .json();
        let steps = said["provenance"]["steps"].to_string();
        assert!(steps.contains(excitation), "{steps}");
        assert_eq!(said["distortion"].is_null(), excitation == "sweep");
        if excitation == "multisine" {
            let bands = said["distortion"]["levels"].as_array().unwrap();
            let at_100_hz = bands
                .iter()
                .find(|b| b["band_hz"][0].as_f64().unwrap() > 85.0)
                .unwrap();
            let share =
                at_100_hz["noise"].as_f64().unwrap() / at_100_hz["linear"].as_f64().unwrap();
            assert!((1e-4..0.3).contains(&share), "{share}");
        }
        folder
            .run(&["info", &format!("{excitation}.json")])
            .expect_success();
    }
}

/// One transfer function as JSON, universal file and MATLAB file: the same lines, the same condition.
#[test]
fn three_formats_hold_one_transfer_function() {
    let folder = Folder::new();
    let mut lines = Vec::new();
    for file in ["tf.json", "tf.uff", "tf.mat"] {
        let done = characterise(&folder, &format!("--seconds 10 --out {file}"));
        done.expect_success();
        assert_eq!(
            done.err().contains("universal file"),
            file == "tf.uff",
            "{}",
            done.err()
        );
        let said = folder.run(&["info", file, "--json"]).json();
        assert_eq!(said["kind"], "transfer function");
        assert_eq!(said["condition"]["participant"], "P01");
        lines.push([
            said["lines"].clone(),
            said["coherence"]["median"].clone(),
            said["averages"].clone(),
        ]);
    }
    assert_eq!(lines[0], lines[2]);
    assert_eq!(lines[0][0], lines[1][0]);
}

#[test]
fn the_gate_names_why_and_stops() {
    let folder = Folder::new();
    characterise(
        &folder,
        "--seconds 12 --force-tolerance 0.0005 --attempts 2 --out tf.json",
    )
    .expect_failure(
        1,
        &[
            "repeat 1 was rejected in all 2 attempts",
            "the mean force was",
            "0.2 N ± 0 %",
            "hold the finger",
        ],
    );
    characterise(
        &folder,
        "--seconds 12 --least-coherence 0.99999 --attempts 1 --out tf.json",
    )
    .expect_failure(
        1,
        &[
            "coherence was 0.99",
            "expected 0.99999 or more",
            "put the finger on the actuator",
        ],
    );
    assert!(!folder.names().contains(&"tf.json".to_owned()));
    // Without a gate there is nothing to set.
    characterise(&folder, "--gate off --least-coherence 2 --out tf.json")
        .expect_failure(2, &["--gate on with --least-coherence", "checks nothing"]);
    characterise(&folder, "--seconds 12 --gate off --out tf.json").expect_success();
    // A band between two lines, and a segment of hardly any.
    characterise(&folder, "--gate off --band 10..11 --out x.json").expect_failure(
        2,
        &[
            "2.44 Hz apart",
            "--segment 2048",
            "10–11 Hz",
            "longer --segment",
        ],
    );
    characterise(&folder, "--gate off --segment 3 --out x.json").expect_failure(
        2,
        &["1666.67 Hz apart with --segment 3", "longer --segment"],
    );
    assert!(!folder.names().contains(&"x.json".to_owned()));
    characterise(&folder, "--force-tolerance 1.5 --out tf.json")
        .expect_failure(2, &["--force-tolerance between 0 and 1", "1.5"]);
    characterise(&folder, "--excitation chirp --out tf.json")
        .expect_failure(2, &["random, sweep or multisine"]);
    characterise(&folder, "--excitation multisine --seconds 5 --out tf.json")
        .expect_failure(2, &["two realisations of two periods"]);
    characterise(&folder, "--excitation sweep --band 0..500 --out tf.json")
        .expect_failure(2, &["three sweeps", "1 Hz"]);
    characterise(
        &folder,
        "--excitation multisine --segment 4096 --seconds 20 --out tf.json",
    )
    .expect_failure(2, &["2 to 2500 samples", "4096"]);
    characterise(&folder, "--repeats 0 --out tf.json").expect_failure(2, &["--repeats"]);
}

/// Attempts that were refused keep what was recorded of them.
#[test]
fn refused_attempts_are_kept_as_they_broke_off() {
    let folder = Folder::new();
    characterise(
        &folder,
        "--seconds 12 --force-tolerance 0.0005 --attempts 2 --record raw.parquet --out tf.json",
    )
    .expect_failure(1, &["rejected in all 2 attempts"]);
    for file in ["raw.parquet", "raw-again-1.parquet"] {
        let said = folder.run(&["info", file, "--json"]).json();
        assert!(
            said["warnings"].to_string().contains("refused by the gate"),
            "{said}"
        );
    }
}

/// A recording of a drive to 1 kHz through a resonance at 200 Hz, half a millisecond late.
struct Measured {
    drive: Vec<f64>,
    response: Vec<f64>,
}

const RATE_HZ: f64 = 5_000.0;

fn measured() -> Measured {
    let noise: Vec<f64> = support::noise(40_000).collect();
    // A windowed sinc low-pass at 1 kHz.
    let taps: Vec<f64> = (-60i32..=60)
        .map(|k| {
            let t = f64::from(k);
            let sinc = if k == 0 {
                0.4
            } else {
                (0.4 * std::f64::consts::PI * t).sin() / (std::f64::consts::PI * t)
            };
            sinc * (0.5 + 0.5 * (TAU * t / 122.0).cos())
        })
        .collect();
    let filtered = |x: &[f64], h: &[f64]| -> Vec<f64> {
        (0..x.len())
            .map(|i| {
                h.iter()
                    .take(i + 1)
                    .enumerate()
                    .map(|(k, h)| h * x[i - k])
                    .sum()
            })
            .collect()
    };
    let drive = filtered(&noise, &taps);
    let plant: Vec<f64> = (0..400)
        .map(|i| f64::from(i) / RATE_HZ)
        .map(|t| (-200.0 * t).exp() * (TAU * 200.0 * t).sin())
        .collect();
    let plant = [vec![0.0; 8], plant].concat();
    let response = filtered(&drive, &plant);
    Measured { drive, response }
}

fn transfer(folder: &Folder, name: &str, drive: &[f64], response: &[f64]) -> String {
    let mut text = String::from("time [s],drive [N],nail [m/s2]\n");
    for (i, (x, y)) in drive.iter().zip(response).enumerate() {
        writeln!(text, "{},{x},{y}", i as f64 / RATE_HZ).unwrap();
    }
    let file = format!("{name}.csv");
    folder.write(&file, text);
    let done = folder.run(&[
        "transfer",
        &file,
        "--drive",
        "drive",
        "--response",
        "nail",
        "--segment",
        "1024",
        "--out",
        "tf.json",
    ]);
    done.expect_success();
    done.err()
}

#[test]
fn what_was_measured_badly_is_named() {
    let folder = Folder::new();
    let Measured { drive, response } = measured();
    let good = transfer(&folder, "good", &drive, &response);
    for named in [
        "swapped",
        "ms after the drive",
        "wrong sign",
        "clip",
        "no relation",
    ] {
        assert!(!good.contains(named), "{good}");
    }
    let swapped = transfer(&folder, "swapped", &response, &drive);
    assert!(swapped.contains("swapped"), "{swapped}");
    let late: Vec<f64> = [
        vec![0.0; 3_000],
        response[..response.len() - 3_000].to_vec(),
    ]
    .concat();
    let late = transfer(&folder, "late", &drive, &late);
    assert!(
        late.contains("ms after the drive") && late.contains("of a segment"),
        "{late}"
    );
    // Of a displacement, the acceleration: the force puts power in; with the sign reversed it takes it out.
    let acceleration: Vec<f64> = (1..response.len() - 1)
        .map(|i| 1e3 * (response[i + 1] - 2.0 * response[i] + response[i - 1]))
        .collect();
    // The eight samples by which the response is late taken away.
    let force = &drive[1..drive.len() - 9];
    let acceleration = &acceleration[8..];
    let upright = transfer(&folder, "upright", force, acceleration);
    assert!(!upright.contains("wrong sign"), "{upright}");
    let turned: Vec<f64> = acceleration.iter().map(|a| -a).collect();
    let turned = transfer(&folder, "turned", force, &turned);
    assert!(turned.contains("wrong sign"), "{turned}");
    let limit = 0.5 * response.iter().fold(0.0, |most: f64, y| most.max(y.abs()));
    let clipped: Vec<f64> = response.iter().map(|y| y.clamp(-limit, limit)).collect();
    let clipped = transfer(&folder, "clipped", &drive, &clipped);
    assert!(
        clipped.contains("nail") && clipped.contains("limit"),
        "{clipped}"
    );
}

/// What lies beyond the band that was asked for is not excited, whatever the ends of the drive do there; nothing renders there.
#[test]
fn what_is_not_driven_is_not_rendered() {
    let folder = support::prepared();
    let said = characterise(
        &folder,
        "--seconds 10 --band 20..300 --out narrow.json --json",
    )
    .json();
    assert_eq!(said["excited_hz"], serde_json::json!([20.0, 300.0]));
    folder.run(&["demo", "--out", "d"]).expect_success();
    let rendered = folder.run(&[
        "render",
        "d/target.wav",
        "--transfer",
        "narrow.json",
        "--level",
        "-6",
        "--out",
        "drive.wav",
        "--json",
    ]);
    let said = rendered.json();
    let highest = said["achievable_band_hz"]
        .as_array()
        .unwrap()
        .last()
        .unwrap()[1]
        .as_f64()
        .unwrap();
    assert!(highest < 305.0, "{said}");
    assert!(
        said["warnings"].to_string().contains("is not excited"),
        "{said}"
    );
    // A band below what the device answers to has nothing to be judged by, and is no error.
    characterise(
        &folder,
        "--seconds 10 --band 2..15 --gate off --out low.json",
    )
    .expect_success();
}

#[test]
fn channels_that_cannot_be_meant_are_named() {
    let folder = Folder::new();
    let Measured { drive, response } = measured();
    let late: Vec<f64> = [vec![0.0; 300], response[..response.len() - 300].to_vec()].concat();
    // 60 ms of a segment of 205 ms.
    let late = transfer(&folder, "late", &drive, &late);
    assert!(
        late.contains("62.2") && late.contains("ms after the drive"),
        "{late}"
    );
    folder
        .run(&[
            "transfer",
            "late.csv",
            "--drive",
            "drive",
            "--response",
            "drive",
            "--out",
            "tf.json",
        ])
        .expect_failure(2, &["`drive` is both drive and response"]);
    let mut text = String::from("time [s],nail [m/s2],drive [V]\n");
    for (i, (x, y)) in drive.iter().zip(&response).enumerate() {
        writeln!(text, "{},{x},{y}", i as f64 / RATE_HZ).unwrap();
    }
    folder.write("units.csv", text);
    let done = folder.run(&[
        "transfer",
        "units.csv",
        "--drive",
        "nail",
        "--response",
        "drive",
        "--out",
        "tf.json",
    ]);
    done.expect_success();
    assert!(
        done.err()
            .contains("exchange them (--drive and --response)"),
        "{}",
        done.err()
    );
}
