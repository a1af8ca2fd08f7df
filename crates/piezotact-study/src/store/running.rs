//! A session is run by one program at a time.

use crate::store::error::StudyError;
use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::store::StoreError;

use super::database::Database;
use super::postgres::Locked;
use super::{Pseudonym, StudyStore};
use piezotact_dataset::WriteError;
use piezotact_dataset::lock::{Lock, LockFile};

/// The file that is locked while a session runs.
const RUNNING: &str = ".running";
/// The file that is locked while a study is simulated.
const SIMULATING: &str = ".simulating";

/// The exclusive right to run a session, until it is dropped or its program ends for any reason.
///
/// Where several stations share the study, the right is taken at the server as well, and stays until the store is closed.
#[derive(Debug)]
pub struct SessionLock {
    _lock: Lock,
}

impl StudyStore {
    /// Takes the exclusive right to simulate the study: two programs would mix what they present.
    ///
    /// # Errors
    /// [`StudyError::Simulated`] while another program has it.
    pub fn simulate_alone(&self) -> Result<SessionLock, StudyError> {
        let path = self.folder.join(SIMULATING);
        let lock = Lock::take(&path, LockFile::Goes);
        lock.map(|lock| SessionLock { _lock: lock })
            .map_err(|error| match error {
                WriteError::Held { by, .. } => StudyError::Simulated {
                    folder: self.folder.clone(),
                    by,
                },
                other => not_writable(path, &other),
            })
    }

    /// Takes the exclusive right to run `session` of `participant`: what is played and recorded there is not replaced by a second
    /// program.
    ///
    /// # Errors
    /// [`StudyError::Running`] while another program has it.
    pub fn run_alone(
        &self,
        participant: &Pseudonym,
        session: &str,
    ) -> Result<SessionLock, StudyError> {
        let folder = self.session_folder(participant, session)?;
        let path = folder.join(RUNNING);
        let made = std::fs::create_dir_all(&folder);
        made.map_err(|error| not_writable(path.clone(), &error))?;
        let held = |by| StudyError::Running {
            participant: participant.to_string(),
            session: session.to_owned(),
            by,
        };
        let lock = Lock::take(&path, LockFile::Goes).map_err(|error| match error {
            WriteError::Held { by, .. } => held(by),
            other => not_writable(path.clone(), &other),
        })?;
        match self.lock_at_server(participant, session)? {
            Locked::Taken => Ok(SessionLock { _lock: lock }),
            Locked::Held(by) => Err(held(by)),
        }
    }

    /// Takes the advisory lock of a session for the life of the connection, where the study is on a server.
    fn lock_at_server(&self, participant: &Pseudonym, session: &str) -> Result<Locked, StoreError> {
        let Some(line) = &self.line else {
            return Ok(Locked::Taken);
        };
        let parts = [self.study(), participant.as_str(), session];
        let sum = Sha::of_parts(&parts.map(str::as_bytes));
        let mut first = [0; 8];
        first.copy_from_slice(&sum.bytes()[..8]);
        let key = i64::from_be_bytes(first);
        if line.locks.borrow().contains(&key) {
            // The file alone keeps other programs of this station out, and the others wait for this one.
            return Ok(Locked::Taken);
        }
        let locked = self.read(async |database| match database {
            Database::Server(server) => server.lock(key).await,
            Database::File(_) => Ok(Locked::Taken),
        })?;
        if matches!(locked, Locked::Taken) {
            line.locks.borrow_mut().push(key);
        }
        Ok(locked)
    }
}

fn not_writable(path: std::path::PathBuf, error: &dyn std::fmt::Display) -> StudyError {
    StudyError::Place {
        path,
        why: error.to_string(),
        advice: "a session needs a folder that can be written",
    }
}
