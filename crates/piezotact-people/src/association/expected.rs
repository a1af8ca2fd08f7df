//! How many answers are those that are expected, beside what guessing reaches.

use std::collections::BTreeMap;
use std::fmt;

use piezotact::criterion::{Criterion, Limit, Outcome};
use serde::{Deserialize, Serialize};

use super::answer::{Answer, Declared};
use crate::interval::clustered_interval;

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
    /// The share with its 95 % interval over participants, beside chance: met above it, not met below it.
    pub criterion: Criterion<ExpectedCriterion>,
}

impl ExpectedShare {
    /// In words: the share, its interval, chance, and whether it is above.
    #[must_use]
    pub fn words(&self) -> String {
        let share = 100.0 * self.expected as f64 / self.answers as f64;
        let chance = format!("chance {:.1} %", 100.0 * self.chance_share);
        let Some([low, high]) = self.criterion.interval else {
            return format!("{share:.1} % as expected ({chance}; no interval: not decided)");
        };
        let told = match self.criterion.outcome {
            Outcome::Met => "above chance",
            Outcome::NotMet => "below chance",
            Outcome::NotDecided => "not told from chance",
        };
        format!(
            "{share:.1} % as expected (95 %: {:.1} to {:.1} %; {chance}: {told})",
            100.0 * low,
            100.0 * high
        )
    }
}

/// The share of `answers` to stimuli of `kind` that are as expected; `None` where there are none. Its interval is clustered by
/// participant.
///
/// Source: decision 0064 of this project; intervals: [`clustered_interval`].
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
    let mut people: BTreeMap<&str, (usize, usize)> = BTreeMap::new();
    let mut guessed = 0.0;
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
        person.0 += usize::from(answer.answered == *wanted);
        person.1 += 1;
        guessed += 1.0 / answer.offered.len() as f64;
    }
    let each: Vec<(usize, usize)> = people.into_values().collect();
    let found = clustered_interval(&each)?;
    let answers = each.iter().map(|(_, answers)| answers).sum::<usize>();
    let chance_share = guessed / answers as f64;
    let judged = found.interval.unwrap_or([f64::NAN; 2]);
    let limit = Limit::at_least(chance_share);
    let what = ExpectedCriterion::AboveChance;
    Some(ExpectedShare {
        stimuli: kind,
        answers,
        expected: each.iter().map(|(expected, _)| expected).sum(),
        chance_share,
        criterion: Criterion {
            interval: found.interval,
            ..Criterion::new(what, "", found.share, Some(judged), limit)
        },
    })
}
