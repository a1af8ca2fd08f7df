//! Sessions and events in the database of a study.

use crate::store::error::StudyError;
use piezotact_people::campaign::chain::{Link, Payload, Salt, Sha, next_link};
use piezotact_people::campaign::store::{
    NewEvent, Purpose, SessionEntry, SessionKey, Store, StoreError,
};

use super::database::{Database, Value};
use super::error::{Kept, damaged};
use super::pseudonym::Pseudonym;
use super::study_store::{Changed, StudyStore};

pub(super) async fn has_withdrawn(
    database: &mut Database,
    participant: &str,
) -> Result<bool, StoreError> {
    let found = "SELECT EXISTS (SELECT 1 FROM withdrawals WHERE participant = $1)";
    let (found,) = database.one(found, &[participant.into()]).await?;
    Ok(found)
}

pub(super) fn withdrawn(participant: &str) -> StoreError {
    StoreError::Withdrawn {
        participant: participant.to_owned(),
    }
}

/// As what a session was begun; `None` where it was not. One of somebody who has withdrawn is refused.
async fn begun(database: &mut Database, key: &SessionKey) -> Result<Option<Purpose>, StoreError> {
    let standing = "SELECT (SELECT purpose FROM sessions WHERE participant = $1 AND session = $2), \
        EXISTS (SELECT 1 FROM withdrawals WHERE participant = $1)";
    let names = [Value::from(&key.participant), (&key.session).into()];
    let (begun, gone): (Option<String>, bool) = database.one(standing, &names).await?;
    match gone {
        true => Err(withdrawn(&key.participant)),
        false => begun.as_deref().map(purpose).transpose(),
    }
}

fn purpose(word: &str) -> Result<Purpose, StoreError> {
    match word {
        "volunteer" => Ok(Purpose::Volunteer),
        "rehearsal" => Ok(Purpose::Rehearsal),
        _ => Err(damaged(format!("`{word}` is no purpose of a session"))),
    }
}

/// Where power cuts lose what was acknowledged, nothing of a volunteer is stored.
fn require_keeping(database: &Database, purpose: Purpose) -> Result<(), StoreError> {
    match purpose {
        Purpose::Volunteer => database.require_keeping(),
        Purpose::Rehearsal => Ok(()),
    }
}

async fn check_there(database: &mut Database, key: &SessionKey) -> Result<(), StoreError> {
    let found = "SELECT EXISTS (SELECT 1 FROM sessions WHERE participant = $1 AND session = $2)";
    let names = [Value::from(&key.participant), (&key.session).into()];
    match database.one(found, &names).await? {
        (true,) => Ok(()),
        (false,) => Err(StoreError::Unknown { key: key.clone() }),
    }
}

/// A row of `events`, from number to salt.
type Row = (i64, i64, Vec<u8>, Vec<u8>, Option<String>, Option<Vec<u8>>);

fn link((number, at_ms, payload_sha, sha, json, salt): Row) -> Result<Link, StoreError> {
    let payload = match (json, salt) {
        (Some(json), Some(salt)) => Some(Payload {
            json,
            salt: Salt::try_from(salt).map_err(|_salt| damaged("a salt is not of 16 bytes"))?,
        }),
        _ => None,
    };
    Ok(Link {
        number: number.unsigned_abs(),
        at_ms,
        payload_sha: checksum(&payload_sha)?,
        sha: checksum(&sha)?,
        payload,
    })
}

pub(super) fn checksum(bytes: &[u8]) -> Result<Sha, StoreError> {
    let text: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    Sha::try_from(text).map_err(|error| damaged(error.to_string()))
}

fn number_of(link: &Link) -> Result<i64, StoreError> {
    i64::try_from(link.number).map_err(|_number| damaged("too many events"))
}

async fn insert(database: &mut Database, key: &SessionKey, link: &Link) -> Result<(), StoreError> {
    let payload = link.payload.as_ref();
    let values = [
        Value::from(&key.participant),
        (&key.session).into(),
        number_of(link)?.into(),
        link.at_ms.into(),
        link.payload_sha.bytes()[..].into(),
        link.sha.bytes()[..].into(),
        Value::Text(payload.map(|payload| payload.json.as_str())),
        Value::Bytes(payload.map(|payload| &payload.salt[..])),
    ];
    let event = "INSERT INTO events VALUES ($1, $2, $3, $4, $5, $6, $7, $8)";
    database.execute(event, &values).await.map(|_| ())
}

/// Begins a session, within a transaction.
async fn begin(
    database: &mut Database,
    key: &SessionKey,
    purpose: Purpose,
) -> Result<(), StoreError> {
    let refused = |error: StudyError| StoreError::Place {
        why: error.to_string(),
        advice: "then begin the session again",
    };
    let name = Pseudonym::new(&key.participant).map_err(refused)?;
    require_keeping(database, purpose)?;
    if begun(database, key).await?.is_some() {
        return Err(StoreError::Exists { key: key.clone() });
    }
    let known = "SELECT participant FROM sessions UNION SELECT participant FROM withdrawals";
    let known: Vec<(String,)> = database.rows(known, &[]).await?;
    name.check_among(known.iter().map(|(name,)| name.as_str()))
        .map_err(refused)?;
    let purpose = match purpose {
        Purpose::Volunteer => "volunteer",
        Purpose::Rehearsal => "rehearsal",
    };
    let session = "INSERT INTO sessions (participant, session, purpose) VALUES ($1, $2, $3)";
    let values = [
        Value::from(&key.participant),
        (&key.session).into(),
        purpose.into(),
    ];
    database.execute(session, &values).await.map(|_| ())
}

/// Adds an event, within a transaction.
async fn append(
    database: &mut Database,
    key: &SessionKey,
    known: u64,
    event: NewEvent<'_>,
) -> Result<Link, StoreError> {
    let Some(purpose) = begun(database, key).await? else {
        return Err(StoreError::Unknown { key: key.clone() });
    };
    require_keeping(database, purpose)?;
    let last = "SELECT number, at_ms, payload_sha, sha, NULL, NULL FROM events \
        WHERE participant = $1 AND session = $2 ORDER BY number DESC LIMIT 1";
    let names = [Value::from(&key.participant), (&key.session).into()];
    let last: Option<Row> = database.row(last, &names).await?;
    let last = last.map(link).transpose()?;
    let found = last.as_ref().map_or(0, |link| link.number + 1);
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
    let link = next_link(key.names(), last.as_ref(), event.at_ms, payload);
    insert(database, key, &link).await?;
    Ok(link)
}

impl StudyStore {
    /// Whether exactly this event is stored, after a connection broke within its commit: waits until the server has ended what was left
    /// of that connection, so that the answer stays.
    fn is_stored(&mut self, key: &SessionKey, link: &Link) -> Result<bool, StoreError> {
        let number = number_of(link)?;
        let (stored, changes) = self.read(async |database| {
            database.begin().await?;
            let stored = "SELECT EXISTS (SELECT 1 FROM events WHERE participant = $1 AND session = $2 AND number = $3 AND sha = $4), \
                (SELECT changes FROM study)";
            let values = [
                Value::from(&key.participant),
                (&key.session).into(),
                number.into(),
                link.sha.bytes()[..].into(),
            ];
            let stored: Result<(bool, i64), _> = database.one(stored, &values).await;
            database.run("ROLLBACK").await?;
            stored
        })?;
        if stored {
            self.seal_changes(changes.unsigned_abs());
        }
        Ok(stored)
    }

    /// The time of the newest event or withdrawal, in ms since 1970-01-01 00:00 UTC; `None` before the first.
    ///
    /// # Errors
    /// [`StoreError::Place`].
    pub fn newest_ms(&self) -> Result<Option<i64>, StoreError> {
        self.read(async |database| {
            let newest = "SELECT max(at_ms) FROM (SELECT at_ms FROM events UNION ALL SELECT at_ms FROM withdrawals) AS all_times";
            let (newest,): (Option<i64>,) = database.one(newest, &[]).await?;
            Ok(newest)
        })
    }

    /// How many of the changes that the study counted are no session that was begun, no event and no withdrawal that was given once: the
    /// last events of sessions that were removed, or withdrawals that were given again. 0 where a server keeps the study, which counts
    /// plans too.
    ///
    /// # Errors
    /// [`StoreError::Place`].
    pub fn unexplained_changes(&self) -> Result<u64, StoreError> {
        let unexplained = self.counted()?.unexplained();
        Ok(unexplained.max(0).unsigned_abs())
    }

    /// The sessions that are there, also of a study from which some were removed: what a participant who withdraws has there is erased.
    ///
    /// # Errors
    /// [`StoreError::Place`], [`StoreError::Damaged`].
    pub fn entries(&self) -> Result<Vec<SessionEntry>, StoreError> {
        let rows = self.read(async |database| {
            let rows = "SELECT s.participant, s.session, s.purpose, w.at_ms, w.at_ms IS NOT NULL AND EXISTS \
                (SELECT 1 FROM events AS e WHERE e.participant = s.participant AND e.session = s.session AND e.payload IS NOT NULL) \
                FROM sessions AS s LEFT JOIN withdrawals AS w ON w.participant = s.participant ORDER BY s.begun";
            let rows: Vec<(String, String, String, Option<i64>, bool)> =
                database.rows(rows, &[]).await?;
            Ok(rows)
        })?;
        rows.into_iter().map(entry).collect()
    }

    fn counted(&self) -> Result<Counted, StoreError> {
        if self.kept() == Kept::OnServer {
            return Ok(Counted::default());
        }
        self.read(async |database| {
            let counts = "SELECT changes, (SELECT count(*) FROM sessions), (SELECT count(*) FROM events), \
                (SELECT count(*) FROM withdrawals) FROM study";
            let (changes, sessions, events, withdrawals) = database.one(counts, &[]).await?;
            Ok(Counted {
                changes,
                sessions,
                events,
                withdrawals,
            })
        })
    }

    /// Whether a participant has withdrawn, with sessions or before the first.
    pub(super) fn is_withdrawn(&self, participant: &Pseudonym) -> Result<bool, StoreError> {
        self.read(async |database| has_withdrawn(database, participant.as_str()).await)
    }
}

impl Store for StudyStore {
    fn begin(&mut self, key: &SessionKey, purpose: Purpose) -> Result<(), StoreError> {
        self.change(async |database| begin(database, key, purpose).await)
    }

    fn append(
        &mut self,
        key: &SessionKey,
        known: u64,
        event: NewEvent<'_>,
    ) -> Result<Link, StoreError> {
        match self.try_change(async |database| append(database, key, known, event).await)? {
            Changed::Stored(link) => Ok(link),
            Changed::Unsure(link, error) => match self.is_stored(key, &link) {
                Ok(true) => Ok(link),
                Ok(false) | Err(_) => Err(error),
            },
        }
    }

    fn events(&self, key: &SessionKey) -> Result<Vec<Link>, StoreError> {
        self.read(async |database| {
            check_there(database, key).await?;
            let rows = "SELECT number, at_ms, payload_sha, sha, payload, salt FROM events \
                WHERE participant = $1 AND session = $2 ORDER BY number";
            let names = [Value::from(&key.participant), (&key.session).into()];
            let rows: Vec<Row> = database.rows(rows, &names).await?;
            rows.into_iter().map(link).collect()
        })
    }

    /// The sessions in the order in which they were begun.
    ///
    /// # Errors
    /// [`StoreError::Gap`], [`StoreError::Changed`], [`StoreError::Broken`] and [`StoreError::Damaged`] where sessions or events were removed: whoever reads results reads this list first.
    fn sessions(&self) -> Result<Vec<SessionEntry>, StoreError> {
        let sessions = self.entries()?;
        if let Err(uncounted) = self.counted()?.verify() {
            // The chains say where it is, unless it was at an end.
            for entry in &sessions {
                entry.verify(&self.events(&entry.key)?)?;
            }
            return Err(uncounted);
        }
        Ok(sessions)
    }

    fn erase(&mut self, participant: &str, at_ms: i64) -> Result<usize, StoreError> {
        self.erase_payloads(participant, at_ms)
    }

    /// Verifies the file, the chains of all sessions, and how much of them is there; gives their number.
    fn verify(&self) -> Result<usize, StoreError> {
        self.read(async |database| database.check().await)?;
        let sessions = self.sessions()?;
        for entry in &sessions {
            entry.verify(&self.events(&entry.key)?)?;
        }
        Ok(sessions.len())
    }
}

/// How many changes a study counted, and what it holds of them.
#[derive(Default)]
struct Counted {
    changes: i64,
    sessions: i64,
    events: i64,
    withdrawals: i64,
}

impl Counted {
    /// The steps of a withdrawal: it is intended, files are erased, the database is rewritten.
    const STEPS: i64 = 3;

    /// The changes that nothing explains; fewer than 0 where withdrawals had fewer steps.
    fn unexplained(&self) -> i64 {
        self.changes - self.sessions - self.events - Self::STEPS * self.withdrawals
    }

    /// Refuses what no withdrawal explains, even one that was given again. What was removed from the end of a journal is found here, as the
    /// rest of a chain verifies.
    fn verify(&self) -> Result<(), StoreError> {
        let Self {
            changes,
            sessions,
            events,
            withdrawals,
        } = self;
        let unexplained = self.unexplained();
        let again = *withdrawals > 0 && unexplained % Self::STEPS == 0;
        let what = match unexplained {
            missing if missing > 0 && !again => {
                "the last events of sessions, or sessions, were removed"
            }
            _ if *changes < sessions + events + withdrawals => "some were added by another program",
            _ => return Ok(()),
        };
        Err(damaged(format!(
            "the study counted {changes} changes, and holds {sessions} sessions, {events} events and {withdrawals} withdrawals: {what}"
        )))
    }
}

/// What the database says of a session: names, purpose, when its participant withdrew, and whether events of it are there then.
fn entry(
    (participant, session, word, withdrawn_at_ms, kept): (
        String,
        String,
        String,
        Option<i64>,
        bool,
    ),
) -> Result<SessionEntry, StoreError> {
    // One transaction notes a withdrawal and erases its events.
    if kept {
        return Err(damaged(format!(
            "{participant} is noted as withdrawn, and events of session {session} are still there"
        )));
    }
    let purpose = purpose(&word)?;
    let key = SessionKey {
        participant,
        session,
    };
    Ok(SessionEntry {
        key,
        purpose,
        withdrawn_at_ms,
    })
}
