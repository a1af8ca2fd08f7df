//! The studies in `examples/`: every command runs, and prints what its README shows.
//!
//! `PIEZOTACT_WRITE_GOLDEN=1 cargo test --locked --workspace examples` writes outputs and figures again.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::path::{Path, PathBuf};

use crate::support::Folder;

fn examples() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples")
}

/// The figure `number`, from 1, of a report.
fn figure(report: &str, number: usize) -> Option<&str> {
    let figure = report.split("<figure>").nth(number)?;
    Some(&figure[..figure.find("</svg>")? + "</svg>".len()])
}

/// `readme` with the output of every command as the program prints it today, and the figures that it shows, by file name.
fn as_run(folder: &Folder, readme: &str) -> (String, Vec<(String, String)>) {
    let (mut text, mut figures) = (String::new(), Vec::new());
    let mut in_output = false;
    let mut lines = readme.lines();
    while let Some(line) = lines.next() {
        if let Some(command) = line.strip_prefix("$ piezotact ") {
            let arguments: Vec<&str> = command.split_whitespace().collect();
            let done = folder.run_as_given(&arguments);
            done.expect_success();
            text += &format!("{line}\n{}", done.out());
            in_output = true;
            continue;
        }
        in_output &= line != "```";
        if in_output {
            continue;
        }
        text += line;
        text.push('\n');
        let Some(origin) = line.strip_prefix("<!-- figure ") else {
            continue;
        };
        let shown = lines.next().unwrap();
        text += &format!("{shown}\n");
        let (number, report) = origin.split_once(" of ").unwrap();
        let report = report.trim_end_matches(" -->");
        let report = std::fs::read_to_string(folder.path(report)).unwrap();
        let svg = figure(&report, number.parse().unwrap());
        let (_, name) = shown.trim_end_matches(')').rsplit_once('(').unwrap();
        figures.push((name.to_owned(), format!("{}\n", svg.unwrap())));
    }
    (text, figures)
}

#[track_caller]
fn check(name: &str) {
    let place = examples().join(name);
    let path = place.join("README.md");
    let readme = std::fs::read_to_string(&path).unwrap();
    let (text, figures) = as_run(&Folder::new(), &readme);
    if std::env::var_os("PIEZOTACT_WRITE_GOLDEN").is_some() {
        std::fs::write(&path, &text).unwrap();
        for (figure, svg) in &figures {
            std::fs::write(place.join(figure), svg).unwrap();
        }
    }
    assert_eq!(text, std::fs::read_to_string(&path).unwrap(), "{name}");
    assert!(!figures.is_empty(), "{name} shows no figure");
    for (figure, _) in &figures {
        let stored = std::fs::read_to_string(place.join(figure)).unwrap();
        assert!(stored.contains("<svg"), "{name}/{figure} is no figure");
    }
}

#[test]
fn one_texture_at_three_speeds() {
    check("01_three_speeds");
}

#[test]
fn a_panel_of_five_fingers_and_its_average() {
    check("02_panel_of_five");
}

#[test]
fn a_closed_loop_on_a_measured_finger() {
    check("03_closed_loop");
}

#[test]
fn every_example_has_a_test_and_stands_in_the_list() {
    let list = std::fs::read_to_string(examples().join("README.md")).unwrap();
    let tests = include_str!("examples.rs");
    for entry in std::fs::read_dir(examples()).unwrap() {
        let entry = entry.unwrap();
        let name = entry.file_name().to_string_lossy().into_owned();
        if entry.path().is_dir() {
            assert!(list.contains(&format!("({name}/README.md)")), "{name}");
            assert!(tests.contains(&format!("check(\"{name}\")")), "{name}");
        }
    }
}
