//! What the columns of responses and events mean.

use std::collections::BTreeMap;

use super::{BETWEEN, STIMULUS, event_columns, plays, response_columns};
use crate::campaign::dictionary::{ColumnMeaning, column, dictionary};
use crate::campaign::protocol::{Protocol, TaskKind};

/// The columns of one task.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct BehaviourMeanings {
    pub task: String,
    /// Of the responses; empty where nothing is answered.
    pub responses: BTreeMap<String, ColumnMeaning>,
    pub events: BTreeMap<String, ColumnMeaning>,
}

/// What the columns of [`super::behaviour`] mean, for each task of `protocol`: description, unit and levels.
///
/// Source: docs/decisions/store.md; BIDS 1.11, tabular files, for the fields of a column.
#[must_use]
pub fn behaviour_meanings(protocol: &Protocol) -> Vec<BehaviourMeanings> {
    let known = dictionary(protocol).tasks;
    let tasks = protocol.tasks.iter().zip(known);
    let meanings = tasks.map(|(task, known)| {
        let of_answers = known.meanings;
        let own = |name: &str| of_answers.get(name).cloned().unwrap_or_default();
        let of = Meanings {
            kind: &task.kind,
            presented: own("presented"),
            answered: own("answered"),
            offered: own("offered"),
            flags: own("flags"),
        };
        let named = |names: Vec<&'static str>, meaning: &dyn Fn(&str) -> ColumnMeaning| {
            let named = names
                .into_iter()
                .map(|name| (name.to_owned(), meaning(name)));
            named.collect()
        };
        BehaviourMeanings {
            task: task.name.clone(),
            responses: named(response_columns(protocol, &task.kind), &|name| {
                of.response(name)
            }),
            events: named(event_columns(&task.kind), &|name| of.event(name)),
        }
    });
    meanings.collect()
}

/// A column of several names in a cell. BIDS compares levels with whole cells, so they stand in the description.
fn several(of: ColumnMeaning) -> ColumnMeaning {
    let names = of.level_names().join(", ");
    let description = match names.is_empty() {
        true => of.description.clone(),
        false => format!("{} The names: {names}.", of.description),
    };
    ColumnMeaning {
        description,
        delimiter: Some(BETWEEN.to_owned()),
        levels: BTreeMap::new(),
        ..of
    }
}

/// Of one task.
struct Meanings<'a> {
    kind: &'a TaskKind,
    presented: ColumnMeaning,
    answered: ColumnMeaning,
    offered: ColumnMeaning,
    flags: ColumnMeaning,
}

impl Meanings<'_> {
    fn response(&self, name: &str) -> ColumnMeaning {
        let with_levels = |of: &ColumnMeaning, table| ColumnMeaning {
            levels: of.levels.clone(),
            ..column(table, name)
        };
        match (name, self.kind) {
            ("rank", TaskKind::Order { from, to, .. }) => {
                column("order", name).with(&[("from", from), ("to", to)])
            }
            ("expected" | "response", TaskKind::Order { .. }) => {
                with_levels(&self.offered, "order")
            }
            ("presented", TaskKind::Compare { .. }) => several(self.presented.clone()),
            ("presented", _) => self.presented.clone(),
            ("expected", _) => with_levels(&self.answered, "responses"),
            ("response", TaskKind::Categorise { .. }) => several(self.answered.clone()),
            ("response", _) => self.answered.clone(),
            ("offered", _) if self.offered.description.is_empty() => {
                several(with_levels(&self.answered, "responses"))
            }
            ("offered", _) => several(self.offered.clone()),
            ("flags", _) => ColumnMeaning {
                delimiter: Some(" ".to_owned()),
                levels: BTreeMap::new(),
                description: format!(
                    "{} The words: {}.",
                    self.flags.description.replace("empty", "n/a"),
                    self.flags.level_names().join(", ")
                ),
                ..self.flags.clone()
            },
            _ => column("responses", name),
        }
    }

    fn event(&self, name: &str) -> ColumnMeaning {
        let mut known = column("events", name);
        match name {
            "trial_type" if !plays(self.kind) => {
                known.levels.remove(STIMULUS);
            }
            "stimulus" => known.levels.clone_from(&self.presented.levels),
            _ if known.description.is_empty() => return self.response(name),
            _ => {}
        }
        known
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::campaign::protocol::{LIBRARY, from_library};

    #[test]
    fn every_column_of_the_library_is_described() {
        for (name, _) in LIBRARY {
            let protocol = from_library(name).unwrap().unwrap();
            for task in behaviour_meanings(&protocol) {
                for (column, meaning) in task.responses.iter().chain(&task.events) {
                    let place = format!("{name} {} {column}", task.task);
                    assert!(meaning.description.ends_with('.'), "{place}: {meaning:?}");
                    assert!(
                        meaning.delimiter.is_none() || meaning.levels.is_empty(),
                        "{place}"
                    );
                }
            }
        }
    }

    #[test]
    fn levels_are_those_that_can_be_answered() {
        let protocol = from_library("isotropic_triplets").unwrap().unwrap();
        let all = behaviour_meanings(&protocol);
        let of = |task: &str| all.iter().find(|one| one.task == task).unwrap();
        assert!(of("measure").responses.is_empty());
        let response = &of("task3").responses["response"];
        assert!(response.levels.contains_key("S13") && !response.levels.contains_key("NO"));
        let offered = &of("task3").responses["offered"];
        assert!(offered.levels.is_empty() && offered.description.contains("S2, S3"));
        assert!(of("task1").responses.contains_key("rank"));
        assert!(!of("task1").events.contains_key("stimulus"));
    }
}
