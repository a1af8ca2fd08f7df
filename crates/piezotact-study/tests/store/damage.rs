//! Logs that are cut or damaged, and damaged databases.

use std::path::Path;

use piezotact_people::campaign::store::Store as _;
use piezotact_study::store::{StudyError, StudyStore};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

use crate::{study, whole};

fn copy(from: &Path, to: &Path) {
    for name in ["study.sqlite", "study.sqlite-wal", "study.seal"] {
        std::fs::copy(from.join(name), to.join(name)).unwrap();
    }
}

/// The commits whose frames all end before byte `end` of a log: frames of 24 bytes and a page of 4096, behind a header of 32; the
/// second number of a frame is not 0 where it ends a commit.
fn commits_before(log: &[u8], end: usize) -> u64 {
    let frames = log[32..].chunks_exact(24 + 4096).enumerate();
    let whole = frames.filter(|(i, _)| 32 + (i + 1) * (24 + 4096) <= end);
    whole.filter(|(_, frame)| frame[4..8] != [0; 4]).count() as u64
}

/// What SQLite guarantees: all commits before the first damaged frame. What the seal adds: where any that was acknowledged is not among
/// them, opening says so.
#[test]
fn a_cut_or_damaged_log_is_never_opened_with_fewer_events_without_a_word() {
    let (source, target) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    let store = study(source.path(), 30);
    let log = std::fs::read(source.path().join("study.sqlite-wal")).unwrap();
    // The begin of the session, and the events.
    assert_eq!(commits_before(&log, log.len()), 31);
    let mut random = ChaCha8Rng::seed_from_u64(68);
    let (mut lost, mut kept) = (0, 0);
    for round in 0..60 {
        copy(source.path(), target.path());
        let _shared = std::fs::remove_file(target.path().join("study.sqlite-shm"));
        let path = target.path().join("study.sqlite-wal");
        let at = random.next_u64() as usize % log.len();
        let mut damaged = log.clone();
        match round % 3 {
            0 => damaged.truncate(at),
            1 => damaged[at] ^= 1 << (random.next_u32() % 8),
            // Bytes behind the last frame.
            _ => damaged.extend((0..at % 9000).map(|_| random.next_u32() as u8)),
        }
        std::fs::write(&path, &damaged).unwrap();
        let expected = match round % 3 {
            2 => 31,
            // A damaged header makes all of the log invalid. Two numbers of it are not looked at: format and sequence.
            _ if at < 32 => continue,
            _ => commits_before(&log, at),
        };
        match StudyStore::open(target.path()) {
            Ok(store) => {
                assert_eq!((whole(&store), expected), (30, 31), "{round} at {at}");
                kept += 1;
            }
            Err(StudyError::Lost {
                acknowledged,
                found,
                ..
            }) => {
                assert_eq!((acknowledged, found), (31, expected), "{round} at {at}");
                lost += 1;
                // Without the seal, somebody goes on with what is there.
                std::fs::remove_file(target.path().join("study.seal")).unwrap();
                let store = StudyStore::open(target.path()).unwrap();
                if expected > 0 {
                    assert_eq!(whole(&store), expected - 1);
                }
            }
            Err(other) => panic!("{round} at {at}: {other}"),
        }
    }
    assert!(lost >= 30 && kept >= 20, "{lost} {kept}");
    drop(store);
}

/// Pages in the middle of the database are overwritten: the database says so, or the chain does.
#[test]
fn a_damaged_database_is_found() {
    let folder = tempfile::tempdir().unwrap();
    drop(study(folder.path(), 200));
    let path = folder.path().join("study.sqlite");
    let good = std::fs::read(&path).unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(69);
    let mut found = 0;
    for page in 1..good.len() / 4096 {
        let mut bad = good.clone();
        for byte in &mut bad[page * 4096..(page + 1) * 4096] {
            *byte = random.next_u32() as u8;
        }
        std::fs::write(&path, bad).unwrap();
        match StudyStore::open(folder.path()) {
            Ok(store) => found += u32::from(store.verify().is_err()),
            Err(error) => {
                assert!(error.to_string().contains("restore"), "{error}");
                found += 1;
            }
        }
    }
    assert_eq!(found as usize, good.len() / 4096 - 1);
    std::fs::write(&path, good).unwrap();
    assert_eq!(whole(&StudyStore::open(folder.path()).unwrap()), 200);
}
