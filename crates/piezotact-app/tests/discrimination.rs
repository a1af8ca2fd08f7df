//! Which samples `piezotact compare` says are distinguishable, as a black box.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]
#![allow(
    clippy::disallowed_methods,
    reason = "a test reads files that were written"
)]

use crate::support::{self, Folder};

fn number(value: &serde_json::Value) -> f64 {
    value.as_f64().unwrap()
}

/// The strokes of one recording, its first and its second half under two names.
#[test]
fn halves_of_one_recording_are_not_distinguishable_and_text_json_and_report_agree() {
    let folder = Folder::new();
    folder
        .run(&[
            "twin",
            "record",
            "--bench",
            "acttouch",
            "--sample",
            "S4",
            "--seed",
            "3",
            "--out",
            "all.parquet",
        ])
        .expect_success();
    let cuts = folder
        .run(&["strokes", "--cuts-only", "all.parquet", "--json"])
        .json();
    let strokes = cuts["recordings"][0]["cuts"].as_array().unwrap();
    let middle = number(&strokes[strokes.len() / 2]["contact_start_s"]) - 0.05;
    let all = std::fs::read(folder.path("all.parquet")).unwrap();
    for (name, left_out) in [("A", [middle, 1e4]), ("B", [0.0, middle])] {
        folder.write(&format!("{name}_active.parquet"), all.clone());
        let cut = format!("leave-out {} {} the other half\n", left_out[0], left_out[1]);
        folder.write(&format!("{name}_active.parquet.cuts"), cut);
    }
    let run = |more: &[&str]| {
        let files = ["A_active.parquet", "B_active.parquet"];
        let by = ["--by", "file"];
        folder.run(&[&["compare"][..], &files, &by, more].concat())
    };
    let done = run(&["--report", "halves.html"]);
    done.expect_success();
    assert!(!done.out().contains("distinguishable: "), "{}", done.out());
    assert!(
        done.out().contains("halves of one sample: "),
        "{}",
        done.out()
    );
    assert!(
        done.err().contains("all strokes are from one recording"),
        "{}",
        done.err()
    );
    let html = std::fs::read_to_string(folder.path("halves.html")).unwrap();
    let line = done
        .out()
        .lines()
        .find(|l| l.contains(" and ") && l.contains("JND (95 %"))
        .unwrap()
        .to_owned();
    assert!(html.contains(&line), "the report lacks: {line}");
    let json = run(&["--json"]).json();
    assert_ne!(
        json["discrimination"]["settings"][0]["pairs"][0]["outcome"],
        "told_apart"
    );
}

/// What has no unit in m/s² is compared by JND nowhere: not in text, JSON or report.
#[test]
fn counts_are_withheld_in_text_json_and_report() {
    let Some(data) = support::shared("data/vibration/fabricslide") else {
        return;
    };
    let mut files = Vec::new();
    for board in ["2mm", "10mm"] {
        for speed in [5, 10, 20, 30] {
            let name = format!("Board{board}_F135_V-{speed}mmps_0.csv");
            files.push(data.join(name).display().to_string());
        }
    }
    let folder = Folder::new();
    let run = |more: &[&str]| {
        let mut arguments = vec!["compare"];
        arguments.extend(files.iter().map(String::as_str));
        arguments.extend(["--by", "sample"]);
        arguments.extend(more);
        folder.run(&arguments)
    };
    let done = run(&["--report", "slide.html"]);
    done.expect_success();
    let html = std::fs::read_to_string(folder.path("slide.html")).unwrap();
    for text in [&done.out(), &html] {
        assert!(
            text.contains("it is not computed which samples are distinguishable"),
            "{text}"
        );
        assert!(text.contains("Board2mm is in no unit"));
        assert!(!text.contains("distinguishable: Board") && !text.contains(" JND (95"));
    }
    assert!(!html.contains("Distances in just-noticeable differences"));
    let json = run(&["--json"]).json();
    assert_eq!(json["discrimination"]["withheld"], "not_an_acceleration");
    assert!(json["discrimination"].get("settings").is_none());
}
