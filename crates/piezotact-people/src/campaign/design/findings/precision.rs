//! The interval of a cell, and what would narrow it.

use std::collections::BTreeMap;

use piezotact::criterion::{Criterion, Limit};

use super::super::description::{CompareAim, Scoring, TaskDescription, TaskKind};
use super::super::error::DesignError;
use super::super::fault::{BetterPlan, Change, DesignCriterion, Fault};
use super::super::precision::{CellPlan, MOST_PRESENTED, cell_precision, rating_half_width};
use super::super::sequence::SequenceRule;
use super::presented::tests;
use super::report::{RatingPrecision, SampleCount};
use super::{Work, fewest};

/// Simulated studies for the precision of a cell.
const STUDIES: usize = 1000;
/// The largest number of presentations that is looked for.
const MOST_PRESENTATIONS: usize = 60;
/// The largest number of people that is looked for to rate.
const MOST_RATERS: usize = 10_000;

impl Work<'_> {
    /// Fault 7: the interval of a cell, of a mean rating, or the spread of thresholds.
    pub(super) fn precision(&mut self, task: &TaskDescription) -> Result<(), DesignError> {
        match &task.task {
            TaskKind::Rate { range, .. } => self.rating(task, *range),
            TaskKind::Compare {
                aim:
                    CompareAim::Threshold {
                        levels,
                        rule,
                        largest_sd,
                    },
                ..
            } => self.thresholds(task, (levels, rule), *largest_sd),
            _ => match self.rarest_cell(task)? {
                Some((sample, presentations)) => self.cell(task, sample, presentations),
                None => Ok(()),
            },
        }
    }

    /// What is presented least often to a participant, and its mean number of presentations; `None` of tasks without answers, and of
    /// orders that are scored by position.
    fn rarest_cell(&self, task: &TaskDescription) -> Result<Option<(String, f64)>, DesignError> {
        let all_alike = |what: &str, presentations| Ok(Some((what.to_owned(), presentations)));
        match &task.task {
            TaskKind::Associate { sequence } if !self.blocks.is_empty() => {
                self.rarest_stimulus(task, sequence)
            }
            TaskKind::IdentifyFromMemory if !self.blocks.is_empty() => {
                let sets = |place: usize| {
                    let with = self.blocks.iter().filter(|block| block.contains(&place));
                    with.count() as f64
                };
                let places = (0..self.campaign.samples.len()).map(|place| (place, sets(place)));
                let shown = places.filter(|(_, sets)| *sets > 0.0);
                let rarest = shown.min_by(|a, b| a.1.total_cmp(&b.1));
                let times = self.share() * task.repeats as f64;
                Ok(
                    rarest
                        .map(|(place, sets)| (self.campaign.samples[place].clone(), sets * times)),
                )
            }
            TaskKind::Compare {
                trials,
                aim: CompareAim::Shares { pairs },
                ..
            } => all_alike(
                "a pair",
                (trials * task.repeats) as f64 / (*pairs).max(1) as f64,
            ),
            TaskKind::Categorise { .. } => all_alike("a sample", task.repeats as f64),
            TaskKind::OrderAll { scoring, .. } | TaskKind::OrderSet { scoring }
                if *scoring == Scoring::ByPositionAndDominance =>
            {
                all_alike("a pair", task.repeats as f64)
            }
            _ => Ok(None),
        }
    }

    /// The stimulus of an association that is presented least often.
    fn rarest_stimulus(
        &self,
        task: &TaskDescription,
        sequence: &SequenceRule,
    ) -> Result<Option<(String, f64)>, DesignError> {
        let tests = tests(&self.campaign.sets, sequence, self.blocks)?;
        // A row of the matrix for each stimulus, also where two are made from one sample.
        let mut counts: BTreeMap<&str, f64> = BTreeMap::new();
        let times = self.share() * task.repeats as f64;
        for test in &tests {
            for stimulus in &test.stimuli {
                *counts.entry(stimulus).or_default() += times;
            }
            let samples = match test.stimuli.is_empty() {
                true => test.presentations.as_slice(),
                false => &[],
            };
            for (place, n) in samples.iter().enumerate().filter(|(_, n)| **n > 0.0) {
                let sample = &self.campaign.samples[self.blocks[test.set][place]];
                *counts.entry(sample).or_default() += n * times;
            }
        }
        // Of those presented as often, the first of the protocol.
        let samples = &self.campaign.samples;
        let place = |name: &str| samples.iter().position(|own| own == name);
        let key = |name| place(name).unwrap_or(samples.len());
        let fewest = counts
            .into_iter()
            .min_by(|a, b| (a.1.total_cmp(&b.1)).then_with(|| key(a.0).cmp(&key(b.0))));
        Ok(fewest.map(|(stimulus, presentations)| (stimulus.to_owned(), presentations)))
    }

    fn cell(
        &mut self,
        task: &TaskDescription,
        sample: String,
        presentations: f64,
    ) -> Result<(), DesignError> {
        let aims = self.campaign.aims;
        let plan = CellPlan {
            participants: self.campaign.participants,
            presentations: (presentations.round() as usize).max(1),
            share: aims.cell_share,
            logit_sd: aims.logit_sd,
        };
        let precision = cell_precision(&plan, STUDIES, self.seed)?;
        self.report.precision.push(SampleCount {
            task: task.name.clone(),
            sample: sample.clone(),
            presentations,
            precision,
        });
        let what = DesignCriterion::HalfWidth {
            task: task.name.clone(),
        };
        let limit = Limit::at_most(aims.half_width_share);
        let found = precision.half_width_share;
        let criterion = Criterion::new(what, "", found, Some(precision.interval), limit);
        self.judge(criterion, |work| {
            let fault = Fault::IntervalTooWide {
                task: task.name.clone(),
                sample,
                presentations: plan.presentations,
                half_width_share: found,
                wanted_share: aims.half_width_share,
            };
            Ok((fault, work.narrower(task, &plan)?))
        })
    }

    /// The interval of a mean rating.
    fn rating(&mut self, task: &TaskDescription, range: u64) -> Result<(), DesignError> {
        let (aims, participants) = (self.campaign.aims, self.campaign.participants);
        let of = |people| rating_half_width(people, range, aims.cell_share, aims.logit_sd);
        let half_width_share = of(participants)?;
        let task = task.name.clone();
        self.report.ratings.push(RatingPrecision {
            task: task.clone(),
            range,
            half_width_share,
        });
        let what = DesignCriterion::RatingHalfWidth { task: task.clone() };
        let wanted_share = aims.half_width_share;
        let limit = Limit::at_most(wanted_share);
        let criterion = Criterion::new(what, "", half_width_share, None, limit);
        self.judge(criterion, |work| {
            let wide = |people| Ok(of(people)? > wanted_share);
            let better = match wide(MOST_RATERS)? {
                true => None,
                false => {
                    let participants = fewest(participants, MOST_RATERS, wide)?;
                    Some(work.with_participants(participants))
                }
            };
            let fault = Fault::RatingTooWide {
                task,
                participants,
                half_width_share,
                wanted_share,
            };
            Ok((fault, better))
        })
    }

    /// More presentations where they suffice, else more participants.
    fn narrower(
        &self,
        task: &TaskDescription,
        plan: &CellPlan,
    ) -> Result<Option<BetterPlan>, DesignError> {
        let wide = |plan: &CellPlan| -> Result<bool, DesignError> {
            let found = cell_precision(plan, STUDIES, self.seed)?;
            Ok(found.interval[1] > self.campaign.aims.half_width_share)
        };
        // As many as can be simulated with so many participants.
        let in_reach = MOST_PRESENTATIONS.min(MOST_PRESENTED / plan.participants);
        let most = CellPlan {
            presentations: in_reach.max(plan.presentations),
            ..*plan
        };
        if !wide(&most)? {
            let of = |presentations| CellPlan {
                presentations,
                ..*plan
            };
            let presentations = fewest(plan.presentations, most.presentations, |n| wide(&of(n)))?;
            let mut better = self.plan(Change::Presentations { presentations });
            let now = self.report.time.iter().find(|time| time.task == task.name);
            let times = presentations as f64 / plan.presentations as f64;
            better.participant_s[1] += now.map_or(0.0, |time| time.time_s * (times - 1.0));
            return Ok(Some(better));
        }
        let of = |participants| CellPlan {
            participants,
            ..*plan
        };
        let reach = 400.min(MOST_PRESENTED / plan.presentations);
        let reach = reach.max(plan.participants);
        if wide(&of(reach))? {
            return Ok(None);
        }
        let participants = fewest(plan.participants, reach, |n| wide(&of(n)))?;
        Ok(Some(self.with_participants(participants)))
    }
}
