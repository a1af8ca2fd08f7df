//! EEG files: BrainVision, EDF, EDF+, BDF, BDF+ and EEGLAB in; BrainVision and EDF+ out. XDF has streams with clocks of their own, and
//! a reader of its own ([`read_xdf`]).
//!
//! Samples are in SI (V for EEG), channels have the names of the file, and an event has its onset in s and the index of its sample.
//! A recording that was paused is not joined: each part between two gaps is an [`EegSegment`] with its start time. What a file
//! claims is checked against the bytes that it has before anything is reserved.

mod beside;
mod brainvision;
mod brainvision_samples;
mod brainvision_write;
mod content;
mod edf;
mod eeglab;
mod events;
mod ini;
mod trigger;
mod xdf;

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

use piezotact::Warning;
use piezotact::quantity::{Seconds, Unit};
use piezotact::recording::{Recording, RecordingWarning};

pub use beside::{
    ChannelRow, EegSource, EventTable, StatedPosition, files_of, read_eeg_source, read_electrodes,
};
pub use brainvision_write::{EegMarker, markers_of, write_brainvision};
pub use edf::write_edf;
pub use xdf::{LostBefore, XdfFile, XdfStream, XdfValues, read_xdf};

pub(crate) use brainvision::{looks_like_brainvision, looks_like_markers};
pub(crate) use edf::{looks_like_bdf, looks_like_edf};
pub(crate) use eeglab::is_called_set;
pub(crate) use xdf::{looks_like_xdf, recording_of_xdf};

use crate::error::ReadError;
use crate::input::open_input;
use crate::matlab::looks_like_mat;
use crate::open::no_part;

/// The kind of an EEG file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EegKind {
    /// `BrainVision`: a header, a file of markers and a file of samples.
    BrainVision,
    /// EDF of 1992, without annotations.
    Edf,
    /// EDF+, continuous.
    EdfPlus,
    /// EDF+ with gaps between its records.
    EdfPlusGaps,
    /// BDF, 24 bits.
    Bdf,
    /// BDF+, continuous.
    BdfPlus,
    /// BDF+ with gaps between its records.
    BdfPlusGaps,
    /// A data set of EEGLAB: a MATLAB file, with its samples inside or in a `.fdt` file.
    Eeglab,
}

impl fmt::Display for EegKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::BrainVision => "BrainVision",
            Self::Edf => "EDF",
            Self::EdfPlus => "EDF+C",
            Self::EdfPlusGaps => "EDF+D",
            Self::Bdf => "BDF",
            Self::BdfPlus => "BDF+C",
            Self::BdfPlusGaps => "BDF+D",
            Self::Eeglab => "EEGLAB",
        })
    }
}

/// A part of a recording without a gap.
#[derive(Clone, Debug, PartialEq)]
pub struct EegSegment {
    /// Its channels; its events begin at its first sample, and `annotations.started_at` is the time of that sample. Warnings about the whole file
    /// stand in the first segment.
    pub recording: Recording,
    /// The time of its first sample, from the first sample of the file, s.
    pub start_s: Seconds,
    /// For each event of the recording, in order, the index of its sample from the first one of the segment, on the channel of the
    /// highest rate. An event before the segment has a negative one, and an event after its end one beyond its last sample; a warning
    /// says that there are such events.
    pub event_samples: Vec<i64>,
}

/// What an EEG file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct EegFile {
    pub kind: EegKind,
    /// Its segments in the order of the file, at least one.
    pub segments: Vec<EegSegment>,
    /// The positions of electrodes that the file states: x to the right, y to the front, z up, in any unit; empty where it states none.
    pub positions: Vec<StatedPosition>,
    /// The unit of each channel as the file writes it, before the samples became SI; empty where the format states none.
    pub stated_units: BTreeMap<String, String>,
}

/// The part called `part`, from 1 on; without one the first, with a warning where there are others.
fn one_of(
    path: &Path,
    segments: Vec<EegSegment>,
    part: Option<usize>,
) -> Result<Recording, ReadError> {
    let count = segments.len();
    let lengths = segments.iter().map(|part| part.recording.duration().0);
    let all_s: f64 = lengths.sum();
    let of_file = segments.first().map(|first| first.recording.about.clone());
    let mut segments = segments.into_iter();
    let number = part.unwrap_or(1);
    let Some(found) = number.checked_sub(1).and_then(|at| segments.nth(at)) else {
        return Err(no_part(path, number, count));
    };
    let mut recording = found.recording;
    if let Some(of_file) = of_file.filter(|_| number > 1) {
        recording.about.warnings.extend(of_file.warnings);
        let losses = &mut recording.about.provenance.losses;
        losses.is_interrupted = of_file.provenance.losses.is_interrupted;
    }
    if count > 1 && part.is_none() {
        let lasts_s = recording.duration().0;
        let warning = RecordingWarning::OneSegment {
            count,
            lasts_s,
            all_s,
        };
        recording.about.warnings.push(Warning::from(warning));
    }
    Ok(recording)
}

/// The part called `part` of the file at `path`, as [`one_of`].
pub(crate) fn recording_of_eeg(path: &Path, part: Option<usize>) -> Result<Recording, ReadError> {
    one_of(path, read_eeg(path)?.segments, part)
}

/// Reads an EEG file, known by its content: the `.vhdr` of a `BrainVision` recording, EDF, EDF+, BDF, BDF+, or the `.set` of EEGLAB
/// (MATLAB 5 to 7).
///
/// # Errors
/// [`ReadError`] when a file is missing, is none of these, or claims something that its bytes do not hold.
pub fn read_eeg(path: &Path) -> Result<EegFile, ReadError> {
    use std::io::Read as _;
    let mut head = Vec::new();
    open_input(path)?
        .take(1024)
        .read_to_end(&mut head)
        .map_err(|error| ReadError::io(path, &error))?;
    let bytes = || crate::input::read_input(path);
    if looks_like_brainvision(&head) {
        brainvision::read(path, &bytes()?)
    } else if looks_like_edf(&head) || looks_like_bdf(&head) {
        edf::read(path, &bytes()?)
    } else if looks_like_mat(&head) {
        eeglab::read(path, &bytes()?)
    } else if looks_like_xdf(&head) {
        Err(ReadError::content(
            path,
            "an EEG file of one clock",
            "XDF, which has streams with clocks of their own",
            "read it with `read_xdf`",
        ))
    } else if looks_like_markers(&head) || has_header_beside(path) {
        Err(not_the_header(path))
    } else {
        Err(ReadError::content(
            path,
            "an EEG file: BrainVision (.vhdr), EDF, EDF+, BDF, BDF+ or EEGLAB (.set)",
            "another file",
            "export it as one of these",
        ))
    }
}

/// Whether `path` is a file of samples with a `BrainVision` header beside it.
fn has_header_beside(path: &Path) -> bool {
    let ending = path.extension().and_then(|ending| ending.to_str());
    matches!(ending, Some("eeg" | "dat" | "avg")) && path.with_extension("vhdr").is_file()
}

/// Refuses a part of a `BrainVision` recording that is not its header.
pub(crate) fn not_the_header(path: &Path) -> ReadError {
    ReadError::content(
        path,
        "the header of a BrainVision recording",
        "its markers or its samples",
        format!("give {}", path.with_extension("vhdr").display()),
    )
}

/// The SI unit of `text` and the factor to it, as EEG programs write units. A unit without an SI unit here is kept as written.
fn eeg_unit(text: &str) -> (Unit, f64) {
    let text = text.trim();
    match text.replace(['µ', 'μ'], "u").as_str() {
        "nV" => (Unit::Volt, 1e-9),
        "uS" => (Unit::Other("S".into()), 1e-6),
        _ => Unit::parse(text),
    }
}

/// The file called `name` in the folder of `beside`.
fn in_folder_of(beside: &Path, name: &str) -> PathBuf {
    beside.with_file_name(name)
}

/// Names without a repetition: `EEG`, `EEG` become `EEG-0`, `EEG-1`, as in MNE; the names that changed.
fn unique_names(names: &mut [String]) -> Vec<String> {
    let before: Vec<String> = names.to_vec();
    let mut changed = Vec::new();
    let mut seen = BTreeMap::<&str, (usize, usize)>::new();
    for name in &before {
        seen.entry(name).or_default().0 += 1;
    }
    let mut taken: std::collections::BTreeSet<String> = before.iter().cloned().collect();
    for (name, old) in names.iter_mut().zip(&before) {
        let Some((count, next)) = seen.get_mut(old.as_str()) else {
            continue;
        };
        if *count < 2 {
            continue;
        }
        loop {
            let candidate = format!("{old}-{next}");
            *next += 1;
            if taken.insert(candidate.clone()) {
                *name = candidate;
                break;
            }
        }
        changed.push(old.clone());
    }
    changed.dedup();
    changed
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_become_si() {
        for (text, unit, factor) in [
            ("uV", Unit::Volt, 1e-6),
            ("µV", Unit::Volt, 1e-6),
            ("nV", Unit::Volt, 1e-9),
            ("mV", Unit::Volt, 1e-3),
            ("V", Unit::Volt, 1.0),
            ("µS", Unit::Other("S".into()), 1e-6),
            ("C", Unit::Other("C".into()), 1.0),
            ("°C", Unit::Other("°C".into()), 1.0),
            ("", Unit::Other(String::new()), 1.0),
        ] {
            assert_eq!(eeg_unit(text), (unit, factor), "{text}");
        }
    }

    #[test]
    fn repeated_names_get_numbers() {
        let mut names = ["EEG", "A", "EEG", "EEG-1"].map(String::from);
        assert_eq!(unique_names(&mut names), ["EEG"]);
        assert_eq!(names, ["EEG-0", "A", "EEG-2", "EEG-1"]);
    }
}
