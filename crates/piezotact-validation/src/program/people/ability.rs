//! How people answer: the probability of a right answer of each, drawn from a population whose mean is known.

use piezotact::statistics::random::Random;
use piezotact_people::association::{Answer, AnswerTable, Declared};

use anyhow::Result;

/// The samples of every study.
pub(super) const SAMPLES: [&str; 4] = ["S1", "S2", "S3", "S4"];
/// What guessing among them reaches.
pub(super) const GUESS_SHARE: f64 = 0.25;
/// The share of people who guess, where some do.
pub(super) const GUESSERS_SHARE: f64 = 0.15;
/// People of whom the mean of a population is taken.
const POPULATION: u64 = 40_000;

/// How people differ: the standard deviation of the logit of a right answer.
#[derive(Clone, Copy)]
pub(super) enum Spread {
    Normal(f64),
    /// A log-normal distribution, with its tail towards wrong answers.
    Skewed(f64),
    /// Normal, and 15 % who guess.
    Guessers(f64),
}

/// A population.
#[derive(Clone, Copy)]
pub(super) struct Ability {
    middle_logit: f64,
    /// What a person has in common in all tasks, as a standard deviation of the logit.
    shared_logit: f64,
    spread: Spread,
}

fn logistic(logit: f64) -> f64 {
    1.0 / (1.0 + (-logit).exp())
}

/// A number of mean 0 and variance 1, log-normal with a skewness of 3.7.
pub(super) fn skewed(random: &mut Random) -> f64 {
    let shape = 0.8f64;
    let middle = (shape * shape / 2.0).exp();
    let sd = middle * ((shape * shape).exp() - 1.0).sqrt();
    ((shape * random.normal()).exp() - middle) / sd
}

impl Ability {
    /// People whose mean share of right answers is `share`.
    pub(super) fn of(share: f64, shared_logit: f64, spread: Spread) -> Self {
        let at = |middle_logit: f64| Self {
            middle_logit,
            shared_logit,
            spread,
        };
        let (mut low, mut high) = (-12.0, 12.0);
        for _ in 0..24 {
            let middle = 0.5 * (low + high);
            match at(middle).mean_share() < share {
                true => low = middle,
                false => high = middle,
            }
        }
        at(0.5 * (low + high))
    }

    /// The same people, with `logit` more.
    pub(super) fn with(self, logit: f64) -> Self {
        Self {
            middle_logit: self.middle_logit + logit,
            ..self
        }
    }

    /// The mean share of right answers of everybody.
    pub(super) fn mean_share(&self) -> f64 {
        let mut random = Random::stream(49, 0, "population");
        let all = (0..POPULATION).map(|_| {
            let shared = random.normal();
            self.share(shared, &mut random)
        });
        all.sum::<f64>() / POPULATION as f64
    }

    /// The share of right answers of a person, who has `shared` in common in all tasks.
    pub(super) fn share(&self, shared: f64, random: &mut Random) -> f64 {
        let logit = self.middle_logit + self.shared_logit * shared;
        match self.spread {
            Spread::Normal(sd) => logistic(logit + sd * random.normal()),
            Spread::Skewed(sd) => logistic(logit - sd * skewed(random)),
            Spread::Guessers(sd) => {
                let share = logistic(logit + sd * random.normal());
                match random.uniform() < GUESSERS_SHARE {
                    true => GUESS_SHARE,
                    false => share,
                }
            }
        }
    }
}

/// The answers of `person` to `trials` presentations of all `samples` in turn, of which the share `right` is right and the others are guessed.
pub(super) fn answers(
    (person, task): (&str, &str),
    samples: &[&str],
    trials: usize,
    right: f64,
    random: &mut Random,
) -> Vec<Answer> {
    let one = |trial: usize| {
        let presented = trial % samples.len();
        let answered = match random.uniform() < right {
            true => presented,
            false => {
                let others = (random.uniform() * (samples.len() - 1) as f64) as usize;
                (presented + 1 + others) % samples.len()
            }
        };
        Answer {
            participant: person.into(),
            task: task.into(),
            trial: trial.to_string(),
            presented: samples[presented].into(),
            answered: samples[answered].into(),
            ..Answer::default()
        }
    };
    (0..trials).map(one).collect()
}

/// A table of answers to `samples`.
pub(super) fn table(samples: &[&str], answers: Vec<Answer>) -> Result<AnswerTable> {
    Ok(AnswerTable::new(Declared::plain(samples), answers)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Populations have the mean that is asked for, whatever their shape.
    #[test]
    fn populations_have_the_mean_that_is_asked_for() {
        for spread in [
            Spread::Normal(1.2),
            Spread::Skewed(0.9),
            Spread::Guessers(0.9),
        ] {
            let ability = Ability::of(0.6, 0.3, spread);
            assert!((ability.mean_share() - 0.6).abs() < 1e-3);
            let mut random = Random::stream(1, 0, "test");
            let people = 20_000;
            let all = (0..people).map(|_| {
                let shared = random.normal();
                let right = ability.share(shared, &mut random);
                let given = answers(("P", "1"), &SAMPLES, 4, right, &mut random);
                let is_right = |one: &&Answer| one.presented == one.answered;
                given.iter().filter(is_right).count() as f64 / 4.0
            });
            let found = all.sum::<f64>() / f64::from(people);
            // Four standard errors of 20 000 people with a standard deviation below 0.4.
            assert!((found - 0.6).abs() < 0.012, "{found}");
        }
        let mut random = Random::stream(1, 0, "skewed");
        let drawn: Vec<f64> = (0..100_000).map(|_| skewed(&mut random)).collect();
        let middle = drawn.iter().sum::<f64>() / 1e5;
        assert!(middle.abs() < 0.02, "{middle}");
    }
}
