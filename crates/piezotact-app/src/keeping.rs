//! Where the runs on a bench are kept, with their progress shown.

use std::cell::Cell;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use anyhow::anyhow;
use indicatif::ProgressBar;
use piezotact::checksum::Checksum;
use piezotact::quantity::Seconds;
use piezotact::recording::{BenchKind, Recording, StartTime};
use piezotact::run::{Judged, RunDocument, RunStart, Sink, SinkError};
use piezotact_bench::ProcedureError;
use piezotact_bench::procedure::RunKeeper;
use piezotact_dataset::reads::found;
use piezotact_dataset::sidecar::{Rendering, sidecar_path};
use piezotact_dataset::{JournalSink, RunFolder, keep_before, stays_as_it_is};

use serde::{Deserialize, Serialize};

use crate::dashboard::{Counts, Dashboard};
use crate::failure::{Failure, Outcome, bench_failure};
use crate::interrupt::interrupted;
use crate::invocation;
use crate::live::Showing;
use crate::output::say;
use crate::progress;

/// An earlier measurement under the name of a new one. It is kept as `.before-N`, unless both have the same bytes.
pub(crate) struct Earlier {
    place: PathBuf,
    /// Where it is kept.
    kept: Option<PathBuf>,
    /// What it is, in words.
    said: &'static str,
}

impl Earlier {
    /// What stands at `place`, with its sidecar, kept under a free name; unless the same is to be written there again.
    pub(crate) fn at(place: &Path, said: &'static str) -> Outcome<Self> {
        let kept = if place.is_file() && !stays_as_it_is(place) {
            keep_before(place)?
        } else {
            None
        };
        if let Some(kept) = &kept
            && sidecar_path(place).is_file()
        {
            std::fs::rename(sidecar_path(place), sidecar_path(kept))?;
        }
        Ok(Self {
            place: place.to_owned(),
            kept,
            said,
        })
    }

    /// Says where it is kept, now that the new one is written; the same measurement is not kept twice.
    pub(crate) fn settle(mut self) -> Outcome {
        let Some(kept) = self.kept.take() else {
            return Ok(());
        };
        let same = |a: &Path, b: &Path| found(a) == found(b);
        if same(&self.place, &kept) && same(&sidecar_path(&self.place), &sidecar_path(&kept)) {
            std::fs::remove_file(&kept)?;
            if sidecar_path(&kept).is_file() {
                std::fs::remove_file(sidecar_path(&kept))?;
            }
            return Ok(());
        }
        let (place, kept) = (self.place.display(), kept.display());
        say(&format!("{place}: {} is kept as {kept}", self.said));
        Ok(())
    }

    /// Puts it back in the place of what was written there since, as what belongs to it was not.
    pub(crate) fn put_back(self) -> Outcome {
        let written = [self.place.clone(), sidecar_path(&self.place)];
        for path in written
            .iter()
            .filter(|path| self.kept.is_some() && path.is_file())
        {
            std::fs::remove_file(path)?;
        }
        Ok(())
    }
}

impl Drop for Earlier {
    /// Where no new one was written, the earlier one is put back.
    fn drop(&mut self) {
        let Some(kept) = self.kept.take().filter(|_| !self.place.exists()) else {
            return;
        };
        // Nothing is lost where this fails: it stays under its other name.
        let _stays = std::fs::rename(&kept, &self.place);
        let sidecars = [&kept, &self.place].map(|path| sidecar_path(path));
        if sidecars[0].is_file() {
            let _stays = std::fs::rename(&sidecars[0], &sidecars[1]);
        }
    }
}

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
    /// Where the last run is kept, and how many samples of it were acquired.
    last: Option<(PathBuf, Rc<Cell<u64>>)>,
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
            last: None,
        }
    }
}

impl Keeper<'_> {
    /// What an interrupted run leaves, in words, and no folder that holds nothing; none where nothing is kept.
    fn left(&self) -> Option<String> {
        let (path, samples) = self.last.as_ref()?;
        if samples.get() > 0 {
            return Some(format!(
                "the acquired samples are kept in {}",
                path.display()
            ));
        }
        if let Place::Continued(folder) = &self.place {
            // Only one that holds nothing goes.
            let _stays = std::fs::remove_dir(folder.path());
        }
        Some("nothing was acquired, and no file was written".into())
    }

    /// What went wrong in a procedure, with what an interrupted run leaves.
    pub(crate) fn failure(&self, error: ProcedureError) -> Failure {
        let kept = error.continues() && !matches!(error, ProcedureError::Keep(_));
        match self.left().filter(|_| kept) {
            Some(left) if interrupted() => {
                Failure::Data(anyhow!("{error}; {left}; give the same command again"))
            }
            Some(left) => Failure::Data(anyhow!("{error}; {left}")),
            None => bench_failure(error),
        }
    }
}

/// When a run on a bench of `kind` begins. What is simulated has no time of day, so that the same command gives the same bytes.
pub(crate) fn began(kind: BenchKind) -> Option<StartTime> {
    match kind {
        BenchKind::Hardware => invocation::now(),
        BenchKind::Twin | BenchKind::Measured | BenchKind::Scripted => None,
    }
}

impl RunKeeper for Keeper<'_> {
    fn now(&self, kind: BenchKind) -> Option<StartTime> {
        began(kind)
    }

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
        let path = match &self.place {
            Place::Nowhere => None,
            Place::File(path, _) => Some(path.to_path_buf()),
            Place::Named(path_of) => Some(path_of(start)),
            Place::Continued(folder) => Some(folder.file(start)),
        };
        let samples = Rc::default();
        self.last = path.clone().map(|path| (path, Rc::clone(&samples)));
        let journal = match (&mut self.place, path) {
            (Place::File(path, rendering), _) => {
                Some(JournalSink::new(path, rendering.take().map(|made| *made)))
            }
            (Place::Continued(folder), path) => {
                self.files.extend(path);
                Some(folder.sink(start)?)
            }
            (_, path) => path.map(|path| JournalSink::new(&path, None)),
        };
        let (bar, own) = match &self.shown {
            Shown::Nothing => (ProgressBar::hidden(), false),
            Shown::Each(what, length) => (progress::of_run(&what(start), Some(*length)), true),
            Shown::Together(bar) => ((*bar).clone(), false),
        };
        Ok(Box::new(Showing(Kept {
            journal,
            dashboard: Dashboard::new(&bar, Counts::Nothing),
            bar,
            own,
            samples,
            rate_hz: start.rate_hz.hz(),
        })))
    }
}

/// One run that is kept and shown.
struct Kept {
    journal: Option<JournalSink>,
    bar: ProgressBar,
    dashboard: Dashboard,
    /// Whether the bar is of this run alone.
    own: bool,
    /// How many samples were acquired.
    samples: Rc<Cell<u64>>,
    rate_hz: f64,
}

impl Sink for Kept {
    fn take(&mut self, document: &RunDocument) -> Result<Option<Judged>, SinkError> {
        if let Some(journal) = &mut self.journal {
            journal.take(document)?;
        }
        self.dashboard.take(document);
        match document {
            RunDocument::Start(_) => {
                if let Some(journal) = &mut self.journal {
                    say_moved(journal);
                }
            }
            RunDocument::Chunk(chunk) => {
                self.samples.set(self.samples.get() + chunk.len() as u64);
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
    let (moved, removed) = journal.take_renamed();
    say_removed(removed);
    for moved in moved {
        say(&format!(
            "the earlier recording of that name is kept as {}",
            moved.display()
        ));
    }
}

/// Says how many half copies were removed.
fn say_removed(removed: usize) {
    if removed > 0 {
        say(&format!(
            "removed {removed} incomplete copies left by an interrupted command; its recording is kept in its journal"
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

/// What the runs of a closed loop are for: they are taken for no other finger, texture or transfer function.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Purpose {
    pub(crate) participant: Option<String>,
    /// What the bench is and how it is set.
    pub(crate) bench: Vec<String>,
    pub(crate) target: Checksum,
    pub(crate) transfer: Checksum,
}

impl Purpose {
    /// What differs from the purpose that runs were begun for, in words; nothing where they are the same.
    fn differs_from(&self, begun: &Self) -> Vec<String> {
        let who = |purpose: &Self| {
            let known = purpose.participant.clone();
            known.unwrap_or_else(|| "an unnamed participant".into())
        };
        let differs = [
            (
                self.participant != begun.participant,
                format!("{}, now {}", who(begun), who(self)),
            ),
            (
                self.bench != begun.bench,
                "another bench or other settings of the bench".into(),
            ),
            (self.target != begun.target, "another target".into()),
            (
                self.transfer != begun.transfer,
                "another transfer function".into(),
            ),
        ];
        let differs = differs.into_iter().filter(|(differs, _)| *differs);
        differs.map(|(_, what)| what).collect()
    }
}

/// Goes on with the runs in `folder` where a closed loop for the same purpose was interrupted. Other runs are put aside: what is
/// measured today is not taken from before, nor from another finger. The folder that knows what its runs are for.
pub(crate) fn go_on(folder: &RunFolder, purpose: &Purpose) -> Outcome<RunFolder> {
    let path = folder.path().display();
    let aside = |why: &str| -> Outcome {
        if let Some(aside) = folder.set_aside()? {
            say(&format!(
                "{path}: {why}; its recordings are kept in {}, and everything is measured again",
                aside.display()
            ));
        }
        Ok(())
    };
    let begun = folder.purpose();
    // What says nothing is compared run by run.
    let begun = begun.and_then(|text| serde_json::from_str::<Purpose>(&text).ok());
    let differs = begun.map_or(Vec::new(), |begun| purpose.differs_from(&begun));
    if !folder.is_interrupted() {
        aside("it contains the runs of a completed closed loop")?;
    } else if differs.is_empty() {
        say(&format!(
            "{path}: continues with the runs of an interrupted command; remove the folder to repeat all measurements"
        ));
    } else {
        let differs = differs.join(" and ");
        aside(&format!("the interrupted closed loop was for {differs}"))?;
    }
    Ok(folder.for_purpose(serde_json::to_string_pretty(purpose)?))
}

/// Says that the procedure with its runs in `folder` was completed; they are kept, or discarded on request.
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
    /// They are discarded on request.
    Discarded,
}
