//! Studies as BIDS data sets: what is carried and what is not, every break that is found, and what is refused.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]
#![allow(clippy::print_stderr, reason = "a test says what it left out")]

use std::collections::BTreeMap;
use std::io::{Read as _, Write as _};
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use flate2::Compression;
use flate2::read::GzDecoder;
use flate2::write::GzEncoder;

use crate::campaign_drives::{DISCRIMINATE, measured, prepared};
use crate::campaign_session::{holds, run, whole};
use crate::support::session::table;
use crate::support::{BENCH, Folder, copy};

/// A study of two people, one of whom felt textures on the twin and one on another system, and its data set.
pub(crate) fn exported() -> &'static Folder {
    static EXPORTED: OnceLock<Folder> = OnceLock::new();
    EXPORTED.get_or_init(|| {
        let folder = measured();
        whole(
            &folder,
            &format!("{DISCRIMINATE} {BENCH} --age 34 --sex femme"),
        );
        whole(
            &folder,
            "campaign run study P02 measurement --age 93 --handedness left",
        );
        whole(&folder, "campaign run study P02 discrimination --by-hand");
        whole(&folder, "campaign run study P03 measurement --rehearsal");
        for sample in ["S2", "S4", "S8", "S9"] {
            let name = format!("{sample}.parquet");
            std::fs::copy(prepared().path(&name), folder.path(&name)).unwrap();
        }
        std::fs::copy(prepared().path("tf.json"), folder.path("tf.json")).unwrap();
        let done = run(&folder, EXPORT);
        done.expect_success();
        holds(
            &done.out(),
            &[
                "2 participants in 4 sessions",
                "not carried",
                "true dates",
                "the age of 1 participant of more than 89 years",
                "1 rehearsal",
                "recordings of 4 trials of touching, for which none was given",
                "`piezotact bids check`",
                "wrote bids",
            ],
        );
        folder
    })
}

const EXPORT: &str = "bids export study --recordings S2.parquet S4.parquet S8.parquet S9.parquet --transfer tf.json --license CC0 --out bids";

/// The files of a folder, from its root, in order.
pub(crate) fn files(root: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![root.to_owned()];
    while let Some(folder) = open.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            match path.is_dir() {
                true => open.push(path),
                false => found.push(path.strip_prefix(root).unwrap().to_owned()),
            }
        }
    }
    found.sort();
    found
}

/// The only file whose name holds all `parts`, or the first of several.
pub(crate) fn file(root: &Path, parts: &[&str]) -> PathBuf {
    let all = files(root);
    let holds = |path: &&PathBuf| {
        let name = path.to_string_lossy();
        !name.starts_with("derivatives") && parts.iter().all(|part| name.contains(part))
    };
    let found = all.iter().find(holds);
    root.join(found.unwrap_or_else(|| panic!("no file with {parts:?}")))
}

pub(crate) fn edit(path: &Path, change: impl Fn(&str) -> String) {
    let text = std::fs::read_to_string(path).unwrap();
    let changed = change(&text);
    assert_ne!(text, changed, "{}", path.display());
    std::fs::write(path, changed).unwrap();
}

pub(crate) fn unpacked(path: &Path) -> String {
    let mut text = String::new();
    GzDecoder::new(std::fs::File::open(path).unwrap())
        .read_to_string(&mut text)
        .unwrap();
    text
}

pub(crate) fn pack(path: &Path, text: &str) {
    let mut encoder = GzEncoder::new(std::fs::File::create(path).unwrap(), Compression::fast());
    encoder.write_all(text.as_bytes()).unwrap();
    encoder.finish().unwrap();
}

/// Line `number` (from 1) with the cell of `column` changed.
pub(crate) fn with_cell(
    text: &str,
    number: usize,
    column: &str,
    change: impl Fn(&str) -> String,
) -> String {
    let lines = text.lines().enumerate();
    let at = text
        .lines()
        .next()
        .unwrap()
        .split('\t')
        .position(|name| name == column);
    let at = at.unwrap_or_else(|| panic!("no column {column} in {text}"));
    let lines = lines.map(|(i, line)| {
        let mut cells: Vec<String> = line.split('\t').map(str::to_owned).collect();
        if i + 1 == number {
            cells[at] = change(&cells[at]);
        }
        cells.join("\t") + "\n"
    });
    lines.collect()
}

/// What is wrong with the data set in `root`, by kind, file and line.
pub(crate) fn problems(
    folder: &Folder,
    root: &str,
) -> (Vec<BTreeMap<String, String>>, Option<i32>) {
    let line = format!("bids check {root} --json --second-opinion none");
    let done = run(folder, &line);
    assert!(!done.out().is_empty(), "{}", done.err());
    let (document, code) = done.json_and_code();
    let all = document["problems"].as_array().unwrap().iter().map(|one| {
        let text = |key: &str| match &one[key] {
            serde_json::Value::String(text) => text.clone(),
            other => other.to_string(),
        };
        ["kind", "file", "line", "text"]
            .map(|key| (key.to_owned(), text(key)))
            .into()
    });
    (all.collect(), code)
}

#[test]
fn a_study_is_exported_without_a_fault_and_without_who_somebody_is() {
    let folder = exported();
    let (found, code) = problems(folder, "bids");
    assert!(found.is_empty() && code == Some(0), "{found:?}");
    let root = folder.path("bids");
    let people = std::fs::read_to_string(root.join("participants.tsv")).unwrap();
    holds(
        &people,
        &[
            "sub-P01 homo sapiens 34 F n/a volunteer P01",
            "sub-P02 homo sapiens 89 n/a L volunteer P02",
        ],
    );
    assert!(!people.contains("P03"));
    // No true date, no age that is rare, no tag of an experimenter: nowhere in a text.
    let year = String::from_utf8(
        std::process::Command::new("date")
            .arg("+%Y-")
            .output()
            .unwrap()
            .stdout,
    )
    .unwrap();
    for path in files(&root) {
        let Ok(text) = std::fs::read_to_string(root.join(&path)) else {
            continue;
        };
        assert!(!text.contains(year.trim()), "{}", path.display());
        assert!(
            !text.contains("\t93\t") && !text.contains("experimenter\""),
            "{}",
            path.display()
        );
    }
    for path in files(&root)
        .iter()
        .filter(|path| path.extension().is_some_and(|end| end == "gz"))
    {
        let bytes = std::fs::read(root.join(path)).unwrap();
        assert_eq!(
            (bytes[3], &bytes[4..8]),
            (0, &[0_u8; 4][..]),
            "{}",
            path.display()
        );
    }
    // Recordings as they were made, bit by bit.
    let own = std::fs::read(folder.path("S2.parquet")).unwrap();
    let kept = file(&root, &["sourcedata", "acq-S2_run-1.parquet"]);
    assert_eq!(std::fs::read(kept).unwrap(), own);
    let drive =
        std::fs::read(folder.path("study/participants/P01/discrimination/drives/S8.wav")).unwrap();
    assert_eq!(
        std::fs::read(root.join("stimuli/sub-P01/ses-discrimination/S8_drive.wav")).unwrap(),
        drive
    );
    for (suffix, parts) in [
        ("psd", &["acq-S2", "desc-strokes"][..]),
        ("features", &["acq-S2"]),
        ("verification", &["acq-S8", "sub-P01"]),
        ("transfer", &["sub-P01"]),
        ("matrix", &["desc-association"]),
    ] {
        let ending = format!("_{suffix}.tsv");
        let of = files(&root.join("derivatives")).into_iter();
        let mut of = of.filter(|path| path.to_string_lossy().ends_with(&ending));
        let path = of.next().unwrap_or_else(|| panic!("no {suffix}"));
        let name = path.to_string_lossy();
        assert!(parts.iter().any(|part| name.contains(part)), "{name}");
        let sidecar = root.join("derivatives").join(path.with_extension("json"));
        let sidecar: serde_json::Value =
            serde_json::from_slice(&std::fs::read(sidecar).unwrap()).unwrap();
        assert!(sidecar["Provenance"].is_object(), "{sidecar}");
        if ["psd", "features"].contains(&suffix) {
            let filtered = sidecar["Provenance"]["settings"]["high_pass"].is_object();
            let said = sidecar["Description"].as_str().unwrap();
            assert_eq!(filtered, !said.contains("without a high-pass"), "{sidecar}");
        }
    }
    // A second export gives the same bytes.
    run(folder, &EXPORT.replace("--out bids", "--out again")).expect_success();
    for path in files(&root) {
        let [one, other] =
            ["bids", "again"].map(|root| std::fs::read(folder.path(root).join(&path)).unwrap());
        assert!(one == other, "{}", path.display());
    }
    // The same at the same place is done, and anything else is refused with what differs.
    run(folder, &EXPORT.replace("--out bids", "--out again")).expect_success();
    let fewer = EXPORT
        .replace("--out bids", "--out again")
        .replace(" S9.parquet", "");
    run(folder, &fewer).expect_failure(
        1,
        &["cannot write to again: found", "nothing is overwritten"],
    );
    std::fs::write(folder.path("again/notes.txt"), "mine").unwrap();
    run(folder, &EXPORT.replace("--out bids", "--out again"))
        .expect_failure(1, &["notes.txt beside them", "nothing is overwritten"]);
}

#[test]
fn what_is_imported_is_what_was_exported() {
    let folder = exported();
    run(folder, "bids import bids --out imported").expect_success();
    run(folder, "campaign export study --out tables").expect_success();
    let both = |name: &str| ["tables", "imported"].map(|from| table(&folder.path(from).join(name)));
    let counts = |rows: &Vec<BTreeMap<String, String>>| {
        rows.iter().filter(|row| row["rehearsal"] == "no").count()
    };
    for name in ["answers.csv", "orders.csv"] {
        let [own, read] = both(name);
        assert_eq!(own, read, "{name}");
        assert!(counts(&read) == read.len() && read.len() > 9, "{name}");
    }
    let [own, read] = both("trials.csv");
    let own: Vec<_> = own
        .into_iter()
        .filter(|row| row["rehearsal"] == "no")
        .collect();
    assert_eq!(own.len(), read.len());
    for (one, other) in own.iter().zip(&read) {
        for (column, value) in one.iter().filter(|(column, _)| !column.ends_with("_ms")) {
            assert_eq!(value, &other[column], "{column} of {}", one["trial"]);
        }
        // Dates are shifted, and what lies between is kept.
        let between = |row: &BTreeMap<String, String>| {
            let [from, to] =
                ["presented_ms", "confirmed_ms"].map(|name| row[name].parse::<i64>().unwrap());
            to - from
        };
        assert_eq!(between(one), between(other));
    }
    let [own, read] = both("evidence.csv");
    assert!(read.len() > 3);
    assert_eq!(own.len(), read.len());
    for (one, other) in own.iter().zip(&read) {
        for (column, value) in one.iter().filter(|(column, _)| *column != "journal") {
            assert_eq!(value, &other[column], "{column}");
        }
    }
    let [own, read] = both("participants.csv");
    let own: Vec<_> = own
        .into_iter()
        .filter(|row| row["rehearsal"] == "no")
        .collect();
    assert_eq!(own.len(), read.len());
    for (one, other) in own.iter().zip(&read) {
        for (column, value) in one {
            let expected = if value == "93" { "89" } else { value };
            assert_eq!(expected, other[column], "{column}");
        }
    }
    // Every sample of every channel, with its condition.
    let compared = [
        (
            "S2.parquet".to_owned(),
            "sub-P01_ses-measurement_task-measure_acq-S2_run-1.parquet",
        ),
        (
            "study/participants/P01/discrimination/runs/triplets.task3.A-1-1-1.parquet".to_owned(),
            "",
        ),
    ];
    for (own, imported) in compared {
        let imported = match imported {
            "" => {
                let rows = both("evidence.csv");
                let row = rows[1]
                    .iter()
                    .find(|row| row["trial"] == "triplets.task3.A" && row["element"] == "1")
                    .unwrap();
                let stem = row["journal"]
                    .rsplit('/')
                    .next()
                    .unwrap()
                    .split("_recording-")
                    .next()
                    .unwrap()
                    .to_owned();
                format!("{stem}.parquet")
            }
            name => name.to_owned(),
        };
        let info = |path: &str| run(folder, &format!("info {path} --json")).json();
        let (one, other) = (info(&own), info(&format!("imported/recordings/{imported}")));
        for key in ["channels", "condition", "warnings", "samples", "rate_hz"] {
            assert_eq!(one[key], other[key], "{key} of {own}");
        }
        let csv = |path: &str, name: &str| {
            let line = format!("spectrum {path} --channel {name} --json");
            crate::support::results(run(folder, &line).json())
        };
        for channel in one["channels"].as_array().unwrap() {
            let name = channel["name"].as_str().unwrap();
            assert_eq!(
                csv(&own, name)["psd"],
                csv(&format!("imported/recordings/{imported}"), name)["psd"]
            );
        }
    }
    // What is imported is read by other commands.
    run(folder, "answers imported/answers.csv --by task").expect_success();
    run(
        folder,
        "strokes imported/recordings/sub-P01_ses-measurement_task-measure_acq-S2_run-1.parquet",
    )
    .expect_success();
    // The same again is done; what a person changed since is not overwritten.
    run(folder, "bids import bids --out imported").expect_success();
    let answers = folder.path("imported/answers.csv");
    let changed = std::fs::read_to_string(&answers).unwrap() + "mine\n";
    std::fs::write(&answers, &changed).unwrap();
    let again = run(folder, "bids import bids --out imported");
    again.expect_failure(
        1,
        &[
            "imported",
            "cannot write to",
            "another answers.csv, which differs from line",
            "nothing is overwritten",
        ],
    );
    assert_eq!(std::fs::read_to_string(&answers).unwrap(), changed);
}

/// The 18 breaks of a data set that official validators find in part, each with what is found and in which file.
#[test]
fn every_break_is_found_with_its_file_and_line() {
    type Break = (&'static str, &'static str, &'static str, fn(&Path));
    const PHYSIO: &[&str] = &["sub-P01", "acq-S2_run-1", "physio.tsv.gz"];
    const SIDECAR: &[&str] = &["sub-P01", "acq-S2_run-1", "physio.json"];
    const EVENTS: &[&str] = &["sub-P01", "acq-S2_run-1", "events.tsv"];
    const ANSWERS: &[&str] = &["sub-P01", "task-task3", "beh.tsv"];
    const ORDERS: &[&str] = &["sub-P01", "task-task1", "beh.tsv"];
    fn sidecar(root: &Path, change: impl Fn(&mut serde_json::Value)) {
        let path = file(root, &["sub-P01/", "acq-S2_run-1", "physio.json"]);
        let mut value: serde_json::Value =
            serde_json::from_slice(&std::fs::read(&path).unwrap()).unwrap();
        change(&mut value);
        std::fs::write(path, value.to_string()).unwrap();
    }
    let breaks: [Break; 18] = [
        (
            "a column fewer than its sidecar says",
            "columns",
            "physio.tsv.gz",
            |root| {
                let path = file(root, PHYSIO);
                let text = unpacked(&path);
                let three = text
                    .lines()
                    .map(|line| line.rsplit_once('\t').unwrap().0.to_owned() + "\n");
                pack(&path, &three.collect::<String>());
            },
        ),
        ("no rate", "metadata", "physio.tsv.gz", |root| {
            sidecar(root, |value| {
                value.as_object_mut().unwrap().remove("SamplingFrequency");
            });
        }),
        ("no sidecar", "sidecar", "physio.tsv.gz", |root| {
            std::fs::remove_file(file(root, SIDECAR)).unwrap()
        }),
        ("cut gzip", "compression", "physio.tsv.gz", |root| {
            let path = file(root, PHYSIO);
            let bytes = std::fs::read(&path).unwrap();
            std::fs::write(path, &bytes[..bytes.len() / 2]).unwrap();
        }),
        ("negative duration", "duration", "events.tsv", |root| {
            edit(&file(root, EVENTS), |text| {
                with_cell(text, 2, "duration", |cell| format!("-{cell}"))
            });
        }),
        (
            "participant without a row",
            "participant",
            "participants.tsv",
            |root| {
                edit(&root.join("participants.tsv"), |text| {
                    text.lines()
                        .filter(|line| !line.starts_with("sub-P02"))
                        .map(|line| format!("{line}\n"))
                        .collect()
                });
            },
        ),
        ("participant twice", "twice", "participants.tsv", |root| {
            edit(&root.join("participants.tsv"), |text| {
                format!("{text}{}\n", text.lines().nth(1).unwrap())
            });
        }),
        ("no file of a stimulus", "file", "beh.tsv", |root| {
            std::fs::remove_file(root.join("stimuli/sub-P01/ses-discrimination/S8_drive.wav"))
                .unwrap();
        }),
        ("uneven line", "ragged", "beh.tsv", |root| {
            edit(&file(root, ANSWERS), |text| {
                text.replacen("\tcounted\t", "\t", 1)
            });
        }),
        ("bad name", "name", "run-1_acq-S2", |root| {
            let path = file(root, EVENTS);
            let name = path
                .file_name()
                .unwrap()
                .to_string_lossy()
                .replace("acq-S2_run-1", "run-1_acq-S2");
            std::fs::rename(&path, path.with_file_name(name)).unwrap();
        }),
        ("text in a cell of numbers", "number", "beh.tsv", |root| {
            edit(&file(root, ANSWERS), |text| {
                with_cell(text, 3, "response_time", |_| "soon".into())
            });
        }),
        ("heading in physio", "number", "physio.tsv.gz", |root| {
            let path = file(root, PHYSIO);
            pack(
                &path,
                &format!(
                    "acceleration\tforce_x\tforce_y\tforce_z\n{}",
                    unpacked(&path)
                ),
            );
        }),
        ("empty gz", "empty", "physio.tsv.gz", |root| {
            pack(&file(root, PHYSIO), "")
        }),
        ("onset after the end", "onset", "events.tsv", |root| {
            edit(&file(root, EVENTS), |text| {
                with_cell(text, 3, "onset", |_| "1000000".into())
            });
        }),
        (
            "names and birth dates",
            "privacy",
            "participants.tsv",
            |root| {
                edit(&root.join("participants.tsv"), |text| {
                    let lines = text.lines().enumerate().map(|(i, line)| match i {
                        0 => format!("{line}\tname\tbirth_date\n"),
                        _ => format!("{line}\tsomebody\t1990-05-17\n"),
                    });
                    lines.collect()
                });
            },
        ),
        (
            "answer that was not offered",
            "response",
            "beh.tsv",
            |root| {
                edit(&file(root, ANSWERS), |text| {
                    // The one sample of the protocol that is not in the set of the line.
                    let set = text
                        .lines()
                        .nth(1)
                        .unwrap()
                        .split('\t')
                        .nth(1)
                        .unwrap()
                        .to_owned();
                    let other = if set == "A" { "S9" } else { "S2" };
                    let changed = with_cell(text, 2, "response", |_| other.into());
                    with_cell(&changed, 2, "correct", |_| "0".into())
                });
            },
        ),
        ("right and wrong exchanged", "correct", "beh.tsv", |root| {
            edit(&file(root, ANSWERS), |text| {
                with_cell(text, 2, "correct", |cell| {
                    if cell == "1" { "0".into() } else { "1".into() }
                })
            });
        }),
        ("order that is none", "ranking", "beh.tsv", |root| {
            edit(&file(root, ORDERS), |text| {
                with_cell(text, 3, "rank", |_| "1".into())
            });
        }),
    ];
    let folder = exported();
    for (i, (what, kind, part, break_it)) in breaks.into_iter().enumerate() {
        let name = format!("broken{i}");
        copy(&folder.path("bids"), &folder.path(&name));
        break_it(&folder.path(&name));
        let (found, code) = problems(folder, &name);
        let is_it =
            |one: &&BTreeMap<String, String>| one["kind"] == kind && one["file"].contains(part);
        let problem = found
            .iter()
            .find(is_it)
            .unwrap_or_else(|| panic!("{what}: {found:?}"));
        assert_eq!(code, Some(3), "{what}");
        let text = &problem["text"];
        assert!(
            text.contains("expected") && text.contains("found") && text.contains(';'),
            "{what}: {text}"
        );
        // Lines are named where there is one.
        let by_line = [
            "duration", "twice", "ragged", "number", "onset", "privacy", "response", "correct",
            "ranking",
        ];
        assert!(
            !by_line.contains(&kind) || problem["line"] != "null",
            "{what}: {problem:?}"
        );
        std::fs::remove_dir_all(folder.path(&name)).unwrap();
    }
}

#[test]
fn what_is_no_data_set_of_touch_is_refused_by_name() {
    let folder = exported();
    let root = folder.path("bids");
    std::fs::create_dir(folder.path("photographs")).unwrap();
    folder.write("photographs/S2.png", "mine");
    run(folder, &EXPORT.replace("--out bids", "--out photographs")).expect_failure(
        1,
        &[
            "photographs",
            "found a folder with files and without",
            "nothing is overwritten",
        ],
    );
    folder.write("in the way", "text");
    run(folder, "bids import nowhere --out new").expect_failure(1, &["nowhere", "found nothing"]);
    // Half an export.
    copy(&root, &folder.path("half"));
    std::fs::remove_file(folder.path("half/dataset_description.json")).unwrap();
    for line in ["bids import half --out new", "bids check half"] {
        let done = run(folder, line);
        let said = done.out() + &done.err();
        holds(&said, &["a half-written one"]);
        assert_ne!(done.code(), Some(0));
    }
    copy(&root, &folder.path("copied in part"));
    std::fs::remove_dir_all(folder.path("copied in part").join("sub-P02")).unwrap();
    let done = folder.run_as_given(&[
        "bids",
        "check",
        "copied in part",
        "--second-opinion",
        "none",
    ]);
    holds(
        &done.out(),
        &["the data set is half copied", "expected the folder sub-P02"],
    );
    // Two studies in one folder, and one in another.
    {
        let (name, seed) = ("two", 8);
        copy(&root, &folder.path(name));
        run(
            folder,
            &format!("campaign new other --protocol protocol.toml --seed {seed}"),
        )
        .expect_success();
        whole(folder, "campaign run other P07 measurement");
        run(folder, "bids export other --out others").expect_success();
        copy(&folder.path("others"), &folder.path("side"));
        for path in files(&folder.path("side")) {
            let there = folder.path(name).join(&path);
            if !there.exists() {
                std::fs::create_dir_all(there.parent().unwrap()).unwrap();
                std::fs::copy(folder.path("side").join(&path), there).unwrap();
            }
        }
        let done = run(folder, "bids check two --second-opinion none");
        holds(&done.out(), &["expected a line for the folder sub-P07"]);
        assert_eq!(done.code(), Some(3));
    }
    std::fs::create_dir_all(folder.path("both")).unwrap();
    copy(&root, &folder.path("both/one"));
    copy(&root, &folder.path("both/other"));
    run(folder, "bids import both --out new").expect_failure(
        1,
        &["2 in it: one, other", "give the folder of one of them"],
    );
    // A study of another kind.
    std::fs::create_dir_all(folder.path("brains/sub-01/meg")).unwrap();
    folder.write(
        "brains/dataset_description.json",
        r#"{"Name": "b", "BIDSVersion": "1.10.0"}"#,
    );
    folder.write("brains/sub-01/meg/sub-01_task-rest_meg.fif", "0");
    run(folder, "bids import brains --out new")
        .expect_failure(1, &["has no touch data", "data in meg"]);
    let done = run(folder, "bids check brains --second-opinion none");
    assert_eq!(done.code(), Some(5), "{}", done.out());
    holds(&done.out(), &["Nothing could be checked", "1 of meg"]);
    assert!(!folder.path("new").exists());
    // Other tests export into this folder at the same time.
    let own = ["new", "photographs", "others"];
    let left = folder.names().into_iter().filter(|name| {
        own.iter().any(|own| name.contains(own))
            && (name.contains("unfinished") || name.ends_with(".lock"))
    });
    assert_eq!(left.count(), 0);
}
