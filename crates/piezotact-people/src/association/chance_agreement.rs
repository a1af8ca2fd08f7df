//! How probable it is that the answers of two people agree as they do, by what was presented, their habits, and guessing.

use std::collections::{BTreeMap, BTreeSet};

use serde::{Deserialize, Serialize};

use super::answer::{Answer, AnswerTable};

/// So many answers of a person to one stimulus say how consistent the person is.
const CONSISTENT: usize = 3;

/// Only who agrees in at least this share of what chance leaves open is named, 0–1: answers that people share by learning or by the
/// order of presentation agree less.
const MIN_AGREEMENT: f64 = 0.5;

/// Fewer of the answers of who has fewer say nothing of a whole part: one task of two that is the same is a part of its own.
const MIN_MATCHED: f64 = 2.0 / 3.0;

/// How answers of two people are matched.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Matching {
    /// The same trial, in which the same was presented.
    Trial,
    /// The first presentation of a stimulus with the first, the second with the second.
    Presentation,
    /// How often each sample was answered to each stimulus, in whatever order.
    Counts,
}

impl Matching {
    pub(super) const ALL: [Self; 3] = [Self::Trial, Self::Presentation, Self::Counts];
}

/// An answer, its names as numbers.
#[derive(Clone, Copy, Debug)]
struct One {
    /// Task, set, trial and position.
    trial: usize,
    /// Task, what was presented, and of which samples it could be answered.
    stimulus: usize,
    /// Task, set and what was presented.
    presentation: usize,
    said: usize,
    /// What is expected, where it was offered.
    wanted: Option<usize>,
    /// What guessing reaches: the answers that are left to say.
    guess: f64,
}

/// All answers of a table, their names as numbers.
pub(super) struct Coded {
    rows: Vec<One>,
    people: BTreeMap<String, Vec<usize>>,
}

/// Names as numbers.
struct Numbers<K>(BTreeMap<K, usize>);

impl<K: Ord> Numbers<K> {
    fn of(&mut self, key: K) -> usize {
        let next = self.0.len();
        *self.0.entry(key).or_insert(next)
    }
}

impl Coded {
    pub(super) fn of(table: &AnswerTable) -> Self {
        let expected: BTreeMap<&str, &str> = (table.declared().stimuli.iter())
            .map(|stimulus| (stimulus.name.as_str(), stimulus.expected.as_str()))
            .collect();
        let (mut names, mut trials) = (Numbers(BTreeMap::new()), Numbers(BTreeMap::new()));
        let (mut stimuli, mut shown) = (Numbers(BTreeMap::new()), Numbers(BTreeMap::new()));
        let mut people: BTreeMap<String, Vec<usize>> = BTreeMap::new();
        // Of answers with places each takes one of those that are left.
        let mut places: BTreeMap<[&str; 5], usize> = BTreeMap::new();
        let in_places = table.answers().iter().filter(|one| one.position.is_some());
        for answer in in_places {
            *places.entry(sequence(answer)).or_default() += 1;
        }
        let mut rows = Vec::new();
        for (row, answer) in table.answers().iter().enumerate() {
            people
                .entry(answer.participant.clone())
                .or_default()
                .push(row);
            let mut offered: Vec<&str> = answer.offered.iter().map(String::as_str).collect();
            offered.sort_unstable();
            let left = match answer.position {
                Some(_) => places.get_mut(&sequence(answer)).map_or(1, |left| {
                    *left = left.saturating_sub(1);
                    *left + 1
                }),
                None => offered.len(),
            };
            let wanted = expected.get(answer.presented.as_str());
            let wanted = wanted.filter(|one| offered.contains(one));
            let place = [&*answer.task, &answer.set, &answer.trial];
            let stimulus = (&*answer.task, &*answer.presented, offered);
            let presentation = [&*answer.task, &answer.set, &answer.presented];
            rows.push(One {
                trial: trials.of((place, answer.position)),
                stimulus: stimuli.of(stimulus),
                presentation: shown.of(presentation),
                said: names.of(answer.answered.as_str()),
                wanted: wanted.map(|one| names.of(*one)),
                guess: 1.0 / left.max(1) as f64,
            });
        }
        Self { rows, people }
    }

    /// The answers of `participant` that stand in the rows `kept`.
    pub(super) fn part(&self, participant: &str, kept: &[(usize, &Answer)]) -> Part<'_> {
        let all = self.people.get(participant).map_or(&[][..], Vec::as_slice);
        let kept: Vec<&One> = kept.iter().map(|(row, _)| &self.rows[*row]).collect();
        Part {
            person: all.first().copied(),
            all: by_stimulus(all.iter().map(|row| &self.rows[*row])),
            own: by_stimulus(kept.iter().copied()),
            kept,
        }
    }
}

/// The trial of one sequence of places.
fn sequence(answer: &Answer) -> [&str; 5] {
    [
        &answer.participant,
        &answer.session,
        &answer.task,
        &answer.set,
        &answer.trial,
    ]
}

/// Answers of one person.
pub(super) struct Part<'a> {
    /// The first answer of the person.
    person: Option<usize>,
    /// What the person said, of all answers.
    all: BTreeMap<usize, Said>,
    /// And of those that are compared.
    own: BTreeMap<usize, Said>,
    kept: Vec<&'a One>,
}

/// How often each sample was said.
#[derive(Default)]
struct Said {
    by_answer: BTreeMap<usize, usize>,
    of: usize,
}

impl Said {
    fn add(&mut self, said: usize) {
        *self.by_answer.entry(said).or_default() += 1;
        self.of += 1;
    }

    fn times(&self, said: usize) -> usize {
        self.by_answer.get(&said).copied().unwrap_or(0)
    }

    fn share(&self, said: usize) -> f64 {
        self.times(said) as f64 / self.of as f64
    }
}

fn by_stimulus<'a>(answers: impl Iterator<Item = &'a One>) -> BTreeMap<usize, Said> {
    let mut found: BTreeMap<usize, Said> = BTreeMap::new();
    for one in answers {
        found.entry(one.stimulus).or_default().add(one.said);
    }
    found
}

/// What all people said.
pub(super) struct Others(BTreeMap<usize, Said>);

impl Others {
    pub(super) fn of(coded: &Coded) -> Self {
        Self(by_stimulus(coded.rows.iter()))
    }
}

/// How often a person gives an answer, by what is known of the person and of others.
struct Habits<'a> {
    part: &'a Part<'a>,
    whatever: Said,
    right: [usize; 2],
    others: &'a Others,
    /// Who is none of the others.
    pair: Vec<&'a Part<'a>>,
}

impl<'a> Habits<'a> {
    fn of(part: &'a Part<'a>, beside: &'a Part<'a>, others: &'a Others) -> Self {
        let mut whatever = Said::default();
        let mut right = [0; 2];
        for one in &part.kept {
            whatever.add(one.said);
            right[0] += usize::from(one.wanted == Some(one.said));
            right[1] += usize::from(one.wanted.is_some());
        }
        let mut pair = vec![part];
        pair.extend((beside.person != part.person).then_some(beside));
        Self {
            part,
            whatever,
            right,
            others,
            pair,
        }
    }

    /// How probable it is that the person, who said `own`, says what `other` is, 0–1: the largest of what may explain it. Their own answer
    /// does not count for itself.
    fn agrees(&self, own: &One, other: &One) -> f64 {
        let said = other.said;
        let same = usize::from(own.said == said);
        let without =
            |times: usize, of: usize, prior: f64| ((times - same) as f64 + prior) / of as f64;
        let of = |counts: &BTreeMap<usize, Said>| {
            let found = counts.get(&own.stimulus);
            found.map_or([0, 0], |one| [one.times(said), one.of])
        };
        let [mine, times] = of(&self.part.own);
        let mut left = of(&self.others.0);
        for part in &self.pair {
            let its = of(&part.all);
            left = [left[0] - its[0], left[1] - its[1]];
        }
        let pool = (left[0] as f64 + own.guess) / (left[1] as f64 + 1.0);
        let consistent = match times >= CONSISTENT {
            true => mine as f64 / times as f64,
            false => 0.0,
        };
        let right = match own.wanted == Some(said) {
            true => without(self.right[0], self.right[1], own.guess),
            false => 0.0,
        };
        [
            own.guess,
            pool,
            without(mine, times, pool),
            consistent,
            without(self.whatever.times(said), self.whatever.of, own.guess),
            right,
        ]
        .into_iter()
        .fold(0.0, f64::max)
        .min(1.0)
    }
}

/// How far the answers of two agree.
pub(super) struct Agreement {
    pub(super) matched: usize,
    pub(super) alike: usize,
    pub(super) expected: f64,
    pub(super) p_value: f64,
}

/// How far the answers of two parts agree, matched by `matching`; the larger of the probabilities of either by the other. `None` where
/// fewer than two thirds are matched, and where less than half of what chance leaves open agrees.
pub(super) fn matched<'a>(
    parts: [&'a Part<'a>; 2],
    others: &'a Others,
    matching: Matching,
) -> Option<Agreement> {
    let [a, b] = parts;
    let pairs = match matching {
        Matching::Counts => return by_counts(parts),
        Matching::Trial => joined(a, b, |one| (one.trial, one.presentation)),
        Matching::Presentation => joined(a, b, |one| (one.presentation, one.stimulus)),
    };
    if (pairs.len() as f64) < MIN_MATCHED * a.kept.len().min(b.kept.len()) as f64 {
        return None;
    }
    let alike = pairs.iter().filter(|[x, y]| x.said == y.said).count();
    let [of_a, of_b] = [Habits::of(a, b, others), Habits::of(b, a, others)];
    let by_a: Vec<f64> = pairs.iter().map(|[x, y]| of_a.agrees(x, y)).collect();
    let by_b: Vec<f64> = pairs.iter().map(|[x, y]| of_b.agrees(y, x)).collect();
    let expected = [&by_a, &by_b].map(|shares| shares.iter().sum::<f64>());
    let expected = expected[0].max(expected[1]);
    agrees(pairs.len(), alike, expected).then(|| Agreement {
        matched: pairs.len(),
        alike,
        expected,
        p_value: at_least(&by_a, alike).max(at_least(&by_b, alike)),
    })
}

/// Whether at least [`MIN_AGREEMENT`] of what chance leaves open agrees.
fn agrees(matched: usize, alike: usize, expected: f64) -> bool {
    let [matched, alike] = [matched, alike].map(|count| count as f64);
    alike - expected >= MIN_AGREEMENT * (matched - expected)
}

/// The answers of both with the same key, the first of each with the first of the other.
fn joined<'a>(
    a: &Part<'a>,
    b: &Part<'a>,
    key: impl Fn(&One) -> (usize, usize),
) -> Vec<[&'a One; 2]> {
    let mut waiting: BTreeMap<(usize, usize), Vec<&One>> = BTreeMap::new();
    for one in b.kept.iter().rev() {
        waiting.entry(key(one)).or_default().push(*one);
    }
    let pair = |one: &&'a One| Some([*one, waiting.get_mut(&key(one))?.pop()?]);
    a.kept.iter().filter_map(pair).collect()
}

/// The probability that at least `alike` of independent events of these probabilities happen.
fn at_least(shares: &[f64], alike: usize) -> f64 {
    // The last place holds all counts from `alike` on.
    let mut counts = vec![0.0; alike + 1];
    counts[0] = 1.0;
    for share in shares {
        for count in (0..alike).rev() {
            let moved = counts[count] * share;
            counts[count + 1] += moved;
            counts[count] -= moved;
        }
    }
    counts[alike].clamp(0.0, 1.0)
}

/// How far two agree in how often they gave each answer to each stimulus: of the probability that a person of the mean of their shares
/// repeats the counts of one of the two, the larger.
fn by_counts([a, b]: [&Part<'_>; 2]) -> Option<Agreement> {
    let [of_a, of_b] = [&a.own, &b.own];
    let mut found = Agreement {
        matched: 0,
        alike: 0,
        expected: 0.0,
        p_value: 1.0,
    };
    let mut common = Vec::new();
    for (stimulus, said) in of_a {
        let Some(other) = of_b.get(stimulus) else {
            continue;
        };
        let same = said.by_answer.iter();
        let same = same.map(|(answer, times)| (*times).min(other.times(*answer)));
        found.alike += same.sum::<usize>();
        found.matched += said.of.min(other.of);
        common.push([said, other]);
    }
    // About as many differ by chance, of normal counts: where chance leaves nothing open, or nearly as many differ, the long way to
    // the probability is spared.
    let open: f64 = common.iter().map(|pair| differing(*pair)).sum();
    if open < 0.5 || (found.matched - found.alike) as f64 > 0.75 * open {
        return None;
    }
    let both = [0, 1].map(|fixed| {
        let mut chance = vec![1.0];
        for pair in &common {
            chance = convolved(&chance, &repeated(pair[fixed], pair[1 - fixed]));
        }
        let expected = chance.iter().zip(0_u32..);
        let expected: f64 = expected.map(|(p, count)| p * f64::from(count)).sum();
        (
            expected,
            chance[found.alike.min(chance.len())..].iter().sum::<f64>(),
        )
    });
    found.expected = both[0].0.max(both[1].0);
    found.p_value = both[0].1.max(both[1].1);
    agrees(found.matched, found.alike, found.expected).then_some(found)
}

/// How many answers differ by chance from counts that are their mean, of normal counts: Σ√(n·p·(1 − p)/2π).
fn differing([one, other]: [&Said; 2]) -> f64 {
    let n = one.of.min(other.of) as f64;
    let answers = one.by_answer.keys().chain(other.by_answer.keys());
    let answers: BTreeSet<usize> = answers.copied().collect();
    let each = answers.into_iter().map(|answer| {
        let share = f64::midpoint(one.share(answer), other.share(answer));
        (n * share * (1.0 - share) / std::f64::consts::TAU).sqrt()
    });
    each.sum()
}

/// The distribution of how many of as many answers as `drawn` has repeat those of `fixed`, for the mean of the shares of both.
fn repeated(fixed: &Said, drawn: &Said) -> Vec<f64> {
    let answers = fixed.by_answer.keys().chain(drawn.by_answer.keys());
    let answers: BTreeSet<usize> = answers.copied().collect();
    let n = drawn.of;
    // By how many answers are drawn, and how many of them repeat.
    let mut chance = vec![vec![0.0; n + 1]; n + 1];
    chance[0][0] = 1.0;
    let mut left = 1.0;
    for answer in answers {
        let share = f64::midpoint(fixed.share(answer), drawn.share(answer));
        let each = (share / left).clamp(0.0, 1.0);
        left = (left - share).max(f64::MIN_POSITIVE);
        let most = fixed.times(answer);
        let mut next = vec![vec![0.0; n + 1]; n + 1];
        for (used, row) in chance.iter().enumerate() {
            let more = binomial(n - used, each);
            for (alike, p) in row.iter().enumerate().filter(|(_, p)| **p > 0.0) {
                for (times, q) in more.iter().enumerate() {
                    next[used + times][(alike + times.min(most)).min(n)] += p * q;
                }
            }
        }
        chance = next;
    }
    chance.swap_remove(n)
}

/// The binomial distribution of `n` trials of probability `share`.
fn binomial(n: usize, share: f64) -> Vec<f64> {
    let mut chance = vec![0.0; n + 1];
    chance[0] = 1.0;
    for used in 0..n {
        for count in (0..=used).rev() {
            let moved = chance[count] * share;
            chance[count + 1] += moved;
            chance[count] -= moved;
        }
    }
    chance
}

fn convolved(a: &[f64], b: &[f64]) -> Vec<f64> {
    let mut sum = vec![0.0; a.len() + b.len() - 1];
    for (i, x) in a.iter().enumerate() {
        for (j, y) in b.iter().enumerate() {
            sum[i + j] += x * y;
        }
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    fn said(times: &[usize]) -> Said {
        let mut found = Said::default();
        for (answer, times) in times.iter().enumerate() {
            for _ in 0..*times {
                found.add(answer);
            }
        }
        found
    }

    fn near(found: f64, expected: f64) {
        assert!((found - expected).abs() < 1e-12, "{found}, {expected}");
    }

    #[test]
    fn agreements_are_a_sum_of_independent_ones() {
        near(at_least(&[0.5; 4], 3), 5.0 / 16.0);
        near(at_least(&[0.2, 0.3], 1), 1.0 - 0.8 * 0.7);
        near(at_least(&[0.2, 0.3], 2), 0.06);
        near(at_least(&[1.0; 5], 5), 1.0);
        near(at_least(&[0.3], 0), 1.0);
    }

    /// Counts of 2, 1 and 1 come again with 4!/2!·(1/2)²·(1/4)².
    #[test]
    fn counts_are_repeated_as_a_multinomial_distribution_has_it() {
        let twice = said(&[2, 1, 1]);
        let chance = repeated(&twice, &twice);
        near(chance[4], 12.0 / 64.0);
        near(chance.iter().sum::<f64>(), 1.0);
        // Of 4 that are all alike, 4 are.
        near(repeated(&said(&[4]), &said(&[4]))[4], 1.0);
        // The mean of (2, 0) and (0, 2): both of the first with 1/4, one with 1/2.
        let [one, other] = [said(&[2, 0]), said(&[0, 2])];
        for (found, expected) in repeated(&one, &other).iter().zip([0.25, 0.5, 0.25]) {
            near(*found, expected);
        }
    }
}
