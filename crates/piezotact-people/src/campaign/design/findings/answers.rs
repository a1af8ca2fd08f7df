//! What chance reaches, answers that follow from others, and how orders are scored.

use piezotact::criterion::{Criterion, Limit};

use super::super::chance::{Matches, permutation_matches, tau_null_sd, trial_matches};
use super::super::description::{Scoring, TaskDescription, TaskKind};
use super::super::error::DesignError;
use super::super::fault::{Change, DesignCriterion, Fault};
use super::super::sequence::SequenceRule;
use super::Work;
use super::check::{check_answers, check_order, check_trials};
use super::presented::{Test, tests};
use super::report::TaskChance;

/// The larger of two thresholds; none where one of them has none.
fn larger(a: Option<usize>, b: Option<usize>) -> Option<usize> {
    Some(a?.max(b?))
}

/// What guessing reaches in one repetition of a task.
struct Guessing {
    /// As the task is asked.
    once: Matches,
    /// With every answer free.
    independent: Matches,
    /// With each sample answered once, wherever each is presented once.
    each_once: Option<Matches>,
    /// The number of samples that are put in order.
    order: Option<usize>,
    /// For sequences: the shares of answers that are forced and of sequences that are permutations, and the number of tests.
    dependence: Option<(f64, f64, usize)>,
}

impl Work<'_> {
    /// What chance reaches, and fault 4: answers that follow from others.
    pub(super) fn chance(&mut self, task: &TaskDescription) -> Result<(), DesignError> {
        let Some(Guessing {
            once,
            independent,
            each_once,
            order,
            dependence,
        }) = self.guessing(task)?
        else {
            return Ok(());
        };
        let sizes = || self.blocks.iter().map(Vec::len);
        let total = once.repeated(task.repeats);
        let independent = independent.repeated(task.repeats);
        let answers = match &task.task {
            TaskKind::OrderAll { samples, .. } => (*samples * task.repeats) as f64,
            TaskKind::OrderSet { .. } => (sizes().sum::<usize>() * task.repeats) as f64,
            TaskKind::Associate { .. } | TaskKind::IdentifyFromMemory => {
                self.trials(task)? / self.share()
            }
            _ => self.trials(task)?,
        };
        let groups = (self.campaign.participants / self.campaign.sets_shared_over).max(1);
        // Nobody is kept from answering one sample twice, unless samples are put in order; nor from answering each once.
        let others = match task.task {
            TaskKind::OrderAll { .. } | TaskKind::OrderSet { .. } => &total,
            _ => &independent,
        };
        let each_once = each_once.map_or(total.clone(), |once| once.repeated(task.repeats));
        let guesses = [&total, others, &each_once];
        let beyond = |from: &dyn Fn(&Matches) -> Option<usize>| {
            guesses.into_iter().map(from).reduce(larger).flatten()
        };
        let chance = TaskChance {
            task: task.name.clone(),
            answers,
            mean: total.mean(),
            sd: total.standard_deviation(),
            sd_independent: independent.standard_deviation(),
            beyond_chance_from: beyond(&Matches::beyond_chance_from),
            beyond_chance_together_from: beyond(&|one| one.beyond_chance_together(groups)),
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
        let longest = sizes().max().unwrap_or(2);
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

    /// What guessing reaches in one repetition of `task`; none for a task that has no right answer.
    fn guessing(&self, task: &TaskDescription) -> Result<Option<Guessing>, DesignError> {
        let permuted = |sizes: &mut dyn Iterator<Item = usize>| {
            sizes.fold((Matches::none(), Matches::none()), |(a, b), n| {
                (a.and(&permutation_matches(n)), b.and(&trial_matches(n, n)))
            })
        };
        let sizes = || self.blocks.iter().map(Vec::len);
        let largest = sizes().max();
        let mut dependence = None;
        let mut each_once = None;
        let (once, independent, order) = match &task.task {
            TaskKind::OrderAll { samples, .. } => {
                check_order(*samples)?;
                check_answers(*samples, task.repeats)?;
                let (once, independent) = permuted(&mut std::iter::once(*samples));
                (once, independent, Some(*samples))
            }
            TaskKind::OrderSet { .. } => {
                check_answers(sizes().sum(), task.repeats)?;
                let (once, independent) = permuted(&mut sizes());
                (once, independent, largest)
            }
            TaskKind::IdentifyFromMemory => {
                check_answers(sizes().sum(), task.repeats)?;
                let (once, independent) = permuted(&mut sizes());
                (once, independent, None)
            }
            TaskKind::Associate { sequence } => {
                let tests = tests(&self.campaign.sets, sequence, self.blocks)?;
                let answers = tests.iter().map(|test| test.chance.probability().len() - 1);
                check_answers(answers.sum(), task.repeats)?;
                let sum = |of: fn(&Test) -> &Matches| {
                    tests
                        .iter()
                        .fold(Matches::none(), |sum, test| sum.and(of(test)))
                };
                each_once = Some(sum(|test| &test.each_once));
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
                ..
            }
            | TaskKind::Categorise {
                categories: n,
                trials,
            } => {
                check_trials(*n, *trials)?;
                check_answers(*trials, task.repeats)?;
                let once = trial_matches(*n, *trials);
                (once.clone(), once, None)
            }
            TaskKind::Touch { .. } | TaskKind::Rate { .. } => return Ok(None),
        };
        Ok(Some(Guessing {
            once,
            independent,
            each_once,
            order,
            dependence,
        }))
    }

    /// Fault 5: positions alone overstate confusion.
    pub(super) fn positions(&mut self, task: &TaskDescription) -> Result<(), DesignError> {
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
        // One sample moved from first to last reverses n − 1 of n(n − 1)/2 pairs, and leaves none in position.
        let tau = (samples as f64 - 4.0) / samples as f64;
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
                in_position: 0,
                tau,
            };
            Ok((fault, Some(work.plan(Change::DominanceBesidePosition))))
        })
    }
}
