//! Where a command writes: places are checked before anything is computed.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use piezotact_dataset::sidecar::sidecar_path;
use piezotact_dataset::{check_place, cuts_path, journal_path, set_aside_path};

use crate::failure::{Outcome, usage};
use crate::invocation;

/// Refuses outputs that would replace an input, an input's sidecar, each other, or what another command wrote, or that have no
/// folder to stand in: before anything is measured that could not be kept.
pub(crate) fn outputs(inputs: &[&Path], outputs: &[&Path]) -> Outcome {
    let read: Vec<PathBuf> = inputs
        .iter()
        .flat_map(|input| {
            // Cuts beside a recording may be edited by hand; where there are none, they may be written.
            let cuts = Some(cuts_path(input)).filter(|cuts| cuts.exists());
            let files = [Some(input.to_path_buf()), Some(sidecar_path(input)), cuts];
            files.into_iter().flatten().map(|file| place(&file))
        })
        .collect();
    for (i, output) in outputs.iter().enumerate() {
        if read.contains(&place(output)) {
            return Err(usage(anyhow!(
                "{} is read and would be replaced: give the output another name",
                output.display()
            )));
        }
        if outputs[..i]
            .iter()
            .any(|other| place(other) == place(output))
        {
            return Err(usage(anyhow!(
                "{} is written twice: give each output its own name",
                output.display()
            )));
        }
    }
    for output in outputs {
        can_be_written(output)?;
    }
    Ok(())
}

/// Refuses an output in a folder that is not there, or whose name is that of something other than a file.
pub(crate) fn can_be_written(output: &Path) -> Outcome {
    let folder = folder_of(output);
    if !folder.is_dir() {
        return Err(anyhow!(
            "{}: expected the folder {}, found none; create it",
            output.display(),
            folder.display()
        )
        .into());
    }
    if std::fs::metadata(output).is_ok_and(|found| !found.is_dir() && !found.is_file()) {
        return Err(anyhow!(
            "{}: expected the name of a file, found a device; give a file's name",
            output.display()
        )
        .into());
    }
    if output.is_dir() {
        return Err(anyhow!(
            "{}: expected the name of a file, found a folder; give a file's name in it",
            output.display()
        )
        .into());
    }
    invocation::refuse_existing(output)?;
    check_place(output)?;
    Ok(())
}

/// The ending of an output's name, in small letters, which is one of `known`.
pub(crate) fn has_ending<'a>(path: &Path, known: &[&'a str]) -> Outcome<&'a str> {
    let found = path.extension().map(|end| end.to_ascii_lowercase());
    let ending = known
        .iter()
        .find(|known| found.as_deref() == Some((*known).as_ref()));
    ending.copied().ok_or_else(|| {
        usage(anyhow!(
            "{}: expected a name that ends in .{}, found another extension; the extension selects the format",
            path.display(),
            known.join(" or .")
        ))
    })
}

/// The files that a recording called `record` takes up while it is made, and the longest name that one of an interrupted
/// command gets.
pub(crate) fn recording_files(record: &Path) -> [PathBuf; 3] {
    [
        record.to_owned(),
        journal_path(record),
        set_aside_path(record, 1),
    ]
}

pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent()
        .filter(|folder| !folder.as_os_str().is_empty())
        .unwrap_or(Path::new("."))
}

/// Where a path leads to, whatever its spelling and whether the file is there yet or not.
pub(crate) fn place(path: &Path) -> PathBuf {
    std::fs::canonicalize(path).unwrap_or_else(|_| {
        let folder =
            std::fs::canonicalize(folder_of(path)).unwrap_or_else(|_| folder_of(path).to_owned());
        folder.join(path.file_name().unwrap_or_default())
    })
}
