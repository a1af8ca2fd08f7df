//! The interval of a cell, and what would narrow it.

use std::collections::BTreeMap;

use piezotact::criterion::{Criterion, Limit};

use super::super::description::{TaskDescription, TaskKind};
use super::super::error::DesignError;
use super::super::fault::{BetterPlan, Change, DesignCriterion, Fault};
use super::super::precision::{CellPlan, MOST_PRESENTED, cell_precision};
use super::presented::tests;
use super::report::SampleCount;
use super::{Work, fewest};

/// Simulated studies for the precision of a cell.
const STUDIES: usize = 1000;
/// The largest number of presentations that is looked for.
const MOST_PRESENTATIONS: usize = 60;

impl Work<'_> {
    /// Fault 7: the interval of a cell.
    pub(super) fn precision(&mut self, task: &TaskDescription) -> Result<(), DesignError> {
        let (TaskKind::Associate { sequence }, false) = (&task.task, self.blocks.is_empty()) else {
            return Ok(());
        };
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
        let Some((stimulus, presentations)) = fewest else {
            return Ok(());
        };
        let aims = self.campaign.aims;
        let plan = CellPlan {
            participants: self.campaign.participants,
            presentations: (presentations.round() as usize).max(1),
            share: aims.cell_share,
            logit_sd: aims.logit_sd,
        };
        let precision = cell_precision(&plan, STUDIES, self.seed)?;
        let sample = stimulus.to_owned();
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
        let more = of(fewest(plan.participants, reach, |n| wide(&of(n)))?);
        let mut better = self.plan(Change::Participants {
            participants: more.participants,
        });
        better.participants[1] = more.participants;
        Ok(Some(better))
    }
}
