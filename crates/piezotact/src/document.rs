//! Documents: values as they are handed out, with the name and the version of their form.
//!
//! A value that a command hands out implements [`Content`]. Its [`Document`] is what JSON holds: `schema`, `version`, and the
//! fields of the value. `docs/schemas/` has the JSON Schema of each.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize, Serializer};
use serde_json::{Map, Value};

use crate::warning::{Merged, Warning};

/// The field of a document that says how it was made ([`crate::invocation::Invocation`]); it is no part of the value.
pub const INVOCATION: &str = "invocation";

/// A value with a written form of its own.
pub trait Content: Serialize {
    /// The name of its form: "noise".
    const SCHEMA: &'static str;
    /// The version of its form. It rises when a field is removed or changes its meaning; a new field leaves it as it is.
    const VERSION: u32 = 1;

    /// Why a document of an earlier version with these fields is not read, and how it is made again; `None` for one that is read.
    fn outdated(_version: u64, _fields: &Map<String, Value>) -> Option<String> {
        None
    }
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
    /// Source: docs/decisions/documents.md.
    pub fn of(content: &'a T) -> Self {
        Self {
            schema: T::SCHEMA,
            version: T::VERSION,
            content,
        }
    }
}

/// A result with the file that holds it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Kept<'a, T> {
    /// The file that holds it.
    pub out: &'a Path,
    #[serde(flatten)]
    pub value: &'a T,
}

impl<T: Content> Content for Kept<'_, T> {
    const SCHEMA: &'static str = T::SCHEMA;
    const VERSION: u32 = T::VERSION;
}

/// Writes a value as its text; for serde's `serialize_with`.
///
/// Source: house rule.
///
/// # Errors
/// Those of the serializer.
pub fn in_words<S: Serializer>(value: &impl Display, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.collect_str(value)
}

/// A file of several from which there is no result.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct FailedFile {
    /// The file.
    pub file: PathBuf,
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
    /// It was written by an earlier version of the program, and its form is no longer read.
    #[error("expected version {known} of the document `{schema}`, found version {found}: {why}")]
    Earlier {
        schema: &'static str,
        /// The version that is read.
        known: u32,
        found: u64,
        /// Why it is not read, and how it is made again.
        why: String,
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
/// Source: docs/decisions/documents.md.
///
/// # Errors
/// [`DocumentError`] for a document of another kind, of a newer version or of an earlier one that is no longer read, and for a text that is no document.
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
    if let Some(why) = T::outdated(version, &fields) {
        return Err(DocumentError::Earlier {
            schema: expected,
            known: T::VERSION,
            found: version,
            why,
        });
    }
    serde_json::from_value(Value::Object(fields)).map_err(wrong)
}

/// How a front end words warnings: the command line adds the names of options.
pub trait Words {
    /// A warning with what to do.
    fn warning(&self, warning: &Warning) -> String;
    /// Warnings of one kind.
    fn merged(&self, warnings: &Merged) -> String {
        warnings.text_with(&|warning| self.warning(warning))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
    fn a_file_stands_beside_the_fields_of_a_result() {
        let level = Level { level_db: -3.5 };
        let kept = Kept {
            out: Path::new("a.json"),
            value: &level,
        };
        let text = serde_json::to_string(&Document::of(&kept)).unwrap();
        assert_eq!(
            text,
            r#"{"schema":"level","version":2,"out":"a.json","level_db":-3.5}"#
        );
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
}
