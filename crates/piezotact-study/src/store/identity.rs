//! Who the participants are: names, contacts and signed consents, in one file that is encrypted with a passphrase.

use std::collections::BTreeMap;
use std::fmt;
use std::fs::File;
use std::io::{Read as _, Write as _};
use std::path::Path;

use age::secrecy::{ExposeSecret as _, SecretString};
use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::store::StoreError;
use piezotact_people::campaign::text::{TextError, check_line, check_secret};
use serde::{Deserialize, Serialize};

use super::error::StudyError;
use super::pseudonym::Pseudonym;
use super::sessions::has_withdrawn;
use super::study_store::StudyStore;
use piezotact_dataset::WriteError;
use piezotact_dataset::atomic::{Prepared, sync_folder};
use piezotact_dataset::lock::{Lock, LockFile};

/// The encrypted file.
pub(super) const IDENTITY: &str = "identity.age";
/// The file that takes its place when a withdrawal is certain.
pub(super) const NEXT: &str = "identity.age.next";
/// Held while it is changed.
const LOCK: &str = "identity.lock";
/// What the content says that it is.
const FORMAT: &str = "piezotact-identities";
/// scrypt's work factor, log2 N: about a second and 256 MiB.
const WORK: u8 = 18;
/// The highest that is read: 16 times as much.
const MOST_WORK: u8 = 22;

/// The passphrase of the identities of a study. It is shown by nothing.
#[derive(Clone)]
pub struct Passphrase {
    secret: SecretString,
    work: u8,
}

impl fmt::Debug for Passphrase {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("Passphrase")
    }
}

impl Passphrase {
    /// The passphrase `text`; what is written with it costs about a second to try one passphrase.
    ///
    /// # Errors
    /// [`StudyError::NoPassphrase`].
    pub fn new(text: String) -> Result<Self, StudyError> {
        if text.trim().is_empty() {
            return Err(StudyError::NoPassphrase);
        }
        Ok(Self {
            secret: text.into(),
            work: WORK,
        })
    }

    /// Whether it can be chosen for new identities. An earlier one that cannot still opens the file that was written with it.
    ///
    /// # Errors
    /// [`TextError`].
    pub fn check(&self) -> Result<(), TextError> {
        check_secret(self.secret.expose_secret())
    }

    /// The same with another work factor of scrypt, log2 N from 1 to 22: a low one is for tests.
    #[must_use]
    pub fn with_work_factor(self, log2_n: u8) -> Self {
        Self {
            work: log2_n.clamp(1, MOST_WORK),
            ..self
        }
    }
}

/// Who a participant is.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PersonalData {
    pub name: String,
    /// How the person is reached.
    pub contact: String,
    /// The consent, once it is signed.
    pub consent: Option<SignedConsent>,
}

/// A consent that was signed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SignedConsent {
    /// The version of the text, as the laboratory calls it.
    pub version: String,
    /// The text that was signed.
    pub text: String,
    /// The checksum of the text.
    pub text_sha256: Sha,
    /// When it was signed, in ms since 1970-01-01 00:00 UTC.
    pub signed_at_ms: i64,
}

impl SignedConsent {
    /// The consent to `text`.
    #[must_use]
    pub fn new(version: &str, text: &str, signed_at_ms: i64) -> Self {
        Self {
            version: version.to_owned(),
            text: text.to_owned(),
            text_sha256: Sha::of(text.as_bytes()),
            signed_at_ms,
        }
    }
}

/// What became of the consent when an identity was stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConsentStored {
    /// The one that was given is stored.
    Given,
    /// None was given: the one that was signed before stays.
    Kept,
    /// None was given, and none was signed before.
    Unsigned,
}

/// The content of the file.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct Identities {
    format: String,
    version: u32,
    pub(super) people: BTreeMap<String, PersonalData>,
}

impl Default for Identities {
    fn default() -> Self {
        Self {
            format: FORMAT.into(),
            version: 1,
            people: BTreeMap::new(),
        }
    }
}

impl StudyStore {
    /// Who the participants are, by pseudonym; none where no identity was stored.
    ///
    /// # Errors
    /// [`StudyError`].
    pub fn identities(
        &self,
        passphrase: &Passphrase,
    ) -> Result<BTreeMap<String, PersonalData>, StudyError> {
        Ok(read(&self.folder, passphrase)?.people)
    }

    /// Stores who `participant` is, in place of what was stored before; a consent that was signed stays where `person` brings none.
    /// The first identity decides the passphrase, which [`Passphrase::check`] accepts.
    ///
    /// # Errors
    /// [`StudyError`]; the file is then as it was.
    pub fn set_identity(
        &mut self,
        participant: &Pseudonym,
        mut person: PersonalData,
        passphrase: &Passphrase,
    ) -> Result<ConsentStored, StudyError> {
        check_texts(participant, &person)?;
        // A file that waits for its place would undo this.
        if self.folder.join(NEXT).exists() {
            self.complete_withdrawals_now()?;
        }
        let _alone = alone(&self.folder)?;
        let name = participant.as_str();
        if self.read(async |database| has_withdrawn(database, name).await)? {
            let participant = name.to_owned();
            return Err(StudyError::Withdrawn { participant });
        }
        if !are_there(&self.folder)? {
            passphrase.check()?;
        }
        let mut identities = read(&self.folder, passphrase)?;
        participant.check_among(identities.people.keys().map(String::as_str))?;
        let before = identities.people.remove(name);
        let consent = match (&person.consent, before.and_then(|before| before.consent)) {
            (Some(_), _) => ConsentStored::Given,
            (None, None) => ConsentStored::Unsigned,
            (None, signed) => {
                person.consent = signed;
                ConsentStored::Kept
            }
        };
        identities.people.insert(name.to_owned(), person);
        let gone = self.without_withdrawn(&mut identities)?;
        write(&self.folder.join(IDENTITY), &identities, passphrase)?;
        self.note_erased(&gone)?;
        Ok(consent)
    }
}

impl StudyStore {
    /// Takes everybody who has withdrawn, at whatever station, out of `identities`; gives who has.
    pub(super) fn without_withdrawn(
        &self,
        identities: &mut Identities,
    ) -> Result<Vec<String>, StoreError> {
        let gone = self.withdrawn()?;
        for name in &gone {
            identities.people.remove(name);
        }
        Ok(gone)
    }
}

/// Refuses what would not stand in one line of a list.
fn check_texts(participant: &Pseudonym, person: &PersonalData) -> Result<(), StudyError> {
    let version = person.consent.as_ref().map(|signed| &signed.version);
    let texts = [
        ("the name", Some(&person.name)),
        ("the contact", Some(&person.contact)),
        ("the version of the consent", version),
    ];
    for (what, text) in texts {
        let checked = text.map_or(Ok(()), |text| check_line(text));
        checked.map_err(|why| StudyError::IdentityText {
            participant: participant.to_string(),
            what,
            why,
        })?;
    }
    Ok(())
}

/// The right to change the file, until it is dropped.
pub(super) fn alone(folder: &Path) -> Result<Lock, StudyError> {
    let path = folder.join(LOCK);
    Lock::take(&path, LockFile::Stays).map_err(|error| match error {
        WriteError::Held { by: holder, .. } => StudyError::IdentitiesHeld {
            path: folder.join(IDENTITY),
            holder,
        },
        WriteError::Io { source, .. } => StudyError::io(&path)(source),
        other => other.into(),
    })
}

/// Whether there are identities. A link is none: it would lead out of the study.
pub(super) fn are_there(folder: &Path) -> Result<bool, StudyError> {
    let path = folder.join(IDENTITY);
    match std::fs::symlink_metadata(&path) {
        Ok(found) if found.is_file() => Ok(true),
        Ok(_) => Err(StudyError::IdentitiesDamaged {
            path,
            found: "a link or a folder".into(),
        }),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(StudyError::io(&path)(error)),
    }
}

/// The identities in `folder`; none where there is no file.
pub(super) fn read(folder: &Path, passphrase: &Passphrase) -> Result<Identities, StudyError> {
    if !are_there(folder)? {
        return Ok(Identities::default());
    }
    let path = folder.join(IDENTITY);
    let mut bytes = Vec::new();
    // Not noted: no result is made from who somebody is.
    let file = File::open(&path).map_err(StudyError::io(&path))?;
    (&file)
        .read_to_end(&mut bytes)
        .map_err(StudyError::io(&path))?;
    let damaged = |found: String| StudyError::IdentitiesDamaged {
        path: path.clone(),
        found,
    };
    let plain = decrypted(&bytes, passphrase, &path)?;
    #[derive(Deserialize)]
    struct Head {
        format: String,
        version: u32,
    }
    let head: Head =
        serde_json::from_slice(&plain).map_err(|_error| damaged("another document".into()))?;
    match (head.format.as_str(), head.version) {
        (FORMAT, 1) => {}
        (FORMAT, found) => {
            return Err(StudyError::Newer {
                path,
                known: 1,
                found: found.into(),
            });
        }
        _ => return Err(damaged("another document".into())),
    }
    let identities: Identities = serde_json::from_slice(&plain)
        // What serde says may quote a name.
        .map_err(|error| {
            damaged(format!(
                "an entry that does not fit (line {})",
                error.line()
            ))
        })?;
    for (participant, person) in &identities.people {
        let changed =
            |consent: &SignedConsent| Sha::of(consent.text.as_bytes()) != consent.text_sha256;
        if person.consent.as_ref().is_some_and(changed) {
            let participant = participant.clone();
            return Err(StudyError::ConsentChanged { participant });
        }
    }
    Ok(identities)
}

fn decrypted(bytes: &[u8], passphrase: &Passphrase, path: &Path) -> Result<Vec<u8>, StudyError> {
    use age::DecryptError::{
        DecryptionFailed, ExcessiveWork, KeyDecryptionFailed, NoMatchingKeys, UnknownFormat,
    };
    let failed = |error: age::DecryptError| match error {
        DecryptionFailed | KeyDecryptionFailed => StudyError::WrongPassphrase { path: path.into() },
        other => StudyError::IdentitiesDamaged {
            path: path.into(),
            found: match other {
                NoMatchingKeys => "a file that is not encrypted with a passphrase",
                ExcessiveWork { .. } => "a work factor of more than 22",
                UnknownFormat => "another version of age, or no such file",
                _ => "a damaged beginning",
            }
            .into(),
        },
    };
    let file = age::Decryptor::new_buffered(bytes).map_err(failed)?;
    let mut key = age::scrypt::Identity::new(passphrase.secret.clone());
    key.set_max_work_factor(MOST_WORK);
    let mut reader = file
        .decrypt(std::iter::once(&key as &dyn age::Identity))
        .map_err(failed)?;
    let mut plain = Vec::new();
    reader
        .read_to_end(&mut plain)
        .map_err(|_error| StudyError::IdentitiesDamaged {
            path: path.into(),
            found: "damaged or missing bytes".into(),
        })?;
    Ok(plain)
}

/// Writes identities to `path`; gives the checksum of the file.
pub(super) fn write(
    path: &Path,
    identities: &Identities,
    passphrase: &Passphrase,
) -> Result<Sha, StudyError> {
    let failed = |why: String| StudyError::Place {
        path: path.into(),
        why,
        advice: "give it again",
    };
    let plain = serde_json::to_vec(identities).map_err(|error| failed(error.to_string()))?;
    let mut recipient = age::scrypt::Recipient::new(passphrase.secret.clone());
    recipient.set_work_factor(passphrase.work);
    let recipients = std::iter::once(&recipient as &dyn age::Recipient);
    let encryptor =
        age::Encryptor::with_recipients(recipients).map_err(|error| failed(error.to_string()))?;
    let mut bytes = Vec::new();
    let mut writer = encryptor
        .wrap_output(&mut bytes)
        .map_err(StudyError::io(path))?;
    writer.write_all(&plain).map_err(StudyError::io(path))?;
    writer.finish().map_err(StudyError::io(path))?;
    let prepared = Prepared::new(path, |out| {
        // For the one who runs the study alone.
        #[cfg(unix)]
        out.get_ref()
            .set_permissions(std::os::unix::fs::PermissionsExt::from_mode(0o600))
            .map_err(WriteError::io(path))?;
        out.write_all(&bytes).map_err(WriteError::io(path))
    })?;
    prepared.commit()?;
    sync_folder(path);
    Ok(Sha::of(&bytes))
}
