//! Why people cannot be compared.

use crate::eeg::cluster::{ClusterError, GridError};

/// Why people cannot be compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GroupError {
    /// Fewer than two documents.
    #[error(
        "expected documents of at least two tasks of a participant, or of two participants, found {found}; analyse another recording"
    )]
    OneDocument {
        /// How many there are.
        found: usize,
    },
    /// Two documents of one person and task.
    #[error("expected one document of {subject}, found {first} and {second}; give one of them")]
    Twice {
        subject: String,
        first: String,
        second: String,
    },
    /// Two names that may be those of one person, task or surface.
    #[error(
        "expected names that differ in more than case, signs and leading zeros, found {first} and {second}; give one person, task or surface one name"
    )]
    AlmostTwice { first: String, second: String },
    /// A recording under two names.
    #[error(
        "expected different recordings, found the same numbers in {first} and {second}; give each recording once"
    )]
    Copy {
        /// A file, and who and what it is of.
        first: String,
        second: String,
    },
    /// Documents of other settings.
    #[error(
        "expected the same {what} in all documents, found others in {first} and {second}; analyse all recordings with the same options"
    )]
    Settings {
        what: String,
        first: String,
        second: String,
    },
    /// No surface in common.
    #[error(
        "expected surfaces that two tasks share, found {found}; name the surface of each marker in the same way in all tasks"
    )]
    NoSurface {
        /// The surfaces of each task.
        found: String,
    },
    /// No electrode in common.
    #[error(
        "expected electrodes that all documents have, found none; check the names of the channels"
    )]
    NoElectrode,
    /// A task of the gradient that is not there.
    #[error("expected one of the tasks {tasks}, found `{task}` in the claimed order; correct it")]
    NoTask {
        task: String,
        /// The tasks that there are.
        tasks: String,
    },
    /// A gradient of one task.
    #[error("expected an order of at least two different tasks, found one; state the others")]
    OneStep,
    /// A margin that is none.
    #[error(
        "expected a margin above 0, found another; state how large a difference is of no interest"
    )]
    Margin,
    /// A map with another number of values than its axes.
    #[error(
        "expected electrodes × frequencies × times values in the maps of {file}, found {found}; analyse the recording again"
    )]
    Map { file: String, found: usize },
    /// The cluster test cannot be.
    #[error(transparent)]
    Cluster(#[from] ClusterError),
    /// The nodes of the cluster test cannot be.
    #[error(transparent)]
    Grid(#[from] GridError),
}
