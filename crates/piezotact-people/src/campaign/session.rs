//! A session as a state machine: events in, state and next step out. It touches no clock, file or device.
//!
//! What happened is a list of [`Event`]s, which only grows. The state is derived from plan and events alone, so a session
//! that was cut off at any moment goes on from what is stored. [`State::decide`] says what a command of the experimenter makes
//! happen: an event to be stored, first of all, and then taken up with [`State::apply`].

mod adaptive;
mod answer;
mod decide;
mod event;
mod named;
mod warning;

use std::collections::{BTreeMap, BTreeSet};

pub use adaptive::{CatchCount, Threshold};
pub use answer::{Answer, UNKNOWN, letters};
pub use decide::{Command, Refusal};
pub use event::{Event, Evidence, Participant, TouchRecord, TouchRecording, sha_of_samples};
pub use warning::{CampaignWarning, LeftOut};

use super::chain::Sha;
use super::plan::{Plan, Presented, Trial};
use super::protocol::Protocol;
use super::store::Purpose;

/// Where a trial stands.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TrialState {
    /// How often it was begun; more than 1 after an interruption.
    pub attempts: u32,
    /// What was presented, where it was not what was planned.
    pub presented_instead: Option<Vec<String>>,
    /// What an adaptive run chose when it was presented.
    pub chosen: Option<Vec<String>>,
    /// How often each element was felt in this attempt, the first time included.
    pub plays: Vec<u32>,
    /// How often each element was felt in all attempts, also where it was cut off.
    pub felt: Vec<u32>,
    /// The elements that began to be played in this attempt, of which nothing more is known yet.
    pub begun: BTreeSet<usize>,
    /// What was measured while an element was played, with the element, in the order of the plays.
    pub evidence: Vec<(usize, Evidence)>,
    /// When each of these was noted, directly after it was played, in ms since 1970-01-01 00:00 UTC.
    pub played_ms: Vec<i64>,
    /// The answers in the order in which they were given; the last one counts.
    pub answers: Vec<Answer>,
    /// For each answer how often the participant's own order, which its letters stand for, had been corrected when it was given; for
    /// the last when it was confirmed.
    pub order_corrections: Vec<usize>,
    /// Whether the participant confirmed.
    pub confirmed: bool,
    /// How the sample was touched, where that was recorded.
    pub touched: Option<TouchRecord>,
    /// Corrections by the experimenter after the confirmation, with the reason.
    pub corrections: Vec<(Answer, String)>,
    /// How many attempts were cut off.
    pub interrupted: u32,
    /// How many attempts are void, as a device failed.
    pub voided: u32,
    /// When it was presented in this attempt, and when it was confirmed, in ms since 1970-01-01 00:00 UTC.
    pub at_ms: [Option<i64>; 2],
    /// How long pauses took between these, in ms.
    pub paused_ms: i64,
}

impl TrialState {
    /// The same trial before a further attempt.
    fn anew(&self) -> Self {
        Self {
            attempts: self.attempts,
            interrupted: self.interrupted,
            voided: self.voided,
            felt: self.felt.clone(),
            ..Self::default()
        }
    }

    /// Counts that `element` was felt; that it began to be played was counted before.
    fn feel(&mut self, element: usize) {
        if self.begun.remove(&element) {
            return;
        }
        if self.felt.len() <= element {
            self.felt.resize(element + 1, 0);
        }
        self.felt[element] += 1;
    }

    /// Whether something of this attempt was felt.
    fn is_under_way(&self) -> bool {
        self.is_presented() || !self.begun.is_empty()
    }

    /// The time from the presentation to the confirmation without pauses, in s; `None` before, and where the clock jumped back between.
    #[must_use]
    pub fn seconds(&self) -> Option<f64> {
        let [presented, confirmed] = self.at_ms;
        let passed_ms = confirmed? - presented? - self.paused_ms;
        (passed_ms >= 0).then_some(passed_ms as f64 / 1000.0)
    }

    /// What was measured while `element` was played in this attempt.
    pub fn evidence_of(&self, element: usize) -> impl Iterator<Item = &Evidence> {
        let of_element = move |(which, _): &&(usize, Evidence)| *which == element;
        self.evidence.iter().filter(of_element).map(|(_, one)| one)
    }

    /// The answer that counts: the last correction, or the last confirmed answer.
    #[must_use]
    pub fn answer(&self) -> Option<&Answer> {
        match self.corrections.last() {
            Some((answer, _)) => Some(answer),
            None => self.as_confirmed(),
        }
    }

    /// The answer that counted after the first `count` corrections.
    fn after_corrections(&self, count: usize) -> Option<&Answer> {
        match self.corrections[..count.min(self.corrections.len())].last() {
            Some((answer, _)) => Some(answer),
            None => self.as_confirmed(),
        }
    }

    /// The answer that was confirmed, whatever was corrected since.
    #[must_use]
    pub fn as_confirmed(&self) -> Option<&Answer> {
        self.answers.last().filter(|_| self.confirmed)
    }
}

/// Where a session stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Not begun.
    New,
    /// Begun; consent is not given yet.
    Consent,
    /// Under way.
    Running,
    /// In a pause.
    Paused,
    /// Cut off, and refused to go on: too late, or the participant said so.
    Stopped,
    /// Ended; nothing can be added but corrections.
    Ended,
    /// Consent was withdrawn: everything is to be erased.
    Withdrawn,
}

/// The next step of a session.
#[derive(Clone, Debug, PartialEq)]
pub enum Step<'a> {
    /// The session is to be begun.
    Begin,
    /// The participant is asked for consent.
    AskConsent,
    /// The experimenter confirms an item of a task's checklist.
    Check { task: &'a str, item: &'a str },
    /// The trial is to be presented.
    Present {
        trial: &'a Trial,
        /// Which attempt this is, from 1.
        attempt: u32,
    },
    /// The trial is presented; an answer is awaited.
    Answer {
        trial: &'a Trial,
        state: &'a TrialState,
    },
    /// An answer was given; it can be revised, and is to be confirmed.
    Confirm {
        trial: &'a Trial,
        answer: &'a Answer,
    },
    /// The session is in a pause.
    GoOn,
    /// All trials are confirmed; the session is to be ended.
    End,
    /// There is nothing left to do.
    Nothing,
}

/// The state of a session.
#[derive(Clone, Debug)]
pub struct State<'a> {
    protocol: &'a Protocol,
    plan: &'a Plan,
    stage: Stage,
    purpose: Option<Purpose>,
    participant: Participant,
    /// By the place in the plan.
    trials: Vec<TrialState>,
    /// Adaptive runs by name; none where a rule cannot be followed, which no session begins with.
    runs: BTreeMap<&'a str, adaptive::Run<'a>>,
    /// Items of checklists that are confirmed, by task and set.
    checked: BTreeSet<(String, String)>,
    /// What was journalled without effect.
    ignored: u32,
    /// Times at which the clock of the computer jumped back, in ms.
    jumps_back_ms: Vec<i64>,
    began_ms: Option<i64>,
    paused_at_ms: Option<i64>,
    last_ms: Option<i64>,
    events: u64,
}

/// An event that does not fit the ones before it, as the journal was not written by this state machine, or a text that is no answer.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SessionError {
    /// It is about a plan or protocol other than the one given.
    #[error(
        "the session was begun with the {what} {found}, and the one given is {given}; restore the earlier {what}, or begin a new session for another participant"
    )]
    Changed {
        /// "plan" or "protocol".
        what: &'static str,
        /// The checksum in the journal.
        found: Sha,
        /// That of what was given.
        given: Sha,
    },
    /// An event about something that the plan does not have, or that cannot happen now.
    #[error("event {number} cannot follow the events before it: {why}")]
    Order { number: u64, why: String },
    /// Not one of the choices.
    #[error("`{found}` is not one of the choices {choices}")]
    NoChoice { found: String, choices: String },
    /// Another number of names.
    #[error("expected {expected} of {choices}, found {found}")]
    Count {
        expected: String,
        choices: String,
        /// How many were given.
        found: usize,
    },
    /// The same name twice in an order.
    #[error("`{name}` stands twice; name each of {choices} once")]
    NamedTwice { name: String, choices: String },
    /// No number within the scale.
    #[error("expected a whole number from {from} to {to}, found `{found}`")]
    Scale { from: i64, to: i64, found: String },
}

impl<'a> State<'a> {
    /// The state before anything happened.
    #[must_use]
    pub fn new(protocol: &'a Protocol, plan: &'a Plan) -> Self {
        Self {
            protocol,
            plan,
            stage: Stage::New,
            purpose: None,
            participant: Participant::default(),
            trials: vec![TrialState::default(); plan.trials.len()],
            runs: adaptive::runs(plan).unwrap_or_default(),
            checked: BTreeSet::new(),
            ignored: 0,
            jumps_back_ms: Vec::new(),
            began_ms: None,
            paused_at_ms: None,
            last_ms: None,
            events: 0,
        }
    }

    /// The state after `events`, each with its time in ms since 1970-01-01 00:00 UTC.
    ///
    /// # Errors
    /// [`SessionError`] with the first event that does not fit.
    pub fn after(
        protocol: &'a Protocol,
        plan: &'a Plan,
        events: impl IntoIterator<Item = (i64, Event)>,
    ) -> Result<Self, SessionError> {
        let mut state = Self::new(protocol, plan);
        for (at_ms, event) in events {
            state.apply(at_ms, &event)?;
        }
        Ok(state)
    }

    /// The stage.
    #[must_use]
    pub fn stage(&self) -> Stage {
        self.stage
    }

    /// As what it was begun: with a volunteer, or as a rehearsal. `None` before.
    #[must_use]
    pub fn purpose(&self) -> Option<Purpose> {
        self.purpose
    }

    /// The protocol.
    #[must_use]
    pub fn protocol(&self) -> &'a Protocol {
        self.protocol
    }

    /// Who takes part.
    #[must_use]
    pub fn participant(&self) -> &Participant {
        &self.participant
    }

    /// The plan.
    #[must_use]
    pub fn plan(&self) -> &'a Plan {
        self.plan
    }

    /// The trials with their states, in the order of the plan.
    pub fn trials(&self) -> impl Iterator<Item = (&'a Trial, &TrialState)> {
        self.plan.trials.iter().zip(&self.trials)
    }

    /// When it was begun, in ms since 1970-01-01 00:00 UTC; `None` before.
    #[must_use]
    pub fn began_ms(&self) -> Option<i64> {
        self.began_ms
    }

    /// When the last event was, in ms since 1970-01-01 00:00 UTC.
    #[must_use]
    pub fn last_ms(&self) -> Option<i64> {
        self.last_ms
    }

    /// How many events it was made from.
    #[must_use]
    pub fn events(&self) -> u64 {
        self.events
    }

    /// How many events were journalled without effect.
    #[must_use]
    pub fn ignored(&self) -> u32 {
        self.ignored
    }

    /// How far the clock of the computer jumped back, each time, in ms. Times between such events say nothing.
    #[must_use]
    pub fn jumps_back_ms(&self) -> &[i64] {
        &self.jumps_back_ms
    }

    /// How many trials are confirmed.
    #[must_use]
    pub fn confirmed(&self) -> usize {
        self.trials.iter().filter(|trial| trial.confirmed).count()
    }

    /// The first trial that is not confirmed, and is needed: an adaptive run can end before its last one.
    #[must_use]
    pub fn current(&self) -> Option<(&'a Trial, &TrialState)> {
        let at = self.place()?;
        Some((&self.plan.trials[at], &self.trials[at]))
    }

    /// The place of the current trial in the plan.
    fn place(&self) -> Option<usize> {
        let open = |at: &usize| {
            let state = &self.trials[*at];
            !state.confirmed && (state.is_presented() || self.needs(*at))
        };
        (0..self.trials.len()).find(open)
    }

    /// The next step.
    #[must_use]
    pub fn step(&self) -> Step<'_> {
        match self.stage {
            Stage::New => return Step::Begin,
            Stage::Consent => return Step::AskConsent,
            Stage::Paused => return Step::GoOn,
            Stage::Stopped | Stage::Ended | Stage::Withdrawn => return Step::Nothing,
            Stage::Running => {}
        }
        let Some((trial, state)) = self.current() else {
            return Step::End;
        };
        if state.attempts == 0 || state.plays.is_empty() {
            if let Some(item) = self.unchecked(trial) {
                return Step::Check {
                    task: &trial.task,
                    item,
                };
            }
            return Step::Present {
                trial,
                attempt: state.attempts + 1,
            };
        }
        match state.answers.last() {
            None => Step::Answer { trial, state },
            Some(answer) => Step::Confirm { trial, answer },
        }
    }

    /// The first item of the checklist of `trial`'s task that is not confirmed for its block, or for its set where the samples
    /// change.
    fn unchecked(&self, trial: &Trial) -> Option<&'a str> {
        let task = self.protocol.task(&trial.task)?;
        let place = checklist_place(trial);
        task.checklist
            .iter()
            .find(|item| !self.checked.contains(&(place.clone(), (*item).clone())))
            .map(String::as_str)
    }

    /// Takes up an event that is stored.
    ///
    /// # Errors
    /// [`SessionError`] where it cannot follow the events before it; the state is unchanged then.
    pub fn apply(&mut self, at_ms: i64, event: &Event) -> Result<(), SessionError> {
        self.take(event)?;
        if let Event::Presented { trial, .. } = event {
            let state = self.trial_state(trial)?;
            state.at_ms[0] = Some(at_ms);
            state.paused_ms = 0;
            state.played_ms.clear();
        }
        if let Event::Presented { trial, .. } | Event::Played { trial, .. } = event {
            let state = self.trial_state(trial)?;
            state.played_ms.resize(state.evidence.len(), at_ms);
        }
        if matches!(event, Event::Begun { .. }) {
            self.began_ms = Some(at_ms);
        }
        if let Event::Confirmed { trial, .. } = event {
            self.trial_state(trial)?.at_ms[1] = Some(at_ms);
        }
        if matches!(event, Event::Paused) {
            self.paused_at_ms = Some(at_ms);
        } else if self.stage != Stage::Paused
            && let Some(since_ms) = self.paused_at_ms.take()
            && let Some(at) = self.place()
        {
            // A clock that jumped back says nothing of a pause.
            self.trials[at].paused_ms += at_ms.saturating_sub(since_ms).max(0);
        }
        self.follow();
        if let Some(last) = self.last_ms
            && at_ms < last
        {
            self.jumps_back_ms.push(last - at_ms);
        }
        self.last_ms = Some(at_ms);
        self.events += 1;
        Ok(())
    }

    fn take(&mut self, event: &Event) -> Result<(), SessionError> {
        match event {
            Event::Begun {
                plan,
                protocol,
                purpose,
                participant,
                ..
            } => {
                same("protocol", *protocol, self.plan.protocol_sha)?;
                same("plan", *plan, self.plan.sha())?;
                adaptive::runs(self.plan).map_err(|error| SessionError::Order {
                    number: self.events,
                    why: error.to_string(),
                })?;
                self.stage = Stage::Consent;
                self.purpose = Some(*purpose);
                self.participant = participant.clone();
            }
            Event::ConsentGiven { .. } => self.stage = Stage::Running,
            Event::ConsentRefused => self.stage = Stage::Ended,
            Event::Checked { place, item } => {
                self.checked.insert((place.clone(), item.clone()));
            }
            Event::Presented {
                trial,
                instead,
                evidence,
                chosen,
            } => {
                let (instead, chosen) = (instead.as_deref(), chosen.as_deref());
                self.presented_first(trial, instead, evidence, chosen)?;
            }
            Event::PlayBegan { trial, element } => self.play_began(trial, *element)?,
            Event::Voided { trial, .. } => {
                let state = self.trial_state(trial)?;
                // It failed while it was presented for the first time in this attempt.
                let unpresented = u32::from(state.plays.is_empty());
                *state = state.anew();
                state.attempts += unpresented;
                state.voided += 1;
            }
            Event::Played {
                trial,
                element,
                evidence,
            } => {
                let number = self.events;
                let state = self.trial_state(trial)?;
                let Some(plays) = state.plays.get_mut(*element) else {
                    return Err(SessionError::Order {
                        number,
                        why: format!("trial {trial} has no element {element}"),
                    });
                };
                *plays += 1;
                state.feel(*element);
                let evidence = evidence.iter().cloned();
                state.evidence.extend(evidence.map(|one| (*element, one)));
            }
            Event::Answered { trial, answer } => {
                let corrected = self.order_corrections(trial);
                let state = self.trial_state(trial)?;
                state.answers.push(answer.clone());
                state.order_corrections.push(corrected);
            }
            Event::Confirmed { trial, touched } => {
                let corrected = self.order_corrections(trial);
                let state = self.trial_state(trial)?;
                state.confirmed = true;
                state.touched.clone_from(touched);
                if let Some(last) = state.order_corrections.last_mut() {
                    *last = corrected;
                }
            }
            Event::Corrected { trial, answer, why } => {
                let correction = (answer.clone(), why.clone());
                self.trial_state(trial)?.corrections.push(correction);
            }
            Event::Paused => self.stage = Stage::Paused,
            Event::WentOn => self.stage = Stage::Running,
            Event::Resumed { .. } => {
                self.interrupted();
                self.stage = match self.stage {
                    Stage::Paused => Stage::Running,
                    other => other,
                };
            }
            Event::ResumeRefused { .. } | Event::Stopped { .. } => self.stage = Stage::Stopped,
            Event::ConsentWithdrawn => self.stage = Stage::Withdrawn,
            Event::Ended => self.stage = Stage::Ended,
            Event::Note { .. } => {}
            Event::Ignored { .. } => self.ignored += 1,
        }
        Ok(())
    }

    /// A trial was presented once: `instead` of what was planned, or as the answers before it have `chosen`.
    fn presented_first(
        &mut self,
        trial: &str,
        instead: Option<&[String]>,
        evidence: &[Evidence],
        chosen: Option<&[String]>,
    ) -> Result<(), SessionError> {
        let planned = &self.trial(trial)?.presented;
        if matches!(planned, Presented::Chosen { .. }) != chosen.is_some() {
            return Err(SessionError::Order {
                number: self.events,
                why: format!("{trial}: what was chosen stands only where the answers choose"),
            });
        }
        let elements = chosen.unwrap_or(planned.names()).len();
        let state = self.trial_state(trial)?;
        state.attempts += 1;
        state.chosen = chosen.map(<[String]>::to_vec);
        state.plays = vec![1; instead.map_or(elements, <[String]>::len)];
        for element in 0..state.plays.len() {
            state.feel(element);
        }
        state.presented_instead = instead.map(<[String]>::to_vec);
        state.evidence = evidence.iter().cloned().enumerate().collect();
        Ok(())
    }

    fn play_began(&mut self, trial: &str, element: usize) -> Result<(), SessionError> {
        let number = self.events;
        let elements = self.presented(self.trial(trial)?).len();
        let state = self.trial_state(trial)?;
        if element >= elements {
            return Err(SessionError::Order {
                number,
                why: format!("trial {trial} has no element {element}"),
            });
        }
        // Twice in one attempt: the first was not acknowledged by the store, and did not sound.
        if !state.begun.contains(&element) {
            state.feel(element);
            state.begun.insert(element);
        }
        Ok(())
    }

    /// The trial that was under way when the session was cut off is repeated from its beginning.
    fn interrupted(&mut self) {
        let Some(at) = self.place() else {
            return;
        };
        // Checklists are confirmed again: spectacles and earmuffs were taken off.
        self.checked.clear();
        let state = &mut self.trials[at];
        if state.is_under_way() {
            // It was cut off while it was presented for the first time in this attempt.
            let unpresented = u32::from(!state.is_presented());
            *state = state.anew();
            state.attempts += unpresented;
            state.interrupted += 1;
        }
    }

    fn trial(&self, name: &str) -> Result<&'a Trial, SessionError> {
        self.plan
            .trials
            .iter()
            .find(|trial| trial.name == name)
            .ok_or_else(|| SessionError::Order {
                number: self.events,
                why: format!("the plan has no trial {name}"),
            })
    }

    fn trial_state(&mut self, name: &str) -> Result<&mut TrialState, SessionError> {
        let number = self.events;
        let at = self.plan.trials.iter().position(|trial| trial.name == name);
        at.map(|at| &mut self.trials[at])
            .ok_or_else(|| SessionError::Order {
                number,
                why: format!("the plan has no trial {name}"),
            })
    }

    /// Whether it was ended with every trial that is needed confirmed: an adaptive run can end before its last one.
    #[must_use]
    pub fn is_complete(&self) -> bool {
        let progress = self.progress();
        let mut tasks = progress.values();
        self.stage == Stage::Ended && tasks.all(|(confirmed, needed)| confirmed == needed)
    }

    /// Trials by task with how many are confirmed: `(confirmed, planned)`. Trials that an ended run does not need are not planned
    /// any more.
    #[must_use]
    pub fn progress(&self) -> BTreeMap<&'a str, (usize, usize)> {
        let mut progress = BTreeMap::new();
        for (at, (trial, state)) in self.trials().enumerate() {
            let (confirmed, planned): &mut (usize, usize) =
                progress.entry(trial.task.as_str()).or_default();
            *confirmed += usize::from(state.confirmed);
            *planned += usize::from(state.is_presented() || self.needs(at));
        }
        progress
    }
}

/// For what an item of a checklist is confirmed: once for each task of a block.
fn checklist_place(trial: &Trial) -> String {
    match &trial.set {
        Some(set) => format!("{}.{}.{set}", trial.block, trial.task),
        None => format!("{}.{}", trial.block, trial.task),
    }
}

fn same(what: &'static str, found: Sha, given: Sha) -> Result<(), SessionError> {
    match found == given {
        true => Ok(()),
        false => Err(SessionError::Changed { what, found, given }),
    }
}

#[cfg(test)]
mod tests;
