//! Campaigns with virtual volunteers: everything from the first stroke to the last answer on the digital twin, through the plan, runner
//! and store of a campaign with people.
//!
//! A volunteer judges what was recorded on the nail ([`piezotact_people::judge::Cues`]) and is never handed the name of a texture.

mod averaged;
mod error;
mod laboratory;
mod measured;
mod person;
mod sitting;

use averaged::averaged;

pub use error::VolunteerError;
pub use laboratory::{Laboratory, characterised, resting};
pub use measured::{Taken, run, take};
pub use person::{VirtualVolunteer, Whose, volunteer};
pub use sitting::sit;

use std::collections::{BTreeMap, BTreeSet};

use piezotact::quantity::{Acceleration, Decibels, Drive};
use piezotact::recording::Recording;
use piezotact::transfer::TransferFunction;
use piezotact_people::association::{Answer, Declared, answers_of, declared};
use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::plan::{Plan, PlanRequest, Presented, Trial, plan};
use piezotact_people::campaign::protocol::{Playing, Protocol, TaskKind, TransferFunctionUse};
use piezotact_people::campaign::store::{Purpose, SessionKey, Store};
use piezotact_people::judge::{Answers, Judge, Touch};
use piezotact_study::session::state_of;
use piezotact_twin::{Participant, Sample, TwinParameters};

/// What chapter 6 of the thesis calls three samples.
const SURFACES: [[&str; 2]; 3] = [["rough", "M8"], ["biomimetic", "BIO"], ["smooth", "M3"]];
/// The samples of a segment of the PSD of strokes.
const STROKE_SEGMENT: usize = 1_024;
/// The strokes on each sample where the protocol does not say how many.
const USUAL_STROKES: u32 = 10;
/// About how long the steady part of a stroke is, s.
const USUAL_STROKE_S: f64 = 1.8;
/// About how many strokes can be played in the time that touching a sample and rendering its drive take.
const STROKES_OF_A_DRIVE: f64 = 12.0;
/// A trial in which nothing is played, compared with a stroke that is played.
const SILENT_TRIAL: f64 = 0.1;

/// A campaign to be simulated.
#[derive(Clone, Debug)]
pub struct Simulation<'a> {
    pub protocol: &'a Protocol,
    /// The SHA-256 of its file.
    pub protocol_sha: Sha,
    /// The seed of campaign, people and noise.
    pub seed: u64,
    /// How the volunteers judge.
    pub judge: Judge,
    /// Their mean sense of touch.
    pub touch: Touch,
    pub parameters: TwinParameters,
    /// Strokes on each real sample, of which one is rendered.
    pub strokes: u32,
    /// How long the transfer function is measured, s.
    pub excitation_s: f64,
    /// Corrections of each drive in a closed loop at most; 0 for the open loop.
    pub iterations: usize,
    /// Between which levels the rendered textures lie re the recorded strokes.
    pub level: LevelRule,
    /// The average transfer function of a panel to which no volunteer belongs, for protocols that render with it.
    pub average: Option<TransferFunction<Drive, Acceleration>>,
    /// How much of each presentation is played.
    pub playings: Playings,
    /// The twin's samples, by the name that the protocol has for them where it is another.
    pub surfaces: BTreeMap<String, String>,
    /// Strokes that were recorded on samples of the protocol, by their names; see [`Self::with_recorded`].
    pub recorded: BTreeMap<String, (Taken, Recording)>,
}

/// How much of a repeated texture the bench plays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Playings {
    /// All strokes, as the protocol has it.
    Whole,
    /// One stroke, which counts as often as the protocol repeats it: for many panels. Nothing is left of what changes from one stroke
    /// of a presentation to the next.
    OneStroke,
}

/// The level at which the textures of a person are rendered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LevelRule {
    /// One for all: the highest at which all fit the device, 0 dB or below.
    Common,
    /// For each the highest at which it fits, 0 dB or below.
    Fit,
    /// This one.
    Stated(Decibels),
}

impl Simulation<'_> {
    /// What is usual: as many strokes on each sample as the protocol has in its measurement (ten where it has none), 30 s of random
    /// drive, six corrections, one level for all textures.
    #[must_use]
    pub fn usual(protocol: &Protocol, protocol_sha: Sha, seed: u64) -> Simulation<'_> {
        Simulation {
            protocol,
            protocol_sha,
            seed,
            judge: Judge::Thurstone,
            touch: Touch::mean_person(),
            parameters: TwinParameters::built_in(),
            strokes: strokes(protocol),
            excitation_s: 30.0,
            iterations: 6,
            level: LevelRule::Common,
            average: None,
            playings: Playings::Whole,
            surfaces: SURFACES
                .map(|[name, sample]| (name.to_owned(), sample.to_owned()))
                .into(),
            recorded: BTreeMap::new(),
        }
    }

    /// The surface of the twin that the protocol's sample `name` is.
    ///
    /// # Errors
    /// What the twin does not have.
    pub fn surface(&self, name: &str) -> Result<&Sample, VolunteerError> {
        let known = self.surfaces.get(name).map_or(name, String::as_str);
        let sample = self.parameters.sample(known);
        Ok(sample?)
    }

    /// The same with strokes that were recorded on the sample `name`, in place of a surface of the twin: all volunteers meet these strokes, with
    /// the friction that they have and no pattern.
    ///
    /// # Errors
    /// What cannot be cut into strokes.
    pub fn with_recorded(
        mut self,
        name: &str,
        recording: Recording,
    ) -> Result<Self, VolunteerError> {
        let strokes = measured::taken(&recording, STROKE_SEGMENT)?;
        self.recorded.insert(name.to_owned(), (strokes, recording));
        Ok(self)
    }

    /// The panel whose average the protocol renders with; `None` where everybody has the own transfer function.
    #[must_use]
    pub fn panel(&self) -> Option<&str> {
        match &self.protocol.rendering.as_ref()?.transfer_function {
            TransferFunctionUse::Average { panel } => Some(panel),
            TransferFunctionUse::Own => None,
        }
    }

    /// The same with the average transfer function of the people `members`, none of whom is among the volunteers `numbers`: the
    /// mean of the logarithms of their gains on the device, 20° and 0.2 N.
    ///
    /// # Errors
    /// [`VolunteerError::Overlap`], and what the twin refuses.
    pub fn with_panel(
        self,
        members: impl IntoIterator<Item = u64>,
        numbers: impl IntoIterator<Item = u64>,
    ) -> Result<Self, VolunteerError> {
        let members: BTreeSet<u64> = members.into_iter().collect();
        if let Some(number) = numbers.into_iter().find(|one| members.contains(one)) {
            return Err(VolunteerError::Overlap { number });
        }
        Ok(Self {
            average: Some(averaged(&self, &members)?),
            ..self
        })
    }

    /// What the protocol declares, and every confirmed answer of the sessions of `plans` in `store`.
    ///
    /// # Errors
    /// [`VolunteerError::Run`] where what is stored does not belong to them.
    pub fn answers(
        &self,
        store: &dyn Store,
        plans: &[Plan],
    ) -> Result<(Declared, Vec<Answer>), VolunteerError> {
        let mut answers = Vec::new();
        for plan in plans {
            let state = state_of(store, self.protocol, plan)?;
            answers.extend(answers_of(&state, Purpose::Volunteer));
        }
        Ok((declared(self.protocol), answers))
    }

    /// What the steps of one volunteer take compared with each other: measuring and rendering first, then each trial as it is planned for
    /// the first who comes. A stroke that is played is 1.
    ///
    /// # Errors
    /// [`VolunteerError::Plan`].
    pub fn steps(&self) -> Result<Vec<f64>, VolunteerError> {
        let strokes = match self.protocol.rendering.as_ref().map(|one| one.playing) {
            Some(Playing::Repeated {
                pause_s,
                duration_s,
            }) if self.playings == Playings::Whole => {
                (duration_s / (pause_s + USUAL_STROKE_S)).max(1.0)
            }
            _ => 1.0,
        };
        let textures = self.protocol.samples.len() + self.protocol.stimuli.len();
        let mut steps = vec![STROKES_OF_A_DRIVE * textures as f64];
        for session in &self.protocol.sessions {
            let request = PlanRequest {
                seed: self.seed,
                participant: "P01",
                session: &session.name,
                completed: &[],
            };
            let plan = plan(self.protocol, self.protocol_sha, request)?;
            let played = |trial: &Trial| match &trial.presented {
                Presented::Rendered { stimuli } => stimuli.len() as f64,
                Presented::Chosen { .. } => 2.0,
                Presented::Sample { .. } | Presented::Tray { .. } => 0.0,
            };
            let sizes = plan
                .trials
                .iter()
                .map(|trial| SILENT_TRIAL + strokes * played(trial));
            steps.extend(sizes);
        }
        Ok(steps)
    }

    /// The volunteers `numbers` come one after the other for all their sessions, and everything is kept in `store`. Each is planned on
    /// arrival. `step` is called before each step, and its error ends the simulation. A session that is complete in `store` is skipped; an
    /// interrupted one is continued.
    ///
    /// # Errors
    /// [`VolunteerError`] with the first thing that cannot be, and those of `step`.
    pub fn run<E: From<VolunteerError>>(
        &self,
        numbers: impl IntoIterator<Item = u64>,
        store: &mut dyn Store,
        step: &mut dyn FnMut(Arrival<'_>) -> Result<(), E>,
    ) -> Result<Simulated, E> {
        let (mut completed, mut done) = (Vec::new(), Simulated::default());
        for number in numbers {
            let mut ready = None;
            let pseudonym = pseudonym(self, number);
            for session in &self.protocol.sessions {
                let request = PlanRequest {
                    seed: self.seed,
                    participant: &pseudonym,
                    session: &session.name,
                    completed: &completed,
                };
                let plan = plan(self.protocol, self.protocol_sha, request);
                let plan = plan.map_err(VolunteerError::from)?;
                if is_complete(self.protocol, store, &plan)? {
                    done.taken_up += 1;
                    step(Arrival::TakenUp { plan: &plan })?;
                } else {
                    if ready.is_none() {
                        step(Arrival::Measured {
                            pseudonym: &pseudonym,
                        })?;
                        ready = Some(volunteer(self, number, Whose::Own)?);
                        step(Arrival::Ready)?;
                    }
                    if let Some(ready) = &ready {
                        step(Arrival::Planned {
                            plan: &plan,
                            volunteer: ready,
                        })?;
                        let whole = !is_begun(store, &plan)?;
                        let mut error = None;
                        let answers = sit(self, ready, &plan, store, &mut |trials| {
                            if error.is_none() {
                                error = step(Arrival::Trial { trials }).err();
                            }
                        })?;
                        if let Some(error) = error {
                            return Err(error);
                        }
                        step(Arrival::Answered {
                            plan: &plan,
                            answers: &answers,
                            whole,
                        })?;
                        let Answers { choices, orders } = answers;
                        done.answers.choices.extend(choices);
                        done.answers.orders.extend(orders);
                    }
                }
                completed.push(plan.as_completed());
                done.plans.push(plan);
            }
            step(Arrival::Gone)?;
        }
        Ok(done)
    }
}

/// The strokes on each sample where they are measured.
fn strokes(protocol: &Protocol) -> u32 {
    let touched = protocol.tasks.iter().filter_map(|task| match task.kind {
        TaskKind::Touch { strokes } => Some(strokes),
        _ => None,
    });
    touched.max().unwrap_or(USUAL_STROKES)
}

/// A step of a simulated campaign.
#[derive(Clone, Copy, Debug)]
pub enum Arrival<'a> {
    /// A volunteer comes; strokes, transfer function and drives are measured.
    Measured { pseudonym: &'a str },
    /// A session begins, as it is planned.
    Planned {
        plan: &'a Plan,
        volunteer: &'a VirtualVolunteer,
    },
    /// All of it is rendered.
    Ready,
    /// A trial is over.
    Trial {
        /// How many trials of the session are over.
        trials: usize,
    },
    /// A session was complete before.
    TakenUp { plan: &'a Plan },
    /// A session is over.
    Answered {
        plan: &'a Plan,
        /// What was felt with what was answered, of the trials that were answered now.
        answers: &'a Answers,
        /// Whether these are all its trials: it was not begun before.
        whole: bool,
    },
    /// All sessions of a volunteer are done.
    Gone,
}

/// A simulated campaign.
#[derive(Debug, Default)]
pub struct Simulated {
    /// The plans of all sessions in their order.
    pub plans: Vec<Plan>,
    /// How many sessions were complete before.
    pub taken_up: usize,
    /// What was felt with what was answered, of the sessions that were done now.
    pub answers: Answers,
}

/// Whether the session of `plan` is complete in `store`.
fn is_complete(
    protocol: &Protocol,
    store: &dyn Store,
    plan: &Plan,
) -> Result<bool, VolunteerError> {
    let key = SessionKey::new(&plan.participant, &plan.session);
    let sessions = store.sessions()?;
    if !sessions.iter().any(|entry| entry.key == key) {
        return Ok(false);
    }
    Ok(state_of(store, protocol, plan)?.is_complete())
}

/// Whether something of the session of `plan` is in `store`.
fn is_begun(store: &dyn Store, plan: &Plan) -> Result<bool, VolunteerError> {
    let key = SessionKey::new(&plan.participant, &plan.session);
    let is_there = store.sessions()?.iter().any(|entry| entry.key == key);
    Ok(is_there && !store.events(&key)?.is_empty())
}

/// The pseudonym of volunteer `number`.
fn pseudonym(simulation: &Simulation<'_>, number: u64) -> String {
    Participant::of(number, simulation.seed, &simulation.parameters).pseudonym()
}
