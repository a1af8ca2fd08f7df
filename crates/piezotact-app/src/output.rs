//! What a command prints: results on standard output, warnings on standard error.

use std::fmt::Write as _;
use std::io::{IsTerminal, Write};
use std::path::Path;

use piezotact::Warning;
use piezotact::document::{Content, Document, Kept};
pub(crate) use piezotact::number::{counted, difference_db, digits};
use piezotact::warning::{Merged, merged};
use piezotact_dataset::{WriteError, write_atomically};
use serde_json::Value;

use crate::advice::merged_text;
use crate::calls;
use crate::failure::{Failure, Outcome};
use crate::invocation;
use crate::progress::aside;
use crate::shown::{harmless, shortened};

/// A message as it is shown.
pub(crate) fn message(text: &str) -> String {
    harmless(&shortened(text)).into_owned()
}

/// Prints `text` and a line end on standard output, without control characters.
pub(crate) fn print(text: &str) -> Outcome {
    if calls::with(|call| call.printed.push(text.to_owned())).is_some() {
        return Ok(());
    }
    let write = || {
        let mut out = std::io::stdout().lock();
        out.write_all(harmless(text).as_bytes())
            .and_then(|()| out.write_all(b"\n"))
            .and_then(|()| out.flush())
    };
    let written = if std::io::stdout().is_terminal() {
        aside(write)
    } else {
        write()
    };
    match written {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Err(Failure::ReaderGone),
        other => Ok(other?),
    }
}

/// Prints the document of `content` as readable JSON.
pub(crate) fn print_document(content: &impl Content) -> Outcome {
    print_made(serde_json::to_value(Document::of(content))?)
}

/// Prints the document of `value`, which the file `out` holds, as readable JSON.
pub(crate) fn print_kept(out: &Path, value: &impl Content) -> Outcome {
    print_document(&Kept { out, value })
}

/// Prints a document as readable JSON with how it was made.
pub(crate) fn print_made(mut document: Value) -> Outcome {
    invocation::add_to(&mut document, None)?;
    match calls::keep_document(document) {
        Some(document) => print(&serde_json::to_string_pretty(&document)?),
        None => Ok(()),
    }
}

/// The document of `content`, which is written to `path` or printed, as readable JSON with how it was made.
pub(crate) fn document_text(content: &impl Content, path: Option<&Path>) -> Outcome<String> {
    let mut value = serde_json::to_value(Document::of(content))?;
    invocation::add_to(&mut value, path)?;
    Ok(serde_json::to_string_pretty(&value)?)
}

/// Writes `text` to `path`, whole or not at all.
pub(crate) fn write_text(path: &Path, text: &str) -> Outcome {
    write_bytes(path, text.as_bytes())
}

/// Writes `bytes` to `path`, whole or not at all.
pub(crate) fn write_bytes(path: &Path, bytes: &[u8]) -> Outcome {
    write_atomically(path, |out| {
        out.write_all(bytes).map_err(|source| WriteError::Io {
            path: path.into(),
            source,
        })
    })?;
    Ok(())
}

/// Says on standard error what is being done, without control characters and shortened. When nobody can hear it the work still goes on.
pub(crate) fn say(text: &str) {
    if calls::with(|call| call.said.push(message(text))).is_some() {
        return;
    }
    let _nobody_hears = aside(|| writeln!(std::io::stderr().lock(), "{}", message(text)));
}

/// Says every warning on standard error, those of one kind once.
pub(crate) fn say_warnings(warnings: &[Warning]) {
    say_merged(&merged(warnings));
}

/// As [`say_warnings`], of warnings that are merged.
pub(crate) fn say_merged(warnings: &[Merged]) {
    let mut text = String::new();
    for warning in warnings {
        let _never_fails = write!(
            text,
            "{}warning: {}",
            if text.is_empty() { "" } else { "\n" },
            merged_text(warning)
        );
    }
    if !text.is_empty() {
        say(&text);
    }
}
