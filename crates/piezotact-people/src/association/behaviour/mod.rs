//! What happened in a session, task by task, as tables that other programs open: responses, and events with their onsets.
//!
//! A row of the responses is one answer: to a stimulus of a sequence, to a sample that was handed over, to a pair, or one place of an
//! order. A row of the events is a trial, or one stimulus that was played in it. Both keep what analyses need and no text that
//! somebody typed. [`read`] makes the answers, trials and evidence of them again.

mod meanings;
mod read;

use std::collections::BTreeMap;

use piezotact::page::{Cell, Column, Table};

use super::answer::Answer;
use super::of_session::{flags, of_trial, offered};
use super::tables::{criteria_not_met, missed_target, noted};
use crate::campaign::plan::Trial;
use crate::campaign::protocol::{Protocol, TaskKind};
use crate::campaign::session::{Evidence, State, TrialState};

pub use meanings::{BehaviourMeanings, behaviour_meanings};
pub use read::{
    ReadBehaviour, evidence_of_behaviour, holds_orders, read_behaviour, trials_of_behaviour,
};

/// Between the names in a cell of several.
pub const BETWEEN: &str = "|";
/// What a trial is called in the column `trial_type`.
pub(super) const TRIAL: &str = "trial";
/// What a played stimulus is called there.
pub(super) const STIMULUS: &str = "stimulus";

/// One task of one session.
#[derive(Clone, Debug, PartialEq)]
pub struct Behaviour {
    pub task: String,
    /// One row for each answer; no columns where the task asks for none.
    pub responses: Table,
    /// One row for each trial that was presented and for each stimulus that was played, in the order of their onsets.
    pub events: Table,
}

/// Where the files of a session are that its tables name.
pub trait StimulusFiles {
    /// The file of the drive of `stimulus`; `None` where there is none.
    fn drive(&self, stimulus: &str) -> Option<String>;
    /// The file of what was recorded in the run with the journal `journal`; `None` where there is none.
    fn recording(&self, journal: &str) -> Option<String>;
}

/// The columns of the responses to a task of this kind, in their order; none where nothing is answered.
pub(super) fn response_columns(protocol: &Protocol, kind: &TaskKind) -> Vec<&'static str> {
    let head = ["trial", "set", "kind"];
    let own: &[&str] = match kind {
        TaskKind::Touch { .. } => return Vec::new(),
        TaskKind::Order { .. } => &[
            "repetition",
            "rank",
            "response",
            "expected",
            "correct",
            "offered",
        ],
        TaskKind::Identify { .. } => &[
            "position",
            "presented",
            "expected",
            "response",
            "correct",
            "offered",
        ],
        TaskKind::Associate { .. } => &[
            "position",
            "presented",
            "source",
            "expected",
            "response",
            "correct",
            "offered",
        ],
        TaskKind::Compare { .. } => &["presented", "response", "offered"],
        TaskKind::Categorise { .. } => &["presented", "response", "offered"],
        TaskKind::Rate { .. } => &["presented", "response"],
    };
    let played: &[&str] = match plays(kind) {
        true => &["n_replays", "stim_file"],
        false => &[],
    };
    let all = head
        .iter()
        .chain(own)
        .chain(&["response_time"])
        .chain(played);
    let all = all.chain(&["flags"]).copied();
    let has_sets = !protocol.sets.is_empty();
    let made = !protocol.stimuli.is_empty();
    all.filter(|name| (*name != "set" || has_sets) && (*name != "source" || made))
        .collect()
}

/// Whether recordings belong to the trials of a task of this kind: of strokes, or of playings.
///
/// Source: docs/decisions/store.md.
#[must_use]
pub fn is_recorded(kind: &TaskKind) -> bool {
    plays(kind) || matches!(kind, TaskKind::Touch { .. })
}

/// What happened in the recording of one playing: the onset of the vibration, in s after its first sample; no row where it is not
/// known. Its columns are among those of the events of the task.
///
/// Source: BIDS 1.11, task events; docs/decisions/store.md.
#[must_use]
pub fn playing_events(trial: &Trial, element: usize, one: &Evidence) -> Table {
    let columns = [
        "onset",
        "duration",
        "trial_type",
        "trial",
        "element",
        "stimulus",
        "strokes",
    ];
    let rows = one.onset_s.map(|onset_s| {
        Row::from([
            ("onset", Cell::from(onset_s)),
            ("trial_type", text(STIMULUS)),
            ("trial", text(trial.name.as_str())),
            ("element", count(element + 1)),
            ("stimulus", text(one.stimulus.as_str())),
            ("strokes", count(one.strokes)),
        ])
    });
    table(&columns, rows.into_iter().collect())
}

/// Whether stimuli are rendered in a task of this kind.
fn plays(kind: &TaskKind) -> bool {
    matches!(kind, TaskKind::Associate { .. } | TaskKind::Compare { .. })
}

/// The columns of the events of every task.
pub(super) const OF_TRIALS: [&str; 19] = [
    "onset",
    "duration",
    "trial_type",
    "trial",
    "number",
    "set",
    "kind",
    "planned",
    "presented",
    "response",
    "first_response",
    "confirmed_response",
    "revisions",
    "corrections",
    "plays",
    "attempts",
    "interrupted",
    "voided",
    "missed_target",
];
/// Further columns where stimuli are played.
pub(super) const OF_STIMULI: [&str; 16] = [
    "element",
    "stimulus",
    "stim_file",
    "drive_sha256",
    "gain",
    "verified",
    "reached",
    "criteria_not_met",
    "score_jnd",
    "level_re_target_db",
    "rendered_at_db",
    "normal_force_n",
    "onset_in_recording",
    "onset_uncertainty",
    "strokes",
    "recording_file",
];

/// The columns of the events of a task of this kind.
pub(super) fn event_columns(kind: &TaskKind) -> Vec<&'static str> {
    let played: &[&str] = match plays(kind) {
        true => &OF_STIMULI,
        false => &[],
    };
    OF_TRIALS.iter().chain(played).copied().collect()
}

/// What happened in the session of `state`, one value for each task of which a trial was presented; onsets in s after the beginning
/// of the session.
///
/// Source: BIDS 1.11, behavioural experiments and task events, for the columns `onset`, `duration`, `trial_type`, `response_time` and
/// `stim_file`; docs/decisions/store.md for the others.
#[must_use]
pub fn behaviour(state: &State<'_>, files: &dyn StimulusFiles) -> Vec<Behaviour> {
    let tasks = state.protocol().tasks.iter();
    let all = tasks.filter_map(|task| {
        let of_task = OfTask {
            state,
            files,
            task: &task.name,
            kind: &task.kind,
        };
        let events = of_task.events();
        (!events.rows.is_empty()).then(|| Behaviour {
            task: task.name.clone(),
            responses: of_task.responses(),
            events,
        })
    });
    all.collect()
}

/// A row by the names of its columns; what is not named is missing.
type Row = BTreeMap<&'static str, Cell>;

/// A table of `rows` with these columns.
fn table(columns: &[&'static str], rows: Vec<Row>) -> Table {
    let mut table = Table::new(columns.iter().map(|name| Column::new(name, name)));
    let cells = |mut row: Row| {
        let cells = columns.iter().map(|name| row.remove(name));
        cells
            .map(|cell| cell.unwrap_or(Cell::Missing(())))
            .collect()
    };
    table.rows = rows.into_iter().map(cells).collect();
    table
}

/// A text; nothing where it is empty.
fn text(value: impl Into<String>) -> Cell {
    let value = value.into();
    match value.is_empty() {
        true => Cell::Missing(()),
        false => Cell::Text(value),
    }
}

fn count(value: impl TryInto<u32>) -> Cell {
    value
        .try_into()
        .map_or(Cell::Missing(()), |value| Cell::from(f64::from(value)))
}

/// 1 where the response is the expected one, else 0.
fn is_right(response: &str, expected: &str) -> Cell {
    count(u32::from(response == expected))
}

struct OfTask<'a> {
    state: &'a State<'a>,
    files: &'a dyn StimulusFiles,
    task: &'a str,
    kind: &'a TaskKind,
}

impl OfTask<'_> {
    /// The trials of the task with their numbers in the session.
    fn trials(&self) -> impl Iterator<Item = (usize, &Trial, &TrialState)> {
        let numbered = self.state.trials().enumerate();
        numbered
            .filter(|(_, (trial, _))| trial.task == self.task)
            .map(|(i, (trial, of))| (i + 1, trial, of))
    }

    fn responses(&self) -> Table {
        let columns = response_columns(self.state.protocol(), self.kind);
        let mut rows = Vec::new();
        let mut repetitions: BTreeMap<&str, u32> = BTreeMap::new();
        for (_, trial, of) in self.trials() {
            let repetition = repetitions
                .entry(trial.set.as_deref().unwrap_or_default())
                .or_default();
            *repetition += u32::from(trial.kind.is_counted());
            if let Some(answer) = of.answer() {
                let names = self.state.names(trial, answer);
                match self.kind {
                    TaskKind::Touch { .. } => {}
                    TaskKind::Order { .. } => {
                        rows.extend(self.places(trial, of, &names, *repetition))
                    }
                    TaskKind::Identify { .. } | TaskKind::Associate { .. } => {
                        rows.extend(self.named(trial, of, &names));
                    }
                    TaskKind::Compare { .. }
                    | TaskKind::Categorise { .. }
                    | TaskKind::Rate { .. } => {
                        rows.extend(self.of_trial(trial, of));
                    }
                }
            }
        }
        match columns.is_empty() {
            true => Table::default(),
            false => table(&columns, rows),
        }
    }

    /// What all responses of a trial share.
    fn shared(&self, trial: &Trial, of: &TrialState) -> Row {
        Row::from([
            ("trial", text(trial.name.as_str())),
            ("set", text(trial.set.as_deref().unwrap_or_default())),
            ("kind", text(trial.kind.word())),
            ("response_time", Cell::from(of.seconds())),
        ])
    }

    /// One row for each place of an order.
    fn places(
        &self,
        trial: &Trial,
        of: &TrialState,
        names: &[String],
        repetition: u32,
    ) -> Vec<Row> {
        let known = of_trial(self.state, (trial, of), names, repetition);
        let offered = offered(self.state, trial).join(BETWEEN);
        let rows = names.iter().enumerate().map(|(i, placed)| {
            let expected = known.get(i).map(|row| row.answered.as_str());
            let mut row = self.shared(trial, of);
            row.extend([
                ("repetition", count(repetition)),
                ("rank", count(i + 1)),
                ("response", text(placed.as_str())),
                ("expected", text(expected.unwrap_or_default())),
                (
                    "correct",
                    expected.map_or(Cell::Missing(()), |one| is_right(one, placed)),
                ),
                ("offered", text(offered.as_str())),
                ("flags", self.flags(trial, of, [i])),
            ]);
            row
        });
        rows.collect()
    }

    /// One row for each sample or stimulus that was named.
    fn named(&self, trial: &Trial, of: &TrialState, names: &[String]) -> Vec<Row> {
        let protocol = self.state.protocol();
        let rows = of_trial(self.state, (trial, of), names, 1).into_iter();
        let rows = rows.map(|answer: Answer| {
            let element = answer.position.unwrap_or(1) - 1;
            let expected = protocol.expected(&answer.presented);
            let made = protocol.stimuli.iter();
            let mut made = made.filter(|stimulus| stimulus.name == answer.presented);
            let mut row = self.shared(trial, of);
            row.extend([
                ("position", count(element + 1)),
                ("presented", text(answer.presented.as_str())),
                (
                    "source",
                    text(made.next().map_or("", |stimulus| stimulus.of.as_str())),
                ),
                ("expected", text(expected.unwrap_or_default())),
                ("response", text(answer.answered.as_str())),
                (
                    "correct",
                    expected.map_or(Cell::Missing(()), |one| is_right(one, &answer.answered)),
                ),
                ("offered", text(answer.offered.join(BETWEEN))),
                ("flags", self.flags(trial, of, [element])),
                ("n_replays", self.replays(of, element)),
                ("stim_file", self.drive(&answer.presented)),
            ]);
            row
        });
        rows.collect()
    }

    /// The one row of a trial that is answered as a whole.
    fn of_trial(&self, trial: &Trial, of: &TrialState) -> Option<Row> {
        let response = noted(of.answer(), &|one| self.state.names(trial, one));
        let presented = self.state.presented(trial);
        let mut row = self.shared(trial, of);
        let files: Vec<String> = presented
            .iter()
            .filter_map(|stimulus| self.files.drive(stimulus))
            .collect();
        let replays = of.plays.iter().map(|plays| plays.saturating_sub(1));
        row.extend([
            ("presented", text(presented.join(BETWEEN))),
            ("response", text(response)),
            ("offered", text(offered(self.state, trial).join(BETWEEN))),
            ("flags", self.flags(trial, of, 0..presented.len().max(1))),
            ("n_replays", count(replays.sum::<u32>())),
            // BIDS has one file in a cell.
            (
                "stim_file",
                match files.as_slice() {
                    [only] => text(only.as_str()),
                    _ => Cell::Missing(()),
                },
            ),
        ]);
        Some(row)
    }

    /// What was wrong with any of these elements of a trial, each once.
    fn flags(
        &self,
        trial: &Trial,
        of: &TrialState,
        elements: impl IntoIterator<Item = usize>,
    ) -> Cell {
        let mut words: Vec<&str> = Vec::new();
        for element in elements {
            for flag in flags((self.state, trial), of, element) {
                if !words.contains(&flag.word()) {
                    words.push(flag.word());
                }
            }
        }
        text(words.join(" "))
    }

    /// How often an element was felt again in the attempt that was answered.
    fn replays(&self, of: &TrialState, element: usize) -> Cell {
        let plays = of.plays.get(element);
        plays.map_or(Cell::Missing(()), |plays| count(plays.saturating_sub(1)))
    }

    fn drive(&self, stimulus: &str) -> Cell {
        match plays(self.kind) {
            true => text(self.files.drive(stimulus).unwrap_or_default()),
            false => Cell::Missing(()),
        }
    }

    fn events(&self) -> Table {
        let mut rows: Vec<(i64, Row)> = Vec::new();
        for (number, trial, of) in self.trials() {
            let Some(presented_ms) = of.at_ms[0] else {
                continue;
            };
            rows.push((presented_ms, self.trial(number, trial, of)));
            let played = of.evidence.iter().zip(&of.played_ms);
            for ((element, one), at_ms) in played {
                rows.push((*at_ms, self.stimulus(trial, *element, one)));
            }
        }
        rows.sort_by_key(|(at_ms, _)| *at_ms);
        let began_ms = self.state.began_ms();
        let rows = rows.into_iter().map(|(at_ms, mut row)| {
            let onset_s = began_ms.map(|began_ms| (at_ms - began_ms) as f64 / 1000.0);
            row.insert("onset", Cell::from(onset_s));
            row
        });
        table(&event_columns(self.kind), rows.collect())
    }

    fn trial(&self, number: usize, trial: &Trial, of: &TrialState) -> Row {
        let last = of.answers.len().saturating_sub(1);
        let as_given = |answer, index| noted(answer, &|_| self.state.names_as_given(trial, index));
        let plays: Vec<String> = of.felt.iter().map(u32::to_string).collect();
        Row::from([
            ("duration", Cell::from(of.seconds())),
            ("trial_type", text(TRIAL)),
            ("trial", text(trial.name.as_str())),
            ("number", count(number)),
            ("set", text(trial.set.as_deref().unwrap_or_default())),
            ("kind", text(trial.kind.word())),
            ("planned", text(trial.presented.names().join(BETWEEN))),
            (
                "presented",
                match of.plays.is_empty() {
                    true => Cell::Missing(()),
                    false => text(self.state.presented(trial).join(BETWEEN)),
                },
            ),
            (
                "response",
                text(noted(of.answer(), &|one| self.state.names(trial, one))),
            ),
            ("first_response", text(as_given(of.answers.first(), 0))),
            (
                "confirmed_response",
                text(as_given(of.as_confirmed(), last)),
            ),
            ("revisions", count(last)),
            ("corrections", count(self.state.corrections(trial))),
            ("plays", text(plays.join(BETWEEN))),
            ("attempts", count(of.attempts)),
            ("interrupted", count(of.interrupted)),
            ("voided", count(of.voided)),
            ("missed_target", text(missed_target(of))),
        ])
    }

    fn stimulus(&self, trial: &Trial, element: usize, one: &Evidence) -> Row {
        let recording = one
            .journal
            .as_deref()
            .and_then(|one| self.files.recording(one));
        Row::from([
            ("trial_type", text(STIMULUS)),
            ("trial", text(trial.name.as_str())),
            ("set", text(trial.set.as_deref().unwrap_or_default())),
            ("kind", text(trial.kind.word())),
            ("element", count(element + 1)),
            ("stimulus", text(one.stimulus.as_str())),
            (
                "stim_file",
                text(self.files.drive(&one.stimulus).unwrap_or_default()),
            ),
            ("drive_sha256", text(one.drive.to_string())),
            ("gain", text(one.gain.as_deref().unwrap_or_default())),
            ("verified", text(one.verified.word())),
            ("reached", text(one.reached.word())),
            ("criteria_not_met", text(criteria_not_met(one))),
            ("score_jnd", Cell::from(one.score_jnd)),
            ("level_re_target_db", Cell::from(one.level_re_target_db)),
            ("rendered_at_db", Cell::from(one.rendered_at_db)),
            ("normal_force_n", Cell::from(one.normal_force_n)),
            ("onset_in_recording", Cell::from(one.onset_s)),
            ("onset_uncertainty", Cell::from(one.onset_uncertainty_s)),
            ("strokes", count(one.strokes)),
            ("recording_file", text(recording.unwrap_or_default())),
        ])
    }
}
