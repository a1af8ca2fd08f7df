//! What a design can show, found before the first volunteer.

mod answers;
mod check;
mod compared;
mod met;
mod pairs;
mod power;
mod precision;
mod presented;
mod report;
mod threshold;

use piezotact::criterion::{Criterion, Outcome};

pub use power::{PowerPoint, PowerQuestion, PowerStudy, power_study};
pub use report::{
    ComparisonPower, DesignReport, RatingPrecision, SampleCount, TaskChance, TaskTime,
    ThresholdShare,
};

use super::coverage::PairCoverage;
use super::description::{CampaignDescription, TaskDescription, TaskKind};
use super::error::DesignError;
use super::fault::{BetterPlan, Change, DesignCriterion, Fault, FoundFault};
use super::sets::indexed;
use check::{check_numbers, check_pairs};
use presented::tests;

/// The check of `campaign`: chance by task, pairs never together, dependence of answers, seconds of one participant, precision
/// and power for the planned number of people, and the faults that these show. `seed` serves simulations and searches.
///
/// # Errors
///
/// Unknown or repeated samples, sets that do not fit the tray, impossible sequences, unknown tasks, numbers out of range.
///
/// Source: docs/decisions/campaigns.md.
pub fn design_findings(
    campaign: &CampaignDescription,
    seed: u64,
) -> Result<DesignReport, DesignError> {
    let sets = checked_sets(campaign)?;
    let mut work = Work::new(campaign, &sets, seed);
    for task in &campaign.tasks {
        work.time(task)?;
    }
    work.report.participant_s = work.report.time.iter().map(|task| task.time_s).sum();
    work.pairs()?;
    for task in &campaign.tasks {
        work.chance(task)?;
        work.positions(task)?;
        work.precision(task)?;
    }
    for comparison in &campaign.comparisons {
        work.order(comparison)?;
        work.power(comparison)?;
    }
    work.crossing()?;
    Ok(work.report)
}

/// The mean trials and the seconds of each task of `campaign`, for one participant; in the order of its tasks.
///
/// # Errors
///
/// As [`design_findings`].
///
/// Source: docs/decisions/campaigns.md.
pub fn task_times(campaign: &CampaignDescription) -> Result<Vec<TaskTime>, DesignError> {
    let sets = checked_sets(campaign)?;
    let mut work = Work::new(campaign, &sets, 0);
    for task in &campaign.tasks {
        work.time(task)?;
    }
    Ok(work.report.time)
}

/// The sets of a campaign whose numbers are in their ranges, as indices of samples; none where it has none.
fn checked_sets(campaign: &CampaignDescription) -> Result<Vec<Vec<usize>>, DesignError> {
    check_numbers(campaign)?;
    check_pairs(campaign)?;
    match campaign.sets.is_empty() {
        true => Ok(Vec::new()),
        false => indexed(&campaign.samples, &campaign.sets, campaign.tray),
    }
}

struct Work<'a> {
    campaign: &'a CampaignDescription,
    seed: u64,
    blocks: &'a [Vec<usize>],
    report: DesignReport,
}

impl<'a> Work<'a> {
    fn new(campaign: &'a CampaignDescription, blocks: &'a [Vec<usize>], seed: u64) -> Self {
        let report = DesignReport {
            name: campaign.name.clone(),
            samples: campaign.samples.clone(),
            coverage: (!blocks.is_empty())
                .then(|| PairCoverage::of(campaign.samples.len(), blocks)),
            never: Vec::new(),
            chance: Vec::new(),
            time: Vec::new(),
            participant_s: 0.0,
            crossing: None,
            power: Vec::new(),
            precision: Vec::new(),
            ratings: Vec::new(),
            thresholds: Vec::new(),
            criteria: Vec::new(),
            faults: Vec::new(),
            seed,
        };
        Self {
            campaign,
            seed,
            blocks,
            report,
        }
    }
}

impl Work<'_> {
    /// Files a criterion, with its fault where it is not met.
    fn judge(
        &mut self,
        criterion: Criterion<DesignCriterion>,
        found: impl FnOnce(&Self) -> Result<(Fault, Option<BetterPlan>), DesignError>,
    ) -> Result<(), DesignError> {
        self.report.criteria.push(criterion.clone());
        if criterion.outcome == Outcome::NotMet {
            let (fault, better) = found(self)?;
            self.report.faults.push(FoundFault {
                fault,
                criterion,
                better,
            });
        }
        Ok(())
    }

    fn share(&self) -> f64 {
        1.0 / self.campaign.sets_shared_over as f64
    }

    /// Sets of one participant.
    fn sets_each(&self) -> usize {
        self.blocks.len().div_ceil(self.campaign.sets_shared_over)
    }

    /// The same cost as now, with a change.
    fn plan(&self, change: Change) -> BetterPlan {
        BetterPlan {
            change,
            sets: [self.sets_each(); 2],
            participant_s: [self.report.participant_s; 2],
            participants: [self.campaign.participants; 2],
            sets_shared_by_two: None,
            participant_shared_by_two_s: None,
        }
    }

    /// As now, with another number of participants.
    fn with_participants(&self, participants: usize) -> BetterPlan {
        let mut better = self.plan(Change::Participants { participants });
        better.participants[1] = participants;
        better
    }

    /// Mean trials of a task, of one participant.
    fn trials(&self, task: &TaskDescription) -> Result<f64, DesignError> {
        let sizes = || self.blocks.iter().map(Vec::len);
        if task.task.uses_sets() && self.blocks.is_empty() {
            return Err(DesignError::NoSets);
        }
        let once = match &task.task {
            TaskKind::OrderAll { .. } => 1.0,
            TaskKind::OrderSet { .. } => self.blocks.len() as f64 * self.share(),
            TaskKind::IdentifyFromMemory => sizes().sum::<usize>() as f64 * self.share(),
            TaskKind::Associate { sequence } => {
                let tests = tests(&self.campaign.sets, sequence, self.blocks)?;
                tests.iter().map(|test| test.mean_length).sum::<f64>() * self.share()
            }
            TaskKind::Compare { trials, .. }
            | TaskKind::Categorise { trials, .. }
            | TaskKind::Touch { trials }
            | TaskKind::Rate { trials, .. } => *trials as f64,
        };
        Ok(once * task.repeats as f64)
    }

    fn time(&mut self, task: &TaskDescription) -> Result<(), DesignError> {
        let trials = self.trials(task)?;
        let all = trials + task.uncounted_trials;
        self.report.time.push(TaskTime {
            task: task.name.clone(),
            trials,
            uncounted: task.uncounted_trials,
            time_s: all * task.seconds_per_trial,
            played_s: all * task.played_s,
        });
        Ok(())
    }

    /// Seconds of one participant that every set takes, and those that none takes.
    fn time_of_sets_s(&self) -> (f64, f64) {
        let (mut sets, mut others) = (0.0, 0.0);
        for (task, time) in self.campaign.tasks.iter().zip(&self.report.time) {
            match task.task.uses_sets() {
                true => sets += time.time_s,
                false => others += time.time_s,
            }
        }
        (
            sets / (self.blocks.len() as f64 * self.share()).max(1.0),
            others,
        )
    }
}

/// The smallest number above `now`, for which it is `too_few`, and up to `enough`, for which it is not.
fn fewest(
    now: usize,
    enough: usize,
    too_few: impl Fn(usize) -> Result<bool, DesignError>,
) -> Result<usize, DesignError> {
    let (mut low, mut high) = (now, now);
    // In steps of a quarter, as large numbers take long to simulate; then halving the last step.
    loop {
        high = (high + high.div_ceil(4).max(1)).min(enough);
        if high == enough || !too_few(high)? {
            break;
        }
        low = high;
    }
    while high - low > 1 {
        let middle = usize::midpoint(low, high);
        match too_few(middle)? {
            true => low = middle,
            false => high = middle,
        }
    }
    Ok(high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_number_that_suffices_is_found() {
        for (now, least) in [
            (0, 1),
            (0, 7),
            (1, 2),
            (5, 10),
            (7, 8),
            (10, 399),
            (10, 400),
        ] {
            let found = fewest(now, 400, |n| Ok(n < least));
            assert_eq!(found, Ok(least));
        }
    }
}
