//! Folders with what was felt: one recording for each sample, named as the sample, for everybody or for each participant.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::error::ReadError;
use crate::open::FileKind;

/// The part of a prepared folder that holds what the fingernail felt.
const MEASURED: &str = "measured";

/// A recording of what was felt.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct FeltFile {
    /// The participant whose folder it is in; `None` for recordings that stand for everybody.
    pub participant: Option<String>,
    /// The sample that it is named as.
    pub sample: String,
    pub path: PathBuf,
}

/// A name for the files of the texture called `texture`: letters, digits, `-`, `_` and `.` are kept.
#[must_use]
pub fn texture_file_name(texture: &str) -> String {
    let kept = |c: char| match c {
        c if c.is_alphanumeric() || "-_.".contains(c) => c,
        _ => '_',
    };
    let plain: String = texture.chars().take(64).map(kept).collect();
    match plain.trim_start_matches('.') {
        "" => "texture".to_owned(),
        plain => plain.to_owned(),
    }
}

/// The recordings of `samples` in `folder`: in its part `measured` where it has one, or in itself; where it holds none, those of each
/// folder in it, which is named by the pseudonym of a participant.
///
/// # Errors
/// [`ReadError`] where it is no folder, holds no recording of any sample, or two of one.
pub fn felt_files(folder: &Path, samples: &BTreeSet<String>) -> Result<Vec<FeltFile>, ReadError> {
    if !folder.is_dir() {
        return Err(ReadError::content(
            folder,
            "a folder with recordings",
            "none",
            "give a folder with one recording for each sample, such as S1.wav",
        ));
    }
    let mut found = of_one(folder, None, samples)?;
    if found.is_empty() {
        for path in entries(folder)?.into_iter().filter(|path| path.is_dir()) {
            let name = path.file_name().and_then(|name| name.to_str());
            let hidden = name.is_none_or(|name| name.starts_with('.'));
            if let Some(name) = name.filter(|_| !hidden) {
                found.extend(of_one(&path, Some(name), samples)?);
            }
        }
    }
    if found.is_empty() && !samples.is_empty() {
        let names: Vec<&str> = samples.iter().map(String::as_str).collect();
        return Err(ReadError::content(
            folder,
            format!("recordings named as samples ({})", names.join(", ")),
            "none",
            "give a folder with one recording for each sample, such as S1.wav",
        ));
    }
    Ok(found)
}

/// What is in `folder`, by name.
fn entries(folder: &Path) -> Result<Vec<PathBuf>, ReadError> {
    let mut found = std::fs::read_dir(folder)
        .map_err(|error| ReadError::io(folder, &error))?
        .map(|entry| entry.map(|entry| entry.path()))
        .collect::<Result<Vec<_>, _>>()
        .map_err(|error| ReadError::io(folder, &error))?;
    found.sort();
    Ok(found)
}

fn of_one(
    folder: &Path,
    participant: Option<&str>,
    samples: &BTreeSet<String>,
) -> Result<Vec<FeltFile>, ReadError> {
    let measured = folder.join(MEASURED);
    let within = if measured.is_dir() { &measured } else { folder };
    let mut found: Vec<FeltFile> = Vec::new();
    for path in entries(within)? {
        let stem = path.file_stem().and_then(|stem| stem.to_str());
        let is_named = |sample: &&String| {
            stem.is_some_and(|stem| stem == sample.as_str() || stem == texture_file_name(sample))
        };
        let Some(sample) = samples.iter().find(is_named) else {
            continue;
        };
        if !path.is_file() || FileKind::of_ending(&path).is_none() {
            continue;
        }
        if let Some(other) = found.iter().find(|other| other.sample == *sample) {
            return Err(ReadError::content(
                &path,
                format!("one recording of {sample}"),
                format!("another one, {}", other.path.display()),
                "keep the one that was felt",
            ));
        }
        found.push(FeltFile {
            participant: participant.map(Into::into),
            sample: sample.clone(),
            path,
        });
    }
    Ok(found)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(found: &[FeltFile]) -> Vec<(Option<&str>, &str)> {
        let files = found.iter();
        files
            .map(|file| (file.participant.as_deref(), file.sample.as_str()))
            .collect()
    }

    #[test]
    fn recordings_are_found_in_folders_of_each_form() {
        let folder = tempfile::tempdir().unwrap();
        let write = |name: &str| {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, "").unwrap();
        };
        let samples: BTreeSet<String> = ["S1", "S2"].map(Into::into).into();
        let of = |name: &str| felt_files(&folder.path().join(name), &samples);
        for name in ["S1.wav", "S1.wav.json", "S2.csv", "S3.csv", "S2.txt~"] {
            write(&format!("plain/{name}"));
        }
        assert_eq!(names(&of("plain").unwrap()), [(None, "S1"), (None, "S2")]);
        write("prepared/targets/S1.wav");
        write("prepared/measured/S1.parquet");
        let prepared = of("prepared").unwrap();
        assert_eq!(names(&prepared), [(None, "S1")]);
        assert!(prepared[0].path.ends_with("measured/S1.parquet"));
        write("people/P01/S1.wav");
        write("people/P02/measured/S2.wav");
        assert_eq!(
            names(&of("people").unwrap()),
            [(Some("P01"), "S1"), (Some("P02"), "S2")]
        );
        write("twice/S1.wav");
        write("twice/S1.csv");
        let twice = of("twice").unwrap_err().to_string();
        assert!(twice.contains("one recording of S1"), "{twice}");
        write("none/S9.wav");
        let none = of("none").unwrap_err().to_string();
        assert!(none.contains("(S1, S2)"), "{none}");
        assert!(of("missing").is_err());
    }
}
