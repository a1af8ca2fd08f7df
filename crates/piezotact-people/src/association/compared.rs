//! Whether two samples, two tasks or two studies differ: one number for each person, and a permutation of people.

use crate::association::AssociationError;
use std::collections::{BTreeMap, BTreeSet};

use piezotact::criterion::Outcome;
use piezotact::number::counted;
use piezotact::statistics::{Permuted, holm, mean, mean_interval, sign_flip_test, t_quantile};
use serde::{Deserialize, Serialize};

use super::answer::{Answer, AnswerTable};
use super::document::Association;
use super::matrix::{MatrixConfig, selected};
use super::warning::AssociationWarning;
use crate::difference::{Difference, LEVEL_SHARE, between_people};
use crate::interval::MIN_PARTICIPANTS;

/// Divisions that are drawn where there are too many to try all.
const DRAWS: usize = 99_999;

/// Two shares of answers and their difference, over people.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Compared {
    /// What is compared.
    pub difference: Difference,
    /// The people of each; the same people twice but for groups.
    pub participants: [usize; 2],
    /// The people who have answers of one of both only, and do not count.
    pub left_out: usize,
    /// Pseudonyms that stand in both of two groups, which are taken for different people.
    pub in_both: usize,
    /// The mean of people's shares, 0–1: as expected in each of two tasks or groups; of two samples, right and taken for the other.
    pub shares: [f64; 2],
    /// Of two samples, presented with each of them: right, and taken for the other; means of people's shares, 0–1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by_sample: Option<[[f64; 2]; 2]>,
    /// What guessing reaches of each, 0–1; absent for two samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chance_shares: Option<[f64; 2]>,
    /// The first less the second.
    pub less_share: f64,
    /// Its 95 % interval over people, of Student's t, for this difference alone and at most from −1 to 1; `None` for fewer than
    /// [`MIN_PARTICIPANTS`], and for people who are all alike.
    pub interval: Option<[f64; 2]>,
    /// The permutation of people.
    pub test: Permuted,
    /// Its probability, adjusted by Holm where several differences are asked for.
    pub p_adjusted: f64,
    /// The smallest probability that so few people can give.
    pub smallest_p: f64,
    /// How many differences were asked for.
    pub of: usize,
    /// The probability with those counted once who may be one person; absent where nobody may.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p_once: Option<f64>,
}

/// What people share in one condition: right answers, wrong ones of interest, and all that count.
#[derive(Clone, Copy, Default)]
struct Counts {
    right: f64,
    other: f64,
    all: f64,
    /// Right answers of a guesser.
    guessed: f64,
}

impl Counts {
    fn right_share(&self) -> f64 {
        self.right / self.all
    }
}

/// The difference between two of `table`: samples or tasks.
///
/// Formula: of samples a and b, d of a person is ½·Σ (right − taken for the other)/presented over presentations of a and of b in which
/// both could be answered, which is zero for whoever answers both alike; of tasks, the difference of the shares of answers as
/// expected, among those in which what is expected was offered.
///
/// Source: docs/decisions/campaigns.md; [`sign_flip_test`].
///
/// # Errors
/// [`AssociationError`].
pub fn compared(
    table: &AnswerTable,
    config: &MatrixConfig,
    difference: &Difference,
) -> Result<Compared, AssociationError> {
    let found = compared_within(table, config, difference)?;
    let once = table.counted_once(&table.same_people());
    let once = once.map(|once| compared_within(&once, config, difference));
    Ok(found.beside_once(once))
}

fn compared_within(
    table: &AnswerTable,
    config: &MatrixConfig,
    difference: &Difference,
) -> Result<Compared, AssociationError> {
    let answers: Vec<&Answer> = selected(table, config).collect();
    match difference {
        Difference::Samples(names) => {
            known("samples", names, &table.declared().samples)?;
            let conditions = [0, 1].map(|i| told_apart(&answers, [&names[i], &names[1 - i]]));
            let mut found = paired(difference, &conditions, |[a, b]| {
                let half = |of: fn(&Counts) -> f64| (of(a) / a.all + of(b) / b.all) / 2.0;
                [half(|c| c.right), half(|c| c.other)]
            })?;
            let [a, b] = &conditions;
            let of_both = |own: &BTreeMap<&str, Counts>, other: &BTreeMap<&str, Counts>| {
                let people = own.iter().filter(|(person, _)| other.contains_key(*person));
                let shares = people.map(|(_, c)| [c.right / c.all, c.other / c.all]);
                let shares: Vec<[f64; 2]> = shares.collect();
                [0, 1].map(|i| mean(&shares.iter().map(|s| s[i]).collect::<Vec<f64>>()))
            };
            found.by_sample = Some([of_both(a, b), of_both(b, a)]);
            Ok(found)
        }
        Difference::Tasks(names) | Difference::Again(names) | Difference::People(names) => {
            let tasks: BTreeSet<&str> = answers.iter().map(|a| a.task.as_str()).collect();
            let tasks: Vec<String> = tasks.into_iter().map(Into::into).collect();
            known("tasks", names, &tasks)?;
            let conditions = [0, 1].map(|i| {
                as_expected(
                    table,
                    answers.iter().copied().filter(|a| a.task == names[i]),
                )
            });
            paired(difference, &conditions, |[a, b]| {
                [a, b].map(Counts::right_share)
            })
        }
    }
}

/// The difference between two studies, each with what is selected of its answers: of different people ([`Difference::People`]), or of the same ones by their pseudonyms
/// ([`Difference::Again`]).
///
/// Source: as [`compared`]; [`between_people`].
///
/// # Errors
/// [`AssociationError`].
pub fn compared_studies(
    answers: [(&AnswerTable, &MatrixConfig); 2],
    difference: &Difference,
) -> Result<Compared, AssociationError> {
    let found = compared_between(answers, difference)?;
    let once = answers.map(|(table, _)| table.counted_once(&table.same_people()));
    if once.iter().all(Option::is_none) {
        return Ok(found);
    }
    let tables = [0, 1].map(|i| (once[i].as_ref().unwrap_or(answers[i].0), answers[i].1));
    Ok(found.beside_once(Some(compared_between(tables, difference))))
}

fn compared_between(
    answers: [(&AnswerTable, &MatrixConfig); 2],
    difference: &Difference,
) -> Result<Compared, AssociationError> {
    let conditions = answers.map(|(table, config)| as_expected(table, selected(table, config)));
    if !matches!(difference, Difference::People(_)) {
        return paired(difference, &conditions, |[a, b]| {
            [a, b].map(Counts::right_share)
        });
    }
    let chance = [0, 1].map(|i| chance_share(&conditions[i]));
    let in_both = conditions[0].keys();
    let in_both = in_both.filter(|person| conditions[1].contains_key(*person));
    let in_both = in_both.count();
    let [a, b] =
        conditions.map(|people| -> Vec<f64> { people.values().map(Counts::right_share).collect() });
    let test = between_people(&a, &b, DRAWS, 1).ok_or_else(|| nobody(difference, ""))?;
    let shares = [&a, &b].map(|shares| mean(shares));
    Ok(Compared {
        difference: difference.clone(),
        participants: [a.len(), b.len()],
        left_out: 0,
        in_both,
        by_sample: None,
        shares,
        chance_shares: Some(chance),
        less_share: shares[0] - shares[1],
        interval: welch_interval(&a, &b),
        p_adjusted: test.p_value,
        smallest_p: difference.smallest_p([a.len(), b.len()]),
        test,
        of: 1,
        p_once: None,
    })
}

impl Association {
    /// The same with the differences `found`, their probabilities adjusted for all of them.
    ///
    /// Source: [`holm`].
    #[must_use]
    pub fn with_comparisons(mut self, mut found: Vec<Compared>) -> Self {
        let p_values: Vec<f64> = found.iter().map(|one| one.test.p_value).collect();
        let of = found.len();
        for (one, p) in found.iter_mut().zip(holm(&p_values)) {
            one.p_adjusted = p;
            one.of = of;
            if one.in_both > 0 {
                let people = one.in_both;
                self.warnings
                    .push(AssociationWarning::SamePseudonyms { people }.into());
            }
        }
        self.comparisons = found;
        self
    }
}

fn known(what: &'static str, names: &[String; 2], all: &[String]) -> Result<(), AssociationError> {
    let wrong = match names[0] == names[1] {
        true => Some(&names[1]),
        false => names.iter().find(|name| !all.contains(name)),
    };
    match wrong {
        None => Ok(()),
        Some(name) => Err(AssociationError::NotToCompare {
            what,
            name: name.clone(),
            known: all.join(", "),
        }),
    }
}

fn nobody(difference: &Difference, both: &'static str) -> AssociationError {
    AssociationError::Nobody {
        of: difference.to_string(),
        both,
        advice: match difference {
            Difference::Samples(_) => {
                "both samples must be presented in trials in which both can be answered"
            }
            Difference::Tasks(_) | Difference::Again(_) => {
                "compare different people where they are not the same"
            }
            Difference::People(_) => "check the study and the task",
        },
    }
}

/// Presentations of the first in which both could be answered, for each person.
fn told_apart<'a>(answers: &[&'a Answer], [own, other]: [&String; 2]) -> BTreeMap<&'a str, Counts> {
    let mut people: BTreeMap<&str, Counts> = BTreeMap::new();
    for answer in answers {
        let both = answer.offered.contains(own) && answer.offered.contains(other);
        if answer.presented != *own || !both {
            continue;
        }
        let person = people.entry(&answer.participant).or_default();
        person.all += 1.0;
        person.right += f64::from(u8::from(answer.answered == *own));
        person.other += f64::from(u8::from(answer.answered == *other));
    }
    people
}

/// Answers in which what is expected was offered, for each person.
fn as_expected<'a>(
    table: &AnswerTable,
    answers: impl Iterator<Item = &'a Answer>,
) -> BTreeMap<&'a str, Counts> {
    let stimuli = table.declared().stimuli.iter();
    let expected: BTreeMap<&str, &String> = stimuli
        .map(|stimulus| (stimulus.name.as_str(), &stimulus.expected))
        .collect();
    let mut people: BTreeMap<&str, Counts> = BTreeMap::new();
    for answer in answers {
        let Some(wanted) = expected.get(answer.presented.as_str()) else {
            continue;
        };
        if !answer.offered.contains(wanted) {
            continue;
        }
        let person = people.entry(&answer.participant).or_default();
        person.all += 1.0;
        person.right += f64::from(u8::from(answer.answered == **wanted));
        person.guessed += 1.0 / answer.offered.len() as f64;
    }
    people
}

/// Two conditions of the same people, whose shares `of` gives.
fn paired(
    difference: &Difference,
    conditions: &[BTreeMap<&str, Counts>; 2],
    of: impl Fn([&Counts; 2]) -> [f64; 2],
) -> Result<Compared, AssociationError> {
    let [first, second] = conditions;
    let both = first
        .iter()
        .filter_map(|(person, a)| Some(of([a, second.get(person)?])));
    let both: Vec<[f64; 2]> = both.collect();
    let everybody: BTreeSet<&&str> = first.keys().chain(second.keys()).collect();
    let differences: Vec<f64> = both.iter().map(|[a, b]| a - b).collect();
    let test =
        sign_flip_test(&differences, DRAWS, 1).ok_or_else(|| nobody(difference, " with both"))?;
    let people = both.len();
    let chance = [0, 1].map(|i| chance_share(&conditions[i]));
    let shares = [0, 1].map(|i| both.iter().map(|shares| shares[i]).sum::<f64>() / people as f64);
    Ok(Compared {
        difference: difference.clone(),
        participants: [people; 2],
        left_out: everybody.len() - people,
        in_both: 0,
        by_sample: None,
        shares,
        chance_shares: (!matches!(difference, Difference::Samples(_))).then_some(chance),
        less_share: shares[0] - shares[1],
        interval: mean_interval(&differences)
            .filter(|_| people >= MIN_PARTICIPANTS)
            .and_then(possible)
            // Where no permutation reaches 5 %, an interval would say more than the people do.
            .filter(|_| difference.smallest_p([people; 2]) <= LEVEL_SHARE),
        p_adjusted: test.p_value,
        smallest_p: difference.smallest_p([people; 2]),
        test,
        of: 1,
        p_once: None,
    })
}

/// What a guesser reaches in all answers.
fn chance_share(people: &BTreeMap<&str, Counts>) -> f64 {
    let sum = |of: fn(&Counts) -> f64| people.values().map(of).sum::<f64>();
    sum(|c| c.guessed) / sum(|c| c.all)
}

/// The 95 % interval of the difference of two means, with the smaller number of degrees of freedom.
fn welch_interval(a: &[f64], b: &[f64]) -> Option<[f64; 2]> {
    let smaller = a.len().min(b.len());
    if smaller < MIN_PARTICIPANTS {
        return None;
    }
    let error_squared = |values: &[f64]| {
        let (n, middle) = (values.len() as f64, mean(values));
        values.iter().map(|v| (v - middle).powi(2)).sum::<f64>() / (n - 1.0) / n
    };
    let reach = t_quantile(smaller - 1)? * (error_squared(a) + error_squared(b)).sqrt();
    let less = mean(a) - mean(b);
    possible([less - reach, less + reach])
}

/// An interval of a difference of shares; `None` where it has no width, as people who are all alike do not say how people differ.
fn possible([low, high]: [f64; 2]) -> Option<[f64; 2]> {
    (high > low).then(|| [low.max(-1.0), high.min(1.0)])
}

impl Compared {
    /// The same beside what is found with people counted once; where nothing can be found then, it rests on them.
    fn beside_once(self, once: Option<Result<Self, AssociationError>>) -> Self {
        let p_once = once.map(|once| once.map_or(1.0, |once| once.test.p_value));
        Self { p_once, ..self }
    }

    /// Whether it differs only while people who may be one are counted as several.
    fn rests_on_same_people(&self) -> bool {
        self.p_once.is_some_and(|p| p > LEVEL_SHARE)
    }

    /// Met where the two differ; else not decided: that they are alike is never shown by a test of a difference.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        match self.p_adjusted <= LEVEL_SHARE && !self.rests_on_same_people() {
            true => Outcome::Met,
            false => Outcome::NotDecided,
        }
    }

    /// What was found, in one sentence.
    #[must_use]
    pub fn sentence(&self) -> String {
        let percent = |share: f64| format!("{:.1} %", 100.0 * share);
        let [a, b] = self.shares.map(percent);
        let [one, two] = self.difference.names();
        let shares = match &self.by_sample {
            Some([first, second]) => format!(
                "{one}: right {}, called {two} {}; {two}: right {}, called {one} {}",
                percent(first[0]),
                percent(first[1]),
                percent(second[0]),
                percent(second[1])
            ),
            None => format!("{one} {a}, {two} {b} as expected"),
        };
        let what = match &self.difference {
            Difference::Samples(_) => "right less called the other",
            _ => "difference",
        };
        let people = match &self.difference {
            Difference::People(_) => format!(
                "means of groups of {} and {}",
                self.participants[0],
                counted(self.participants[1], "participant")
            ),
            _ => format!("means of {}", counted(self.participants[0], "participant")),
        };
        let interval = self.interval.map_or_else(String::new, |[low, high]| {
            format!(
                ", 95 % of Student's t {:.1} to {:.1}",
                100.0 * low,
                100.0 * high
            )
        });
        let left_out = match self.left_out {
            0 => String::new(),
            left_out => format!(
                "; {} with answers of one only left out",
                counted(left_out, "participant")
            ),
        };
        let chance = match self.chance_shares {
            Some([a, b]) if self.guessing_differs() => {
                format!(" Guessing reaches {} and {}.", percent(a), percent(b))
            }
            _ => String::new(),
        };
        format!(
            "{shares} ({people}{left_out}); {what} {:.1} points{interval}; permutation of participants, p = {}{}: {}.{chance}",
            100.0 * self.less_share,
            p_text(self.p_adjusted),
            match self.of {
                0 | 1 => String::new(),
                of => format!(" (Holm's, of {of})"),
            },
            self.verdict()
        )
    }

    /// The conclusion in words.
    #[must_use]
    pub fn verdict(&self) -> &'static str {
        let differs = self.outcome() == Outcome::Met;
        match &self.difference {
            _ if !differs && self.smallest_p > LEVEL_SHARE => {
                "not decided: with so few participants no difference reaches 5 %"
            }
            _ if !differs && self.p_adjusted <= LEVEL_SHARE => {
                "not decided: with those counted once who may be one person, no difference is shown"
            }
            _ if !differs => "not decided",
            Difference::Samples(_) if self.less_share > 0.0 => "told apart better than by guessing",
            Difference::Samples(_) => "called the other more often than right",
            _ if self.guessing_differs() => "they differ, and so does guessing: not decided why",
            _ => "they differ",
        }
    }

    /// Whether guessers reach different shares in both.
    fn guessing_differs(&self) -> bool {
        self.chance_shares
            .is_some_and(|[a, b]| (a - b).abs() > 0.005)
    }
}

/// A probability as papers print it.
fn p_text(p: f64) -> String {
    match p {
        p if p < 0.000_1 => "less than 0.0001".to_owned(),
        p if p < 0.01 => format!("{p:.4}"),
        p => format!("{p:.3}"),
    }
}
