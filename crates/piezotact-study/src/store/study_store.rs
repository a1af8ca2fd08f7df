//! The store of a campaign in a database: of the study's folder (SQLite), or of a server that several stations share (PostgreSQL).

use std::cell::{Cell, RefCell};
use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Duration;

use piezotact_people::campaign::store::StoreError;
use tokio::runtime::Runtime;

use super::database::{Database, Remains};
use super::error::{Kept, StudyError, advice_on_io, damaged, lost};
use super::opening::{Access, Begin, access, check_file, connect};
use super::postgres::{ANSWERING, DatabaseUrl, End, REWRITING, Server};
use super::pseudonym::Pseudonym;
use super::seal::{self, Found, SEAL, Seal, Sealed};
use super::shared::{self, Notice};
use super::{DATABASE, PARTICIPANTS};

/// How long a write waits for another program: a withdrawal rewrites the file.
const PATIENCE: Duration = Duration::from_secs(5);

/// A study in a folder. Not to be called from an asynchronous task, as it waits for the disk: hand it to a thread of its own.
pub struct StudyStore {
    pub(super) folder: PathBuf,
    runtime: Runtime,
    /// `None` while it is dropped, and behind a connection to a server that broke.
    database: RefCell<Option<Database>>,
    pub(super) line: Option<Line>,
    /// The study by which the seal knows its database.
    study: String,
    /// How many changes were acknowledged.
    changes: Cell<u64>,
    /// `None` where the folder can only be read.
    seal: Option<Seal>,
    /// Changes that are stored and not sealed, as the seal could not be written.
    unsealed: Option<u64>,
    pub(super) notices: Vec<Notice>,
}

/// What a connection to a server that broke is made again with.
pub(super) struct Line {
    pub(super) url: DatabaseUrl,
    /// The server's end of the connection that broke.
    earlier: RefCell<Option<End>>,
    /// The locks that belong to the connection.
    pub(super) locks: RefCell<Vec<i64>>,
}

/// How a change ended.
pub(super) enum Changed<T> {
    /// It is on the disk.
    Stored(T),
    /// The connection broke before the server said whether it is: what it would be, and what was said.
    Unsure(T, StoreError),
}

impl fmt::Debug for StudyStore {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut shown = f.debug_struct("StudyStore");
        shown.field("folder", &self.folder).finish_non_exhaustive()
    }
}

impl Drop for StudyStore {
    fn drop(&mut self) {
        // Within an asynchronous task the worker closes it a moment later.
        if let Some(database) = self.database.get_mut().take()
            && tokio::runtime::Handle::try_current().is_err()
        {
            self.runtime.block_on(database.close());
        }
    }
}

impl StudyStore {
    /// Creates the study in `folder`, which is made where it is not there. A creation that was interrupted is completed.
    ///
    /// # Errors
    /// [`StudyError`].
    pub fn create(folder: &Path) -> Result<Self, StudyError> {
        std::fs::create_dir_all(folder).map_err(StudyError::io(folder))?;
        shared::require_no_url(folder)?;
        Self::in_folder(folder, Begin::Create, PATIENCE)
    }

    /// Creates the study in the database at `url`, with its files in `folder`, which is made where it is not there.
    ///
    /// # Errors
    /// [`StudyError`]; [`StudyError::Taken`] where the database holds a study.
    pub fn create_on(folder: &Path, url: &DatabaseUrl) -> Result<Self, StudyError> {
        shared::require_free(folder, url)?;
        Self::on_server(folder, url, Begin::Create)
    }

    /// Opens the study in the database at `url` with the files of this station in `folder`, which is made where it is not there.
    ///
    /// # Errors
    /// [`StudyError`].
    pub fn join(folder: &Path, url: &DatabaseUrl) -> Result<Self, StudyError> {
        shared::require_free(folder, url)?;
        Self::on_server(folder, url, Begin::Open)
    }

    /// Opens the study in `folder`. What a crash has left is put in order, and a withdrawal that was interrupted completed. One that
    /// can only be read is opened as it is, and refuses changes.
    ///
    /// # Errors
    /// [`StudyError`]; [`StudyError::Lost`] where the folder holds less than was acknowledged.
    pub fn open(folder: &Path) -> Result<Self, StudyError> {
        Self::open_waiting(folder, PATIENCE)
    }

    /// As [`Self::open`]; a write waits as long as `patience` for another program. A server has a patience of its own, 5 s.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn open_waiting(folder: &Path, patience: Duration) -> Result<Self, StudyError> {
        match shared::url_of(folder)? {
            Some(url) => {
                shared::require_free(folder, &url)?;
                Self::on_server(folder, &url, Begin::Open)
            }
            None => Self::in_folder(folder, Begin::Open, patience),
        }
    }

    /// What `act` reads in the database at `url`, without a folder.
    pub(super) fn probe<T>(
        url: &DatabaseUrl,
        act: impl AsyncFnOnce(&mut Database) -> Result<T, StoreError>,
    ) -> Result<T, StudyError> {
        let runtime = runtime(Path::new(url.as_str()))?;
        runtime.block_on(async {
            let (server, _) = Server::open(url, Begin::Open).await?;
            let mut database = Database::Server(server);
            let found = database.within(ANSWERING, act).await;
            database.close().await;
            found.map_err(|error| StudyError::Place {
                path: url.as_str().into(),
                why: error.to_string(),
                advice: "then do the same again",
            })
        })
    }

    fn in_folder(folder: &Path, begin: Begin, patience: Duration) -> Result<Self, StudyError> {
        // A relative path that begins with `file:` would be an address to SQLite.
        let folder = std::path::absolute(folder).map_err(StudyError::io(folder))?;
        let path = folder.join(DATABASE);
        check_file(&folder, &path, begin)?;
        let runtime = runtime(&folder)?;
        // Before the database is read: the seal never is ahead of it.
        let found = seal::find(&folder).map_err(StudyError::io(&folder.join(SEAL)))?;
        let access = match begin {
            Begin::Open => access(&path)?,
            Begin::Create => Access::Written,
        };
        let opening = connect(&path, (begin, access), patience, &found);
        let (connection, sealed) = runtime.block_on(opening)?;
        let database = Database::File(connection);
        Self::sealed(folder, runtime, database, (found, sealed, access), None)
    }

    fn on_server(folder: &Path, url: &DatabaseUrl, begin: Begin) -> Result<Self, StudyError> {
        let folder = std::path::absolute(folder).map_err(StudyError::io(folder))?;
        let runtime = runtime(&folder)?;
        let found = seal::find(&folder).map_err(StudyError::io(&folder.join(SEAL)))?;
        let (server, sealed) = runtime.block_on(Server::open(url, begin))?;
        std::fs::create_dir_all(&folder).map_err(StudyError::io(&folder))?;
        shared::write_url(&folder, url)?;
        let line = Line {
            url: url.clone(),
            earlier: RefCell::default(),
            locks: RefCell::default(),
        };
        let database = Database::Server(server);
        let found = (found, sealed, Access::Written);
        Self::sealed(folder, runtime, database, found, Some(line))
    }

    /// The study whose database holds everything that was acknowledged.
    fn sealed(
        folder: PathBuf,
        runtime: Runtime,
        database: Database,
        (found, sealed, access): (Found, Sealed, Access),
        line: Option<Line>,
    ) -> Result<Self, StudyError> {
        let seal = match acknowledged(&folder, line.as_ref(), &found, &sealed)
            .and_then(|()| written_seal(&folder, access, &sealed))
        {
            Ok(seal) => seal,
            Err(error) => {
                runtime.block_on(database.close());
                return Err(error);
            }
        };
        let mut store = Self {
            folder,
            runtime,
            database: RefCell::new(Some(database)),
            line,
            study: sealed.study,
            changes: Cell::new(sealed.changes),
            seal,
            // A commit that was not acknowledged any more is there, and stays.
            unsealed: Some(sealed.changes),
            notices: Vec::new(),
        };
        if access == Access::Written {
            store.complete_withdrawals()?;
        }
        Ok(store)
    }

    /// The folder of the study, as an absolute path.
    #[must_use]
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Where its answers are kept.
    #[must_use]
    pub fn kept(&self) -> Kept {
        match self.line {
            None => Kept::InFolder,
            Some(_) => Kept::OnServer,
        }
    }

    /// The folder of a participant's files, whether it is there or not.
    #[must_use]
    pub fn participant_folder(&self, participant: &Pseudonym) -> PathBuf {
        self.folder.join(PARTICIPANTS).join(participant.as_str())
    }

    /// Reads from the database.
    pub(super) fn read<T>(
        &self,
        act: impl AsyncFnOnce(&mut Database) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        self.within(ANSWERING, act)
    }

    /// What `act` does with the database, within `limit`. A connection that broke before is made again.
    fn within<T>(
        &self,
        limit: Duration,
        act: impl AsyncFnOnce(&mut Database) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        let mut slot = self.database.borrow_mut();
        let mut database = match slot.take() {
            Some(database) => database,
            None => self.connected_again()?,
        };
        let done = self.runtime.block_on(database.within(limit, act));
        match (&self.line, &database) {
            (Some(line), Database::Server(server)) if server.is_gone() => {
                *line.earlier.borrow_mut() = Some(server.end());
            }
            _ => *slot = Some(database),
        }
        done
    }

    /// The connection to the server once more: to the same study, with all that was acknowledged, and with the locks of this program.
    fn connected_again(&self) -> Result<Database, StoreError> {
        let Some(line) = &self.line else {
            return Err(damaged("the study is closed"));
        };
        self.runtime.block_on(async {
            let opened = Server::open(&line.url, Begin::Open).await;
            let (mut server, sealed) = opened.map_err(StudyError::into_store_error)?;
            if sealed.study != self.study {
                return Err(StoreError::Place {
                    why: "expected the study that was open, found another one in its place".into(),
                    advice: "open the study again",
                });
            }
            if sealed.changes < self.changes.get() {
                return Err(StoreError::Place {
                    why: lost(Kept::OnServer, self.changes.get(), sealed.changes),
                    advice: "then open the study again",
                });
            }
            let earlier = line.earlier.borrow().clone();
            if let Some(end) = earlier {
                server.end_earlier(&end).await?;
                // What it was storing is there from here on, or never.
                server.begin().await?;
                server.roll_back().await?;
            }
            let locks = line.locks.borrow().clone();
            for key in locks {
                server.lock_again(key).await?;
            }
            Ok(Database::Server(server))
        })
    }

    /// Changes the database in one transaction: everything that `act` does is on the disk when this returns, or nothing of it.
    pub(super) fn change<T>(
        &mut self,
        act: impl AsyncFnOnce(&mut Database) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        match self.try_change(act)? {
            Changed::Stored(done) => Ok(done),
            Changed::Unsure(_, error) => Err(error),
        }
    }

    /// As [`Self::change`]; tells a connection that broke within the commit from a change that was not stored.
    pub(super) fn try_change<T>(
        &mut self,
        act: impl AsyncFnOnce(&mut Database) -> Result<T, StoreError>,
    ) -> Result<Changed<T>, StoreError> {
        let Some(seal) = &mut self.seal else {
            return Err(StoreError::Place {
                why: format!("{}: this study can only be read", self.folder.display()),
                advice: "copy its folder to a disk that can be written",
            });
        };
        // What is acknowledged next stands on what could not be sealed.
        if let Some(changes) = self.unsealed {
            seal.set(changes).map_err(seal_error)?;
            self.unsealed = None;
        }
        let (done, changes) = self.read(async |database| {
            database.begin().await?;
            let done = act_and_count(database, act).await;
            if done.is_err() {
                // Where the database has rolled back by itself, there is nothing to roll back.
                let _already = database.run("ROLLBACK").await;
            }
            done
        })?;
        let committed = self.read(async |database| {
            let committed = database.run("COMMIT").await;
            if committed.is_err() && !database.is_gone() {
                let _already = database.run("ROLLBACK").await;
            }
            committed
        });
        match committed {
            Ok(()) => {
                self.seal_changes(changes);
                Ok(Changed::Stored(done))
            }
            Err(error) if self.is_cut_off() => Ok(Changed::Unsure(done, error)),
            Err(error) => Err(error),
        }
    }

    /// Whether the connection to the server broke.
    fn is_cut_off(&self) -> bool {
        self.database.borrow().is_none()
    }

    /// Notes that `changes` are stored: where the seal cannot be written, it is before the next change.
    pub(super) fn seal_changes(&mut self, changes: u64) {
        self.changes.set(changes);
        let sealed = self.seal.as_mut().map(|seal| seal.set(changes));
        if sealed.is_some_and(|sealed| sealed.is_err()) {
            self.unsealed = Some(changes);
        }
    }

    /// Removes what erased payloads left in the database.
    pub(super) fn scrub(&self) -> Result<Remains, StoreError> {
        self.within(REWRITING, async |database| database.scrub().await)
    }

    /// The study, by which its seal knows it: 32 hexadecimal digits.
    pub(super) fn study(&self) -> &str {
        &self.study
    }
}

fn runtime(folder: &Path) -> Result<Runtime, StudyError> {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build();
    runtime.map_err(StudyError::io(folder))
}

/// Refuses a study in `folder` that does not hold everything that was acknowledged.
fn acknowledged(
    folder: &Path,
    line: Option<&Line>,
    found: &Found,
    sealed: &Sealed,
) -> Result<(), StudyError> {
    match (found, line) {
        (Found::Whole(found), Some(line)) if found.study != sealed.study => {
            Err(StudyError::Server {
                url: line.url.to_string(),
                why: "expected the study of this folder, found another one".into(),
                advice: "correct the URL in study.url, or restore the database from a backup",
            })
        }
        (Found::Damaged, _) => Err(StudyError::Seal {
            path: folder.join(SEAL),
        }),
        (Found::Whole(found), None) if found.study != sealed.study => Err(StudyError::Seal {
            path: folder.join(SEAL),
        }),
        (Found::Whole(found), line) if found.changes > sealed.changes => Err(StudyError::Lost {
            folder: folder.to_owned(),
            kept: line.map_or(Kept::InFolder, |_| Kept::OnServer),
            acknowledged: found.changes,
            found: sealed.changes,
        }),
        _ => Ok(()),
    }
}

/// The seal of the study in `folder`, where it can be written.
fn written_seal(
    folder: &Path,
    access: Access,
    sealed: &Sealed,
) -> Result<Option<Seal>, StudyError> {
    if access == Access::OnlyRead {
        return Ok(None);
    }
    let participants = folder.join(PARTICIPANTS);
    if !participants.exists() {
        std::fs::create_dir_all(&participants).map_err(StudyError::io(&participants))?;
    }
    let seal = Seal::open(folder, sealed).map_err(StudyError::io(&folder.join(SEAL)))?;
    Ok(Some(seal))
}

/// What `act` gives, and how many changes there are with it. The count comes last: a transaction that failed within refuses it.
async fn act_and_count<T>(
    database: &mut Database,
    act: impl AsyncFnOnce(&mut Database) -> Result<T, StoreError>,
) -> Result<(T, u64), StoreError> {
    let done = act(database).await?;
    let counted = "UPDATE study SET changes = changes + 1 RETURNING changes";
    let (changes,): (i64,) = database.one(counted, &[]).await?;
    Ok((done, changes.unsigned_abs()))
}

fn seal_error(error: std::io::Error) -> StoreError {
    StoreError::Place {
        advice: advice_on_io(&error),
        why: format!("{SEAL}: {error}"),
    }
}
