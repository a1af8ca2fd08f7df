//! The tables of a study on a server, and the triggers that keep events as they were stored.

/// The version of the tables.
pub(super) const VERSION: i64 = 1;

/// Makes the tables, within a transaction. The version is [`VERSION`].
pub(super) const TABLES: &str = "
CREATE SCHEMA IF NOT EXISTS piezotact;

CREATE TABLE piezotact.study (
  single SMALLINT PRIMARY KEY CHECK (single = 1),
  version BIGINT NOT NULL,
  identity TEXT NOT NULL CHECK (length(identity) = 32),
  changes BIGINT NOT NULL
);
INSERT INTO piezotact.study VALUES (1, 1, upper(replace(gen_random_uuid()::text, '-', '')), 0);

CREATE TABLE piezotact.campaign (
  single SMALLINT PRIMARY KEY CHECK (single = 1),
  file TEXT NOT NULL,
  protocol TEXT NOT NULL,
  consent TEXT
);

CREATE TABLE piezotact.sessions (
  begun BIGINT GENERATED ALWAYS AS IDENTITY PRIMARY KEY,
  participant TEXT NOT NULL,
  session TEXT NOT NULL,
  purpose TEXT NOT NULL CHECK (purpose IN ('volunteer', 'rehearsal')),
  UNIQUE (participant, session)
);

CREATE TABLE piezotact.events (
  participant TEXT NOT NULL,
  session TEXT NOT NULL,
  number BIGINT NOT NULL,
  at_ms BIGINT NOT NULL,
  payload_sha BYTEA NOT NULL CHECK (octet_length(payload_sha) = 32),
  sha BYTEA NOT NULL CHECK (octet_length(sha) = 32),
  payload TEXT,
  salt BYTEA CHECK (octet_length(salt) = 16),
  PRIMARY KEY (participant, session, number),
  FOREIGN KEY (participant, session) REFERENCES piezotact.sessions (participant, session),
  CHECK ((payload IS NULL) = (salt IS NULL))
);

CREATE TABLE piezotact.plans (
  participant TEXT NOT NULL,
  session TEXT NOT NULL,
  plan TEXT NOT NULL,
  sha BYTEA NOT NULL CHECK (octet_length(sha) = 32),
  PRIMARY KEY (participant, session)
);

CREATE TABLE piezotact.withdrawals (
  participant TEXT PRIMARY KEY,
  at_ms BIGINT NOT NULL,
  pending TEXT NOT NULL CHECK (pending IN ('bytes', 'nothing')),
  identity_sha BYTEA CHECK (octet_length(identity_sha) = 32)
);

CREATE FUNCTION piezotact.refuse() RETURNS trigger LANGUAGE plpgsql AS
$$ BEGIN RAISE EXCEPTION '%', TG_ARGV[0]; END $$;

CREATE FUNCTION piezotact.has_withdrawn(who TEXT) RETURNS boolean LANGUAGE sql AS
$$ SELECT EXISTS (SELECT 1 FROM piezotact.withdrawals WHERE participant = who) $$;

CREATE TRIGGER study_stays BEFORE DELETE ON piezotact.study
FOR EACH ROW EXECUTE FUNCTION piezotact.refuse('the study is never removed');
CREATE TRIGGER study_is_not_emptied BEFORE TRUNCATE ON piezotact.study
EXECUTE FUNCTION piezotact.refuse('the study is never removed');
CREATE TRIGGER changes_grow BEFORE UPDATE ON piezotact.study FOR EACH ROW
WHEN (NEW.single <> OLD.single OR NEW.version < OLD.version OR NEW.identity <> OLD.identity OR NEW.changes <= OLD.changes)
EXECUTE FUNCTION piezotact.refuse('changes are only counted up');

CREATE TRIGGER campaign_stays BEFORE DELETE OR UPDATE ON piezotact.campaign
FOR EACH ROW EXECUTE FUNCTION piezotact.refuse('a study keeps its campaign');
CREATE TRIGGER campaign_is_not_emptied BEFORE TRUNCATE ON piezotact.campaign
EXECUTE FUNCTION piezotact.refuse('a study keeps its campaign');

CREATE TRIGGER sessions_stay BEFORE DELETE ON piezotact.sessions
FOR EACH ROW EXECUTE FUNCTION piezotact.refuse('sessions are never removed');
CREATE TRIGGER sessions_are_not_emptied BEFORE TRUNCATE ON piezotact.sessions
EXECUTE FUNCTION piezotact.refuse('sessions are never removed');
CREATE TRIGGER sessions_keep BEFORE UPDATE ON piezotact.sessions
FOR EACH ROW EXECUTE FUNCTION piezotact.refuse('sessions are never changed');
CREATE FUNCTION piezotact.sessions_once() RETURNS trigger LANGUAGE plpgsql AS
$$ BEGIN
  IF piezotact.has_withdrawn(NEW.participant) THEN
    RAISE EXCEPTION 'a session is begun once, and not after a withdrawal';
  END IF;
  RETURN NEW;
END $$;
CREATE TRIGGER sessions_once BEFORE INSERT ON piezotact.sessions
FOR EACH ROW EXECUTE FUNCTION piezotact.sessions_once();

CREATE TRIGGER events_stay BEFORE DELETE ON piezotact.events
FOR EACH ROW EXECUTE FUNCTION piezotact.refuse('events are never removed');
CREATE TRIGGER events_are_not_emptied BEFORE TRUNCATE ON piezotact.events
EXECUTE FUNCTION piezotact.refuse('events are never removed');
CREATE FUNCTION piezotact.events_keep() RETURNS trigger LANGUAGE plpgsql AS
$$ BEGIN
  IF NEW.payload IS NULL AND NEW.salt IS NULL
    AND NEW.participant = OLD.participant AND NEW.session = OLD.session AND NEW.number = OLD.number
    AND NEW.at_ms = OLD.at_ms AND NEW.payload_sha = OLD.payload_sha AND NEW.sha = OLD.sha
    AND piezotact.has_withdrawn(OLD.participant)
  THEN RETURN NEW; END IF;
  RAISE EXCEPTION 'events are never changed, only erased after a withdrawal';
END $$;
CREATE TRIGGER events_keep BEFORE UPDATE ON piezotact.events
FOR EACH ROW EXECUTE FUNCTION piezotact.events_keep();
CREATE FUNCTION piezotact.events_in_order() RETURNS trigger LANGUAGE plpgsql AS
$$ BEGIN
  IF piezotact.has_withdrawn(NEW.participant) OR NEW.number <>
    (SELECT coalesce(max(number) + 1, 0) FROM piezotact.events WHERE participant = NEW.participant AND session = NEW.session)
  THEN RAISE EXCEPTION 'events follow each other, and none a withdrawal'; END IF;
  RETURN NEW;
END $$;
CREATE TRIGGER events_in_order BEFORE INSERT ON piezotact.events
FOR EACH ROW EXECUTE FUNCTION piezotact.events_in_order();

CREATE FUNCTION piezotact.plans_keep() RETURNS trigger LANGUAGE plpgsql AS
$$ BEGIN
  IF TG_OP = 'DELETE' THEN
    IF piezotact.has_withdrawn(OLD.participant) THEN RETURN OLD; END IF;
    RAISE EXCEPTION 'a plan is removed only after a withdrawal';
  END IF;
  IF piezotact.has_withdrawn(NEW.participant) THEN
    RAISE EXCEPTION 'nothing is planned after a withdrawal';
  END IF;
  IF TG_OP = 'UPDATE' AND (NEW.participant <> OLD.participant OR NEW.session <> OLD.session OR EXISTS
    (SELECT 1 FROM piezotact.sessions WHERE participant = OLD.participant AND session = OLD.session))
  THEN RAISE EXCEPTION 'a session that was begun keeps its plan'; END IF;
  RETURN NEW;
END $$;
CREATE TRIGGER plans_keep BEFORE INSERT OR UPDATE OR DELETE ON piezotact.plans
FOR EACH ROW EXECUTE FUNCTION piezotact.plans_keep();
CREATE TRIGGER plans_are_not_emptied BEFORE TRUNCATE ON piezotact.plans
EXECUTE FUNCTION piezotact.refuse('a plan is removed only after a withdrawal');

CREATE TRIGGER withdrawals_stay BEFORE DELETE ON piezotact.withdrawals
FOR EACH ROW EXECUTE FUNCTION piezotact.refuse('withdrawals are never removed');
CREATE TRIGGER withdrawals_are_not_emptied BEFORE TRUNCATE ON piezotact.withdrawals
EXECUTE FUNCTION piezotact.refuse('withdrawals are never removed');
CREATE TRIGGER withdrawals_keep BEFORE UPDATE ON piezotact.withdrawals FOR EACH ROW
WHEN (NEW.participant <> OLD.participant OR NEW.at_ms <> OLD.at_ms)
EXECUTE FUNCTION piezotact.refuse('a withdrawal keeps its time');
";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_version_in_the_tables_is_the_one_that_is_checked() {
        assert!(TABLES.contains(&format!("study VALUES (1, {VERSION}, ")));
    }
}
