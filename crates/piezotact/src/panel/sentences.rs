//! What a panel says, in sentences.

use super::{
    AverageCriterion, Cell, CellPenalties, FallsWithLoad, LearningCurve, WorstCase, WorstCriterion,
};
use crate::criterion::Outcome as Judged;
use crate::number::{p_text, signed};
use crate::statistics::Direction;

/// A share, 0–1, as a percentage.
pub(super) fn percent(share: f64) -> String {
    format!("{:.0}\u{a0}%", share * 100.0)
}

impl CellPenalties {
    /// Whether the average is sufficient at `cell` for a new person; where that is not decided, what leaves it open and what would
    /// decide it.
    ///
    /// Source: docs/decisions/documents.md.
    #[must_use]
    pub fn conclusion(&self, cell: Cell) -> String {
        let least = percent(self.verdict.criterion.least_share);
        let answer = match self.verdict.outcome {
            Judged::NotDecided => {
                let open = self.open_text();
                return format!(
                    "Whether the average is sufficient at {cell} is not decided: {open}."
                );
            }
            Judged::Met => "is",
            Judged::NotMet => "is not",
        };
        format!(
            "The average {answer} sufficient at {cell}: {}; at least {least} of the population is required.",
            self.share_text()
        )
    }

    /// The share of people within the criterion, with its interval.
    fn share_text(&self) -> String {
        let n = self.people.len();
        let within = (self.verdict.share_within * n as f64).round();
        let rule = self.criterion(AverageCriterion::ShareWithin);
        let interval = match rule.and_then(|rule| rule.interval) {
            Some([low, high]) => format!(
                "95 %: {} to {} of the population",
                percent(low),
                percent(high)
            ),
            None => "too few participants for an interval".into(),
        };
        let limit_db = self.verdict.criterion.db_rms;
        format!(
            "the error is within {limit_db} dB rms for {within:.0} of {n} participants ({interval})"
        )
    }

    /// What leaves the verdict open, and what would decide it.
    fn open_text(&self) -> String {
        let open = self.verdict.criteria.iter();
        let open: Vec<AverageCriterion> = open
            .filter(|rule| rule.outcome == Judged::NotDecided)
            .map(|rule| rule.what)
            .collect();
        let reasons = open.iter().map(|what| match what {
            AverageCriterion::ShareWithin => format!(
                "{}, and at least {} of the population is required",
                self.share_text(),
                percent(self.verdict.criterion.least_share)
            ),
            AverageCriterion::Excited => {
                "not every participant was measured with a drive over the whole band".into()
            }
            AverageCriterion::Distinct => "participants in it may be one person".into(),
        });
        let reasons: Vec<String> = reasons.collect();
        let decides = match self.verdict.people_needed {
            _ if open.contains(&AverageCriterion::Excited) => {
                "Measure them again with a drive over the whole band".into()
            }
            _ if open.contains(&AverageCriterion::Distinct) => {
                "Remove who is there twice".into()
            }
            Some(needed) => format!(
                "With the same scatter as these {} participants, it takes at least {needed} participants to decide it",
                self.people.len()
            ),
            None => "With the same scatter, even 300 participants would not decide it: the values are too close to the criterion".into(),
        };
        format!("{}. {decides}", reasons.join("; "))
    }
}

impl WorstCase {
    /// Where people lie furthest apart; where that is not decided, what leaves it open and what would decide it.
    ///
    /// Source: docs/decisions/documents.md.
    #[must_use]
    pub fn conclusion(&self) -> String {
        let cell = self.cell;
        let found = format!("{:.1} dB at {:.0} Hz", self.max_deviation_db, self.at_hz);
        let Some((next, next_db)) = self.ranking.get(1) else {
            return format!(
                "The largest difference between participants is {found}, at {cell}, the only load and angle."
            );
        };
        let agreement = self.share.map(|share| {
            format!(
                "It has the largest deviation in {} of {} random halves of these {} participants",
                percent(share),
                self.resamples,
                self.people
            )
        });
        let measured = format!("{found}; next is {next} with {next_db:.1} dB");
        if self.outcome() == Judged::Met {
            let agreement = agreement.unwrap_or_default();
            return format!("Participants differ most at {cell}: {measured}. {agreement}.");
        }
        let open = self.criteria().into_iter();
        let open = open.filter(|rule| rule.outcome != Judged::Met);
        let deciding: Vec<String> = open
            .map(|rule| {
                let least = rule.limit.value();
                match rule.what {
                    WorstCriterion::People => {
                        format!("at least {least} participants measured at every load and angle")
                    }
                    WorstCriterion::Agreement => {
                        format!("agreement of at least {} of the halves", percent(least))
                    }
                }
            })
            .collect();
        let agreement = agreement.unwrap_or_else(|| {
            format!("{} participants are too few for random halves", self.people)
        });
        format!(
            "At which load and angle participants differ most is not decided; the largest measured deviation is at {cell}: {measured}. \
             {agreement}. It would be decided by {}.",
            deciding.join(" and ")
        )
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

#[cfg(test)]
mod tests {
    use super::super::{Criterion as Limits, ParticipantPenalty, Verdict};
    use super::*;
    use crate::criterion::{Criterion, Limit};
    use crate::quantity::{Degrees, Newtons};
    use crate::transfer::BundleAverage;

    fn cell(load_n: f64) -> Cell {
        Cell {
            load_n: Newtons(load_n),
            angle_deg: Degrees(20.0),
        }
    }

    /// All random halves agree, and all participants are within the limit: what is open is said, and what would decide it.
    #[test]
    fn what_is_not_decided_at_100_percent_says_why() {
        let worst = WorstCase {
            cell: cell(0.2),
            max_deviation_db: 5.1,
            at_hz: 95.0,
            ranking: vec![(cell(0.2), 5.1), (cell(0.6), 4.0)],
            people: 4,
            share: Some(1.0),
            resamples: 1000,
        };
        assert_eq!(
            worst.conclusion().replace('\u{a0}', " "),
            "At which load and angle participants differ most is not decided; the largest measured deviation is at 20°, 0.2 N: 5.1 dB at \
             95 Hz; next is 20°, 0.6 N with 4.0 dB. It has the largest deviation in 100 % of 1000 random halves of these 4 \
             participants. It would be decided by at least 6 participants measured at every load and angle."
        );
        let enough = WorstCase { people: 6, ..worst };
        assert_eq!(enough.outcome(), Judged::Met);
        let apart = WorstCase {
            share: Some(0.9),
            ..enough
        };
        let open = apart.conclusion().replace('\u{a0}', " ");
        assert!(
            open.ends_with("It would be decided by agreement of at least 95 % of the halves."),
            "{open}"
        );

        let one = ParticipantPenalty {
            participant: "P01".into(),
            db_rms: 1.0,
            db_max: 2.0,
        };
        let limits = Limits::thesis_2024();
        let costs = CellPenalties {
            averaging: BundleAverage::LogMagnitude,
            people: vec![one.clone(); 5],
            mean_db_rms: 1.0,
            new_person_db_rms: Some([0.2, 2.5]),
            mean_db_max: 2.0,
            worst: one,
            verdict: Verdict {
                outcome: Judged::NotDecided,
                criterion: limits,
                share_within: 1.0,
                criteria: vec![Criterion::new(
                    AverageCriterion::ShareWithin,
                    "",
                    1.0,
                    Some([0.48, 1.0]),
                    Limit::at_least(limits.least_share),
                )],
                people_needed: Some(36),
            },
        };
        assert_eq!(
            costs.conclusion(cell(0.2)).replace('\u{a0}', " "),
            "Whether the average is sufficient at 20°, 0.2 N is not decided: the error is within 3 dB rms for 5 of 5 participants (95 %: 48 % \
             to 100 % of the population), and at least 90 % of the population is required. With the same scatter as these 5 participants, \
             it takes at least 36 participants to decide it."
        );
    }
}
