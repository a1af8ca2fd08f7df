//! A withdrawal: payloads, files and identity of a participant are erased, and a tombstone stays.
//!
//! The intention is stored first, with the erasing of the payloads: a withdrawal that was interrupted is completed when the study is
//! opened next. The identities without the participant are written beside the file before, so that no passphrase is needed then.

use std::fs::File;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::store::{SessionKey, StoreError};

use super::database::{Database, Remains, Value};
use super::error::{Kept, StudyError};
use super::identity::{self, IDENTITY, NEXT, Passphrase};
use super::pseudonym::Pseudonym;
use super::sessions::has_withdrawn;
use super::shared::Notice;
use super::study_store::StudyStore;
use super::{DATABASE, PARTICIPANTS};
use piezotact_dataset::atomic::{UNFINISHED, remove_left_behind, sync_folder};

/// What a withdrawal erased.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Withdrawn {
    /// Sessions whose payloads were erased.
    pub sessions: usize,
    /// Files that were removed.
    pub files: usize,
    /// Identities that were removed: 0 or 1.
    pub identities: usize,
    /// What stays in the database.
    pub remains: Remains,
}

/// A withdrawal that is not complete: participant, what is pending, and the checksum of the identities without the participant.
pub(super) type Pending = (String, String, Option<Vec<u8>>);

impl StudyStore {
    /// Erases everything of `participant` in the folder of the study: payloads and salts of all sessions, files and identity. What
    /// stays is a tombstone: pseudonym, sessions, times and checksums, with which the chains still verify.
    ///
    /// # Errors
    /// [`StudyError`]. What fails after the payloads were erased is completed by the next call, or when the study is opened next.
    pub fn withdraw(
        &mut self,
        participant: &Pseudonym,
        at_ms: i64,
        passphrase: Option<&Passphrase>,
    ) -> Result<Withdrawn, StudyError> {
        self.complete_withdrawals_now()?;
        let _alone = identity::alone(&self.folder)?;
        let name = participant.as_str();
        let identity_sha = self.prepare_identities(name, passphrase)?;
        let (sessions, known) = self.read(async |database| known(database, name).await)?;
        let files = files_of(&self.folder, name)?;
        if !known && files.is_empty() && identity_sha.is_none() {
            let participant = name.to_owned();
            return Err(StudyError::UnknownParticipant { participant });
        }
        let is_again = self.read(async |database| has_withdrawn(database, name).await)?;
        if is_again && files.is_empty() && identity_sha.is_none() {
            // Nothing is left to be erased, and no change to be counted.
            return Ok(Withdrawn {
                sessions,
                files: 0,
                identities: 0,
                remains: Remains::Nothing,
            });
        }
        let pending = match self.kept() {
            Kept::InFolder => "files",
            Kept::OnServer => "bytes",
        };
        self.change(async |database| {
            intend(database, name, at_ms, pending, identity_sha.as_ref()).await
        })?;
        let files = files.iter().map(|path| count(path)).sum();
        let identities = usize::from(identity_sha.is_some());
        let remains = self.complete_one((
            name.to_owned(),
            "files".to_owned(),
            identity_sha.map(|sha| sha.bytes().to_vec()),
        ))?;
        if passphrase.is_some() {
            // The identities were looked through.
            let names = [name.to_owned()];
            self.note_erased(&names)?;
        }
        Ok(Withdrawn {
            sessions,
            files,
            identities,
            remains,
        })
    }

    /// Writes the identities without `participant` beside the file, if it is in it; gives their checksum.
    pub(super) fn prepare_identities(
        &self,
        participant: &str,
        passphrase: Option<&Passphrase>,
    ) -> Result<Option<Sha>, StudyError> {
        if !identity::are_there(&self.folder)? {
            return Ok(None);
        }
        let Some(passphrase) = passphrase else {
            return Err(StudyError::PassphraseNeeded {
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
        let (sessions, pending) = self.change(async |database| {
            let (sessions, _) = known(database, participant).await?;
            if sessions == 0 {
                let key = SessionKey::new(participant, "(any)");
                return Err(StoreError::Unknown { key });
            }
            // Not less than what is pending already.
            let pending =
                "SELECT pending FROM withdrawals WHERE participant = $1 AND pending = 'files'";
            let pending: Option<(String,)> = database.row(pending, &[participant.into()]).await?;
            if pending.is_none() {
                intend(database, participant, at_ms, "bytes", None).await?;
            }
            Ok((sessions, pending))
        })?;
        if pending.is_none() {
            self.scrub_and_settle(participant)?;
        }
        Ok(sessions)
    }

    /// Completes withdrawals that were interrupted, and those of other stations, when the study is opened.
    pub(super) fn complete_withdrawals(&mut self) -> Result<(), StudyError> {
        let folder = self.folder.clone();
        let failed = |error: StudyError| StudyError::Withdrawal {
            participant: "a participant".into(),
            source: Box::new(error),
        };
        if self.kept() == Kept::OnServer {
            return self.complete_at_station();
        }
        let pending = self.pending().map_err(|error| failed(error.into()))?;
        if pending.is_empty() && !folder.join(NEXT).exists() {
            return Ok(());
        }
        let _alone = identity::alone(&folder).map_err(failed)?;
        for pending in self.pending().map_err(|error| failed(error.into()))? {
            let participant = pending.0.clone();
            self.complete_one(pending)
                .map_err(|error| StudyError::Withdrawal {
                    participant,
                    source: Box::new(error),
                })?;
        }
        remove_next(&folder)
    }

    /// Erases what this station has of everybody who has withdrawn, and says what it cannot erase.
    fn complete_at_station(&mut self) -> Result<(), StudyError> {
        let folder = self.folder.clone();
        let failed = |participant: &str, error: StudyError| StudyError::Withdrawal {
            participant: participant.to_owned(),
            source: Box::new(error),
        };
        let all = self.all_withdrawals();
        self.notices.clear();
        for (participant, pending, identity_sha) in all.map_err(StudyError::of_withdrawals)? {
            let failed = |error| failed(&participant, error);
            let files = files_of(&folder, &participant).map_err(failed)?;
            if !files.is_empty() || folder.join(NEXT).exists() {
                let _alone = identity::alone(&folder).map_err(failed)?;
                let count = files.iter().map(|path| count(path)).sum();
                remove_files(&folder, &participant).map_err(failed)?;
                if let Some(sha) = &identity_sha
                    && is_file(&folder.join(NEXT), sha)
                {
                    put_identities(&folder, sha).map_err(failed)?;
                }
                if count > 0 {
                    let participant = participant.clone();
                    let files = count;
                    self.notices
                        .push(Notice::FilesErased { participant, files });
                }
            }
            // The identities are those that were written without the participant.
            if identity_sha.is_some_and(|sha| is_file(&folder.join(IDENTITY), &sha)) {
                self.note_erased(std::slice::from_ref(&participant))?;
            }
            if pending == "bytes" {
                let remains = self.scrub_and_settle(&participant);
                let why = match remains.map_err(|error| failed(error.into()))? {
                    Remains::NotRewritten { why } => why,
                    Remains::Nothing | Remains::OnServer => continue,
                };
                self.notices
                    .retain(|notice| !matches!(notice, Notice::NotRewritten { .. }));
                self.notices.push(Notice::NotRewritten { why });
            }
        }
        for participant in self.may_be_named()? {
            let path = folder.join(IDENTITY);
            self.notices.push(Notice::MayBeNamed { participant, path });
        }
        if !folder.join(NEXT).exists() {
            return Ok(());
        }
        let alone = identity::alone(&folder);
        let _alone = alone.map_err(|error| failed("a participant", error))?;
        remove_next(&folder)
    }

    /// As [`Self::complete_withdrawals`], while the study is open.
    pub(super) fn complete_withdrawals_now(&mut self) -> Result<(), StudyError> {
        self.complete_withdrawals()
            .map_err(|error| StudyError::Place {
                path: self.folder.clone(),
                why: error.to_string(),
                advice: "open the study again",
            })
    }

    pub(super) fn pending(&self) -> Result<Vec<Pending>, StoreError> {
        self.read(async |database| {
            let rows = "SELECT participant, pending, identity_sha FROM withdrawals WHERE pending <> 'nothing'";
            database.rows(rows, &[]).await
        })
    }

    fn all_withdrawals(&self) -> Result<Vec<Pending>, StoreError> {
        self.read(async |database| {
            let rows =
                "SELECT participant, pending, identity_sha FROM withdrawals ORDER BY participant";
            database.rows(rows, &[]).await
        })
    }

    /// Does what is pending of one withdrawal; all of it can be done twice.
    pub(super) fn complete_one(
        &mut self,
        (participant, pending, identity_sha): Pending,
    ) -> Result<Remains, StudyError> {
        if pending == "files" {
            remove_files(&self.folder, &participant)?;
            if let Some(sha) = identity_sha {
                put_identities(&self.folder, &sha)?;
            }
            self.settle(&participant, "bytes")?;
        }
        Ok(self.scrub_and_settle(&participant)?)
    }

    /// Removes what erased payloads left in the database; that is pending until it could be done.
    fn scrub_and_settle(&mut self, participant: &str) -> Result<Remains, StoreError> {
        let remains = self.scrub()?;
        if !matches!(remains, Remains::NotRewritten { .. }) {
            self.settle(participant, "nothing")?;
        }
        Ok(remains)
    }

    fn settle(&mut self, participant: &str, pending: &str) -> Result<(), StoreError> {
        // At a server the checksum stays: another station may have written it, and have to find it.
        let settled = match self.kept() {
            Kept::InFolder => {
                "UPDATE withdrawals SET pending = $1, identity_sha = NULL WHERE participant = $2"
            }
            Kept::OnServer => "UPDATE withdrawals SET pending = $1 WHERE participant = $2",
        };
        self.change(async |database| {
            let values = [pending.into(), participant.into()];
            database.execute(settled, &values).await.map(|_| ())
        })
    }
}

/// Whether the file at `path` has the checksum `sha`.
fn is_file(path: &Path, sha: &[u8]) -> bool {
    let bytes = std::fs::read(path);
    bytes.is_ok_and(|bytes| Sha::of(&bytes).bytes()[..] == *sha)
}

/// Removes identities that were written beside the file for a withdrawal that was interrupted before it was certain.
fn remove_next(folder: &Path) -> Result<(), StudyError> {
    let next = folder.join(NEXT);
    match std::fs::remove_file(&next) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
            Err(StudyError::io(&next)(error))
        }
        _ => Ok(()),
    }
}

/// The number of sessions of a participant, and whether the database knows the name at all.
async fn known(database: &mut Database, participant: &str) -> Result<(usize, bool), StoreError> {
    let sessions = "SELECT count(*) FROM sessions WHERE participant = $1";
    let (sessions,): (i64,) = database.one(sessions, &[participant.into()]).await?;
    let withdrawn = has_withdrawn(database, participant).await?;
    Ok((sessions.unsigned_abs() as usize, sessions > 0 || withdrawn))
}

/// Stores that the participant withdraws, and erases the payloads, and plans that are in the database. The time of the first time stays.
pub(super) async fn intend(
    database: &mut Database,
    participant: &str,
    at_ms: i64,
    pending: &str,
    identity_sha: Option<&Sha>,
) -> Result<(), StoreError> {
    let sha = Value::Bytes(identity_sha.map(|sha| &sha.bytes()[..]));
    let again = "UPDATE withdrawals SET pending = $1, identity_sha = coalesce($2, identity_sha) WHERE participant = $3";
    let values = [pending.into(), sha, participant.into()];
    if database.execute(again, &values).await? == 0 {
        let first = "INSERT INTO withdrawals VALUES ($1, $2, $3, $4)";
        let values = [participant.into(), at_ms.into(), pending.into(), sha];
        database.execute(first, &values).await?;
    }
    let who = [participant.into()];
    let erased = "UPDATE events SET payload = NULL, salt = NULL WHERE participant = $1 AND payload IS NOT NULL";
    database.execute(erased, &who).await?;
    if database.is_shared() {
        let plans = "DELETE FROM plans WHERE participant = $1";
        database.execute(plans, &who).await?;
    }
    Ok(())
}

/// What stands in `participants/` of a participant: the folder, and what was set aside of it.
fn files_of(folder: &Path, participant: &str) -> Result<Vec<PathBuf>, StudyError> {
    let participants = folder.join(PARTICIPANTS);
    match std::fs::symlink_metadata(&participants) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(StudyError::not_erased(&participants)(error)),
        Ok(found) if !found.is_dir() => {
            return Err(StudyError::NotErased {
                path: participants,
                why: "expected a folder, found a link or a file: nothing is removed outside of the study".into(),
                advice: "move the folder to its place",
            });
        }
        Ok(_) => {}
    }
    let aside = format!("{participant}.before-");
    let mut found = Vec::new();
    for entry in std::fs::read_dir(&participants).map_err(StudyError::not_erased(&participants))? {
        let entry = entry.map_err(StudyError::not_erased(&participants))?;
        let name = entry.file_name();
        if name == participant || name.to_string_lossy().starts_with(&aside) {
            found.push(entry.path());
        }
    }
    Ok(found)
}

impl StudyStore {
    /// What stands in the folder of the study under a name that has the pseudonym of `participant` in it as a word, in capital or small
    /// letters: copies that a withdrawal does not know, and does not erase.
    ///
    /// # Errors
    /// [`StudyError::NotErased`] where a folder cannot be read.
    pub fn named_alike(&self, participant: &Pseudonym) -> Result<Vec<PathBuf>, StudyError> {
        let mut found = Vec::new();
        for folder in [self.folder().to_owned(), self.folder().join(PARTICIPANTS)] {
            for entry in std::fs::read_dir(&folder).map_err(StudyError::not_erased(&folder))? {
                let path = entry.map_err(StudyError::not_erased(&folder))?.path();
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

impl StudyStore {
    /// Where the links in the folders of `participant` lead: a withdrawal removes the links, and leaves what is there.
    ///
    /// # Errors
    /// [`StudyError::NotErased`] where a folder or a link cannot be read.
    pub fn linked_outside(&self, participant: &Pseudonym) -> Result<Vec<PathBuf>, StudyError> {
        let mut open = files_of(self.folder(), participant.as_str())?;
        let mut found = Vec::new();
        while let Some(path) = open.pop() {
            let kind = std::fs::symlink_metadata(&path).map_err(StudyError::not_erased(&path))?;
            if kind.is_symlink() {
                let to = std::fs::read_link(&path).map_err(StudyError::not_erased(&path))?;
                // As the link means it: from the folder in which it stands.
                found.push(path.parent().map_or(to.clone(), |folder| folder.join(&to)));
            } else if kind.is_dir() {
                for entry in std::fs::read_dir(&path).map_err(StudyError::not_erased(&path))? {
                    open.push(entry.map_err(StudyError::not_erased(&path))?.path());
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

pub(super) fn remove_files(folder: &Path, participant: &str) -> Result<(), StudyError> {
    for path in files_of(folder, participant)? {
        let is_folder = std::fs::symlink_metadata(&path).is_ok_and(|found| found.is_dir());
        // Both remove a link itself, and never what it leads to.
        let removed = match is_folder {
            true => std::fs::remove_dir_all(&path),
            false => std::fs::remove_file(&path),
        };
        match removed {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                return Err(StudyError::not_erased(&path)(error));
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
pub(super) fn put_identities(folder: &Path, sha: &[u8]) -> Result<(), StudyError> {
    let next = folder.join(NEXT);
    let mut bytes = Vec::new();
    match File::open(&next) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(()),
        Err(error) => return Err(StudyError::not_erased(&next)(error)),
        Ok(file) => (&file)
            .read_to_end(&mut bytes)
            .map_err(StudyError::not_erased(&next))?,
    };
    if Sha::of(&bytes).bytes()[..] != *sha {
        return Err(StudyError::IdentitiesDamaged {
            path: next,
            found: "a file that is not the one that was prepared".into(),
        });
    }
    std::fs::rename(&next, folder.join(IDENTITY)).map_err(StudyError::not_erased(&next))?;
    sync_folder(&folder.join(DATABASE));
    Ok(())
}
