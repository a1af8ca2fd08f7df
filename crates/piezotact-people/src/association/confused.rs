//! Pairs of samples that are confused, each with the criterion that says so.

use std::collections::BTreeMap;
use std::fmt;

use piezotact::criterion::{Criterion, Limit, Outcome};
use serde::{Deserialize, Serialize};

use super::answer::{Answer, AnswerTable};
use super::expected::counted_alike;
use super::matrix::{MatrixConfig, selected};
use crate::interval::clustered_of;

/// From this share of presentations on two samples are confused: two that feel the same are confused half of the time, two that
/// always feel different never. At a quarter, 75 % of answers tell one from the other, as at one just-noticeable difference.
///
/// Source: docs/decisions/answers.md.
pub const CONFUSED_SHARE: f64 = 0.25;

/// Whether two samples are confused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum PairOutcome {
    /// The whole interval lies at the limit or above.
    Confused,
    /// The interval contains the limit, or there is none.
    NotDecided,
    /// The whole interval lies below the limit, and right answers are shown to be more frequent than those that name the other.
    NotConfused,
    /// Neither was presented while the other could be answered.
    Untested,
}

impl PairOutcome {
    /// The outcome in words.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Confused => "confused",
            Self::NotDecided => "not decided",
            Self::NotConfused => "not confused",
            Self::Untested => "untested",
        }
    }
}

/// What a pair is judged by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum PairCriterion {
    /// The share of presentations of either in which the other was declared, both weighing alike, however often each was presented.
    ConfusedShare,
}

impl fmt::Display for PairCriterion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("share of presentations declared to be the other")
    }
}

/// Two samples, and how often either was declared to be the other.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ConfusedPair {
    /// The two; a manipulated texture stands first, under its own name.
    pub pair: [String; 2],
    /// How often the first was declared to be the second, and the second the first.
    pub declared: [usize; 2],
    /// How often the first was presented where the second was offered, and the second where the first was.
    pub presented: [usize; 2],
    /// The criterion; its outcome is met where the two are confused.
    pub criterion: Criterion<PairCriterion>,
    /// Whether they are confused.
    pub outcome: PairOutcome,
}

/// All pairs of samples, and all pairs of a manipulated texture and a sample that it is not expected to be declared as: the most
/// confused first, then in the order of declaration, untested ones last. Presentations in which the right answer could not be given do
/// not count. Not confused are only two of which right answers are more frequent than the other's name, with 95 % confidence: who guesses
/// among many rarely names the other. The interval of each is clustered by participant and
/// holds for that pair alone.
///
/// Formula: of a person who was presented the two n and m times, the mean of both shares counts as one of 4nm/(n + m) presentations, which has
/// the variance of that mean.
///
/// Source: docs/decisions/answers.md; intervals: [`crate::interval::clustered_interval`].
#[must_use]
pub fn confused_pairs(table: &AnswerTable, config: &MatrixConfig) -> Vec<ConfusedPair> {
    let answers: Vec<&Answer> = selected(table, config).collect();
    let samples = &table.declared().samples;
    let mut pairs = Vec::new();
    for (i, first) in samples.iter().enumerate() {
        for second in &samples[i + 1..] {
            let of = Of {
                names: [first, second],
                right: [first, second],
                directions: Directions::Both,
            };
            pairs.push(pair(&answers, &of));
        }
    }
    let manipulated = table.declared().stimuli.iter();
    for stimulus in manipulated.filter(|stimulus| !stimulus.is_plain()) {
        for sample in samples.iter().filter(|name| **name != stimulus.expected) {
            let of = Of {
                names: [&stimulus.name, sample],
                right: [&stimulus.expected, sample],
                directions: Directions::First,
            };
            pairs.push(pair(&answers, &of));
        }
    }
    sorted(pairs)
}

/// `pairs` beside those of people counted `once`: not decided where these decide otherwise.
pub(super) fn beside_once(pairs: Vec<ConfusedPair>, once: &[ConfusedPair]) -> Vec<ConfusedPair> {
    beside(pairs, once, |own, other| own != other)
}

/// `pairs` of all tasks beside those of one `task`: not decided where they are confused in one and not in the other.
pub(super) fn beside_task(pairs: Vec<ConfusedPair>, task: &[ConfusedPair]) -> Vec<ConfusedPair> {
    use PairOutcome::{Confused, NotConfused};
    beside(pairs, task, |own, other| {
        matches!(
            (own, other),
            (Confused, NotConfused) | (NotConfused, Confused)
        )
    })
}

fn beside(
    mut pairs: Vec<ConfusedPair>,
    others: &[ConfusedPair],
    contradict: fn(PairOutcome, PairOutcome) -> bool,
) -> Vec<ConfusedPair> {
    for pair in &mut pairs {
        let other = others.iter().find(|one| one.pair == pair.pair);
        if other.is_some_and(|one| contradict(pair.outcome, one.outcome)) {
            pair.outcome = PairOutcome::NotDecided;
        }
    }
    sorted(pairs)
}

fn sorted(mut pairs: Vec<ConfusedPair>) -> Vec<ConfusedPair> {
    let size = |pair: &ConfusedPair| pair.criterion.found.unwrap_or(-1.0);
    pairs.sort_by(|a, b| (a.outcome.cmp(&b.outcome)).then(size(b).total_cmp(&size(a))));
    pairs
}

/// Whether both of a pair are presented.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Directions {
    Both,
    First,
}

/// A pair that is judged.
struct Of<'a> {
    names: [&'a String; 2],
    /// What is expected to be answered to each.
    right: [&'a String; 2],
    directions: Directions,
}

/// What one person answered to one of a pair.
#[derive(Clone, Copy, Default)]
struct Given {
    presented: usize,
    right: usize,
    other: usize,
}

/// How many of how many, of both of a pair weighing alike.
fn weighed(of: [(usize, usize); 2]) -> (f64, f64) {
    let [(x, n), (y, m)] = of.map(|(of, all)| (of as f64, all as f64));
    if n == 0.0 || m == 0.0 {
        return (x + y, n + m);
    }
    let all = 4.0 * n * m / (n + m);
    (0.5 * (x / n + y / m) * all, all)
}

fn pair(answers: &[&Answer], of: &Of<'_>) -> ConfusedPair {
    let [first, second] = of.names;
    let (names, right) = (of.names, of.right);
    let mut people: BTreeMap<&str, [Given; 2]> = BTreeMap::new();
    let (mut declared, mut presented) = ([0; 2], [0; 2]);
    for answer in answers {
        let direction = if answer.presented == *first && answer.offered.contains(second) {
            0
        } else if of.directions == Directions::Both
            && answer.presented == *second
            && answer.offered.contains(first)
        {
            1
        } else {
            continue;
        };
        // Where the right answer could not be given, another says nothing.
        if !answer.offered.contains(right[direction]) {
            continue;
        }
        let is_other = answer.answered == *names[1 - direction];
        let is_right = answer.answered == *right[direction];
        presented[direction] += 1;
        declared[direction] += usize::from(is_other);
        let given = &mut people.entry(&answer.participant).or_default()[direction];
        given.presented += 1;
        given.right += usize::from(is_right);
        given.other += usize::from(is_other);
    }
    // Of the answers that name one of the two, those that are right.
    let told = people.values();
    let told = told.map(|of| weighed(of.map(|one| (one.right, one.right + one.other))));
    let told = clustered_of(told).and_then(|found| found.interval);
    let is_told_apart = told.is_some_and(|[low, _]| low > 0.5);
    let each = people.values();
    let each = each.map(|of| weighed(of.map(|one| (one.other, one.presented))));
    let each: Vec<(f64, f64)> = each.collect();
    let limit = Limit::at_least(CONFUSED_SHARE);
    let what = PairCriterion::ConfusedShare;
    let (criterion, outcome) = match clustered_of(each.iter().copied()) {
        None => (
            Criterion::unmeasured(what, "", limit),
            PairOutcome::Untested,
        ),
        Some(found) => {
            // Without an interval nothing is decided.
            let judged = found.interval.unwrap_or([f64::NAN; 2]);
            let criterion = Criterion {
                interval: found.interval,
                ..Criterion::new(what, "", found.share, Some(judged), limit)
            };
            let outcome = match criterion.outcome {
                Outcome::Met => PairOutcome::Confused,
                // Who guesses among many rarely names the other, and tells nothing apart.
                Outcome::NotMet if is_told_apart => PairOutcome::NotConfused,
                Outcome::NotMet => PairOutcome::NotDecided,
                Outcome::NotDecided => PairOutcome::NotDecided,
            };
            let alike = counted_alike(&each, limit);
            let is_decided = alike.is_none_or(|one| one.outcome == criterion.outcome);
            let outcome = if is_decided {
                outcome
            } else {
                PairOutcome::NotDecided
            };
            (criterion, outcome)
        }
    };
    ConfusedPair {
        pair: names.map(Clone::clone),
        declared,
        presented,
        criterion,
        outcome,
    }
}
