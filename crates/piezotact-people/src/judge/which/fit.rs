//! Whether a judge explains the answers, whatever other judges do.

use piezotact::criterion::{Criterion, Limit};
use piezotact::statistics::{mean, mean_interval};
use serde::{Deserialize, Serialize};

use super::super::answer::{JudgeError, Look};
use super::super::cues::CUE_BANDS;
use super::super::{Judge, Person};
use super::{Answers, MIN_PEOPLE};

/// An excess of up to this share of the choices is no misfit: no model is exact.
pub const FIT_SHARE: f64 = 0.08;
/// A mean log-probability that is this far from its expectation is no misfit.
pub const FIT_NATS: f64 = 0.15;
/// The ranges of predicted probability in which choices are counted.
const BINS: [[f64; 2]; 4] = [[0.0, 0.2], [0.2, 0.5], [0.5, 0.8], [0.8, 1.0]];
/// Pairs of an order with a predicted probability outside this say nothing.
const OPEN: std::ops::RangeInclusive<f64> = 0.02..=0.98;
/// A range needs so many predictions for each participant.
const FEWEST_IN_BIN: usize = 5;

/// What is compared of predicted and given answers.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "is", rename_all = "snake_case")]
pub enum FitCriterion {
    /// The share of choices of the alternative that is nearest in level, given − predicted.
    NearestLevel,
    /// The same of the nearest in spectrum.
    NearestSpectrum,
    /// The same of the strongest alternative.
    Strongest,
    /// The same of the alternative that was named first.
    First,
    /// Of alternatives whose predicted probability lies in a range, the share that was chosen − the mean prediction.
    Calibration {
        /// The lower end.
        from: f64,
        /// The upper end.
        to: f64,
    },
    /// The mean logarithm of the probability of a choice − its expectation, nats.
    LogProbability,
    /// Of pairs in orders that are not certain, the share that stand as is more probable − predicted.
    Pairs,
}

/// The criteria of the fit of `person` to `answers`: each with the mean over participants and its 95 % interval.
pub(super) fn fit(
    person: &Person,
    answers: &Answers,
) -> Result<Vec<Criterion<FitCriterion>>, JudgeError> {
    let people = answers.people();
    let mut residuals = Residuals::new(people.len());
    for choice in &answers.choices {
        let Some(who) = people.iter().position(|name| **name == choice.participant) else {
            continue;
        };
        let (presented, alternatives) = choice.looks();
        let at = (choice.recall, choice.moment);
        let p = person.choice_probabilities(presented, &alternatives, at)?;
        residuals.choice(who, (presented, &alternatives), &p, choice.chosen);
    }
    for order in &answers.orders {
        let Some(who) = people.iter().position(|name| **name == order.participant) else {
            continue;
        };
        let looks = order.looks();
        // Of all pairs, not of neighbours alone: who became neighbours depends on the answer.
        for (i, one) in order.order.iter().enumerate() {
            for other in &order.order[i + 1..] {
                let (Some(one), Some(other)) = (looks.get(*one), looks.get(*other)) else {
                    continue;
                };
                let p = stands_before(person, [*one, *other], order.moment)?;
                if OPEN.contains(&p) {
                    residuals.pairs[who].push(f64::from(p >= 0.5) - p.max(1.0 - p));
                }
            }
        }
    }
    Ok(residuals.criteria(person.judge))
}

/// The probability that the first of two stands before the second.
fn stands_before(
    person: &Person,
    pair: [Look<'_>; 2],
    moment: super::super::Moment,
) -> Result<f64, JudgeError> {
    let last = pair.map(|look| person.is_placed_last(look));
    match last {
        [false, true] => Ok(1.0 - 0.5 * person.touch.lapse_share),
        [true, false] => Ok(0.5 * person.touch.lapse_share),
        _ => person.first_rougher_probability(pair, moment),
    }
}

/// Given − predicted, by participant.
struct Residuals {
    /// Nearest in level, in spectrum, strongest, first; of each answer.
    shares: [Vec<Vec<f64>>; 4],
    bins: [Vec<Vec<f64>>; BINS.len()],
    logs: Vec<Vec<f64>>,
    pairs: Vec<Vec<f64>>,
}

impl Residuals {
    fn new(people: usize) -> Self {
        let none = || vec![Vec::new(); people];
        Self {
            shares: std::array::from_fn(|_| none()),
            bins: std::array::from_fn(|_| none()),
            logs: none(),
            pairs: none(),
        }
    }

    fn choice(
        &mut self,
        who: usize,
        (presented, alternatives): (Look<'_>, &[Look<'_>]),
        p: &[f64],
        chosen: usize,
    ) {
        let level = |look: &Look<'_>| (look.cues.ln_rms - presented.cues.ln_rms).abs();
        let spectrum = |look: &Look<'_>| -> f64 {
            (0..CUE_BANDS)
                .map(|i| (look.cues.bands_db[i] - presented.cues.bands_db[i]).powi(2))
                .sum()
        };
        let least = |of: &dyn Fn(&Look<'_>) -> f64| {
            let all = (0..alternatives.len()).map(|j| (j, of(&alternatives[j])));
            all.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(j, _)| j)
        };
        let places = [
            least(&level),
            least(&spectrum),
            least(&|look| -look.cues.ln_rms),
            0,
        ];
        for (share, place) in self.shares.iter_mut().zip(places) {
            share[who].push(f64::from(chosen == place) - p.get(place).copied().unwrap_or(0.0));
        }
        let (mut log, mut expected) = (0.0, 0.0);
        for (j, p) in p.iter().enumerate() {
            let given = f64::from(j == chosen);
            for (bin, [from, to]) in self.bins.iter_mut().zip(BINS) {
                if *p >= from && (*p < to || to >= 1.0) {
                    bin[who].push(given - p);
                }
            }
            if *p > 0.0 {
                expected += p * p.ln();
            }
            if j == chosen {
                log = p.max(1e-300).ln();
            }
        }
        self.logs[who].push(log - expected);
    }

    fn criteria(&self, judge: Judge) -> Vec<Criterion<FitCriterion>> {
        use FitCriterion as F;
        let of_share = |what, by_person: &[Vec<f64>], fewest| {
            of_people(what, "", by_person, fewest, FIT_SHARE)
        };
        let whats = [F::NearestLevel, F::NearestSpectrum, F::Strongest, F::First];
        let mut all: Vec<Criterion<FitCriterion>> = whats
            .into_iter()
            .zip(&self.shares)
            .map(|(what, by_person)| of_share(what, by_person, 1))
            .collect();
        for ([from, to], bin) in BINS.into_iter().zip(&self.bins) {
            all.push(of_share(F::Calibration { from, to }, bin, FEWEST_IN_BIN));
        }
        all.push(of_people(F::LogProbability, "nat", &self.logs, 1, FIT_NATS));
        if judge != Judge::Guesser && self.pairs.iter().any(|one| !one.is_empty()) {
            all.push(of_share(F::Pairs, &self.pairs, 1));
        }
        // A range into which nothing was predicted says nothing.
        all.retain(|criterion| {
            !matches!(criterion.what, F::Calibration { .. }) || criterion.found.is_some()
        });
        all
    }
}

/// The mean over participants who have at least `fewest` values.
fn of_people(
    what: FitCriterion,
    unit: &str,
    by_person: &[Vec<f64>],
    fewest: usize,
    reach: f64,
) -> Criterion<FitCriterion> {
    let limit = Limit::Within { reach };
    let counted = by_person.iter().filter(|values| values.len() >= fewest);
    let means: Vec<f64> = counted.map(|values| mean(values)).collect();
    match mean_interval(&means) {
        Some(interval) if means.len() >= MIN_PEOPLE => {
            Criterion::new(what, unit, mean(&means), Some(interval), limit)
        }
        _ => Criterion::unmeasured(what, unit, limit),
    }
}
