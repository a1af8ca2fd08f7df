//! What a study asked: the beginning of its report.

use std::collections::{BTreeMap, BTreeSet};

use piezotact::number::counted;
use piezotact::page::{Cell, Column, Table};
use serde::{Deserialize, Serialize};

use super::answer::{Answer, AnswerTable};
use super::document::{Association, share_beside_once};
use super::expected::{ExpectedShare, StimulusKind};
use super::matrix::{MatrixConfig, Selection};
use crate::campaign::protocol::Protocol;
use crate::judge::Which;

/// A task of a study with its answers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct AskedTask {
    /// Its name.
    pub task: String,
    /// What is done.
    pub title: String,
    /// How many participants answered.
    pub participants: usize,
    /// How many answers they gave: associations, or places in orders.
    pub answers: usize,
    /// How many are as expected, beside chance; absent for orders, and where nothing is expected.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub expected: Option<ExpectedShare>,
    /// Kendall's τ over participants with its interval, of orders.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub orders: Option<String>,
}

/// What a study asked, of whom, and how.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Asked {
    /// The title of the protocol.
    pub title: String,
    /// Where it comes from.
    pub source: String,
    /// The number of samples.
    pub samples: usize,
    /// The participants whose answers count, and how many were planned.
    pub participants: [usize; 2],
    /// How the study was simulated; absent for people.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulated: Option<String>,
    /// Its tasks with answers, in the order of the protocol.
    pub tasks: Vec<AskedTask>,
    /// Which judge the answers of virtual volunteers show.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub which: Option<Which>,
    /// That judge in words, or why it is not compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub which_sentence: Option<String>,
}

impl Association {
    /// The same with what the study of `protocol` asked. `simulated` says how, and `which` the judge that answers show or why it is
    /// not compared, of virtual volunteers.
    #[must_use]
    pub fn with_study(
        mut self,
        table: &AnswerTable,
        protocol: &Protocol,
        simulated: Option<String>,
        which: Option<Result<Which, String>>,
    ) -> Self {
        let mut by_task: BTreeMap<&str, Vec<&Answer>> = BTreeMap::new();
        let mut people: BTreeSet<&str> = BTreeSet::new();
        for answer in table.answers() {
            by_task.entry(&answer.task).or_default().push(answer);
            people.insert(&answer.participant);
        }
        let once = table.counted_once(&self.same_people);
        let tasks = protocol.tasks.iter().filter_map(|task| {
            let answers = by_task.get(task.name.as_str())?;
            let who: BTreeSet<&str> = answers.iter().map(|a| a.participant.as_str()).collect();
            let order = self.orderings.iter().find(|order| order.task == task.name);
            Some(AskedTask {
                task: task.name.clone(),
                title: task.title.clone(),
                participants: who.len(),
                answers: answers.len(),
                expected: match order {
                    Some(_) => None,
                    None => {
                        let selection = Selection {
                            task: Some(task.name.clone()),
                            ..Selection::default()
                        };
                        let all = MatrixConfig {
                            selection,
                            ..MatrixConfig::default()
                        };
                        share_beside_once([Some(table), once.as_ref()], &all, StimulusKind::All)
                    }
                },
                orders: order.map(|order| order.sentence()),
            })
        });
        let tasks = tasks.collect();
        let (which, which_sentence) = match which {
            None => (None, None),
            Some(Ok(which)) => {
                let said = which.sentence();
                (Some(which), Some(said))
            }
            Some(Err(why)) => (
                None,
                Some(format!("which judge it was is not compared: {why}")),
            ),
        };
        self.asked = Some(Asked {
            title: protocol.title.clone(),
            source: protocol.source.clone(),
            samples: protocol.samples.len(),
            participants: [people.len(), protocol.panel.participants as usize],
            simulated,
            tasks,
            which,
            which_sentence,
        });
        self
    }
}

impl Asked {
    /// What was asked, of whom and how, in sentences.
    #[must_use]
    pub fn sentences(&self) -> Vec<String> {
        let [people, planned] = self.participants;
        let who = match &self.simulated {
            Some(_) => counted(people, "virtual volunteer"),
            None => counted(people, "participant"),
        };
        let planned = match people == planned {
            true => String::new(),
            false => format!(" of {planned} planned"),
        };
        let tasks: Vec<String> = self
            .tasks
            .iter()
            .map(|task| match task.title.is_empty() {
                true => task.task.clone(),
                false => format!("{} ({})", task.task, task.title),
            })
            .collect();
        let mut said = vec![format!(
            "{} ({}): {who}{planned}, {}; answers of {}.",
            self.title,
            self.source,
            counted(self.samples, "sample"),
            tasks.join(", ")
        )];
        said.extend(self.simulated.as_ref().map(|how| {
            format!(
                "Simulated: no person touched anything or answered. Strokes, transfer functions, renderings and answers are those of \
                 the digital twin; rendering: {how}."
            )
        }));
        said
    }

    /// Each task with what was found.
    #[must_use]
    pub fn table(&self) -> Table {
        let columns = [
            ("task", "task"),
            ("what is done", "title"),
            ("participants", "participants"),
            ("answers", "answers"),
            ("found", "found"),
        ];
        let mut table = Table::new(columns.map(|(heading, name)| Column::new(heading, name)));
        table.rows = (self.tasks.iter())
            .map(|task| {
                let expected = task.expected.as_ref().map(ExpectedShare::words);
                let orders = task.orders.as_ref().map(|text| {
                    let (_, after) = text.split_once(": ").unwrap_or(("", text));
                    after.to_owned()
                });
                let found = expected.or(orders).unwrap_or_else(|| "–".to_owned());
                vec![
                    Cell::from(task.task.clone()),
                    Cell::from(task.title.clone()),
                    Cell::from(task.participants.to_string()),
                    Cell::from(task.answers.to_string()),
                    Cell::from(found),
                ]
            })
            .collect();
        table
    }

    /// How probable each judge is, where answers of virtual volunteers were compared.
    #[must_use]
    pub fn judges_table(&self) -> Option<Table> {
        let which = self.which.as_ref()?;
        let columns = [
            ("judge", "judge"),
            ("log-likelihood", "log_likelihood"),
            ("AICc", "aicc"),
            ("Akaike weight", "weight"),
            ("held out, nat per answer", "held_out_mean"),
        ];
        let mut table = Table::new(columns.map(|(heading, name)| Column::new(heading, name)));
        table.rows = (which.judges.iter())
            .map(|fit| {
                let held_out = piezotact::statistics::mean(&fit.held_out);
                vec![
                    Cell::from(fit.judge.name().to_owned()),
                    Cell::rounded(fit.log_likelihood, 1),
                    Cell::rounded(fit.aicc, 1),
                    Cell::rounded(fit.weight, 3),
                    Cell::rounded(held_out, 3),
                ]
            })
            .collect();
        Some(table)
    }
}
