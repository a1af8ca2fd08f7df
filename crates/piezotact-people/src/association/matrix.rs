//! The matrix itself: presented × answered, with counts, shares and intervals.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::answer::{Answer, AnswerTable, Declared, Stimulus};
use crate::interval::clustered_interval;

/// Which answers a matrix is made of: those that agree with everything that is stated.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Selection {
    /// Of this task.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub task: Option<String>,
    /// Of this participant.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub participant: Option<String>,
    /// Of this set.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub set: Option<String>,
    /// Not of these tasks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub without_tasks: Vec<String>,
}

/// What becomes of trials that something was wrong with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum FlaggedTrials {
    /// They count, and each cell says how many it has.
    #[default]
    Kept,
    /// They are left out.
    LeftOut,
}

/// What a matrix is made of.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct MatrixConfig {
    /// Which answers.
    pub selection: Selection,
    /// What becomes of flagged trials.
    pub flagged: FlaggedTrials,
}

/// How often one stimulus was declared to be one sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Cell {
    /// The sample that was answered.
    pub answered: String,
    /// How often the stimulus was declared to be it.
    pub declared: usize,
    /// How often the stimulus was presented and this sample could be answered; at 0 the pair is untested.
    pub offered: usize,
    /// Declared over presentations of the stimulus, %; `None` for an untested pair.
    pub percent: Option<f64>,
    /// The 95 % interval of `percent`, clustered by participant; `None` where there are too few participants.
    pub interval_percent: Option<[f64; 2]>,
    /// How many participants declared it.
    pub participants: usize,
    /// How many of the declarations are from flagged trials.
    pub flagged: usize,
}

impl Cell {
    /// Whether the sample was ever offered for the stimulus.
    #[must_use]
    pub fn is_tested(&self) -> bool {
        self.offered > 0
    }
}

/// The answers to one stimulus.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Row {
    /// The stimulus that was presented.
    #[serde(flatten)]
    pub stimulus: Stimulus,
    /// How often it was presented.
    pub presented: usize,
    /// To how many participants.
    pub participants: usize,
    /// How many of its presentations are flagged.
    pub flagged: usize,
    /// One cell for each sample.
    pub cells: Vec<Cell>,
}

/// An association matrix: a row for each declared stimulus, a column for each declared sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct AssociationMatrix {
    /// The samples of the columns.
    pub samples: Vec<String>,
    /// The rows.
    pub rows: Vec<Row>,
}

impl AssociationMatrix {
    /// The cell of a stimulus and a sample; `None` for names that are not declared.
    #[must_use]
    pub fn cell(&self, presented: &str, answered: &str) -> Option<&Cell> {
        let row = self
            .rows
            .iter()
            .find(|row| row.stimulus.name == presented)?;
        row.cells.iter().find(|cell| cell.answered == answered)
    }

    /// How many presentations it counts.
    #[must_use]
    pub fn presentations(&self) -> usize {
        self.rows.iter().map(|row| row.presented).sum()
    }

    /// The share of presentations that were declared to be what is expected, 0–1; `None` without presentations.
    #[must_use]
    pub fn expected_share(&self) -> Option<f64> {
        let presentations = self.presentations();
        let expected = self.rows.iter().flat_map(|row| {
            let cells = row.cells.iter();
            cells.filter(|cell| cell.answered == row.stimulus.expected)
        });
        let expected: usize = expected.map(|cell| cell.declared).sum();
        (presentations > 0).then(|| expected as f64 / presentations as f64)
    }

    /// The same with its rows in the order of the samples that they are expected to be declared as: expected associations lie
    /// on the diagonal (thesis figure 63).
    #[must_use]
    pub fn by_expected(mut self) -> Self {
        let samples = self.samples.clone();
        let place = |row: &Row| {
            let expected = &row.stimulus.expected;
            samples.iter().position(|sample| sample == expected)
        };
        self.rows.sort_by_key(place);
        self
    }
}

/// The answers that a selection takes.
pub(super) fn selected<'a>(
    table: &'a AnswerTable,
    config: &'a MatrixConfig,
) -> impl Iterator<Item = &'a Answer> {
    let Selection {
        task,
        participant,
        set,
        without_tasks,
    } = &config.selection;
    let is = |wish: &Option<String>, found: &str| wish.as_ref().is_none_or(|wish| wish == found);
    table.answers().iter().filter(move |answer| {
        let counts = config.flagged == FlaggedTrials::Kept || answer.flags.is_empty();
        counts
            && is(task, &answer.task)
            && is(participant, &answer.participant)
            && is(set, &answer.set)
            && !without_tasks.contains(&answer.task)
    })
}

/// The association matrix of the answers that `config` selects: declared over presented for each stimulus, %; rows and columns
/// as declared, so that a sample never answered keeps its column, and a stimulus never presented its row. A sample that was
/// never offered for a stimulus is untested.
///
/// Source: thesis 2.6.3; intervals: [`clustered_interval`].
///
/// ```
/// use piezotact_people::association::{Answer, AnswerTable, Declared, MatrixConfig, association_matrix};
/// let answer = |trial: &str, presented: &str, answered: &str| Answer {
///     participant: "P1".into(),
///     trial: trial.into(),
///     presented: presented.into(),
///     answered: answered.into(),
///     ..Answer::default()
/// };
/// let answers = vec![answer("1", "SC", "SC"), answer("2", "SC", "SD"), answer("3", "SC", "SC")];
/// let table = AnswerTable::new(Declared::plain(&["SC", "SD"]), answers).unwrap();
/// let matrix = association_matrix(&table, &MatrixConfig::default());
/// let cell = matrix.cell("SC", "SD").unwrap();
/// assert_eq!((cell.declared, cell.percent), (1, Some(100.0 / 3.0)));
/// ```
#[must_use]
pub fn association_matrix(table: &AnswerTable, config: &MatrixConfig) -> AssociationMatrix {
    let Declared { samples, stimuli } = table.declared();
    let answers: Vec<&Answer> = selected(table, config).collect();
    let rows = stimuli.iter().map(|stimulus| {
        let of_it = answers.iter().filter(|a| a.presented == stimulus.name);
        row(stimulus, samples, of_it.copied().collect())
    });
    AssociationMatrix {
        samples: samples.clone(),
        rows: rows.collect(),
    }
}

fn percent_of(declared: usize, presented: usize) -> f64 {
    100.0 * declared as f64 / presented as f64
}

fn row(stimulus: &Stimulus, samples: &[String], answers: Vec<&Answer>) -> Row {
    let mut people: BTreeMap<&str, usize> = BTreeMap::new();
    for answer in &answers {
        *people.entry(&answer.participant).or_default() += 1;
    }
    let cells = samples.iter().map(|sample| {
        let declared = || answers.iter().filter(|a| a.answered == *sample);
        let offered = answers.iter().filter(|a| a.offered.contains(sample));
        let offered = offered.count();
        let each: Vec<(usize, usize)> = people
            .iter()
            .map(|(person, trials)| {
                let of_them = declared().filter(|a| a.participant == *person);
                (of_them.count(), *trials)
            })
            .collect();
        let found = clustered_interval(&each).filter(|_| offered > 0);
        let percent = |[low, high]: [f64; 2]| [100.0 * low, 100.0 * high];
        Cell {
            answered: sample.clone(),
            declared: declared().count(),
            offered,
            percent: found.map(|_| percent_of(declared().count(), answers.len())),
            interval_percent: found.and_then(|found| found.interval).map(percent),
            participants: each.iter().filter(|(declared, _)| *declared > 0).count(),
            flagged: declared().filter(|a| !a.flags.is_empty()).count(),
        }
    });
    Row {
        stimulus: stimulus.clone(),
        presented: answers.len(),
        participants: people.len(),
        flagged: answers.iter().filter(|a| !a.flags.is_empty()).count(),
        cells: cells.collect(),
    }
}
