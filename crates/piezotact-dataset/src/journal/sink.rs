//! The journal as a sink of the documents of runs.

use std::path::{Path, PathBuf};

use piezotact::recording::Recording;
use piezotact::run::{Ended, Judged, RunDocument, RunEnd, RunStart, Sink, SinkError};

use super::{JournalWriter, StartDocument};
use crate::error::{ReadError, WriteError};
use crate::recording_file::Stored;
use crate::sidecar::Rendering;

/// Keeps one run as the recording at a path: a journal while it runs, a Parquet file when it ends, however it ends.
#[derive(Debug)]
pub struct JournalSink {
    path: PathBuf,
    rendering: Option<Rendering>,
    writer: Option<JournalWriter>,
    moved: Vec<PathBuf>,
}

impl JournalSink {
    /// A sink for the recording at `path`, of a drive that was made as `rendering` says.
    #[must_use]
    pub fn new(path: &Path, rendering: Option<Rendering>) -> Self {
        Self {
            path: path.into(),
            rendering,
            writer: None,
            moved: Vec::new(),
        }
    }

    /// Where recordings and journals of the same name that were there before are kept now.
    #[must_use]
    pub fn moved(&self) -> &[PathBuf] {
        &self.moved
    }

    fn end(&mut self, end: &RunEnd) -> Result<(), WriteError> {
        let Some(writer) = self.writer.take() else {
            return Ok(());
        };
        let provenance = end.provenance.clone();
        let kept = writer.finish_as(provenance, end.doubts.clone(), Some(end.ended.clone()))?;
        self.moved.extend(kept);
        Ok(())
    }
}

impl Sink for JournalSink {
    fn take(&mut self, document: &RunDocument) -> Result<Option<Judged>, SinkError> {
        match document {
            RunDocument::Start(start) => {
                let start = StartDocument::of(start, self.rendering.take());
                let writer = JournalWriter::create(&self.path, start)?;
                self.moved.extend(writer.set_aside().map(Path::to_owned));
                self.writer = Some(writer);
            }
            RunDocument::Chunk(chunk) => {
                if let Some(writer) = &mut self.writer {
                    writer.append_chunk(chunk)?;
                }
            }
            RunDocument::Judged(judged) => {
                if let Some(writer) = &mut self.writer {
                    writer.append_judged(judged)?;
                }
            }
            RunDocument::End(end) => self.end(end)?,
        }
        Ok(None)
    }
}

/// A folder in which every run of a procedure is kept, one recording each, so that a procedure that was interrupted goes on
/// with what it has.
#[derive(Clone, Debug)]
pub struct RunFolder {
    path: PathBuf,
}

impl RunFolder {
    /// The folder at `path`; it is made with its first run.
    #[must_use]
    pub fn new(path: &Path) -> Self {
        Self { path: path.into() }
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The recording of the run that begins with `start`.
    #[must_use]
    pub fn file(&self, start: &RunStart) -> PathBuf {
        let person = start.condition.person().unwrap_or_default();
        let mut name = String::new();
        for c in format!("{person} {}", start.label).trim().chars() {
            match c {
                c if c.is_alphanumeric() || c == '.' => name.push(c),
                _ if name.ends_with('-') => {}
                _ => name.push('-'),
            }
        }
        // File systems allow 255 bytes, and a character has up to four.
        let name: String = name.trim_matches('-').chars().take(50).collect();
        let sum = crate::journal::fingerprint_of(&format!("{person}\n{}", start.label)) as u32;
        self.path.join(format!("{name}-{sum:08x}.parquet"))
    }

    /// The recording of a run with this start, if one was completed: same label, channels, rate, condition, device, bench and drive.
    ///
    /// # Errors
    /// [`ReadError`] when what stands there is damaged.
    pub fn completed(&self, start: &RunStart) -> Result<Option<Recording>, ReadError> {
        let file = self.file(start);
        if !file.is_file() {
            return Ok(None);
        }
        let (
            Stored {
                recording, setup, ..
            },
            stored,
            end,
        ) = crate::recording_file::read_parquet_whole(&file)?;
        let same = stored.label.as_deref() == Some(&start.label)
            && stored.drive == start.drive
            && stored.channels == start.channels
            && stored.rate_hz == start.rate_hz
            && stored.condition == start.condition
            && setup == start.setup
            && stored.provenance.source == start.provenance.source
            && stored.provenance.seed == start.provenance.seed
            && stored.provenance.answered_with == start.provenance.answered_with;
        let completed = end.is_some_and(|end| end.ended == Some(Ended::Completed));
        Ok((same && completed).then_some(recording))
    }

    /// What keeps the run that begins with `start`.
    ///
    /// # Errors
    /// [`WriteError::Io`] when the folder cannot be made.
    pub fn sink(&self, start: &RunStart) -> Result<JournalSink, WriteError> {
        std::fs::create_dir_all(&self.path).map_err(WriteError::io(&self.path))?;
        Ok(JournalSink::new(&self.file(start), None))
    }

    /// Puts the folder aside under the first free `NAME.before-N`, where it is there.
    ///
    /// # Errors
    /// [`WriteError::Io`] when the operating system refuses.
    pub fn set_aside(&self) -> Result<Option<PathBuf>, WriteError> {
        if !self.path.is_dir() {
            return Ok(None);
        }
        let aside = (1..)
            .map(|number: u32| {
                let mut name = self.path.as_os_str().to_owned();
                name.push(format!(".before-{number}"));
                PathBuf::from(name)
            })
            .find(|candidate| !candidate.exists());
        if let Some(aside) = &aside {
            std::fs::rename(&self.path, aside).map_err(WriteError::io(&self.path))?;
        }
        Ok(aside)
    }

    /// Removes the folder with all its runs, on purpose.
    ///
    /// # Errors
    /// [`WriteError::Io`] when the operating system refuses.
    pub fn discard(&self) -> Result<(), WriteError> {
        if self.path.is_dir() {
            std::fs::remove_dir_all(&self.path).map_err(WriteError::io(&self.path))?;
        }
        Ok(())
    }
}
