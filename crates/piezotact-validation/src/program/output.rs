//! What the program prints: results on standard output, what is being done on standard error; and what it writes, whole or not at all.

use std::io::Write as _;
use std::path::Path;

use piezotact::document::{Content, Document};
use piezotact_dataset::{WriteError, write_atomically};

use super::failure::{Failure, Outcome};

/// `text` without control characters, except line ends and tabs, nor signs that turn the direction of writing: what a file holds acts on
/// no terminal.
fn harmless(text: &str) -> String {
    let acts = |sign: char| {
        (sign.is_control() && !['\n', '\t'].contains(&sign))
            || ('\u{202a}'..='\u{202e}').contains(&sign)
            || ('\u{2066}'..='\u{2069}').contains(&sign)
    };
    let shown = |sign: char| match acts(sign) {
        true => format!("\\u{:04x}", u32::from(sign)),
        false => sign.to_string(),
    };
    text.chars().map(shown).collect()
}

/// Prints `text` and a line end on standard output.
pub(super) fn print(text: &str) -> Outcome {
    let write = || {
        let mut out = std::io::stdout().lock();
        out.write_all(harmless(text).as_bytes())
            .and_then(|()| out.write_all(b"\n"))
            .and_then(|()| out.flush())
    };
    match write() {
        Err(error) if error.kind() == std::io::ErrorKind::BrokenPipe => Err(Failure::ReaderGone),
        other => Ok(other?),
    }
}

/// Says on standard error what is being done. When nobody can hear it the work still goes on.
pub(super) fn say(text: &str) {
    let _nobody_hears = writeln!(std::io::stderr().lock(), "{}", harmless(text));
}

/// The document of `content`.
pub(super) fn document_value(content: &impl Content) -> Outcome<serde_json::Value> {
    Ok(serde_json::to_value(Document::of(content))?)
}

/// The document of `content` as readable JSON without how it was made: the state of a command that continues.
pub(super) fn state_text(content: &impl Content) -> Outcome<String> {
    Ok(serde_json::to_string_pretty(&document_value(content)?)?)
}

/// Writes `text` to `path`, whole or not at all.
pub(super) fn write_text(path: &Path, text: &str) -> Outcome {
    write_atomically(path, |out| {
        out.write_all(text.as_bytes())
            .map_err(|source| WriteError::Io {
                path: path.into(),
                source,
            })
    })?;
    Ok(())
}

/// A file's name without its folder.
pub(super) fn name(path: &Path) -> String {
    path.file_name().map_or_else(
        || path.display().to_string(),
        |name| name.to_string_lossy().into_owned(),
    )
}
