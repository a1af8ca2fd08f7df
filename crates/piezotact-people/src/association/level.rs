//! Two conditions over the stimuli that both have, so that neither is easier.

use std::collections::{BTreeMap, BTreeSet};

use piezotact::statistics::mean;

use super::answer::{Answer, AnswerTable};
use super::guessing::Person;

/// What each person answered to each stimulus, where what is expected was offered.
pub(super) type ByStimulus<'a> = BTreeMap<&'a str, BTreeMap<&'a str, Person>>;

/// What one person answered as expected in one condition.
#[derive(Clone, Copy)]
pub(super) struct Expected {
    /// Means over stimuli, 0–1: of those as expected, and of what guessing reaches.
    pub(super) share: f64,
    pub(super) guessed_share: f64,
    /// The variance of the share in that of one answer.
    pub(super) variance: f64,
    /// All answers.
    pub(super) own: Person,
}

/// Two conditions over the stimuli that both have.
pub(super) struct Level<'a> {
    pub(super) people: [BTreeMap<&'a str, Expected>; 2],
    /// How many stimuli both have, and one alone.
    pub(super) stimuli: usize,
    pub(super) left_out: usize,
}

impl<'a> Level<'a> {
    /// Over the stimuli that both have, and, where people are the `same`, that the person has in both: who meets the easy ones more
    /// often in one condition is not better there. Over all of each where there are none.
    pub(super) fn of(conditions: &[ByStimulus<'a>; 2], same: Same) -> Self {
        let [a, b] = [0, 1].map(|i| -> BTreeSet<&str> {
            let own = conditions[i].values();
            own.flat_map(|of| of.keys().copied()).collect()
        });
        let common: BTreeSet<&str> = a.intersection(&b).copied().collect();
        let people = [0, 1].map(|i| {
            let of_person = |(person, own): (&&'a str, &BTreeMap<&'a str, Person>)| {
                let other = conditions[1 - i].get(person);
                let other = other.filter(|_| same == Same::People);
                let counts = |stimulus: &str| {
                    common.is_empty()
                        || (common.contains(stimulus)
                            && other.is_none_or(|other| other.contains_key(stimulus)))
                };
                let own: Vec<Person> = own
                    .iter()
                    .filter(|(stimulus, _)| counts(stimulus))
                    .map(|(_, person)| *person)
                    .collect();
                Some((*person, Expected::of(&own)?))
            };
            conditions[i].iter().filter_map(of_person).collect()
        });
        Self {
            people,
            stimuli: common.len(),
            left_out: match common.is_empty() {
                true => 0,
                false => a.len() + b.len() - 2 * common.len(),
            },
        }
    }
}

impl Level<'_> {
    /// The standard error of the difference of means if nobody differed from anybody: that of as many answers of the share of all. Differences
    /// between people cannot make it smaller, and people who are all right show none.
    pub(super) fn error(&self) -> f64 {
        let all = self.people.iter().flat_map(BTreeMap::values);
        let [right, answers] = all.fold([0, 0], |[right, answers], one| {
            [right + one.own.right, answers + one.own.answers]
        });
        let share = right as f64 / answers as f64;
        let of_means = self.people.iter().map(|people| {
            let variances = people.values().map(|one| one.variance).sum::<f64>();
            variances / (people.len() as f64).powi(2)
        });
        (share * (1.0 - share) * of_means.sum::<f64>()).sqrt()
    }
}

/// Who two conditions are of.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Same {
    People,
    Nobody,
}

impl Expected {
    /// `None` without an answer.
    fn of(stimuli: &[Person]) -> Option<Self> {
        let mean_of = |of: &dyn Fn(&Person) -> f64| {
            let shares = stimuli.iter().map(|one| of(one) / one.answers as f64);
            mean(&shares.collect::<Vec<f64>>())
        };
        (!stimuli.is_empty()).then(|| Self {
            share: mean_of(&|one| one.right as f64),
            guessed_share: mean_of(&|one| one.guessed),
            variance: mean_of(&|_| 1.0) / stimuli.len() as f64,
            own: Person {
                right: stimuli.iter().map(|one| one.right).sum(),
                answers: stimuli.iter().map(|one| one.answers).sum(),
                guessed: stimuli.iter().map(|one| one.guessed).sum(),
            },
        })
    }
}

/// Answers in which what is expected was offered, for each person and stimulus.
pub(super) fn as_expected<'a>(
    table: &AnswerTable,
    answers: impl Iterator<Item = &'a Answer>,
) -> ByStimulus<'a> {
    let stimuli = table.declared().stimuli.iter();
    let expected: BTreeMap<&str, &String> = stimuli
        .map(|stimulus| (stimulus.name.as_str(), &stimulus.expected))
        .collect();
    let mut people: ByStimulus<'a> = BTreeMap::new();
    for answer in answers {
        let Some(wanted) = expected.get(answer.presented.as_str()) else {
            continue;
        };
        if !answer.offered.contains(wanted) {
            continue;
        }
        let person = people.entry(&answer.participant).or_default();
        let person = person.entry(&answer.presented).or_default();
        person.answers += 1;
        person.right += usize::from(answer.answered == **wanted);
        person.guessed += 1.0 / answer.offered.len() as f64;
    }
    people
}
