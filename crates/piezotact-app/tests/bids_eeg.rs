//! EEG in a data set: written with a study, read back, and its four breaks found.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::OnceLock;

use piezotact_dataset::eeg::read_eeg;

use crate::bids::{edit, exported, file, files, problems};
use crate::campaign_session::{holds, run};
use crate::support::{Folder, copy};

const EXPORT: &str = "bids export study --recordings S2.parquet --eeg P01_task3.vhdr P02_measure.edf --eeg-reference average --line 50Hz --out with-eeg";

/// The study with EEG of two tasks, as BrainVision and EDF+ files.
fn with_eeg() -> &'static Folder {
    static WITH: OnceLock<()> = OnceLock::new();
    let folder = exported();
    WITH.get_or_init(|| {
        for (person, task, out) in [
            (1, "control", "P01_task3.vhdr"),
            (2, "natural", "P02_measure.edf"),
        ] {
            let line = format!(
                "twin record --bench eeg --task {task} --participant {person} --seed 7 --trials 2 --out {out}"
            );
            run(folder, &line).expect_success();
        }
        let done = run(folder, EXPORT);
        done.expect_success();
    });
    folder
}

#[test]
fn eeg_stands_beside_touch_and_is_read_back() {
    let folder = with_eeg();
    let (found, code) = problems(folder, "with-eeg");
    assert!(found.is_empty() && code == Some(0), "{found:?}");
    run(folder, "bids import with-eeg --out eeg-out").expect_success();
    let imported = file(
        &folder.path("eeg-out"),
        &["eeg/", "task-task3_run-1_eeg.vhdr"],
    );
    let [own, read] =
        [folder.path("P01_task3.vhdr"), imported.clone()].map(|path| read_eeg(&path).unwrap());
    let [own, read] = [&own.segments[0], &read.segments[0]];
    assert_eq!(own.recording.channels(), read.recording.channels());
    // But for the start of the segment, which is the start of the file.
    let own_samples: Vec<i64> = (own.recording.annotations.events.iter())
        .zip(&own.event_samples)
        .filter(|(event, _)| event.kind != "New Segment")
        .map(|(_, sample)| *sample)
        .collect();
    let read_events = (read.recording.annotations.events.iter()).zip(&read.event_samples);
    let read_samples: Vec<i64> = read_events
        .filter(|(event, _)| event.kind != "New Segment")
        .map(|(_, sample)| *sample)
        .collect();
    assert_eq!(own_samples, read_samples);
    assert!(own.event_samples.len() > 5 && own.recording.channels().len() > 64);
    // Exact onsets stand in the table of events.
    let events = std::fs::read_to_string(
        imported
            .to_str()
            .unwrap()
            .replace("_eeg.vhdr", "_events.tsv"),
    )
    .unwrap();
    assert_eq!(events.lines().count(), own_samples.len() + 1);
    assert!(events.contains("\trest\t"));
    for name in files(&folder.path("with-eeg")) {
        assert!(!name.to_string_lossy().contains("P02_measure"), "{name:?}");
    }
}

#[test]
fn eeg_of_nobody_and_of_no_task_is_refused() {
    let folder = with_eeg();
    let refused = |from: &str, to: &str, parts: &[&str]| {
        std::fs::copy(folder.path(from), folder.path(to)).unwrap();
        let line = format!("bids export study --eeg {to} --out refused-eeg");
        run(folder, &line).expect_failure(2, parts);
        assert!(!folder.path("refused-eeg").exists());
    };
    refused(
        "P02_measure.edf",
        "P07_measure.edf",
        &["P07", "leave it out"],
    );
    refused(
        "P02_measure.edf",
        "P02_dreaming.edf",
        &["task dreaming", "measure"],
    );
    refused("P02_measure.edf", "noname.edf", &["expected a name like"]);
    // As a recording of touch it is none.
    run(folder, "bids export study --recordings P02_measure.edf --meta {participant}_{sample} --out refused-eeg")
        .expect_failure(2, &["expected a recording of touch"]);
}

/// The four breaks of EEG that official validators do not find.
#[test]
fn every_break_of_eeg_is_found() {
    type Break = (&'static str, &'static str, &'static str, fn(&Path));
    const BRAIN: &[&str] = &["sub-P01", "eeg/", "task-task3"];
    fn of(root: &Path, ending: &str) -> std::path::PathBuf {
        let mut parts = BRAIN.to_vec();
        parts.push(ending);
        file(root, &parts)
    }
    let breaks: [Break; 17] = [
        ("samples cut in half", "samples", "_eeg.vhdr", |root| {
            let path = of(root, "_eeg.eeg");
            let bytes = std::fs::read(&path).unwrap();
            std::fs::write(path, &bytes[..bytes.len() / 2]).unwrap();
        }),
        ("no samples", "samples", "_eeg.vhdr", |root| {
            std::fs::remove_file(of(root, "_eeg.eeg")).unwrap();
        }),
        (
            "a channel without a line",
            "columns",
            "_channels.tsv",
            |root| {
                edit(&of(root, "_channels.tsv"), |text| {
                    let lines = text.lines().filter(|line| !line.starts_with("C3\t"));
                    lines.map(|line| format!("{line}\n")).collect()
                });
            },
        ),
        (
            "another rate in the JSON file",
            "metadata",
            "_eeg.vhdr",
            |root| {
                edit(&of(root, "_eeg.json"), |text| {
                    text.replace("\"SamplingFrequency\": 512", "\"SamplingFrequency\": 500")
                });
            },
        ),
        ("a renamed channel", "columns", "_channels.tsv", |root| {
            edit(&of(root, "_channels.tsv"), |text| {
                text.replace("\nC3\t", "\nC33\t")
            });
        }),
        ("no reference stated", "metadata", "_eeg.vhdr", |root| {
            edit(&of(root, "_eeg.json"), |text| {
                text.replace("\"EEGReference\"", "\"Reference\"")
            });
        }),
        ("an unknown type", "level", "_channels.tsv", |root| {
            edit(&of(root, "_channels.tsv"), |text| {
                text.replace("\nC3\tEEG", "\nC3\tEeg")
            });
        }),
        ("a channel twice", "twice", "_channels.tsv", |root| {
            edit(&of(root, "_channels.tsv"), |text| {
                let twice = text.lines().find(|line| line.starts_with("C3\t"));
                format!("{text}{}\n", twice.unwrap())
            });
        }),
        ("a marker without a line", "onset", "_events.tsv", |root| {
            edit(&of(root, "_events.tsv"), |text| {
                let kept = text.lines().enumerate().filter(|(i, _)| *i != 2);
                kept.map(|(_, line)| format!("{line}\n")).collect()
            });
        }),
        ("an event off its marker", "onset", "_events.tsv", |root| {
            edit(&of(root, "_events.tsv"), |text| {
                crate::bids::with_cell(text, 3, "onset", |onset| {
                    (onset.parse::<f64>().unwrap() + 0.05).to_string()
                })
            });
        }),
        (
            "positions without axes",
            "sidecar",
            "_electrodes.tsv",
            |root| {
                std::fs::remove_file(file(root, &["sub-P01", "eeg/", "_coordsystem.json"]))
                    .unwrap();
            },
        ),
        ("another unit", "metadata", "_channels.tsv", |root| {
            edit(&of(root, "_channels.tsv"), |text| {
                crate::bids::with_cell(text, 3, "units", |_| "kV".into())
            });
        }),
        (
            "another number of channels",
            "metadata",
            "_eeg.vhdr",
            |root| {
                edit(&of(root, "_eeg.json"), |text| {
                    text.replace("\"EEGChannelCount\": ", "\"EEGChannelCount\": 1")
                });
            },
        ),
        ("a line of no channel", "columns", "_channels.tsv", |root| {
            edit(&of(root, "_channels.tsv"), |text| {
                let other = text.lines().find(|line| line.starts_with("C3\t")).unwrap();
                let other = other.replacen("C3\tEEG", "AUX\tAUDIO", 1);
                format!("{text}{other}\n")
            });
        }),
        ("durations first", "columns", "_events.tsv", |root| {
            edit(&of(root, "_events.tsv"), |text| {
                let turned = text.lines().map(|line| {
                    let cells: Vec<&str> = line.splitn(3, '\t').collect();
                    format!("{}\t{}\t{}\n", cells[1], cells[0], cells[2])
                });
                turned.collect()
            });
        }),
        ("events of no recording", "file", "task-other", |root| {
            let path = of(root, "_events.tsv");
            let other = path.to_str().unwrap().replace("task-task3", "task-other");
            std::fs::copy(path, other).unwrap();
        }),
        ("an event after the end", "onset", "_events.tsv", |root| {
            edit(&of(root, "_events.tsv"), |text| {
                crate::bids::with_cell(text, 3, "onset", |_| "100000".into())
            });
        }),
    ];
    let folder = with_eeg();
    for (i, (what, kind, part, break_it)) in breaks.into_iter().enumerate() {
        let name = format!("brain{i}");
        copy(&folder.path("with-eeg"), &folder.path(&name));
        break_it(&folder.path(&name));
        let (found, code) = problems(folder, &name);
        let is_it =
            |one: &&BTreeMap<String, String>| one["kind"] == kind && one["file"].contains(part);
        let problem = found.iter().find(is_it);
        let problem = problem.unwrap_or_else(|| panic!("{what}: {found:?}"));
        holds(&problem["text"], &["expected", "found"]);
        assert_eq!(code, Some(3), "{what}");
        std::fs::remove_dir_all(folder.path(&name)).unwrap();
    }
}
