//! A session is run by one program at a time.

use super::{CampaignError, Pseudonym, SqliteStore};
use crate::lock::{Lock, LockError, LockFile};

/// The file that is locked while a session runs.
const RUNNING: &str = ".running";
/// The file that is locked while a study is simulated.
const SIMULATING: &str = ".simulating";

/// The exclusive right to run a session, until it is dropped or its program ends for any reason.
#[derive(Debug)]
pub struct SessionLock {
    _lock: Lock,
}

/// Why a session cannot be run now.
#[derive(Debug, thiserror::Error)]
pub enum RunningError {
    /// Another program runs it.
    #[error(
        "session {session} of {participant} is run by another program ({by}): end it there, or wait until it has ended"
    )]
    Held {
        /// Whose.
        participant: String,
        /// The session.
        session: String,
        /// Who runs it.
        by: String,
    },
    /// Another program simulates the study.
    #[error(
        "{}: another program simulates this study ({by}): end it there, or wait until it has ended", folder.display()
    )]
    Simulated {
        /// The study.
        folder: std::path::PathBuf,
        /// Who does.
        by: String,
    },
    /// Its folder cannot be had.
    #[error(transparent)]
    Folder(#[from] CampaignError),
    /// The operating system refuses the file.
    #[error("{path}: {source}; a session needs a folder that can be written", path = .path.display())]
    Io {
        /// The file.
        path: std::path::PathBuf,
        /// The error.
        source: std::io::Error,
    },
}

impl SqliteStore {
    /// Takes the exclusive right to simulate the study: two programs would mix what they present.
    ///
    /// # Errors
    /// [`RunningError::Simulated`] while another program has it.
    pub fn simulate_alone(&self) -> Result<SessionLock, RunningError> {
        let path = self.folder.join(SIMULATING);
        let lock = Lock::take(&path, LockFile::Goes);
        lock.map(|lock| SessionLock { _lock: lock })
            .map_err(|error| match error {
                LockError::Held(by) => RunningError::Simulated {
                    folder: self.folder.clone(),
                    by,
                },
                LockError::Io(source) => RunningError::Io { path, source },
            })
    }

    /// Takes the exclusive right to run `session` of `participant`: what is played and recorded there is not replaced by a second
    /// program.
    ///
    /// # Errors
    /// [`RunningError::Held`] while another program has it.
    pub fn run_alone(
        &self,
        participant: &Pseudonym,
        session: &str,
    ) -> Result<SessionLock, RunningError> {
        let folder = self.session_folder(participant, session)?;
        let path = folder.join(RUNNING);
        let io = |source| RunningError::Io {
            path: path.clone(),
            source,
        };
        std::fs::create_dir_all(&folder).map_err(io)?;
        let lock = Lock::take(&path, LockFile::Goes);
        lock.map(|lock| SessionLock { _lock: lock })
            .map_err(|error| match error {
                LockError::Held(by) => RunningError::Held {
                    participant: participant.to_string(),
                    session: session.to_owned(),
                    by,
                },
                LockError::Io(source) => io(source),
            })
    }
}
