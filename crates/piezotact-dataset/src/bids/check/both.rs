//! Answers and events of one task of a session, which say the same of its trials.

use std::collections::BTreeMap;

use piezotact_people::association::BETWEEN;

use super::super::NOTHING;
use super::super::name::TRIALS;
use super::super::tree::Entry;
use super::{Found, ProblemKind};

/// The task of a session: its folder, and the entities of its tables.
type Task = (String, Vec<(String, String)>);

/// What two tables say of the trials of a task.
#[derive(Default)]
struct Trials {
    /// The responses of each trial, in the order of the lines.
    answered: BTreeMap<String, Vec<String>>,
    /// The response of each trial as its event has it, with the line.
    noted: BTreeMap<String, (u64, String)>,
    events: String,
}

/// What the tables of a data set say of its trials.
#[derive(Default)]
pub(super) struct Both {
    tasks: BTreeMap<Task, Trials>,
}

fn task_of(entry: &Entry) -> Option<Task> {
    let mut all = entry.parsed()?.together();
    all.retain(|of| *of != ("acq", TRIALS));
    let all = all.into_iter();
    let all = all.map(|(key, label)| (key.to_owned(), label.to_owned()));
    Some((entry.folder().to_owned(), all.collect()))
}

impl Both {
    /// Notes a row of answers or events, by its cells.
    pub(super) fn row<'a>(
        &mut self,
        entry: &Entry,
        number: u64,
        cell: impl Fn(&str) -> Option<&'a str>,
    ) {
        let known = |name: &str| cell(name).filter(|text| *text != NOTHING && !text.is_empty());
        let (Some(task), Some(trial)) = (task_of(entry), known("trial")) else {
            return;
        };
        let response = known("response").unwrap_or_default().to_owned();
        let of = self.tasks.entry(task).or_default();
        if entry.file.ends_with("_beh.tsv") {
            of.answered
                .entry(trial.to_owned())
                .or_default()
                .push(response);
        } else if known("trial_type") == Some("trial") {
            of.events.clone_from(&entry.file);
            of.noted.insert(trial.to_owned(), (number, response));
        }
    }

    /// What contradicts, when all tables are read.
    pub(super) fn end(self, found: &mut Found) {
        for of in self.tasks.into_values() {
            if of.noted.is_empty() || of.answered.is_empty() {
                continue;
            }
            for (trial, responses) in &of.answered {
                let answered = responses.join(BETWEEN);
                match of.noted.get(trial) {
                    Some((_, noted)) if *noted == answered => {}
                    Some((line, noted)) => {
                        let why = format!(
                            "expected the response {answered} of trial {trial}, as the table of answers has it, found `{noted}`; correct one of them"
                        );
                        found.add(ProblemKind::Response, &of.events, *line, why);
                    }
                    None => {
                        let why = format!(
                            "expected an event for trial {trial}, which the table of answers has, found none; restore the line"
                        );
                        found.add(ProblemKind::Response, &of.events, None, why);
                    }
                }
            }
            for (trial, (line, noted)) in &of.noted {
                if !noted.is_empty() && !of.answered.contains_key(trial) {
                    let why = format!(
                        "expected trial {trial} in the table of answers, as it was answered, found none; restore its lines"
                    );
                    found.add(ProblemKind::Response, &of.events, *line, why);
                }
            }
        }
    }
}
