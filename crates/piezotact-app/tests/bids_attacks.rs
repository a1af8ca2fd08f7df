//! Data sets that somebody changed, damaged or made to mislead, and data sets of other programs that are right.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::path::Path;

use crate::bids::{edit, exported, file, files, pack, problems, with_cell};
use crate::campaign_session::{holds, run};
use crate::support::{Folder, copy};

const ANSWERS: &[&str] = &["sub-P01", "task-task3", "beh.tsv"];
const ORDERS: &[&str] = &["sub-P01", "task-task1", "beh.tsv"];
const TRIALS: &[&str] = &["sub-P01", "task-task3", "acq-trials", "events.tsv"];
const STROKES: &[&str] = &["sub-P01", "acq-S2_run-1", "events.tsv"];
const SIDECAR: &[&str] = &["sub-P01/", "acq-S2_run-1", "physio.json"];

fn sidecar(root: &Path, key: &str, value: serde_json::Value) {
    let path = file(root, SIDECAR);
    let mut stated: serde_json::Value =
        serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
    stated[key] = value;
    std::fs::write(path, stated.to_string()).unwrap();
}

fn cell(root: &Path, parts: &[&str], (line, column): (usize, &str), value: &str) {
    edit(&file(root, parts), |text| {
        with_cell(text, line, column, |_| value.into())
    });
}

fn line_of(root: &Path, parts: &[&str], holding: &str) -> usize {
    let text = std::fs::read_to_string(file(root, parts)).unwrap();
    let mut lines = text.lines().skip(1);
    lines.position(|line| line.contains(holding)).unwrap() + 2
}

/// What was changed, the kind and the file of the problem, and the change. Each is found although the checksums are those of the
/// changed files.
type Change = (&'static str, &'static str, &'static str, fn(&Path));

const CHANGES: &[Change] = &[
    ("a heading renamed", "columns", "beh.tsv", |root| {
        edit(&file(root, ANSWERS), |text| {
            text.replacen("response\t", "Response\t", 1)
        });
    }),
    ("a heading with a space", "columns", "beh.tsv", |root| {
        edit(&file(root, ANSWERS), |text| {
            text.replacen("correct\t", "correct \t", 1)
        });
    }),
    ("commas for tabulators", "columns", "beh.tsv", |root| {
        edit(&file(root, ANSWERS), |text| text.replace('\t', ","));
    }),
    ("an answer twice", "twice", "beh.tsv", |root| {
        edit(&file(root, ANSWERS), |text| {
            format!("{text}{}\n", text.lines().nth(1).unwrap())
        });
    }),
    ("nothing offered", "response", "beh.tsv", |root| {
        cell(root, ANSWERS, (2, "offered"), "n/a");
    }),
    ("a position that is none", "number", "beh.tsv", |root| {
        cell(root, ANSWERS, (2, "position"), "99");
    }),
    ("the drive of another stimulus", "file", "beh.tsv", |root| {
        let other = ["S2", "S4"].map(|name| format!("sub-P01/ses-discrimination/{name}_drive.wav"));
        let text = std::fs::read_to_string(file(root, ANSWERS)).unwrap();
        let own = text.lines().nth(1).unwrap().contains(&other[0]);
        cell(root, ANSWERS, (2, "stim_file"), &other[usize::from(own)]);
    }),
    (
        "a flag that the playings deny",
        "level",
        "beh.tsv",
        |root| {
            cell(root, ANSWERS, (2, "flags"), "missed_target");
        },
    ),
    ("a rank without a sample", "ranking", "beh.tsv", |root| {
        edit(&file(root, ORDERS), |text| {
            let without = with_cell(text, 2, "response", |_| "n/a".into());
            with_cell(&without, 2, "correct", |_| "n/a".into())
        });
    }),
    (
        "a trial with another response",
        "response",
        "events.tsv",
        |root| {
            let line = line_of(root, TRIALS, "\ttrial\t");
            cell(root, TRIALS, (line, "response"), "S2|S2|S2|S2|S2");
        },
    ),
    (
        "an answer without its trial",
        "response",
        "events.tsv",
        |root| {
            let line = line_of(root, TRIALS, "\ttrial\t");
            cell(root, TRIALS, (line, "trial"), "another");
        },
    ),
    (
        "an event before the beginning",
        "onset",
        "events.tsv",
        |root| {
            cell(root, STROKES, (2, "onset"), "-5");
        },
    ),
    ("an event without an onset", "onset", "events.tsv", |root| {
        cell(root, STROKES, (2, "onset"), "n/a");
    }),
    ("an event of years", "duration", "events.tsv", |root| {
        let line = line_of(root, TRIALS, "\ttrial\t");
        cell(root, TRIALS, (line, "duration"), "1e300");
    }),
    ("spaces about a cell", "level", "beh.tsv", |root| {
        cell(root, ANSWERS, (2, "presented"), " S2 ");
    }),
    ("a rate of nothing", "metadata", "physio.tsv.gz", |root| {
        sidecar(root, "SamplingFrequency", 5e-324.into());
    }),
    (
        "a start in another year",
        "metadata",
        "physio.tsv.gz",
        |root| {
            sidecar(root, "StartTime", 1e308.into());
        },
    ),
    (
        "columns that are none",
        "metadata",
        "physio.tsv.gz",
        |root| {
            sidecar(root, "Columns", serde_json::json!(["a", null, ["b"], 4]));
        },
    ),
    ("a column twice", "twice", "physio.tsv.gz", |root| {
        sidecar(root, "Columns", serde_json::json!(["a", "a", "a", "a"]));
    }),
    (
        "a recording that is in no list",
        "file",
        "scans.tsv",
        |root| {
            edit(
                &file(root, &["sub-P01", "ses-measurement_scans.tsv"]),
                |text| {
                    let lines = text.lines().filter(|line| !line.contains("acq-S2"));
                    lines.map(|line| format!("{line}\n")).collect()
                },
            );
        },
    ),
    (
        "a folder of no kind of data",
        "name",
        "ses-measurement/foo",
        |root| {
            std::fs::create_dir(root.join("sub-P01/ses-measurement/foo")).unwrap();
            std::fs::write(root.join("sub-P01/ses-measurement/foo/a.txt"), "a").unwrap();
        },
    ),
    ("a participant without a file", "empty", "sub-P09", |root| {
        std::fs::create_dir(root.join("sub-P09")).unwrap();
    }),
    ("a list of names", "privacy", "key.tsv", |root| {
        std::fs::write(
            root.join("key.tsv"),
            "participant_id\tname\nsub-P01\tsomebody\n",
        )
        .unwrap();
    }),
    (
        "birth dates in a questionnaire",
        "privacy",
        "phenotype/form.tsv",
        |root| {
            std::fs::create_dir(root.join("phenotype")).unwrap();
            let text = "participant_id\tq1\nsub-P01\t1990-05-17\n";
            std::fs::write(root.join("phenotype/form.tsv"), text).unwrap();
        },
    ),
    (
        "samples of another recording",
        "changed",
        "physio.tsv.gz",
        |root| {
            let [one, other] = ["S2", "S4"].map(|sample| {
                file(
                    root,
                    &[
                        "sub-P01/ses-measurement",
                        &format!("acq-{sample}_run-1"),
                        "physio.tsv.gz",
                    ],
                )
            });
            std::fs::copy(other, one).unwrap();
        },
    ),
    ("another unit", "changed", "physio.tsv.gz", |root| {
        let path = file(root, SIDECAR);
        edit(&path, |text| text.replace("m/s^2", "g"));
    }),
    ("another rate", "changed", "physio.tsv.gz", |root| {
        sidecar(root, "SamplingFrequency", 4000.into());
    }),
    ("another right answer", "correct", "beh.tsv", |root| {
        let text = std::fs::read_to_string(file(root, ANSWERS)).unwrap();
        let name = if text.lines().nth(1).unwrap().contains("\tS8\t") {
            "S4"
        } else {
            "S8"
        };
        edit(&file(root, ANSWERS), |text| {
            with_cell(text, 2, "expected", |_| name.into())
        });
    }),
    ("another drive", "file", "events.tsv", |root| {
        let line = line_of(root, TRIALS, "\tstimulus\t");
        cell(root, TRIALS, (line, "drive_sha256"), &"0".repeat(64));
    }),
    ("a target that was missed", "level", "events.tsv", |root| {
        let line = line_of(root, TRIALS, "\tstimulus\t");
        edit(&file(root, TRIALS), |text| {
            let missed = with_cell(text, line, "reached", |_| "not met".into());
            let lines = missed.lines().map(|line| line.replace("\tyes", "\tno"));
            lines.map(|line| format!("{line}\n")).collect()
        });
    }),
    (
        "another duration of a trial",
        "response",
        "events.tsv",
        |root| {
            let line = line_of(root, TRIALS, "\ttrial\t");
            cell(root, TRIALS, (line, "duration"), "123");
        },
    ),
    ("another age", "participant", "sessions.tsv", |root| {
        cell(root, &["sub-P01_sessions.tsv"], (2, "age"), "60");
        cell(root, &["sub-P01_sessions.tsv"], (3, "age"), "60");
    }),
    (
        "participants exchanged",
        "changed",
        "participants.tsv",
        |root| {
            edit(&root.join("participants.tsv"), |text| {
                text.replace("\tP01\n", "\tPX\n")
                    .replace("\tP02\n", "\tP01\n")
                    .replace("\tPX\n", "\tP02\n")
            });
        },
    ),
    (
        "a table that was not exported",
        "changed",
        "run-2_events.tsv",
        |root| {
            let path = file(root, TRIALS);
            let name = path
                .file_name()
                .unwrap()
                .to_string_lossy()
                .replace("acq-trials", "acq-trials_run-2");
            std::fs::copy(&path, path.with_file_name(name)).unwrap();
        },
    ),
    ("no checksums", "empty", "SHA256SUMS", |root| {
        std::fs::write(root.join("sourcedata/SHA256SUMS"), "").unwrap();
    }),
];

/// Writes the checksums again, so that nothing is found by them alone.
fn renew(root: &Path) {
    let list = root.join("sourcedata/SHA256SUMS");
    let old = std::fs::read_to_string(&list).unwrap();
    let lines = old.lines().filter_map(|line| {
        let name = line.split_once("  ").unwrap().1;
        let bytes = std::fs::read(root.join("sourcedata").join(name)).ok()?;
        Some(format!(
            "{}  {name}\n",
            piezotact_dataset::reads::sha256(&bytes)
        ))
    });
    std::fs::write(&list, lines.collect::<String>()).unwrap();
}

#[test]
#[ignore = "many repetitions: ./x soak runs it"]
fn soak_a_change_is_found_also_under_new_checksums() {
    let folder = exported();
    for (i, (what, kind, part, change)) in CHANGES.iter().enumerate() {
        let name = format!("changed{i}");
        copy(&folder.path("bids"), &folder.path(&name));
        change(&folder.path(&name));
        // What only checksums tell is left as it is.
        let by_sums = ["participants.tsv", "run-2_events.tsv", "SHA256SUMS"];
        if !by_sums.contains(part) {
            renew(&folder.path(&name));
        }
        let (found, code) = problems(folder, &name);
        let is_it = found
            .iter()
            .any(|one| one["kind"] == *kind && one["file"].contains(part));
        assert!(is_it && code == Some(3), "{what}: {found:?}");
        std::fs::remove_dir_all(folder.path(&name)).unwrap();
    }
}

#[test]
fn data_that_were_changed_are_not_imported() {
    let folder = exported();
    let refused = |name: &str, change: &dyn Fn(&Path), parts: &[&str]| {
        copy(&folder.path("bids"), &folder.path(name));
        change(&folder.path(name));
        run(folder, &format!("bids import {name} --out {name}-out")).expect_failure(1, parts);
        assert!(!folder.path(&format!("{name}-out")).exists());
        std::fs::remove_dir_all(folder.path(name)).unwrap();
    };
    let cut = |root: &Path| {
        let text = |text: &str| {
            text.lines()
                .take(2)
                .map(|line| format!("{line}\n"))
                .collect()
        };
        edit(&file(root, ANSWERS), text);
    };
    refused("cut", &cut, &["task-task3_beh.tsv", "as it was exported"]);
    let far = |root: &Path| {
        let line = line_of(root, TRIALS, "\ttrial\t");
        cell(root, TRIALS, (line, "onset"), "1e300");
        renew(root);
    };
    refused("far", &far, &["expected a number in the column `onset`"]);
    // The folder that is read is not written.
    run(folder, "bids import bids --out bids/imported")
        .expect_failure(1, &["lies inside the data set"]);
    assert!(!folder.path("bids/imported").exists());
}

#[cfg(unix)]
#[test]
fn what_is_no_file_or_leads_out_is_named_and_hides_nothing() {
    let folder = exported();
    copy(&folder.path("bids"), &folder.path("odd"));
    let root = folder.path("odd");
    folder.write("secret.txt", "somebody's");
    let drive = root.join("stimuli/sub-P01/ses-discrimination/S8_drive.wav");
    std::fs::remove_file(&drive).unwrap();
    std::os::unix::fs::symlink(folder.path("secret.txt"), &drive).unwrap();
    let beh = root.join("sub-P01/ses-measurement/beh");
    let name = "sub-P01_ses-measurement_task-measure_acq-S2_run-9_events.tsv";
    std::os::unix::fs::symlink("nowhere", beh.join(name)).unwrap();
    let made = std::process::Command::new("mkfifo")
        .arg(beh.join(name.replace("run-9", "run-8")))
        .status();
    assert!(made.unwrap().success());
    std::fs::write(beh.join("a\n\u{1b}[31mb_events.tsv"), "onset\tduration\n").unwrap();
    let done = run(folder, "bids check odd --second-opinion none");
    assert_eq!(done.code(), Some(3), "{}", done.err());
    holds(
        &done.out(),
        &[
            "S8_drive.wav expected a file of the data set, found a link",
            "run-9_events.tsv",
            "device or a pipe",
            "a\\n\\u{1b}[31mb",
        ],
    );
    run(folder, "bids import odd --out odd-out").expect_failure(1, &["leads out of it"]);
    // Other tests use this folder at the same time.
    let names = folder.names();
    assert!(
        names.iter().all(|name| !name.starts_with("odd-out")),
        "{names:?}"
    );
}

/// A data set of another program, as BIDS allows it.
fn foreign() -> Folder {
    let folder = Folder::new();
    let write = |name: &str, text: &str| {
        let path = folder.path("set").join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    };
    write(
        "dataset_description.json",
        r#"{"Name": "pulse", "BIDSVersion": "1.10.0"}"#,
    );
    write(
        "physio.json",
        r#"{"SamplingFrequency": 10, "StartTime": 0, "Columns": ["cardiac", "force"], "force": {"Units": "N"}}"#,
    );
    write(
        "participants.tsv",
        "participant_id\tscanner_name\tbirth_weight\tphone_use_hours\nsub-01\tA\t3.1\t2\n\n",
    );
    write("code/tests/data/dataset_description.json", "{}");
    write(".bidsignore", "sub-*/extra/\n*_odd.tsv\n");
    write("sub-01/extra/notes.txt", "a");
    write("sub-01/beh/x_odd.tsv", "a,b\n");
    write(&format!("sourcedata/{}deep.txt", "a/".repeat(20)), "a");
    let beh = "sub-01/beh/sub-01_task-pulse";
    write(
        &format!("{beh}_events.tsv"),
        "onset\tduration\ttrial_type\n1\tn/a\ttap\n9\t1\ttap\n172800\t1\tsleep\n",
    );
    write(
        &format!("{beh}_beh.tsv"),
        "presented\tresponse\tcorrect\trank\tstimulus_name\nface\tleft\t1\t3\ta\nhouse\tright\t1\t3\ta\n",
    );
    write(
        "sub-01/beh/sub-01_task-count_beh.tsv",
        "expected\tresponse\tcorrect\tsoftware_version\n7\t7.0\t1\t1.2.2020\n",
    );
    pack(
        &folder.path(&format!("set/{beh}_physio.tsv.gz")),
        &"1\t2\n".repeat(50),
    );
    folder
}

#[test]
fn data_sets_of_other_programs_that_are_right_are_called_right() {
    let folder = foreign();
    let mut root = folder.path("set/sub-01/beh/sub-01_task-pulse_events.tsv");
    // Two days later is beyond what was recorded.
    let (found, code) = problems(&folder, "set");
    assert_eq!((found.len(), code), (1, Some(3)), "{found:?}");
    edit(&root, |text| {
        text.replace("172800\t1\tsleep\n", "60\t1\tsleep\n")
    });
    let (found, code) = problems(&folder, "set");
    assert!(found.is_empty() && code == Some(0), "{found:?}");
    // Two recordings whose names differ in how a number is written, or in their kind, are two.
    root.pop();
    for name in ["sub-01_task-pulse_run-01", "sub-01_task-pulse_run-1"] {
        pack(
            &root.join(format!("{name}_physio.tsv.gz")),
            &"1\t2\n".repeat(9),
        );
    }
    let other = folder.path("set/sub-01/func");
    std::fs::create_dir(&other).unwrap();
    pack(
        &other.join("sub-01_task-pulse_run-1_physio.tsv.gz"),
        &"1\t2\n".repeat(8),
    );
    run(&folder, "bids import set --out out").expect_success();
    let names: Vec<String> = files(&folder.path("out/recordings"))
        .iter()
        .map(|path| path.display().to_string())
        .collect();
    assert_eq!(
        names,
        [
            "sub-01_task-pulse.parquet",
            "sub-01_task-pulse_run-01.parquet",
            "sub-01_task-pulse_run-1.parquet",
            "sub-01_task-pulse_run-1_func.parquet",
        ]
    );
}

#[test]
fn a_label_that_somebody_typed_is_not_carried() {
    let folder = exported();
    run(
        folder,
        "twin record --bench acttouch --sample S4 --participant 1 --seed 7 --strokes 2 --stroke-time 1s --label zz-ward-seven --out labelled.parquet",
    )
    .expect_success();
    run(
        folder,
        "bids export study --recordings labelled.parquet --out labelled",
    )
    .expect_success();
    for path in files(&folder.path("labelled")) {
        let bytes = std::fs::read(folder.path("labelled").join(&path)).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        assert!(!text.contains("zz-ward"), "{}", path.display());
    }
}
