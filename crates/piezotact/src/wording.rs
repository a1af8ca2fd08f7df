//! Warnings in words: what was found, and what to do.
//!
//! The sentences are defined beside the rules that raise the warnings. This module tries every kind of warning in turn, so that
//! warnings read from a file get their sentences too.

use std::fmt;

use crate::feature::FeatureError;
use crate::recording::RecordingError;
use crate::score::ScoreError;
use crate::stroke::SegmentError;
use crate::transfer::TransferError;
use crate::warning::{Advice, ChannelRole, Value, Warning, WarningKind};

/// The texts that a kind of warning provides for its own warnings.
type Said = (String, Vec<Advice>);

fn said_by<K: WarningKind>(warning: &Warning) -> Option<Said> {
    let kind: K = warning.kind()?;
    Some((kind.to_string(), kind.advice()))
}

/// All kinds.
const KINDS: &[fn(&Warning) -> Option<Said>] = &kinds_of_warnings!(said_by);

fn said(warning: &Warning) -> Option<Said> {
    KINDS.iter().find_map(|kind| kind(warning))
}

/// What was found and why it matters, without what to do. A warning that this version does not know is given with its code
/// and its values.
///
/// Source: house rule; decision 0037 of this project.
#[must_use]
pub fn finding(warning: &Warning) -> String {
    if let Some((found, _)) = said(warning) {
        return found;
    }
    if let ("noted", Some(Value::Example(text))) =
        (warning.code.as_ref(), warning.values.get("text"))
    {
        return text.clone();
    }
    let about = warning.about.iter().filter_map(|about| about.name());
    let about = about.map(|name| format!("about {name}"));
    let values = warning.values.iter().map(|(name, value)| {
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
        "a warning of another version of this program: {}{values}",
        warning.code
    )
}

/// What a person can do: as stored with the warning, else as its kind says.
///
/// Source: house rule; decision 0037 of this project.
#[must_use]
pub fn advice(warning: &Warning) -> Vec<Advice> {
    match said(warning) {
        Some((_, advice)) if warning.advice.is_empty() => advice,
        _ => warning.advice.clone(),
    }
}

/// What was found and what to do, with each advice in the words of a front end.
///
/// Source: house rule; decision 0037 of this project.
#[must_use]
pub fn text_with(warning: &Warning, words: &dyn Fn(&Advice) -> String) -> String {
    worded(finding(warning), &advice(warning), words)
}

/// As [`text_with`], of a warning of the kind `K` that another crate raises; `None` where it is of another kind.
///
/// Source: house rule; decision 0037 of this project.
#[must_use]
pub fn text_of<K: WarningKind>(
    warning: &Warning,
    words: &dyn Fn(&Advice) -> String,
) -> Option<String> {
    let (found, advice) = said_by::<K>(warning)?;
    let stored = !warning.advice.is_empty();
    let advice = if stored { &warning.advice } else { &advice };
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

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&text_with(self, &Advice::to_string))
    }
}
