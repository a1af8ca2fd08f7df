//! What follows from the answers so far: the stimuli of adaptive runs, thresholds, and catch trials.

use std::collections::BTreeMap;

use super::super::adaptive::{AdaptiveRuleError, AdaptiveRun, Response, ThresholdEstimate};
use super::super::plan::{Plan, Presented, Trial, TrialKind};
use super::super::protocol::Adaptive;
use super::{Answer, State, TrialState};

/// An adaptive run with the answers that it has taken up.
#[derive(Clone, Debug)]
pub(super) struct Run<'a> {
    adaptive: &'a Adaptive,
    /// Before its first trial.
    new: AdaptiveRun,
    now: AdaptiveRun,
    taken: Vec<(usize, Response)>,
    /// The place of the next level.
    pub(super) next: Option<usize>,
    /// The place of its last trial in the plan.
    last: usize,
}

/// The runs of `plan` before their first trials.
pub(super) fn runs(plan: &Plan) -> Result<BTreeMap<&str, Run<'_>>, AdaptiveRuleError> {
    let mut runs = BTreeMap::new();
    for (name, adaptive) in &plan.runs {
        let new = AdaptiveRun::new(&adaptive.levels(), &adaptive.rule)?;
        let of_run = |trial: &Trial| chosen_by(trial) == Some(name);
        let made = Run {
            adaptive,
            next: new.next_level(),
            now: new.clone(),
            new,
            taken: Vec::new(),
            last: plan.trials.iter().rposition(of_run).unwrap_or(0),
        };
        runs.insert(name.as_str(), made);
    }
    Ok(runs)
}

impl Run<'_> {
    fn course(&self) -> Vec<(f64, Response)> {
        let level = |at: usize| self.adaptive.levels.get(at).map(|one| one.level);
        let taken = self.taken.iter();
        taken
            .filter_map(|(at, response)| Some((level(*at)?, *response)))
            .collect()
    }
}

/// The run that chooses the comparison of `trial`.
fn chosen_by(trial: &Trial) -> Option<&str> {
    match &trial.presented {
        Presented::Chosen { run, .. } => Some(run),
        _ => None,
    }
}

/// What a run says about the threshold.
#[derive(Clone, Debug, PartialEq)]
pub struct Threshold<'a> {
    /// The run, as in the plan.
    pub run: &'a str,
    /// The set; absent where the task has none.
    pub set: Option<&'a str>,
    /// The level of each trial that was answered, in the unit of the protocol's levels, and its response.
    pub course: Vec<(f64, Response)>,
    /// How many of these answers were given to stimuli of which one missed its target, or its drive had not passed.
    pub missed_target: usize,
    pub estimate: ThresholdEstimate,
}

/// The catch trials of a task.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CatchCount<'a> {
    pub task: &'a str,
    /// How many are answered.
    pub answered: usize,
    /// How many of them wrongly.
    pub failed: usize,
    /// How many wrong ones raise no warning.
    pub allowed: usize,
}

impl<'a> State<'a> {
    /// What is presented in `trial`, or would be now: what was handed over, else what was chosen when it was presented, else what is
    /// planned or follows from the answers so far. Empty for a trial that its run does not need.
    #[must_use]
    pub fn presented(&self, trial: &Trial) -> Vec<String> {
        let own = self.trials().find(|(other, _)| other.name == trial.name);
        let known = own.and_then(|(_, state)| state.presented());
        match (known, &trial.presented) {
            (Some(presented), _) => presented.to_vec(),
            (None, Presented::Chosen { run, standard }) => {
                let Some(run) = self.runs.get(run.as_str()) else {
                    return Vec::new();
                };
                let chosen = run.next.and_then(|level| run.adaptive.levels.get(level));
                chosen.map_or_else(Vec::new, |level| {
                    standard.pair(&run.adaptive.standard, &level.stimulus)
                })
            }
            (None, planned) => planned.names().to_vec(),
        }
    }

    /// Whether the trial at place `at` of the plan is needed: those of an ended run are not, and no catch trial before them. A run
    /// that a correction opens again stays ended where later trials have begun.
    pub(super) fn needs(&self, at: usize) -> bool {
        let trials = &self.plan.trials[at..];
        let follows = |trial: &&Trial| !matches!(trial.kind, TrialKind::Catch { .. });
        let Some(run) = trials.iter().find(follows).and_then(chosen_by) else {
            return true;
        };
        self.runs.get(run).is_none_or(|run| {
            let after = &self.trials[run.last + 1..];
            run.next.is_some() && !after.iter().any(TrialState::is_presented)
        })
    }

    /// The answers to the adaptive runs taken up again: only what is new, unless an earlier answer changed.
    pub(super) fn follow(&mut self) {
        let mut runs = std::mem::take(&mut self.runs);
        for (name, run) in &mut runs {
            let of_run = self
                .trials()
                .filter(|(trial, _)| chosen_by(trial) == Some(name));
            let taken: Vec<_> = of_run
                .filter_map(|(_, state)| run.adaptive.response(state))
                .collect();
            if taken == run.taken {
                continue;
            }
            if !taken.starts_with(&run.taken) {
                run.now = run.new.clone();
                run.taken.clear();
            }
            for (level, response) in &taken[run.taken.len()..] {
                run.now.answer(*level, *response);
            }
            run.next = run.now.next_level();
            run.taken = taken;
        }
        self.runs = runs;
    }

    /// The thresholds of `task`, one for each of its runs.
    #[must_use]
    pub fn thresholds(&self, task: &str) -> Vec<Threshold<'a>> {
        let of_task = self.runs.iter().filter_map(|(name, run)| {
            let last = self.plan.trials.get(run.last)?;
            (last.task == task).then(|| Threshold {
                run: name,
                set: last.set.as_deref(),
                course: run.course(),
                missed_target: self.missed_in(name, run),
                estimate: run.now.estimate(run.adaptive.largest_sd),
            })
        });
        of_task.collect()
    }

    fn missed_in(&self, name: &str, run: &Run<'_>) -> usize {
        let of_run = self
            .trials()
            .filter(|(trial, _)| chosen_by(trial) == Some(name));
        let counted = of_run.filter(|(_, state)| run.adaptive.response(state).is_some());
        let missed = |state: &TrialState| state.evidence.iter().any(|(_, one)| one.missed());
        counted.filter(|(_, state)| missed(state)).count()
    }

    /// The right answer to be shown after a confirmed training trial; `None` where nothing is to be shown.
    #[must_use]
    pub fn feedback(&self, trial: &'a Trial) -> Option<&'a [String]> {
        let confirmed = |(other, state): (&Trial, &TrialState)| {
            other.name == trial.name && state.confirmed && state.presented_instead.is_none()
        };
        match &trial.kind {
            TrialKind::Training { feedback } if self.trials().any(confirmed) => feedback.as_deref(),
            _ => None,
        }
    }

    /// The catch trials that were answered, by task. Those with other stimuli than planned have no known answer and do not count.
    #[must_use]
    pub fn catches(&self) -> Vec<CatchCount<'a>> {
        let mut counts: Vec<CatchCount<'a>> = Vec::new();
        for (trial, state) in self.trials() {
            let (TrialKind::Catch { right }, Some(answer), None) =
                (&trial.kind, state.answer(), &state.presented_instead)
            else {
                continue;
            };
            let known = counts.iter().position(|count| count.task == trial.task);
            let at = known.unwrap_or_else(|| {
                let catch = self.protocol.task(&trial.task);
                let catch = catch.and_then(|task| task.catch.as_ref());
                counts.push(CatchCount {
                    task: &trial.task,
                    answered: 0,
                    failed: 0,
                    allowed: catch.map_or(0, |catch| catch.failures_allowed as usize),
                });
                counts.len() - 1
            });
            counts[at].answered += 1;
            counts[at].failed += usize::from(self.names(trial, answer) != *right);
        }
        counts
    }
}

impl TrialState {
    /// Whether it was presented, in the attempt that counts.
    pub(super) fn is_presented(&self) -> bool {
        !self.plays.is_empty()
    }

    /// What was presented, where it is not what the plan names: what was handed over instead, or what was chosen.
    #[must_use]
    pub fn presented(&self) -> Option<&[String]> {
        let known = self.presented_instead.as_ref().or(self.chosen.as_ref());
        known.map(Vec::as_slice)
    }
}

impl Adaptive {
    /// The level that was compared with the standard, and whether the comparison was named; `None` where something else was
    /// presented, or nothing is answered.
    fn response(&self, state: &TrialState) -> Option<(usize, Response)> {
        let (Some(Answer::Names(said)), Some([first, second])) =
            (state.answer(), state.presented())
        else {
            return None;
        };
        let (comparison, right) = match (first == &self.standard, second == &self.standard) {
            (true, false) => (second, "second"),
            (false, true) => (first, "first"),
            _ => return None,
        };
        let at = |level: &super::super::protocol::Level| level.stimulus == *comparison;
        let level = self.levels.iter().position(at)?;
        let response = match said.first().is_some_and(|said| said == right) {
            true => Response::Correct,
            false => Response::Wrong,
        };
        Some((level, response))
    }
}
