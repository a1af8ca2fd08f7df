//! What the experimenter sees at each step of a session.

use piezotact::number::counted;
use piezotact_people::campaign::plan::{AnswerForm, Presented, Trial, TrialKind};
use piezotact_people::campaign::protocol::TaskKind;
use piezotact_people::campaign::session::{
    Answer, Evidence, State, Step, TouchRecord, TrialState, UNKNOWN, letters,
};
use piezotact_people::campaign::text::part_in;

/// Lines on a screen with this many columns.
const WIDTH: usize = 78;

/// Who plays rendered textures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PlayedBy {
    /// The bench.
    Bench,
    /// The experimenter, on another system.
    Hand,
}

/// The lines of a step, and the prompt below them.
pub(super) struct Shown {
    pub(super) lines: Vec<String>,
    pub(super) prompt: &'static str,
}

/// What is shown at the step where `state` stands; of a task's text the participant hears it once for each `said` task.
pub(super) fn shown(state: &State<'_>, consent: Option<&str>, played_by: PlayedBy) -> Shown {
    match state.step() {
        Step::Begin => plain(&["The session begins."], "Enter>"),
        Step::AskConsent => {
            let stated = state.participant().language.as_deref();
            let text = consent.map_or(
                "Ask the participant for consent, in your own words.",
                |text| part_in(text, stated),
            );
            let mut lines = vec![rule("consent")];
            lines.extend(text.lines().flat_map(wrapped));
            lines.push("Does the participant consent? yes or no".to_owned());
            Shown {
                lines,
                prompt: "consent>",
            }
        }
        Step::Check { item, .. } => Shown {
            lines: vec![format!("  check: {item}")],
            prompt: "Enter when it is so>",
        },
        Step::Present { trial, attempt } => present(state, trial, attempt, played_by),
        Step::Answer { trial, state: of } => answer(state, trial, of),
        Step::Confirm { trial, answer } => Shown {
            lines: vec![format!("  noted: {}", said(state, trial, answer))],
            prompt: "Enter when it is final, or another answer>",
        },
        Step::GoOn => plain(&["  pause"], "Enter to go on>"),
        Step::End => plain(&["  All trials are done."], "Enter ends the session>"),
        Step::Nothing => plain(&[], ""),
    }
}

fn plain(lines: &[&str], prompt: &'static str) -> Shown {
    let lines = lines.iter().map(|&line| line.to_owned()).collect();
    Shown { lines, prompt }
}

/// A line across the screen with `title` in it.
fn rule(title: &str) -> String {
    let filled = WIDTH.saturating_sub(title.chars().count() + 4);
    format!("── {title} {}", "─".repeat(filled))
}

/// The heading of a trial: which one of how many, its task and its set.
fn heading(state: &State<'_>, trial: &Trial, attempt: u32) -> String {
    let number = state
        .trials()
        .position(|(other, _)| other.name == trial.name);
    let mut title = format!(
        "trial {} of {} · {}",
        number.map_or(0, |i| i + 1),
        state.plan().trials.len(),
        trial.task
    );
    if let Some(set) = &trial.set {
        title.push_str(&format!(" · set {set}"));
    }
    match trial.kind {
        TrialKind::Training { .. } => title.push_str(" · training"),
        // A catch trial is not to be known as one.
        TrialKind::Counted | TrialKind::Catch { .. } => {}
    }
    if attempt > 1 {
        title.push_str(&format!(" · attempt {attempt}"));
    }
    rule(&title)
}

fn present(state: &State<'_>, trial: &Trial, attempt: u32, played_by: PlayedBy) -> Shown {
    let mut lines = vec![heading(state, trial, attempt)];
    if let Some(task) = state.protocol().task(&trial.task) {
        lines.push(format!("  {}", task.title));
    }
    // What the participant is asked is read out once for each task.
    let first = state.trials().find(|(other, _)| other.task == trial.task);
    if let Some(task) = state.protocol().task(&trial.task)
        && first.is_some_and(|(first, _)| first.name == trial.name)
    {
        let stated = state.participant().language.as_deref();
        let words = stated.and_then(|tag| task.words_in(tag));
        let instruction = words.map_or(&task.instruction, |words| &words.instruction);
        let instruction = format!("“{instruction}”");
        lines.extend(
            wrapped(&instruction)
                .into_iter()
                .map(|line| format!("  {line}")),
        );
    }
    match &trial.presented {
        Presented::Tray { samples } => {
            lines.push("  lay the samples out, from the left:".to_owned());
            let slots = samples.iter().enumerate();
            lines.extend(side_by_side(
                slots.map(|(i, s)| format!("{} {s}{}", i + 1, turned(state, s))),
            ));
            lines.push("  then Enter".to_owned());
        }
        Presented::Sample { sample } => {
            lines.push(format!(
                "  hand over: {sample}{}, then Enter",
                turned(state, sample)
            ));
        }
        _ => {
            let count = state.presented(trial).len();
            lines.extend(own_order(state, trial));
            match played_by {
                PlayedBy::Bench if count == 1 => {
                    lines.push("  1 texture on the device: Enter plays it".to_owned());
                }
                PlayedBy::Bench => lines.push(format!(
                    "  {count} textures on the device: Enter plays them one after the other"
                )),
                PlayedBy::Hand => {
                    lines.push("  play by hand, one after the other, then Enter:".to_owned());
                    let names = state.presented(trial).into_iter().enumerate();
                    lines.extend(side_by_side(names.map(|(i, s)| format!("{} {s}", i + 1))));
                }
            }
        }
    }
    lines.retain(|line| !line.is_empty());
    Shown {
        lines,
        prompt: "present>",
    }
}

/// How `sample` is turned, in brackets; nothing where the protocol does not say it.
fn turned(state: &State<'_>, sample: &str) -> String {
    let turned = state.protocol().orientation.get(sample);
    turned.map_or_else(String::new, |turned| format!(" ({turned})"))
}

/// Where the participant's own A, B, C lie; nothing where samples have their names.
fn own_order(state: &State<'_>, trial: &Trial) -> Vec<String> {
    if !matches!(trial.answer, AnswerForm::EachOfOrder { .. }) {
        return Vec::new();
    }
    let mut lines = vec!["  on the tray, in the participant's order:".to_owned()];
    let places = state.choices(trial).into_iter();
    lines.extend(side_by_side(places.map(|(letter, sample)| {
        format!("{letter} {sample}{}", turned(state, &sample))
    })));
    lines
}

/// `items` in as few lines of the screen's width as hold them, none broken.
fn side_by_side(items: impl Iterator<Item = String>) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for item in items {
        match lines.last_mut() {
            Some(line) if line.chars().count() + 3 + item.chars().count() <= WIDTH => {
                line.push_str("   ");
                line.push_str(&item);
            }
            _ => lines.push(format!("    {item}")),
        }
    }
    lines
}

fn answer(state: &State<'_>, trial: &Trial, of: &TrialState) -> Shown {
    let mut lines: Vec<String> = played(&of.evidence).into_iter().collect();
    let choices: Vec<String> = state
        .choices(trial)
        .into_iter()
        .map(|(said, _)| said)
        .collect();
    let count = of.plays.len();
    let ask = match &trial.answer {
        AnswerForm::Done => match state.protocol().task(&trial.task).map(|task| &task.kind) {
            Some(TaskKind::Touch { strokes }) => {
                format!(
                    "{}; Enter when it is done",
                    counted(*strokes as usize, "stroke")
                )
            }
            _ => "Enter when it is done".to_owned(),
        },
        AnswerForm::OneOf { .. } => format!("one of {}", choices.join(" ")),
        AnswerForm::Each { .. } | AnswerForm::EachOfOrder { .. } => {
            format!("for each of the {count}, one of {}", choices.join(" "))
        }
        AnswerForm::Order { from, to, .. } => {
            format!(
                "all of {} in order, from the {from} to the {to}",
                choices.join(" ")
            )
        }
        AnswerForm::Some { at_most, .. } => {
            format!("up to {at_most} of {}", choices.join(", "))
        }
        AnswerForm::Scale { from, to } => {
            let [lowest, highest] = ends(state, trial).map(|end| match end {
                Some(end) => format!(" ({end})"),
                None => String::new(),
            });
            format!("a number from {from}{lowest} to {to}{highest}")
        }
    };
    let ask = match state.may_not_know(trial) {
        true => format!("{ask}, or {UNKNOWN} when it is not known"),
        false => ask,
    };
    lines.extend(wrapped(&ask).into_iter().map(|line| format!("  {line}")));
    Shown {
        lines,
        prompt: "answer>",
    }
}

/// What the lowest and the highest rating stand for, where the protocol says it.
fn ends<'a>(state: &'a State<'_>, trial: &Trial) -> [Option<&'a str>; 2] {
    let task = state.protocol().task(&trial.task);
    match task.map(|task| &task.kind) {
        Some(TaskKind::Rate {
            lowest, highest, ..
        }) => [lowest.as_deref(), highest.as_deref()],
        _ => [None, None],
    }
}

/// What was measured while the textures of a trial were played, in one line: never which stimulus it was, nor its level or which one
/// of them missed its target, by which it could be known.
fn played(evidence: &[(usize, Evidence)]) -> Option<String> {
    let outcome = match evidence {
        [] => return None,
        all if all.iter().any(|(_, one)| one.missed()) => "A TEXTURE MISSED ITS TARGET",
        all if all.iter().any(|(_, one)| one.is_open()) => "target not decided",
        _ => "target met",
    };
    let mut parts = vec![outcome.to_owned()];
    parts.extend(evidence.iter().filter_map(|(element, one)| {
        let force = one.normal_force_n?;
        Some(format!("texture {}: force {force:.2} N", element + 1))
    }));
    Some(format!("  {}", parts.join(", ")))
}

/// How the sample of the trial named `name` was touched.
pub(super) fn touched(state: &State<'_>, name: &str, touched: &TouchRecord) -> String {
    let mut trials = state.plan().trials.iter();
    let wanted = trials
        .find(|trial| trial.name == name)
        .and_then(|trial| state.strokes_wanted(trial))
        .unwrap_or_default();
    let mut parts = Vec::new();
    if let Some(found) = touched.strokes {
        parts.push(format!("strokes found: {found} of {wanted}"));
        if found < wanted {
            parts.push("NOT COMPLETE".to_owned());
        }
    }
    let recordings = touched.recordings.iter();
    let recordings: Vec<&str> = recordings.map(|one| one.journal.as_str()).collect();
    if !recordings.is_empty() {
        parts.push(format!("recorded as {}", recordings.join(", ")));
    }
    if let Some(why) = &touched.not_recorded {
        parts.push(format!(
            "THE VIBRATION WAS NOT RECORDED, or not all of it: {why}"
        ));
    }
    format!("  {}", parts.join("; "))
}

/// An answer as it was said.
pub(super) fn said(state: &State<'_>, trial: &Trial, answer: &Answer) -> String {
    match answer {
        Answer::Done => "done".to_owned(),
        Answer::Unknown => "not known".to_owned(),
        Answer::Number(number) => number.to_string(),
        Answer::Names(names) => names.join(" "),
        Answer::Places(places) => {
            let said = places.iter().filter_map(|place| letters().nth(*place));
            let said: Vec<String> = said.collect();
            format!(
                "{} ({})",
                said.join(" "),
                state.names(trial, answer).join(" ")
            )
        }
    }
}

/// `text` in lines of the screen's width.
fn wrapped(text: &str) -> Vec<String> {
    let mut lines = vec![String::new()];
    for word in text.split_whitespace() {
        let line = lines.last_mut().map_or(0, |line| line.chars().count());
        if line > 0 && line + 1 + word.chars().count() > WIDTH - 2 {
            lines.push(String::new());
        }
        if let Some(line) = lines.last_mut() {
            if !line.is_empty() {
                line.push(' ');
            }
            line.push_str(word);
        }
    }
    lines
}
