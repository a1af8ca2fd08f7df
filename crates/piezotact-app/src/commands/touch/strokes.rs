//! `piezotact strokes`: recordings cut into strokes, and what the strokes hold.

use std::path::Path;

use piezotact::study::{AnalysisDocument, CutsDocument, Question};

use super::large::Cut;
use super::{analysed, cuts, settings, take_all};
use crate::cli::{By, Strokes};
use crate::deliver::deliver_and;
use crate::failure::{Failures, Outcome};

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
