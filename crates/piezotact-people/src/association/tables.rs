//! Answers and trials as tidy tables.

use piezotact::criterion::Outcome;
use piezotact::page::{Cell, Column, Table};

use super::answer::{Answer, Declared, Purpose};
use crate::campaign::dictionary::ANSWER_COLUMNS;
use crate::campaign::session::{Answer as Noted, Evidence, State, TrialState};
use crate::campaign::store;
use crate::campaign::text::cell;

/// `answers` to what is `declared` as a table with a row for each, in the columns that are read as answers again.
///
/// Source: docs/decisions/answers.md.
#[must_use]
pub fn answers_table(declared: &Declared, answers: &[Answer]) -> Table {
    let mut table = table(&ANSWER_COLUMNS);
    for answer in answers {
        let stimulus = declared
            .stimuli
            .iter()
            .find(|stimulus| stimulus.name == answer.presented && !stimulus.is_plain());
        let of_stimulus = |part: fn(&super::Stimulus) -> &str| stimulus.map_or("", part);
        let flags: Vec<&str> = answer.flags.iter().map(|flag| flag.word()).collect();
        let position = answer.position.map_or(String::new(), |at| at.to_string());
        table.rows.push(vec![
            Cell::from(answer.participant.as_str()),
            Cell::from(answer.session.as_str()),
            Cell::from(answer.task.as_str()),
            Cell::from(answer.set.as_str()),
            Cell::from(answer.trial.as_str()),
            Cell::from(position),
            Cell::from(answer.presented.as_str()),
            Cell::from(of_stimulus(|stimulus| &stimulus.source)),
            Cell::from(of_stimulus(|stimulus| &stimulus.expected)),
            Cell::from(answer.offered.join("|")),
            Cell::from(answer.answered.as_str()),
            Cell::from(flags.join(" ")),
            Cell::from(match answer.purpose {
                Purpose::Trial => "no",
                Purpose::Rehearsal => "yes",
            }),
            Cell::from(answer.judge.as_deref().unwrap_or("")),
        ]);
    }
    table
}

pub(super) fn table(names: &[&str]) -> Table {
    Table::new(names.iter().map(|&name| Column::new(name, name)))
}

/// The columns of the table of trials.
pub(super) const OF_TRIALS: [&str; 24] = [
    "participant",
    "session",
    "number",
    "trial",
    "task",
    "set",
    "kind",
    "planned",
    "presented",
    "answer",
    "first_answer",
    "confirmed_answer",
    "revisions",
    "corrected_because",
    "plays",
    "attempts",
    "interrupted",
    "voided",
    "missed_target",
    "presented_ms",
    "confirmed_ms",
    "seconds",
    "rehearsal",
    "judge",
];

/// How a virtual volunteer judges; empty for a person.
fn judge(state: &State<'_>) -> &'static str {
    state.participant().judge.map_or("", |judge| judge.name())
}

/// Every trial of the sessions `states`, answered or not, with a row for each: what was planned and presented, the answer that counts
/// and the first one, the one that was confirmed,
/// revisions, corrections, plays, attempts, when it was presented and confirmed in ms since 1970-01-01 00:00 UTC, and the time between in s.
///
/// Source: docs/decisions/answers.md.
#[must_use]
pub fn trials_table<'a>(
    states: impl IntoIterator<Item = (&'a State<'a>, store::Purpose)>,
) -> Table {
    let mut table = table(&OF_TRIALS);
    for (state, purpose) in states {
        for (i, (trial, of)) in state.trials().enumerate() {
            let last = of.answers.len().saturating_sub(1);
            let as_given = |answer, index| noted(answer, &|_| state.names_as_given(trial, index));
            let planned = trial.presented.names().join("|");
            let presented = match of.plays.is_empty() {
                true => String::new(),
                false => state.presented(trial).join("|"),
            };
            let plays: Vec<String> = of.felt.iter().map(u32::to_string).collect();
            let why = state.corrected_because(trial).unwrap_or_default();
            let time = |ms: Option<i64>| ms.map_or(String::new(), |ms| ms.to_string());
            let seconds = of.seconds().map_or(String::new(), |s| format!("{s:.3}"));
            table.rows.push(vec![
                Cell::from(state.plan().participant.as_str()),
                Cell::from(state.plan().session.as_str()),
                Cell::from((i + 1).to_string()),
                Cell::from(trial.name.as_str()),
                Cell::from(trial.task.as_str()),
                Cell::from(trial.set.as_deref().unwrap_or("")),
                Cell::from(trial.kind.word()),
                Cell::from(planned),
                Cell::from(presented),
                Cell::from(noted(of.answer(), &|one| state.names(trial, one))),
                Cell::from(as_given(of.answers.first(), 0)),
                Cell::from(as_given(of.as_confirmed(), last)),
                Cell::from(of.answers.len().saturating_sub(1).to_string()),
                Cell::from(cell(&why).into_owned()),
                Cell::from(plays.join("|")),
                Cell::from(of.attempts.to_string()),
                Cell::from(of.interrupted.to_string()),
                Cell::from(of.voided.to_string()),
                Cell::from(missed_target(of)),
                Cell::from(time(of.at_ms[0])),
                Cell::from(time(of.at_ms[1])),
                Cell::from(seconds),
                Cell::from(word_of(purpose)),
                Cell::from(judge(state)),
            ]);
        }
    }
    table
}

/// What stands in tables for a trial that asks for no answer, such as one to learn the textures.
pub const DONE: &str = "done";

/// An answer as it stands in a table; `names` are those that it stands for.
pub(super) fn noted(answer: Option<&Noted>, names: &dyn Fn(&Noted) -> Vec<String>) -> String {
    match answer {
        None => String::new(),
        Some(answer @ (Noted::Names(_) | Noted::Places(_))) => names(answer).join("|"),
        Some(Noted::Number(number)) => number.to_string(),
        Some(Noted::Done) => DONE.to_owned(),
        Some(Noted::Unknown) => "n/a".to_owned(),
    }
}

/// The criteria that a playing did not meet, with | between.
pub(super) fn criteria_not_met(one: &Evidence) -> String {
    let not_met = one.criteria.iter();
    let not_met = not_met.filter(|(_, outcome)| **outcome == Outcome::NotMet);
    let not_met: Vec<&str> = not_met.map(|(name, _)| name.as_str()).collect();
    not_met.join("|")
}

/// Whether a playing of a trial missed its target: `yes`, `no`, or `not decided` of one and `yes` of none.
pub(super) fn missed_target(of: &TrialState) -> &'static str {
    let all = || of.evidence.iter().map(|(_, one)| one);
    match (all().any(Evidence::missed), all().any(Evidence::is_open)) {
        (true, _) => "yes",
        (false, true) => "not decided",
        (false, false) => "no",
    }
}

fn word_of(purpose: store::Purpose) -> &'static str {
    match purpose {
        store::Purpose::Rehearsal => "yes",
        store::Purpose::Volunteer => "no",
    }
}

/// The columns of the table of evidence.
pub(super) const OF_EVIDENCE: [&str; 19] = [
    "participant",
    "session",
    "trial",
    "element",
    "stimulus",
    "drive_sha256",
    "gain",
    "verified",
    "reached",
    "criteria_not_met",
    "score_jnd",
    "level_re_target_db",
    "rendered_at_db",
    "normal_force_n",
    "onset_s",
    "onset_uncertainty_s",
    "strokes",
    "journal",
    "judge",
];

/// What was measured at every playing of the sessions `states`, with a row for each.
///
/// Source: docs/decisions/answers.md.
#[must_use]
pub fn evidence_table<'a>(states: impl IntoIterator<Item = &'a State<'a>>) -> Table {
    let mut table = table(&OF_EVIDENCE);
    let number = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
    for state in states {
        for (trial, of) in state.trials() {
            for (element, one) in &of.evidence {
                table.rows.push(vec![
                    Cell::from(state.plan().participant.as_str()),
                    Cell::from(state.plan().session.as_str()),
                    Cell::from(trial.name.as_str()),
                    Cell::from((element + 1).to_string()),
                    Cell::from(one.stimulus.as_str()),
                    Cell::from(one.drive.to_string()),
                    Cell::from(cell(one.gain.as_deref().unwrap_or("")).into_owned()),
                    Cell::from(one.verified.word()),
                    Cell::from(one.reached.word()),
                    Cell::from(criteria_not_met(one)),
                    Cell::from(number(one.score_jnd)),
                    Cell::from(number(one.level_re_target_db)),
                    Cell::from(number(one.rendered_at_db)),
                    Cell::from(number(one.normal_force_n)),
                    Cell::from(number(one.onset_s)),
                    Cell::from(number(one.onset_uncertainty_s)),
                    Cell::from(one.strokes.to_string()),
                    Cell::from(one.journal.as_deref().unwrap_or("")),
                    Cell::from(judge(state)),
                ]);
            }
        }
    }
    table
}

/// Who took part, with a row for each session: sex, age, handedness, finger, language, as stated.
///
/// Source: thesis 2.6, the description of panels.
#[must_use]
pub fn participants_table<'a>(
    states: impl IntoIterator<Item = (&'a State<'a>, store::Purpose)>,
) -> Table {
    let mut table = table(&[
        "participant",
        "session",
        "sex",
        "age_years",
        "handedness",
        "finger",
        "language",
        "confirmed",
        "planned",
        "rehearsal",
        "judge",
    ]);
    for (state, purpose) in states {
        let who = state.participant();
        // An adaptive run that has ended needs no more of its trials.
        let planned: usize = state.progress().values().map(|(_, planned)| planned).sum();
        let text =
            |text: &Option<String>| Cell::from(cell(text.as_deref().unwrap_or("")).into_owned());
        table.rows.push(vec![
            Cell::from(state.plan().participant.as_str()),
            Cell::from(state.plan().session.as_str()),
            text(&who.sex),
            Cell::from(who.age_years.map_or(String::new(), |age| age.to_string())),
            text(&who.handedness),
            text(&who.finger),
            text(&who.language),
            Cell::from(state.confirmed().to_string()),
            Cell::from(planned.to_string()),
            Cell::from(word_of(purpose)),
            Cell::from(who.judge.map_or("", |judge| judge.name())),
        ]);
    }
    table
}

/// The columns of [`thresholds_table`].
pub const THRESHOLD_COLUMNS: [&str; 14] = [
    "participant",
    "session",
    "task",
    "run",
    "threshold",
    "interval_low",
    "interval_high",
    "posterior_sd",
    "reversals_sd",
    "answers",
    "missed_target",
    "decided",
    "not_decided_because",
    "catch_trials_failed",
];

/// The thresholds of the adaptive comparisons of `state`, with a row for each run, in the unit of its levels.
///
/// Source: docs/decisions/answers.md.
#[must_use]
pub fn thresholds_table(state: &State<'_>) -> Table {
    let mut table = table(&THRESHOLD_COLUMNS);
    let catches = state.catches();
    for task in &state.protocol().tasks {
        let catch = catches.iter().find(|one| one.task == task.name);
        let catch = catch.map_or(String::new(), |one| {
            format!("{} of {}", one.failed, one.answered)
        });
        for threshold in state.thresholds(&task.name) {
            let estimate = &threshold.estimate;
            let number = |value: Option<f64>| value.map_or(String::new(), |v| format!("{v:.3}"));
            let open = estimate.criteria.iter();
            let open = open.filter(|one| one.outcome != Outcome::Met);
            let open: Vec<String> = open.map(|one| one.what.to_string()).collect();
            table.rows.push(vec![
                Cell::from(state.plan().participant.as_str()),
                Cell::from(state.plan().session.as_str()),
                Cell::from(task.name.as_str()),
                Cell::from(threshold.run),
                Cell::from(number(estimate.level)),
                Cell::from(number(estimate.interval.map(|[low, _]| low))),
                Cell::from(number(estimate.interval.map(|[_, high]| high))),
                Cell::from(number(estimate.posterior_sd)),
                Cell::from(number(estimate.reversals_sd)),
                Cell::from(estimate.answers.to_string()),
                Cell::from(threshold.missed_target.to_string()),
                Cell::from(estimate.decided().word()),
                Cell::from(open.join("; ")),
                Cell::from(catch.clone()),
            ]);
        }
    }
    table
}
