//! `piezotact campaign export`: a study as tables.

use std::path::{Path, PathBuf};

use clap::Args;
use piezotact::number::counted;
use piezotact::page::Table;
use piezotact_people::association::{
    answers_table, declared, evidence_table, participants_table, trials_table,
};
use piezotact_people::campaign::dictionary::dictionary;
use piezotact_people::campaign::plan::Plan;
use piezotact_people::campaign::session::State;
use piezotact_people::campaign::store::{Purpose, SessionEntry, Store as _};
use piezotact_report::report;

use super::study::Study;
use crate::commands::render::folders;
use crate::failure::Outcome;
use crate::output::{document_text, print, say_doubts, write_text};

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The folder of the study.
    #[arg(value_name = "STUDY")]
    study: PathBuf,
    /// The folder to write: answers.csv, orders.csv, trials.csv, evidence.csv, thresholds.csv, participants.csv, events/ and dictionary.json.
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let study = Study::open(&args.study)?;
    let [answers, places] = [study.associations()?, study.places()?].map(|of| of.len());
    let begun = study.sessions()?.len();
    let live = study.live()?;
    let mut states: Vec<(State<'_>, Purpose)> = Vec::new();
    for (entry, plan) in &live {
        states.push((study.state(plan)?, entry.purpose));
    }
    let events = args.out.join("events");
    folders([Some(args.out.as_path()), Some(events.as_path())].as_slice())?;
    for (name, table) in tables(&study, &states)? {
        write_text(&args.out.join(name), &report::csv(&table)?)?;
    }
    let path = args.out.join("dictionary.json");
    let dictionary = dictionary(&study.campaign.protocol);
    write_text(&path, &document_text(&dictionary, Some(&path))?)?;
    write_events(&study, &live, &events)?;
    let rehearsals = states
        .iter()
        .filter(|(_, purpose)| *purpose == Purpose::Rehearsal);
    print(&format!(
        "{}: {} that name a sample and {} in orders, of {} ({}, marked); left out, of participants who withdrew: {}",
        args.out.display(),
        counted(answers, "answer"),
        counted(places, "place"),
        counted(states.len(), "session"),
        counted(rehearsals.count(), "rehearsal"),
        counted(begun - states.len(), "session")
    ))?;
    say_doubts(&study.doubts()?);
    Ok(())
}

/// All answers that name a sample, as the text of a table.
#[cfg(feature = "web")]
pub(crate) fn answers_of(folder: &Path) -> Outcome<String> {
    let study = Study::open(folder)?;
    let declared = declared(&study.campaign.protocol);
    Ok(report::csv(&answers_table(
        &declared,
        &study.associations()?,
    ))?)
}

/// The tables with the names of their files.
fn tables(study: &Study, states: &[(State<'_>, Purpose)]) -> Outcome<[(&'static str, Table); 6]> {
    let declared = declared(&study.campaign.protocol);
    let answers = answers_table(&declared, &study.associations()?);
    let orders = answers_table(&declared, &study.places()?);
    let each = || states.iter().map(|(state, purpose)| (state, *purpose));
    Ok([
        ("answers.csv", answers),
        ("orders.csv", orders),
        ("trials.csv", trials_table(each())),
        (
            "evidence.csv",
            evidence_table(states.iter().map(|(state, _)| state)),
        ),
        ("thresholds.csv", study.thresholds()?),
        ("participants.csv", participants_table(each())),
    ])
}

/// Writes the events of every session that counts, one file for each session and one line for each event.
fn write_events(study: &Study, live: &[(SessionEntry, Plan)], folder: &Path) -> Outcome {
    for (entry, _) in live {
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
        write_text(&folder.join(name), &lines)?;
    }
    Ok(())
}
