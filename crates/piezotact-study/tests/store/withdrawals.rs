//! What a withdrawal leaves.

use piezotact_study::store::StudyError;
use std::path::PathBuf;

use piezotact_people::campaign::store::{
    NewEvent, Purpose, SessionEntry, SessionKey, Store as _, StoreError,
};
use piezotact_study::store::{Passphrase, PersonalData, Remains, Withdrawn};

use crate::{AT_MS, fill, holding, key, name, passphrase, study};

#[test]
fn a_withdrawal_leaves_no_byte_of_the_participant_and_all_of_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = study(folder.path(), 300);
    // Long payloads are on pages of their own.
    let long = format!("{{\"note\":\"{}\"}}", "quince ".repeat(3000));
    let event = NewEvent {
        at_ms: AT_MS,
        json: &long,
        salt: [3; 16],
    };
    store.append(&key(), 300, event).unwrap();
    let other = SessionKey::new("P01-b", "discrimination");
    store.begin(&other, Purpose::Volunteer).unwrap();
    let medlar = NewEvent {
        at_ms: AT_MS,
        json: "{\"answer\":\"medlar\"}",
        salt: [4; 16],
    };
    store.append(&other, 0, medlar).unwrap();
    fill(&mut store, "P01");
    let person = PersonalData {
        name: "Rosa".into(),
        contact: String::new(),
        consent: None,
    };
    store
        .set_identity(&name("P01-b"), person.clone(), &passphrase())
        .unwrap();
    let others = store.participant_folder(&name("P01-b"));
    std::fs::create_dir_all(&others).unwrap();
    std::fs::write(others.join("S2.parquet"), "samples of medlar").unwrap();
    let heads = (store.head(&key()).unwrap(), store.head(&other).unwrap());
    assert!(holding(folder.path(), "quince").len() >= 4);

    let refused = store.withdraw(&name("P01"), AT_MS, None).unwrap_err();
    assert!(matches!(refused, StudyError::PassphraseNeeded { .. }));
    let wrong = Passphrase::new("other words".into())
        .unwrap()
        .with_work_factor(2);
    let refused = store
        .withdraw(&name("P01"), AT_MS, Some(&wrong))
        .unwrap_err();
    assert!(matches!(refused, StudyError::WrongPassphrase { .. }));
    let unknown = store
        .withdraw(&name("P09"), AT_MS, Some(&passphrase()))
        .unwrap_err();
    assert!(matches!(unknown, StudyError::UnknownParticipant { .. }));
    assert!(
        holding(folder.path(), "quince").len() >= 4,
        "nothing is erased by a refusal"
    );

    let done = store
        .withdraw(&name("P01"), AT_MS + 7, Some(&passphrase()))
        .unwrap();
    let expected = Withdrawn {
        sessions: 1,
        files: 3,
        identities: 1,
        remains: Remains::Nothing,
    };
    assert_eq!(done, expected);
    for words in ["quince", "Quentin"] {
        assert_eq!(holding(folder.path(), words), Vec::<PathBuf>::new());
    }
    assert_eq!(
        heads,
        (store.head(&key()).unwrap(), store.head(&other).unwrap())
    );
    assert_eq!(store.verify().unwrap(), 2);
    let entries = store.sessions().unwrap();
    let withdrawn: Vec<_> = entries
        .iter()
        .map(|entry: &SessionEntry| entry.withdrawn_at_ms)
        .collect();
    assert_eq!(withdrawn, [Some(AT_MS + 7), None]);
    assert!(holding(folder.path(), "medlar").len() >= 2);
    assert_eq!(store.identities(&passphrase()).unwrap()["P01-b"], person);
    assert!(matches!(
        store.begin(&SessionKey::new("P01", "another"), Purpose::Volunteer),
        Err(StoreError::Withdrawn { .. })
    ));
    // Again is no error, and keeps the time.
    store
        .withdraw(&name("P01"), AT_MS + 9, Some(&passphrase()))
        .unwrap();
    assert_eq!(
        store.sessions().unwrap()[0].withdrawn_at_ms,
        Some(AT_MS + 7)
    );
    // One who was measured and had no session yet.
    let measured = store.participant_folder(&name("P03"));
    std::fs::create_dir_all(&measured).unwrap();
    std::fs::write(measured.join("S2.parquet"), "samples").unwrap();
    let done = store
        .withdraw(&name("P03"), AT_MS, Some(&passphrase()))
        .unwrap();
    assert_eq!(
        (done.sessions, done.files, measured.exists()),
        (0, 1, false)
    );
}

#[cfg(unix)]
#[test]
fn a_link_is_not_followed_out_of_the_study() {
    use std::os::unix::fs::symlink;
    let (folder, outside) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let kept = outside.path().join("kept");
    std::fs::write(&kept, "kept").unwrap();
    let mut store = study(folder.path(), 1);
    let own = store.participant_folder(&name("P01"));
    std::fs::create_dir_all(&own).unwrap();
    symlink(outside.path(), own.join("link")).unwrap();
    symlink(&kept, own.join("file")).unwrap();
    symlink(outside.path(), own.with_file_name("P01.before-1")).unwrap();
    let linked = store.linked_outside(&name("P01")).unwrap();
    let to = outside.path().to_owned();
    assert_eq!(linked, [to.clone(), to, kept.clone()]);
    store.withdraw(&name("P01"), AT_MS, None).unwrap();
    assert_eq!(
        store.linked_outside(&name("P01")).unwrap(),
        Vec::<PathBuf>::new()
    );
    assert!(!own.exists() && !own.with_file_name("P01.before-1").is_symlink());
    assert!(kept.is_file());
    // A link in the place of all participants, or of the identities, is refused.
    store
        .begin(&SessionKey::new("P02", "x"), Purpose::Volunteer)
        .unwrap();
    std::fs::remove_dir(folder.path().join("participants")).unwrap();
    symlink(outside.path(), folder.path().join("participants")).unwrap();
    std::fs::create_dir(outside.path().join("P02")).unwrap();
    let refused = store
        .withdraw(&name("P02"), AT_MS, None)
        .unwrap_err()
        .to_string();
    assert!(
        refused.contains("nothing is removed outside of the study"),
        "{refused}"
    );
    assert!(outside.path().join("P02").is_dir());
    symlink(&kept, folder.path().join("identity.age")).unwrap();
    assert!(matches!(
        store.identities(&passphrase()),
        Err(StudyError::IdentitiesDamaged { .. })
    ));
}
