//! Why a study cannot be created or opened, and what the database says in terms of the trait of stores.

use std::path::{Path, PathBuf};

use piezotact_dataset::{ReadError, WriteError};
use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::protocol::ProtocolError;
use piezotact_people::campaign::store::StoreError;
use piezotact_people::campaign::text::TextError;

/// Why a study cannot be created, opened, read or changed.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// There is a study already.
    #[error("{}: a study is in this folder already: open it, or give another folder", folder.display())]
    Exists { folder: PathBuf },
    /// There is no study.
    #[error("{}: no study is in this folder (no study.sqlite or study.url): check the path, or create the study", folder.display())]
    Missing { folder: PathBuf },
    /// The file is something else.
    #[error("{}: expected the database of a study, found {found}; check the path, or restore the folder from a copy", path.display())]
    NoStudy { path: PathBuf, found: &'static str },
    /// A later version wrote it.
    #[error("{}: version {found} is newer than version {known}, the latest that this program reads: open it with a newer Piezotact", path.display())]
    Newer {
        path: PathBuf,
        /// The latest version that this program reads.
        known: i64,
        /// The version of the file.
        found: i64,
    },
    /// The database holds fewer changes than were acknowledged.
    #[error("{}: {}", folder.display(), lost(*kept, *acknowledged, *found))]
    Lost {
        folder: PathBuf,
        /// Where the answers are kept.
        kept: Kept,
        /// How many changes were acknowledged.
        acknowledged: u64,
        /// How many there are.
        found: u64,
    },
    /// The file of acknowledged changes is damaged.
    #[error("{} should hold the number of stored changes and does not: restore the whole folder from a copy, or remove this file and give up the check for missing answers", path.display()
    )]
    Seal { path: PathBuf },
    /// A study is in the database already.
    #[error(
        "{url}: a study is in this database already: join that study, or name another database"
    )]
    Taken {
        /// The URL of the database.
        url: String,
    },
    /// The database on a server is not what was expected, or cannot be reached.
    #[error("{url}: {why}; {advice}")]
    Server {
        url: String,
        /// What was expected and found, or what the server said.
        why: String,
        advice: &'static str,
    },
    /// The file with the URL of the database cannot be used.
    #[error("{}: {why}", path.display())]
    Url {
        path: PathBuf,
        /// Why, and what to do.
        why: Box<Self>,
    },
    /// The folder belongs to another study.
    #[error(
        "{}: expected the study in the database {url}, found {found}; open it there, or name another folder", folder.display()
    )]
    OtherPlace {
        folder: PathBuf,
        /// The URL of the database.
        url: String,
        found: &'static str,
    },
    /// The operating system or the database refuses.
    #[error("{}: {why}; {advice}", path.display())]
    Place {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        why: String,
        advice: &'static str,
    },
    /// A withdrawal that was interrupted cannot be completed.
    #[error("the withdrawal of {participant} was interrupted and is not complete: {source}")]
    Withdrawal {
        participant: String,
        source: Box<Self>,
    },
    /// It has a character that not every file system takes, or none, or too many.
    #[error(
        "`{found}` is no pseudonym: give 1 to 32 letters (A-Z, a-z), digits, `-` and `_`, not beginning with `-`, such as P01"
    )]
    Pseudonym { found: String },
    /// A system keeps the name for a device.
    #[error("`{found}` is the name of a device on some systems: give a pseudonym such as P01")]
    PseudonymReserved { found: String },
    /// Another one differs from it in capital letters or leading zeros only.
    #[error(
        "`{found}` differs from `{existing}` in capital letters or leading zeros only, and is easily taken for the same: give another pseudonym"
    )]
    PseudonymCase {
        found: String,
        /// The one that is there.
        existing: String,
    },
    /// It has a password.
    #[error(
        "the URL of the database holds a password: leave it out; it is read from the environment variable PGPASSWORD or the file ~/.pgpass, and never kept in a study"
    )]
    UrlPassword,
    /// It is something else.
    #[error(
        "expected the URL of a database, such as postgres://user@host:5432/database, found {found}; correct it"
    )]
    NoUrl { found: String },
    /// Another program runs it.
    #[error(
        "session {session} of {participant} is run by another program ({by}): end it there, or wait until it has ended"
    )]
    Running {
        participant: String,
        session: String,
        by: String,
    },
    /// Another program simulates the study.
    #[error(
        "{}: another program simulates this study ({by}): end it there, or wait until it has ended", folder.display()
    )]
    Simulated { folder: PathBuf, by: String },
    /// Nothing of such a participant is there.
    #[error("nothing of `{participant}` is in this study: check the pseudonym")]
    UnknownParticipant { participant: String },
    /// The identities cannot be read without it.
    #[error("{} may hold the identity of {participant}: give its passphrase; nothing was erased yet", path.display())]
    PassphraseNeeded { participant: String, path: PathBuf },
    /// A file cannot be removed.
    #[error("{}: {why}; {advice}: the withdrawal is completed then", path.display())]
    NotErased {
        /// The file or folder.
        path: PathBuf,
        /// What the system said.
        why: String,
        advice: &'static str,
    },
    /// No passphrase.
    #[error("no passphrase was given: give one of several words")]
    NoPassphrase,
    /// It is too easy to guess.
    #[error("the passphrase: {0}")]
    WeakPassphrase(#[from] TextError),
    /// Another passphrase.
    #[error("{}: the passphrase is not the one that the file was written with, or its first lines are damaged: type it again, or restore the file from a copy", path.display())]
    WrongPassphrase { path: PathBuf },
    /// The file is not as it was written.
    #[error("{}: expected encrypted identities, found {found}; restore the file from a copy", path.display())]
    IdentitiesDamaged { path: PathBuf, found: String },
    /// A consent is not the one that was signed.
    #[error(
        "the consent of {participant}: the text is not the one whose checksum was signed; restore identity.age from a copy"
    )]
    ConsentChanged { participant: String },
    /// The participant has withdrawn.
    #[error(
        "{participant} has withdrawn: no identity is kept; use another pseudonym for another person"
    )]
    Withdrawn { participant: String },
    /// A text would forge lines of the list of identities.
    #[error("{what} of {participant}: {why}")]
    IdentityText {
        participant: String,
        /// "the name", "the contact" or "the version of the consent".
        what: &'static str,
        /// Why it is refused, and what to do.
        why: TextError,
    },
    /// Another program changes it.
    #[error("{}: {holder} changes the identities; wait until it has ended, then give it again", path.display())]
    IdentitiesHeld { path: PathBuf, holder: String },
    /// A file cannot be read.
    #[error(transparent)]
    Read(#[from] ReadError),
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// The protocol cannot be used.
    #[error(transparent)]
    Protocol(#[from] ProtocolError),
    /// A file was changed after the study was made.
    #[error("{} is not the {what} that the study was made with (SHA-256 {expected}, found {found}): restore it from a copy, or make a new study with the changed one, as a running study keeps its {what}", path.display()
    )]
    Changed {
        path: PathBuf,
        /// "protocol" or "consent text".
        what: &'static str,
        /// Its checksum when the study was made.
        expected: Sha,
        found: Sha,
    },
    /// A folder of the study that is a link.
    #[error("{} is a link, and what is written there would not be erased with the participant: move the folder to its place", path.display()
    )]
    Linked { path: PathBuf },
    /// A study was begun, and what it is of is missing.
    #[error("{} is missing, the campaign of the {sessions} sessions of this study: restore it from a copy of the study", path.display()
    )]
    Incomplete {
        /// The file that is missing.
        path: PathBuf,
        /// How many sessions the study has.
        sessions: usize,
    },
    /// A study in a database was not made to its end.
    #[error("{url}: the study was not made to its end: make it once more where it was begun")]
    Unfinished {
        /// The URL of the database.
        url: String,
    },
    /// The campaign in the folder of a station is not the one that the stations share.
    #[error("{} is another campaign than that in the database of the study: remove this file and join the study again", path.display()
    )]
    NotShared { path: PathBuf },
    /// Another file stands in the place of one of the study.
    #[error("{} is not the {what} of the new study: move it away, or give another folder", path.display()
    )]
    InTheWay {
        path: PathBuf,
        /// "protocol" or "consent text".
        what: &'static str,
    },
    /// A session that was begun has another plan.
    #[error("{}: session {session} of {participant} was begun with another plan ({}, now {}): go on with the one that is written", path.display(), .shas[0], .shas[1]
    )]
    Planned {
        path: PathBuf,
        participant: String,
        session: String,
        /// The checksums of the plan that is written and of the one that was given.
        shas: Box<[Sha; 2]>,
    },
    /// The database cannot be read, or the participant has withdrawn.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// A file is not what it must be.
    #[error("{}: expected {expected}, found {why}; restore it from a copy of the study", path.display())]
    Form {
        path: PathBuf,
        /// What it should hold.
        expected: &'static str,
        why: String,
    },
}

/// Where the answers of a study are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// In its folder, as study.sqlite.
    InFolder,
    /// In the database of a server, which several stations share.
    OnServer,
}

/// That a study has fewer changes than were acknowledged.
pub(super) fn lost(kept: Kept, acknowledged: u64, found: u64) -> String {
    let (cause, restore) = match kept {
        Kept::InFolder => (
            "study.sqlite or study.sqlite-wal was cut, damaged or exchanged",
            "restore the whole folder from a copy",
        ),
        Kept::OnServer => (
            "the database was restored from an older backup or exchanged",
            "restore it from a newer backup",
        ),
    };
    format!(
        "expected {acknowledged} changes or more, found {found}: stored answers are missing, as {cause}; \
         {restore}, or remove study.seal to go on without them"
    )
}

impl StudyError {
    pub(super) fn io(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        move |error| Self::Place {
            path: path.to_owned(),
            advice: advice_on_io(&error),
            why: error.to_string(),
        }
    }

    /// As [`Self::io`], while a participant is erased.
    pub(super) fn not_erased(path: &Path) -> impl FnOnce(std::io::Error) -> Self + '_ {
        move |error| Self::NotErased {
            path: path.to_owned(),
            advice: advice_on_io(&error),
            why: error.to_string(),
        }
    }

    /// The same as a store says it, while the study is open.
    pub(super) fn into_store_error(self) -> StoreError {
        match self {
            Self::Server { why, advice, .. } => StoreError::Place { why, advice },
            other => StoreError::Place {
                why: other.to_string(),
                advice: "then open the study again",
            },
        }
    }

    pub(super) fn of_withdrawals(error: StoreError) -> Self {
        Self::Withdrawal {
            participant: "a participant".into(),
            source: Box::new(error.into()),
        }
    }

    pub(super) fn database(path: &Path) -> impl FnOnce(sqlx::Error) -> Self + '_ {
        move |error| {
            if code_of(&error) == Some(NOT_A_DATABASE) {
                return Self::NoStudy {
                    path: path.to_owned(),
                    found: "a file that is no SQLite database",
                };
            }
            let (why, advice) = said(&error);
            Self::Place {
                path: path.to_owned(),
                why,
                advice,
            }
        }
    }
}

/// What to do when the operating system refuses a file.
pub(super) fn advice_on_io(error: &std::io::Error) -> &'static str {
    match error.kind() {
        std::io::ErrorKind::StorageFull | std::io::ErrorKind::QuotaExceeded => FREE_SPACE,
        std::io::ErrorKind::PermissionDenied | std::io::ErrorKind::ReadOnlyFilesystem => WRITABLE,
        std::io::ErrorKind::AlreadyExists | std::io::ErrorKind::NotADirectory => OTHER_NAME,
        _ => CHECK_DISK,
    }
}

const OTHER_NAME: &str =
    "a file or a link that leads nowhere has this name: name another folder, or remove it";
const FREE_SPACE: &str = "free space on the disk, then do the same again";
const WRITABLE: &str =
    "make the folder and its files writable for this user, or copy the folder to a disk that is";
const CHECK_DISK: &str = "check the disk and the folder, then open the study again";
const END_OTHER: &str = "end the other program that uses this study, then do the same again";
const RESTORE: &str = "restore the whole folder from a copy";

/// SQLite's code of a file that is no database.
const NOT_A_DATABASE: i32 = 26;

/// SQLite's primary result code.
fn code_of(error: &sqlx::Error) -> Option<i32> {
    let code = error.as_database_error()?.code()?;
    code.parse::<i32>().ok().map(|extended| extended & 0xff)
}

/// What was refused, and what to do.
fn said(error: &sqlx::Error) -> (String, &'static str) {
    let message = match error.as_database_error() {
        Some(database) => database.message().to_owned(),
        None => error.to_string(),
    };
    let advice = match code_of(error) {
        // BUSY, LOCKED
        Some(5 | 6) => END_OTHER,
        // FULL
        Some(13) => FREE_SPACE,
        // PERM, READONLY, CANTOPEN
        Some(3 | 8 | 14) => WRITABLE,
        // CORRUPT
        Some(11 | NOT_A_DATABASE) => RESTORE,
        // IOERR: also a limit on the size of files
        Some(10) => "check the free space and the health of the disk, then do the same again",
        // Values that are not of the schema.
        None => RESTORE,
        _ => CHECK_DISK,
    };
    (message, advice)
}

/// What the database says, as a store says it.
pub(super) fn place(error: sqlx::Error) -> StoreError {
    let (why, advice) = said(&error);
    StoreError::Place { why, advice }
}

/// Content that is not what a store wrote.
pub(super) fn damaged(why: impl Into<String>) -> StoreError {
    StoreError::Damaged { why: why.into() }
}
