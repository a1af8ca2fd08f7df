//! Participants, sessions and scans: each once, each with its folder or file, and nothing that tells who somebody is.

use std::collections::BTreeSet;

use piezotact::page::Table;

use super::super::physio::number_in;
use super::super::privacy::{handedness_of, ms_of, sex_of};
use super::super::table::{cell, read_table};
use super::super::tree::Tree;
use super::{Found, Origin, ProblemKind};

const PARTICIPANTS: &str = "participants.tsv";

pub(super) fn check(tree: &Tree, origin: Origin, found: &mut Found) {
    let first = |file: &str| file.split('/').next().unwrap_or_default().to_owned();
    let mut folders: BTreeSet<String> = tree.participants.clone();
    for folder in &tree.participants {
        let within = format!("{folder}/");
        let is_empty = !tree
            .entries
            .iter()
            .any(|entry| entry.file.starts_with(&within));
        if is_empty {
            let why = "expected files of this participant, found an empty folder; copy it again, or remove it";
            found.add(ProblemKind::Empty, folder, None, why);
        }
    }
    let of_links = tree.entries.iter().filter(|entry| entry.file.contains('/'));
    folders.extend(
        of_links
            .map(|entry| first(&entry.file))
            .filter(|folder| folder.starts_with("sub-")),
    );
    let people = read_table(&tree.path(PARTICIPANTS), PARTICIPANTS).ok();
    if tree.has(PARTICIPANTS) {
        // Lines that are uneven are found with the other tables.
        if let Some(table) = &people {
            rows(
                (table, origin),
                "participant_id",
                PARTICIPANTS,
                &folders,
                found,
            );
            ages(table, PARTICIPANTS, found);
        }
    } else if origin == Origin::Ours {
        let why = "expected the table of participants, found none; restore it from a copy";
        found.add(ProblemKind::Participant, PARTICIPANTS, None, why);
    }
    for entry in &tree.entries {
        let Some(name) = entry.parsed().filter(|name| name.ending == "tsv") else {
            continue;
        };
        if !["sessions", "scans"].contains(&name.suffix.as_str()) {
            continue;
        }
        let Ok(table) = read_table(&tree.path(&entry.file), &entry.file) else {
            continue;
        };
        match name.suffix.as_str() {
            "sessions" => {
                let folder = entry.folder().to_owned() + "/";
                let inside = tree
                    .entries
                    .iter()
                    .filter_map(|other| other.file.strip_prefix(&folder));
                let sessions = inside.filter(|rest| rest.starts_with("ses-") && rest.contains('/'));
                let sessions = sessions.map(first).collect();
                rows(
                    (&table, origin),
                    "session_id",
                    &entry.file,
                    &sessions,
                    found,
                );
                ages(&table, &entry.file, found);
                times(origin, (&entry.file, &table), found);
                if let (Origin::Ours, Some(people)) = (origin, &people) {
                    same_person(people, entry.folder(), (&entry.file, &table), found);
                }
            }
            "scans" => {
                scans((tree, origin), entry.folder(), (&entry.file, &table), found);
                times(origin, (&entry.file, &table), found);
            }
            _ => {}
        }
    }
}

/// Rows that are there once, each with its folder.
fn rows(
    (table, origin): (&Table, Origin),
    column: &str,
    file: &str,
    folders: &BTreeSet<String>,
    found: &mut Found,
) {
    let mut listed = BTreeSet::new();
    if !table.columns.iter().any(|one| one.name == column) {
        let why = format!("expected the column {column}, found none; add it");
        found.add(ProblemKind::Participant, file, 1, why);
        return;
    }
    for row in 0..table.rows.len() {
        let line = row as u64 + 2;
        let Some(id) = cell(table, row, column) else {
            let why =
                format!("expected a label in the column {column}, found none; complete the line");
            found.add(ProblemKind::Participant, file, line, why);
            continue;
        };
        if !listed.insert(id.to_owned()) {
            let why = format!("expected {id} once, found it twice; remove one of the lines");
            found.add(ProblemKind::Twice, file, line, why);
        } else if origin == Origin::Ours
            && !folders.contains(id)
            // A session that was stopped before its first answer has none.
            && cell(table, row, "confirmed") != Some("0")
        {
            let why =
                format!("expected the folder {id}, found none; restore it, or remove the line");
            found.add(ProblemKind::Participant, file, line, why);
        }
    }
    for missing in folders.difference(&listed) {
        let why = format!(
            "expected a line for the folder {missing}, found none; add it, or remove the folder"
        );
        found.add(ProblemKind::Participant, file, None, why);
    }
}

/// What is stated of a participant against what the sessions state, and trials against what was planned.
fn same_person(people: &Table, id: &str, (file, table): (&str, &Table), found: &mut Found) {
    let of_people = |name: &str| {
        let mut rows = 0..people.rows.len();
        let row = rows.find(|row| cell(people, *row, "participant_id") == Some(id))?;
        cell(people, row, name)
    };
    type Said = fn(&str) -> Option<&str>;
    let pairs: [(&str, &str, Said); 3] = [
        ("age", "age", |text| Some(text)),
        ("sex", "stated_sex", |text| sex_of(text)),
        ("handedness", "handedness", |text| handedness_of(text)),
    ];
    for (name, column, said) in pairs {
        let all: BTreeSet<&str> = (0..table.rows.len())
            .filter_map(|row| said(cell(table, row, column)?))
            .collect();
        let Some(stated) = of_people(name) else {
            continue;
        };
        if !all.is_empty() && !all.contains(stated) {
            let why = format!(
                "expected the {name} that {PARTICIPANTS} states ({stated}), found {}; correct one of them",
                all.into_iter().collect::<Vec<_>>().join(", ")
            );
            found.add(ProblemKind::Participant, file, None, why);
        }
    }
    for row in 0..table.rows.len() {
        let count = |name: &str| cell(table, row, name).and_then(number_in);
        if let (Some(confirmed), Some(planned)) = (count("confirmed"), count("planned"))
            && confirmed > planned
        {
            let why = format!(
                "expected at most the {planned} planned trials, found {confirmed} confirmed ones; correct the cell"
            );
            found.add(ProblemKind::Number, file, row as u64 + 2, why);
        }
    }
}

/// Ages that are rare, or none.
fn ages(table: &Table, file: &str, found: &mut Found) {
    for row in 0..table.rows.len() {
        let Some(age) = cell(table, row, "age").and_then(number_in) else {
            continue;
        };
        let line = row as u64 + 2;
        if !(0.0..=150.0).contains(&age) {
            let why = format!("expected an age in years, found {age}; correct the cell");
            found.add(ProblemKind::Number, file, line, why);
        } else if age > 89.0 {
            let why =
                format!("expected no age over 89, which few people have, found {age}; write 89");
            found.add(ProblemKind::Privacy, file, line, why);
        }
    }
}

/// Times that are none, and true dates where the data set was exported with shifted ones.
fn times(origin: Origin, (file, table): (&str, &Table), found: &mut Found) {
    // The end of 1925, to which BIDS has dates shifted.
    let shifted = ms_of("1926-01-01T00:00:00").unwrap_or_default();
    for row in 0..table.rows.len() {
        let Some(text) = cell(table, row, "acq_time") else {
            continue;
        };
        let line = row as u64 + 2;
        match ms_of(text) {
            None => {
                let why = format!(
                    "expected a time such as 1900-01-01T10:22:33, found `{text}`; correct the cell"
                );
                found.add(ProblemKind::Number, file, line, why);
            }
            Some(ms) if ms >= shifted && origin == Origin::Ours => {
                let why = format!(
                    "expected a shifted date before 1926, found `{text}`; shift it, or write n/a"
                );
                found.add(ProblemKind::Privacy, file, line, why);
            }
            Some(_) => {}
        }
    }
}

fn scans(
    (tree, origin): (&Tree, Origin),
    folder: &str,
    (file, table): (&str, &Table),
    found: &mut Found,
) {
    let mut listed = BTreeSet::new();
    for row in 0..table.rows.len() {
        let line = row as u64 + 2;
        let Some(name) = cell(table, row, "filename") else {
            continue;
        };
        let whole = format!("{folder}/{name}");
        // Some formats are folders.
        let within = format!("{whole}/");
        let is_there = tree.has(&whole)
            || tree
                .entries
                .iter()
                .any(|entry| entry.file.starts_with(&within));
        if !is_there {
            let why =
                format!("expected the file {name}, found none; restore it, or remove the line");
            found.add(ProblemKind::File, file, line, why);
        }
        if !listed.insert(name.to_owned()) {
            let why = format!("expected {name} once, found it twice; remove one of the lines");
            found.add(ProblemKind::Twice, file, line, why);
        }
    }
    if origin == Origin::Foreign {
        return;
    }
    let within = format!("{folder}/");
    let data = tree.entries.iter().filter(|entry| {
        let is_data = entry.is_signal()
            || entry.file.ends_with("_beh.tsv")
            || entry.file.ends_with("_eeg.vhdr");
        is_data && entry.file.starts_with(&within)
    });
    for name in data.filter_map(|entry| entry.file.strip_prefix(&within)) {
        if !listed.contains(name) {
            let why = format!("expected a line for the file {name}, found none; restore it");
            found.add(ProblemKind::File, file, None, why);
        }
    }
}
