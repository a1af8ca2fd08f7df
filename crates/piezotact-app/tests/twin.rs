//! `twin` as a black box: recordings that analyse as they should, surfaces that measure as they should, and refusals.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use crate::support::{self, Folder};

const RECORD: [&str; 3] = ["twin", "record", "--bench"];

fn record(folder: &Folder, arguments: &str) -> support::Done {
    let all: Vec<&str> = RECORD.into_iter().chain(arguments.split(' ')).collect();
    folder.run(&all)
}

/// As `--bench acttouch` of the help: every stroke is found, the level is the person's own, and the condition is known.
#[test]
fn active_strokes_are_found_and_analysed() {
    let folder = Folder::new();
    let asked = "acttouch --sample S4 --participant 3 --speed 30mm/s --strokes 15 --out S4.parquet";
    record(&folder, asked).expect_success();
    let cut = folder
        .run(&["strokes", "--cuts-only", "S4.parquet", "--json"])
        .json();
    assert_eq!(
        cut["recordings"][0]["cuts"].as_array().unwrap().len(),
        15,
        "{cut}"
    );
    let said = folder.run(&["strokes", "S4.parquet", "--json"]).json();
    let group = &said["groups"][0];
    assert_eq!(group["name"], "S4");
    // 1.36 m/s² times a person's own 15 % and 10 %, cut at two standard deviations.
    let rms = group["rms"]["mean"].as_f64().unwrap();
    assert!((0.8..2.5).contains(&rms), "{rms}");
    let friction = group["friction_coefficient"]["mean"].as_f64().unwrap();
    assert!((0.5..0.95).contains(&friction), "{friction}");
}

/// The reference participant's fingerprint on S1, 0.545 mm, at two speeds: v/λ within a tenth, as 4.9 Hz lines allow.
#[test]
fn passive_touch_shows_the_fingerprint() {
    let folder = Folder::new();
    for (speed, expected_hz) in [("20mm/s", 36.7), ("30mm/s", 55.0)] {
        let asked =
            format!("triboair --sample S1 --participant 0 --speed {speed} --out S1.parquet");
        record(&folder, &asked).expect_success();
        let said = folder
            .run(&["strokes", "S1.parquet", "--ridge", "0.545mm", "--json"])
            .json();
        let found_hz = said["groups"][0]["fingerprint"]["found_hz"]
            .as_f64()
            .unwrap();
        assert!((found_hz / expected_hz - 1.0).abs() < 0.1, "{found_hz}");
    }
}

#[test]
fn one_command_gives_the_same_bytes_and_another_seed_others() {
    let folder = Folder::new();
    for (bench, end) in [
        ("acttouch --sample NO --strokes 2", "parquet"),
        ("triboair --sample M8 --strokes 1", "parquet"),
        ("shaker --seconds 2", "parquet"),
        (
            "acttouch --sample M1 --strokes 2 --direction circular",
            "wav",
        ),
    ] {
        let bytes = |name: &str, more: &str| {
            let name = format!("{name}.{end}");
            record(&folder, &format!("{bench}{more} --out {name}")).expect_success();
            std::fs::read(folder.path(&name)).unwrap()
        };
        let one = bytes("one", "");
        assert!(one == bytes("again", ""), "{bench}");
        assert!(one != bytes("other", " --seed 2"), "{bench}");
        assert!(one != bytes("labelled", " --label another"), "{bench}");
        for name in ["one", "again", "other", "labelled"] {
            std::fs::remove_file(folder.path(&format!("{name}.{end}"))).unwrap();
        }
    }
}

/// The EEG of one person in each of the three formats: the same channels and trials, found again by `info`; another task, label, person
/// or seed gives another recording.
#[test]
fn eeg_is_written_as_other_programs_read_it() {
    let folder = Folder::new();
    for end in ["parquet", "vhdr", "edf"] {
        let asked = format!("eeg --task imagery --trials 2 --participant 3 --out a.{end} --json");
        let said = record(&folder, &asked).json();
        assert_eq!(said["channels"].as_array().unwrap().len(), 66, "{said}");
        assert_eq!(said["channels"][12][0], "C3");
        assert_eq!(said["condition"]["participant"], "P03");
        let info = folder.run(&["info", &format!("a.{end}"), "--json"]);
        info.expect_success();
        let info = info.out();
        assert!(info.contains("imagery") && info.contains("BIO"), "{info}");
        assert!(info.contains("VEOG") && info.contains("512"), "{info}");
    }
    let bytes = |more: &str| {
        let asked = format!("eeg --trials 1 --out b.parquet {more}");
        record(&folder, &asked).expect_success();
        let bytes = std::fs::read(folder.path("b.parquet")).unwrap();
        std::fs::remove_file(folder.path("b.parquet")).unwrap();
        bytes
    };
    let one = bytes("--task natural");
    assert!(one == bytes("--task natural"));
    for other in [
        "--task control",
        "--task natural --label two",
        "--task natural --seed 2",
        "--task natural --participant 2",
    ] {
        assert!(one != bytes(other), "{other}");
    }
}

/// Another recording of the same name is kept, or the command refuses before it does anything.
#[test]
fn no_eeg_is_replaced() {
    let folder = Folder::new();
    for end in ["parquet", "edf"] {
        let asked =
            |seed: &str| format!("eeg --task control --trials 1 --seed {seed} --out a.{end}");
        record(&folder, &asked("1")).expect_success();
        record(&folder, &asked("2")).expect_success();
        assert!(folder.names().contains(&format!("a.{end}.before-1")));
    }
    // The three files of a header name each other: the same recording stays, and another one is refused.
    let asked = |seed: &str| format!("eeg --task control --trials 1 --seed {seed} --out a.vhdr");
    record(&folder, &asked("1")).expect_success();
    let samples = std::fs::read(folder.path("a.eeg")).unwrap();
    record(&folder, &asked("1")).expect_success();
    record(&folder, &asked("2")).expect_failure(2, &["a.eeg"]);
    assert_eq!(std::fs::read(folder.path("a.eeg")).unwrap(), samples);
    folder.write("real.eeg", "samples");
    record(&folder, "eeg --task control --out real.vhdr").expect_failure(2, &["real.eeg"]);
    assert!(!folder.names().contains(&"real.vhdr".to_owned()));
}

/// A map has the Ra of its sample as its Sa, and dots their height.
#[cfg(feature = "surface")]
#[test]
fn surfaces_measure_as_their_samples() {
    let folder = Folder::new();
    for (sample, more, parameter, expected_um, within_um) in [
        ("S4", "", "Sa", 14.4, 0.01),
        ("NO", "", "Sa", 0.1, 0.001),
        ("M8", " --size 3mm --step 4um", "Sz", 18.0, 2.0),
    ] {
        let asked = format!("twin surface {sample} --out {sample}.sur{more}");
        let asked: Vec<&str> = asked.split(' ').collect();
        folder.run(&asked).expect_success();
        let file = format!("{sample}.sur");
        let said = folder
            .run(&["roughness", &file, "--form", "mean", "--json"])
            .json();
        let found = said["parameters"][parameter]
            .as_f64()
            .or_else(|| said[parameter].as_f64())
            .or_else(|| said["areal"][parameter].as_f64())
            .unwrap_or_else(|| panic!("{said}"));
        let found_um = if found < 1e-2 { found * 1e6 } else { found };
        assert!(
            (found_um - expected_um).abs() <= within_um,
            "{sample}: {found_um}"
        );
    }
}

#[test]
fn a_laboratory_s_file_counts_and_is_named() {
    let folder = Folder::new();
    folder.write(
        "own.toml",
        "[samples.S4]\nrms_m_s2 = { value = 5.0, origin = \"measured\" }\n",
    );
    let asked = "triboair --sample S4 --participant 0 --strokes 3 --twin own.toml --out S4.parquet";
    record(&folder, asked).expect_success();
    let said = folder.run(&["strokes", "S4.parquet", "--json"]).json();
    let rms = said["groups"][0]["rms"]["mean"].as_f64().unwrap();
    assert!((rms / 5.0 - 1.0).abs() < 0.15, "{rms}");
    let info = folder.run(&["info", "S4.parquet"]).out();
    assert!(
        info.contains("samples.S4.rms_m_s2 = 5.0 (measured)"),
        "{info}"
    );
    let printed = folder.run(&["twin", "parameters", "--twin", "own.toml"]);
    printed.expect_success();
    assert!(printed.out().contains("samples.S4.rms_m_s2"));
    let all = folder.run(&["twin", "parameters"]).out();
    folder.write("all.toml", &all);
    // What is printed can be read back as a whole.
    folder
        .run(&["twin", "parameters", "--twin", "all.toml"])
        .expect_success();
}

#[test]
fn what_cannot_be_is_refused_with_what_can() {
    let folder = Folder::new();
    folder.write(
        "zero.toml",
        "[samples.M8]\nwavelength_m = { value = 0.0, origin = \"chosen\" }\n",
    );
    for (asked, code, says) in [
        (
            "acttouch --sample S99 --out a.parquet",
            2,
            "expected a sample of the twin",
        ),
        (
            "acttouch --out a.parquet",
            2,
            "expected a sample, found none",
        ),
        (
            "acttouch --sample S1 --load -1 --out a.parquet",
            2,
            "a load in N from 0.05 to 2",
        ),
        (
            "acttouch --sample S1 --load nan --out a.parquet",
            2,
            "a load in N from 0.05 to 2",
        ),
        (
            "acttouch --sample S1 --speed 300mm/s --out a.parquet",
            2,
            "a speed from 6.67 to 66.67 mm/s",
        ),
        (
            "acttouch --sample S1 --speed -30mm/s --out a.parquet",
            2,
            "expected",
        ),
        (
            "acttouch --sample S1 --speed 30 --out a.parquet",
            2,
            "expected a speed with its unit",
        ),
        (
            "acttouch --sample S1 --speed 60mm/s --stroke-time 1s --out a.parquet",
            2,
            "at most 40 mm/s for 1 s, or at most 0.667 s at 60 mm/s",
        ),
        (
            "acttouch --sample S1 --strokes 0 --out a.parquet",
            2,
            "from 1 to",
        ),
        (
            "triboair --sample S1 --speed 200mm/s --out a.parquet",
            2,
            "s of plateau are left on the track of 35 mm",
        ),
        (
            "triboair --sample S1 --free --out a.parquet",
            2,
            "--free, which this bench does not use",
        ),
        (
            "shaker --sample S1 --out a.parquet",
            2,
            "--sample, which this bench does not use",
        ),
        (
            "eeg --out a.edf",
            2,
            "expected a task, found none; name one of natural, control, imagery",
        ),
        ("eeg --task sleep --out a.edf", 2, "sleep"),
        (
            "eeg --task natural --out a.wav",
            2,
            "ends in .parquet or .vhdr or .edf",
        ),
        (
            "eeg --task natural --trials 0 --out a.edf",
            2,
            "trials of a surface: expected 1 to 500",
        ),
        (
            "eeg --task natural --trials 9999999 --out a.edf",
            2,
            "expected 1 to 500",
        ),
        (
            "eeg --task natural --sample S1 --out a.edf",
            2,
            "--sample, which this bench",
        ),
        (
            "eeg --task natural --load 0.2 --out a.edf",
            2,
            "--load, which this bench",
        ),
        (
            "eeg --task natural --live --out a.edf",
            2,
            "--live, which this bench",
        ),
        (
            "eeg --task natural --out nowhere/a.vhdr",
            1,
            "expected the folder",
        ),
        (
            "acttouch --sample S1 --task natural --out a.parquet",
            2,
            "--task, which this bench does not use",
        ),
        (
            "shaker --trials 3 --out a.parquet",
            2,
            "--trials, which this bench does not use",
        ),
        (
            "shaker --seconds 9999 --out a.parquet",
            2,
            "a duration from 1 to 600 s, found 9999 s; 60 s is usual (--seconds)",
        ),
        (
            "acttouch --sample M8 --twin zero.toml --out a.parquet",
            1,
            "samples.M8.wavelength_m: expected 0.00001 to 0.005, found 0",
        ),
        (
            "acttouch --sample M8 --twin none.toml --out a.parquet",
            1,
            "none.toml",
        ),
        (
            "acttouch --sample M8 --out nowhere/a.parquet",
            1,
            "expected the folder",
        ),
    ] {
        let done = record(&folder, asked);
        done.expect_failure(code, &[says]);
    }
    for (asked, says) in [
        (
            "twin surface S99 --out a.sur",
            "expected a sample of the twin",
        ),
        ("twin surface S1 --step 0.01um --out a.sur", "expected"),
        ("twin surface M8 --size 1um --out a.sur", "expected"),
    ] {
        let all: Vec<&str> = asked.split(' ').collect();
        let done = folder.run(&all);
        done.expect_failure(2, &[says]);
    }
    assert_eq!(folder.names(), ["zero.toml"]);
}
