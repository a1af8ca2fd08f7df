//! `piezotact answers` as a black box.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::collections::BTreeMap;

use crate::support::{Folder, noise, wav};

const HEADER: &str = "participant,task,set,trial,presented,answered\n";

/// Four participants; SC is declared SD once in three, and SD never SC. SE is declared, and never used.
fn answers() -> String {
    let mut text = HEADER.to_owned();
    let of = [
        ("SA", ["SA", "SA", "SB", "SA"]),
        ("SB", ["SB", "SB", "SB", "SC"]),
        ("SC", ["SC", "SD", "SC", "SB"]),
        ("SD", ["SD", "SD", "SD", "SD"]),
    ];
    for (presented, answered) in of {
        for (person, answered) in answered.iter().enumerate() {
            text += &format!("P{person},3,A,{presented},{presented},{answered}\n");
        }
    }
    text
}

/// (presented, answered) and the percentage, which is "n/a" where it is untested.
type Cells = BTreeMap<(String, String), String>;

fn of_csv(text: &str) -> Cells {
    let mut rows = csv::Reader::from_reader(text.as_bytes());
    let names = rows.headers().unwrap().clone();
    let at = |name: &str| names.iter().position(|n| n == name).unwrap();
    let rows = rows.records().map(Result::unwrap);
    rows.map(|row| {
        let cell = |name: &str| row[at(name)].to_owned();
        ((cell("presented"), cell("answered")), cell("percent"))
    })
    .collect()
}

fn of_json(document: &serde_json::Value) -> Cells {
    let mut cells = Cells::new();
    for row in document["matrices"][0]["rows"].as_array().unwrap() {
        let name = |value: &serde_json::Value| value.as_str().unwrap().to_owned();
        for cell in row["cells"].as_array().unwrap() {
            let percent = cell["percent"].as_f64();
            let percent = percent.map_or("n/a".to_owned(), |percent| percent.to_string());
            cells.insert((name(&row["name"]), name(&cell["answered"])), percent);
        }
    }
    cells
}

/// The cells of the table of counts, one column for each sample.
fn of_counts(text: &str) -> Cells {
    let mut rows = csv::Reader::from_reader(text.as_bytes());
    let names = rows.headers().unwrap().clone();
    let mut cells = Cells::new();
    for row in rows.records().map(Result::unwrap) {
        for (name, value) in names.iter().zip(&row).skip(2) {
            cells.insert((row[0].to_owned(), name.to_owned()), value.to_owned());
        }
    }
    cells
}

#[test]
fn one_matrix_is_the_same_in_table_document_and_report() {
    let folder = Folder::new();
    folder.write("answers.csv", answers());
    let command = "answers answers.csv --samples SA,SB,SC,SD,SE --csv m.csv --report m.html --figures f --tables t --json";
    let words: Vec<&str> = command.split(' ').collect();
    let done = folder.run(&words);
    done.expect_success();
    let document = done.json();
    let read = |name: &str| std::fs::read_to_string(folder.path(name)).unwrap();
    let cells = of_csv(&read("m.csv"));
    assert_eq!(cells, of_json(&document));
    let tables = std::fs::read_dir(folder.path("t")).unwrap();
    let counts = tables.map(|file| std::fs::read_to_string(file.unwrap().path()).unwrap());
    let mut counts = counts.map(|text| of_counts(&text));
    assert!(
        counts.any(|counts| counts == cells),
        "no table of the report holds the matrix"
    );
    let cell = |presented: &str, answered: &str| &*cells[&(presented.into(), answered.into())];
    assert_eq!([cell("SC", "SD"), cell("SD", "SC")], ["25", "0"]);
    assert_eq!([cell("SA", "SE"), cell("SE", "SA")], ["n/a", "n/a"]);
    for presented in ["SA", "SB", "SC", "SD"] {
        let row = cells.iter().filter(|((row, _), _)| row == presented);
        let sum: f64 = row
            .filter_map(|(_, percent)| percent.parse::<f64>().ok())
            .sum();
        assert!((sum - 100.0).abs() < 1e-9, "{presented}: {sum}");
    }
    assert_eq!(document["schema"], "association");
    let codes: Vec<&str> = document["warnings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|d| d["code"].as_str().unwrap())
        .collect();
    assert_eq!(codes, ["not_declared", "untested_pairs"]);
    let text = document["warnings"][1]["text"].as_str().unwrap();
    assert!(text.contains("4 of 10 pairs"), "{text}");
    // Cells of row and column SE, and one in the legend.
    assert_eq!(
        read("f/01-association-matrix-of-all-answers-rows.svg")
            .matches("class=\"untested\"")
            .count(),
        10
    );
}

#[test]
fn groups_and_orders_are_shown() {
    let folder = Folder::new();
    let mut text = HEADER.replace("set", "session");
    for (person, made) in [["S1", "S2", "S3"], ["S2", "S1", "S3"], ["S1", "S2", "S3"]]
        .iter()
        .enumerate()
    {
        for (place, sample) in made.iter().enumerate() {
            text += &format!("P{person},1,,{place},{sample},S{}\n", place + 1);
        }
    }
    folder.write("answers.csv", text.replace(',', ";"));
    let done = folder.run(&[
        "answers",
        "answers.csv",
        "--ordering",
        "1",
        "--by",
        "participant",
        "--report",
        "r.html",
    ]);
    done.expect_success();
    let out = done.out();
    for part in [
        "9 answers of 3 participants",
        "77.8 % as expected",
        "3 orders: mean Kendall τ over participants 0.778",
        "report: r.html",
    ] {
        assert!(out.contains(part), "no `{part}` in: {out}");
    }
    let page = std::fs::read_to_string(folder.path("r.html")).unwrap();
    for part in [
        "Orders of task 1",
        "Association matrix of participant P1",
        "put before",
    ] {
        assert!(page.contains(part), "no `{part}`");
    }
}

#[test]
fn what_gives_no_matrix_is_refused() {
    let folder = Folder::new();
    folder.write("answers.csv", answers());
    let refused = |arguments: &[&str], code: i32, parts: &[&str]| {
        folder
            .run(&[&["answers", "answers.csv"], arguments].concat())
            .expect_failure(code, parts);
    };
    refused(&["--task", "9"], 2, &["no answers of task 9", "tasks 3"]);
    refused(
        &["--samples", "SA,SB"],
        1,
        &["declared samples (SA, SB)", "`SC`"],
    );
    refused(
        &["--ordering", "3"],
        1,
        &["task 3, participant P1", "answered"],
    );
    refused(
        &["--ordering", "1"],
        1,
        &["task 1", "name one of the tasks (3)"],
    );
    folder.write("answers.csv", ",SA,SB\nSA,2,1\nSB,0,3\n");
    refused(&[], 1, &["found a matrix", "give the table of answers"]);
}

/// Four participants who confuse S1 and S11, and S1 and S2 now and then; nobody confuses S2 and S11.
fn confused() -> String {
    let mut text = HEADER.replace('\n', ",offered\n");
    let of = [
        ("S1", ["S1", "S11", "S11", "S1", "S2"]),
        ("S2", ["S2", "S2", "S2", "S2", "S1"]),
        ("S11", ["S11", "S1", "S1", "S11", "S1"]),
    ];
    for person in 0..4 {
        for (presented, answered) in of {
            for trial in 0..answered.len() {
                // Everybody in another order: people are no copies.
                let answered = answered[(trial + person) % answered.len()];
                text += &format!(
                    "P{person},3,A,{presented}-{trial},{presented},{answered},S1 S2 S11\n"
                );
            }
        }
    }
    text
}

/// What a participant of the twin felt in a prepared session, with pairs in its text, document, table and report.
#[test]
fn what_was_felt_in_confused_pairs_is_shown() {
    let folder = Folder::new();
    folder.write("answers.csv", confused());
    let run = |line: &str| {
        let words: Vec<&str> = line.split(' ').collect();
        let done = folder.run(&words);
        done.expect_success();
        done
    };
    for sample in ["S1", "S11"] {
        run(&format!(
            "twin record --bench acttouch --sample {sample} --participant 2 --seed 7 --strokes 2 --out {sample}.parquet"
        ));
    }
    let bench = "--bench twin:participant=2,seed=7";
    run(&format!("characterise {bench} --seconds 10 --out tf.json"));
    // The verdicts on the drives are another test's.
    let prepare = format!("prepare S1.parquet S11.parquet --transfer tf.json {bench} --out felt");
    folder.run(&prepare.split(' ').collect::<Vec<_>>());
    let done = run("answers answers.csv --felt felt --csv m.csv --report m.html --json");
    let document = done.json();
    let felt = &document["felt"];
    assert_eq!(felt["pairs"][0]["pair"], serde_json::json!(["S1", "S11"]));
    let warnings = document["warnings"].as_array().unwrap();
    for why in ["one_for_all", "no_recording"] {
        let is = |warning: &serde_json::Value| {
            warning["code"] == "felt_not_known" && warning["why"] == why
        };
        assert!(warnings.iter().any(is), "no {why} in {warnings:?}");
    }
    let criterion = &felt["pairs"][0]["comparisons"][0]["criteria"][0];
    assert_eq!(criterion["what"], "level");
    let jnd = criterion["found"].as_f64().unwrap();
    let text = run("answers answers.csv --felt felt");
    let out = text.out();
    assert!(out.contains(&format!("level {jnd:.2} JND")), "{jnd}: {out}");
    assert!(out.contains("S1 – S2: "), "{out}");
    assert!(out.contains("what was felt is not known"), "{out}");
    // What a recording was made from is believed, and not its name.
    let measured = |sample: &str| folder.path(&format!("felt/measured/{sample}.parquet"));
    let right = std::fs::read(measured("S11")).unwrap();
    std::fs::copy(measured("S1"), measured("S11")).unwrap();
    let other = run("answers answers.csv --felt felt").err();
    assert!(
        other.contains("expected a texture of S11, found one of S1; put the file into the folder"),
        "{other}"
    );
    std::fs::write(measured("S11"), right).unwrap();
    let page = std::fs::read_to_string(folder.path("m.html")).unwrap();
    for part in [
        "What was felt in confused pairs",
        "PSD, dB re 1 (m/s²)²/Hz",
        &format!("level {jnd:.2} JND"),
    ] {
        assert!(page.contains(part), "no `{part}`");
    }
    assert!(!page.contains("S2 – S11: "));
    let table = std::fs::read_to_string(folder.path("m.csv")).unwrap();
    let mut rows = csv::Reader::from_reader(table.as_bytes());
    let names = rows.headers().unwrap().clone();
    let at = |name: &str| names.iter().position(|n| n == name).unwrap();
    let rows: Vec<csv::StringRecord> = rows.records().map(Result::unwrap).collect();
    let row = rows
        .iter()
        .find(|row| &row[at("presented")] == "S11" && &row[at("answered")] == "S1");
    let found: f64 = row.unwrap()[at("felt_level_jnd")].parse().unwrap();
    assert!((found - jnd).abs() < 1e-9, "{found}, {jnd}");
}

#[test]
fn felt_folders_by_participant_and_without_recordings() {
    let folder = Folder::new();
    folder.write("answers.csv", confused());
    for person in ["P0", "P1"] {
        std::fs::create_dir_all(folder.path(&format!("all/{person}"))).unwrap();
        for (sample, scale, skipped) in [("S1", 1.0, 0), ("S11", 0.25, 20_000)] {
            // The same noise, with some of each sensor: a recording that is scaled alone is a copy.
            let sensor = noise(60_000).skip(20_000 + skipped);
            let both = noise(20_000).zip(sensor);
            let made = both.map(|(v, sensor)| scale * (v + 0.05 * sensor));
            folder.write(&format!("all/{person}/{sample}.wav"), wav(made, 5000));
        }
    }
    folder.write("all/P1/S2.wav", wav(std::iter::empty(), 5000));
    let done = folder.run(&[
        "answers",
        "answers.csv",
        "--felt",
        "all",
        "--scale",
        "20 m/s2",
        "--json",
    ]);
    done.expect_success();
    let document = done.json();
    let pair = &document["felt"]["pairs"][0];
    let comparisons = pair["comparisons"].as_array().unwrap();
    assert_eq!(comparisons.len(), 2);
    for (one, person) in comparisons.iter().zip(["P0", "P1"]) {
        assert_eq!(one["participant"], person);
        assert_eq!([&one["by_level"], &one["by_spectrum"]], ["yes", "no"]);
    }
    let texts: Vec<&str> = document["warnings"]
        .as_array()
        .unwrap()
        .iter()
        .map(|warning| warning["text"].as_str().unwrap())
        .collect();
    let said = |part: &str| texts.iter().any(|text| text.contains(part));
    assert!(
        said("S2 of P1: what was felt is not known, as its recording cannot be used"),
        "{texts:?}"
    );
    assert!(
        said("S2 of P0: what was felt is not known, as there is no recording"),
        "{texts:?}"
    );
    std::fs::create_dir(folder.path("empty")).unwrap();
    for (felt, part) in [("empty", "named as samples"), ("gone", "expected a folder")] {
        folder
            .run(&["answers", "answers.csv", "--felt", felt])
            .expect_failure(1, &[part]);
    }
}

#[test]
fn orders_follow_the_answers_that_count() {
    let folder = Folder::new();
    let mut text = HEADER.replace('\n', ",flags\n");
    for (person, order) in [["S2", "S1"], ["S1", "S2"]].iter().enumerate() {
        for (place, sample) in order.iter().enumerate() {
            let flag = if person == 0 && place == 0 {
                "missed_target"
            } else {
                ""
            };
            text += &format!("P{person},1,A,{place},{sample},S{},{flag}\n", place + 1);
        }
    }
    text += "P0,2,A,9,S1,S2,\n";
    folder.write("answers.csv", text);
    let matrix = ["answers", "answers.csv", "--ordering", "1"];
    let out = |more: &[&str]| {
        let done = folder.run(&[&matrix, more].concat());
        done.expect_success();
        done.out()
    };
    assert!(out(&["--task", "1"]).contains("2 orders: mean Kendall τ over participants 0.000"));
    let left = out(&["--without-flagged"]);
    assert!(
        left.contains("1 order: mean Kendall τ over participants 1.000"),
        "{left}"
    );
    assert!(left.contains("1 with flagged trials left out"), "{left}");
    folder
        .run(&[&matrix[..], &["--task", "2"]].concat())
        .expect_failure(2, &["only answers of task 2", "task 1 cannot be ordered"]);
}

/// Eight people who name SA and SB rightly in task 3, and always SA in task 4; as many others who always say SA.
#[test]
fn differences_are_tested_over_people() {
    let folder = Folder::new();
    let table = |task_3: &dyn Fn(&'static str) -> &'static str| {
        let mut text = HEADER.to_owned();
        for person in 0..8 {
            for trial in 0..6 {
                let presented = ["SA", "SB"][trial % 2];
                text += &format!("P{person},3,A,{trial},{presented},{}\n", task_3(presented));
                text += &format!("P{person},4,A,{trial},{presented},SA\n");
            }
        }
        text
    };
    folder.write("answers.csv", table(&|presented| presented));
    folder.write("other.csv", table(&|_| "SA"));
    let of = |arguments: &[&str]| {
        let all = [&["answers", "answers.csv"], arguments].concat();
        folder.run(&all)
    };
    let found = of(&[
        "--task",
        "3",
        "--compare",
        "samples:SA,SB",
        "--report",
        "report.html",
    ]);
    found.expect_success();
    let told = "SA: right 100.0 %, called SB 0.0 %; SB: right 100.0 %, called SA 0.0 % (means of 8 participants); right less called the \
                other 100.0 points; permutation of participants, p = 0.0078: told apart better than by guessing.";
    assert!(found.out().contains(told), "{}", found.out());
    let page = std::fs::read_to_string(folder.path("report.html")).unwrap();
    assert!(page.contains("told apart") && page.contains("<h2>Differences</h2>"));
    let found = of(&[
        "--compare",
        "tasks:3,4",
        "--compare",
        "samples:SA,SB",
        "--json",
    ]);
    let document: serde_json::Value = serde_json::from_str(&found.out()).unwrap();
    assert_eq!(document["comparisons"][0]["less_share"], 0.5);
    assert_eq!(document["comparisons"][1]["of"], 2);
    let found = of(&["--task", "4", "--compare", "samples:SA,SB"]);
    assert!(
        found.out().contains("p = 1.000: not decided"),
        "{}",
        found.out()
    );
    let found = of(&[
        "--task",
        "3",
        "--compare",
        "people:other.csv",
        "--compare",
        "again:other.csv",
    ]);
    for words in [
        "means of groups of 8 and 8 participants",
        "means of 8 participants",
        "they differ",
    ] {
        assert!(found.out().contains(words), "{}", found.out());
    }
    // The same pseudonyms are not two groups of people.
    let same = "the two groups have 8 pseudonyms in common";
    assert!(found.err().contains(same), "{}", found.err());
    let page = ["--compare", "people:other.csv", "--report", "same.html"];
    of(&page).expect_success();
    let page = std::fs::read_to_string(folder.path("same.html")).unwrap();
    assert!(page.contains(same));
    let again = of(&["--compare", "again:other.csv"]);
    assert!(!again.err().contains(same));
    of(&["--compare", "people:answers.csv"]).expect_failure(2, &["found answers.csv again"]);
    of(&["--compare", "samples:SA,SZ"]).expect_failure(2, &["cannot compare `SZ`", "(SA, SB"]);
    of(&["--compare", "samples:SA"]).expect_failure(2, &["expected samples:A,B"]);
    of(&["--compare", "people:nothing.csv"]).expect_failure(1, &["nothing.csv"]);
}
