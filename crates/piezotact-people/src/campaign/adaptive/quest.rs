//! QUEST+ for a Weibull function: the next level is the one that is expected to leave the smallest entropy.

use serde::{Deserialize, Serialize};

use super::{AdaptiveRuleError, Response};

/// The rule of a QUEST+ run. Levels and thresholds are in dB.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct QuestRule {
    /// The levels that can be presented, in dB.
    pub levels_db: Vec<f64>,
    /// The thresholds that are possible, in dB; each has the same probability beforehand.
    pub thresholds_db: Vec<f64>,
    /// The slopes that are possible.
    pub slopes: Vec<f64>,
    /// The share of correct answers by guessing: 0.5 for two alternatives.
    pub guess_share: f64,
    /// The shares of lapses that are possible.
    pub lapse_shares: Vec<f64>,
    /// The number of trials.
    pub trials: u32,
}

/// What a run says about the threshold.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct QuestEstimate {
    /// The mean of the posterior of the threshold, in dB.
    pub threshold_db: f64,
    /// Its standard deviation, in dB.
    pub threshold_sd_db: f64,
    /// Its quantiles of 2.5 and 97.5 %, in dB, where the thresholds of the grid stand for what lies nearer to them than to others.
    pub threshold_interval_db: [f64; 2],
    /// The mean of the posterior of the slope.
    pub slope: f64,
    /// The mean of the posterior of the share of lapses.
    pub lapse_share: f64,
    /// The probability of the lowest and the highest threshold together: where it is not small, the threshold may lie
    /// outside of the ones that are possible.
    pub at_ends_share: f64,
}

/// The parameters of a point of the grid.
#[derive(Clone, Copy, Debug)]
struct Point {
    threshold_db: f64,
    slope: f64,
    lapse_share: f64,
}

/// A run under way. What is the same for all trials is computed once; a trial allocates nothing.
#[derive(Clone, Debug)]
pub struct QuestPlus {
    rule: QuestRule,
    points: Vec<Point>,
    posterior: Vec<f64>,
    /// By level: the probability of a correct answer at each point.
    correct: Vec<Vec<f64>>,
    /// By level: p ln p of correct and of wrong answers together, at each point.
    p_ln_p: Vec<Vec<f64>>,
    trials: u32,
}

/// The share of correct answers at a level: ψ = 1 − λ − (1 − γ − λ) · exp(−10^(β (x − t) / 20)), from γ to 1 − λ.
///
/// Source: Watson 2017, J. Vision 17(3):10, equation of the Weibull function in dB.
#[must_use]
pub fn weibull(
    level_db: f64,
    threshold_db: f64,
    slope_ratio: f64,
    guess_share: f64,
    lapse_share: f64,
) -> f64 {
    let height = 1.0 - guess_share - lapse_share;
    1.0 - lapse_share
        - height * (-(10_f64.powf(slope_ratio * (level_db - threshold_db) / 20.0))).exp()
}

impl QuestPlus {
    /// A run before its first trial.
    ///
    /// # Errors
    /// [`AdaptiveRuleError`].
    pub fn new(rule: QuestRule) -> Result<Self, AdaptiveRuleError> {
        check(&rule)?;
        let mut points = Vec::new();
        for &threshold_db in &rule.thresholds_db {
            for &slope in &rule.slopes {
                let point = |&lapse_share: &f64| Point {
                    threshold_db,
                    slope,
                    lapse_share,
                };
                points.extend(rule.lapse_shares.iter().map(point));
            }
        }
        let share = |level_db: f64, point: &Point| {
            weibull(
                level_db,
                point.threshold_db,
                point.slope,
                rule.guess_share,
                point.lapse_share,
            )
        };
        let correct: Vec<Vec<f64>> = rule
            .levels_db
            .iter()
            .map(|level_db| points.iter().map(|point| share(*level_db, point)).collect())
            .collect();
        let both = |p: &f64| x_ln_x(*p) + x_ln_x(1.0 - p);
        let p_ln_p = correct
            .iter()
            .map(|row| row.iter().map(both).collect())
            .collect();
        Ok(Self {
            posterior: vec![1.0 / points.len() as f64; points.len()],
            points,
            correct,
            p_ln_p,
            rule,
            trials: 0,
        })
    }

    /// The place of the next level in the rule's list; `None` when the run has ended.
    ///
    /// The expected entropy after a trial at level x is H = −Σθ p(θ) ln p(θ) − Σθ p(θ) Σr p(r|x,θ) ln p(r|x,θ) + Σr p(r|x) ln p(r|x).
    /// The first term is the same for all levels.
    ///
    /// Source: Watson 2017, J. Vision 17(3):10.
    #[must_use]
    pub fn next_level(&self) -> Option<usize> {
        if self.trials >= self.rule.trials {
            return None;
        }
        let entropy = |level: usize| {
            let p = dot(&self.posterior, &self.correct[level]);
            x_ln_x(p) + x_ln_x(1.0 - p) - dot(&self.posterior, &self.p_ln_p[level])
        };
        let mut best = (0, entropy(0));
        for level in 1..self.rule.levels_db.len() {
            let here = entropy(level);
            if here < best.1 {
                best = (level, here);
            }
        }
        Some(best.0)
    }

    /// Takes up the answer to a trial at the level with this place in the rule's list. A place that is not there changes nothing.
    pub fn answer(&mut self, level: usize, response: Response) {
        let Some(correct) = self.correct.get(level) else {
            return;
        };
        for (posterior, p) in self.posterior.iter_mut().zip(correct) {
            *posterior *= match response {
                Response::Correct => *p,
                Response::Wrong => 1.0 - p,
            };
        }
        let sum: f64 = self.posterior.iter().sum();
        // Where no point can explain the answer, nothing is known any more.
        match sum > 0.0 {
            true => self.posterior.iter_mut().for_each(|p| *p /= sum),
            false => self.posterior.fill(1.0 / self.points.len() as f64),
        }
        self.trials += 1;
    }

    /// What the answers so far say.
    #[must_use]
    pub fn estimate(&self) -> QuestEstimate {
        let mean = |of: fn(&Point) -> f64| -> f64 {
            self.points
                .iter()
                .zip(&self.posterior)
                .map(|(point, p)| of(point) * p)
                .sum()
        };
        let threshold_db = mean(|point| point.threshold_db);
        let lowest = self
            .rule
            .thresholds_db
            .iter()
            .copied()
            .fold(f64::INFINITY, f64::min);
        let highest = self
            .rule
            .thresholds_db
            .iter()
            .copied()
            .fold(f64::NEG_INFINITY, f64::max);
        let (mut variance, mut at_ends_share) = (0.0, 0.0);
        for (point, p) in self.points.iter().zip(&self.posterior) {
            variance += (point.threshold_db - threshold_db).powi(2) * p;
            if point.threshold_db <= lowest || point.threshold_db >= highest {
                at_ends_share += p;
            }
        }
        QuestEstimate {
            threshold_db,
            threshold_sd_db: variance.sqrt(),
            threshold_interval_db: [0.025, 0.975].map(|share| self.quantile_db(share)),
            slope: mean(|point| point.slope),
            lapse_share: mean(|point| point.lapse_share),
            at_ends_share,
        }
    }
}

impl QuestPlus {
    /// The threshold below which the `share` of the posterior lies, in dB: linear between the middles of the grid.
    fn quantile_db(&self, share: f64) -> f64 {
        let mut thresholds = self.rule.thresholds_db.clone();
        thresholds.sort_unstable_by(f64::total_cmp);
        thresholds.dedup();
        let mut below = 0.0;
        for (i, &here) in thresholds.iter().enumerate() {
            let all = self.points.iter().zip(&self.posterior);
            let of_here = all.filter(|(point, _)| point.threshold_db == here);
            let p: f64 = of_here.map(|(_, p)| *p).sum();
            if below + p >= share || i + 1 == thresholds.len() {
                let middle = |other: Option<&f64>| other.map(|other| (here + other) / 2.0);
                let [before, after] = [i.checked_sub(1), Some(i + 1)]
                    .map(|at| middle(at.and_then(|at| thresholds.get(at))));
                let from = before.or(after.map(|end| 2.0 * here - end)).unwrap_or(here);
                let to = after.or(before.map(|end| 2.0 * here - end)).unwrap_or(here);
                let within = ((share - below) / p.max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
                return from + within * (to - from);
            }
            below += p;
        }
        f64::NAN
    }
}

fn check(rule: &QuestRule) -> Result<(), AdaptiveRuleError> {
    let wrong = |what, expected, found| {
        Err(AdaptiveRuleError {
            rule: "QUEST+",
            what,
            expected,
            found,
        })
    };
    let lists = [
        ("the number of levels", &rule.levels_db),
        ("the number of thresholds", &rule.thresholds_db),
        ("the number of slopes", &rule.slopes),
        ("the number of lapses", &rule.lapse_shares),
    ];
    for (what, list) in lists {
        if list.is_empty() {
            return wrong(what, "at least 1", 0.0);
        }
        if let Some(found) = list.iter().find(|one| !one.is_finite()) {
            return wrong("every value", "a finite number", *found);
        }
    }
    if let Some(found) = rule.slopes.iter().find(|slope| **slope <= 0.0) {
        return wrong("a slope", "positive", *found);
    }
    if !(0.0..1.0).contains(&rule.guess_share) {
        return wrong("`guess_share`", "from 0 to below 1", rule.guess_share);
    }
    let highest = 1.0 - rule.guess_share;
    if let Some(found) = rule
        .lapse_shares
        .iter()
        .find(|lapse| !(0.0..highest).contains(*lapse))
    {
        return wrong(
            "a share of lapses",
            "from 0 to below 1 − guess_share",
            *found,
        );
    }
    if rule.trials == 0 {
        return wrong("`trials`", "at least 1", 0.0);
    }
    let size = [
        rule.levels_db.len(),
        rule.thresholds_db.len(),
        rule.slopes.len(),
        rule.lapse_shares.len(),
    ];
    let cells = size.iter().try_fold(1_usize, |all, n| all.checked_mul(*n));
    match cells {
        Some(cells) if cells <= 20_000_000 => Ok(()),
        _ => wrong("the grid", "at most 20 million cells", f64::INFINITY),
    }
}

fn x_ln_x(x: f64) -> f64 {
    match x > 0.0 {
        true => x * x.ln(),
        false => 0.0,
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid(from: f64, to: f64, count: usize) -> Vec<f64> {
        (0..count)
            .map(|i| from + (to - from) * i as f64 / (count - 1) as f64)
            .collect()
    }

    fn rule() -> QuestRule {
        QuestRule {
            levels_db: grid(-40.0, 0.0, 41),
            thresholds_db: grid(-40.0, 0.0, 41),
            slopes: vec![3.5],
            guess_share: 0.5,
            lapse_shares: vec![0.02],
            trials: 32,
        }
    }

    #[test]
    fn the_weibull_function_has_its_known_values() {
        // At the threshold: 1 − λ − (1 − γ − λ)/e.
        let at = weibull(-20.0, -20.0, 3.5, 0.5, 0.02);
        assert!((at - (0.98 - 0.48 / std::f64::consts::E)).abs() < 1e-15);
        assert!((weibull(-400.0, -20.0, 3.5, 0.5, 0.02) - 0.5).abs() < 1e-12);
        assert!((weibull(60.0, -20.0, 3.5, 0.5, 0.02) - 0.98).abs() < 1e-12);
    }

    #[test]
    fn quantiles_are_those_of_the_posterior() {
        // Before any answer it is even, from half a step below the lowest threshold to half a step above the highest.
        let mut run = QuestPlus::new(rule()).unwrap();
        let [low, high] = run.estimate().threshold_interval_db;
        assert!(
            (low + 40.5 - 0.025 * 41.0).abs() < 1e-9 && (high - 0.5 + 0.025 * 41.0).abs() < 1e-9
        );
        // A wrong answer far up says little, right ones much: the posterior is skewed, and the interval is.
        for (level, response) in [
            (40, Response::Correct),
            (20, Response::Correct),
            (20, Response::Correct),
            (14, Response::Wrong),
        ] {
            run.answer(level, response);
        }
        let found = run.estimate();
        let [low, high] = found.threshold_interval_db;
        let share = |below: f64| -> f64 {
            let all = run.points.iter().zip(&run.posterior);
            all.map(|(point, p)| p * (below - point.threshold_db + 0.5).clamp(0.0, 1.0))
                .sum()
        };
        assert!((share(low) - 0.025).abs() < 1e-9 && (share(high) - 0.975).abs() < 1e-9);
        let middle = (low + high) / 2.0;
        assert!(
            (middle - found.threshold_db).abs() > 0.05,
            "{low} {high} {found:?}"
        );
    }

    #[test]
    fn watsons_first_level_is_chosen() {
        // The example of Watson 2017 (figure 3): the first level is −18 dB.
        let run = QuestPlus::new(rule()).unwrap();
        assert_eq!(run.rule.levels_db[run.next_level().unwrap()], -18.0);
    }

    #[test]
    fn the_expected_entropy_is_that_of_the_definition() {
        let mut run = QuestPlus::new(rule()).unwrap();
        run.answer(20, Response::Correct);
        run.answer(14, Response::Wrong);
        let entropy = |level: usize| -> f64 {
            [Response::Correct, Response::Wrong]
                .iter()
                .map(|response| {
                    let p: f64 = match response {
                        Response::Correct => dot(&run.posterior, &run.correct[level]),
                        Response::Wrong => 1.0 - dot(&run.posterior, &run.correct[level]),
                    };
                    let mut after = run.clone();
                    after.answer(level, *response);
                    p * -after.posterior.iter().map(|q| x_ln_x(*q)).sum::<f64>()
                })
                .sum()
        };
        let smallest = (0..41).min_by(|a, b| entropy(*a).total_cmp(&entropy(*b)));
        assert_eq!(run.next_level(), smallest);
    }

    #[test]
    fn a_threshold_outside_of_the_grid_is_seen_at_its_ends() {
        let mut run = QuestPlus::new(rule()).unwrap();
        while let Some(level) = run.next_level() {
            run.answer(level, Response::Wrong);
        }
        assert!(run.estimate().at_ends_share > 0.5, "{:?}", run.estimate());
        let mut within = QuestPlus::new(rule()).unwrap();
        while let Some(level) = within.next_level() {
            let response = match within.rule.levels_db[level] > -20.0 {
                true => Response::Correct,
                false => Response::Wrong,
            };
            within.answer(level, response);
        }
        assert!(
            within.estimate().at_ends_share < 1e-3,
            "{:?}",
            within.estimate()
        );
    }

    #[test]
    fn an_answer_that_no_point_explains_leaves_a_number() {
        let mut run = QuestPlus::new(QuestRule {
            thresholds_db: vec![-400.0],
            lapse_shares: vec![0.0],
            guess_share: 0.0,
            ..rule()
        })
        .unwrap();
        run.answer(40, Response::Wrong);
        run.answer(99, Response::Wrong);
        assert_eq!(run.estimate().threshold_db, -400.0);
    }

    #[test]
    fn impossible_rules_are_refused() {
        let says = |rule: QuestRule, part: &str| {
            let text = QuestPlus::new(rule).unwrap_err().to_string();
            assert!(text.contains(part), "{text}");
        };
        says(
            QuestRule {
                slopes: vec![],
                ..rule()
            },
            "the number of slopes must be at least 1",
        );
        says(
            QuestRule {
                slopes: vec![-1.0],
                ..rule()
            },
            "a slope must be positive",
        );
        says(
            QuestRule {
                guess_share: 1.0,
                ..rule()
            },
            "`guess_share`",
        );
        says(
            QuestRule {
                lapse_shares: vec![0.5],
                ..rule()
            },
            "a share of lapses",
        );
        says(
            QuestRule {
                levels_db: vec![f64::NAN],
                ..rule()
            },
            "finite",
        );
        says(
            QuestRule {
                trials: 0,
                ..rule()
            },
            "`trials`",
        );
        says(
            QuestRule {
                slopes: vec![1.0; 20_000],
                ..rule()
            },
            "20 million",
        );
    }
}
