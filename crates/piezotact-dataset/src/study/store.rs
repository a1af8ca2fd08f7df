//! The store of a campaign in SQLite.

use std::cell::RefCell;
use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use piezotact_people::campaign::chain::{Link, Payload, Salt, Sha, next_link};
use piezotact_people::campaign::store::{
    NewEvent, Purpose, SessionEntry, SessionKey, Store, StoreError,
};
use sqlx::Connection as _;
use sqlx::sqlite::SqliteConnection;
use tokio::runtime::Runtime;

use super::error::{StudyError, advice_on_io, damaged, place};
use super::opening::{Begin, check_file, closed, connect, empty_log, lost};
use super::pseudonym::Pseudonym;
use super::seal::{self, Found, SEAL, Seal, Sealed};
use super::{DATABASE, PARTICIPANTS};

/// How long a write waits for another program: a withdrawal rewrites the file.
const PATIENCE: Duration = Duration::from_secs(5);

/// A study in a folder. Not to be called from an asynchronous task, as it waits for the disk: hand it to a thread of its own.
pub struct SqliteStore {
    pub(super) folder: PathBuf,
    runtime: Runtime,
    /// `None` only while it is dropped.
    connection: RefCell<Option<SqliteConnection>>,
    seal: Seal,
    /// Changes that are stored and not sealed, as the seal could not be written.
    unsealed: Option<u64>,
}

impl fmt::Debug for SqliteStore {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut shown = f.debug_struct("SqliteStore");
        shown.field("folder", &self.folder).finish_non_exhaustive()
    }
}

impl Drop for SqliteStore {
    fn drop(&mut self) {
        // Within an asynchronous task the worker closes it a moment later.
        if let Some(connection) = self.connection.get_mut().take()
            && tokio::runtime::Handle::try_current().is_err()
        {
            let _best_effort = self.runtime.block_on(connection.close());
        }
    }
}

impl SqliteStore {
    /// Creates the study in `folder`, which is made where it is not there. A creation that was interrupted is completed.
    ///
    /// # Errors
    /// [`StudyError`].
    pub fn create(folder: &Path) -> Result<Self, StudyError> {
        std::fs::create_dir_all(folder).map_err(StudyError::io(folder))?;
        Self::begin_at(folder, Begin::Create, PATIENCE)
    }

    /// Opens the study in `folder`. What a crash has left is put in order, and a withdrawal that was interrupted completed.
    ///
    /// # Errors
    /// [`StudyError`]; [`StudyError::Lost`] where the folder holds less than was acknowledged.
    pub fn open(folder: &Path) -> Result<Self, StudyError> {
        Self::open_waiting(folder, PATIENCE)
    }

    /// As [`Self::open`]; a write waits as long as `patience` for another program.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn open_waiting(folder: &Path, patience: Duration) -> Result<Self, StudyError> {
        Self::begin_at(folder, Begin::Open, patience)
    }

    fn begin_at(folder: &Path, begin: Begin, patience: Duration) -> Result<Self, StudyError> {
        // A relative path that begins with `file:` would be an address to SQLite.
        let folder = std::path::absolute(folder).map_err(StudyError::io(folder))?;
        let path = folder.join(DATABASE);
        check_file(&folder, &path, begin)?;
        let runtime = tokio::runtime::Builder::new_current_thread().build();
        let runtime = runtime.map_err(StudyError::io(&folder))?;
        // Before the database is read: the seal never is ahead of it.
        let found = seal::find(&folder).map_err(StudyError::io(&folder.join(SEAL)))?;
        let opening = connect(&path, begin, patience, &found);
        let (connection, sealed) = runtime.block_on(opening)?;
        let seal = match acknowledged(&folder, &found, &sealed) {
            Ok(seal) => seal,
            Err(error) => {
                runtime.block_on(closed(connection));
                return Err(error);
            }
        };
        let mut store = Self {
            folder,
            runtime,
            connection: RefCell::new(Some(connection)),
            seal,
            unsealed: None,
        };
        // A commit that was not acknowledged any more is there, and stays.
        store.unsealed = Some(sealed.changes);
        store.complete_withdrawals()?;
        Ok(store)
    }

    /// The folder of the study, as an absolute path.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// The folder of a participant's files, whether it is there or not.
    #[must_use]
    pub fn participant_folder(&self, participant: &Pseudonym) -> PathBuf {
        self.folder.join(PARTICIPANTS).join(participant.as_str())
    }

    /// Whether a participant has withdrawn, with sessions or before the first.
    pub(super) fn is_withdrawn(&self, participant: &Pseudonym) -> Result<bool, StoreError> {
        self.read(async |connection| has_withdrawn(connection, participant.as_str()).await)
    }

    /// Reads from the database.
    pub(super) fn read<T>(
        &self,
        act: impl AsyncFnOnce(&mut SqliteConnection) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        let mut connection = self.connection.borrow_mut();
        match connection.as_mut() {
            Some(connection) => self.runtime.block_on(act(connection)),
            None => Err(damaged("the study is closed")),
        }
    }

    /// Changes the database in one transaction: everything that `act` does is on the disk when this returns, or nothing of it.
    pub(super) fn change<T>(
        &mut self,
        act: impl AsyncFnOnce(&mut SqliteConnection) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        // What is acknowledged next stands on what could not be sealed.
        if let Some(changes) = self.unsealed {
            self.seal.set(changes).map_err(seal_error)?;
            self.unsealed = None;
        }
        let (done, changes) = self.read(async |connection| {
            // At once a write: a read that became one would not wait for another program.
            run(connection, "BEGIN IMMEDIATE").await?;
            match act_and_commit(connection, act).await {
                Ok(done) => Ok(done),
                Err(error) => {
                    // Where SQLite has rolled back by itself, there is nothing to roll back.
                    let _already = run(connection, "ROLLBACK").await;
                    Err(error)
                }
            }
        })?;
        // It is on the disk: where the seal cannot be written, it is before the next change.
        if self.seal.set(changes).is_err() {
            self.unsealed = Some(changes);
        }
        Ok(done)
    }

    /// Removes what erased payloads left in the files: the database is rewritten and its log emptied.
    pub(super) fn scrub(&self) -> Result<(), StoreError> {
        self.read(async |connection| {
            run(connection, "VACUUM").await?;
            empty_log(connection).await.map_err(place)
        })
    }
}

/// The seal of the study in `folder`, which holds everything that was acknowledged.
fn acknowledged(folder: &Path, found: &Found, sealed: &Sealed) -> Result<Seal, StudyError> {
    match found {
        Found::Damaged => {
            let path = folder.join(SEAL);
            return Err(StudyError::Seal { path });
        }
        Found::Whole(found) if found.study != sealed.study => {
            let path = folder.join(SEAL);
            return Err(StudyError::Seal { path });
        }
        Found::Whole(found) if found.changes > sealed.changes => {
            return Err(lost(folder, found.changes, sealed.changes));
        }
        _ => {}
    }
    let participants = folder.join(PARTICIPANTS);
    if !participants.exists() {
        std::fs::create_dir_all(&participants).map_err(StudyError::io(&participants))?;
    }
    Seal::open(folder, sealed).map_err(StudyError::io(&folder.join(SEAL)))
}

async fn act_and_commit<T>(
    connection: &mut SqliteConnection,
    act: impl AsyncFnOnce(&mut SqliteConnection) -> Result<T, StoreError>,
) -> Result<(T, u64), StoreError> {
    let done = act(connection).await?;
    let counted = sqlx::query_scalar("UPDATE study SET changes = changes + 1 RETURNING changes");
    let changes: i64 = counted.fetch_one(&mut *connection).await.map_err(place)?;
    run(connection, "COMMIT").await?;
    Ok((done, changes.unsigned_abs()))
}

async fn run(connection: &mut SqliteConnection, statement: &'static str) -> Result<(), StoreError> {
    let done = sqlx::raw_sql(statement).execute(connection).await;
    done.map(|_| ()).map_err(place)
}

fn seal_error(error: std::io::Error) -> StoreError {
    StoreError::Place {
        advice: advice_on_io(&error),
        why: format!("{SEAL}: {error}"),
    }
}

pub(super) async fn has_withdrawn(
    connection: &mut SqliteConnection,
    participant: &str,
) -> Result<bool, StoreError> {
    let found =
        sqlx::query_scalar("SELECT EXISTS (SELECT 1 FROM withdrawals WHERE participant = ?)");
    found
        .bind(participant)
        .fetch_one(connection)
        .await
        .map_err(place)
}

async fn refuse_withdrawn(
    connection: &mut SqliteConnection,
    participant: &str,
) -> Result<(), StoreError> {
    match has_withdrawn(connection, participant).await? {
        true => Err(StoreError::Withdrawn {
            participant: participant.to_owned(),
        }),
        false => Ok(()),
    }
}

async fn is_there(connection: &mut SqliteConnection, key: &SessionKey) -> Result<bool, StoreError> {
    let found = sqlx::query_scalar(
        "SELECT EXISTS (SELECT 1 FROM sessions WHERE participant = ? AND session = ?)",
    );
    let found = found.bind(&key.participant).bind(&key.session);
    found.fetch_one(connection).await.map_err(place)
}

async fn check_there(
    connection: &mut SqliteConnection,
    key: &SessionKey,
) -> Result<(), StoreError> {
    match is_there(connection, key).await? {
        true => Ok(()),
        false => Err(StoreError::Unknown { key: key.clone() }),
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

fn checksum(bytes: &[u8]) -> Result<Sha, StoreError> {
    let text: String = bytes.iter().map(|byte| format!("{byte:02x}")).collect();
    Sha::try_from(text).map_err(|error| damaged(error.to_string()))
}

async fn insert(
    connection: &mut SqliteConnection,
    key: &SessionKey,
    link: &Link,
) -> Result<(), StoreError> {
    let (json, salt) = match &link.payload {
        Some(payload) => (Some(&payload.json), Some(&payload.salt[..])),
        None => (None, None),
    };
    let number = i64::try_from(link.number).map_err(|_number| damaged("too many events"))?;
    let event = sqlx::query("INSERT INTO events VALUES (?, ?, ?, ?, ?, ?, ?, ?)");
    let event = event
        .bind(&key.participant)
        .bind(&key.session)
        .bind(number)
        .bind(link.at_ms);
    let event = event
        .bind(&link.payload_sha.bytes()[..])
        .bind(&link.sha.bytes()[..]);
    let done = event.bind(json).bind(salt).execute(connection).await;
    done.map(|_| ()).map_err(place)
}

impl Store for SqliteStore {
    fn begin(&mut self, key: &SessionKey, purpose: Purpose) -> Result<(), StoreError> {
        let refused = |error: super::PseudonymError| StoreError::Place {
            why: error.to_string(),
            advice: "then begin the session again",
        };
        let name = Pseudonym::new(&key.participant).map_err(refused)?;
        let purpose = match purpose {
            Purpose::Volunteer => "volunteer",
            Purpose::Rehearsal => "rehearsal",
        };
        self.change(async |connection| {
            refuse_withdrawn(connection, name.as_str()).await?;
            if is_there(connection, key).await? {
                return Err(StoreError::Exists { key: key.clone() });
            }
            let known = sqlx::query_scalar(
                "SELECT participant FROM sessions UNION SELECT participant FROM withdrawals",
            );
            let known: Vec<String> = known.fetch_all(&mut *connection).await.map_err(place)?;
            name.check_among(known.iter().map(String::as_str))
                .map_err(refused)?;
            let session = sqlx::query(
                "INSERT INTO sessions (participant, session, purpose) VALUES (?, ?, ?)",
            );
            let session = session
                .bind(&key.participant)
                .bind(&key.session)
                .bind(purpose);
            session.execute(connection).await.map(|_| ()).map_err(place)
        })
    }

    fn append(
        &mut self,
        key: &SessionKey,
        known: u64,
        event: NewEvent<'_>,
    ) -> Result<Link, StoreError> {
        self.change(async |connection| {
            refuse_withdrawn(connection, &key.participant).await?;
            check_there(connection, key).await?;
            let last = sqlx::query_as(
                "SELECT number, at_ms, payload_sha, sha, NULL, NULL FROM events \
                 WHERE participant = ? AND session = ? ORDER BY number DESC LIMIT 1",
            );
            let last = last.bind(&key.participant).bind(&key.session);
            let last: Option<Row> = last.fetch_optional(&mut *connection).await.map_err(place)?;
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
            insert(connection, key, &link).await?;
            Ok(link)
        })
    }

    fn events(&self, key: &SessionKey) -> Result<Vec<Link>, StoreError> {
        self.read(async |connection| {
            check_there(connection, key).await?;
            let rows = sqlx::query_as(
                "SELECT number, at_ms, payload_sha, sha, payload, salt FROM events \
                 WHERE participant = ? AND session = ? ORDER BY number",
            );
            let rows = rows.bind(&key.participant).bind(&key.session);
            let rows: Vec<Row> = rows.fetch_all(connection).await.map_err(place)?;
            rows.into_iter().map(link).collect()
        })
    }

    fn sessions(&self) -> Result<Vec<SessionEntry>, StoreError> {
        let rows = self.read(async |connection| {
            let rows = sqlx::query_as(
                "SELECT s.participant, s.session, s.purpose, w.at_ms, w.at_ms IS NOT NULL AND EXISTS \
                 (SELECT 1 FROM events AS e WHERE e.participant = s.participant AND e.session = s.session AND e.payload IS NOT NULL) \
                 FROM sessions AS s LEFT JOIN withdrawals AS w ON w.participant = s.participant ORDER BY s.begun",
            );
            let rows: Vec<(String, String, String, Option<i64>, bool)> =
                rows.fetch_all(connection).await.map_err(place)?;
            Ok(rows)
        })?;
        let entry = |(participant, session, purpose, withdrawn_at_ms, kept): (
            _,
            _,
            String,
            _,
            bool,
        )| {
            // One transaction notes a withdrawal and erases its events.
            if kept {
                return Err(damaged(format!(
                    "{participant} is noted as withdrawn, and events of session {session} are still there"
                )));
            }
            let purpose = match purpose.as_str() {
                "volunteer" => Purpose::Volunteer,
                "rehearsal" => Purpose::Rehearsal,
                _ => return Err(damaged(format!("`{purpose}` is no purpose of a session"))),
            };
            let key = SessionKey {
                participant,
                session,
            };
            Ok(SessionEntry {
                key,
                purpose,
                withdrawn_at_ms,
            })
        };
        rows.into_iter().map(entry).collect()
    }

    fn erase(&mut self, participant: &str, at_ms: i64) -> Result<usize, StoreError> {
        self.erase_payloads(participant, at_ms)
    }

    /// Verifies the file and the chains of all sessions; gives their number.
    fn verify(&self) -> Result<usize, StoreError> {
        let found: String = self.read(async |connection| {
            let check = sqlx::query_scalar("PRAGMA integrity_check(1)");
            check.fetch_one(connection).await.map_err(place)
        })?;
        if found != "ok" {
            return Err(damaged(found));
        }
        let sessions = self.sessions()?;
        for entry in &sessions {
            entry.verify(&self.events(&entry.key)?)?;
        }
        Ok(sessions.len())
    }
}
