//! What may stand where the program writes: nothing, what the same command wrote before, the same bytes, or what `--force` gives up.

use std::path::Path;

use anyhow::anyhow;
use clap::Parser as _;
use piezotact::document::INVOCATION;
use piezotact::invocation::Invocation;
use piezotact_dataset::{check_place, keep_as_it_is};
use piezotact_report::invocation::split;

use super::failure::{NAME, Outcome, usage};
use super::{Cli, Command};

/// Where a replay writes.
pub(super) struct Outputs<'a> {
    /// The folder in which the command runs.
    pub(super) here: &'a Path,
    /// The folder that was given.
    pub(super) folder: &'a Path,
    /// Whether existing files are replaced.
    pub(super) existing: Existing,
}

/// What becomes of files that the command did not write.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Existing {
    /// They stay where the same is written again; anything else is refused when it is known.
    Compared,
    /// They are replaced.
    Replaced,
}

impl Outputs<'_> {
    /// Refuses `files` that would replace what is `read`, or what another command wrote, or that cannot be written: before anything is
    /// measured that could not be kept. The last of them is the state, with which the command goes on.
    pub(super) fn check(&self, read: Option<&Path>, files: &[impl AsRef<Path>]) -> Outcome {
        let place = |path: &Path| std::fs::canonicalize(path).ok();
        for file in files {
            let file = file.as_ref();
            if read.is_some_and(|read| place(read).is_some() && place(read) == place(file)) {
                return Err(usage(anyhow!(
                    "{} is read and would be replaced: give the output another name",
                    file.display()
                )));
            }
        }
        for (i, file) in files.iter().enumerate() {
            let file = file.as_ref();
            let found = std::fs::metadata(file).ok();
            if let Some(found) = found.filter(|found| !found.is_file()) {
                let found = if found.is_dir() { "folder" } else { "device" };
                let todo = if found == "folder" { " in it" } else { "" };
                return Err(anyhow!(
                    "{}: expected the name of a file, found a {found}; give a file's name{todo}",
                    file.display()
                )
                .into());
            }
            if i + 1 < files.len() {
                self.refuse_existing(file)?;
            }
            check_place(file)?;
        }
        Ok(())
    }

    fn refuse_existing(&self, path: &Path) -> Outcome {
        if !path.is_file() || self.existing == Existing::Replaced {
            return Ok(());
        }
        let beside = self.folder.join("report.html");
        let mut made = [path, &beside].into_iter().filter_map(made_at);
        if made.any(|made| is_replay(&made) && self.wrote(&made, path)) {
            return Ok(());
        }
        // A report always says who made it; of a document that does not, it is known when it is written.
        if path.extension().is_none_or(|ending| ending != "html") && made_at(path).is_none() {
            keep_as_it_is(path);
            return Ok(());
        }
        Err(usage(anyhow!(
            "{} already exists: give another name, move it away, or replace it with --force",
            path.display()
        )))
    }

    /// Whether the command that `made` states wrote `path`.
    fn wrote(&self, made: &Invocation, path: &Path) -> bool {
        let here = self.here.join(path);
        let outs = made.settings.iter().filter(|setting| setting.name == "out");
        let mut outs = outs.flat_map(|setting| &setting.values);
        outs.any(|value| here.starts_with(Path::new(&made.folder).join(value)))
    }
}

/// Whether `made` is of this command.
fn is_replay(made: &Invocation) -> bool {
    let words = std::iter::once(NAME).chain(made.command.iter().map(String::as_str));
    Cli::try_parse_from(words).is_ok_and(|cli| matches!(cli.command, Command::Replay(_)))
}

/// How the report or document at `path` was made; `None` for what does not say.
fn made_at(path: &Path) -> Option<Invocation> {
    let text = std::fs::read_to_string(path).ok()?;
    if let Some((_, invocation)) = split(&text) {
        return Some(invocation);
    }
    let mut document: serde_json::Value = serde_json::from_str(&text).ok()?;
    let invocation = document.as_object_mut()?.remove(INVOCATION)?;
    serde_json::from_value(invocation).ok()
}
