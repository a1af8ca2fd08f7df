//! Servers that crash and connections that break: nothing that was acknowledged is lost, and nothing is stored twice.

use std::io::{Read as _, Write as _};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU8, Ordering};
use std::time::{Duration, Instant};

use piezotact_people::campaign::store::{Purpose, Store as _, StoreError};
use piezotact_study::store::StudyStore;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

use crate::postgres::{Server, server};
use crate::server::{station, url};
use crate::{append, fill, holding, key, kill_within_ms, lines, name, passphrase, start, whole};

/// Crashes a server `count` times while a station stores answers.
fn crashes(count: u32) {
    let own = Server::start("");
    let folder = tempfile::tempdir().unwrap();
    let (mut store, _) = station(&own, folder.path(), 0);
    let stops = AtomicBool::new(false);
    let (mut stored, mut refused) = (Vec::new(), 0);
    let count_refused = std::thread::scope(|scope| {
        let station = scope.spawn(|| {
            let mut next = 0;
            while !stops.load(Ordering::Relaxed) {
                match append(&mut store, &key(), next) {
                    Ok(link) => {
                        stored.push(link.number);
                        next += 1;
                    }
                    Err(StoreError::Place { .. }) => {
                        refused += 1;
                        // As whoever reads the journal again does.
                        next = loop {
                            match store.events(&key()) {
                                Ok(links) => break links.len() as u64,
                                Err(_) => std::thread::sleep(Duration::from_millis(50)),
                            }
                        };
                    }
                    Err(other) => panic!("{other}"),
                }
            }
            refused
        });
        let mut random = ChaCha8Rng::seed_from_u64(78);
        for _ in 0..count {
            std::thread::sleep(Duration::from_millis(u64::from(random.next_u32() % 300)));
            own.crash();
            own.start_again();
        }
        std::thread::sleep(Duration::from_millis(300));
        stops.store(true, Ordering::Relaxed);
        station.join().unwrap()
    });
    assert!(
        count_refused >= count / 2,
        "{count_refused} of {count} crashes were among answers"
    );
    drop(store);
    let store = StudyStore::open(folder.path()).unwrap();
    let there = whole(&store);
    assert!(
        stored.windows(2).all(|pair| pair[0] < pair[1]),
        "stored twice"
    );
    let unsaid = there - stored.len() as u64;
    assert!(stored.iter().all(|number| *number < there));
    assert!(unsaid <= u64::from(count_refused), "{unsaid}");
}

#[test]
fn an_acknowledged_event_survives_a_crash_of_the_server() {
    crashes(5);
}

#[test]
#[ignore = "100 crashes; ./x soak runs it, and 5 run in every test"]
fn soak_store_server_crash() {
    crashes(100);
}

/// What a relay does with the next commit.
#[derive(Clone, Copy, PartialEq)]
#[repr(u8)]
enum Fault {
    None,
    /// The connection ends after the server got it, before it has answered.
    AnswerLost,
    /// The connection ends before the server gets it.
    CommitLost,
    /// As `AnswerLost`, and nobody is let in until the relay is mended.
    AnswerLostAndAway,
    /// As `CommitLost`, but the server hears of it only when the relay is mended: its end of the connection stays.
    Silent,
}

const ALL: [Fault; 5] = [
    Fault::None,
    Fault::AnswerLost,
    Fault::CommitLost,
    Fault::AnswerLostAndAway,
    Fault::Silent,
];

/// A relay between a station and the server.
struct Relay {
    port: u16,
    fault: Arc<AtomicU8>,
    away: Arc<AtomicBool>,
}

impl Relay {
    fn to(server: u16) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let relay = Self {
            port: listener.local_addr().unwrap().port(),
            fault: Arc::default(),
            away: Arc::default(),
        };
        let (fault, away) = (Arc::clone(&relay.fault), Arc::clone(&relay.away));
        std::thread::spawn(move || {
            for station in listener.incoming() {
                let station = station.unwrap();
                if away.load(Ordering::SeqCst) {
                    continue;
                }
                let server = TcpStream::connect(("127.0.0.1", server)).unwrap();
                let (fault, away) = (Arc::clone(&fault), Arc::clone(&away));
                let back = (server.try_clone().unwrap(), station.try_clone().unwrap());
                std::thread::spawn(move || forward(station, server, &fault, &away));
                std::thread::spawn(move || {
                    let (mut server, mut station) = back;
                    let _ended = std::io::copy(&mut server, &mut station);
                    let _closed = station.shutdown(Shutdown::Both);
                });
            }
        });
        relay
    }

    fn set(&self, fault: Fault) {
        self.fault.store(fault as u8, Ordering::SeqCst);
    }
}

/// Forwards what a station says, but for the fault.
fn forward(mut station: TcpStream, mut server: TcpStream, fault: &AtomicU8, away: &AtomicBool) {
    let mut bytes = [0; 65536];
    while let Ok(count) = station.read(&mut bytes) {
        if count == 0 {
            break;
        }
        let said = &bytes[..count];
        let is_commit = said.windows(6).any(|word| word == b"COMMIT");
        let now = match is_commit {
            true => ALL[usize::from(fault.swap(0, Ordering::SeqCst))],
            false => Fault::None,
        };
        if now == Fault::AnswerLostAndAway {
            away.store(true, Ordering::SeqCst);
        }
        match now {
            Fault::None => server.write_all(said).unwrap_or_default(),
            Fault::AnswerLost | Fault::AnswerLostAndAway => {
                let _closed = station.shutdown(Shutdown::Both);
                server.write_all(said).unwrap_or_default();
                std::thread::sleep(Duration::from_millis(200));
                break;
            }
            Fault::CommitLost => break,
            Fault::Silent => {
                let _closed = station.shutdown(Shutdown::Both);
                std::thread::sleep(Duration::from_secs(3));
                break;
            }
        }
    }
    let _closed = (
        station.shutdown(Shutdown::Both),
        server.shutdown(Shutdown::Both),
    );
}

/// A station that reaches the server through a relay.
fn relayed(folder: &std::path::Path) -> (StudyStore, Relay) {
    let database = server().database();
    let (_, after) = database.split_once("127.0.0.1:").unwrap();
    let (port, name) = after.split_once('/').unwrap();
    let relay = Relay::to(port.parse().unwrap());
    let through = format!(
        "postgres://lab@127.0.0.1:{}/{name}?sslmode=disable",
        relay.port
    );
    let mut store = StudyStore::create_on(folder, &url(&through)).unwrap();
    store.begin(&key(), Purpose::Volunteer).unwrap();
    append(&mut store, &key(), 0).unwrap();
    (store, relay)
}

#[test]
fn an_answer_whose_acknowledgement_was_lost_is_stored_once() {
    let folder = tempfile::tempdir().unwrap();
    let (mut store, relay) = relayed(folder.path());
    let _lock = store.run_alone(&name("P01"), "discrimination").unwrap();
    relay.set(Fault::AnswerLost);
    // The store looks, over a new connection, and finds it.
    assert_eq!(append(&mut store, &key(), 1).unwrap().number, 1);
    assert_eq!(whole(&store), 2);
    // The server never got it: it is refused, and given again.
    relay.set(Fault::CommitLost);
    let refused = append(&mut store, &key(), 2).unwrap_err();
    assert!(
        refused.to_string().contains("check the network and that the server runs, then do the same again: nothing is stored twice"),
        "{refused}"
    );
    append(&mut store, &key(), 2).unwrap();
    assert_eq!(whole(&store), 3);
    // Nobody answers for a while.
    relay.set(Fault::AnswerLostAndAway);
    assert!(append(&mut store, &key(), 3).is_err());
    assert!(append(&mut store, &key(), 3).is_err());
    relay.away.store(false, Ordering::SeqCst);
    assert!(matches!(
        append(&mut store, &key(), 3),
        Err(StoreError::Overtaken {
            expected: 3,
            found: 4,
            ..
        })
    ));
    assert_eq!(whole(&store), 4);
    append(&mut store, &key(), 4).unwrap();
    drop(store);
    assert_eq!(whole(&StudyStore::open(folder.path()).unwrap()), 5);
}

/// The server still waits for a station that has lost its connection: its transaction and its locks are ended by the station itself.
#[test]
fn a_connection_that_the_server_holds_open_is_ended_by_the_next() {
    let folder = tempfile::tempdir().unwrap();
    let (mut store, relay) = relayed(folder.path());
    let _lock = store.run_alone(&name("P01"), "discrimination").unwrap();
    relay.set(Fault::Silent);
    let began = Instant::now();
    assert!(append(&mut store, &key(), 1).is_err());
    append(&mut store, &key(), 1).unwrap();
    assert!(
        began.elapsed() < Duration::from_secs(3),
        "{:?}",
        began.elapsed()
    );
    assert_eq!(whole(&store), 2);
    // The lock of the session went over to the new connection.
    let other = tempfile::tempdir().unwrap();
    let through = std::fs::read_to_string(folder.path().join("study.url")).unwrap();
    let there = StudyStore::join(other.path(), &url(through.trim_end())).unwrap();
    assert!(there.run_alone(&name("P01"), "discrimination").is_err());
}

/// A session that another station has taken up while the connection was lost does not go on here.
#[test]
fn a_session_that_was_taken_up_elsewhere_does_not_go_on() {
    let own = Server::start("");
    let folders = [tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap()];
    let (mut here, database) = station(&own, folders[0].path(), 1);
    let _lock = here.run_alone(&name("P01"), "discrimination").unwrap();
    own.crash();
    own.start_again();
    let there = StudyStore::join(folders[1].path(), &url(&database)).unwrap();
    let _taken = there.run_alone(&name("P01"), "discrimination").unwrap();
    assert!(append(&mut here, &key(), 1).is_err());
    let refused = append(&mut here, &key(), 1).unwrap_err().to_string();
    assert!(
        refused.contains("a station at 127.0.0.1 has taken up the session; end it there"),
        "{refused}"
    );
    drop(there);
    let again = (0..50).find_map(|_| append(&mut here, &key(), 1).ok());
    assert!(again.is_some());
}

/// A withdrawal that is killed at a random moment has not happened, or is complete once the study was opened; also what is at the server.
#[test]
fn a_killed_withdrawal_at_a_server_has_not_happened_or_is_completed() {
    let mut random = ChaCha8Rng::seed_from_u64(80);
    let unkilled = tempfile::tempdir().unwrap();
    let (mut store, _database) = station(server(), unkilled.path(), 20);
    fill(&mut store, "P01");
    drop(store);
    let within_ms = kill_within_ms(unkilled.path());
    let mut after = 0;
    for _ in 0..8 {
        let folder = tempfile::tempdir().unwrap();
        let (mut store, database) = station(server(), folder.path(), 20);
        fill(&mut store, "P01");
        drop(store);
        let mut child = start("withdraw", folder.path());
        std::thread::sleep(Duration::from_millis(
            u64::from(random.next_u32()) % within_ms,
        ));
        child.kill().unwrap();
        drop(lines(child));
        // What the server had of it ends a moment later.
        std::thread::sleep(Duration::from_millis(100));
        let store = StudyStore::open(folder.path()).unwrap();
        assert_eq!(store.verify().unwrap(), 1);
        let found = holding(folder.path(), "quince");
        let people = store.identities(&passphrase()).unwrap();
        let pending = "SELECT count(*) FROM piezotact.withdrawals WHERE pending <> 'nothing'";
        if store.sessions().unwrap()[0].withdrawn_at_ms.is_none() {
            assert_eq!((whole(&store), people.len()), (20, 1));
            assert_eq!(found.len(), 3, "{found:?}");
        } else {
            after += 1;
            assert!(
                found.is_empty() && people.is_empty(),
                "{found:?} {people:?}"
            );
            assert_eq!(server().sql(&database, pending), "0");
            // Nobody is said to be in the identities who is not.
            drop(store);
            assert_eq!(StudyStore::open(folder.path()).unwrap().notices(), []);
        }
        assert!(!folder.path().join("identity.age.next").exists());
    }
    assert!(
        after > 0,
        "no kill came after an intention in {within_ms} ms"
    );
}
