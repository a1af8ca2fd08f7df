//! A study, or the recordings of a laboratory, in the Brain Imaging Data Structure (BIDS), which other programs open: written, read
//! back, and checked.
//!
//! Behaviour alone has no modality of its own in BIDS, and touch has none at all. Continuous signals of a finger are `physio`, drives
//! are `stim`, strokes and trials are `events`, answers are `beh`, all in the folder `beh` of a session (docs/decisions/store.md). What is derived
//! is handed in as values; nothing is computed here.

mod about;
mod check;
mod error;
mod folder;
mod json;
mod label;
mod name;
mod page;
mod physio;
mod privacy;
mod read;
mod table;
mod tree;
mod write;

pub use about::{DatasetAbout, Followed, NotCarried, Person, SessionFacts};
pub use check::{Checked, Problem, ProblemKind, SecondOpinion, check};
pub use error::BidsError;
pub use folder::{NewFolder, require_outside};
pub use json::unit_text;
pub use label::label_of;
pub use name::Entities;
pub use page::Imported;
pub use privacy::{Calendar, warnings_carried};
pub use read::{BidsFolder, BidsRecording};
pub use write::{BidsWriter, Brain, BrainAbout, Derived, Exported, NamedBy, Sources, Touched};

/// The version of BIDS that is written.
pub const BIDS_VERSION: &str = "1.11.0";
/// The version of the HED schema of the tags.
pub const HED_VERSION: &str = "8.3.0";
/// The name of the program in what it writes.
pub(crate) const PROGRAM: &str = "Piezotact";
/// What stands in a cell that has nothing.
pub(crate) const NOTHING: &str = "n/a";
/// The file that says what the data set is, from the root.
pub(crate) const DESCRIPTION: &str = "dataset_description.json";
/// The list of all files with their checksums, from the root.
pub(crate) const CHECKSUMS: &str = "sourcedata/SHA256SUMS";
/// The protocol of the study, from the root.
pub(crate) const PROTOCOL: &str = "sourcedata/protocol.toml";
