//! Recordings of a laboratory without a campaign as a BIDS data set: without sessions, without dates, and read back as they were.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use crate::bids::{file, files, problems, unpacked};
use crate::campaign_session::{holds, run};
use crate::known_cuts::{Kind, Random, recorded, table};
use crate::support::Folder;

/// Three recordings of two people: two of another program with a date, of a person, and one of the twin; a transfer function.
fn laboratory() -> Folder {
    let folder = Folder::new();
    let kinds = [Kind::Plain, Kind::TouchOnly, Kind::Plain];
    for (seed, name) in [(3, "Anna_S4.csv"), (4, "Anna_S8.csv")] {
        folder.write(name, table(&recorded(&mut Random::new(seed), &kinds)));
        folder.write(
            &format!("{name}.json"),
            r#"{"started_at": "2024-03-05T10:22:33.250", "events": [{"onset_s": 0.5, "duration_s": 0, "kind": "answer", "value": "rough"}, {"onset_s": 0.6, "duration_s": 0, "kind": "Dupont 12.03.1988 starts"}, {"onset_s": 0.7, "duration_s": 0, "kind": "Marie Dupont"}]}"#,
        );
    }
    folder.write(
        "Anna_S4.csv.json",
        r#"{"started_at": "2024-03-04T22:00:00+01:00"}"#,
    );
    run(
        &folder,
        "twin record --bench acttouch --sample S2 --participant 2 --seed 7 --strokes 3 --stroke-time 1s --out P02_S2.parquet",
    )
    .expect_success();
    run(
        &folder,
        "characterise --bench twin:participant=2,seed=7 --seconds 4 --out tf.json",
    )
    .expect_success();
    folder
}

const EXPORT: &str = "bids export --recordings Anna_S4.csv Anna_S8.csv P02_S2.parquet --meta {participant}_{sample} --transfer tf.json --out bids";

#[test]
fn recordings_without_a_campaign_are_a_data_set_without_sessions() {
    let folder = laboratory();
    let done = run(&folder, EXPORT);
    done.expect_success();
    holds(
        &done.out(),
        &[
            "2 participants in 3 recordings",
            "true dates",
            "look whether one tells who somebody is: Anna (participant)",
        ],
    );
    assert!(!done.out().contains("session of"), "{}", done.out());
    let (found, code) = problems(&folder, "bids");
    assert!(found.is_empty() && code == Some(0), "{found:?}");
    let root = folder.path("bids");
    for path in files(&root) {
        let name = path.to_string_lossy().into_owned();
        assert!(
            !name.contains("ses-") && !name.contains("sessions") && !name.contains("protocol"),
            "{name}"
        );
        if let Ok(text) = std::fs::read_to_string(root.join(&path)) {
            assert!(
                !text.contains("2024-03") && !text.contains("Dupont"),
                "{name}"
            );
        }
    }
    // Dates of a person are shifted together; those of another stay none.
    let scans = std::fs::read_to_string(root.join("sub-Anna/sub-Anna_scans.tsv")).unwrap();
    holds(
        &scans,
        &[
            "acq-S4_run-1_recording-fiv_physio.tsv.gz 1900-01-01T21:00:00Z",
            "acq-S8_run-1_recording-fiv_physio.tsv.gz 1900-01-02T10:22:33.25",
        ],
    );
    // UTC is marked, and a clock in an unknown time zone is not taken for UTC.
    assert_eq!(scans.matches('Z').count(), 1, "{scans}");
    let scans = std::fs::read_to_string(root.join("sub-P02/sub-P02_scans.tsv")).unwrap();
    holds(&scans, &["physio.tsv.gz n/a"]);
    let people = std::fs::read_to_string(root.join("participants.tsv")).unwrap();
    holds(
        &people,
        &[
            "sub-Anna homo sapiens n/a n/a n/a volunteer Anna",
            "sub-P02 n/a n/a n/a n/a virtual P02",
        ],
    );
    let readme = std::fs::read_to_string(root.join("README.md")).unwrap();
    holds(
        &readme,
        &[
            "3 recordings of 2 participants, without sessions",
            "1 of 3 recordings are simulated",
        ],
    );
    for suffix in ["psd", "features", "transfer"] {
        let of = files(&root.join("derivatives")).into_iter();
        let ending = format!("_{suffix}.tsv");
        let count = of
            .filter(|path| path.to_string_lossy().ends_with(&ending))
            .count();
        assert_eq!(count, if suffix == "transfer" { 1 } else { 3 }, "{suffix}");
    }
    // The event of the recording stands beside its strokes; the word that somebody typed does not.
    let events = file(&root, &["acq-S8_run-1", "events.tsv"]);
    let events = std::fs::read_to_string(events).unwrap();
    assert!(events.contains("\tstroke\t"), "{events}");
    assert_eq!(events.matches("\tanswer\t").count(), 1, "{events}");
    assert_eq!(events.matches("\tevent\t").count(), 2, "{events}");
    assert!(!events.contains("rough"), "{events}");
}

#[test]
fn what_a_laboratory_exported_is_imported_as_it_was() {
    let folder = laboratory();
    run(&folder, EXPORT).expect_success();
    run(&folder, "bids import bids --out imported").expect_success();
    let pairs = [
        ("Anna_S4.csv", "sub-Anna_task-touch_acq-S4_run-1"),
        ("Anna_S8.csv", "sub-Anna_task-touch_acq-S8_run-1"),
        ("P02_S2.parquet", "sub-P02_task-touch_acq-S2_run-1"),
    ];
    for (own, name) in pairs {
        let imported = format!("imported/recordings/{name}.parquet");
        let info = |path: &str| run(&folder, &format!("info {path} --json")).json();
        let (one, other) = (info(own), info(&imported));
        for key in ["channels", "samples", "rate_hz"] {
            assert_eq!(one[key], other[key], "{key} of {own}");
        }
        assert_eq!(
            other["condition"]["participant"],
            own.split('_').next().unwrap()
        );
        for channel in one["channels"].as_array().unwrap() {
            let name = channel["name"].as_str().unwrap();
            let psd = |path: &str| {
                let line = format!("spectrum {path} --channel {name} --json");
                crate::support::results(run(&folder, &line).json())["psd"].clone()
            };
            assert_eq!(psd(own), psd(&imported), "{name} of {own}");
        }
        run(&folder, &format!("strokes {imported}")).expect_success();
    }
    // Sample by sample, as the table has them.
    let rows = unpacked(&file(
        &folder.path("bids"),
        &["acq-S4_run-1", "physio.tsv.gz"],
    ));
    let own = std::fs::read_to_string(folder.path("Anna_S4.csv")).unwrap();
    assert_eq!(rows.lines().count(), own.lines().count() - 1);
}

#[test]
fn who_was_recorded_is_stated_and_never_guessed() {
    let folder = laboratory();
    let export = "bids export --recordings Anna_S4.csv --out other";
    run(&folder, export).expect_failure(
        1,
        &[
            "Anna_S4.csv",
            "names its participant, found none",
            "--participant",
        ],
    );
    assert!(!folder.path("other").exists());
    // The name of the option counts where the recording has none, and nowhere else.
    let stated = export.replace("Anna_S4.csv", "Anna_S4.csv P02_S2.parquet");
    let done = run(&folder, &format!("{stated} --participant P01 --task slide"));
    done.expect_success();
    holds(&done.out(), &["2 participants in 2 recordings"]);
    let (found, code) = problems(&folder, "other");
    assert!(found.is_empty() && code == Some(0), "{found:?}");
    let root = folder.path("other");
    assert!(file(&root, &["sub-P01_task-slide_run-1", "physio.json"]).is_file());
    assert!(file(&root, &["sub-P02_task-slide_acq-S2_run-1", "physio.json"]).is_file());
    let refused = [
        ("bids export --out none", 2, &["STUDY"][..]),
        (
            "bids export --recordings Anna_S4.csv Anna_S4.csv --participant P01 --out none",
            2,
            &["expected recordings that differ"],
        ),
        (
            "bids export --recordings Anna_S4.csv --participant P01 --transfer tf.json --out none",
            2,
            &["participant of the data set (P01), found one of P02"],
        ),
        (
            "bids export --recordings Anna_S4.csv --participant P01 --eeg a.vhdr --out none",
            2,
            &["expected a study for --eeg", "mne-bids"],
        ),
        ("bids export Anna_S4.csv --out none", 1, &["Anna_S4.csv"]),
    ];
    for (line, code, parts) in refused {
        run(&folder, line).expect_failure(code, parts);
        assert!(!folder.path("none").exists(), "{line}");
    }
}

/// Reading warns of events before the first sample and after the last; a table with them would not pass `bids check`.
#[test]
fn events_outside_the_recording_are_left_out_and_counted() {
    let folder = Folder::new();
    folder.write(
        "P01_S4.csv",
        table(&recorded(&mut Random::new(3), &[Kind::Plain])),
    );
    let event = |onset_s: f64, kind: &str| {
        format!(r#"{{"onset_s": {onset_s}, "duration_s": 0, "kind": "{kind}"}}"#)
    };
    let events = [
        event(-2.0, "too_early"),
        event(0.5, "within"),
        event(9000.0, "too_late"),
    ];
    folder.write(
        "P01_S4.csv.json",
        format!(r#"{{"events": [{}]}}"#, events.join(", ")),
    );
    let done = run(
        &folder,
        "bids export --recordings P01_S4.csv --meta {participant}_{sample} --out bids",
    );
    done.expect_success();
    let said = done.out() + &done.err();
    holds(&said, &["2 event(s) are outside the recording"]);
    let events = file(&folder.path("bids"), &["acq-S4_run-1", "events.tsv"]);
    let events = std::fs::read_to_string(events).unwrap();
    assert!(events.contains("\twithin\t"), "{events}");
    assert!(!events.contains("too_"), "{events}");
    let (found, code) = problems(&folder, "bids");
    assert!(found.is_empty() && code == Some(0), "{found:?}");
}

/// The second of three recordings of a sample has no strokes, and so nothing is derived of it.
#[test]
fn derived_values_have_the_run_of_their_recording() {
    let folder = Folder::new();
    let kinds = [
        ("P01_S4_1.csv", Kind::Plain),
        ("P01_S4_2.csv", Kind::TouchOnly),
        ("P01_S4_3.csv", Kind::Plain),
    ];
    for (seed, (name, kind)) in (3..).zip(kinds) {
        folder.write(name, table(&recorded(&mut Random::new(seed), &[kind])));
    }
    run(
        &folder,
        "bids export --recordings P01_S4_1.csv P01_S4_2.csv P01_S4_3.csv --meta {participant}_{sample}_{repeat} --out bids",
    )
    .expect_success();
    let derived = folder.path("bids/derivatives/piezotact/sub-P01/beh");
    for suffix in ["psd", "features"] {
        let name = |run: u32| format!("sub-P01_task-touch_acq-S4_run-{run}_desc-strokes_{suffix}");
        let all = files(&derived).into_iter();
        let all = all.map(|path| path.to_string_lossy().into_owned());
        let ending = format!("_{suffix}.tsv");
        let found: Vec<String> = all.filter(|file| file.ends_with(&ending)).collect();
        let expected = [1, 3].map(|run| name(run) + ".tsv");
        assert_eq!(found, expected);
        for run in [1, 3] {
            let sidecar = derived.join(name(run) + ".json");
            let sidecar = std::fs::read_to_string(sidecar).unwrap();
            let source = format!("acq-S4_run-{run}_recording-fiv_physio.tsv.gz");
            assert!(sidecar.contains(&source), "{sidecar}");
        }
    }
}

/// What the program says of a recording of another program names its channels; a data set does not repeat such names.
#[test]
fn words_of_a_file_are_not_carried_by_its_warnings() {
    let folder = Folder::new();
    let made = table(&recorded(&mut Random::new(3), &[Kind::Plain]));
    let (header, rows) = made.split_once('\n').unwrap();
    // Two vibrations and a force: the choice among them is a warning that names them.
    let mut text = header.to_owned() + ",acc nail 2024-03-05 (m/s2)\n";
    for (at, row) in rows.lines().enumerate() {
        let more = if at % 2 == 0 { 0.25 } else { -0.25 };
        text.push_str(&format!("{row},{more}\n"));
    }
    folder.write("P01_S4.csv", text);
    let done = run(
        &folder,
        "bids export --recordings P01_S4.csv --meta {participant}_{sample} --out bids",
    );
    done.expect_success();
    let root = folder.path("bids");
    let mut codes = 0;
    for path in files(&root) {
        if let Ok(text) = std::fs::read_to_string(root.join(&path)) {
            assert!(!text.contains("2024-03"), "{}: {text}", path.display());
            codes += text.matches("see docs/guide/warnings.md").count();
        }
    }
    assert!(codes > 0, "{}", done.out());
    // What was measured stays in the name of the channel.
    let sidecar = file(&root, &["acq-S4_run-1", "physio.json"]);
    let sidecar = std::fs::read_to_string(sidecar).unwrap();
    assert!(sidecar.contains("acc nail"), "{sidecar}");
}

/// Names that a laboratory gave its files, channels, device and events: of transfer functions they are left out, of recordings they are said.
#[test]
fn names_of_a_laboratory_are_left_out_or_said() {
    let folder = Folder::new();
    let made = table(&recorded(&mut Random::new(3), &[Kind::Plain]));
    folder.write("P01_S4.csv", made.replacen("nail", "nail_martin", 1));
    let events = ["dupont", "BAD_blink", "Mme Dupont"].map(|kind| {
        format!(r#"{{"onset_s": 0.5, "duration_s": 0, "kind": "{kind}", "value": "M8/S  2"}}"#)
    });
    folder.write(
        "P01_S4.csv.json",
        format!(r#"{{"events": [{}]}}"#, events.join(", ")),
    );
    let mut random = Random::new(4);
    let mut bench = "time (s),drive_Marie (FS),nail_Dupont (m/s2)\n".to_owned();
    let mut before = 0.0;
    for i in 0..20_000 {
        let drive = 0.2 * random.normal();
        let nail = 3.0 * drive + 2.0 * before + 0.01 * random.normal();
        before = drive;
        let time_s = f64::from(i) / 4000.0;
        bench.push_str(&format!("{time_s:.5},{drive:.6},{nail:.6}\n"));
    }
    folder.write("dupont_bench.csv", bench);
    run(
        &folder,
        "transfer dupont_bench.csv --drive drive_Marie --response nail_Dupont --out tf.json",
    )
    .expect_success();
    let done = run(
        &folder,
        "bids export --recordings P01_S4.csv --meta {participant}_{sample} --transfer tf.json --participant P01 --out bids",
    );
    done.expect_success();
    let said = "so look whether one tells who somebody is";
    holds(
        &done.out(),
        &[said, "dupont (event)", "nail_martin (channel)"],
    );
    let root = folder.path("bids");
    for path in files(&root) {
        if let Ok(text) = std::fs::read_to_string(root.join(&path)) {
            for name in ["Marie", "Dupont", "dupont_bench"] {
                assert!(!text.contains(name), "{}: {text}", path.display());
            }
        }
    }
    let events = file(&root, &["acq-S4_run-1", "events.tsv"]);
    let events = std::fs::read_to_string(events).unwrap();
    for kind in ["\tdupont\t", "\tBAD_blink\t", "\tevent\t"] {
        assert!(events.contains(kind), "{events}");
    }
    assert_eq!(events.matches("\tM8/S  2").count(), 3, "{events}");
}
