//! What `piezotact answers` prints of a study: shares beside chance, cells, confused pairs, Kendall's τ.

use anyhow::{Context as _, Result};
use piezotact::criterion::Outcome;
use piezotact::statistics::random::Random;
use piezotact_people::association::{
    Answer, AnswerTable, Association, AssociationConfig, MatrixConfig, PairOutcome, associate,
    kendall_tau_b, ordering,
};

use super::ability::{
    Ability, GUESS_SHARE, GUESSERS_SHARE, SAMPLES, Spread, answers, skewed, table,
};
use super::{Found, Printed, Question, Scenario, World};

const STUDIES: usize = 2_000;
/// The mean share of right answers.
const RIGHT_SHARE: f64 = 0.7;
/// How people differ, logits.
const PEOPLE_LOGIT: f64 = 0.9;
/// How people differ who are hardly different.
const ALIKE_LOGIT: f64 = 0.3;
/// Where chance is 25 %, and something is felt.
const FELT_SHARE: f64 = 0.35;
/// Of two samples that are not confused.
const NOT_CONFUSED_SHARE: f64 = 0.95;
/// Orders of which the mean τ of everybody is taken.
const POPULATION: usize = 40_000;

/// What [`associate`] is asked for of a share.
#[derive(Clone, Copy)]
struct Asked {
    name: &'static str,
    people: usize,
    /// By person, in turn.
    trials: [usize; 2],
    ability: Ability,
}

impl Asked {
    fn of(name: &'static str, people: usize, ability: Ability) -> Self {
        Self {
            name,
            people,
            trials: [24; 2],
            ability,
        }
    }

    fn found(&self, samples: &[&str], seed: u64, more_logit: f64) -> Result<Association> {
        let mut random = Random::stream(seed, 1, self.name);
        let ability = self.ability.with(more_logit);
        let of_person = |i: usize| {
            let right = ability.share(0.0, &mut random);
            let trials = self.trials[i % 2];
            answers(
                (format!("P{i}").as_str(), "1"),
                samples,
                trials,
                right,
                &mut random,
            )
        };
        let all: Vec<Answer> = (0..self.people).flat_map(of_person).collect();
        Ok(associate(
            &table(samples, all)?,
            &AssociationConfig::default(),
        )?)
    }
}

/// By how many logits `ability` has to be better for a mean share of `share`.
fn logits_to(ability: Ability, share: f64) -> f64 {
    let (mut low, mut high) = (0.0, 8.0);
    for _ in 0..24 {
        let middle = 0.5 * (low + high);
        match ability.with(middle).mean_share() < share {
            true => low = middle,
            false => high = middle,
        }
    }
    low
}

pub(super) fn scenarios() -> Vec<Scenario> {
    let mut all = chance();
    all.extend(intervals());
    all.extend(pairs());
    all.extend(orders());
    all
}

/// Everybody guesses.
fn chance() -> Vec<Scenario> {
    let guess = Ability::of(GUESS_SHARE, 0.0, Spread::Normal(0.0));
    let unequal = Asked {
        trials: [42, 12],
        ..Asked::of("all guess, unequal trials", 10, guess)
    };
    let equal = |people| Asked::of("all guess", people, guess);
    let all = [equal(4), equal(6), equal(10), equal(20), unequal];
    let felt = logits_to(guess, FELT_SHARE);
    let scenario = |asked: Asked| Scenario {
        questions: vec![Question::of("above or below chance", Printed::Test)],
        name: asked.name,
        people: asked.people.to_string(),
        studies: STUDIES,
        study: Box::new(move |seed, world| {
            let more = if world == World::Effect { felt } else { 0.0 };
            let found = asked.found(&SAMPLES, seed, more)?;
            let criterion = &found.expected.first().context("no share")?.criterion;
            let concluded = criterion
                .interval
                .map(|_| criterion.outcome != Outcome::NotDecided);
            Ok(vec![Found::tested(concluded)])
        }),
    };
    all.into_iter().map(scenario).collect()
}

/// Shares of people who differ.
fn intervals() -> Vec<Scenario> {
    let of = |spread: Spread| Ability::of(RIGHT_SHARE, 0.0, spread);
    let usual = of(Spread::Normal(PEOPLE_LOGIT));
    let equal = |people| Asked::of("equal", people, usual);
    let guessers = of(Spread::Guessers(PEOPLE_LOGIT));
    let mixture = of(Spread::Guessers(ALIKE_LOGIT));
    let skewed = of(Spread::Skewed(PEOPLE_LOGIT));
    let all = [
        equal(4),
        equal(6),
        equal(10),
        equal(20),
        Asked::of("wide spread", 10, of(Spread::Normal(1.8))),
        Asked {
            trials: [42, 12],
            ..Asked::of("unequal trials", 10, usual)
        },
        Asked::of("skewed", 10, skewed),
        Asked::of("skewed", 20, skewed),
        Asked::of("15 % guessers", 10, guessers),
        Asked::of("15 % guessers", 20, guessers),
        Asked::of("15 % guessers, others alike", 10, mixture),
        Asked::of("15 % guessers, others alike", 20, mixture),
    ];
    let scenario = |asked: Asked| Scenario {
        questions: [
            "share as expected",
            "cell of right answers",
            "cell of wrong answers",
            "share of a pair that is confused",
        ]
        .map(|name| Question::of(name, Printed::Interval))
        .into(),
        name: asked.name,
        people: asked.people.to_string(),
        studies: STUDIES,
        study: Box::new(move |seed, _| {
            let found = asked.found(&SAMPLES, seed, 0.0)?;
            let wrong_share = (1.0 - RIGHT_SHARE) / (SAMPLES.len() - 1) as f64;
            let expected = found.expected.first().context("no share")?;
            let cell = |answered: &str| {
                let all = &found.matrices[0].matrix;
                all.cell(SAMPLES[0], answered)
                    .and_then(|cell| cell.interval_percent)
            };
            let pair = found
                .pairs
                .iter()
                .find(|one| one.pair == [SAMPLES[0], SAMPLES[1]]);
            let pair = pair.context("no pair")?.criterion.interval;
            Ok(vec![
                Found::estimated(expected.criterion.interval, RIGHT_SHARE),
                Found::estimated(cell(SAMPLES[0]), 100.0 * RIGHT_SHARE),
                Found::estimated(cell(SAMPLES[1]), 100.0 * wrong_share),
                Found::estimated(pair, wrong_share),
            ])
        }),
    };
    all.into_iter().map(scenario).collect()
}

/// Two samples that are confused in a quarter of all presentations, which is the limit.
fn pairs() -> Vec<Scenario> {
    let of = |spread: Spread| Ability::of(0.75, 0.0, spread);
    let usual = of(Spread::Normal(PEOPLE_LOGIT));
    let all = [
        Asked::of("at the limit", 4, usual),
        Asked::of("at the limit", 10, usual),
        Asked::of("at the limit", 20, usual),
        Asked::of("at the limit, skewed", 10, of(Spread::Skewed(PEOPLE_LOGIT))),
    ];
    let scenario = |asked: Asked| {
        let more = logits_to(asked.ability, NOT_CONFUSED_SHARE);
        Scenario {
            questions: vec![Question::of("pair confused or not confused", Printed::Test)],
            name: asked.name,
            people: asked.people.to_string(),
            studies: STUDIES,
            study: Box::new(move |seed, world| {
                let more = if world == World::Effect { more } else { 0.0 };
                let found = asked.found(&SAMPLES[..2], seed, more)?;
                let outcome = found.pairs.first().context("no pair")?.outcome;
                Ok(vec![Found::tested(Some(matches!(
                    outcome,
                    PairOutcome::Confused | PairOutcome::NotConfused
                )))])
            }),
        }
    };
    all.into_iter().map(scenario).collect()
}

/// How people put samples in order: the standard deviation of where they feel one, in places.
#[derive(Clone, Copy)]
enum Ordering {
    Equal,
    UnequalSpread,
    UnequalOrders,
    Skewed,
    Guessers,
}

impl Ordering {
    fn name(self) -> &'static str {
        match self {
            Self::Equal => "equal",
            Self::UnequalSpread => "unequal spread",
            Self::UnequalOrders => "unequal number of orders",
            Self::Skewed => "skewed",
            Self::Guessers => "15 % guessers",
        }
    }

    /// The noise of a person.
    fn noise(self, random: &mut Random) -> f64 {
        match self {
            Self::Equal | Self::UnequalOrders => 1.0 + 0.3 * random.person(),
            Self::UnequalSpread => [0.3, 2.0][usize::from(random.uniform() < 0.5)],
            Self::Skewed => (1.0 + 0.6 * skewed(random)).max(0.1),
            // Hundreds of places: any order.
            Self::Guessers => match random.uniform() < GUESSERS_SHARE {
                true => 1e3,
                false => 0.8,
            },
        }
    }

    fn orders(self, person: usize) -> usize {
        match self {
            Self::UnequalOrders => [1, 6][person % 2],
            _ => 2,
        }
    }

    /// The samples in the order in which they are felt.
    fn order(noise: f64, random: &mut Random) -> Vec<usize> {
        let felt: Vec<f64> = (0..SAMPLES.len())
            .map(|place| place as f64 + noise * random.normal())
            .collect();
        let mut order: Vec<usize> = (0..SAMPLES.len()).collect();
        order.sort_by(|a, b| felt[*a].total_cmp(&felt[*b]));
        order
    }

    /// The mean τ of everybody.
    fn mean_tau(self) -> f64 {
        let mut random = Random::stream(49, 1, "orders");
        let declared: Vec<f64> = (0..SAMPLES.len()).map(|place| place as f64).collect();
        let all = (0..POPULATION).filter_map(|_| {
            let noise = self.noise(&mut random);
            let made = Self::order(noise, &mut random);
            let made: Vec<f64> = made.into_iter().map(|sample| sample as f64).collect();
            kendall_tau_b(&declared, &made)
        });
        all.sum::<f64>() / POPULATION as f64
    }

    fn answers(self, people: usize, random: &mut Random) -> Result<AnswerTable> {
        let mut all = Vec::new();
        for person in 0..people {
            let noise = self.noise(random);
            for session in 0..self.orders(person) {
                let made = Self::order(noise, random).into_iter().enumerate();
                all.extend(made.map(|(place, sample)| Answer {
                    participant: format!("P{person}"),
                    session: session.to_string(),
                    task: "1".into(),
                    trial: sample.to_string(),
                    presented: SAMPLES[sample].into(),
                    answered: SAMPLES[place].into(),
                    ..Answer::default()
                }));
            }
        }
        table(&SAMPLES, all)
    }
}

/// Samples in order.
fn orders() -> Vec<Scenario> {
    use Ordering as O;
    let all = [
        (O::Equal, 4),
        (O::Equal, 6),
        (O::Equal, 10),
        (O::Equal, 20),
        (O::UnequalSpread, 10),
        (O::UnequalOrders, 10),
        (O::Skewed, 10),
        (O::Guessers, 10),
        (O::Guessers, 20),
    ];
    let scenario = |(kind, people): (Ordering, usize)| {
        let truth = kind.mean_tau();
        Scenario {
            questions: vec![Question::of("mean τ of orders", Printed::Interval)],
            name: kind.name(),
            people: people.to_string(),
            studies: STUDIES,
            study: Box::new(move |seed, _| {
                let mut random = Random::stream(seed, 2, kind.name());
                let table = kind.answers(people, &mut random)?;
                let found = ordering(&table, &MatrixConfig::default(), "1")?;
                Ok(vec![Found::estimated(found.tau_interval, truth)])
            }),
        }
    };
    all.into_iter().map(scenario).collect()
}
