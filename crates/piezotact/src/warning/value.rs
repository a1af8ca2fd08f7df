//! The subject of a warning, and the values that it holds.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::Warning;
use crate::checksum::Checksum;
use crate::quantity::{Band, Hertz};

/// What a warning is about.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum About {
    /// A channel, by its name.
    Channel(String),
    /// A signal that is not a channel of a recording, such as "the target".
    Signal(String),
    /// A file, by its name.
    File(String),
    /// A group of recordings.
    Group(String),
    /// A participant of a panel.
    Participant(String),
    /// A measurement of a panel.
    Measurement(String),
    /// A value that was computed.
    Result(String),
    /// What a newer version writes.
    #[serde(untagged)]
    Other(serde_json::Value),
}

impl About {
    /// Its name; `None` for what a newer version writes.
    #[must_use]
    pub fn name(&self) -> Option<&str> {
        match self {
            Self::Channel(name)
            | Self::Signal(name)
            | Self::File(name)
            | Self::Group(name)
            | Self::Participant(name)
            | Self::Measurement(name)
            | Self::Result(name) => Some(name),
            Self::Other(_) => None,
        }
    }

    /// The same kind of thing without its name; `None` for what a newer version writes.
    pub(super) fn nameless(&self) -> Option<Self> {
        Some(match self {
            Self::Channel(_) => Self::Channel(String::new()),
            Self::Signal(_) => Self::Signal(String::new()),
            Self::File(_) => Self::File(String::new()),
            Self::Group(_) => Self::Group(String::new()),
            Self::Participant(_) => Self::Participant(String::new()),
            Self::Measurement(_) => Self::Measurement(String::new()),
            Self::Result(_) => Self::Result(String::new()),
            Self::Other(_) => return None,
        })
    }
}

/// A value of a warning.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// A number, in the unit that its name ends with.
    Number(f64),
    /// A name or a text.
    Text(String),
    /// One example of several; not compared when warnings are compared.
    Example(String),
    /// Counts by name; not compared when warnings are compared.
    Counts(BTreeMap<String, usize>),
    /// A band of frequencies.
    Band(Band),
    /// Several values.
    List(Vec<Self>),
    /// A warning of something that the result was made from, as an example.
    Warning(Box<Warning>),
    /// What a newer version writes.
    Other(serde_json::Value),
}

/// The name of one example of several; not compared when warnings are compared.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Example(pub String);

impl std::fmt::Display for Example {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

/// Counts of several things, by name.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Counts(pub BTreeMap<String, usize>);

impl Counts {
    /// `too short: 2, clipped: 1`, each name in the words that `words` has for it.
    pub(crate) fn text(&self, words: &dyn Fn(&str) -> String) -> String {
        let counts = self.0.iter();
        let texts: Vec<String> = counts
            .map(|(name, n)| format!("{}: {n}", words(name)))
            .collect();
        texts.join(", ")
    }
}

impl FieldValue for Counts {
    fn into_value(self) -> Option<Value> {
        Some(Value::Counts(self.0))
    }

    fn from_value(value: Option<&Value>) -> Option<Self> {
        match value? {
            Value::Counts(counts) => Some(Self(counts.clone())),
            _ => None,
        }
    }
}

/// A type that a field of a warning can have.
pub trait FieldValue: Sized {
    /// The value; `None` where there is nothing to hold.
    fn into_value(self) -> Option<Value>;
    /// The field; `None` where `value` is no such field.
    fn from_value(value: Option<&Value>) -> Option<Self>;
}

impl FieldValue for f64 {
    fn into_value(self) -> Option<Value> {
        Some(Value::Number(self))
    }

    fn from_value(value: Option<&Value>) -> Option<Self> {
        match value? {
            Value::Number(number) => Some(*number),
            // JSON has no NaN: it is written as null.
            Value::Other(serde_json::Value::Null) => Some(Self::NAN),
            _ => None,
        }
    }
}

/// The integer that a number is; `None` for a fraction, a negative one, and one beyond 2⁵³.
fn whole(number: f64) -> Option<u64> {
    const MOST: f64 = 9_007_199_254_740_992.0;
    ((0.0..=MOST).contains(&number) && number.fract() == 0.0).then_some(number as u64)
}

impl FieldValue for u64 {
    fn into_value(self) -> Option<Value> {
        Some(Value::Number(self as f64))
    }

    fn from_value(value: Option<&Value>) -> Option<Self> {
        whole(f64::from_value(value)?)
    }
}

impl FieldValue for usize {
    fn into_value(self) -> Option<Value> {
        Some(Value::Number(self as f64))
    }

    fn from_value(value: Option<&Value>) -> Option<Self> {
        Self::try_from(u64::from_value(value)?).ok()
    }
}

impl FieldValue for String {
    fn into_value(self) -> Option<Value> {
        Some(Value::Text(self))
    }

    fn from_value(value: Option<&Value>) -> Option<Self> {
        match value? {
            Value::Text(text) => Some(text.clone()),
            _ => None,
        }
    }
}

impl FieldValue for Example {
    fn into_value(self) -> Option<Value> {
        Some(Value::Example(self.0))
    }

    fn from_value(value: Option<&Value>) -> Option<Self> {
        match value? {
            Value::Example(text) => Some(Self(text.clone())),
            _ => None,
        }
    }
}

impl FieldValue for Checksum {
    fn into_value(self) -> Option<Value> {
        Some(Value::Text(self.to_string()))
    }

    fn from_value(value: Option<&Value>) -> Option<Self> {
        match value? {
            Value::Text(text) => serde_json::from_value(text.clone().into()).ok(),
            _ => None,
        }
    }
}

impl FieldValue for Band {
    fn into_value(self) -> Option<Value> {
        Some(Value::Band(self))
    }

    fn from_value(value: Option<&Value>) -> Option<Self> {
        match value? {
            Value::Band(band) => Some(*band),
            _ => None,
        }
    }
}

impl FieldValue for Warning {
    fn into_value(self) -> Option<Value> {
        Some(Value::Warning(Box::new(self)))
    }

    fn from_value(value: Option<&Value>) -> Option<Self> {
        match value? {
            Value::Warning(warning) => Some((**warning).clone()),
            _ => None,
        }
    }
}

impl<T: FieldValue> FieldValue for Vec<T> {
    fn into_value(self) -> Option<Value> {
        Some(Value::List(
            self.into_iter().filter_map(T::into_value).collect(),
        ))
    }

    fn from_value(value: Option<&Value>) -> Option<Self> {
        match value? {
            Value::List(values) => values.iter().map(|v| T::from_value(Some(v))).collect(),
            _ => None,
        }
    }
}

impl FieldValue for [f64; 2] {
    fn into_value(self) -> Option<Value> {
        self.to_vec().into_value()
    }

    fn from_value(value: Option<&Value>) -> Option<Self> {
        Vec::from_value(value)?.try_into().ok()
    }
}

impl<T: FieldValue> FieldValue for Option<T> {
    fn into_value(self) -> Option<Value> {
        self.and_then(T::into_value)
    }

    fn from_value(value: Option<&Value>) -> Option<Self> {
        match value {
            None => Some(None),
            some => T::from_value(some).map(Some),
        }
    }
}

impl From<Value> for serde_json::Value {
    fn from(value: Value) -> Self {
        match value {
            Value::Number(number) => match whole(number) {
                Some(whole) => whole.into(),
                None => number.into(),
            },
            Value::Text(text) => text.into(),
            Value::Example(text) => serde_json::json!({ "example": text }),
            Value::Counts(counts) => serde_json::json!(counts),
            Value::Band(band) => {
                let end = |hz: Hertz| Self::from(Value::Number(hz.0));
                serde_json::json!({ "low_hz": end(band.low()), "high_hz": end(band.high()) })
            }
            Value::List(values) => values.into_iter().map(Self::from).collect(),
            Value::Warning(warning) => serde_json::to_value(&*warning).unwrap_or_default(),
            Value::Other(other) => other,
        }
    }
}

impl From<serde_json::Value> for Value {
    fn from(json: serde_json::Value) -> Self {
        use serde_json::Value as Json;
        match json {
            Json::Number(number) => match number.as_f64() {
                Some(number) => Self::Number(number),
                None => Self::Other(number.into()),
            },
            Json::String(text) => Self::Text(text),
            Json::Array(values) => Self::List(values.into_iter().map(Self::from).collect()),
            Json::Object(fields) => {
                let number = |name: &str| fields.get(name).and_then(Json::as_f64).map(Hertz);
                let counts = || {
                    let counts = fields.iter().map(|(name, count)| {
                        Some((name.clone(), usize::try_from(count.as_u64()?).ok()?))
                    });
                    counts.collect::<Option<_>>().map(Self::Counts)
                };
                let known = match fields.len() {
                    _ if fields.contains_key("code") => {
                        let warning = serde_json::from_value(Json::Object(fields.clone()));
                        warning.ok().map(|warning| Self::Warning(Box::new(warning)))
                    }
                    1 => fields
                        .get("example")
                        .and_then(Json::as_str)
                        .map(|text| Self::Example(text.to_owned())),
                    2 => number("low_hz")
                        .zip(number("high_hz"))
                        .and_then(|(low, high)| Band::new(low, high).ok())
                        .map(Self::Band),
                    _ => None,
                };
                known
                    .or_else(counts)
                    .unwrap_or(Self::Other(Json::Object(fields)))
            }
            other => Self::Other(other),
        }
    }
}
