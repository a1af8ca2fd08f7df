//! Answers, trials and evidence, made again of responses and events.

use crate::association::AssociationError;
use piezotact::page::{Cell, Table};

use super::super::answer::{Answer, Flag};
use super::super::of_session::REPETITION;
use super::super::tables::{OF_EVIDENCE, OF_TRIALS, table};
use super::{BETWEEN, STIMULUS, TRIAL};

/// One task of one session, as it was read.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ReadBehaviour {
    pub participant: String,
    pub session: String,
    pub task: String,
    /// How a virtual volunteer judges; absent for a person.
    pub judge: Option<String>,
    /// When the session began, in ms since 1970-01-01 00:00 UTC, on the shifted calendar where dates were shifted; absent where
    /// it is not stated.
    pub began_ms: Option<i64>,
    pub responses: Table,
    pub events: Table,
}

/// No time in a session is as long, in s.
const LONGEST_S: f64 = 3e9;

/// One row, by the names of its columns.
#[derive(Clone, Copy)]
struct Row<'a> {
    table: &'a Table,
    number: usize,
}

impl<'a> Row<'a> {
    fn all(table: &'a Table) -> impl Iterator<Item = Self> {
        (0..table.rows.len()).map(move |number| Self { table, number })
    }

    /// The text of a cell; `None` where the column is not there or the cell has nothing.
    fn text(self, column: &str) -> Option<&'a str> {
        let at = self
            .table
            .columns
            .iter()
            .position(|one| one.name == column)?;
        match &self.table.rows[self.number][at] {
            Cell::Text(text) if !text.is_empty() => Some(text),
            _ => None,
        }
    }

    fn or_empty(self, column: &str) -> String {
        self.text(column).unwrap_or_default().to_owned()
    }

    fn required(self, column: &str) -> Result<&'a str, AssociationError> {
        self.text(column).ok_or_else(|| AssociationError::Missing {
            row: self.number + 1,
            column: column.to_owned(),
        })
    }

    /// The number in a cell; `None` where it has none.
    fn number<T: std::str::FromStr>(self, column: &str) -> Result<Option<T>, AssociationError> {
        let Some(text) = self.text(column) else {
            return Ok(None);
        };
        text.parse()
            .map(Some)
            .map_err(|_says_less| AssociationError::Number {
                row: self.number + 1,
                column: column.to_owned(),
                found: text.to_owned(),
            })
    }

    /// The time in a cell, in s: less than a human life.
    fn seconds(self, column: &str) -> Result<Option<f64>, AssociationError> {
        let found: Option<f64> = self.number(column)?;
        match found.filter(|seconds| seconds.abs() >= LONGEST_S || !seconds.is_finite()) {
            None => Ok(found),
            Some(_) => Err(AssociationError::Number {
                row: self.number + 1,
                column: column.to_owned(),
                found: self.or_empty(column),
            }),
        }
    }

    fn has(self, column: &str) -> bool {
        self.table.columns.iter().any(|one| one.name == column)
    }
}

/// The counted answers that name a sample, and the places of samples in orders: the rows of [`super::super::answers_of`], as far as the
/// responses hold them. Tables of other tasks and other programs give those rows that have a presented stimulus and a response that
/// is right or wrong.
///
/// # Errors
/// [`AssociationError`].
///
/// Source: docs/decisions/store.md.
pub fn read_behaviour(of: &ReadBehaviour) -> Result<Vec<Answer>, AssociationError> {
    let mut answers = Vec::new();
    for row in Row::all(&of.responses) {
        let is_order = holds_orders(&of.responses);
        let is_judged = row.has("expected") || row.has("correct");
        if row.text("kind").is_some_and(|kind| kind != "counted") || !is_judged {
            continue;
        }
        let (presented, answered) = match is_order {
            true => ("response", "expected"),
            false => ("presented", "response"),
        };
        // Of other programs: nothing that is known to have been presented.
        if !row.has(presented) {
            continue;
        }
        // No order is right or wrong.
        if is_order && row.text(answered).is_none() {
            continue;
        }
        let repetition: Option<u32> = row.number("repetition")?;
        let session = match repetition {
            Some(again) if again > 1 => format!("{}{REPETITION}{again}", of.session),
            _ => of.session.clone(),
        };
        let offered = row.text("offered").map(|names| names.split(BETWEEN));
        let position = row.number(if is_order { "rank" } else { "position" })?;
        let trial = row.text("trial").map(str::to_owned);
        answers.push(Answer {
            participant: of.participant.clone(),
            session,
            task: of.task.clone(),
            set: row.or_empty("set"),
            trial: trial.unwrap_or_else(|| (row.number + 1).to_string()),
            presented: row.required(presented)?.to_owned(),
            answered: row.required(answered)?.to_owned(),
            position,
            offered: offered.into_iter().flatten().map(str::to_owned).collect(),
            flags: flags(row)?,
            judge: of.judge.clone(),
            ..Answer::default()
        });
    }
    Ok(answers)
}

/// Whether the rows of `responses` are places of orders: of other programs a column `rank` may hold anything.
///
/// Source: docs/decisions/store.md.
#[must_use]
pub fn holds_orders(responses: &Table) -> bool {
    let has = |wanted| responses.columns.iter().any(|one| one.name == wanted);
    has("rank") && has("offered")
}

fn flags(row: Row<'_>) -> Result<Vec<Flag>, AssociationError> {
    let words = row.text("flags").unwrap_or_default().split_whitespace();
    let flags = words.map(|word| {
        let known = Flag::ALL.into_iter().find(|flag| flag.word() == word);
        known.ok_or_else(|| AssociationError::Flag {
            row: row.number + 1,
            known: Flag::ALL.map(Flag::word).join(", "),
            found: word.to_owned(),
        })
    });
    flags.collect()
}

fn of_kind<'a>(of: &'a ReadBehaviour, kind: &'a str) -> impl Iterator<Item = Row<'a>> {
    Row::all(&of.events).filter(move |row| row.text("trial_type") == Some(kind))
}

/// The trials that were presented, in the columns of [`super::super::trials_table`] and in the order of their numbers; times are those
/// of the shifted calendar, and no reason of a correction is known.
///
/// # Errors
/// [`AssociationError`].
///
/// Source: docs/decisions/store.md.
pub fn trials_of_behaviour(all: &[ReadBehaviour]) -> Result<Table, AssociationError> {
    let mut trials = table(&OF_TRIALS);
    let mut keyed = Vec::new();
    for (place, of) in all.iter().enumerate() {
        let session = all.iter().position(|other| {
            (&other.participant, &other.session) == (&of.participant, &of.session)
        });
        for row in of_kind(of, TRIAL) {
            let number: usize = row.number("number")?.unwrap_or(row.number + 1);
            let onset_s = row.seconds("onset")?;
            let seconds = row.seconds("duration")?;
            let later = |(from_ms, seconds): (i64, f64)| {
                from_ms.saturating_add((seconds * 1000.0).round() as i64)
            };
            let presented_ms = of.began_ms.zip(onset_s).map(later);
            let confirmed_ms = presented_ms.zip(seconds).map(later);
            let ms = |ms: Option<i64>| Cell::from(ms.map_or(String::new(), |ms| ms.to_string()));
            let same = |column| Cell::from(row.or_empty(column));
            let cells = vec![
                Cell::from(of.participant.as_str()),
                Cell::from(of.session.as_str()),
                Cell::from(number.to_string()),
                same("trial"),
                Cell::from(of.task.as_str()),
                same("set"),
                same("kind"),
                same("planned"),
                same("presented"),
                same("response"),
                same("first_response"),
                same("confirmed_response"),
                same("revisions"),
                Cell::from(""),
                same("plays"),
                same("attempts"),
                same("interrupted"),
                same("voided"),
                same("missed_target"),
                ms(presented_ms),
                ms(confirmed_ms),
                Cell::from(seconds.map_or(String::new(), |s| format!("{s:.3}"))),
                Cell::from("no"),
                Cell::from(of.judge.as_deref().unwrap_or("")),
            ];
            keyed.push(((session.unwrap_or(place), number), cells));
        }
    }
    keyed.sort_by_key(|(key, _)| *key);
    trials.rows = keyed.into_iter().map(|(_, cells)| cells).collect();
    Ok(trials)
}

/// What was measured at every playing, in the columns of [`super::super::evidence_table`]; the journal is the recording of the playing.
///
/// # Errors
/// [`AssociationError`].
///
/// Source: docs/decisions/store.md.
pub fn evidence_of_behaviour(all: &[ReadBehaviour]) -> Result<Table, AssociationError> {
    let mut evidence = table(&OF_EVIDENCE);
    let mut keyed = Vec::new();
    for (place, of) in all.iter().enumerate() {
        let trials: Vec<(&str, usize)> = of_kind(of, TRIAL)
            .filter_map(|row| Some((row.text("trial")?, row.number("number").ok()??)))
            .collect();
        let session = all.iter().position(|other| {
            (&other.participant, &other.session) == (&of.participant, &of.session)
        });
        for row in of_kind(of, STIMULUS) {
            let trial = row.required("trial")?;
            let number = trials.iter().find(|(name, _)| *name == trial);
            let number = number.map_or(usize::MAX, |(_, number)| *number);
            let same = |column| Cell::from(row.or_empty(column));
            let cells = vec![
                Cell::from(of.participant.as_str()),
                Cell::from(of.session.as_str()),
                Cell::from(trial),
                same("element"),
                same("stimulus"),
                same("drive_sha256"),
                same("gain"),
                same("verified"),
                same("reached"),
                same("criteria_not_met"),
                same("score_jnd"),
                same("level_re_target_db"),
                same("rendered_at_db"),
                same("normal_force_n"),
                same("onset_in_recording"),
                same("onset_uncertainty"),
                same("strokes"),
                same("recording_file"),
                Cell::from(of.judge.as_deref().unwrap_or("")),
            ];
            keyed.push(((session.unwrap_or(place), number), cells));
        }
    }
    keyed.sort_by_key(|(key, _)| *key);
    evidence.rows = keyed.into_iter().map(|(_, cells)| cells).collect();
    Ok(evidence)
}
