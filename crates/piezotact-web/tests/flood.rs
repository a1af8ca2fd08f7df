//! What arrives in masses: passwords, tries and connections, from many addresses of this machine.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::io::{Read, Write};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::sync::Mutex;
use std::time::{Duration, Instant};

use crate::client::{PASSWORD, Page, Pages, with_pages, with_pages_on_network};
use crate::support::{Bed, isotropic};

/// One flood at a time: memory is that of the whole program.
static ONE: Mutex<()> = Mutex::new(());

/// A page is loaded within this time, whatever arrives, also on a machine with other work.
const SOON: Duration = Duration::from_secs(3);

/// Idle connections of an address, of six: more than there are places. Each is open in this program twice.
const IDLE_OF_ONE: usize = 50;

fn served(act: impl FnOnce(&Pages) + Send) {
    let (protocol, plan) = isotropic();
    with_pages(&mut Bed::new(), (&protocol, &plan), act);
}

fn on_network(act: impl FnOnce(&Pages) + Send) {
    let (protocol, plan) = isotropic();
    with_pages_on_network(&mut Bed::new(), (&protocol, &plan), act);
}

/// A connection of the address `from`, which may be any one of 127.0.0.0/8.
fn connect(pages: &Pages, from: [u8; 4]) -> TcpStream {
    let runtime = tokio::runtime::Builder::new_current_thread()
        .enable_all()
        .build()
        .unwrap();
    let stream = runtime.block_on(async {
        let socket = tokio::net::TcpSocket::new_v4().unwrap();
        let from = Ipv4Addr::from(from);
        socket.bind(SocketAddr::from((from, 0))).unwrap();
        let stream = socket.connect(pages.at).await.unwrap();
        stream.into_std().unwrap()
    });
    stream.set_nonblocking(false).unwrap();
    stream
        .set_read_timeout(Some(Duration::from_secs(30)))
        .unwrap();
    stream
}

/// The same, encrypted where the pages are.
fn channel(pages: &Pages, from: [u8; 4]) -> impl Read + Write + Send {
    let stream = connect(pages, from);
    match &pages.encrypt {
        Some(encrypt) => encrypt(stream),
        None => Box::new(stream),
    }
}

/// Tries to enter with a filled form: the head of the answer.
fn tried(pages: &Pages, from: [u8; 4], filled: &str) -> String {
    let mut stream = channel(pages, from);
    let _cut = write!(
        stream,
        "POST /enter HTTP/1.1\r\nhost: {}\r\nconnection: close\r\ncontent-type: application/x-www-form-urlencoded\r\ncontent-length: {}\r\n\r\n{filled}",
        pages.at,
        filled.len()
    );
    let mut all = Vec::new();
    let _cut = stream.read_to_end(&mut all);
    let all = String::from_utf8(all).unwrap();
    let (head, _) = all.split_once("\r\n\r\n").unwrap_or((&all, ""));
    head.to_lowercase()
}

fn is(head: &str, status: u16) -> bool {
    head.starts_with(&format!("http/1.1 {status} "))
}

/// Resident memory of this program, in MiB.
fn resident() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with("VmRSS:"));
    let kib = line.unwrap().split_whitespace().nth(1).unwrap();
    kib.parse::<u64>().unwrap() / 1024
}

fn loads_soon(pages: &Pages, page: &Page, path: &str) {
    let began = Instant::now();
    let reply = pages.send("GET", path, &[("cookie", &page.cookie)], "");
    assert_eq!(reply.status, 200, "{path}: {reply:?}");
    let took = began.elapsed();
    assert!(took < SOON, "{path} took {took:?}");
}

#[test]
fn wrong_passwords_of_sixty_addresses_take_little_memory_and_hold_nobody_up() {
    let _one = ONE.lock();
    on_network(|pages| {
        let page = pages.experimenter();
        let before = resident();
        // Three networks of twenty addresses.
        let heads: Vec<String> = std::thread::scope(|scope| {
            let all: Vec<_> = (0..60_u8)
                .map(|i| {
                    scope.spawn(move || tried(pages, [127, 0, 1 + i % 3, 10 + i], "password=x"))
                })
                .collect();
            // Reports do not wait for passwords.
            loads_soon(
                pages,
                &page,
                "/session?participant=P01&session=discrimination",
            );
            loads_soon(pages, &page, "/experimenter");
            let right = tried(pages, [127, 0, 9, 1], &format!("password={PASSWORD}"));
            assert!(is(&right, 303), "{right}");
            all.into_iter().map(|one| one.join().unwrap()).collect()
        });
        let wrong = heads.iter().filter(|head| is(head, 403)).count();
        let later = heads.iter().filter(|head| is(head, 429)).count();
        assert_eq!(wrong + later, 60, "{heads:?}");
        assert!(wrong > 0 && later > 0, "{wrong} {later}");
        let waits = heads
            .iter()
            .filter(|head| head.contains("\r\nretry-after: "));
        assert_eq!(waits.count(), later, "{heads:?}");
        let after = resident();
        assert!(after < before + 150, "{before} MiB, then {after} MiB");
    });
}

#[test]
fn addresses_of_one_network_share_their_tries() {
    served(|pages| {
        let page = pages.experimenter();
        let looked_at = |network: u8| {
            let all = (1..=30).flat_map(|own| [[127, 3, network, own]; 2]);
            let all = all.filter(|from| is(&tried(pages, *from, "code=aaaaaaaaaa"), 403));
            all.count()
        };
        assert_eq!(looked_at(1), 20);
        let code = format!("code={}", pages.viewer);
        let refused = tried(pages, [127, 3, 1, 77], &code);
        assert!(is(&refused, 429), "{refused}");
        assert!(refused.contains("\r\nretry-after: 60"), "{refused}");
        // Another network, and a page that is in.
        assert!(is(&tried(pages, [127, 3, 2, 77], &code), 303));
        loads_soon(pages, &page, "/experimenter");
    });
}

/// More connections than there are places, of six addresses of the network of everybody else.
fn idle_connections_hold_nobody_up(pages: &Pages, page: &Page, first: &[u8]) {
    let mut stream = pages.follow(page);
    assert!(stream.step().is_some());
    let mut idle = Vec::new();
    for i in 0..6 * IDLE_OF_ONE {
        let mut one = connect(pages, [127, 0, 0, 2 + (i % 6) as u8]);
        let _cut = one.write_all(first);
        idle.push(one);
    }
    for path in ["/experimenter", "/assets/session.js", "/study"] {
        loads_soon(pages, page, path);
    }
    assert!(is(&tried(pages, [127, 5, 5, 5], "code=x"), 403));
    // Also behind the address of the page itself.
    for _ in 0..IDLE_OF_ONE {
        let mut one = connect(pages, [127, 0, 0, 1]);
        let _cut = one.write_all(first);
        idle.push(one);
    }
    loads_soon(pages, page, "/experimenter");
    let code = format!("code={}", pages.viewer);
    assert!(is(&tried(pages, [127, 0, 0, 1], &code), 303));
    // The page still follows.
    assert_eq!(pages.ask(page, r#""do":"consent""#).status, 204);
    assert!(stream.step().is_some());
}

#[test]
fn idle_connections_of_six_addresses_hold_nobody_up() {
    let _one = ONE.lock();
    served(|pages| {
        let page = pages.experimenter();
        idle_connections_hold_nobody_up(pages, &page, b"GET /enter HTTP/1.1\r\nhost: ");
    });
}

#[test]
fn handshakes_of_six_addresses_that_never_finish_hold_nobody_up() {
    let _one = ONE.lock();
    on_network(|pages| {
        let page = pages.experimenter();
        idle_connections_hold_nobody_up(pages, &page, &[22, 3, 1, 2, 0, 1]);
    });
}

/// Sends `then` a byte a second after `first` until the connection is closed; how long it was open.
fn dripped(mut stream: impl Read + Write, (first, then): (&str, &[u8])) -> Duration {
    let began = Instant::now();
    stream.write_all(first.as_bytes()).unwrap();
    for byte in then.iter().cycle().take(25) {
        let is_sent = stream.write_all(&[*byte]).and_then(|()| stream.flush());
        std::thread::sleep(Duration::from_secs(1));
        if is_sent.is_err() {
            return began.elapsed();
        }
    }
    panic!(
        "a slow connection is open for longer than {:?}",
        began.elapsed()
    );
}

/// How long the server holds a connection that says nothing more; what it answered before.
fn held(mut stream: impl Read + Write) -> (Duration, String) {
    let began = Instant::now();
    let mut all = Vec::new();
    let _cut = stream.read_to_end(&mut all);
    (began.elapsed(), String::from_utf8_lossy(&all).into_owned())
}

#[test]
fn slow_connections_are_closed() {
    on_network(|pages| {
        let host = format!("host: {}\r\n", pages.at);
        let from = |own| [127, 0, 7, own];
        let form = "content-type: application/x-www-form-urlencoded\r\ncontent-length: 1000\r\n";
        let body = format!("POST /enter HTTP/1.1\r\n{host}{form}\r\ncode=");
        let head = format!("GET /enter HTTP/1.1\r\n{host}");
        let times = std::thread::scope(|scope| {
            let all = [
                scope.spawn(|| held(connect(pages, from(1))).0),
                // A handshake that begins late and never finishes.
                scope.spawn(|| {
                    let mut stream = connect(pages, from(8));
                    let late = Duration::from_secs(8);
                    std::thread::sleep(late);
                    stream.write_all(&[22, 3, 1, 2, 0, 1]).unwrap();
                    late + held(stream).0
                }),
                // The head of a handshake, and a whole one without a request.
                scope.spawn(|| dripped(connect(pages, from(2)), ("\u{16}\u{3}\u{1}", &[2, 0, 1]))),
                scope.spawn(|| {
                    let mut stream = channel(pages, from(3));
                    stream.flush().unwrap();
                    held(stream).0
                }),
                scope.spawn(|| dripped(channel(pages, from(4)), (&head, b"x: y\r\n"))),
                scope.spawn(|| dripped(channel(pages, from(5)), (&body, b"a"))),
                // After an answer.
                scope.spawn(|| {
                    let mut stream = channel(pages, from(6));
                    write!(stream, "{head}\r\n").unwrap();
                    let (time, answer) = held(stream);
                    assert!(answer.starts_with("HTTP/1.1 200 "), "{answer}");
                    time
                }),
                // To where it is not encrypted.
                scope.spawn(|| dripped(connect(pages, from(7)), ("G", b"ET /"))),
            ];
            all.map(|one| one.join().unwrap())
        });
        assert!(
            times.iter().all(|time| *time < Duration::from_secs(16)),
            "{times:?}"
        );
    });
}
