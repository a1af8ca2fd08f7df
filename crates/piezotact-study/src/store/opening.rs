//! Opening the database of a study: what it is, what state it is in, and its tables where there are none yet.

use std::fs::File;
use std::path::Path;
use std::time::Duration;

use sqlx::ConnectOptions as _;
use sqlx::Connection as _;
use sqlx::sqlite::{SqliteConnectOptions, SqliteConnection, SqliteSynchronous};

use super::error::{Kept, StudyError};
use super::schema::{APPLICATION, TABLES, VERSION};
use super::seal::{Found, Sealed};

/// What is to happen to a folder.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Begin {
    Create,
    Open,
}

/// Whether a study can be changed.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Access {
    Written,
    /// Its folder or its file can only be read, as on a disk for reading or for somebody else's account.
    OnlyRead,
}

/// Whether the database at `path` can be changed.
///
/// # Errors
/// [`StudyError::Place`] where it can only be read, and a log that is not moved into it yet holds its last changes.
pub(super) fn access(path: &Path) -> Result<Access, StudyError> {
    use std::io::ErrorKind::{PermissionDenied, ReadOnlyFilesystem};
    let file = File::options().write(true).open(path).map(drop);
    // The log and its index stand beside it.
    let beside = tempfile::tempfile_in(path.parent().unwrap_or(path)).map(drop);
    let is_refused = |tried: std::io::Result<()>| {
        tried.is_err_and(|error| matches!(error.kind(), PermissionDenied | ReadOnlyFilesystem))
    };
    if !is_refused(file) && !is_refused(beside) {
        return Ok(Access::Written);
    }
    let mut log = path.as_os_str().to_owned();
    log.push("-wal");
    match std::fs::metadata(&log) {
        Ok(found) if found.len() > 0 => Err(StudyError::Place {
            path: path.to_owned(),
            why: "expected a study that was closed, as it can only be read, found changes in its write-ahead log".into(),
            advice: "make the folder and its files writable for this user, or open a copy of the whole folder",
        }),
        _ => Ok(Access::OnlyRead),
    }
}

pub(super) fn lost(folder: &Path, acknowledged: u64, found: u64) -> StudyError {
    StudyError::Lost {
        folder: folder.to_owned(),
        kept: Kept::InFolder,
        acknowledged,
        found,
    }
}

/// Checks what stands in the place of the database, without opening it.
pub(super) fn check_file(folder: &Path, path: &Path, begin: Begin) -> Result<(), StudyError> {
    let no_study = |found| StudyError::NoStudy {
        path: path.to_owned(),
        found,
    };
    match std::fs::symlink_metadata(path) {
        Ok(found) if found.is_symlink() => Err(no_study("a link")),
        Ok(found) if !found.is_file() => Err(no_study("no file")),
        Ok(_) => Ok(()),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => match begin {
            Begin::Create => Ok(()),
            Begin::Open => Err(StudyError::Missing {
                folder: folder.to_owned(),
            }),
        },
        Err(error) => Err(StudyError::io(path)(error)),
    }
}

/// Opens the database, and makes the tables where there are none yet.
pub(super) async fn connect(
    path: &Path,
    (begin, access): (Begin, Access),
    patience: Duration,
    seal: &Found,
) -> Result<(SqliteConnection, Sealed), StudyError> {
    let options = SqliteConnectOptions::new()
        .filename(path)
        .create_if_missing(begin == Begin::Create)
        .busy_timeout(patience)
        .synchronous(SqliteSynchronous::Full)
        .pragma("fullfsync", "ON")
        .pragma("checkpoint_fullfsync", "ON")
        .pragma("secure_delete", "ON")
        // What is rewritten is never written to a folder of temporary files.
        .pragma("temp_store", "MEMORY");
    let options = match access {
        Access::Written => options,
        // Without a log and its index, which could not be made.
        Access::OnlyRead => options.read_only(true).immutable(true),
    };
    let connecting = options.connect().await;
    let mut connection = connecting.map_err(StudyError::database(path))?;
    match sealed(&mut connection, path, (begin, access), seal).await {
        Ok(sealed) => Ok((connection, sealed)),
        Err(error) => {
            closed(connection).await;
            Err(error)
        }
    }
}

/// Closes `connection` now: dropped, it is closed by its own thread a moment later, and whoever opens the same files in between would be
/// given its memory of them.
pub(super) async fn closed(connection: SqliteConnection) {
    let _best_effort = connection.close().await;
}

/// What the database of a study has stored; of a new one, once its tables are made.
async fn sealed(
    connection: &mut SqliteConnection,
    path: &Path,
    (begin, access): (Begin, Access),
    seal: &Found,
) -> Result<Sealed, StudyError> {
    let folder = path.parent().unwrap_or(path);
    let failed = || StudyError::database(path);
    // Nothing is changed before it is known that the database is a study.
    let blank = match state(connection).await.map_err(failed())? {
        (0, 0, 0) => true,
        (APPLICATION, _, _) if begin == Begin::Create => {
            return Err(StudyError::Exists {
                folder: folder.to_owned(),
            });
        }
        (APPLICATION, VERSION, _) => false,
        (APPLICATION, found, _) => {
            return Err(StudyError::Newer {
                path: path.to_owned(),
                known: VERSION,
                found,
            });
        }
        _ => {
            return Err(StudyError::NoStudy {
                path: path.to_owned(),
                found: "the database of another program",
            });
        }
    };
    if let (true, Found::Whole(sealed)) = (blank, seal) {
        return Err(lost(folder, sealed.changes, 0));
    }
    if access == Access::Written {
        write_ahead(connection, path).await?;
    }
    if blank {
        make_tables(connection).await.map_err(failed())?;
        piezotact_dataset::atomic::sync_folder(path);
        piezotact_dataset::atomic::sync_folder(folder);
    }
    let study = sqlx::query_as("SELECT identity, changes FROM study");
    let (study, changes): (String, i64) =
        study.fetch_one(&mut *connection).await.map_err(failed())?;
    Ok(Sealed {
        study,
        changes: changes.unsigned_abs(),
    })
}

/// Turns the write-ahead log on.
async fn write_ahead(connection: &mut SqliteConnection, path: &Path) -> Result<(), StudyError> {
    let mode = sqlx::query_scalar("PRAGMA journal_mode = WAL");
    let mode = mode.fetch_one(connection).await;
    let mode: String = mode.map_err(StudyError::database(path))?;
    match mode.as_str() {
        "wal" => Ok(()),
        _ => Err(StudyError::Place {
            path: path.to_owned(),
            why: format!("expected a write-ahead log, found journal mode `{mode}`"),
            advice: "copy the folder to a local disk",
        }),
    }
}

/// Application, version, and number of tables.
async fn state(connection: &mut SqliteConnection) -> Result<(i64, i64, i64), sqlx::Error> {
    let application = sqlx::query_scalar("PRAGMA application_id");
    let application = application.fetch_one(&mut *connection).await?;
    let version = sqlx::query_scalar("PRAGMA user_version");
    let version = version.fetch_one(&mut *connection).await?;
    let tables = sqlx::query_scalar("SELECT count(*) FROM sqlite_schema");
    Ok((application, version, tables.fetch_one(connection).await?))
}

/// Makes the tables, unless another program has made them in the meantime.
async fn make_tables(connection: &mut SqliteConnection) -> Result<(), sqlx::Error> {
    sqlx::raw_sql("BEGIN IMMEDIATE")
        .execute(&mut *connection)
        .await?;
    if state(connection).await? == (0, 0, 0) {
        sqlx::raw_sql(TABLES).execute(&mut *connection).await?;
    }
    sqlx::raw_sql("COMMIT").execute(&mut *connection).await?;
    // So that a damaged log never leaves a file without tables.
    empty_log(connection).await
}

/// Moves the log into the database and empties it.
pub(super) async fn empty_log(connection: &mut SqliteConnection) -> Result<(), sqlx::Error> {
    let moved = sqlx::query_as("PRAGMA wal_checkpoint(TRUNCATE)");
    let (busy, _, _): (i64, i64, i64) = moved.fetch_one(connection).await?;
    match busy {
        0 => Ok(()),
        _ => Err(sqlx::Error::Io(std::io::Error::new(
            std::io::ErrorKind::ResourceBusy,
            "another program reads the study: end it, then open the study again",
        ))),
    }
}
