//! Whether a data set is one, whole, of one study, and what was exported.

use std::collections::BTreeMap;

use piezotact::recording::Recording;

use super::super::DESCRIPTION;
use super::super::check::{LEADS_OUT, changes};
use super::super::error::BidsError;
use super::super::tree::{Tree, text};
use super::BidsFolder;

impl BidsFolder {
    /// The recordings of `tree` that are not those in `sourcedata` that they were made from, each with what is wrong.
    pub(in super::super) fn recordings_unlike(tree: &Tree) -> Vec<(String, BidsError)> {
        let folder = Self {
            tree: tree.clone(),
            people: BTreeMap::new(),
            sessions: BTreeMap::new(),
        };
        let all = folder.recordings();
        let unlike = all.iter().filter_map(|of| {
            let file = of.files.first()?.file.clone();
            Some((file, folder.read_recording(of).err()?))
        });
        unlike.collect()
    }

    /// Refuses samples that are not those of the recording as it was made.
    pub(super) fn require_source(
        &self,
        file: &str,
        recording: &Recording,
        source: &str,
    ) -> Result<(), BidsError> {
        let source = source.trim_start_matches("bids::");
        let path = self.tree.path(source);
        let refused = |found: String| {
            let why = format!(
                "expected the recording of {source}, from which it was made, found {found}; copy both files again, or export the study again"
            );
            Err(BidsError::file(file, None, why))
        };
        if !self.tree.has(source) {
            return refused("no such file".into());
        }
        let made = piezotact_dataset::recording_of_ours(&path)?;
        let person = (
            &made.about.condition.participant,
            &recording.about.condition.participant,
        );
        if made.channels().len() != recording.channels().len() {
            return refused("another number of channels".into());
        }
        if let (Some(own), Some(stated)) = person
            && own != stated
        {
            return refused(format!("participant {stated} for {own}"));
        }
        for (own, read) in made.channels().iter().zip(recording.channels()) {
            let clocks = [made.clock_of(&own.name), recording.clock_of(&read.name)];
            if clocks[0] != clocks[1] {
                return refused(format!("another rate or start of {}", own.name));
            }
            if own.unit != read.unit {
                return refused(format!("{} for {} of {}", read.unit, own.unit, own.name));
            }
            let same = |(one, other): (&f64, &f64)| {
                one.to_bits() == other.to_bits() || (!one.is_finite() && other.is_nan())
            };
            let samples = (&own.samples, &read.samples);
            if samples.0.len() != samples.1.len() {
                return refused(format!("another number of samples of {}", own.name));
            }
            if !samples.0.iter().zip(samples.1).all(same) {
                return refused(format!("other samples of {}", own.name));
            }
        }
        Ok(())
    }
}

/// Refuses a folder without a data set, or with several.
pub(in super::super) fn require_one(tree: &Tree) -> Result<(), BidsError> {
    let none = |found: String, todo| {
        Err(BidsError::NoDataset {
            folder: tree.root.clone(),
            found,
            todo,
        })
    };
    let has_own = tree.has(DESCRIPTION);
    match (has_own, tree.within.as_slice()) {
        (true, []) => Ok(()),
        (false, []) => {
            let is_half = tree
                .entries
                .iter()
                .any(|entry| entry.file.starts_with("sub-"));
            match is_half {
                _ if tree.is_part() => none(
                    "a part of one".into(),
                    "give the folder above it, which holds dataset_description.json",
                ),
                true => none(
                    format!("a half-written one: folders of participants without {DESCRIPTION}"),
                    "export it again; an export that ended early is no data set",
                ),
                false => none(format!("no {DESCRIPTION}"), "give the folder that holds it"),
            }
        }
        (false, within) => none(
            format!("{} in it: {}", within.len(), within.join(", ")),
            "give the folder of one of them",
        ),
        (true, within) => none(
            format!("further ones within it: {}", within.join(", ")),
            "move them out: a data set is one study",
        ),
    }
}

/// Refuses links that lead out of the data set, and data that are not those that were exported.
pub(super) fn require_whole(tree: &Tree) -> Result<(), BidsError> {
    if let Some(file) = tree.outside.first() {
        return Err(BidsError::file(file, None, LEADS_OUT));
    }
    match changes(tree).into_iter().next() {
        None => Ok(()),
        Some(change) => Err(BidsError::file(&change.file, change.line, change.text)),
    }
}

/// A file of another study than those before it, with what is said of it.
pub(in super::super) fn two_studies(tree: &Tree) -> Option<(String, String)> {
    let mut first: Option<(String, String)> = None;
    for entry in tree
        .entries
        .iter()
        .filter(|entry| entry.file.ends_with(".json"))
    {
        let Some(name) = entry.parsed() else { continue };
        if !["beh", "eeg", "physio", "stim"].contains(&name.suffix.as_str()) {
            continue;
        }
        let Ok(object) = tree.json(&entry.file) else {
            continue;
        };
        let Some(study) = text(&object, "Study") else {
            continue;
        };
        match &first {
            None => first = Some((entry.file.clone(), study.to_owned())),
            Some((_, known)) if known == study => {}
            Some((file, known)) => {
                return Some((
                    entry.file.clone(),
                    format!(
                        "expected files of one study, found this one of study {} and {file} of study {}; keep each study in a folder of its own",
                        short(study),
                        short(known)
                    ),
                ));
            }
        }
    }
    None
}

fn short(checksum: &str) -> String {
    checksum.chars().take(12).collect()
}
