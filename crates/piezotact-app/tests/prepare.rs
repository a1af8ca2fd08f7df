//! `prepare`: strokes of one session to verified drives, as a black box.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::sync::OnceLock;

use serde_json::Value;

use crate::support::{Done, Folder};

const BENCH: &str = "twin:participant=2,seed=7";

fn record(folder: &Folder, sample: &str, participant: &str) {
    let out = format!("{sample}.parquet");
    let arguments = [
        "twin",
        "record",
        "--bench",
        "acttouch",
        "--sample",
        sample,
        "--participant",
        participant,
        "--seed",
        "7",
        "--strokes",
        "4",
        "--out",
        &out,
    ];
    folder.run(&arguments).expect_success();
}

/// A folder with the strokes of participant 2 on S1 and S11 and their transfer function.
fn session() -> Folder {
    static SESSION: OnceLock<Folder> = OnceLock::new();
    Folder::once(&SESSION, || {
        let folder = Folder::new();
        record(&folder, "S1", "2");
        record(&folder, "S11", "2");
        let arguments = [
            "characterise",
            "--bench",
            BENCH,
            "--seconds",
            "20",
            "--out",
            "tf.json",
        ];
        folder.run(&arguments).expect_success();
        folder
    })
}

fn prepare(folder: &Folder, rest: &str) -> Done {
    prepare_with(folder, "tf.json", rest)
}

fn prepare_with(folder: &Folder, transfer: &str, rest: &str) -> Done {
    let all: Vec<&str> = ["prepare", "--transfer", transfer]
        .into_iter()
        .chain(rest.split(' '))
        .collect();
    folder.run(&all)
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[test]
fn a_session_becomes_verified_drives_that_keep_their_differences() {
    let folder = session();
    let command =
        format!("S1.parquet S11.parquet --bench {BENCH} --out ready --report ready.html --json");
    let done = prepare(&folder, &command);
    assert_eq!(done.code(), Some(0), "{}", done.err());
    let found = done.json_and_code().0;
    assert_eq!(found["sentence"], "All 2 drives passed");
    assert!(found["not_good_enough"].as_array().unwrap().is_empty());
    let textures = found["textures"].as_array().unwrap();
    // One level for both, so that their difference is that of the samples.
    let level_db = number(&found["level_db"]);
    assert!(level_db <= 0.0);
    for texture in textures {
        assert_eq!(number(&texture["level_db"]), level_db);
        assert_eq!(texture["strokes"], 4);
    }
    for name in ["S1", "S11"] {
        // The verification of the same files says the same.
        let arguments = [
            "verify",
            "--target",
            &format!("ready/targets/{name}.wav"),
            "--measured",
            &format!("ready/measured/{name}.parquet"),
            "--json",
        ];
        let verified = folder.run(&arguments).json();
        let own = textures.iter().find(|one| one["texture"] == name).unwrap();
        assert_eq!(own["verification"]["criteria"], verified["criteria"]);
        assert_eq!(own["sentence"], verified["sentence"]);
        assert!(
            folder
                .path(&format!("ready/drives/{name}.wav.json"))
                .is_file()
        );
    }
    let report = std::fs::read_to_string(folder.path("ready.html")).unwrap();
    assert!(report.contains("All 2 drives passed") && report.contains("P02"));
    let again = folder.run(&["rerun", "ready.html"]);
    assert_eq!(again.code(), Some(0), "{}{}", again.out(), again.err());
    // A second session in the same folder keeps what was measured before.
    prepare(&folder, &command).expect_success();
    assert!(folder.path("ready/measured/S1.parquet").is_file());
}

#[test]
fn what_was_prepared_before_is_kept() {
    let folder = session();
    let command = format!("S11.parquet --bench {BENCH} --out ready");
    prepare(&folder, &command).expect_success();
    let bare = |rest: &str| {
        let words = ["prepare", "--transfer", "tf.json"].into_iter();
        let words: Vec<&str> = words.chain(rest.split(' ')).collect();
        folder.run_as_given(&words)
    };
    // The same again: the same files, none of them twice.
    let again = bare(&command);
    assert_eq!(again.code(), Some(0), "{}", again.err());
    let measured = std::fs::read_dir(folder.path("ready/measured")).unwrap();
    assert_eq!(measured.count(), 1);
    // Another level is another drive: the earlier one and its measurement are kept.
    let other = format!("S11.parquet --level -3 --bench {BENCH} --out ready");
    let drive = std::fs::read(folder.path("ready/drives/S11.wav")).unwrap();
    let done = bare(&other);
    done.expect_success();
    for name in ["drives/S11.wav", "measured/S11.parquet"] {
        let kept = format!("{name}: what an earlier command left is kept as");
        assert!(done.err().contains(&kept), "{}", done.err());
    }
    let kept = folder.path("ready/drives/S11.wav.before-1");
    assert_eq!(std::fs::read(kept).unwrap(), drive);
    // What is no drive of ours is not moved.
    std::fs::remove_file(folder.path("ready/drives/S11.wav.json")).unwrap();
    let refused = bare(&format!("{command} --level -4"));
    refused.expect_failure(3, &[]);
    let said = refused.out();
    assert!(
        said.contains("S11.wav already exists") && said.contains("--force"),
        "{said}"
    );
}

/// Data of which "passed" would be false.
#[test]
fn another_finger_a_rehearsal_and_no_bench_do_not_pass() {
    let folder = session();
    // A transfer function of somebody else that does not say so.
    let arguments = [
        "characterise",
        "--bench",
        "twin:participant=5,seed=7",
        "--seconds",
        "20",
        "--out",
        "other.json",
    ];
    folder.run(&arguments).expect_success();
    let text = std::fs::read_to_string(folder.path("other.json")).unwrap();
    let mut function: Value = serde_json::from_str(&text).unwrap();
    function["condition"]
        .as_object_mut()
        .unwrap()
        .remove("participant");
    folder.write("other.json", function.to_string());
    let other = prepare_with(
        &folder,
        "other.json",
        &format!("S11.parquet --bench {BENCH} --out other --json"),
    );
    assert_eq!(other.code(), Some(3), "{}", other.err());
    assert_eq!(
        other.json_and_code().0["textures"][0]["state"],
        "not_passed"
    );
    // What missed was measured three times, and the middle one counts, not the best.
    let error_db = |name: &str| {
        let measured = format!("other/measured/{name}.parquet");
        let arguments = [
            "verify",
            "--target",
            "other/targets/S11.wav",
            "--measured",
            &measured,
            "--json",
        ];
        let found = folder.run(&arguments).json_and_code().0;
        number(&found["error_db_rms_achievable"])
    };
    let kept = error_db("S11");
    let mut turns = ["S11.1", "S11.2", "S11.3"].map(error_db);
    turns.sort_by(f64::total_cmp);
    assert!(turns[0] < kept && kept < turns[2], "{kept} of {turns:?}");
    assert_eq!(kept, turns[1]);
    // Somebody else at the bench is refused before anything plays.
    let elsewhere = prepare(
        &folder,
        "S11.parquet --bench twin:participant=5,seed=7 --out elsewhere",
    );
    elsewhere.expect_failure(2, &["expected P02", "at the bench", "found P05"]);
    assert!(!folder.path("elsewhere").exists());
    let rehearsed = prepare(
        &folder,
        "S11.parquet --bench measured:tf.json --out rehearsed --json",
    );
    assert_eq!(rehearsed.code(), Some(5));
    assert_eq!(
        rehearsed.json_and_code().0["sentence"],
        "No drive passed; S11 rehearsed only"
    );
    let alone = prepare(&folder, "S11.parquet --out alone --json");
    assert_eq!(alone.code(), Some(5));
    assert_eq!(
        alone.json_and_code().0["textures"][0]["state"],
        "not_measured"
    );
    assert!(!folder.path("alone/measured").exists());
    // A level far above the device: nothing is written as a drive.
    let loud = prepare(
        &folder,
        &format!("S11.parquet --level 60 --bench {BENCH} --out loud --json"),
    );
    assert_eq!(loud.code(), Some(3));
    assert_eq!(
        loud.json_and_code().0["textures"][0]["state"],
        "not_rendered"
    );
    assert!(!folder.path("loud/drives/S11.wav").exists());
}

#[test]
fn strokes_and_transfer_functions_of_other_people_are_refused() {
    let folder = session();
    record(&folder, "S8", "3");
    for command in ["S8.parquet --out no", "S8.parquet S11.parquet --out no"] {
        let refused = prepare(&folder, command);
        assert_eq!(refused.code(), Some(2));
        assert!(
            refused.err().contains("one participant"),
            "{}",
            refused.err()
        );
        assert!(!folder.path("no").exists());
    }
}

#[test]
fn a_recording_without_strokes_does_not_stop_the_others() {
    let folder = session();
    folder.write("rest.csv", {
        let rows = (0..5000).map(|i| {
            format!(
                "{:.4},{:.4},0.0\n",
                f64::from(i) / 5000.0,
                f64::from(i % 7) * 1e-3
            )
        });
        format!(
            "time (s),acceleration (m/s2),normal_force (N)\n{}",
            rows.collect::<String>()
        )
    });
    let done = prepare(
        &folder,
        &format!("rest.csv S11.parquet --bench {BENCH} --out ready --json"),
    );
    assert_eq!(done.code(), Some(1), "{}", done.err());
    assert!(done.err().contains("rest.csv"));
    assert_eq!(done.json_and_code().0["textures"][0]["state"], "passed");
    assert_eq!(done.json_and_code().0["outcome"], "not_decided");
}

#[test]
fn a_closed_loop_and_own_levels_can_be_asked_for() {
    let folder = session();
    let looped = format!(
        "S1.parquet S11.parquet --mode texture --iterations 1 --bench {BENCH} --out looped --json"
    );
    let found = prepare(&folder, &looped).json_and_code().0;
    for texture in found["textures"].as_array().unwrap() {
        assert!(texture["measured"].is_string() && texture["state"] != "not_measured");
        assert!(number(&texture["verification"]["level_error_db"]).abs() < 1.5);
    }
    assert_eq!(found["mode"], "texture");
    let own = prepare(
        &folder,
        &format!("S1.parquet S11.parquet --level fit --bench {BENCH} --out own --json"),
    )
    .json_and_code()
    .0;
    let levels: Vec<f64> = own["textures"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| number(&one["level_db"]))
        .collect();
    let codes: Vec<&str> = own["warnings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|warning| warning["code"].as_str().unwrap())
        .collect();
    assert_eq!(
        codes.contains(&"levels_differ"),
        (levels[0] - levels[1]).abs() > 0.05,
        "{levels:?}"
    );
    assert!(own["level_db"].is_null());
}

/// Target, drive and measurement are of one command, files of one name are two textures, and other conditions are said.
#[test]
fn sessions_in_one_folder_do_not_mix() {
    let folder = session();
    let fits = format!("S1.parquet --bench {BENCH} --out ready");
    prepare(&folder, &fits).expect_success();
    let loud = format!("S1.parquet --level 30 --bench {BENCH} --out ready");
    let bytes = || {
        let names = [
            "targets/S1.wav",
            "drives/S1.wav",
            "drives/S1.wav.json",
            "measured/S1.parquet",
        ];
        names.map(|name| std::fs::read(folder.path(&format!("ready/{name}"))).unwrap())
    };
    let before = bytes();
    assert_eq!(prepare(&folder, &loud).code(), Some(3));
    assert!(
        bytes() == before,
        "what could not be rendered leaves what was there"
    );
    // Without a sample, two files of one name.
    for part in ["a", "b"] {
        std::fs::create_dir(folder.path(part)).unwrap();
    }
    let stroke = |name: &str, hz: f64| {
        let rows = (0..15_000).map(|i| {
            let t = f64::from(i) / 5000.0;
            let on = if (0.5..2.5).contains(&t) { 1.0 } else { 0.0 };
            let wave = on * (std::f64::consts::TAU * hz * t).sin();
            format!(
                "{t:.4},{:.5},{:.5},{:.5}\n",
                wave,
                0.2 * on + 0.001 * wave,
                0.08 * on
            )
        });
        let text = format!(
            "time (s),acc (m/s2),fz (N),fx (N)\n{}",
            rows.collect::<String>()
        );
        folder.write(name, text);
    };
    stroke("a/rec.csv", 130.0);
    stroke("b/rec.csv", 230.0);
    let two = prepare(&folder, "a/rec.csv b/rec.csv --out two --json")
        .json_and_code()
        .0;
    let names: Vec<&str> = two["textures"]
        .as_array()
        .unwrap()
        .iter()
        .map(|one| one["texture"].as_str().unwrap())
        .collect();
    assert_eq!(names, ["rec", "b/rec"]);
    // Strokes at another load than the transfer function.
    let heavy = prepare(&folder, "S11.parquet --load 0.21 --out same --json")
        .json_and_code()
        .0;
    let codes = |found: &Value| found["textures"][0]["warnings"].to_string();
    let other_load = r#""what":"strokes_load""#;
    assert!(!codes(&heavy).contains(other_load));
    let arguments = [
        "twin",
        "record",
        "--bench",
        "acttouch",
        "--sample",
        "S8",
        "--participant",
        "2",
        "--seed",
        "7",
        "--strokes",
        "4",
        "--load",
        "0.5",
        "--out",
        "heavy.parquet",
    ];
    folder.run(&arguments).expect_success();
    let heavy = prepare(&folder, "heavy.parquet --out heavy --json")
        .json_and_code()
        .0;
    assert!(codes(&heavy).contains(other_load), "{heavy}");
}

/// A texture that nobody feels at this level is said to be so.
#[test]
fn a_drive_below_the_threshold_is_reported() {
    let folder = session();
    let soft = format!("S11.parquet --level -60 --bench {BENCH} --out soft --json");
    let found = prepare(&folder, &soft).json_and_code().0;
    let said = found["textures"][0]["warnings"].to_string();
    assert!(said.contains("not_felt"), "{said}");
}
