//! Errors of reading and writing files. Every message states what was expected, what was found, and what to do.

use std::path::{Path, PathBuf};

/// Why a file cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The operating system refuses it.
    #[error("{what}")]
    Io {
        path: PathBuf,
        /// What the operating system says, with the path.
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
    /// What it holds makes no recording, transfer function, device, surface or table.
    #[error("{}: {source}", path.display())]
    Invalid {
        path: PathBuf,
        source: Box<dyn std::error::Error + Send + Sync>,
    },
    /// A pattern of file names is not valid.
    #[error(
        "invalid name pattern `{pattern}` ({why}): write for example '{{sample}}_F{{load:N}}_V{{speed:mm/s}}_{{repeat}}'"
    )]
    Pattern {
        pattern: String,
        /// What is wrong with it.
        why: String,
    },
}

impl ReadError {
    /// What the operating system says of `path`, as `error`.
    #[must_use]
    pub fn io(path: &Path, error: &std::io::Error) -> Self {
        let file = path.display();
        let what = match error.kind() {
            std::io::ErrorKind::NotFound => format!("no such file: {file}; check the path"),
            std::io::ErrorKind::PermissionDenied => {
                format!("permission to read {file} was denied")
            }
            std::io::ErrorKind::IsADirectory => format!("{file} is a folder: give a file"),
            std::io::ErrorKind::InvalidInput => format!("cannot read {file}: {error}"),
            _ => format!("cannot read {file}: {error}; check the path"),
        };
        Self::Io {
            path: path.into(),
            what,
        }
    }

    /// What makes an error about the content of `path` one of reading it.
    pub fn of<E: Into<Box<dyn std::error::Error + Send + Sync>>>(
        path: &Path,
    ) -> impl FnOnce(E) -> Self {
        move |error| Self::Invalid {
            path: path.into(),
            source: error.into(),
        }
    }

    /// What is wrong, without the file and what is to be done: where something else was used instead.
    pub(crate) fn reason(&self) -> String {
        match self {
            Self::Content {
                expected, found, ..
            } => format!("expected {expected}, found {found}"),
            other => other.to_string(),
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
    #[error("{} already exists and its content differs {at}: give another name, or replace it with --force", path.display())]
    Differs {
        path: PathBuf,
        /// Where: "from line 3 on".
        at: String,
    },
    /// Another program uses it.
    #[error("cannot write {}: {by} is still writing to it; wait until it has finished, or give another output", path.display())]
    Held {
        path: PathBuf,
        /// Who, as far as it is known.
        by: String,
    },
}

impl WriteError {
    /// The same about `path`, for which a file beside it was to be written.
    #[must_use]
    pub fn about(mut self, path: &Path) -> Self {
        let (Self::Io { path: of, .. }
        | Self::Content { path: of, .. }
        | Self::Differs { path: of, .. }
        | Self::Held { path: of, .. }) = &mut self;
        *of = path.into();
        self
    }

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
