//! The study on disk: foreign files in, our files out. This crate reads and writes, and never computes.
//!
//! Everything becomes a [`Recording`](piezotact::recording::Recording) in SI units, whatever it was:
//! [`read_recording`] looks at a file's content, not at its name. What a file does not say is never guessed
//! silently: the physical scale of a WAV file comes from its [`sidecar`] or from the person.

pub mod atomic;
mod catman;
mod columns;
mod commas;
mod contact_map;
mod csv_table;
mod cuts_file;
mod date_time;
mod device_file;
pub mod document;
#[cfg(feature = "eeg")]
pub mod eeg;
mod error;
mod felt_folder;
#[cfg(feature = "flac")]
mod flac;
mod flat;
pub mod format;
pub mod haptic;
mod input;
mod journal;
pub mod lock;
pub mod lvm;
pub mod matlab;
mod naming;
mod open;
mod panel_folder;
mod parquet_file;
pub mod reads;
mod recording_file;
mod sample_set;
pub mod sidecar;
mod stated_rate;
mod stored;
pub mod tdms;
mod text;
mod time_column;
mod transfer_file;
mod transfer_json;
pub mod uff;
mod version;
pub mod wav;

pub use atomic::{
    EndWriting, check_place, end_writing, keep_as_it_is, stays_as_it_is, write_atomically,
};
pub use contact_map::read_contact_map;
pub use cuts_file::{cuts_path, cuts_text, read_cuts, read_cuts_of, recording_checksum};
pub use device_file::read_device;
pub use error::{ReadError, WriteError};
pub use felt_folder::{FeltFile, felt_files, texture_file_name};
pub use input::{open_input, read_input, read_input_text};
pub use journal::{
    EndDocument, JournalSink, JournalWriter, RunFolder, StartDocument, journal_path, keep_before,
    set_aside_path, write_measurement, write_recording,
};
pub use naming::{NamePattern, Naming, known_naming};
pub use open::{
    ArrayChannel, Contents, FileKind, NumberTable, ReadOptions, RecordingInBlocks, is_npy,
    parse_npy, read_recording, recording_formats, recording_in_blocks, recording_of_arrays,
};
pub use panel_folder::{
    Adopted, BenchFile, PANEL_INDEX, PanelContents, PanelFolder, PanelIndex, function_of_any_unit,
    panel_of,
};
pub use recording_file::recording_of_ours;
pub use sample_set::{known_sample_sets, read_sample_set};
pub use time_column::is_time_unit;
pub use transfer_file::{
    TransferFormat, holds_transfer, read_transfer, stored_transfer, transfer_formats,
    write_transfer, write_transfer_as,
};
pub use transfer_json::{ConfidenceColumns, MeasuredFor, TransferDocument};
