//! People who guess beside people who do not.

use piezotact::number::counted;
use piezotact::statistics::{mean, standard_deviation};
use serde::{Deserialize, Serialize};
use statrs::distribution::{Binomial, ContinuousCDF, DiscreteCDF, StudentsT};

use crate::interval::MIN_PARTICIPANTS;

/// Who is right as often by guessing with a larger probability, answers as guessing does.
const GUESSING_P: f64 = 0.05;
/// Who is right as rarely by guessing with a smaller probability, answers below guessing.
const BELOW_P: f64 = 0.025;
/// Below the others lies what is below all but this share of such people.
const BELOW_SHARE: f64 = 0.005;

/// What one person answered.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Person {
    pub(super) right: usize,
    pub(super) answers: usize,
    /// Right answers of a guesser.
    pub(super) guessed: f64,
}

impl Person {
    fn answers_as_guessing(&self) -> bool {
        let chance = self.guessed / self.answers as f64;
        let Ok(guesser) = Binomial::new(chance.clamp(0.0, 1.0), self.answers as u64) else {
            return false;
        };
        // P(X ≥ right) = P(X > right − 1).
        let above = self.right.checked_sub(1);
        above.is_none_or(|below| guesser.sf(below as u64) > GUESSING_P)
    }

    /// Whether it is right less often than a guesser, with a probability of 2.5 %: names may be exchanged.
    fn answers_below_guessing(&self) -> bool {
        let chance = self.guessed / self.answers as f64;
        let guesser = Binomial::new(chance.clamp(0.0, 1.0), self.answers as u64);
        guesser.is_ok_and(|guesser| guesser.cdf(self.right as u64) < BELOW_P)
    }

    /// The arcsine of the root of the share, of which a person's scatter depends little on the share.
    fn angle(&self) -> f64 {
        let share = (self.right as f64 + 0.375) / (self.answers as f64 + 0.75);
        share.sqrt().asin()
    }
}

/// Participants who answer no better than guessing does, beside others who do far better: two kinds of people, of which a mean is of neither.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Guessing {
    /// How many answer no better than guessing does.
    pub participants: usize,
    /// How many of them are right less often than guessing.
    #[serde(default)]
    pub below: usize,
    /// Of how many.
    pub of: usize,
    /// The share of right answers of the others, 0–1.
    pub others_share: f64,
}

impl Guessing {
    /// How many they are, and what the others reach.
    #[must_use]
    pub fn words(&self) -> String {
        let below = match self.below {
            0 => String::new(),
            below => format!(
                " ({below} of them right less often than guessing, as with exchanged names)"
            ),
        };
        format!(
            "{} of {} {} no better than guessing{below}, the other {} reach {:.1} %",
            self.participants,
            counted(self.of, "participant"),
            if self.participants == 1 {
                "answers"
            } else {
                "answer"
            },
            self.of - self.participants,
            100.0 * self.others_share
        )
    }
}

/// People who guess among `people`, where the answers show two kinds: everybody who is not above guessing (one-sided, 5 %) lies below all
/// but 0.5 % of people like the others, of whom there are three or more.
///
/// Formula: arcsin √((x + 3/8)/(n + 3/4)) of each below m − t·s·√(1 + 1/k), of mean m and standard deviation s of the k others; s is at least
/// that of one person's answers, 1/(2√n).
///
/// Source: F. J. Anscombe (1948), Biometrika 35; docs/decisions/answers.md.
pub(super) fn guessing(people: &[Person]) -> Option<Guessing> {
    let people = people.iter().filter(|person| person.answers > 0);
    let (guess, others): (Vec<&Person>, Vec<&Person>) =
        people.partition(|person| person.answers_as_guessing());
    if guess.is_empty() || others.len() < MIN_PARTICIPANTS {
        return None;
    }
    let k = others.len() as f64;
    let angles: Vec<f64> = others.iter().map(|person| person.angle()).collect();
    let middle = mean(&angles);
    let answers = others.iter().map(|person| person.answers).sum::<usize>();
    let of_answers = 0.5 / (answers as f64 / k).sqrt();
    let spread = standard_deviation(&angles) * (k / (k - 1.0)).sqrt();
    let spread = spread.max(of_answers);
    let t = StudentsT::new(0.0, 1.0, k - 1.0).ok()?;
    let lowest = middle - t.inverse_cdf(1.0 - BELOW_SHARE) * spread * (1.0 + 1.0 / k).sqrt();
    let right = others.iter().map(|person| person.right).sum::<usize>();
    let is_apart = guess.iter().all(|person| person.angle() < lowest);
    is_apart.then(|| Guessing {
        participants: guess.len(),
        below: guess
            .iter()
            .filter(|person| person.answers_below_guessing())
            .count(),
        of: guess.len() + others.len(),
        others_share: right as f64 / answers as f64,
    })
}
