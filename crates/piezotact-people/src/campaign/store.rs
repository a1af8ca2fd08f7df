//! Where the events of a campaign are kept: a trait, and a store in memory for simulations and tests.
//!
//! A store keeps events and never interprets them: what a session is at is derived from its events.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::chain::{Link, Payload, Salt, Sha, next_link, verify};

/// A session of a participant, by the names that the campaign gives them.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct SessionKey {
    pub participant: String,
    /// The name of the session in the protocol.
    pub session: String,
}

impl SessionKey {
    /// The key of `session` of `participant`.
    #[must_use]
    pub fn new(participant: &str, session: &str) -> Self {
        Self {
            participant: participant.to_owned(),
            session: session.to_owned(),
        }
    }

    /// Both names, as the chain takes them.
    #[must_use]
    pub fn names(&self) -> (&str, &str) {
        (&self.participant, &self.session)
    }
}

/// Whether a session is with a volunteer, or tried out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Purpose {
    /// A volunteer: it is analysed.
    Volunteer,
    /// A rehearsal: never analysed.
    Rehearsal,
}

/// What a store says about a session without its events.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SessionEntry {
    pub key: SessionKey,
    pub purpose: Purpose,
    /// Whether its payloads were erased, with the time in ms since 1970-01-01 00:00 UTC.
    pub withdrawn_at_ms: Option<i64>,
}

impl SessionEntry {
    /// Verifies the chain of this session, and that its payloads are there, or erased where the participant has withdrawn.
    ///
    /// # Errors
    /// [`StoreError::Gap`], [`StoreError::Changed`], [`StoreError::Broken`] with the first link that does not fit, [`StoreError::Damaged`].
    pub fn verify(&self, links: &[Link]) -> Result<(), StoreError> {
        verify(self.key.names(), links)?;
        let (participant, session) = self.key.names();
        let withdrawn = self.withdrawn_at_ms.is_some();
        let wrong = links
            .iter()
            .find(|link| link.payload.is_some() == withdrawn);
        let Some(Link { number, .. }) = wrong else {
            return Ok(());
        };
        let why = match withdrawn {
            true => format!(
                "{participant} is noted as withdrawn, and event {number} of session {session} is still there"
            ),
            false => format!(
                "event {number} of session {session} of {participant}, who has not withdrawn, was erased"
            ),
        };
        Err(StoreError::Damaged { why })
    }
}

/// An event to be kept.
#[derive(Clone, Copy, Debug)]
pub struct NewEvent<'a> {
    /// When, in ms since 1970-01-01 00:00 UTC.
    pub at_ms: i64,
    /// The event as JSON.
    pub json: &'a str,
    pub salt: Salt,
}

/// Why a store did not do as it was asked. Nothing was kept then.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum StoreError {
    /// The session is there already.
    #[error(
        "session {} of {} exists already; resume it, or give the participant another pseudonym", .key.session, .key.participant
    )]
    Exists { key: SessionKey },
    /// There is no such session.
    #[error("there is no session {} of {}; begin it first", .key.session, .key.participant)]
    Unknown { key: SessionKey },
    /// The participant has withdrawn.
    #[error(
        "{participant} has withdrawn: nothing can be added; use another pseudonym for another person"
    )]
    Withdrawn { participant: String },
    /// Another program has added events since this one read them.
    #[error("session {} of {} has {found} events, not {expected}: another program runs it; end one of them", .key.session, .key.participant
    )]
    Overtaken {
        key: SessionKey,
        /// How many this program knows.
        expected: u64,
        /// How many there are.
        found: u64,
    },
    /// What is kept is not what a store keeps.
    #[error("what is stored was changed or damaged: {why}; restore the whole folder from a copy")]
    Damaged { why: String },
    /// The place where it is kept cannot be read or written.
    #[error("nothing was stored: {why}; {advice}")]
    Place {
        /// What the system said.
        why: String,
        advice: &'static str,
    },
    /// A number is missing or twice.
    #[error(
        "session {session} of {participant}: expected event {expected}, found event {found}; an event was removed or exchanged: restore the folder from a copy"
    )]
    Gap {
        participant: String,
        session: String,
        /// The number that was expected.
        expected: u64,
        /// The number that is there.
        found: u64,
    },
    /// A payload is not the one that was stored.
    #[error(
        "session {session} of {participant}: the content of event {number} was changed after it was stored: restore the folder from a copy"
    )]
    Changed {
        participant: String,
        session: String,
        number: u64,
    },
    /// A link does not fit the one before it.
    #[error(
        "session {session} of {participant}: event {number} does not fit the events before it; the time or the order was changed: restore the folder from a copy"
    )]
    Broken {
        participant: String,
        session: String,
        number: u64,
    },
}

/// A store of sessions. An event is acknowledged (`Ok`) when a crash can no longer lose it.
pub trait Store {
    /// Begins a session.
    ///
    /// # Errors
    /// [`StoreError::Exists`], [`StoreError::Withdrawn`], [`StoreError::Place`].
    fn begin(&mut self, key: &SessionKey, purpose: Purpose) -> Result<(), StoreError>;

    /// Adds an event behind the `known` events of a session that the caller has read.
    ///
    /// # Errors
    /// [`StoreError::Unknown`], [`StoreError::Overtaken`], [`StoreError::Withdrawn`], [`StoreError::Place`].
    fn append(
        &mut self,
        key: &SessionKey,
        known: u64,
        event: NewEvent<'_>,
    ) -> Result<Link, StoreError>;

    /// The events of a session in their order; without payloads where they were erased.
    ///
    /// # Errors
    /// [`StoreError::Unknown`], [`StoreError::Place`].
    fn events(&self, key: &SessionKey) -> Result<Vec<Link>, StoreError>;

    /// All sessions, in the order in which they were begun.
    ///
    /// # Errors
    /// [`StoreError::Place`].
    fn sessions(&self) -> Result<Vec<SessionEntry>, StoreError>;

    /// Erases payloads and salts of all sessions of a participant; the chains stay as tombstones.
    ///
    /// # Errors
    /// [`StoreError::Unknown`] where the participant has no session, [`StoreError::Place`].
    fn erase(&mut self, participant: &str, at_ms: i64) -> Result<usize, StoreError>;

    /// Verifies the chains of all sessions; gives their number.
    ///
    /// # Errors
    /// [`StoreError::Gap`], [`StoreError::Changed`], [`StoreError::Broken`] with the first that is broken, [`StoreError::Damaged`], [`StoreError::Place`].
    fn verify(&self) -> Result<usize, StoreError> {
        let sessions = self.sessions()?;
        for entry in &sessions {
            entry.verify(&self.events(&entry.key)?)?;
        }
        Ok(sessions.len())
    }

    /// The checksum at the end of a session's chain, to be noted elsewhere; `None` before the first event.
    ///
    /// # Errors
    /// As [`Store::events`].
    fn head(&self, key: &SessionKey) -> Result<Option<Sha>, StoreError> {
        Ok(self.events(key)?.last().map(|link| link.sha))
    }
}

/// A store in memory.
#[derive(Clone, Debug, Default)]
pub struct MemoryStore {
    entries: Vec<SessionEntry>,
    links: BTreeMap<SessionKey, Vec<Link>>,
}

impl MemoryStore {
    /// An empty store.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    fn has_withdrawn(&self, participant: &str) -> bool {
        self.entries
            .iter()
            .any(|entry| entry.key.participant == participant && entry.withdrawn_at_ms.is_some())
    }
}

impl Store for MemoryStore {
    fn begin(&mut self, key: &SessionKey, purpose: Purpose) -> Result<(), StoreError> {
        if self.has_withdrawn(&key.participant) {
            return Err(StoreError::Withdrawn {
                participant: key.participant.clone(),
            });
        }
        if self.links.contains_key(key) {
            return Err(StoreError::Exists { key: key.clone() });
        }
        self.links.insert(key.clone(), Vec::new());
        self.entries.push(SessionEntry {
            key: key.clone(),
            purpose,
            withdrawn_at_ms: None,
        });
        Ok(())
    }

    fn append(
        &mut self,
        key: &SessionKey,
        known: u64,
        event: NewEvent<'_>,
    ) -> Result<Link, StoreError> {
        if self.has_withdrawn(&key.participant) {
            return Err(StoreError::Withdrawn {
                participant: key.participant.clone(),
            });
        }
        let links = self
            .links
            .get_mut(key)
            .ok_or_else(|| StoreError::Unknown { key: key.clone() })?;
        let found = links.len() as u64;
        if found != known {
            return Err(StoreError::Overtaken {
                key: key.clone(),
                expected: known,
                found,
            });
        }
        let payload = Payload {
            json: event.json.to_owned(),
            salt: event.salt,
        };
        let link = next_link(key.names(), links.last(), event.at_ms, payload);
        links.push(link.clone());
        Ok(link)
    }

    fn events(&self, key: &SessionKey) -> Result<Vec<Link>, StoreError> {
        self.links
            .get(key)
            .cloned()
            .ok_or_else(|| StoreError::Unknown { key: key.clone() })
    }

    fn sessions(&self) -> Result<Vec<SessionEntry>, StoreError> {
        Ok(self.entries.clone())
    }

    fn erase(&mut self, participant: &str, at_ms: i64) -> Result<usize, StoreError> {
        let mut erased = 0;
        for entry in &mut self.entries {
            if entry.key.participant != participant {
                continue;
            }
            erased += 1;
            entry.withdrawn_at_ms.get_or_insert(at_ms);
            for link in self.links.get_mut(&entry.key).into_iter().flatten() {
                link.payload = None;
            }
        }
        match erased {
            0 => Err(StoreError::Unknown {
                key: SessionKey::new(participant, "(any)"),
            }),
            _ => Ok(erased),
        }
    }
}

/// What every store must do; each implementation calls it with an empty one in its tests.
pub mod conformance {
    use super::{NewEvent, Purpose, SessionKey, Store, StoreError};

    /// Ends the check with the sentence `$what` where it does not hold.
    macro_rules! ensure {
        ($holds:expr, $what:literal) => {
            if !$holds {
                return Err($what.to_owned());
            }
        };
    }

    fn fails(what: &str) -> impl Fn(StoreError) -> String + '_ {
        move |error| format!("{what}: {error}")
    }

    fn event(json: &str) -> NewEvent<'_> {
        NewEvent {
            at_ms: 1_700_000_000_000,
            json,
            salt: [7; 16],
        }
    }

    /// Goes through begin, append, read, refuse and erase; gives the first difference as a sentence.
    ///
    /// # Errors
    /// The sentence.
    ///
    /// Source: the documentation of [`Store`].
    pub fn check(store: &mut impl Store) -> Result<(), String> {
        let key = SessionKey::new("P01", "discrimination");
        let other = SessionKey::new("P02", "discrimination");
        store
            .begin(&key, Purpose::Volunteer)
            .map_err(fails("begin"))?;
        store
            .begin(&other, Purpose::Rehearsal)
            .map_err(fails("begin another"))?;
        ensure!(
            matches!(
                store.begin(&key, Purpose::Volunteer),
                Err(StoreError::Exists { .. })
            ),
            "the same session twice is refused"
        );
        for (known, json) in ["{\"a\":1}", "{\"a\":\"é\"}", "{\"a\":3}"]
            .iter()
            .enumerate()
        {
            let link = store
                .append(&key, known as u64, event(json))
                .map_err(fails("append"))?;
            ensure!(link.number == known as u64, "events are numbered from 0");
        }
        ensure!(
            matches!(
                store.append(&key, 1, event("{}")),
                Err(StoreError::Overtaken {
                    expected: 1,
                    found: 3,
                    ..
                })
            ),
            "an event of a program that was overtaken is refused"
        );
        ensure!(
            matches!(
                store.append(&SessionKey::new("P09", "x"), 0, event("{}")),
                Err(StoreError::Unknown { .. })
            ),
            "an event of an unknown session is refused"
        );
        let links = store.events(&key).map_err(fails("events"))?;
        let texts: Vec<_> = links
            .iter()
            .filter_map(|link| link.payload.as_ref())
            .map(|payload| payload.json.as_str())
            .collect();
        ensure!(
            texts == ["{\"a\":1}", "{\"a\":\"é\"}", "{\"a\":3}"],
            "events are read as they were stored"
        );
        ensure!(
            store.verify().map_err(fails("verify"))? == 2,
            "both chains verify"
        );
        let head = store.head(&key).map_err(fails("head"))?;
        ensure!(
            store.erase("P01", 5).map_err(fails("erase"))? == 1,
            "one session is erased"
        );
        let links = store.events(&key).map_err(fails("events after erase"))?;
        ensure!(
            links.len() == 3 && links.iter().all(|link| link.payload.is_none()),
            "payloads are erased and the links stay"
        );
        ensure!(
            store.head(&key).map_err(fails("head after erase"))? == head,
            "the chain is the same"
        );
        ensure!(
            store.verify().map_err(fails("verify after erase"))? == 2,
            "the chains verify after erasing"
        );
        ensure!(
            matches!(
                store.append(&key, 3, event("{}")),
                Err(StoreError::Withdrawn { .. })
            ),
            "nothing is added after a withdrawal"
        );
        let entries = store.sessions().map_err(fails("sessions"))?;
        ensure!(
            entries.len() == 2
                && entries[0].withdrawn_at_ms == Some(5)
                && entries[1].purpose == Purpose::Rehearsal
                && entries[1].withdrawn_at_ms.is_none(),
            "sessions say their purpose and withdrawal"
        );
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_store_in_memory_conforms() {
        assert_eq!(conformance::check(&mut MemoryStore::new()), Ok(()));
    }
}
