//! Warnings about a session.

use std::collections::BTreeMap;
use std::fmt;

use piezotact::Warning;
use piezotact::warning::{Advice, FieldValue, WarningKind};

use super::super::plan::AnswerForm;
use super::{Stage, State};

/// One thing to know before relying on the answers of a session.
#[derive(Clone, Debug, PartialEq)]
pub enum CampaignWarning {
    /// More catch trials were answered wrongly than the protocol allows.
    CatchTrialsFailed {
        task: String,
        /// How many were wrong.
        failed: usize,
        /// How many were answered.
        answered: usize,
        /// How many may be wrong.
        allowed: usize,
    },
    /// The session was stopped before its end; the answers until then are counted.
    StoppedEarly {
        /// The session and whose it is.
        session: String,
        /// How many trials were confirmed.
        confirmed: usize,
        /// How many were planned.
        planned: usize,
    },
    /// The session is under way; the answers until now are counted.
    UnderWay {
        /// The session and whose it is.
        session: String,
        /// How many trials are confirmed.
        confirmed: usize,
        /// How many are planned.
        planned: usize,
    },
    /// The participant's own order was corrected after its letters were answered with.
    OrderCorrected {
        /// The session and whose it is.
        session: String,
        /// The number of the trial with the order, from 1.
        trial: usize,
        /// How many answers stand for other samples since.
        answers: usize,
    },
    /// A participant withdrew, and what is stored was not erased yet.
    NotErased { participant: String },
    /// The plan of a session cannot be read.
    NoPlan {
        /// The session and whose it is.
        session: String,
        why: String,
    },
    /// Virtual volunteers.
    Virtual {
        sessions: usize,
        /// How the volunteer judges.
        judge: String,
    },
    /// Stimuli were played to a finger that a bench simulates: no person felt them.
    Simulated {
        /// The session and whose it is.
        session: String,
        playings: usize,
    },
}

const CATCH: &str = "catch_trials_failed";
const STOPPED: &str = "session_stopped_early";
const UNDER_WAY: &str = "session_under_way";
const ORDER_CORRECTED: &str = "order_corrected";
const NOT_ERASED: &str = "withdrawn_not_erased";
const NO_PLAN: &str = "plan_unreadable";
const VIRTUAL: &str = "virtual_volunteer";
const SIMULATED: &str = "felt_by_a_simulated_finger";

impl From<CampaignWarning> for Warning {
    fn from(kind: CampaignWarning) -> Self {
        match kind {
            CampaignWarning::CatchTrialsFailed {
                task,
                failed,
                answered,
                allowed,
            } => {
                let fields = [
                    ("task", task.into_value()),
                    ("failed", failed.into_value()),
                    ("answered", answered.into_value()),
                    ("allowed", allowed.into_value()),
                ];
                Self::of_fields(CATCH, fields, None, Vec::new())
            }
            CampaignWarning::StoppedEarly {
                session,
                confirmed,
                planned,
            } => {
                let fields = [
                    ("session", session.into_value()),
                    ("confirmed", confirmed.into_value()),
                    ("planned", planned.into_value()),
                ];
                Self::of_fields(STOPPED, fields, None, Vec::new())
            }
            CampaignWarning::UnderWay {
                session,
                confirmed,
                planned,
            } => {
                let fields = [
                    ("session", session.into_value()),
                    ("confirmed", confirmed.into_value()),
                    ("planned", planned.into_value()),
                ];
                Self::of_fields(UNDER_WAY, fields, None, Vec::new())
            }
            CampaignWarning::OrderCorrected {
                session,
                trial,
                answers,
            } => {
                let fields = [
                    ("session", session.into_value()),
                    ("trial", trial.into_value()),
                    ("answers", answers.into_value()),
                ];
                Self::of_fields(ORDER_CORRECTED, fields, None, Vec::new())
            }
            CampaignWarning::NotErased { participant } => {
                let fields = [("participant", participant.into_value())];
                Self::of_fields(NOT_ERASED, fields, None, Vec::new())
            }
            CampaignWarning::NoPlan { session, why } => {
                let fields = [("session", session.into_value()), ("why", why.into_value())];
                Self::of_fields(NO_PLAN, fields, None, Vec::new())
            }
            CampaignWarning::Virtual { sessions, judge } => {
                let fields = [
                    ("sessions", sessions.into_value()),
                    ("judge", judge.into_value()),
                ];
                Self::of_fields(VIRTUAL, fields, None, Vec::new())
            }
            CampaignWarning::Simulated { session, playings } => {
                let fields = [
                    ("session", session.into_value()),
                    ("playings", playings.into_value()),
                ];
                Self::of_fields(SIMULATED, fields, None, Vec::new())
            }
        }
    }
}

impl WarningKind for CampaignWarning {
    fn of(warning: &Warning) -> Option<Self> {
        let field = |name: &str| warning.field::<usize>(name, None);
        let text = |name: &str| warning.field::<String>(name, None);
        match warning.code.as_ref() {
            CATCH => Some(Self::CatchTrialsFailed {
                task: text("task")?,
                failed: field("failed")?,
                answered: field("answered")?,
                allowed: field("allowed")?,
            }),
            STOPPED => Some(Self::StoppedEarly {
                session: text("session")?,
                confirmed: field("confirmed")?,
                planned: field("planned")?,
            }),
            UNDER_WAY => Some(Self::UnderWay {
                session: text("session")?,
                confirmed: field("confirmed")?,
                planned: field("planned")?,
            }),
            ORDER_CORRECTED => Some(Self::OrderCorrected {
                session: text("session")?,
                trial: field("trial")?,
                answers: field("answers")?,
            }),
            NOT_ERASED => Some(Self::NotErased {
                participant: text("participant")?,
            }),
            NO_PLAN => Some(Self::NoPlan {
                session: text("session")?,
                why: text("why")?,
            }),
            VIRTUAL => Some(Self::Virtual {
                sessions: field("sessions")?,
                judge: text("judge")?,
            }),
            SIMULATED => Some(Self::Simulated {
                session: text("session")?,
                playings: field("playings")?,
            }),
            _ => None,
        }
    }

    fn advice(&self) -> Vec<Advice> {
        Vec::new()
    }
}

impl fmt::Display for CampaignWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::CatchTrialsFailed {
                task,
                failed,
                answered,
                allowed,
            } => write!(
                f,
                "{task}: {failed} of {answered} catch trials, whose answer is known and easy, were answered wrongly, and the \
                 protocol allows {allowed}: the participant may not have done the task; look at the other answers before they \
                 are used"
            ),
            Self::StoppedEarly {
                session,
                confirmed,
                planned,
            } => write!(
                f,
                "{session} was stopped after {confirmed} of {planned} trials; the answers until then are counted: decide, before \
                 the answers are looked at, whether incomplete sessions belong to the analysis"
            ),
            Self::UnderWay {
                session,
                confirmed,
                planned,
            } => write!(
                f,
                "{session} is under way: {confirmed} of {planned} trials are confirmed and counted here; trials that were not \
                 reached yet are missing"
            ),
            Self::OrderCorrected {
                session,
                trial,
                answers,
            } => write!(
                f,
                "{session}: the participant's own order of trial {trial} was corrected after its letters had been answered with: \
                 {answers} {} for other samples since; trials.csv of `campaign export` has both",
                match answers {
                    1 => "answer stands",
                    _ => "answers stand",
                }
            ),
            Self::NotErased { participant } => write!(
                f,
                "{participant} has withdrawn and is not erased yet: the sessions of {participant} are left out here; erase everything of \
                 this participant now"
            ),
            Self::NoPlan { session, why } => write!(
                f,
                "{session}: {why}; all sessions of this participant are left out here"
            ),
            Self::Virtual { sessions, judge } => write!(
                f,
                "virtual volunteers who judge as `{judge}` answered in {sessions} sessions, no person: the answers say what this model does"
            ),
            Self::Simulated { session, playings } => write!(
                f,
                "{session}: {playings} playings were on a simulated bench: no person felt them, and the answers say nothing about \
                 people"
            ),
        }
    }
}

impl State<'_> {
    /// What to know before relying on the answers.
    #[must_use]
    pub fn warnings(&self) -> Vec<Warning> {
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
        if let Some(judge) = self.participant.judge {
            warnings.push(CampaignWarning::Virtual {
                sessions: 1,
                judge: judge.name().to_owned(),
            });
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
