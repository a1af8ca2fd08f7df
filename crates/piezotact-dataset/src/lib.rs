//! The study on disk: foreign files in, our files out. This crate reads and writes, and never computes.
//!
//! Everything becomes a [`Recording`](piezotact::recording::Recording) in SI units, whatever it was:
//! [`read_recording`] looks at a file's content, not at its name. What a file does not say is never guessed
//! silently: the physical scale of a WAV file comes from its [`sidecar`] or from the person.

mod atomic;
mod csv_table;
mod error;
mod journal;
mod open;
mod recording_file;
pub mod sidecar;
pub mod topography;
mod transfer_json;
pub mod wav;

pub use atomic::write_atomically;
pub use error::{ReadError, WriteError};
pub use journal::{EndDocument, JournalWriter, StartDocument, journal_path};
pub use open::{Contents, FileKind, ReadOptions, read_recording};
pub use topography::{
    TopographyFile, TopographyKind, TopographyOptions, read_topography, write_sur,
};
pub use transfer_json::{TransferDocument, read_transfer, write_transfer};
