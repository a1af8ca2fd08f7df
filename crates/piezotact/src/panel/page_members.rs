//! Which measurements are members of a panel and its averages, and which were asked for again, in the report.

use std::cmp::Ordering;
use std::fmt::Display;

use super::page_tables::table;
use super::{AnalysedPanel, FiledMeasurement, Member, MemberCriterion};
use crate::criterion::{Criterion, Limit, Outcome};
use crate::number::counted;
use crate::page::{Block, Cell, Table, limit_number, limit_text};
use crate::run::{Attempt, RunCriterion};

/// As many measurements are listed one by one; the others are folded.
const LISTED: usize = 12;

fn found<W>(criterion: &Criterion<W>) -> String {
    criterion.found.map_or_else(
        || "not measured".into(),
        |found| limit_number(found, &criterion.unit),
    )
}

/// Criteria in one cell of a table.
fn listed<'a, W: Display + 'a>(criteria: impl IntoIterator<Item = &'a Criterion<W>>) -> Cell {
    let all: Vec<String> = criteria
        .into_iter()
        .map(|criterion| {
            format!(
                "{}: {} ({}), {}",
                criterion.what,
                found(criterion),
                limit_text(criterion.limit, &criterion.unit),
                criterion.outcome.word()
            )
        })
        .collect();
    Cell::from(all.join("; "))
}

/// A table with its first rows shown and the others folded.
fn shortened(mut table: Table) -> Vec<Block> {
    let more = table.rows.split_off(table.rows.len().min(LISTED));
    let rest = Table {
        columns: table.columns.clone(),
        rows: more,
    };
    let mut blocks = vec![table.into()];
    if !rest.rows.is_empty() {
        let summary = format!("{} more", rest.rows.len());
        blocks.push(Block::folded(summary, [rest.into()]));
    }
    blocks
}

/// How far what was found lies towards not meeting the limit.
fn beyond<W>(criterion: &Criterion<W>) -> f64 {
    let found = criterion.found.unwrap_or(f64::NEG_INFINITY);
    match criterion.limit {
        Limit::AtMost { .. } => found,
        Limit::AtLeast { .. } => -found,
        Limit::Within { .. } => found.abs(),
    }
}

fn nearer<W>(a: &Criterion<W>, b: &Criterion<W>) -> Ordering {
    beyond(a).partial_cmp(&beyond(b)).unwrap_or(Ordering::Equal)
}

pub(super) fn blocks(panel: &AnalysedPanel<'_>) -> Vec<Block> {
    let said = panel.analysis;
    let open = |member: &&Member| member.outcome() != Outcome::Met;
    let reported: Vec<&Member> = said.members.iter().filter(open).collect();
    let mut blocks = vec![
        Block::text(format!(
            "{} in the averages, {} of them with all criteria met. A measurement that does not meet a criterion is refused. A \
             measurement with a criterion that is not decided is included, with a warning.",
            counted(said.members.len(), "measurement"),
            said.members.len() - reported.len()
        )),
        by_rule(&said.members).into(),
    ];
    if !reported.is_empty() {
        let rows = reported.iter().map(|member| {
            let criteria = member.criteria.iter();
            let open = criteria.filter(|criterion| criterion.outcome != Outcome::Met);
            [Cell::from(member.filing.to_string()), listed(open)]
        });
        let columns = [("measurement", "measurement"), ("not decided", "criteria")];
        blocks.push(Block::heading("Included with a criterion not decided"));
        blocks.extend(shortened(table(columns, rows)));
    }
    let partly = said.attendances.iter();
    let partly = partly.filter(|one| one.outcome() != Outcome::Met);
    let incomplete = table(
        [("participant", "participant"), ("criterion", "criteria")],
        partly.map(|one| [Cell::from(one.participant.as_str()), listed(&one.criteria)]),
    );
    if !incomplete.rows.is_empty() {
        blocks.extend([
            Block::heading(
                "Participants without every load and angle: left out of the comparisons concerned",
            ),
            incomplete.into(),
        ]);
    }
    if !panel.accepted.is_empty() {
        blocks.extend(while_measuring(&panel.accepted));
    }
    blocks
}

/// Every rule with its limit and the measurement that comes nearest to not meeting it.
fn by_rule(members: &[Member]) -> Table {
    let rules = members.first().map_or(&[][..], |member| &member.criteria);
    let columns = [
        ("criterion", "criterion"),
        ("limit", "limit"),
        ("met", "met"),
        ("not decided", "not_decided"),
        ("worst value", "worst_value"),
        ("measurement", "measurement"),
    ];
    let row = |rule: MemberCriterion| {
        let all: Vec<(&Member, &Criterion<MemberCriterion>)> = members
            .iter()
            .filter_map(|member| Some((member, member.criterion(rule)?)))
            .collect();
        let met = all
            .iter()
            .filter(|(_, c)| c.outcome == Outcome::Met)
            .count();
        let first = all.first()?.1.found;
        let (member, worst) = all.iter().max_by(|(_, a), (_, b)| nearer(a, b))?;
        let where_worst = match all.iter().all(|(_, c)| c.found == first) {
            true => "same for all".to_owned(),
            false => member.filing.to_string(),
        };
        Some([
            Cell::from(rule.to_string()),
            Cell::from(limit_text(worst.limit, &worst.unit)),
            Cell::rounded(met as f64, 0),
            Cell::rounded((all.len() - met) as f64, 0),
            Cell::from(found(worst)),
            Cell::from(where_worst),
        ])
    };
    table(columns, rules.iter().filter_map(|rule| row(rule.what)))
}

/// What was judged while measuring: every rule at its worst among the accepted, and what was asked for again.
fn while_measuring(entries: &[&FiledMeasurement]) -> Vec<Block> {
    let attempts = entries.iter().flat_map(|entry| {
        let own = entry.attempts.iter();
        own.map(move |attempt| (*entry, attempt))
    });
    let (refused, taken): (Vec<_>, Vec<_>) = attempts
        .partition(|(_, attempt): &(_, &Attempt)| attempt.judged.outcome() == Outcome::NotMet);
    let columns = [
        ("criterion", "criterion"),
        ("limit", "limit"),
        ("worst accepted window", "worst_accepted"),
        ("outcome", "outcome"),
        ("measurement", "measurement"),
    ];
    let row = |rule: RunCriterion| {
        let own = taken.iter().filter_map(|(entry, attempt)| {
            let mut criteria = attempt.judged.criteria.iter();
            Some((entry, criteria.find(|c| c.what == rule)?))
        });
        let (entry, own) = own.max_by(|(_, a), (_, b)| nearer(a, b))?;
        Some([
            Cell::from(rule.to_string()),
            Cell::from(limit_text(own.limit, &own.unit)),
            Cell::from(found(own)),
            Cell::from(own.outcome),
            Cell::from(entry.filing.to_string()),
        ])
    };
    let rules = [
        RunCriterion::Force,
        RunCriterion::Coherence,
        RunCriterion::Polarity,
    ];
    let mut blocks = vec![
        Block::heading("Checks during the measurement"),
        Block::text(format!(
            "{} were checked window by window while they ran; {} {} refused and repeated.",
            counted(entries.len(), "measurement"),
            counted(refused.len(), "attempt"),
            if refused.len() == 1 { "was" } else { "were" }
        )),
        table(columns, rules.into_iter().filter_map(row)).into(),
    ];
    if !refused.is_empty() {
        let columns = [
            ("measurement", "measurement"),
            ("attempt", "attempt"),
            ("from, s", "from_s"),
            ("to, s", "to_s"),
            ("criteria", "criteria"),
        ];
        let rows = refused.iter().map(|(entry, attempt)| {
            let [from_s, to_s] = attempt.judged.window_s;
            [
                Cell::from(entry.filing.to_string()),
                Cell::rounded(attempt.attempt as f64, 0),
                Cell::rounded(from_s, 0),
                Cell::rounded(to_s, 0),
                listed(&attempt.judged.criteria),
            ]
        });
        blocks.push(Block::heading("Refused attempts"));
        blocks.extend(shortened(table(columns, rows)));
    }
    blocks
}
