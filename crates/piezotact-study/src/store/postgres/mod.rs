//! A study on a PostgreSQL server, which several stations share: connecting, what the server must be, and what it says.

mod making;
mod schema;
mod url;

use std::time::Duration;

use piezotact_people::campaign::store::StoreError;
use sqlx::ConnectOptions as _;
use sqlx::Connection as _;
use sqlx::Row as _;
use sqlx::postgres::{PgConnection, PgDatabaseError};
use tokio::time::timeout;

use super::database::Remains;
use super::error::StudyError;
use super::opening::Begin;
use super::seal::Sealed;
use making::{DURABLE, LOSES};
pub use url::DatabaseUrl;

/// How long connecting may take.
const CONNECTING: Duration = Duration::from_secs(10);
/// How long an answer of the server may take: behind it, the connection is given up.
pub(super) const ANSWERING: Duration = Duration::from_secs(20);
/// How long rewriting the tables may take.
pub(super) const REWRITING: Duration = Duration::from_secs(600);

/// Begins a transaction, waits until no other station writes, and says whether the server keeps what it acknowledges.
const BEGIN: &str = "BEGIN; SELECT current_setting('fsync') = 'on' AND current_setting('full_page_writes') = 'on' FROM study FOR UPDATE";

/// What holds for a connection. A station that vanishes within a transaction holds up the others for 10 s; its session lock goes with
/// its connection, which the server finds broken after 25 s.
const SETTINGS: &str = "SET search_path TO piezotact; SET synchronous_commit TO on; SET statement_timeout TO 0; \
    SET lock_timeout TO '5s'; SET idle_in_transaction_session_timeout TO '10s'; \
    SET tcp_keepalives_idle TO 10; SET tcp_keepalives_interval TO 5; SET tcp_keepalives_count TO 3; \
    SET standard_conforming_strings TO on";

/// An open connection to the server.
pub(super) struct Server {
    pub(super) connection: PgConnection,
    /// Process and start of its end on the server.
    end: End,
    condition: Condition,
    keeping: Keeping,
}

/// Whether a server keeps through a power cut what it acknowledges, when its transaction began.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Keeping {
    Keeps,
    Loses,
}

/// The server's end of a connection: its process, and when it was started.
pub(super) type End = (i32, String);

#[derive(Clone, Copy, PartialEq, Eq)]
enum Condition {
    Open,
    /// It broke: nothing can be asked any more.
    Broken,
}

impl Server {
    /// Connects to a server that keeps what it acknowledges; gives the study that its database holds, and makes the tables where a study
    /// is created and there are none.
    pub(super) async fn open(
        url: &DatabaseUrl,
        begin: Begin,
    ) -> Result<(Self, Sealed), StudyError> {
        let failed = |error: &sqlx::Error| said_of(url, error);
        let options = url.options().map_err(|error| server(url, error))?;
        let options = options.application_name("piezotact");
        let mut connection = match timeout(CONNECTING, options.connect()).await {
            Ok(connection) => connection.map_err(|error| failed(&error))?,
            Err(_late) => return Err(silent(url)),
        };
        let prepared = timeout(ANSWERING, making::prepared(&mut connection, url, begin));
        match prepared.await {
            Ok(prepared) => {
                let (end, sealed) = prepared?;
                let server = Self {
                    connection,
                    end,
                    condition: Condition::Open,
                    keeping: Keeping::Loses,
                };
                Ok((server, sealed))
            }
            Err(_late) => Err(silent(url)),
        }
    }

    /// Begins a transaction. No other station writes until it ends.
    pub(super) async fn begin(&mut self) -> Result<(), StoreError> {
        let begun = sqlx::raw_sql(BEGIN).fetch_one(&mut self.connection).await;
        let keeps = begun.and_then(|row| row.try_get(0));
        self.keeping = match keeps.map_err(|error| self.refusal(&error))? {
            true => Keeping::Keeps,
            false => Keeping::Loses,
        };
        Ok(())
    }

    /// Ends a transaction without what it has changed.
    pub(super) async fn roll_back(&mut self) -> Result<(), StoreError> {
        let done = sqlx::raw_sql("ROLLBACK").execute(&mut self.connection);
        let done = done.await.map(|_| ());
        done.map_err(|error| self.refusal(&error))
    }

    /// Refuses to store the answers of a volunteer on a server that can lose them.
    pub(super) fn require_keeping(&self) -> Result<(), StoreError> {
        match self.keeping {
            Keeping::Keeps => Ok(()),
            Keeping::Loses => Err(StoreError::Place {
                why: LOSES.into(),
                advice: DURABLE,
            }),
        }
    }

    /// Notes that nothing can be asked of this connection any more.
    pub(super) fn give_up(&mut self) {
        self.condition = Condition::Broken;
    }

    /// Ends what is left of an earlier connection of this program on the server, so that its transaction and its locks end.
    pub(super) async fn end_earlier(&mut self, (process, started): &End) -> Result<(), StoreError> {
        let ending = sqlx::query(
            "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE pid = $1 AND backend_start::text = $2",
        );
        let ended = ending.bind(*process).bind(started);
        let ended = ended.execute(&mut self.connection).await;
        ended.map(|_| ()).map_err(|error| self.refusal(&error))
    }

    /// Takes the advisory lock `key` for the life of this connection.
    pub(super) async fn lock(&mut self, key: i64) -> Result<Locked, StoreError> {
        let locking = sqlx::query_scalar("SELECT pg_try_advisory_lock($1)").bind(key);
        let locked = locking.fetch_one(&mut self.connection).await;
        match locked.map_err(|error| self.refusal(&error))? {
            true => Ok(Locked::Taken),
            false => Ok(Locked::Held(self.holder(key).await?)),
        }
    }

    /// Takes the advisory lock `key`, which an earlier connection of this program had.
    pub(super) async fn lock_again(&mut self, key: i64) -> Result<(), StoreError> {
        for _ in 0..20 {
            if let Locked::Taken = self.lock(key).await? {
                return Ok(());
            }
            // The end of the earlier connection takes a moment.
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
        let by = self.holder(key).await?;
        Err(StoreError::Place {
            why: format!("while the connection was lost, {by} has taken up the session"),
            advice: "end it there, then go on with it here or there",
        })
    }

    /// Who holds the advisory lock `key`.
    async fn holder(&mut self, key: i64) -> Result<String, StoreError> {
        // The lower half of the key is the object of the lock, the upper half its class.
        let holder = sqlx::query_scalar(
            "SELECT coalesce(host(a.client_addr), 'the machine of the server') FROM pg_locks AS l JOIN pg_stat_activity AS a USING (pid) \
             WHERE l.locktype = 'advisory' AND l.granted AND l.objsubid = 1 \
             AND l.classid::bigint = ($1::bigint >> 32) & 4294967295 AND l.objid::bigint = $1::bigint & 4294967295",
        );
        let holder = holder.bind(key).fetch_optional(&mut self.connection).await;
        let holder: Option<String> = holder.map_err(|error| self.refusal(&error))?;
        Ok(holder.map_or_else(
            || "another station".into(),
            |at| format!("a station at {at}"),
        ))
    }

    /// The server's end of this connection.
    pub(super) fn end(&self) -> End {
        self.end.clone()
    }

    /// Rewrites the tables that held what was erased.
    pub(super) async fn scrub(&mut self) -> Result<Remains, StoreError> {
        // Who may not rewrite a table is only warned by the server.
        let owned = sqlx::query_scalar(
            "SELECT bool_and(pg_has_role(current_user, relowner, 'USAGE')) FROM pg_class \
             WHERE oid IN ('events'::regclass, 'plans'::regclass)",
        );
        let owned: Result<bool, _> = owned.fetch_one(&mut self.connection).await;
        if !owned.map_err(|error| self.refusal(&error))? {
            return Ok(Remains::NotRewritten {
                why: "this user does not own the tables".into(),
            });
        }
        for statement in ["VACUUM FULL events", "VACUUM FULL plans"] {
            let done = sqlx::raw_sql(statement).execute(&mut self.connection).await;
            match done {
                Ok(_) => {}
                // Somebody reads for longer than the others wait.
                Err(error) if code_of(&error) == Some("55P03") => {
                    return Ok(Remains::NotRewritten {
                        why: "another program uses the tables".into(),
                    });
                }
                Err(error) => return Err(self.refusal(&error)),
            }
        }
        Ok(Remains::OnServer)
    }

    /// What the server says, as a store says it; notes where the connection broke.
    pub(super) fn refusal(&mut self, error: &sqlx::Error) -> StoreError {
        if is_broken(error) {
            self.give_up();
        }
        let (why, advice) = said(error);
        StoreError::Place { why, advice }
    }

    pub(super) fn is_gone(&self) -> bool {
        self.condition == Condition::Broken
    }

    pub(super) async fn close(self) -> Result<(), sqlx::Error> {
        let closing = timeout(Duration::from_secs(1), self.connection.close());
        closing.await.unwrap_or(Ok(()))
    }
}

/// Whether an advisory lock was taken.
pub(super) enum Locked {
    Taken,
    /// Somebody else holds it: who.
    Held(String),
}

/// That the server gave no answer within the time.
pub(super) fn no_answer() -> StoreError {
    StoreError::Place {
        why: "the server of the database gives no answer".into(),
        advice: AGAIN,
    }
}

const AGAIN: &str =
    "check the network and that the server runs, then do the same again: nothing is stored twice";
const START: &str = "check host and port in the URL, and that the server runs";
const RIGHTS: &str = "ask the administrator of the database for the rights: to make a study, CREATE on the database; to use one, \
    USAGE on the schema piezotact, and SELECT, INSERT, UPDATE and DELETE on its tables";
const PASSWORD: &str = "check the user in the URL, and the password in PGPASSWORD or ~/.pgpass";
const WAIT: &str = "another station writes to the study: wait a moment, then do the same again";
const SPACE: &str = "free space on the disk of the server, then do the same again";
const CERTIFICATE: &str = "check sslmode in the URL, and the certificates of the server";
const ADMINISTRATOR: &str =
    "ask the administrator of the server, whose log says more, then do the same again";
const NAME: &str = "check the name of the database in the URL, or have it made (createdb)";

fn code_of(error: &sqlx::Error) -> Option<&str> {
    let error = error.as_database_error()?;
    error
        .try_downcast_ref::<PgDatabaseError>()
        .map(PgDatabaseError::code)
}

/// Whether the connection is lost with this error.
fn is_broken(error: &sqlx::Error) -> bool {
    match error {
        sqlx::Error::Io(_) | sqlx::Error::Tls(_) | sqlx::Error::Protocol(_) => true,
        // Connections that ended, sessions that were ended, a server that stops, starts or has crashed.
        error => {
            let code = code_of(error).unwrap_or_default();
            code.starts_with("08") || code.starts_with("57P") || code.starts_with("25P03")
        }
    }
}

/// Whether a certificate was refused, which the encryption says as an error of input.
fn is_untrusted(error: &sqlx::Error) -> bool {
    matches!(error, sqlx::Error::Io(error) if error.kind() == std::io::ErrorKind::InvalidData)
}

/// What was refused, and what to do.
fn said(error: &sqlx::Error) -> (String, &'static str) {
    let message = match error.as_database_error() {
        Some(database) => database.message().to_owned(),
        None => match error {
            error if is_untrusted(error) => format!("no encrypted connection is made: {error}"),
            sqlx::Error::Io(error) => format!("the connection to the database is lost: {error}"),
            other => other.to_string(),
        },
    };
    let code = code_of(error).unwrap_or_default();
    let advice = match (error, code) {
        (error, _) if is_untrusted(error) => CERTIFICATE,
        (sqlx::Error::Io(_) | sqlx::Error::Protocol(_), _) => AGAIN,
        (sqlx::Error::Tls(_), _) => CERTIFICATE,
        (_, "3D000") => NAME,
        (_, "42501") => RIGHTS,
        (_, "25006") => "connect to the server that takes changes, not to a copy of it",
        (_, "55P03" | "40P01" | "40001") => WAIT,
        (_, "53100") => SPACE,
        (_, code) if code.starts_with("28") => PASSWORD,
        (_, code) if code.starts_with("08") || code.starts_with("57P") || code == "25P03" => AGAIN,
        _ => ADMINISTRATOR,
    };
    (message, advice)
}

/// That a server or what it holds is not what was expected.
fn server(url: &DatabaseUrl, why: impl ToString) -> StudyError {
    StudyError::Server {
        url: url.to_string(),
        why: why.to_string(),
        advice: ADMINISTRATOR,
    }
}

/// What the server says when a study is opened.
fn said_of(url: &DatabaseUrl, error: &sqlx::Error) -> StudyError {
    let (why, advice) = said(error);
    StudyError::Server {
        url: url.to_string(),
        why,
        advice: match error {
            sqlx::Error::Io(_) if !is_untrusted(error) => START,
            _ => advice,
        },
    }
}

fn silent(url: &DatabaseUrl) -> StudyError {
    StudyError::Server {
        url: url.to_string(),
        why: format!(
            "the server gives no answer within {} s",
            CONNECTING.as_secs()
        ),
        advice: START,
    }
}
