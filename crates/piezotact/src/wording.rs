//! Doubts in words: what was found, and what to do.
//!
//! The sentences are defined beside the rules that raise the doubts. This module tries every kind of doubt in turn, so that
//! doubts read from a file get their sentences too.

use std::fmt;

use crate::doubt::{Advice, ChannelRole, Doubt, DoubtKind, Value};
use crate::feature::FeatureError;
use crate::recording::RecordingError;
use crate::score::ScoreError;
use crate::stroke::SegmentError;
use crate::transfer::TransferError;

/// The texts that a kind of doubt provides for its own doubts.
type Said = (String, Vec<Advice>);

fn said_by<K: DoubtKind>(doubt: &Doubt) -> Option<Said> {
    let kind: K = doubt.kind()?;
    Some((kind.to_string(), kind.advice()))
}

/// All kinds.
const KINDS: &[fn(&Doubt) -> Option<Said>] = &kinds_of_doubts!(said_by);

fn said(doubt: &Doubt) -> Option<Said> {
    KINDS.iter().find_map(|kind| kind(doubt))
}

/// What was found and why it matters, without what to do. A doubt that this version does not know is given with its code
/// and its values.
///
/// Source: house rule; decision 0037 of this project.
#[must_use]
pub fn finding(doubt: &Doubt) -> String {
    if let Some((found, _)) = said(doubt) {
        return found;
    }
    if let ("noted", Some(Value::Example(text))) = (doubt.code.as_ref(), doubt.values.get("text")) {
        return text.clone();
    }
    let about = doubt.about.iter().filter_map(|about| about.name());
    let about = about.map(|name| format!("about {name}"));
    let values = doubt.values.iter().map(|(name, value)| {
        let value = serde_json::Value::from(value.clone());
        format!("{name} = {value}")
    });
    let values: Vec<String> = about.chain(values).collect();
    let values = if values.is_empty() {
        String::new()
    } else {
        format!(" ({})", values.join(", "))
    };
    format!(
        "a doubt of another version of this program: {}{values}",
        doubt.code
    )
}

/// What a person can do: as stored with the doubt, else as its kind says.
///
/// Source: house rule; decision 0037 of this project.
#[must_use]
pub fn advice(doubt: &Doubt) -> Vec<Advice> {
    match said(doubt) {
        Some((_, advice)) if doubt.advice.is_empty() => advice,
        _ => doubt.advice.clone(),
    }
}

/// What was found and what to do, with each advice in the words of a front end.
///
/// Source: house rule; decision 0037 of this project.
#[must_use]
pub fn text_with(doubt: &Doubt, words: &dyn Fn(&Advice) -> String) -> String {
    worded(finding(doubt), &advice(doubt), words)
}

/// As [`text_with`], of a doubt of the kind `K` that another crate raises; `None` where it is of another kind.
///
/// Source: house rule; decision 0037 of this project.
#[must_use]
pub fn text_of<K: DoubtKind>(doubt: &Doubt, words: &dyn Fn(&Advice) -> String) -> Option<String> {
    let (found, advice) = said_by::<K>(doubt)?;
    let stored = !doubt.advice.is_empty();
    let advice = if stored { &doubt.advice } else { &advice };
    Some(worded(found, advice, words))
}

fn worded(found: String, advice: &[Advice], words: &dyn Fn(&Advice) -> String) -> String {
    let advice: Vec<String> = advice.iter().map(words).collect();
    if advice.is_empty() {
        return found;
    }
    let between = if found.contains(": ") { "; " } else { ": " };
    format!("{found}{between}{}", advice.join("; "))
}

/// What a person can do about an error of the science, beyond what its sentence says; `None` where that is all.
///
/// Source: house rule; decision 0037 of this project.
#[must_use]
pub fn advice_of_error(error: &(dyn std::error::Error + 'static)) -> Vec<Advice> {
    let role = |role| Advice::NameChannel { role };
    if let Some(error) = error.downcast_ref() {
        return match error {
            RecordingError::Ambiguous { .. } => vec![role(ChannelRole::Signal)],
            RecordingError::Unit { .. } => vec![Advice::StateScale],
            _ => Vec::new(),
        };
    }
    if let Some(error) = error.downcast_ref::<TransferError>() {
        return error.advice();
    }
    if let Some(SegmentError::NothingToCutBy) = error.downcast_ref() {
        let roles = [
            ChannelRole::NormalForce,
            ChannelRole::Motion,
            ChannelRole::Vibration,
        ];
        return roles.map(role).to_vec();
    }
    if let Some(FeatureError::NoVibration | FeatureError::Units { .. }) = error.downcast_ref() {
        return vec![role(ChannelRole::Vibration)];
    }
    if let Some(ScoreError::TooShort { .. }) = error.downcast_ref() {
        return vec![Advice::JoinWithItself];
    }
    Vec::new()
}

impl fmt::Display for Doubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&text_with(self, &Advice::to_string))
    }
}
