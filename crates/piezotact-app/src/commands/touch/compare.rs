//! `piezotact compare`: what changes from group to group.

use piezotact::quantity::{Band, Hertz};
use piezotact::study::{ComparisonDocument, Question};

use super::{analysed, check_outputs, settings, take_all};
use crate::cli::Compare;
use crate::commands::score;
use crate::deliver::deliver;
use crate::failure::Outcome;

/// The band over which a finger feels: the one that `score` compares unless told otherwise.
const FELT_HZ: [f64; 2] = [20.0, 1000.0];

pub(crate) fn run(args: &Compare) -> Outcome {
    let outputs = &args.computing.outputs;
    let [low, high] = FELT_HZ.map(Hertz);
    let question = Question::Changes {
        by: args.by.factor(),
        model: score::model(&args.feeling, Band::new(low, high)?)?,
    };
    check_outputs(&args.takes, &outputs.files())?;
    let settings = settings(&args.computing, question)?;
    let (takes, failures) = take_all(&args.takes)?;
    let study = analysed(takes, Some(&args.by), &failures, &settings)?;
    deliver(outputs, &ComparisonDocument::of(&study))?;
    failures.outcome()
}
