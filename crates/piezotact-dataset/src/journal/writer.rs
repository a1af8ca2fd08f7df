//! Writes the journal of a run, and converts it to the recording at the end.

use std::fs::{File, TryLockError};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use piezotact::Warning;
use piezotact::quantity::SampleRate;
use piezotact::recording::{Clock, Event, Provenance};
use piezotact::run::{Ended, Judged, RunChunk};

use super::frames::{Block, MAGIC, block_bytes};
use super::read::chunks_of;
use super::{EndDocument, Fingerprint, StartDocument, journal_path, write_parquet};
use crate::atomic::{led_to, remove_unfinished_of, sync_folder};
use crate::error::WriteError;

/// A recording that is being written.
pub struct JournalWriter {
    path: PathBuf,
    journal: PathBuf,
    start: StartDocument,
    /// Kept locked, so that no other program takes it for the leftover of an interrupted one.
    file: File,
    /// The number of the clock of each channel; all 0 where they share one.
    clock_of: Vec<usize>,
    samples: usize,
    events: Vec<Event>,
    fingerprints: Vec<Fingerprint>,
    set_aside: Vec<PathBuf>,
    removed: usize,
}

impl std::fmt::Debug for JournalWriter {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("JournalWriter")
            .field("path", &self.path)
            .field("samples", &self.samples)
            .finish_non_exhaustive()
    }
}

impl JournalWriter {
    /// Begins the recording at `path`: the start document is on the disk when this returns. The journal of a recording that was
    /// interrupted is kept beside it under a name of its own ([`Self::set_aside`]).
    ///
    /// # Errors
    /// [`WriteError::Content`] when a recording of that name is still running, or a folder stands there; [`WriteError::Io`] when the
    /// operating system refuses.
    pub fn create(path: &Path, start: StartDocument) -> Result<Self, WriteError> {
        let journal = journal_path(path);
        if path.is_dir() {
            return Err(WriteError::content(
                path,
                "the name of a file",
                "a folder",
                "give a file's name in it",
            ));
        }
        let mut aside: Vec<PathBuf> = set_aside(&journal, path)?.into_iter().collect();
        let side = side_path(path);
        // A recording that was interrupted while it was finished: its journal holds all of it.
        let mut removed = remove_unfinished_of(&side);
        if side.is_file() && aside.is_empty() {
            // Without the journal it is the only copy.
            aside.extend(keep_at_free(&side, |number| {
                set_aside_path(path, number).with_extension("parquet")
            })?);
        } else if side.is_file() {
            std::fs::remove_file(&side).map_err(WriteError::io(&side))?;
            removed += 1;
        }
        let file = File::options()
            .write(true)
            .create_new(true)
            .open(&journal)
            .map_err(WriteError::io(&journal))?;
        file.try_lock().map_err(|error| WriteError::Io {
            path: journal.clone(),
            source: error.into(),
        })?;
        let text = serde_json::to_string(&start).map_err(|error| WriteError::Io {
            path: path.into(),
            source: error.into(),
        })?;
        let fingerprints = vec![Fingerprint::new(); start.channels.len()];
        let mut clock_of = Clock::numbered(&start.clocks).1;
        clock_of.resize(start.channels.len(), 0);
        let mut writer = Self {
            clock_of,
            events: Vec::new(),
            path: path.into(),
            journal,
            start,
            file,
            samples: 0,
            fingerprints,
            set_aside: aside,
            removed,
        };
        let start = writer.bytes_of(&Block::Start(text))?;
        let mut bytes = MAGIC.to_vec();
        bytes.extend(&start);
        bytes.extend(&start);
        writer.put(&bytes)?;
        sync_folder(&writer.journal);
        Ok(writer)
    }

    /// Where the journal of an interrupted recording of the same name was put, if there was one.
    #[must_use]
    pub fn set_aside(&self) -> &[PathBuf] {
        &self.set_aside
    }

    /// How many half copies of what an interrupted recording of the same name holds were removed.
    #[must_use]
    pub fn removed(&self) -> usize {
        self.removed
    }

    /// Appends one chunk, a list of samples for each channel; it is on the disk when this returns.
    ///
    /// # Errors
    /// [`WriteError::Content`] when the chunk has other channels than the start document says, or lists of
    /// different length; [`WriteError::Io`] when the operating system refuses.
    pub fn append(&mut self, chunk: &[Vec<f64>]) -> Result<(), WriteError> {
        self.append_chunk(&RunChunk {
            first: self.samples as u64,
            channels: chunk.to_vec(),
            ..RunChunk::default()
        })
    }

    /// Appends one chunk of a run; it is on the disk when this returns.
    ///
    /// # Errors
    /// Those of [`Self::append`].
    pub fn append_chunk(&mut self, chunk: &RunChunk) -> Result<(), WriteError> {
        let frames = chunk.len();
        let expected = self.clock_of.iter();
        let expected = expected.filter(|clock| **clock == chunk.clock as usize);
        let expected = expected.count();
        if expected == 0
            || chunk.channels.len() != expected
            || chunk.channels.iter().any(|channel| channel.len() != frames)
        {
            return Err(WriteError::content(
                &self.path,
                format!("{expected} channels of equal length in every chunk"),
                format!("{}", chunk.channels.len()),
                "this is a fault of the bench: report it",
            ));
        }
        let bytes = self.bytes_of(&Block::Chunk(chunk.clone()))?;
        self.put(&bytes)?;
        if chunk.clock == 0 {
            self.samples += frames;
        }
        let of_clock = self.fingerprints.iter_mut().zip(&self.clock_of);
        let of_clock = of_clock
            .filter(|(_, clock)| **clock == chunk.clock as usize)
            .map(|(fingerprint, _)| fingerprint);
        for (fingerprint, channel) in of_clock.zip(&chunk.channels) {
            fingerprint.add(channel);
        }
        Ok(())
    }

    /// Appends what was judged of the run.
    ///
    /// # Errors
    /// [`WriteError::Io`] when the operating system refuses.
    pub fn append_judged(&mut self, judged: &Judged) -> Result<(), WriteError> {
        let bytes = self.bytes_of(&Block::Judged(judged.clone()))?;
        self.put(&bytes)
    }

    /// Appends something that happened; it is on the disk when this returns.
    ///
    /// # Errors
    /// [`WriteError::Io`] when the operating system refuses.
    pub fn append_event(&mut self, event: &Event) -> Result<(), WriteError> {
        let bytes = self.bytes_of(&Block::Event(event.clone()))?;
        self.put(&bytes)?;
        self.events.push(event.clone());
        Ok(())
    }

    /// Ends the recording: the journal becomes the Parquet file with the end document in it. A recording that
    /// stood there before is kept beside it under a name of its own, which is returned; the same bytes are not
    /// kept twice.
    ///
    /// # Errors
    /// [`WriteError`] when the Parquet file cannot be written; the journal then stays and can be read.
    pub fn finish(
        self,
        provenance: Provenance,
        warnings: Vec<Warning>,
    ) -> Result<Option<PathBuf>, WriteError> {
        self.finish_as(provenance, warnings, None)
    }

    /// As [`Self::finish`], with how the run ended.
    ///
    /// # Errors
    /// Those of [`Self::finish`].
    pub fn finish_as(
        mut self,
        provenance: Provenance,
        warnings: Vec<Warning>,
        ended: Option<Ended>,
    ) -> Result<Option<PathBuf>, WriteError> {
        // Provenance that became known during the run, such as the sensors' noise, is added to that of the start.
        self.start.about.provenance = provenance;
        let fingerprint = Some(Fingerprint::all(&self.fingerprints));
        let end = EndDocument {
            samples: self.samples,
            fingerprint,
            start_fingerprint: None,
            warnings,
            events: std::mem::take(&mut self.events),
            ended,
        };
        let text = serde_json::to_string(&(&self.start, &end)).map_err(|error| WriteError::Io {
            path: self.path.clone(),
            source: error.into(),
        })?;
        let bytes = self.bytes_of(&Block::End(text))?;
        self.put(&bytes)?;
        let journal = File::open(&self.journal).map_err(WriteError::io(&self.journal))?;
        let aside = side_path(&self.path);
        // A chunk grows the channels of its clock.
        let chunks = chunks_of(journal).map(|chunk| {
            let chunk = chunk?;
            let mut new = chunk.channels.into_iter();
            let of_clock = self.clock_of.iter().map(|clock| {
                let its_own = *clock == chunk.clock as usize;
                its_own.then(|| new.next()).flatten().unwrap_or_default()
            });
            Ok(of_clock.collect())
        });
        write_parquet(&aside, &self.start, &end, chunks)?;
        self.in_place(&aside)
    }

    /// Discards a recording without samples: its journal is removed, and an earlier recording of that name stays.
    ///
    /// # Errors
    /// [`WriteError::Io`] when the operating system refuses.
    pub fn discard_empty(self) -> Result<(), WriteError> {
        drop(self.file);
        std::fs::remove_file(&self.journal).map_err(WriteError::io(&self.journal))
    }

    /// The rate of the run.
    pub(super) fn rate(&self) -> SampleRate {
        self.start.rate_hz
    }

    /// Puts the finished file in its place, and takes the journal away.
    fn in_place(&self, aside: &Path) -> Result<Option<PathBuf>, WriteError> {
        let kept = keep_aside(&self.path, aside)?;
        // A link stays one, unless it leads to another disk.
        std::fs::rename(aside, led_to(&self.path))
            .or_else(|_| std::fs::rename(aside, &self.path))
            .map_err(WriteError::io(&self.path))?;
        // The recording is in its place on the disk before its journal goes.
        sync_folder(&self.path);
        std::fs::remove_file(&self.journal).map_err(WriteError::io(&self.journal))?;
        Ok(kept)
    }

    fn bytes_of(&self, block: &Block) -> Result<Vec<u8>, WriteError> {
        block_bytes(block).map_err(|error| WriteError::Io {
            path: self.journal.clone(),
            source: error.into(),
        })
    }

    fn put(&mut self, bytes: &[u8]) -> Result<(), WriteError> {
        self.file
            .write_all(bytes)
            .and_then(|()| self.file.sync_data())
            .map_err(WriteError::io(&self.journal))
    }
}

/// Where the journal of an interrupted recording at `path` is kept: `NAME.interrupted-N.part`.
#[must_use]
pub fn set_aside_path(path: &Path, number: u32) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(format!(".interrupted-{number}.part"));
    name.into()
}

/// Renames a file to the first of the names that is free.
fn keep_at_free(file: &Path, name: impl Fn(u32) -> PathBuf) -> Result<Option<PathBuf>, WriteError> {
    let free = (1..).map(name).find(|candidate| !candidate.exists());
    if let Some(free) = &free {
        std::fs::rename(file, free).map_err(WriteError::io(file))?;
    }
    Ok(free)
}

/// Renames the journal of an interrupted recording at `path` to the first free [`set_aside_path`].
fn set_aside(journal: &Path, path: &Path) -> Result<Option<PathBuf>, WriteError> {
    let Ok(file) = File::open(journal) else {
        return Ok(None);
    };
    match file.try_lock() {
        Ok(()) => {}
        Err(TryLockError::WouldBlock) => {
            return Err(WriteError::content(
                journal,
                "a name that no other recording is using",
                "the journal of a recording that is still running",
                "wait until it has finished, or give another name",
            ));
        }
        Err(TryLockError::Error(source)) => {
            return Err(WriteError::Io {
                path: journal.into(),
                source,
            });
        }
    }
    keep_at_free(journal, |number| set_aside_path(path, number))
}

/// The temporary name of a finished recording until an earlier one of the same name has been renamed: `NAME.whole`.
fn side_path(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".whole");
    name.into()
}

/// Renames what stands at `path` to the first free `NAME.before-N`, unless it is the same as `new`.
fn keep_aside(path: &Path, new: &Path) -> Result<Option<PathBuf>, WriteError> {
    if !path.is_file() || same_bytes(path, new).unwrap_or(false) {
        return Ok(None);
    }
    keep_before(path)
}

/// Renames what stands at `path`, or where a link at `path` leads to, to the first free `NAME.before-N`, which is returned: a link
/// that is renamed would lead to the new file.
///
/// # Errors
/// [`WriteError::Io`] when the operating system refuses.
pub fn keep_before(path: &Path) -> Result<Option<PathBuf>, WriteError> {
    let file = match path.is_symlink() {
        true => std::fs::canonicalize(path).map_err(WriteError::io(path))?,
        false => path.to_owned(),
    };
    let kept = keep_at_free(&file, |number| {
        let mut name = file.as_os_str().to_owned();
        name.push(format!(".before-{number}"));
        name.into()
    })?;
    if let Some(kept) = &kept {
        crate::reads::moved(path, kept);
    }
    Ok(kept)
}

fn same_bytes(a: &Path, b: &Path) -> std::io::Result<bool> {
    Ok(std::fs::metadata(a)?.len() == std::fs::metadata(b)?.len()
        && std::fs::read(a)? == std::fs::read(b)?)
}
