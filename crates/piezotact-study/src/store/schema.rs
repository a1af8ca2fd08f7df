//! The tables of a study, and the triggers that keep events as they were stored.

/// `PZTS`: marks the database of a study.
pub(super) const APPLICATION: i64 = 0x505A_5453;
/// The version of the tables.
pub(super) const VERSION: i64 = 1;

/// Makes the tables in one transaction. The numbers at the end are [`APPLICATION`] and [`VERSION`].
pub(super) const TABLES: &str = "
CREATE TABLE study (
  only INTEGER PRIMARY KEY CHECK (only = 1),
  identity TEXT NOT NULL CHECK (length(identity) = 32),
  changes INTEGER NOT NULL
) STRICT;
INSERT INTO study VALUES (1, hex(randomblob(16)), 0);

CREATE TABLE sessions (
  begun INTEGER PRIMARY KEY,
  participant TEXT NOT NULL,
  session TEXT NOT NULL,
  purpose TEXT NOT NULL CHECK (purpose IN ('volunteer', 'rehearsal')),
  UNIQUE (participant, session)
) STRICT;

CREATE TABLE events (
  participant TEXT NOT NULL,
  session TEXT NOT NULL,
  number INTEGER NOT NULL,
  at_ms INTEGER NOT NULL,
  payload_sha BLOB NOT NULL CHECK (length(payload_sha) = 32),
  sha BLOB NOT NULL CHECK (length(sha) = 32),
  payload TEXT,
  salt BLOB CHECK (length(salt) = 16),
  PRIMARY KEY (participant, session, number),
  FOREIGN KEY (participant, session) REFERENCES sessions (participant, session),
  CHECK ((payload IS NULL) = (salt IS NULL))
) STRICT;

CREATE TABLE withdrawals (
  participant TEXT PRIMARY KEY,
  at_ms INTEGER NOT NULL,
  pending TEXT NOT NULL CHECK (pending IN ('files', 'bytes', 'nothing')),
  identity_sha BLOB CHECK (length(identity_sha) = 32)
) STRICT;

CREATE TRIGGER study_stays BEFORE DELETE ON study
BEGIN SELECT RAISE(ABORT, 'the study is never removed'); END;
CREATE TRIGGER changes_grow BEFORE UPDATE ON study
WHEN NEW.only <> OLD.only OR NEW.identity <> OLD.identity OR NEW.changes <= OLD.changes
BEGIN SELECT RAISE(ABORT, 'changes are only counted up'); END;

CREATE TRIGGER sessions_stay BEFORE DELETE ON sessions
BEGIN SELECT RAISE(ABORT, 'sessions are never removed'); END;
CREATE TRIGGER sessions_keep BEFORE UPDATE ON sessions
BEGIN SELECT RAISE(ABORT, 'sessions are never changed'); END;
CREATE TRIGGER sessions_once BEFORE INSERT ON sessions
WHEN EXISTS (SELECT 1 FROM sessions WHERE (participant = NEW.participant AND session = NEW.session) OR begun = NEW.begun)
  OR EXISTS (SELECT 1 FROM withdrawals WHERE participant = NEW.participant)
BEGIN SELECT RAISE(ABORT, 'a session is begun once, and not after a withdrawal'); END;

CREATE TRIGGER events_stay BEFORE DELETE ON events
BEGIN SELECT RAISE(ABORT, 'events are never removed'); END;
CREATE TRIGGER events_keep BEFORE UPDATE ON events
WHEN NOT (NEW.payload IS NULL AND NEW.salt IS NULL
  AND NEW.participant = OLD.participant AND NEW.session = OLD.session AND NEW.number = OLD.number
  AND NEW.at_ms = OLD.at_ms AND NEW.payload_sha = OLD.payload_sha AND NEW.sha = OLD.sha
  AND EXISTS (SELECT 1 FROM withdrawals WHERE participant = OLD.participant))
BEGIN SELECT RAISE(ABORT, 'events are never changed, only erased after a withdrawal'); END;
CREATE TRIGGER events_in_order BEFORE INSERT ON events
WHEN NEW.number <> (SELECT coalesce(max(number) + 1, 0) FROM events WHERE participant = NEW.participant AND session = NEW.session)
  OR EXISTS (SELECT 1 FROM withdrawals WHERE participant = NEW.participant)
BEGIN SELECT RAISE(ABORT, 'events follow each other, and none a withdrawal'); END;

CREATE TRIGGER withdrawals_stay BEFORE DELETE ON withdrawals
BEGIN SELECT RAISE(ABORT, 'withdrawals are never removed'); END;
CREATE TRIGGER withdrawals_keep BEFORE UPDATE ON withdrawals
WHEN NEW.participant <> OLD.participant OR NEW.at_ms <> OLD.at_ms
BEGIN SELECT RAISE(ABORT, 'a withdrawal keeps its time'); END;
CREATE TRIGGER withdrawals_once BEFORE INSERT ON withdrawals
WHEN EXISTS (SELECT 1 FROM withdrawals WHERE participant = NEW.participant)
BEGIN SELECT RAISE(ABORT, 'a participant withdraws once'); END;

PRAGMA application_id = 1348097107;
PRAGMA user_version = 1;
";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbers_in_the_tables_are_the_ones_that_are_checked() {
        assert!(TABLES.contains(&format!("application_id = {APPLICATION};")));
        assert!(TABLES.contains(&format!("user_version = {VERSION};")));
    }
}
