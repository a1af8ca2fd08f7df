//! Where pages and the runner of a session meet: requests in, views out.
//!
//! The runner works on the thread that owns store and bench; pages wait for its answer. A view holds everything that a page shows, so a
//! page that was away has nothing to catch up with, and one that hangs keeps only its own view waiting.

use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, RecvTimeoutError, Sender, channel};
use std::sync::{Arc, OnceLock};
use std::time::{Duration, Instant};

use piezotact_people::campaign::session::{Command, Event, Evidence, Refusal, Stage, Step};
use piezotact_people::campaign::store::StoreError;
use piezotact_study::session::{
    Given, Heard, PlayStop, Played, RunError, Runner, Stimulator, StopHandle, TouchEnd,
};
use tokio::sync::{oneshot, watch};

use crate::asked::What;
use crate::beat::{Beat, LONGEST};
use crate::view::{OpenStep, PlayedBy, Text, View, is_rendered, next_after, shown_as, words_of};
use crate::words::{Language, Word};

/// As many of the last events are listed.
const LISTED: usize = 30;
/// As many answered requests are known by their ids: what a page sends again is not done again.
const KNOWN: usize = 256;
/// A second press this soon after strokes were said to be missing is one of a double click.
const SECOND_PRESS: Duration = Duration::from_secs(1);
/// How often the end is looked for.
const LOOK: Duration = Duration::from_millis(50);

/// What a page asks for.
#[derive(Debug)]
pub(crate) struct Request {
    /// An id that the page made: the same one again is the same request again.
    pub(crate) id: String,
    /// The mark of the step at which it was asked, [`crate::view::Open::mark`]; none where it fits any step.
    pub(crate) at: Option<String>,
    /// How many events were stored when the page showed it.
    pub(crate) seen: Option<u64>,
    /// How many stops there had been when it came.
    pub(crate) stops: u64,
    pub(crate) command: Command,
    /// As the page sent it.
    pub(crate) sent: What,
    pub(crate) reply: oneshot::Sender<Reply>,
}

/// What came of a request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Reply {
    /// It is stored.
    Stored,
    /// The session is at another step than the page showed; nothing was stored.
    MovedOn,
    /// Nothing was stored; why is for the experimenter alone.
    Refused(String),
    /// It could not be stored: it can be sent again.
    NotStored(String),
}

/// The pages' side.
#[derive(Clone, Debug)]
pub(crate) struct Asking {
    pub(crate) requests: Sender<Request>,
    pub(crate) views: watch::Receiver<View>,
}

/// The runner's side.
#[derive(Debug)]
pub struct Desk {
    requests: Receiver<Request>,
    views: watch::Sender<View>,
    consent: Option<String>,
    played_by: PlayedBy,
    log: VecDeque<(i64, String)>,
    /// What was stored, by the ids of the requests.
    answered: VecDeque<(String, Option<String>, What)>,
    /// What was stored before this program began, in order: requests of pages that were cut off then are known by it.
    earlier: Vec<Event>,
    notice: Option<(Word, Text)>,
    /// The right answer to the last trial, where the protocol has it said.
    feedback: Option<Text>,
    /// When it was said that strokes are missing.
    missing: Option<Instant>,
    /// When the next trial begins by itself, when that was settled, and how many stops there had been then.
    next: Option<(Instant, Instant, u64)>,
    stop: PlayStop,
    /// Nothing begins by itself where no page of an experimenter answers.
    beat: Arc<Beat>,
}

/// Where a stimulator shows what it plays: on the pages of a desk, as soon as there is one.
#[derive(Clone, Debug, Default)]
pub struct Screen(Arc<OnceLock<watch::Sender<View>>>);

impl Screen {
    /// Shows it on the pages of `desk` from now on. A screen shows one desk.
    pub fn shows(&self, desk: &Desk) {
        let _shows_another = self.0.set(desk.views.clone());
    }
}

/// A stimulator whose playing the pages show.
#[derive(Debug)]
pub struct Shown<S> {
    inner: S,
    screen: Screen,
}

impl<S> Shown<S> {
    /// `inner`, which shows what it plays on `screen`: the number of the element, never the stimulus.
    pub fn new(inner: S, screen: Screen) -> Self {
        Self { inner, screen }
    }
}

impl<S: Stimulator> Stimulator for Shown<S> {
    fn check(&self, stimulus: &str) -> Result<(), RunError> {
        self.inner.check(stimulus)
    }

    fn play(&mut self, played: Played<'_>, stop: &StopHandle) -> Result<Evidence, RunError> {
        if let Some(views) = self.screen.0.get() {
            let element = played.element + 1;
            views.send_modify(|view| {
                let of = view.closed.presented.len();
                view.open.step = OpenStep::Playing([element, of]);
            });
        }
        self.inner.play(played, stop)
    }

    fn listen(&mut self, touched: Played<'_>, stop: &StopHandle) -> Result<bool, String> {
        self.inner.listen(touched, stop)
    }

    fn strokes(&self) -> Option<u32> {
        self.inner.strokes()
    }

    fn heard(&mut self, end: TouchEnd) -> Option<Heard> {
        self.inner.heard(end)
    }
}

impl Desk {
    /// A desk for a session that shows `view` first, with the pages' side.
    pub(crate) fn new(
        view: View,
        consent: Option<String>,
        (played_by, stop): (PlayedBy, PlayStop),
        earlier: Vec<(i64, Event)>,
        beat: Arc<Beat>,
    ) -> (Self, Asking) {
        let (requests, received) = channel();
        let (views, seen) = watch::channel(view);
        let asking = Asking {
            requests,
            views: seen,
        };
        let desk = Self {
            requests: received,
            views,
            consent,
            played_by,
            log: earlier
                .iter()
                .rev()
                .take(LISTED)
                .map(|(at_ms, event)| (*at_ms, words(event)))
                .collect(),
            earlier: earlier.into_iter().map(|(_, event)| event).collect(),
            answered: VecDeque::new(),
            notice: None,
            feedback: None,
            missing: None,
            next: None,
            stop,
            beat,
        };
        (desk, asking)
    }

    /// Says on the pages that the clock of the computer is behind, in so many words, until the next step.
    pub fn clock_is_behind(&mut self, why: String) {
        self.notice = Some((Word::ClockBehind, why.into()));
    }

    /// Answers requests with `runner` until `is_over` or all pages are closed. What is refused or cannot be stored leaves the session
    /// where it is.
    ///
    /// # Errors
    /// [`RunError`] with what makes it impossible to go on: a store that was changed.
    pub fn run(
        &mut self,
        runner: &mut Runner<'_>,
        is_over: &dyn Fn() -> bool,
    ) -> Result<(), RunError> {
        self.show(runner);
        while !is_over() {
            let request = match self.requests.recv_timeout(LOOK) {
                Ok(request) => request,
                Err(RecvTimeoutError::Timeout) => {
                    self.begin_next(runner)?;
                    continue;
                }
                Err(RecvTimeoutError::Disconnected) => return Ok(()),
            };
            let reply = match self.known(&request) {
                Some(reply) => reply,
                None => self.give(runner, &request)?,
            };
            if reply == Reply::Stored {
                self.answered
                    .push_front((request.id, request.at, request.sent));
                self.answered.truncate(KNOWN);
            }
            self.show(runner);
            // A page that has gone asks again.
            let _gone = request.reply.send(reply);
        }
        Ok(())
    }

    /// What came of the same request before, where it was stored.
    fn known(&self, request: &Request) -> Option<Reply> {
        let known = self.answered.iter().find(|(id, ..)| *id == request.id);
        match known {
            Some((_, at, sent)) if *sent == request.sent && *at == request.at => {
                Some(Reply::Stored)
            }
            Some(_) => Some(Reply::Refused(
                "another request had the same id; load the page again".to_owned(),
            )),
            None => {
                // What fits any step is known by what it says: nobody else noted the same since the page saw the session.
                let seen = usize::try_from(request.seen?).ok()?;
                let since = self.earlier.get(seen..)?;
                let is_it = since.iter().any(|event| is_of(event, &request.command));
                is_it.then_some(Reply::Stored)
            }
        }
    }

    /// Shows where the session stands.
    fn show(&mut self, runner: &Runner<'_>) {
        let mut view = View::of(runner.state(), self.consent.as_deref(), self.played_by);
        view.closed.log = self.log.iter().cloned().collect();
        view.closed.notice.clone_from(&self.notice);
        view.open.feedback.clone_from(&self.feedback);
        view.open.begins = self.next.is_some();
        if let Some((Word::NotComplete, found)) = &self.notice
            && let OpenStep::Answer(form) = &mut view.open.step
        {
            let found = Text::after_word(Word::NotComplete, found);
            form.more = Text::joined([&form.more, &found].into_iter());
        }
        self.views.send_if_modified(|shown| {
            let is_new = *shown != view;
            *shown = view;
            is_new
        });
    }

    fn give(&mut self, runner: &mut Runner<'_>, request: &Request) -> Result<Reply, RunError> {
        let now = View::of(runner.state(), None, self.played_by).open.mark;
        if request.at.as_ref().is_some_and(|at| *at != now) {
            return Ok(Reply::MovedOn);
        }
        let stage = runner.state().stage();
        if is_so(stage, &request.command) {
            return Ok(Reply::Stored);
        }
        if is_over(stage) {
            return Ok(Reply::Refused("the session is over".to_owned()));
        }
        self.stop.plays_after(request.stops);
        let given = self.done(runner, request.command.clone(), request.stops)?;
        let is_answer = matches!(request.command, Command::Answer { .. });
        if given == Reply::Stored && is_answer && pace(runner).is_some() {
            // One press for each answer. Where it cannot be stored the page asks for it.
            let _asked_for_then = self.done(runner, Command::Confirm, request.stops)?;
        }
        Ok(given)
    }

    /// Begins the next trial when its time has come, where a page of the experimenter, and of the participant who has one, is open that can
    /// stop it.
    fn begin_next(&mut self, runner: &mut Runner<'_>) -> Result<(), RunError> {
        let Some((at, settled, stops)) = self.next else {
            return Ok(());
        };
        // A connection that is open is no page that answers: its lid may be closed.
        let is_watched =
            self.beat.last().is_some_and(|beat| beat > settled) && !self.beat.is_participant_away();
        let now = Instant::now();
        if self.stop.asked() != stops || now > at + LONGEST {
            self.next = None;
        } else if now < at || !is_watched {
            return Ok(());
        } else {
            self.stop.plays_after(stops);
            let evidence = Vec::new();
            let given = self.done(runner, Command::Present { evidence }, stops)?;
            if let Reply::Refused(why) | Reply::NotStored(why) = given {
                self.notice = Some((Word::NotBegunItself, why.into()));
            }
        }
        self.show(runner);
        Ok(())
    }

    /// Gives `command` to `runner`, with what follows from it for the pages; there had been `stops` when it was asked for.
    fn done(
        &mut self,
        runner: &mut Runner<'_>,
        command: Command,
        stops: u64,
    ) -> Result<Reply, RunError> {
        let keeps = matches!(command, Command::Note { .. } | Command::Correct { .. });
        if !keeps {
            self.next = None;
        }
        let now_ms = runner.now_ms();
        let too_soon = runner.state().too_soon(now_ms);
        if let Some(refusal) = too_soon.filter(|_| command == Command::Confirm) {
            return Ok(Reply::Refused(refusal.to_string()));
        }
        let is_second =
            |said: Instant| command == Command::Confirm && said.elapsed() < SECOND_PRESS;
        if self.missing.is_some_and(is_second) {
            return Ok(Reply::Refused(
                "not complete: wait a moment before it is confirmed once more".to_owned(),
            ));
        }
        let given = runner.give(command);
        let at_ms = runner.state().last_ms().unwrap_or_default();
        match given {
            Ok(Given::Done(event)) => {
                // Why it is paused is still to be read.
                if !keeps && event != Event::Paused {
                    (self.notice, self.feedback) = notice(runner, &event).unzip();
                    self.notice = self.notice.take().or_else(|| touched(runner, &event));
                }
                if matches!(event, Event::Confirmed { .. })
                    && let Some(pause) = pace(runner).filter(|_| is_next_played(runner))
                    && self.played_by == PlayedBy::Bench
                {
                    let now = Instant::now();
                    self.next = Some((now + pause, now, stops));
                }
                self.keep(at_ms, words(&event));
                Ok(Reply::Stored)
            }
            Ok(Given::Void { why }) => {
                self.notice = Some((Word::Void, reason(&why)));
                self.keep(at_ms, format!("void: {why}"));
                Ok(Reply::Stored)
            }
            Err(error @ (RunError::Store(StoreError::Place { .. }) | RunError::Salt(_))) => {
                Ok(Reply::NotStored(error.to_string()))
            }
            Err(RunError::Refused(refusal)) => {
                if let Refusal::TooFew { found, .. } = refusal {
                    let wanted = runner.state().current();
                    let wanted = wanted.and_then(|(trial, _)| runner.state().strokes_wanted(trial));
                    self.notice = Some(strokes(found, wanted.unwrap_or_default()));
                    self.missing = Some(Instant::now());
                }
                Ok(Reply::Refused(refusal.to_string()))
            }
            Err(RunError::NoDrive { .. }) => {
                // Its name would tell what is played.
                self.notice = Some((Word::NoDrive, Text::default()));
                Ok(Reply::Refused(String::new()))
            }
            Err(
                error @ (RunError::TooLong { .. } | RunError::Device(_) | RunError::NoBench { .. }),
            ) => Ok(Reply::Refused(error.to_string())),
            Err(error) => Err(error),
        }
    }

    fn keep(&mut self, at_ms: i64, what: String) {
        self.log.push_front((at_ms, what));
        self.log.truncate(LISTED);
    }
}

/// Whether `event` is what `command`, which fits any step, made happen.
fn is_of(event: &Event, command: &Command) -> bool {
    match (event, command) {
        (Event::Note { text }, Command::Note { text: asked }) => text == asked,
        (
            Event::Corrected { trial, answer, why },
            Command::Correct {
                trial: asked,
                words,
                why: because,
            },
        ) => trial == asked && why == because && words_of(answer) == *words,
        (Event::Stopped { .. }, Command::Stop { .. }) => true,
        _ => false,
    }
}

/// Whether what `command` asks for is so already: a second press changes nothing.
fn is_so(stage: Stage, command: &Command) -> bool {
    matches!(
        (stage, command),
        (Stage::Paused, Command::Pause)
            | (Stage::Stopped, Command::Stop { .. })
            | (Stage::Withdrawn, Command::Withdraw)
    )
}

fn is_over(stage: Stage) -> bool {
    matches!(stage, Stage::Stopped | Stage::Ended | Stage::Withdrawn)
}

/// Why a trial is void, in the language of a page where it is one of the pages' own reasons.
fn reason(why: &str) -> Text {
    let own = [
        Word::StoppedByParticipant,
        Word::StoppedOnPage,
        Word::NobodyWatched,
    ];
    let mut own = own.into_iter();
    match own.find(|word| word.in_language(Language::English) == why) {
        Some(word) => Text::of_word(why, word),
        None => why.to_owned().into(),
    }
}

/// The pause after which the next trial begins by itself; none where the experimenter begins it.
fn pace(runner: &Runner<'_>) -> Option<Duration> {
    let (trial, _) = runner.state().current()?;
    let after_s = next_after(runner.state().protocol().task(&trial.task))?;
    Duration::try_from_secs_f64(after_s).ok()
}

/// Whether textures are played next that were not played before. What was cut off is begun by the experimenter.
fn is_next_played(runner: &Runner<'_>) -> bool {
    matches!(
        runner.state().step(),
        Step::Present { trial, attempt: 1 } if is_rendered(trial)
    )
}

/// What is to be known at once after `event`, by the experimenter and by the participant.
fn notice(runner: &Runner<'_>, event: &Event) -> Option<((Word, Text), Text)> {
    let Event::Confirmed { trial, .. } = event else {
        return None;
    };
    let mut trials = runner.state().plan().trials.iter();
    let trial = trials.find(|one| one.name == *trial)?;
    let right = runner.state().feedback(trial)?;
    let shown = shown_as(runner.state(), trial, right);
    Some(((Word::RightAnswer, shown.clone()), shown))
}

/// What is to be known at once of a touch that `event` confirms.
fn touched(runner: &Runner<'_>, event: &Event) -> Option<(Word, Text)> {
    let Event::Confirmed {
        trial,
        touched: Some(touched),
    } = event
    else {
        return None;
    };
    if let Some(why) = &touched.not_recorded {
        return Some((Word::NotRecorded, why.clone().into()));
    }
    let mut trials = runner.state().plan().trials.iter();
    let wanted = trials
        .find(|one| one.name == *trial)
        .and_then(|trial| runner.state().strokes_wanted(trial))?;
    Some(strokes(touched.strokes?, wanted))
}

/// How many strokes were found of how many.
fn strokes(found: u32, wanted: u32) -> (Word, Text) {
    let word = match found < wanted {
        true => Word::NotComplete,
        false => Word::StrokesFound,
    };
    (word, format!("{found} / {wanted}").into())
}

/// An event in a few words: its kind, its trial, and what it says, never what was presented.
fn words(event: &Event) -> String {
    match event {
        Event::Begun { .. } => "begun".to_owned(),
        Event::ConsentGiven { .. } => "consent".to_owned(),
        Event::ConsentRefused => "consent refused".to_owned(),
        Event::Checked { item, .. } => format!("checked: {item}"),
        Event::Presented { trial, instead, .. } => match instead {
            None => format!("presented: {trial}"),
            Some(names) => format!("{} handed over instead: {trial}", names.join(", ")),
        },
        Event::PlayBegan { trial, element } => format!("begins: {trial}, {}", element + 1),
        Event::Voided { trial, .. } => format!("void: {trial}"),
        Event::Played { trial, element, .. } => format!("once more: {trial}, {}", element + 1),
        Event::Answered { trial, .. } => format!("answered: {trial}"),
        Event::Confirmed { trial, .. } => format!("confirmed: {trial}"),
        Event::Corrected { trial, .. } => format!("corrected: {trial}"),
        Event::Paused => "pause".to_owned(),
        Event::WentOn => "end of the pause".to_owned(),
        Event::Resumed { .. } => "resumed".to_owned(),
        Event::ResumeRefused { .. } => "not resumed: too late".to_owned(),
        Event::Note { text } => format!("note: {text}"),
        Event::Stopped { why } => format!("stopped: {why}"),
        Event::ConsentWithdrawn => "consent withdrawn".to_owned(),
        Event::Ended => "ended".to_owned(),
        Event::Ignored { command, why } => format!("without effect: {command} ({why})"),
    }
}
