//! Why an EEG cannot be generated.

use piezotact::recording::RecordingError;

use crate::ParameterError;

/// An EEG that cannot be generated, or a truth that it does not have.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EegError {
    /// A value of the protocol, or of a question about the truth, that cannot be.
    #[error("{what}: expected {expected}, found {found}; {todo}")]
    Impossible {
        what: &'static str,
        expected: String,
        found: String,
        todo: &'static str,
    },
    /// A surface that the twin does not have.
    #[error(transparent)]
    Surface(#[from] ParameterError),
    /// Channels that make no recording.
    #[error(transparent)]
    Recording(#[from] RecordingError),
}

/// [`EegError::Impossible`].
pub(super) fn impossible(
    what: &'static str,
    expected: impl Into<String>,
    found: impl ToString,
    todo: &'static str,
) -> EegError {
    EegError::Impossible {
        what,
        expected: expected.into(),
        found: found.to_string(),
        todo,
    }
}
