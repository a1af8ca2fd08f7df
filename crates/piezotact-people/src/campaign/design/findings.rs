//! What a design can show, found before the first volunteer.

use piezotact::criterion::{Criterion, Limit, Outcome};
use serde::{Deserialize, Serialize};

use super::chance::{
    Matches, kendall_tau, permutation_matches, rule_matches, tau_null_sd, trial_matches,
};
use super::construct::{balanced_blocks, covering, shares};
use super::coverage::{PairCoverage, pair_coverage};
use super::description::{
    CampaignDescription, Comparison, PairsWanted, Scoring, TaskDescription, TaskKind,
};
use super::error::DesignError;
use super::fault::{BetterPlan, Change, DesignCriterion, Fault, FoundFault, SampleSetCount};
use super::orders::{Crossing, crossing, order_balance, williams_orders};
use super::precision::{
    CellPlan, CellPrecision, cell_precision, paired_power, participants_for_power,
};
use super::sequence::{SequenceRule, is_permutation, sequence_distribution};
use super::sets::SampleSets;

/// Simulated studies for the precision of a cell.
const STUDIES: usize = 1000;
/// The largest number of presentations that is looked for.
const MOST_PRESENTATIONS: usize = 60;

/// What chance reaches in a task, for one participant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct TaskChance {
    /// The task.
    pub task: String,
    /// The number of answers; a mean where sequences have several lengths.
    pub answers: f64,
    /// The mean number of right answers by chance.
    pub mean: f64,
    /// Its standard deviation.
    pub sd: f64,
    /// What the standard deviation would be for independent answers.
    pub sd_independent: f64,
    /// The smallest number of right answers that chance reaches with 5 % at most; absent where there is none.
    pub beyond_chance_from: Option<usize>,
    /// The probability by chance of each number of right answers, from 0 on.
    pub probability: Vec<f64>,
    /// The probability by chance of a whole order, for tasks of order.
    pub whole_order_share: Option<f64>,
    /// The standard deviation of Kendall's τ by chance, for tasks of order.
    pub tau_sd: Option<f64>,
    /// The share of sequences whose last answer follows from the others, for tasks of association.
    pub forced_share: Option<f64>,
    /// The share of sequences that are permutations of their set, for tasks of association.
    pub permutation_share: Option<f64>,
}

/// Trials and time of a task, for one participant.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct TaskTime {
    /// The task.
    pub task: String,
    /// The mean number of trials.
    pub trials: f64,
    /// Seconds.
    pub time_s: f64,
}

/// A sample and how often one participant meets it in a task of association.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SampleCount {
    /// The task.
    pub task: String,
    /// The sample that is presented least often.
    pub sample: String,
    /// The mean number of its presentations to one participant.
    pub presentations: f64,
    /// The precision of one of its cells.
    pub precision: CellPrecision,
}

/// The power of a comparison.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ComparisonPower {
    /// The tasks compared.
    pub tasks: Vec<String>,
    /// The smallest effect that must not be missed.
    pub effect_ratio: f64,
    /// The power.
    pub power_share: f64,
}

/// What a design can show.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct DesignReport {
    /// The campaign.
    pub name: String,
    /// The samples; the coverage counts by their indices.
    pub samples: Vec<String>,
    /// The pairs that the sets put together; absent without sets.
    pub coverage: Option<PairCoverage>,
    /// The pairs never together, by name.
    pub never: Vec<[String; 2]>,
    /// What chance reaches in each task in which answers are right or wrong.
    pub chance: Vec<TaskChance>,
    /// The time of each task.
    pub time: Vec<TaskTime>,
    /// Seconds of one participant.
    pub participant_s: f64,
    /// How participants fill the cells of crossed factors; absent without such factors.
    pub crossing: Option<Crossing>,
    /// The power of each comparison.
    pub power: Vec<ComparisonPower>,
    /// The precision of the least presented sample of each task of association.
    pub precision: Vec<SampleCount>,
    /// Every rule that was judged.
    pub criteria: Vec<Criterion<DesignCriterion>>,
    /// The faults: criteria that are not met.
    pub faults: Vec<FoundFault>,
    /// The seed of simulations and searches.
    pub seed: u64,
}

/// The check of `campaign`: chance by task, pairs never together, dependence of answers, seconds of one participant, precision
/// and power for the planned number of people, and the faults that these show. `seed` serves simulations and searches.
///
/// # Errors
///
/// Unknown or repeated samples, sets that do not fit the tray, impossible sequences, unknown tasks, numbers out of range.
///
/// Source: decision 0063 of this project.
pub fn design_findings(
    campaign: &CampaignDescription,
    seed: u64,
) -> Result<DesignReport, DesignError> {
    check_numbers(campaign)?;
    let sets = if campaign.sets.is_empty() {
        None
    } else {
        Some(SampleSets::new(
            &campaign.samples,
            &campaign.sets,
            campaign.tray,
        )?)
    };
    let mut work = Work {
        campaign,
        seed,
        blocks: sets.as_ref().map_or(&[], |sets| sets.sets()),
        report: DesignReport {
            name: campaign.name.clone(),
            samples: campaign.samples.clone(),
            coverage: sets.as_ref().map(pair_coverage),
            never: Vec::new(),
            chance: Vec::new(),
            time: Vec::new(),
            participant_s: 0.0,
            crossing: None,
            power: Vec::new(),
            precision: Vec::new(),
            criteria: Vec::new(),
            faults: Vec::new(),
            seed,
        },
    };
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
        work.power(comparison);
    }
    work.crossing()?;
    Ok(work.report)
}

fn check_numbers(campaign: &CampaignDescription) -> Result<(), DesignError> {
    let ranges = [
        ("the wanted power", campaign.aims.power_share, 0.0, 1.0),
        (
            "the wanted half-width",
            campaign.aims.half_width_share,
            0.0,
            0.5,
        ),
    ];
    for (what, found, low, high) in ranges {
        if !(found > low && found < high) {
            let expected = if high < 1.0 {
                "above 0 and below 0.5"
            } else {
                "above 0 and below 1"
            };
            return Err(DesignError::OutOfRange {
                what,
                found,
                expected,
            });
        }
    }
    for task in &campaign.tasks {
        let found = task.seconds_per_trial;
        if !(found >= 0.0 && found.is_finite()) {
            let what = "the time of a trial in seconds";
            return Err(DesignError::OutOfRange {
                what,
                found,
                expected: "0 or more",
            });
        }
        if (1..=1000).contains(&task.repeats) {
            continue;
        }
        let what = "the number of repeats of a task";
        let found = task.repeats as f64;
        return Err(DesignError::OutOfRange {
            what,
            found,
            expected: "1 to 1000",
        });
    }
    let shared = campaign.sets_shared_over;
    if shared == 0 || (shared > campaign.sets.len() && shared > 1) {
        let what = "the number of participants who share the sets";
        let found = shared as f64;
        return Err(DesignError::OutOfRange {
            what,
            found,
            expected: "1 up to the number of sets",
        });
    }
    for comparison in &campaign.comparisons {
        let found = comparison.smallest_effect_ratio;
        if !(found > 0.0 && found.is_finite()) {
            let what = "the smallest effect";
            return Err(DesignError::OutOfRange {
                what,
                found,
                expected: "above 0",
            });
        }
    }
    if campaign.participants < 2 {
        let what = "the number of participants";
        let found = campaign.participants as f64;
        return Err(DesignError::OutOfRange {
            what,
            found,
            expected: "2 or more",
        });
    }
    Ok(())
}

struct Work<'a> {
    campaign: &'a CampaignDescription,
    seed: u64,
    blocks: &'a [Vec<usize>],
    report: DesignReport,
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

    /// Mean trials of a task, of one participant.
    fn trials(&self, task: &TaskDescription) -> Result<f64, DesignError> {
        let sizes = || self.blocks.iter().map(Vec::len);
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
            | TaskKind::Rate { trials } => *trials as f64,
        };
        Ok(once * task.repeats as f64)
    }

    fn time(&mut self, task: &TaskDescription) -> Result<(), DesignError> {
        let trials = self.trials(task)?;
        self.report.time.push(TaskTime {
            task: task.name.clone(),
            trials,
            time_s: trials * task.seconds_per_trial,
        });
        Ok(())
    }

    /// Seconds of one participant that every set takes, and those that none takes.
    fn time_of_sets_s(&self) -> (f64, f64) {
        let by_sets = self
            .campaign
            .tasks
            .iter()
            .zip(&self.report.time)
            .map(|(task, time)| {
                let per_set = matches!(
                    task.task,
                    TaskKind::OrderSet { .. }
                        | TaskKind::IdentifyFromMemory
                        | TaskKind::Associate { .. }
                );
                if per_set {
                    (time.time_s, 0.0)
                } else {
                    (0.0, time.time_s)
                }
            });
        let (sets, others) = by_sets.fold((0.0, 0.0), |(a, b), (c, d)| (a + c, b + d));
        (
            sets / (self.blocks.len() as f64 * self.share()).max(1.0),
            others,
        )
    }

    /// Fault 2: pairs that are never together.
    fn pairs(&mut self) -> Result<(), DesignError> {
        let Some(coverage) = self.report.coverage.clone() else {
            return Ok(());
        };
        let name = |i: &usize| self.campaign.samples[*i].clone();
        let never: Vec<[String; 2]> = coverage
            .never
            .iter()
            .map(|[a, b]| [name(a), name(b)])
            .collect();
        self.report.never.clone_from(&never);
        if self.campaign.pairs_wanted == PairsWanted::WithinSets {
            return Ok(());
        }
        let criterion = Criterion::new(
            DesignCriterion::PairsTogether,
            "pairs",
            coverage.together as f64,
            None,
            Limit::at_least(coverage.pairs as f64),
        );
        self.judge(criterion, |work| {
            let fewest = coverage.presentations.iter().min().copied().unwrap_or(0);
            let rare = coverage
                .presentations
                .iter()
                .enumerate()
                .filter(|(_, sets)| **sets == fewest);
            let rarest = rare
                .map(|(i, sets)| SampleSetCount {
                    sample: name(&i),
                    sets: *sets,
                })
                .collect();
            let fault = Fault::PairsNeverTogether {
                together: coverage.together,
                pairs: coverage.pairs,
                never,
                rarest,
            };
            Ok((fault, Some(work.better_sets()?)))
        })
    }

    /// Sets of the largest size used that hold every pair.
    fn better_sets(&self) -> Result<BetterPlan, DesignError> {
        let points = self.campaign.samples.len();
        let size = self.blocks.iter().map(Vec::len).max().unwrap_or(2);
        let built = match balanced_blocks(points, size) {
            Ok(built) => built,
            Err(_) => covering(points, size, self.seed)?,
        };
        let halves = shares(points, &built.blocks, 2.min(built.blocks.len()))?.sets;
        let (per_set_s, others_s) = self.time_of_sets_s();
        let then = built.blocks.len();
        let half = halves.iter().map(Vec::len).max();
        let change = Change::Sets {
            method: built.method,
            sets: built.named(&self.campaign.samples),
            together: built.coverage.together,
            pairs: built.coverage.pairs,
            bound: built.bound,
            halves,
        };
        Ok(BetterPlan {
            sets: [self.sets_each(), then],
            participant_s: [
                self.report.participant_s,
                others_s + per_set_s * then as f64,
            ],
            sets_shared_by_two: half,
            participant_shared_by_two_s: half.map(|sets| others_s + per_set_s * sets as f64),
            ..self.plan(change)
        })
    }

    /// What chance reaches, and fault 4: answers that follow from others.
    fn chance(&mut self, task: &TaskDescription) -> Result<(), DesignError> {
        let permuted = |sizes: &mut dyn Iterator<Item = usize>| {
            sizes.fold((Matches::none(), Matches::none()), |(a, b), n| {
                (a.and(&permutation_matches(n)), b.and(&trial_matches(n, n)))
            })
        };
        let sizes = || self.blocks.iter().map(Vec::len);
        let largest = sizes().max();
        let mut dependence = None;
        let (once, independent, order) = match &task.task {
            TaskKind::OrderAll { samples, .. } => {
                check_order(*samples)?;
                let (once, independent) = permuted(&mut std::iter::once(*samples));
                (once, independent, Some(*samples))
            }
            TaskKind::OrderSet { .. } => {
                let (once, independent) = permuted(&mut sizes());
                (once, independent, largest)
            }
            TaskKind::IdentifyFromMemory => {
                let (once, independent) = permuted(&mut sizes());
                (once, independent, None)
            }
            TaskKind::Associate { sequence } => {
                let tests = tests(&self.campaign.sets, sequence, self.blocks)?;
                let sum = |of: fn(&Test) -> &Matches| {
                    tests
                        .iter()
                        .fold(Matches::none(), |sum, test| sum.and(of(test)))
                };
                let n = tests.len().max(1) as f64;
                dependence = Some((
                    tests.iter().map(|test| test.forced_share).sum::<f64>() / n,
                    tests.iter().map(|test| test.permutation_share).sum::<f64>() / n,
                    tests.len(),
                ));
                (
                    sum(|test| &test.chance),
                    sum(|test| &test.independent),
                    None,
                )
            }
            TaskKind::Compare {
                alternatives: n,
                trials,
            }
            | TaskKind::Categorise {
                categories: n,
                trials,
            } => {
                check_trials(*n, *trials)?;
                let once = trial_matches(*n, *trials);
                (once.clone(), once, None)
            }
            TaskKind::Touch { .. } | TaskKind::Rate { .. } => return Ok(()),
        };
        let total = once.repeated(task.repeats);
        let independent = independent.repeated(task.repeats);
        let answers = match &task.task {
            TaskKind::OrderAll { samples, .. } => (*samples * task.repeats) as f64,
            TaskKind::OrderSet { .. } => (sizes().sum::<usize>() * task.repeats) as f64,
            _ => self.trials(task)? / self.share(),
        };
        let chance = TaskChance {
            task: task.name.clone(),
            answers,
            mean: total.mean(),
            sd: total.standard_deviation(),
            sd_independent: independent.standard_deviation(),
            beyond_chance_from: total.beyond_chance_from(),
            probability: total.probability().to_vec(),
            whole_order_share: order.map(|n| (1..=n).map(|i| 1.0 / i as f64).product()),
            tau_sd: order.and_then(tau_null_sd),
            forced_share: dependence.map(|(forced, ..)| forced),
            permutation_share: dependence.map(|(_, permutations, _)| permutations),
        };
        self.report.chance.push(chance.clone());
        let (TaskKind::Associate { sequence }, Some((forced, _, count))) = (&task.task, dependence)
        else {
            return Ok(());
        };
        let what = DesignCriterion::ForcedAnswers {
            task: task.name.clone(),
        };
        let criterion = Criterion::new(what, "", forced, None, Limit::at_most(0.0));
        let longest = largest.unwrap_or(2);
        self.judge(criterion, |work| {
            let fault = Fault::AnswersByExclusion {
                task: task.name.clone(),
                permutations: matches!(sequence, SequenceRule::Fixed { .. }).then_some(count),
                chance_sd: chance.sd,
                chance_sd_independent: chance.sd_independent,
            };
            let change = Change::IndependentSequences {
                shortest: longest,
                longest: longest + 1,
            };
            let mut better = work.plan(change);
            // Half a stimulus more in each test.
            let more =
                (longest as f64 + 0.5) / (chance.answers / (count * task.repeats) as f64) - 1.0;
            let now = work.report.time.iter().find(|time| time.task == task.name);
            better.participant_s[1] += now.map_or(0.0, |time| time.time_s * more);
            Ok((fault, Some(better)))
        })
    }

    /// Fault 5: positions alone overstate confusion.
    fn positions(&mut self, task: &TaskDescription) -> Result<(), DesignError> {
        let (samples, scoring) = match task.task {
            TaskKind::OrderAll { samples, scoring } => (samples, scoring),
            TaskKind::OrderSet { scoring } => {
                (self.blocks.iter().map(Vec::len).max().unwrap_or(0), scoring)
            }
            _ => return Ok(()),
        };
        if scoring == Scoring::ByPositionAndDominance || samples < 2 {
            return Ok(());
        }
        let key: Vec<usize> = (0..samples).collect();
        let moved: Vec<usize> = (1..samples).chain([0]).collect();
        let in_position = key.iter().zip(&moved).filter(|(a, b)| a == b).count();
        let tau = kendall_tau(&key, &moved).unwrap_or(0.0);
        let what = DesignCriterion::PositionsOfOrder {
            task: task.name.clone(),
        };
        // An order that agrees with the true one more than chance does, and has nothing in position.
        let criterion = Criterion::new(what, "", tau, None, Limit::at_most(0.0));
        self.judge(criterion, |work| {
            let task = task.name.clone();
            let fault = Fault::PositionOverstatesConfusion {
                task,
                samples,
                in_position,
                tau,
            };
            Ok((fault, Some(work.plan(Change::DominanceBesidePosition))))
        })
    }

    /// Fault 7: the interval of a cell.
    fn precision(&mut self, task: &TaskDescription) -> Result<(), DesignError> {
        let (TaskKind::Associate { sequence }, false) = (&task.task, self.blocks.is_empty()) else {
            return Ok(());
        };
        let tests = tests(&self.campaign.sets, sequence, self.blocks)?;
        let mut counts = vec![0.0; self.campaign.samples.len()];
        for test in &tests {
            for (place, n) in test.presentations.iter().enumerate() {
                counts[self.blocks[test.set][place]] += n * self.share() * task.repeats as f64;
            }
        }
        let used = counts.iter().enumerate().filter(|(_, n)| **n > 0.0);
        let Some((i, &presentations)) = used.min_by(|a, b| a.1.total_cmp(b.1)) else {
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
        let sample = self.campaign.samples[i].clone();
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
        let most = CellPlan {
            presentations: MOST_PRESENTATIONS.max(plan.presentations),
            ..*plan
        };
        if !wide(&most)? {
            let mut more = *plan;
            while wide(&more)? {
                more.presentations += more.presentations.div_ceil(4);
            }
            let change = Change::Presentations {
                presentations: more.presentations,
            };
            let mut better = self.plan(change);
            let now = self.report.time.iter().find(|time| time.task == task.name);
            let times = more.presentations as f64 / plan.presentations as f64;
            better.participant_s[1] += now.map_or(0.0, |time| time.time_s * (times - 1.0));
            return Ok(Some(better));
        }
        let mut more = *plan;
        while more.participants < 400 && wide(&more)? {
            more.participants += more.participants.div_ceil(4);
        }
        if wide(&more)? {
            return Ok(None);
        }
        let mut better = self.plan(Change::Participants {
            participants: more.participants,
        });
        better.participants[1] = more.participants;
        Ok(Some(better))
    }

    /// Fault 6: a task that always has the same position among those it is compared with.
    fn order(&mut self, comparison: &Comparison) -> Result<(), DesignError> {
        let names = &comparison.tasks;
        for name in names
            .iter()
            .chain(self.campaign.task_orders.iter().flatten())
        {
            if self
                .campaign
                .tasks
                .iter()
                .filter(|task| task.name == *name)
                .count()
                != 1
            {
                return Err(DesignError::UnknownTask { task: name.clone() });
            }
        }
        if names.len() < 2 || self.campaign.task_orders.is_empty() {
            return Ok(());
        }
        let among = |order: &Vec<String>| -> Vec<usize> {
            order
                .iter()
                .filter_map(|name| names.iter().position(|n| n == name))
                .collect()
        };
        let orders: Vec<Vec<usize>> = self.campaign.task_orders.iter().map(among).collect();
        let balance = order_balance(names.len(), &orders)?;
        let fixed: Vec<(usize, usize)> = (0..names.len())
            .filter_map(|i| balance.only_position(i).map(|at| (i, at)))
            .collect();
        let what = DesignCriterion::FixedPositions {
            tasks: names.clone(),
        };
        let criterion =
            Criterion::new(what, "tasks", fixed.len() as f64, None, Limit::at_most(0.0));
        self.judge(criterion, |work| {
            let (task, position) = fixed.first().copied().unwrap_or_default();
            let fault = Fault::ConfoundedWithOrder {
                task: names[task].clone(),
                position: position + 1,
                tasks: names.clone(),
            };
            let named = |order: &Vec<usize>| order.iter().map(|i| names[*i].clone()).collect();
            let orders = williams_orders(names.len())?.iter().map(named).collect();
            Ok((
                fault,
                Some(work.plan(Change::EarlierMeasurement { orders })),
            ))
        })
    }

    /// Fault 7: the power of a comparison.
    fn power(&mut self, comparison: &Comparison) {
        let participants = self.campaign.participants;
        let effect_ratio = comparison.smallest_effect_ratio;
        let Some(power_share) = paired_power(participants, effect_ratio) else {
            return;
        };
        let tasks = comparison.tasks.clone();
        self.report.power.push(ComparisonPower {
            tasks: tasks.clone(),
            effect_ratio,
            power_share,
        });
        let wanted_share = self.campaign.aims.power_share;
        let what = DesignCriterion::Power {
            tasks: tasks.clone(),
        };
        let criterion = Criterion::new(what, "", power_share, None, Limit::at_least(wanted_share));
        self.report.criteria.push(criterion.clone());
        if criterion.outcome != Outcome::NotMet {
            return;
        }
        let better = participants_for_power(effect_ratio, wanted_share).map(|n| BetterPlan {
            participants: [participants, n],
            ..self.plan(Change::Participants { participants: n })
        });
        let fault = Fault::PowerTooLow {
            tasks,
            participants,
            effect_ratio,
            power_share,
            wanted_share,
        };
        self.report.faults.push(FoundFault {
            fault,
            criterion,
            better,
        });
    }

    /// Fault 6: cells that the participants do not fill equally.
    fn crossing(&mut self) -> Result<(), DesignError> {
        if self.campaign.counterbalanced.is_empty() {
            return Ok(());
        }
        let orders: Vec<usize> = self
            .campaign
            .counterbalanced
            .iter()
            .map(|f| f.orders)
            .collect();
        let found = crossing(&orders, self.campaign.participants)?;
        self.report.crossing = Some(found);
        let left = found.left_over as f64;
        let criterion = Criterion::new(
            DesignCriterion::CellsFilled,
            "participants",
            left,
            None,
            Limit::at_most(0.0),
        );
        self.judge(criterion, |work| {
            let Crossing {
                cells,
                participants,
                next_balanced,
                ..
            } = found;
            let mut better = work.plan(Change::Participants {
                participants: next_balanced,
            });
            better.participants[1] = next_balanced;
            Ok((
                Fault::CannotBeBalanced {
                    cells,
                    participants,
                },
                Some(better),
            ))
        })
    }
}

fn check_order(samples: usize) -> Result<(), DesignError> {
    if (2..=100).contains(&samples) {
        return Ok(());
    }
    let found = samples as f64;
    Err(DesignError::OutOfRange {
        what: "the number of samples to order",
        found,
        expected: "2 to 100",
    })
}

fn check_trials(alternatives: usize, trials: usize) -> Result<(), DesignError> {
    if alternatives >= 2 && (1..=5000).contains(&trials) {
        return Ok(());
    }
    let (what, found, expected) = if alternatives < 2 {
        (
            "the number of possible answers",
            alternatives as f64,
            "2 or more",
        )
    } else {
        ("the number of trials", trials as f64, "1 to 5000")
    };
    Err(DesignError::OutOfRange {
        what,
        found,
        expected,
    })
}

/// One test of association.
struct Test {
    set: usize,
    mean_length: f64,
    chance: Matches,
    independent: Matches,
    forced_share: f64,
    permutation_share: f64,
    /// Mean presentations of each sample of the set.
    presentations: Vec<f64>,
}

/// The tests of association of all sets. Fixed sequences leave the last answer to exclusion where all of them are
/// permutations: one that repeats a sample shows participants that they cannot rely on it.
fn tests(
    names: &[Vec<String>],
    rule: &SequenceRule,
    blocks: &[Vec<usize>],
) -> Result<Vec<Test>, DesignError> {
    if blocks.is_empty() {
        return Err(DesignError::NoSets);
    }
    let SequenceRule::Fixed { tests } = rule else {
        return blocks
            .iter()
            .enumerate()
            .map(|(set, block)| drawn_test(rule, set, block.len()))
            .collect();
    };
    if tests.len() != blocks.len() || tests.iter().any(Vec::is_empty) {
        let found = tests.iter().filter(|of| !of.is_empty()).count();
        return Err(DesignError::FixedSequences {
            found,
            expected: blocks.len(),
        });
    }
    let mut all: Vec<(usize, Vec<usize>)> = Vec::new();
    for (set, of_set) in tests.iter().enumerate() {
        for test in of_set {
            let place = |sample: &String| {
                names[set]
                    .iter()
                    .position(|own| own == sample)
                    .ok_or_else(|| DesignError::UnknownSample {
                        set: set + 1,
                        sample: sample.clone(),
                    })
            };
            let places = test.iter().map(place).collect::<Result<Vec<_>, _>>()?;
            if places.is_empty() {
                return Err(DesignError::ImpossibleLengths {
                    shortest: 0,
                    longest: 0,
                });
            }
            all.push((set, places));
        }
    }
    let permuted = |(set, test): &(usize, Vec<usize>)| is_permutation(test, blocks[*set].len());
    let exclusion = all.iter().all(permuted);
    let test = |one: &(usize, Vec<usize>)| {
        let (set, places) = one;
        let size = blocks[*set].len();
        let independent = trial_matches(size, places.len());
        let count = |place: usize| places.iter().filter(|at| **at == place).count() as f64;
        Test {
            set: *set,
            mean_length: places.len() as f64,
            chance: if exclusion {
                permutation_matches(size)
            } else {
                independent.clone()
            },
            independent,
            forced_share: if exclusion { 1.0 } else { 0.0 },
            permutation_share: if permuted(one) { 1.0 } else { 0.0 },
            presentations: (0..size).map(count).collect(),
        }
    };
    Ok(all.iter().map(test).collect())
}

fn drawn_test(rule: &SequenceRule, set: usize, size: usize) -> Result<Test, DesignError> {
    let distribution = sequence_distribution(rule, size)?;
    let chance = rule_matches(rule, size)?;
    let independent = match *rule {
        SequenceRule::Independent { .. } => chance.clone(),
        SequenceRule::AtMost {
            shortest, longest, ..
        } => rule_matches(&SequenceRule::Independent { shortest, longest }, size)?,
        _ => trial_matches(size, size),
    };
    Ok(Test {
        set,
        mean_length: distribution.mean_length,
        chance,
        independent,
        forced_share: distribution.forced_share,
        permutation_share: distribution.permutation_share,
        // By symmetry, all samples of a set are presented equally often.
        presentations: vec![distribution.mean_length / size as f64; size],
    })
}
