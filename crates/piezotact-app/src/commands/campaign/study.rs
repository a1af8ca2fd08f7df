//! A study that is open: its store, its campaign, and the sessions with their plans.

use piezotact::recording::{RecordingWarning, Simulated};
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

use anyhow::{Error, anyhow};
use piezotact::Warning;
use piezotact::page::{Column, Table};
use piezotact_people::association::{
    Answer, AssociationWarning, Declared, THRESHOLD_COLUMNS, answers_of, declared, not_known,
    thresholds_table,
};
use piezotact_people::campaign::plan::{CompletedSession, Plan};
use piezotact_people::campaign::protocol::TaskKind;
use piezotact_people::campaign::session::{CampaignWarning, LeftOut, Stage, State};
use piezotact_people::campaign::store::{Purpose, SessionEntry, Store as _};
use piezotact_study::session::state_of;
use piezotact_study::store::{Notice, Pseudonym, StudyCampaign, StudyStore};

use crate::failure::{Failure, Outcome, sentence, usage};
use crate::output::say;

/// A study with its campaign.
pub(crate) struct Study {
    pub(crate) store: StudyStore,
    pub(crate) campaign: StudyCampaign,
}

/// A session that was begun.
pub(crate) struct Begun {
    pub(crate) entry: SessionEntry,
    /// Its plan; none where it was erased, or cannot be read.
    pub(crate) plan: Option<Plan>,
    /// Why its plan cannot be read.
    pub(crate) unreadable: Option<Failure>,
}

impl Study {
    /// The study in `folder`.
    pub(crate) fn open(folder: &Path) -> Outcome<Self> {
        let store = open_store(folder)?;
        let campaign = store.campaign()?;
        let study = Self { store, campaign };
        study.check_seed()?;
        Ok(study)
    }

    /// Refuses another seed than the one with which the first session was planned: later plans would not be those of this study.
    fn check_seed(&self) -> Outcome {
        let planned = self.store.sessions()?.into_iter();
        let mut planned = planned.filter_map(|entry| match entry.withdrawn_at_ms {
            Some(_) => None,
            None => self.written_plan(&entry).ok(),
        });
        match planned.next() {
            Some(plan) if plan.seed != self.campaign.seed => Err(Failure::Data(anyhow!(
                "{}: expected the seed {} in campaign.json, with which session {} of {} was planned, found {}; restore campaign.json from a copy of the study",
                self.store.folder().display(),
                plan.seed,
                plan.session,
                plan.participant,
                self.campaign.seed
            ))),
            _ => Ok(()),
        }
    }

    /// The sessions that count: of everybody who has not withdrawn, in the order in which they were begun. Who withdrew in one
    /// session has withdrawn from all, erased or not.
    pub(crate) fn live(&self) -> Outcome<Vec<(SessionEntry, Plan)>> {
        let mut left_out = self.not_erased()?;
        let sessions = self.sessions()?;
        // Whether they withdrew in it is not known.
        let unreadable = sessions.iter().filter(|begun| begun.unreadable.is_some());
        left_out.extend(unreadable.map(|begun| begun.entry.key.participant.clone()));
        let live = sessions
            .into_iter()
            .filter(|begun| !left_out.contains(&begun.entry.key.participant));
        let planned = live.filter_map(|begun| begun.plan.map(|plan| (begun.entry, plan)));
        Ok(planned.collect())
    }

    /// Refuses a study of virtual volunteers, where a person would be counted among them.
    pub(super) fn require_people(&self) -> Outcome {
        // Also where all of them have withdrawn.
        if super::simulated_as(self)?.is_some() {
            return Err(usage(anyhow!(
                "{}: expected a study with people, found one that was simulated; make a study of its own for people",
                self.store.folder().display()
            )));
        }
        for (entry, plan) in self.live()? {
            if self.state(&plan)?.participant().judge.is_some() {
                return Err(usage(anyhow!(
                    "{}: expected a study with people, found virtual volunteers, such as {}; make a study of its own for people",
                    self.store.folder().display(),
                    entry.key.participant
                )));
            }
        }
        Ok(())
    }

    /// Who withdrew in a session and was not erased yet.
    pub(super) fn not_erased(&self) -> Outcome<BTreeSet<String>> {
        let mut withdrawn = BTreeSet::new();
        for Begun { plan, .. } in self.sessions()? {
            if let Some(plan) = plan
                && self.state(&plan)?.stage() == Stage::Withdrawn
            {
                withdrawn.insert(plan.participant);
            }
        }
        Ok(withdrawn)
    }

    /// All sessions, in the order in which they were begun.
    pub(crate) fn sessions(&self) -> Outcome<Vec<Begun>> {
        let entries = self.store.sessions()?.into_iter();
        let begun = entries.map(|entry| {
            let (plan, unreadable) = match entry.withdrawn_at_ms {
                Some(_) => (None, None),
                None => match self.written_plan(&entry) {
                    Ok(plan) => (Some(plan), None),
                    Err(why) => (None, Some(why)),
                },
            };
            Begun {
                entry,
                plan,
                unreadable,
            }
        });
        Ok(begun.collect())
    }

    fn written_plan(&self, entry: &SessionEntry) -> Outcome<Plan> {
        let participant = Pseudonym::new(&entry.key.participant)?;
        let plan = self.store.plan(&participant, &entry.key.session)?;
        plan.ok_or_else(|| {
            Failure::Data(anyhow!(
                "{}: the plan of session {} of {participant} is not there; restore its folder from a copy of the study",
                self.store.folder().display(),
                entry.key.session
            ))
        })
    }

    /// Where the session of `plan` stands.
    pub(crate) fn state<'a>(&'a self, plan: &'a Plan) -> Outcome<State<'a>> {
        state_of(&self.store, &self.campaign.protocol, plan).map_err(|error| {
            let session = format!("session {} of {}", plan.session, plan.participant);
            Failure::Data(Error::new(error).context(session))
        })
    }

    /// The sessions with volunteers that were ended, for the plan of the next.
    pub(super) fn completed(&self) -> Outcome<Vec<CompletedSession>> {
        let mut completed = Vec::new();
        for (entry, plan) in self.live()? {
            if entry.purpose == Purpose::Volunteer && self.state(&plan)?.is_complete() {
                completed.push(plan.as_completed());
            }
        }
        Ok(completed)
    }

    /// What the protocol declares, and every confirmed answer of every session that was not erased.
    pub(crate) fn answers(&self) -> Outcome<(Declared, Vec<Answer>)> {
        let mut answers = Vec::new();
        for (entry, plan) in self.live()? {
            answers.extend(answers_of(&self.state(&plan)?, entry.purpose));
        }
        Ok((declared(&self.campaign.protocol), answers))
    }

    /// The answers that name a sample.
    pub(super) fn associations(&self) -> Outcome<Vec<Answer>> {
        let (orders, mut answers) = (self.orders(), self.answers()?.1);
        answers.retain(|answer| !orders.contains(&answer.task));
        Ok(answers)
    }

    /// The places of samples in orders.
    pub(super) fn places(&self) -> Outcome<Vec<Answer>> {
        let (orders, mut answers) = (self.orders(), self.answers()?.1);
        answers.retain(|answer| orders.contains(&answer.task));
        Ok(answers)
    }

    /// The tasks in which samples are put in order.
    pub(crate) fn orders(&self) -> Vec<String> {
        let tasks = self.campaign.protocol.tasks.iter();
        let orders = tasks.filter(|task| matches!(task.kind, TaskKind::Order { .. }));
        orders.map(|task| task.name.clone()).collect()
    }

    /// What a person should know of the sessions with volunteers.
    pub(crate) fn warnings(&self) -> Outcome<Vec<Warning>> {
        let not_erased = self.not_erased()?.into_iter();
        let not_erased = not_erased.map(|participant| CampaignWarning::LeftOut {
            why: LeftOut::Withdrawn { participant },
        });
        let mut warnings: Vec<Warning> = not_erased.map(Warning::from).collect();
        for begun in self.sessions()? {
            if let Some(Failure::Data(why) | Failure::Usage(why)) = &begun.unreadable {
                let session = format!(
                    "session {} of {}",
                    begun.entry.key.session, begun.entry.key.participant
                );
                let why = sentence(why);
                warnings.push(
                    CampaignWarning::LeftOut {
                        why: LeftOut::Plan { session, said: why },
                    }
                    .into(),
                );
            }
        }
        let mut by_judge: BTreeMap<String, usize> = BTreeMap::new();
        let mut unknown = 0;
        for (entry, plan) in self.live()? {
            if entry.purpose != Purpose::Volunteer {
                continue;
            }
            let state = self.state(&plan)?;
            unknown += not_known(&state);
            warnings.extend(state.warnings_but_of_judge());
            if let Some(judge) = state.participant().judge {
                *by_judge.entry(judge.name().into()).or_default() += 1;
            }
        }
        let virtual_volunteers = by_judge.into_iter();
        let virtual_volunteers = virtual_volunteers.map(|(judge, sessions)| {
            RecordingWarning::Simulated {
                by: Simulated::Volunteers { sessions, judge },
            }
            .into()
        });
        warnings.extend(virtual_volunteers);
        warnings
            .extend((unknown > 0).then(|| AssociationWarning::NotKnown { trials: unknown }.into()));
        Ok(warnings)
    }

    /// The thresholds of adaptive comparisons, one row for each run.
    pub(crate) fn thresholds(&self) -> Outcome<Table> {
        let mut rows = Vec::new();
        for (_, plan) in self.live()? {
            rows.extend(thresholds_table(&self.state(&plan)?).rows);
        }
        let mut table = Table::new(THRESHOLD_COLUMNS.map(|name| Column::new(name, name)));
        table.rows = rows;
        Ok(table)
    }

    /// The pseudonym `text`, which differs from those that are there by more than case.
    pub(super) fn participant(&self, text: &str) -> Outcome<Pseudonym> {
        let participant = Pseudonym::new(text).map_err(usage)?;
        let sessions = self.store.sessions()?;
        let known = sessions.iter().map(|entry| entry.key.participant.as_str());
        participant.check_among(known).map_err(usage)?;
        Ok(participant)
    }
}

/// The store of the study in `folder`; what became of withdrawals at other stations is said.
pub(super) fn open_store(folder: &Path) -> Outcome<StudyStore> {
    let store = StudyStore::open(folder)?;
    for notice in store.notices() {
        say(&notice.to_string());
        if let Notice::MayBeNamed { participant, .. } = notice {
            say(&format!(
                "  piezotact campaign withdraw {} {participant} --passphrase FILE",
                folder.display()
            ));
        }
    }
    Ok(store)
}

/// The time now, in ms since 1970-01-01 00:00 UTC.
pub(crate) fn now_ms() -> i64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH);
    since.map_or(0, |since| {
        i64::try_from(since.as_millis()).unwrap_or(i64::MAX)
    })
}

/// `at_ms` as date and time in UTC: `2026-03-01 10:22`.
pub(crate) fn said(at_ms: i64) -> String {
    // The end of the year 9999: later ones have no date.
    const LATEST_MS: i64 = 253_402_300_799_000;
    let at_ms = at_ms.clamp(0, LATEST_MS).unsigned_abs();
    let at = UNIX_EPOCH + std::time::Duration::from_millis(at_ms);
    let text = humantime::format_rfc3339_seconds(at).to_string();
    text.replace('T', " ").chars().take(16).collect()
}
