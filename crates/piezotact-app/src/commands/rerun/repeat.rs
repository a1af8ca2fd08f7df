//! Running a command again, with its outputs in a temporary folder.
//!
//! The command comes from a file that anybody may have edited. What is executed is this program alone: its words are parsed as
//! those of a person are, every output is replaced by one in the temporary folder, and the rest is given as values of options.

use std::ffi::OsString;
use std::fs::File;
use std::path::{Component, Path, PathBuf};
use std::process::Stdio;
use std::time::Duration;

use anyhow::{Context as _, anyhow};
use piezotact::document::INVOCATION;
use piezotact::invocation::{Found, Invocation, Output};
use serde_json::Value;
use tempfile::TempDir;

use crate::arguments::{Arguments, OutputPath};
use crate::commands::refusal;
use crate::failure::{Failure, Outcome};
use crate::interrupt::{self, Between, interrupted};
use crate::invocation::this_program;
use crate::made::{Made, Results};
use crate::progress::Work;

/// Commands that cannot be run again, with the reason.
const NOT_AGAIN: [(&str, &str); 2] = [
    ("panel add", "it changes the folder of a panel"),
    ("rerun", "it runs another command again"),
];
/// The exit codes of a command that has results: done, and the verdicts of a verification.
const WITH_RESULTS: [i32; 4] = [0, 3, 4, 5];

/// How often it is looked whether the command has ended.
const LOOK: Duration = Duration::from_millis(20);

/// A command that is ready to be run again.
pub(super) struct Repeated {
    words: Vec<OsString>,
    /// Where relative paths begin.
    folder: PathBuf,
    temporary: TempDir,
    /// Each output with its place in the temporary folder.
    led: Vec<(OutputPath, PathBuf)>,
}

impl Repeated {
    /// The command of `made`, in `folder`.
    pub(super) fn of(made: &Made, folder: &Path) -> Outcome<Self> {
        let mut root = crate::commands::command();
        let words = std::iter::once("piezotact");
        let words = words.chain(made.invocation.command.iter().map(String::as_str));
        let matches = root.try_get_matches_from_mut(words).map_err(|error| {
            let words = made.invocation.command.iter().map(String::as_str);
            let renamed = refusal::renamed(&error, &root, words);
            let text = error.to_string();
            let first = renamed.unwrap_or_else(|| text.lines().next().unwrap_or_default().into());
            anyhow!("the command that it states cannot be run: {first}")
        })?;
        let arguments = Arguments::of(&root, &matches);
        let name = arguments.names.join(" ");
        if let Some((_, why)) = NOT_AGAIN.iter().find(|(command, _)| *command == name) {
            return Err(anyhow!("`piezotact {name}` cannot be run again: {why}").into());
        }
        refuse_missing(made, folder)?;
        let temporary = tempfile::Builder::new()
            .prefix("piezotact-rerun-")
            .tempdir()?;
        let mut led = Vec::new();
        let mut words = arguments.again(&mut |output| {
            let number = led.len().to_string();
            let name = output.path.file_name().unwrap_or("out".as_ref());
            let place = temporary.path().join(number).join(name);
            led.push((output.clone(), place.clone()));
            place
        });
        let at = arguments.names.len();
        words.insert(
            at,
            OsString::from(format!("--date={}", made.invocation.date)),
        );
        Ok(Self {
            words,
            folder: folder.to_owned(),
            temporary,
            led,
        })
    }

    /// Runs the command; the results that correspond to those of `made`, and how they were made.
    pub(super) fn run(&self, made: &Made) -> Outcome<(Results, Invocation)> {
        for (_, place) in &self.led {
            std::fs::create_dir_all(place.parent().unwrap_or(self.temporary.path()))?;
        }
        let [out, err] = ["stdout", "stderr"].map(|name| self.temporary.path().join(name));
        let code = self.ended([&out, &err])?;
        if !WITH_RESULTS.contains(&code) {
            let said = String::from_utf8_lossy(&std::fs::read(&err)?).into_owned();
            let last = said
                .lines()
                .rfind(|line| !line.is_empty())
                .unwrap_or("it said nothing");
            let last = last.trim_start_matches("piezotact: ");
            return Err(anyhow!("the command could not be run again: {last}").into());
        }
        let text = match &made.invocation.output {
            None => std::fs::read_to_string(&out)?,
            Some(output) => {
                let place = self.place_of(output)?;
                let text = std::fs::read_to_string(&place);
                text.with_context(|| format!("the command did not write {}", place.display()))?
            }
        };
        self.as_before(made, &text)
    }

    /// Runs the command with what it prints in files; its exit code. Where a signal comes, the command is stopped too.
    fn ended(&self, [out, err]: [&Path; 2]) -> Outcome<i32> {
        let mut program = this_program().context("this program does not know where it is")?;
        let _between = Between::moments();
        let _shown = Work::one("running again");
        let mut running = program
            .args(&self.words)
            .current_dir(&self.folder)
            .stdin(Stdio::null())
            .stdout(File::create(out)?)
            .stderr(File::create(err)?)
            .spawn()
            .context("this program could not be started again")?;
        loop {
            if let Some(status) = running.try_wait()? {
                if interrupted() {
                    break;
                }
                return Ok(status.code().unwrap_or(-1));
            }
            if interrupted() {
                // All that it writes stands in the temporary folder, which is removed.
                running.kill()?;
                running.wait()?;
                break;
            }
            std::thread::sleep(LOOK);
        }
        Err(interrupt::failure(
            "nothing was compared, and what the command wrote was removed",
            "give the same command again",
        ))
    }

    /// Where an output stands in the temporary folder.
    fn place_of(&self, output: &Output) -> Outcome<PathBuf> {
        let led = self
            .led
            .iter()
            .find(|(led, _)| led.setting == output.setting);
        let below = Path::new(output.below.as_deref().unwrap_or_default());
        let plain = below
            .components()
            .all(|part| matches!(part, Component::Normal(_)));
        match led.filter(|_| plain) {
            // A path that ends in nothing is one of a folder.
            Some((_, place)) if below.as_os_str().is_empty() => Ok(place.clone()),
            Some((_, place)) => Ok(place.join(below)),
            None => Err(anyhow!(
                "expected an output of the command, found {} {}; the file was changed by hand",
                output.setting,
                below.display()
            )
            .into()),
        }
    }

    /// The results in `text` with the paths of outputs as they were.
    fn as_before(&self, made: &Made, text: &str) -> Outcome<(Results, Invocation)> {
        let again = Made::of(text).ok_or_else(|| {
            Failure::Data(anyhow!(
                "the command gave nothing that can be compared; run it by hand"
            ))
        })?;
        let results = match (again.results, &made.results) {
            (Results::Report(html), Results::Report(_)) => {
                Results::Report(self.renamed(&html, &|path| escaped(&path.display().to_string())))
            }
            (Results::Document(mut document), Results::Document(_)) => {
                document
                    .as_object_mut()
                    .map(|fields| fields.remove(INVOCATION));
                self.rename_in(&mut document);
                Results::Document(document)
            }
            _ => {
                return Err(
                    anyhow!("expected a report or a document as before, found the other").into(),
                );
            }
        };
        Ok((results, again.invocation))
    }

    /// `text` with the paths in the temporary folder as they were given.
    fn renamed(&self, text: &str, shown: &dyn Fn(&Path) -> String) -> String {
        self.led
            .iter()
            .fold(text.to_owned(), |text, (output, place)| {
                text.replace(&shown(place), &shown(&output.path))
            })
    }

    fn rename_in(&self, value: &mut Value) {
        match value {
            Value::String(text) => *text = self.renamed(text, &|path| path.display().to_string()),
            Value::Array(several) => several.iter_mut().for_each(|one| self.rename_in(one)),
            Value::Object(fields) => fields.values_mut().for_each(|one| self.rename_in(one)),
            _ => {}
        }
    }
}

/// Refuses a command whose inputs are gone.
fn refuse_missing(made: &Made, folder: &Path) -> Outcome {
    let inputs = made.invocation.inputs.iter();
    let inputs = inputs.filter(|input| input.found != Found::Nothing);
    let missing = inputs.filter(|input| !folder.join(&input.path).is_file());
    let missing: Vec<&str> = missing.map(|input| input.path.as_str()).collect();
    if missing.is_empty() {
        return Ok(());
    }
    Err(anyhow!(
        "cannot be run again: expected {} in {}, found no such file; put what was read there, or the report beside it",
        missing.join(", "),
        folder.display()
    )
    .into())
}

/// `text` as it stands in HTML.
fn escaped(text: &str) -> String {
    let text = text.replace('&', "&amp;").replace('<', "&lt;");
    text.replace('>', "&gt;").replace('"', "&quot;")
}
