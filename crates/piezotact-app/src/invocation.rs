//! How this command was called, for every document and every report that it writes.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::{Arc, OnceLock};
use std::time::SystemTime;

use piezotact::document::INVOCATION;
use piezotact::invocation::{Invocation, Output, Setting};
use piezotact::recording::StartTime;
use piezotact_dataset::reads::{inputs, sha256};
use piezotact_dataset::{keep_before, stays_as_it_is};
use piezotact_report::invocation::{command_line, with_invocation};
use serde_json::Value;

use crate::arguments::{Arguments, OutputPath, output_of};
use crate::calls;
use crate::failure::Outcome;
use crate::output::{say, write_text};
use crate::parts::Parts;
use crate::replacing::{Existing, Writing};
use crate::report::name;

/// The command that this program was called with; one that is called as a function is its thread's ([`calls`]).
static CALLED: OnceLock<Arc<Called>> = OnceLock::new();
/// What starts this program; empty: the file of this process.
static STARTED_BY: OnceLock<Vec<OsString>> = OnceLock::new();

/// How a command was called.
pub(crate) struct Called {
    command: Vec<String>,
    date: String,
    /// Whether the date was stated.
    dated: bool,
    settings: Vec<Setting>,
    writing: Writing,
    parts: Parts,
    /// The files that arguments name: inputs, wherever they stand.
    named: Vec<PathBuf>,
}

/// Keeps how the program was called: `words` behind its name, the date that is stated, else that of the clock, and what becomes of
/// existing files. Outputs that cannot be are refused.
pub(crate) fn begin(
    words: &[OsString],
    arguments: &Arguments<'_>,
    date: Option<&str>,
    existing: Existing,
) -> Outcome {
    let words = words.iter().skip(1);
    let folder = std::env::current_dir().unwrap_or_default();
    let called = Called {
        command: words
            .map(|word| word.to_string_lossy().into_owned())
            .collect(),
        date: date.map_or_else(|| rfc3339(SystemTime::now()), str::to_owned),
        dated: date.is_some(),
        settings: arguments.settings(),
        writing: Writing {
            command: arguments.names.join(" "),
            folder,
            outputs: arguments.outputs(),
            existing,
        },
        parts: Parts::of(arguments),
        named: arguments.named_inputs(),
    };
    called.writing.check()?;
    let mut called = Some(Arc::new(called));
    calls::with(|call| call.called = called.take());
    // A program is called once.
    let _kept = called.map(|called| CALLED.set(called));
    Ok(())
}

/// The command that runs on this thread; `None` in a test that calls no command.
fn called() -> Option<Arc<Called>> {
    calls::with(|call| call.called.clone()).unwrap_or_else(|| CALLED.get().cloned())
}

/// Keeps what starts this program; empty: the file of this process.
pub(crate) fn started_by(words: Vec<OsString>) {
    // A program is started once.
    let _kept = STARTED_BY.set(words);
}

/// What starts this program again.
///
/// # Errors
/// Where the system does not say which file it is.
pub(crate) fn this_program() -> std::io::Result<Command> {
    match STARTED_BY.get().map(Vec::as_slice) {
        Some([first, others @ ..]) => {
            let mut command = Command::new(first);
            command.args(others);
            Ok(command)
        }
        _ => std::env::current_exe().map(Command::new),
    }
}

/// The words behind the name of the program that this command was called with.
#[cfg(feature = "study")]
pub(crate) fn words() -> Vec<String> {
    called().map_or_else(Vec::new, |called| called.command.clone())
}

/// Refuses a file at `path` that this command did not write before and does not keep.
pub(crate) fn refuse_existing(path: &Path) -> Outcome {
    called().map_or(Ok(()), |called| called.writing.refuse_existing(path))
}

fn rfc3339(time: SystemTime) -> String {
    humantime::format_rfc3339_seconds(time).to_string()
}

/// When something begins that is recorded now: the date that is stated, else that of the clock, in UTC.
pub(crate) fn now() -> Option<StartTime> {
    let stated = called().filter(|called| called.dated);
    let text = stated.map_or_else(
        || humantime::format_rfc3339_millis(SystemTime::now()).to_string(),
        |called| called.date.clone(),
    );
    StartTime::try_from(text).ok()
}

/// A date as it was stated, as RFC 3339 in UTC.
pub(crate) fn date(text: &str) -> Result<String, String> {
    let read = humantime::parse_rfc3339_weak(text)
        .or_else(|_no_time| humantime::parse_rfc3339_weak(&format!("{text} 00:00:00")));
    read.map(rfc3339).map_err(|_no_date| {
        "expected a date in UTC such as 2026-03-01 or 2026-03-01T10:22:33Z; leave it out for now".into()
    })
}

/// The date on which this command was called, in UTC: `2026-03-01`.
#[cfg(feature = "audio")]
pub(crate) fn today() -> String {
    let date = called().map_or_else(|| rfc3339(SystemTime::now()), |called| called.date.clone());
    date.chars().take(10).collect()
}

/// The same in days since 1970-01-01.
#[cfg(feature = "audio")]
pub(crate) fn day() -> i64 {
    let begins = humantime::parse_rfc3339_weak(&format!("{} 00:00:00", today()));
    let since = begins
        .ok()
        .and_then(|begins| begins.duration_since(SystemTime::UNIX_EPOCH).ok());
    since.map_or(0, |since| (since.as_secs() / 86_400) as i64)
}

/// The program with its version.
pub(crate) const PROGRAM: &str = concat!("piezotact ", env!("CARGO_PKG_VERSION"));

/// How the results that are written to `path`, or printed, were made; `None` in a test that calls no command, and where data are
/// given that are in no file.
fn of_results(results: &str, path: Option<&Path>) -> Option<Invocation> {
    let called = called().filter(|_| !calls::has_data())?;
    let output = path.and_then(|path| output_of(&called.writing.outputs, path));
    Some(Invocation {
        command: called.command.clone(),
        program: PROGRAM.to_owned(),
        date: called.date.clone(),
        folder: called.writing.folder.display().to_string(),
        settings: called.settings.clone(),
        inputs: inputs(|path| called.is_own(path)),
        output: output.map(|(output, below)| Output {
            setting: output.setting.clone(),
            below: Some(below.display().to_string()).filter(|below| !below.is_empty()),
        }),
        results_sha256: sha256(results.as_bytes()),
    })
}

impl Called {
    /// The figures and tables that an earlier run of this command wrote with the report at `report`, as far as they stand there unchanged.
    fn earlier_parts(&self, report: &Path) -> Outcome<Vec<PathBuf>> {
        let Ok(html) = std::fs::read_to_string(report) else {
            return Ok(Vec::new());
        };
        let mut earlier = self.parts.unchanged_of(&html)?;
        earlier.retain(|part| self.writing.wrote_part(report, part));
        Ok(earlier)
    }

    /// Whether a file that is read is one that this command writes: what it has begun, or the runs behind it.
    fn is_own(&self, path: &Path) -> bool {
        let with = |output: &Path, ending: &str| {
            let mut name = output.as_os_str().to_owned();
            name.push(ending);
            PathBuf::from(name)
        };
        let outputs = self.writing.outputs.iter();
        let mut places = outputs.flat_map(|output| {
            ["", ".json", ".part", ".runs"].map(|ending| with(&output.path, ending))
        });
        // What stood at an output before is kept beside it (`crate::keeping`), and is no input either.
        let is_kept = |output: &OutputPath| {
            let before = with(&output.path, ".before-");
            path.to_string_lossy()
                .starts_with(&*before.to_string_lossy())
        };
        !self.named.iter().any(|named| named == path)
            && (places.any(|place| path.starts_with(place))
                || self.writing.outputs.iter().any(is_kept))
    }
}

/// The results in a document, as they are summed: all of it but how it was made.
pub(crate) fn results_of(document: &Value) -> String {
    match document.as_object() {
        Some(fields) if fields.contains_key(INVOCATION) => {
            let mut fields = fields.clone();
            fields.remove(INVOCATION);
            Value::Object(fields).to_string()
        }
        _ => document.to_string(),
    }
}

/// Adds to `document`, which is written to `path` or printed, how it was made.
pub(crate) fn add_to(document: &mut Value, path: Option<&Path>) -> Outcome {
    let invocation = of_results(&results_of(document), path);
    if let (Some(invocation), Some(fields)) = (invocation, document.as_object_mut()) {
        fields.insert(INVOCATION.to_owned(), serde_json::to_value(invocation)?);
    }
    Ok(())
}

/// Writes a report to `path`, with how it was made; and its figures and tables, where they are asked for.
pub(crate) fn write_report(path: &Path, html: &str) -> Outcome {
    let Some(called) = called() else {
        return write_text(path, html);
    };
    let parts = called.parts.of_report(html)?;
    let is_part = |file: &Path| parts.iter().any(|(part, _)| part == file);
    called.writing.refuse_others(&is_part)?;
    // Before the new report says that they are of this command.
    parts
        .iter()
        .try_for_each(|(part, _)| called.writing.refuse_existing(part))?;
    let earlier = called.earlier_parts(path)?;
    // A report says where its parts are, not that nobody changed them since.
    let changed = parts.iter().filter(|(part, bytes)| {
        let is_kept = called.writing.replaces_everything() || stays_as_it_is(part);
        part.is_file()
            && !is_kept
            && !earlier.contains(part)
            && std::fs::read(part).is_ok_and(|found| found != *bytes)
    });
    for (part, _) in changed {
        if let Some(kept) = keep_before(part)? {
            let (part, kept) = (part.display(), kept.display());
            say(&format!(
                "{part}: what stood there is not of the earlier report, and is kept as {kept}"
            ));
        }
    }
    match of_results(html, Some(path)) {
        None => write_text(path, html)?,
        Some(invocation) => {
            let rerun = command_line(&["rerun".to_owned(), name(path)]);
            let again = format!("{rerun} does it again and compares every value.");
            write_text(path, &with_invocation(html, &invocation, &again)?)?;
        }
    }
    // Behind the report, which says whose they are where the command is killed in between.
    called.parts.write(&parts)?;
    // Those of an earlier run would be taken for those of this report.
    for stale in earlier.iter().filter(|file| !is_part(file)) {
        std::fs::remove_file(stale)?;
    }
    Ok(())
}
