//! How a trial is answered on a page: what can be chosen, in which words, and how many.

use piezotact_people::campaign::plan::{AnswerForm, Trial};
use piezotact_people::campaign::protocol::{Question, Task, TaskKind, TaskWords};
use piezotact_people::campaign::session::{State, TrialState};

use super::{Form, PlayedBy, Repeats, Text, is_rendered, next_after, words_of};
use crate::words::{Language, Word};

/// At most so many numbers are buttons; of a wider scale one is typed.
const MOST_BUTTONS: u64 = 21;

pub(super) fn form(state: &State<'_>, trial: &Trial, of: &TrialState, played_by: PlayedBy) -> Form {
    let task = state.protocol().task(&trial.task);
    let choices = state.choices(trial).into_iter().enumerate();
    let choices = choices.map(|(i, (said, _))| {
        let shown = shown(task, i, &said);
        (said, shown)
    });
    let choices: Vec<(String, Text)> = choices.collect();
    let elements = of.plays.len();
    let is_played = is_rendered(trial);
    let typed = match &trial.answer {
        AnswerForm::Scale { from, to } if to.abs_diff(*from) >= MOST_BUTTONS => Some([*from, *to]),
        _ => None,
    };
    let (ask, more, choices, count, repeats) = match &trial.answer {
        AnswerForm::Done => (
            Word::TouchNow,
            strokes(task),
            choices,
            [0, 0],
            Repeats::Once,
        ),
        AnswerForm::OneOf { .. } => (
            Word::Choose,
            Text::default(),
            choices,
            [1, 1],
            Repeats::Once,
        ),
        AnswerForm::EachOfOrder { .. } => (
            Word::ChooseLetters,
            Text::default(),
            choices,
            [elements; 2],
            Repeats::Any,
        ),
        AnswerForm::Each { .. } => (
            Word::ChooseForEach,
            Text::default(),
            choices,
            [elements; 2],
            Repeats::Any,
        ),
        AnswerForm::Order { from, to, .. } => {
            let all = choices.len();
            let ends = format!("{from} → {to}");
            let in_other = |words: &TaskWords| {
                let (from, to) = (words.from.as_ref()?, words.to.as_ref()?);
                Some(format!("{from} → {to}"))
            };
            let ends = match task {
                Some(task) => Text::of(task, ends, in_other),
                None => ends.into(),
            };
            (Word::PutInOrder, ends, choices, [all; 2], Repeats::Once)
        }
        AnswerForm::Some { at_most, .. } => {
            let most = at_most.to_string();
            (
                Word::ChooseUpTo,
                most.into(),
                choices,
                [1, *at_most],
                Repeats::Once,
            )
        }
        AnswerForm::Scale { from, to } => {
            let numbers = match typed {
                Some(_) => Vec::new(),
                None => as_said((*from..=*to).map(|number| number.to_string())),
            };
            (
                Word::ANumber,
                scale(task, [*from, *to]),
                numbers,
                [1, 1],
                Repeats::Once,
            )
        }
    };
    Form {
        ask,
        more,
        choices,
        may_not_know: state.may_not_know(trial) && trial.answer != AnswerForm::Done,
        is_final: next_after(task).is_some(),
        number: typed,
        count,
        repeats,
        felt: match is_played && played_by == PlayedBy::Bench {
            true => of.plays.clone(),
            false => Vec::new(),
        },
        noted: of.answers.last().map_or_else(Vec::new, words_of),
    }
}

/// What is noted and shown alike.
pub(super) fn as_said(words: impl IntoIterator<Item = String>) -> Vec<(String, Text)> {
    let each = words.into_iter();
    each.map(|word| (word.clone(), word.into())).collect()
}

/// Choice `i` of `task`, which is noted as `said`, as it is shown.
pub(super) fn shown(task: Option<&Task>, i: usize, said: &str) -> Text {
    let own = || said.to_owned();
    match task.map(|task| (task, &task.kind)) {
        Some((task, TaskKind::Categorise { .. })) => {
            Text::of(task, own(), |words| words.descriptors.get(i).cloned())
        }
        Some((_, TaskKind::Compare { question, .. })) => {
            let words = match question {
                Question::SameDifferent => [Word::Same, Word::Different],
                Question::Rougher | Question::Stronger => [Word::First, Word::Second],
            };
            words
                .get(i)
                .map_or_else(|| own().into(), |word| Text::of_word(said, *word))
        }
        _ => own().into(),
    }
}

/// How many strokes are asked for in a trial of touch.
fn strokes(task: Option<&Task>) -> Text {
    match task.map(|task| &task.kind) {
        Some(TaskKind::Touch { strokes }) => {
            let of = |word: Word, language| format!("{} {strokes}", word.in_language(language));
            let each = Language::ALL.map(|one| (one, of(Word::StrokesWanted, one)));
            Text {
                own: of(Word::StrokesWanted, Language::English),
                others: each.to_vec(),
            }
        }
        _ => Text::default(),
    }
}

/// A scale with what its ends stand for.
fn scale(task: Option<&Task>, [from, to]: [i64; 2]) -> Text {
    let ends = |lowest: Option<&str>, highest: Option<&str>| {
        let end = |number: i64, word: Option<&str>| match word {
            Some(word) => format!("{number} ({word})"),
            None => number.to_string(),
        };
        format!("{} – {}", end(from, lowest), end(to, highest))
    };
    match task.map(|task| (task, &task.kind)) {
        Some((
            task,
            TaskKind::Rate {
                lowest, highest, ..
            },
        )) => Text::of(task, ends(lowest.as_deref(), highest.as_deref()), |words| {
            Some(ends(words.from.as_deref(), words.to.as_deref()))
        }),
        _ => ends(None, None).into(),
    }
}
