//! A study on pages: its sessions with their reports, its matrices and tables.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

use anyhow::anyhow;
use piezotact_people::association::session_page;
use piezotact_people::campaign::plan::Plan;
use piezotact_people::campaign::session::{Stage, State};
use piezotact_people::campaign::store::Purpose;
use piezotact_report::report;
use piezotact_study::session::events_of;
use piezotact_web::{Listed, Overview, Role, Site, Standing, StudyPages};

use super::led::{PAGES, access, named};
use super::network::Door;
use crate::commands::answers::report_of;
use crate::commands::campaign::export::{answers_of, zip_of};
use crate::commands::campaign::status::completed;
use crate::commands::campaign::study::{Study, said};
use crate::failure::{Failure, Outcome, sentence, usage};
use crate::interrupt::{Between, interrupted};
use crate::output::print;

/// How often it is looked whether the program is to end.
const LOOK: Duration = Duration::from_millis(100);

/// The study in a folder.
pub(super) struct OfStudy(pub(super) PathBuf);

impl StudyPages for OfStudy {
    fn overview(&self) -> Result<Overview, String> {
        overview_of(&self.0).map_err(why)
    }

    fn session(&self, participant: &str, session: &str) -> Result<String, String> {
        session_of(&self.0, participant, session).map_err(why)
    }

    fn matrix(&self) -> Result<String, String> {
        report_of(&self.0).map_err(why)
    }

    fn answers(&self) -> Result<String, String> {
        answers_of(&self.0).map_err(why)
    }

    fn tables(&self) -> Result<Vec<u8>, String> {
        zip_of(&self.0).map_err(why)
    }
}

fn why(failure: Failure) -> String {
    match failure {
        Failure::Data(error) | Failure::Usage(error) => sentence(&error),
        _ => "the command ended".to_owned(),
    }
}

/// Serves the study in `folder` at `door`, with nothing to lead, until the program is interrupted.
pub(super) fn serve(folder: &Path, door: Door) -> Outcome {
    let _ends_between = Between::items("page");
    // Refused before a page is opened.
    drop(Study::open(folder)?);
    let access = door.guard(
        access(&named(folder, "study"), &folder.join(PAGES))?,
        folder,
    )?;
    let codes = [Role::Experimenter, Role::Viewer].map(|role| access.code(role, 0));
    let said = door.said(
        codes,
        "Sessions with their reports, matrices and tables. To lead a session, add the participant and the session. Ctrl-C ends the pages.",
    )?;
    let site = Site::study(access, Arc::new(OfStudy(folder.to_owned())));
    let _served = site
        .serve(door.listener, &door.reach)
        .map_err(anyhow::Error::new)?;
    // Whoever reads may have gone: the pages go on.
    let _reader_gone = print(&said);
    while !interrupted() {
        std::thread::sleep(LOOK);
    }
    Ok(())
}

/// The study in `folder` at a glance, for a page.
fn overview_of(folder: &Path) -> Outcome<Overview> {
    let study = Study::open(folder)?;
    let mut sessions = Vec::new();
    let mut is_simulated = false;
    for begun in study.sessions()? {
        let entry = &begun.entry;
        let state = begun.plan.as_ref().map(|plan| study.state(plan));
        let state = state.transpose()?;
        let judge = state.as_ref().and_then(|state| state.participant().judge);
        is_simulated |= judge.is_some();
        let standing = match &state {
            None if begun.unreadable.is_some() => Standing::Unreadable,
            None => Standing::Erased,
            Some(state) => match state.stage() {
                Stage::New => Standing::New,
                Stage::Consent => Standing::Consent,
                Stage::Running => Standing::Running,
                Stage::Paused => Standing::Paused,
                Stage::Stopped => Standing::Stopped,
                Stage::Ended if !state.is_complete() => Standing::NoConsent,
                Stage::Ended => Standing::Complete,
                Stage::Withdrawn => Standing::Withdrawn,
            },
        };
        let trials = |state: &State<'_>| {
            let needed = state.progress().values().map(|(_, needed)| needed).sum();
            (state.confirmed(), needed)
        };
        let last = state.as_ref().map_or(entry.withdrawn_at_ms, State::last_ms);
        sessions.push(Listed {
            participant: entry.key.participant.clone(),
            session: entry.key.session.clone(),
            standing,
            is_rehearsal: entry.purpose == Purpose::Rehearsal,
            trials: state.as_ref().map(trials),
            last: last.map_or(String::new(), said),
        });
    }
    let planned = study.campaign.protocol.panel.participants;
    Ok(Overview {
        title: study.campaign.protocol.title.clone(),
        completed: (completed(&study)?, planned as usize),
        is_simulated,
        sessions,
    })
}

/// The report of the session `session` of `participant` in the study in `folder`, as an HTML document, where it is over.
fn session_of(folder: &Path, participant: &str, session: &str) -> Outcome<String> {
    let study = Study::open(folder)?;
    let is_it = |plan: &Plan| plan.participant == participant && plan.session == session;
    let mut live = study.live()?.into_iter();
    let Some((_, plan)) = live.find(|(_, plan)| is_it(plan)) else {
        return Err(usage(anyhow!(
            "expected a session that counts, found none named {session} of {participant}"
        )));
    };
    let state = study.state(&plan)?;
    match state.stage() {
        Stage::Stopped | Stage::Ended => {}
        _ => {
            return Err(usage(anyhow!(
                "session {session} of {participant} is not over: its report would show what is presented; end it first"
            )));
        }
    }
    let events = events_of(&study.store, &plan).map_err(anyhow::Error::new)?;
    let page = session_page(&state, &events);
    Ok(report::html(&page, &crate::advice::OptionWords)?)
}
