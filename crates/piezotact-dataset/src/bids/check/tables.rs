//! Tables: even lines, numbers where numbers are stated, levels that are listed, events within what was recorded, files that are there.

use std::collections::BTreeSet;
use std::io::BufReader;

use serde_json::{Map, Value};

use super::super::NOTHING;
use super::super::error::BidsError;
use super::super::physio::number_in;
use super::super::table::Lines;
use super::super::tree::{Entry, Tree};
use super::answers::Answers;
use super::signals::{Ends, together};
use super::{Found, ProblemKind};
use crate::input::open_input;

/// Columns that hold numbers wherever they stand.
///
/// Source: BIDS 1.11, schema `objects.columns`.
const NUMBERS: [&str; 8] = [
    "onset",
    "duration",
    "response_time",
    "sampling_frequency",
    "age",
    "x",
    "y",
    "z",
];
/// An event this long after the one before it, in s, is no event of the same session.
const LONGEST_PAUSE_S: f64 = 86_400.0;
/// How far an event may lie after the end of what was recorded, in s: a rounded onset.
const TOLERANCE_S: f64 = 0.001;

/// What a column may hold.
struct Rule {
    name: String,
    is_number: bool,
    levels: Option<BTreeSet<String>>,
    delimiter: Option<String>,
}

/// Checks all tables; gives how many were read.
pub(super) fn check(tree: &Tree, ends: &Ends, found: &mut Found) -> Result<usize, BidsError> {
    let mut count = 0;
    for entry in tree.entries.iter().filter(|entry| entry.is_table()) {
        count += 1;
        table(tree, entry, ends, found)?;
    }
    Ok(count)
}

fn table(tree: &Tree, entry: &Entry, ends: &Ends, found: &mut Found) -> Result<(), BidsError> {
    let file = entry.file.as_str();
    // A sidecar that cannot be read is named with the sidecars.
    let mut sidecar = tree.sidecar(entry).unwrap_or_default();
    if file == "participants.tsv" && tree.has("participants.json") {
        sidecar = tree.json("participants.json").unwrap_or_default();
    }
    let opened = open_input(&tree.path(file))?;
    let mut lines = Lines::of(BufReader::new(opened));
    let mut checked: Option<Rows<'_>> = None;
    loop {
        let (number, line) = match lines.next() {
            Ok(Some(line)) => line,
            Ok(None) => break,
            Err((number, fault)) => {
                found.add(ProblemKind::Ragged, file, number, fault.sentence());
                return Ok(());
            }
        };
        match &mut checked {
            None => {
                checked = Some(Rows {
                    tree,
                    entry,
                    rules: rules(line, &sidecar),
                    answers: Answers::of(line),
                    end_s: together(entry).and_then(|key| ends.get(&key).copied()),
                    last_s: None,
                    is_empty: true,
                    sidecar_of_levels: tree.sidecars(entry).last().map(|of| of.file.clone()),
                });
                heading(file, line, found);
            }
            Some(rows) => rows.row(number, line, found),
        }
    }
    match checked {
        None => found.add(
            ProblemKind::Empty,
            file,
            None,
            "expected a heading, found an empty file; copy it again",
        ),
        Some(rows) => {
            if rows.is_empty && file.ends_with("_beh.tsv") {
                found.add(
                    ProblemKind::Empty,
                    file,
                    None,
                    "expected answers, found a heading alone; copy it again, or remove the file",
                );
            }
            rows.answers.end(file, found);
        }
    }
    Ok(())
}

fn heading(file: &str, line: &str, found: &mut Found) {
    let mut known = BTreeSet::new();
    for name in line.split('\t') {
        if name.trim().is_empty() {
            found.add(
                ProblemKind::Columns,
                file,
                1,
                "expected a name for every column, found an empty one; name it",
            );
        } else if !known.insert(name) {
            let why =
                format!("expected the column `{name}` once, found it twice; remove or rename one");
            found.add(ProblemKind::Twice, file, 1, why);
        }
    }
    let is_events = file.ends_with("_events.tsv");
    for name in ["onset", "duration"] {
        if is_events && !known.contains(name) {
            let why =
                format!("expected the column {name} in a table of events, found none; add it");
            found.add(ProblemKind::Columns, file, 1, why);
        }
    }
}

fn rules(heading: &str, sidecar: &Map<String, Value>) -> Vec<Rule> {
    let rules = heading.split('\t').map(|name| {
        let meaning = sidecar.get(name).and_then(Value::as_object);
        let levels = meaning.and_then(|meaning| meaning.get("Levels")?.as_object());
        let levels = levels.map(|levels| levels.keys().cloned().collect());
        let delimiter = meaning.and_then(|meaning| meaning.get("Delimiter")?.as_str());
        let has_unit = meaning.is_some_and(|meaning| {
            let unit = meaning.get("Units").and_then(Value::as_str);
            unit.is_some_and(|unit| !unit.is_empty() && unit != NOTHING)
        });
        Rule {
            name: name.to_owned(),
            is_number: (NUMBERS.contains(&name) || has_unit)
                && levels.is_none()
                && delimiter.is_none(),
            levels,
            delimiter: delimiter.map(str::to_owned),
        }
    });
    rules.collect()
}

/// The rows of a table.
struct Rows<'a> {
    tree: &'a Tree,
    entry: &'a Entry,
    rules: Vec<Rule>,
    answers: Answers,
    /// When what was recorded with it ends.
    end_s: Option<f64>,
    last_s: Option<f64>,
    is_empty: bool,
    sidecar_of_levels: Option<String>,
}

impl Rows<'_> {
    fn row(&mut self, number: u64, line: &str, found: &mut Found) {
        let file = self.entry.file.as_str();
        self.is_empty = false;
        let cells: Vec<&str> = line.split('\t').collect();
        if cells.len() != self.rules.len() {
            let why = match line.is_empty() {
                true => "expected a row, found an empty line; remove it".to_owned(),
                false => format!(
                    "expected {} cells as in the heading, found {}; complete the line",
                    self.rules.len(),
                    cells.len()
                ),
            };
            found.add(ProblemKind::Ragged, file, number, why);
            return;
        }
        for (rule, cell) in self.rules.iter().zip(&cells) {
            if *cell == NOTHING {
                continue;
            }
            if rule.is_number {
                // Ages of 89 and more were written so.
                let is_age = rule.name == "age" && *cell == "89+";
                if number_in(cell).is_none() && !is_age {
                    let why = format!(
                        "expected a number or n/a in the column `{}`, found `{}`; correct the cell",
                        rule.name,
                        short(cell)
                    );
                    found.add(ProblemKind::Number, file, number, why);
                }
            }
            let is_count = ["response_time", "n_replays"].contains(&rule.name.as_str());
            if is_count && number_in(cell).is_some_and(|value| value < 0.0) {
                let why = format!(
                    "expected 0 or more in the column `{}`, found {cell}; correct the cell",
                    rule.name
                );
                found.add(ProblemKind::Number, file, number, why);
            }
            if let (Some(levels), None) = (&rule.levels, &rule.delimiter)
                && !levels.contains(*cell)
            {
                let of = self.sidecar_of_levels.as_deref().unwrap_or("its JSON file");
                let why = format!(
                    "expected one of the levels of `{}` that {of} lists, found `{}`; correct the cell, or add the level",
                    rule.name,
                    short(cell)
                );
                let kind = match rule.name.as_str() {
                    "response" => ProblemKind::Response,
                    _ => ProblemKind::Level,
                };
                found.add(kind, file, number, why);
            }
            if rule.name == "stim_file" && !self.tree.has(&format!("stimuli/{cell}")) {
                let why = format!(
                    "expected the file stimuli/{}, found none; restore it, or correct the cell",
                    short(cell)
                );
                found.add(ProblemKind::File, file, number, why);
            }
        }
        self.time(number, &cells, found);
        self.answers.row(file, number, &cells, found);
    }

    /// The times of an event.
    fn time(&mut self, number: u64, cells: &[&str], found: &mut Found) {
        let file = self.entry.file.as_str();
        if !file.ends_with("_events.tsv") {
            return;
        }
        let value = |name: &str| {
            let at = self.rules.iter().position(|rule| rule.name == name)?;
            number_in(cells[at])
        };
        let (onset_s, duration_s) = (value("onset"), value("duration"));
        if duration_s.is_some_and(|duration_s| duration_s < 0.0) {
            let why = "expected a duration of 0 s or more, found a negative one; correct it, or write n/a";
            found.add(ProblemKind::Duration, file, number, why);
        }
        let Some(onset_s) = onset_s else { return };
        if let Some(end_s) = self.end_s.filter(|end_s| onset_s > end_s + TOLERANCE_S) {
            let why = format!(
                "expected an onset before the end of what was recorded ({end_s:.3} s), found {onset_s} s; correct it"
            );
            found.add(ProblemKind::Onset, file, number, why);
        }
        let ends_s = onset_s + duration_s.unwrap_or(0.0);
        let outlasts = |end_s: &f64| onset_s <= end_s + TOLERANCE_S && ends_s > end_s + TOLERANCE_S;
        if let Some(end_s) = self.end_s.filter(outlasts) {
            let why = format!(
                "expected an event that ends before the end of what was recorded ({end_s:.3} s), found one until {ends_s} s; correct its duration"
            );
            found.add(ProblemKind::Duration, file, number, why);
        }
        let pause_s = onset_s - self.last_s.unwrap_or(0.0);
        if self.end_s.is_none() && pause_s > LONGEST_PAUSE_S {
            let why = format!(
                "expected an onset within a day of the event before it, found {onset_s} s; correct it"
            );
            found.add(ProblemKind::Onset, file, number, why);
        } else {
            self.last_s = Some(onset_s);
        }
    }
}

fn short(cell: &str) -> String {
    cell.chars().take(60).collect()
}
