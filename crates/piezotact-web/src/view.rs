//! What pages show of a session: what everybody may see, and what only the experimenter may.

mod form;

use std::collections::BTreeMap;

use piezotact::criterion::Outcome;
use piezotact_people::campaign::plan::{AnswerForm, Presented, Trial, TrialKind};
use piezotact_people::campaign::protocol::{Task, TaskKind, TaskWords};
use piezotact_people::campaign::session::{
    Answer, Stage, State, Step, TrialState, UNKNOWN, letters,
};
use piezotact_people::campaign::text::part_in;

use crate::words::{Language, Word};
use form::{as_said, form, shown};

/// What a session shows. A participant's page is made from [`View::open`] alone.
#[derive(Clone, Debug, PartialEq)]
pub struct View {
    /// What the participant may see.
    pub open: Open,
    /// What only the experimenter may see.
    pub closed: Closed,
}

/// What the participant may see: nothing of it follows from what is presented, from conditions, keys, seeds or other participants.
#[derive(Clone, Debug, PartialEq)]
pub struct Open {
    /// At which step the session is, as a mark that changes with every step: a command that was given at another one is late.
    pub mark: String,
    /// The same for what is chosen and not sent yet: what is felt once more leaves it.
    pub draft: String,
    /// The language that the participant stated.
    pub language: Option<String>,
    /// How many trials are confirmed, and how many there are.
    pub progress: [usize; 2],
    /// What the participant is asked, word for word, while a trial runs.
    pub instruction: Option<Text>,
    pub step: OpenStep,
    /// Whether a pause can be asked for.
    pub can_pause: bool,
    /// The right answer to the last trial, where the protocol has it said.
    pub feedback: Option<Text>,
    /// The next trial begins by itself.
    pub begins: bool,
}

/// A step as the participant sees it.
#[derive(Clone, Debug, PartialEq)]
pub enum OpenStep {
    /// Nothing is to be done.
    Wait,
    /// The participant is asked for consent, with this text.
    Consent(Option<String>),
    /// The first of these elements is played, from 1, of so many.
    Playing([usize; 2]),
    /// An answer is awaited.
    Answer(Form),
    /// An answer is noted, and can be changed.
    Confirm {
        /// As it was said.
        said: Text,
        /// How it is changed.
        form: Form,
    },
    /// A pause.
    Pause,
    /// The session is over.
    Over,
}

impl OpenStep {
    /// Whether its elements can be played again here.
    #[must_use]
    pub fn is_played(&self) -> bool {
        self.form().is_some_and(|form| !form.felt.is_empty())
    }

    /// Whether `words` can stand on the page before they are sent.
    pub(crate) fn can_say(&self, words: &[String]) -> bool {
        let Some(form) = self.form() else {
            return false;
        };
        let is_choice = |word: &String| match form.number {
            Some([from, to]) => word
                .parse()
                .is_ok_and(|number| (from..=to).contains(&number)),
            None => form.choices.iter().any(|(said, _)| said == word),
        };
        words.len() <= form.count[1] && words.iter().all(is_choice)
    }

    fn form(&self) -> Option<&Form> {
        match self {
            Self::Answer(form) | Self::Confirm { form, .. } => Some(form),
            _ => None,
        }
    }
}

/// A text of the protocol, in its own language and in others.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Text {
    own: String,
    others: Vec<(Language, String)>,
}

impl Text {
    /// The text `own` of `task`, with what `said` finds in the words of other languages.
    fn of(task: &Task, own: String, said: impl Fn(&TaskWords) -> Option<String>) -> Self {
        let each = Language::ALL.into_iter();
        let others = each.filter_map(|one| Some((one, said(task.words_in(one.tag())?)?)));
        let others = others.collect();
        Self { own, others }
    }

    /// The words of pages for it.
    pub(crate) fn of_word(own: &str, word: Word) -> Self {
        let each = Language::ALL.into_iter();
        Self {
            own: own.to_owned(),
            others: each
                .map(|one| (one, word.in_language(one).to_owned()))
                .collect(),
        }
    }

    /// `text` behind the words of pages.
    pub(crate) fn after_word(word: Word, text: &Self) -> Self {
        let one = |language| {
            format!(
                "{} {}",
                word.in_language(language),
                text.in_language(language)
            )
        };
        Self {
            own: one(Language::English),
            others: Language::ALL.map(|each| (each, one(each))).to_vec(),
        }
    }

    /// All of `texts` with ", " between.
    pub(crate) fn joined<'a>(texts: impl Iterator<Item = &'a Self> + Clone) -> Self {
        let list = |language| {
            let each = texts.clone().map(|text| match language {
                Some(language) => text.in_language(language),
                None => text.own.as_str(),
            });
            each.collect::<Vec<_>>().join(", ")
        };
        Self {
            own: list(None),
            others: Language::ALL.map(|one| (one, list(Some(one)))).to_vec(),
        }
    }

    /// It in `language`, or in its own.
    #[must_use]
    pub fn in_language(&self, language: Language) -> &str {
        let found = self.others.iter().find(|(one, _)| *one == language);
        found.map_or(&self.own, |(_, text)| text)
    }
}

impl From<String> for Text {
    fn from(own: String) -> Self {
        let others = Vec::new();
        Self { own, others }
    }
}

/// How a trial is answered.
#[derive(Clone, Debug, PartialEq)]
pub struct Form {
    pub ask: Word,
    /// More of it: the ends of an order, or how many at most.
    pub more: Text,
    /// What can be chosen: as it is noted, and as it is shown.
    pub choices: Vec<(String, Text)>,
    /// Whether "I do not know" is an answer.
    pub may_not_know: bool,
    /// Whether an answer is final when it is pressed.
    pub is_final: bool,
    /// The lowest and the highest number, where there are too many to be chosen from: one is typed.
    pub number: Option<[i64; 2]>,
    /// The smallest and the largest number of choices.
    pub count: [usize; 2],
    /// Whether each can be chosen once only.
    pub repeats: Repeats,
    /// How often each element was felt; none where it is not played here.
    pub felt: Vec<u32>,
    /// What is noted until now.
    pub noted: Vec<String>,
}

/// Whether a choice can be made again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Repeats {
    /// Once.
    Once,
    /// Any number of times.
    Any,
}

/// What only the experimenter may see.
#[derive(Clone, Debug, PartialEq)]
pub struct Closed {
    pub participant: String,
    pub session: String,
    /// A rehearsal, or a session with a volunteer.
    pub is_rehearsal: bool,
    /// How many events are stored.
    pub events: u64,
    /// When the last was stored, in ms since 1970-01-01 00:00 UTC.
    pub last_ms: Option<i64>,
    /// The heading of the trial.
    pub heading: Option<Heading>,
    pub step: ClosedStep,
    /// How the trial is answered, and what is noted, by names.
    pub answer: Option<(Form, Option<Text>)>,
    /// What lies in each place of the tray, which the participant names by its number.
    pub places: Vec<String>,
    /// Where the participant's own letters lie.
    pub own_order: Vec<(String, String)>,
    /// What is presented, element by element: hidden in the blind mode where it is rendered.
    pub presented: Vec<String>,
    /// Whether textures are presented, and by whom they are played.
    pub played_by: Option<PlayedBy>,
    /// All samples of the protocol.
    pub samples: Vec<String>,
    /// How real samples are turned, by the sample, where the protocol says it.
    pub orientation: BTreeMap<String, String>,
    /// What was measured while each element was played.
    pub evidence: Vec<Measured>,
    /// The confirmed trials, the last first.
    pub answered: Vec<Answered>,
    /// By task: confirmed and planned.
    pub tasks: Vec<(String, usize, usize)>,
    /// What was stored since the page was begun, the last first.
    pub log: Vec<(i64, String)>,
    /// What is to be known at once.
    pub notice: Option<(Word, Text)>,
}

/// Which trial it is.
#[derive(Clone, Debug, PartialEq)]
pub struct Heading {
    /// Its number, from 1.
    pub number: usize,
    pub of: usize,
    /// The title of its task.
    pub task: Text,
    pub set: Option<String>,
    pub is_training: bool,
    /// Which attempt, from 1.
    pub attempt: u32,
}

/// A step as the experimenter sees it.
#[derive(Clone, Debug, PartialEq)]
pub enum ClosedStep {
    /// The participant is asked for consent, with this text.
    Consent(Option<String>),
    /// An item of a checklist.
    Check(Text),
    /// The samples are laid out.
    LayOut(Vec<String>),
    /// A sample is handed over.
    HandOver(String),
    /// So many textures are played on the bench.
    Play(usize),
    /// They are played by hand.
    PlayByHand(Vec<String>),
    /// As the participant's step.
    Answer,
    /// The participant did not consent.
    NoConsent,
    /// All trials are done.
    End,
    /// It was stopped before its end.
    Stopped,
    /// The session is over.
    Over,
    /// The participant has withdrawn.
    Withdrawn,
}

/// What was measured while an element was played.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// The element, from 1.
    pub element: usize,
    /// Whether the target was reached.
    pub reached: Outcome,
    /// The level in dB re the target.
    pub level_db: Option<f64>,
    /// The mean normal force in N.
    pub force_n: Option<f64>,
}

/// A confirmed trial.
#[derive(Clone, Debug, PartialEq)]
pub struct Answered {
    /// Its number, from 1.
    pub number: usize,
    pub name: String,
    pub task: String,
    /// The answer as it was said.
    pub said: String,
    /// Whether it was corrected.
    pub is_corrected: bool,
}

/// Who plays rendered textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PlayedBy {
    /// A bench.
    Bench,
    /// The experimenter, on another system.
    Hand,
}

impl View {
    /// What `state` shows; `consent` is the text that consent is given to.
    #[must_use]
    pub fn of(state: &State<'_>, consent: Option<&str>, played_by: PlayedBy) -> Self {
        let step = state.step();
        // Of consent the participant reads the part in the own language.
        let stated = state.participant().language.as_deref();
        let consent = consent.map(|text| part_in(text, stated));
        let progress = state.progress();
        let sum = |of: fn(&(usize, usize)) -> usize| progress.values().map(of).sum();
        let current = state.current();
        let trial = current.map(|(trial, _)| trial);
        let runs = matches!(state.stage(), Stage::Running);
        let task = trial.and_then(|trial| state.protocol().task(&trial.task));
        let open = Open {
            mark: mark(state),
            draft: draft(state),
            language: state.participant().language.clone(),
            progress: [sum(|(done, _)| *done), sum(|(_, planned)| *planned)],
            instruction: task.filter(|_| runs).map(|task| {
                Text::of(task, task.instruction.clone(), |words| {
                    Some(words.instruction.clone())
                })
            }),
            step: open_step(state, &step, consent, played_by),
            can_pause: runs && trial.is_some(),
            feedback: None,
            begins: false,
        };
        let own_order =
            trial.filter(|trial| runs && matches!(trial.answer, AnswerForm::EachOfOrder { .. }));
        let tasks = progress.iter();
        let closed = Closed {
            participant: state.plan().participant.clone(),
            session: state.plan().session.clone(),
            is_rehearsal: state.purpose()
                == Some(piezotact_people::campaign::store::Purpose::Rehearsal),
            events: state.events(),
            last_ms: state.last_ms(),
            heading: current
                .filter(|_| runs)
                .map(|(trial, of)| heading(state, trial, of)),
            step: closed_step(state, &step, consent, played_by),
            answer: named_answer(state, &step, played_by),
            places: trial.map_or_else(Vec::new, |trial| places(state, trial)),
            own_order: own_order.map_or_else(Vec::new, |trial| state.choices(trial)),
            presented: trial
                .filter(|_| runs)
                .map_or_else(Vec::new, |t| state.presented(t)),
            played_by: trial.filter(|trial| is_rendered(trial)).map(|_| played_by),
            samples: presentable(state, trial),
            orientation: state.protocol().orientation.clone(),
            evidence: current.map_or_else(Vec::new, |(_, of)| measured(of)),
            answered: answered(state),
            tasks: tasks
                .map(|(task, (done, planned))| ((*task).to_owned(), *done, *planned))
                .collect(),
            log: Vec::new(),
            notice: None,
        };
        Self { open, closed }
    }
}

/// What can have been presented in `trial`: by hand also a texture that was made from a sample.
fn presentable(state: &State<'_>, trial: Option<&Trial>) -> Vec<String> {
    let mut names = state.protocol().samples.clone();
    if trial.is_some_and(is_rendered) {
        let made = state.protocol().stimuli.iter();
        names.extend(made.map(|stimulus| stimulus.name.clone()));
    }
    names
}

/// A mark that changes with every attempt and every answer.
fn draft(state: &State<'_>) -> String {
    let Some((trial, of)) = state.current() else {
        return String::new();
    };
    let number = state.number(&trial.name);
    let stage = state.stage();
    format!("{stage:?}-{number}-{}-{}", of.attempts, of.answers.len())
}

/// A mark that changes with every step, and with nothing else: notes and corrections leave it.
fn mark(state: &State<'_>) -> String {
    let stage = match state.stage() {
        Stage::New => "new",
        Stage::Consent => "consent",
        Stage::Running => "running",
        Stage::Paused => "paused",
        Stage::Stopped | Stage::Ended | Stage::Withdrawn => "over",
    };
    let Some((trial, of)) = state.current() else {
        return stage.to_owned();
    };
    let item = match state.step() {
        Step::Check { item, .. } => {
            let task = state.protocol().task(&trial.task);
            let at = task.and_then(|task| task.checklist.iter().position(|one| one == item));
            at.map_or(0, |at| at + 1)
        }
        _ => 0,
    };
    format!(
        "{stage}-{}-{}-{}-{}-{item}",
        state.number(&trial.name),
        of.attempts,
        of.plays.iter().sum::<u32>(),
        of.answers.len()
    )
}

/// The samples on the tray that are put in order, from the left. On the participant's page they are letters: their names stand for an order,
/// and numbers are its ranks.
fn places(state: &State<'_>, trial: &Trial) -> Vec<String> {
    match (&trial.presented, &trial.answer) {
        (Presented::Tray { .. }, AnswerForm::Order { .. }) => state.presented(trial),
        _ => Vec::new(),
    }
}

/// The letters of `names` among `places`, from A; as they are where there are no places.
fn lettered(places: &[String], names: &[String]) -> Vec<String> {
    let letter = |name: &String| {
        let at = places.iter().position(|place| place == name);
        at.and_then(|at| letters().nth(at))
            .unwrap_or_else(|| name.clone())
    };
    names.iter().map(letter).collect()
}

/// How the trial is answered, and what is noted, by names.
fn named_answer(
    state: &State<'_>,
    step: &Step<'_>,
    played_by: PlayedBy,
) -> Option<(Form, Option<Text>)> {
    let on_tray = |trial: &Trial, of: &TrialState| {
        let mut form = form(state, trial, of, played_by);
        if is_rendered(trial) {
            // By hand, too, it is counted how often each was felt.
            form.felt.clone_from(&of.plays);
        }
        let places = places(state, trial);
        if !places.is_empty() {
            // As they lie: the list of the protocol is their order.
            form.choices = as_said(places);
        }
        form
    };
    match step {
        Step::Answer { trial, state: of } => Some((on_tray(trial, of), None)),
        Step::Confirm { trial, answer } => {
            let (_, of) = state.current()?;
            let form = on_tray(trial, of);
            let said = said(&form, answer);
            Some((form, Some(said)))
        }
        _ => None,
    }
}

/// `form` with the letters of places, where samples on the tray are put in order.
fn with_letters(state: &State<'_>, trial: &Trial, mut form: Form) -> Form {
    let places = places(state, trial);
    if !places.is_empty() {
        form.ask = Word::PutPlacesInOrder;
        form.noted = lettered(&places, &form.noted);
        form.choices = as_said(letters().take(places.len()));
    }
    form
}

fn open_step(
    state: &State<'_>,
    step: &Step<'_>,
    consent: Option<&str>,
    played_by: PlayedBy,
) -> OpenStep {
    match step {
        Step::AskConsent => OpenStep::Consent(consent.map(str::to_owned)),
        Step::Begin | Step::Check { .. } | Step::Present { .. } | Step::End => OpenStep::Wait,
        Step::Answer { trial, state: of } => {
            let form = form(state, trial, of, played_by);
            OpenStep::Answer(with_letters(state, trial, form))
        }
        Step::Confirm { trial, answer } => {
            let Some((_, of)) = state.current() else {
                return OpenStep::Wait;
            };
            let form = form(state, trial, of, played_by);
            let form = with_letters(state, trial, form);
            let said = match answer {
                Answer::Names(names) => {
                    let names = lettered(&places(state, trial), names);
                    said(&form, &Answer::Names(names))
                }
                other => said(&form, other),
            };
            OpenStep::Confirm { said, form }
        }
        Step::GoOn => OpenStep::Pause,
        Step::Nothing => OpenStep::Over,
    }
}

/// After how many seconds the next trial of `task` begins by itself; none where the experimenter begins it.
pub(crate) fn next_after(task: Option<&Task>) -> Option<f64> {
    match &task?.kind {
        TaskKind::Compare { next_after_s, .. } => *next_after_s,
        _ => None,
    }
}

/// The choices that `names` are, as they are shown for `trial`.
pub(crate) fn shown_as(state: &State<'_>, trial: &Trial, names: &[String]) -> Text {
    let task = state.protocol().task(&trial.task);
    let choices = state.choices(trial);
    let each: Vec<Text> = names
        .iter()
        .map(
            |name| match choices.iter().position(|(said, _)| said == name) {
                Some(i) => shown(task, i, name),
                None => name.clone().into(),
            },
        )
        .collect();
    Text::joined(each.iter())
}

pub(crate) fn is_rendered(trial: &Trial) -> bool {
    matches!(
        trial.presented,
        Presented::Rendered { .. } | Presented::Chosen { .. }
    )
}

fn closed_step(
    state: &State<'_>,
    step: &Step<'_>,
    consent: Option<&str>,
    played_by: PlayedBy,
) -> ClosedStep {
    match step {
        Step::Begin | Step::AskConsent => ClosedStep::Consent(consent.map(str::to_owned)),
        Step::Check { task, item } => {
            let task = state.protocol().task(task);
            let item = (*item).to_owned();
            ClosedStep::Check(match task {
                Some(task) => {
                    let at = task.checklist.iter().position(|one| *one == item);
                    Text::of(task, item, |words| words.checklist.get(at?).cloned())
                }
                None => item.into(),
            })
        }
        Step::Present { trial, .. } => match &trial.presented {
            Presented::Tray { samples } => ClosedStep::LayOut(samples.clone()),
            Presented::Sample { sample } => ClosedStep::HandOver(sample.clone()),
            Presented::Rendered { .. } | Presented::Chosen { .. } => {
                let names = state.presented(trial);
                match played_by {
                    PlayedBy::Bench => ClosedStep::Play(names.len()),
                    PlayedBy::Hand => ClosedStep::PlayByHand(names),
                }
            }
        },
        Step::Answer { .. } | Step::Confirm { .. } | Step::GoOn => ClosedStep::Answer,
        Step::End => ClosedStep::End,
        Step::Nothing if state.stage() == Stage::Withdrawn => ClosedStep::Withdrawn,
        Step::Nothing if state.stage() == Stage::Stopped => ClosedStep::Stopped,
        Step::Nothing if !state.is_complete() => ClosedStep::NoConsent,
        Step::Nothing => ClosedStep::Over,
    }
}

fn heading(state: &State<'_>, trial: &Trial, of: &TrialState) -> Heading {
    let task = state.protocol().task(&trial.task);
    Heading {
        number: state.number(&trial.name),
        of: state.plan().trials.len(),
        task: match task {
            Some(task) => Text::of(task, task.title.clone(), |words| words.title.clone()),
            None => trial.task.clone().into(),
        },
        set: trial.set.clone(),
        // A catch trial is not to be known as one.
        is_training: matches!(trial.kind, TrialKind::Training { .. }),
        attempt: of.attempts + u32::from(of.plays.is_empty()),
    }
}

fn measured(of: &TrialState) -> Vec<Measured> {
    let each = of.evidence.iter().map(|(element, evidence)| Measured {
        element: element + 1,
        reached: match evidence.missed() {
            true => Outcome::NotMet,
            false => evidence.reached,
        },
        level_db: evidence.level_re_target_db,
        force_n: evidence.normal_force_n,
    });
    each.collect()
}

fn answered(state: &State<'_>) -> Vec<Answered> {
    let trials = state.trials().enumerate();
    let answered = trials.filter_map(|(at, (trial, of))| {
        let answer = of.answer().filter(|_| of.confirmed)?;
        Some(Answered {
            number: at + 1,
            name: trial.name.clone(),
            task: trial.task.clone(),
            said: noted(answer),
            is_corrected: !of.corrections.is_empty(),
        })
    });
    let mut answered: Vec<Answered> = answered.collect();
    answered.reverse();
    answered
}

/// The words of an answer: the participant's own letters stay letters.
pub(crate) fn words_of(answer: &Answer) -> Vec<String> {
    match answer {
        Answer::Done => Vec::new(),
        Answer::Unknown => vec![UNKNOWN.to_owned()],
        Answer::Number(number) => vec![number.to_string()],
        Answer::Names(names) => names.clone(),
        Answer::Places(places) => {
            let said = places.iter().filter_map(|place| letters().nth(*place));
            said.collect()
        }
    }
}

/// An answer as it was noted.
fn noted(answer: &Answer) -> String {
    match answer {
        Answer::Done => "✓".to_owned(),
        other => words_of(other).join(", "),
    }
}

/// An answer to `form` as it was said.
fn said(form: &Form, answer: &Answer) -> Text {
    if *answer == Answer::Unknown {
        return Text::of_word(UNKNOWN, Word::DoNotKnow);
    }
    if *answer == Answer::Done {
        return noted(answer).into();
    }
    let words = words_of(answer).into_iter();
    let shown = words.map(|word| {
        let mut choices = form.choices.iter();
        let found = choices.find(|(said, _)| *said == word);
        found.map_or_else(|| word.clone().into(), |(_, text)| text.clone())
    });
    let shown: Vec<Text> = shown.collect();
    Text::joined(shown.iter())
}
