//! The report on cuts: where strokes lie, and what was rejected.

use super::{ended, person, signals, signs};
use crate::criterion::Criterion;
use crate::document::FailedFile;
use crate::number::counted;
use crate::page::{Block, Cell, Column, Page, Table, limit_number, limit_text};
use crate::stroke::StrokeCriterion;
use crate::study::{AnalysedRecording, cuts_table, warnings_of};

/// Recordings whose signals are shown.
const SHOWN: usize = 12;

/// The signals with their strokes and rejects.
pub(super) fn page(takes: &[AnalysedRecording], failed: &[FailedFile]) -> Page {
    let concluded = takes.iter().map(|take| {
        let segmentation = &take.segmentation;
        let file = person(take).map_or(String::new(), |text| format!("; with the cuts in {text}"));
        Block::conclusion(
            format!(
                "{}: {}, {} rejected{file}",
                take.name,
                counted(segmentation.strokes.len(), "stroke"),
                segmentation.rejected.len(),
            ),
            None,
        )
    });
    let rejected: Vec<Block> = rejected(takes).into_iter().collect();
    let warnings = warnings_of(takes, &[]);
    let page = Page::new("Strokes", counted(takes.len(), "recording"))
        .rows(cuts_table(takes))
        .section("", concluded.chain([Block::numbers(signs(takes))]))
        .section("Signals and cuts", signals(takes, SHOWN))
        .section("Strokes and rejected parts", [Block::from(parts(takes))]);
    let page = match rejected.is_empty() {
        true => page,
        false => page.section("Criteria of the rejected parts", rejected),
    };
    let page = page.section("Warnings", [Block::warnings("", warnings)]);
    ended(page, takes, failed)
}

fn seconds(take: &AnalysedRecording, sample: usize) -> Cell {
    Cell::rounded(take.seconds(sample), 3)
}

/// Where strokes and rejected parts lie, in the order of time.
fn parts(takes: &[AnalysedRecording]) -> Table {
    let mut table = Table::new([
        Column::new("recording", "file"),
        Column::new("part", "kind"),
        Column::new("from, s", "start_s"),
        Column::new("to, s", "end_s"),
        Column::new("duration, s", "duration_s"),
        Column::new("reason", "reason"),
    ]);
    for take in takes {
        let segmentation = &take.segmentation;
        let strokes = segmentation.strokes.iter();
        let strokes = strokes.map(|stroke| (stroke.steady, "stroke", String::new()));
        let rejected = segmentation.rejected.iter();
        let rejected = rejected.map(|part| (part.interval, "rejected", part.reason.to_string()));
        let mut parts: Vec<_> = strokes.chain(rejected).collect();
        parts.sort_by_key(|(interval, _, _)| interval.start);
        table
            .rows
            .extend(parts.into_iter().map(|(interval, kind, reason)| {
                vec![
                    Cell::from(take.name.as_str()),
                    Cell::from(kind),
                    seconds(take, interval.start),
                    seconds(take, interval.end),
                    seconds(take, interval.len()),
                    Cell::from(reason),
                ]
            }));
    }
    table
}

/// The rejected parts with their criteria; `None` without any.
pub(super) fn rejected(takes: &[AnalysedRecording]) -> Option<Block> {
    let mut table = Table::new([
        Column::new("recording", "file"),
        Column::new("from, s", "start_s"),
        Column::new("to, s", "end_s"),
        Column::new("reason", "reason"),
        Column::new("criteria", "criteria"),
    ]);
    for take in takes {
        table
            .rows
            .extend(take.segmentation.rejected.iter().map(|part| {
                let criteria = part.criteria.iter().map(criterion);
                vec![
                    Cell::from(take.name.as_str()),
                    seconds(take, part.interval.start),
                    seconds(take, part.interval.end),
                    Cell::from(part.reason.to_string()),
                    Cell::from(criteria.collect::<Vec<_>>().join("; ")),
                ]
            }));
    }
    let summary = format!(
        "{} with their criteria",
        counted(table.rows.len(), "rejected part")
    );
    let is_empty = table.rows.is_empty();
    (!is_empty).then(|| Block::folded(summary, [Block::from(table)]))
}

fn criterion(criterion: &Criterion<StrokeCriterion>) -> String {
    let unit = &criterion.unit;
    let found = criterion
        .found
        .map_or("not measured".into(), |found| limit_number(found, unit));
    format!(
        "{}: {found} ({}), {}",
        criterion.what,
        limit_text(criterion.limit, unit),
        criterion.outcome.word()
    )
}
