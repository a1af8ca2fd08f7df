//! `piezotact campaign status`: where every session of a study stands.

use std::path::{Path, PathBuf};

use clap::Args;
use piezotact::page::{Cell, Column, Table};
use piezotact_people::campaign::session::{Stage, State};
use piezotact_people::campaign::store::Purpose;
use piezotact_report::report;

use super::study::{Begun, Study, said};
use crate::failure::Outcome;
use crate::output::{print, say_warnings, write_text};
use crate::places::outputs;

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The folder of the study.
    #[arg(value_name = "STUDY")]
    study: PathBuf,
    /// Writes the sessions as a table, with a row for each.
    #[arg(long, value_name = "TABLE.csv")]
    csv: Option<PathBuf>,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let written: Vec<&Path> = args.csv.iter().map(PathBuf::as_path).collect();
    outputs(&[], &written)?;
    let study = Study::open(&args.study)?;
    let table = sessions(&study)?;
    if let Some(path) = &args.csv {
        write_text(path, &report::csv(&table)?)?;
    }
    print(&format!(
        "{}: {} of {} {} completed {}",
        study.campaign.protocol.title,
        completed(&study)?,
        study.campaign.protocol.panel.participants,
        people(&study)?,
        study.campaign.protocol.aims.session
    ))?;
    match table.rows.is_empty() {
        true => print("no session was begun yet")?,
        false => print(&report::text(&table)?)?,
    }
    let thresholds = study.thresholds()?;
    if !thresholds.rows.is_empty() {
        print(&report::text(&thresholds)?)?;
    }
    say_warnings(&study.warnings()?);
    let wrote = |path: &PathBuf| print(&format!("wrote {}", path.display()));
    args.csv.iter().try_for_each(wrote)
}

/// Every session with its stage, one row for each.
fn sessions(study: &Study) -> Outcome<Table> {
    let names = [
        ("participant", "participant"),
        ("session", "session"),
        ("stage", "stage"),
        ("trials", "trials"),
        ("last event (UTC)", "last_event_utc"),
        ("ignored", "ignored"),
    ];
    let mut table = Table::new(names.map(|(heading, name)| Column::new(heading, name)));
    for Begun {
        entry,
        plan,
        unreadable,
    } in study.sessions()?
    {
        let state = plan.as_ref().map(|plan| study.state(plan)).transpose()?;
        let (stage, trials, last, ignored) = match &state {
            None if unreadable.is_some() => ("its plan cannot be read", String::new(), None, 0),
            None => (
                "withdrawn and erased",
                String::new(),
                entry.withdrawn_at_ms,
                0,
            ),
            Some(state) => (
                stage(state),
                {
                    let progress = state.progress();
                    let needed: usize = progress.values().map(|(_, needed)| needed).sum();
                    format!("{} of {needed}", state.confirmed())
                },
                state.last_ms(),
                state.ignored(),
            ),
        };
        let stage = match entry.purpose {
            Purpose::Volunteer => stage.to_owned(),
            Purpose::Rehearsal => format!("rehearsal: {stage}"),
        };
        table.rows.push(vec![
            Cell::from(entry.key.participant.as_str()),
            Cell::from(entry.key.session.as_str()),
            Cell::from(stage),
            Cell::from(trials),
            Cell::from(last.map_or(String::new(), said)),
            Cell::from(ignored.to_string()),
        ]);
    }
    Ok(table)
}

/// What the participants are.
fn people(study: &Study) -> Outcome<&'static str> {
    for (_, plan) in study.live()? {
        if study.state(&plan)?.participant().judge.is_some() {
            return Ok("virtual volunteers (no person)");
        }
    }
    Ok("participants")
}

/// How many participants completed the session that the campaign is judged by.
pub(crate) fn completed(study: &Study) -> Outcome<usize> {
    let session = &study.campaign.protocol.aims.session;
    let completed = study.completed()?;
    Ok(completed
        .iter()
        .filter(|done| done.session == *session)
        .count())
}

fn stage(state: &State<'_>) -> &'static str {
    match state.stage() {
        Stage::New => "not begun",
        Stage::Consent => "waits for consent",
        Stage::Running => "under way",
        Stage::Paused => "in a pause",
        Stage::Stopped => "stopped",
        Stage::Ended if !state.is_complete() => "no consent",
        Stage::Ended => "complete",
        Stage::Withdrawn => "withdrawn, not erased yet",
    }
}
