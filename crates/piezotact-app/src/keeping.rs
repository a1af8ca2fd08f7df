//! Where the runs on a bench are kept, with their progress shown, and how Ctrl-C stops them.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, Once, PoisonError};

use indicatif::ProgressBar;
use piezotact::quantity::Seconds;
use piezotact::recording::Recording;
use piezotact::run::{Judged, RunDocument, RunStart, Sink, SinkError};
use piezotact_bench::StopHandle;
use piezotact_bench::procedure::RunKeeper;
use piezotact_dataset::sidecar::Rendering;
use piezotact_dataset::{JournalSink, RunFolder};

use crate::failure::Outcome;
use crate::output::{progress, say};

/// Where runs are kept.
pub(crate) enum Place<'a> {
    /// Nowhere.
    Nowhere,
    /// One run, as the recording at a path.
    File(&'a Path, Option<Box<Rendering>>),
    /// Each run as the recording at a path of its own.
    Named(&'a dyn Fn(&RunStart) -> PathBuf),
    /// Each run in a folder; those that an interrupted procedure has completed are not measured again.
    Continued(RunFolder),
}

/// Keeps runs and shows their progress.
pub(crate) struct Keeper<'a> {
    place: Place<'a>,
    shown: Shown<'a>,
    /// How many runs were there already.
    pub(crate) reused: usize,
    /// The files of the runs that were recorded or taken, where each has one of a folder.
    pub(crate) files: Vec<PathBuf>,
}

/// How the progress of runs is shown.
pub(crate) enum Shown<'a> {
    /// Not at all.
    Nothing,
    /// Each run with a bar of its own: what it says, and how long the drive is.
    Each(&'a dyn Fn(&RunStart) -> String, Seconds),
    /// All runs on one bar.
    Together(&'a ProgressBar),
}

impl<'a> Keeper<'a> {
    /// Runs kept at `place`, shown as `shown` says.
    pub(crate) fn new(place: Place<'a>, shown: Shown<'a>) -> Self {
        Self {
            place,
            shown,
            reused: 0,
            files: Vec::new(),
        }
    }
}

impl RunKeeper for Keeper<'_> {
    fn completed(&mut self, start: &RunStart) -> Result<Option<Recording>, SinkError> {
        let Place::Continued(folder) = &self.place else {
            return Ok(None);
        };
        // What cannot be read is measured again, and kept beside the new one.
        let found = folder.completed(start).unwrap_or_default();
        if found.is_some() {
            self.reused += 1;
            self.files.push(folder.file(start));
        }
        Ok(found)
    }

    fn sink(&mut self, start: &RunStart) -> Result<Box<dyn Sink + '_>, SinkError> {
        let journal = match &mut self.place {
            Place::Nowhere => None,
            Place::File(path, rendering) => {
                Some(JournalSink::new(path, rendering.take().map(|made| *made)))
            }
            Place::Named(path_of) => Some(JournalSink::new(&path_of(start), None)),
            Place::Continued(folder) => {
                self.files.push(folder.file(start));
                Some(folder.sink(start)?)
            }
        };
        let (bar, own) = match &self.shown {
            Shown::Nothing => (ProgressBar::hidden(), false),
            Shown::Each(what, length) => (progress(&what(start), *length), true),
            Shown::Together(bar) => ((*bar).clone(), false),
        };
        Ok(Box::new(Kept {
            journal,
            bar,
            own,
            rate_hz: start.rate_hz.hz(),
        }))
    }
}

/// One run that is kept and shown.
struct Kept {
    journal: Option<JournalSink>,
    bar: ProgressBar,
    /// Whether the bar is of this run alone.
    own: bool,
    rate_hz: f64,
}

impl Sink for Kept {
    fn take(&mut self, document: &RunDocument) -> Result<Option<Judged>, SinkError> {
        if let Some(journal) = &mut self.journal {
            journal.take(document)?;
        }
        match document {
            RunDocument::Start(_) => {
                if let Some(journal) = &mut self.journal {
                    say_moved(journal);
                }
            }
            RunDocument::Chunk(chunk) => {
                let tenths = chunk.len() as f64 / self.rate_hz * 10.0;
                self.bar.inc(tenths.round() as u64);
            }
            RunDocument::End(_) => {
                if self.own {
                    self.bar.finish_and_clear();
                }
                if let Some(journal) = &mut self.journal {
                    say_moved(journal);
                }
            }
            RunDocument::Judged(_) | RunDocument::Event(_) => {}
        }
        Ok(None)
    }
}

/// Says where what stood in the way of a recording is kept now, and what was removed of it.
pub(crate) fn say_moved(journal: &mut JournalSink) {
    let (moved, removed) = journal.take_moved();
    say_removed(removed);
    for moved in moved {
        say(&format!(
            "the recording of that name that was there is kept as {}",
            moved.display()
        ));
    }
}

/// Says how many half copies were removed.
fn say_removed(removed: usize) {
    if removed > 0 {
        say(&format!(
            "removed {removed} half copies that an interrupted command left; what it recorded is kept in its journal"
        ));
    }
}

/// The folder of the raw recordings behind `out`, `OUT.runs`, for this command alone.
pub(crate) fn runs_of(out: &Path) -> Outcome<RunFolder> {
    let mut name = out.as_os_str().to_owned();
    name.push(".runs");
    runs_in(Path::new(&name))
}

/// The folder of raw recordings at `path`, for this command alone, without what a killed one left half finished.
pub(crate) fn runs_in(path: &Path) -> Outcome<RunFolder> {
    let folder = RunFolder::take(path)?;
    say_removed(folder.clean());
    Ok(folder)
}

/// Goes on with the runs in `folder` where a procedure was interrupted. The runs of a procedure that came to its end are put aside:
/// what is measured today is not taken from before.
pub(crate) fn go_on(folder: &RunFolder) -> Outcome {
    if folder.is_interrupted() {
        say(&format!(
            "{}: goes on with the runs of an interrupted command; remove the folder to measure all of them again",
            folder.path().display()
        ));
    } else {
        folder.set_aside()?;
    }
    Ok(())
}

/// Says that the procedure with its runs in `folder` came to its end; they are kept, or discarded on purpose.
pub(crate) fn done(folder: &RunFolder, raw: Raw) -> Outcome {
    match raw {
        Raw::Discarded => folder.discard()?,
        Raw::Kept if folder.path().is_dir() => {
            piezotact_dataset::write_atomically(&folder.path().join(RunFolder::DONE), |_empty| {
                Ok(())
            })?;
        }
        Raw::Kept => {}
    }
    Ok(())
}

/// Whether the raw recordings of a procedure are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Raw {
    /// They are.
    Kept,
    /// They are thrown away on purpose.
    Discarded,
}

/// What Ctrl-C stops.
static RUNNING: Mutex<Option<StopHandle>> = Mutex::new(None);
/// Whether Ctrl-C came: what would run next is stopped too.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// Lets Ctrl-C stop what runs with `handle`: the run ends in order, and what was acquired is kept. A second Ctrl-C ends the
/// program at once.
pub(crate) fn stopped_by_interrupt(handle: &StopHandle) {
    static ONCE: Once = Once::new();
    let set = |handle: Option<StopHandle>| {
        *RUNNING.lock().unwrap_or_else(PoisonError::into_inner) = handle;
    };
    if INTERRUPTED.load(Ordering::SeqCst) {
        handle.stop();
        return;
    }
    set(Some(handle.clone()));
    ONCE.call_once(|| {
        let installed = ctrlc::set_handler(|| {
            INTERRUPTED.store(true, Ordering::SeqCst);
            let running = RUNNING
                .lock()
                .unwrap_or_else(PoisonError::into_inner)
                .take();
            match running {
                Some(handle) => handle.stop(),
                None => {
                    say(
                        "ended at once: what was acquired stands in its journal, which `piezotact info` reads by the name of the recording; the next command of that name keeps it and removes what is half written",
                    );
                    std::process::exit(130)
                }
            }
        });
        // Without a handler Ctrl-C ends the program, and the journal keeps what was acquired.
        if let Err(error) = installed {
            say(&format!("Ctrl-C cannot end a run in order: {error}"));
        }
    });
}
