//! The bytes of a TDMS file, read in order, each within a stated end.

use std::io::{BufRead as _, BufReader, Read, Seek, SeekFrom};
use std::path::Path;

use crate::error::ReadError;
use crate::stored::ByteOrder;

/// Bytes that are read at a time.
const BLOCK: usize = 1 << 18;
/// A longer name is no name.
const LONGEST_NAME: u64 = 1 << 16;
/// What to do about bytes that cannot be right.
pub(super) const DAMAGED: &str =
    "the file is damaged: copy it again, or export it again from the program that wrote it";

/// A file and where in it the next byte stands.
#[derive(Debug)]
pub(super) struct Source<'p, R> {
    pub(super) path: &'p Path,
    from: BufReader<R>,
    at: u64,
    /// The bytes of the file.
    pub(super) length: u64,
    /// Where the part that is read ends.
    pub(super) end: u64,
}

impl<'p, R: Read + Seek> Source<'p, R> {
    pub(super) fn new(path: &'p Path, mut from: R) -> Result<Self, ReadError> {
        let mut seek = |to| from.seek(to).map_err(|error| ReadError::io(path, &error));
        let length = seek(SeekFrom::End(0))?;
        seek(SeekFrom::Start(0))?;
        Ok(Self {
            path,
            from: BufReader::with_capacity(BLOCK, from),
            at: 0,
            length,
            end: length,
        })
    }

    pub(super) fn at(&self) -> u64 {
        self.at
    }

    /// The error that at `at` not what was `expected` was found.
    pub(super) fn wrong(
        &self,
        at: u64,
        expected: impl Into<String>,
        found: impl std::fmt::Display,
    ) -> ReadError {
        ReadError::content(
            self.path,
            expected,
            format!("{found} at byte {at}"),
            DAMAGED,
        )
    }

    /// Goes to `to`, a place within the file.
    pub(super) fn seek(&mut self, to: u64) -> Result<(), ReadError> {
        let by = i64::try_from(i128::from(to) - i128::from(self.at));
        let moved = match by {
            Ok(by) => self.from.seek_relative(by),
            Err(_) => self.from.seek(SeekFrom::Start(to)).map(drop),
        };
        moved.map_err(|error| ReadError::io(self.path, &error))?;
        self.at = to;
        Ok(())
    }

    /// The next bytes, which are `what`, before the end of the part that is read.
    pub(super) fn fill(&mut self, bytes: &mut [u8], what: &str) -> Result<(), ReadError> {
        let left = self.end.saturating_sub(self.at);
        if (bytes.len() as u64) > left {
            let found = format!("{left} bytes before the end of their part");
            return Err(self.wrong(self.at, format!("{} bytes of {what}", bytes.len()), found));
        }
        let read = self.from.read_exact(bytes);
        read.map_err(|error| ReadError::io(self.path, &error))?;
        self.at += bytes.len() as u64;
        Ok(())
    }

    /// A whole number of `N` bytes.
    pub(super) fn number<const N: usize>(
        &mut self,
        order: ByteOrder,
        what: &str,
    ) -> Result<u64, ReadError> {
        let mut bytes = [0; N];
        self.fill(&mut bytes, what)?;
        Ok(order.unsigned(&bytes))
    }

    /// A name: a length and as many bytes of text.
    pub(super) fn name(&mut self, order: ByteOrder, what: &str) -> Result<String, ReadError> {
        let at = self.at;
        match self.text(order, what)? {
            Some(text) => Ok(text),
            None => Err(self.wrong(
                at,
                format!("{what} of at most {LONGEST_NAME} bytes"),
                "a longer one",
            )),
        }
    }

    /// A text: a length and as many bytes; `None` where it is too long to be kept.
    pub(super) fn text(
        &mut self,
        order: ByteOrder,
        what: &str,
    ) -> Result<Option<String>, ReadError> {
        let at = self.at;
        let length = self.number::<4>(order, what)?;
        let left = self.end.saturating_sub(self.at);
        if length > left {
            let found = format!("a length of {length}, with {left} bytes before the end");
            return Err(self.wrong(at, format!("the length of {what}"), found));
        }
        if length > LONGEST_NAME {
            self.seek(self.at + length)?;
            return Ok(None);
        }
        let mut bytes = vec![0; length as usize];
        self.fill(&mut bytes, what)?;
        Ok(Some(String::from_utf8_lossy(&bytes).into_owned()))
    }

    /// Gives the `left` bytes that follow to `take` in blocks of whole rows of `width` bytes.
    pub(super) fn rows(
        &mut self,
        mut left: u64,
        width: usize,
        mut take: impl FnMut(&[u8]),
    ) -> Result<(), ReadError> {
        let mut row = Vec::new();
        while left > 0 {
            let held = self.from.fill_buf();
            let held = held.map_err(|error| ReadError::io(self.path, &error))?;
            let whole = (left.min(held.len() as u64)) as usize / width * width;
            if whole > 0 {
                take(&held[..whole]);
                self.from.consume(whole);
                self.at += whole as u64;
                left -= whole as u64;
            } else {
                // A row that does not lie in the buffer in one piece.
                row.resize(width, 0);
                self.fill(&mut row, "samples")?;
                take(&row);
                left = left.saturating_sub(width as u64);
            }
        }
        Ok(())
    }
}
