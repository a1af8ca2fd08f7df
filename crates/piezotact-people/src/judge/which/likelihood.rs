//! The likelihood of answers by each judge, over the values that its free parameters can have.

use serde::{Deserialize, Serialize};

use super::super::answer::JudgeError;
use super::super::{Judge, Person, Touch};
use super::{Answers, Bounds};

/// Noise ratios and spectrum weights of the first look are this factor apart.
const NOISE_STEP: f64 = 1.259_921_049_894_873_2;
const WEIGHT_STEP: f64 = std::f64::consts::SQRT_2;
/// How often the steps around the best are halved.
const HALVINGS: usize = 3;
/// A probability below this counts as this: an answer that a judge cannot give without a lapse.
const LEAST_PROBABILITY: f64 = 1e-300;

/// Values of the free parameters of a judge.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Parameters {
    /// The noise of a look over that of the assumed sense of touch; absent where the judge has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_ratio: Option<f64>,
    /// The weight of a squared step in spectrum; absent where the judge has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spectrum_weight: Option<f64>,
    /// The share of lapses; absent where the judge has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lapse_share: Option<f64>,
}

impl Parameters {
    /// How many are free.
    #[must_use]
    pub fn free(&self) -> usize {
        [self.noise_ratio, self.spectrum_weight, self.lapse_share]
            .iter()
            .flatten()
            .count()
    }
}

/// The probabilities of all answers at one point of noise and weight.
pub(super) struct Point {
    pub(super) noise_ratio: f64,
    pub(super) spectrum_weight: f64,
    /// Of each answer with attention, and in a lapse.
    answers: Vec<[f64; 2]>,
}

/// All points that were looked at for one judge, and the best of them.
pub(super) struct Surface {
    judge: Judge,
    points: Vec<Point>,
    bounds: Bounds,
}

/// A maximum: which point, with which lapses, and how likely.
#[derive(Clone, Copy)]
pub(super) struct Best {
    pub(super) point: usize,
    pub(super) lapse_share: f64,
    pub(super) log_likelihood: f64,
}

impl Surface {
    /// `judge` at all points of a grid within `bounds`, and around the best of them.
    pub(super) fn of(
        judge: Judge,
        answers: &Answers,
        touch: &Touch,
        bounds: Bounds,
    ) -> Result<Self, JudgeError> {
        let noises = match judge {
            Judge::Guesser => vec![1.0],
            _ => grid(bounds.noise_ratio, NOISE_STEP),
        };
        let weights = match judge {
            Judge::Thurstone => grid(bounds.spectrum_weight, WEIGHT_STEP),
            _ => vec![touch.spectrum_weight],
        };
        let mut surface = Self {
            judge,
            points: Vec::new(),
            bounds,
        };
        for noise_ratio in noises {
            // The weight changes no order.
            let mut orders = None;
            for spectrum_weight in &weights {
                let point = Point::at(
                    (judge, answers, touch),
                    noise_ratio,
                    *spectrum_weight,
                    orders.take(),
                )?;
                orders = Some(point.answers[answers.choices.len()..].to_vec());
                surface.points.push(point);
            }
        }
        surface.refine(answers, touch)?;
        Ok(surface)
    }

    /// Adds points around the best, at ever smaller steps.
    fn refine(&mut self, answers: &Answers, touch: &Touch) -> Result<(), JudgeError> {
        if self.judge == Judge::Guesser {
            return Ok(());
        }
        let (mut noise_step, mut weight_step) = (NOISE_STEP, WEIGHT_STEP);
        for _ in 0..HALVINGS {
            (noise_step, weight_step) = (noise_step.sqrt(), weight_step.sqrt());
            let middle = &self.points[self.best(|_| true).point];
            let (noise, weight) = (middle.noise_ratio, middle.spectrum_weight);
            let weights = match self.judge {
                Judge::Thurstone => vec![weight / weight_step, weight, weight * weight_step],
                _ => vec![weight],
            };
            let [low, high] = self.bounds.spectrum_weight;
            let [quiet, loud] = self.bounds.noise_ratio;
            for noise in [noise / noise_step, noise, noise * noise_step] {
                for weight in &weights {
                    let within = (quiet..=loud).contains(&noise)
                        && (self.judge != Judge::Thurstone || (low..=high).contains(weight));
                    if within {
                        let of = (self.judge, answers, touch);
                        self.points.push(Point::at(of, noise, *weight, None)?);
                    }
                }
            }
        }
        Ok(())
    }

    /// The maximum over all points and lapses of the likelihood of the answers that `counts`.
    pub(super) fn best(&self, counts: impl Fn(usize) -> bool) -> Best {
        let mut best = Best {
            point: 0,
            lapse_share: 0.0,
            log_likelihood: f64::NEG_INFINITY,
        };
        for (i, point) in self.points.iter().enumerate() {
            let counted: Vec<[f64; 2]> = point
                .answers
                .iter()
                .enumerate()
                .filter(|(i, _)| counts(*i))
                .map(|(_, p)| *p)
                .collect();
            let lapse_share = match self.judge {
                Judge::Guesser => 0.0,
                _ => likeliest_lapse(&counted, self.bounds.lapse_share),
            };
            let log_likelihood = counted.iter().map(|p| log_of(*p, lapse_share)).sum();
            if log_likelihood > best.log_likelihood {
                best = Best {
                    point: i,
                    lapse_share,
                    log_likelihood,
                };
            }
        }
        best
    }

    /// The logarithm of the probability of each answer at `best`.
    pub(super) fn logs(&self, best: &Best) -> Vec<f64> {
        let answers = self.points[best.point].answers.iter();
        answers.map(|p| log_of(*p, best.lapse_share)).collect()
    }

    /// The free parameters at `best`.
    pub(super) fn parameters(&self, best: &Best) -> Parameters {
        let point = &self.points[best.point];
        let thinks = self.judge != Judge::Guesser;
        Parameters {
            noise_ratio: thinks.then_some(point.noise_ratio),
            spectrum_weight: (self.judge == Judge::Thurstone).then_some(point.spectrum_weight),
            lapse_share: thinks.then_some(best.lapse_share),
        }
    }

    /// The person with the parameters at `best`.
    pub(super) fn person(&self, best: &Best, touch: &Touch) -> Person {
        let point = &self.points[best.point];
        Person {
            judge: self.judge,
            touch: Touch {
                spectrum_weight: point.spectrum_weight,
                lapse_share: best.lapse_share,
                ..touch.with_noise(point.noise_ratio)
            },
        }
    }
}

impl Point {
    fn at(
        (judge, answers, touch): (Judge, &Answers, &Touch),
        noise_ratio: f64,
        spectrum_weight: f64,
        orders: Option<Vec<[f64; 2]>>,
    ) -> Result<Self, JudgeError> {
        let person = Person {
            judge,
            touch: Touch {
                spectrum_weight,
                ..touch.with_noise(noise_ratio)
            },
        };
        let mut all = Vec::with_capacity(answers.len());
        for choice in &answers.choices {
            let (presented, alternatives) = choice.looks();
            let at = (choice.recall, choice.moment);
            let p = person.attentive_choice(presented, &alternatives, at)?;
            let guess = 1.0 / alternatives.len() as f64;
            all.push([p.get(choice.chosen).copied().unwrap_or(0.0), guess]);
        }
        match orders {
            Some(orders) => all.extend(orders),
            None => {
                for order in &answers.orders {
                    let looks = order.looks();
                    all.push(person.attentive_order(&looks, &order.order, order.moment)?);
                }
            }
        }
        Ok(Self {
            noise_ratio,
            spectrum_weight,
            answers: all,
        })
    }
}

fn log_of([attentive, lapsed]: [f64; 2], lapse_share: f64) -> f64 {
    (lapse_share * lapsed + (1.0 - lapse_share) * attentive)
        .max(LEAST_PROBABILITY)
        .ln()
}

/// The share of lapses with the largest likelihood, which is concave in it: where its slope is 0, or at an end.
fn likeliest_lapse(answers: &[[f64; 2]], [low, high]: [f64; 2]) -> f64 {
    let slope = |share: f64| -> f64 {
        let of = |[attentive, lapsed]: &[f64; 2]| {
            let p = (share * lapsed + (1.0 - share) * attentive).max(LEAST_PROBABILITY);
            (lapsed - attentive) / p
        };
        answers.iter().map(of).sum()
    };
    if slope(low) <= 0.0 {
        return low;
    }
    if slope(high) >= 0.0 {
        return high;
    }
    let (mut below, mut above) = (low, high);
    for _ in 0..24 {
        let middle = 0.5 * (below + above);
        if slope(middle) > 0.0 {
            below = middle;
        } else {
            above = middle;
        }
    }
    0.5 * (below + above)
}

/// From `low` to `high` in equal factors of at most `step`.
fn grid([low, high]: [f64; 2], step: f64) -> Vec<f64> {
    let count = ((high / low).ln() / step.ln() - 1e-9).ceil().max(0.0) as usize;
    if count == 0 {
        return vec![low];
    }
    (0..=count)
        .map(|i| match i {
            0 => low,
            i if i == count => high,
            i => low * (high / low).powf(i as f64 / count as f64),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lapse_of_a_mixture_is_its_maximum() {
        // Ten answers of probability 0.5 and two that only a lapse gives, of 1/3: 12·ln … has its maximum where
        // 2/λ = 10·(1/6)/(0.5 − λ/6), λ = 0.5.
        let mut answers = vec![[0.5, 1.0 / 3.0]; 10];
        answers.extend([[0.0, 1.0 / 3.0]; 2]);
        assert!((likeliest_lapse(&answers, [0.0, 1.0]) - 0.5).abs() < 1e-6);
        assert!((likeliest_lapse(&answers, [0.0, 0.2]) - 0.2).abs() < 1e-12);
        assert!(likeliest_lapse(&answers[..10], [0.0, 0.2]).abs() < 1e-12);
    }

    #[test]
    fn grids_reach_both_ends() {
        assert_eq!(grid([0.5, 8.0], 2.0), [0.5, 1.0, 2.0, 4.0, 8.0]);
        assert_eq!(grid([1.0, 1.0], 2.0), [1.0]);
        let uneven = grid([1.0, 3.0], 2.0);
        assert_eq!(uneven.len(), 3);
        assert!((uneven[2] - 3.0).abs() < 1e-12);
    }
}
