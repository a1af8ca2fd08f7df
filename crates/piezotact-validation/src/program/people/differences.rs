//! `piezotact answers --compare`: groups of people, tasks of the same people, samples.

use anyhow::Result;
use piezotact::criterion::Outcome;
use piezotact::statistics::random::Random;
use piezotact_people::association::{
    Answer, AnswerTable, Compared, MatrixConfig, compared, compared_studies,
};
use piezotact_people::difference::{Difference, LEVEL_SHARE};

use super::ability::{Ability, GUESS_SHARE, GUESSERS_SHARE, SAMPLES, Spread, answers, table};
use super::{Found, Printed, Question, Scenario, World};

/// The difference where there is one, logits.
const EFFECT_LOGIT: f64 = 1.0;
/// The share of presentations that are heard, where two samples differ.
const HEARD_SHARE: f64 = 0.3;
/// Studies of scenarios in which all divisions of people are tried.
const STUDIES: usize = 2_000;
/// Where divisions are drawn, which takes long.
const SLOW_STUDIES: usize = 1_000;
/// How people differ in common, logits.
const PEOPLE_LOGIT: f64 = 0.9;

fn questions(name: &'static str) -> Vec<Question> {
    vec![Question::of(name, Printed::Both)]
}

/// What a comparison says, beside the true difference.
fn judged(found: &Compared, truth: f64) -> Vec<Found> {
    // Where no division reaches 5 %, nothing is concluded.
    let concluded = (found.smallest_p <= LEVEL_SHARE).then(|| found.outcome() == Outcome::Met);
    vec![Found {
        concluded,
        ..Found::estimated(found.interval, truth)
    }]
}

fn names(a: &str, b: &str) -> [String; 2] {
    [a.to_owned(), b.to_owned()]
}

/// People of one kind.
#[derive(Clone, Copy)]
struct Group {
    people: usize,
    trials: usize,
    ability: Ability,
}

impl Group {
    fn of(people: usize, trials: usize, ability: Ability) -> Self {
        Self {
            people,
            trials,
            ability,
        }
    }

    fn answers(&self, name: &str, random: &mut Random) -> Result<AnswerTable> {
        let of_person = |i: usize| {
            let shared = random.normal();
            let right = self.ability.share(shared, random);
            answers(
                (format!("{name}{i}").as_str(), "1"),
                &SAMPLES,
                self.trials,
                right,
                random,
            )
        };
        let all: Vec<Answer> = (0..self.people).flat_map(of_person).collect();
        table(&SAMPLES, all)
    }
}

/// Groups of different people.
pub(super) fn people() -> Vec<Scenario> {
    let of = |share: f64, spread: Spread| Ability::of(share, 0.0, spread);
    let usual = of(0.5, Spread::Normal(PEOPLE_LOGIT));
    let (narrow, wide) = (of(0.5, Spread::Normal(0.3)), of(0.5, Spread::Normal(1.2)));
    let skewed = of(0.6, Spread::Skewed(PEOPLE_LOGIT));
    let guessers = of(0.65, Spread::Guessers(PEOPLE_LOGIT));
    let without = of(0.65, Spread::Normal(PEOPLE_LOGIT));
    let groups = |a: Group, b: Group| [a, b];
    let alike = |n: usize| groups(Group::of(n, 24, usual), Group::of(n, 24, usual));
    let all = [
        ("equal", STUDIES, alike(4)),
        ("equal", STUDIES, alike(6)),
        ("equal", SLOW_STUDIES, alike(10)),
        ("equal", SLOW_STUDIES, alike(20)),
        (
            "unequal spread",
            STUDIES,
            groups(Group::of(8, 24, narrow), Group::of(8, 24, wide)),
        ),
        (
            "unequal trials",
            STUDIES,
            groups(Group::of(8, 42, usual), Group::of(8, 12, usual)),
        ),
        (
            "unequal n",
            STUDIES,
            groups(Group::of(12, 24, usual), Group::of(5, 24, usual)),
        ),
        (
            "unequal spread, trials and n",
            STUDIES,
            groups(Group::of(12, 42, narrow), Group::of(5, 12, wide)),
        ),
        (
            "skewed",
            STUDIES,
            groups(Group::of(8, 24, skewed), Group::of(8, 24, skewed)),
        ),
        (
            "skewed, unequal n",
            STUDIES,
            groups(Group::of(12, 24, skewed), Group::of(5, 24, skewed)),
        ),
        (
            "15 % guessers",
            STUDIES,
            groups(Group::of(8, 24, guessers), Group::of(8, 24, guessers)),
        ),
        (
            "15 % guessers in one group",
            STUDIES,
            groups(Group::of(8, 24, guessers), Group::of(8, 24, without)),
        ),
    ];
    let scenario = |(name, studies, [a, b]): (&'static str, usize, [Group; 2])| Scenario {
        questions: questions("--compare people"),
        name,
        people: format!("{} + {}", a.people, b.people),
        studies,
        study: Box::new(move |seed, world| {
            let mut random = Random::stream(seed, 0, name);
            let second = match world {
                World::Null => b,
                World::Effect => Group {
                    ability: b.ability.with(EFFECT_LOGIT),
                    ..b
                },
            };
            let tables = [
                a.answers("A", &mut random)?,
                second.answers("B", &mut random)?,
            ];
            let config = MatrixConfig::default();
            let both = [(&tables[0], &config), (&tables[1], &config)];
            let difference = Difference::People(names("A", "B"));
            // The groups have equal means; what the interval holds is counted there.
            Ok(judged(&compared_studies(both, &difference)?, 0.0))
        }),
    };
    all.into_iter().map(scenario).collect()
}

/// Two tasks of the same people.
#[derive(Clone, Copy)]
struct Tasks {
    name: &'static str,
    people: usize,
    /// People with the first task alone.
    of_one: usize,
    trials: [usize; 2],
    abilities: [Ability; 2],
    /// The share of people who guess in both.
    guess_both_share: f64,
}

impl Tasks {
    fn of(name: &'static str, people: usize, spreads: [Spread; 2], share: f64) -> Self {
        Self {
            name,
            people,
            of_one: 0,
            trials: [24; 2],
            abilities: spreads.map(|spread| Ability::of(share, PEOPLE_LOGIT, spread)),
            guess_both_share: 0.0,
        }
    }

    fn answers(&self, random: &mut Random, world: World) -> Result<AnswerTable> {
        let mut all = Vec::new();
        for i in 0..self.people + self.of_one {
            let person = format!("P{i}");
            let shared = random.normal();
            let guesses = random.uniform() < self.guess_both_share;
            let tasks = if i < self.people { 2 } else { 1 };
            for task in 0..tasks {
                let ability = match (task, world) {
                    (1, World::Effect) => self.abilities[1].with(EFFECT_LOGIT),
                    _ => self.abilities[task],
                };
                let own = ability.share(shared, random);
                let right = if guesses { GUESS_SHARE } else { own };
                let of = (person.as_str(), ["a", "b"][task]);
                all.extend(answers(of, &SAMPLES, self.trials[task], right, random));
            }
        }
        table(&SAMPLES, all)
    }
}

/// Tasks of the same people.
pub(super) fn tasks() -> Vec<Scenario> {
    let usual = Spread::Normal(0.5);
    let equal = |people: usize| Tasks::of("equal", people, [usual; 2], 0.6);
    let ten = equal(10);
    let all = [
        equal(4),
        equal(6),
        ten,
        equal(20),
        Tasks::of(
            "unequal spread",
            10,
            [Spread::Normal(0.2), Spread::Normal(1.2)],
            0.5,
        ),
        Tasks {
            name: "unequal trials",
            trials: [42, 12],
            ..ten
        },
        Tasks {
            name: "unequal n: 5 with one task alone",
            of_one: 5,
            ..ten
        },
        Tasks::of("skewed in one task", 10, [usual, Spread::Skewed(0.9)], 0.6),
        Tasks {
            name: "15 % guess in both tasks",
            guess_both_share: GUESSERS_SHARE,
            ..ten
        },
        Tasks::of(
            "15 % guess in one task",
            10,
            [usual, Spread::Guessers(0.5)],
            0.75,
        ),
        Tasks::of(
            "15 % guess in one task",
            20,
            [usual, Spread::Guessers(0.5)],
            0.75,
        ),
    ];
    let scenario = |tasks: Tasks| Scenario {
        questions: questions("--compare tasks"),
        name: tasks.name,
        people: tasks.people.to_string(),
        // Twenty people have more signs than are tried.
        studies: if tasks.people > 15 {
            SLOW_STUDIES
        } else {
            STUDIES
        },
        study: Box::new(move |seed, world| {
            let mut random = Random::stream(seed, 0, tasks.name);
            let table = tasks.answers(&mut random, world)?;
            let difference = Difference::Tasks(names("a", "b"));
            let found = compared(&table, &MatrixConfig::default(), &difference)?;
            Ok(judged(&found, 0.0))
        }),
    };
    all.into_iter().map(scenario).collect()
}

/// People who answer two samples alike.
#[derive(Clone, Copy)]
struct Alike {
    name: &'static str,
    people: usize,
    /// How often each is presented.
    trials: [usize; 2],
    /// How often people name the first of the two, where they do not hear which it is.
    preference: Ability,
    /// The share of people who guess among all samples.
    guessers_share: f64,
    /// People to whom both are presented three times as often.
    more_often: usize,
}

impl Alike {
    fn answers(&self, random: &mut Random, world: World) -> Result<AnswerTable> {
        let heard = match world {
            World::Null => 0.0,
            World::Effect => HEARD_SHARE,
        };
        let mut all = Vec::new();
        for i in 0..self.people {
            let person = format!("P{i}");
            let first_name = self.preference.share(0.0, random);
            let guesses = random.uniform() < self.guessers_share;
            let times = if i < self.more_often { 3 } else { 1 };
            for (presented, trials) in self.trials.into_iter().enumerate() {
                for trial in 0..trials * times {
                    let answered = if guesses {
                        (random.uniform() * SAMPLES.len() as f64) as usize
                    } else if random.uniform() < heard {
                        presented
                    } else {
                        usize::from(random.uniform() >= first_name)
                    };
                    all.push(Answer {
                        participant: person.clone(),
                        task: "1".into(),
                        trial: format!("{presented} {trial}"),
                        presented: SAMPLES[presented].into(),
                        answered: SAMPLES[answered].into(),
                        ..Answer::default()
                    });
                }
            }
        }
        table(&SAMPLES, all)
    }
}

/// Two samples.
pub(super) fn samples() -> Vec<Scenario> {
    let preference = |spread: Spread| Ability::of(0.5, 0.0, spread);
    let usual = preference(Spread::Normal(0.5));
    let equal = |people: usize| Alike {
        name: "equal",
        people,
        trials: [12; 2],
        preference: usual,
        guessers_share: 0.0,
        more_often: 0,
    };
    let ten = equal(10);
    let all = [
        equal(4),
        equal(6),
        ten,
        equal(20),
        Alike {
            name: "unequal spread of preferences",
            preference: preference(Spread::Normal(2.0)),
            ..ten
        },
        Alike {
            name: "unequal trials",
            trials: [21, 6],
            ..ten
        },
        Alike {
            name: "unequal n of trials by person",
            more_often: 3,
            ..ten
        },
        Alike {
            name: "skewed preferences",
            preference: preference(Spread::Skewed(1.5)),
            ..ten
        },
        Alike {
            name: "15 % guessers",
            guessers_share: GUESSERS_SHARE,
            ..ten
        },
    ];
    let scenario = |alike: Alike| Scenario {
        questions: questions("--compare samples"),
        name: alike.name,
        people: alike.people.to_string(),
        studies: if alike.people > 15 {
            SLOW_STUDIES
        } else {
            STUDIES
        },
        study: Box::new(move |seed, world| {
            let mut random = Random::stream(seed, 0, alike.name);
            let table = alike.answers(&mut random, world)?;
            let difference = Difference::Samples(names(SAMPLES[0], SAMPLES[1]));
            let found = compared(&table, &MatrixConfig::default(), &difference)?;
            Ok(judged(&found, 0.0))
        }),
    };
    all.into_iter().map(scenario).collect()
}
