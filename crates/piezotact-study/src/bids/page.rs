//! What was written, checked and read of data sets, as reports.

use std::fmt;
use std::path::PathBuf;

use piezotact::criterion::Outcome;
use piezotact::document::Content;
use piezotact::number::counted;
use piezotact::page::{Block, Cell, Column, Ending, Number, Page, Shown, Table};
use serde::Serialize;

use super::check::{Checked, Problem, SecondOpinion};
use super::write::Exported;

/// What was read of a data set.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Imported {
    /// The folder of the data set.
    pub dataset: PathBuf,
    /// How many recordings.
    pub recordings: usize,
    /// How many EEG recordings.
    pub eeg_recordings: usize,
    /// How many drives.
    pub drives: usize,
    /// How many answers.
    pub answers: usize,
    /// What the data set has and the tables and recordings do not.
    pub not_imported: Vec<String>,
}

impl Content for Imported {
    const SCHEMA: &'static str = "bids_import";
}

fn number(count: usize, what: &str) -> Number {
    Number::new(count.to_string(), what)
}

/// A table of one column.
fn listed<T: fmt::Display>(heading: &str, name: &str, lines: &[T]) -> Block {
    let mut table = Table::new([Column::new(heading, name)]);
    let rows = lines.iter().map(|line| vec![Cell::Text(line.to_string())]);
    table.rows = rows.collect();
    Block::Table(table)
}

impl Shown for Exported {
    fn page(&self) -> Page {
        let sentence = format!(
            "{} in {}: a data set of {}; `piezotact bids check` checks it",
            counted(self.participants, "participant"),
            match self.sessions {
                0 => counted(self.recordings, "recording"),
                count => counted(count, "session"),
            },
            counted(self.files, "file")
        );
        let numbers = [
            number(self.recordings, "recordings"),
            number(self.eeg_recordings, "EEG recordings"),
            number(self.answers, "answers"),
        ];
        Page::new("BIDS data set of a study", "")
            .section(
                "",
                [Block::conclusion(sentence, None), Block::numbers(numbers)],
            )
            .section(
                "What the data set does not carry",
                [listed("not carried", "not_carried", &self.not_carried)],
            )
            .warnings(&self.warnings)
    }
}

impl Shown for Imported {
    fn page(&self) -> Page {
        let sentence = format!(
            "{} and {} of {}",
            counted(self.recordings + self.eeg_recordings, "recording"),
            counted(self.answers, "answer"),
            self.dataset.display()
        );
        let numbers = [
            number(self.recordings, "recordings of touch and playing"),
            number(self.eeg_recordings, "EEG recordings"),
            number(self.drives, "drives"),
            number(self.answers, "answers"),
        ];
        Page::new("Import of a BIDS data set", "")
            .section(
                "",
                [Block::conclusion(sentence, None), Block::numbers(numbers)],
            )
            .section(
                "What was not imported",
                [listed("not imported", "not_imported", &self.not_imported)],
            )
    }
}

/// The problems, one row each: the place with its line in a report, file and line apart in CSV.
fn problems(all: &[Problem], columns: &[(&str, &str)], place: fn(&Problem) -> Vec<Cell>) -> Table {
    let columns = columns.iter();
    let mut table = Table::new(columns.map(|(heading, name)| Column::new(heading, name)));
    let rows = all.iter().map(|problem| {
        let mut row = place(problem);
        row.push(Cell::Text(problem.text()));
        row
    });
    table.rows = rows.collect();
    table
}

impl Shown for Checked {
    fn ending(&self) -> Ending {
        let other = self.second_opinion.as_ref();
        let errors = other.is_some_and(|other| !other.errors.is_empty());
        match (self.outcome, errors) {
            (Outcome::NotMet, _) | (_, true) => Ending::NotPassed,
            (Outcome::NotDecided, _) => Ending::NotDecided,
            (Outcome::Met, false) => Ending::Done,
        }
    }

    fn page(&self) -> Page {
        let read = format!(
            "{} and {}",
            counted(self.tables, "table"),
            counted(self.signals, "signal file")
        );
        let sentence = match self.outcome {
            Outcome::Met => format!("Nothing wrong was found in {read}"),
            Outcome::NotMet => format!(
                "{} found in {read}",
                counted(self.problems.len() + self.more, "problem")
            ),
            Outcome::NotDecided => {
                "Nothing could be checked: no table and no signal file".to_owned()
            }
        };
        let mut first = vec![Block::conclusion(sentence, self.outcome)];
        if let Some(other) = &self.second_opinion {
            let outcome = match (&other.failed, other.errors.is_empty()) {
                (Some(_), _) => Outcome::NotDecided,
                (None, true) => Outcome::Met,
                (None, false) => Outcome::NotMet,
            };
            first.push(Block::conclusion(other.sentence(), outcome));
        } else {
            let sentence = "The official validator was not asked";
            first.push(Block::conclusion(sentence, None));
        }
        let not_read = self.not_read.iter();
        first.push(Block::numbers(not_read.map(|(kind, count)| {
            Number::new(
                format!("{count} of {kind}"),
                "files that this check does not read, as it does not know their contents",
            )
        })));
        let mut page = Page::new("Check of a BIDS data set", "").section("", first);
        if !self.problems.is_empty() {
            let columns = [("where", "place"), ("what is wrong", "text")];
            let table = problems(&self.problems, &columns, |one| {
                vec![Cell::Text(one.place())]
            });
            let more = (self.more > 0)
                .then(|| Block::text(format!("… and {} more of the same kinds", self.more)));
            let blocks = [Block::Table(table)].into_iter().chain(more);
            page = page.section("Problems", blocks);
        }
        let other = self.second_opinion.as_ref();
        if let Some(other) = other.filter(|other| !other.errors.is_empty()) {
            let errors = listed("error", "error", &other.errors);
            page = page.section(&format!("Errors of {}", other.program), [errors]);
        }
        let columns = [
            ("file", "file"),
            ("line", "line"),
            ("what is wrong", "text"),
        ];
        page.rows(problems(&self.problems, &columns, |one| {
            let line = one.line.map(|line| line.to_string());
            vec![
                Cell::from(one.file.as_str()),
                Cell::Text(line.unwrap_or_default()),
            ]
        }))
    }
}

impl SecondOpinion {
    fn sentence(&self) -> String {
        match &self.failed {
            Some(why) => format!("{}: {why}", self.program),
            None => format!(
                "{}: {} and {}",
                self.program,
                counted(self.errors.len(), "error"),
                counted(self.warnings, "warning")
            ),
        }
    }
}
