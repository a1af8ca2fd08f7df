//! What a laboratory reads of its own files with programs of its own: labels, criteria, and files that are no recording.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use crate::known_cuts::{Kind, Random, recorded, table};
use crate::support::{self, Folder};

/// Strokes and rejects have their criteria, in JSON and as columns; reasons are counted by their codes.
#[test]
fn criteria_are_numbers() {
    let folder = Folder::new();
    let kinds = [
        Kind::Plain,
        Kind::StickSlip,
        Kind::Plain,
        Kind::TouchOnly,
        Kind::Plain,
    ];
    let made = recorded(&mut Random::new(3), &kinds);
    folder.write("S8.csv", table(&made));
    let found = folder.run(&[
        "strokes",
        "--cuts-only",
        "S8.csv",
        "--csv",
        "cuts.csv",
        "--json",
    ]);
    let found = found.json();
    let take = &found["recordings"][0];
    let (strokes, rejected) = (
        take["cuts"].as_array().unwrap(),
        take["rejected"].as_array().unwrap(),
    );
    for part in strokes.iter().chain(rejected) {
        let criteria = part["criteria"].as_array().unwrap();
        assert!(criteria.len() > 2, "{part}");
    }
    assert!(
        strokes[0]["criteria"]
            .as_array()
            .unwrap()
            .iter()
            .all(|c| c["outcome"] == "met"),
        "{take}"
    );
    let reasons = take["warnings"]
        .as_array()
        .unwrap()
        .iter()
        .find(|d| d["code"] == "rejected");
    let reasons = &reasons.unwrap()["reasons"];
    assert_eq!(
        *reasons,
        serde_json::json!({ "stick_slip": 1, "no_sliding": 1 })
    );
    let rows = std::fs::read_to_string(folder.path("cuts.csv")).unwrap();
    assert_eq!(rows.lines().count(), 6, "{rows}");
    let header: Vec<&str> = rows.lines().next().unwrap().split(',').collect();
    for column in [
        "steady_part_found",
        "steady_part_limit",
        "slip_rate_outcome",
        "force_deviation_found",
    ] {
        assert!(header.contains(&column), "no {column} in {header:?}");
    }
    assert!(
        rows.contains(",not_met") && !rows.contains("at least"),
        "{rows}"
    );
}

/// Labels of a recording and of its name are one set, in JSON and in the columns of tables.
#[test]
fn labels_reach_json_and_tables() {
    let folder = Folder::new();
    folder.write(
        "a_7.wav",
        support::wav(support::noise(20_000).map(|v| v * 0.1), 5_000),
    );
    folder.write(
        "a_7.wav.json",
        r#"{"full_scale": "3 m/s2", "labels": {"session": "2"}}"#,
    );
    let meta = ["a_7.wav", "--meta", "{sample}_{run}", "--json", "--csv"];
    for (command, table) in [
        (&["strokes", "--cuts-only"][..], "cuts.csv"),
        (&["strokes"], "strokes.csv"),
    ] {
        let arguments = [command, &meta[..], &[table]].concat();
        let labels = &folder.run(&arguments).json()["recordings"][0]["labels"];
        let expected = serde_json::json!({ "run": "7", "sample": "a", "session": "2" });
        assert_eq!(*labels, expected, "{command:?}");
        let rows = std::fs::read_to_string(folder.path(table)).unwrap();
        let (header, first) = rows.split_once('\n').unwrap();
        let at = |name: &str| header.split(',').position(|column| column == name).unwrap();
        let cells: Vec<&str> = first.lines().next().unwrap().split(',').collect();
        assert_eq!(
            [cells[at("label_run")], cells[at("label_session")]],
            ["7", "2"],
            "{rows}"
        );
        assert!(!header.contains("label_sample"), "{header}");
    }
}

/// `info` says what a file of the program is that is no recording, and what reads it.
#[test]
fn info_names_files_that_are_no_recording() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("panel")).unwrap();
    folder.write(
        "panel/panel.json",
        r#"{"format": "piezotact panel 1", "entries": [1, 2]}"#,
    );
    for name in ["panel/panel.json", "panel"] {
        let said = folder.run(&["info", name]);
        said.expect_success();
        let text = said.out();
        assert!(
            text.contains("the index of a panel of 2")
                && text.contains("`piezotact panel analyse panel`"),
            "{text}"
        );
        assert_eq!(
            folder.run(&["info", name, "--json"]).json()["measurements"],
            2
        );
    }
    let parts = ["the index of a panel", "piezotact panel analyse panel"];
    folder
        .run(&["spectrum", "panel/panel.json"])
        .expect_failure(1, &["JSON"]);
    folder
        .run(&["export", "panel/panel.json", "--out", "a.uff"])
        .expect_failure(1, &parts[..1]);
    folder.write(
        "own.toml",
        include_str!("../../piezotact/src/device/fixed.toml"),
    );
    let said = folder.run(&["info", "own.toml"]);
    said.expect_success();
    assert!(
        said.out().contains("the description of a device") && said.out().contains("gain x20"),
        "{}",
        said.out()
    );
    std::fs::create_dir(folder.path("a.runs")).unwrap();
    folder
        .run(&["info", "a.runs"])
        .expect_failure(1, &["found no run in it"]);
    let record = "twin record --bench acttouch --sample S4 --participant 3 --strokes 1 --out a.runs/one.parquet";
    folder
        .run(&record.split(' ').collect::<Vec<_>>())
        .expect_success();
    let said = folder.run(&["info", "a.runs", "--json"]).json();
    assert_eq!(
        (&said["kind"], &said["runs"][0]["ended"]),
        (&"kept runs".into(), &"ended".into()),
        "{said}"
    );
}
