//! Tables: even lines, numbers where numbers are stated, levels that are listed, events within what was recorded, files that are there,
//! and nothing that tells who somebody is.

use std::collections::{BTreeMap, BTreeSet};
use std::io::BufReader;

use piezotact_people::campaign::protocol::{Protocol, read};
use serde_json::{Map, Value};

use super::super::physio::number_in;
use super::super::privacy::{personal, personal_in_people, tells_who, tells_who_beside_stimuli};
use super::super::table::Lines;
use super::super::tree::{Entry, Tree};
use super::super::{NOTHING, PROTOCOL, label_of};
use super::answers::Answers;
use super::both::Both;
use super::signals::{Span, Spans, together};
use super::{Found, LONGEST_SESSION_S, Origin, ProblemKind};
use piezotact_dataset::reads::sha256_of_file;
use piezotact_dataset::{open_input, read_input_text};

/// Columns that hold numbers in tables with these suffixes.
///
/// Source: BIDS 1.11, schema `objects.columns` and `rules.tabular_data`.
const NUMBERS: [(&str, &[&str]); 8] = [
    ("onset", &["events"]),
    ("duration", &["events"]),
    ("response_time", &["events"]),
    ("sampling_frequency", &["channels"]),
    ("age", &["participants"]),
    ("x", &["electrodes"]),
    ("y", &["electrodes"]),
    ("z", &["electrodes"]),
];
/// Headings that decide what is looked at.
const DECIDING: [&str; 15] = [
    "acq_time",
    "correct",
    "duration",
    "expected",
    "offered",
    "onset",
    "participant_id",
    "presented",
    "rank",
    "response",
    "response_time",
    "session_id",
    "stim_file",
    "trial",
    "trial_type",
];
/// How far an event may lie after the end of what was recorded, in s: a rounded onset.
const TOLERANCE_S: f64 = 0.001;

/// What a column may hold.
struct Rule {
    name: String,
    is_number: bool,
    levels: Option<BTreeSet<String>>,
    delimiter: Option<String>,
    /// Whether its cells are looked at for what tells who somebody is.
    is_private: bool,
    /// Whether the rows are people.
    of_people: bool,
}

/// Checks all tables; gives how many were read.
pub(super) fn check(tree: &Tree, origin: Origin, spans: &Spans, found: &mut Found) -> usize {
    let mut both = Both::default();
    let text = match origin {
        Origin::Ours => read_input_text(&tree.path(PROTOCOL)).unwrap_or_default(),
        Origin::Foreign => String::new(),
    };
    let protocol = read(&text).ok();
    let mut count = 0;
    // Motion has no heading.
    let has_heading = |entry: &&Entry| {
        entry.is_table() && entry.parsed().is_none_or(|name| name.suffix != "motion")
    };
    for entry in tree.entries.iter().filter(has_heading) {
        count += 1;
        table(
            (tree, origin, protocol.as_ref()),
            entry,
            (spans, &mut both),
            found,
        );
    }
    if origin == Origin::Ours {
        both.end(found);
    }
    // Of other folders nothing is known but that nobody may be named in them.
    let tables = tree.others.iter().filter(|file| {
        let of_people = ["phenotype/", "sourcedata/"];
        file.ends_with(".tsv") && of_people.iter().any(|folder| file.starts_with(folder))
    });
    for file in tables {
        nobody(tree, file, found);
    }
    count
}

/// Looks for what tells who somebody is, in a table of which nothing else is known.
fn nobody(tree: &Tree, file: &str, found: &mut Found) {
    let Ok(opened) = open_input(&tree.path(file)) else {
        return;
    };
    let mut lines = Lines::of(BufReader::new(opened));
    let mut rules: Option<Vec<Rule>> = None;
    while let Ok(Some((number, line))) = lines.next() {
        match &rules {
            None => {
                rules = Some(self::rules(file, line, &Map::new()));
                private_heading(file, line, found);
            }
            Some(rules) => {
                let cells = rules.iter().zip(line.split('\t'));
                for (rule, cell) in cells.filter(|(rule, _)| rule.is_private) {
                    private_cell(file, number, (rule, cell), found);
                }
            }
        }
    }
}

fn table(
    (tree, origin, protocol): (&Tree, Origin, Option<&Protocol>),
    entry: &Entry,
    (spans, both): (&Spans, &mut Both),
    found: &mut Found,
) {
    let file = entry.file.as_str();
    // A sidecar that cannot be read is named with the sidecars.
    let mut sidecar = tree.sidecar(entry).unwrap_or_default();
    if file == "participants.tsv" && tree.has("participants.json") {
        sidecar = tree.json("participants.json").unwrap_or_default();
    }
    let opened = match open_input(&tree.path(file)) {
        Ok(opened) => opened,
        Err(error) => {
            found.add(ProblemKind::File, file, None, error.to_string());
            return;
        }
    };
    let mut lines = Lines::of(BufReader::new(opened));
    let mut checked: Option<Rows<'_>> = None;
    // An empty line at the end is none.
    let mut empty: Option<u64> = None;
    loop {
        let (number, line) = match lines.next() {
            Ok(Some(line)) => line,
            Ok(None) => break,
            Err((number, fault)) => {
                found.add(ProblemKind::Ragged, file, number, fault.sentence());
                return;
            }
        };
        match &mut checked {
            None => {
                checked = Some(Rows {
                    tree,
                    entry,
                    origin,
                    rules: rules(file, line, &sidecar),
                    answers: Answers::of(line, origin, protocol),
                    sums: BTreeMap::new(),
                    span: together(entry).and_then(|key| spans.get(&key).copied()),
                    last_s: None,
                    is_empty: true,
                    sidecar_of_levels: tree.sidecars(entry).last().map(|of| of.file.clone()),
                });
                heading(file, line, found);
                private_heading(file, line, found);
                if origin == Origin::Ours {
                    described(file, line, &sidecar, found);
                }
                levels(file, &sidecar, found);
            }
            Some(rows) => {
                if let Some(number) = empty.take() {
                    let why = "expected a row, found an empty line; remove it";
                    found.add(ProblemKind::Ragged, file, number, why);
                }
                match line.is_empty() && rows.rules.len() > 1 {
                    true => empty = Some(number),
                    false => rows.row(number, line, both, found),
                }
            }
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
            if rows.is_empty && origin == Origin::Ours && file.ends_with("_beh.tsv") {
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
}

fn heading(file: &str, line: &str, found: &mut Found) {
    let mut known = BTreeSet::new();
    if !line.contains('\t') && line.contains([',', ';']) {
        let why = "expected columns between tabulators, found other separators; save the table with tabulators";
        found.add(ProblemKind::Columns, file, 1, why);
    }
    for name in line.split('\t') {
        let plain = name.trim_matches(|sign: char| sign.is_whitespace() || sign == '"');
        if plain.is_empty() {
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
        } else if plain != name {
            let why = format!(
                "expected the column `{plain}`, found `{}`, with spaces or quotation marks about it; remove them",
                short(name)
            );
            found.add(ProblemKind::Columns, file, 1, why);
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
    let first: Vec<&str> = line.split('\t').take(2).collect();
    let are_there = ["onset", "duration"]
        .iter()
        .all(|name| known.contains(name));
    if is_events && are_there && first != ["onset", "duration"] {
        let why = format!(
            "expected the columns onset and duration first, found {}; move them",
            first.join(" and ")
        );
        found.add(ProblemKind::Columns, file, 1, why);
    }
}

/// Columns of our own tables that were renamed: rules go by their names.
fn described(file: &str, line: &str, sidecar: &Map<String, Value>, found: &mut Found) {
    let names: BTreeSet<&str> = line.split('\t').collect();
    let is_table = file.ends_with("_beh.tsv") || file.ends_with("_events.tsv");
    if !is_table || sidecar.is_empty() {
        return;
    }
    for name in names.iter().filter(|name| !sidecar.contains_key(**name)) {
        let known = DECIDING
            .iter()
            .find(|known| !names.contains(**known) && name.trim().eq_ignore_ascii_case(known));
        let wanted = known.map_or(
            "a column that its JSON file describes".to_owned(),
            |known| format!("the column {known}"),
        );
        let why = format!("expected {wanted}, found `{}`; rename it", short(name));
        found.add(ProblemKind::Columns, file, 1, why);
    }
    if !file.ends_with("_beh.tsv") {
        return;
    }
    let columns = sidecar.iter().filter(|(_, meaning)| meaning.is_object());
    for (name, _) in columns.filter(|(name, _)| !names.contains(name.as_str())) {
        let why = format!(
            "expected the column {name}, which its JSON file describes, found none; restore it"
        );
        found.add(ProblemKind::Columns, file, 1, why);
    }
}

/// Levels that are no list of levels.
fn levels(file: &str, sidecar: &Map<String, Value>, found: &mut Found) {
    for (name, meaning) in sidecar {
        let stated = meaning.get("Levels");
        if stated.is_some_and(|stated| !stated.is_object()) {
            let why = format!(
                "expected Levels of `{name}` in its JSON file as an object, found another value; put braces around them"
            );
            found.add(ProblemKind::Metadata, file, None, why);
        }
    }
}

/// Which names of columns tell who somebody is: in tables of people more than beside samples and stimuli, which have names too.
fn telling(file: &str, line: &str) -> fn(&str) -> bool {
    match is_of_people(file, line) {
        true => tells_who,
        false => tells_who_beside_stimuli,
    }
}

fn is_of_people(file: &str, line: &str) -> bool {
    file.ends_with("_sessions.tsv")
        || file.starts_with("phenotype/")
        || line.split('\t').any(|name| name == "participant_id")
}

fn private_heading(file: &str, line: &str, found: &mut Found) {
    let tells = telling(file, line);
    for name in line.split('\t').filter(|name| tells(name)) {
        let why = format!(
            "expected nothing that tells who somebody is, found the column `{}`; remove it",
            short(name)
        );
        found.add(ProblemKind::Privacy, file, 1, why);
    }
}

fn private_cell(file: &str, number: u64, (rule, cell): (&Rule, &str), found: &mut Found) {
    let column = &rule.name;
    let looked = if rule.of_people {
        personal_in_people
    } else {
        personal
    };
    if let Some(what) = looked(cell) {
        let why = format!(
            "expected nothing that tells who somebody is, found {what} in the column `{column}`; remove it"
        );
        found.add(ProblemKind::Privacy, file, number, why);
    }
}

fn rules(file: &str, heading: &str, sidecar: &Map<String, Value>) -> Vec<Rule> {
    let tells = telling(file, heading);
    let of_people = is_of_people(file, heading);
    let suffix = file.trim_end_matches(".tsv").rsplit(['_', '/']).next();
    let holds_numbers = |name: &str| {
        let known = NUMBERS.iter().find(|(known, _)| *known == name);
        known.is_some_and(|(_, of)| suffix.is_some_and(|suffix| of.contains(&suffix)))
    };
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
            is_number: (holds_numbers(name) || has_unit) && levels.is_none() && delimiter.is_none(),
            levels,
            delimiter: delimiter.map(str::to_owned),
            // Times of sessions are dates, which may be shifted; versions look like dates.
            of_people,
            is_private: name != "acq_time"
                && !name.to_lowercase().contains("version")
                && !tells(name),
        }
    });
    rules.collect()
}

/// The rows of a table.
struct Rows<'a> {
    tree: &'a Tree,
    entry: &'a Entry,
    origin: Origin,
    rules: Vec<Rule>,
    answers: Answers<'a>,
    /// Checksums of drives by their files.
    sums: BTreeMap<String, String>,
    /// When what was recorded with it begins and ends.
    span: Option<Span>,
    last_s: Option<f64>,
    is_empty: bool,
    sidecar_of_levels: Option<String>,
}

impl Rows<'_> {
    fn row(&mut self, number: u64, line: &str, both: &mut Both, found: &mut Found) {
        let file = self.entry.file.as_str();
        self.is_empty = false;
        let cells: Vec<&str> = line.split('\t').collect();
        if cells.len() != self.rules.len() {
            let why = format!(
                "expected {} cells as in the heading, found {}; complete the line",
                self.rules.len(),
                cells.len()
            );
            found.add(ProblemKind::Ragged, file, number, why);
            return;
        }
        for (rule, cell) in self.rules.iter().zip(&cells) {
            if *cell != NOTHING {
                self.cell(number, rule, cell, found);
            }
        }
        self.stimulus(number, &cells, found);
        self.time(number, &cells, found);
        self.answers.row(file, number, &cells, found);
        both.row(self.entry, number, |name| self.value(&cells, name));
    }

    fn value<'c>(&self, cells: &[&'c str], name: &str) -> Option<&'c str> {
        let at = self.rules.iter().position(|rule| rule.name == name)?;
        cells.get(at).copied()
    }

    /// One cell against the rule of its column.
    fn cell(&self, number: u64, rule: &Rule, cell: &str, found: &mut Found) {
        let file = self.entry.file.as_str();
        if rule.is_private {
            private_cell(file, number, (rule, cell), found);
        }
        if self.origin == Origin::Ours && cell.trim() != cell {
            let why = format!(
                "expected a cell without spaces about it in the column `{}`, found `{}`; remove them",
                rule.name,
                short(cell)
            );
            found.add(ProblemKind::Level, file, number, why);
        }
        if self.origin == Origin::Ours && cell.is_empty() {
            let why = format!(
                "expected a value or n/a in the column `{}`, found an empty cell; write n/a",
                rule.name
            );
            found.add(ProblemKind::Level, file, number, why);
            return;
        }
        // Ages of 89 and more were written so.
        let is_age = rule.name == "age" && cell == "89+";
        if rule.is_number && number_in(cell).is_none() && !is_age {
            let why = format!(
                "expected a number or n/a in the column `{}`, found `{}`; correct the cell",
                rule.name,
                short(cell)
            );
            found.add(ProblemKind::Number, file, number, why);
        }
        // Others have responses that anticipate.
        let is_count = self.origin == Origin::Ours
            && ["response_time", "n_replays"].contains(&rule.name.as_str());
        if is_count && number_in(cell).is_some_and(|value| value < 0.0) {
            let why = format!(
                "expected 0 or more in the column `{}`, found {cell}; correct the cell",
                rule.name
            );
            found.add(ProblemKind::Number, file, number, why);
        }
        if let (Some(levels), None) = (&rule.levels, &rule.delimiter)
            && !levels.contains(cell)
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
        if rule.name == "stim_file" && !self.tree.is_there(&format!("stimuli/{cell}")) {
            let why = format!(
                "expected the file stimuli/{}, found none; restore it, or correct the cell",
                short(cell)
            );
            found.add(ProblemKind::File, file, number, why);
        }
    }

    /// A file of another stimulus than the one of its row.
    fn stimulus(&mut self, number: u64, cells: &[&str], found: &mut Found) {
        let named = ["stimulus", "presented"]
            .into_iter()
            .find_map(|name| self.value(cells, name).filter(|text| *text != NOTHING));
        let file = self
            .value(cells, "stim_file")
            .filter(|text| *text != NOTHING);
        let (Origin::Ours, Some(named), Some(file)) = (self.origin, named, file) else {
            return;
        };
        let own = self.entry.file.as_str();
        let label = label_of(named).unwrap_or_default();
        let of = file.rsplit('/').next().unwrap_or_default();
        let of = of.strip_suffix("_drive.wav");
        let whose = own.split("/beh/").next().unwrap_or_default();
        if of.is_some_and(|of| of != label) || !file.starts_with(whose) {
            let why = format!(
                "expected the drive of {} for this session, found the file {}; correct the cell",
                short(named),
                short(file)
            );
            found.add(ProblemKind::File, own, number, why);
        }
        let stated = self.value(cells, "drive_sha256").map(str::to_owned);
        if let Some(stated) = stated.filter(|sum| sum != NOTHING) {
            let path = self.tree.path(&format!("stimuli/{file}"));
            let sum = self.sums.entry(file.to_owned());
            let sum = sum.or_insert_with(|| sha256_of_file(&path).unwrap_or_default());
            if !sum.is_empty() && *sum != stated {
                let why = format!(
                    "expected the checksum of stimuli/{} for drive_sha256, found another; restore the drive that was played",
                    short(file)
                );
                found.add(ProblemKind::File, own, number, why);
            }
        }
        let recording = self.value(cells, "recording_file");
        if let Some(recording) = recording.filter(|text| *text != NOTHING) {
            let is_there = self.tree.has(&format!("{whose}/{recording}"));
            if !is_there || !recording.contains(&format!("_acq-{label}_")) {
                let why = format!(
                    "expected a recording of {} in this session, found {}; correct the cell",
                    short(named),
                    short(recording)
                );
                found.add(ProblemKind::File, own, number, why);
            }
        }
    }

    /// The times of an event.
    fn time(&mut self, number: u64, cells: &[&str], found: &mut Found) {
        let file = self.entry.file.as_str();
        if !file.ends_with("_events.tsv") {
            return;
        }
        let value = |name: &str| self.value(cells, name).and_then(number_in);
        let (onset_s, duration_s) = (value("onset"), value("duration"));
        if duration_s.is_some_and(|duration_s| duration_s < 0.0) {
            let why = "expected a duration of 0 s or more, found a negative one; correct it, or write n/a";
            found.add(ProblemKind::Duration, file, number, why);
        } else if let Some(duration_s) = duration_s.filter(|of| *of > LONGEST_SESSION_S) {
            let why = format!(
                "expected a duration of less than a week, found {duration_s} s; correct it"
            );
            found.add(ProblemKind::Duration, file, number, why);
        }
        let Some(onset_s) = onset_s else {
            if self.origin == Origin::Ours {
                let why = "expected an onset in s, found none; correct the cell";
                found.add(ProblemKind::Onset, file, number, why);
            }
            return;
        };
        if self.origin == Origin::Ours && self.last_s.is_some_and(|last_s| onset_s < last_s) {
            let why = format!(
                "expected events in the order of their onsets, found one at {onset_s} s behind a later one; sort the table"
            );
            found.add(ProblemKind::Onset, file, number, why);
        }
        match self.span {
            Some(span) => self.within(number, span, (onset_s, duration_s), found),
            None => {
                // Others count from another time than the beginning.
                let first_s = match self.origin {
                    Origin::Ours => 0.0,
                    Origin::Foreign => onset_s,
                };
                let pause_s = (onset_s - self.last_s.unwrap_or(first_s)).abs();
                if pause_s > LONGEST_SESSION_S {
                    let why = format!(
                        "expected an onset within a week of the event before it, found {onset_s} s; correct it"
                    );
                    found.add(ProblemKind::Onset, file, number, why);
                    return;
                }
            }
        }
        self.last_s = Some(onset_s);
    }

    /// An event against what was recorded with it.
    fn within(
        &self,
        number: u64,
        span: Span,
        (onset_s, duration_s): (f64, Option<f64>),
        found: &mut Found,
    ) {
        let file = self.entry.file.as_str();
        let Span { start_s, end_s, .. } = span;
        let tolerance_s = match self.origin {
            Origin::Ours => TOLERANCE_S,
            Origin::Foreign => span.slack_s,
        };
        if onset_s > end_s + tolerance_s {
            let why = format!(
                "expected an onset before the end of what was recorded ({end_s:.3} s), found {onset_s} s; correct it"
            );
            found.add(ProblemKind::Onset, file, number, why);
            return;
        }
        if onset_s < start_s - tolerance_s {
            let why = format!(
                "expected an onset after the beginning of what was recorded ({start_s:.3} s), found {onset_s} s; correct it"
            );
            found.add(ProblemKind::Onset, file, number, why);
        }
        let ends_s = onset_s + duration_s.unwrap_or(0.0);
        if ends_s > end_s + tolerance_s {
            let why = format!(
                "expected an event that ends before the end of what was recorded ({end_s:.3} s), found one until {ends_s} s; correct its duration"
            );
            found.add(ProblemKind::Duration, file, number, why);
        }
    }
}

fn short(cell: &str) -> String {
    cell.chars().take(60).collect()
}
