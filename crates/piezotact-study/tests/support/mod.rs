//! A store that refuses when it is told to, a player that fails when it is told to, and a session excited to its end.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::cell::{Cell, RefCell};
use std::rc::Rc;
use std::time::Duration;

use piezotact::criterion::Outcome;
use piezotact_people::campaign::chain::{Link, Sha};
use piezotact_people::campaign::plan::{AnswerForm, Plan, PlanRequest, plan};
use piezotact_people::campaign::protocol::{Protocol, from_library};
use piezotact_people::campaign::session::{
    Command, Event, Evidence, Participant, Stage, State, Step, TrialState,
};
use piezotact_people::campaign::store::{
    MemoryStore, NewEvent, Purpose, SessionEntry, SessionKey, Store, StoreError,
};
use piezotact_study::session::{
    Given, Heard, Outside, PlayStop, Played, RunError, Runner, Stimulator, Stimuli, StopHandle,
    TouchEnd,
};

pub(crate) const START_MS: i64 = 1_800_000_000_000;

pub(crate) fn planned(library: &str, session: &str) -> (Protocol, Plan) {
    let protocol = from_library(library).unwrap().unwrap();
    let request = PlanRequest {
        seed: 7,
        participant: "P01",
        session,
        completed: &[],
    };
    let plan = plan(&protocol, Sha::of(library.as_bytes()), request).unwrap();
    (protocol, plan)
}

pub(crate) fn isotropic() -> (Protocol, Plan) {
    planned("isotropic_triplets", "discrimination")
}

/// A store in memory that refuses the next `refusals` events, stores the `losses` behind them without saying so, and in which another program notes something before the next one.
#[derive(Default)]
pub(crate) struct Refusing {
    kept: MemoryStore,
    pub(crate) refusals: Rc<Cell<usize>>,
    pub(crate) losses: Rc<Cell<usize>>,
    pub(crate) overtakes: Rc<Cell<bool>>,
    /// Whether that a texture begins is refused or lost too.
    pub(crate) with_begins: Rc<Cell<bool>>,
}

impl Store for Refusing {
    fn begin(&mut self, key: &SessionKey, purpose: Purpose) -> Result<(), StoreError> {
        self.kept.begin(key, purpose)
    }
    fn append(
        &mut self,
        key: &SessionKey,
        known: u64,
        event: NewEvent<'_>,
    ) -> Result<Link, StoreError> {
        let counts = self.with_begins.get() || !event.json.contains("play_began");
        let left = |of: &Cell<usize>| of.get().checked_sub(1).filter(|_| counts);
        if let Some(left) = left(&self.refusals) {
            self.refusals.set(left);
            return Err(StoreError::Place {
                why: "the disk is full".to_owned(),
                advice: "free space",
            });
        }
        if self.overtakes.replace(false) {
            let others = NewEvent {
                json: r#"{"event":"note","text":"of another program"}"#,
                ..event
            };
            self.kept.append(key, known, others)?;
        }
        let link = self.kept.append(key, known, event)?;
        if let Some(left) = left(&self.losses) {
            self.losses.set(left);
            return Err(StoreError::Place {
                why: "the connection is lost".to_owned(),
                advice: "try again",
            });
        }
        Ok(link)
    }
    fn events(&self, key: &SessionKey) -> Result<Vec<Link>, StoreError> {
        self.kept.events(key)
    }
    fn sessions(&self) -> Result<Vec<SessionEntry>, StoreError> {
        self.kept.sessions()
    }
    fn erase(&mut self, participant: &str, at_ms: i64) -> Result<usize, StoreError> {
        self.kept.erase(participant, at_ms)
    }
}

/// What a player has played, and when it fails.
#[derive(Clone, Default)]
pub(crate) struct Tape {
    /// `TRIAL-ATTEMPT-ELEMENT-PLAY` of every playing that was begun, as a journal would be named.
    pub(crate) begun: Rc<RefCell<Vec<String>>>,
    /// Playings until one fails.
    pub(crate) fails_after: Rc<Cell<Option<usize>>>,
    /// A stimulus without a drive.
    pub(crate) missing: Rc<RefCell<Option<String>>>,
    /// The element whose playings miss their target.
    pub(crate) misses: Rc<Cell<Option<usize>>>,
    /// How long a stimulus is played.
    pub(crate) lasts: Rc<Cell<Duration>>,
    /// The strokes that its sensors find in a touch; none where it has no sensors.
    pub(crate) strokes: Rc<Cell<Option<u32>>>,
}

impl Stimulator for Tape {
    fn check(&self, stimulus: &str) -> Result<(), RunError> {
        match self.missing.borrow().as_deref() == Some(stimulus) {
            true => Err(RunError::NoDrive {
                stimulus: stimulus.to_owned(),
            }),
            false => Ok(()),
        }
    }

    fn play(&mut self, played: Played<'_>, stop: &StopHandle) -> Result<Evidence, RunError> {
        self.check(played.stimulus)?;
        let Played {
            trial,
            attempt,
            element,
            play,
            stimulus,
        } = played;
        let journal = format!("{trial}-{attempt}-{element}-{play}");
        self.begun.borrow_mut().push(journal.clone());
        match self.fails_after.get() {
            Some(0) => {
                self.fails_after.set(None);
                return Err(RunError::Device("the cable came off".to_owned()));
            }
            Some(more) => self.fails_after.set(Some(more - 1)),
            None => {}
        }
        if stop.wait(self.lasts.get()) {
            return Err(RunError::Device("the run was stopped".to_owned()));
        }
        let reached = match self.misses.get() == Some(element) {
            true => Outcome::NotMet,
            false => Outcome::Met,
        };
        Ok(Evidence {
            journal: Some(journal),
            reached,
            ..evidence(stimulus)
        })
    }

    fn listen(&mut self, _touched: Played<'_>, _stop: &StopHandle) -> Result<bool, String> {
        Ok(self.strokes.get().is_some())
    }

    fn strokes(&self) -> Option<u32> {
        self.strokes.get()
    }

    fn heard(&mut self, _end: TouchEnd) -> Option<Heard> {
        Some(Heard {
            recording: None,
            strokes: self.strokes.get(),
            failed: None,
        })
    }
}

pub(crate) fn evidence(stimulus: &str) -> Evidence {
    Evidence {
        stimulus: stimulus.to_owned(),
        drive: Sha::of(stimulus.as_bytes()),
        gain: None,
        verified: Outcome::Met,
        reached: Outcome::Met,
        criteria: [("level".to_owned(), Outcome::Met)].into(),
        // A number that a parser of less than full precision changes.
        score_jnd: Some(0.1 + 0.2),
        level_re_target_db: Some(-1.0 / 3.0),
        rendered_at_db: Some(-9.0),
        normal_force_n: None,
        onset_s: None,
        onset_uncertainty_s: None,
        strokes: 1,
        journal: None,
        bench: None,
        recorded: None,
    }
}

/// Where rendered stimuli are played.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Place {
    Tape,
    ByHand,
    Nowhere,
}

/// What outlives a runner.
pub(crate) struct Bed {
    pub(crate) store: Refusing,
    pub(crate) tape: Tape,
    pub(crate) now_ms: Rc<Cell<i64>>,
    pub(crate) saltless: Rc<Cell<bool>>,
    pub(crate) stop: PlayStop,
}

impl Bed {
    pub(crate) fn new() -> Self {
        Self {
            store: Refusing::default(),
            tape: Tape::default(),
            now_ms: Rc::new(Cell::new(START_MS)),
            saltless: Rc::default(),
            stop: PlayStop::default(),
        }
    }

    /// Opens the session of `plan`, and does `act` with it.
    pub(crate) fn open<T>(
        &mut self,
        (protocol, plan): (&Protocol, &Plan),
        purpose: Purpose,
        place: Place,
        act: impl FnOnce(&mut Runner<'_>) -> T,
    ) -> Result<T, RunError> {
        let mut tape = self.tape.clone();
        let (now, saltless) = (Rc::clone(&self.now_ms), Rc::clone(&self.saltless));
        let mut salts = now.get() as u128;
        let mut now_ms = || {
            now.set(now.get() + 1000);
            now.get()
        };
        let mut salt = || {
            salts += 1;
            match saltless.get() {
                true => Err(RunError::Salt("none".to_owned())),
                false => Ok(salts.to_le_bytes()),
            }
        };
        let stimuli = match place {
            Place::Tape => Stimuli::On(&mut tape),
            Place::ByHand => Stimuli::ByHand,
            Place::Nowhere => Stimuli::Nowhere,
        };
        let outside = Outside {
            now_ms: &mut now_ms,
            salt: &mut salt,
            stop: self.stop.clone(),
        };
        let opened = Runner::open(&mut self.store, (protocol, plan), purpose, stimuli, outside);
        Ok(act(&mut opened?))
    }

    pub(crate) fn volunteer<T>(
        &mut self,
        of: (&Protocol, &Plan),
        act: impl FnOnce(&mut Runner<'_>) -> T,
    ) -> T {
        self.open(of, Purpose::Volunteer, Place::Tape, act).unwrap()
    }

    pub(crate) fn events(&self, plan: &Plan) -> Vec<Event> {
        let key = SessionKey::new(&plan.participant, &plan.session);
        let links = self.store.events(&key).unwrap().into_iter();
        let event = |link: Link| serde_json::from_str(&link.payload.unwrap().json).unwrap();
        links.map(event).collect()
    }
}

/// Everything that a state says.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Said {
    stage: Stage,
    step: String,
    trials: Vec<TrialState>,
    events: u64,
    last_ms: Option<i64>,
    ignored: u32,
    jumps: Vec<i64>,
    participant: Participant,
}

impl Said {
    /// It without what began to be played and is not known to be felt yet.
    pub(crate) fn but_begun(mut self) -> Self {
        (self.events, self.last_ms) = (0, None);
        for trial in &mut self.trials {
            trial.begun.clear();
            trial.felt.clear();
        }
        self
    }
}

pub(crate) fn said(state: &State<'_>) -> Said {
    Said {
        stage: state.stage(),
        step: format!("{:?}", state.step()),
        trials: state.trials().map(|(_, of)| of.clone()).collect(),
        events: state.events(),
        last_ms: state.last_ms(),
        ignored: state.ignored(),
        jumps: state.jumps_back_ms().to_vec(),
        participant: state.participant().clone(),
    }
}

pub(crate) fn present() -> Command {
    let evidence = Vec::new();
    Command::Present { evidence }
}

pub(crate) fn replay(element: usize) -> Command {
    let evidence = None;
    Command::Play { element, evidence }
}

/// An answer of the first choices to the current trial.
fn first_choices(state: &State<'_>) -> Vec<String> {
    let (trial, of) = state.current().unwrap();
    let choices = state.choices(trial);
    match &trial.answer {
        AnswerForm::Done => Vec::new(),
        AnswerForm::Each { .. } | AnswerForm::EachOfOrder { .. } => {
            vec![choices[0].0.clone(); of.plays.len()]
        }
        AnswerForm::OneOf { .. } | AnswerForm::Some { .. } => vec![choices[0].0.clone()],
        AnswerForm::Order { .. } => choices.into_iter().map(|(said, _)| said).collect(),
        AnswerForm::Scale { from, .. } => vec![from.to_string()],
    }
}

/// The command that takes the session on; `None` at its end.
pub(crate) fn next(state: &State<'_>) -> Option<Command> {
    Some(match state.step() {
        Step::Begin => Command::Begin {
            experimenter: "EX".to_owned(),
            program: "piezotact".to_owned(),
            purpose: Purpose::Volunteer,
            participant: Participant {
                age_years: Some(25),
                ..Participant::default()
            },
        },
        Step::AskConsent => Command::Consent {
            text: Sha::of(b"consent"),
        },
        Step::Check { .. } => Command::Check,
        Step::Present { .. } => present(),
        Step::Answer { .. } => Command::Answer {
            words: first_choices(state),
        },
        Step::Confirm { .. } => Command::Confirm,
        Step::GoOn => Command::GoOn,
        Step::End => Command::End,
        Step::Nothing => return None,
    })
}

pub(crate) fn done(runner: &mut Runner<'_>, command: Command) -> Event {
    match runner.give(command.clone()).unwrap() {
        Given::Done(event) => event,
        void @ Given::Void { .. } => panic!("{command:?}: {void:?}"),
    }
}

/// Goes on until the next step is to present a trial of `task`.
pub(crate) fn until_presenting(runner: &mut Runner<'_>, task: &str) {
    let waits = |state: &State<'_>| matches!(state.step(), Step::Present { trial, .. } if trial.task == task);
    while !waits(runner.state()) {
        let command = next(runner.state()).unwrap();
        done(runner, command);
    }
}

/// Name, attempts and number of elements of the current trial.
pub(crate) fn current(runner: &Runner<'_>) -> (String, TrialState) {
    let (trial, of) = runner.state().current().unwrap();
    (trial.name.clone(), of.clone())
}
