//! Documents: values as they are handed out, with the name and the version of their form.
//!
//! A value that a command hands out implements [`Content`]. Its [`Document`] is what JSON holds: `schema`, `version`, and the
//! fields of the value. `docs/schemas/` has the JSON Schema of each.

use std::collections::BTreeMap;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use crate::warning::{About, Advice, Merged, Warning};

/// The field of a document that says how it was made ([`crate::invocation::Invocation`]); it is no part of the value.
pub const INVOCATION: &str = "invocation";

/// A value with a written form of its own.
pub trait Content: Serialize {
    /// The name of its form: "noise".
    const SCHEMA: &'static str;
    /// The version of its form. It rises when a field is removed or changes its meaning; a new field leaves it as it is.
    const VERSION: u32 = 1;
}

/// A value with the name and the version of its form.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Document<T> {
    schema: &'static str,
    version: u32,
    #[serde(flatten)]
    content: T,
}

impl<'a, T: Content> Document<&'a T> {
    /// The document of `content`.
    ///
    /// Source: decision 0046 of this project.
    pub fn of(content: &'a T) -> Self {
        Self {
            schema: T::SCHEMA,
            version: T::VERSION,
            content,
        }
    }
}

/// A file of several from which there is no result.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct FailedFile {
    /// The file.
    pub file: std::path::PathBuf,
    /// What was expected, what was found, and what to do.
    pub why: String,
}

/// A text that is not the expected document.
#[derive(Debug, thiserror::Error)]
pub enum DocumentError {
    /// It names no form.
    #[error(
        "expected a document `{expected}`, found no field `schema`; give a file that this program wrote as JSON"
    )]
    NoSchema {
        /// The form that was expected.
        expected: &'static str,
    },
    /// It is a document of another form.
    #[error(
        "expected a document `{expected}`, found one called `{found}`; give the file of the right kind"
    )]
    OtherKind {
        /// The form that was expected.
        expected: &'static str,
        /// The form that it names.
        found: String,
    },
    /// It was written by a newer version of the program.
    #[error(
        "expected version {known} or earlier of the document `{schema}`, found version {found}; read it with the version of the program that wrote it"
    )]
    Newer {
        schema: &'static str,
        /// The latest version that is known here.
        known: u32,
        found: u64,
    },
    /// It is not JSON, or a field is missing or wrong.
    #[error(
        "expected a document `{expected}`, found something else: {source}; write it again with this program"
    )]
    Content {
        /// The form that was expected.
        expected: &'static str,
        /// What the parser says.
        source: serde_json::Error,
    },
}

/// The value in a document, JSON text.
///
/// Source: decision 0046 of this project.
///
/// # Errors
/// [`DocumentError`] for a document of another kind or of a newer version, and for a text that is no document.
pub fn read<T: Content + DeserializeOwned>(text: &str) -> Result<T, DocumentError> {
    let expected = T::SCHEMA;
    let wrong = |source| DocumentError::Content { expected, source };
    let mut fields: Map<String, Value> = serde_json::from_str(text).map_err(wrong)?;
    let schema = fields.remove("schema");
    let schema = schema.as_ref().and_then(Value::as_str);
    let schema = schema.ok_or(DocumentError::NoSchema { expected })?;
    if schema != expected {
        return Err(DocumentError::OtherKind {
            expected,
            found: schema.to_owned(),
        });
    }
    // A document without a version is of the first.
    let version = fields.remove("version");
    let version = version.map_or(Some(1), |version| version.as_u64());
    let version = version.ok_or(DocumentError::NoSchema { expected })?;
    // How it was made is no part of the value.
    fields.remove(INVOCATION);
    if version > u64::from(T::VERSION) {
        return Err(DocumentError::Newer {
            schema: expected,
            known: T::VERSION,
            found: version,
        });
    }
    serde_json::from_value(Value::Object(fields)).map_err(wrong)
}

/// What a person can do, in a document.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct AdviceEntry {
    /// Which advice it is: `state_scale`.
    pub code: String,
    /// Its values by name; names end with their unit.
    pub values: Map<String, Value>,
    /// The advice in words.
    pub text: String,
}

/// One or several warnings of one kind, in a document, with the sentence for a person.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct WarningEntry {
    /// Which kind of warning it is: `force_not_measured`.
    pub code: String,
    /// What it is about.
    pub about: Option<About>,
    /// What was found, by name; names end with their unit.
    pub values: BTreeMap<String, Value>,
    /// How many warnings of this kind there are.
    pub seen: usize,
    /// What a person can do.
    pub advice: Vec<AdviceEntry>,
    /// The warning in words.
    pub text: String,
    /// The numbers in which several warnings differ: lowest and highest.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub ranges: BTreeMap<String, [f64; 2]>,
    /// The recordings, files or groups that several warnings are about.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub of: Vec<String>,
    /// What several warnings name themselves: channels, groups, measurements.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub subjects: Vec<String>,
}

/// How warnings and advice are put into words: the command line names options, Python keywords, a page buttons.
pub trait Words {
    /// A warning with what to do.
    fn warning(&self, warning: &Warning) -> String;
    /// An advice.
    fn advice(&self, advice: &Advice) -> String;
    /// Warnings of one kind.
    fn merged(&self, warnings: &Merged) -> String {
        warnings.text_with(&|warning| self.warning(warning))
    }
}

impl AdviceEntry {
    /// `advice` with its text.
    ///
    /// Source: decision 0046 of this project.
    pub fn of(advice: &Advice, words: &dyn Words) -> Self {
        let (code, values) = match serde_json::to_value(advice) {
            Ok(Value::String(code)) => (code, Map::new()),
            Ok(Value::Object(fields)) => match fields.into_iter().next() {
                Some((code, Value::Object(values))) => (code, values),
                Some((code, what)) => (code, Map::from_iter([("what".to_owned(), what)])),
                None => (String::new(), Map::new()),
            },
            _ => (String::new(), Map::new()),
        };
        Self {
            code,
            values,
            text: words.advice(advice),
        }
    }
}

impl WarningEntry {
    /// `warnings` of one kind with their text.
    ///
    /// Source: decisions 0030 and 0046 of this project.
    pub fn of(warnings: &Merged, words: &dyn Words) -> Self {
        let warning = &warnings.warning;
        let values = warning.values.iter().map(|(name, value)| {
            let mut value = Value::from(value.clone());
            complete_values(&mut value, words);
            (name.clone(), value)
        });
        Self {
            code: warning.code.clone().into_owned(),
            about: warning.about.clone(),
            values: values.collect(),
            seen: warning.seen,
            advice: (warning.advice.iter())
                .map(|advice| AdviceEntry::of(advice, words))
                .collect(),
            text: words.merged(warnings),
            ranges: (warnings.ranges.iter())
                .map(|range| (range.field.clone(), [range.low, range.high]))
                .collect(),
            of: warnings.about.clone(),
            subjects: warnings.subjects.clone(),
        }
    }
}

/// The keys of stored warnings.
const STORED: [&str; 5] = ["code", "about", "values", "seen", "advice"];
/// The keys that several warnings as one have besides.
const MERGED: [&str; 3] = ["ranges", "of", "subjects"];

/// Gives every warning in `document` the sentences of `words` and all its keys, whatever it holds: those in lists whose name
/// contains "warning", and those in the values of warnings. Stored warnings leave out what is empty.
///
/// Source: decision 0046 of this project.
pub fn complete_warnings(document: &mut Value, words: &dyn Words) {
    match document {
        Value::Object(fields) => {
            for (name, inner) in fields.iter_mut() {
                match inner {
                    Value::Array(warnings) if name.contains("warning") => {
                        for warning in warnings {
                            complete_one(warning, words);
                        }
                    }
                    other => complete_warnings(other, words),
                }
            }
        }
        Value::Array(values) => {
            for value in values {
                complete_warnings(value, words);
            }
        }
        _ => {}
    }
}

/// Completes warnings in the values of a warning.
fn complete_values(value: &mut Value, words: &dyn Words) {
    match value {
        Value::Array(several) => several.iter_mut().for_each(|one| complete_one(one, words)),
        one => complete_one(one, words),
    }
}

/// Completes `value` where it is a stored warning; else what is in it.
fn complete_one(value: &mut Value, words: &dyn Words) {
    let stored = value.as_object().is_some_and(|fields| {
        fields.get("code").is_some_and(Value::is_string)
            && (fields.keys()).all(|key| [&STORED[..], &MERGED].concat().contains(&key.as_str()))
    });
    let merged = stored.then(|| serde_json::from_value::<Merged>(value.clone()));
    let Some(Ok(merged)) = merged else {
        return complete_warnings(value, words);
    };
    if let Ok(whole) = serde_json::to_value(WarningEntry::of(&merged, words)) {
        *value = whole;
    }
}

/// Warnings of a document have the form that is printed, not the one that is stored.
#[cfg(feature = "schemas")]
mod schemas {
    use std::borrow::Cow;

    use schemars::{JsonSchema, Schema, SchemaGenerator};

    use super::WarningEntry;
    use crate::warning::{Merged, Warning};

    macro_rules! printed {
        ($($stored:ty),*) => { $(
            impl JsonSchema for $stored {
                fn schema_name() -> Cow<'static, str> {
                    WarningEntry::schema_name()
                }

                fn schema_id() -> Cow<'static, str> {
                    WarningEntry::schema_id()
                }

                fn json_schema(generator: &mut SchemaGenerator) -> Schema {
                    WarningEntry::json_schema(generator)
                }
            }
        )* };
    }

    printed!(Warning, Merged);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::recording::RecordingWarning;
    use crate::stroke::StrokeWarning;
    use crate::warning::merged;
    use serde_json::json;

    struct Plain;

    impl Words for Plain {
        fn warning(&self, warning: &Warning) -> String {
            format!("a warning called {}", warning.code)
        }

        fn advice(&self, advice: &Advice) -> String {
            format!("follow {advice}")
        }
    }

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    struct Level {
        level_db: f64,
    }

    impl Content for Level {
        const SCHEMA: &'static str = "level";
        const VERSION: u32 = 2;
    }

    #[test]
    fn a_document_says_which_form_it_has_and_is_read_again() {
        let level = Level { level_db: -3.5 };
        let text = serde_json::to_string(&Document::of(&level)).unwrap();
        assert_eq!(text, r#"{"schema":"level","version":2,"level_db":-3.5}"#);
        assert_eq!(read::<Level>(&text).unwrap(), level);
        let earlier = r#"{"schema":"level","level_db":1.0}"#;
        assert_eq!(read::<Level>(earlier).unwrap().level_db, 1.0);
    }

    #[test]
    fn a_document_of_another_kind_or_of_the_future_is_refused_by_name() {
        let refused = |text: &str| read::<Level>(text).unwrap_err().to_string();
        let other = refused(r#"{"schema":"score","version":1,"level_db":1.0}"#);
        assert!(
            other.contains("`level`") && other.contains("`score`"),
            "{other}"
        );
        let newer = refused(r#"{"schema":"level","version":3,"level_db":1.0}"#);
        assert!(
            newer.contains("version 2") && newer.contains("version 3"),
            "{newer}"
        );
        let none = refused(r#"{"level_db":1.0}"#);
        assert!(none.contains("no field `schema`"), "{none}");
        for broken in [
            "",
            "[]",
            "nonsense",
            r#"{"schema":"level"}"#,
            r#"{"schema":"level","version":-1}"#,
        ] {
            assert!(refused(broken).contains("`level`"), "{broken}");
        }
    }

    /// Python reads every warning by the same keys, those within warnings and those without advice too.
    #[test]
    fn every_warning_of_a_document_has_all_its_keys() {
        let plain = Warning::from(StrokeWarning::SlidingAssumed);
        let scaled = Warning::from(RecordingWarning::Uncalibrated {
            channel: "acc".into(),
        });
        let rate = Warning::from(RecordingWarning::RateStated {
            stated_hz: 1.0,
            found_hz: 2.0,
        });
        let mut outer = serde_json::to_value(&plain).unwrap();
        outer["values"] = json!({ "example": scaled, "several": [rate] });
        let mut document = json!({ "part": { "warnings": [outer] }, "code": "no warning" });
        complete_warnings(&mut document, &Plain);
        assert_eq!(document["code"], "no warning");
        let outer = &document["part"]["warnings"][0];
        let inner = [&outer["values"]["example"], &outer["values"]["several"][0]];
        for warning in inner.into_iter().chain([outer]) {
            for key in STORED.into_iter().chain(["text"]) {
                assert!(warning.get(key).is_some(), "no {key} in {warning}");
            }
            let code = warning["code"].as_str().unwrap();
            assert_eq!(warning["text"], format!("a warning called {code}"));
        }
        assert_eq!(
            (&outer["about"], &outer["advice"]),
            (&Value::Null, &json!([]))
        );
        let advice = &inner[0]["advice"][0];
        assert_eq!(
            (&advice["code"], &advice["values"]),
            (&json!("state_scale"), &json!({}))
        );
        assert_eq!(
            inner[1]["advice"][0]["values"],
            json!({ "what": "which_is_right" })
        );
        // A second time nothing changes.
        let once = document.clone();
        complete_warnings(&mut document, &Plain);
        assert_eq!(document, once);
    }

    #[test]
    fn warnings_of_one_kind_keep_their_ranges_in_a_document() {
        let rate = |found_hz| {
            Warning::from(RecordingWarning::RateStated {
                stated_hz: 1.0,
                found_hz,
            })
        };
        let all = merged(&[rate(2.0), rate(3.0)]);
        let mut document = json!({ "warnings": all });
        complete_warnings(&mut document, &Plain);
        let one = &document["warnings"][0];
        assert_eq!(one["ranges"], json!({ "found_hz": [2.0, 3.0] }));
        assert_eq!(one["seen"], 2);
        assert!(
            one["text"].as_str().unwrap().contains("2 of this kind"),
            "{one}"
        );
    }
}
