//! What a panel says, in sentences.

use super::{AverageCriterion, CellPenalties, FallsWithLoad, LearningCurve};
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
    /// Source: docs/decisions/documents.md.
    #[must_use]
    pub fn share_text(&self) -> String {
        let verdict = &self.verdict;
        let n = self.people.len();
        let within = (verdict.share_within * n as f64).round();
        let rule = verdict
            .criteria
            .iter()
            .find(|c| c.what == AverageCriterion::ShareWithin);
        let interval = match rule.and_then(|rule| rule.interval) {
            Some([low, high]) => format!(
                "95 %: {} to {} of the population",
                percent(low),
                percent(high)
            ),
            None => "too few participants for an interval".into(),
        };
        format!("{within:.0} of {n} participants are within the limit ({interval})")
    }

    /// How many people would decide, where it is not decided.
    ///
    /// Source: docs/decisions/documents.md.
    #[must_use]
    pub fn needed_text(&self) -> Option<String> {
        let verdict = &self.verdict;
        let excited = |c: &&Criterion<AverageCriterion>| c.what == AverageCriterion::Excited;
        let excited = verdict.criteria.iter().find(excited).map(|c| c.outcome);
        match (verdict.outcome, verdict.people_needed) {
        (Judged::NotDecided, _) if excited != Some(Judged::Met) => {
            Some("Not every participant was measured with a drive over the whole band.".into())
        }
        (Judged::NotDecided, Some(needed)) => Some(format!(
            "With the same scatter as these {} participants, {needed} participants would decide it.",
            self.people.len()
        )),
        (Judged::NotDecided, None) => Some(
            "With the same scatter, even 300 participants would not decide it: the values are too close to the criterion.".into(),
        ),
        _ => None,
    }
    }
}

impl LearningCurve {
    /// How many people are enough, with its interval.
    ///
    /// Source: docs/decisions/documents.md.
    #[must_use]
    pub fn enough_text(&self) -> String {
        let measured = self.points.len() + 1;
        let (Some(found), Some([low, high])) = (self.enough.found, self.enough.interval) else {
            return format!("the number of participants needed cannot be decided from {measured}");
        };
        let range = format!("{found:.0} participants (95 %: {low:.0} to {high:.0})");
        match self.enough.outcome {
            Judged::Met => format!("{range} are enough, {measured} were measured"),
            Judged::NotMet => format!("{range} are needed, {measured} were measured"),
            Judged::NotDecided => {
                format!(
                    "whether {measured} participants are enough is not decided: the number needed is {range}"
                )
            }
        }
    }
}

impl FallsWithLoad {
    /// Whether people lie closer together under load.
    ///
    /// Source: docs/decisions/documents.md.
    #[must_use]
    pub fn text(&self) -> String {
        let Some(p) = self.p_value else {
            return format!(
                "whether it changes with load cannot be decided from {} participants",
                self.people
            );
        };
        let numbers = format!(
            "{} dB from the lightest to the heaviest load ({} over {} participants)",
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
