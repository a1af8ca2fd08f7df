//! The data dictionary of a campaign: what each column of its table of answers means in each task.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::LazyLock;

use piezotact::document::Content;
use serde::{Deserialize, Serialize};

use super::protocol::{Block, Labels, OrderKey, Protocol, Question, Task, TaskKind, When};

/// The columns of a table of answers, in their order.
pub const ANSWER_COLUMNS: [&str; 14] = [
    "participant",
    "session",
    "task",
    "set",
    "trial",
    "position",
    "presented",
    "source",
    "expected",
    "offered",
    "answered",
    "flags",
    "rehearsal",
    "judge",
];

/// What a column means, with the fields that BIDS has for it.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "PascalCase")]
pub struct ColumnMeaning {
    /// What it holds.
    pub description: String,
    /// The unit; absent for texts. "1" is a number without a unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub units: Option<String>,
    /// The values that it can have, with their meaning; absent where they are not listed.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub levels: BTreeMap<String, String>,
    /// What stands between several values in a cell; absent where a cell has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub delimiter: Option<String>,
}

/// The columns of each table by name.
static TABLES: LazyLock<BTreeMap<String, BTreeMap<String, ColumnMeaning>>> =
    LazyLock::new(|| toml::from_str(include_str!("../../columns.toml")).unwrap_or_default());

/// What the columns of a table mean, by the name of the table: `events`, `features`; none for a table that is not listed.
///
/// Source: `columns.toml`; BIDS 1.11, tabular files, for the fields of a column.
#[must_use]
pub fn columns_of(table: &str) -> BTreeMap<String, ColumnMeaning> {
    TABLES.get(table).cloned().unwrap_or_default()
}

/// One column of a table; empty where it is not listed.
pub(crate) fn column(table: &str, name: &str) -> ColumnMeaning {
    let found = TABLES.get(table).and_then(|columns| columns.get(name));
    found.cloned().unwrap_or_default()
}

/// The columns of a task.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct TaskDictionary {
    /// The task.
    pub task: String,
    /// Its title.
    pub title: String,
    /// What the participant is asked, word for word.
    pub instruction: String,
    /// What a row of the table is; absent where nothing is answered.
    pub row: Option<String>,
    /// The columns in their order; none for a task without answers.
    pub columns: Vec<String>,
    /// What they mean.
    pub meanings: BTreeMap<String, ColumnMeaning>,
}

/// The data dictionary of a campaign.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct DataDictionary {
    /// The protocol's name.
    pub protocol: String,
    /// Its title.
    pub title: String,
    /// The tasks in the order of the protocol.
    pub tasks: Vec<TaskDictionary>,
}

impl Content for DataDictionary {
    const SCHEMA: &'static str = "campaign_dictionary";
}

/// The columns of the answers to each task of `protocol`: description, unit and levels.
///
/// Source: docs/decisions/campaigns.md; BIDS, tabular files, for the fields of a column.
#[must_use]
pub fn dictionary(protocol: &Protocol) -> DataDictionary {
    let tasks = protocol.tasks.iter();
    DataDictionary {
        protocol: protocol.name.clone(),
        title: protocol.title.clone(),
        tasks: tasks.map(|task| Described::of(protocol, task)).collect(),
    }
}

/// A task with where it stands in the sessions.
struct Described<'a> {
    protocol: &'a Protocol,
    task: &'a Task,
    /// The sessions with their blocks in which it stands.
    blocks: Vec<(&'a str, When, &'a Block)>,
}

impl<'a> Described<'a> {
    fn of(protocol: &'a Protocol, task: &'a Task) -> TaskDictionary {
        let sessions = protocol.sessions.iter();
        let blocks = sessions.flat_map(|session| {
            let blocks = session.blocks.iter();
            blocks.map(|block| (session.name.as_str(), session.when, block))
        });
        let described = Self {
            protocol,
            task,
            blocks: blocks
                .filter(|(.., block)| block.tasks.contains(&task.name))
                .collect(),
        };
        let meanings: BTreeMap<String, ColumnMeaning> = ANSWER_COLUMNS
            .iter()
            .filter_map(|name| Some(((*name).to_owned(), described.column(name)?)))
            .collect();
        let columns = ANSWER_COLUMNS.iter().copied().map(str::to_owned);
        TaskDictionary {
            task: task.name.clone(),
            title: task.title.clone(),
            instruction: task.instruction.clone(),
            row: described.row().map(str::to_owned),
            columns: columns.filter(|name| meanings.contains_key(name)).collect(),
            meanings,
        }
    }

    /// What a row is; `None` where nothing is answered.
    fn row(&self) -> Option<&'static str> {
        match self.task.kind {
            TaskKind::Touch { .. } => None,
            TaskKind::Identify { .. } => Some("one sample that was handed over and named"),
            TaskKind::Order { .. } => {
                Some("one sample and the place in which it was put, in the table of orders")
            }
            TaskKind::Associate { .. } => {
                Some("one stimulus of a sequence and the sample associated to it")
            }
            TaskKind::Compare { .. } => Some(
                "one pair of stimuli that was compared, in the table of trials alone, where `answered` is called `answer`",
            ),
            TaskKind::Categorise { .. } => Some(
                "one sample and the descriptors chosen for it, in the table of trials alone, where `answered` is called `answer`",
            ),
            TaskKind::Rate { .. } => Some(
                "one sample and its rating, in the table of trials alone, where `answered` is called `answer`",
            ),
        }
    }

    /// The meaning of a column; `None` where the task has no such column.
    fn column(&self, name: &str) -> Option<ColumnMeaning> {
        if matches!(self.task.kind, TaskKind::Touch { .. }) {
            return None;
        }
        match name {
            "session" => Some(self.session()),
            "task" => Some(ColumnMeaning {
                levels: [(self.task.name.clone(), self.task.title.clone())].into(),
                ..column("answers", name)
            }),
            "set" => self.set(),
            "position" => self.position(),
            "presented" => Some(self.presented()),
            "source" => self.manipulated(name, |stimulus| &stimulus.of),
            "expected" => self.manipulated(name, |stimulus| stimulus.expected()),
            "offered" => self.offered(),
            "answered" => {
                let mut meaning = self.answered();
                if self.task.may_not_know {
                    meaning.description.push_str(
                        " n/a in the table of trials: the participant did not know; the table of answers has no row then.",
                    );
                }
                Some(meaning)
            }
            _ => Some(column("answers", name)),
        }
    }

    fn session(&self) -> ColumnMeaning {
        // The trials of other tasks have names of their own.
        let is_order = matches!(self.task.kind, TaskKind::Order { .. });
        let repeats = |session: &str| -> usize {
            let of_session = self.blocks.iter().filter(|(name, ..)| *name == session);
            of_session.map(|(.., block)| block.repeats as usize).sum()
        };
        // A repetition adds its number to the name.
        if is_order && self.blocks.iter().any(|(name, ..)| repeats(name) > 1) {
            return column("order", "session");
        }
        let levels = self.blocks.iter().map(|(session, when, _)| {
            let when = match when {
                When::AnyTime => "first, or at any time after the one before it",
                When::AnotherDay => "on a later day than the one before it",
            };
            ((*session).to_owned(), when.to_owned())
        });
        ColumnMeaning {
            levels: levels.collect(),
            ..column("answers", "session")
        }
    }

    fn set(&self) -> Option<ColumnMeaning> {
        let groups = (self.blocks.iter()).flat_map(|(.., block)| self.protocol.groups(&block.over));
        let names: BTreeSet<&str> = groups.flatten().filter_map(|group| group.set).collect();
        let sets = names.iter().filter_map(|name| self.protocol.set(name));
        let levels: BTreeMap<String, String> = sets
            .map(|set| (set.name.clone(), set.samples.join(", ")))
            .collect();
        (!levels.is_empty()).then(|| ColumnMeaning {
            levels,
            ..column("answers", "set")
        })
    }

    fn position(&self) -> Option<ColumnMeaning> {
        match &self.task.kind {
            TaskKind::Identify { .. } => Some(column("identify", "position")),
            TaskKind::Order { from, to, .. } => {
                Some(column("order", "position").with(&[("from", from), ("to", to)]))
            }
            TaskKind::Associate { .. } => Some(column("associate", "position")),
            _ => None,
        }
    }

    fn rendered_levels(&self) -> BTreeMap<String, String> {
        let meaning = |name: &str| {
            let made = self.protocol.stimuli.iter().find(|one| one.name == name);
            let Some(made) = made else {
                return format!("rendered vibration of {name}");
            };
            let mut words = vec![format!("rendered vibration of {}", made.of)];
            words.extend(made.of_spectrum());
            let level = made.level_in_words();
            let level = level.map_or(String::new(), |of| format!(" at {of}"));
            format!("{}{level}", words.join(", "))
        };
        let names = self.protocol.rendered_in(self.task).into_iter();
        names.map(|name| (name.to_owned(), meaning(name))).collect()
    }

    fn sample_levels(&self, what: &str) -> BTreeMap<String, String> {
        let samples = self.protocol.touched_in(self.task).into_iter();
        samples
            .map(|sample| (sample.clone(), format!("{what} {sample}")))
            .collect()
    }

    fn presented(&self) -> ColumnMeaning {
        let (table, levels) = match self.task.kind {
            TaskKind::Associate { .. } => ("associate", self.rendered_levels()),
            TaskKind::Compare { .. } => ("compare", self.rendered_levels()),
            TaskKind::Order { .. } => ("order", self.sample_levels("real sample")),
            _ => ("answers", self.sample_levels("real sample")),
        };
        ColumnMeaning {
            levels,
            ..column(table, "presented")
        }
    }

    fn manipulated(
        &self,
        name: &str,
        of: impl Fn(&'a super::protocol::Stimulus) -> &'a str,
    ) -> Option<ColumnMeaning> {
        let used = match self.task.kind {
            TaskKind::Associate { .. } | TaskKind::Compare { .. } => {
                self.protocol.rendered_in(self.task)
            }
            _ => return None,
        };
        let made = self.protocol.stimuli.iter();
        let made = made.filter(|stimulus| used.contains(stimulus.name.as_str()));
        let levels: BTreeMap<String, String> = made
            .map(of)
            .map(|sample| (sample.to_owned(), format!("sample {sample}")))
            .collect();
        (!levels.is_empty()).then(|| ColumnMeaning {
            levels,
            ..column("answers", name)
        })
    }

    fn offered(&self) -> Option<ColumnMeaning> {
        let choices = matches!(
            self.task.kind,
            TaskKind::Identify { .. } | TaskKind::Order { .. } | TaskKind::Associate { .. }
        );
        choices.then(|| ColumnMeaning {
            levels: self.sample_levels("sample"),
            ..column("answers", "offered")
        })
    }

    fn answered(&self) -> ColumnMeaning {
        let of = |table: &str| column(table, "answered");
        let samples = |meaning| ColumnMeaning {
            levels: self.sample_levels("sample"),
            ..meaning
        };
        match &self.task.kind {
            TaskKind::Touch { .. } => ColumnMeaning::default(),
            TaskKind::Identify { .. } => samples(of("identify")),
            TaskKind::Order { from, to, key } => {
                let key = match key {
                    OrderKey::AsListed => {
                        "the physical order, which is that of the protocol's list"
                    }
                    OrderKey::Reversed => {
                        "the physical order, which is that of the protocol's list from its end"
                    }
                    OrderKey::None => "the protocol's list; no order is right or wrong",
                };
                samples(of("order").with(&[("from", from), ("to", to), ("key", key)]))
            }
            TaskKind::Associate { labels, .. } => samples(of(match labels {
                Labels::Names => "associate",
                Labels::OwnOrder { .. } => "own_order",
            })),
            TaskKind::Compare { question, .. } => of(match question {
                Question::SameDifferent => "same_different",
                Question::Rougher => "rougher",
                Question::Stronger => "stronger",
            }),
            TaskKind::Categorise {
                descriptors,
                at_most,
            } => ColumnMeaning {
                levels: (descriptors.iter())
                    .map(|name| (name.clone(), format!("the sample feels {name}")))
                    .collect(),
                ..of("categorise").with(&[("at_most", &at_most.to_string())])
            },
            TaskKind::Rate { from, to, .. } => {
                of("rate").with(&[("from", &from.to_string()), ("to", &to.to_string())])
            }
        }
    }
}

/// A name in parts of letters and numbers, so that S2 stands before S13.
fn parts(name: &str) -> Vec<(String, u64)> {
    let mut parts = Vec::new();
    let mut rest = name;
    while !rest.is_empty() {
        let letters = rest.find(|sign: char| sign.is_ascii_digit());
        let (before, from) = rest.split_at(letters.unwrap_or(rest.len()));
        let digits = from.find(|sign: char| !sign.is_ascii_digit());
        let (number, after) = from.split_at(digits.unwrap_or(from.len()));
        parts.push((before.to_owned(), number.parse().unwrap_or(0)));
        rest = after;
    }
    parts
}

impl ColumnMeaning {
    /// With `{name}` in its description replaced by what the protocol states.
    pub(crate) fn with(mut self, stated: &[(&str, &str)]) -> Self {
        for (name, value) in stated {
            self.description = self.description.replace(&format!("{{{name}}}"), value);
        }
        self
    }

    /// The names of the levels, numbers in them by their size.
    #[must_use]
    pub fn level_names(&self) -> Vec<&str> {
        let mut names: Vec<&str> = self.levels.keys().map(String::as_str).collect();
        names.sort_by_key(|name| parts(name));
        names
    }
}

#[cfg(test)]
mod tests {
    use super::super::protocol::{LIBRARY, from_library};
    use super::*;

    fn of(protocol: &str, task: &str) -> TaskDictionary {
        let found = dictionary(&from_library(protocol).unwrap().unwrap());
        let mut tasks = found.tasks.into_iter();
        tasks.find(|of| of.task == task).unwrap()
    }

    #[test]
    fn every_listed_column_says_what_it_holds() {
        assert!(TABLES.len() > 20);
        for (table, columns) in &*TABLES {
            for (name, meaning) in columns {
                assert!(meaning.description.ends_with('.'), "{table} {name}");
                assert_ne!(meaning.units.as_deref(), Some(""), "{table} {name}");
            }
        }
    }

    #[test]
    fn every_task_of_the_library_is_described() {
        for (name, _) in LIBRARY {
            for task in dictionary(&from_library(name).unwrap().unwrap()).tasks {
                assert_eq!(
                    task.row.is_none(),
                    task.columns.is_empty(),
                    "{name} {}",
                    task.task
                );
                assert_eq!(task.columns.len(), task.meanings.len());
                for (column, meaning) in &task.meanings {
                    assert!(meaning.description.ends_with('.'), "{name} {column}");
                }
            }
        }
    }

    #[test]
    fn levels_are_those_of_the_protocol() {
        let task3 = of("amplitude_inversion", "task3");
        assert_eq!(task3.columns, ANSWER_COLUMNS);
        let presented = &task3.meanings["presented"].levels;
        assert_eq!(
            presented["S2 INVERTED"],
            "rendered vibration of S2 at the rms level of S13"
        );
        assert!(task3.meanings["expected"].levels.contains_key("S13"));
        assert_eq!(
            task3.meanings["presented"].level_names()[..3],
            ["S2", "S2 INVERTED", "S5"]
        );
        // Only what stands in a set can be answered.
        let answered = &of("isotropic_triplets", "task3").meanings["answered"].levels;
        assert!(answered.contains_key("S13") && !answered.contains_key("NO"));
        let all = of("isotropic_triplets", "task1");
        assert!(all.meanings["answered"].levels.contains_key("NO"));
        assert!(!all.meanings.contains_key("set") && !all.meanings.contains_key("source"));
        let sets = &of("isotropic_triplets", "task2").meanings["set"].levels;
        assert_eq!((sets.len(), sets["A"].as_str()), (12, "S2, S4, S8"));
    }
}
