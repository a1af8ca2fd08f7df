//! Why people cannot be compared.

use crate::eeg::cluster::ClusterError;

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
        "{first} and {second} differ only in case, signs or leading zeros: give one person, task or surface one name"
    )]
    AlmostTwice { first: String, second: String },
    /// A recording under two names.
    #[error(
        "{first} and {second} are the same recording: their epochs correlate by {likeness:.2}, those of different recordings by about 0.3; give each \
         recording once"
    )]
    Copy {
        /// A file, and who and what it is of.
        first: String,
        second: String,
        /// The mean of the largest correlations of epochs.
        likeness: f64,
    },
    /// Documents of other settings.
    #[error("{first} and {second} differ in {what}: analyse all recordings with the same options")]
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
    #[error("no electrode is in all documents: check the names of the channels")]
    NoElectrode,
    /// A task of the gradient that is not there.
    #[error("expected one of the tasks {tasks}, found `{task}` in the claimed order; correct it")]
    NoTask {
        task: String,
        /// The tasks that there are.
        tasks: String,
    },
    /// A gradient of one task.
    #[error("an order of one task says nothing: state at least two different tasks")]
    OneStep,
    /// A margin that is none.
    #[error("the margin must be above 0: state the largest difference of no interest")]
    Margin,
    /// A map with another number of values than its axes.
    #[error(
        "expected electrodes × frequencies × times values in the maps of {file}, found {found}; analyse the recording again"
    )]
    Map { file: String, found: usize },
    /// The cluster test cannot be.
    #[error(transparent)]
    Cluster(#[from] ClusterError),
}
