//! NI TDMS files, as LabVIEW, `FlexLogger`, `DIAdem` and `DAQmx` write them.
//!
//! A file is a row of segments: a lead-in, metadata (objects, their properties, and how their samples lie in the segment) and samples.
//! It is read twice: once for its structure, so that every channel is reserved once and by what the file holds, and once for the
//! samples, in blocks.
//!
//! Source of the layout: National Instruments, *TDMS File Format Internal Structure*.

mod blocks;
mod convert;
mod index;
mod layout;
mod plan;
mod property;
mod samples;
mod scale;
mod source;

pub(crate) use blocks::TdmsBlocks;
use std::io::{Read, Seek};
use std::path::Path;

use piezotact::recording::Recording;

use crate::error::ReadError;
use crate::open::ReadOptions;

/// Whether `head` begins as a TDMS file or its index does.
#[must_use]
pub(crate) fn looks_like_tdms(head: &[u8]) -> bool {
    head.starts_with(b"TDSm") || head.starts_with(b"TDSh")
}

/// Reads the TDMS file at `path`.
pub(crate) fn read_tdms(path: &Path, options: &ReadOptions) -> Result<Recording, ReadError> {
    parse_tdms(path, crate::input::open_input(path)?, options)
}

/// Reads a TDMS file from `bytes`; `path` is what a refusal names.
///
/// # Errors
/// [`ReadError::Content`] when a length or an offset lies, a type or a scale is not known, channels of one clock differ in length, or no
/// channel holds samples; [`ReadError::Io`] when it cannot be read.
pub fn parse_tdms(
    path: &Path,
    bytes: impl Read + Seek,
    options: &ReadOptions,
) -> Result<Recording, ReadError> {
    let mut walk = layout::Walk::new(source::Source::new(path, bytes)?);
    while let Some(segment) = walk.advance()? {
        walk.count(&segment);
    }
    let (file, values) = samples::read(walk)?;
    convert::recording_of(path, &file, values, options)
}
