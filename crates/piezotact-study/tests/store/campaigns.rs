//! What a study is of: made, completed, read, changed, damaged; and the plans of its sessions.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use piezotact_people::campaign::plan::{CompletedSession, Plan, PlanRequest, plan};
use piezotact_people::campaign::protocol::{LIBRARY, read};
use piezotact_people::campaign::store::{Purpose, SessionKey, Store as _, StoreError};
use piezotact_study::store::{NewCampaign, StudyCampaign, StudyError, StudyStore};

use crate::{AT_MS, append, fill, holding, name, passphrase};

const CONSENT: &str = "I take part of my own will.\n";

pub(crate) fn protocol() -> &'static str {
    let found = LIBRARY
        .iter()
        .find(|(name, _)| *name == "isotropic_triplets");
    found.unwrap().1
}

pub(crate) fn new(protocol: &str) -> NewCampaign<'_> {
    NewCampaign {
        protocol,
        seed: 11,
        consent: Some(CONSENT),
        panels: BTreeMap::from([("of 20".to_owned(), BTreeSet::from(["P07".to_owned()]))]),
        program: "piezotact 0.1.0",
    }
}

pub(crate) fn planned(
    campaign: &StudyCampaign,
    participant: &str,
    completed: &[CompletedSession],
) -> Plan {
    let request = PlanRequest {
        seed: campaign.seed,
        participant,
        session: "discrimination",
        completed,
    };
    plan(&campaign.protocol, campaign.protocol_sha, request).unwrap()
}

/// Every file in `folder` with what is in it.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let entries = std::fs::read_dir(folder).unwrap();
    let paths = entries.map(|entry| entry.unwrap().path());
    let files = paths.filter(|path| path.is_file());
    files
        .map(|path| (path.clone(), std::fs::read(path).unwrap()))
        .collect()
}

#[test]
fn a_study_says_again_what_it_was_made_of() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("a/study");
    drop(StudyCampaign::create(&study, &new(protocol())).unwrap());
    let found = StudyCampaign::read(&study).unwrap();
    assert_eq!(found.protocol, read(protocol()).unwrap());
    assert_eq!((found.seed, found.consent.as_deref()), (11, Some(CONSENT)));
    assert_eq!(
        found.panels,
        new(protocol()).panels.into_iter().collect::<Vec<_>>()
    );
    assert_eq!(
        std::fs::read_to_string(study.join("protocol.toml")).unwrap(),
        protocol()
    );
    // It is there: another one is not made over it, and nothing of it changes.
    drop(StudyStore::open(&study).unwrap());
    let was = files(&study);
    let other = NewCampaign {
        seed: 12,
        ..new(protocol())
    };
    for again in [new(protocol()), other] {
        let refused = StudyCampaign::create(&study, &again).unwrap_err();
        assert!(matches!(refused, StudyError::Exists { .. }), "{refused}");
    }
    assert_eq!(files(&study), was);
}

#[test]
fn a_protocol_that_cannot_be_used_leaves_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let study = folder.path().join("study");
    let bad = protocol().replace("name = \"discrimination\"", "name = \"../out\"");
    let bad = bad.replace("session = \"discrimination\"", "session = \"../out\"");
    for text in ["form = 1", bad.as_str()] {
        let refused = StudyCampaign::create(&study, &new(text)).unwrap_err();
        assert!(
            matches!(
                refused,
                StudyError::Protocol(_) | StudyError::Pseudonym { .. }
            ),
            "{refused}"
        );
    }
    assert!(!study.exists());
}

/// Whatever a creation has left when it was cut off, the same command completes it.
#[test]
fn a_creation_that_was_interrupted_is_completed() {
    let texts = [("protocol.toml", protocol()), ("consent.txt", CONSENT)];
    for written in 0..=texts.len() {
        let folder = tempfile::tempdir().unwrap();
        drop(StudyStore::create(folder.path()).unwrap());
        for (name, text) in &texts[..written] {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        assert!(StudyCampaign::read(folder.path()).is_err());
        let store = StudyCampaign::create(folder.path(), &new(protocol())).unwrap();
        assert_eq!(store.sessions().unwrap(), []);
        drop(store);
        assert_eq!(StudyCampaign::read(folder.path()).unwrap().seed, 11);
    }
    // Also where the database has no tables yet.
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("study.sqlite"), "").unwrap();
    drop(StudyCampaign::create(folder.path(), &new(protocol())).unwrap());
    assert_eq!(StudyCampaign::read(folder.path()).unwrap().seed, 11);
}

#[test]
fn nothing_of_somebody_is_written_over() {
    // A file that is not of the study.
    let folder = tempfile::tempdir().unwrap();
    for name in ["protocol.toml", "consent.txt"] {
        let path = folder.path().join(name);
        std::fs::write(&path, "mine").unwrap();
        let refused = StudyCampaign::create(folder.path(), &new(protocol())).unwrap_err();
        assert!(matches!(refused, StudyError::InTheWay { .. }), "{refused}");
        assert!(refused.to_string().contains("move it away"), "{refused}");
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "mine");
        assert_eq!(files(folder.path()).len(), 1);
        std::fs::remove_file(path).unwrap();
    }
    // A study with sessions that has lost its campaign is no interrupted creation.
    let mut store = StudyCampaign::create(folder.path(), &new(protocol())).unwrap();
    let key = SessionKey::new("P01", "discrimination");
    store.begin(&key, Purpose::Volunteer).unwrap();
    drop(store);
    std::fs::remove_file(folder.path().join("campaign.json")).unwrap();
    let refused = StudyCampaign::create(folder.path(), &new(protocol())).unwrap_err();
    assert!(
        matches!(refused, StudyError::Incomplete { sessions: 1, .. }),
        "{refused}"
    );
    assert!(!folder.path().join("campaign.json").exists());
    // Another program's file in the place of the database.
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("study.sqlite"), "x".repeat(5000)).unwrap();
    let refused = StudyCampaign::create(folder.path(), &new(protocol())).unwrap_err();
    assert!(matches!(refused, StudyError::NoStudy { .. }), "{refused}");
    assert_eq!(files(folder.path()).len(), 1);
}

#[test]
fn a_changed_protocol_or_consent_text_is_refused_with_both_choices() {
    let folder = tempfile::tempdir().unwrap();
    drop(StudyCampaign::create(folder.path(), &new(protocol())).unwrap());
    for (file, what) in [
        ("protocol.toml", "protocol"),
        ("consent.txt", "consent text"),
    ] {
        let path = folder.path().join(file);
        let was = std::fs::read_to_string(&path).unwrap();
        std::fs::write(&path, format!("{was}\n")).unwrap();
        let refused = StudyCampaign::read(folder.path()).unwrap_err();
        assert!(
            matches!(&refused, StudyError::Changed { what: found, .. } if *found == what),
            "{refused:?}"
        );
        let text = refused.to_string();
        for part in [file, what, "restore it from a copy", "make a new study"] {
            assert!(text.contains(part), "no `{part}` in: {text}");
        }
        std::fs::remove_file(&path).unwrap();
        assert!(matches!(
            StudyCampaign::read(folder.path()),
            Err(StudyError::Read(_))
        ));
        std::fs::write(&path, was).unwrap();
        StudyCampaign::read(folder.path()).unwrap();
    }
}

#[test]
fn a_damaged_campaign_says_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    drop(StudyCampaign::create(folder.path(), &new(protocol())).unwrap());
    let path = folder.path().join("campaign.json");
    let whole = std::fs::read_to_string(&path).unwrap();
    let half = &whole[..whole.len() / 2];
    let later = whole.replace("\"form\": 1", "\"form\": 2,\n  \"ethics\": \"x\"");
    let unknown = whole.replace("\"form\": 1", "\"form\": 1,\n  \"ethics\": \"x\"");
    let none = whole.replace("\"form\": 1", "\"form\": 0");
    let cut_sha = whole.replacen("\"protocol_sha\": \"", "\"protocol_sha\": \"zz", 1);
    let later_text = "version 2 is newer than version 1, the latest that this program reads: open it with a newer Piezotact";
    for (text, part) in [
        ("", "restore it from a copy"),
        (half, "restore it from a copy"),
        (&unknown, "`ethics`"),
        (&none, "form 0"),
        (&cut_sha, "restore it from a copy"),
        (&later, later_text),
    ] {
        assert_ne!(text, whole);
        std::fs::write(&path, text).unwrap();
        let refused = StudyCampaign::read(folder.path()).unwrap_err().to_string();
        assert!(
            refused.contains("campaign.json") && refused.contains(part),
            "{refused}"
        );
        // A second creation does not replace it.
        let again = StudyCampaign::create(folder.path(), &new(protocol()));
        assert!(matches!(again, Err(StudyError::Exists { .. })));
    }
}

#[test]
fn a_plan_is_read_as_it_was_written_and_stays_once_the_session_is_there() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = StudyCampaign::create(folder.path(), &new(protocol())).unwrap();
    let campaign = StudyCampaign::read(folder.path()).unwrap();
    let first = planned(&campaign, "P01", &[]);
    assert_eq!(store.plan(&name("P01"), "discrimination").unwrap(), None);
    store.write_plan(&first).unwrap();
    let read = store.plan(&name("P01"), "discrimination").unwrap().unwrap();
    assert_eq!((&read, read.sha()), (&first, first.sha()));
    let path = folder
        .path()
        .join("participants/P01/discrimination/plan.json");
    assert_eq!(std::fs::read(&path).unwrap(), first.bytes());
    // Not begun: somebody else came first, and it is planned again.
    let mut second = first.clone();
    second.completed = vec![planned(&campaign, "P02", &[]).as_completed()];
    assert_ne!(second.sha(), first.sha());
    store.write_plan(&second).unwrap();
    // Begun.
    let key = SessionKey::new("P01", "discrimination");
    store.begin(&key, Purpose::Volunteer).unwrap();
    store.write_plan(&second).unwrap();
    let refused = store.write_plan(&first).unwrap_err();
    assert!(matches!(refused, StudyError::Planned { .. }), "{refused}");
    assert!(
        refused
            .to_string()
            .contains("go on with the one that is written")
    );
    assert_eq!(std::fs::read(&path).unwrap(), second.bytes());
    // The folder of another participant is no plan of this one.
    let copied = folder.path().join("participants/P03/discrimination");
    std::fs::create_dir_all(&copied).unwrap();
    std::fs::copy(&path, copied.join("plan.json")).unwrap();
    let refused = store
        .plan(&name("P03"), "discrimination")
        .unwrap_err()
        .to_string();
    assert!(
        refused.contains("found that of session discrimination of P01"),
        "{refused}"
    );
    // Nor is one that differs by case only planned.
    let refused = store
        .write_plan(&planned(&campaign, "p01", &[]))
        .unwrap_err();
    assert!(
        matches!(refused, StudyError::PseudonymCase { .. }),
        "{refused}"
    );
    std::fs::write(&path, "{").unwrap();
    let refused = store
        .plan(&name("P01"), "discrimination")
        .unwrap_err()
        .to_string();
    assert!(
        refused.contains("plan.json") && refused.contains("restore it"),
        "{refused}"
    );
}

#[test]
fn a_withdrawal_leaves_of_the_sessions_files_the_pseudonym_alone() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = StudyCampaign::create(folder.path(), &new(protocol())).unwrap();
    let campaign = StudyCampaign::read(folder.path()).unwrap();
    let first = planned(&campaign, "P01", &[]);
    store.write_plan(&first).unwrap();
    let key = SessionKey::new("P01", "discrimination");
    store.begin(&key, Purpose::Volunteer).unwrap();
    for number in 0..20 {
        append(&mut store, &key, number).unwrap();
    }
    fill(&mut store, "P01");
    let session = store
        .session_folder(&name("P01"), "discrimination")
        .unwrap();
    for file in [
        "drives/S2.wav",
        "runs/triplets.task3.A-1-1-1.parquet",
        "runs/x.parquet.before-1",
    ] {
        let path = session.join(file);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, "samples of quince").unwrap();
    }
    // The plan of the next one names the session that was completed.
    let next = planned(&campaign, "P02", &[first.as_completed()]);
    store.write_plan(&next).unwrap();
    store
        .begin(
            &SessionKey::new("P02", "discrimination"),
            Purpose::Volunteer,
        )
        .unwrap();
    let planned_for = "\"participant\": \"P01\"";
    assert_eq!(holding(folder.path(), planned_for).len(), 2);
    assert!(holding(folder.path(), "quince").len() >= 6);

    store
        .withdraw(&name("P01"), AT_MS, Some(&passphrase()))
        .unwrap();
    assert_eq!(holding(folder.path(), "quince"), Vec::<PathBuf>::new());
    let others = folder
        .path()
        .join("participants/P02/discrimination/plan.json");
    assert_eq!(holding(folder.path(), planned_for), [others]);
    // Nothing of the plan is left: not the order of the sets, not a checksum of it.
    assert_eq!(
        holding(folder.path(), &first.sha().to_string()),
        Vec::<PathBuf>::new()
    );
    assert!(!session.exists());
    assert_eq!(
        store.plan(&name("P02"), "discrimination").unwrap(),
        Some(next)
    );
    // Nor is a file of the participant made again.
    for participant in ["P01", "P05"] {
        if participant == "P05" {
            // Withdrawn before the first session.
            let own = store.participant_folder(&name("P05"));
            std::fs::create_dir_all(&own).unwrap();
            std::fs::write(own.join("S2.parquet"), "samples").unwrap();
            store
                .withdraw(&name("P05"), AT_MS, Some(&passphrase()))
                .unwrap();
        }
        let refused = store
            .write_plan(&planned(&campaign, participant, &[]))
            .unwrap_err();
        assert!(
            matches!(refused, StudyError::Store(StoreError::Withdrawn { .. })),
            "{refused}"
        );
        assert!(!store.participant_folder(&name(participant)).exists());
    }
    drop(store);
    assert_eq!(
        StudyStore::open(folder.path()).unwrap().verify().unwrap(),
        2
    );
}
