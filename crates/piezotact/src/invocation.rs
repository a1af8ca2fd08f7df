//! How a document or a report was made: the command as given, program, date, settings, and the files that were read.
//!
//! An [`Invocation`] stands beside the results and is no part of them: the same command on the same files gives the same results
//! on any date and in any folder.

use serde::{Deserialize, Serialize};

/// How a document or a report was made.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Invocation {
    /// The command as given: its arguments in order, without the program.
    pub command: Vec<String>,
    /// The program with its version.
    pub program: String,
    /// When it was run, or the date that was stated: RFC 3339, UTC.
    pub date: String,
    /// The folder in which it was run; relative paths begin there.
    pub folder: String,
    /// Every setting that has a value, in the order of the help.
    pub settings: Vec<Setting>,
    /// Every file that was read or looked for, in the order of reading.
    pub inputs: Vec<Input>,
    /// Which output of the command this is; absent for standard output.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output: Option<Output>,
    /// SHA-256 of the results beside the invocation, 64 hexadecimal digits.
    pub results_sha256: String,
}

/// A setting of a command.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Setting {
    /// Its name.
    pub name: String,
    /// Its values in words; several where it was given several times.
    pub values: Vec<String>,
    /// Whether it was given, or is the default.
    pub given: bool,
}

/// A file that was read or looked for.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Input {
    /// Its path as it was given.
    pub path: String,
    /// What was found there.
    #[serde(flatten)]
    pub found: Found,
}

/// What was found at a path.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "found", rename_all = "snake_case")]
pub enum Found {
    /// A file.
    File {
        /// Its length in bytes.
        bytes: u64,
        /// SHA-256 of its bytes, 64 hexadecimal digits.
        sha256: String,
    },
    /// A file that changed between its reading and the end of the command.
    Changed,
    /// No file: an optional one, such as a sidecar or cuts.
    Nothing,
}

/// Which output of a command something is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Output {
    /// The name of the setting that holds its path.
    pub setting: String,
    /// Its path in the folder that the setting names; absent where the setting names the file itself.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub below: Option<String>,
}

/// Whether a command that was run again gave the same results.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Rerun {
    /// The report or document that was made again.
    pub file: String,
    /// The command that was run, without the program.
    pub command: Vec<String>,
    /// Whether every value is the same.
    pub same: bool,
    /// How many values were compared: numbers, texts, figures.
    pub compared: usize,
    /// How many of them differ.
    pub different: usize,
    /// The first differences.
    pub first_differences: Vec<Difference>,
    /// What is no longer as it was: inputs, the report itself, the program.
    pub changed: Vec<String>,
}

/// A value that is another than before.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Difference {
    /// Which value: the path of a field, or the place in a report.
    pub place: String,
    /// The value before; absent where there was none.
    pub before: Option<String>,
    /// The value now; absent where there is none.
    pub now: Option<String>,
}

impl crate::document::Content for Rerun {
    const SCHEMA: &'static str = "rerun";
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_invocation_is_stored_and_read_again() {
        let file = Found::File {
            bytes: 3,
            sha256: "ab".into(),
        };
        let input = |path: &str, found| Input {
            path: path.into(),
            found,
        };
        let invocation = Invocation {
            command: vec!["info".into(), "S4.wav".into()],
            program: "piezotact 0.1.0".into(),
            date: "2026-11-22T18:00:00Z".into(),
            folder: "/study".into(),
            settings: Vec::new(),
            inputs: vec![
                input("S4.wav", file),
                input("S4.wav.json", Found::Nothing),
                input("growing.csv", Found::Changed),
            ],
            output: None,
            results_sha256: "cd".into(),
        };
        let text = serde_json::to_string(&invocation).unwrap();
        assert!(
            text.contains(r#"{"path":"S4.wav","found":"file","bytes":3,"sha256":"ab"}"#)
                && text.contains(r#"{"path":"S4.wav.json","found":"nothing"}"#),
            "{text}"
        );
        assert_eq!(
            serde_json::from_str::<Invocation>(&text).unwrap(),
            invocation
        );
    }
}
