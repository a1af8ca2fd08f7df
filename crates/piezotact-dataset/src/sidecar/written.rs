//! Sidecars that people write: each entry is looked at by itself, so that a refusal names it and shows how it is written.

use std::path::Path;

use piezotact::Warning;
use piezotact::recording::{Condition, Event, NotUsed, RecordingWarning, StartTime};
use serde::de::DeserializeOwned;
use serde_json::{Map, Value, json};

use super::{Rendering, people_write_measures};
use crate::error::ReadError;

/// What a sidecar looks like.
pub(super) const EXAMPLE: &str =
    r#"a sidecar such as {"full_scale": {"value": 200, "unit": "m/s2"}}"#;
/// What to do about one that is none.
pub(super) const ADVICE: &str = "correct it, or remove it and give --scale";

/// The entries of a sidecar.
const ENTRIES: [&str; 13] = [
    "format",
    "full_scale",
    "channels",
    "units",
    "condition",
    "provenance",
    "warnings",
    "started_at",
    "labels",
    "events",
    "rendering",
    "samples",
    "rate_hz",
];
const OF_FULL_SCALE: [&str; 2] = ["value", "unit"];
const OF_EVENTS: [&str; 4] = ["onset_s", "duration_s", "kind", "value"];
/// The entries of a condition, with how each is written.
const OF_CONDITION: [(&str, &str); 8] = [
    ("sample", r#""S4""#),
    ("participant", r#""P01""#),
    ("twin_seed", "7"),
    ("load_n", "0.4"),
    ("angle_deg", "20"),
    ("speed_m_s", "0.04"),
    ("touch", r#""active", "passive" or "resting""#),
    (
        "direction",
        r#""proximal", "distal", "transversal" or "circular""#,
    ),
];
const EVENT: &str = r#"{"onset_s": 1.2, "duration_s": 0, "kind": "answer"}"#;

/// Refuses a sidecar with an entry that cannot be read, naming the entry and how it is written.
pub(super) fn check(path: &Path, text: &str) -> Result<(), ReadError> {
    let wrong =
        |expected: String, found: String| Err(ReadError::content(path, expected, found, ADVICE));
    let fields = match serde_json::from_str(text) {
        Ok(Value::Object(fields)) => fields,
        Ok(Value::Array(_)) => return wrong(EXAMPLE.into(), "a list".into()),
        Ok(other) => return wrong(EXAMPLE.into(), shown(&other)),
        Err(error) => {
            let found = format!(
                "text that is not JSON from line {}, column {} on",
                error.line(),
                error.column()
            );
            return wrong(EXAMPLE.into(), found);
        }
    };
    for (entry, value) in &fields {
        let as_written = match entry.as_str() {
            "full_scale" => (people_write_measures(value).is_err()).then_some(
                r#"{"full_scale": {"value": 200, "unit": "m/s2"}} or {"full_scale": "200 m/s2"}"#,
            ),
            "channels" => {
                (!reads::<Option<Vec<String>>>(value)).then_some(r#"{"channels": ["acc", "fz"]}"#)
            }
            "units" => {
                (!is_map_of_texts(value)).then_some(r#"{"units": {"acc": "m/s2", "fz": "2 N"}}"#)
            }
            "started_at" => match value {
                Value::String(_) | Value::Null => None,
                _ => Some(r#"{"started_at": "2024-03-01T10:22:33Z"}"#),
            },
            "labels" => (!is_map_of_texts(value)).then_some(r#"{"labels": {"session": "2"}}"#),
            "rendering" => (!reads::<Option<Rendering>>(value))
                .then_some("what `piezotact render` writes: write the drive again"),
            "rate_hz" => (!reads::<Option<f64>>(value)).then_some(r#"{"rate_hz": 5000}"#),
            "samples" => {
                (!reads::<Option<String>>(value)).then_some("what the program wrote: remove it")
            }
            _ => None,
        };
        if let Some(as_written) = as_written {
            let found = shown(value);
            return wrong(format!("`{entry}` as in {as_written}"), found);
        }
        match (entry.as_str(), value) {
            ("started_at", Value::String(text)) => {
                if let Err(error) = StartTime::try_from(text.clone()) {
                    return wrong(
                        "a date and time such as 2024-03-01T10:22:33+01:00 in `started_at`".into(),
                        format!("`{}`", error.found),
                    );
                }
            }
            ("condition", Value::Object(of)) => {
                for (name, example) in OF_CONDITION {
                    let Some(value) = of.get(name) else { continue };
                    if !reads::<Condition>(&json!({ name: value })) {
                        let expected = format!(
                            r#"`condition.{name}` as in {{"condition": {{"{name}": {example}}}}}"#
                        );
                        return wrong(expected, shown(value));
                    }
                }
            }
            ("condition", other) => {
                let expected = r#"`condition` as in {"condition": {"sample": "S4", "participant": "P01", "load_n": 0.4}}"#;
                return wrong(expected.into(), shown(other));
            }
            ("events", Value::Array(events)) => {
                for (i, event) in events.iter().enumerate() {
                    if let Some(found) = wrong_event(event) {
                        return wrong(format!("event {} as in {EVENT}", i + 1), found);
                    }
                }
            }
            ("events", other) => {
                return wrong(
                    format!(r#"`events` as in {{"events": [{EVENT}]}}"#),
                    shown(other),
                );
            }
            _ => {}
        }
    }
    Ok(())
}

/// What is wrong with an event.
fn wrong_event(event: &Value) -> Option<String> {
    let Some(of) = event.as_object() else {
        return Some(shown(event));
    };
    for name in &OF_EVENTS[..3] {
        let Some(value) = of.get(*name) else {
            return Some(format!("none called `{name}` in {}", shown(event)));
        };
        let fits = match *name {
            "kind" => value.is_string(),
            _ => value.is_number(),
        };
        if !fits {
            return Some(format!("`{name}`: {}", shown(value)));
        }
    }
    match of.get("value") {
        Some(value) if !reads::<Event>(event) => Some(format!("`value`: {}", shown(value))),
        _ => None,
    }
}

/// The warning about entries that nothing reads.
pub(super) fn unknown_entries(path: &Path, text: &str) -> Option<Warning> {
    let fields: Map<String, Value> = serde_json::from_str(text).ok()?;
    let mut entries = Vec::new();
    let mut look = |of: &str, value: &Value, known: &[&str]| {
        for name in value.as_object().into_iter().flat_map(Map::keys) {
            if !known.contains(&name.as_str()) {
                entries.push(format!("`{of}{name}`"));
            }
        }
    };
    for (name, value) in &fields {
        match name.as_str() {
            "full_scale" => look("full_scale.", value, &OF_FULL_SCALE),
            "condition" => look("condition.", value, &OF_CONDITION.map(|(name, _)| name)),
            "events" => {
                for (i, event) in value.as_array().into_iter().flatten().enumerate() {
                    look(&format!("events[{i}]."), event, &OF_EVENTS);
                }
            }
            _ => {}
        }
    }
    look("", &Value::Object(fields), &ENTRIES);
    (!entries.is_empty()).then(|| {
        Warning::from(RecordingWarning::NotUsed {
            what: NotUsed::Entries {
                file: path.display().to_string(),
                entries,
            },
        })
    })
}

fn reads<T: DeserializeOwned>(value: &Value) -> bool {
    serde_json::from_value::<T>(value.clone()).is_ok()
}

fn is_map_of_texts(value: &Value) -> bool {
    let fields = value.as_object();
    fields.is_some_and(|fields| fields.values().all(Value::is_string))
}

/// A value as it stands in the file, shortened.
fn shown(value: &Value) -> String {
    let text = value.to_string();
    let mut start: String = text.chars().take(80).collect();
    if start.len() < text.len() {
        start.push('…');
    }
    start
}
