//! Group commit: many participants answer at once, each is acknowledged when its answer is on the disk.
#![allow(clippy::print_stderr, reason = "what was measured is the result")]

use std::fs::File;
use std::io::Write as _;
use std::path::Path;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use piezotact_dataset::study::{GroupStore, StudyStore};
use piezotact_people::campaign::store::{
    NewEvent, Purpose, SessionKey, Store, StoreError, conformance,
};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

use crate::AT_MS;
use crate::postgres::{Server, server};
use crate::server::url;

/// The time between two answers of a participant, on average.
const BETWEEN: f64 = 3.0;

/// Where a study is kept.
#[derive(Clone, Copy)]
enum Place {
    File,
    Server(&'static Server),
}

impl Place {
    fn name(self) -> &'static str {
        match self {
            Self::File => "SQLite",
            Self::Server(_) => "PostgreSQL",
        }
    }

    fn create(self, folder: &Path) -> StudyStore {
        match self {
            Self::File => StudyStore::create(folder).unwrap(),
            Self::Server(server) => {
                StudyStore::create_on(folder, &url(&server.database())).unwrap()
            }
        }
    }
}

fn places() -> [Place; 2] {
    [Place::File, Place::Server(server())]
}

fn key(participant: usize) -> SessionKey {
    SessionKey::new(&format!("P{participant:03}"), "discrimination")
}

/// An answer as long as those of a session are.
fn answer(participant: usize, number: u64) -> String {
    let note = "x".repeat(150);
    format!(
        "{{\"event\":\"answered\",\"by\":{participant},\"number\":{number},\"note\":\"{note}\"}}"
    )
}

fn append(store: &mut GroupStore, participant: usize, number: u64) -> Result<u64, StoreError> {
    let json = answer(participant, number);
    let mut salt = [0; 16];
    salt[..8].copy_from_slice(&number.to_le_bytes());
    salt[8..].copy_from_slice(&(participant as u64).to_le_bytes());
    let event = NewEvent {
        at_ms: AT_MS,
        json: &json,
        salt,
    };
    store
        .append(&key(participant), number, event)
        .map(|link| link.number)
}

/// A study with a session of each participant.
fn begun(place: Place, folder: &Path, participants: usize) -> GroupStore {
    let mut store = GroupStore::new(place.create(folder)).unwrap();
    for participant in 0..participants {
        store.begin(&key(participant), Purpose::Volunteer).unwrap();
    }
    store
}

/// Every answer of every participant is there, once, as it was given.
fn assert_whole(store: &GroupStore, counts: &[u64]) {
    assert_eq!(store.verify().unwrap(), counts.len());
    for (participant, count) in counts.iter().enumerate() {
        let links = store.events(&key(participant)).unwrap();
        assert_eq!(links.len() as u64, *count);
        for (number, link) in links.iter().enumerate() {
            let payload = link.payload.as_ref().unwrap();
            assert_eq!(payload.json, answer(participant, number as u64));
        }
    }
}

#[test]
fn a_store_of_groups_conforms() {
    for place in places() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = GroupStore::new(place.create(folder.path())).unwrap();
        assert_eq!(conformance::check(&mut store), Ok(()), "{}", place.name());
        drop(store.clone());
        drop(store);
        // Its thread has ended, and the study is closed.
        if let Place::File = place {
            let log = folder.path().join("study.sqlite-wal");
            assert!(!log.exists());
        }
    }
}

/// Requests that wait together: those that are refused spoil none of the others.
#[test]
fn a_refused_request_does_not_spoil_the_others() {
    for place in places() {
        let folder = tempfile::tempdir().unwrap();
        let mut store = begun(place, folder.path(), 12);
        store.erase("P011", 5).unwrap();
        let refused: Vec<String> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..24)
                .map(|thread| {
                    let mut store = store.clone();
                    scope.spawn(move || {
                        let participant = thread % 12;
                        let mut refused = Vec::new();
                        for number in 0..20 {
                            if let Err(error) = append(&mut store, participant, number) {
                                refused.push(format!("{participant} {error}"));
                            }
                        }
                        refused
                    })
                })
                .collect();
            let refused = threads
                .into_iter()
                .flat_map(|thread| thread.join().unwrap());
            refused.collect()
        });
        // Two threads answer for each participant, and of each number one is stored, or none by the one that was overtaken.
        let withdrawn = refused
            .iter()
            .filter(|why| why.contains("has withdrawn"))
            .count();
        assert_eq!(withdrawn, 40);
        assert!(refused.iter().all(|why| {
            why.contains("has withdrawn") || why.contains("another program is running")
        }));
        for participant in 0..11 {
            assert_eq!(store.events(&key(participant)).unwrap().len(), 20);
        }
        assert_eq!(store.verify().unwrap(), 12);
    }
}

/// A text that a database cannot keep is refused alone.
#[test]
fn what_a_database_refuses_does_not_spoil_the_others() {
    let folder = tempfile::tempdir().unwrap();
    let store = begun(Place::Server(server()), folder.path(), 9);
    let bad = AtomicBool::new(false);
    std::thread::scope(|scope| {
        for participant in 0..8 {
            let mut store = store.clone();
            scope.spawn(move || {
                for number in 0..100 {
                    append(&mut store, participant, number).unwrap();
                }
            });
        }
        for _ in 0..100 {
            let mut store = store.clone();
            let event = NewEvent {
                at_ms: AT_MS,
                json: "\"\0\"",
                salt: [1; 16],
            };
            let refused = store.append(&key(8), 0, event);
            assert!(matches!(refused, Err(StoreError::Place { .. })));
            bad.store(true, Ordering::Relaxed);
        }
    });
    let mut counts = [100; 9];
    counts[8] = 0;
    assert!(bad.into_inner());
    assert_whole(&store, &counts);
}

#[test]
fn a_commit_that_fails_is_told_to_everybody() {
    let own = Server::start("");
    let folder = tempfile::tempdir().unwrap();
    let study = StudyStore::create_on(folder.path(), &url(&own.database())).unwrap();
    let mut store = GroupStore::new(study).unwrap();
    for participant in 0..20 {
        store.begin(&key(participant), Purpose::Volunteer).unwrap();
    }
    let counts: Vec<u64> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..20)
            .map(|participant| {
                let mut store = store.clone();
                scope.spawn(move || {
                    let mut refused = 0;
                    let mut number = 0;
                    while number < 300 {
                        match append(&mut store, participant, number) {
                            Ok(_) => number += 1,
                            Err(StoreError::Place { .. }) => {
                                refused += 1;
                                std::thread::sleep(Duration::from_millis(20));
                                if let Ok(links) = store.events(&key(participant)) {
                                    let there = links.len() as u64;
                                    // At most the one that was not acknowledged.
                                    assert!(there == number || there == number + 1);
                                    number = there;
                                }
                            }
                            Err(StoreError::Overtaken {
                                found, expected, ..
                            }) => {
                                assert_eq!(found, expected + 1);
                                number = found;
                            }
                            Err(other) => panic!("{other}"),
                        }
                    }
                    refused
                })
            })
            .collect();
        std::thread::sleep(Duration::from_millis(150));
        own.crash();
        own.start_again();
        threads
            .into_iter()
            .map(|thread| thread.join().unwrap())
            .collect()
    });
    assert!(counts.iter().all(|refused| *refused > 0), "{counts:?}");
    assert_whole(&store, &[300; 20]);
}

/// Times from an answer to its acknowledgement, sorted.
struct Latencies(Vec<Duration>);

impl Latencies {
    fn of(times: impl IntoIterator<Item = Duration>) -> Self {
        let mut times: Vec<Duration> = times.into_iter().collect();
        times.sort_unstable();
        Self(times)
    }

    /// In ms, the smallest that so many per thousand do not exceed.
    fn per_mille(&self, share: usize) -> f64 {
        let place = (self.0.len() * share).div_ceil(1000).max(1);
        self.0[place - 1].as_secs_f64() * 1e3
    }

    fn row(&self) -> String {
        format!(
            "{:>7} {:>9.2} {:>9.2} {:>9.2}",
            self.0.len(),
            self.per_mille(500),
            self.per_mille(990),
            self.per_mille(1000)
        )
    }
}

/// The next pause of a random process with a mean of `mean` seconds.
fn pause(random: &mut ChaCha8Rng, mean: f64) -> Duration {
    let share = (f64::from(random.next_u32()) + 1.0) / 4_294_967_297.0;
    Duration::from_secs_f64((-share.ln() * mean).min(4.0 * mean))
}

/// One participant until `ends`: an answer, then a bare write of the same size with `fdatasync` into a file of its own, and so on, each at
/// a random time. So both meet the same moments of the disk: where it stands still for a while, every answer of that while waits, and a
/// single writer of bare writes would meet it once.
fn participant(
    store: &mut GroupStore,
    participant: usize,
    folder: &Path,
    ends: Instant,
) -> [Vec<Duration>; 2] {
    let mut random = ChaCha8Rng::seed_from_u64(7800 + participant as u64);
    let mut file = File::create(folder.join(format!("bare-{participant}"))).unwrap();
    let bytes = answer(participant, 0).into_bytes();
    let mut times = [Vec::new(), Vec::new()];
    // Half of them begin with a bare write.
    for turn in participant.. {
        let pause = pause(&mut random, BETWEEN / 2.0);
        if Instant::now() + pause > ends {
            break;
        }
        std::thread::sleep(pause);
        let number = times[0].len() as u64;
        let began = Instant::now();
        if turn % 2 == 0 {
            let stored = append(store, participant, number);
            times[0].push(began.elapsed());
            assert_eq!(stored.unwrap(), number);
        } else {
            file.write_all(&bytes).unwrap();
            file.sync_data().unwrap();
            times[1].push(began.elapsed());
        }
    }
    times
}

/// So many participants answer at random for `lasts`; gives the latencies of answers, and of bare writes in between.
fn answered(place: Place, participants: usize, lasts: Duration) -> [Latencies; 2] {
    let folder = tempfile::tempdir().unwrap();
    let store = begun(place, folder.path(), participants);
    let ends = Instant::now() + lasts;
    let times: Vec<[Vec<Duration>; 2]> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..participants)
            .map(|number| {
                let (mut store, folder) = (store.clone(), folder.path());
                scope.spawn(move || participant(&mut store, number, folder, ends))
            })
            .collect();
        let times = threads.into_iter().map(|thread| thread.join().unwrap());
        times.collect()
    });
    let counts: Vec<u64> = times
        .iter()
        .map(|[answers, _]| answers.len() as u64)
        .collect();
    assert_whole(&store, &counts);
    [0, 1].map(|what| Latencies::of(times.iter().flat_map(|of| of[what].iter().copied())))
}

#[test]
fn many_participants_answer_at_once() {
    for place in places() {
        let [answers, bare] = answered(place, 40, Duration::from_secs(2));
        assert!(!answers.0.is_empty() && !bare.0.is_empty());
    }
}

/// Memory of this program, in KiB.
fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:"));
    line.unwrap()
        .trim()
        .trim_end_matches(" kB")
        .parse()
        .unwrap()
}

/// 100,000 answers as fast as they are stored; gives the growth of memory behind the first fifth, in KiB, and answers per second.
fn flood(place: Place) -> (i64, f64) {
    const WRITERS: usize = 50;
    const EACH: u64 = 2000;
    let folder = tempfile::tempdir().unwrap();
    let store = begun(place, folder.path(), WRITERS);
    let answer_until = |from: u64, to: u64| {
        std::thread::scope(|scope| {
            for participant in 0..WRITERS {
                let mut store = store.clone();
                scope.spawn(move || {
                    for number in from..to {
                        append(&mut store, participant, number).unwrap();
                    }
                });
            }
        });
    };
    let began = Instant::now();
    answer_until(0, EACH / 5);
    let warm = resident();
    answer_until(EACH / 5, EACH);
    let grown = i64::try_from(resident()).unwrap() - i64::try_from(warm).unwrap();
    let rate = (WRITERS as u64 * EACH) as f64 / began.elapsed().as_secs_f64();
    let sessions = store.sessions().unwrap();
    let counts = sessions
        .iter()
        .map(|entry| store.events(&entry.key).unwrap().len() as u64);
    assert!(counts.eq(vec![EACH; WRITERS]));
    (grown, rate)
}

/// What 80,000 answers may leave in memory, in KiB: 100 bytes for each, where one that was kept takes more than 400 (its text, two
/// checksums, salt and names). Caches of the databases are full, and threads have their heaps, before the growth is measured.
const MOST_GROWTH: i64 = 8 * 1024;
/// How many times the 99th percentile of a bare write an answer may take: it waits for the transaction under way and for its own, each
/// of two flushes, and the server adds its own.
const MOST_RATIO: f64 = 10.0;

#[test]
#[ignore = "a minute and more of answers; ./x soak runs it, and a short one runs in every test"]
fn soak_group_commit() {
    let seconds = std::env::var("PIEZOTACT_SOAK_SECONDS");
    let seconds = seconds.map_or(20, |text| text.parse().unwrap());
    eprintln!("200 participants, an answer each in {BETWEEN} s, for {seconds} s; times in ms");
    eprintln!(
        "{:<22} {:>7} {:>9} {:>9} {:>9}",
        "", "number", "p50", "p99", "max"
    );
    let mut ratios = Vec::new();
    for place in places() {
        let [answers, bare] = answered(place, 200, Duration::from_secs(seconds));
        let ratio = answers.per_mille(990) / bare.per_mille(990);
        eprintln!("{:<22} {}", place.name(), answers.row());
        eprintln!("{:<22} {}", "  bare fdatasync", bare.row());
        eprintln!("{:<22} {ratio:.2}", "  ratio of p99");
        ratios.push((place, ratio));
    }
    let mut floods = Vec::new();
    for place in places() {
        let (grown, rate) = flood(place);
        eprintln!(
            "{:<22} 100000 answers at {rate:.0} per second, memory grew by {grown} KiB over the last 80000",
            place.name()
        );
        floods.push((place, grown));
    }
    for (place, ratio) in ratios {
        assert!(ratio <= MOST_RATIO, "{}: {ratio}", place.name());
    }
    for (place, grown) in floods {
        assert!(grown <= MOST_GROWTH, "{}: {grown} KiB", place.name());
    }
}
