//! An adaptive run over listed levels, by staircase or QUEST+, of comparisons with two alternatives.

use std::fmt;

use piezotact::criterion::{Criterion, Limit, Outcome};
use serde::{Deserialize, Serialize};

use super::{AdaptiveRuleError, QuestPlus, QuestRule, Response, Staircase, StaircaseRule};

/// The share of correct answers by guessing between two alternatives.
pub const GUESS_SHARE: f64 = 0.5;

/// The largest share of a staircase's trials at which its rule asked for a level beyond the lowest or the highest.
const LARGEST_CLAMPED_SHARE: f64 = 0.1;

/// The largest probability, after QUEST+, of the lowest and the highest possible threshold together.
const LARGEST_AT_ENDS_SHARE: f64 = 0.05;

/// The rule that chooses the levels of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "is", rename_all = "snake_case", deny_unknown_fields)]
pub enum AdaptiveRule {
    /// A transformed up-down staircase. Each level that it can ask for must be listed.
    Staircase {
        /// Its rule.
        staircase: StaircaseRule,
        /// The number of trials after which it is stopped, ended or not.
        at_most: u32,
    },
    /// QUEST+ for a Weibull function with two alternatives, over the listed levels.
    QuestPlus {
        /// The thresholds that are possible, in dB.
        thresholds_db: Vec<f64>,
        /// The slopes that are possible.
        slopes: Vec<f64>,
        /// The shares of lapses that are possible.
        lapse_shares: Vec<f64>,
        /// The number of trials.
        trials: u32,
    },
}

impl AdaptiveRule {
    /// The largest number of trials.
    #[must_use]
    pub fn at_most(&self) -> u32 {
        match self {
            Self::Staircase { at_most, .. } => *at_most,
            Self::QuestPlus { trials, .. } => *trials,
        }
    }
}

/// What a criterion on a threshold judges.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ThresholdCriterion {
    /// The number of answers, of QUEST+.
    Answers,
    /// The number of reversals, of a staircase.
    Reversals,
    /// The standard deviation: of the posterior of QUEST+, of the counted reversals of a staircase.
    Spread,
    /// The threshold, beside the lowest level.
    AboveLowest,
    /// The threshold, beside the highest level.
    BelowHighest,
    /// The probability of the ends of the possible thresholds, of QUEST+.
    AtEnds,
    /// The share of trials that the rule wanted beyond the levels, of a staircase.
    Clamped,
}

impl fmt::Display for ThresholdCriterion {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Answers => "answers",
            Self::Reversals => "reversals",
            Self::Spread => "standard deviation of the posterior, or of the reversals",
            Self::AboveLowest => "threshold beside the lowest level",
            Self::BelowHighest => "threshold beside the highest level",
            Self::AtEnds => "probability of the lowest and the highest possible threshold",
            Self::Clamped => "share of trials beyond the levels",
        })
    }
}

/// What a run says about a threshold. It is decided where all criteria are met; else the value says little.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ThresholdEstimate {
    /// The threshold, in the unit of the levels; absent with fewer than two reversals that count.
    pub level: Option<f64>,
    /// The standard deviation of the posterior of QUEST+.
    pub posterior_sd: Option<f64>,
    /// The standard deviation of the counted reversals of a staircase, which is no standard error: they are not independent.
    pub reversals_sd: Option<f64>,
    /// The interval of 95 % of a threshold of QUEST+ that is decided. A staircase has none: Student's t over the pairs of its reversals holds the
    /// truth in 74 % of runs.
    pub interval: Option<[f64; 2]>,
    /// The answers that it is made from.
    pub answers: u32,
    /// What was judged.
    pub criteria: Vec<Criterion<ThresholdCriterion>>,
}

impl ThresholdEstimate {
    /// Met where all criteria are met, else not decided: a run that went wrong says nothing against a threshold.
    #[must_use]
    pub fn decided(&self) -> Outcome {
        match Outcome::of_all(self.criteria.iter().map(|one| one.outcome)) {
            Outcome::Met => Outcome::Met,
            Outcome::NotMet | Outcome::NotDecided => Outcome::NotDecided,
        }
    }
}

/// A run under way.
#[derive(Clone, Debug)]
pub struct AdaptiveRun {
    levels_db: Vec<f64>,
    at_most: u32,
    answers: u32,
    method: Method,
}

#[derive(Clone, Debug)]
enum Method {
    Staircase { run: Staircase, reversals: u32 },
    QuestPlus(QuestPlus),
}

impl AdaptiveRun {
    /// A run over `levels_db`, in increasing order, before its first trial. Levels need not be in dB: the unit is that of the rule.
    ///
    /// # Errors
    /// [`AdaptiveRuleError`].
    pub fn new(levels_db: &[f64], rule: &AdaptiveRule) -> Result<Self, AdaptiveRuleError> {
        let method = match rule {
            AdaptiveRule::Staircase { staircase, .. } => Method::Staircase {
                reversals: staircase.reversals,
                run: Staircase::new(staircase.clone())?,
            },
            AdaptiveRule::QuestPlus {
                thresholds_db,
                slopes,
                lapse_shares,
                trials,
            } => Method::QuestPlus(QuestPlus::new(QuestRule {
                levels_db: levels_db.to_vec(),
                thresholds_db: thresholds_db.clone(),
                slopes: slopes.clone(),
                guess_share: GUESS_SHARE,
                lapse_shares: lapse_shares.clone(),
                trials: *trials,
            })?),
        };
        Ok(Self {
            levels_db: levels_db.to_vec(),
            at_most: rule.at_most(),
            answers: 0,
            method,
        })
    }

    /// The place of the next level in the list; `None` when the run has ended. The level of a staircase is the nearest one listed.
    #[must_use]
    pub fn next_level(&self) -> Option<usize> {
        if self.answers >= self.at_most {
            return None;
        }
        match &self.method {
            Method::QuestPlus(run) => run.next_level(),
            Method::Staircase { run, .. } => {
                let wanted = run.next_level()?;
                let far = |i: &usize| (self.levels_db[*i] - wanted).abs();
                (0..self.levels_db.len()).min_by(|a, b| far(a).total_cmp(&far(b)))
            }
        }
    }

    /// Takes up the answer to a trial at the level with this place in the list: what was presented counts, also where the
    /// answers before it were corrected and another level would be chosen now. A place that is not there changes nothing.
    pub fn answer(&mut self, level: usize, response: Response) {
        let Some(level_db) = self.levels_db.get(level) else {
            return;
        };
        self.answers += 1;
        match &mut self.method {
            Method::QuestPlus(run) => run.answer(level, response),
            Method::Staircase { run, .. } => run.answer_at(*level_db, response),
        }
    }

    /// What the answers so far say, judged with `largest_sd_db` as the largest standard deviation, in the unit of the levels.
    #[must_use]
    pub fn estimate(&self, largest_sd_db: f64) -> ThresholdEstimate {
        use ThresholdCriterion as What;
        let exact = |what, unit: &str, found: f64, limit| {
            let interval = (!found.is_finite()).then_some([f64::NAN; 2]);
            Criterion::new(what, unit, found, interval, limit)
        };
        let answers = f64::from(self.answers);
        let mut criteria = Vec::new();
        let (level, posterior_sd, reversals_sd, interval) = match &self.method {
            Method::QuestPlus(run) => {
                let found = run.estimate();
                let wanted = Limit::at_least(f64::from(self.at_most));
                criteria.push(exact(What::Answers, "", answers, wanted));
                let limit = Limit::at_most(LARGEST_AT_ENDS_SHARE);
                criteria.push(exact(What::AtEnds, "", found.at_ends_share, limit));
                (
                    Some(found.threshold_db),
                    Some(found.threshold_sd_db),
                    None,
                    Some(found.threshold_interval_db),
                )
            }
            Method::Staircase { run, reversals } => {
                let found = run.estimate();
                let limit = Limit::at_least(f64::from(*reversals));
                let had = run.reversals().len() as f64;
                criteria.push(exact(What::Reversals, "", had, limit));
                let share = f64::from(run.clamped()) / answers.max(1.0);
                let limit = Limit::at_most(LARGEST_CLAMPED_SHARE);
                criteria.push(exact(What::Clamped, "", share, limit));
                (
                    found.map(|found| found.level),
                    None,
                    found.map(|found| found.reversals_sd),
                    None,
                )
            }
        };
        let ends = (self.levels_db.first(), self.levels_db.last());
        let sd = posterior_sd.or(reversals_sd);
        let (Some(level_db), Some(sd_db), (Some(lowest), Some(highest))) = (level, sd, ends) else {
            let limit = Limit::at_most(largest_sd_db);
            criteria.push(Criterion::unmeasured(What::Spread, "dB", limit));
            return ThresholdEstimate {
                level: None,
                posterior_sd: None,
                reversals_sd: None,
                interval: None,
                answers: self.answers,
                criteria,
            };
        };
        let spread = Limit::at_most(largest_sd_db);
        criteria.push(exact(What::Spread, "dB", sd_db, spread));
        // QUEST+ knows how probable other thresholds are; the reversals of a staircase only stand within its levels.
        let reach = interval.or(Some([level_db; 2]));
        for (what, limit) in [
            (What::AboveLowest, Limit::at_least(*lowest)),
            (What::BelowHighest, Limit::at_most(*highest)),
        ] {
            criteria.push(Criterion::new(what, "dB", level_db, reach, limit));
        }
        let is_decided = criteria.iter().all(|one| one.outcome == Outcome::Met);
        ThresholdEstimate {
            level,
            posterior_sd,
            reversals_sd,
            interval: interval.filter(|_| is_decided),
            answers: self.answers,
            criteria,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Start;
    use super::*;

    const LEVELS: [f64; 5] = [-8.0, -6.0, -4.0, -2.0, 0.0];

    fn staircase() -> StaircaseRule {
        StaircaseRule {
            first: -2.0,
            steps: vec![4.0, 2.0],
            down: 2,
            up: 1,
            start: Start::OneUpOneDown,
            lowest: -8.0,
            highest: 0.0,
            reversals: 6,
            trials: 0,
            left_out: 2,
        }
    }

    fn run(at_most: u32) -> AdaptiveRun {
        let rule = AdaptiveRule::Staircase {
            staircase: staircase(),
            at_most,
        };
        AdaptiveRun::new(&LEVELS, &rule).unwrap()
    }

    /// Answers without an order of their own.
    fn response(trial: usize) -> Response {
        match [0, 1, 1, 0, 1, 1, 1, 0][trial % 8] {
            0 => Response::Wrong,
            _ => Response::Correct,
        }
    }

    #[test]
    fn a_staircase_over_listed_levels_is_the_staircase() {
        let (mut run, mut alone) = (run(100), Staircase::new(staircase()).unwrap());
        let mut trial = 0;
        while let Some(level) = alone.next_level() {
            let at = run.next_level().unwrap();
            assert_eq!(LEVELS[at], level);
            run.answer(at, response(trial));
            alone.answer(response(trial));
            trial += 1;
        }
        assert_eq!(run.next_level(), None);
        let found = run.estimate(5.0);
        assert_eq!(found.level, alone.estimate().map(|one| one.level));
        assert_eq!(found.answers as usize, trial);
    }

    #[test]
    fn a_staircase_that_is_stopped_has_too_few_reversals() {
        let mut run = run(7);
        for trial in 0..7 {
            let at = run.next_level().unwrap();
            run.answer(at, response(trial));
        }
        assert_eq!(run.next_level(), None);
        let found = run.estimate(50.0);
        assert_eq!(found.decided(), Outcome::NotDecided);
        let reversals = &found.criteria[0];
        assert_eq!(reversals.what, ThresholdCriterion::Reversals);
        assert_eq!(reversals.outcome, Outcome::NotMet);
        run.answer(99, Response::Correct);
        assert_eq!(run.estimate(50.0), found, "no such level");
    }

    #[test]
    fn every_criterion_can_leave_a_threshold_open() {
        let rule = AdaptiveRule::QuestPlus {
            thresholds_db: (-10..=2).map(f64::from).collect(),
            slopes: vec![20.0],
            lapse_shares: vec![0.0],
            trials: 40,
        };
        let judged = |threshold_db: f64, largest_sd_db: f64, trials: usize| {
            let mut run = AdaptiveRun::new(&LEVELS, &rule).unwrap();
            for _ in 0..trials {
                let at = run.next_level().unwrap();
                let response = match LEVELS[at] > threshold_db {
                    true => Response::Correct,
                    false => Response::Wrong,
                };
                run.answer(at, response);
            }
            let found = run.estimate(largest_sd_db);
            let open = found.criteria.iter();
            let open = open.filter(|one| one.outcome != Outcome::Met);
            let open: Vec<_> = open.map(|one| one.what).collect();
            assert_eq!(found.decided() == Outcome::Met, open.is_empty());
            open
        };
        use ThresholdCriterion as What;
        assert_eq!(judged(-5.0, 2.0, 40), []);
        assert_eq!(judged(-5.0, 2.0, 39), [What::Answers]);
        assert_eq!(judged(-5.0, 0.01, 40), [What::Spread]);
        assert!(judged(9.0, 2.0, 40).contains(&What::BelowHighest));
        assert!(judged(9.0, 2.0, 40).contains(&What::AtEnds));
        assert!(judged(-20.0, 2.0, 40).contains(&What::AboveLowest));
        // A staircase against the highest level.
        let mut run = run(60);
        let mut trial = 0;
        while let Some(at) = run.next_level() {
            run.answer(
                at,
                if trial % 5 < 3 {
                    Response::Wrong
                } else {
                    Response::Correct
                },
            );
            trial += 1;
        }
        let clamped = &run.estimate(9.0).criteria[1];
        assert_eq!(
            (clamped.what, clamped.outcome),
            (What::Clamped, Outcome::NotMet)
        );
    }
}
