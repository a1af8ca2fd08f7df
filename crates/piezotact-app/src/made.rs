//! What a report or a document of this program says of itself: its results, and how it was made.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use piezotact::document::INVOCATION;
use piezotact::invocation::{Found, Input, Invocation};
use piezotact_dataset::reads::{found, sha256};
use piezotact_report::invocation::{is_as_written, split};
use serde_json::Value;

use crate::failure::{Failure, Outcome};
use crate::invocation::{PROGRAM, results_of};

/// What was made, without how.
pub(crate) enum Results {
    /// A report.
    Report(String),
    /// A document.
    Document(Value),
}

/// A report or a document with how it was made.
pub(crate) struct Made {
    pub(crate) results: Results,
    pub(crate) invocation: Invocation,
    /// Whether its results are those that were written.
    pub(crate) untouched: bool,
    /// Whether a person reads in it what is stored for a program; of a program of another version nothing is known.
    pub(crate) shows_its_invocation: bool,
}

impl Made {
    /// What the file at `path` holds.
    pub(crate) fn read(path: &Path) -> Outcome<Self> {
        let text = piezotact_dataset::read_input_text(path)?;
        let made = Self::of(&text);
        made.ok_or_else(|| {
            Failure::Data(anyhow!(
                "{}: expected a report or a document that says how it was made, found none; give a report, or \
                 what a command printed with --json: sidecars, transfer functions and tables say nothing of the command",
                path.display()
            ))
        })
    }

    /// What `text` holds; `None` where it does not say how it was made.
    pub(crate) fn of(text: &str) -> Option<Self> {
        if let Some((results, invocation)) = split(text) {
            return Some(Self {
                untouched: sha256(results.as_bytes()) == invocation.results_sha256,
                shows_its_invocation: invocation.program != PROGRAM
                    || is_as_written(text, &invocation),
                results: Results::Report(results),
                invocation,
            });
        }
        let mut document: Value = serde_json::from_str(text).ok()?;
        let invocation = document.as_object_mut()?.remove(INVOCATION)?;
        let invocation: Invocation = serde_json::from_value(invocation).ok()?;
        Some(Self {
            untouched: sha256(results_of(&document).as_bytes()) == invocation.results_sha256,
            shows_its_invocation: true,
            results: Results::Document(document),
            invocation,
        })
    }

    /// The folder in which relative paths begin: that of the run, or that of `file` where more inputs are found there as they were.
    pub(crate) fn folder(&self, file: &Path) -> Outcome<PathBuf> {
        let beside = std::path::absolute(file)?;
        let beside = beside.parent().unwrap_or(Path::new("/")).to_owned();
        let first = PathBuf::from(&self.invocation.folder);
        if !first.is_absolute() || !first.is_dir() {
            return Ok(beside);
        }
        let as_they_were = |folder: &Path| {
            let inputs = self.invocation.inputs.iter();
            inputs
                .filter(|input| found(&folder.join(&input.path)) == input.found)
                .count()
        };
        let moved = as_they_were(&beside) > as_they_were(&first);
        Ok(if moved { beside } else { first })
    }

    /// What is no longer as it was when it was made, one sentence each.
    pub(crate) fn changed(&self, folder: &Path) -> Vec<String> {
        let inputs = self.invocation.inputs.iter();
        let mut changed: Vec<String> = inputs
            .filter_map(|input| change_of(input, folder))
            .collect();
        if !self.untouched {
            changed.push("the file itself was changed after it was written".into());
        }
        if self.invocation.program != PROGRAM {
            changed.push(format!(
                "it was made by {}, and is run again by {PROGRAM}",
                self.invocation.program
            ));
        }
        changed
    }
}

/// What became of an input.
fn change_of(input: &Input, folder: &Path) -> Option<String> {
    let now = found(&folder.join(&input.path));
    if now == input.found {
        return None;
    }
    let path = &input.path;
    Some(match (&input.found, &now) {
        (Found::Nothing, _) => format!("{path}: is read now, and was not there"),
        (_, Found::Nothing) => format!("{path}: is missing"),
        (Found::Changed, _) => {
            format!("{path}: changed while it was read, so that nothing is known of it")
        }
        _ => format!("{path}: is another file now (its SHA-256 differs)"),
    })
}
