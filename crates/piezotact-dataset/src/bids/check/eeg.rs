//! EEG: samples against their header, the JSON file, the table of channels and the length that is stated.

use std::collections::BTreeMap;

use super::super::super::eeg::{EegFile, read_eeg};
use super::super::physio::number_in;
use super::super::table::{cell, read_table};
use super::super::tree::{Entry, Tree};
use super::signals::{Span, Spans, together};
use super::{Found, Origin, ProblemKind};

/// How far rates may be apart, as a share.
const SAME_RATE: f64 = 1e-4;
/// How far the length may be from the stated one, as a share, beside two samples: some programs state it rounded.
const SAME_LENGTH: f64 = 0.005;
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
        if let Some(key) = together(entry) {
            let span = Span {
                start_s: 0.0,
                end_s,
                slack_s: SLACK_S,
            };
            spans.insert(key, span);
        }
    }
    count
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

/// The channels against their table.
fn channels(tree: &Tree, (entry, origin): (&Entry, Origin), read: &EegFile, found: &mut Found) {
    let of = together(entry);
    let listed = tree.entries.iter().find(|other| {
        let is_list = other.parsed().is_some_and(|name| name.suffix == "channels");
        is_list && other.is_table() && together(other) == of
    });
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
    let mut missing: BTreeMap<&str, f64> = rates.clone();
    for row in 0..table.rows.len() {
        let line = row as u64 + 2;
        let Some(name) = cell(&table, row, "name").map(str::trim) else {
            continue;
        };
        let of_brain = cell(&table, row, "type").is_some_and(|kind| kind == "EEG");
        missing.remove(name);
        match rates.get(name) {
            // Channels of triggers are read as events.
            None if of_brain => {
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
    for name in missing.into_keys() {
        let why = format!(
            "expected a line for the channel {name}, which the file of samples has, found none; restore it"
        );
        found.add(ProblemKind::Columns, file, None, why);
    }
}
