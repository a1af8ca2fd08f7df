//! Continuous signals against their sidecars.

use std::collections::BTreeMap;

use serde_json::{Map, Value};

use super::super::error::BidsError;
use super::super::physio::{LineFault, SignalFault, each_row};
use super::super::tree::{Entry, Tree};
use super::{Found, ProblemKind};

/// When what was recorded ends, in s, by the folder and the entities of what belongs together.
pub(super) type Ends = BTreeMap<(String, Vec<(String, String)>), f64>;

/// The key of what belongs together.
pub(super) fn together(entry: &Entry) -> Option<(String, Vec<(String, String)>)> {
    let of = entry.parsed()?.together().into_iter();
    let of = of.map(|(key, label)| (key.to_owned(), label.to_owned()));
    Some((entry.folder().to_owned(), of.collect()))
}

pub(super) fn check(tree: &Tree, found: &mut Found) -> Result<Ends, BidsError> {
    let mut ends = Ends::new();
    for entry in tree.entries.iter().filter(|entry| entry.is_signal()) {
        let file = &entry.file;
        let sidecar = match tree.sidecar(entry) {
            Ok(sidecar) => sidecar,
            // It is named with the sidecars.
            Err(_damaged) => continue,
        };
        if tree.sidecars(entry).is_empty() {
            let why = "expected a JSON file of the same name beside it, found none; restore it: without it nobody knows the rate and the columns";
            found.add(ProblemKind::Sidecar, file, None, why);
        }
        let rate_hz = number(&sidecar, "SamplingFrequency").filter(|rate_hz| *rate_hz > 0.0);
        let start_s = number(&sidecar, "StartTime");
        let has_sidecar = !tree.sidecars(entry).is_empty();
        for (key, is_there) in [
            ("SamplingFrequency", rate_hz.is_some()),
            ("StartTime", start_s.is_some()),
        ] {
            if has_sidecar && !is_there {
                let stated = sidecar
                    .get(key)
                    .map_or("none".to_owned(), |value| format!("`{value}`"));
                let why = format!(
                    "expected {key} in its JSON file, a number{}, found {stated}; complete it",
                    if key == "StartTime" { "" } else { " above 0" }
                );
                found.add(ProblemKind::Metadata, file, None, why);
            }
        }
        let columns = sidecar.get("Columns").and_then(Value::as_array);
        if has_sidecar && columns.is_none_or(Vec::is_empty) {
            let why = "expected Columns in its JSON file, a list of names, found none; complete it";
            found.add(ProblemKind::Metadata, file, None, why);
        }
        let names: Vec<&str> = columns
            .into_iter()
            .flatten()
            .filter_map(Value::as_str)
            .collect();
        for name in &names {
            if !sidecar.contains_key(*name) {
                let why = format!(
                    "expected a description of the column `{name}` in its JSON file, found none; add it with its unit"
                );
                found.add(ProblemKind::Metadata, file, None, why);
            }
        }
        let path = tree.path(file);
        let expected = match names.len() {
            0 => first_cells(&path)?,
            count => Some(count),
        };
        match each_row(&path, expected.unwrap_or(1), |_| ())? {
            Ok(rows) => {
                if let (Some(rate_hz), Some(start_s), Some(key)) =
                    (rate_hz, start_s, together(entry))
                {
                    let end_s = start_s + rows as f64 / rate_hz;
                    let known = ends.entry(key).or_insert(end_s);
                    *known = known.max(end_s);
                }
            }
            Err(fault) => {
                let (line, why) = fault.sentence(expected.unwrap_or(1));
                found.add(kind_of(&fault), file, line, why);
            }
        }
    }
    Ok(ends)
}

fn kind_of(fault: &SignalFault) -> ProblemKind {
    match fault {
        SignalFault::Empty => ProblemKind::Empty,
        SignalFault::Damaged(_) => ProblemKind::Compression,
        SignalFault::Line(1, LineFault::Cells(_)) => ProblemKind::Columns,
        SignalFault::Line(_, LineFault::Cells(_)) => ProblemKind::Ragged,
        SignalFault::Line(_, LineFault::Text(..) | LineFault::Bytes(_)) => ProblemKind::Number,
    }
}

/// How many cells the first line has, where nothing states it.
fn first_cells(path: &std::path::Path) -> Result<Option<usize>, BidsError> {
    match each_row(path, usize::MAX, |_| ())? {
        Err(SignalFault::Line(1, LineFault::Cells(count))) => Ok(Some(count)),
        _ => Ok(None),
    }
}

fn number(of: &Map<String, Value>, key: &str) -> Option<f64> {
    of.get(key)?.as_f64()
}
