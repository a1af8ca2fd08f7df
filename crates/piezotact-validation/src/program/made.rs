//! How the program was called, for the document and the report that it writes.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Command};
use piezotact::document::{Content, INVOCATION};
use piezotact::invocation::{Invocation, Output, Setting};
use piezotact_dataset::reads::{inputs, sha256};
use piezotact_report::invocation::with_invocation;

use super::failure::{NAME, Outcome};
use super::output::{document_value, write_text};

/// The command that the program was called with.
pub(super) struct Called {
    command: Vec<String>,
    date: String,
    pub(super) folder: PathBuf,
    settings: Vec<Setting>,
}

/// An output of a command: the folder that was given, a file in it, and what of the command is read.
pub(super) struct Written<'a> {
    pub(super) folder: &'a Path,
    pub(super) file: &'a Path,
    pub(super) read: Option<&'a Path>,
}

fn rfc3339(time: SystemTime) -> String {
    humantime::format_rfc3339_seconds(time).to_string()
}

/// A date as it was stated, as RFC 3339 in UTC.
pub(super) fn date(text: &str) -> Result<String, String> {
    let read = humantime::parse_rfc3339_weak(text)
        .or_else(|_no_time| humantime::parse_rfc3339_weak(&format!("{text} 00:00:00")));
    read.map(rfc3339).map_err(|_no_date| {
        "expected a date in UTC such as 2026-03-01 or 2026-03-01T10:22:33Z; leave it out for now".into()
    })
}

/// The settings that `matches` of `root` hold, in the order of the help.
fn settings(root: &Command, matches: &ArgMatches) -> Vec<Setting> {
    let below = matches.subcommand();
    let found = below.and_then(|(name, found)| Some((root.find_subcommand(name)?, found)));
    let Some((command, found)) = found else {
        return Vec::new();
    };
    let own = |argument: &&Arg| !argument.is_global_set();
    let setting = |argument: &Arg| {
        let id = argument.get_id().as_str();
        let source = found.value_source(id)?;
        let is_flag = matches!(argument.get_action(), ArgAction::SetTrue);
        if is_flag && source == ValueSource::DefaultValue {
            return None;
        }
        let values = found.get_raw(id)?;
        Some(Setting {
            name: id.to_owned(),
            values: values
                .map(|value| value.to_string_lossy().into_owned())
                .collect(),
            given: source == ValueSource::CommandLine,
        })
    };
    let own = command.get_arguments().filter(own);
    own.filter_map(setting).collect()
}

impl Called {
    /// What `words` say, of which `root` made `matches`; at the date that is stated, else that of the clock.
    pub(super) fn of(
        words: &[OsString],
        root: &Command,
        matches: &ArgMatches,
        date: Option<String>,
    ) -> Self {
        let words = words.iter().skip(1);
        Self {
            command: words
                .map(|word| word.to_string_lossy().into_owned())
                .collect(),
            date: date.unwrap_or_else(|| rfc3339(SystemTime::now())),
            folder: std::env::current_dir().unwrap_or_default(),
            settings: settings(root, matches),
        }
    }

    /// How the results that are written as `written` were made.
    fn invocation(&self, results: &str, written: &Written<'_>) -> Invocation {
        let is_own = |path: &Path| Some(path) != written.read && path.starts_with(written.folder);
        let below = written.file.strip_prefix(written.folder).ok();
        Invocation {
            command: self.command.clone(),
            program: format!("{NAME} {}", env!("CARGO_PKG_VERSION")),
            date: self.date.clone(),
            folder: self.folder.display().to_string(),
            settings: self.settings.clone(),
            inputs: inputs(is_own),
            output: Some(Output {
                setting: "out".into(),
                below: below.map(|below| below.display().to_string()),
            }),
            results_sha256: sha256(results.as_bytes()),
        }
    }

    /// The document of `content`, which is written as `written`, as readable JSON with how it was made.
    pub(super) fn document(
        &self,
        content: &impl Content,
        written: &Written<'_>,
    ) -> Outcome<String> {
        let mut value = document_value(content)?;
        let invocation = self.invocation(&value.to_string(), written);
        if let Some(fields) = value.as_object_mut() {
            fields.insert(INVOCATION.to_owned(), serde_json::to_value(invocation)?);
        }
        Ok(serde_json::to_string_pretty(&value)?)
    }

    /// Writes the report `html` as `written`, with how it was made.
    pub(super) fn write_report(&self, html: &str, written: &Written<'_>) -> Outcome {
        let invocation = self.invocation(html, written);
        let again = "The same command gives the same values.";
        let text = with_invocation(html, &invocation, again)?;
        write_text(written.file, &text)
    }
}
