//! Warnings about a session.

use piezotact::recording::{RecordingWarning, Simulated};
use std::collections::BTreeMap;

use piezotact::Warning;
use serde::{Deserialize, Serialize};

use super::super::plan::AnswerForm;
use super::{Stage, State};

/// One thing to know before relying on the answers of a session.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum CampaignWarning {
    /// More catch trials were answered wrongly than the protocol allows.
    #[error(
        "{task}: {failed} of {answered} catch trials, whose answer is known and easy, were answered wrongly, and the protocol allows {allowed}: the \
            participant may not have done the task; look at the other answers before they are used"
    )]
    CatchTrialsFailed {
        task: String,
        failed: usize,
        answered: usize,
        allowed: usize,
    },
    /// The participant's own order was corrected after its letters were answered with; `trial` is the number of the trial with the order, from 1.
    #[error(
        "{session}: the participant's own order of trial {trial} was corrected after its letters had been used in answers, so that {answers} {} another \
            sample now; compare both in the exported table of trials",
        if *answers == 1 { "answer means" } else { "answers mean" }
    )]
    OrderCorrected {
        session: String,
        trial: usize,
        answers: usize,
    },
    /// All sessions of a participant are left out.
    #[error("{why}; {}", why.advice())]
    #[serde(rename = "participant_left_out")]
    LeftOut {
        #[serde(flatten)]
        why: LeftOut,
    },
    /// A session that was stopped, or is under way: the answers until now are counted.
    #[error(
        "{session} {} {confirmed} of {planned} trials, and its answers are counted; decide, before you look at them, whether incomplete sessions \
            belong to the analysis",
        match stopped { true => "was stopped after", false => "is under way:" }
    )]
    #[serde(rename = "session_incomplete")]
    Incomplete {
        session: String,
        confirmed: usize,
        planned: usize,
        stopped: bool,
    },
}

/// Why the sessions of a participant are left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "why", rename_all = "snake_case")]
pub enum LeftOut {
    /// A participant withdrew, and what is stored was not erased yet.
    #[error(
        "{participant} has withdrawn and is not erased yet, so that all sessions of {participant} are left out here"
    )]
    Withdrawn { participant: String },
    /// The plan of a session cannot be read.
    #[error("{session}: {said}; all sessions of this participant are left out here")]
    Plan { session: String, said: String },
}

impl LeftOut {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Withdrawn { .. } => "erase everything of this participant now",
            Self::Plan { .. } => "repair or remove the plan",
        }
    }
}

impl State<'_> {
    /// What to know before relying on the answers.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let mut warnings = self.warnings_but_of_judge();
        let judge = self.participant.judge;
        warnings.extend(judge.map(|judge| {
            Warning::from(RecordingWarning::Simulated {
                by: Simulated::Volunteers {
                    sessions: 1,
                    judge: judge.name().to_owned(),
                },
            })
        }));
        warnings
    }

    /// As [`Self::warnings`], without the one that a virtual volunteer answered.
    #[must_use]
    pub fn warnings_but_of_judge(&self) -> Vec<Warning> {
        let failed = self.catches().into_iter();
        let failed = failed.filter(|count| count.failed > count.allowed);
        let mut warnings: Vec<CampaignWarning> = failed
            .map(|count| CampaignWarning::CatchTrialsFailed {
                task: count.task.to_owned(),
                failed: count.failed,
                answered: count.answered,
                allowed: count.allowed,
            })
            .collect();
        let session = format!("session {} of {}", self.plan.session, self.plan.participant);
        let confirmed = self.confirmed();
        let planned = self.progress().values().map(|(_, needed)| needed).sum();
        match self.stage {
            Stage::Stopped if confirmed > 0 => warnings.push(CampaignWarning::Incomplete {
                session: session.clone(),
                confirmed,
                planned,
                stopped: true,
            }),
            Stage::Running | Stage::Paused if confirmed > 0 => {
                warnings.push(CampaignWarning::Incomplete {
                    session: session.clone(),
                    confirmed,
                    planned,
                    stopped: false,
                });
            }
            _ => {}
        }
        warnings.extend(self.orders_corrected(&session));
        let mut warnings: Vec<Warning> = warnings.into_iter().map(Warning::from).collect();
        if self.participant.judge.is_some() {
            return warnings;
        }
        let played = self.trials.iter().flat_map(|trial| &trial.evidence);
        let playings = played.filter(|(_, one)| one.is_simulated()).count();
        if playings > 0 {
            let by = Simulated::Bench { session, playings };
            warnings.push(RecordingWarning::Simulated { by }.into());
        }
        warnings
    }

    /// The orders that were corrected after their letters had been answered with.
    fn orders_corrected(&self, session: &str) -> Vec<CampaignWarning> {
        let mut anew: BTreeMap<usize, usize> = BTreeMap::new();
        for trial in &self.plan.trials {
            if let AnswerForm::EachOfOrder { trial: order } = &trial.answer
                && self.is_read_anew(trial)
            {
                *anew.entry(self.number(order)).or_default() += 1;
            }
        }
        let of = |(trial, answers)| CampaignWarning::OrderCorrected {
            session: session.to_owned(),
            trial,
            answers,
        };
        anew.into_iter().map(of).collect()
    }
}
