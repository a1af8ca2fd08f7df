//! What the columns of responses and events mean.

use std::collections::BTreeMap;

use super::{BETWEEN, STIMULUS, TRIAL, event_columns, response_columns};
use crate::campaign::dictionary::{ColumnMeaning, dictionary};
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

/// What is known of each participant, as columns.
///
/// Source: BIDS 1.11, participants file; thesis 2.6, the description of panels.
#[must_use]
pub fn person_meanings() -> BTreeMap<String, ColumnMeaning> {
    let kinds = levels(&[
        ("volunteer", "a person"),
        (
            "virtual",
            "a virtual volunteer of the digital twin: no person answered",
        ),
    ]);
    let all = [
        ("species", text("Species; absent for a virtual volunteer.")),
        (
            "age",
            number(
                "Age at the first session; 89 for everybody of 89 or more.",
                "year",
            ),
        ),
        (
            "sex",
            ColumnMeaning {
                levels: levels(&[("F", "female"), ("M", "male"), ("O", "other")]),
                ..text(
                    "Sex, where what was stated is one of the levels; `stated_sex` of the sessions has the words.",
                )
            },
        ),
        (
            "handedness",
            ColumnMeaning {
                levels: levels(&[("R", "right"), ("L", "left"), ("A", "ambidextrous")]),
                ..text("Preferred hand.")
            },
        ),
        (
            "pseudonym",
            text(
                "Pseudonym in the study; the label of the participant has letters and digits alone.",
            ),
        ),
        (
            "kind",
            ColumnMeaning {
                levels: kinds,
                ..text("Who took part.")
            },
        ),
    ];
    all.map(|(name, meaning)| (name.to_owned(), meaning)).into()
}

fn text(description: &str) -> ColumnMeaning {
    ColumnMeaning {
        description: description.to_owned(),
        ..ColumnMeaning::default()
    }
}

fn number(description: &str, unit: &str) -> ColumnMeaning {
    ColumnMeaning {
        units: Some(unit.to_owned()),
        ..text(description)
    }
}

fn levels(of: &[(&str, &str)]) -> BTreeMap<String, String> {
    of.iter()
        .map(|(name, meaning)| ((*name).to_owned(), (*meaning).to_owned()))
        .collect()
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

/// Yes and no as numbers.
fn yes_or_no(description: &str) -> ColumnMeaning {
    ColumnMeaning {
        levels: levels(&[("1", "yes"), ("0", "no")]),
        ..text(description)
    }
}

fn outcome(description: &str) -> ColumnMeaning {
    ColumnMeaning {
        levels: levels(&[
            ("met", "met"),
            ("not met", "not met"),
            ("not decided", "the data do not decide it"),
        ]),
        ..text(description)
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
        let order = matches!(self.kind, TaskKind::Order { .. });
        match name {
            "trial" => text("Trial, unique within the session; as in the events of the task."),
            "set" => text("Set of samples that are on the tray together."),
            "kind" => self.trial_kind(),
            "repetition" => number(
                "How often these samples had been put in order with this one, from 1.",
                "1",
            ),
            "rank" => match self.kind {
                TaskKind::Order { from, to, .. } => number(
                    &format!("Place in the order, from 1 ({from}) on ({to})."),
                    "1",
                ),
                _ => number("Place in the order, from 1.", "1"),
            },
            "position" => number("Place in the sequence that was presented, from 1.", "1"),
            "presented" => match self.kind {
                TaskKind::Compare { .. } => several(self.presented.clone()),
                _ => self.presented.clone(),
            },
            "source" => text(
                "Sample whose friction-induced vibration a manipulated stimulus is made from; n/a for others.",
            ),
            "expected" if order => ColumnMeaning {
                levels: self.offered.levels.clone(),
                ..text(
                    "Sample that has this place in the physical order of those that were put in order; n/a where no order is right or wrong.",
                )
            },
            "expected" => ColumnMeaning {
                levels: self.answered.levels.clone(),
                ..text(
                    "Sample that is the right answer: the own sample of the stimulus, or the one that the hypothesis expects for a manipulated one.",
                )
            },
            "response" if order => ColumnMeaning {
                levels: self.offered.levels.clone(),
                ..text("Sample that the participant put in this place.")
            },
            "response" => match self.kind {
                TaskKind::Categorise { .. } => several(self.answered.clone()),
                _ => self.answered.clone(),
            },
            "correct" => yes_or_no(
                "Whether the response is the expected one; n/a where nothing is expected.",
            ),
            "offered" if self.offered.description.is_empty() => several(ColumnMeaning {
                levels: self.answered.levels.clone(),
                ..text("What could be answered in this trial, with | between.")
            }),
            "offered" => several(self.offered.clone()),
            "response_time" => number(
                "Time from the presentation of the trial to its confirmation, the same in all rows of a trial.",
                "s",
            ),
            "n_replays" => number(
                "How often the stimulus was felt again, in the attempt that was answered.",
                "1",
            ),
            "stim_file" => text("Drive that was played, re the folder stimuli."),
            "flags" => ColumnMeaning {
                delimiter: Some(" ".to_owned()),
                levels: BTreeMap::new(),
                description: format!(
                    "{} The words: {}.",
                    self.flags.description.replace("empty", "n/a"),
                    self.flags.level_names().join(", ")
                ),
                ..self.flags.clone()
            },
            _ => ColumnMeaning::default(),
        }
    }

    fn trial_kind(&self) -> ColumnMeaning {
        ColumnMeaning {
            levels: levels(&[
                ("counted", "it is analysed"),
                ("training", "to learn the task; it is not analysed"),
                (
                    "catch",
                    "its right answer is known; it shows whether the participant does the task",
                ),
            ]),
            ..text("What the trial is for.")
        }
    }

    fn event(&self, name: &str) -> ColumnMeaning {
        let many = |description: &str| ColumnMeaning {
            delimiter: Some(BETWEEN.to_owned()),
            ..text(description)
        };
        match name {
            "onset" => number(
                "Time after the beginning of the session: of a trial when its presentation was noted, of a stimulus when its playing was noted, directly after it ended.",
                "s",
            ),
            "duration" => number(
                "From the presentation of a trial to its confirmation; n/a for a stimulus and for a trial that was not confirmed.",
                "s",
            ),
            "trial_type" => {
                let played = matches!(
                    self.kind,
                    TaskKind::Associate { .. } | TaskKind::Compare { .. }
                );
                let mut kinds = levels(&[(TRIAL, "a trial")]);
                if played {
                    kinds.extend(levels(&[(
                        STIMULUS,
                        "a stimulus that was played in a trial, and what was measured while it was",
                    )]));
                }
                ColumnMeaning {
                    levels: kinds,
                    ..text("What the row is.")
                }
            }
            "number" => number("Number of the trial in the session, from 1.", "1"),
            "planned" => many(
                "What was planned to be presented, with | between; n/a where earlier answers decide.",
            ),
            "presented" => many("What was presented, with | between."),
            "response" => many("The answer that counts, with | between: after corrections."),
            "first_response" => many("The first answer to the trial, with | between."),
            "confirmed_response" => {
                many("The answer that was confirmed, before corrections, with | between.")
            }
            "revisions" => number("How often the participant revised the answer.", "1"),
            "corrections" => number(
                "How often the experimenter corrected the answer after its confirmation, or the order that its letters stand for where that changes it.",
                "1",
            ),
            "plays" => many("How often each element was felt, with | between."),
            "attempts" => number("How often the trial was begun.", "1"),
            "interrupted" => number("How many attempts were cut off.", "1"),
            "voided" => number("How many attempts are void, as a device failed.", "1"),
            "missed_target" => ColumnMeaning {
                levels: levels(&[
                    ("yes", "a stimulus of the trial missed its target"),
                    ("no", "none did, or nothing was played"),
                    (
                        "not decided",
                        "none is known to have missed it, and of one it is not decided",
                    ),
                ]),
                ..text("Whether what was played missed its target.")
            },
            "element" => number("Place of the stimulus in the sequence, from 1.", "1"),
            "stimulus" => ColumnMeaning {
                levels: self.presented.levels.clone(),
                ..text("Stimulus that was played.")
            },
            "drive_sha256" => text("SHA-256 of the file of the drive that was played."),
            "gain" => text("Gain of the amplifier, by its name."),
            "verified" => {
                outcome("Whether the drive had passed its verification before the session.")
            }
            "reached" => outcome("Whether this playing came to its target."),
            "criteria_not_met" => {
                many("The criteria that this playing did not meet, with | between.")
            }
            "score_jnd" => number(
                "Difference from the target that is felt, in just-noticeable differences.",
                "1",
            ),
            "level_re_target_db" => number(
                "Level on the fingernail relative to the target at its rendered level.",
                "dB",
            ),
            "rendered_at_db" => number(
                "Level at which it was rendered, re the recorded stroke.",
                "dB",
            ),
            "normal_force_n" => number(
                "Mean normal force over the recording of the playing, from its first to its last sample.",
                "N",
            ),
            "onset_in_recording" => number(
                "Onset of the vibration on the fingernail, after the start of the recording.",
                "s",
            ),
            "onset_uncertainty" => number("Uncertainty of that onset.", "s"),
            "strokes" => number("How often the stroke was played in a row.", "1"),
            "recording_file" => text("Recording of this playing, re the folder of the session."),
            other => self.response(other),
        }
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
