//! `piezotact strokes`: recordings cut into strokes, and what the strokes hold.

use std::path::Path;

use piezotact::page::Shown;
use piezotact::study::{AnalysedRecording, AnalysisDocument, CutsDocument, Question};

use super::large::Cut;
use super::{analysed, cuts, settings, take_all};
use crate::cli::{By, Strokes};
use crate::deliver::{Outputs, deliver_and, write};
use crate::failure::{Failures, Outcome};
use crate::output::say;

pub(crate) fn run(args: &Strokes) -> Outcome {
    cuts::check(args)?;
    let outputs = &args.computing.outputs;
    let question = Question::Groups(args.by.as_ref().map(By::factor));
    let settings = settings(&args.computing, question)?;
    let large = Cut::of(&args.takes)?;
    let (takes, failures) = match &large {
        Some(large) => (vec![large.take()], Failures::of(1)),
        None => take_all(&args.takes)?,
    };
    cuts::write(args, &takes)?;
    let written: Vec<&Path> = args.write_cuts.as_deref().into_iter().collect();
    if args.cuts_only {
        let document = CutsDocument::of(&takes, failures.files());
        deliver_and(outputs, &document, &written)?;
        return failures.outcome();
    }
    if takes.iter().all(has_no_stroke) && large.is_none() {
        report_cuts(args, &takes, &failures)?;
    }
    let by = args.by.as_ref();
    let study = match large {
        Some(large) => {
            drop(takes);
            large.analysed(by, &settings)?
        }
        None => analysed(takes, by, &failures, &settings)?,
    };
    deliver_and(outputs, &AnalysisDocument::of(&study), &written)?;
    failures.outcome()
}

fn has_no_stroke(take: &AnalysedRecording) -> bool {
    take.segmentation.strokes.is_empty()
}

/// Writes what was rejected as the report that is asked for: no features come of it.
fn report_cuts(args: &Strokes, takes: &[AnalysedRecording], failures: &Failures) -> Outcome {
    let Some(report) = &args.computing.outputs.report else {
        return Ok(());
    };
    let page = CutsDocument::of(takes, failures.files()).page();
    let outputs = Outputs {
        report: Some(report.clone()),
        ..Outputs::default()
    };
    write(&outputs, &page)?;
    say(&format!("report: {}", report.display()));
    Ok(())
}
