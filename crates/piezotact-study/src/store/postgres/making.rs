//! What a server and its database must be, and the tables where there are none yet.

use sqlx::postgres::PgConnection;

use super::schema::{TABLES, VERSION};
use super::{DatabaseUrl, End, RIGHTS, SETTINGS, said_of};
use crate::store::error::StudyError;
use crate::store::opening::Begin;
use crate::store::seal::Sealed;

/// The oldest server that has what the tables use.
const OLDEST: i32 = 130_000;

/// Whether the settings of a server keep what it acknowledges through a power cut.
const KEEPS: &str =
    "SELECT current_setting('fsync') = 'on' AND current_setting('full_page_writes') = 'on'";

/// Held while the tables are made: `PZTS`.
const MAKING: &str = "BEGIN; SELECT pg_advisory_xact_lock(1348097107)";

/// What stands in the schema `piezotact`.
enum Holds {
    Nothing,
    Study { version: i64 },
    Other,
}

/// Checks a server and its database; gives the server's end of the connection, and the study.
pub(super) async fn prepared(
    connection: &mut PgConnection,
    url: &DatabaseUrl,
    begin: Begin,
) -> Result<(End, Sealed), StudyError> {
    let failed = |error: sqlx::Error| said_of(url, &error);
    let refused = |why: String, advice| StudyError::Server {
        url: url.to_string(),
        why,
        advice,
    };
    check_server(connection, url).await?;
    match holds(connection).await.map_err(failed)? {
        Holds::Nothing if begin == Begin::Create => make(connection, url).await?,
        Holds::Nothing => {
            return Err(refused(
                "expected the database of a study, found one without".into(),
                "check the name of the database in the URL, or make the study",
            ));
        }
        Holds::Study { version } if version > VERSION => {
            return Err(refused(
                format!(
                    "version {version} is newer than version {VERSION}, the latest that this program reads"
                ),
                "open it with a newer Piezotact",
            ));
        }
        Holds::Study { .. } if begin == Begin::Create => {
            return Err(StudyError::Taken {
                url: url.to_string(),
            });
        }
        Holds::Study { .. } => {}
        Holds::Other => {
            return Err(refused(
                "expected the tables of a study in the schema piezotact, found something else"
                    .into(),
                "name another database",
            ));
        }
    }
    check_rights(connection, url).await?;
    sqlx::raw_sql(SETTINGS)
        .execute(&mut *connection)
        .await
        .map_err(failed)?;
    let end = sqlx::query_as(
        "SELECT pid, backend_start::text FROM pg_stat_activity WHERE pid = pg_backend_pid()",
    );
    let end = end.fetch_one(&mut *connection).await.map_err(failed)?;
    let study = sqlx::query_as("SELECT identity, changes FROM study");
    let (study, changes): (String, i64) = study.fetch_one(connection).await.map_err(failed)?;
    let changes = changes.unsigned_abs();
    Ok((end, Sealed { study, changes }))
}

/// Refuses a server that is too old, that takes no changes, or that has letters of another kind.
async fn check_server(connection: &mut PgConnection, url: &DatabaseUrl) -> Result<(), StudyError> {
    let asked = sqlx::query_as(
        "SELECT current_setting('server_version_num')::int, current_setting('server_version'), pg_is_in_recovery(), \
         current_setting('transaction_read_only'), current_setting('server_encoding')",
    );
    let asked = asked.fetch_one(connection).await;
    let (number, version, copies, read_only, letters): (i32, String, bool, String, String) =
        asked.map_err(|error| said_of(url, &error))?;
    let refused = |why: String, advice| {
        Err(StudyError::Server {
            url: url.to_string(),
            why,
            advice,
        })
    };
    if number < OLDEST {
        return refused(
            format!("expected PostgreSQL 13 or later, found {version}"),
            "name another server",
        );
    }
    if copies || read_only == "on" {
        return refused(
            "expected a database that takes changes, found one that is only read".into(),
            "connect to the server that takes changes, and as a user who may make them",
        );
    }
    if letters != "UTF8" {
        return refused(
            format!("expected a database with the encoding UTF8, found {letters}"),
            "have it made with createdb --encoding=UTF8 --template=template0",
        );
    }
    Ok(())
}

async fn holds(connection: &mut PgConnection) -> Result<Holds, sqlx::Error> {
    // The catalogue is shown to everybody, whatever the rights.
    let there = sqlx::query_as(
        "SELECT count(DISTINCT c.oid), count(a.attname) FROM pg_class AS c JOIN pg_namespace AS n ON n.oid = c.relnamespace \
         LEFT JOIN pg_attribute AS a ON a.attrelid = c.oid AND c.relname = 'study' \
         AND a.attname IN ('single', 'version', 'identity', 'changes') WHERE n.nspname = 'piezotact'",
    );
    match there.fetch_one(&mut *connection).await? {
        (0_i64, _) => Ok(Holds::Nothing),
        (_, 4_i64) => {
            let version = sqlx::query_scalar("SELECT version FROM piezotact.study");
            let version: Option<i64> = version.fetch_optional(connection).await?;
            Ok(version.map_or(Holds::Other, |version| Holds::Study { version }))
        }
        _ => Ok(Holds::Other),
    }
}

/// Makes the tables, unless another station has made them in the meantime.
async fn make(connection: &mut PgConnection, url: &DatabaseUrl) -> Result<(), StudyError> {
    check_keeps(connection, url).await?;
    let failed = |error: sqlx::Error| said_of(url, &error);
    for statement in [MAKING, TABLES, "COMMIT"] {
        // One that waited finds the tables of the other.
        if statement == TABLES
            && !matches!(holds(connection).await.map_err(failed)?, Holds::Nothing)
        {
            let _ends = sqlx::raw_sql("ROLLBACK").execute(&mut *connection).await;
            return Err(StudyError::Taken {
                url: url.to_string(),
            });
        }
        sqlx::raw_sql(statement)
            .execute(&mut *connection)
            .await
            .map_err(failed)?;
    }
    Ok(())
}

async fn check_keeps(connection: &mut PgConnection, url: &DatabaseUrl) -> Result<(), StudyError> {
    let keeps: Result<bool, _> = sqlx::query_scalar(KEEPS).fetch_one(connection).await;
    match keeps.map_err(|error| said_of(url, &error))? {
        true => Ok(()),
        false => Err(StudyError::Server {
            url: url.to_string(),
            why: LOSES.into(),
            advice: DURABLE,
        }),
    }
}

/// Refuses a user who may not do what a session needs.
async fn check_rights(connection: &mut PgConnection, url: &DatabaseUrl) -> Result<(), StudyError> {
    let rights = sqlx::query_scalar(
        "SELECT has_schema_privilege('piezotact', 'USAGE') AND (SELECT \
         bool_and(has_table_privilege(c.oid, 'SELECT') AND has_table_privilege(c.oid, 'INSERT') AND has_table_privilege(c.oid, 'UPDATE')) \
         AND count(*) = 6 FROM pg_class AS c JOIN pg_namespace AS n ON n.oid = c.relnamespace WHERE n.nspname = 'piezotact' AND c.relkind = 'r')",
    );
    let rights: Result<bool, _> = rights.fetch_one(connection).await;
    match rights.map_err(|error| said_of(url, &error))? {
        true => Ok(()),
        false => Err(StudyError::Server {
            url: url.to_string(),
            why: "expected a study that this user may change, found tables that are missing or only read".into(),
            advice: RIGHTS,
        }),
    }
}

/// What is wrong with a server that loses what it acknowledged.
pub(super) const LOSES: &str = "expected a server that keeps through a power cut what it acknowledges (fsync = on, full_page_writes = on), \
     found one that does not";
/// What to do about it.
pub(super) const DURABLE: &str = "have the administrator set both to on, then do the same again";
