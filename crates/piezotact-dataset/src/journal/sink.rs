//! The journal as a sink of the documents of runs.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use piezotact::recording::Recording;
use piezotact::run::{Ended, Judged, RunDocument, RunEnd, RunStart, Sink, SinkError};

use super::writer::keep_before;
use super::{JournalWriter, StartDocument};
use crate::atomic::{UNFINISHED, remove_left_behind, write_atomically};
use crate::error::{ReadError, WriteError};
use crate::lock::{Lock, LockFile};
use crate::recording_file::Stored;
use crate::sidecar::Rendering;

/// Removes the journal of the completed `recording` in `file` that a kill between its end and the journal's removal left: nothing is
/// in it that is not in the recording. Another journal stays.
fn remove_journal_of(file: &Path, recording: &Recording) {
    let journal = super::journal_path(file);
    let left = journal
        .is_file()
        .then(|| super::read::read_run_journal(&journal));
    if left.is_some_and(|left| {
        left.is_ok_and(|left| left.recording.channels() == recording.channels())
    }) {
        // One that stays is removed by the next command.
        let _stays = std::fs::remove_file(&journal);
    }
}

/// Stores one run as the recording at a path: a journal while it runs, a Parquet file at its end, whether completed or not; no
/// file if an interrupted run has no samples.
#[derive(Debug)]
pub struct JournalSink {
    path: PathBuf,
    rendering: Option<Rendering>,
    writer: Option<JournalWriter>,
    moved: Vec<PathBuf>,
    removed: usize,
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
            removed: 0,
        }
    }

    /// Where recordings and journals of the same name that were there before are kept now, and how many half copies of them were
    /// removed, since this was asked last.
    pub fn take_renamed(&mut self) -> (Vec<PathBuf>, usize) {
        (
            std::mem::take(&mut self.moved),
            std::mem::take(&mut self.removed),
        )
    }

    fn end(&mut self, end: &RunEnd) -> Result<(), WriteError> {
        let Some(writer) = self.writer.take() else {
            return Ok(());
        };
        // An interrupted run of which nothing was acquired is no recording.
        if end.samples == 0 && end.ended != Ended::Completed {
            return writer.discard_empty();
        }
        let provenance = end.provenance.clone();
        let warnings = end.all_warnings(writer.rate());
        let kept = writer.finish_as(provenance, warnings, Some(end.ended.clone()))?;
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
                self.moved.extend(writer.set_aside().iter().cloned());
                self.removed = writer.removed();
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
            RunDocument::Event(event) => {
                if let Some(writer) = &mut self.writer {
                    writer.append_event(event)?;
                }
            }
            RunDocument::End(end) => self.end(end)?,
        }
        Ok(None)
    }
}

/// A folder with the runs of one procedure, one recording each, from which an interrupted procedure can be resumed. It belongs to
/// one procedure at a time.
#[derive(Clone, Debug)]
pub struct RunFolder {
    path: PathBuf,
    /// What the file that says what the runs are for holds.
    purpose: Option<String>,
    _lock: Lock,
}

impl RunFolder {
    /// The file that says that the procedure came to its end.
    pub const DONE: &str = "done";
    /// The file that says what the runs are for.
    pub const PURPOSE: &str = "purpose";

    /// The folder at `path`, which is created with its first run. It is locked for other programs as long as this value or a
    /// clone of it exists: the file `NAME.lock` beside it is locked, and removed at the end. A lock file left by a killed
    /// program does not block.
    ///
    /// # Errors
    /// [`WriteError::Content`] when another procedure that still runs has it; [`WriteError::Io`] when nothing can be written beside it.
    pub fn take(path: &Path) -> Result<Self, WriteError> {
        let mut lock = path.as_os_str().to_owned();
        lock.push(".lock");
        let lock = Lock::take(Path::new(&lock), LockFile::Goes);
        let lock = lock.map_err(|error| error.about(path))?;
        Ok(Self {
            path: path.into(),
            purpose: None,
            _lock: lock,
        })
    }

    /// Whether there are runs of a procedure that did not come to its end.
    #[must_use]
    pub fn is_interrupted(&self) -> bool {
        self.path.is_dir() && !self.path.join(Self::DONE).exists()
    }

    /// The same folder for the runs of the procedure described by `purpose`, which is stored with its first run.
    #[must_use]
    pub fn for_purpose(&self, purpose: String) -> Self {
        Self {
            purpose: Some(purpose),
            ..self.clone()
        }
    }

    /// What the runs that are there are for; none where nothing says it.
    #[must_use]
    pub fn purpose(&self) -> Option<String> {
        std::fs::read_to_string(self.path.join(Self::PURPOSE)).ok()
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The recording of the run that begins with `start`.
    #[must_use]
    pub fn file(&self, start: &RunStart) -> PathBuf {
        let person = start.about.condition.person().unwrap_or_default();
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
            && stored.about.condition == start.about.condition
            && setup == start.setup
            && stored.about.provenance.source == start.about.provenance.source
            && stored.about.provenance.seed == start.about.provenance.seed
            && stored.about.provenance.answered_with == start.about.provenance.answered_with
            // The steps that describe the bench and its settings; the calibration at rest follows them.
            && stored.about.provenance.steps.starts_with(&start.about.provenance.steps);
        let completed = end.is_some_and(|end| end.ended == Some(Ended::Completed));
        if !(same && completed) {
            return Ok(None);
        }
        remove_journal_of(&file, &recording);
        Ok(Some(recording))
    }

    /// What keeps the run that begins with `start`.
    ///
    /// # Errors
    /// [`WriteError::Io`] when the folder cannot be made.
    pub fn sink(&self, start: &RunStart) -> Result<JournalSink, WriteError> {
        std::fs::create_dir_all(&self.path).map_err(WriteError::io(&self.path))?;
        let says = self.path.join(Self::PURPOSE);
        if let (Some(purpose), false) = (&self.purpose, says.exists()) {
            write_atomically(&says, |out| {
                let written = out.write_all(purpose.as_bytes());
                written.map_err(WriteError::io(&says))
            })?;
        }
        Ok(JournalSink::new(&self.file(start), None))
    }

    /// Removes what a program that was killed has left unfinished in the folder: half copies of what journals hold. How many files
    /// that were.
    #[must_use = "somebody should be told"]
    pub fn clean(&self) -> usize {
        remove_left_behind(&self.path, UNFINISHED)
    }

    /// Renames the folder to the first free `NAME.before-N`, if it exists.
    ///
    /// # Errors
    /// [`WriteError::Io`] when the operating system refuses.
    pub fn set_aside(&self) -> Result<Option<PathBuf>, WriteError> {
        if !self.path.is_dir() {
            return Ok(None);
        }
        keep_before(&self.path)
    }

    /// Removes those `files` of the folder on request, and the folder where nothing else is in it. How many were
    /// removed, and how many recordings of other commands are left.
    ///
    /// # Errors
    /// [`WriteError::Io`] when the operating system refuses.
    pub fn discard_these(&self, files: &[PathBuf]) -> Result<(usize, usize), WriteError> {
        let mut removed = 0;
        for file in files.iter().filter(|file| file.is_file()) {
            std::fs::remove_file(file).map_err(WriteError::io(file))?;
            removed += 1;
        }
        if !self.path.is_dir() {
            return Ok((removed, 0));
        }
        let entries = std::fs::read_dir(&self.path).map_err(WriteError::io(&self.path))?;
        let left = entries.filter_map(Result::ok);
        let left = left.filter(|entry| is_run(&entry.path())).count();
        // What others have put there stays, and the folder with it.
        let _stays = std::fs::remove_dir(&self.path);
        Ok((removed, left))
    }

    /// Removes the runs of the folder on request, and the folder where nothing else is in it.
    ///
    /// # Errors
    /// [`WriteError::Io`] when the operating system refuses.
    pub fn discard(&self) -> Result<(), WriteError> {
        let io = || WriteError::io(&self.path);
        if !self.path.is_dir() {
            return Ok(());
        }
        let _on_purpose = self.clean();
        for entry in std::fs::read_dir(&self.path).map_err(io())? {
            let path = entry.map_err(io())?.path();
            if is_run(&path) {
                std::fs::remove_file(&path).map_err(WriteError::io(&path))?;
            }
        }
        // What others have put there stays, and the folder with it.
        let _stays = std::fs::remove_dir(&self.path);
        Ok(())
    }
}

/// Whether a file is called as the run of a folder: `NAME-0123abcd.parquet`, with what stands behind it while it is written
/// or kept beside another, what they are for, or the mark of a procedure that came to its end.
fn is_run(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let sum = name
        .split(".parquet")
        .next()
        .and_then(|stem| stem.rsplit('-').next());
    let is_sum = |sum: &str| sum.len() == 8 && sum.chars().all(|c| c.is_ascii_hexdigit());
    let ours = [RunFolder::DONE, RunFolder::PURPOSE];
    ours.contains(&name.as_ref()) || name.contains(".parquet") && sum.is_some_and(is_sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezotact::quantity::{SampleRate, Unit};
    use piezotact::recording::{About, Annotations, Condition, Provenance};
    use piezotact::run::RunChunk;

    fn start() -> RunStart {
        RunStart {
            label: "iteration 1, first".into(),
            rate_hz: SampleRate::new(100.0).unwrap(),
            channels: vec![("acc".into(), Unit::MetrePerSecondSquared)],
            about: About::new(
                Condition::default(),
                Provenance::default().then("a resonance at 180 Hz"),
            ),
            annotations: Annotations::default(),
            clocks: Vec::new(),
            setup: None,
            drive: None,
            expected_s: None,
        }
    }

    /// A run is taken for measured only where everything that is known before it is the same.
    #[test]
    fn a_run_is_continued_with_what_is_its_own() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("out.runs");
        let runs = RunFolder::take(&path).unwrap();
        let second = RunFolder::take(&path).unwrap_err().to_string();
        assert!(
            second.contains("still writing to it; wait until it has finished"),
            "{second}"
        );
        let keep = |ended: Ended| {
            let mut sink = runs.sink(&start()).unwrap();
            let chunk = RunChunk {
                channels: vec![vec![1.0, 2.0]],
                ..RunChunk::default()
            };
            let end = RunEnd {
                samples: 2,
                ended,
                provenance: start().about.provenance.then("sensors at rest: none"),
                warnings: Vec::new(),
            };
            for document in [
                RunDocument::Start(Box::new(start())),
                RunDocument::Chunk(chunk),
                RunDocument::End(Box::new(end)),
            ] {
                sink.take(&document).unwrap();
            }
        };
        assert_eq!(runs.completed(&start()).unwrap(), None);
        keep(Ended::Stopped);
        assert_eq!(runs.completed(&start()).unwrap(), None, "it was stopped");
        keep(Ended::Completed);
        let found = runs.completed(&start()).unwrap().unwrap();
        assert_eq!(found.channels()[0].samples, [1.0, 2.0]);
        // A kill before its removal leaves the journal of what is complete; that of something else is not ours to remove.
        let journal = super::super::journal_path(&runs.file(&start()));
        for (samples, stays) in [(vec![1.0, 2.0], false), (vec![1.0, 3.0], true)] {
            let aside = folder.path().join("aside.parquet");
            let mut sink = JournalSink::new(&aside, None);
            let chunk = RunChunk {
                channels: vec![samples],
                ..RunChunk::default()
            };
            for document in [
                RunDocument::Start(Box::new(start())),
                RunDocument::Chunk(chunk),
            ] {
                sink.take(&document).unwrap();
            }
            std::fs::copy(super::super::journal_path(&aside), &journal).unwrap();
            drop(sink);
            assert!(runs.completed(&start()).unwrap().is_some());
            assert_eq!(journal.exists(), stays);
        }
        std::fs::remove_file(&journal).unwrap();
        for left in std::fs::read_dir(folder.path()).unwrap() {
            let left = left.unwrap().path();
            if left.to_string_lossy().contains("aside") {
                std::fs::remove_file(left).unwrap();
            }
        }
        let mut others = [start(), start(), start(), start()];
        others[0].label = "iteration 1, second".into();
        others[1].about.provenance = Provenance::default().then("a resonance at 200 Hz");
        others[2].drive = Some(piezotact::checksum::Checksum::of([1.0]));
        others[3].about.condition.participant = Some("P02".into());
        for other in others {
            assert_eq!(runs.completed(&other).unwrap(), None, "{other:?}");
        }
        // What is not ours is not thrown away.
        let notes = runs.path().join("notes.txt");
        std::fs::write(&notes, "mine").unwrap();
        runs.discard().unwrap();
        let left: Vec<_> = std::fs::read_dir(runs.path()).unwrap().collect();
        assert!(left.len() == 1 && notes.exists());
        std::fs::remove_file(&notes).unwrap();
        runs.discard().unwrap();
        assert!(!runs.path().exists());
        drop(runs);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
