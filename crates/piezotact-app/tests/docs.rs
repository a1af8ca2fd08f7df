//! What the README tells a user to do is done, in its order.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test fails where it cannot go on"
)]

mod support;

use std::path::Path;

use support::Folder;

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

#[test]
fn the_readme_s_tour_works() {
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    let folder = Folder::new();
    let mut ran = 0;
    for line in readme
        .lines()
        .filter_map(|line| line.strip_prefix("$ piezotact "))
    {
        let arguments: Vec<&str> = line.split_whitespace().collect();
        folder.run(&arguments).expect_success();
        ran += 1;
    }
    assert!(ran >= 8, "the tour has only {ran} commands");
    for name in ["psd.svg", "report.html", "measured.parquet"] {
        assert!(folder.path(name).exists(), "the tour leaves no {name}");
    }
}

/// The examples in the help name options that exist: each is parsed up to its files.
#[test]
fn the_examples_in_the_help_are_understood() {
    let folder = Folder::new();
    let mut ran = 0;
    for command in [
        "demo",
        "info",
        "spectrum",
        "characterise",
        "transfer",
        "render",
        "play",
        "verify",
    ] {
        let help = folder.run(&[command, "--help"]).out();
        let examples = help.split_once("Example:").unwrap().1;
        for line in examples
            .lines()
            .filter_map(|line| line.trim().strip_prefix("piezotact "))
        {
            let line = line.split(" > ").next().unwrap();
            // Words, with quoted ones kept together.
            let arguments: Vec<&str> = line
                .split('"')
                .enumerate()
                .flat_map(|(i, part)| {
                    if i % 2 == 1 {
                        vec![part]
                    } else {
                        part.split_whitespace().collect()
                    }
                })
                .collect();
            let done = folder.run(&arguments);
            // Either it ran, or only its files are missing; never a matter of usage.
            assert_ne!(done.code(), Some(2), "{line}: {}", done.err());
            ran += 1;
        }
    }
    assert!(ran >= 9, "only {ran} examples");
}

#[test]
fn links_of_the_documents_lead_somewhere() {
    for document in [
        "README.md",
        "ARCHITECTURE.md",
        "CONTRIBUTING.md",
        "CHANGELOG.md",
    ] {
        let text = std::fs::read_to_string(root().join(document)).unwrap();
        for link in text
            .split("](")
            .skip(1)
            .filter_map(|rest| rest.split(')').next())
        {
            assert!(root().join(link).exists(), "{document} links to {link}");
        }
        for path in text
            .split('`')
            .skip(1)
            .step_by(2)
            .filter(|code| code.starts_with("crates/"))
        {
            assert!(root().join(path).exists(), "{document} names {path}");
        }
    }
}
