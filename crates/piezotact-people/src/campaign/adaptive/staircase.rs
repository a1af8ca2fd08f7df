//! Transformed up-down staircases.

use serde::{Deserialize, Serialize};

use super::{AdaptiveRuleError, Response};

/// How a staircase begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Start {
    /// One up, one down until the first reversal; it reaches the threshold sooner.
    OneUpOneDown,
    /// With its own rule from the first trial.
    OwnRule,
}

/// The rule of a staircase. Levels and steps have the same unit, which steps are added to: dB for levels of vibration.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct StaircaseRule {
    /// The first level.
    pub first: f64,
    /// The steps: the first until the first reversal, and so on; the last one is kept.
    pub steps: Vec<f64>,
    /// Correct answers in a row before the level falls.
    pub down: u32,
    /// Wrong answers in a row before the level rises.
    pub up: u32,
    /// How it begins.
    pub start: Start,
    /// The lowest level.
    pub lowest: f64,
    /// The highest level.
    pub highest: f64,
    /// It ends when it has this many reversals …
    pub reversals: u32,
    /// … and this many trials.
    pub trials: u32,
    /// How many of the first reversals the estimate leaves out.
    pub left_out: u32,
}

/// What a staircase says about the threshold.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct StaircaseEstimate {
    /// The mean level at the reversals that count.
    pub level: f64,
    /// The standard deviation of these levels. They are not independent: it is no standard error.
    pub reversals_sd: f64,
    /// How many reversals count; an even number, so that peaks and valleys balance.
    pub reversals: usize,
    /// The share of correct answers that the rule converges to, where it has a closed form.
    pub converges_to_share: Option<f64>,
    /// How many trials were at the lowest or the highest level because the rule asked for more: the threshold may lie
    /// outside.
    pub clamped: u32,
}

/// A staircase under way.
#[derive(Clone, Debug, PartialEq)]
pub struct Staircase {
    rule: StaircaseRule,
    level: f64,
    /// Answers of the same kind in a row since the last step: positive for correct ones.
    in_a_row: i64,
    last: Option<Response>,
    rising: Option<Rising>,
    reversals: Vec<f64>,
    trials: u32,
    clamped: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Rising {
    Up,
    Down,
}

impl Staircase {
    /// A staircase at its first level.
    ///
    /// # Errors
    /// [`AdaptiveRuleError`].
    pub fn new(rule: StaircaseRule) -> Result<Self, AdaptiveRuleError> {
        let number = |what, expected, found| AdaptiveRuleError {
            rule: "staircase",
            what,
            expected,
            found,
        };
        let finite = [rule.first, rule.lowest, rule.highest];
        if let Some(found) = finite.iter().find(|level| !level.is_finite()) {
            return Err(number("a level", "a finite number", *found));
        }
        if rule.lowest >= rule.highest {
            return Err(number("`highest`", "above `lowest`", rule.highest));
        }
        if !(rule.lowest..=rule.highest).contains(&rule.first) {
            return Err(number(
                "`first`",
                "between `lowest` and `highest`",
                rule.first,
            ));
        }
        if rule.steps.is_empty() {
            return Err(number("the number of steps", "at least 1", 0.0));
        }
        if let Some(found) = rule
            .steps
            .iter()
            .find(|step| !(**step > 0.0 && step.is_finite()))
        {
            return Err(number("a step", "positive", *found));
        }
        for (what, count) in [
            ("`down`", rule.down),
            ("`up`", rule.up),
            ("`reversals`", rule.reversals),
        ] {
            if count == 0 {
                return Err(number(what, "at least 1", 0.0));
            }
        }
        if rule.reversals < rule.left_out.saturating_add(2) {
            return Err(number(
                "`reversals`",
                "at least 2 more than `left_out`",
                f64::from(rule.reversals),
            ));
        }
        Ok(Self {
            level: rule.first,
            rule,
            in_a_row: 0,
            last: None,
            rising: None,
            reversals: Vec::new(),
            trials: 0,
            clamped: 0,
        })
    }

    /// The level of the next trial; `None` when the staircase has ended.
    #[must_use]
    pub fn next_level(&self) -> Option<f64> {
        let enough =
            self.reversals.len() >= self.rule.reversals as usize && self.trials >= self.rule.trials;
        (!enough).then_some(self.level)
    }

    /// Takes up the answer to the trial at the level of [`Self::next_level`].
    ///
    /// Source: Levitt 1971, JASA 49:467.
    pub fn answer(&mut self, response: Response) {
        self.trials += 1;
        let sign = match response {
            Response::Correct => 1,
            Response::Wrong => -1,
        };
        self.in_a_row = match self.last == Some(response) {
            true => self.in_a_row + sign,
            false => sign,
        };
        self.last = Some(response);
        let beginning = self.reversals.is_empty() && self.rule.start == Start::OneUpOneDown;
        let (down, up) = match beginning {
            true => (1, 1),
            false => (i64::from(self.rule.down), i64::from(self.rule.up)),
        };
        let turn = match self.in_a_row {
            n if n >= down => Rising::Down,
            n if n <= -up => Rising::Up,
            _ => return,
        };
        if self.rising.is_some_and(|before| before != turn) {
            self.reversals.push(self.level);
        }
        self.rising = Some(turn);
        self.step(turn);
    }

    /// Takes up the answer to a trial at `level_db`, in the unit of the rule, whatever level would be next: for answers that were
    /// corrected after the levels that followed them had been presented.
    pub fn answer_at(&mut self, level_db: f64, response: Response) {
        self.level = level_db;
        self.answer(response);
    }

    /// How many trials were at the lowest or the highest level because the rule asked for more.
    #[must_use]
    pub fn clamped(&self) -> u32 {
        self.clamped
    }

    fn step(&mut self, turn: Rising) {
        let steps = &self.rule.steps;
        let step = steps[self.reversals.len().min(steps.len() - 1)];
        let wanted = match turn {
            Rising::Up => self.level + step,
            Rising::Down => self.level - step,
        };
        self.level = wanted.clamp(self.rule.lowest, self.rule.highest);
        self.clamped += u32::from(self.level != wanted);
        self.in_a_row = 0;
    }

    /// The levels at the reversals so far.
    #[must_use]
    pub fn reversals(&self) -> &[f64] {
        &self.reversals
    }

    /// The estimate, when at least two reversals count.
    #[must_use]
    pub fn estimate(&self) -> Option<StaircaseEstimate> {
        let counted = self.reversals.get(self.rule.left_out as usize..)?;
        let counted = &counted[counted.len() % 2..];
        if counted.is_empty() {
            return None;
        }
        let count = counted.len() as f64;
        let level = counted.iter().sum::<f64>() / count;
        let squares: f64 = counted.iter().map(|one| (one - level).powi(2)).sum();
        Some(StaircaseEstimate {
            level,
            reversals_sd: (squares / (count - 1.0)).sqrt(),
            reversals: counted.len(),
            converges_to_share: (self.rule.up == 1)
                .then(|| 0.5_f64.powf(1.0 / f64::from(self.rule.down))),
            clamped: self.clamped,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rule() -> StaircaseRule {
        StaircaseRule {
            first: 20.0,
            steps: vec![4.0, 2.0, 1.0],
            down: 3,
            up: 1,
            start: Start::OneUpOneDown,
            lowest: -20.0,
            highest: 40.0,
            reversals: 8,
            trials: 0,
            left_out: 2,
        }
    }

    fn levels(rule: StaircaseRule, answers: &str) -> (Vec<f64>, Staircase) {
        let mut staircase = Staircase::new(rule).unwrap();
        let mut levels = Vec::new();
        for sign in answers.chars() {
            levels.push(staircase.next_level().unwrap());
            staircase.answer(match sign {
                '+' => Response::Correct,
                _ => Response::Wrong,
            });
        }
        (levels, staircase)
    }

    #[test]
    fn levels_follow_the_rule_by_hand() {
        let (seen, staircase) = levels(rule(), "+++-+++-");
        // Down by 4 each until the first wrong answer, then 3-down-1-up with a step of 2, then 1.
        assert_eq!(seen, [20.0, 16.0, 12.0, 8.0, 10.0, 10.0, 10.0, 9.0]);
        assert_eq!(staircase.reversals(), [8.0, 10.0, 9.0]);
        assert_eq!(
            staircase.estimate(),
            None,
            "one reversal counts, and that is no pair"
        );
    }

    #[test]
    fn own_rule_from_the_first_trial_waits_for_three() {
        let (seen, _) = levels(
            StaircaseRule {
                start: Start::OwnRule,
                ..rule()
            },
            "+++-",
        );
        assert_eq!(seen, [20.0, 20.0, 20.0, 16.0]);
    }

    #[test]
    fn limits_hold_and_are_said() {
        let (seen, staircase) = levels(
            StaircaseRule {
                lowest: 15.0,
                ..rule()
            },
            "+++",
        );
        assert_eq!(seen, [20.0, 16.0, 15.0]);
        assert_eq!(staircase.clamped, 2);
    }

    #[test]
    fn impossible_rules_are_refused() {
        let says = |rule: StaircaseRule, part: &str| {
            let text = Staircase::new(rule).unwrap_err().to_string();
            assert!(text.contains(part), "{text}");
        };
        says(
            StaircaseRule {
                steps: vec![],
                ..rule()
            },
            "steps must be at least 1",
        );
        says(
            StaircaseRule {
                steps: vec![0.0],
                ..rule()
            },
            "a step must be positive",
        );
        says(
            StaircaseRule { down: 0, ..rule() },
            "`down` must be at least 1",
        );
        says(
            StaircaseRule {
                first: 41.0,
                ..rule()
            },
            "between `lowest` and `highest`",
        );
        says(
            StaircaseRule {
                lowest: f64::NAN,
                ..rule()
            },
            "finite",
        );
        says(
            StaircaseRule {
                highest: -30.0,
                ..rule()
            },
            "above `lowest`",
        );
        says(
            StaircaseRule {
                left_out: 7,
                ..rule()
            },
            "at least 2 more than `left_out`",
        );
    }
}
