//! A withdrawal: payloads, files and identity of a participant are erased, and a tombstone stays.
//!
//! The intention is stored first, with the erasing of the payloads: a withdrawal that was interrupted is completed when the study is
//! opened next. The identities without the participant are written beside the file before, so that no passphrase is needed then.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::store::{SessionKey, StoreError};
use sqlx::sqlite::SqliteConnection;

use super::error::{StudyError, advice_on_io, place};
use super::identity::{self, IDENTITY, IdentityError, NEXT, Passphrase};
use super::pseudonym::Pseudonym;
use super::store::SqliteStore;
use super::{DATABASE, PARTICIPANTS};
use crate::atomic::{UNFINISHED, remove_left_behind, sync_folder};

/// What a withdrawal erased.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Withdrawn {
    /// Sessions whose payloads were erased.
    pub sessions: usize,
    /// Files that were removed.
    pub files: usize,
    /// Identities that were removed: 0 or 1.
    pub identities: usize,
}

/// Why a withdrawal is not done, or not complete.
#[derive(Debug, thiserror::Error)]
pub enum WithdrawError {
    /// Nothing of such a participant is there.
    #[error(
        "expected a participant of this study, found nothing of `{participant}`; check the pseudonym"
    )]
    Unknown {
        /// The pseudonym.
        participant: String,
    },
    /// The identities cannot be read without it.
    #[error("{}: expected its passphrase, as the identity of {participant} may be in it, found none; give the passphrase: nothing was erased yet", path.display())]
    PassphraseNeeded {
        /// The participant.
        participant: String,
        /// The encrypted file.
        path: PathBuf,
    },
    /// The identities cannot be read or written.
    #[error(transparent)]
    Identity(#[from] IdentityError),
    /// A file cannot be removed.
    #[error("{}: {why}; {advice}: the withdrawal is completed then", path.display())]
    Place {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        why: String,
        /// What to do.
        advice: &'static str,
    },
    /// The store refuses.
    #[error(transparent)]
    Store(#[from] StoreError),
}

impl WithdrawError {
    fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        move |error| Self::Place {
            path: path.to_owned(),
            advice: advice_on_io(&error),
            why: error.to_string(),
        }
    }
}

/// A withdrawal that is not complete: participant, what is pending, and the checksum of the identities without the participant.
pub(super) type Pending = (String, String, Option<Vec<u8>>);

impl SqliteStore {
    /// Erases everything of `participant` in the folder of the study: payloads and salts of all sessions, files and identity. What
    /// stays is a tombstone: pseudonym, sessions, times and checksums, with which the chains still verify.
    ///
    /// # Errors
    /// [`WithdrawError`]. What fails after the payloads were erased is completed by the next call, or when the study is opened next.
    pub fn withdraw(
        &mut self,
        participant: &Pseudonym,
        at_ms: i64,
        passphrase: Option<&Passphrase>,
    ) -> Result<Withdrawn, WithdrawError> {
        self.complete_withdrawals_now_or_withdraw_error()?;
        let _alone = identity::alone(&self.folder)?;
        let name = participant.as_str();
        let identity_sha = self.prepare_identities(name, passphrase)?;
        let (sessions, known) = self.read(async |connection| known(connection, name).await)?;
        let files = files_of(&self.folder, name)?;
        if !known && files.is_empty() && identity_sha.is_none() {
            let participant = name.to_owned();
            return Err(WithdrawError::Unknown { participant });
        }
        self.change(async |connection| {
            intend(connection, name, at_ms, "files", identity_sha.as_ref()).await
        })?;
        let files = files.iter().map(|path| count(path)).sum();
        let identities = usize::from(identity_sha.is_some());
        self.complete_one((
            name.to_owned(),
            "files".to_owned(),
            identity_sha.map(|sha| sha.bytes().to_vec()),
        ))?;
        Ok(Withdrawn {
            sessions,
            files,
            identities,
        })
    }

    /// Writes the identities without `participant` beside the file, if it is in it; gives their checksum.
    pub(super) fn prepare_identities(
        &self,
        participant: &str,
        passphrase: Option<&Passphrase>,
    ) -> Result<Option<Sha>, WithdrawError> {
        if !identity::are_there(&self.folder)? {
            return Ok(None);
        }
        let Some(passphrase) = passphrase else {
            return Err(WithdrawError::PassphraseNeeded {
                participant: participant.to_owned(),
                path: self.folder.join(IDENTITY),
            });
        };
        let mut identities = identity::read(&self.folder, passphrase)?;
        if identities.people.remove(participant).is_none() {
            return Ok(None);
        }
        let next = self.folder.join(NEXT);
        Ok(Some(identity::write(&next, &identities, passphrase)?))
    }

    /// Erases the payloads of a participant; gives the number of sessions.
    pub(super) fn erase_payloads(
        &mut self,
        participant: &str,
        at_ms: i64,
    ) -> Result<usize, StoreError> {
        let (sessions, pending) = self.change(async |connection| {
            let (sessions, _) = known(connection, participant).await?;
            if sessions == 0 {
                let key = SessionKey::new(participant, "(any)");
                return Err(StoreError::Unknown { key });
            }
            // Not less than what is pending already.
            let pending = sqlx::query_scalar(
                "SELECT pending FROM withdrawals WHERE participant = ? AND pending = 'files'",
            );
            let pending = pending
                .bind(participant)
                .fetch_optional(&mut *connection)
                .await;
            let pending: Option<String> = pending.map_err(place)?;
            if pending.is_none() {
                intend(connection, participant, at_ms, "bytes", None).await?;
            }
            Ok((sessions, pending))
        })?;
        if pending.is_none() {
            self.scrub()?;
            self.settle(participant, "nothing")?;
        }
        Ok(sessions)
    }

    /// Completes withdrawals that were interrupted, when the study is opened.
    pub(super) fn complete_withdrawals(&mut self) -> Result<(), StudyError> {
        let folder = self.folder.clone();
        let failed = |error: WithdrawError| StudyError::Withdrawal {
            participant: "a participant".into(),
            source: Box::new(error),
        };
        let pending = self.pending().map_err(|error| failed(error.into()))?;
        if pending.is_empty() && !folder.join(NEXT).exists() {
            return Ok(());
        }
        let _alone = identity::alone(&folder).map_err(|error| failed(error.into()))?;
        for pending in self.pending().map_err(|error| failed(error.into()))? {
            let participant = pending.0.clone();
            self.complete_one(pending)
                .map_err(|error| StudyError::Withdrawal {
                    participant,
                    source: Box::new(error),
                })?;
        }
        // Of a withdrawal that was interrupted before it was certain.
        let next = folder.join(NEXT);
        match std::fs::remove_file(&next) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(StudyError::io(&next)(error))
            }
            _ => Ok(()),
        }
    }

    /// As [`Self::complete_withdrawals`], while the study is open.
    pub(super) fn complete_withdrawals_now(&mut self) -> Result<(), IdentityError> {
        self.complete_withdrawals()
            .map_err(|error| IdentityError::Place {
                path: self.folder.clone(),
                why: error.to_string(),
                advice: "open the study again",
            })
    }

    fn complete_withdrawals_now_or_withdraw_error(&mut self) -> Result<(), WithdrawError> {
        Ok(self.complete_withdrawals_now()?)
    }

    pub(super) fn pending(&self) -> Result<Vec<Pending>, StoreError> {
        self.read(async |connection| {
            let rows = sqlx::query_as(
                "SELECT participant, pending, identity_sha FROM withdrawals WHERE pending <> 'nothing'",
            );
            rows.fetch_all(connection).await.map_err(place)
        })
    }

    /// Does what is pending of one withdrawal; all of it can be done twice.
    pub(super) fn complete_one(
        &mut self,
        (participant, pending, identity_sha): Pending,
    ) -> Result<(), WithdrawError> {
        if pending == "files" {
            remove_files(&self.folder, &participant)?;
            if let Some(sha) = identity_sha {
                put_identities(&self.folder, &sha)?;
            }
            self.settle(&participant, "bytes")?;
        }
        self.scrub()?;
        self.settle(&participant, "nothing")?;
        Ok(())
    }

    fn settle(&mut self, participant: &str, pending: &str) -> Result<(), StoreError> {
        self.change(async |connection| {
            let settled = sqlx::query(
                "UPDATE withdrawals SET pending = ?, identity_sha = NULL WHERE participant = ?",
            );
            let settled = settled.bind(pending).bind(participant);
            settled.execute(connection).await.map(|_| ()).map_err(place)
        })
    }
}

/// The number of sessions of a participant, and whether the database knows the name at all.
async fn known(
    connection: &mut SqliteConnection,
    participant: &str,
) -> Result<(usize, bool), StoreError> {
    let sessions = sqlx::query_scalar("SELECT count(*) FROM sessions WHERE participant = ?");
    let sessions = sessions.bind(participant).fetch_one(&mut *connection).await;
    let sessions: i64 = sessions.map_err(place)?;
    let withdrawn = super::store::has_withdrawn(connection, participant).await?;
    Ok((sessions.unsigned_abs() as usize, sessions > 0 || withdrawn))
}

/// Stores that the participant withdraws, and erases the payloads. The time of the first time stays.
pub(super) async fn intend(
    connection: &mut SqliteConnection,
    participant: &str,
    at_ms: i64,
    pending: &str,
    identity_sha: Option<&Sha>,
) -> Result<(), StoreError> {
    let sha = identity_sha.map(|sha| sha.bytes().to_vec());
    let again =
        sqlx::query("UPDATE withdrawals SET pending = ?, identity_sha = ? WHERE participant = ?");
    let again = again.bind(pending).bind(&sha).bind(participant);
    let again = again.execute(&mut *connection).await.map_err(place)?;
    if again.rows_affected() == 0 {
        let first = sqlx::query("INSERT INTO withdrawals VALUES (?, ?, ?, ?)");
        let first = first.bind(participant).bind(at_ms).bind(pending).bind(&sha);
        first.execute(&mut *connection).await.map_err(place)?;
    }
    let erased = sqlx::query(
        "UPDATE events SET payload = NULL, salt = NULL WHERE participant = ? AND payload IS NOT NULL",
    );
    erased
        .bind(participant)
        .execute(connection)
        .await
        .map(|_| ())
        .map_err(place)
}

/// What stands in `participants/` of a participant: the folder, and what was set aside of it.
fn files_of(folder: &Path, participant: &str) -> Result<Vec<PathBuf>, WithdrawError> {
    let participants = folder.join(PARTICIPANTS);
    match std::fs::symlink_metadata(&participants) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(WithdrawError::io(&participants)(error)),
        Ok(found) if !found.is_dir() => {
            return Err(WithdrawError::Place {
                path: participants,
                why: "expected a folder, found a link or a file: nothing is removed outside of the study".into(),
                advice: "move the folder to its place",
            });
        }
        Ok(_) => {}
    }
    let aside = format!("{participant}.before-");
    let mut found = Vec::new();
    for entry in std::fs::read_dir(&participants).map_err(WithdrawError::io(&participants))? {
        let entry = entry.map_err(WithdrawError::io(&participants))?;
        let name = entry.file_name();
        if name == participant || name.to_string_lossy().starts_with(&aside) {
            found.push(entry.path());
        }
    }
    Ok(found)
}

impl SqliteStore {
    /// What stands in the folder of the study under a name that has the pseudonym of `participant` in it as a word, in capital or small
    /// letters: copies that a withdrawal does not know, and does not erase.
    ///
    /// # Errors
    /// [`WithdrawError::Place`] where a folder cannot be read.
    pub fn named_alike(&self, participant: &Pseudonym) -> Result<Vec<PathBuf>, WithdrawError> {
        let mut found = Vec::new();
        for folder in [self.folder().to_owned(), self.folder().join(PARTICIPANTS)] {
            for entry in std::fs::read_dir(&folder).map_err(WithdrawError::io(&folder))? {
                let path = entry.map_err(WithdrawError::io(&folder))?.path();
                let name = path
                    .file_name()
                    .map(|name| name.to_string_lossy().to_lowercase());
                if name.is_some_and(|name| has_word(&name, &participant.as_str().to_lowercase())) {
                    found.push(path);
                }
            }
        }
        found.sort();
        Ok(found)
    }
}

impl SqliteStore {
    /// Where the links in the folders of `participant` lead: a withdrawal removes the links, and leaves what is there.
    ///
    /// # Errors
    /// [`WithdrawError::Place`] where a folder or a link cannot be read.
    pub fn linked_outside(&self, participant: &Pseudonym) -> Result<Vec<PathBuf>, WithdrawError> {
        let mut open = files_of(self.folder(), participant.as_str())?;
        let mut found = Vec::new();
        while let Some(path) = open.pop() {
            let kind = std::fs::symlink_metadata(&path).map_err(WithdrawError::io(&path))?;
            if kind.is_symlink() {
                let to = std::fs::read_link(&path).map_err(WithdrawError::io(&path))?;
                // As the link means it: from the folder in which it stands.
                found.push(path.parent().map_or(to.clone(), |folder| folder.join(&to)));
            } else if kind.is_dir() {
                for entry in std::fs::read_dir(&path).map_err(WithdrawError::io(&path))? {
                    open.push(entry.map_err(WithdrawError::io(&path))?.path());
                }
            }
        }
        found.sort();
        Ok(found)
    }
}

/// Whether `word` stands in `text` with no letter or digit beside it.
fn has_word(text: &str, word: &str) -> bool {
    let is_beside = |part: Option<char>| part.is_some_and(char::is_alphanumeric);
    text.match_indices(word).any(|(at, _)| {
        let before = text[..at].chars().next_back();
        let after = text[at + word.len()..].chars().next();
        !is_beside(before) && !is_beside(after)
    })
}

/// The number of files in `path`, links counted and not followed.
fn count(path: &Path) -> usize {
    match std::fs::symlink_metadata(path) {
        Ok(found) if found.is_dir() => {
            let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
            entries.map(|entry| count(&entry.path())).sum()
        }
        Ok(_) => 1,
        Err(_gone) => 0,
    }
}

pub(super) fn remove_files(folder: &Path, participant: &str) -> Result<(), WithdrawError> {
    for path in files_of(folder, participant)? {
        let is_folder = std::fs::symlink_metadata(&path).is_ok_and(|found| found.is_dir());
        // Both remove a link itself, and never what it leads to.
        let removed = match is_folder {
            true => std::fs::remove_dir_all(&path),
            false => std::fs::remove_file(&path),
        };
        match removed {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(WithdrawError::io(&path)(error));
            }
            _ => {}
        }
    }
    // What killed programs were writing may be of this participant.
    remove_left_behind(folder, UNFINISHED);
    remove_left_behind(&folder.join(PARTICIPANTS), UNFINISHED);
    sync_folder(&folder.join(PARTICIPANTS).join(participant));
    Ok(())
}

/// Puts the identities that were written beside the file in its place, unless they are there already.
pub(super) fn put_identities(folder: &Path, sha: &[u8]) -> Result<(), WithdrawError> {
    let next = folder.join(NEXT);
    let mut bytes = Vec::new();
    match File::open(&next) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(WithdrawError::io(&next)(error)),
        Ok(file) => (&file)
            .read_to_end(&mut bytes)
            .map_err(WithdrawError::io(&next))?,
    };
    if Sha::of(&bytes).bytes()[..] != *sha {
        return Err(WithdrawError::Identity(IdentityError::Damaged {
            path: next,
            found: "a file that is not the one that was prepared".into(),
        }));
    }
    std::fs::rename(&next, folder.join(IDENTITY)).map_err(WithdrawError::io(&next))?;
    sync_folder(&folder.join(DATABASE));
    Ok(())
}
