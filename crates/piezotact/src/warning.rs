//! Warnings: what a person should know before relying on a result. A value that had to be clamped, gated, guessed or estimated from
//! few data comes back with a [`Warning`]: what was found, and what to do.
//!
//! Each module has an enum of its warnings (`RenderWarning`, `TransferWarning`, …), one variant each: its fields, and one sentence with
//! its advice. `into` makes a [`Warning`] of it, which holds the same fields and the sentence, so that it can be written, read,
//! merged and shown without the enum. A warning of another version is kept and written again unchanged.

mod few;
mod list;
mod merged;
mod scatter;
pub mod words;

use std::collections::BTreeMap;
use std::error::Error;
use std::fmt;

use serde::de::{DeserializeOwned, Error as _};
use serde::{Deserialize, Deserializer, Serialize};
use serde_json::{Map, Value};

pub use few::{Few, FewWarning};
pub use list::Warnings;
pub(crate) use list::not_found_again;
pub use merged::{Merged, Range, merged, merged_of, serialize_merged};
pub use scatter::{OverStrokes, Scatter, ScatterWarning};

/// One thing that a person should know before relying on a result.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Warning {
    /// The variant of its enum: `force_not_measured`. Codes never change their meaning.
    pub code: String,
    /// The fields of the variant, by name; names of numbers end with their unit.
    #[serde(flatten)]
    pub fields: Map<String, Value>,
    /// What was found, why it matters and what to do, in one sentence.
    pub text: String,
    /// How many warnings are merged in it.
    pub seen: usize,
}

/// A warning as it is read.
#[derive(Deserialize)]
struct Stored {
    code: Option<String>,
    text: Option<String>,
    #[serde(default = "once")]
    seen: usize,
    #[serde(flatten)]
    fields: Map<String, Value>,
}

fn once() -> usize {
    1
}

/// Whether a warning says of a recording what it lacks as it was said before [`crate::recording::Losses`] did: read without them, the
/// recording would be taken as whole.
fn is_earlier_loss(code: &str, fields: &Map<String, Value>) -> bool {
    match code {
        "samples_lost" => !fields.contains_key("by"),
        "journal_damaged" | "playback_incomplete" => true,
        _ => false,
    }
}

impl<'de> Deserialize<'de> for Warning {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        let stored = Stored::deserialize(from)?;
        let is_known = |code: &String| !is_earlier_loss(code, &stored.fields);
        let (Some(code), Some(text)) = (stored.code.filter(is_known), stored.text) else {
            return Err(D::Error::custom(
                "a warning in the form of an earlier version (make the file again with this version)",
            ));
        };
        Ok(Self {
            code,
            fields: stored.fields,
            text,
            seen: stored.seen,
        })
    }
}

impl<W: Error + Serialize> From<W> for Warning {
    /// The warning that a variant of a module's enum is. The enum is written with its variant as `code`.
    fn from(warning: W) -> Self {
        let text = warning.to_string();
        let mut fields = match serde_json::to_value(&warning) {
            Ok(Value::Object(fields)) => fields,
            _ => Map::new(),
        };
        let code = match fields.remove("code") {
            Some(Value::String(code)) => code,
            _ => "unnamed".into(),
        };
        Self {
            code,
            fields,
            text,
            seen: 1,
        }
    }
}

/// Two warnings are equal when code, fields and count are. Sentences are not compared: they follow from the others.
impl PartialEq for Warning {
    fn eq(&self, other: &Self) -> bool {
        self.is_equivalent_to(other) && self.seen == other.seen
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl Warning {
    /// The warning as a variant of the enum `W`; `None` when it is of another one, or lacks a field. For tests: what a decision needs is
    /// a field of the result.
    ///
    /// ```
    /// use piezotact::Warning;
    /// use piezotact::warning::{Few, FewWarning};
    /// let what = Few::Segments;
    /// let warning = Warning::from(FewWarning::Few { found: 2, recommended: 10, what });
    /// assert!(matches!(warning.kind(), Some(FewWarning::Few { found: 2, what: Few::Segments, .. })));
    /// ```
    #[must_use]
    pub fn kind<W: Error + DeserializeOwned>(&self) -> Option<W> {
        let mut fields = self.fields.clone();
        fields.insert("code".into(), self.code.clone().into());
        serde_json::from_value(Value::Object(fields)).ok()
    }

    /// Whether code and fields equal those of `other`; count and sentence are not compared.
    #[must_use]
    pub fn is_equivalent_to(&self, other: &Self) -> bool {
        (&self.code, &self.fields) == (&other.code, &other.fields)
    }
}

/// The name of one example of several; not compared when warnings are merged.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Example {
    pub example: String,
}

impl From<String> for Example {
    fn from(example: String) -> Self {
        Self { example }
    }
}

impl fmt::Display for Example {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.example)
    }
}

/// Counts of several things, by name; not compared when warnings are merged.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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
