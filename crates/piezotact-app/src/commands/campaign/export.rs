//! `piezotact campaign export`: a study as tables.

use std::path::PathBuf;

use clap::Args;
use piezotact::page::Table;
use piezotact_people::association::{
    answers_table, evidence_table, participants_table, trials_table,
};
use piezotact_people::campaign::dictionary::dictionary;
use piezotact_people::campaign::session::State;
use piezotact_people::campaign::store::{Purpose, Store as _};
use piezotact_report::report;

use super::study::{Begun, Study};
use crate::commands::render::folders;
use crate::failure::Outcome;
use crate::output::{document_text, print, write_text};

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The folder of the study.
    #[arg(value_name = "STUDY")]
    study: PathBuf,
    /// The folder to write: answers.csv, trials.csv, evidence.csv, thresholds.csv, participants.csv, events/ and dictionary.json.
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let study = Study::open(&args.study)?;
    let (declared, answers) = study.answers()?;
    let begun = study.sessions()?;
    let mut states: Vec<(State<'_>, Purpose)> = Vec::new();
    for Begun { entry, plan } in &begun {
        if let Some(plan) = plan {
            states.push((study.state(plan)?, entry.purpose));
        }
    }
    let events = args.out.join("events");
    folders([Some(args.out.as_path()), Some(events.as_path())].as_slice())?;
    let each = || states.iter().map(|(state, purpose)| (state, *purpose));
    let tables: [(&str, Table); 5] = [
        ("answers.csv", answers_table(&declared, &answers)),
        ("trials.csv", trials_table(each())),
        (
            "evidence.csv",
            evidence_table(states.iter().map(|(state, _)| state)),
        ),
        ("thresholds.csv", study.thresholds()?),
        ("participants.csv", participants_table(each())),
    ];
    for (name, table) in &tables {
        write_text(&args.out.join(name), &report::csv(table)?)?;
    }
    let path = args.out.join("dictionary.json");
    let dictionary = dictionary(&study.campaign.protocol);
    write_text(&path, &document_text(&dictionary, Some(&path))?)?;
    for Begun { entry, .. } in &begun {
        let mut lines = String::new();
        for link in study.store.events(&entry.key)? {
            if let Some(payload) = &link.payload {
                let at_ms = link.at_ms;
                lines.push_str(&format!(
                    "{{\"number\":{},\"at_ms\":{at_ms},\"event\":{}}}\n",
                    link.number, payload.json
                ));
            }
        }
        let name = format!("{}_{}.jsonl", entry.key.participant, entry.key.session);
        write_text(&events.join(name), &lines)?;
    }
    let rehearsals = states
        .iter()
        .filter(|(_, purpose)| *purpose == Purpose::Rehearsal);
    print(&format!(
        "{}: {} answers of {} sessions ({} of them rehearsals, marked), {} withdrawn",
        args.out.display(),
        answers.len(),
        states.len(),
        rehearsals.count(),
        begun.len() - states.len()
    ))
}
