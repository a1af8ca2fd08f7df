//! Several renderings in one go: what was rendered, what was refused, and what did not come to its end.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use piezotact::page::Shown as _;
use piezotact_bench::ProcedureError;
use piezotact_bench::document::{RefusedRendering, RenderBatchDocument, RenderedTextures};
use serde_json::Value;

use super::{Done, Job, folder_of};
use crate::cli::Render;
use crate::deliver::{deliver_and, write};
use crate::failure::{Failure, Outcome, sentence};
use crate::keeping::{self, Raw};
use crate::output::say;

/// The jobs of a command, as they are done.
pub(super) struct Batch<'a> {
    args: &'a Render,
    jobs: &'a [Job<'a>],
    /// Of several what was rendered and what was refused; of one its drive.
    all: RenderBatchDocument<Value>,
    only: Option<Done>,
    /// The drives that are written.
    written: Vec<PathBuf>,
    /// What is said of closed loops that did not come to their end.
    unfinished: Vec<String>,
    begun: usize,
}

impl<'a> Batch<'a> {
    pub(super) fn new(args: &'a Render, jobs: &'a [Job<'a>]) -> Self {
        Self {
            args,
            jobs,
            all: RenderBatchDocument {
                renderings: Vec::new(),
                refused: Vec::new(),
                shown: RenderedTextures::of(args.band, jobs.len()),
            },
            only: None,
            written: Vec::new(),
            unfinished: Vec::new(),
            begun: 0,
        }
    }

    fn is_several(&self) -> bool {
        self.jobs.len() > 1
    }

    /// Does `job`. What is wrong with one texture or person is not wrong with the next.
    pub(super) fn add(&mut self, job: &Job<'_>) -> Outcome {
        self.begun += 1;
        if self.is_several() {
            say(&format!("{}:", job.called));
        }
        match job.done(self.args) {
            Ok(done) => self.take(job, done)?,
            Err(Failure::Data(error) | Failure::Usage(error)) if self.is_several() => {
                self.refuse(job, &error);
            }
            Err(Failure::Data(error)) if continues(&error) => {
                return Err(Failure::Data(anyhow!(
                    "{}; {}",
                    sentence(&error),
                    self.continued()
                )));
            }
            Err(failure) => return Err(failure),
        }
        // After every one: an interrupted run leaves the report of what is done.
        match self.is_several() {
            true => write(&self.args.outputs, &self.all.page()),
            false => Ok(()),
        }
    }

    fn take(&mut self, job: &Job<'_>, done: Done) -> Outcome {
        self.written.push(done.out.clone());
        if let Some(said) = done.unfinished() {
            let kept = format!("{said}; {} holds the best drive so far", job.out.display());
            if self.is_several() {
                say(&format!("error: {kept}"));
            }
            self.unfinished.push(kept);
        }
        if self.is_several() {
            let document = done.document(job, self.args);
            self.all.renderings.push(serde_json::to_value(&document)?);
            self.all.shown.add(&document);
        } else {
            self.only = Some(done);
        }
        Ok(())
    }

    fn refuse(&mut self, job: &Job<'_>, error: &anyhow::Error) {
        let why = sentence(error);
        say(&format!("error: {why}"));
        if continues(error) {
            self.unfinished.push(why.clone());
        }
        self.all.shown.refuse(&job.called, &why);
        self.all.refused.push(RefusedRendering {
            called: job.called.clone(),
            target: job.target.to_owned(),
            transfer: job.transfer.to_owned(),
            why,
        });
    }

    /// Discards or keeps the measurements when all is done. One that was broken off goes on with them.
    pub(super) fn tidy(&self) -> Outcome {
        if !self.unfinished.is_empty() || self.begun < self.jobs.len() {
            return Ok(());
        }
        for runs in self.jobs.iter().filter_map(|job| job.runs.as_ref()) {
            let raw = if self.args.discard_raw {
                Raw::Discarded
            } else {
                Raw::Kept
            };
            keeping::done(runs, raw)?;
        }
        Ok(())
    }

    /// Hands out what was rendered.
    pub(super) fn deliver(&self) -> Outcome {
        let outputs = &self.args.outputs;
        let written: Vec<&Path> = self.written.iter().map(PathBuf::as_path).collect();
        match (&self.only, self.jobs) {
            (Some(only), [job]) => deliver_and(outputs, &only.document(job, self.args), &written),
            _ => deliver_and(outputs, &self.all, &written),
        }
    }

    /// Whether all was done.
    pub(super) fn outcome(&self) -> Outcome {
        let all = self.jobs.len();
        if let ([kept], false) = (self.unfinished.as_slice(), self.is_several()) {
            return Err(Failure::Data(anyhow!("{kept}; {}", self.continued())));
        }
        if self.begun < all {
            return Err(Failure::Data(anyhow!(
                "stopped by hand: {} of {all} were rendered; {}",
                self.written.len(),
                self.continued()
            )));
        }
        if !self.unfinished.is_empty() {
            return Err(Failure::Data(anyhow!(
                "{} of {all} were not completed; {}",
                self.unfinished.len(),
                self.continued()
            )));
        }
        match self.all.refused.len() {
            0 => Ok(()),
            some if some == all => Err(Failure::Data(anyhow!("none of {all} could be rendered"))),
            some => Err(Failure::Data(anyhow!(
                "{some} of {all} could not be rendered; the others were written"
            ))),
        }
    }

    /// How to go on where not all was done: with the measurements of closed loops, and where they are kept.
    fn continued(&self) -> String {
        let mut kept = self.jobs.iter().filter_map(|job| job.runs.as_ref());
        let kept = kept.find(|runs| runs.is_interrupted());
        let kept = kept.map(|runs| match self.jobs.len() {
            1 => format!(", which are kept in {}", runs.path().display()),
            _ => format!(
                ", which are kept in the folders *.runs of {}",
                folder_of(runs.path()).display()
            ),
        });
        if self.jobs.iter().all(|job| job.runs.is_none()) {
            return match self.written.len() {
                0 => "nothing was written; give the same command again".into(),
                _ => {
                    "their drives are written; give the same command again to render the others too"
                        .into()
                }
            };
        }
        format!(
            "give the same command again to continue with the measurements made so far{}",
            kept.unwrap_or_default()
        )
    }
}

/// Whether the same command continues with what was measured before this error.
fn continues(error: &anyhow::Error) -> bool {
    error
        .downcast_ref::<ProcedureError>()
        .is_some_and(ProcedureError::continues)
}
