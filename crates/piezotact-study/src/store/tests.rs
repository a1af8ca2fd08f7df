//! The store from inside: the common check, what the triggers refuse, foreign files, and withdrawals that end between two steps.

use std::path::Path;

use piezotact_people::campaign::store::{
    NewEvent, Purpose, SessionKey, Store as _, StoreError, conformance,
};

use super::identity::NEXT;
use super::seal::SEAL;
use super::{DATABASE, Passphrase, PersonalData, Pseudonym, StudyError, StudyStore};

fn event(json: &str) -> NewEvent<'_> {
    NewEvent {
        at_ms: 1_700_000_000_000,
        json,
        salt: [9; 16],
    }
}

fn refusal(store: &StudyStore, statement: &'static str) -> String {
    let done = store.read(async |database| database.run(statement).await);
    done.err()
        .map_or_else(String::new, |error| error.to_string())
}

/// A study with one session of two events.
fn study(folder: &Path) -> (StudyStore, SessionKey) {
    let mut store = StudyStore::create(folder).unwrap();
    let key = SessionKey::new("P01", "discrimination");
    store.begin(&key, Purpose::Volunteer).unwrap();
    store
        .append(&key, 0, event("{\"secret\":\"quince\"}"))
        .unwrap();
    store
        .append(&key, 1, event("{\"secret\":\"medlar\"}"))
        .unwrap();
    (store, key)
}

fn passphrase() -> Passphrase {
    let passphrase = Passphrase::new("four words of wood".into()).unwrap();
    passphrase.with_work_factor(2)
}

fn person(name: &str) -> PersonalData {
    PersonalData {
        name: name.into(),
        contact: "room 7".into(),
        consent: None,
    }
}

#[test]
fn the_store_on_disk_conforms() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = StudyStore::create(folder.path()).unwrap();
    assert_eq!(conformance::check(&mut store), Ok(()));
    // And so it is read by the next program.
    drop(store);
    let store = StudyStore::open(folder.path()).unwrap();
    assert_eq!(store.verify().unwrap(), 2);
    assert_eq!(store.sessions().unwrap()[0].withdrawn_at_ms, Some(5));
}

#[test]
fn what_was_stored_is_not_changed_past_the_store() {
    let folder = tempfile::tempdir().unwrap();
    let (mut store, key) = study(folder.path());
    let before = store.events(&key).unwrap();
    let refused = [
        "DELETE FROM events",
        "DELETE FROM sessions",
        "DELETE FROM study",
        "UPDATE events SET payload = '{}' WHERE number = 0",
        "UPDATE events SET payload = NULL, salt = NULL",
        "UPDATE events SET at_ms = 0",
        "UPDATE sessions SET purpose = 'rehearsal'",
        "UPDATE study SET changes = 0",
        "INSERT OR REPLACE INTO events SELECT participant, session, number, 0, payload_sha, sha, payload, salt FROM events WHERE number = 0",
        "INSERT INTO events SELECT participant, session, 5, 0, payload_sha, sha, payload, salt FROM events WHERE number = 0",
        "INSERT OR REPLACE INTO sessions VALUES (1, 'P01', 'discrimination', 'rehearsal')",
        "INSERT OR REPLACE INTO sessions VALUES (1, 'P07', 'x', 'rehearsal')",
        "INSERT INTO events VALUES ('P02', 'x', 0, 0, zeroblob(32), zeroblob(32), '', zeroblob(16))",
    ];
    for statement in refused {
        assert_ne!(refusal(&store, statement), "", "{statement}");
    }
    assert_eq!(store.events(&key).unwrap(), before);
    store.erase("P01", 5).unwrap();
    let refused = [
        "DELETE FROM withdrawals",
        "UPDATE withdrawals SET at_ms = 6",
        "INSERT OR REPLACE INTO withdrawals VALUES ('P01', 6, 'nothing', NULL)",
        "UPDATE events SET payload = '{}', salt = zeroblob(16)",
        "INSERT INTO sessions (participant, session, purpose) VALUES ('P01', 'y', 'rehearsal')",
    ];
    for statement in refused {
        assert_ne!(refusal(&store, statement), "", "{statement}");
    }
    assert_eq!(store.verify().unwrap(), 1);
}

/// Somebody who removes the triggers is found by the chain.
#[test]
fn one_flipped_bit_in_the_database_is_found() {
    let folder = tempfile::tempdir().unwrap();
    let (store, _) = study(folder.path());
    drop(store);
    let path = folder.path().join(DATABASE);
    let mut bytes = std::fs::read(&path).unwrap();
    let at = bytes
        .windows(6)
        .position(|window| window == b"medlar")
        .unwrap();
    bytes[at] ^= 1;
    std::fs::write(&path, bytes).unwrap();
    let store = StudyStore::open(folder.path()).unwrap();
    assert!(matches!(
        store.verify(),
        Err(StoreError::Gap { .. } | StoreError::Changed { .. } | StoreError::Broken { .. })
    ));
}

/// Somebody who removes the triggers, notes a withdrawal that was none, or erases an event of a person who stays.
#[test]
fn a_withdrawal_and_what_is_erased_belong_together() {
    let changed = |statement: &'static str| {
        let folder = tempfile::tempdir().unwrap();
        let (store, _) = study(folder.path());
        for trigger in ["DROP TRIGGER events_keep", "DROP TRIGGER withdrawals_once"] {
            assert_eq!(refusal(&store, trigger), "");
        }
        assert_eq!(refusal(&store, statement), "");
        drop(store);
        let store = StudyStore::open(folder.path()).unwrap();
        store.verify().unwrap_err().to_string()
    };
    assert_eq!(
        changed("INSERT INTO withdrawals VALUES ('P01', 6, 'nothing', NULL)"),
        "what is stored was changed or damaged: P01 is noted as withdrawn, and events of session discrimination are still there; \
         restore the whole folder from a copy"
    );
    assert_eq!(
        changed("UPDATE events SET payload = NULL, salt = NULL WHERE number = 1"),
        "what is stored was changed or damaged: event 1 of session discrimination of P01, who has not withdrawn, was erased; \
         restore the whole folder from a copy"
    );
}

/// Somebody who removes the triggers, and events from the end of a journal, whose rest is a chain that verifies.
#[test]
fn last_events_that_were_removed_are_found_by_the_count() {
    let changed = |withdrawn: bool, statements: &[&'static str]| {
        let folder = tempfile::tempdir().unwrap();
        let (mut store, _) = study(folder.path());
        let other = SessionKey::new("P02", "discrimination");
        store.begin(&other, Purpose::Volunteer).unwrap();
        store.append(&other, 0, event("{}")).unwrap();
        if withdrawn {
            let passphrase = Some(passphrase());
            let name = Pseudonym::new("P02").unwrap();
            store
                .withdraw(&name, event("").at_ms + 1, passphrase.as_ref())
                .unwrap();
        }
        for trigger in ["DROP TRIGGER events_stay", "DROP TRIGGER sessions_stay"] {
            assert_eq!(refusal(&store, trigger), "");
        }
        for statement in statements {
            assert_eq!(refusal(&store, statement), "");
        }
        drop(store);
        let store = StudyStore::open(folder.path()).unwrap();
        let verified = store.verify().map_err(|error| error.to_string());
        // Reading the sessions gives the same error.
        let read = store.sessions().map_err(|error| error.to_string());
        assert_eq!(read.err(), verified.clone().err());
        (
            verified.err().unwrap_or_default(),
            store.unexplained_changes().unwrap(),
        )
    };
    assert_eq!(changed(false, &[]), (String::new(), 0));
    assert_eq!(changed(true, &[]), (String::new(), 0));
    let last = "DELETE FROM events WHERE participant = 'P01' AND number = 1";
    let (found, unexplained) = changed(false, &[last]);
    assert_eq!(
        found,
        "what is stored was changed or damaged: the study counted 5 changes, and holds 2 sessions, 2 events and 0 withdrawals: the last \
         events of sessions, or sessions, were removed; restore the whole folder from a copy"
    );
    assert_eq!(unexplained, 1);
    assert!(changed(true, &[last]).0.contains("were removed"));
    // What was in the middle is named by its session.
    let middle = "DELETE FROM events WHERE participant = 'P01' AND number = 0";
    let found = changed(false, &[middle]).0;
    assert!(found.contains("P01") && !found.contains("last"), "{found}");
    let session = [
        "DELETE FROM events WHERE participant = 'P01'",
        "DELETE FROM sessions WHERE participant = 'P01'",
    ];
    assert!(
        changed(false, &session)
            .0
            .contains("holds 1 sessions, 1 events")
    );
    // As many as the steps of a withdrawal that was given again: said, as nothing tells them apart.
    assert_eq!(changed(true, &session), (String::new(), 3));
    let session =
        "INSERT INTO sessions (participant, session, purpose) VALUES ('P03', 'x', 'volunteer')";
    assert!(
        changed(false, &[session])
            .0
            .contains("added by another program")
    );
}

#[test]
fn the_newest_time_is_that_of_the_last_event_of_any_session() {
    let folder = tempfile::tempdir().unwrap();
    assert_eq!(
        StudyStore::create(folder.path())
            .unwrap()
            .newest_ms()
            .unwrap(),
        None
    );
    let other = tempfile::tempdir().unwrap();
    let (mut store, key) = study(other.path());
    let late = NewEvent {
        at_ms: event("").at_ms + 900,
        ..event("{}")
    };
    store.append(&key, 2, late).unwrap();
    assert_eq!(store.newest_ms().unwrap(), Some(event("").at_ms + 900));
}

#[test]
fn pseudonyms_are_checked_where_a_session_begins() {
    let folder = tempfile::tempdir().unwrap();
    let (mut store, _) = study(folder.path());
    for name in ["../P01", "p01", "", "nul"] {
        let begun = store.begin(&SessionKey::new(name, "x"), Purpose::Volunteer);
        let Err(StoreError::Place { why, .. }) = begun else {
            panic!("{name}: {begun:?}");
        };
        assert!(
            why.contains("pseudonym") && why.contains(&format!("`{name}`")),
            "{why}"
        );
    }
    assert_eq!(store.sessions().unwrap().len(), 1);
}

#[test]
fn what_is_no_study_of_this_version_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join(DATABASE);
    let open = || StudyStore::open(folder.path()).unwrap_err();
    assert!(matches!(open(), StudyError::Missing { .. }));
    std::fs::write(&path, "name,answer\n".repeat(500)).unwrap();
    assert!(matches!(open(), StudyError::NoStudy { .. }));
    assert!(std::fs::read(&path).unwrap().starts_with(b"name,answer"));
    std::fs::remove_file(&path).unwrap();

    let (store, _) = study(folder.path());
    assert!(matches!(
        StudyStore::create(folder.path()),
        Err(StudyError::Exists { .. })
    ));
    assert_eq!(refusal(&store, "PRAGMA user_version = 2"), "");
    drop(store);
    let newer = open();
    assert!(matches!(newer, StudyError::Newer { found: 2, .. }));
    assert!(
        newer
            .to_string()
            .ends_with("open it with a newer Piezotact")
    );

    // The 4 bytes at 68 of the header are the application.
    let mut bytes = std::fs::read(&path).unwrap();
    bytes[68] ^= 1;
    std::fs::write(&path, bytes).unwrap();
    assert!(
        open()
            .to_string()
            .contains("the database of another program")
    );

    #[cfg(unix)]
    {
        let elsewhere = folder.path().join("elsewhere");
        std::fs::rename(&path, &elsewhere).unwrap();
        std::os::unix::fs::symlink(&elsewhere, &path).unwrap();
        assert!(open().to_string().contains("found a link"));
    }
}

#[test]
fn an_empty_file_of_an_interrupted_creation_is_completed_and_one_of_a_lost_study_not() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join(DATABASE), "").unwrap();
    let (store, _) = study(folder.path());
    drop(store);
    std::fs::write(folder.path().join(DATABASE), "").unwrap();
    for opened in [
        StudyStore::open(folder.path()),
        StudyStore::create(folder.path()),
    ] {
        assert!(matches!(
            opened,
            Err(StudyError::Lost {
                acknowledged: 3,
                found: 0,
                ..
            })
        ));
    }
}

#[test]
fn a_seal_of_another_study_or_a_damaged_one_is_an_error_and_a_missing_one_is_made() {
    let folder = tempfile::tempdir().unwrap();
    let (store, _) = study(folder.path());
    drop(store);
    let seal = folder.path().join(SEAL);
    let other = tempfile::tempdir().unwrap();
    drop(study(other.path()));
    for foreign in [
        std::fs::read(other.path().join(SEAL)).unwrap(),
        b"x".to_vec(),
    ] {
        std::fs::write(&seal, foreign).unwrap();
        assert!(matches!(
            StudyStore::open(folder.path()),
            Err(StudyError::Seal { .. })
        ));
    }
    std::fs::remove_file(&seal).unwrap();
    drop(StudyStore::open(folder.path()).unwrap());
    assert!(seal.is_file());
}

/// An older copy of the database beside the seal of today.
#[test]
fn an_older_copy_of_the_database_is_not_taken_for_the_study() {
    let folder = tempfile::tempdir().unwrap();
    let (store, key) = study(folder.path());
    drop(store);
    let path = folder.path().join(DATABASE);
    let older = std::fs::read(&path).unwrap();
    let mut store = StudyStore::open(folder.path()).unwrap();
    store.append(&key, 2, event("{}")).unwrap();
    drop(store);
    std::fs::write(&path, older).unwrap();
    assert!(matches!(
        StudyStore::open(folder.path()),
        Err(StudyError::Lost {
            acknowledged: 4,
            found: 3,
            ..
        })
    ));
}

/// A withdrawal that ended before its intention was stored has not happened; one that ended after any later step is completed.
#[test]
fn a_withdrawal_that_ends_between_two_steps_is_completed_when_the_study_is_opened() {
    for step in 0..4 {
        let folder = tempfile::tempdir().unwrap();
        let (mut store, key) = study(folder.path());
        let name = Pseudonym::new("P01").unwrap();
        let other = Pseudonym::new("P02").unwrap();
        store
            .set_identity(&name, person("Quentin"), &passphrase())
            .unwrap();
        store
            .set_identity(&other, person("Rosa"), &passphrase())
            .unwrap();
        let files = store.participant_folder(&name);
        std::fs::create_dir_all(&files).unwrap();
        std::fs::write(files.join("touch.parquet"), "quince").unwrap();

        // The steps of `withdraw`.
        let sha = store
            .prepare_identities("P01", Some(&passphrase()))
            .unwrap()
            .unwrap();
        if step > 0 {
            store
                .change(async |database| {
                    super::withdrawal::intend(database, "P01", 5, "files", Some(&sha)).await
                })
                .unwrap();
        }
        if step > 1 {
            super::withdrawal::remove_files(folder.path(), "P01").unwrap();
        }
        if step > 2 {
            super::withdrawal::put_identities(folder.path(), sha.bytes()).unwrap();
        }
        drop(store);

        let mut store = StudyStore::open(folder.path()).unwrap();
        assert!(!folder.path().join(NEXT).exists(), "{step}");
        assert_eq!(store.verify().unwrap(), 1, "{step}");
        let people = store.identities(&passphrase()).unwrap();
        let erased = store
            .events(&key)
            .unwrap()
            .iter()
            .all(|link| link.payload.is_none());
        let (withdrawn, names): (bool, &[&str]) = match step {
            0 => (false, &["P01", "P02"]),
            _ => (true, &["P02"]),
        };
        assert_eq!(people.keys().collect::<Vec<_>>(), names, "{step}");
        assert_eq!((erased, files.exists()), (withdrawn, !withdrawn), "{step}");
        assert!(store.pending().unwrap().is_empty());
        let again = store.set_identity(&name, person("Quentin"), &passphrase());
        assert_eq!(
            matches!(again, Err(StudyError::Withdrawn { .. })),
            withdrawn,
            "{step}"
        );
    }
}
