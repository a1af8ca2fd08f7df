//! A study in a PostgreSQL database: what every store must do, what the triggers refuse, several stations, and servers that are refused.

use std::path::Path;

use piezotact_people::campaign::store::{Purpose, SessionKey, Store as _, StoreError, conformance};
use piezotact_study::store::{
    DatabaseUrl, NewCampaign, Notice, Remains, StudyCampaign, StudyError, StudyStore,
};

use crate::campaigns::{new, planned, protocol};
use crate::postgres::{Server, server};
use crate::{AT_MS, append, fill, holding, key, name, passphrase, whole};

pub(crate) fn url(text: &str) -> DatabaseUrl {
    text.parse().unwrap()
}

/// A station of the study in a new database, with `count` events of P01.
pub(crate) fn station(server: &Server, folder: &Path, count: u64) -> (StudyStore, String) {
    let database = server.database();
    let mut store = StudyStore::create_on(folder, &url(&database)).unwrap();
    store.begin(&key(), Purpose::Volunteer).unwrap();
    for number in 0..count {
        append(&mut store, &key(), number).unwrap();
    }
    (store, database)
}

#[test]
fn the_store_on_a_server_conforms() {
    let folder = tempfile::tempdir().unwrap();
    let database = url(&server().database());
    let mut store = StudyStore::create_on(folder.path(), &database).unwrap();
    assert_eq!(conformance::check(&mut store), Ok(()));
    // And so it is read by the next program, and at another station.
    drop(store);
    let other = tempfile::tempdir().unwrap();
    for store in [
        StudyStore::open(folder.path()).unwrap(),
        StudyStore::join(other.path(), &database).unwrap(),
    ] {
        assert_eq!(store.verify().unwrap(), 2);
        assert_eq!(store.sessions().unwrap()[0].withdrawn_at_ms, Some(5));
    }
}

#[test]
fn what_was_stored_on_a_server_is_not_changed_past_the_store() {
    let folder = tempfile::tempdir().unwrap();
    let (mut store, database) = station(server(), folder.path(), 2);
    let before = store.events(&key()).unwrap();
    let refused = |statement: &str, why: &str| {
        let statement = format!("SET search_path TO piezotact; {statement}");
        let said = server().try_sql(&database, &statement).unwrap_err();
        assert!(said.contains(why), "{statement}: {said}");
    };
    for (statement, why) in [
        ("DELETE FROM events", "events are never removed"),
        ("TRUNCATE events", "events are never removed"),
        ("DELETE FROM sessions", "sessions are never removed"),
        ("TRUNCATE sessions CASCADE", "never removed"),
        ("DELETE FROM study", "the study is never removed"),
        ("TRUNCATE study", "the study is never removed"),
        (
            "UPDATE events SET payload = '{}' WHERE number = 0",
            "never changed",
        ),
        (
            "UPDATE events SET payload = NULL, salt = NULL",
            "never changed",
        ),
        ("UPDATE events SET at_ms = 0", "never changed"),
        (
            "UPDATE sessions SET purpose = 'rehearsal'",
            "sessions are never changed",
        ),
        ("UPDATE study SET changes = 0", "only counted up"),
        (
            "UPDATE study SET identity = repeat('0', 32)",
            "only counted up",
        ),
        (
            "INSERT INTO events SELECT participant, session, 5, 0, payload_sha, sha, payload, salt FROM events WHERE number = 0",
            "events follow each other",
        ),
        (
            "INSERT INTO events SELECT participant, session, 2, 0, payload_sha, sha, payload, NULL FROM events WHERE number = 0",
            "check constraint",
        ),
        (
            "INSERT INTO sessions (participant, session, purpose) VALUES ('P01', 'discrimination', 'rehearsal')",
            "unique constraint",
        ),
        (
            "INSERT INTO events VALUES ('P02', 'x', 0, 0, sha256('a'), sha256('b'), '', '0123456789abcdef')",
            "foreign key constraint",
        ),
        (
            "INSERT INTO study VALUES (2, 1, repeat('0', 32), 0)",
            "check constraint",
        ),
    ] {
        refused(statement, why);
    }
    assert_eq!(store.events(&key()).unwrap(), before);
    store.erase("P01", 5).unwrap();
    for (statement, why) in [
        ("DELETE FROM withdrawals", "withdrawals are never removed"),
        ("TRUNCATE withdrawals", "withdrawals are never removed"),
        ("UPDATE withdrawals SET at_ms = 6", "keeps its time"),
        (
            "INSERT INTO withdrawals VALUES ('P01', 6, 'nothing', NULL)",
            "unique constraint",
        ),
        (
            "UPDATE events SET payload = '{}', salt = '0123456789abcdef'",
            "never changed",
        ),
        (
            "INSERT INTO sessions (participant, session, purpose) VALUES ('P01', 'y', 'rehearsal')",
            "not after a withdrawal",
        ),
        (
            "INSERT INTO plans VALUES ('P01', 'y', '', sha256('a'))",
            "nothing is planned after a withdrawal",
        ),
    ] {
        refused(statement, why);
    }
    assert_eq!(store.verify().unwrap(), 1);
}

#[test]
fn two_stations_store_each_answer_once() {
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let (mut here, database) = station(server(), folders[0].path(), 2);
    let mut there = StudyStore::join(folders[1].path(), &url(&database)).unwrap();
    assert_eq!(whole(&there), 2);
    let begun = there.begin(&key(), Purpose::Volunteer);
    assert!(matches!(begun, Err(StoreError::Exists { .. })));
    append(&mut there, &key(), 2).unwrap();
    let late = append(&mut here, &key(), 2).unwrap_err();
    assert!(
        matches!(
            late,
            StoreError::Overtaken {
                expected: 2,
                found: 3,
                ..
            }
        ),
        "{late}"
    );
    append(&mut here, &key(), 3).unwrap();
    // Both at once: of each number one is stored.
    let stored: Vec<u64> = std::thread::scope(|scope| {
        let mut threads = Vec::new();
        for store in [&mut here, &mut there] {
            threads.push(scope.spawn(move || {
                let mut stored = Vec::new();
                for number in 4..104 {
                    match append(store, &key(), number) {
                        Ok(link) => stored.push(link.number),
                        Err(StoreError::Overtaken { .. }) => {}
                        Err(other) => panic!("{other}"),
                    }
                    while store.events(&key()).unwrap().len() as u64 <= number {
                        std::thread::yield_now();
                    }
                }
                stored
            }));
        }
        let stored = threads.into_iter().flat_map(|t| t.join().unwrap());
        stored.collect()
    });
    let mut sorted = stored.clone();
    sorted.sort_unstable();
    assert_eq!(sorted, (4..104).collect::<Vec<_>>());
    assert_eq!((whole(&here), whole(&there)), (104, 104));
}

#[test]
fn a_session_runs_at_one_station() {
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let (here, database) = station(server(), folders[0].path(), 0);
    let there = StudyStore::join(folders[1].path(), &url(&database)).unwrap();
    let lock = here.run_alone(&name("P01"), "discrimination").unwrap();
    let held = there.run_alone(&name("P01"), "discrimination").unwrap_err();
    assert!(
        held.to_string()
            .contains("is run by another program (a station at 127.0.0.1)"),
        "{held}"
    );
    drop(there.run_alone(&name("P02"), "discrimination").unwrap());
    drop(lock);
    drop(here);
    // The server hears of it a moment later.
    let again = (0..50).find_map(|_| {
        std::thread::sleep(std::time::Duration::from_millis(20));
        there.run_alone(&name("P01"), "discrimination").ok()
    });
    assert!(again.is_some());
}

#[test]
fn a_withdrawal_is_seen_at_the_other_station() {
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let (mut here, database) = station(server(), folders[0].path(), 40);
    let mut there = StudyStore::join(folders[1].path(), &url(&database)).unwrap();
    fill(&mut here, "P01");
    fill(&mut there, "P01");
    let head = here.head(&key()).unwrap();
    let done = here
        .withdraw(&name("P01"), AT_MS + 7, Some(&passphrase()))
        .unwrap();
    assert_eq!((done.sessions, done.files, done.identities), (1, 3, 1));
    assert_eq!(done.remains, Remains::OnServer);
    assert!(holding(folders[0].path(), "quince").is_empty());
    let rows = "SELECT count(*), count(payload), count(salt) FROM piezotact.events";
    assert_eq!(server().sql(&database, rows), "40|0|0");
    assert_eq!(here.head(&key()).unwrap(), head);
    assert!(here.notices().is_empty());
    // Whoever is in the middle of a session there stores nothing more.
    let refused = append(&mut there, &key(), 40);
    assert!(matches!(refused, Err(StoreError::Withdrawn { .. })));
    drop(there);
    // The identity there needs the passphrase; the files do not.
    let mut there = StudyStore::open(folders[1].path()).unwrap();
    let identities = folders[1].path().join("identity.age");
    assert_eq!(
        there.notices(),
        [
            Notice::FilesErased {
                participant: "P01".into(),
                files: 3
            },
            Notice::MayBeNamed {
                participant: "P01".into(),
                path: identities
            },
        ]
    );
    assert!(holding(folders[1].path(), "quince").is_empty());
    let done = there
        .withdraw(&name("P01"), AT_MS + 9, Some(&passphrase()))
        .unwrap();
    assert_eq!((done.files, done.identities), (0, 1));
    assert!(there.identities(&passphrase()).unwrap().is_empty());
    drop(there);
    let there = StudyStore::open(folders[1].path()).unwrap();
    assert_eq!(there.notices(), []);
    assert_eq!(there.verify().unwrap(), 1);
    assert_eq!(
        there.sessions().unwrap()[0].withdrawn_at_ms,
        Some(AT_MS + 7)
    );
}

/// The tables of a server hold no byte of a participant who has withdrawn: they are looked through on its disk.
#[test]
fn a_withdrawal_rewrites_the_tables_of_the_server() {
    let own = Server::start("");
    let folder = tempfile::tempdir().unwrap();
    let (mut store, database) = station(&own, folder.path(), 200);
    let files = own.sql(
        &database,
        "CHECKPOINT; SELECT current_setting('data_directory') || '/' || regexp_replace(pg_relation_filepath('piezotact.events'), '/[^/]*$', '')",
    );
    assert!(!holding(Path::new(&files), "quince").is_empty());
    store.withdraw(&name("P01"), AT_MS, None).unwrap();
    own.sql(&database, "CHECKPOINT");
    assert_eq!(
        holding(Path::new(&files), "quince"),
        Vec::<std::path::PathBuf>::new()
    );
}

fn refusal(done: Result<StudyStore, StudyError>) -> String {
    done.unwrap_err().to_string()
}

#[test]
fn a_server_that_cannot_be_used_is_refused_in_a_sentence() {
    let folder = tempfile::tempdir().unwrap();
    let create = |database: &str| {
        let made = StudyStore::create_on(&folder.path().join("study"), &url(database));
        let refused = refusal(made);
        assert!(!folder.path().join("study").exists(), "{refused}");
        refused
    };
    let server = server();
    // Nobody listens.
    let refused = create("postgres://lab@127.0.0.1:1/touch");
    assert!(
        refused.contains("Connection refused")
            && refused.ends_with("check host and port in the URL, and that the server runs"),
        "{refused}"
    );
    let refused = create(&server.url("nowhere"));
    assert!(
        refused.contains("database \"nowhere\" does not exist; check the name of the database"),
        "{refused}"
    );
    let refused = create(&server.url("touch").replace("lab@", "nobody_here@"));
    assert!(
        refused.contains("role \"nobody_here\" does not exist; check the user in the URL, and the password in PGPASSWORD"),
        "{refused}"
    );
    let database = server.database();
    server.sql(&database, "CREATE ROLE guest LOGIN");
    let as_guest = database.replace("lab@", "guest@");
    let refused = create(&as_guest);
    assert!(
        refused.contains("permission denied for database")
            && refused.contains("CREATE on the database"),
        "{refused}"
    );
    // No study, something else, and a later version.
    let refused = refusal(StudyStore::join(
        &folder.path().join("study"),
        &url(&database),
    ));
    assert!(
        refused.contains("expected the database of a study, found one without"),
        "{refused}"
    );
    server.sql(
        &database,
        "CREATE SCHEMA piezotact; CREATE TABLE piezotact.study (name TEXT)",
    );
    assert!(
        create(&database).contains("expected the tables of a study in the schema piezotact, found something else; name another database")
    );
    server.sql(&database, "DROP SCHEMA piezotact CASCADE");
    let store = StudyStore::create_on(&folder.path().join("made"), &url(&database)).unwrap();
    drop(store);
    assert!(create(&database).contains("a study is in this database already"));
    // Somebody who may only look.
    server.sql(
        &database,
        "GRANT USAGE ON SCHEMA piezotact TO guest; GRANT SELECT ON ALL TABLES IN SCHEMA piezotact TO guest",
    );
    let refused = refusal(StudyStore::join(
        &folder.path().join("study"),
        &url(&as_guest),
    ));
    assert!(
        refused.contains("SELECT, INSERT, UPDATE and DELETE on its tables"),
        "{refused}"
    );
    server.sql(&database, "REVOKE ALL ON SCHEMA piezotact FROM guest; REVOKE ALL ON ALL TABLES IN SCHEMA piezotact FROM guest");
    let refused = refusal(StudyStore::join(
        &folder.path().join("study"),
        &url(&as_guest),
    ));
    assert!(
        refused.contains("permission denied") && refused.contains("USAGE on the schema"),
        "{refused}"
    );
    server.sql(
        &database,
        "ALTER ROLE guest SET default_transaction_read_only = on",
    );
    let refused = refusal(StudyStore::join(
        &folder.path().join("study"),
        &url(&as_guest),
    ));
    assert!(
        refused.contains("expected a database that takes changes"),
        "{refused}"
    );
    server.sql(
        &database,
        "UPDATE piezotact.study SET version = 2, changes = changes + 1",
    );
    let refused = refusal(StudyStore::open(&folder.path().join("made")));
    assert!(
        refused.contains("version 2 is newer than version 1, the latest that this program reads")
            && refused.contains("open it with a newer Piezotact"),
        "{refused}"
    );
    let latin = "CREATE DATABASE latin ENCODING 'LATIN1' TEMPLATE template0";
    server.sql(&database, latin);
    assert!(create(&server.url("latin")).contains("encoding UTF8, found LATIN1"));
}

/// Where fsync is off, a power cut loses what was acknowledged: no answer of a volunteer is stored there.
#[test]
fn a_server_that_loses_answers_takes_none_of_volunteers() {
    let own = Server::start("");
    let folder = tempfile::tempdir().unwrap();
    let (mut store, database) = station(&own, folder.path(), 1);
    let tried = SessionKey::new("P02", "discrimination");
    store.begin(&tried, Purpose::Rehearsal).unwrap();
    own.set("fsync = off");
    let found = (0..100).any(|_| {
        std::thread::sleep(std::time::Duration::from_millis(20));
        own.sql(&database, "SHOW fsync") == "off"
    });
    assert!(found);
    std::thread::sleep(std::time::Duration::from_millis(200));
    for refused in [
        append(&mut store, &key(), 1).map(|_| ()),
        store.begin(&SessionKey::new("P03", "x"), Purpose::Volunteer),
    ] {
        let refused = refused.unwrap_err().to_string();
        assert!(
            refused.contains("(fsync = on, full_page_writes = on), found one that does not; have the administrator set both to on"),
            "{refused}"
        );
    }
    append(&mut store, &tried, 0).unwrap();
    let other = tempfile::tempdir().unwrap();
    let refused = refusal(StudyStore::create_on(other.path(), &url(&own.database())));
    assert!(refused.contains("keeps through a power cut"), "{refused}");
    // Who withdraws is erased on any server.
    assert_eq!(
        store.withdraw(&name("P01"), AT_MS, None).unwrap().sessions,
        1
    );
}

/// The database is that of another study, or older than what this station saw.
#[test]
fn an_older_backup_and_another_study_are_found() {
    let own = Server::start("");
    let folder = tempfile::tempdir().unwrap();
    let (mut store, database) = station(&own, folder.path(), 3);
    own.crash();
    own.copy("data", "backup");
    own.start_again();
    // The connection was lost with the server, and is made again.
    assert!(matches!(
        append(&mut store, &key(), 3),
        Err(StoreError::Place { .. })
    ));
    append(&mut store, &key(), 3).unwrap();
    append(&mut store, &key(), 4).unwrap();
    own.crash();
    own.copy("backup", "data");
    own.start_again();
    // While it is open.
    assert!(append(&mut store, &key(), 5).is_err());
    let refused = append(&mut store, &key(), 5).unwrap_err().to_string();
    assert!(
        refused.contains("restored from an older backup"),
        "{refused}"
    );
    drop(store);
    let refused = StudyStore::open(folder.path()).unwrap_err();
    assert!(
        matches!(
            refused,
            StudyError::Lost {
                acknowledged: 6,
                found: 4,
                ..
            }
        ),
        "{refused}"
    );
    assert!(
        refused
            .to_string()
            .contains("restore it from a newer backup"),
        "{refused}"
    );
    // Without the seal, somebody goes on with what is there.
    std::fs::remove_file(folder.path().join("study.seal")).unwrap();
    assert_eq!(whole(&StudyStore::open(folder.path()).unwrap()), 3);
    own.sql(&database, "DROP SCHEMA piezotact CASCADE");
    let other = tempfile::tempdir().unwrap();
    drop(StudyStore::create_on(other.path(), &url(&database)).unwrap());
    let refused = refusal(StudyStore::open(folder.path()));
    assert!(
        refused.contains(
            "expected the study of this folder, found another one; correct the URL in study.url"
        ),
        "{refused}"
    );
}

#[test]
fn a_folder_belongs_to_one_database() {
    let folder = tempfile::tempdir().unwrap();
    let (store, database) = station(server(), folder.path(), 1);
    drop(store);
    let other = url(&server().database());
    for refused in [
        refusal(StudyStore::create_on(folder.path(), &other)),
        refusal(StudyStore::join(folder.path(), &other)),
        refusal(StudyStore::create(folder.path())),
    ] {
        assert!(refused.contains("name another folder"), "{refused}");
    }
    let path = folder.path().join("study.url");
    assert_eq!(
        std::fs::read_to_string(&path).unwrap(),
        format!("{database}\n")
    );
    std::fs::write(&path, database.replace("lab@", "lab:quince@")).unwrap();
    let refused = refusal(StudyStore::open(folder.path()));
    assert!(
        refused.contains("holds a password: leave it out") && !refused.contains("quince"),
        "{refused}"
    );
    let in_folder = tempfile::tempdir().unwrap();
    drop(StudyStore::create(in_folder.path()).unwrap());
    assert!(
        refusal(StudyStore::join(in_folder.path(), &other))
            .contains("found study.sqlite in the folder")
    );
}

#[test]
fn a_campaign_is_the_same_at_every_station() {
    let protocol = protocol();
    let folder = tempfile::tempdir().unwrap();
    let database = url(&server().database());
    let (first, second) = (folder.path().join("first"), folder.path().join("second"));
    let refused = StudyCampaign::join(&second, &database).unwrap_err();
    assert!(
        refused.to_string().contains("found one without"),
        "{refused}"
    );
    // A creation that ended before the campaign was entered.
    drop(StudyStore::create_on(&first, &database).unwrap());
    let refused = StudyCampaign::join(&second, &database).unwrap_err();
    assert!(
        matches!(refused, StudyError::Unfinished { .. }),
        "{refused}"
    );
    drop(StudyCampaign::create_on(&first, &database, &new(protocol)).unwrap());
    // And one that ended before its files were written.
    for file in ["campaign.json", "consent.txt"] {
        std::fs::remove_file(first.join(file)).unwrap();
    }
    let mut here = StudyCampaign::create_on(&first, &database, &new(protocol)).unwrap();
    let other = NewCampaign {
        seed: 12,
        ..new(protocol)
    };
    let refused = StudyCampaign::create_on(&second, &database, &other).unwrap_err();
    assert!(matches!(refused, StudyError::Taken { .. }), "{refused}");
    assert!(!second.exists());
    let there = StudyCampaign::join(&second, &database).unwrap();
    for file in ["campaign.json", "protocol.toml", "consent.txt"] {
        let read = |folder: &Path| std::fs::read(folder.join(file)).unwrap();
        assert_eq!(read(&first), read(&second), "{file}");
    }
    assert_eq!(
        (
            here.campaign().unwrap().seed,
            there.campaign().unwrap().seed
        ),
        (11, 11)
    );
    // A plan that is written here is read there, and nowhere else.
    let plan = planned(&here.campaign().unwrap(), "P01", &[]);
    here.write_plan(&plan).unwrap();
    here.begin(&SessionKey::new("P01", &plan.session), Purpose::Volunteer)
        .unwrap();
    assert_eq!(
        there.plan(&name("P01"), &plan.session).unwrap(),
        Some(plan.clone())
    );
    let folder = here.session_folder(&name("P01"), &plan.session).unwrap();
    assert!(folder.is_dir() && !folder.join("plan.json").exists());
    let mut there = there;
    there.write_plan(&plan).unwrap();
    let mut changed = plan.clone();
    changed.seed += 1;
    let refused = there.write_plan(&changed).unwrap_err();
    assert!(matches!(refused, StudyError::Planned { .. }), "{refused}");
    let directly = server().try_sql(database.as_str(), "UPDATE piezotact.plans SET plan = ''");
    assert!(directly.unwrap_err().contains("keeps its plan"));
    there.withdraw(&name("P01"), AT_MS, None).unwrap();
    assert_eq!(here.plan(&name("P01"), &plan.session).unwrap(), None);
    // A seed that is changed in one folder is found there.
    let path = second.join("campaign.json");
    let text = std::fs::read_to_string(&path).unwrap();
    std::fs::write(&path, text.replace("\"seed\": 11", "\"seed\": 12")).unwrap();
    let refused = there.campaign().unwrap_err();
    assert!(matches!(refused, StudyError::NotShared { .. }), "{refused}");
    assert!(here.campaign().is_ok() && text.contains("\"seed\": 11"));
}

/// What `sslmode` says is done, with the certificate that the URL names.
#[test]
fn a_connection_is_encrypted_as_the_url_says() {
    let (own, folder) = (Server::start(""), tempfile::tempdir().unwrap());
    let database = own.database();
    let create = |name: &str, options: &str| {
        let url = url(&format!("{database}?{options}"));
        StudyStore::create_on(&folder.path().join(name), &url)
    };
    let refused = refusal(create("plain", "sslmode=require"));
    assert!(
        refused.contains("TLS")
            && refused.ends_with("check sslmode in the URL, and the certificates of the server"),
        "{refused}"
    );
    let made = rcgen::generate_simple_self_signed(["127.0.0.1".to_owned()]).unwrap();
    own.write("server.crt", &made.cert.pem());
    own.write("server.key", &made.signing_key.serialize_pem());
    own.set("ssl = on");
    own.allow("hostssl all lab 127.0.0.1/32 trust\n");
    let refused = refusal(create("plain", "sslmode=disable"));
    assert!(refused.contains("check the user in the URL"), "{refused}");
    drop(create("encrypted", "sslmode=require").unwrap());
    let refused = refusal(create("unknown", "sslmode=verify-full"));
    assert!(
        refused.ends_with("check sslmode in the URL, and the certificates of the server"),
        "{refused}"
    );
    let root = folder.path().join("root.crt");
    std::fs::write(&root, made.cert.pem()).unwrap();
    let verified = url(&format!(
        "{database}?sslmode=verify-full&sslrootcert={}",
        root.display()
    ));
    let store = StudyStore::join(&folder.path().join("verified"), &verified).unwrap();
    assert_eq!(store.verify().unwrap(), 0);
}
