//! How many adaptive runs decide a threshold.

use piezotact::criterion::{Criterion, Limit, Outcome};

use super::super::description::TaskDescription;
use super::super::error::DesignError;
use super::super::fault::{DesignCriterion, Fault};
use super::super::precision::uniform;
use super::Work;
use super::report::ThresholdShare;
use crate::campaign::adaptive::{AdaptiveRule, AdaptiveRun, GUESS_SHARE, Response, weibull};
use crate::campaign::random::Stream;

/// Simulated runs.
const RUNS: usize = 100;
/// What people are assumed to be like where the rule does not say: slopes around those of Watson (2017), and shares of lapses.
const SLOPES: [f64; 3] = [1.0, 2.0, 3.0];
const LAPSE_SHARES: [f64; 3] = [0.0, 0.02, 0.04];
/// The most points that all simulated runs compute with; nothing is simulated beyond.
const MOST_POINTS: f64 = 5e8;

impl Work<'_> {
    /// The share of runs that decide a threshold: with people who answer as a Weibull function in dB says, with thresholds in the
    /// middle half of the levels.
    ///
    /// Source: Watson 2017, J. Vision 17(3):10; judged by [`AdaptiveRun::estimate`], as the runs of a session are.
    pub(super) fn thresholds(
        &mut self,
        task: &TaskDescription,
        (levels, rule): (&[f64], &AdaptiveRule),
        largest_sd: f64,
    ) -> Result<(), DesignError> {
        let wanted_share = self.campaign.aims.power_share;
        let limit = Limit::at_least(wanted_share);
        let task = task.name.clone();
        let what = DesignCriterion::ThresholdsDecided { task: task.clone() };
        let decided = match points(levels, rule) * RUNS as f64 <= MOST_POINTS {
            true => self.decided(&task, (levels, rule), largest_sd),
            false => None,
        };
        let Some((decided, thresholds)) = decided else {
            self.report
                .criteria
                .push(Criterion::unmeasured(what, "", limit));
            return Ok(());
        };
        let decided_share = decided as f64 / RUNS as f64;
        self.report.thresholds.push(ThresholdShare {
            task: task.clone(),
            runs: RUNS,
            decided_share,
            thresholds,
        });
        // By the share itself: what decides too rarely is never called enough for the interval of a simulation.
        let criterion = Criterion::new(what, "", decided_share, None, limit);
        self.judge(criterion, |_| {
            let fault = Fault::ThresholdsOpen {
                task,
                trials: rule.at_most(),
                decided_share,
                wanted_share,
            };
            Ok((fault, None))
        })
    }

    /// How many runs decide, and between which thresholds; `None` of a rule that cannot be followed.
    fn decided(
        &self,
        task: &str,
        (levels, rule): (&[f64], &AdaptiveRule),
        largest_sd: f64,
    ) -> Option<(usize, [f64; 2])> {
        let new = AdaptiveRun::new(levels, rule).ok()?;
        let at = |place: usize| levels.get(place).copied();
        let [low, high] = [at(levels.len() / 4), at(levels.len() * 3 / 4)];
        let thresholds = [low?, high?];
        let (slopes, lapses): (&[f64], &[f64]) = match rule {
            AdaptiveRule::QuestPlus {
                slopes,
                lapse_shares,
                ..
            } => (slopes, lapse_shares),
            AdaptiveRule::Staircase { .. } => (&SLOPES, &LAPSE_SHARES),
        };
        let mut draws = Stream::of(self.seed, &["thresholds", task]);
        let decides = |_: &usize| {
            let threshold = thresholds[0] + uniform(&mut draws) * (thresholds[1] - thresholds[0]);
            let slope = slopes[draws.below(slopes.len())];
            let lapse = lapses[draws.below(lapses.len())];
            let mut run = new.clone();
            while let Some(at) = run.next_level() {
                let correct = weibull(levels[at], threshold, slope, GUESS_SHARE, lapse);
                run.answer(
                    at,
                    match uniform(&mut draws) < correct {
                        true => Response::Correct,
                        false => Response::Wrong,
                    },
                );
            }
            run.estimate(largest_sd).decided() == Outcome::Met
        };
        Some(((0..RUNS).filter(decides).count(), thresholds))
    }
}

/// The points that a run computes with.
fn points(levels: &[f64], rule: &AdaptiveRule) -> f64 {
    let of_rule = match rule {
        AdaptiveRule::Staircase { .. } => 1,
        AdaptiveRule::QuestPlus {
            thresholds_db,
            slopes,
            lapse_shares,
            ..
        } => thresholds_db.len() * slopes.len() * lapse_shares.len(),
    };
    levels.len() as f64 * of_rule as f64 * f64::from(rule.at_most())
}
