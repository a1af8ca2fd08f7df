//! Errors of reading and writing files. Every message states what was expected, what was found, and what to do.

use std::path::{Path, PathBuf};

use piezotact::device::DescriptionError;
use piezotact::quantity::QuantityError;
use piezotact::recording::RecordingError;
use piezotact::surface::SurfaceError;
use piezotact::transfer::TransferError;

/// Why a file cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The operating system refuses it.
    #[error("cannot read {}: {what}", path.display())]
    Io {
        path: PathBuf,
        /// What the operating system says.
        what: String,
    },
    /// The content is not what is needed.
    #[error("{}: expected {expected}, found {found}; {todo}", path.display())]
    Content {
        path: PathBuf,
        expected: String,
        found: String,
        todo: String,
    },
    /// The channels make no recording.
    #[error("{}: {source}", path.display())]
    Recording {
        path: PathBuf,
        source: RecordingError,
    },
    /// The lines make no transfer function.
    #[error("{}: {source}", path.display())]
    Transfer {
        path: PathBuf,
        source: TransferError,
    },
    /// The text describes no device.
    #[error("{}: {source}", path.display())]
    Device {
        path: PathBuf,
        source: DescriptionError,
    },
    /// The heights make no surface.
    #[error("{}: {source}", path.display())]
    Surface { path: PathBuf, source: SurfaceError },
    /// The answers make no table.
    #[error("{}: {source}", path.display())]
    Answers {
        path: PathBuf,
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// An invalid rate, band or measure.
    #[error("{}: {source}", path.display())]
    Quantity {
        path: PathBuf,
        source: QuantityError,
    },
}

impl ReadError {
    /// What the operating system says of `path`, as `error`.
    #[must_use]
    pub fn io(path: &Path, error: &std::io::Error) -> Self {
        let what = match error.kind() {
            std::io::ErrorKind::NotFound => {
                "expected a file, found none there; check the path".into()
            }
            std::io::ErrorKind::PermissionDenied => {
                "expected a readable file, found one without permission; check the path".into()
            }
            std::io::ErrorKind::IsADirectory => {
                "expected a file, found a folder; check the path".into()
            }
            std::io::ErrorKind::InvalidInput => error.to_string(),
            _ => format!("{error}; check the path"),
        };
        Self::Io {
            path: path.into(),
            what,
        }
    }

    /// That `path` holds `found` instead of what was `expected`, with what is to be done.
    #[must_use]
    pub fn content(
        path: &Path,
        expected: impl Into<String>,
        found: impl Into<String>,
        todo: impl Into<String>,
    ) -> Self {
        Self::Content {
            path: path.into(),
            expected: expected.into(),
            found: found.into(),
            todo: todo.into(),
        }
    }
}

/// Why a file cannot be written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The operating system refuses it.
    #[error("cannot write {}: {source}; check the folder and the free disk space", path.display())]
    Io {
        path: PathBuf,
        /// What the operating system says.
        source: std::io::Error,
    },
    /// The format cannot hold it.
    #[error("cannot write {}: expected {expected}, found {found}; {todo}", path.display())]
    Content {
        path: PathBuf,
        /// What the format holds.
        expected: String,
        /// What was to be written.
        found: String,
        todo: String,
    },
    /// Something else stands there, which is not replaced unasked.
    #[error("{} already exists, and what is written now differs from it {at}: give another name, move it away, or replace it with --force", path.display())]
    Differs {
        path: PathBuf,
        /// Where: "from line 3 on".
        at: String,
    },
}

impl WriteError {
    /// What makes an error of the operating system one about `path`.
    pub fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        move |source| Self::Io {
            path: path.into(),
            source,
        }
    }

    /// That a file of this format cannot hold what was found instead of what was `expected`, with what is to be done.
    #[must_use]
    pub fn content(
        path: &Path,
        expected: impl Into<String>,
        found: impl Into<String>,
        todo: impl Into<String>,
    ) -> Self {
        Self::Content {
            path: path.into(),
            expected: expected.into(),
            found: found.into(),
            todo: todo.into(),
        }
    }
}
