//! Answers and events of one task of a session, which say the same of its trials.

use std::collections::BTreeMap;

use piezotact::criterion::Outcome;
use piezotact_people::association::{BETWEEN, DONE, Flag};

use super::super::NOTHING;
use super::super::name::TRIALS;
use super::super::tree::Entry;
use super::{Found, ProblemKind};

/// The task of a session: its folder, and the entities of its tables.
type Task = (String, Vec<(String, String)>);

/// What two tables say of the trials of a task.
#[derive(Default)]
struct Trials {
    /// What the table of answers says of each trial.
    answered: BTreeMap<String, Answered>,
    /// What the events say of each trial.
    noted: BTreeMap<String, Noted>,
    /// How each playing of a trial came out: whether its drive was verified, and whether it reached its target.
    played: BTreeMap<String, Vec<[String; 2]>>,
    events: String,
}

/// The cells of a trial in the table of answers, in the order of the lines.
#[derive(Default)]
struct Answered {
    responses: Vec<String>,
    presented: Vec<String>,
    seconds: String,
    /// Where the trial stands last, and whether a line of it is flagged as one that missed its target.
    place: (String, u64),
    is_missed: bool,
}

/// The cells of a trial in the events.
struct Noted {
    line: u64,
    response: String,
    presented: String,
    seconds: String,
    number: String,
    missed: String,
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
        let text = |name: &str| known(name).unwrap_or_default().to_owned();
        let of = self.tasks.entry(task).or_default();
        if entry.file.ends_with("_beh.tsv") {
            let answered = of.answered.entry(trial.to_owned()).or_default();
            answered.responses.push(text("response"));
            answered
                .presented
                .extend(known("presented").map(str::to_owned));
            answered.seconds = text("response_time");
            answered.place = (entry.file.clone(), number);
            let mut flags = cell("flags").unwrap_or_default().split(' ');
            answered.is_missed |= flags.any(|flag| flag == Flag::MissedTarget.word());
            return;
        }
        match known("trial_type") {
            Some("trial") => {
                of.events.clone_from(&entry.file);
                let noted = Noted {
                    line: number,
                    response: text("response"),
                    presented: text("presented"),
                    seconds: text("duration"),
                    number: text("number"),
                    missed: text("missed_target"),
                };
                of.noted.insert(trial.to_owned(), noted);
            }
            Some("stimulus") => {
                let played = of.played.entry(trial.to_owned()).or_default();
                played.push([text("verified"), text("reached")]);
            }
            _ => {}
        }
    }

    /// What contradicts, when all tables are read.
    pub(super) fn end(self, found: &mut Found) {
        for of in self.tasks.into_values() {
            of.numbers(found);
            of.targets(found);
            if !of.noted.is_empty() && !of.answered.is_empty() {
                of.answers(found);
                of.flags(found);
            }
        }
    }
}

impl Trials {
    /// Answers against the events of their trials.
    fn answers(&self, found: &mut Found) {
        for (trial, answered) in &self.answered {
            let Some(noted) = self.noted.get(trial) else {
                let why = format!(
                    "expected an event for trial {trial}, which the table of answers has, found none; restore the line"
                );
                found.add(ProblemKind::Response, &self.events, None, why);
                continue;
            };
            let pairs = [
                (
                    "response",
                    answered.responses.join(BETWEEN),
                    &noted.response,
                ),
                (
                    "presented",
                    answered.presented.join(BETWEEN),
                    &noted.presented,
                ),
                ("duration", answered.seconds.clone(), &noted.seconds),
            ];
            for (name, own, other) in pairs {
                // Orders present all at once, and say so in the events alone.
                if own == *other || (name != "response" && (own.is_empty() || other.is_empty())) {
                    continue;
                }
                let why = format!(
                    "expected {own} in the column `{name}` of trial {trial}, as the table of answers has it, found `{other}`; correct one of them"
                );
                found.add(ProblemKind::Response, &self.events, noted.line, why);
            }
        }
        for (trial, noted) in &self.noted {
            let asks = !noted.response.is_empty() && noted.response != DONE;
            if asks && !self.answered.contains_key(trial) {
                let why = format!(
                    "expected trial {trial} in the table of answers, as it was answered, found none; restore its lines"
                );
                found.add(ProblemKind::Response, &self.events, noted.line, why);
            }
        }
    }

    /// Flags of answers against the events of their trials.
    fn flags(&self, found: &mut Found) {
        for (trial, answered) in &self.answered {
            let missed = self.noted.get(trial).map(|noted| noted.missed.as_str());
            let flag = Flag::MissedTarget.word();
            let (expected, is) = match (missed, answered.is_missed) {
                (Some("yes"), false) => ("the flag", "none"),
                (Some("no" | "not decided"), true) => ("no flag", "one"),
                _ => continue,
            };
            let why = format!(
                "expected {expected} {flag} in trial {trial}, as the events say, found {is}; correct one of them"
            );
            let (file, line) = &answered.place;
            found.add(ProblemKind::Level, file, *line, why);
        }
    }

    /// Numbers of trials that stand there twice.
    fn numbers(&self, found: &mut Found) {
        let mut known: BTreeMap<&str, &str> = BTreeMap::new();
        for (trial, noted) in self
            .noted
            .iter()
            .filter(|(_, noted)| !noted.number.is_empty())
        {
            if let Some(other) = known.insert(&noted.number, trial) {
                let why = format!(
                    "expected numbers of trials that differ, found {} of {trial} and {other}; correct one",
                    noted.number
                );
                found.add(ProblemKind::Twice, &self.events, noted.line, why);
            }
        }
    }

    /// Whether a trial missed its target, against its playings.
    fn targets(&self, found: &mut Found) {
        let [met, not_met] = [Outcome::Met, Outcome::NotMet].map(Outcome::word);
        for (trial, noted) in &self.noted {
            let Some(played) = self.played.get(trial) else {
                continue;
            };
            let missed =
                |[verified, reached]: &[String; 2]| *verified != met || *reached == not_met;
            let is = match (
                played.iter().any(missed),
                played.iter().any(|[_, reached]| *reached != met),
            ) {
                (true, _) => "yes",
                (false, true) => "not decided",
                (false, false) => "no",
            };
            if !noted.missed.is_empty() && noted.missed != is {
                let why = format!(
                    "expected `{is}` for missed_target of trial {trial}, as its playings say, found `{}`; correct one of them",
                    noted.missed
                );
                found.add(ProblemKind::Level, &self.events, noted.line, why);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noted(response: &str, number: &str) -> Noted {
        Noted {
            line: 2,
            response: response.to_owned(),
            presented: "S1|S2".to_owned(),
            seconds: "10".to_owned(),
            number: number.to_owned(),
            missed: "no".to_owned(),
        }
    }

    #[test]
    fn a_trial_that_asks_for_nothing_has_no_answer() {
        let mut of = Trials::default();
        of.noted.insert("A.learn".to_owned(), noted(DONE, "1"));
        of.noted.insert("A.1".to_owned(), noted("S1", "2"));
        let mut found = Found::default();
        of.answers(&mut found);
        let texts: Vec<String> = found.problems.iter().map(|one| one.text()).collect();
        assert!(texts.len() == 1 && texts[0].contains("A.1"), "{texts:?}");
    }
}
