//! Commands as functions of another language: the same words, the same values. Nothing is printed; what a command would print comes
//! back, and recordings may be given instead of files.

mod described;

use std::collections::BTreeMap;
use std::error::Error as _;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::error::{ContextKind, ContextValue};
use piezotact::Warning;
use piezotact::figure::Figure;
use piezotact::integrity::warnings_of;
use piezotact::page::{Block, Page};
use piezotact::quantity::SampleRate;
use piezotact::recording::Condition;
use piezotact::warning::{Merged, merged};
use piezotact_dataset::reads::apart;
use piezotact_dataset::{ArrayChannel, Contents, read_transfer, recording_of_arrays};
use serde_json::Value;

pub use described::{Argument, ArgumentKind, CommandDescription, commands};

use crate::advice::{OptionWords, merged_text};
use crate::calls::{self, Call};
use crate::cli::Reading;
use crate::failure::{Failure, Outcome, sentence, usage};
use crate::interrupt;
use crate::reading;

/// What a command gave.
#[derive(Debug)]
pub struct Called {
    /// The document that `--json` prints; absent where the command has none.
    pub document: Option<Value>,
    /// The report; absent where the command has none.
    pub page: Option<Page>,
    /// The warnings that the command says, each with its sentence.
    pub warnings: Vec<Said>,
    /// What the command prints beside, line by line.
    pub printed: Vec<String>,
    /// What the command says on standard error beside, line by line.
    pub said: Vec<String>,
    /// How it ended.
    pub ended: Result<Ended, CallError>,
}

/// How a command ended that gave a result.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ended {
    /// A result, or a verification that passed.
    Done,
    /// A verification that did not pass.
    NotPassed,
    /// A verification that passed over part of its target.
    PassedInPart,
    /// A verification that could not be decided.
    NotDecided,
}

/// A warning as a command says it.
#[derive(Clone, Debug)]
pub struct Said {
    /// Its code: `few`.
    pub code: String,
    /// Its sentence, with what it is about and the options with which its advice is followed.
    pub text: String,
}

/// Why a command gave no result.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CallError {
    pub kind: ErrorKind,
    /// What was expected, what was found and what to do: the sentence that the command says.
    pub sentence: String,
    /// The value that it refuses, where the parser of the command line does.
    pub refused: Option<RefusedValue>,
}

/// A value that the parser of the command line refuses.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RefusedValue {
    /// The option without its dashes, or of an argument without one what its value is called: [`Argument::option`] and [`Argument::value`].
    pub argument: String,
    pub value: String,
    /// What its type says of it; absent where it is none of a few choices.
    pub why: Option<String>,
}

/// What is at fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ErrorKind {
    /// The command was asked for something that cannot be: exit code 2 of the program.
    Usage,
    /// The data, a file or a device is not what it must be: exit code 1 of the program.
    Data,
}

/// Does what `words` ask for (the first is the name of the program), on this thread. A word that names a recording in `given` stands
/// for that recording.
#[must_use]
pub fn call(words: &[OsString], given: BTreeMap<PathBuf, Arc<Contents>>) -> Called {
    let call = Call {
        given,
        ..Call::default()
    };
    let (outcome, left) = apart(|| calls::within(call, || crate::commands::run(words)));
    Called {
        warnings: left.page.as_ref().map(said_of).unwrap_or_default(),
        document: left.document,
        page: left.page,
        printed: left.printed,
        said: left.said,
        ended: ended(outcome),
    }
}

/// The recording in the file at `path`, as commands read it. `scale` is that of the option `--scale`, each time it is given, `rate_hz` that of
/// `--rate`, and `part` that of `--part`.
///
/// # Errors
/// What a command says of the file or of the options.
pub fn read(
    path: &Path,
    scale: &[String],
    rate_hz: Option<f64>,
    part: Option<usize>,
) -> Result<Contents, CallError> {
    let scale = scale.iter().map(|scale| scale.parse().map_err(usage));
    let contents = scale.collect::<Outcome<_>>().and_then(|scale| {
        let reading = Reading {
            scale,
            rate: rate_hz,
            part,
        };
        apart(|| reading::read_uninspected(path, &reading))
    });
    contents.map_err(error)
}

/// What a person should know of the recording in `contents` before relying on it: what its file says, and what is found in its samples.
#[must_use]
pub fn warnings(contents: &Contents) -> Vec<Warning> {
    let mut about = contents.recording.about.clone();
    let limit = reading::drive_limit(contents.setup.as_ref());
    about.add_warnings(warnings_of(&contents.recording, limit));
    about.warnings
}

/// The transfer function in the file at `path`, of any format that is read, as the JSON that is written of it.
///
/// # Errors
/// What a command says of the file.
pub fn transfer_function(path: &Path) -> Result<String, CallError> {
    let found = apart(|| read_transfer(path));
    let found = found.map_err(|wrong| error(Failure::Data(wrong.into())))?;
    serde_json::to_string(&found).map_err(|wrong| error(Failure::Data(wrong.into())))
}

/// The recording of arrays, as commands have it of a file. The samples of each of the `channels` are in its unit; `name` is what messages
/// and documents call it.
///
/// # Errors
/// What a command says of a rate or of samples that cannot be.
pub fn recording_of(
    name: &Path,
    channels: Vec<ArrayChannel>,
    rate_hz: f64,
    condition: Condition,
) -> Result<Contents, CallError> {
    let rate = SampleRate::new(rate_hz).map_err(|wrong| error(usage(wrong)))?;
    let contents = recording_of_arrays(name, channels, rate, condition);
    contents.map_err(|wrong| error(Failure::Data(wrong.into())))
}

/// The report `page` as one HTML file.
///
/// # Errors
/// Where it cannot be drawn.
pub fn html(page: &Page) -> Result<String, CallError> {
    let drawn = piezotact_report::report::html(page, &OptionWords);
    drawn.map_err(|drawing| error(Failure::Data(drawing.into())))
}

/// The report `page` as text: its conclusions, its numbers and its first table.
///
/// # Errors
/// Where it cannot be shown.
pub fn text(page: &Page) -> Result<String, CallError> {
    let drawn = piezotact_report::report::terminal(page);
    drawn.map_err(|drawing| error(Failure::Data(drawing.into())))
}

/// The table of the report `page` as CSV, which the option `--csv` writes; `None` where it has none.
///
/// # Errors
/// Where it cannot be written.
pub fn csv(page: &Page) -> Result<Option<String>, CallError> {
    let table = page.csv_table().map(piezotact_report::report::csv);
    table
        .transpose()
        .map_err(|drawing| error(Failure::Data(drawing.into())))
}

/// The figures of the report `page`, in its order, those that are folded too.
#[must_use]
pub fn figures(page: &Page) -> Vec<&Figure> {
    fn within<'p>(blocks: &'p [Block], found: &mut Vec<&'p Figure>) {
        for block in blocks {
            match block {
                Block::Figure(figure) => found.push(figure),
                Block::Beside { blocks } | Block::Folded { blocks, .. } => within(blocks, found),
                _ => {}
            }
        }
    }
    let mut found = Vec::new();
    for section in &page.sections {
        within(&section.blocks, &mut found);
    }
    found
}

/// `warnings` as commands say them, those of one kind once.
#[must_use]
pub fn said(warnings: &[Warning]) -> Vec<Said> {
    merged(warnings)
        .iter()
        .map(|one| said_one("", one))
        .collect()
}

/// Stops the run on a bench that is played or acquired now, if there is one: it ends in order, and what was acquired is kept.
pub fn stop() {
    interrupt::stop_run();
}

fn said_of(page: &Page) -> Vec<Said> {
    let warnings = page.merged_warnings();
    warnings.map(|(about, one)| said_one(about, one)).collect()
}

fn said_one(about: &str, warning: &Merged) -> Said {
    let text = merged_text(warning);
    Said {
        code: warning.warning.code.clone(),
        text: match about {
            "" => text,
            about => format!("{about}: {text}"),
        },
    }
}

fn ended(outcome: Outcome) -> Result<Ended, CallError> {
    match outcome {
        Ok(()) | Err(Failure::ReaderGone) => Ok(Ended::Done),
        Err(Failure::NotPassed) => Ok(Ended::NotPassed),
        Err(Failure::PassedInPart) => Ok(Ended::PassedInPart),
        Err(Failure::NotDecided) => Ok(Ended::NotDecided),
        Err(failure) => Err(error(failure)),
    }
}

fn error(failure: Failure) -> CallError {
    let mut refused = None;
    let (kind, sentence) = match failure {
        Failure::Usage(error) => (ErrorKind::Usage, sentence(&error)),
        Failure::Words(error) => {
            refused = refused_by(&error);
            (ErrorKind::Usage, first_sentence(&error))
        }
        Failure::Data(error) => (ErrorKind::Data, sentence(&error)),
        // Verdicts are results.
        Failure::NotPassed | Failure::PassedInPart | Failure::NotDecided | Failure::ReaderGone => {
            (ErrorKind::Data, String::new())
        }
    };
    CallError {
        kind,
        sentence,
        refused,
    }
}

/// What the parser says of the words, without how they are written.
fn first_sentence(error: &clap::Error) -> String {
    let text = error.render().to_string();
    let first = text.split("\n\n").next().unwrap_or_default();
    let words = first.trim_start_matches("error: ").split_whitespace();
    words.collect::<Vec<_>>().join(" ")
}

fn refused_by(error: &clap::Error) -> Option<RefusedValue> {
    let text = |kind| match error.get(kind) {
        Some(ContextValue::String(text)) => Some(text.as_str()),
        _ => None,
    };
    // `--segment <SAMPLES>`, `<FILE>` or `[FILES]...`.
    let argument = text(ContextKind::InvalidArg)?.trim_start_matches(['-', '<', '[']);
    Some(RefusedValue {
        argument: argument.split([' ', '=', '>', ']', '[']).next()?.to_owned(),
        value: text(ContextKind::InvalidValue)?.to_owned(),
        why: error.source().map(ToString::to_string),
    })
}
