//! Why a study cannot be created or opened, and what the database says in terms of the trait of stores.

use std::path::{Path, PathBuf};

use piezotact_people::campaign::store::StoreError;

use super::postgres::DatabaseUrlError;
use super::withdrawal::WithdrawError;

/// Why a study cannot be created or opened.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// There is a study already.
    #[error("{}: expected a folder without a study, found one; open it, or give another folder", folder.display())]
    Exists { folder: PathBuf },
    /// There is no study.
    #[error("{}: expected a folder with a study (study.sqlite or study.url), found none; check the path, or create the study", folder.display())]
    Missing { folder: PathBuf },
    /// The file is something else.
    #[error("{}: expected the database of a study, found {found}; check the path, or restore the folder from a copy", path.display())]
    NoStudy { path: PathBuf, found: &'static str },
    /// A later version wrote it.
    #[error("{}: expected a study of version {known} or earlier, found version {found}; open it with a newer Piezotact", path.display())]
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
    #[error(
        "{}: expected how many changes were stored, found something else; restore the whole folder from a copy, or remove this file to go on without \
         knowing whether answers are missing", path.display()
    )]
    Seal { path: PathBuf },
    /// A study is in the database already.
    #[error(
        "{url}: expected a database without a study, found one with a study; join that study, or name another database"
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
        why: DatabaseUrlError,
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
        source: Box<WithdrawError>,
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
