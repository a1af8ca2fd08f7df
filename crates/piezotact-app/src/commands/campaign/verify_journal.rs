//! `piezotact campaign verify-journal`: whether what is stored is what was written.

use std::path::PathBuf;

use clap::Args;
use piezotact_people::campaign::store::Store as _;

use super::study::{Begun, Study};
use crate::failure::Outcome;
use crate::output::print;

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The folder of the study.
    #[arg(value_name = "STUDY")]
    study: PathBuf,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let study = Study::open(&args.study)?;
    let sessions = study.store.verify()?;
    for Begun { entry, plan } in study.sessions()? {
        let events = study.store.events(&entry.key)?.len();
        let head = study.store.head(&entry.key)?;
        let head = head.map_or_else(|| "no event".to_owned(), |head| head.to_string());
        let what = match plan {
            Some(plan) => {
                // Its events follow from each other, and belong to its plan.
                study.state(&plan)?;
                "whole"
            }
            None => "erased after a withdrawal, the chain is whole",
        };
        print(&format!(
            "{} {}: {events} events, {what}; ends with {head}",
            entry.key.participant, entry.key.session
        ))?;
    }
    print(&format!(
        "{}: the journals of {sessions} sessions verify: none of their events was changed, reordered, or removed from the middle. Missing sessions, missing last events and rewritten journals are found only by comparing the checksums above with a copy of them: keep one outside the study. Recordings and drives are not checked.",
        args.study.display()
    ))
}
