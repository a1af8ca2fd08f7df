//! `piezotact strokes`: recordings cut into strokes, and what the strokes hold.

use std::path::Path;

use piezotact::study::{AnalysisDocument, CutsDocument, Question};

use super::{analysed, cuts, settings, take_all};
use crate::cli::{By, Strokes};
use crate::deliver::deliver_and;
use crate::failure::Outcome;

pub(crate) fn run(args: &Strokes) -> Outcome {
    cuts::check(args)?;
    let outputs = &args.computing.outputs;
    let question = Question::Groups(args.by.as_ref().map(By::factor));
    let settings = settings(&args.computing, question)?;
    let (takes, failures) = take_all(&args.takes)?;
    cuts::write(args, &takes)?;
    let written: Vec<&Path> = args.write_cuts.as_deref().into_iter().collect();
    if args.cuts_only {
        let document = CutsDocument::of(&takes, failures.files());
        deliver_and(outputs, &document, &written)?;
        return failures.outcome();
    }
    let study = analysed(takes, args.by.as_ref(), &failures, &settings)?;
    deliver_and(outputs, &AnalysisDocument::of(&study), &written)?;
    failures.outcome()
}
