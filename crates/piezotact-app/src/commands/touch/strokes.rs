//! `piezotact strokes`: recordings cut into strokes, and what the strokes hold.

use piezotact::study::{AnalysisDocument, Question};

use super::{analysed, cuts, settings, shown, take_all, wrote};
use crate::cli::Strokes;
use crate::failure::Outcome;
use crate::output::print_document;

pub(crate) fn run(args: &Strokes) -> Outcome {
    cuts::check(args)?;
    if args.cuts_only {
        return cuts::run(args);
    }
    let computing = &args.computing;
    let settings = settings(computing, Question::Groups(args.by.map(Into::into)))?;
    let (takes, failures) = take_all(&args.takes)?;
    cuts::write(args, &takes)?;
    let study = analysed(takes, &failures, &settings)?;
    shown(&study, computing, || {
        print_document(&AnalysisDocument::of(&study))
    })?;
    if !computing.json {
        wrote(&[&args.write_cuts])?;
    }
    failures.outcome()
}
