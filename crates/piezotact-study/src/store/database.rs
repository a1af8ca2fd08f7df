//! The database of a study, in its folder or on a server: statements stand once, as both understand `$1`.

use std::time::Duration;

use piezotact_people::campaign::store::StoreError;
use sqlx::postgres::{PgArguments, PgRow};
use sqlx::sqlite::{SqliteArguments, SqliteConnection, SqliteRow};
use sqlx::{Arguments as _, Connection as _, FromRow};

use super::error::{damaged, place};
use super::opening::empty_log;
use super::postgres::{Server, no_answer};

/// A value of a statement, in the order of `$1`, `$2`, …
#[derive(Clone, Copy)]
pub(super) enum Value<'a> {
    Text(Option<&'a str>),
    Bytes(Option<&'a [u8]>),
    Number(i64),
}

impl<'a> From<&'a str> for Value<'a> {
    fn from(text: &'a str) -> Self {
        Self::Text(Some(text))
    }
}

impl<'a> From<&'a String> for Value<'a> {
    fn from(text: &'a String) -> Self {
        Self::Text(Some(text))
    }
}

impl From<i64> for Value<'_> {
    fn from(number: i64) -> Self {
        Self::Number(number)
    }
}

impl<'a> From<&'a [u8]> for Value<'a> {
    fn from(bytes: &'a [u8]) -> Self {
        Self::Bytes(Some(bytes))
    }
}

/// A row that both databases give.
pub(super) trait Row:
    for<'r> FromRow<'r, SqliteRow> + for<'r> FromRow<'r, PgRow> + Send + Unpin
{
}

impl<T> Row for T where T: for<'r> FromRow<'r, SqliteRow> + for<'r> FromRow<'r, PgRow> + Send + Unpin
{}

/// An open connection.
pub(super) enum Database {
    /// `study.sqlite` in the folder.
    File(SqliteConnection),
    /// A server that several stations share.
    Server(Server),
}

/// The values of a statement as SQLite takes them.
fn for_file(values: &[Value<'_>]) -> Result<SqliteArguments, sqlx::error::BoxDynError> {
    let mut arguments = SqliteArguments::default();
    for value in values {
        match value {
            Value::Text(text) => arguments.add(text.map(str::to_owned))?,
            Value::Bytes(bytes) => arguments.add(bytes.map(<[u8]>::to_vec))?,
            Value::Number(number) => arguments.add(*number)?,
        }
    }
    Ok(arguments)
}

/// The values of a statement as PostgreSQL takes them.
fn for_server(values: &[Value<'_>]) -> Result<PgArguments, sqlx::error::BoxDynError> {
    let mut arguments = PgArguments::default();
    for value in values {
        match value {
            Value::Text(text) => arguments.add(*text)?,
            Value::Bytes(bytes) => arguments.add(*bytes)?,
            Value::Number(number) => arguments.add(*number)?,
        }
    }
    Ok(arguments)
}

impl Database {
    /// The rows of a statement.
    pub(super) async fn rows<T: Row>(
        &mut self,
        statement: &'static str,
        values: &[Value<'_>],
    ) -> Result<Vec<T>, StoreError> {
        match self {
            Self::File(connection) => {
                let values = for_file(values).map_err(refused)?;
                let rows = sqlx::query_as_with(statement, values);
                rows.fetch_all(connection).await.map_err(place)
            }
            Self::Server(server) => {
                let values = for_server(values).map_err(refused)?;
                let rows = sqlx::query_as_with(statement, values);
                let rows = rows.fetch_all(&mut server.connection).await;
                rows.map_err(|error| server.refusal(&error))
            }
        }
    }

    /// The first row of a statement, where there is one.
    pub(super) async fn row<T: Row>(
        &mut self,
        statement: &'static str,
        values: &[Value<'_>],
    ) -> Result<Option<T>, StoreError> {
        Ok(self.rows(statement, values).await?.into_iter().next())
    }

    /// The row of a statement that always has one.
    pub(super) async fn one<T: Row>(
        &mut self,
        statement: &'static str,
        values: &[Value<'_>],
    ) -> Result<T, StoreError> {
        let row = self.row(statement, values).await?;
        row.ok_or_else(|| damaged("a row that every study has is not there"))
    }

    /// Executes a statement; gives the number of rows that it changed.
    pub(super) async fn execute(
        &mut self,
        statement: &'static str,
        values: &[Value<'_>],
    ) -> Result<u64, StoreError> {
        match self {
            Self::File(connection) => {
                let values = for_file(values).map_err(refused)?;
                let done = sqlx::query_with(statement, values).execute(connection);
                done.await.map(|done| done.rows_affected()).map_err(place)
            }
            Self::Server(server) => {
                let values = for_server(values).map_err(refused)?;
                let done = sqlx::query_with(statement, values).execute(&mut server.connection);
                let done = done.await.map(|done| done.rows_affected());
                done.map_err(|error| server.refusal(&error))
            }
        }
    }

    /// Executes a statement without values, or several of them.
    pub(super) async fn run(&mut self, statement: &'static str) -> Result<(), StoreError> {
        let statement = sqlx::raw_sql(statement);
        match self {
            Self::File(connection) => {
                let done = statement.execute(connection).await;
                done.map(|_| ()).map_err(place)
            }
            Self::Server(server) => {
                let done = statement.execute(&mut server.connection).await;
                done.map(|_| ()).map_err(|error| server.refusal(&error))
            }
        }
    }

    /// Begins a transaction that writes. No other program writes until it ends.
    pub(super) async fn begin(&mut self) -> Result<(), StoreError> {
        match self {
            // At once a write: a read that became one would not wait for another program.
            Self::File(_) => self.run("BEGIN IMMEDIATE").await,
            Self::Server(server) => server.begin().await,
        }
    }

    /// Refuses to store the answers of a volunteer where a power cut can lose them.
    pub(super) fn require_keeping(&self) -> Result<(), StoreError> {
        match self {
            // Every commit is flushed.
            Self::File(_) => Ok(()),
            Self::Server(server) => server.require_keeping(),
        }
    }

    /// What `act` gives; a server that gives no answer within `limit` is given up.
    pub(super) async fn within<T>(
        &mut self,
        limit: Duration,
        act: impl AsyncFnOnce(&mut Self) -> Result<T, StoreError>,
    ) -> Result<T, StoreError> {
        if matches!(self, Self::File(_)) {
            return act(self).await;
        }
        if let Ok(done) = tokio::time::timeout(limit, act(self)).await {
            return done;
        }
        if let Self::Server(server) = self {
            server.give_up();
        }
        Err(no_answer())
    }

    /// Whether several stations share it.
    pub(super) fn is_shared(&self) -> bool {
        matches!(self, Self::Server(_))
    }

    /// Removes what erased payloads left in the database.
    pub(super) async fn scrub(&mut self) -> Result<Remains, StoreError> {
        if let Self::Server(server) = self {
            return server.scrub().await;
        }
        self.run("VACUUM").await?;
        if let Self::File(connection) = self {
            empty_log(connection).await.map_err(place)?;
        }
        Ok(Remains::Nothing)
    }

    /// Checks that the database is whole, as far as it can say so itself.
    pub(super) async fn check(&mut self) -> Result<(), StoreError> {
        if matches!(self, Self::Server(_)) {
            return Ok(());
        }
        let (found,): (String,) = self.one("PRAGMA integrity_check(1)", &[]).await?;
        match found.as_str() {
            "ok" => Ok(()),
            _ => Err(damaged(found)),
        }
    }

    /// Whether nothing can be asked of this connection any more.
    pub(super) fn is_gone(&self) -> bool {
        match self {
            Self::File(_) => false,
            Self::Server(server) => server.is_gone(),
        }
    }

    /// Closes it now.
    pub(super) async fn close(self) {
        let _best_effort = match self {
            Self::File(connection) => connection.close().await,
            Self::Server(server) => server.close().await,
        };
    }
}

/// What a withdrawal leaves in a database.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Remains {
    /// No byte.
    Nothing,
    /// The tables of a server were rewritten; its log, its replicas and its backups are the administrator's to erase.
    OnServer,
    /// The tables of a server could not be rewritten: bytes may stand in free space of its files until they are.
    NotRewritten { why: String },
}

fn refused(error: sqlx::error::BoxDynError) -> StoreError {
    place(sqlx::Error::Encode(error))
}
