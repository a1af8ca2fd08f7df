//! Who answered: people whose answers or names say that they may be one, and answers of which one person gave most.

use std::collections::{BTreeMap, BTreeSet};

use piezotact::Warning;
use piezotact::compare::{CompareWarning, Mixed, Named, plain_name};
use serde::{Deserialize, Serialize};

use super::answer::{Answer, AnswerTable};
use super::chance_agreement::{Coded, Matching, Others, Part, matched};
use super::warning::AssociationWarning;

/// People whose answers agree this improbably are named: the probability that a table of people who answered for themselves names any.
///
/// Source: docs/decisions/answers.md.
const LEVEL_SHARE: f64 = 0.005;
/// The answers of a participant, or a part of them.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct AnswersPart {
    pub participant: String,
    /// Of this session alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub session: Option<String>,
    /// Of this task alone.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub task: Option<String>,
}

impl AnswersPart {
    /// All answers of `participant`.
    fn of(participant: &str) -> Self {
        Self {
            participant: participant.to_owned(),
            session: None,
            task: None,
        }
    }

    fn is_whole(&self) -> bool {
        self.session.is_none() && self.task.is_none()
    }

    fn holds(&self, answer: &Answer) -> bool {
        let is = |wish: &Option<String>, found: &str| wish.as_ref().is_none_or(|one| one == found);
        self.participant == answer.participant
            && is(&self.session, &answer.session)
            && is(&self.task, &answer.task)
    }
}

impl std::fmt::Display for AnswersPart {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.participant)?;
        if let Some(session) = &self.session {
            write!(f, ", session {session}")?;
        }
        if let Some(task) = &self.task {
            write!(f, ", task {task}")?;
        }
        Ok(())
    }
}

/// What says that two are one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "by", rename_all = "snake_case")]
pub enum SameBy {
    /// Names that differ in capital letters, blanks or leading zeros alone.
    Name,
    /// Answers that agree more than what was presented and the habits of either explain.
    Answers {
        /// How answers of the two were matched.
        matching: Matching,
        /// How many were matched.
        matched: usize,
        /// How many of them agree.
        alike: usize,
        /// How many would agree by chance, at most.
        expected: f64,
        /// The largest probability of so many by chance.
        p_value: f64,
    },
}

/// Two whose answers may be those of one person, or the same answers twice.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SamePerson {
    pub one: AnswersPart,
    /// Stands after `one` in the table; left out where people are counted once.
    pub other: AnswersPart,
    #[serde(flatten)]
    pub by: SameBy,
}

/// One person gave so many of the answers that they say little of people.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Unbalanced {
    /// Who gave most.
    pub participant: String,
    pub answers: usize,
    /// Of how many.
    pub of: usize,
    /// How many people of equal numbers of answers would weigh as much.
    pub effective_people: f64,
    pub people: usize,
}

/// Who gave most of the answers, where they weigh as those of fewer than half of the people who gave them.
///
/// Formula: (Σn)²/Σn² people of n answers each.
///
/// Source: L. Kish (1965), Survey Sampling, 11.7.
#[must_use]
pub(super) fn unbalanced<'a>(answers: impl Iterator<Item = &'a Answer>) -> Option<Unbalanced> {
    let mut by_person: BTreeMap<&str, usize> = BTreeMap::new();
    for answer in answers {
        *by_person.entry(&answer.participant).or_default() += 1;
    }
    let effective_people = effective_people(by_person.values().map(|n| *n as f64));
    let people = by_person.len();
    let of: usize = by_person.values().sum();
    let (participant, answers) = by_person.into_iter().max_by_key(|(_, count)| *count)?;
    (2.0 * effective_people < people as f64).then(|| Unbalanced {
        participant: participant.to_owned(),
        answers,
        of,
        effective_people,
        people,
    })
}

/// How many people of equal numbers of answers weigh as much as those with these.
pub(super) fn effective_people(answers: impl Iterator<Item = f64>) -> f64 {
    let (sum, squares) = answers.fold((0.0, 0.0), |(sum, squares), n| (sum + n, squares + n * n));
    sum * sum / squares
}

impl AnswerTable {
    /// Participants, sessions and tasks whose answers may be those of one person, or the same answers twice: each with the first that
    /// it is like, by name and by answers.
    ///
    /// Formula: two are alike by answers where at least half of what chance leaves open agrees and P(as many agree) · pairs · 3 ≤ 0.005,
    /// of answers matched by trial, by the presentations of each stimulus in their order, and by how often each was answered to each
    /// stimulus. By chance the second gives an answer of the first as often as the most frequent of: the second's own
    /// answers to that stimulus, those of others, its answers whatever is presented, its right answers, and guessing.
    ///
    /// Source: docs/decisions/answers.md.
    #[must_use]
    pub fn same_people(&self) -> Vec<SamePerson> {
        let answers = self.answers();
        let mut found = same_names(answers);
        let coded = Coded::of(self);
        let others = Others::of(&coded);
        for parts in kinds_of_parts(answers) {
            let coded: Vec<Part<'_>> = parts
                .iter()
                .map(|(part, kept)| coded.part(&part.participant, kept))
                .collect();
            let pairs = coded.len() * coded.len().saturating_sub(1) / 2;
            let level = LEVEL_SHARE / pairs.max(1) as f64;
            for (i, (other, _)) in parts.iter().enumerate() {
                let known = found.iter().any(|one| {
                    matches!(one.by, SameBy::Answers { .. })
                        && one.other.participant == other.participant
                        && (one.other == *other || one.other.is_whole())
                });
                if known {
                    continue;
                }
                let first = (0..i).find_map(|j| {
                    let one = &parts[j].0;
                    if !comparable(one, other) {
                        return None;
                    }
                    let by = alike([&coded[j], &coded[i]], &others, level)?;
                    Some((one.clone(), by))
                });
                found.extend(first.map(|(one, by)| SamePerson {
                    one,
                    other: other.clone(),
                    by,
                }));
            }
        }
        found
    }

    /// The warnings about participants who may be one, and about one who gave most of the answers.
    #[must_use]
    pub fn warnings_of_people(&self) -> Vec<Warning> {
        let unbalanced = unbalanced(self.answers().iter());
        warnings_of_people(&self.same_people(), unbalanced.as_ref())
    }

    /// The same with who stands in `same` counted once: under the first of two names, without answers that are there twice; `None` where
    /// nobody stands in it.
    #[must_use]
    pub fn counted_once(&self, same: &[SamePerson]) -> Option<Self> {
        if same.is_empty() {
            return None;
        }
        let twice = same
            .iter()
            .filter(|one| matches!(one.by, SameBy::Answers { .. }));
        let twice: Vec<&AnswersPart> = twice.map(|one| &one.other).collect();
        let names: BTreeMap<&str, &str> = same
            .iter()
            .filter(|one| one.by == SameBy::Name)
            .map(|one| (&*one.other.participant, &*one.one.participant))
            .collect();
        Some(self.with_answers(|answer| {
            if twice.iter().any(|part| part.holds(answer)) {
                return None;
            }
            let mut kept = answer.clone();
            if let Some(name) = names.get(&*answer.participant) {
                kept.participant = (*name).to_owned();
            }
            Some(kept)
        }))
    }
}

/// Participants whose names differ in capital letters, blanks or leading zeros alone.
fn same_names(answers: &[Answer]) -> Vec<SamePerson> {
    let mut first: BTreeMap<String, &str> = BTreeMap::new();
    let mut seen: BTreeSet<&str> = BTreeSet::new();
    let mut found = Vec::new();
    for answer in answers {
        let name = answer.participant.as_str();
        if !seen.insert(name) {
            continue;
        }
        let one = *first.entry(plain_name(name)).or_insert(name);
        if one != name {
            found.push(SamePerson {
                one: AnswersPart::of(one),
                other: AnswersPart::of(name),
                by: SameBy::Name,
            });
        }
    }
    found
}

type Parts<'a> = Vec<(AnswersPart, Vec<(usize, &'a Answer)>)>;

/// The answers by what `of` makes of each, in the order of the table.
fn parts_by(answers: &[Answer], of: impl Fn(&Answer) -> AnswersPart) -> Parts<'_> {
    let mut places: BTreeMap<AnswersPart, usize> = BTreeMap::new();
    let mut found: Parts<'_> = Vec::new();
    for (row, answer) in answers.iter().enumerate() {
        let part = of(answer);
        let place = *places.entry(part.clone()).or_insert(found.len());
        if place == found.len() {
            found.push((part, Vec::new()));
        }
        found[place].1.push((row, answer));
    }
    found
}

/// All answers of each participant, those of each session where somebody has several, and those of each task where somebody has several.
fn kinds_of_parts(answers: &[Answer]) -> Vec<Parts<'_>> {
    let people = parts_by(answers, |answer| AnswersPart::of(&answer.participant));
    let sessions = parts_by(answers, |answer| AnswersPart {
        session: Some(answer.session.clone()),
        ..AnswersPart::of(&answer.participant)
    });
    let tasks = parts_by(answers, |answer| AnswersPart {
        task: Some(answer.task.clone()),
        ..AnswersPart::of(&answer.participant)
    });
    let more = people.len();
    let parts = [sessions, tasks].into_iter();
    std::iter::once(people)
        .chain(parts.filter(|parts| parts.len() > more))
        .collect()
}

/// Whether two parts are of one kind: tasks are compared with themselves in others.
fn comparable(one: &AnswersPart, other: &AnswersPart) -> bool {
    one.task == other.task
}

/// What says that two parts are of one person, where they agree by less than `level`.
fn alike<'a>(parts: [&'a Part<'a>; 2], others: &'a Others, level: f64) -> Option<SameBy> {
    Matching::ALL.into_iter().find_map(|matching| {
        let found = matched(parts, others, matching)?;
        let improbable = found.p_value * Matching::ALL.len() as f64 <= level;
        improbable.then_some(SameBy::Answers {
            matching,
            matched: found.matched,
            alike: found.alike,
            expected: found.expected,
            p_value: found.p_value,
        })
    })
}

/// Who may be one person, and who gave most of the answers.
pub(super) fn warnings_of_people(
    same: &[SamePerson],
    unbalanced: Option<&Unbalanced>,
) -> Vec<Warning> {
    let same = same.iter().map(|found| match &found.by {
        SameBy::Name => Warning::from(CompareWarning::Mixed {
            how: Mixed::NamesAlike {
                of: Named::Participant,
                one: found.one.participant.clone(),
                other: found.other.participant.clone(),
            },
        }),
        SameBy::Answers {
            matching,
            matched,
            alike,
            expected,
            p_value: _,
        } => Warning::from(AssociationWarning::SameAnswers {
            one: found.one.clone(),
            other: found.other.clone(),
            matching: *matching,
            matched: *matched,
            alike: *alike,
            expected: *expected,
        }),
    });
    let unbalanced = unbalanced.map(|found| {
        Warning::from(AssociationWarning::UnbalancedAnswers {
            participant: found.participant.clone(),
            answers: found.answers,
            of: found.of,
            people: found.people,
            effective_people: found.effective_people,
        })
    });
    same.chain(unbalanced).collect()
}
