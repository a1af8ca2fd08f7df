//! The address of a database that several stations share.

use crate::store::error::StudyError;
use std::fmt;
use std::str::FromStr;

use sqlx::ConnectOptions as _;
use sqlx::postgres::PgConnectOptions;

/// What can stand behind the `?` of an address. A password is none of them, whatever it is written as.
const OPTIONS: [&str; 8] = [
    "sslmode",
    "sslrootcert",
    "sslcert",
    "sslkey",
    "host",
    "port",
    "user",
    "dbname",
];

/// The address of a PostgreSQL database, without a password: `postgres://USER@HOST:PORT/DATABASE?sslmode=verify-full`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct DatabaseUrl {
    text: String,
}

impl DatabaseUrl {
    /// The address as it was given.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.text
    }

    /// How to connect: the password is that of PGPASSWORD or of the user's password file.
    pub(super) fn options(&self) -> Result<PgConnectOptions, StudyError> {
        let options = PgConnectOptions::from_str(&self.text);
        let options = options.map_err(|error| form(error.to_string()))?;
        // An address of version 6 stands in brackets in a URL, and without them elsewhere.
        let host = options.get_host().trim_matches(['[', ']']).to_owned();
        Ok(options.host(&host).disable_statement_logging())
    }
}

impl fmt::Display for DatabaseUrl {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.text)
    }
}

impl FromStr for DatabaseUrl {
    type Err = StudyError;

    fn from_str(text: &str) -> Result<Self, StudyError> {
        let schemes = ["postgres://", "postgresql://"];
        let rest = schemes.iter().find_map(|scheme| text.strip_prefix(scheme));
        let rest = rest.ok_or_else(|| form("another scheme"))?;
        if rest.chars().any(|c| c.is_whitespace() || c.is_control()) {
            return Err(form("a space or a control character"));
        }
        // A password may hold any of the characters that end what stands before it.
        let (before_last_at, _) = rest.rsplit_once('@').unwrap_or_default();
        if before_last_at.contains(':') {
            return Err(StudyError::UrlPassword);
        }
        let (address, options) = rest.split_once('?').unwrap_or((rest, ""));
        let database = address.split_once('/').map_or("", |(_, path)| path);
        for option in options.split('&').filter(|option| !option.is_empty()) {
            let (name, _) = option.split_once('=').unwrap_or((option, ""));
            if name.eq_ignore_ascii_case("password") {
                return Err(StudyError::UrlPassword);
            }
            if !OPTIONS.contains(&name) {
                let known = OPTIONS.join(", ");
                return Err(form(format!("an option that is none of {known}")));
            }
        }
        if rest.contains('#') {
            return Err(form("a `#`"));
        }
        if database.is_empty() && !options.contains("dbname=") {
            return Err(form("no name of a database"));
        }
        let url = Self {
            text: text.to_owned(),
        };
        url.options()?;
        Ok(url)
    }
}

fn form(found: impl Into<String>) -> StudyError {
    StudyError::NoUrl {
        found: found.into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_has_a_database_and_no_password() {
        for good in [
            "postgres://lab@db.example.org:5432/touch",
            "postgresql://db.example.org/touch?sslmode=verify-full",
            "postgres://lab@%2Fvar%2Frun%2Fpostgresql/touch",
            "postgres:///touch?host=/var/run/postgresql",
            "postgres://lab@[::1]:5433/touch",
        ] {
            let url: DatabaseUrl = good.parse().unwrap();
            assert_eq!(url.to_string(), good);
        }
        let url: DatabaseUrl = "postgres://lab@[::1]:5433/touch".parse().unwrap();
        assert_eq!(url.options().unwrap().get_host(), "::1");
        for secret in [
            "postgres://lab:quince@host/touch",
            "postgres://lab:qu@ince@host/touch",
            "postgres://lab:qu/i?n#ce@host/touch",
            "postgres://lab@host/touch?password=quince",
            "postgres://lab@host/touch?sslmode=require&PASSWORD=quince",
        ] {
            let refused = secret.parse::<DatabaseUrl>().unwrap_err();
            assert!(matches!(refused, StudyError::UrlPassword), "{secret}");
        }
        for bad in [
            "",
            "study",
            "mysql://lab@host/touch",
            "postgres://",
            "postgres://lab@host",
            "postgres://lab@host/",
            "postgres://lab@host:port/touch",
            "postgres://lab@host/touch?sslmode=perhaps",
            "postgres://lab@host/touch?p%61ssword=quince",
            "postgres://lab@host/touch?options=-c fsync",
            "postgres://lab@host/touch#quince",
            "postgres://lab@ho st/touch",
            "postgres://lab@host/touch\n",
        ] {
            let refused = bad.parse::<DatabaseUrl>().unwrap_err().to_string();
            assert!(!refused.contains("quince"), "{bad}: {refused}");
        }
    }
}
