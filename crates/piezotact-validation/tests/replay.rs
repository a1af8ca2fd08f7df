//! `piezotact-validation replay` as a black box: what it prints and writes, and what it refuses.
use crate::support::{Folder, results};

/// The claims that chapter 3 speaks of, and the figures that have a counterpart.
const CLAIMS: [u64; 11] = [10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 35];
const FIGURES: [&str; 23] = [
    "27a", "27b", "29a", "30", "31", "32", "33a", "33b", "34", "35a", "35b", "35c", "35", "36a",
    "36b", "36c", "37", "38a", "38b", "39a", "39b", "40a", "40b",
];

/// One chapter, measured twice: as a table with its report, and as JSON; with a count of one panel, which it is itself.
#[test]
fn a_chapter_is_measured_again() {
    let folder = Folder::new();
    let replay = [
        "replay",
        "--chapter",
        "3",
        "--seed",
        "2",
        "--panels",
        "1",
        "--out",
    ];
    let done = folder.run(&[&replay[..], &["new/one"]].concat());
    done.expect_success();
    let out = done.out();
    let lines: Vec<&str> = out.lines().collect();
    // A line for each claim that a panel misses.
    assert_eq!(lines.len(), 29, "{out}");
    assert!(lines[0].contains("claim") && lines[0].contains("measured"));
    for (line, claim) in lines[1..].iter().zip(CLAIMS) {
        assert!(line.trim_start().starts_with(&claim.to_string()), "{out}");
    }
    assert_eq!(lines[13], "1 panel from seed 2");
    for (line, claim) in lines[15..].iter().zip(&CLAIMS) {
        assert!(line.trim_start().starts_with(&claim.to_string()), "{out}");
        assert!(line.contains("/1 "), "{out}");
    }
    assert!(
        lines[27].starts_with("report: ") && lines[27].ends_with("report.html"),
        "{out}"
    );
    assert!(lines[28].starts_with("11 claims: holds "), "{out}");
    assert_eq!(done.err().lines().count(), 1, "{}", done.err());

    let findings = folder
        .run(&[&replay[..], &["two", "--json"]].concat())
        .json();
    let found = findings["chapters"][0]["findings"].as_array().unwrap();
    let numbers: Vec<u64> = found.iter().filter_map(|f| f["claim"].as_u64()).collect();
    assert_eq!(numbers, CLAIMS);
    let counted = findings["panels"]["claims"].as_array().unwrap();
    assert_eq!(counted.len(), 11);
    for count in counted {
        let holds =
            found.iter().find(|f| f["claim"] == count["claim"]).unwrap()["verdict"] == "holds";
        assert_eq!(
            (&count["of"], &count["held"]),
            (&1.into(), &u64::from(holds).into())
        );
        assert_eq!(
            count["misses"].as_array().unwrap().is_empty(),
            holds,
            "{count}"
        );
    }
    for finding in found {
        assert_eq!(
            finding["chapter"],
            if finding["claim"] == 35 { 2 } else { 3 }
        );
        for field in ["says", "holds_if", "measured"] {
            assert!(!finding[field].as_str().unwrap().is_empty(), "{finding}");
        }
        let reason = &finding["reason"];
        match finding["verdict"].as_str().unwrap() {
            "holds" => assert!(reason.is_null(), "{finding}"),
            "does_not_hold" | "not_yet" => assert!(reason.is_string(), "{finding}"),
            other => panic!("{other}"),
        }
    }

    // The same seed gives the same findings, to the byte, and what is printed is what is written.
    let written = |folder_name: &str| {
        std::fs::read_to_string(folder.path(folder_name).join("findings.json")).unwrap()
    };
    let parsed: serde_json::Value = serde_json::from_str(&written("two")).unwrap();
    let one = serde_json::from_str(&written("new/one")).unwrap();
    assert_eq!(
        results(one).to_string(),
        results(parsed.clone()).to_string()
    );
    assert_eq!(parsed, findings);

    let html = std::fs::read_to_string(folder.path("new/one/report.html")).unwrap();
    for claim in 1..=37 {
        assert!(html.contains(&format!("id=\"claim-{claim}\"")), "{claim}");
    }
    for finding in found {
        let says = finding["says"].as_str().unwrap();
        assert!(html.contains(says), "{says}");
    }
    for figure in FIGURES {
        assert!(
            html.contains(&format!("Counterpart of figure {figure}<")),
            "{figure}"
        );
    }
    assert!(html.contains("Digital twin") && html.contains("Seed 2, built-in parameters"));
    assert!(html.len() < 6_000_000, "{}", html.len());
}

/// Panels of another kind, version, seed or chapter are not gone on with, and nothing is measured first.
#[test]
fn stored_panels_of_another_setting_are_refused() {
    let folder = Folder::new();
    let settings = r#""settings":{"program":"0.0.9","claims":"0000000000000001","parameters":"0000000000000001","changes":[],"seed":1,"chapters":[3]}"#;
    for (stored, says) in [
        (r#"{"schema":"noise","version":1}"#.to_owned(), "noise"),
        (
            format!(r#"{{"schema":"replay_panels","version":99,{settings},"panels":[]}}"#),
            "99",
        ),
        (
            format!(r#"{{"schema":"replay_panels","version":1,{settings},"panels":[]}}"#),
            "version of the program: expected",
        ),
        ("{".to_owned(), "replay_panels"),
    ] {
        std::fs::create_dir_all(folder.path("out")).unwrap();
        std::fs::write(folder.path("out/panels.json"), &stored).unwrap();
        let done = folder.run(&["replay", "--chapter", "3", "--panels", "2", "--out", "out"]);
        assert_eq!(done.code(), Some(1), "{}", done.err());
        assert!(
            done.err().contains(says) && done.err().contains("remove the file"),
            "{}",
            done.err()
        );
        // It is left as it was.
        assert_eq!(
            std::fs::read_to_string(folder.path("out/panels.json")).unwrap(),
            stored
        );
    }
}

#[test]
fn what_cannot_be_is_refused() {
    let folder = Folder::new();
    for chapter in ["2", "7", "three"] {
        let bad = ["replay", "--out", "out", "--chapter", chapter];
        let found = format!("`{chapter}`");
        folder
            .run(&bad)
            .expect_failure(2, &["expected one of the chapters 3, 4, 5, 6", &found]);
    }
    folder.run(&["replay"]).expect_failure(2, &["--out"]);
    let with = |file| ["replay", "--chapter", "3", "--out", "out", "--twin", file];
    folder.run(&with("missing.toml")).expect_failure(
        1,
        &["missing.toml: expected a parameter file", "no such file"],
    );
    folder.write("text.toml", "a texture");
    folder
        .run(&with("text.toml"))
        .expect_failure(1, &["text.toml", "expected TOML"]);
    folder.write(
        "far.toml",
        "[hand]\nlift_s = { value = -1.0, origin = \"measured\" }",
    );
    folder
        .run(&with("far.toml"))
        .expect_failure(1, &["far.toml", "hand.lift_s: expected 0.2 to 5, found -1"]);
    assert_eq!(
        folder.names(),
        ["far.toml", "text.toml"],
        "nothing is left of what was refused"
    );
}

#[test]
fn a_place_that_cannot_be_written_is_named() {
    let folder = Folder::new();
    folder.write("taken", "a file");
    for out in ["taken", "taken/inside"] {
        folder
            .run(&["replay", "--chapter", "3", "--out", out])
            .expect_failure(1, &["cannot create the folder", out]);
    }
    std::fs::create_dir_all(folder.path("out/report.html")).unwrap();
    folder
        .run(&["replay", "--chapter", "3", "--out", "out"])
        .expect_failure(1, &["report.html", "found a folder"]);
    // A parameter file that would be replaced.
    std::fs::create_dir(folder.path("own")).unwrap();
    folder.write("own/findings.json", "");
    let own = ["replay", "--out", "own", "--twin", "own/findings.json"];
    folder.run(&own).expect_failure(2, &["would be replaced"]);
}

/// What another command wrote stands in the way; what this one wrote before does not, and a device is no parameter file.
#[test]
fn files_of_others_are_left_alone() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("out")).unwrap();
    folder.write("out/report.html", "a page");
    let again = [
        "replay",
        "--chapter",
        "3",
        "--out",
        "out",
        "--date",
        "2026-03-01",
    ];
    folder
        .run_as_given(&again)
        .expect_failure(2, &["report.html already exists", "--force"]);
    folder.run(&again).expect_success();
    let report = || std::fs::read_to_string(folder.path("out/report.html")).unwrap();
    let first = report();
    assert!(
        first.contains("piezotact-validation 0")
            && first.contains("<span>piezotact-validation</span> <span>--force</span>")
    );
    let parts = ["--figures", "figures", "--tables", "tables"];
    folder
        .run_as_given(&[&again[..], &parts].concat())
        .expect_success();
    for (parts, ending, least) in [("figures", "svg", 23), ("tables", "csv", 1)] {
        let files = std::fs::read_dir(folder.path(parts)).unwrap();
        let names = files.map(|file| file.unwrap().path());
        let names = names.filter(|name| name.extension().is_some_and(|found| found == ending));
        assert!(names.count() >= least, "{parts}");
    }
    assert_eq!(
        report().split("<section id=\"invocation\">").next(),
        first.split("<section id=\"invocation\">").next()
    );
    #[cfg(unix)]
    folder
        .run(&["replay", "--out", "r", "--twin", "/dev/zero"])
        .expect_failure(1, &["found a device or a pipe"]);
}
