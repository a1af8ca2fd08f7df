//! The report of one session: who, what was presented and answered, and what happened besides.

use piezotact::criterion::Outcome;
use piezotact::figure::{Axis, Chart, Figure, Line, Mark, Scale, Tone};
use piezotact::page::{Block, Cell, Column, Number, Page, Table};

use super::tables::{noted, thresholds_table};
use crate::campaign::adaptive::Response;
use crate::campaign::plan::TrialKind;
use crate::campaign::session::{
    Answer, Event, Evidence, Participant, Stage, State, Threshold, TrialState,
};
use crate::campaign::store::Purpose;

/// The report of the session with the state `state`, which was made from `events` with their times in ms since 1970-01-01 00:00 UTC.
///
/// Source: docs/decisions/answers.md.
#[must_use]
pub fn session_page(state: &State<'_>, events: &[(i64, Event)]) -> Page {
    let plan = state.plan();
    let title = format!("Session {} of {}", plan.session, plan.participant);
    let mut page = Page::new(title, origin(state));
    page = page.section(
        "",
        [Block::Numbers {
            numbers: numbers(state, events),
        }],
    );
    let thresholds = thresholds_table(state);
    if !thresholds.rows.is_empty() {
        let tasks = state.protocol().tasks.iter();
        let runs = tasks.flat_map(|task| state.thresholds(&task.name));
        let runs = runs.filter(|run| !run.course.is_empty());
        let figures = runs.map(|run| Block::Figure(course(&run)));
        let blocks: Vec<Block> = [Block::Table(thresholds)]
            .into_iter()
            .chain(figures)
            .collect();
        page = page.section("Thresholds", blocks);
    }
    page = page.section("Trials", [Block::Table(trials(state, events))]);
    let happened = happened(events);
    if !happened.rows.is_empty() {
        page = page.section("What happened besides", [Block::Table(happened)]);
    }
    page.warnings(&state.warnings())
}

/// The levels of an adaptive run over its trials, with the threshold and its interval where it is decided.
fn course(run: &Threshold<'_>) -> Figure {
    let all = || {
        run.course
            .iter()
            .enumerate()
            .map(|(i, (level, response))| ((i + 1) as f64, *level, *response))
    };
    let of = |wanted| {
        all()
            .filter(move |(.., found)| *found == wanted)
            .map(|(x, y, _)| (x, y))
            .collect()
    };
    let end = run.course.len() as f64 + 1.0;
    let mut lines = vec![
        Line::new("", Tone::Pale, all().map(|(x, y, _)| (x, y)).collect()).thin(),
        Line::new("right", Tone::Main, of(Response::Correct)).marked(Mark::Dots),
        Line::new("wrong", Tone::Accent, of(Response::Wrong)).marked(Mark::Dots),
    ];
    let estimate = &run.estimate;
    let decided = estimate
        .level
        .filter(|_| estimate.decided() == Outcome::Met);
    if let Some(level) = decided {
        let mut line = Line::new(
            "threshold",
            Tone::Reference,
            vec![(0.0, level), (end, level)],
        )
        .marked(Mark::Dashed);
        if let Some([low, high]) = estimate.interval {
            line = line.ribbon(vec![(0.0, low, high), (end, low, high)]);
        }
        lines.push(line);
    }
    let of_interval = estimate
        .interval
        .filter(|_| decided.is_some())
        .into_iter()
        .flatten();
    let levels = all()
        .map(|(_, level, _)| level)
        .chain(decided)
        .chain(of_interval);
    let y = Axis::around("level, as the protocol states it", Scale::Linear, levels);
    let caption = format!(
        "Run {}: the level of each trial{}.",
        run.run,
        match decided {
            Some(_) if estimate.interval.is_some() => ", the threshold and its 95 % interval",
            Some(_) => " and the threshold",
            None => "; no threshold is decided",
        }
    );
    Chart::new(Axis::new("trial", 0.0, end), y, lines).captioned(caption)
}

/// Who took part, and as what.
fn origin(state: &State<'_>) -> String {
    let purpose = match state.purpose() {
        Some(Purpose::Rehearsal) => "A rehearsal: it counts in no result.",
        Some(Purpose::Volunteer) | None => "",
    };
    let Participant {
        sex,
        age_years,
        handedness,
        finger,
        language: _,
        judge,
    } = state.participant();
    let said = [
        judge.map(|judge| format!("virtual volunteer (no person), judge {}", judge.name())),
        sex.clone(),
        age_years.map(|years| format!("{years} years")),
        handedness
            .as_ref()
            .map(|hand| format!("handedness: {hand}")),
        finger.as_ref().map(|finger| format!("finger: {finger}")),
    ];
    let said: Vec<String> = said.into_iter().flatten().collect();
    let parts = [state.protocol().title.clone(), said.join(", ")];
    let parts: Vec<String> = parts.into_iter().filter(|part| !part.is_empty()).collect();
    format!("{}. {purpose}", parts.join(" · "))
        .trim_end()
        .to_owned()
}

/// When the first trial was presented, or the session was begun.
fn start_ms(events: &[(i64, Event)]) -> i64 {
    let first = events
        .iter()
        .find(|(_, event)| matches!(event, Event::Presented { .. }));
    first.or(events.first()).map_or(0, |(at_ms, _)| *at_ms)
}

/// The time `at_ms` after `start_ms` as minutes and seconds; earlier ones have a sign.
fn clock(at_ms: i64, start_ms: i64) -> String {
    let s = at_ms.saturating_sub(start_ms) / 1000;
    let sign = if s < 0 { "−" } else { "" };
    let s = s.unsigned_abs();
    format!("{sign}{}:{:02}", s / 60, s % 60)
}

fn numbers(state: &State<'_>, events: &[(i64, Event)]) -> Vec<Number> {
    let stage = match state.stage() {
        _ if state.is_complete() => "complete",
        Stage::Stopped => "stopped",
        Stage::Ended => "no consent",
        Stage::Withdrawn => "withdrawn",
        Stage::New | Stage::Consent | Stage::Running | Stage::Paused => "under way",
    };
    let needed: usize = state.progress().values().map(|(_, needed)| needed).sum();
    let count = |of: fn(&TrialState) -> usize| -> usize {
        state.trials().map(|(_, trial)| of(trial)).sum()
    };
    let last = state.last_ms().unwrap_or_default();
    let mut numbers = vec![
        Number::new(stage, "session"),
        Number::new(
            format!("{} of {needed}", state.confirmed()),
            "trials confirmed",
        ),
        Number::new(
            clock(last, start_ms(events)),
            "min:s from the first trial to the last event",
        ),
        Number::new(
            count(|trial| trial.corrections.len()).to_string(),
            "answers corrected",
        ),
        Number::new(
            count(|trial| trial.voided as usize).to_string(),
            "void trials, presented again",
        ),
    ];
    let played = count(|trial| trial.evidence.len());
    if played > 0 {
        let missed = count(|trial| playings(trial, Evidence::missed));
        let open = count(|trial| playings(trial, Evidence::is_open));
        numbers.push(Number::new(
            format!("{missed} of {played}"),
            "stimuli that missed their target",
        ));
        numbers.push(Number::new(
            format!("{open} of {played}"),
            "stimuli of which it is not decided",
        ));
    }
    numbers
}

/// Each trial that was presented, in the order of the plan.
fn trials(state: &State<'_>, events: &[(i64, Event)]) -> Table {
    let columns = [
        ("no.", "number"),
        ("at (min:s)", "at"),
        ("task", "task"),
        ("set", "set"),
        ("presented", "presented"),
        ("answer", "answer"),
        ("time (s)", "seconds"),
        ("remarks", "remarks"),
    ];
    let mut table = Table::new(columns.map(|(heading, name)| Column::new(heading, name)));
    let start_ms = start_ms(events);
    for (i, (trial, of)) in state.trials().enumerate() {
        if of.attempts == 0 {
            continue;
        }
        let names = |answer: &Answer| state.names(trial, answer);
        let at = of.at_ms[0].map_or(String::new(), |at_ms| clock(at_ms, start_ms));
        table.rows.push(vec![
            Cell::from((i + 1).to_string()),
            Cell::from(at),
            Cell::from(trial.task.as_str()),
            Cell::from(trial.set.as_deref().unwrap_or("")),
            Cell::from(state.presented(trial).join(", ")),
            Cell::from(noted(of.answer(), &names).replace('|', ", ")),
            Cell::from(of.seconds().map_or(String::new(), |s| format!("{s:.1}"))),
            Cell::from(remarks(&trial.kind, of).join("; ")),
        ]);
    }
    table
}

/// What is out of the ordinary in a trial.
fn remarks(kind: &TrialKind, of: &TrialState) -> Vec<String> {
    let mut remarks = Vec::new();
    match kind {
        TrialKind::Counted => {}
        TrialKind::Training { .. } => remarks.push("training".to_owned()),
        TrialKind::Catch { .. } => remarks.push("catch trial".to_owned()),
    }
    let mut add = |many: bool, text: String| {
        if many {
            remarks.push(text);
        }
    };
    add(!of.confirmed, "not confirmed".to_owned());
    add(
        of.presented_instead.is_some(),
        "other samples than planned".to_owned(),
    );
    let revised = of.answers.len().saturating_sub(1);
    add(revised > 0, format!("revised {}", times(revised)));
    for (_, why) in &of.corrections {
        add(true, format!("corrected: {why}"));
    }
    add(of.voided > 0, format!("void {}", times(of.voided as usize)));
    add(
        of.interrupted > 0,
        format!("interrupted {}", times(of.interrupted as usize)),
    );
    let felt: Vec<String> = of.felt.iter().map(u32::to_string).collect();
    add(
        of.felt.iter().any(|felt| *felt > 1),
        format!("felt {} times", felt.join(", ")),
    );
    let missed = playings(of, Evidence::missed);
    add(missed > 0, format!("target missed {}", times(missed)));
    let open = playings(of, Evidence::is_open);
    add(open > 0, format!("target not decided {}", times(open)));
    remarks
}

/// Of how many playings of a trial `is_it` is so.
fn playings(of: &TrialState, is_it: fn(&Evidence) -> bool) -> usize {
    of.evidence.iter().filter(|(_, one)| is_it(one)).count()
}

fn times(count: usize) -> String {
    match count {
        1 => "once".to_owned(),
        count => format!("{count} times"),
    }
}

/// Notes, pauses, interruptions and what was refused, as they came.
fn happened(events: &[(i64, Event)]) -> Table {
    let columns = [("at (min:s)", "at"), ("what", "what")];
    let mut table = Table::new(columns.map(|(heading, name)| Column::new(heading, name)));
    let start_ms = start_ms(events);
    for (at_ms, event) in events {
        let what = match event {
            Event::Begun {
                experimenter,
                program,
                ..
            } => format!("begun by {experimenter} with {program}"),
            Event::ConsentGiven { .. } => "consent was given".to_owned(),
            Event::ConsentRefused => "consent was refused".to_owned(),
            Event::Voided { trial, why } => format!("trial {trial} is void: {why}"),
            Event::Paused => "pause".to_owned(),
            Event::WentOn => "the pause ended".to_owned(),
            Event::Resumed { experimenter } => {
                format!("resumed by {experimenter} after an interruption")
            }
            Event::ResumeRefused { after_hours } => {
                format!("not resumed: it was left {after_hours:.1} h before")
            }
            Event::Note { text } => format!("note: {text}"),
            Event::Stopped { why } => format!("stopped: {why}"),
            Event::ConsentWithdrawn => "consent was withdrawn".to_owned(),
            Event::Ended => "ended".to_owned(),
            Event::Ignored { command, why } => format!("without effect: {command}: {why}"),
            Event::Checked { .. }
            | Event::PlayBegan { .. }
            | Event::Presented { .. }
            | Event::Played { .. }
            | Event::Answered { .. }
            | Event::Confirmed { .. }
            | Event::Corrected { .. } => continue,
        };
        table
            .rows
            .push(vec![Cell::from(clock(*at_ms, start_ms)), Cell::from(what)]);
    }
    table
}
