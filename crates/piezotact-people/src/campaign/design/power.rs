//! How many people find a stated difference: the test of [`crate::difference`], on simulated campaigns.

use piezotact::statistics::random::Random;
use piezotact::statistics::{mean, sign_flip_test};
use serde::{Deserialize, Serialize};

use super::error::{DesignError, above_0_below, must};
use crate::difference::{Difference, LEVEL_SHARE, between_people};

/// Divisions drawn for each simulated campaign where they are too many to try all: (k + 1)/400 can be 5 %.
const DRAWS: usize = 399;
/// The correlation over people of the logits of a person's shares in two tasks.
pub(super) const CORRELATION: f64 = 0.5;
/// The most participants (of each group) that are looked for.
pub(super) const MOST_PARTICIPANTS: usize = 200;
/// The most presentations to a participant in each of the two.
pub(super) const MOST_PRESENTATIONS: usize = 1000;

/// What is to be found, and what is assumed about people.
#[derive(Clone, Debug, PartialEq)]
pub struct PowerPlan {
    pub difference: Difference,
    /// Participants; of each group where groups are compared.
    pub participants: usize,
    /// What a participant may be presented with, each as probable: how often each of the two samples, or in each of the two tasks or
    /// groups. Who has none of one of the two does not count, as in the test of answers.
    pub presentations: Vec<[usize; 2]>,
    /// Shares of the median participant, above 0 and below 1: as expected in each of two tasks or groups; of two samples, right and
    /// taken for the other.
    pub shares: [f64; 2],
    /// The standard deviation over participants, of the logits of these shares.
    pub logit_sd: f64,
}

/// The share of simulated campaigns that find a difference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct FoundShare {
    /// Participants; of each group where groups are compared.
    pub participants: usize,
    /// How many times the presentations of the design.
    pub times: usize,
    /// The share of campaigns in which the permutation test gives 5 % or less.
    pub power_share: f64,
    /// The number of simulated campaigns.
    pub campaigns: usize,
}

impl PowerPlan {
    fn check(&self) -> Result<(), DesignError> {
        let [a, b] = self.shares;
        for share in [a, b] {
            let what = "a share of the stated difference";
            must(what, share, above_0_below(1.0), "above 0 and below 1")?;
        }
        if matches!(self.difference, Difference::Samples(_)) {
            let what = "the sum of right answers and of those that name the other sample";
            must(what, a + b, ..=1.0, "at most 1")?;
        }
        let (what, people) = ("the number of participants", self.participants as f64);
        let range = 1.0..=MOST_PARTICIPANTS as f64;
        must(what, people, range, "1 to 200 for its power")?;
        for found in self.presentations.iter().flatten() {
            let (what, range) = ("the number of presentations", ..=MOST_PRESENTATIONS as f64);
            must(what, *found as f64, range, "at most 1000 for its power")?;
        }
        let both = self.presentations.iter().filter(|[n, m]| *n > 0 && *m > 0);
        let what = "the number of presentations of both";
        must(what, both.count() as f64, 1.0.., "at least 1")?;
        let what = "the spread of participants in logits";
        must(what, self.logit_sd, 0.0..=10.0, "0 to 10")
    }

    /// What a participant is presented with.
    fn presented(&self, random: &mut Random) -> [usize; 2] {
        match self.presentations[..] {
            [all] => all,
            ref drawn => drawn[(random.uniform() * drawn.len() as f64) as usize],
        }
    }

    /// The differences of the people of a simulated campaign, of one who is presented with both.
    fn differences(&self, random: &mut Random) -> Vec<f64> {
        let mut people = Vec::with_capacity(self.participants);
        for _ in 0..self.participants {
            let [n, m] = self.presented(random);
            let own = match self.difference {
                Difference::Samples(_) => self.told_apart(random, [n, m]),
                _ => self.two_tasks(random, [n, m]),
            };
            if n > 0 && m > 0 {
                people.push(own);
            }
        }
        people
    }

    /// Right answers less those that name the other sample, of one person.
    fn told_apart(&self, random: &mut Random, presented: [usize; 2]) -> f64 {
        let [a, b] = self.shares;
        let right = moved(a, self.logit_sd * random.normal());
        let other = (1.0 - right) * b / (1.0 - a);
        let of = presented.map(|n| {
            let answers = (0..n).map(|_| match random.uniform() {
                u if u < right => 1.0,
                u if u < right + other => -1.0,
                _ => 0.0,
            });
            answers.sum::<f64>() / n as f64
        });
        (of[0] + of[1]) / 2.0
    }

    /// The difference of the shares of one person in two tasks.
    fn two_tasks(&self, random: &mut Random, [n, m]: [usize; 2]) -> f64 {
        let [a, b] = self.shares;
        let shared = self.logit_sd * CORRELATION.sqrt() * random.normal();
        let apart = self.logit_sd * (1.0 - CORRELATION).sqrt();
        let [x, y] = [random.normal(), random.normal()];
        share_of(random, moved(a, shared + apart * x), n)
            - share_of(random, moved(b, shared + apart * y), m)
    }

    /// The shares of the people of both groups of a simulated campaign.
    fn groups(&self, random: &mut Random) -> [Vec<f64>; 2] {
        [0, 1].map(|group| {
            let mut people = Vec::with_capacity(self.participants);
            for _ in 0..self.participants {
                let n = self.presented(random)[group];
                let share = moved(self.shares[group], self.logit_sd * random.normal());
                let found = share_of(random, share, n);
                if n > 0 {
                    people.push(found);
                }
            }
            people
        })
    }

    /// Whether a simulated campaign finds the difference, in its direction where there is one.
    fn is_found(&self, random: &mut Random, seed: u64) -> bool {
        let (p_value, less) = match self.difference {
            Difference::People(_) => {
                let [a, b] = self.groups(random);
                let test = between_people(&a, &b, DRAWS, seed);
                (test.map(|test| test.p_value), mean(&a) - mean(&b))
            }
            _ => {
                let people = self.differences(random);
                let test = sign_flip_test(&people, DRAWS, seed);
                (test.map(|test| test.p_value), mean(&people))
            }
        };
        let [a, b] = self.shares;
        let is_its_direction = a == b || (less > 0.0) == (a > b);
        is_its_direction && p_value.is_some_and(|p| p <= LEVEL_SHARE)
    }
}

/// `share` with its logit moved by `by`.
fn moved(share: f64, by: f64) -> f64 {
    1.0 / (1.0 + (-(share / (1.0 - share)).ln() - by).exp())
}

/// The share of successes in `n` trials.
fn share_of(random: &mut Random, share: f64, n: usize) -> f64 {
    (0..n).filter(|_| random.uniform() < share).count() as f64 / n as f64
}

/// The share of `campaigns` simulated campaigns in which a permutation of participants finds the difference at 5 %, two-sided and in
/// its direction; of two equal shares in any. People differ: the logits of their shares are normal; those of one person in two tasks
/// correlate by 0.5; right answers and those that name the other sample share what a person is better by.
///
/// Source: docs/decisions/campaigns.md; test: [`crate::difference`].
///
/// # Errors
/// [`DesignError::OutOfRange`].
pub fn found_share(plan: &PowerPlan, campaigns: usize, seed: u64) -> Result<f64, DesignError> {
    plan.check()?;
    if plan.difference.smallest_p([plan.participants; 2]) > LEVEL_SHARE {
        return Ok(0.0);
    }
    let found = (0..campaigns as u64).filter(|number| {
        let mut random = Random::stream(seed, *number, "power");
        plan.is_found(&mut random, seed ^ number.rotate_left(32))
    });
    Ok(found.count() as f64 / campaigns.max(1) as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plan(difference: fn([String; 2]) -> Difference, shares: [f64; 2]) -> PowerPlan {
        PowerPlan {
            difference: difference(["a".into(), "b".into()]),
            participants: 10,
            presentations: vec![[12, 12]],
            shares,
            logit_sd: 0.9,
        }
    }

    /// Without a difference a level of 5 % is kept, also of people who differ much and of few answers.
    #[test]
    fn without_a_difference_at_most_five_percent_are_found() {
        for (of, shares) in [
            (Difference::Samples as fn(_) -> _, [0.4, 0.4]),
            (Difference::Tasks, [0.7, 0.7]),
            (Difference::Again, [0.7, 0.7]),
            (Difference::People, [0.7, 0.7]),
        ] {
            for (presentations, logit_sd, participants) in
                [([12, 12], 0.9, 10), ([2, 2], 2.0, 8), ([3, 3], 0.0, 18)]
            {
                let plan = PowerPlan {
                    presentations: vec![presentations],
                    logit_sd,
                    participants,
                    ..plan(of, shares)
                };
                // Whose median right and wrong answers are as many, are not right as often on average.
                let plan = match plan.difference {
                    Difference::Samples(_) => PowerPlan {
                        logit_sd: 0.0,
                        ..plan
                    },
                    _ => plan,
                };
                let found = found_share(&plan, 1000, 3).unwrap();
                // Three standard deviations of 1000 campaigns.
                assert!(found < 0.05 + 0.021, "{plan:?}: {found}");
            }
        }
    }

    #[test]
    fn more_people_more_answers_and_larger_differences_are_found_more_often() {
        for of in [
            Difference::Samples as fn(_) -> _,
            Difference::Tasks,
            Difference::People,
        ] {
            let power = |plan: &PowerPlan| found_share(plan, 400, 5).unwrap();
            let base = PowerPlan {
                presentations: vec![[2, 2]],
                ..plan(of, [0.65, 0.3])
            };
            let more = PowerPlan {
                participants: 20,
                ..base.clone()
            };
            let repeats = PowerPlan {
                presentations: vec![[60, 60]],
                ..base.clone()
            };
            let larger = PowerPlan {
                shares: [0.9, 0.05],
                ..base.clone()
            };
            let least = power(&base);
            for other in [&more, &repeats, &larger] {
                let found = power(other);
                assert!(found > least, "{other:?}: {found}, {least}");
            }
        }
    }

    #[test]
    fn too_few_people_never_find_anything() {
        let few = |of, participants| PowerPlan {
            participants,
            ..plan(of, [0.9, 0.05])
        };
        assert_eq!(found_share(&few(Difference::Tasks, 5), 200, 1), Ok(0.0));
        assert!(found_share(&few(Difference::Tasks, 6), 200, 1).unwrap() > 0.5);
        assert_eq!(found_share(&few(Difference::People, 4), 200, 1), Ok(0.0));
        assert!(found_share(&few(Difference::People, 5), 200, 1).unwrap() > 0.5);
    }

    #[test]
    fn bad_questions_are_refused() {
        let good = plan(Difference::Samples, [0.6, 0.3]);
        for bad in [
            PowerPlan {
                shares: [0.6, 0.5],
                ..good.clone()
            },
            PowerPlan {
                shares: [f64::NAN, 0.5],
                ..good.clone()
            },
            PowerPlan {
                shares: [1.0, 0.5],
                ..good.clone()
            },
            PowerPlan {
                participants: 0,
                ..good.clone()
            },
            PowerPlan {
                presentations: vec![[0, 3]],
                ..good.clone()
            },
            PowerPlan {
                logit_sd: f64::INFINITY,
                ..good.clone()
            },
        ] {
            assert!(found_share(&bad, 100, 1).is_err(), "{bad:?}");
        }
    }
}
