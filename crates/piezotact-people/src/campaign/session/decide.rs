//! What a command of the experimenter makes happen.

use crate::campaign::session::SessionError;
use piezotact::number::counted;

use super::super::chain::Sha;
use super::super::plan::{AnswerForm, Presented, Trial};
use super::super::protocol::TaskKind;
use super::super::store::Purpose;
use super::super::text::{TextError, check_long};
use super::answer::{letters, understand};
use super::{
    Answer, Event, Evidence, Participant, Stage, State, Step, TouchRecord, checklist_place,
};

/// A command of the experimenter.
#[derive(Clone, Debug, PartialEq)]
pub enum Command {
    /// Begins the session.
    Begin {
        /// The tag of the experimenter.
        experimenter: String,
        /// The program and its version.
        program: String,
        /// With a volunteer, or a rehearsal.
        purpose: Purpose,
        participant: Participant,
    },
    /// The participant gives consent to a text.
    Consent {
        /// The SHA-256 of the text.
        text: Sha,
    },
    /// The participant does not give consent.
    RefuseConsent,
    /// Confirms the next item of the checklist.
    Check,
    /// The trial was presented as planned.
    Present {
        /// What was measured while each element was played; empty for what is not rendered.
        evidence: Vec<Evidence>,
    },
    /// Other samples than planned were presented.
    PresentInstead {
        names: Vec<String>,
        /// As for what was planned.
        evidence: Vec<Evidence>,
    },
    /// The trial is void, as a device failed while it ran.
    Void { why: String },
    /// An element was felt once more.
    Play {
        /// The element, from 0.
        element: usize,
        evidence: Option<Evidence>,
    },
    /// The participant answers the current trial, or revises the answer.
    Answer { words: Vec<String> },
    /// The participant answers a trial by its name: as a page sends it, which may come late.
    AnswerTo { trial: String, words: Vec<String> },
    /// The participant confirms.
    Confirm,
    /// The participant confirms a trial of touch, of which this was recorded.
    ConfirmTouched { touched: TouchRecord },
    /// Corrects what was noted for a confirmed trial.
    Correct {
        trial: String,
        words: Vec<String>,
        why: String,
    },
    /// A pause begins.
    Pause,
    /// The pause ends.
    GoOn,
    /// The session goes on after it was cut off.
    Resume {
        /// The tag of the experimenter.
        experimenter: String,
        /// The time now, in ms since 1970-01-01 00:00 UTC.
        now_ms: i64,
    },
    /// A note.
    Note { text: String },
    /// Stops before the end.
    Stop { why: String },
    /// The participant withdraws consent.
    Withdraw,
    /// Ends the session.
    End,
}

/// Why a command makes nothing happen; nothing is stored.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// It is not the time for it.
    #[error("not now: {expected}")]
    NotNow {
        /// What is to be done first.
        expected: String,
    },
    /// There is no such trial or element.
    #[error("there is no {what} `{name}` in this session")]
    Unknown {
        /// "trial" or "element".
        what: &'static str,
        name: String,
    },
    /// What was presented is not among the samples.
    #[error("`{name}` is not one of the samples or stimuli of the protocol")]
    NotPresentable { name: String },
    /// The answer does not fit.
    #[error(transparent)]
    Answer(#[from] SessionError),
    /// A note or a reason that cannot be shown.
    #[error(transparent)]
    Text(#[from] TextError),
    /// The strokes of a trial take longer.
    #[error(
        "expected at least {least_s:.1} s for {strokes}, found {passed_s:.1} s since the sample was handed over; continue the strokes, then confirm"
    )]
    TooSoon {
        strokes: String,
        least_s: f64,
        passed_s: f64,
    },
    /// Fewer strokes were found in what was recorded.
    #[error(
        "not complete: expected {expected}, found {found}; continue the strokes, then confirm, or confirm once more to leave it as it is"
    )]
    TooFew { expected: String, found: u32 },
    /// A reason is missing.
    #[error("say why in a few words")]
    NoReason,
}

/// The shortest time of a stroke and its return that is accepted, s. An assumption: five strokes a second (docs/decisions/campaigns.md).
const SHORTEST_STROKE_S: f64 = 0.2;

impl State<'_> {
    /// The event that `command` makes happen. It is stored first, and then taken up with [`State::apply`].
    ///
    /// # Errors
    /// [`Refusal`]: nothing happens and nothing is to be stored.
    pub fn decide(&self, command: &Command) -> Result<Event, Refusal> {
        if self.stage == Stage::Withdrawn {
            return Err(Refusal::NotNow {
                expected: "the participant has withdrawn".to_owned(),
            });
        }
        if let Some(decided) = self.decide_at_any_step(command) {
            return decided;
        }
        match (self.step(), command) {
            (
                Step::Begin,
                Command::Begin {
                    experimenter,
                    program,
                    purpose,
                    participant,
                },
            ) => Ok(Event::Begun {
                plan: self.plan.sha(),
                protocol: self.plan.protocol_sha,
                experimenter: experimenter.clone(),
                program: program.clone(),
                purpose: *purpose,
                participant: participant.clone(),
            }),
            (Step::AskConsent, Command::Consent { text }) => {
                Ok(Event::ConsentGiven { text: *text })
            }
            (Step::AskConsent, Command::RefuseConsent) => Ok(Event::ConsentRefused),
            (Step::Check { item, .. }, Command::Check) => Ok(Event::Checked {
                place: self
                    .current()
                    .map(|(trial, _)| checklist_place(trial))
                    .unwrap_or_default(),
                item: item.to_owned(),
            }),
            (Step::Present { trial, .. }, Command::Present { evidence }) => Ok(Event::Presented {
                trial: trial.name.clone(),
                instead: None,
                evidence: evidence.clone(),
                chosen: self.chosen(trial),
            }),
            (Step::Present { trial, .. }, Command::PresentInstead { names, evidence }) => {
                let instead = self.presentable(trial, names)?;
                Ok(Event::Presented {
                    trial: trial.name.clone(),
                    instead: Some(instead),
                    evidence: evidence.clone(),
                    chosen: self.chosen(trial),
                })
            }
            (
                Step::Present { trial, .. }
                | Step::Answer { trial, .. }
                | Step::Confirm { trial, .. },
                Command::Void { why },
            ) => Ok(Event::Voided {
                trial: trial.name.clone(),
                why: why.clone(),
            }),
            (
                Step::Answer { trial, .. } | Step::Confirm { trial, .. },
                Command::Answer { words },
            ) => self.answer_to(&trial.name, words),
            (
                Step::Answer { trial, .. } | Step::Confirm { trial, .. },
                Command::Play { element, evidence },
            ) => self.play_again(trial, *element, evidence.as_ref()),
            (Step::Answer { trial, .. }, Command::Confirm) if trial.answer == AnswerForm::Done => {
                Ok(Event::Confirmed {
                    trial: trial.name.clone(),
                    touched: None,
                })
            }
            (Step::Confirm { trial, .. }, Command::Confirm) => Ok(Event::Confirmed {
                trial: trial.name.clone(),
                touched: None,
            }),
            (Step::Answer { trial, .. }, Command::ConfirmTouched { touched })
                if self.strokes_wanted(trial).is_some() =>
            {
                Ok(Event::Confirmed {
                    trial: trial.name.clone(),
                    touched: Some(touched.clone()),
                })
            }
            (Step::GoOn, Command::GoOn) => Ok(Event::WentOn),
            (Step::End, Command::End) => Ok(Event::Ended),
            (step, _) => Err(Refusal::NotNow {
                expected: expected(&step),
            }),
        }
    }

    /// What `command` makes happen at whatever step the session is.
    fn decide_at_any_step(&self, command: &Command) -> Option<Result<Event, Refusal>> {
        Some(match command {
            Command::Note { text } => match check_long(text) {
                Ok(()) => Ok(Event::Note { text: text.clone() }),
                Err(error) => Err(error.into()),
            },
            Command::Withdraw if self.stage != Stage::New => Ok(Event::ConsentWithdrawn),
            Command::Correct { trial, words, why } => self.correct(trial, words, why),
            Command::AnswerTo { trial, words } => self.answer_to(trial, words),
            Command::Resume {
                experimenter,
                now_ms,
            } => self.resume(experimenter, *now_ms),
            Command::Stop { why }
                if matches!(self.stage, Stage::Running | Stage::Paused | Stage::Consent) =>
            {
                match check_long(why) {
                    Err(error) => Err(error.into()),
                    Ok(()) if why.trim().is_empty() => Err(Refusal::NoReason),
                    Ok(()) => Ok(Event::Stopped { why: why.clone() }),
                }
            }
            Command::Pause if self.stage == Stage::Running => Ok(Event::Paused),
            _ => return None,
        })
    }

    /// An element of the current trial is played once more.
    fn play_again(
        &self,
        trial: &Trial,
        element: usize,
        evidence: Option<&Evidence>,
    ) -> Result<Event, Refusal> {
        let elements = self.current().map_or(0, |(_, state)| state.plays.len());
        match element < elements {
            true => Ok(Event::Played {
                trial: trial.name.clone(),
                element,
                evidence: evidence.cloned(),
            }),
            false => Err(Refusal::Unknown {
                what: "element",
                name: (element + 1).to_string(),
            }),
        }
    }

    /// An answer to a trial by its name: of the current one it counts, of a confirmed one it is journalled without effect.
    fn answer_to(&self, name: &str, words: &[String]) -> Result<Event, Refusal> {
        let Some((trial, state)) = self.trials().find(|(trial, _)| trial.name == name) else {
            return Err(unknown_trial(name));
        };
        if state.confirmed {
            return Ok(Event::Ignored {
                command: format!("answer to {name}: {}", words.join(" ")),
                why: "the trial is confirmed".to_owned(),
            });
        }
        let waits = matches!(
            self.step(),
            Step::Answer { trial: current, .. } | Step::Confirm { trial: current, .. } if current.name == name
        );
        if !waits {
            return Err(Refusal::NotNow {
                expected: expected(&self.step()),
            });
        }
        let elements = state.plays.len();
        let form = (&trial.answer, self.may_not_know(trial));
        let answer = understand(form, &self.choices(trial), elements, words)?;
        Ok(Event::Answered {
            trial: name.to_owned(),
            answer,
        })
    }

    /// Whether "I do not know" answers `trial`.
    #[must_use]
    pub fn may_not_know(&self, trial: &Trial) -> bool {
        let task = self.protocol.task(&trial.task);
        task.is_some_and(|task| task.may_not_know)
    }

    /// How many strokes are asked for in `trial`; none where it is no trial of touch.
    #[must_use]
    pub fn strokes_wanted(&self, trial: &Trial) -> Option<u32> {
        match self.protocol.task(&trial.task)?.kind {
            TaskKind::Touch { strokes } => Some(strokes),
            _ => None,
        }
    }

    /// Why the current trial is not complete where `found` strokes were made; none where it is, or is no trial of touch.
    #[must_use]
    pub fn too_few(&self, found: u32) -> Option<Refusal> {
        let (trial, _) = self.current()?;
        let wanted = self.strokes_wanted(trial)?;
        (found < wanted).then(|| Refusal::TooFew {
            expected: counted(wanted as usize, "stroke"),
            found,
        })
    }

    /// Why the current trial cannot be done yet at `now_ms`, in ms since 1970-01-01 00:00 UTC: its strokes take longer than it runs. None
    /// where it can.
    #[must_use]
    pub fn too_soon(&self, now_ms: i64) -> Option<Refusal> {
        let (trial, state) = self.current()?;
        let strokes = self.strokes_wanted(trial)?;
        let least_s = f64::from(strokes) * SHORTEST_STROKE_S;
        // A clock that jumped back says nothing.
        let passed_ms = now_ms.checked_sub(state.at_ms[0]?).filter(|ms| *ms >= 0)?;
        let passed_s = passed_ms as f64 / 1000.0;
        (passed_s < least_s).then(|| Refusal::TooSoon {
            strokes: counted(strokes as usize, "stroke"),
            least_s,
            passed_s,
        })
    }

    fn correct(&self, name: &str, words: &[String], why: &str) -> Result<Event, Refusal> {
        let Some((trial, state)) = self.trials().find(|(trial, _)| trial.name == name) else {
            return Err(unknown_trial(name));
        };
        if !state.confirmed {
            return Err(Refusal::NotNow {
                expected: format!(
                    "trial {} is not confirmed yet; until then its answer is revised, and can be corrected afterwards",
                    self.number(name)
                ),
            });
        }
        check_long(why)?;
        if why.trim().is_empty() {
            return Err(Refusal::NoReason);
        }
        let form = (&trial.answer, self.may_not_know(trial));
        let answer = understand(form, &self.choices(trial), state.plays.len(), words)?;
        Ok(Event::Corrected {
            trial: name.to_owned(),
            answer,
            why: why.to_owned(),
        })
    }

    fn resume(&self, experimenter: &str, now_ms: i64) -> Result<Event, Refusal> {
        if !matches!(self.stage, Stage::Consent | Stage::Running | Stage::Paused) {
            return Err(Refusal::NotNow {
                expected: expected(&self.step()),
            });
        }
        // A clock that jumped back says nothing about the time that passed; the journal says that it jumped.
        let after_ms = self.last_ms.map_or(0, |last| (now_ms - last).max(0));
        let after_hours = after_ms as f64 / 3.6e6;
        match after_hours > self.protocol.resuming.refused_after_hours {
            true => Ok(Event::ResumeRefused { after_hours }),
            false => Ok(Event::Resumed {
                experimenter: experimenter.to_owned(),
            }),
        }
    }

    /// What the answers so far choose for `trial`; `None` where the plan says what is presented.
    fn chosen(&self, trial: &Trial) -> Option<Vec<String>> {
        matches!(trial.presented, Presented::Chosen { .. }).then(|| self.presented(trial))
    }

    /// `names` as what was presented in `trial` instead of what was planned or chosen.
    fn presentable(&self, trial: &Trial, names: &[String]) -> Result<Vec<String>, Refusal> {
        if let Some(name) = names
            .iter()
            .find(|name| self.protocol.sample_of(name).is_none())
        {
            return Err(Refusal::NotPresentable { name: name.clone() });
        }
        let is_played = matches!(
            trial.presented,
            Presented::Rendered { .. } | Presented::Chosen { .. }
        );
        if !is_played {
            // Real samples: a manipulated texture is none, and a tray has each once.
            let mut others = (names.iter()).filter(|name| !self.protocol.samples.contains(name));
            if let Some(name) = others.next() {
                return Err(Refusal::NotPresentable { name: name.clone() });
            }
            let twice = (1..names.len()).find(|i| names[..*i].contains(&names[*i]));
            if let Some(i) = twice {
                return Err(Refusal::Answer(SessionError::NamedTwice {
                    name: names[i].clone(),
                    choices: self.protocol.samples.join(" "),
                }));
            }
        }
        let wanted = self.presented(trial).len();
        match names.len() == wanted {
            true => Ok(names.to_vec()),
            false => Err(Refusal::Answer(SessionError::Count {
                expected: wanted.to_string(),
                choices: self.protocol.samples.join(" "),
                found: names.len(),
            })),
        }
    }
}

fn unknown_trial(name: &str) -> Refusal {
    Refusal::Unknown {
        what: "trial",
        name: name.to_owned(),
    }
}

/// What the experimenter is to do at `step`.
fn expected(step: &Step<'_>) -> String {
    match step {
        Step::Begin => "begin the session".to_owned(),
        Step::AskConsent => "ask for consent".to_owned(),
        Step::Check { item, .. } => format!("confirm: {item}"),
        Step::Present { trial, .. } => match &trial.presented {
            Presented::Tray { samples } => format!("present {}", samples.join(", ")),
            Presented::Sample { sample } => format!("present {sample}"),
            // Which textures they are is not said: the experimenter is blind, too.
            Presented::Rendered { .. } | Presented::Chosen { .. } => {
                "play the textures of the trial".to_owned()
            }
        },
        Step::Answer { trial, .. } => match trial.answer {
            AnswerForm::Done => "say when it is done".to_owned(),
            _ => "an answer is awaited".to_owned(),
        },
        Step::Confirm { answer, .. } => match answer {
            Answer::Names(names) => format!("confirm or revise the answer {}", names.join(" ")),
            Answer::Places(places) => {
                let said: Vec<String> = places.iter().filter_map(|i| letters().nth(*i)).collect();
                format!("confirm or revise the answer {}", said.join(" "))
            }
            Answer::Number(number) => format!("confirm or revise the answer {number}"),
            Answer::Unknown => "confirm or revise the answer: not known".to_owned(),
            Answer::Done => "confirm that it is done".to_owned(),
        },
        Step::GoOn => "end the pause".to_owned(),
        Step::End => "end the session".to_owned(),
        Step::Nothing => "the session is over".to_owned(),
    }
}
