//! EEG: samples against their header, the JSON file, the table of channels and the length that is stated.

use std::collections::{BTreeMap, BTreeSet};

use piezotact::page::Table;
use piezotact::quantity::Unit;

use super::super::physio::number_in;
use super::super::table::{cell, read_table};
use super::super::tree::{Entry, Tree};
use super::signals::{Span, Spans, together};
use super::{Found, Origin, ProblemKind};
use piezotact_dataset::eeg::{EegFile, EegKind, read_eeg};

/// How far rates may be apart, as a share.
const SAME_RATE: f64 = 1e-4;
/// How far an event may be from its sample or marker, in samples: tables count from 0 or 1, and onsets are rounded.
const MOST_SAMPLES: f64 = 2.0;
/// How far the length may be from the stated one, as a share, beside two samples: some programs state it rounded.
const SAME_LENGTH: f64 = 0.005;
/// Fields that the JSON file of EEG has, beside the rate (BIDS 1.11, EEG).
const REQUIRED: [&str; 4] = [
    "TaskName",
    "EEGReference",
    "PowerLineFrequency",
    "SoftwareFilters",
];
/// The types of channels of BIDS 1.11, EEG.
const TYPES: [&str; 17] = [
    "AUDIO", "EEG", "EOG", "ECG", "EMG", "EYEGAZE", "GSR", "HEOG", "MISC", "PPG", "PUPIL", "REF",
    "RESP", "SYSCLOCK", "TEMP", "TRIG", "VEOG",
];
/// Fields of the JSON file that count channels, with the types of the table of channels that they count (BIDS 1.11, EEG).
const COUNTS: [(&str, &[&str]); 6] = [
    ("EEGChannelCount", &["EEG"]),
    ("ECGChannelCount", &["ECG"]),
    ("EMGChannelCount", &["EMG"]),
    ("EOGChannelCount", &["EOG", "HEOG", "VEOG"]),
    ("MISCChannelCount", &["MISC"]),
    ("TriggerChannelCount", &["TRIG"]),
];
/// Columns that a table of channels has.
const COLUMNS: [&str; 3] = ["name", "type", "units"];

/// How far an event may lie beyond the recording, in s: onsets are rounded.
const SLACK_S: f64 = 0.1;

/// Whether `entry` is the file of an EEG recording that is read here.
pub(super) fn is_eeg(entry: &Entry) -> bool {
    let known = ["vhdr", "edf", "bdf", "set"];
    entry.datatype() == Some("eeg")
        && entry
            .parsed()
            .is_some_and(|name| name.suffix == "eeg" && known.contains(&name.ending.as_str()))
}

/// Checks all EEG recordings, and adds when they begin and end to `spans`; gives how many there are.
pub(super) fn check(tree: &Tree, origin: Origin, spans: &mut Spans, found: &mut Found) -> usize {
    let mut count = 0;
    for entry in tree.entries.iter().filter(|entry| is_eeg(entry)) {
        count += 1;
        let file = entry.file.as_str();
        let read = match read_eeg(&tree.path(file)) {
            Ok(read) => read,
            Err(error) => {
                found.add(ProblemKind::Samples, file, None, error.to_string());
                continue;
            }
        };
        let rates = read
            .segments
            .iter()
            .flat_map(|part| part.recording.clocks());
        let rate_hz = rates.map(|clock| clock.rate_hz.hz()).fold(0.0, f64::max);
        let ends = read
            .segments
            .iter()
            .map(|part| part.start_s.0 + part.recording.duration().0);
        let end_s = ends.fold(0.0, f64::max);
        stated(tree, entry, [rate_hz, end_s], found);
        channels(tree, (entry, origin), &read, found);
        events(tree, (entry, origin), &read, found);
        electrodes(tree, entry, found);
        if let Some(key) = together(entry) {
            let span = Span {
                start_s: 0.0,
                end_s,
                slack_s: SLACK_S,
            };
            spans.insert(key, span);
        }
    }
    alone(tree, found);
    count
}

/// Tables of channels and of events in a folder of EEG that belong to no recording.
fn alone(tree: &Tree, found: &mut Found) {
    let in_eeg = |entry: &&Entry| entry.datatype() == Some("eeg");
    let recordings: BTreeSet<_> = tree
        .entries
        .iter()
        .filter(in_eeg)
        .filter(|entry| entry.parsed().is_some_and(|name| name.suffix == "eeg"))
        .filter(|entry| !entry.file.ends_with(".json"))
        .filter_map(together)
        .collect();
    for entry in tree
        .entries
        .iter()
        .filter(in_eeg)
        .filter(|one| one.is_table())
    {
        let is_of_recording = entry
            .parsed()
            .is_some_and(|name| matches!(name.suffix.as_str(), "channels" | "events"));
        if is_of_recording && together(entry).is_some_and(|key| !recordings.contains(&key)) {
            let why = "expected a recording of the same name beside it, found none; restore the recording, or remove this table";
            found.add(ProblemKind::File, &entry.file, None, why);
        }
    }
}

/// The rate and the length against those of the JSON file.
fn stated(tree: &Tree, entry: &Entry, [rate_hz, end_s]: [f64; 2], found: &mut Found) {
    let file = entry.file.as_str();
    if tree.sidecars(entry).is_empty() {
        let why = "expected a JSON file of the same name beside it, found none; restore it: without it nobody knows the reference and the task";
        found.add(ProblemKind::Sidecar, file, None, why);
        return;
    }
    // One that cannot be read is named with the sidecars.
    let Ok(sidecar) = tree.sidecar(entry) else {
        return;
    };
    for key in REQUIRED.iter().filter(|key| !sidecar.contains_key(**key)) {
        let why = format!(
            "expected {key} in its JSON file, as BIDS demands for EEG, found none; add it (n/a where nobody knows it)"
        );
        found.add(ProblemKind::Metadata, file, None, why);
    }
    let letters = |text: &str| -> String {
        let plain = text.chars().filter(|sign| sign.is_alphanumeric());
        plain.flat_map(char::to_lowercase).collect()
    };
    let task = entry
        .parsed()
        .and_then(|name| name.label("task").map(letters));
    let stated = sidecar.get("TaskName").and_then(serde_json::Value::as_str);
    if let (Some(task), Some(stated)) = (task, stated)
        && letters(stated) != task
    {
        let why = format!(
            "expected the TaskName of the file's name ({task}) in its JSON file, found `{stated}`; correct the one that is wrong"
        );
        found.add(ProblemKind::Metadata, file, None, why);
    }
    let number = |key: &str| sidecar.get(key).and_then(serde_json::Value::as_f64);
    match number("SamplingFrequency") {
        Some(stated) if (stated - rate_hz).abs() <= SAME_RATE * rate_hz => {}
        stated => {
            let stated = stated.map_or("none".to_owned(), |stated| stated.to_string());
            let why = format!(
                "expected the SamplingFrequency {rate_hz} Hz of the file in its JSON file, found {stated}; correct it"
            );
            found.add(ProblemKind::Metadata, file, None, why);
        }
    }
    if let Some(stated_s) = number("RecordingDuration") {
        let tolerance_s = SAME_LENGTH * stated_s.abs() + 2.0 / rate_hz;
        if (stated_s - end_s).abs() > tolerance_s {
            let why = format!(
                "expected {stated_s} s of samples, as RecordingDuration of its JSON file says, found {end_s} s; copy the file of samples again, or correct RecordingDuration"
            );
            found.add(ProblemKind::Samples, file, None, why);
        }
    }
}

/// The table of `suffix` that belongs to a recording.
fn beside<'a>(tree: &'a Tree, entry: &Entry, suffix: &str) -> Option<&'a Entry> {
    let of = together(entry);
    tree.entries.iter().find(|other| {
        let is_it = other.parsed().is_some_and(|name| name.suffix == suffix);
        is_it && other.is_table() && together(other) == of
    })
}

/// The events of a table against the markers of the file of samples, where both have as many; and each against the sample that it states.
fn events(tree: &Tree, (entry, origin): (&Entry, Origin), read: &EegFile, found: &mut Found) {
    let Some(listed) = beside(tree, entry, "events") else {
        return;
    };
    let file = listed.file.as_str();
    let Ok(table) = read_table(&tree.path(file), file) else {
        return;
    };
    let rates = read
        .segments
        .iter()
        .flat_map(|part| part.recording.clocks());
    let rate_hz = rates.map(|clock| clock.rate_hz.hz()).fold(0.0, f64::max);
    let number = |row: usize, column: &str| cell(&table, row, column).and_then(number_in);
    let mut stated: Vec<(f64, u64)> = Vec::new();
    for row in 0..table.rows.len() {
        let line = row as u64 + 2;
        let Some(onset_s) = number(row, "onset") else {
            continue;
        };
        stated.push((onset_s, line));
        if let Some(sample) = number(row, "sample")
            && (sample - onset_s * rate_hz).abs() > MOST_SAMPLES
        {
            let why = format!(
                "expected the sample of the onset {onset_s} s, {:.0} at {rate_hz} Hz, found {sample}; correct the one that is wrong",
                onset_s * rate_hz
            );
            found.add(ProblemKind::Onset, file, line, why);
        }
    }
    let marks = read.segments.iter().flat_map(|part| {
        let own = part.recording.annotations.events.iter();
        let own = own.filter(|event| !matches!(event.kind.as_str(), "New Segment" | "boundary"));
        own.map(|event| part.start_s.0 + event.onset_s.0)
    });
    let mut marks: Vec<f64> = marks.collect();
    if marks.len() != stated.len() {
        if origin == Origin::Ours {
            let why = format!(
                "expected a line for each of the {} markers in the file of samples, found {}; restore it",
                marks.len(),
                stated.len()
            );
            found.add(ProblemKind::Onset, file, None, why);
        }
        // Another program may state other events than the amplifier recorded.
        return;
    }
    marks.sort_by(f64::total_cmp);
    stated.sort_by(|a, b| a.0.total_cmp(&b.0));
    let apart = |(mark, (onset_s, _)): &(&f64, &(f64, u64))| (*mark - onset_s).abs() * rate_hz;
    let furthest = marks
        .iter()
        .zip(&stated)
        .max_by(|a, b| apart(a).total_cmp(&apart(b)));
    if let Some(pair) = furthest
        && apart(&pair) > MOST_SAMPLES
    {
        let (mark, (onset_s, line)) = pair;
        let why = format!(
            "expected the events at the markers of the file of samples, of which there are as many, found one at {onset_s} s whose marker stands at \
             {mark} s ({:.0} samples apart); export the events again",
            apart(&pair)
        );
        found.add(ProblemKind::Onset, file, *line, why);
    }
}

/// The positions of electrodes need the file that says in which coordinates they are.
fn electrodes(tree: &Tree, entry: &Entry, found: &mut Found) {
    let same_folder = |other: &&Entry| other.folder() == entry.folder();
    let of = |suffix: &'static str| {
        let own = tree.entries.iter().filter(same_folder);
        own.filter(move |other| other.parsed().is_some_and(|name| name.suffix == suffix))
    };
    let tables = of("electrodes").filter(|other| other.is_table());
    // Once for a folder: at its first recording.
    let first = tree
        .entries
        .iter()
        .filter(same_folder)
        .find(|one| is_eeg(one));
    if first.is_none_or(|first| first.file != entry.file) {
        return;
    }
    for listed in tables {
        if of("coordsystem").next().is_none() {
            let why = "expected a file of coordinates (coordsystem.json) beside it, found none; restore it: without it nobody knows the unit and the axes";
            found.add(ProblemKind::Sidecar, &listed.file, None, why);
        }
        let Ok(table) = read_table(&tree.path(&listed.file), &listed.file) else {
            continue;
        };
        for column in ["name", "x", "y", "z"] {
            if !table.columns.iter().any(|own| own.name == column) {
                let why =
                    format!("expected the columns name, x, y and z, found no `{column}`; add it");
                found.add(ProblemKind::Columns, &listed.file, 1, why);
            }
        }
    }
}

/// The channels against their table.
fn channels(tree: &Tree, (entry, origin): (&Entry, Origin), read: &EegFile, found: &mut Found) {
    let listed = beside(tree, entry, "channels");
    let Some(listed) = listed else {
        if origin == Origin::Ours {
            let why = "expected a table of channels beside it, found none; restore it";
            found.add(ProblemKind::Sidecar, &entry.file, None, why);
        }
        return;
    };
    let file = listed.file.as_str();
    // Lines that are uneven are found with the other tables.
    let Ok(table) = read_table(&tree.path(file), file) else {
        return;
    };
    let Some(part) = read.segments.first() else {
        return;
    };
    let mut rates: BTreeMap<&str, f64> = BTreeMap::new();
    for channel in part.recording.channels() {
        let rate_hz = part.recording.clock_of(&channel.name).rate_hz.hz();
        rates.insert(channel.name.trim(), rate_hz);
    }
    for column in COLUMNS
        .iter()
        .filter(|column| !table.columns.iter().any(|own| own.name == **column))
    {
        let why = format!("expected the columns name, type and units, found no `{column}`; add it");
        found.add(ProblemKind::Columns, file, 1, why);
    }
    let mut missing: BTreeMap<&str, f64> = rates.clone();
    let mut seen = BTreeSet::new();
    for row in 0..table.rows.len() {
        let line = row as u64 + 2;
        let Some(name) = cell(&table, row, "name").map(str::trim) else {
            continue;
        };
        let of_events = matches!(cell(&table, row, "type"), Some("TRIG" | "MISC"));
        missing.remove(name);
        if !seen.insert(name) {
            let why =
                format!("expected each channel once, found {name} again; remove one of the lines");
            found.add(ProblemKind::Twice, file, line, why);
        }
        levels(&table, row, (file, line), found);
        unit(&table, (row, name), read, (file, line), found);
        match rates.get(name) {
            // Channels of triggers and of annotations are read as events.
            None if !of_events || read.kind == EegKind::BrainVision => {
                let why = format!(
                    "expected channels that the file of samples has, found `{name}`; correct the name, or remove the line"
                );
                found.add(ProblemKind::Columns, file, line, why);
            }
            None => {}
            Some(rate_hz) => {
                let stated = cell(&table, row, "sampling_frequency").and_then(number_in);
                if let Some(stated) =
                    stated.filter(|stated| (stated - rate_hz).abs() > SAME_RATE * rate_hz)
                {
                    let why = format!(
                        "expected the rate {rate_hz} Hz of the channel {name}, found {stated}; correct the cell"
                    );
                    found.add(ProblemKind::Number, file, line, why);
                }
            }
        }
    }
    counts(tree, (entry, file), &table, found);
    for name in missing.into_keys() {
        let why = format!(
            "expected a line for the channel {name}, which the file of samples has, found none; restore it"
        );
        found.add(ProblemKind::Columns, file, None, why);
    }
}

/// The unit of a channel in its table against the one in the file of samples.
fn unit(
    table: &Table,
    (row, name): (usize, &str),
    read: &EegFile,
    (file, line): (&str, u64),
    found: &mut Found,
) {
    let stated = cell(table, row, "units").map(str::trim);
    // A share of full scale, and what has no unit, are no quantities.
    let stated = stated.filter(|unit| !matches!(*unit, "" | "n/a" | "1" | "arbitrary"));
    let (Some(stated), Some(own)) = (stated, read.stated_units.get(name)) else {
        return;
    };
    let meant = |unit: &str| Unit::parse(&unit.trim().replace(['\u{b5}', '\u{3bc}'], "u"));
    if !own.trim().is_empty() && meant(stated) != meant(own) {
        let why = format!(
            "expected the unit {own} of the channel {name}, as in the file of samples, found {stated}; correct the one that is wrong"
        );
        found.add(ProblemKind::Metadata, file, line, why);
    }
}

/// The numbers of channels in the JSON file against the types in the table of channels.
fn counts(tree: &Tree, (entry, listed): (&Entry, &str), table: &Table, found: &mut Found) {
    let Ok(sidecar) = tree.sidecar(entry) else {
        return;
    };
    for (field, types) in COUNTS {
        let Some(stated) = sidecar.get(field).and_then(serde_json::Value::as_f64) else {
            continue;
        };
        let rows = 0..table.rows.len();
        let count = rows
            .filter(|row| cell(table, *row, "type").is_some_and(|kind| types.contains(&kind)))
            .count();
        if stated != count as f64 {
            let why = format!(
                "expected {field} {count} in its JSON file, as {listed} lists so many, found {stated}; correct the one that is wrong"
            );
            found.add(ProblemKind::Metadata, &entry.file, None, why);
        }
    }
}

/// The type and the status of a channel are among the words of BIDS.
fn levels(table: &Table, row: usize, (file, line): (&str, u64), found: &mut Found) {
    let of = |column: &str| {
        cell(table, row, column)
            .map(str::trim)
            .filter(|text| *text != "n/a")
    };
    if let Some(kind) = of("type").filter(|kind| !TYPES.contains(kind)) {
        let why = format!(
            "expected a type of channel such as EEG, VEOG or TRIG, found `{kind}`; write it in capitals, or MISC"
        );
        found.add(ProblemKind::Level, file, line, why);
    }
    if let Some(status) = of("status").filter(|status| !matches!(*status, "good" | "bad")) {
        let why = format!("expected the status good or bad, found `{status}`; correct it");
        found.add(ProblemKind::Level, file, line, why);
    }
}
