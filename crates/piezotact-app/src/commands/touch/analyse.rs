//! `piezotact analyse`: what the strokes of recordings hold.

use piezotact::study::{AnalysisDocument, Question};

use super::{analysed, check_outputs, settings, shown};
use crate::cli::Analyse;
use crate::failure::Outcome;
use crate::output::print_document;

pub(crate) fn run(args: &Analyse) -> Outcome {
    let computing = &args.computing;
    check_outputs(&args.takes, &[&computing.csv, &computing.report])?;
    let settings = settings(computing, Question::Groups(args.by.map(Into::into)))?;
    let (study, failures) = analysed(&args.takes, &settings)?;
    shown(&study, computing, || {
        print_document(&AnalysisDocument::of(&study))
    })?;
    failures.outcome()
}
