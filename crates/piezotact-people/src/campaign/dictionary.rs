//! The data dictionary of a campaign: what each column of its table of answers means in each task.

use std::collections::{BTreeMap, BTreeSet};

use piezotact::document::Content;
use serde::{Deserialize, Serialize};

use super::protocol::{Block, Labels, OrderKey, Over, Protocol, Question, Task, TaskKind, When};

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
            "participant" => Some(text("Participant, by pseudonym.")),
            "session" => Some(self.session()),
            "task" => Some(ColumnMeaning {
                levels: level(&self.task.name, &self.task.title),
                ..text("Task.")
            }),
            "set" => self.set(),
            "trial" => Some(text(
                "Trial, as in the tables of trials and of evidence; with the position (`element` there) unique within participant and session.",
            )),
            "position" => self.position(),
            "presented" => Some(self.presented()),
            "source" => self.manipulated(
                "Sample whose friction-induced vibration a manipulated stimulus is made from; empty for others.",
                |stimulus| &stimulus.of,
            ),
            "expected" => self.manipulated(
                "Sample that the hypothesis expects as answer to a manipulated stimulus; empty for others, whose own sample is expected.",
                |stimulus| stimulus.expected(),
            ),
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
            "flags" => Some(flags()),
            "rehearsal" => Some(rehearsal()),
            "judge" => Some(text(
                "How a virtual volunteer judges; empty for a person.",
            )),
            _ => None,
        }
    }

    fn session(&self) -> ColumnMeaning {
        // The trials of other tasks have names of their own.
        let is_order = matches!(self.task.kind, TaskKind::Order { .. });
        let repeats = |session: &str| -> usize {
            let of_session = self.blocks.iter().filter(|(name, ..)| *name == session);
            of_session.map(|(.., block)| block.repeats as usize).sum()
        };
        let repeated = is_order && self.blocks.iter().any(|(name, ..)| repeats(name) > 1);
        let description = match repeated {
            true => {
                "Session; from the second order of the same samples on with its number: `NAME, repetition 2`."
            }
            false => "Session.",
        };
        let levels = self.blocks.iter().map(|(session, when, _)| {
            let when = match when {
                When::AnyTime => "first, or at any time after the one before it",
                When::AnotherDay => "on a later day than the one before it",
            };
            ((*session).to_owned(), when.to_owned())
        });
        ColumnMeaning {
            // A repetition adds its number to the name.
            levels: if repeated {
                BTreeMap::new()
            } else {
                levels.collect()
            },
            ..text(description)
        }
    }

    fn set(&self) -> Option<ColumnMeaning> {
        let names: BTreeSet<&str> = (self.blocks.iter())
            .flat_map(|(.., block)| self.sets_of(block))
            .collect();
        let sets = names.iter().filter_map(|name| self.protocol.set(name));
        let levels: BTreeMap<String, String> = sets
            .map(|set| (set.name.clone(), set.samples.join(", ")))
            .collect();
        (!levels.is_empty()).then(|| ColumnMeaning {
            levels,
            ..text("Set of samples that are on the tray together.")
        })
    }

    fn sets_of(&self, block: &'a Block) -> Vec<&'a str> {
        match &block.over {
            Over::EverySet => {
                let sets = self.protocol.sets.iter();
                sets.map(|set| set.name.as_str()).collect()
            }
            Over::SharesOfSets(shares) => shares.iter().flatten().map(String::as_str).collect(),
            Over::AllSamples | Over::Samples(_) => Vec::new(),
        }
    }

    fn position(&self) -> Option<ColumnMeaning> {
        let description = match &self.task.kind {
            TaskKind::Identify { .. } => "Always 1: samples are handed over one by one.".to_owned(),
            TaskKind::Order { from, to, .. } => {
                format!("Place in which the sample was put, from 1 ({from}) on ({to}).")
            }
            TaskKind::Associate { .. } => {
                "Place of the stimulus in the sequence that was presented, from 1.".to_owned()
            }
            _ => return None,
        };
        Some(ColumnMeaning {
            units: Some("1".into()),
            ..text(&description)
        })
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
        match self.task.kind {
            TaskKind::Associate { .. } => ColumnMeaning {
                levels: self.rendered_levels(),
                ..text("Stimulus that was presented.")
            },
            TaskKind::Compare { .. } => ColumnMeaning {
                levels: self.rendered_levels(),
                ..text(
                    "The two stimuli in the order in which they were presented, with | between; each is one of the levels.",
                )
            },
            TaskKind::Order { .. } => ColumnMeaning {
                levels: self.sample_levels("real sample"),
                ..text("Real sample that was put in its place.")
            },
            _ => ColumnMeaning {
                levels: self.sample_levels("real sample"),
                ..text(
                    "Real sample that was handed over: where it was another than the planned one, this one.",
                )
            },
        }
    }

    fn manipulated(
        &self,
        description: &str,
        of: impl Fn(&'a super::protocol::Stimulus) -> &'a str,
    ) -> Option<ColumnMeaning> {
        if !matches!(
            self.task.kind,
            TaskKind::Associate { .. } | TaskKind::Compare { .. }
        ) {
            return None;
        }
        let used = self.protocol.rendered_in(self.task);
        let made = self.protocol.stimuli.iter();
        let made = made.filter(|stimulus| used.contains(stimulus.name.as_str()));
        let levels: BTreeMap<String, String> = made
            .map(of)
            .map(|sample| (sample.to_owned(), format!("sample {sample}")))
            .collect();
        (!levels.is_empty()).then(|| ColumnMeaning {
            levels,
            ..text(description)
        })
    }

    fn offered(&self) -> Option<ColumnMeaning> {
        let choices = matches!(
            self.task.kind,
            TaskKind::Identify { .. } | TaskKind::Order { .. } | TaskKind::Associate { .. }
        );
        choices.then(|| ColumnMeaning {
            levels: self.sample_levels("sample"),
            ..text("Samples that could be answered in this trial, with | between; each is one of the levels.")
        })
    }

    fn answered(&self) -> ColumnMeaning {
        let samples = |description: &str| ColumnMeaning {
            levels: self.sample_levels("sample"),
            ..text(description)
        };
        let of = |description: &str, levels: &[(&str, &str)]| ColumnMeaning {
            levels: (levels.iter())
                .map(|(name, meaning)| ((*name).to_owned(), (*meaning).to_owned()))
                .collect(),
            ..text(description)
        };
        match &self.task.kind {
            TaskKind::Touch { .. } => ColumnMeaning::default(),
            TaskKind::Identify { .. } => samples("Sample that the participant named."),
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
                samples(&format!(
                    "Place, from {from} to {to}: the sample that has it in {key}."
                ))
            }
            TaskKind::Associate { labels, .. } => samples(match labels {
                Labels::Names => "Sample that the participant associated to the stimulus.",
                Labels::OwnOrder { .. } => {
                    "Sample that the participant associated to the stimulus; said as A, B, C … in the participant's own order and stored as the sample that stood there."
                }
            }),
            TaskKind::Compare { question, .. } => match question {
                Question::SameDifferent => of(
                    "Whether the two stimuli felt the same.",
                    &[("same", "the same"), ("different", "different")],
                ),
                Question::Rougher => of(
                    "Which stimulus felt rougher.",
                    &[("first", "the first one"), ("second", "the second one")],
                ),
                Question::Stronger => of(
                    "Which stimulus felt stronger.",
                    &[("first", "the first one"), ("second", "the second one")],
                ),
            },
            TaskKind::Categorise {
                descriptors,
                at_most,
            } => ColumnMeaning {
                levels: (descriptors.iter())
                    .map(|name| (name.clone(), format!("the sample feels {name}")))
                    .collect(),
                ..text(&format!(
                    "Descriptors chosen, at most {at_most}, with | between; each is one of the levels."
                ))
            },
            TaskKind::Rate { from, to, .. } => ColumnMeaning {
                units: Some("1".into()),
                ..text(&format!("Rating, a whole number from {from} to {to}."))
            },
        }
    }
}

fn text(description: &str) -> ColumnMeaning {
    ColumnMeaning {
        description: description.into(),
        ..ColumnMeaning::default()
    }
}

fn level(name: &str, meaning: &str) -> BTreeMap<String, String> {
    BTreeMap::from([(name.to_owned(), meaning.to_owned())])
}

fn flags() -> ColumnMeaning {
    let mut levels = level(
        "missed_target",
        "the vibration that was played did not reach its target",
    );
    levels.extend(level(
        "not_measured",
        "it was played by hand on another system, and nothing was measured",
    ));
    levels.extend(level(
        "wrong_sample",
        "another sample than the planned one was handed over",
    ));
    levels.extend(level(
        "simulated",
        "it was played on a simulated bench, and no person felt it",
    ));
    ColumnMeaning {
        levels,
        ..text("What was wrong with the trial, with spaces between; empty where nothing was.")
    }
}

fn rehearsal() -> ColumnMeaning {
    let mut levels = level("yes", "a rehearsal, which is no data");
    levels.extend(level("no", "a trial of the campaign"));
    ColumnMeaning {
        levels,
        ..text("Whether the trial was a rehearsal.")
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
