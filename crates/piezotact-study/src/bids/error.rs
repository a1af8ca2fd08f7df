//! Why a data set cannot be written or read.

use std::path::PathBuf;

use piezotact::recording::RecordingError;

use piezotact_dataset::{ReadError, WriteError};

/// Why a data set cannot be written or read.
#[derive(Debug, thiserror::Error)]
pub enum BidsError {
    /// Something stands where it is to be written.
    #[error("cannot write to {}: found {found}; give another folder, as nothing is overwritten", folder.display())]
    Exists { folder: PathBuf, found: String },
    /// The place is inside the study or data set that is read.
    #[error("{} lies inside the data set or study that is read: give a folder outside it", folder.display())]
    Inside { folder: PathBuf },
    /// Another program writes there.
    #[error("{}: another program writes this folder; wait until it has ended", folder.display())]
    Held { folder: PathBuf },
    /// A name has no letter and no digit.
    #[error(
        "expected a {what} with a letter or digit (A to Z, 0 to 9), of which BIDS makes the names of files, found `{name}`; rename it in the protocol, or where the recordings state it"
    )]
    NoLabel {
        /// "participant", "session", "task" or "sample".
        what: &'static str,
        name: String,
    },
    /// Two names have one label.
    #[error("expected {what}s that differ in letters and digits, of which BIDS makes the names of files, found `{}` and `{}`, both {label}; rename one of them", .names[0], .names[1])]
    Clash {
        /// "participant", "session", "task" or "sample".
        what: &'static str,
        label: String,
        names: [String; 2],
    },
    /// A text that a table of BIDS cannot hold.
    #[error(
        "{place}: expected a text without tabulators and line ends that is not `n/a`, found `{found}`; change the name in the protocol"
    )]
    Text {
        /// The table and column.
        place: String,
        found: String,
    },
    /// No folder with a data set.
    #[error("{}: expected a BIDS data set, found {found}; {todo}", folder.display())]
    NoDataset {
        folder: PathBuf,
        found: String,
        todo: &'static str,
    },
    /// The data set holds no touch data.
    #[error("{} has no touch data (acceleration, force, or answers to stimuli), but {found}: open it with a program for its own modality", folder.display())]
    NoTouch { folder: PathBuf, found: String },
    /// A file of the data set.
    #[error("{file}{}: {why}", .line.map_or(String::new(), |line| format!(", line {line}")))]
    File {
        /// The file, from the root.
        file: String,
        /// The line, from 1.
        line: Option<u64>,
        /// What was expected, what was found, and what to do.
        why: String,
    },
    /// Channels that make no recording.
    #[error("{file}: {source}")]
    Recording {
        /// The file, from the root.
        file: String,
        source: RecordingError,
    },
    /// A file cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

impl BidsError {
    pub(super) fn file(file: &str, line: impl Into<Option<u64>>, why: impl Into<String>) -> Self {
        Self::File {
            file: file.to_owned(),
            line: line.into(),
            why: why.into(),
        }
    }

    pub(super) fn io(path: &std::path::Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        move |source| {
            Self::Write(WriteError::Io {
                path: path.to_owned(),
                source,
            })
        }
    }
}
