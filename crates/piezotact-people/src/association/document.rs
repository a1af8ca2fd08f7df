//! Everything that answers say, as one value; reports, tables and documents are made of it.

use crate::association::AssociationError;
use piezotact::warning::{Few, FewWarning};
use std::collections::{BTreeMap, BTreeSet};

use piezotact::Warning;
use piezotact::compare::{CompareWarning, Mixed, Named, plain_name};
use piezotact::criterion::Outcome;
use piezotact::discrimination::Model;
use piezotact::document::Content;
use piezotact::number::counted;
use piezotact::page::{Cell as TableCell, Column, Table};
use serde::{Deserialize, Serialize};

use super::answer::{Answer, AnswerTable, Flag};
use super::asked::Asked;
use super::compared::Compared;
use super::confused::{ConfusedPair, PairOutcome, beside_once, beside_task, confused_pairs};
use super::expected::{ExpectedShare, StimulusKind, expected_share};
use super::felt::{Felt, FeltCriterion, FeltRecording, felt_pairs};
use super::matrix::{
    AssociationMatrix, FlaggedTrials, MatrixConfig, Selection, association_matrix,
};
use super::order::{Ordering, ordering};
use super::same_person::{SamePerson, Unbalanced, unbalanced, warnings_of_people};
use super::warning::{AssociationWarning, NotDeclared};
use crate::interval::MIN_PARTICIPANTS;

/// What an untested pair is called in tables for programs.
pub(super) const UNTESTED: &str = "n/a";

/// A terminal shows matrices of up to so many samples.
const TERMINAL_SAMPLES: usize = 30;

/// What was felt in a pair, in tables of cells: heading and name.
const FELT_COLUMNS: [(&str, &str); 7] = [
    ("compared by", "felt_compared"),
    ("level, JND", "felt_level_jnd"),
    ("level separates", "felt_level_separates"),
    ("spectrum, JND", "felt_spectrum_jnd"),
    ("spectrum separates", "felt_spectrum_separates"),
    ("time course, JND", "felt_time_jnd"),
    ("time course separates", "felt_time_separates"),
];

/// What answers are divided by: one matrix for each.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Grouping {
    /// The task.
    Task,
    /// The participant.
    Participant,
    /// The set of samples.
    Set,
}

impl Grouping {
    /// Its name: "task".
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Task => "task",
            Self::Participant => "participant",
            Self::Set => "set",
        }
    }

    fn of(self, answer: &Answer) -> &str {
        match self {
            Self::Task => &answer.task,
            Self::Participant => &answer.participant,
            Self::Set => &answer.set,
        }
    }
}

/// What is made of answers.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct AssociationConfig {
    /// Which answers count.
    #[serde(flatten)]
    pub matrix: MatrixConfig,
    /// One matrix more for each of these.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by: Option<Grouping>,
    /// The tasks in which samples were put in order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ordering_tasks: Vec<String>,
}

/// The matrix of a part of the answers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct GroupMatrix {
    /// The task, participant or set; "all" for all answers together.
    pub group: String,
    /// How many answers of a group are as expected, beside chance; of all answers it stands in the document itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected: Option<ExpectedShare>,
    /// The matrix.
    #[serde(flatten)]
    pub matrix: AssociationMatrix,
}

/// What answers say: matrices, pairs that are confused, orders.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Association {
    /// Whose answers they are, for the report.
    #[serde(skip)]
    pub name: String,
    /// What was asked for.
    pub config: AssociationConfig,
    /// What the study asked; absent for a table of answers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub asked: Option<Asked>,
    /// How many answers count.
    pub answers: usize,
    /// How many of them virtual volunteers gave.
    pub virtual_answers: usize,
    /// Of how many participants.
    pub participants: usize,
    /// How many rehearsals were excluded.
    pub rehearsals: usize,
    /// How many answers are as expected, beside chance: of all stimuli, and of plain and manipulated ones where there are both.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub expected: Vec<ExpectedShare>,
    /// The matrix of all answers, then one for each group.
    pub matrices: Vec<GroupMatrix>,
    /// All pairs, the confused ones first.
    pub pairs: Vec<ConfusedPair>,
    /// The orders of each ordering task.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub orderings: Vec<Ordering>,
    /// What was felt in confused pairs, where recordings of it were given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub felt: Option<Felt>,
    /// The differences that were asked for.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub comparisons: Vec<Compared>,
    /// People, sessions and tasks whose answers may be those of one person, or the same answers twice.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub same_people: Vec<SamePerson>,
    /// Who gave most of the answers, where they say little of people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unbalanced: Option<Unbalanced>,
    /// What it leaves open.
    #[serde(alias = "doubts")]
    pub warnings: Vec<Warning>,
}

impl Content for Association {
    const SCHEMA: &'static str = "association";
}

/// What the answers of `table` say, as `config` asks for it. Places in the orders of its ordering tasks are no associations, as each
/// follows from the others: their answers are left out of matrices and pairs, where there are others.
///
/// Source: thesis 2.6.3; docs/decisions/answers.md.
///
/// # Errors
/// [`AssociationError`] where no answer is selected, or a task is no ordering task.
pub fn associate(
    table: &AnswerTable,
    config: &AssociationConfig,
) -> Result<Association, AssociationError> {
    let orderings = config.ordering_tasks.iter();
    let orderings = orderings.map(|task| ordering(table, &config.matrix, task));
    let orderings = orderings.collect::<Result<_, _>>();
    let config = &without_orders(table, config);
    let selected: Vec<&Answer> = super::matrix::selected(table, &config.matrix).collect();
    if selected.is_empty() {
        return Err(nothing_selected(table, &config.matrix));
    }
    let orderings = orderings?;
    let different = |of: &dyn Fn(&Answer) -> &str| -> Vec<String> {
        let found: BTreeSet<&str> = selected.iter().map(|answer| of(answer)).collect();
        found.into_iter().map(Into::into).collect()
    };
    let same_people = table.same_people();
    let once = table.counted_once(&same_people);
    let once = once.as_ref();
    let mut matrices = vec![GroupMatrix {
        group: "all".into(),
        expected: None,
        matrix: association_matrix(table, &config.matrix).by_expected(),
    }];
    if let Some(by) = config.by {
        for group in different(&|answer| by.of(answer)) {
            let mut part = config.matrix.clone();
            let Selection {
                task,
                participant,
                set,
                without_tasks: _,
            } = &mut part.selection;
            *match by {
                Grouping::Task => task,
                Grouping::Participant => participant,
                Grouping::Set => set,
            } = Some(group.clone());
            let matrix = association_matrix(table, &part).by_expected();
            let expected = share_beside_once([Some(table), once], &part, StimulusKind::All);
            matrices.push(GroupMatrix {
                group,
                expected,
                matrix,
            });
        }
    }
    let pairs = confused_pairs(table, &config.matrix);
    let pairs = match once {
        Some(once) => beside_once(pairs, &confused_pairs(once, &config.matrix)),
        None => pairs,
    };
    let tasks = match config.matrix.selection.task {
        Some(_) => Vec::new(),
        None => different(&|answer| &answer.task),
    };
    let pairs = match tasks.len() {
        0 | 1 => pairs,
        _ => tasks.into_iter().fold(pairs, |pairs, task| {
            let mut part = config.matrix.clone();
            part.selection.task = Some(task);
            beside_task(pairs, &confused_pairs(table, &part))
        }),
    };
    let expected = expected_shares([Some(table), once], &config.matrix);
    let unbalanced = unbalanced(selected.iter().copied());
    let mut warnings = warnings(table, config, &selected, &expected, &pairs);
    warnings.splice(0..0, warnings_of_people(&same_people, unbalanced.as_ref()));
    warnings.extend(samples_alike(&selected));
    let participants = different(&|answer| &answer.participant).len();
    Ok(Association {
        name: String::new(),
        asked: None,
        answers: selected.len(),
        virtual_answers: selected.iter().filter(|a| a.judge.is_some()).count(),
        participants,
        rehearsals: table.rehearsals(),
        expected,
        matrices,
        orderings,
        same_people,
        unbalanced,
        warnings,
        config: config.clone(),
        pairs,
        felt: None,
        comparisons: Vec::new(),
    })
}

/// `config` without the answers of its ordering tasks, where there are answers of others, flagged or not: places in orders never stand for
/// associations that were left out.
fn without_orders(table: &AnswerTable, config: &AssociationConfig) -> AssociationConfig {
    let mut without = config.clone();
    without
        .matrix
        .selection
        .without_tasks
        .extend(config.ordering_tasks.iter().cloned());
    let all = MatrixConfig {
        flagged: FlaggedTrials::Kept,
        ..without.matrix.clone()
    };
    let is_left = super::matrix::selected(table, &all).count() > 0;
    if is_left { without } else { config.clone() }
}

/// The share of expected answers of all stimuli, and of plain and manipulated ones where there are both.
fn expected_shares(tables: [Option<&AnswerTable>; 2], config: &MatrixConfig) -> Vec<ExpectedShare> {
    use StimulusKind as Of;
    let share = |kind| share_beside_once(tables, config, kind);
    let apart: Vec<ExpectedShare> = [Of::Plain, Of::Manipulated]
        .into_iter()
        .filter_map(share)
        .collect();
    let apart = if apart.len() == 2 { apart } else { Vec::new() };
    share(Of::All).into_iter().chain(apart).collect()
}

/// The share of expected answers of the first, beside that of the second, in which people are counted once.
pub(super) fn share_beside_once(
    tables: [Option<&AnswerTable>; 2],
    config: &MatrixConfig,
    kind: StimulusKind,
) -> Option<ExpectedShare> {
    let [found, once] = tables.map(|table| {
        let table = table?;
        let answers: Vec<&Answer> = super::matrix::selected(table, config).collect();
        expected_share(table.declared(), &answers, kind)
    });
    Some(found?.beside_once(once))
}

fn nothing_selected(table: &AnswerTable, config: &MatrixConfig) -> AssociationError {
    let kept = MatrixConfig {
        flagged: FlaggedTrials::Kept,
        ..config.clone()
    };
    let flagged = super::matrix::selected(table, &kept).count();
    if flagged > 0 {
        return AssociationError::OnlyFlagged { flagged };
    }
    let wanted = [
        ("task", &config.selection.task),
        ("participant", &config.selection.participant),
        ("set", &config.selection.set),
    ];
    let wanted = wanted.into_iter();
    let wanted: Vec<String> = wanted
        .filter_map(|(name, value)| Some(format!("{name} {}", value.as_ref()?)))
        .collect();
    let found = |of: &dyn Fn(&Answer) -> &str| {
        let all: BTreeSet<&str> = table.answers().iter().map(of).collect();
        all.into_iter().collect::<Vec<_>>().join(", ")
    };
    AssociationError::NothingSelected {
        wanted: wanted.join(", "),
        tasks: found(&|answer| &answer.task),
        sets: found(&|answer| &answer.set),
    }
}

fn warnings(
    table: &AnswerTable,
    config: &AssociationConfig,
    selected: &[&Answer],
    expected: &[ExpectedShare],
    pairs: &[ConfusedPair],
) -> Vec<Warning> {
    let participants: BTreeSet<&str> = selected.iter().map(|a| a.participant.as_str()).collect();
    let participants = participants.len();
    let few = (participants < MIN_PARTICIPANTS).then(|| {
        Warning::from(FewWarning::Few {
            found: participants,
            recommended: MIN_PARTICIPANTS,
            what: Few::Answering,
        })
    });
    let mut found = Vec::new();
    if table.inferred() > 0 {
        let answers = table.inferred();
        found.push(AssociationWarning::NotDeclared {
            what: NotDeclared::Offered { answers },
        });
    }
    match config.matrix.flagged {
        FlaggedTrials::Kept => {
            let (trials, of) = flagged(selected.iter().copied());
            found.extend((trials > 0).then_some(AssociationWarning::Flagged {
                trials,
                of,
                kept: true,
            }));
        }
        FlaggedTrials::LeftOut => {
            let kept = MatrixConfig {
                flagged: FlaggedTrials::Kept,
                ..config.matrix.clone()
            };
            let (trials, of) = flagged(super::matrix::selected(table, &kept));
            found.extend((trials > 0).then_some(AssociationWarning::Flagged {
                trials,
                of,
                kept: false,
            }));
        }
    }
    let untested = pairs.iter().filter(|p| p.outcome == PairOutcome::Untested);
    let untested = untested.count();
    if untested > 0 {
        let of = pairs.len();
        found.push(AssociationWarning::Untested {
            pairs: untested,
            of,
        });
    }
    let confused = pairs.iter().filter(|p| p.outcome == PairOutcome::Confused);
    let confused = confused.count();
    let share = expected.first();
    let some_guess = share.and_then(|share| share.guessing);
    found.extend(some_guess.map(|guessing| AssociationWarning::SomeGuess { guessing }));
    let guessed = share.is_some_and(|share| {
        share.criterion.interval.is_some() && share.criterion.outcome == Outcome::NotDecided
    });
    if guessed && confused > 0 {
        found.push(AssociationWarning::Guesses { pairs: confused });
    }
    few.into_iter()
        .chain(found.into_iter().map(Warning::from))
        .collect()
}

/// Samples whose names differ in capital letters, blanks or leading zeros alone.
fn samples_alike(answers: &[&Answer]) -> Vec<Warning> {
    let names = answers
        .iter()
        .flat_map(|answer| [answer.presented.as_str(), answer.answered.as_str()]);
    let mut first: BTreeMap<String, &str> = BTreeMap::new();
    let mut found = Vec::new();
    for name in names.collect::<BTreeSet<&str>>() {
        let one = *first.entry(plain_name(name)).or_insert(name);
        if one != name {
            let how = Mixed::NamesAlike {
                of: Named::Sample,
                one: one.to_owned(),
                other: name.to_owned(),
            };
            found.push(CompareWarning::Mixed { how }.into());
        }
    }
    found
}

/// How many of `answers` are flagged, and how many have each flag.
fn flagged<'a>(answers: impl Iterator<Item = &'a Answer>) -> (usize, [usize; 4]) {
    let (mut all, mut of) = (0, [0; 4]);
    for answer in answers.filter(|answer| !answer.flags.is_empty()) {
        all += 1;
        for (count, flag) in of.iter_mut().zip(Flag::ALL) {
            *count += usize::from(answer.flags.contains(&flag));
        }
    }
    (all, of)
}

fn count(value: usize) -> TableCell {
    TableCell::Number(value as f64)
}

/// A number; "n/a" for a pair that is untested.
fn tested(value: Option<f64>) -> TableCell {
    value.map_or_else(|| TableCell::from(UNTESTED), TableCell::Number)
}

impl Association {
    /// The matrix of all answers; `None` in a document without matrices.
    #[must_use]
    pub fn all(&self) -> Option<&AssociationMatrix> {
        self.matrices.first().map(|group| &group.matrix)
    }

    /// The same with what was felt in confused pairs, by `recordings` of the fingernail's acceleration and `model`, and the warnings about
    /// it; `table` holds the answers that it was made of.
    #[must_use]
    pub fn with_felt(
        mut self,
        table: &AnswerTable,
        recordings: &[FeltRecording],
        model: &Model,
    ) -> Self {
        let answers = super::matrix::selected(table, &self.config.matrix);
        let people = answers.map(|answer| answer.participant.clone()).collect();
        let (felt, warnings) = felt_pairs(&self.pairs, recordings, &people, model);
        self.felt = Some(felt);
        self.warnings.extend(warnings);
        self
    }

    /// How many pairs have each outcome: confused, not decided, not confused, untested.
    #[must_use]
    pub fn outcomes(&self) -> [(PairOutcome, usize); 4] {
        use PairOutcome as Of;
        [Of::Confused, Of::NotDecided, Of::NotConfused, Of::Untested].map(|outcome| {
            let pairs = self.pairs.iter().filter(|pair| pair.outcome == outcome);
            (outcome, pairs.count())
        })
    }

    /// What was found: how many answers are as expected, beside chance, and how many pairs are confused.
    #[must_use]
    pub fn sentence(&self) -> String {
        let shares: Vec<String> = (self.expected.iter())
            .map(|share| {
                let of = match share.stimuli {
                    StimulusKind::All => String::new(),
                    StimulusKind::Plain => format!("{} to plain stimuli, ", share.answers),
                    StimulusKind::Manipulated => {
                        format!("{} to manipulated ones, ", share.answers)
                    }
                };
                format!("{of}{}", share.words())
            })
            .collect();
        let expected = match shares.is_empty() {
            true => String::new(),
            false => format!(": {}", shares.join("; ")),
        };
        let outcomes = self.outcomes();
        let pairs = outcomes
            .iter()
            .map(|(outcome, pairs)| format!("{pairs} {}", outcome.word()));
        let pairs: Vec<String> = pairs.collect();
        let who = match self.virtual_answers {
            0 => "",
            all if all == self.answers => "Simulated: ",
            _ => "Partly simulated: ",
        };
        format!(
            "{who}{} answers of {}{expected}. Pairs: {}.",
            self.answers,
            match self.virtual_answers {
                all if all > 0 && all == self.answers => {
                    counted(self.participants, "virtual volunteer")
                }
                _ => counted(self.participants, "participant"),
            },
            pairs.join(", ")
        )
    }

    /// How many answers of each group are as expected, a line each; none where all answers are one group.
    #[must_use]
    pub fn group_sentences(&self) -> Vec<String> {
        let by = self.config.by.map_or("", Grouping::name);
        let groups = self.matrices.iter();
        let said = groups.filter_map(|group| Some((group, group.expected.as_ref()?)));
        said.map(|(group, share)| {
            format!(
                "{by} {}: {} answers, {}",
                group.group,
                share.answers,
                share.words()
            )
        })
        .collect()
    }

    /// The matrix of all answers in percent, a row for each stimulus; "n/a" for untested pairs. `None` in a document without
    /// matrices, and for one too broad for a terminal.
    #[must_use]
    pub fn matrix_table(&self) -> Option<Table> {
        let matrix = self.all().filter(|m| m.samples.len() <= TERMINAL_SAMPLES)?;
        let head = ["presented", "times"].map(|name| Column::new(name, name));
        let samples = matrix.samples.iter().map(|name| Column::new(name, name));
        let mut table = Table::new(head.into_iter().chain(samples));
        table.rows = (matrix.rows.iter())
            .map(|row| {
                let percent = |value: Option<f64>| {
                    value.map_or_else(|| UNTESTED.to_owned(), |percent| format!("{percent:.0}"))
                };
                let cells = row.cells.iter();
                let cells = cells.map(|cell| TableCell::from(percent(cell.percent)));
                let times = TableCell::from(row.presented.to_string());
                let name = TableCell::from(row.stimulus.name.as_str());
                [name, times].into_iter().chain(cells).collect()
            })
            .collect();
        Some(table)
    }

    /// All cells as a tidy table, one row for each cell of each matrix; an untested pair has "n/a" as its percentage, and an
    /// interval that could not be estimated is empty.
    #[must_use]
    pub fn cells_table(&self) -> Table {
        let names = [
            ("group", "group"),
            ("presented", "presented"),
            ("source", "source"),
            ("expected", "expected"),
            ("answered", "answered"),
            ("declared", "declared"),
            ("presentations", "presentations"),
            ("offered", "offered"),
            ("%", "percent"),
            ("95 % from", "percent_low"),
            ("95 % to", "percent_high"),
            ("participants", "participants"),
            ("flagged", "flagged"),
        ];
        let felt = self.felt.as_ref().map(|_| FELT_COLUMNS);
        let names = names.into_iter().chain(felt.into_iter().flatten());
        let virtual_answers = (self.virtual_answers > 0).then_some(self.virtual_answers);
        let names = names
            .chain(virtual_answers.map(|_| ("virtual answers, all", "virtual_answers_of_all")));
        let mut table = Table::new(names.map(|(heading, name)| Column::new(heading, name)));
        for GroupMatrix { group, matrix, .. } in &self.matrices {
            for row in &matrix.rows {
                table.rows.extend(row.cells.iter().map(|cell| {
                    let end = |i: usize| cell.interval_percent.map(|ends| ends[i]);
                    let known = vec![
                        TableCell::from(group.as_str()),
                        TableCell::from(row.stimulus.name.as_str()),
                        TableCell::from(row.stimulus.source.as_str()),
                        TableCell::from(row.stimulus.expected.as_str()),
                        TableCell::from(cell.answered.as_str()),
                        count(cell.declared),
                        count(row.presented),
                        count(cell.offered),
                        tested(cell.percent),
                        TableCell::from(end(0)),
                        TableCell::from(end(1)),
                        count(cell.participants),
                        count(cell.flagged),
                    ];
                    let felt = self.felt_cells(&row.stimulus.name, &cell.answered);
                    let simulated = virtual_answers.map(count);
                    known.into_iter().chain(felt).chain(simulated).collect()
                }));
            }
        }
        table
    }

    /// What was felt in the pair of `presented` and `answered`, as [`FELT_COLUMNS`] has it; nothing where no recordings were given.
    fn felt_cells(&self, presented: &str, answered: &str) -> Vec<TableCell> {
        let Some(felt) = &self.felt else {
            return Vec::new();
        };
        let is = |pair: &[String; 2]| {
            let [a, b] = pair.each_ref().map(String::as_str);
            (a, b) == (presented, answered) || (b, a) == (presented, answered)
        };
        let found = felt.pairs.iter().find(|one| is(&one.pair));
        let Some(pair) = found.filter(|one| !one.comparisons.is_empty()) else {
            return vec![TableCell::Missing(()); FELT_COLUMNS.len()];
        };
        let [level, spectrum, time] = pair.separated();
        vec![
            count(pair.comparisons.len()),
            TableCell::from(pair.median_jnd(FeltCriterion::Level)),
            count(level),
            TableCell::from(pair.median_jnd(FeltCriterion::Spectrum)),
            count(spectrum),
            TableCell::from(pair.median_jnd(FeltCriterion::TimeCourse)),
            count(time),
        ]
    }

    /// The pairs that were tested as a table, the most confused first.
    #[must_use]
    pub fn pairs_table(&self) -> Table {
        let names = [
            ("pair", "pair"),
            ("declared / presented", "declared_of_presented"),
            ("the other way", "declared_of_presented_reverse"),
            ("confused, %", "confused_percent"),
            ("95 % interval, %", "interval_percent"),
            ("outcome", "outcome"),
        ];
        let mut table = Table::new(names.map(|(heading, name)| Column::new(heading, name)));
        let tested = self.pairs.iter();
        let tested = tested.filter(|pair| pair.outcome != PairOutcome::Untested);
        table.rows = tested
            .map(|pair| {
                let [first, second] = &pair.pair;
                let of = |i: usize| match pair.presented[i] {
                    0 => TableCell::Missing(()),
                    presented => TableCell::from(format!("{} / {presented}", pair.declared[i])),
                };
                let interval = pair.criterion.interval;
                vec![
                    TableCell::from(format!("{first} – {second}")),
                    of(0),
                    of(1),
                    pair.criterion
                        .found
                        .map_or(TableCell::Missing(()), |share| {
                            TableCell::from(format!("{:.1}", 100.0 * share))
                        }),
                    interval.map_or(TableCell::Missing(()), |[low, high]| {
                        TableCell::from(format!("{:.1} to {:.1}", 100.0 * low, 100.0 * high))
                    }),
                    TableCell::from(pair.outcome.word()),
                ]
            })
            .collect();
        table
    }
}
