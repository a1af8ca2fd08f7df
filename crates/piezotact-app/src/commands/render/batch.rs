//! Several renderings in one go: what was rendered, what was refused, and what did not come to its end.

use anyhow::anyhow;
use piezotact::document::Document;
use piezotact_bench::ProcedureError;
use piezotact_bench::document::{RefusedRendering, RenderBatchDocument};
use piezotact_report::rendering::Page;
use serde_json::Value;

use super::{Done, Job, folder_of};
use crate::advice::OptionWords;
use crate::cli::Render;
use crate::failure::{Failure, Outcome, sentence};
use crate::invocation::write_report;
use crate::keeping::{self, Raw};
use crate::output::{print, print_document, print_made, say};

/// The jobs of a command, as they are done.
pub(super) struct Batch<'a> {
    args: &'a Render,
    jobs: &'a [Job<'a>],
    page: Page,
    /// Of several the renderings in their document, of one its document.
    renderings: Vec<Value>,
    refused: Vec<RefusedRendering>,
    /// What is said of closed loops that did not come to their end.
    unfinished: Vec<String>,
    begun: usize,
}

impl<'a> Batch<'a> {
    pub(super) fn new(args: &'a Render, jobs: &'a [Job<'a>]) -> Self {
        Self {
            args,
            jobs,
            page: Page::of(args.band, jobs.len()),
            renderings: Vec::new(),
            refused: Vec::new(),
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
            Ok(done) => self.take(job, &done)?,
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
        match &self.args.report {
            Some(path) => write_report(path, &self.page.html()),
            None => Ok(()),
        }
    }

    fn take(&mut self, job: &Job<'_>, done: &Done) -> Outcome {
        let document = done.document(job, self.args);
        self.renderings.push(match self.is_several() {
            true => serde_json::to_value(&document)?,
            false => serde_json::to_value(Document::of(&document))?,
        });
        if !self.args.json {
            done.say()?;
        }
        let Some(corrected) = &done.corrected else {
            return Ok(());
        };
        let looped = &corrected.looped;
        if self.args.report.is_some() {
            let summary = looped.summary(&job.called, done.level_db, &done.drive);
            self.page.add(&summary, &OptionWords)?;
        }
        if let Some(said) = &looped.failed {
            let kept = format!("{said}; {} holds the best drive so far", job.out.display());
            if self.is_several() {
                say(&format!("error: {kept}"));
            }
            self.unfinished.push(kept);
        }
        Ok(())
    }

    fn refuse(&mut self, job: &Job<'_>, error: &anyhow::Error) {
        let why = sentence(error);
        say(&format!("error: {why}"));
        if continues(error) {
            self.unfinished.push(why.clone());
        }
        self.refused.push(RefusedRendering {
            called: job.called.clone(),
            target: job.target.to_owned(),
            transfer: job.transfer.to_owned(),
            why: why.clone(),
        });
        self.page.refuse(&job.called, why);
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

    /// Prints what was rendered as JSON, or where the report is.
    pub(super) fn print(&mut self) -> Outcome {
        if self.args.json {
            return match self.renderings.as_slice() {
                [only] if !self.is_several() => print_made(only.clone()),
                _ => print_document(&RenderBatchDocument {
                    renderings: self.renderings.clone(),
                    refused: self.refused.clone(),
                }),
            };
        }
        match &self.args.report {
            Some(path) => print(&format!("report: {}", path.display())),
            None => Ok(()),
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
                self.renderings.len(),
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
        match self.refused.len() {
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
            return match self.renderings.len() {
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
