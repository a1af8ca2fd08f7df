//! Whether two samples, two tasks or two studies differ: one number for each person, and a permutation of people.

use crate::association::AssociationError;
use std::collections::{BTreeMap, BTreeSet};

use piezotact::compare::plain_name;
use piezotact::criterion::Outcome;
use piezotact::number::{counted, signed};
use piezotact::statistics::{Permuted, holm, mean, sign_flip_test};
use serde::{Deserialize, Serialize};
use statrs::distribution::{ContinuousCDF, Normal};

use super::answer::{Answer, AnswerTable};
use super::document::Association;
use super::guessing::{Guessing, Person, guessing};
use super::level::{ByStimulus, Expected, Level, Same, as_expected};
use super::matrix::{MatrixConfig, selected};
use super::same_person::AnswersPart;
use super::warning::AssociationWarning;
use crate::difference::{
    Difference, LEVEL_SHARE, MIN_GROUP, between_interval, between_people, paired_interval,
};

/// Divisions that are drawn where there are too many to try all.
const DRAWS: usize = 19_999;

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
    /// People of one group who answer as somebody of the other does, so that they may be the same.
    #[serde(default)]
    pub same_answers: usize,
    /// The mean of people's shares, 0–1: as expected in each of two tasks or groups; of two samples, right and taken for the other.
    pub shares: [f64; 2],
    /// Of two samples, presented with each of them: right, and taken for the other; means of people's shares, 0–1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub by_sample: Option<[[f64; 2]; 2]>,
    /// The stimuli that both have, over which the shares of each person are means, each stimulus weighing alike: 0 where both have none in
    /// common, and all of each count. Absent for two samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub stimuli: Option<usize>,
    /// Stimuli that one of both has alone, and that do not count.
    #[serde(default)]
    pub stimuli_left_out: usize,
    /// What guessing reaches of each, 0–1; absent for two samples.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub chance_shares: Option<[f64; 2]>,
    /// Participants who answer as guessing does beside others who do far better, of each; absent for two samples.
    #[serde(default)]
    pub guessing: [Option<Guessing>; 2],
    /// The first less the second.
    pub less_share: f64,
    /// Its 95 % interval over people, for this difference alone and at most from −1 to 1: the differences that the test does not
    /// reject, and no narrower than that of as many answers of people who are alike. `None` for people too few to decide.
    pub interval: Option<[f64; 2]>,
    /// The permutation of people: of signs, or of Welch's t of two groups.
    pub test: Permuted,
    /// The probability that decides: that of the permutation; of groups, the larger of it and that of Student's t; of shares as expected,
    /// no smaller than that of as many answers of people who are alike.
    pub p_value: f64,
    /// The same, adjusted by Holm where several differences are asked for.
    pub p_adjusted: f64,
    /// The smallest probability that so few people can give; 1 for groups too small to decide.
    pub smallest_p: f64,
    /// How many differences were asked for.
    pub of: usize,
    /// The probability with those counted once who may be one person; absent where nobody may.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub p_once: Option<f64>,
}

/// What one person answered in one condition: right, the other of two samples, and all that count.
#[derive(Clone, Copy, Default)]
struct Counts {
    other: usize,
    own: Person,
}

impl Counts {
    fn right_share(&self) -> f64 {
        self.own.right as f64 / self.own.answers as f64
    }

    fn other_share(&self) -> f64 {
        self.other as f64 / self.own.answers as f64
    }
}

/// The difference between two of `table`: samples or tasks.
///
/// Formula: of samples a and b, d of a person is ½·Σ (right − taken for the other)/presented over presentations of a and of b in which
/// both could be answered, which is zero for whoever answers both alike; of tasks, the difference of the means over stimuli of the shares
/// of answers as expected, among those in which what is expected was offered, over the stimuli that the person has in both.
///
/// Source: docs/decisions/answers.md; [`sign_flip_test`].
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
                let half = |of: fn(&Counts) -> f64| f64::midpoint(of(a), of(b));
                [half(Counts::right_share), half(Counts::other_share)]
            })?;
            let [a, b] = &conditions;
            let of_both = |own: &BTreeMap<&str, Counts>, other: &BTreeMap<&str, Counts>| {
                let people = own.iter().filter(|(person, _)| other.contains_key(*person));
                let shares = people.map(|(_, c)| [c.right_share(), c.other_share()]);
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
            of_expected(difference, &conditions)
        }
    }
}

/// The difference of the shares as expected in two conditions of the same people.
fn of_expected(
    difference: &Difference,
    conditions: &[ByStimulus<'_>; 2],
) -> Result<Compared, AssociationError> {
    let level = Level::of(conditions, Same::People);
    let found = paired(difference, &level.people, |both| both.map(|one| one.share))?;
    let found = found.beside_answers(level.error());
    let everybody: BTreeSet<&&str> = conditions.iter().flat_map(BTreeMap::keys).collect();
    Ok(Compared {
        left_out: everybody.len() - found.participants[0],
        ..found.with_level(&level)
    })
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
        return of_expected(difference, &conditions);
    }
    let tables = answers.map(|(table, _)| table);
    let (in_both, same_answers) = (names_in_both(tables), answers_in_both(tables));
    let level = Level::of(&conditions, Same::Nobody);
    let [a, b] = [0, 1].map(|i| -> Vec<f64> {
        let people = level.people[i].values();
        people.map(|one| one.share).collect()
    });
    let found = between_people(&a, &b, DRAWS, 1).ok_or_else(|| nobody(difference, ""))?;
    let shares = [&a, &b].map(|shares| mean(shares));
    let found = Compared {
        difference: difference.clone(),
        participants: [a.len(), b.len()],
        left_out: 0,
        in_both,
        same_answers,
        by_sample: None,
        shares,
        stimuli: None,
        stimuli_left_out: 0,
        chance_shares: None,
        guessing: [None; 2],
        less_share: shares[0] - shares[1],
        interval: between_interval(&a, &b, DRAWS, 1),
        p_value: found.p_value,
        p_adjusted: found.p_value,
        smallest_p: difference.smallest_p([a.len(), b.len()]),
        test: found.permuted,
        of: 1,
        p_once: None,
    };
    Ok(found.beside_answers(level.error()).with_level(&level))
}

/// How many pseudonyms stand in both, but for capital letters, blanks and zeros.
fn names_in_both(tables: [&AnswerTable; 2]) -> usize {
    let [first, second] = tables.map(|of| -> BTreeSet<String> {
        let names = of.answers().iter().map(|one| plain_name(&one.participant));
        names.collect()
    });
    first.intersection(&second).count()
}

/// How many people of the first answer as somebody of the second does.
fn answers_in_both([first, second]: [&AnswerTable; 2]) -> usize {
    let marked = [("1 ", first), ("2 ", second)].map(|(mark, of)| {
        let answers = of.answers().iter().cloned();
        answers.map(move |one| Answer {
            participant: format!("{mark}{}", one.participant),
            ..one
        })
    });
    let mut declared = first.declared().clone();
    for sample in &second.declared().samples {
        if !declared.samples.contains(sample) {
            declared.samples.push(sample.clone());
        }
    }
    for stimulus in &second.declared().stimuli {
        if !declared.stimuli.iter().any(|one| one.name == stimulus.name) {
            declared.stimuli.push(stimulus.clone());
        }
    }
    let both = AnswerTable::new(declared, marked.into_iter().flatten().collect());
    let alike = both.map_or_else(|_no_table| Vec::new(), |both| both.same_people());
    let of = |part: &AnswersPart| part.participant.starts_with('1');
    let across = alike
        .iter()
        .filter(|found| of(&found.one) != of(&found.other));
    let across: BTreeSet<&str> = across.map(|found| found.one.participant.as_str()).collect();
    across.len()
}

impl Association {
    /// The same with the differences `found`, their probabilities adjusted for all of them, and warnings about them.
    ///
    /// Source: [`holm`].
    #[must_use]
    pub fn with_comparisons(mut self, mut found: Vec<Compared>) -> Self {
        let p_values: Vec<f64> = found.iter().map(|one| one.p_value).collect();
        let of = found.len();
        for (one, p) in found.iter_mut().zip(holm(&p_values)) {
            one.p_adjusted = p;
            one.of = of;
            if one.in_both > 0 {
                let people = one.in_both;
                self.warnings
                    .push(AssociationWarning::SamePseudonyms { people }.into());
            }
            for guessing in one.guessing.into_iter().flatten() {
                let warning = AssociationWarning::SomeGuess { guessing }.into();
                if !self.warnings.contains(&warning) {
                    self.warnings.push(warning);
                }
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
            Difference::Tasks(_) | Difference::Again(_) => "compare different people with people:",
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
        person.own.answers += 1;
        person.own.right += usize::from(answer.answered == *own);
        person.other += usize::from(answer.answered == *other);
    }
    people
}

/// Two conditions of the same people, whose shares `of` gives.
fn paired<T>(
    difference: &Difference,
    conditions: &[BTreeMap<&str, T>; 2],
    of: impl Fn([&T; 2]) -> [f64; 2],
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
    let shares = [0, 1].map(|i| both.iter().map(|shares| shares[i]).sum::<f64>() / people as f64);
    Ok(Compared {
        difference: difference.clone(),
        participants: [people; 2],
        left_out: everybody.len() - people,
        in_both: 0,
        same_answers: 0,
        by_sample: None,
        shares,
        stimuli: None,
        stimuli_left_out: 0,
        chance_shares: None,
        guessing: [None; 2],
        less_share: shares[0] - shares[1],
        interval: paired_interval(&differences, DRAWS, 1),
        p_value: test.p_value,
        p_adjusted: test.p_value,
        smallest_p: difference.smallest_p([people; 2]),
        test,
        of: 1,
        p_once: None,
    })
}

impl Compared {
    /// The same beside a difference of answers with the standard error `error`, as if nobody differed from anybody: the larger probability
    /// decides, and the interval holds both. Near 0 and 100 % people show no spread, and their shares are skewed.
    fn beside_answers(self, error: f64) -> Self {
        if self.smallest_p > LEVEL_SHARE || error.is_nan() || error <= 0.0 {
            return self;
        }
        let of = Normal::standard();
        let p_value = 2.0 * of.cdf(-self.less_share.abs() / error);
        let p_value = p_value.max(self.p_value);
        let reach = of.inverse_cdf(1.0 - 0.5 * LEVEL_SHARE) * error;
        let own = [self.less_share - reach, self.less_share + reach];
        let [low, high] = self.interval.unwrap_or(own);
        Self {
            p_value,
            p_adjusted: p_value,
            interval: Some([low.min(own[0]).max(-1.0), high.max(own[1]).min(1.0)]),
            ..self
        }
    }

    /// The same with the stimuli of `level`, what guessing reaches of them, and who guesses.
    fn with_level(self, level: &Level<'_>) -> Self {
        let of = |of: fn(&Expected) -> f64, i: usize| -> Vec<f64> {
            level.people[i].values().map(of).collect()
        };
        let guessed = [0, 1].map(|i| mean(&of(|one| one.guessed_share, i)));
        let guessing = [0, 1].map(|i| {
            let people = level.people[i].values();
            guessing(&people.map(|one| one.own).collect::<Vec<_>>())
        });
        Self {
            stimuli: Some(level.stimuli),
            stimuli_left_out: level.left_out,
            chance_shares: Some(guessed),
            guessing,
            ..self
        }
    }

    /// The same beside what is found with people counted once; where nothing can be found then, it rests on them.
    fn beside_once(self, once: Option<Result<Self, AssociationError>>) -> Self {
        let p_once = once.map(|once| once.map_or(1.0, |once| once.p_value.max(once.smallest_p)));
        Self { p_once, ..self }
    }

    /// Whether it differs only while people who may be one are counted as several.
    fn rests_on_same_people(&self) -> bool {
        self.p_once.is_some_and(|p| p > LEVEL_SHARE)
    }

    /// Met where the two differ; else not decided: that they are alike is never shown by a test of a difference.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        let rests = self.rests_on_same_people() || self.same_answers > 0;
        match self.p_adjusted <= LEVEL_SHARE && self.can_decide() && !rests {
            true => Outcome::Met,
            false => Outcome::NotDecided,
        }
    }

    /// Whether so few people can show a difference.
    fn can_decide(&self) -> bool {
        self.smallest_p <= LEVEL_SHARE
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
                ", 95 %{}: {} to {}",
                if self.of > 1 {
                    " for this one alone"
                } else {
                    ""
                },
                signed(100.0 * low, 1),
                signed(100.0 * high, 1)
            )
        });
        let left_out = match self.left_out {
            0 => String::new(),
            left_out => format!(
                "; {} with answers of one only left out",
                counted(left_out, "participant")
            ),
        };
        let stimuli = match self.stimuli_left_out {
            0 => String::new(),
            left_out => format!(
                "; {} of one only left out",
                counted(left_out, "presented sample")
            ),
        };
        let chance = match self.chance_shares {
            Some([a, b]) if self.guessing_differs() => {
                format!(" Guessing reaches {} and {}.", percent(a), percent(b))
            }
            _ => String::new(),
        };
        let guessing = [one, two].into_iter().zip(self.guessing);
        let guessing = guessing.filter_map(|(name, found)| Some((name, found?)));
        let guessing = guessing.map(|(name, found)| format!(" {name}: {}.", found.words()));
        let guessing: String = guessing.collect();
        let test = match &self.difference {
            Difference::People(_) => "permutation of participants (studentised) and Student's t",
            _ => "permutation of participants",
        };
        format!(
            "{shares} ({people}{left_out}{stimuli}); {what} {} points{interval}; {test}, p = {}{}: {}.{chance}{guessing}",
            signed(100.0 * self.less_share, 1),
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
            Difference::People(_) if self.participants.iter().any(|n| *n < MIN_GROUP) => {
                "not decided: groups of fewer than 5 participants decide nothing"
            }
            _ if self.same_answers > 0 => {
                "not decided: some in one group answer as some in the other do, and may be the same people"
            }
            _ if !differs && !self.can_decide() => {
                "not decided: with so few participants no difference reaches 5 %"
            }
            _ if !differs && self.p_adjusted <= LEVEL_SHARE => {
                "not decided: with those counted once who may be one person, no difference is shown"
            }
            _ if !differs => "not decided",
            Difference::Samples(_) if self.less_share > 0.0 => "told apart better than by guessing",
            Difference::Samples(_) => "called the other more often than right",
            _ if self.in_both > 0 => {
                "they differ, if those with the same pseudonym are different people"
            }
            _ if self.guessing_differs() => "they differ, and so does guessing: not decided why",
            _ if self.stimuli == Some(0) => "they differ, and so do the samples: not decided why",
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
