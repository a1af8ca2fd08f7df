//! `piezotact campaign export`: a study as tables.

use std::path::{Path, PathBuf};

use clap::Args;
use piezotact::number::counted;
use piezotact::page::Table;
use piezotact_people::association::{
    answers_table, declared, evidence_table, participants_table, session_page, trials_table,
};
use piezotact_people::campaign::dictionary::dictionary;
use piezotact_people::campaign::plan::Plan;
use piezotact_people::campaign::session::{Stage, State};
use piezotact_people::campaign::store::{Purpose, SessionEntry, Store as _};
use piezotact_report::report;
use piezotact_study::session::events_of;

use super::study::Study;
use crate::advice::OptionWords;
use crate::commands::render::folders;
use crate::failure::Outcome;
use crate::invocation::write_report;
use crate::output::{document_text, print, say_warnings, write_text};
use crate::places::outputs;

/// The folder of the events.
const EVENTS: &str = "events";
/// The folder of the reports.
const REPORTS: &str = "reports";

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The folder of the study.
    #[arg(value_name = "STUDY")]
    study: PathBuf,
    /// The folder to write: answers.csv, orders.csv, trials.csv, evidence.csv, thresholds.csv, participants.csv, events/, reports/ and dictionary.json.
    #[arg(long, value_name = "FOLDER")]
    out: PathBuf,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let study = Study::open(&args.study)?;
    let [answers, places] = [study.associations()?, study.places()?].map(|of| of.len());
    let begun = study.sessions()?.len();
    let live = study.live()?;
    let states = states(&study, &live)?;
    folders(
        [
            Some(args.out.as_path()),
            Some(args.out.join(EVENTS).as_path()),
            Some(args.out.join(REPORTS).as_path()),
        ]
        .as_slice(),
    )?;
    let files = files(&study, &live, &states)?;
    let paths: Vec<PathBuf> = files.iter().map(|(name, _)| args.out.join(name)).collect();
    outputs(&[], &paths.iter().map(PathBuf::as_path).collect::<Vec<_>>())?;
    for (path, (_, text)) in paths.iter().zip(&files) {
        match path.extension().is_some_and(|ending| ending == "html") {
            true => write_report(path, text)?,
            false => write_text(path, text)?,
        }
    }
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
    say_warnings(&study.warnings()?);
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

/// The files of a study, with their names and contents: its tables, their dictionary, and of every session that counts its events, one
/// line for each, and its report where it is over.
fn files(
    study: &Study,
    live: &[(SessionEntry, Plan)],
    states: &[(State<'_>, Purpose)],
) -> Outcome<Vec<(String, String)>> {
    let mut files = Vec::new();
    for (name, table) in tables(study, states)? {
        files.push((name.to_owned(), report::csv(&table)?));
    }
    let name = "dictionary.json";
    let text = document_text(&dictionary(&study.campaign.protocol), Some(Path::new(name)))?;
    files.push((name.to_owned(), text));
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
        let name = format!(
            "{EVENTS}/{}_{}.jsonl",
            entry.key.participant, entry.key.session
        );
        files.push((name, lines));
    }
    let over = |state: &State<'_>| matches!(state.stage(), Stage::Stopped | Stage::Ended);
    for (state, _) in states.iter().filter(|(state, _)| over(state)) {
        let plan = state.plan();
        let page = session_page(
            state,
            &events_of(&study.store, plan).map_err(anyhow::Error::new)?,
        );
        let name = format!("{REPORTS}/{}_{}.html", plan.participant, plan.session);
        files.push((name, report::html(&page, &OptionWords)?));
    }
    Ok(files)
}

/// The sessions `live` with their states.
fn states<'a>(
    study: &'a Study,
    live: &'a [(SessionEntry, Plan)],
) -> Outcome<Vec<(State<'a>, Purpose)>> {
    let each = live.iter();
    each.map(|(entry, plan)| Ok((study.state(plan)?, entry.purpose)))
        .collect()
}

/// All files of the study in `folder` as one ZIP file.
#[cfg(feature = "web")]
pub(crate) fn zip_of(folder: &Path) -> Outcome<Vec<u8>> {
    use std::io::{Cursor, Write as _};

    let study = Study::open(folder)?;
    let live = study.live()?;
    let states = states(&study, &live)?;
    let mut zip = zip::ZipWriter::new(Cursor::new(Vec::new()));
    let options = zip::write::SimpleFileOptions::default();
    let failed = |error: zip::result::ZipError| anyhow::Error::new(error);
    for (name, text) in files(&study, &live, &states)? {
        zip.start_file(name, options).map_err(failed)?;
        zip.write_all(text.as_bytes())?;
    }
    Ok(zip.finish().map_err(failed)?.into_inner())
}
