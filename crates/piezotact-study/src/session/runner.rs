//! The runner: what a command makes happen is played, stored and taken up, in this order.

use piezotact_people::campaign::session::SessionError;
use std::fmt;

use piezotact_bench::StopHandle;
use piezotact_people::campaign::chain::{Link, Salt};
use piezotact_people::campaign::plan::{Plan, Presented};
use piezotact_people::campaign::protocol::Protocol;
use piezotact_people::campaign::session::{Command, Event, Evidence, Refusal, Stage, State, Step};
use piezotact_people::campaign::store::{NewEvent, Purpose, SessionKey, Store, StoreError};

use crate::session::stop::Playing;
use crate::session::touching::Touching;
use crate::session::{PlayStop, Played, Stimulator, TouchEnd};

/// What comes from outside: the time, fresh entropy for each event, and a stop of what is played.
#[allow(missing_debug_implementations, reason = "it holds closures")]
pub struct Outside<'a> {
    /// The time now, in ms since 1970-01-01 00:00 UTC.
    pub now_ms: &'a mut dyn FnMut() -> i64,
    pub salt: &'a mut dyn FnMut() -> Result<Salt, RunError>,
    pub stop: PlayStop,
}

/// Why a command made nothing happen, or why a session cannot be taken up. Nothing was stored.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// The session does not allow it now.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// It was not stored.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// What is stored does not belong to this plan or program.
    #[error(transparent)]
    Replay(#[from] SessionError),
    /// An event cannot be read.
    #[error(
        "event {number} of the session cannot be read: {why}; use the version of the program that wrote it"
    )]
    Event { number: u64, why: String },
    /// A rehearsal under the name of a session with a volunteer, or the other way round.
    #[error(
        "session {} of {} was begun as {}; go on with it as such, or give the participant another pseudonym", .key.session, .key.participant, word(*.begun)
    )]
    Purpose {
        key: SessionKey,
        /// As what it was begun.
        begun: Purpose,
    },
    /// The store and the first event of the session say different things about it.
    #[error(
        "session {} of {} was begun as {}, and the store lists it as {}: the store was changed; restore it from a copy", .key.session, .key.participant, word(*.begun), word(*.listed)
    )]
    PurposeChanged {
        key: SessionKey,
        /// As what it was begun.
        begun: Purpose,
        /// As what the store lists it.
        listed: Purpose,
    },
    /// There is nothing to play the stimulus on.
    #[error("{stimulus} is played on a bench, and there is none; name one")]
    NoBench { stimulus: String },
    /// The system gave no entropy.
    #[error("the system gave no random numbers: {0}; nothing was stored, try again")]
    Salt(String),
    /// There is no drive for it; nothing was played.
    #[error("there is no drive for {stimulus}; prepare one, and give the folder that holds it")]
    NoDrive { stimulus: String },
    /// One stroke lasts longer than the protocol lets a presentation last; nothing was played.
    #[error(
        "the drive for {stimulus} lasts {found_s:.1} s, and the protocol plays a texture for {longest_s:.1} s at most; prepare it from a shorter stroke"
    )]
    TooLong {
        stimulus: String,
        found_s: f64,
        longest_s: f64,
    },
    /// The bench failed, or the run was stopped: the trial is void.
    #[error("{0}")]
    Device(String),
}

fn word(purpose: Purpose) -> &'static str {
    match purpose {
        Purpose::Volunteer => "a session with a volunteer",
        Purpose::Rehearsal => "a rehearsal",
    }
}

/// What a command made happen.
#[derive(Clone, Debug, PartialEq)]
#[expect(
    clippy::large_enum_variant,
    reason = "there is one for each command, and front ends match on the event"
)]
pub enum Given {
    /// This event, which is stored.
    Done(Event),
    /// The device failed: the trial is void, which is stored, and is to be presented again.
    Void { why: String },
}

/// Where rendered stimuli are played.
pub enum Stimuli<'a> {
    /// On a bench, which says what was measured.
    On(&'a mut dyn Stimulator),
    /// By hand on another system: nothing is known of what was felt.
    ByHand,
    /// Nowhere: a trial with a rendered stimulus is refused.
    Nowhere,
}

impl fmt::Debug for Stimuli<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::On(_) => "On",
            Self::ByHand => "ByHand",
            Self::Nowhere => "Nowhere",
        })
    }
}

/// A session under way.
pub struct Runner<'a> {
    store: &'a mut dyn Store,
    key: SessionKey,
    purpose: Purpose,
    pub(super) state: State<'a>,
    pub(super) stimuli: Stimuli<'a>,
    pub(super) outside: Outside<'a>,
    /// Whether it was found under way, and was not resumed yet.
    is_cut_off: bool,
    pub(super) unstored: Option<Unstored>,
    pub(super) unsure: Option<Unsure>,
    pub(super) touch: Option<Touching>,
}

/// An event that the store did not acknowledge. It can be stored nevertheless, where the answer of a server was lost: the session is
/// read again before anything else happens.
pub(super) struct Unsure {
    /// The command, where nothing was played for it.
    asked: Option<Command>,
    event: Event,
    json: String,
}

/// What a command has played, or tried to play, and what could not be stored. It is stored before anything else happens, so that
/// nothing is played twice under the same number.
pub(super) struct Unstored {
    /// The command, without evidence.
    asked: Command,
    event: Event,
    /// What failed, where the trial is void.
    failed: Option<String>,
    at_ms: i64,
}

impl Unstored {
    /// What the command has made happen, once it is stored.
    fn given(self) -> Given {
        match self.failed {
            Some(why) => Given::Void { why },
            None => Given::Done(self.event),
        }
    }
}

impl fmt::Debug for Runner<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Runner")
            .field("key", &self.key)
            .field("stage", &self.state.stage())
            .finish_non_exhaustive()
    }
}

impl<'a> Runner<'a> {
    /// The session that `plan` is for, where it stands: a new one is entered in the store, of one that is there the chain is
    /// verified and its events are taken up.
    ///
    /// # Errors
    /// [`RunError`]; [`SessionError::Changed`] where protocol or plan are others than those it was begun with.
    pub fn open(
        store: &'a mut dyn Store,
        (protocol, plan): (&'a Protocol, &'a Plan),
        purpose: Purpose,
        stimuli: Stimuli<'a>,
        outside: Outside<'a>,
    ) -> Result<Self, RunError> {
        let key = SessionKey::new(&plan.participant, &plan.session);
        let sessions = store.sessions()?;
        let state = match sessions.iter().find(|entry| entry.key == key) {
            None => {
                store.begin(&key, purpose)?;
                State::new(protocol, plan)
            }
            Some(entry) if entry.purpose != purpose => {
                return Err(RunError::Purpose {
                    key,
                    begun: entry.purpose,
                });
            }
            Some(entry) if entry.withdrawn_at_ms.is_some() => {
                return Err(RunError::Store(StoreError::Withdrawn {
                    participant: key.participant,
                }));
            }
            Some(_) => state_of(store, protocol, plan)?,
        };
        Ok(Self {
            store,
            key,
            purpose,
            is_cut_off: is_under_way(state.stage()),
            state,
            stimuli,
            outside,
            unstored: None,
            unsure: None,
            touch: None,
        })
    }

    /// Where the session stands.
    #[must_use]
    pub fn state(&self) -> &State<'a> {
        &self.state
    }

    /// Whether it was begun by an earlier program and cut off: it goes on with [`Command::Resume`], and until then only takes notes,
    /// corrections, a stop and a withdrawal.
    #[must_use]
    pub fn is_cut_off(&self) -> bool {
        self.is_cut_off && is_under_way(self.state.stage())
    }

    /// What is stored of the session: each event with its time in ms since 1970-01-01 00:00 UTC.
    ///
    /// # Errors
    /// [`RunError`] where the store refuses, or an event cannot be read.
    pub fn events(&self) -> Result<Vec<(i64, Event)>, RunError> {
        read(&self.key, &self.store.events(&self.key)?)
    }

    /// The time now, in ms since 1970-01-01 00:00 UTC.
    pub fn now_ms(&mut self) -> i64 {
        (self.outside.now_ms)()
    }

    /// Does what `command` asks for: plays what is to be played, stores the event, and takes it up. A playing that fails makes
    /// the trial void. What is known of a playing is measured here alone: evidence in `command` is left out.
    ///
    /// # Errors
    /// [`RunError`]: nothing was stored, and the state is as before. After [`StoreError::Place`] and [`RunError::Salt`] the same
    /// command can be given again; what it played is not played again. Another command stores first what was played.
    pub fn give(&mut self, command: Command) -> Result<Given, RunError> {
        if matches!(
            command,
            Command::Pause | Command::Stop { .. } | Command::Withdraw | Command::Void { .. }
        ) {
            self.end_part(TouchEnd::Cut);
        }
        let given = self.given(command);
        self.follow_touch();
        given
    }

    fn given(&mut self, command: Command) -> Result<Given, RunError> {
        let command = without_evidence(command);
        if let Some(given) = self.caught_up(&command)? {
            return Ok(given);
        }
        if let Some(unstored) = self.unstored.take() {
            let is_same = unstored.asked == command;
            let given = self.keep_played(unstored)?;
            if is_same {
                return Ok(given);
            }
        }
        if let Command::Begin { purpose, .. } = &command
            && *purpose != self.purpose
        {
            return Err(RunError::Purpose {
                key: self.key.clone(),
                begun: self.purpose,
            });
        }
        if self.is_cut_off() && !can_come_before_resuming(&command) {
            return Err(RunError::Refused(Refusal::NotNow {
                expected: "the session was cut off; resume it first".to_owned(),
            }));
        }
        let (played, failed) = match self.with_evidence(command.clone()) {
            Ok(played) => (played, None),
            Err(Unplayed::Refused(error)) => return Err(error),
            Err(Unplayed::Void(why)) => (Command::Void { why: why.clone() }, Some(why)),
        };
        let event = self.state.decide(&played)?;
        let at_ms = (self.outside.now_ms)();
        if failed.is_some() || played != command {
            return self.keep_played(Unstored {
                asked: command,
                event,
                failed,
                at_ms,
            });
        }
        if let Err(error) = self.keep(at_ms, &event) {
            if let Some(unsure) = &mut self.unsure {
                unsure.asked = Some(command);
            }
            return Err(error);
        }
        self.note_resumed(&event);
        Ok(Given::Done(event))
    }

    fn note_resumed(&mut self, event: &Event) {
        if matches!(event, Event::Resumed { .. }) {
            self.is_cut_off = false;
        }
    }

    /// Takes up an event that was stored and not acknowledged; gives what `command` has made happen, where it was of this command.
    fn caught_up(&mut self, command: &Command) -> Result<Option<Given>, RunError> {
        let Some(unsure) = &self.unsure else {
            return Ok(None);
        };
        let links = self.store.events(&self.key)?;
        let known = usize::try_from(self.state.events()).unwrap_or(usize::MAX);
        let ours = |link: &Link| {
            let payload = link.payload.as_ref();
            payload.is_some_and(|payload| payload.json == unsure.json)
        };
        let after = match links.get(known..).unwrap_or_default() {
            // It is not stored.
            [] => None,
            [link] if ours(link) => {
                let mut after = self.state.clone();
                after.apply(link.at_ms, &unsure.event)?;
                Some(after)
            }
            _ => {
                return Err(RunError::Store(StoreError::Overtaken {
                    key: self.key.clone(),
                    expected: self.state.events(),
                    found: links.len() as u64,
                }));
            }
        };
        let unsure = self.unsure.take();
        let (Some(after), Some(unsure)) = (after, unsure) else {
            return Ok(None);
        };
        self.state = after;
        self.note_resumed(&unsure.event);
        let (asked, given) = match self.unstored.take() {
            Some(played) => (Some(played.asked.clone()), played.given()),
            None => (unsure.asked, Given::Done(unsure.event)),
        };
        Ok((asked.as_ref() == Some(command)).then_some(given))
    }

    /// Stores what was played, or keeps it for the next command.
    fn keep_played(&mut self, played: Unstored) -> Result<Given, RunError> {
        if let Err(error) = self.keep(played.at_ms, &played.event) {
            self.unstored = Some(played);
            return Err(error);
        }
        Ok(played.given())
    }

    /// Stores `event` and takes it up.
    fn keep(&mut self, at_ms: i64, event: &Event) -> Result<(), RunError> {
        // Applied to a copy first: what the state refuses is never stored.
        let mut after = self.state.clone();
        after.apply(at_ms, event)?;
        let json = serde_json::to_string(event).map_err(|error| RunError::Event {
            number: self.state.events(),
            why: error.to_string(),
        })?;
        let new = NewEvent {
            at_ms,
            json: &json,
            salt: (self.outside.salt)()?,
        };
        if let Err(error) = self.store.append(&self.key, self.state.events(), new) {
            if matches!(error, StoreError::Place { .. }) {
                self.unsure = Some(Unsure {
                    asked: None,
                    event: event.clone(),
                    json,
                });
            }
            return Err(error.into());
        }
        self.state = after;
        Ok(())
    }

    /// `command` with what was measured while its stimuli were played, where it asks for rendered ones.
    fn with_evidence(&mut self, command: Command) -> Result<Command, Unplayed> {
        match command {
            Command::Present { .. } if self.rendered() => {
                self.require(&Command::Present {
                    evidence: Vec::new(),
                })?;
                let names = self.planned();
                let evidence = self.played(&names)?;
                Ok(Command::Present { evidence })
            }
            Command::PresentInstead { names, .. } if self.rendered() => {
                self.require(&Command::PresentInstead {
                    names: names.clone(),
                    evidence: Vec::new(),
                })?;
                let evidence = self.played(&names)?;
                Ok(Command::PresentInstead { names, evidence })
            }
            Command::Play { element, .. } if self.rendered() => {
                let evidence = None;
                self.require(&Command::Play { element, evidence })?;
                let evidence = Some(self.replayed(element)?);
                Ok(Command::Play { element, evidence })
            }
            Command::Confirm if self.touch.is_some() => {
                self.require(&Command::Confirm)?;
                let touched = self.touched().map_err(Unplayed::Refused)?;
                Ok(Command::ConfirmTouched { touched })
            }
            other => Ok(other),
        }
    }

    /// Whether the current trial presents rendered stimuli that are played here.
    fn rendered(&self) -> bool {
        if matches!(self.stimuli, Stimuli::ByHand) {
            return false;
        }
        let current = self.state.current();
        current.is_some_and(|(trial, _)| {
            matches!(
                trial.presented,
                Presented::Rendered { .. } | Presented::Chosen { .. }
            )
        })
    }

    /// Refuses, before anything is played, what the state refuses.
    fn require(&self, command: &Command) -> Result<(), Unplayed> {
        let decided = self.state.decide(command);
        decided.map_err(|error| Unplayed::Refused(error.into()))?;
        Ok(())
    }

    /// What the current trial presents: what is planned, or what the answers so far choose.
    fn planned(&self) -> Vec<String> {
        let current = self.state.current();
        current.map_or_else(Vec::new, |(trial, _)| self.state.presented(trial))
    }

    /// What was measured while each of `names` was played, one after the other.
    fn played(&mut self, names: &[String]) -> Result<Vec<Evidence>, Unplayed> {
        let Step::Present { trial, attempt } = self.state.step() else {
            return Ok(Vec::new());
        };
        let trial = trial.name.clone();
        // Before the first is played: what is refused was not felt in part.
        for stimulus in names {
            check(&self.stimuli, stimulus)?;
        }
        let stop = self.outside.stop.clone();
        let playing = stop.begin();
        let numbered = names.iter().enumerate();
        numbered
            .map(|(element, stimulus)| {
                let played = Played {
                    trial: &trial,
                    attempt,
                    element,
                    play: 1,
                    stimulus,
                };
                let sounded = self.sounded(&playing, played);
                sounded.map_err(|unplayed| match unplayed {
                    // The first ones were felt.
                    Unplayed::Refused(why) if element > 0 => Unplayed::Void(why.to_string()),
                    other => other,
                })
            })
            .collect()
    }

    /// What was measured while `played` was played. That it begins is stored before its sound.
    fn sounded(&mut self, playing: &Playing<'_>, played: Played<'_>) -> Result<Evidence, Unplayed> {
        let goes_on = || {
            playing
                .stopped()
                .map_or(Ok(()), |why| Err(Unplayed::Void(why)))
        };
        goes_on()?;
        let begins = Event::PlayBegan {
            trial: played.trial.to_owned(),
            element: played.element,
        };
        let now_ms = (self.outside.now_ms)();
        self.keep(now_ms, &begins).map_err(Unplayed::Refused)?;
        let sounded = play(&mut self.stimuli, played, &playing.stop);
        // A press is obeyed, also where the sound was over at that moment.
        goes_on()?;
        sounded
    }

    /// What was measured while an element of the current trial was played once more.
    fn replayed(&mut self, element: usize) -> Result<Evidence, Unplayed> {
        let unknown = || {
            Unplayed::Refused(RunError::Refused(Refusal::Unknown {
                what: "element",
                name: (element + 1).to_string(),
            }))
        };
        let (trial, state) = self.state.current().ok_or_else(unknown)?;
        let names = self.state.presented(trial);
        let stimulus = names.get(element).ok_or_else(unknown)?;
        check(&self.stimuli, stimulus)?;
        let played = Played {
            trial: &trial.name,
            attempt: state.attempts,
            element,
            play: state.plays.get(element).map_or(1, |plays| plays + 1),
            stimulus,
        };
        let stop = self.outside.stop.clone();
        self.sounded(&stop.begin(), played)
    }
}

/// Why nothing is known of a playing.
enum Unplayed {
    Refused(RunError),
    Void(String),
}

fn is_under_way(stage: Stage) -> bool {
    matches!(stage, Stage::Consent | Stage::Running | Stage::Paused)
}

fn can_come_before_resuming(command: &Command) -> bool {
    matches!(
        command,
        Command::Resume { .. }
            | Command::Note { .. }
            | Command::Correct { .. }
            | Command::Stop { .. }
            | Command::Withdraw
    )
}

fn without_evidence(command: Command) -> Command {
    match command {
        Command::Present { .. } => Command::Present {
            evidence: Vec::new(),
        },
        Command::PresentInstead { names, .. } => Command::PresentInstead {
            names,
            evidence: Vec::new(),
        },
        Command::Play { element, .. } => Command::Play {
            element,
            evidence: None,
        },
        Command::ConfirmTouched { .. } => Command::Confirm,
        other => other,
    }
}

fn check(stimuli: &Stimuli<'_>, stimulus: &str) -> Result<(), Unplayed> {
    let Stimuli::On(stimulator) = stimuli else {
        return Err(Unplayed::Refused(RunError::NoBench {
            stimulus: stimulus.to_owned(),
        }));
    };
    let checked = stimulator.check(stimulus);
    checked.map_err(Unplayed::Refused)
}

fn play(
    stimuli: &mut Stimuli<'_>,
    played: Played<'_>,
    stop: &StopHandle,
) -> Result<Evidence, Unplayed> {
    let Stimuli::On(stimulator) = stimuli else {
        return Err(Unplayed::Refused(RunError::NoBench {
            stimulus: played.stimulus.to_owned(),
        }));
    };
    stimulator.play(played, stop).map_err(|error| match error {
        RunError::Device(why) => Unplayed::Void(why),
        refused => Unplayed::Refused(refused),
    })
}

/// The state of the session that `plan` is for, from what is stored.
///
/// # Errors
/// [`RunError`] where the chain is broken, an event cannot be read, or belongs to another plan.
pub fn state_of<'a>(
    store: &dyn Store,
    protocol: &'a Protocol,
    plan: &'a Plan,
) -> Result<State<'a>, RunError> {
    let key = SessionKey::new(&plan.participant, &plan.session);
    let links = store.events(&key)?;
    let entries = store.sessions()?;
    let listed = entries.iter().find(|entry| entry.key == key);
    let listed = listed.ok_or_else(|| StoreError::Unknown { key: key.clone() })?;
    listed.verify(&links)?;
    let mut state = State::new(protocol, plan);
    for (at_ms, event) in read(&key, &links)? {
        state.apply(at_ms, &event)?;
    }
    if let Some(begun) = state.purpose()
        && begun != listed.purpose
    {
        return Err(RunError::PurposeChanged {
            key,
            begun,
            listed: listed.purpose,
        });
    }
    Ok(state)
}

/// The events of the session of `plan` with their times in ms since 1970-01-01 00:00 UTC, as `store` has them.
///
/// # Errors
/// [`RunError`] where an event cannot be read.
pub fn events_of(store: &dyn Store, plan: &Plan) -> Result<Vec<(i64, Event)>, RunError> {
    let key = SessionKey::new(&plan.participant, &plan.session);
    read(&key, &store.events(&key)?)
}

/// The events of the session `key` with their times.
fn read(key: &SessionKey, links: &[Link]) -> Result<Vec<(i64, Event)>, RunError> {
    let each = links.iter().map(|link| {
        let Some(payload) = &link.payload else {
            let participant = key.participant.clone();
            return Err(RunError::Store(StoreError::Withdrawn { participant }));
        };
        let event = serde_json::from_str(&payload.json).map_err(|error| RunError::Event {
            number: link.number,
            why: error.to_string(),
        })?;
        Ok((link.at_ms, event))
    });
    each.collect()
}
