//! Warnings about a session.

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
    /// The session was stopped before its end; the answers until then are counted.
    #[error(
        "{session} was stopped after {confirmed} of {planned} trials; the answers until then are counted: decide, before the answers are looked at, \
            whether incomplete sessions belong to the analysis"
    )]
    #[serde(rename = "session_stopped_early")]
    StoppedEarly {
        session: String,
        confirmed: usize,
        planned: usize,
    },
    /// The session is under way; the answers until now are counted.
    #[error(
        "{session} is under way: {confirmed} of {planned} trials are confirmed and counted here; trials that were not reached yet are missing"
    )]
    #[serde(rename = "session_under_way")]
    UnderWay {
        session: String,
        confirmed: usize,
        planned: usize,
    },
    /// The participant's own order was corrected after its letters were answered with; `trial` is the number of the trial with the order, from 1.
    #[error(
        "{session}: the participant's own order of trial {trial} was corrected after its letters had been answered with: {answers} {} for other \
            samples since; trials.csv of `campaign export` has both",
        if *answers == 1 { "answer stands" } else { "answers stand" }
    )]
    OrderCorrected {
        session: String,
        trial: usize,
        answers: usize,
    },
    /// A participant withdrew, and what is stored was not erased yet.
    #[error(
        "{participant} has withdrawn and is not erased yet: the sessions of {participant} are left out here; erase everything of this participant \
            now"
    )]
    #[serde(rename = "withdrawn_not_erased")]
    NotErased { participant: String },
    /// The plan of a session cannot be read.
    #[error("{session}: {why}; all sessions of this participant are left out here")]
    #[serde(rename = "plan_unreadable")]
    NoPlan { session: String, why: String },
    /// Virtual volunteers, who judge as a model does.
    #[error(
        "virtual volunteers who judge as `{judge}` answered in {sessions} sessions, no person: the answers say what this model does"
    )]
    #[serde(rename = "virtual_volunteer")]
    Virtual { sessions: usize, judge: String },
    /// Stimuli were played to a finger that a bench simulates: no person felt them.
    #[error(
        "{session}: {playings} playings were on a simulated bench: no person felt them, and the answers say nothing about people"
    )]
    #[serde(rename = "felt_by_a_simulated_finger")]
    Simulated { session: String, playings: usize },
}

impl State<'_> {
    /// What to know before relying on the answers.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
        let mut warnings = self.warnings_but_of_judge();
        let judge = self.participant.judge;
        warnings.extend(judge.map(|judge| {
            Warning::from(CampaignWarning::Virtual {
                sessions: 1,
                judge: judge.name().to_owned(),
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
            Stage::Stopped if confirmed > 0 => warnings.push(CampaignWarning::StoppedEarly {
                session: session.clone(),
                confirmed,
                planned,
            }),
            Stage::Running | Stage::Paused if confirmed > 0 => {
                warnings.push(CampaignWarning::UnderWay {
                    session: session.clone(),
                    confirmed,
                    planned,
                });
            }
            _ => {}
        }
        warnings.extend(self.orders_corrected(&session));
        if self.participant.judge.is_some() {
            return warnings.into_iter().map(Warning::from).collect();
        }
        let played = self.trials.iter().flat_map(|trial| &trial.evidence);
        let playings = played.filter(|(_, one)| one.is_simulated()).count();
        if playings > 0 {
            warnings.push(CampaignWarning::Simulated { session, playings });
        }
        warnings.into_iter().map(Warning::from).collect()
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
