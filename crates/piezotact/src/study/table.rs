//! Tidy tables of a study: one row for each stroke, one column for each variable, units in the names.

use std::collections::BTreeSet;

use serde::Serialize;

use super::AnalysedRecording;
use crate::criterion::Criterion;
use crate::feature::STROKE_COLUMNS;
use crate::page::{Cell, Column, Table};
use crate::recording::SlidingDirection;
use crate::stroke::{Reason, StrokeCriterion};

/// The labels that a condition takes from a name.
const IN_CONDITION: [&str; 6] = ["sample", "participant", "load", "speed", "angle", "touch"];

/// The labels that recordings have beside what the columns of a condition say, in the order of their names.
fn labels(takes: &[AnalysedRecording]) -> BTreeSet<&str> {
    let all = takes.iter().flat_map(|take| &take.labels);
    // A direction in words is a condition; an angle is a label.
    let own = |(name, value): &(&String, &String)| match name.as_str() {
        "direction" => SlidingDirection::named(value).is_none(),
        name => !IN_CONDITION.contains(&name),
    };
    all.filter(own).map(|(name, _)| name.as_str()).collect()
}

/// The cells of a recording's labels, empty where it has none of that name.
fn label_cells<'a>(
    take: &'a AnalysedRecording,
    labels: &'a BTreeSet<&str>,
) -> impl Iterator<Item = Cell> + 'a {
    let cell = |name: &&str| text(take.labels.get(*name).cloned());
    labels.iter().map(cell)
}

fn label_names(labels: &BTreeSet<&str>) -> impl Iterator<Item = String> {
    labels.iter().map(|name| format!("label_{name}"))
}

fn text(value: Option<String>) -> Cell {
    value.map_or(Cell::Missing(()), Cell::Text)
}

/// A name as documents have it: `steady_part`.
fn code(what: &impl Serialize) -> String {
    let value = serde_json::to_value(what).unwrap_or_default();
    value.as_str().unwrap_or_default().to_owned()
}

fn table(names: Vec<String>) -> Table {
    Table::new(names.iter().map(|name| Column::new(name, name)))
}

/// The strokes and rejects of `takes`, one row for each, with times in s. Every criterion that was judged has the columns
/// `WHAT_found`, `WHAT_limit` (of the size, where it is a limit to both sides) and `WHAT_outcome`, empty where it was not judged.
///
/// Source: tidy data, H. Wickham (2014), J. Stat. Softw. 59(10).
#[must_use]
pub fn cuts_table(takes: &[AnalysedRecording]) -> Table {
    let labels = labels(takes);
    let mut judged: Vec<StrokeCriterion> = Vec::new();
    for take in takes {
        let of_strokes = take.segmentation.strokes.iter().flat_map(|s| &s.criteria);
        let of_rejects = take.segmentation.rejected.iter().flat_map(|r| &r.criteria);
        for criterion in of_strokes.chain(of_rejects) {
            if !judged.contains(&criterion.what) {
                judged.push(criterion.what);
            }
        }
    }
    let mut names: Vec<String> = CUTS_NAMES.map(str::to_owned).to_vec();
    names.extend(label_names(&labels));
    for what in &judged {
        let what = code(what);
        names.extend(["found", "limit", "outcome"].map(|of| format!("{what}_{of}")));
    }
    let criteria = |row: &mut Vec<Cell>, of: &[Criterion<StrokeCriterion>]| {
        for what in &judged {
            let criterion = of.iter().find(|criterion| criterion.what == *what);
            row.push(Cell::from(criterion.and_then(|c| c.found)));
            row.push(Cell::from(criterion.map(|c| c.limit.value())));
            row.push(text(criterion.map(|c| code(&c.outcome))));
        }
    };
    let mut table = table(names);
    for take in takes {
        let s = |sample: usize| Cell::from(take.seconds(sample));
        for stroke in &take.segmentation.strokes {
            let mut row = vec![
                Cell::from(take.name.as_str()),
                Cell::from("stroke"),
                s(stroke.steady.start),
                s(stroke.steady.end),
                s(stroke.contact.start),
                s(stroke.contact.end),
                Cell::from(code(&stroke.cut_by)),
                Cell::Missing(()),
            ];
            row.extend(label_cells(take, &labels));
            criteria(&mut row, &stroke.criteria);
            table.rows.push(row);
        }
        for rejected in &take.segmentation.rejected {
            let ends = || [s(rejected.interval.start), s(rejected.interval.end)];
            let mut row = vec![Cell::from(take.name.as_str()), Cell::from("rejected")];
            row.extend(ends().into_iter().chain(ends()));
            row.push(Cell::Missing(()));
            row.push(Cell::from(rejected.reason.to_string()));
            row.extend(label_cells(take, &labels));
            criteria(&mut row, &rejected.criteria);
            table.rows.push(row);
        }
    }
    table
}

const CUTS_NAMES: [&str; 8] = [
    "file",
    "kind",
    "start_s",
    "end_s",
    "contact_start_s",
    "contact_end_s",
    "cut_by",
    "reason",
];

/// What happened in the recording of `take`, one row for each stroke (its analysed part), rejected part and event that the recording
/// states (without what somebody typed), by their onsets in s after the first sample of the recording, of which the take's first sample is `from_s` later.
///
/// Source: BIDS 1.11, task events, for `onset`, `duration`, `trial_type` and `value`; docs/decisions/store.md for the others.
#[must_use]
pub fn events_table(take: &AnalysedRecording, from_s: f64) -> Table {
    let mut table = table(EVENT_NAMES.map(str::to_owned).to_vec());
    let s = |sample: usize| from_s + take.seconds(sample);
    let span = |from: usize, to: usize| [s(from), take.seconds(to.saturating_sub(from))];
    let mut rows: Vec<(f64, Vec<Cell>)> = Vec::new();
    for (i, stroke) in take.segmentation.strokes.iter().enumerate() {
        let [onset_s, lasts_s] = span(stroke.steady.start, stroke.steady.end);
        let contact_s = span(stroke.contact.start, stroke.contact.end);
        let mut row = vec![
            Cell::from(onset_s),
            Cell::from(lasts_s),
            Cell::from("stroke"),
            Cell::from((i + 1) as f64),
        ];
        row.extend(contact_s.map(Cell::from));
        row.extend([
            Cell::from(code(&stroke.cut_by)),
            Cell::Missing(()),
            Cell::Missing(()),
        ]);
        rows.push((onset_s, row));
    }
    let others = |kind: &str| {
        let mut row = vec![Cell::from(kind)];
        row.resize(EVENT_NAMES.len() - 2, Cell::Missing(()));
        row
    };
    for rejected in &take.segmentation.rejected {
        let [onset_s, lasts_s] = span(rejected.interval.start, rejected.interval.end);
        let mut row = vec![Cell::from(onset_s), Cell::from(lasts_s)];
        row.extend(others("rejected"));
        row[EVENT_NAMES.len() - 2] = match &rejected.reason {
            // What a person typed may say who somebody is.
            Reason::ByPerson { .. } => Cell::from("excluded by hand"),
            other => Cell::from(other.to_string()),
        };
        rows.push((onset_s, row));
    }
    for event in &take.recording.annotations.events {
        let onset_s = from_s + event.onset_s.0;
        let mut row = vec![Cell::from(onset_s), Cell::from(event.duration_s.0)];
        row.extend(others(&event.kind));
        let value = event.value.as_ref();
        row[EVENT_NAMES.len() - 1] = text(value.map(ToString::to_string));
        rows.push((onset_s, row));
    }
    rows.sort_by(|(one, _), (other, _)| one.total_cmp(other));
    table.rows = rows.into_iter().map(|(_, row)| row).collect();
    table
}

/// The columns of [`events_table`].
pub const EVENT_NAMES: [&str; 9] = [
    "onset",
    "duration",
    "trial_type",
    "stroke",
    "contact_onset",
    "contact_duration",
    "cut_by",
    "reason",
    "value",
];

/// The features of every stroke of `takes`, one row for each, in SI units; an empty cell for what was not measured.
///
/// Source: tidy data, H. Wickham (2014), J. Stat. Softw. 59(10).
#[must_use]
pub fn strokes_table(takes: &[AnalysedRecording]) -> Table {
    let labels = labels(takes);
    let mut names = stroke_names();
    names.extend(label_names(&labels));
    let mut table = table(names);
    for take in takes {
        let Some(analysis) = &take.analysis else {
            continue;
        };
        let condition = take.condition();
        for (i, stroke) in analysis.strokes.iter().enumerate() {
            let mut row = vec![
                Cell::from(take.name.as_str()),
                text(condition.sample.clone()),
                text(condition.participant.clone()),
                text(condition.touch.map(|touch| code(&touch))),
                text(condition.direction.map(|direction| direction.to_string())),
                Cell::from(condition.load_n.map(|load| load.0)),
                Cell::from(condition.speed_m_s),
                Cell::from((i + 1) as f64),
                Cell::from(stroke.start_s),
                Cell::from(stroke.duration_s),
                Cell::from(analysis.unit.symbol()),
            ];
            row.extend(
                STROKE_COLUMNS
                    .iter()
                    .map(|column| Cell::from((column.value)(stroke))),
            );
            row.extend(label_cells(take, &labels));
            table.rows.push(row);
        }
    }
    table
}

fn stroke_names() -> Vec<String> {
    let mut names: Vec<String> = [
        "file",
        "sample",
        "participant",
        "touch",
        "direction",
        "load_n",
        "stated_speed_m_s",
        "stroke",
        "start_s",
        "duration_s",
        "unit",
    ]
    .map(str::to_owned)
    .to_vec();
    names.extend(STROKE_COLUMNS.iter().map(|column| column.name.to_owned()));
    names
}
