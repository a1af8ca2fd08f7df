//! Tables of file formats: one row per format, in the order in which they are tried.
//!
//! A new format is a file with its reader and one row in the table of what it holds: recordings (`open.rs`), transfer
//! functions (`transfer_file.rs`) or topographies (in `piezotact-surface`). Lists of formats in helps and errors are made
//! from the tables.

use std::fs::File;
use std::io::{Read as _, Seek as _, SeekFrom};
use std::path::Path;

use crate::error::ReadError;

/// The number of leading bytes by which a format is recognised.
const HEAD: usize = 1024;

/// One format: its names, how it is known, and what reads it.
#[derive(Debug)]
pub struct Format<K, R> {
    /// What its files are called.
    pub kind: K,
    /// Its name in a list of formats; empty where it is known only to be refused by its name.
    pub label: &'static str,
    /// The endings of its files, in lower case, the usual one first.
    pub endings: &'static [&'static str],
    /// How its files are known.
    pub sniff: Recognition,
    /// What reads them.
    pub read: R,
}

/// How the files of a format are known.
#[derive(Clone, Copy, Debug)]
pub enum Recognition {
    /// By their first bytes: nothing more is read for this.
    Head(fn(&[u8]) -> bool),
    /// By their name and all their bytes.
    Whole(fn(&Path, &[u8]) -> bool),
}

/// A file that is read only as far as it has to be.
#[derive(Debug)]
pub struct Opened<'a> {
    /// Where it is.
    pub path: &'a Path,
    bytes: Vec<u8>,
    /// Read up to the end of `bytes`.
    file: File,
    is_whole: bool,
}

impl<'a> Opened<'a> {
    /// The file at `path` with its first bytes.
    ///
    /// # Errors
    /// [`ReadError`] when it cannot be read.
    pub fn open(path: &'a Path) -> Result<Self, ReadError> {
        let mut file = crate::input::open_input(path)?;
        let mut bytes = Vec::new();
        file.by_ref()
            .take(HEAD as u64)
            .read_to_end(&mut bytes)
            .map_err(|error| ReadError::io(path, &error))?;
        Ok(Self {
            path,
            bytes,
            file,
            is_whole: false,
        })
    }

    /// The first bytes.
    #[must_use]
    pub fn head(&self) -> &[u8] {
        &self.bytes[..self.bytes.len().min(HEAD)]
    }

    /// All bytes.
    ///
    /// # Errors
    /// [`ReadError`] when they cannot be read.
    pub fn bytes(&mut self) -> Result<&[u8], ReadError> {
        if !self.is_whole {
            let read = self.file.read_to_end(&mut self.bytes);
            read.map_err(|error| ReadError::io(self.path, &error))?;
            self.is_whole = true;
        }
        Ok(&self.bytes)
    }

    /// All bytes, which the caller drops as soon as their content is known; they are read again where they are asked for again.
    ///
    /// # Errors
    /// [`ReadError`] when they cannot be read.
    pub(crate) fn take_bytes(&mut self) -> Result<Vec<u8>, ReadError> {
        self.bytes()?;
        let head = self.head().to_vec();
        self.file
            .seek(SeekFrom::Start(head.len() as u64))
            .map_err(|error| ReadError::io(self.path, &error))?;
        self.is_whole = false;
        Ok(std::mem::replace(&mut self.bytes, head))
    }
}

/// The first format of `table` that recognises this file.
///
/// # Errors
/// [`ReadError`] when it cannot be read.
pub fn recognise<'t, K, R>(
    table: &'t [Format<K, R>],
    file: &mut Opened<'_>,
) -> Result<Option<&'t Format<K, R>>, ReadError> {
    for format in table {
        let known = match format.sniff {
            Recognition::Head(sniff) => sniff(file.head()),
            Recognition::Whole(sniff) => sniff(file.path, file.bytes()?),
        };
        if known {
            return Ok(Some(format));
        }
    }
    Ok(None)
}

/// The first format of `table` whose file `bytes` are.
#[must_use]
pub fn recognise_bytes<'t, K, R>(
    table: &'t [Format<K, R>],
    path: &Path,
    bytes: &[u8],
) -> Option<&'t Format<K, R>> {
    table.iter().find(|format| match format.sniff {
        Recognition::Head(sniff) => sniff(&bytes[..bytes.len().min(HEAD)]),
        Recognition::Whole(sniff) => sniff(path, bytes),
    })
}

/// The format of `table` with the ending of `path`.
#[must_use]
pub fn of_ending<'t, K, R>(table: &'t [Format<K, R>], path: &Path) -> Option<&'t Format<K, R>> {
    let ending = path.extension()?.to_str()?.to_ascii_lowercase();
    table
        .iter()
        .find(|format| format.endings.contains(&ending.as_str()))
}

/// The names of the formats of `table` that can be read, with `last` before the last: `WAV, MAT or CSV`.
#[must_use]
pub fn list<K, R>(table: &[Format<K, R>], last: &str) -> String {
    let labels: Vec<&str> = table
        .iter()
        .map(|format| format.label)
        .filter(|label| !label.is_empty())
        .collect();
    match labels.as_slice() {
        [] => String::new(),
        [only] => (*only).to_owned(),
        [others @ .., end] => format!("{}{last}{end}", others.join(", ")),
    }
}
