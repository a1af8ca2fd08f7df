//! Answers, and whether they fit their trial.

use crate::campaign::session::SessionError;
use serde::{Deserialize, Serialize};

use super::super::plan::AnswerForm;

/// An answer.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// It is done.
    Done,
    /// Names of samples, stimuli, descriptors or choices, in their order.
    Names(Vec<String>),
    /// Places in the participant's own order, from 0: A is 0. What stands there follows from the trial with the order, also
    /// where the experimenter corrects how that was noted.
    Places(Vec<usize>),
    /// A number.
    Number(i64),
    /// The participant does not know.
    Unknown,
}

/// How "I do not know" is typed and sent.
pub const UNKNOWN: &str = "?";

/// A, B, C … Z, AA, AB …
///
/// Source: thesis 2.6.2, the identifiers of samples; columns of spreadsheets beyond Z.
pub fn letters() -> impl Iterator<Item = String> {
    let letter = |i: usize| char::from(b'A' + (i % 26) as u8).to_string();
    (0_usize..).map(move |i| match i / 26 {
        0 => letter(i),
        more => letter(more - 1) + &letter(i),
    })
}

/// The answer that `words` give to a trial that is answered in `form`, where `choices` are what may be said with what it stands for
/// and `elements` is the number of elements presented; `may_not_know` says whether "I do not know" is an answer.
pub(super) fn understand(
    (form, may_not_know): (&AnswerForm, bool),
    choices: &[(String, String)],
    elements: usize,
    words: &[String],
) -> Result<Answer, SessionError> {
    let listed = || {
        choices
            .iter()
            .map(|(said, _)| said.as_str())
            .collect::<Vec<_>>()
            .join(" ")
    };
    let count = |expected: String| SessionError::Count {
        expected,
        choices: listed(),
        found: words.len(),
    };
    let places = || {
        let each = words.iter().map(|word| choice(word, choices, &listed));
        each.collect::<Result<Vec<usize>, _>>()
    };
    let named = || {
        let named = |places: Vec<usize>| places.into_iter().map(|i| choices[i].1.clone()).collect();
        places().map(|places| Answer::Names(named(places)))
    };
    let exactly = |wanted: usize| match words.len() == wanted {
        true => named(),
        false => Err(count(wanted.to_string())),
    };
    if may_not_know && *form != AnswerForm::Done && words == [UNKNOWN] {
        return Ok(Answer::Unknown);
    }
    match form {
        AnswerForm::Done => match words {
            [] => Ok(Answer::Done),
            _ => Err(count("nothing".to_owned())),
        },
        AnswerForm::OneOf { .. } => exactly(1),
        AnswerForm::Each { .. } => exactly(elements),
        AnswerForm::EachOfOrder { .. } => match words.len() == elements {
            true => places().map(Answer::Places),
            false => Err(count(elements.to_string())),
        },
        AnswerForm::Order { samples, .. } => {
            let answer = exactly(samples.len())?;
            distinct(&answer, &listed)?;
            Ok(answer)
        }
        AnswerForm::Some { at_most, .. } => {
            if words.is_empty() || words.len() > *at_most {
                return Err(count(format!("1 to {at_most}")));
            }
            let answer = named()?;
            distinct(&answer, &listed)?;
            Ok(answer)
        }
        AnswerForm::Scale { from, to } => {
            let said = words.join(" ");
            match said.parse::<i64>() {
                Ok(number) if (*from..=*to).contains(&number) => Ok(Answer::Number(number)),
                _ => Err(SessionError::Scale {
                    from: *from,
                    to: *to,
                    found: said,
                }),
            }
        }
    }
}

/// The place of `word` among the choices; capital and small letters are the same where that leaves one choice.
fn choice(
    word: &str,
    choices: &[(String, String)],
    listed: &impl Fn() -> String,
) -> Result<usize, SessionError> {
    let exact = choices.iter().position(|(said, _)| said == word);
    let small = word.to_lowercase();
    let mut alike = (0..choices.len()).filter(|i| choices[*i].0.to_lowercase() == small);
    let only = match (alike.next(), alike.next()) {
        (Some(only), None) => Some(only),
        _ => None,
    };
    exact.or(only).ok_or_else(|| SessionError::NoChoice {
        found: word.to_owned(),
        choices: listed(),
    })
}

fn distinct(answer: &Answer, listed: &impl Fn() -> String) -> Result<(), SessionError> {
    let Answer::Names(names) = answer else {
        return Ok(());
    };
    let twice = names
        .iter()
        .enumerate()
        .find(|(i, name)| names[..*i].contains(name));
    match twice {
        None => Ok(()),
        Some((_, name)) => Err(SessionError::NamedTwice {
            name: name.clone(),
            choices: listed(),
        }),
    }
}
