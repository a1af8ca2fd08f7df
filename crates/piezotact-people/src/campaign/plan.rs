//! The plan of one session of one participant: every trial, in its order, before the session begins.
//!
//! A plan is a function of the protocol, the seed and the sessions that were completed so far, so that people who leave do not
//! unbalance it; each person is planned on arrival. Each draw has a random stream of its own.

mod trials;

use crate::campaign::protocol::ProtocolError;
use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::chain::Sha;
use super::design::williams_orders;
use super::protocol::{Adaptive, Block, Group, OrderRule, Over, Protocol};
use super::random::Stream;
pub(super) use trials::MOST_TRIALS;

/// A session that was completed, with the cells of the design that it filled.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct CompletedSession {
    /// The participant's pseudonym.
    pub participant: String,
    /// The session.
    pub session: String,
    /// Its cells: which of the orders or shares it had, by block and what is balanced.
    pub cells: BTreeMap<String, usize>,
}

/// A plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Plan {
    /// The protocol's name.
    pub protocol: String,
    /// The SHA-256 of the protocol's file.
    pub protocol_sha: Sha,
    /// The seed of the campaign.
    pub seed: u64,
    /// The participant's pseudonym.
    pub participant: String,
    /// The session.
    pub session: String,
    /// The completed sessions that it was balanced against.
    pub completed: Vec<CompletedSession>,
    /// The cells of the design that this session fills.
    pub cells: BTreeMap<String, usize>,
    /// The adaptive runs by name, with their rules. What they choose stands in the session's events.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub runs: BTreeMap<String, Adaptive>,
    /// The trials in their order; of an adaptive run as many as it has at most.
    pub trials: Vec<Trial>,
}

/// A trial.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Trial {
    /// Its name, unique in the session: `triplets.task3.A`.
    pub name: String,
    /// The block.
    pub block: String,
    /// The task.
    pub task: String,
    /// The set; absent where all samples are presented.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub set: Option<String>,
    /// What it is for.
    #[serde(default, skip_serializing_if = "TrialKind::is_counted")]
    pub kind: TrialKind,
    /// What is presented.
    pub presented: Presented,
    /// What is answered.
    pub answer: AnswerForm,
}

/// What a trial is for. Only counted trials are analysed.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum TrialKind {
    /// Its answer counts.
    #[default]
    Counted,
    /// To learn the task.
    Training {
        /// The right answer, shown after the confirmation; absent where nothing is shown.
        #[serde(default, skip_serializing_if = "Option::is_none")]
        feedback: Option<Vec<String>>,
    },
    /// To see whether the participant does the task.
    Catch {
        /// The right answer.
        right: Vec<String>,
    },
}

impl TrialKind {
    /// The kind as it stands in tables: `counted`.
    #[must_use]
    pub fn word(&self) -> &'static str {
        match self {
            Self::Counted => "counted",
            Self::Training { .. } => "training",
            Self::Catch { .. } => "catch",
        }
    }

    /// Whether the answer is analysed.
    #[must_use]
    pub fn is_counted(&self) -> bool {
        *self == Self::Counted
    }
}

/// The first or the second of two stimuli.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Interval {
    /// The first.
    First,
    /// The second.
    Second,
}

impl Interval {
    /// `standard` in this place, and `comparison` in the other.
    #[must_use]
    pub fn pair(self, standard: &str, comparison: &str) -> Vec<String> {
        let pair = match self {
            Self::First => [standard, comparison],
            Self::Second => [comparison, standard],
        };
        pair.map(str::to_owned).to_vec()
    }
}

/// What a trial presents.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "is", rename_all = "snake_case")]
pub enum Presented {
    /// Real samples on the tray, slot by slot.
    Tray {
        /// The samples.
        samples: Vec<String>,
    },
    /// One real sample, handed over.
    Sample {
        /// The sample.
        sample: String,
    },
    /// Rendered stimuli, one after the other.
    Rendered {
        /// The stimuli.
        stimuli: Vec<String>,
    },
    /// Two rendered stimuli: the standard of an adaptive run, and the comparison that the run chooses then.
    Chosen {
        /// The run, one of [`Plan::runs`].
        run: String,
        /// Where the standard stands.
        standard: Interval,
    },
}

impl Presented {
    /// The names of what is presented, in their order; none where the answers so far decide.
    #[must_use]
    pub fn names(&self) -> &[String] {
        match self {
            Self::Tray { samples } => samples,
            Self::Sample { sample } => std::slice::from_ref(sample),
            Self::Rendered { stimuli } => stimuli,
            Self::Chosen { .. } => &[],
        }
    }
}

/// What is answered to a trial.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "is", rename_all = "snake_case")]
pub enum AnswerForm {
    /// Nothing: it is done.
    Done,
    /// One of these.
    OneOf {
        /// The choices.
        choices: Vec<String>,
    },
    /// One of these for each element that is presented.
    Each {
        /// The choices.
        choices: Vec<String>,
    },
    /// A, B, C … for each element that is presented, in the order that was confirmed for another trial.
    EachOfOrder {
        /// That trial.
        trial: String,
    },
    /// All of these in an order.
    Order {
        /// The samples.
        samples: Vec<String>,
        /// The first end.
        from: String,
        /// The other end.
        to: String,
    },
    /// Up to a number of these.
    Some {
        /// The choices.
        choices: Vec<String>,
        /// How many at most.
        at_most: usize,
    },
    /// A whole number.
    Scale {
        /// The lowest.
        from: i64,
        /// The highest.
        to: i64,
    },
}

/// Who is planned, and where the campaign stands.
#[derive(Clone, Copy, Debug)]
pub struct PlanRequest<'a> {
    /// The seed of the campaign.
    pub seed: u64,
    pub participant: &'a str,
    pub session: &'a str,
    /// The sessions that were completed so far.
    pub completed: &'a [CompletedSession],
}

/// The plan of a session: the same inputs give the same bytes on every machine ([`Plan::bytes`]).
///
/// # Errors
/// [`ProtocolError`].
///
/// Source: docs/decisions/campaigns.md; orders by Williams 1949, Aust. J. Sci. Res. A 2:149.
pub fn plan(
    protocol: &Protocol,
    protocol_sha: Sha,
    request: PlanRequest<'_>,
) -> Result<Plan, ProtocolError> {
    let Some(session) = protocol.session(request.session) else {
        let names: Vec<&str> = protocol
            .sessions
            .iter()
            .map(|one| one.name.as_str())
            .collect();
        return Err(ProtocolError::Session {
            protocol: protocol.name.clone(),
            session: request.session.to_owned(),
            known: names.join(", "),
        });
    };
    let of_session = || {
        let same = |done: &&CompletedSession| done.session == request.session;
        request.completed.iter().filter(same)
    };
    if of_session().any(|done| done.participant == request.participant) {
        return Err(ProtocolError::Completed {
            participant: request.participant.to_owned(),
            session: request.session.to_owned(),
        });
    }
    let mut planner = Planner {
        protocol,
        request,
        completed: of_session().collect(),
        cells: BTreeMap::new(),
        runs: BTreeMap::new(),
        trained: BTreeSet::new(),
        trials: Vec::new(),
    };
    for block in &session.blocks {
        planner.block(block)?;
    }
    let Planner {
        cells,
        runs,
        trials,
        ..
    } = planner;
    Ok(Plan {
        protocol: protocol.name.clone(),
        protocol_sha,
        seed: request.seed,
        participant: request.participant.to_owned(),
        session: request.session.to_owned(),
        completed: request.completed.to_vec(),
        cells,
        runs,
        trials,
    })
}

impl Plan {
    /// The plan as it is written: JSON, the same bytes for the same plan.
    #[must_use]
    pub fn bytes(&self) -> Vec<u8> {
        // Maps are ordered, and the numbers of rules are finite and written in their shortest form: there is one way to write it,
        // and it cannot fail.
        let mut bytes = serde_json::to_vec_pretty(self).unwrap_or_default();
        bytes.push(b'\n');
        bytes
    }

    /// The SHA-256 of [`Plan::bytes`].
    #[must_use]
    pub fn sha(&self) -> Sha {
        Sha::of(&self.bytes())
    }

    /// The session as a completed one.
    #[must_use]
    pub fn as_completed(&self) -> CompletedSession {
        CompletedSession {
            participant: self.participant.clone(),
            session: self.session.clone(),
            cells: self.cells.clone(),
        }
    }
}

struct Planner<'a> {
    protocol: &'a Protocol,
    request: PlanRequest<'a>,
    completed: Vec<&'a CompletedSession>,
    cells: BTreeMap<String, usize>,
    runs: BTreeMap<String, Adaptive>,
    /// Tasks that had their training.
    trained: BTreeSet<&'a str>,
    trials: Vec<Trial>,
}

impl<'a> Planner<'a> {
    fn stream(&self, purpose: &[&str]) -> Stream {
        let mut all = vec![self.request.participant, self.request.session];
        all.extend(purpose);
        Stream::of(self.request.seed, &all)
    }

    fn block(&mut self, block: &'a Block) -> Result<(), ProtocolError> {
        let mut shares = self.protocol.groups(&block.over);
        let share = match block.over {
            Over::SharesOfSets(_) => self.rarest(&format!("{}.share", block.name), shares.len()),
            _ => 0,
        };
        let groups = shares.swap_remove(share);
        let sets = self.ordered(block, "sets", block.set_order, groups);
        let tasks: Vec<&str> = block.tasks.iter().map(String::as_str).collect();
        let tasks = self.ordered(block, "tasks", block.task_order, tasks);
        for repeat in 1..=block.repeats {
            for group in &sets {
                if group.samples.is_empty() {
                    return Err(undeclared(group.set.unwrap_or_default()));
                }
                for task in &tasks {
                    let Some(task) = self.protocol.task(task) else {
                        return Err(undeclared(task));
                    };
                    let mut name = format!("{}.{}", block.name, task.name);
                    if let Some(set) = group.set {
                        name.push_str(&format!(".{set}"));
                    }
                    if block.repeats > 1 {
                        name.push_str(&format!(".{repeat}"));
                    }
                    self.task(block, task, *group, &name)?;
                }
            }
        }
        Ok(())
    }

    /// `items` in the order that `rule` asks for.
    fn ordered<T: Copy>(
        &mut self,
        block: &Block,
        what: &str,
        rule: OrderRule,
        mut items: Vec<T>,
    ) -> Vec<T> {
        match rule {
            OrderRule::AsListed => items,
            OrderRule::Shuffled => {
                self.stream(&["order", &block.name, what])
                    .shuffle(&mut items);
                items
            }
            OrderRule::Balanced => {
                let cell = match self.cells.get(&format!("{}.share", block.name)) {
                    // Balanced within each share of the sets.
                    Some(share) => format!("{}.{what} of share {share}", block.name),
                    None => format!("{}.{what}", block.name),
                };
                let mut orders = balanced_orders(items.len());
                let order = orders.swap_remove(self.rarest(&cell, orders.len()));
                order.into_iter().map(|i| items[i]).collect()
            }
        }
    }

    /// Which of `count` cells the fewest completed sessions have; among equals, a random one.
    fn rarest(&mut self, cell: &str, count: usize) -> usize {
        let mut had = vec![0_usize; count];
        for done in &self.completed {
            if let Some(slot) = done.cells.get(cell).and_then(|which| had.get_mut(*which)) {
                *slot += 1;
            }
        }
        let fewest = had.iter().min().copied().unwrap_or(0);
        let rare: Vec<usize> = (0..count).filter(|i| had[*i] == fewest).collect();
        let chosen = rare[self.stream(&["cell", cell]).below(rare.len())];
        self.cells.insert(cell.to_owned(), chosen);
        chosen
    }
}

fn undeclared(name: &str) -> ProtocolError {
    ProtocolError::Unknown {
        place: "plan".to_owned(),
        what: "sample, stimulus or task",
        name: name.to_owned(),
    }
}

/// The balanced orders of `count` items: each item follows each other equally often over all of them.
pub(super) fn balanced_orders(count: usize) -> Vec<Vec<usize>> {
    williams_orders(count).unwrap_or_else(|_nothing_to_order| vec![Vec::new()])
}

#[cfg(test)]
mod tests;
