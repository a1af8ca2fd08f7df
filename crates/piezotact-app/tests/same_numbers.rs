//! The values that the program gives, held against tables that were stored before its code was redesigned.
//!
//! Chains of commands run in a folder each, over the twin and over measured files of `../shared/data`. What a command
//! prints as JSON, and every file that it writes, becomes rows of field path and value (`same_numbers/rows.rs`); the rows
//! are held against `golden/same_numbers/CHAIN.json` field by field. A stored field that is missing now fails, unless
//! `RENAMED` says where it went. New fields are free.
//!
//! The tables are written again, only where numbers are meant to change, by
//! `PIEZOTACT_WRITE_GOLDEN=1 cargo test --locked --workspace --test same_numbers`.
#![allow(
    clippy::print_stderr,
    clippy::unwrap_used,
    reason = "a test says what it skipped, and fails where it cannot go on"
)]

#[path = "same_numbers/chains.rs"]
mod chains;
#[path = "same_numbers/rows.rs"]
mod rows;
#[path = "same_numbers/schema.rs"]
mod schema;
mod support;

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use rows::{Checksums, Rows, differences, file_rows, json_rows};
use support::{Folder, shared};

/// Fields that have another path now: a run of segments in the stored path, and what stands there now. `CHANGELOG.md`
/// repeats this list.
const RENAMED: &[(&str, &str)] = &[
    ("printed.record", "printed.out"),
    ("printed.map", "printed.out"),
    ("printed.step_m", "printed.step_x_m"),
    ("printed.accepted", "printed.entries"),
    ("strokes", "cuts"),
    ("rms_log_slope", "rms_on_speed.slope"),
    ("rms_log_slope_interval", "rms_on_speed.slope_interval"),
    ("spatial_period_outcome", "period.outcome"),
    ("spatial_period_criteria", "period.criteria"),
    ("spatial_period_groups", "period.groups"),
    ("spatial_period_over.what", "period.over"),
    ("spatial_period_over.count", "period.units"),
    ("peaks", "period.peaks"),
];

#[test]
fn touch_on_the_twin_gives_the_stored_values() {
    check(&[("touch", chains::TOUCH)]);
}

#[test]
fn a_device_on_the_twin_gives_the_stored_values() {
    check(&[("device", chains::DEVICE)]);
}

#[test]
fn a_panel_on_the_twin_gives_the_stored_values() {
    check(&[("panel", chains::PANEL)]);
}

#[test]
fn the_demo_gives_the_stored_values() {
    check(&[("thesis", chains::THESIS)]);
}

#[test]
fn measured_files_give_the_stored_values() {
    check(&[("files", chains::FILES)]);
}

#[test]
fn answers_give_the_stored_values() {
    check(&[("answers", chains::ANSWERS)]);
}

#[test]
fn campaigns_and_their_data_set_give_the_stored_values() {
    check(&[("campaign", chains::CAMPAIGN), ("bids", chains::BIDS)]);
}

#[test]
fn eeg_of_the_twin_gives_the_stored_values() {
    check(&[("eeg", chains::EEG)]);
}

#[test]
fn prepared_drives_and_noise_give_the_stored_values() {
    check(&[("prepare", chains::PREPARE)]);
}

#[test]
fn a_sound_device_gives_the_stored_values() {
    check(&[("sound", chains::SOUND)]);
}

/// A comparison that finds nothing proves nothing: what it has to find, it finds.
#[test]
fn a_changed_value_a_lost_field_and_a_changed_sample_are_found() {
    let rows = |json: serde_json::Value| {
        let mut rows = Rows::new();
        json_rows(&mut rows, "printed", &json);
        rows
    };
    let stored = rows(serde_json::json!({
        "level_db": 1.25, "verdict": "passed", "psd": (0..40).map(f64::from).collect::<Vec<_>>(),
        "warnings": [{"text": "one"}], "steps": [{"gain_db": 2.0}],
    }));
    let found = |json: serde_json::Value, renamed: &[(&str, &str)]| -> Vec<String> {
        differences(&stored, &rows(json), renamed, Checksums::Compared)
    };
    let same = |level: f64, changed: f64| {
        let psd: Vec<f64> = (0..38).map(f64::from).chain([changed, 39.0]).collect();
        serde_json::json!({
            "level_db": level, "verdict": "passed", "psd": psd, "new": 3,
            "warnings": [{"text": "another sentence", "code": "x"}], "steps": [{"gain_db": 2.0}],
        })
    };
    assert_eq!(found(same(1.25 * (1.0 + 1e-11), 38.0), &[]), [""; 0]);
    assert_eq!(found(same(1.25 * (1.0 + 1e-8), 38.0), &[]).len(), 1);
    // One sample in forty that is not among those kept: the sum and the rms tell.
    assert_eq!(found(same(1.25, 38.001), &[]).len(), 2);

    let mut renamed = same(1.25, 38.0);
    let object = renamed.as_object_mut().unwrap();
    let steps = object.remove("steps").unwrap();
    object.insert("about".into(), serde_json::json!({ "steps": steps }));
    let lost = found(renamed.clone(), &[]);
    assert!(
        lost.len() == 2 && lost[1].contains("printed.steps[0].gain_db is missing"),
        "{lost:?}"
    );
    assert_eq!(found(renamed, &[("steps", "about.steps")]), [""; 0]);

    let mut other = same(1.25, 38.0);
    other["verdict"] = "not passed".into();
    other["warnings"] = serde_json::json!([]);
    assert_eq!(found(other, &[]).len(), 2);
}

/// A schema that everything fits proves nothing.
#[test]
fn a_lost_field_another_type_and_another_version_do_not_fit_the_schema() {
    let play = |change: fn(&mut serde_json::Value)| {
        let mut document = serde_json::json!({
            "schema": "play", "version": 2, "out": "r.parquet", "rate_hz": 5000.0,
            "duration_s": 1.5, "channels": [["acceleration", "m/s²"]], "condition": {},
            "provenance": { "source": "a bench", "steps": [] }, "warnings": [],
        });
        change(&mut document);
        schema::differences(&document)
    };
    assert_eq!(play(|_| ()), [""; 0]);
    assert_eq!(play(|d| d["version"] = 3.into()).len(), 1);
    assert_eq!(play(|d| d["out"] = 1.into()).len(), 1);
    assert!(play(|d| drop(d.as_object_mut().unwrap().remove("warnings")))[0].contains("warnings"));
    assert!(!play(|d| d["warnings"] = serde_json::json!([{ "code": "x" }])).is_empty());
    assert!(play(|d| d["schema"] = "plays".into())[0].contains("plays.json"));
}

#[test]
fn the_changelog_repeats_what_was_renamed() {
    let changelog = include_str!("../../../CHANGELOG.md");
    for (old, new) in RENAMED {
        let line = format!("`{old}` → `{new}`");
        assert!(changelog.contains(&line), "CHANGELOG.md lacks {line}");
    }
}

fn golden(chain: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("tests/golden/same_numbers/{chain}.json"))
}

/// Runs the commands of the chains one after the other in one folder, and holds what they give against the stored tables.
#[track_caller]
fn check(chains: &[(&str, &[&str])]) {
    let folder = Folder::new();
    chains::write_inputs(&folder);
    let mut wrong = Vec::new();
    for (chain, commands) in chains {
        let mut found: BTreeMap<String, Rows> = BTreeMap::new();
        for command in *commands {
            if let Some(rows) = rows_of(&folder, command) {
                found.insert((*command).to_owned(), rows);
            }
        }
        let file = golden(chain);
        if std::env::var_os("PIEZOTACT_WRITE_GOLDEN").is_some() {
            assert_eq!(found.len(), commands.len(), "a table needs every command");
            store(&file, found);
        } else {
            wrong.extend(against_stored(&file, &found));
        }
    }
    let shown: Vec<&str> = wrong.iter().take(40).map(String::as_str).collect();
    assert!(
        wrong.is_empty(),
        "{} values differ from the stored ones, the first of them:\n{}",
        wrong.len(),
        shown.join("\n")
    );
}

/// Writes a table.
fn store(file: &Path, mut found: BTreeMap<String, Rows>) {
    // How a document was made names a temporary folder and a version.
    for rows in found.values_mut() {
        rows.retain(|key, _| !key.contains(".invocation."));
    }
    std::fs::create_dir_all(file.parent().unwrap()).unwrap();
    std::fs::write(file, rows::table(&rows::machine(), &found)).unwrap();
}

/// What differs from a stored table.
fn against_stored(file: &Path, found: &BTreeMap<String, Rows>) -> Vec<String> {
    let stored: serde_json::Value = serde_json::from_slice(&std::fs::read(file).unwrap()).unwrap();
    let checksums = match stored["machine"] == rows::machine().as_str() {
        true => Checksums::Compared,
        false => {
            eprintln!(
                "checksums of samples are not compared: stored on {}, and this is {}",
                stored["machine"],
                rows::machine()
            );
            Checksums::LeftOut
        }
    };
    let mut wrong = Vec::new();
    for (command, rows) in found {
        let stored = rows::of_table(&stored["commands"][command]);
        assert!(
            !stored.is_empty(),
            "{} holds no `{command}`",
            file.display()
        );
        for difference in differences(&stored, rows, RENAMED, checksums) {
            wrong.push(format!("{command}\n    {difference}"));
        }
    }
    wrong
}

/// Commands that print no document: what they write is compared.
const WITHOUT_DOCUMENT: &[&str] = &[
    "campaign new",
    "campaign simulate",
    "campaign status",
    "campaign verify",
    "campaign export",
    "campaign withdraw",
    "bids import",
];

/// The rows of one command: its exit code, what it prints, and every file that it writes. None where a measured file is not
/// there.
#[track_caller]
fn rows_of(folder: &Folder, command: &str) -> Option<Rows> {
    let data = match command.contains("DATA/") {
        true => shared("data")?.to_string_lossy().into_owned(),
        false => String::new(),
    };
    let prints = !WITHOUT_DOCUMENT
        .iter()
        .any(|start| command.starts_with(start));
    let (command, kept) = match command.split_once(" > ") {
        Some((command, file)) => (command, Some(file)),
        None => (command, None),
    };
    let words: Vec<String> = command
        .split(' ')
        .map(|word| word.replace("DATA", &data))
        .chain(prints.then(|| "--json".into()))
        .collect();
    let before = contents(&folder.path(""));
    let words: Vec<&str> = words.iter().map(String::as_str).collect();
    let done = folder.run(&words);
    let mut rows = Rows::new();
    rows.insert("exit code".into(), done.code().into());
    if prints {
        let printed = serde_json::from_str(&done.out())
            .unwrap_or_else(|error| panic!("{command}: {error}: {}", done.err()));
        // A plan has no schema of its own.
        if !command.starts_with("campaign plan") {
            let unlike = schema::differences(&printed);
            assert!(unlike.is_empty(), "{command}: {unlike:#?}");
        }
        json_rows(&mut rows, "printed", &printed);
    }
    for (name, bytes) in contents(&folder.path("")) {
        if before.get(&name) != Some(&bytes) {
            file_rows(&mut rows, &folder.path(&name), &name, &bytes);
        }
    }
    if let Some(file) = kept {
        folder.write(file, done.out());
    }
    // What names the place of the measured files differs from checkout to checkout.
    for value in rows.values_mut() {
        if let Some(text) = value.as_str().filter(|_| !data.is_empty()) {
            *value = text.replace(&data, "DATA").into();
        }
    }
    Some(rows)
}

/// The files below a folder, by their names in it.
fn contents(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut files = BTreeMap::new();
    let mut folders = BTreeSet::from([folder.to_owned()]);
    while let Some(next) = folders.pop_first() {
        for entry in std::fs::read_dir(&next).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.insert(path);
            } else {
                let name = path
                    .strip_prefix(folder)
                    .unwrap()
                    .to_string_lossy()
                    .into_owned();
                files.insert(name, std::fs::read(&path).unwrap());
            }
        }
    }
    files
}
