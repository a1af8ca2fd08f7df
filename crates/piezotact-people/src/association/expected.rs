//! How many answers are those that are expected, beside what guessing reaches.

use std::collections::BTreeMap;
use std::fmt;

use piezotact::criterion::{Criterion, Limit, Outcome};
use piezotact::statistics::{mean, mean_interval};
use serde::{Deserialize, Serialize};

use super::answer::{Answer, Declared};
use super::guessing::{Guessing, Person, guessing};
use super::same_person::effective_people;
use crate::interval::{MIN_PARTICIPANTS, clustered_interval};

/// By how much habits must be above chance to be mentioned.
const MARKED_SHARE: f64 = 0.03;

/// Of which stimuli the answers are.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum StimulusKind {
    /// All of them.
    All,
    /// Samples, and textures without manipulation.
    Plain,
    /// Manipulated textures.
    Manipulated,
}

/// What the share of expected answers is judged by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ExpectedCriterion {
    /// At least what guessing reaches.
    AboveChance,
}

impl fmt::Display for ExpectedCriterion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("share of answers as expected, beside that of guessing")
    }
}

/// The share of answers that are those expected, with its interval, and what guessing reaches.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ExpectedShare {
    /// Of which stimuli.
    pub stimuli: StimulusKind,
    /// How many answers, to presentations in which what is expected was offered.
    pub answers: usize,
    /// How many of them are as expected.
    pub expected: usize,
    /// The mean over answers of 1/number of samples offered, 0–1: what guessing reaches, with or without repeats.
    pub chance_share: f64,
    /// What answers like these reach whatever is presented, 0–1: for each answer, the share of what others said with the same samples
    /// on offer that would be as expected here. Above chance where people prefer what is presented most.
    pub habit_share: f64,
    /// Participants who answer as guessing does beside others who do far better, where the answers show such a mixture.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub guessing: Option<Guessing>,
    /// The share with its 95 % interval over participants, beside the larger of chance and habit: met above it, not met below it; not
    /// decided where people counted otherwise would decide otherwise.
    pub criterion: Criterion<ExpectedCriterion>,
    /// The same with another weighting of participants: those who may be one person once, or all alike where one gave most of the answers.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub recounts: Vec<Recount>,
}

/// How people are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Counted {
    /// Those who may be one person once.
    Once,
    /// All alike, however many answers they gave.
    Alike,
}

/// The share and what it decides with another weighting of participants.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Recount {
    /// How they are counted.
    pub counted: Counted,
    /// The share, 0–1.
    pub share: f64,
    /// Its 95 % interval over people.
    pub interval: Option<[f64; 2]>,
    /// What it decides.
    pub outcome: Outcome,
}

impl Recount {
    /// In words, such as "with those who may be one person counted once: 34.0 to 61.2 %".
    fn words(&self) -> String {
        let how = match self.counted {
            Counted::Once => "those who may be one person counted once",
            Counted::Alike => "each person weighing alike",
        };
        let found = self.interval.map_or_else(
            || "no interval".to_owned(),
            |[low, high]| format!("{:.1} to {:.1} %", 100.0 * low, 100.0 * high),
        );
        format!("with {how}: {found}")
    }
}

/// The mean of the shares of (successes, trials) of each person beside `limit`, with its interval of Student's t, where the trials weigh
/// as those of fewer than half of the people.
pub(super) fn counted_alike(people: &[(f64, f64)], limit: Limit) -> Option<Recount> {
    let shown = people.iter().filter(|(_, trials)| *trials > 0.0);
    let shown: Vec<(f64, f64)> = shown.copied().collect();
    let worth = effective_people(shown.iter().map(|(_, trials)| *trials));
    if 2.0 * worth >= shown.len() as f64 {
        return None;
    }
    let shares = shown.iter().map(|(x, n)| x / n);
    let shares: Vec<f64> = shares.collect();
    let interval = mean_interval(&shares).filter(|_| shares.len() >= MIN_PARTICIPANTS);
    let interval = interval.map(|ends| ends.map(|end| end.clamp(0.0, 1.0)));
    Some(Recount {
        counted: Counted::Alike,
        share: mean(&shares),
        interval,
        outcome: limit.judge(interval.unwrap_or([f64::NAN; 2])),
    })
}

impl ExpectedShare {
    /// In words: the share, its interval, chance, and whether it is above.
    #[must_use]
    pub fn words(&self) -> String {
        let share = 100.0 * self.expected as f64 / self.answers as f64;
        let mut chance = format!("chance {:.1} %", 100.0 * self.chance_share);
        if self.habit_share > self.chance_share + MARKED_SHARE {
            chance += &format!(
                ", {:.1} % by what people answer whatever is presented",
                100.0 * self.habit_share
            );
        }
        let Some([low, high]) = self.criterion.interval else {
            return format!("{share:.1} % as expected ({chance}; no interval: not decided)");
        };
        let told = match self.criterion.outcome {
            Outcome::Met => "above chance".to_owned(),
            Outcome::NotMet => "below chance".to_owned(),
            Outcome::NotDecided => {
                let limit = self.criterion.limit;
                let alone = limit.judge([low, high]);
                let mut other = self.recounts.iter().filter(|one| one.outcome != alone);
                match other.next() {
                    Some(recount) if alone != Outcome::NotDecided => {
                        format!("not decided {}", recount.words())
                    }
                    _ => "not told from chance".to_owned(),
                }
            }
        };
        let guessing = self.guessing.map_or_else(String::new, |found| {
            format!("; two kinds of people: {}", found.words())
        });
        format!(
            "{share:.1} % as expected (95 %: {:.1} to {:.1} %; {chance}: {told}{guessing})",
            100.0 * low,
            100.0 * high
        )
    }
}

/// How often each sample was said, by each participant.
type Said<'a> = BTreeMap<&'a str, BTreeMap<&'a str, usize>>;
/// The same by each participant to each stimulus.
type SaidTo<'a> = BTreeMap<[&'a str; 2], BTreeMap<&'a str, usize>>;

/// What people say with the same samples on offer, whatever is presented.
struct Habits<'a> {
    /// By task and samples on offer.
    said: BTreeMap<(&'a str, Vec<&'a str>), Said<'a>>,
    /// The same to each stimulus.
    said_to: BTreeMap<(&'a str, Vec<&'a str>), SaidTo<'a>>,
}

impl<'a> Habits<'a> {
    fn of(answers: &[&'a Answer]) -> Self {
        let mut said: BTreeMap<_, BTreeMap<_, BTreeMap<_, usize>>> = BTreeMap::new();
        let mut said_to: BTreeMap<_, BTreeMap<_, BTreeMap<_, usize>>> = BTreeMap::new();
        for answer in answers {
            let to = [answer.participant.as_str(), answer.presented.as_str()];
            let to = said_to.entry(Self::key(answer)).or_default().entry(to);
            *to.or_default().entry(answer.answered.as_str()).or_default() += 1;
            let by_person = said.entry(Self::key(answer)).or_default();
            let by_sample = by_person.entry(answer.participant.as_str()).or_default();
            *by_sample.entry(answer.answered.as_str()).or_default() += 1;
        }
        Self { said, said_to }
    }

    /// The share of the person's own answers to other stimuli that name `wanted`: who always says one name is right where it is
    /// presented.
    fn own_share(&self, answer: &'a Answer, wanted: &str) -> Option<f64> {
        let key = Self::key(answer);
        let person = answer.participant.as_str();
        let all = self.said.get(&key)?.get(person)?;
        let here = self
            .said_to
            .get(&key)?
            .get(&[person, answer.presented.as_str()])?;
        let of = |said: &BTreeMap<&str, usize>| {
            let named = said.get(wanted).copied().unwrap_or(0);
            [named, said.values().sum::<usize>()]
        };
        let ([named, all], [named_here, here]) = (of(all), of(here));
        (all > here).then(|| (named - named_here) as f64 / (all - here) as f64)
    }

    fn key(answer: &'a Answer) -> (&'a str, Vec<&'a str>) {
        let mut offered: Vec<&str> = answer.offered.iter().map(String::as_str).collect();
        offered.sort_unstable();
        (&answer.task, offered)
    }

    /// The share of answers of other participants that name `wanted`: each person's answers depend on each other.
    fn share(&self, answer: &'a Answer, wanted: &str) -> Option<f64> {
        let by_person = self.said.get(&Self::key(answer))?;
        let others = by_person
            .iter()
            .filter(|(person, _)| **person != answer.participant);
        let (mut named, mut all) = (0, 0);
        for (_, by_sample) in others {
            named += by_sample.get(wanted).copied().unwrap_or(0);
            all += by_sample.values().sum::<usize>();
        }
        (all > 0).then(|| named as f64 / all as f64)
    }
}

/// The share of `answers` to stimuli of `kind` that are as expected; `None` where there are none. Its interval is clustered by
/// participant. Who prefers a sample that is presented often is right more often than a guesser and has felt nothing: the limit is the
/// larger of chance, of what others answer whatever is presented, and of what the person answers when something else is.
///
/// Source: docs/decisions/answers.md; intervals: [`clustered_interval`].
#[must_use]
pub(super) fn expected_share(
    declared: &Declared,
    answers: &[&Answer],
    kind: StimulusKind,
) -> Option<ExpectedShare> {
    let expected: BTreeMap<&str, (&str, StimulusKind)> = declared
        .stimuli
        .iter()
        .map(|stimulus| {
            let kind = match stimulus.is_plain() {
                true => StimulusKind::Plain,
                false => StimulusKind::Manipulated,
            };
            (stimulus.name.as_str(), (stimulus.expected.as_str(), kind))
        })
        .collect();
    let mut people: BTreeMap<&str, Person> = BTreeMap::new();
    let (mut by_habit, mut by_own_habit) = (0.0, 0.0);
    let habits = Habits::of(answers);
    for answer in answers {
        let Some((wanted, of)) = expected.get(answer.presented.as_str()) else {
            continue;
        };
        if kind != StimulusKind::All && kind != *of {
            continue;
        }
        // Where what is expected could not be answered, nothing is right or wrong.
        if !answer.offered.iter().any(|one| one == wanted) {
            continue;
        }
        let person = people.entry(&answer.participant).or_default();
        let guess = 1.0 / answer.offered.len() as f64;
        person.right += usize::from(answer.answered == *wanted);
        person.answers += 1;
        person.guessed += guess;
        by_habit += habits.share(answer, wanted).unwrap_or(guess);
        by_own_habit += habits.own_share(answer, wanted).unwrap_or(guess);
    }
    let people: Vec<Person> = people.into_values().collect();
    let each: Vec<(usize, usize)> = people.iter().map(|p| (p.right, p.answers)).collect();
    let found = clustered_interval(&each)?;
    let answers = each.iter().map(|(_, answers)| answers).sum::<usize>();
    let chance_share = people.iter().map(|p| p.guessed).sum::<f64>() / answers as f64;
    let judged = found.interval.unwrap_or([f64::NAN; 2]);
    let habit_share = f64::max(by_habit, by_own_habit) / answers as f64;
    let limit = Limit::at_least(chance_share.max(habit_share));
    let what = ExpectedCriterion::AboveChance;
    let found = ExpectedShare {
        stimuli: kind,
        answers,
        expected: each.iter().map(|(expected, _)| expected).sum(),
        chance_share,
        habit_share,
        guessing: guessing(&people),
        criterion: Criterion {
            interval: found.interval,
            ..Criterion::new(what, "", found.share, Some(judged), limit)
        },
        recounts: Vec::new(),
    };
    let each = each.iter().map(|(x, n)| (*x as f64, *n as f64));
    let each: Vec<(f64, f64)> = each.collect();
    Some(found.with_recount(counted_alike(&each, limit)))
}

impl ExpectedShare {
    /// The same beside `recount`: not decided where that decides otherwise.
    fn with_recount(mut self, recount: Option<Recount>) -> Self {
        let other = recount.is_some_and(|one| one.outcome != self.criterion.outcome);
        if other {
            self.criterion.outcome = Outcome::NotDecided;
        }
        self.recounts.extend(recount);
        self
    }

    /// The same beside the share of those people counted once.
    #[must_use]
    pub(super) fn beside_once(self, once: Option<Self>) -> Self {
        let recount = once.map(|once| Recount {
            counted: Counted::Once,
            share: once.criterion.found.unwrap_or(f64::NAN),
            interval: once.criterion.interval,
            outcome: once.criterion.outcome,
        });
        self.with_recount(recount)
    }
}
