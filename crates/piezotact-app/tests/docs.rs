//! What the README tells a user to do is done, in its order.
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test fails where it cannot go on"
)]

use std::path::Path;

use crate::support::{COMMANDS, Folder, noise, wav};
use piezotact::quantity::{Drive, SampleRate};
use piezotact::resample::resample;
use piezotact_dataset::{ReadOptions, read_recording};

fn root() -> &'static Path {
    Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
}

/// A line of shell as words, with what stands in quotes kept together.
fn words(line: &str) -> Vec<&str> {
    line.split(['"', '\''])
        .enumerate()
        .flat_map(|(i, part)| {
            if i % 2 == 1 {
                vec![part]
            } else {
                part.split_whitespace().collect()
            }
        })
        .collect()
}

/// The files of the README that come from a user's own hardware, of a device that is known: 3 m/s² a volt.
fn own_files(folder: &Folder) {
    folder.write("texture.wav", wav(noise(20_000).map(|v| v * 0.01), 5_000));
    let rows = noise(60_000)
        .enumerate()
        .map(|(i, v)| format!("{},{},{}\n", i as f64 / 5000.0, v, 3.0 * v));
    let rows: String = rows.collect();
    folder.write(
        "bench.csv",
        format!("time (s),drive (V),nail (m/s2)\n{rows}"),
    );
    folder.write("hits.csv", crate::impact::four_hits());
}

/// What that device answers to `own-drive.wav`, as `own.csv`.
fn own_measurement(folder: &Folder) {
    let drive = read_recording(&folder.path("own-drive.wav"), &ReadOptions::default());
    let drive = drive.unwrap().recording.series::<Drive>(None).unwrap();
    let felt = resample(&drive, SampleRate::new(5000.0).unwrap()).unwrap();
    let rows = felt.samples().iter().enumerate();
    let rows = rows.map(|(i, v)| format!("{},{:.9}\n", i as f64 / 5000.0, 3.0 * 1.41 * v));
    let rows: String = rows.collect();
    folder.write("own.csv", format!("time (s),nail (m/s2)\n{rows}"));
}

/// Every command of the README runs, in its order, in one folder that is empty at first. Only what a user measures with hardware
/// of his own is put there.
#[test]
fn the_readme_runs_from_top_to_bottom_on_an_empty_folder() {
    let readme = std::fs::read_to_string(root().join("README.md")).unwrap();
    let folder = Folder::new();
    let mut ran = 0;
    for line in readme.lines() {
        if line == "## With your own recordings and device" {
            own_files(&folder);
        }
        if line == "## With a sound device" {
            // The loop within the program, as no device is here.
            folder.write("setup.toml", crate::audio::setup(""));
        }
        let shown = line.strip_prefix("$ ").unwrap_or(line);
        let Some(line) = shown.strip_prefix("piezotact ") else {
            continue;
        };
        if line.contains("own.csv") {
            own_measurement(&folder);
        }
        folder.run_as_given(&words(line)).expect_success();
        ran += 1;
    }
    assert!(ran >= 35, "the README has only {ran} commands");
    for name in [
        "psd.svg",
        "report.html",
        "measured.parquet",
        "cuts.html",
        "strokes.csv",
        "speeds.html",
    ] {
        assert!(folder.path(name).exists(), "the commands leave no {name}");
    }
}

/// The examples in the help name options that exist: each is parsed up to its files.
#[test]
fn the_examples_in_the_help_are_understood() {
    let folder = Folder::new();
    // A console would be served until it is stopped: a file in the place of its folder is refused at once.
    folder.write("console", "");
    let mut ran = 0;
    for command in COMMANDS {
        let help = folder
            .run_as_given(&words(&format!("{command} --help")))
            .out();
        let Some((_, examples)) = help.split_once("Example:") else {
            // What only groups commands has no example of its own.
            assert!(help.contains("Commands:\n"), "{command} has no example");
            continue;
        };
        for line in examples
            .lines()
            .filter_map(|line| line.trim().strip_prefix("piezotact "))
        {
            let line = line.split(" > ").next().unwrap();
            let arguments = words(line);
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
            if let Some(anchor) = link.strip_prefix('#') {
                let slug = |heading: &str| {
                    heading
                        .trim_start_matches('#')
                        .trim()
                        .to_lowercase()
                        .replace(' ', "-")
                };
                assert!(
                    text.lines()
                        .any(|line| line.starts_with('#') && slug(line) == anchor),
                    "{document}: {link}"
                );
            } else {
                assert!(root().join(link).exists(), "{document} links to {link}");
            }
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

/// The files that the how-tos name exist, their commands run, and the tests that they name are modules of a test program.
#[test]
fn the_how_tos_are_true() {
    let folder = Folder::new();
    folder.write("texture.wav", wav(noise(10_000).map(|v| v * 0.01), 5_000));
    folder.write("rest.wav", wav(noise(60_000).map(|v| v * 0.001), 5_000));
    for sidecar in ["texture.wav.json", "rest.wav.json"] {
        folder.write(sidecar, r#"{"full_scale": "200 m/s2"}"#);
    }
    let place = root().join("docs/how-to");
    let programs: String = std::fs::read_dir(root().join("crates"))
        .unwrap()
        .filter_map(|krate| {
            std::fs::read_to_string(krate.unwrap().path().join("tests/all.rs")).ok()
        })
        .collect();
    let (mut pages, mut ran) = (0, 0);
    for page in std::fs::read_dir(&place).unwrap() {
        let page = page.unwrap().path();
        let text = std::fs::read_to_string(&page).unwrap();
        pages += 1;
        for link in text
            .split("](")
            .skip(1)
            .filter_map(|rest| rest.split(')').next())
        {
            assert!(
                place.join(link).exists(),
                "{} links to {link}",
                page.display()
            );
        }
        for path in text.split('`').skip(1).step_by(2) {
            if ["crates/", "docs/", "golden/"]
                .iter()
                .any(|start| path.starts_with(start))
            {
                assert!(
                    root().join(path).exists(),
                    "{} names {path}",
                    page.display()
                );
            }
        }
        for line in text.lines() {
            if let Some(command) = line.strip_prefix("$ piezotact ") {
                folder.run_as_given(&words(command)).expect_success();
                ran += 1;
            }
            if let Some(module) = line.strip_prefix("cargo test --workspace --test all ") {
                let module = module.trim_end_matches("::");
                let named = programs.contains(&format!("mod {module};"));
                assert!(named, "{} names the tests {module}", page.display());
            }
        }
    }
    assert!(pages >= 6 && ran >= 4, "{pages} pages, {ran} commands");
}
