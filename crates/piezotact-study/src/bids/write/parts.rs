//! The columns and files of one recording, and the meanings of columns.

use std::collections::BTreeMap;
use std::path::Path;

use piezotact::page::{Cell, Table};
use piezotact::quantity::Unit;
use piezotact::recording::{BenchKind, Channel, Clock};
use piezotact_people::campaign::dictionary::ColumnMeaning;
use serde_json::Value;

use super::super::error::BidsError;
use super::super::json::{ColumnSidecar, Columns, unit_text};
use super::super::name::RECORDING_FIV;
use super::super::physio::number_in;
use super::super::privacy::carried;
use super::recordings::Touched;
use piezotact_dataset::ReadError;
use piezotact_dataset::read_input;

/// The label of recordings of the drive.
pub(super) const DRIVE: &str = "drive";

/// A clock with its number among those of the same label, from 1.
pub(super) type NumberedClock = (Clock, u32);

/// The channels of `recording` that stand in one file, by their places: those of one clock, drives apart; with the label of each.
///
/// A signal in shares of full scale is the drive where one of our benches recorded it; in a file of another program it is a sensor
/// of unknown scale.
pub(super) fn groups(touched: &Touched<'_>) -> Vec<(&'static str, NumberedClock, Vec<usize>)> {
    let recording = touched.recording;
    let mut groups: Vec<(bool, usize, Vec<usize>)> = Vec::new();
    let clocks = recording.clock_numbers().iter();
    for (at, (channel, clock)) in recording.channels().iter().zip(clocks).enumerate() {
        let is_drive = channel.unit == Unit::FullScale && is_of_a_bench(touched);
        let known = groups
            .iter_mut()
            .find(|(drive, of, _)| (*drive, of) == (is_drive, clock));
        match known {
            Some((_, _, members)) => members.push(at),
            None => groups.push((is_drive, *clock, vec![at])),
        }
    }
    let mut counts: BTreeMap<&str, u32> = BTreeMap::new();
    let labelled = groups.into_iter().map(|(is_drive, clock, members)| {
        let label = if is_drive { DRIVE } else { RECORDING_FIV };
        let count = counts.entry(label).or_default();
        *count += 1;
        (label, (recording.clocks()[clock], *count), members)
    });
    labelled.collect()
}

pub(super) fn suffix_number(count: &u32) -> String {
    match count {
        1 => String::new(),
        more => more.to_string(),
    }
}

/// The names of the columns: those of the channels without signs that a table cannot hold, each once.
pub(super) fn column_names(own: &[String]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for name in own {
        let plain: String = name
            .chars()
            .map(|sign| {
                if sign.is_ascii_alphanumeric() {
                    sign
                } else {
                    '_'
                }
            })
            .collect();
        names.push(once_more(plain, '_', &names));
    }
    names
}

/// `name`, or `channel` where it is empty; with a number where it is one of `names`.
fn once_more(name: String, before_number: char, names: &[String]) -> String {
    let plain = match name.is_empty() {
        true => "channel".to_owned(),
        false => name,
    };
    let mut name = plain.clone();
    let mut count = 1;
    while names.contains(&name) {
        count += 1;
        name = format!("{plain}{before_number}{count}");
    }
    name
}

pub(super) fn sidecars(meanings: &BTreeMap<String, ColumnMeaning>) -> Columns {
    let all = meanings.iter();
    all.map(|(name, meaning)| (name.clone(), ColumnSidecar::from(meaning.clone())))
        .collect()
}

/// The names of channels as they may be carried: of one with a date the words without digits, which say what was measured.
pub(super) fn names_carried(channels: &[&Channel]) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    for channel in channels {
        let name = carried(&channel.name)
            .unwrap_or_else(|| once_more(words_of(&channel.name), ' ', &names));
        names.push(name);
    }
    names
}

/// The words of `text` without digits, dates and addresses.
fn words_of(text: &str) -> String {
    let words = text.split(|sign: char| !sign.is_alphanumeric() && sign != '@' && sign != '.');
    let words = words.filter(|word| {
        let is_number = word.chars().any(|sign| sign.is_ascii_digit());
        !word.is_empty() && !is_number && !word.contains(['@', '.'])
    });
    words.collect::<Vec<_>>().join(" ")
}

/// Whether the recording is of one of our benches; notes in files of other programs were typed by somebody.
pub(super) fn is_of_a_bench(touched: &Touched<'_>) -> bool {
    touched.recording.about.provenance.bench.is_some()
}

/// The events of a recording as they may be carried: texts without folders, dates and addresses, and no kinds and values that
/// somebody typed.
pub(super) fn events_carried(events: &Table, touched: &Touched<'_>) -> Table {
    let mut events = events.clone();
    let bench = touched.recording.about.provenance.bench;
    for row in &mut events.rows {
        for (cell, column) in row.iter_mut().zip(&events.columns) {
            let Cell::Text(text) = &*cell else { continue };
            let kept = match column.name.as_str() {
                "trial_type" => Some(kind_carried(text, bench)),
                "value" if bench.is_none() => carried(text).filter(|text| match number_in(text) {
                    Some(number) => is_no_date(number) && !text.starts_with("00"),
                    // A word is an answer that somebody typed.
                    None => text.split(['/', ',']).all(|part| is_code(part.trim())),
                }),
                _ => carried(text),
            };
            *cell = kept.map_or(Cell::Missing(()), Cell::from);
        }
    }
    events
}

/// Kinds of markers that amplifiers and other programs write.
const KINDS: [&str; 15] = [
    "Stimulus",
    "Response",
    "Trigger",
    "Event",
    "Comment",
    "Sync Status",
    "SyncStatus",
    "Sync On",
    "Status",
    "Bad",
    "Bad Interval",
    "Time 0",
    "BAD boundary",
    "EDGE boundary",
    "BAD_ACQ_SKIP",
];
/// A stretch that MNE leaves out has a name that begins so, in capital or small letters.
const BAD: &str = "BAD";

/// The kind of an event as it may be carried: words of amplifiers and codes of any file, all of our own benches. Of others a stretch of bad
/// data stays one, and the rest is `event`.
pub(super) fn kind_carried(kind: &str, bench: Option<BenchKind>) -> String {
    let kept = carried(kind).filter(|kind| bench.is_some() || is_marker(kind));
    let is_bad = || {
        let begins = kind.get(..BAD.len());
        begins.is_some_and(|begins| begins.eq_ignore_ascii_case(BAD))
    };
    let other = || if is_bad() { BAD } else { "event" };
    kept.unwrap_or_else(|| other().to_owned())
}

/// Whether `text` is a marker: words of amplifiers and codes, joined by `/` or `,`, as in `control/M3`.
pub(super) fn is_marker(text: &str) -> bool {
    let mut parts = text.split(['/', ',']);
    parts.all(|part| {
        let part = part.trim();
        let is_bad = part.strip_prefix("BAD_").is_some_and(is_word);
        KINDS.contains(&part) || is_word(part) || is_bad || is_code(part)
    })
}

/// One word in small letters.
fn is_word(text: &str) -> bool {
    let is_small = |byte: u8| byte.is_ascii_lowercase() || byte == b'_';
    text.len() <= 16 && text.bytes().all(is_small)
}

/// Up to three letters and five digits, such as `S  1`.
fn is_code(text: &str) -> bool {
    let digits = text.trim_start_matches(|sign: char| sign.is_ascii_alphabetic());
    let letters = text.len() - digits.len();
    let digits = digits.trim_start();
    letters <= 3 && digits.len() <= 5 && digits.bytes().all(|byte| byte.is_ascii_digit())
}

/// Whether a number may be carried: a whole one with more digits than a code of a marker may be a date or a number of a telephone.
pub(super) fn is_no_date(number: f64) -> bool {
    number.fract() != 0.0 || number.abs() < 1e6
}

/// The unit as it may be carried.
pub(super) fn unit_carried(unit: &Unit) -> Unit {
    match unit {
        Unit::Other(_) => Unit::Other(unit_text(unit)),
        known => known.clone(),
    }
}

/// `value` with its texts as they may be carried.
pub(super) fn texts_carried(value: &Value) -> Value {
    match value {
        Value::String(text) => carried(text).map_or(Value::Null, Value::String),
        Value::Array(all) => all.iter().map(texts_carried).collect(),
        Value::Object(all) => {
            let all = all.iter();
            all.map(|(key, value)| (key.clone(), texts_carried(value)))
                .collect()
        }
        other => other.clone(),
    }
}

/// Parts of a WAV file in which programs note who made it, where and when.
const NOTES: [&[u8; 4]; 5] = [b"LIST", b"bext", b"iXML", b"id3 ", b"ID3 "];

/// Refuses a drive in whose file somebody noted something: it is copied as it is, as its checksum is that of the playing.
pub(super) fn require_no_notes(file: &Path) -> Result<(), BidsError> {
    let bytes = read_input(file)?;
    let mut at = 12;
    while let Some(head) = bytes.get(at..at + 8) {
        let (id, length) = head.split_at(4);
        if NOTES.iter().any(|note| id == *note) {
            return Err(BidsError::Read(ReadError::content(
                file,
                "a WAV file without notes, which is copied as it is",
                format!("the part `{}`", String::from_utf8_lossy(id)),
                "a drive of this program has none: prepare it again",
            )));
        }
        let length = length
            .iter()
            .rev()
            .fold(0, |sum, byte| sum << 8 | usize::from(*byte));
        at += 8 + length + length % 2;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Conditions of a study, codes of amplifiers and stretches of bad data stay; what somebody typed does not, and a bad stretch stays bad.
    #[test]
    fn markers_stay_and_names_of_people_do_not() {
        for kind in [
            "control/M3",
            "Stimulus/S  2",
            "M8/rough",
            "control/BIO",
            "Bad Interval,Bad",
            "BAD boundary",
            "BAD_blink",
            "R128",
            "stroke",
        ] {
            assert_eq!(kind_carried(kind, None), kind);
        }
        for (kind, kept) in [
            ("Dupont", "event"),
            ("control/Dupont", "event"),
            ("Mme Dupont touches", "event"),
            ("BAD Dupont moved", "BAD"),
            ("bad_Dupont", "BAD"),
            ("20240301", "event"),
            ("0612345678", "event"),
        ] {
            assert_eq!(kind_carried(kind, None), kept);
        }
        assert_eq!(
            kind_carried("Mme Dupont", Some(BenchKind::Twin)),
            "Mme Dupont"
        );
        let numbers = [2.0, 65_535.0, 1_234_567.25].map(is_no_date);
        assert_eq!(numbers, [true; 3]);
        assert_eq!([19_610_514.0, 612_345_678.0].map(is_no_date), [false; 2]);
    }
}
