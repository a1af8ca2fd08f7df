//! What a study with virtual volunteers keeps beside its store: how it was simulated, and what was felt with what was answered.

use crate::store::error::StudyError;
use std::path::PathBuf;

use serde::Serialize;
use serde::de::DeserializeOwned;

use super::campaign::{parsed, write};
use super::pseudonym::Pseudonym;
use super::study_store::StudyStore;

/// How the study was simulated.
const SIMULATION: &str = "simulation.json";
/// What was felt with what was answered in a session.
const JUDGED: &str = "judged.json";

impl StudyStore {
    /// How the study was simulated, as [`Self::write_simulation`] has kept it; `None` for a study with people.
    ///
    /// # Errors
    /// [`StudyError`] for a file that is something else.
    pub fn simulation<T: DeserializeOwned>(&self) -> Result<Option<T>, StudyError> {
        read(self.folder.join(SIMULATION), "how a study was simulated")
    }

    /// Keeps how the study is simulated.
    ///
    /// # Errors
    /// [`StudyError`].
    pub fn write_simulation<T: Serialize>(&self, simulation: &T) -> Result<(), StudyError> {
        put(self.folder.join(SIMULATION), simulation)
    }

    /// What was felt with what was answered in a session, as [`Self::write_judged`] has kept it; `None` where it was not.
    ///
    /// # Errors
    /// [`StudyError`] for a file that is something else.
    pub fn judged<T: DeserializeOwned>(
        &self,
        participant: &Pseudonym,
        session: &str,
    ) -> Result<Option<T>, StudyError> {
        let folder = self.session_folder(participant, session)?;
        read(folder.join(JUDGED), "what was felt in a session")
    }

    /// Keeps what was felt with what was answered in a session, in its folder, which a withdrawal erases.
    ///
    /// # Errors
    /// [`StudyError`].
    pub fn write_judged<T: Serialize>(
        &self,
        participant: &Pseudonym,
        session: &str,
        judged: &T,
    ) -> Result<(), StudyError> {
        put(
            self.session_folder(participant, session)?.join(JUDGED),
            judged,
        )
    }
}

fn read<T: DeserializeOwned>(
    path: PathBuf,
    expected: &'static str,
) -> Result<Option<T>, StudyError> {
    match piezotact_dataset::reads::is_there(&path) {
        true => parsed(&path, expected).map(Some),
        false => Ok(None),
    }
}

fn put<T: Serialize>(path: PathBuf, value: &T) -> Result<(), StudyError> {
    let bytes = serde_json::to_vec(value).map_err(|error| StudyError::Form {
        path: path.clone(),
        expected: "numbers",
        why: error.to_string(),
    })?;
    Ok(write(&path, &bytes)?)
}
