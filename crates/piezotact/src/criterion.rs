//! Criteria as data: the quantity judged, the value found, the limit, and the outcome.
//!
//! A verdict is a list of these. Its text and every report read the list and add nothing.

use std::fmt;

use serde::{Deserialize, Serialize};

/// Whether a criterion is met.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Outcome {
    /// The whole confidence interval lies within the limit.
    Met,
    /// The whole confidence interval lies beyond the limit.
    NotMet,
    /// The confidence interval contains the limit, or nothing was measured.
    NotDecided,
}

impl Outcome {
    /// The outcome in plain words: "met", "not met" or "not decided".
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Met => "met",
            Self::NotMet => "not met",
            Self::NotDecided => "not decided",
        }
    }

    /// The outcome as the answer to a question: "yes", "no" or "not decided".
    #[must_use]
    pub fn answer(self) -> &'static str {
        match self {
            Self::Met => "yes",
            Self::NotMet => "no",
            Self::NotDecided => "not decided",
        }
    }

    /// The outcome of several together: not met when one is not met, else not decided when one is not decided, else met.
    #[must_use]
    pub fn of_all(outcomes: impl IntoIterator<Item = Self>) -> Self {
        let mut all = Self::Met;
        for outcome in outcomes {
            all = match (all, outcome) {
                (Self::NotMet, _) | (_, Self::NotMet) => Self::NotMet,
                (Self::NotDecided, _) | (_, Self::NotDecided) => Self::NotDecided,
                _ => Self::Met,
            };
        }
        all
    }
}

/// A limit. Where sources disagree about it, it has a range in which nothing is decided.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(tag = "is", rename_all = "snake_case")]
pub enum Limit {
    /// Up to `met` it is met, above `not_met` it is not; `met` ≤ `not_met`.
    AtMost {
        /// Met up to here.
        met: f64,
        /// Not met above this.
        not_met: f64,
    },
    /// From `met` on it is met, below `not_met` it is not; `not_met` ≤ `met`.
    AtLeast {
        /// Met from here on.
        met: f64,
        /// Not met below this.
        not_met: f64,
    },
    /// Met up to `reach` on either side of zero, not met beyond.
    Within {
        /// The largest size.
        reach: f64,
    },
}

impl Limit {
    /// Met up to `value`, not met above.
    #[must_use]
    pub fn at_most(value: f64) -> Self {
        Self::AtMost {
            met: value,
            not_met: value,
        }
    }

    /// Met from `value` on, not met below.
    #[must_use]
    pub fn at_least(value: f64) -> Self {
        Self::AtLeast {
            met: value,
            not_met: value,
        }
    }

    /// The value up to or from which it is met.
    #[must_use]
    pub fn value(self) -> f64 {
        match self {
            Self::AtMost { met, .. } | Self::AtLeast { met, .. } => met,
            Self::Within { reach } => reach,
        }
    }

    /// The value from which on it is not met: [`Self::value`] where sources agree.
    #[must_use]
    pub fn not_met_from(self) -> f64 {
        match self {
            Self::AtMost { not_met, .. } | Self::AtLeast { not_met, .. } => not_met,
            Self::Within { reach } => reach,
        }
    }

    /// Whether it is met by every value, by none or by some of `interval`, [lowest, highest].
    #[must_use]
    pub fn judge(self, interval: [f64; 2]) -> Outcome {
        let [low, high] = interval;
        if low.is_nan() || high.is_nan() {
            return Outcome::NotDecided;
        }
        let (met, not_met) = match self {
            Self::AtMost { met, not_met } => (high <= met, low > not_met),
            Self::AtLeast { met, not_met } => (low >= met, high < not_met),
            Self::Within { reach } => {
                (low >= -reach && high <= reach, high < -reach || low > reach)
            }
        };
        match (met, not_met) {
            (true, _) => Outcome::Met,
            (_, true) => Outcome::NotMet,
            _ => Outcome::NotDecided,
        }
    }
}

/// One criterion and its outcome. `W` names the quantity judged.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Criterion<W> {
    /// The quantity judged.
    pub what: W,
    /// The unit of `found`, of its interval and of the limit; empty for a pure number.
    pub unit: String,
    /// What was found; absent when it could not be measured.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub found: Option<f64>,
    /// The 95 % confidence interval of `found`; absent if unknown.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub interval: Option<[f64; 2]>,
    /// The limit.
    pub limit: Limit,
    /// Whether it is met.
    pub outcome: Outcome,
}

impl<W> Criterion<W> {
    /// The same rule, called `what`.
    #[must_use]
    pub fn called<V>(self, what: V) -> Criterion<V> {
        Criterion {
            what,
            unit: self.unit,
            found: self.found,
            interval: self.interval,
            limit: self.limit,
            outcome: self.outcome,
        }
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::AtMost { met, not_met } if met == not_met => write!(f, "at most {met:.4}"),
            Self::AtMost { met, not_met } => {
                write!(f, "at most {met:.4}, not decided up to {not_met:.4}")
            }
            Self::AtLeast { met, not_met } if met == not_met => write!(f, "at least {met:.4}"),
            Self::AtLeast { met, not_met } => {
                write!(f, "at least {met:.4}, not decided down to {not_met:.4}")
            }
            Self::Within { reach } => write!(f, "within ±{reach:.4}"),
        }
    }
}

/// What was found, the limit and the outcome: `steady part 0.1200 s, at least 0.3000: not met`.
impl<W: fmt::Display> fmt::Display for Criterion<W> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            what, unit, limit, ..
        } = self;
        let outcome = self.outcome.word();
        let space = if unit.is_empty() { "" } else { " " };
        match self.found {
            Some(found) => write!(f, "{what} {found:.4}{space}{unit}, {limit}: {outcome}"),
            None => write!(f, "{what} not measured, {limit}: {outcome}"),
        }
    }
}

impl<W> Criterion<W> {
    /// A criterion on `found_value`, which lies within `interval` with 95 % confidence, or is exact where that is `None`.
    ///
    /// ```
    /// use piezotact::criterion::{Criterion, Limit, Outcome};
    /// let of = |interval| Criterion::new("level", "dB", 0.8, Some(interval), Limit::at_most(1.0)).outcome;
    /// assert_eq!(of([0.7, 0.9]), Outcome::Met);
    /// assert_eq!(of([0.6, 1.1]), Outcome::NotDecided);
    /// ```
    #[must_use]
    pub fn new(
        what: W,
        unit: &str,
        found_value: f64,
        interval: Option<[f64; 2]>,
        limit: Limit,
    ) -> Self {
        Self {
            what,
            unit: unit.into(),
            found: Some(found_value),
            interval,
            limit,
            outcome: limit.judge(interval.unwrap_or([found_value, found_value])),
        }
    }

    /// A criterion on something that could not be measured: not decided.
    #[must_use]
    pub fn unmeasured(what: W, unit: &str, limit: Limit) -> Self {
        Self {
            what,
            unit: unit.into(),
            found: None,
            interval: None,
            limit,
            outcome: Outcome::NotDecided,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_is_met_only_by_all_that_the_data_allow() {
        let jnd = Limit::AtMost {
            met: 1.58,
            not_met: 2.5,
        };
        for (interval, outcome) in [
            ([0.0, 1.5], Outcome::Met),
            ([1.0, 1.6], Outcome::NotDecided),
            ([1.7, 2.2], Outcome::NotDecided),
            ([2.4, 2.6], Outcome::NotDecided),
            ([2.6, 9.0], Outcome::NotMet),
            ([f64::NAN, 9.0], Outcome::NotDecided),
        ] {
            assert_eq!(jnd.judge(interval), outcome, "{interval:?}");
        }
        assert_eq!(Limit::at_least(0.95).judge([0.9, 0.94]), Outcome::NotMet);
        assert_eq!(Limit::at_least(0.95).judge([0.95, 0.97]), Outcome::Met);
    }

    #[test]
    fn one_that_is_not_met_decides_for_all() {
        use Outcome::{Met, NotDecided, NotMet};
        assert_eq!(Outcome::of_all([Met, NotDecided, NotMet]), NotMet);
        assert_eq!(Outcome::of_all([Met, NotDecided]), NotDecided);
        assert_eq!(Outcome::of_all([Met, Met]), Met);
    }
}
