//! What a panel says, in sentences.

use super::{AverageRule, CellPenalties, FallsWithLoad, LearningCurve};
use crate::criterion::{Criterion, Outcome as Judged};
use crate::number::{p_text, signed};
use crate::statistics::Direction;

/// A share, 0–1, as a percentage.
fn percent(share: f64) -> String {
    format!("{:.0}\u{a0}%", share * 100.0)
}

impl CellPenalties {
    /// The share of people within the criterion, with its interval and how many would decide.
    ///
    /// Source: decision 0046 of this project.
    #[must_use]
    pub fn share_text(&self) -> String {
        let verdict = &self.verdict;
        let n = self.people.len();
        let within = (verdict.share_within * n as f64).round();
        let rule = verdict
            .criteria
            .iter()
            .find(|c| c.what == AverageRule::ShareWithin);
        let interval = match rule.and_then(|rule| rule.interval) {
            Some([low, high]) => format!(
                "95 %: {} to {} of people like them",
                percent(low),
                percent(high)
            ),
            None => "from too few people for an interval".into(),
        };
        format!("{within:.0} of {n} are ({interval})")
    }

    /// How many people would decide, where it is not decided.
    ///
    /// Source: decision 0046 of this project.
    #[must_use]
    pub fn needed_text(&self) -> Option<String> {
        let verdict = &self.verdict;
        let driven = |c: &&Criterion<AverageRule>| c.what == AverageRule::Driven;
        let driven = verdict.criteria.iter().find(driven).map(|c| c.outcome);
        match (verdict.outcome, verdict.people_needed) {
        (Judged::NotDecided, _) if driven != Some(Judged::Met) => {
            Some("Not everybody was driven over all of the band.".into())
        }
        (Judged::NotDecided, Some(needed)) => Some(format!(
            "If further people scatter as these {} do, {needed} would decide it.",
            self.people.len()
        )),
        (Judged::NotDecided, None) => Some(
            "Not even 300 people who scatter as these do would decide it: they lie too close to the criterion.".into(),
        ),
        _ => None,
    }
    }
}

impl LearningCurve {
    /// How many people are enough, with its interval.
    ///
    /// Source: decision 0046 of this project.
    #[must_use]
    pub fn enough_text(&self) -> String {
        let measured = self.points.len() + 1;
        let (Some(found), Some([low, high])) = (self.enough.found, self.enough.interval) else {
            return format!("how many people are enough is not decided from {measured}");
        };
        let range = format!("{found:.0} people (95 %: {low:.0} to {high:.0})");
        match self.enough.outcome {
            Judged::Met => format!("{range} are enough, {measured} were measured"),
            Judged::NotMet => format!("{range} are needed, {measured} were measured"),
            Judged::NotDecided => {
                format!("whether {measured} people are enough is not decided: it takes {range}")
            }
        }
    }
}

impl FallsWithLoad {
    /// Whether people lie closer together under load.
    ///
    /// Source: decision 0046 of this project.
    #[must_use]
    pub fn text(&self) -> String {
        let Some(p) = self.p_value else {
            return format!(
                "whether it changes with load is not decided from {} people",
                self.people
            );
        };
        let numbers = format!(
            "{} dB from the lightest to the heaviest load ({} over {} people)",
            signed(self.change_db, 1),
            p_text(p),
            self.people
        );
        match self.direction {
            Direction::Falls => format!("it falls with load: {numbers}"),
            Direction::Rises => format!("it rises with load: {numbers}"),
            Direction::NotShown => format!("no trend with load shown: {numbers}"),
        }
    }
}
