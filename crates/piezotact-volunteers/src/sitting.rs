//! A virtual volunteer in a session: the same runner and store as with people, and answers from what was delivered.

use crate::VolunteerError;
use piezotact_study::session::RunError;
use std::collections::BTreeMap;

use piezotact::quantity::{Acceleration, Band, Degrees, Drive, Newtons};
use piezotact::recording::Recording;
use piezotact::run::Discard;
use piezotact::series::Series;
use piezotact::statistics::random::Random;
use piezotact::statistics::rms;
use piezotact_bench::procedure::{ACCELERATION_CHANNEL, DRIVE_CHANNEL, RunKeeper};
use piezotact_people::campaign::chain::{Salt, Sha};
use piezotact_people::campaign::plan::{AnswerForm, Plan, Presented, Trial};
use piezotact_people::campaign::protocol::{Playing, Protocol, Question, TaskKind};
use piezotact_people::campaign::session::{
    Command, Evidence, Participant as Described, State, Step, TrialState,
};
use piezotact_people::campaign::store::{Purpose, SessionKey, Store};
use piezotact_people::judge::{
    Answers, ChoiceAnswer, Cues, Judge, JudgeError, Look, Moment, OrderAnswer, Person, Recall,
    Sameness, TouchedTexture,
};
use piezotact_study::session::{
    BenchStimulator, Given, Outside, PlayStop, Played, Runner, Stimulator, Stimuli, StopHandle,
};

use crate::person::{VirtualVolunteer, band};
use crate::{Laboratory, Playings, Simulation};

/// When the first session of a simulated campaign begins, in ms since 1970-01-01 00:00 UTC, and how far sessions are apart.
const FIRST_MS: i64 = 1_700_000_000_000;
const BETWEEN_MS: i64 = 86_400_000;
/// The time of one command, in ms.
const COMMAND_MS: i64 = 5_000;
/// A trial that is void this often ends the simulation.
const MOST_VOID: u32 = 3;

/// Which element of which trial.
type Element = (String, usize);

/// A bench that keeps what was delivered, by the place of the playing and never by the name of the stimulus.
struct Felt<'a> {
    bench: BenchStimulator<'a>,
    band: Band,
    delivered: BTreeMap<Element, Vec<Cues>>,
}

impl Stimulator for Felt<'_> {
    fn check(&self, stimulus: &str) -> Result<(), RunError> {
        self.bench.check(stimulus)
    }

    fn play(&mut self, played: Played<'_>, stop: &StopHandle) -> Result<Evidence, RunError> {
        let place = (played.trial.to_owned(), played.element);
        let (evidence, recording) = self.bench.play_recorded(played, stop)?;
        let cues = delivered(&recording, self.band).map_err(RunError::Device)?;
        self.delivered.entry(place).or_default().push(cues);
        Ok(evidence)
    }
}

/// The blocks in which a drive is looked at, s, and the share of the loudest block from which it counts as playing.
const BLOCK_S: f64 = 0.05;
const PLAYING_SHARE: f64 = 0.1;

/// The cues of what a recording of a playing says was delivered while the drive played: pauses are not felt as a texture.
pub(super) fn delivered(recording: &Recording, band: Band) -> Result<Cues, String> {
    let response = recording.series::<Acceleration>(Some(ACCELERATION_CHANNEL));
    let response = response.map_err(|error| error.to_string())?;
    let drive = recording.series::<Drive>(Some(DRIVE_CHANNEL));
    let drive = drive.map_err(|error| error.to_string())?;
    let block = |rate_hz: f64| ((BLOCK_S * rate_hz).round() as usize).max(1);
    let levels = drive.samples().chunks(block(drive.rate().hz())).map(rms);
    let levels: Vec<f64> = levels.collect();
    let least = PLAYING_SHARE * levels.iter().copied().fold(0.0, f64::max);
    let parts = response.samples().chunks(block(response.rate().hz()));
    let felt = parts.zip(&levels).filter(|(_, level)| **level > least);
    let felt: Vec<f64> = felt.flat_map(|(part, _)| part.iter().copied()).collect();
    let felt = Series::<Acceleration>::new(felt, response.rate());
    let felt = felt.map_err(|error| error.to_string())?;
    Cues::of(&felt, band).map_err(|error| error.to_string())
}

/// When the last event of the session of `plan` was, in ms; 0 where there is none.
fn last_ms(store: &dyn Store, plan: &Plan) -> Result<i64, VolunteerError> {
    let key = SessionKey::new(&plan.participant, &plan.session);
    if !store.sessions()?.iter().any(|entry| entry.key == key) {
        return Ok(0);
    }
    Ok(store.events(&key)?.last().map_or(0, |event| event.at_ms))
}

/// Everything that happens in the session of `plan` with `volunteer` at the device: begun, or gone on with where `store` has it. Returns
/// what was felt and answered in the trials of this run. `trial_over` is called after each trial with the number of trials done.
///
/// # Errors
/// [`VolunteerError`] with the first thing that cannot be.
pub fn sit(
    simulation: &Simulation<'_>,
    volunteer: &VirtualVolunteer,
    plan: &Plan,
    store: &mut dyn Store,
    trial_over: &mut dyn FnMut(usize),
) -> Result<Answers, VolunteerError> {
    let protocol = simulation.protocol;
    let mut felt = Felt {
        bench: bench(simulation, volunteer)?,
        band: band()?,
        delivered: BTreeMap::new(),
    };
    let place = protocol.sessions.iter();
    let place = place.take_while(|one| one.name != plan.session).count();
    let mut now =
        FIRST_MS + BETWEEN_MS * (i64::try_from(volunteer.number).unwrap_or(0) * 8 + place as i64);
    // Gone on with, its times follow those that are there.
    now = now.max(last_ms(store, plan)?);
    let mut salts = Random::stream(
        simulation.seed,
        volunteer.number,
        &format!("salts of {}", plan.session),
    );
    let mut now_ms = || {
        now += COMMAND_MS;
        now
    };
    let mut salt = || {
        let mut salt = Salt::default();
        salt.iter_mut()
            .for_each(|byte| *byte = (salts.uniform() * 256.0) as u8);
        Ok(salt)
    };
    let outside = Outside {
        now_ms: &mut now_ms,
        salt: &mut salt,
        stop: PlayStop::default(),
    };
    // What was delivered is read between two commands, while the runner holds the bench.
    let shared = std::cell::RefCell::new(&mut felt);
    let mut stimulator = Shared(&shared);
    let stimuli = Stimuli::On(&mut stimulator);
    let mut runner = Runner::open(
        store,
        (protocol, plan),
        Purpose::Volunteer,
        stimuli,
        outside,
    )?;
    if runner.is_cut_off() {
        let now_ms = runner.now_ms();
        runner.give(Command::Resume {
            experimenter: EXPERIMENTER.to_owned(),
            now_ms,
        })?;
    }
    let mut all = Answers::default();
    let mut judgement = u32::try_from(runner.state().confirmed()).unwrap_or(u32::MAX);
    while let Some(command) = next(runner.state(), simulation.judge, |state, trial, of| {
        let felt = shared.borrow();
        let scene = Scene {
            simulation,
            volunteer,
            state,
            trial,
            of,
            delivered: &felt.delivered,
            moment: Moment { judgement },
        };
        scene.command(&mut all)
    })? {
        let confirms = command == Command::Confirm;
        if confirms {
            judgement += 1;
        }
        let trial = runner
            .state()
            .current()
            .map(|(trial, _)| trial.name.clone());
        if let Given::Void { why } = runner.give(command)? {
            let voided = runner.state().current().map_or(0, |(_, of)| of.voided);
            if voided >= MOST_VOID {
                return Err(VolunteerError::Void {
                    pseudonym: volunteer.pseudonym.clone(),
                    trial: trial.unwrap_or_default(),
                    why,
                });
            }
        }
        if confirms {
            trial_over(runner.state().confirmed());
        }
    }
    drop(runner);
    Ok(all)
}

/// Who is named as the experimenter of simulated sessions.
const EXPERIMENTER: &str = "simulation";

/// The bench of a volunteer behind a cell.
struct Shared<'a, 'b, 'c>(&'a std::cell::RefCell<&'b mut Felt<'c>>);

impl Stimulator for Shared<'_, '_, '_> {
    fn check(&self, stimulus: &str) -> Result<(), RunError> {
        self.0.borrow().check(stimulus)
    }

    fn play(&mut self, played: Played<'_>, stop: &StopHandle) -> Result<Evidence, RunError> {
        self.0.borrow_mut().play(played, stop)
    }
}

/// The device with the volunteer's finger on it and the drives.
fn bench(
    simulation: &Simulation<'_>,
    volunteer: &VirtualVolunteer,
) -> Result<BenchStimulator<'static>, VolunteerError> {
    let laboratory = Laboratory {
        parameters: simulation.parameters.clone(),
        seed: simulation.seed,
    };
    let rendering = simulation.protocol.rendering.as_ref();
    let condition = volunteer.drives.values().next();
    let condition = condition.map(|drive| &drive.target.about.condition);
    Ok(BenchStimulator {
        bench: laboratory.device(volunteer.number),
        drives: volunteer.drives.clone(),
        playing: match simulation.playings {
            Playings::Whole => rendering.map_or(Playing::Once, |rendering| rendering.playing),
            Playings::OneStroke => Playing::Once,
        },
        band: band()?,
        load: condition
            .and_then(|condition| condition.load_n)
            .or(Some(Newtons(0.2))),
        angle: condition
            .and_then(|condition| condition.angle_deg)
            .unwrap_or(Degrees(20.0)),
        journal: Box::new(|_, _| (Box::new(Discard) as Box<dyn RunKeeper>, None)),
    })
}

/// The command that takes the session on; `None` at its end. `answer` answers a trial.
fn next(
    state: &State<'_>,
    judge: Judge,
    answer: impl FnOnce(&State<'_>, &Trial, &TrialState) -> Result<Command, VolunteerError>,
) -> Result<Option<Command>, VolunteerError> {
    Ok(Some(match state.step() {
        Step::Begin => Command::Begin {
            experimenter: EXPERIMENTER.to_owned(),
            program: concat!("piezotact-replay ", env!("CARGO_PKG_VERSION")).to_owned(),
            purpose: Purpose::Volunteer,
            participant: Described {
                judge: Some(judge),
                ..Described::default()
            },
        },
        Step::AskConsent => Command::Consent {
            text: Sha::of(b"a virtual volunteer"),
        },
        Step::Check { .. } => Command::Check,
        Step::Present { .. } => Command::Present {
            evidence: Vec::new(),
        },
        Step::Answer { trial, state: of } => answer(state, trial, of)?,
        Step::Confirm { .. } => Command::Confirm,
        Step::GoOn => Command::GoOn,
        Step::End => Command::End,
        Step::Nothing => return Ok(None),
    }))
}

/// A trial that is to be answered.
struct Scene<'a> {
    simulation: &'a Simulation<'a>,
    volunteer: &'a VirtualVolunteer,
    state: &'a State<'a>,
    trial: &'a Trial,
    of: &'a TrialState,
    delivered: &'a BTreeMap<Element, Vec<Cues>>,
    moment: Moment,
}

impl Scene<'_> {
    /// The answer; of a trial that was presented before a cut, first what was felt then once more.
    fn command(&self, all: &mut Answers) -> Result<Command, VolunteerError> {
        match self.forgotten() {
            Some(element) => Ok(Command::Play {
                element,
                evidence: None,
            }),
            None => Ok(Command::Answer {
                words: self.words(all)?,
            }),
        }
    }

    /// The first element that was played before this program began.
    fn forgotten(&self) -> Option<usize> {
        let rendered = matches!(
            self.trial.presented,
            Presented::Rendered { .. } | Presented::Chosen { .. }
        );
        let mut elements = 0..self.of.plays.len();
        let is_forgotten = |element: &usize| {
            !self
                .delivered
                .contains_key(&(self.trial.name.clone(), *element))
        };
        elements.find(is_forgotten).filter(|_| rendered)
    }

    /// The words of the answer.
    fn words(&self, all: &mut Answers) -> Result<Vec<String>, VolunteerError> {
        let mut random = Random::stream(
            self.simulation.seed,
            self.volunteer.number,
            &format!(
                "answer to {}, {}, attempt {}",
                self.state.plan().session,
                self.trial.name,
                self.of.attempts
            ),
        );
        let mut draw = || random.normal();
        self.answered(&mut draw, all)
            .map_err(|error| VolunteerError::Judge {
                trial: self.trial.name.clone(),
                error: Box::new(error),
            })
    }

    fn answered(
        &self,
        draw: &mut dyn FnMut() -> f64,
        all: &mut Answers,
    ) -> Result<Vec<String>, JudgeError> {
        let choices = self.state.choices(self.trial);
        let said = |place: usize| choices.get(place).map(|(said, _)| said.clone());
        let person = Person {
            judge: self.simulation.judge,
            touch: self.volunteer.touch,
        };
        match &self.trial.answer {
            AnswerForm::Done => Ok(Vec::new()),
            AnswerForm::Order { .. } => {
                let looks: Vec<Look<'_>> = choices
                    .iter()
                    .filter_map(|(_, sample)| self.real(sample))
                    .collect();
                let order = person.order(&looks, self.moment, draw)?;
                all.orders.push(OrderAnswer {
                    participant: self.volunteer.pseudonym.clone(),
                    moment: self.moment,
                    textures: looks.iter().map(touched).collect(),
                    order: order.clone(),
                });
                let order = match self.is_smoothest_first() {
                    true => order.into_iter().rev().collect(),
                    false => order,
                };
                Ok(order.into_iter().filter_map(said).collect())
            }
            AnswerForm::Scale { from, to } => {
                let felt = self.felt();
                let look = felt.first().copied().ok_or(TOO_FEW)?;
                let value = person.rate(look, [*from, *to], self.moment, draw)?;
                Ok(vec![value.to_string()])
            }
            AnswerForm::Some { .. } => {
                let felt = self.felt();
                let look = felt.first().copied().ok_or(TOO_FEW)?;
                let place = person.categorise(look, choices.len(), self.moment, draw)?;
                Ok(said(place).into_iter().collect())
            }
            AnswerForm::OneOf { .. } | AnswerForm::Each { .. } | AnswerForm::EachOfOrder { .. } => {
                match self.question() {
                    Some(question) => {
                        let felt = self.felt();
                        let [first, second] = felt.as_slice() else {
                            return Err(TOO_FEW);
                        };
                        let pair = [*first, *second];
                        let place = match question {
                            Question::SameDifferent => {
                                match person.same(pair, self.moment, draw)? {
                                    Sameness::Same => 0,
                                    Sameness::Different => 1,
                                }
                            }
                            Question::Rougher | Question::Stronger => {
                                person.rougher(pair, self.moment, draw)?
                            }
                        };
                        Ok(said(place).into_iter().collect())
                    }
                    None => self.associated(&person, &choices, draw, all),
                }
            }
        }
    }

    /// For each element the choice that is most like it.
    fn associated(
        &self,
        person: &Person,
        choices: &[(String, String)],
        draw: &mut dyn FnMut() -> f64,
        all: &mut Answers,
    ) -> Result<Vec<String>, JudgeError> {
        let alternatives: Vec<Look<'_>> = choices
            .iter()
            .filter_map(|(_, sample)| self.real(sample))
            .collect();
        // Blindfold, and the samples are out of reach: they are remembered.
        let recall = match self.task() {
            Some(TaskKind::Identify { .. }) => Recall::Remembered,
            _ => Recall::Touched,
        };
        let mut words = Vec::new();
        for look in self.felt() {
            let place = person.associate(look, &alternatives, (recall, self.moment), draw)?;
            all.choices.push(ChoiceAnswer {
                participant: self.volunteer.pseudonym.clone(),
                moment: self.moment,
                presented: touched(&look),
                alternatives: alternatives.iter().map(touched).collect(),
                recall,
                chosen: place,
            });
            words.extend(choices.get(place).map(|(said, _)| said.clone()));
        }
        Ok(words)
    }

    fn task(&self) -> Option<&TaskKind> {
        let protocol: &Protocol = self.simulation.protocol;
        protocol.task(&self.trial.task).map(|task| &task.kind)
    }

    fn question(&self) -> Option<Question> {
        match self.task() {
            Some(TaskKind::Compare { question, .. }) => Some(*question),
            _ => None,
        }
    }

    fn is_smoothest_first(&self) -> bool {
        matches!(self.task(), Some(TaskKind::Order { from, .. }) if from.contains("smooth"))
    }

    /// A real sample as it is touched at leisure.
    fn real(&self, sample: &str) -> Option<Look<'_>> {
        let cues = self.volunteer.real.get(sample)?;
        Some(Look {
            bias: self.volunteer.bias.get(sample).copied().unwrap_or(0.0),
            ..Look::of(cues)
        })
    }

    /// As how many strokes each that was played counts.
    fn strokes_for_each(&self) -> f64 {
        let rendering = self.simulation.protocol.rendering.as_ref();
        let playing = rendering.map(|rendering| rendering.playing);
        let (
            Playings::OneStroke,
            Some(Playing::Repeated {
                pause_s,
                duration_s,
            }),
        ) = (self.simulation.playings, playing)
        else {
            return 1.0;
        };
        let drives = self.volunteer.drives.values();
        let longest_s = drives.map(|drive| drive.texture.duration().0);
        let longest_s = longest_s.fold(0.0, f64::max);
        ((duration_s + pause_s) / (longest_s + pause_s))
            .floor()
            .max(1.0)
    }

    /// What was felt, element by element: the samples that were handed over, or what the bench delivered.
    fn felt(&self) -> Vec<Look<'_>> {
        if let Presented::Sample { sample } = &self.trial.presented {
            return self.real(sample).into_iter().collect();
        }
        let elements = 0..self.of.plays.len();
        let looks = elements.filter_map(|element| {
            let cues = self
                .delivered
                .get(&(self.trial.name.clone(), element))?
                .last()?;
            let strokes = self
                .of
                .evidence_of(element)
                .map(|one| f64::from(one.strokes));
            let strokes = strokes.sum::<f64>() * self.strokes_for_each();
            Some(Look {
                cues,
                looks: strokes.clamp(1.0, Look::AT_LEISURE),
                // All rendered textures are softer or stronger than the real ones by this much, which is no difference of texture.
                bias: -self.volunteer.offset,
            })
        });
        looks.collect()
    }
}

/// A texture as an analysis of the answers knows it: what was delivered, without the person's own biases; what all rendered textures
/// have in common is taken off, as everybody does who has felt them.
fn touched(look: &Look<'_>) -> TouchedTexture {
    let mut cues = look.cues.clone();
    if cues.surface.is_none() {
        cues.ln_rms += look.bias;
    }
    TouchedTexture {
        cues,
        looks: look.looks,
    }
}

const TOO_FEW: JudgeError = JudgeError::TooFew {
    expected: 1,
    found: 0,
};
