//! Programs that are killed at random moments.

use std::collections::BTreeSet;
use std::time::Duration;

use piezotact_people::campaign::store::Store as _;
use piezotact_study::store::StudyStore;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

use crate::{acknowledged, fill, holding, kill_within_ms, lines, passphrase, start, study, whole};

/// Kills a process that appends, `count` times at random moments from its start on: within 150 ms, and longer by a twentieth after each kill that came
/// before an answer, as machines differ.
fn kills(count: u32) {
    let folder = tempfile::tempdir().unwrap();
    let mut random = ChaCha8Rng::seed_from_u64(66);
    let mut stored: BTreeSet<u64> = BTreeSet::new();
    let (mut within, mut within_ms) = (0, 150);
    for _ in 0..count {
        let mut child = start("append", folder.path());
        std::thread::sleep(Duration::from_millis(u64::from(
            random.next_u32() % within_ms,
        )));
        child.kill().unwrap();
        let lines = lines(child);
        assert!(
            !lines.iter().any(|line| line.starts_with("refused")),
            "{lines:?}"
        );
        let new = acknowledged(&lines);
        if new.is_empty() {
            within_ms += within_ms / 20;
        } else {
            within += 1;
        }
        for number in &new {
            assert!(
                stored.insert(*number),
                "event {number} was acknowledged twice"
            );
        }
        let Ok(store) = StudyStore::open(folder.path()) else {
            // Killed before there was a study: nothing was acknowledged.
            assert!(stored.is_empty());
            continue;
        };
        if store.sessions().unwrap().is_empty() {
            assert!(stored.is_empty());
            continue;
        }
        let there = whole(&store);
        let last = stored.last().map_or(0, |last| last + 1);
        // One may be stored that was not acknowledged any more.
        assert!(there == last || there == last + 1, "{there} of {last}");
        // It is one that the next process has read, and will not say.
        stored.extend(last..there);
        assert_eq!(stored.len() as u64, there);
    }
    assert!(
        within * 2 > count,
        "{within} of {count} kills, within {within_ms} ms at last, were among answers"
    );
}

#[test]
fn an_acknowledged_event_survives_a_kill() {
    kills(20);
}

#[test]
#[ignore = "300 kills; ./x soak runs it, and 20 run in every test"]
fn soak_kill_store() {
    kills(300);
}

/// A withdrawal that is killed at a random moment has not happened, or is complete once the study was opened.
fn killed_withdrawals(count: u32) {
    let mut random = ChaCha8Rng::seed_from_u64(67);
    let unkilled = tempfile::tempdir().unwrap();
    let mut store = study(unkilled.path(), 40);
    fill(&mut store, "P01");
    drop(store);
    let within_ms = kill_within_ms(unkilled.path());
    let mut after = 0;
    for _ in 0..count {
        let folder = tempfile::tempdir().unwrap();
        let mut store = study(folder.path(), 40);
        fill(&mut store, "P01");
        drop(store);
        let mut child = start("withdraw", folder.path());
        std::thread::sleep(Duration::from_millis(
            u64::from(random.next_u32()) % within_ms,
        ));
        child.kill().unwrap();
        drop(lines(child));
        let store = StudyStore::open(folder.path()).unwrap();
        assert_eq!(store.verify().unwrap(), 1);
        let found = holding(folder.path(), "quince");
        let people = store.identities(&passphrase()).unwrap();
        if store.sessions().unwrap()[0].withdrawn_at_ms.is_none() {
            assert_eq!((whole(&store), people.len()), (40, 1));
            assert_eq!(found.len(), 4, "{found:?}");
        } else {
            after += 1;
            assert!(
                found.is_empty() && people.is_empty(),
                "{found:?} {people:?}"
            );
        }
        assert!(!folder.path().join("identity.age.next").exists());
    }
    assert!(
        count < 20 || after > 0,
        "no kill came after an intention in {within_ms} ms"
    );
}

#[test]
fn a_killed_withdrawal_has_not_happened_or_is_completed() {
    killed_withdrawals(20);
}

#[test]
#[ignore = "300 kills; ./x soak runs it, and 20 run in every test"]
fn soak_kill_withdrawal() {
    killed_withdrawals(300);
}
