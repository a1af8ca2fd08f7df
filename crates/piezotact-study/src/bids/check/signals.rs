//! Continuous signals against their sidecars.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::ControlFlow;

use serde_json::{Map, Value};

use super::super::physio::{LineFault, SignalFault, each_row};
use super::super::tree::{Entry, Tree};
use super::{Found, LONGEST_SESSION_S, Origin, ProblemKind};

/// Sampling rates that are possible, in Hz.
const RATES_HZ: std::ops::RangeInclusive<f64> = 1e-3..=1e7;
/// In data sets of other programs a recording may end before the task does, by no more than its own length and this, in s.
const LATER_S: f64 = 3600.0;

/// When what was recorded begins and ends, in s.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    pub(super) start_s: f64,
    pub(super) end_s: f64,
    /// How far an event of another program may lie beyond it, in s.
    pub(super) slack_s: f64,
}

/// By the folder and the entities of what belongs together.
pub(super) type Spans = BTreeMap<(String, Vec<(String, String)>), Span>;

/// The key of what belongs together.
pub(super) fn together(entry: &Entry) -> Option<(String, Vec<(String, String)>)> {
    let of = entry.parsed()?.together().into_iter();
    let of = of.map(|(key, label)| (key.to_owned(), label.to_owned()));
    Some((entry.folder().to_owned(), of.collect()))
}

pub(super) fn check(tree: &Tree, origin: Origin, found: &mut Found) -> Spans {
    let mut spans = Spans::new();
    for entry in tree.entries.iter().filter(|entry| entry.is_signal()) {
        let file = &entry.file;
        let sidecar = match tree.sidecar(entry) {
            Ok(sidecar) => sidecar,
            // It is named with the sidecars.
            Err(_damaged) => continue,
        };
        let has_sidecar = !tree.sidecars(entry).is_empty();
        if !has_sidecar {
            let why = "expected a JSON file of the same name beside it, found none; restore it: without it nobody knows the rate and the columns";
            found.add(ProblemKind::Sidecar, file, None, why);
        }
        let rate_hz =
            number(&sidecar, "SamplingFrequency").filter(|rate_hz| RATES_HZ.contains(rate_hz));
        let start_s =
            number(&sidecar, "StartTime").filter(|start_s| start_s.abs() <= LONGEST_SESSION_S);
        let needed = [
            ("SamplingFrequency", " above 0 in Hz", rate_hz.is_some()),
            (
                "StartTime",
                " in s after the first trial",
                start_s.is_some(),
            ),
        ];
        for (key, which, _) in needed.iter().filter(|(.., is)| has_sidecar && !is) {
            let stated = sidecar
                .get(*key)
                .map_or("none".to_owned(), |value| format!("`{value}`"));
            let why = format!(
                "expected {key} in its JSON file, a number{which}, found {stated}; correct it"
            );
            found.add(ProblemKind::Metadata, file, None, why);
        }
        let names = columns((file, origin), &sidecar, found);
        let path = tree.path(file);
        let expected = match names.len() {
            0 => first_cells(&path),
            count => Some(count),
        };
        match each_row(&path, expected.unwrap_or(1), |_| ControlFlow::Continue(())) {
            Ok(Ok(rows)) => {
                if let (Some(rate_hz), Some(start_s), Some(key)) =
                    (rate_hz, start_s, together(entry))
                {
                    let end_s = start_s + rows as f64 / rate_hz;
                    let known = spans.entry(key).or_insert(Span {
                        start_s,
                        end_s,
                        slack_s: LATER_S + end_s - start_s,
                    });
                    known.start_s = known.start_s.min(start_s);
                    known.end_s = known.end_s.max(end_s);
                    if origin == Origin::Ours && end_s - start_s > LONGEST_SESSION_S {
                        let why = format!(
                            "expected a recording of less than a week, found {rows} samples at {rate_hz} Hz; correct SamplingFrequency"
                        );
                        found.add(ProblemKind::Metadata, file, None, why);
                    }
                }
            }
            Ok(Err(fault)) => {
                let (line, why) = fault.sentence(expected.unwrap_or(1));
                found.add(kind_of(&fault), file, line, why);
            }
            Err(error) => found.error(ProblemKind::File, file, error),
        }
    }
    spans
}

/// The names of the columns, as the sidecar has them.
fn columns<'a>(
    (file, origin): (&str, Origin),
    sidecar: &'a Map<String, Value>,
    found: &mut Found,
) -> Vec<&'a str> {
    let columns = sidecar.get("Columns").and_then(Value::as_array);
    let stated = columns.map_or(0, Vec::len);
    let names: Vec<&str> = columns
        .into_iter()
        .flatten()
        .filter_map(Value::as_str)
        .collect();
    if !sidecar.is_empty() && (stated == 0 || names.len() != stated) {
        let why = "expected Columns in its JSON file, a list of names, found none, or values that are none; complete it";
        found.add(ProblemKind::Metadata, file, None, why);
    }
    let mut known = BTreeSet::new();
    for name in &names {
        if !known.insert(name) {
            let why = format!("expected the column `{name}` once, found it twice; rename one");
            found.add(ProblemKind::Twice, file, None, why);
        } else if origin == Origin::Ours && !sidecar.contains_key(*name) {
            let why = format!(
                "expected a description of the column `{name}` in its JSON file, found none; add it with its unit"
            );
            found.add(ProblemKind::Metadata, file, None, why);
        }
    }
    names
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
fn first_cells(path: &std::path::Path) -> Option<usize> {
    match each_row(path, usize::MAX, |_| ControlFlow::Break(())) {
        Ok(Err(SignalFault::Line(1, LineFault::Cells(count)))) => Some(count),
        _ => None,
    }
}

fn number(of: &Map<String, Value>, key: &str) -> Option<f64> {
    of.get(key)?.as_f64()
}
