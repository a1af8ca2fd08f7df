//! A session on pages: what is refused before, killed servers, and pages that go on with a session that was typed.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]
#![allow(clippy::print_stderr, reason = "a long test says what it did")]

use std::collections::BTreeMap;
use std::io::{BufRead as _, BufReader, Read as _};
use std::process::{Child, Stdio};
use std::sync::{Arc, Mutex};
use std::time::Duration;

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng as _, SeedableRng as _};

use crate::client::{Page, Pages};
use crate::postgres::Server as Database;
use crate::support::Folder;
use crate::support::session::{naming, table};

fn run(folder: &Folder, line: &str) -> crate::support::Done {
    folder.run(&line.split_whitespace().collect::<Vec<_>>())
}

fn study() -> Folder {
    let folder = Folder::new();
    folder.write("protocol.toml", naming(8));
    run(
        &folder,
        "campaign new study --protocol protocol.toml --seed 7",
    )
    .expect_success();
    folder
}

/// A server, which ends with the value.
struct Server {
    child: Arc<Mutex<Child>>,
    pages: Pages,
}

impl Drop for Server {
    fn drop(&mut self) {
        let mut child = self.child.lock().unwrap();
        let _may_have_ended = child.kill();
        let _status = child.wait();
    }
}

/// Serves the session `naming` of P01.
fn serve(folder: &Folder) -> Server {
    serving(folder, "serve study P01 naming --by-hand --port 0")
}

/// What the command `line` serves.
fn serving(folder: &Folder, line: &str) -> Server {
    let mut command = folder.command(&line.split(' ').collect::<Vec<_>>());
    let mut child = command
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    let mut address = || {
        let Some(Ok(line)) = lines.next() else {
            let mut said = String::new();
            child
                .stderr
                .take()
                .unwrap()
                .read_to_string(&mut said)
                .unwrap();
            panic!("the server ended: {said}");
        };
        let (_, address) = line.split_once("http://").unwrap();
        let (at, code) = address.split_once("/enter?code=").unwrap();
        (at.parse().unwrap(), code.to_owned())
    };
    let ((at, experimenter), (_, viewer)) = (address(), address());
    Server {
        child: Arc::new(Mutex::new(child)),
        pages: Pages {
            at,
            encrypt: None,
            experimenter,
            viewer,
        },
    }
}

/// What a page that was let in earlier shows; `None` where there is no server.
fn shown(pages: &Pages, page: &Page) -> Option<String> {
    let reply = pages.try_send("GET", "/experimenter", &[("cookie", &page.cookie)], "")?;
    (reply.status == 200 && reply.body.ends_with("</html>")).then_some(reply.body)
}

fn after<'a>(text: &'a str, before: &str) -> Option<&'a str> {
    let (_, after) = text.split_once(before)?;
    after.split('"').next()
}

/// The answer that belongs to a trial.
fn answer(number: usize) -> String {
    format!("K{}", (number * 7 + 3) % 5 + 1)
}

/// The next request of the page that shows `text`, and the number of its trial; `None` at the end.
fn next(text: &str) -> Option<(String, usize)> {
    let (_, step) = text.split_once("class=\"step\"").unwrap();
    // Before its first trial a session has none.
    let number = after(step, "data-trial=\"").map_or(0, |number| number.parse().unwrap());
    let kinds = ["consent", "check", "present", "confirm", "end"];
    let asked = kinds
        .into_iter()
        .find(|kind| step.contains(&format!("&quot;{kind}&quot;")));
    // An answer that is noted is confirmed; one that is awaited is given.
    let what = match asked {
        Some(kind) => format!(r#""do":"{kind}""#),
        None if step.contains("data-draft") => {
            format!(r#""do":"answer","words":["{}"]"#, answer(number))
        }
        None => return None,
    };
    Some((what, number))
}

/// Does the session on pages while the server is killed `times` times; a page keeps what it asked until that is stored or late.
fn killed(times: usize, seed: u64) {
    let folder = study();
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut server = serve(&folder);
    let page = server.pages.experimenter();
    let mut confirmed: BTreeMap<usize, String> = BTreeMap::new();
    let (mut kills, mut lost_replies, mut requests) = (0, 0, 0_u32);
    let mut pending: Option<(String, String, String, usize)> = None;
    loop {
        let killer = (kills < times).then(|| {
            let child = Arc::clone(&server.child);
            let wait = Duration::from_micros(u64::from(random.next_u32() % 25_000));
            std::thread::spawn(move || {
                std::thread::sleep(wait);
                let _killed = child.lock().unwrap().kill();
            })
        });
        let over = loop {
            let asked = match pending.take() {
                Some(asked) => asked,
                None => {
                    let Some(text) = shown(&server.pages, &page) else {
                        break false;
                    };
                    let Some((what, number)) = next(&text) else {
                        break true;
                    };
                    requests += 1;
                    let at = after(&text, "data-mark=\"").unwrap().to_owned();
                    (requests.to_string(), at, what, number)
                }
            };
            let (id, at, what, number) = &asked;
            let headers = [
                ("cookie", page.cookie.as_str()),
                ("x-piezotact-mark", page.mark.as_str()),
                ("content-type", "application/json"),
            ];
            let body = format!(r#"{{"id":"{id}","at":"{at}",{what}}}"#);
            let reply = server.pages.try_send("POST", "/ask", &headers, &body);
            match reply.map(|reply| reply.status) {
                Some(204) => {
                    if what.contains("confirm") {
                        confirmed.insert(*number, answer(*number));
                    }
                }
                // It was stored before, or the trial is presented anew.
                Some(409) => lost_replies += 1,
                None | Some(0 | 503) => {
                    pending = Some(asked);
                    break false;
                }
                other => panic!("{body}: {other:?}"),
            }
        };
        if let Some(killer) = killer {
            killer.join().unwrap();
            kills += 1;
        }
        if over {
            break;
        }
        drop(server);
        server = serve(&folder);
        // What was acknowledged is there.
        let text = shown(&server.pages, &page).unwrap_or_else(|| {
            let reply =
                server
                    .pages
                    .try_send("GET", "/experimenter", &[("cookie", &page.cookie)], "");
            panic!("the page does not go on without a new code: {reply:?}")
        });
        // The first trial is learning; it has no answer.
        for (number, answer) in confirmed.iter().filter(|(number, _)| **number > 1) {
            let kept = format!("{number} · task1: {answer}");
            assert!(text.contains(&kept), "{kept} is lost: {text}");
        }
    }
    drop(server);
    run(&folder, "campaign verify study").expect_success();
    run(&folder, "campaign export study --out exported").expect_success();
    let trials = table(&folder.path("exported/trials.csv"));
    let answered: Vec<_> = trials
        .iter()
        .filter(|trial| !trial["answer"].is_empty())
        .collect();
    assert!(answered.len() >= 40);
    for trial in answered {
        let number: usize = trial["number"].parse().unwrap();
        if trial["answer"] != "done" && number > 1 {
            assert_eq!(trial["answer"], answer(number), "{trial:?}");
            assert_eq!(trial["revisions"], "0", "{trial:?}");
        }
    }
    let events = std::fs::read_to_string(folder.path("exported/events/P01_naming.jsonl")).unwrap();
    let confirmations: Vec<&str> = events
        .lines()
        .filter(|line| line.contains("\"confirmed\""))
        .collect();
    let mut once = confirmations
        .iter()
        .map(|line| after(line, "\"trial\":\"").unwrap())
        .collect::<Vec<_>>();
    once.sort_unstable();
    once.dedup();
    assert_eq!(
        once.len(),
        confirmations.len(),
        "a trial is confirmed twice"
    );
    assert!(kills >= times.min(3), "{kills}");
    eprintln!("{kills} kills, {lost_replies} requests that came late, of {requests}");
}

#[test]
fn a_server_that_is_killed_loses_and_doubles_nothing() {
    for seed in [3, 4] {
        killed(20, seed);
    }
}

#[test]
#[ignore = "minutes: ./x soak"]
fn soak_kill_serve() {
    for seed in 0..30 {
        killed(20, 100 + seed);
    }
}

/// One session, begun on the terminal and gone on with on pages; not on two at once.
#[test]
fn terminal_and_pages_lead_the_same_session() {
    let folder = study();
    let mut typed = crate::support::session::Session::begin(folder.command(&[
        "campaign",
        "run",
        "study",
        "P01",
        "naming",
        "--by-hand",
    ]));
    typed.prompt().unwrap();
    run(&folder, "serve study P01 naming --by-hand --port 0").expect_failure(1, &["P01"]);
    typed.type_and_read("yes");
    typed.type_line("/leave");
    typed.end();
    let server = serve(&folder);
    let page = server.pages.experimenter();
    assert!(
        shown(&server.pages, &page)
            .unwrap()
            .contains("data-mark=\"running-")
    );
    folder
        .run(&["campaign", "run", "study", "P01", "naming", "--by-hand"])
        .expect_failure(1, &["P01"]);
    let port = server.pages.at.port().to_string();
    folder
        .run(&[
            "serve",
            "study",
            "P02",
            "naming",
            "--by-hand",
            "--port",
            &port,
        ])
        .expect_failure(1, &["state another --port"]);
    run(&folder, "serve study P01 nothing --port 0").expect_failure(2, &["nothing"]);
}

/// A study on pages: a session that is under way has no report yet; one that is over has.
#[test]
fn a_study_is_shown_with_the_reports_of_its_sessions() {
    let folder = study();
    let server = serve(&folder);
    let page = server.pages.experimenter();
    let get = |pages: &Pages, page: &Page, path: &str| {
        pages.send("GET", path, &[("cookie", &page.cookie)], "")
    };
    let report = "/session?participant=P01&session=naming";
    assert_eq!(server.pages.ask(&page, r#""do":"consent""#).status, 204);
    let early = get(&server.pages, &page, report);
    assert_eq!(early.status, 422);
    assert!(early.body.contains("is not over"), "{}", early.body);
    let note = r#""do":"note","text":"the <fan> was loud""#;
    assert_eq!(server.pages.ask(&page, note).status, 204);
    let stop = r#""do":"stop","why":"fire alarm""#;
    assert_eq!(server.pages.ask(&page, stop).status, 204);
    let step = shown(&server.pages, &page).unwrap();
    assert!(
        step.contains(&report.replace('&', "&amp;")),
        "the report has a link when the session is over"
    );
    drop(server);
    let server = serving(&folder, "serve study --port 0");
    let page = server.pages.experimenter();
    let overview = get(&server.pages, &page, "/study").body;
    for words in [
        "P01",
        "naming · stopped before its end",
        "0 of 3 participants",
    ] {
        assert!(overview.contains(words), "{words}: {overview}");
    }
    let found = get(&server.pages, &page, report);
    assert_eq!(found.status, 200);
    for words in [
        "stopped: fire alarm",
        "note: the &lt;fan&gt; was loud",
        "consent was given",
        "trials confirmed",
    ] {
        assert!(found.body.contains(words), "{words}: {}", found.body);
    }
    for path in [
        "/session?participant=P09&session=naming",
        "/session?participant=..&session=..%2F..",
    ] {
        assert_eq!(get(&server.pages, &page, path).status, 422, "{path}");
    }
    // Nothing is led here.
    for path in ["/experimenter", "/console"] {
        assert_eq!(get(&server.pages, &page, path).status, 404, "{path}");
    }
    run(&folder, "serve study P01 --port 0").expect_failure(2, &["SESSION"]);
    run(&folder, "serve nothing --port 0").expect_failure(1, &["nothing"]);
}

/// Pages of a study that stations share: the server of the database crashes between two entries, and nothing is lost or stored twice.
#[test]
fn pages_lead_a_session_of_a_shared_study() {
    let database = Database::start("");
    let url = database.database();
    let (folder, there) = (Folder::new(), Folder::new());
    folder.write("protocol.toml", naming(8));
    let new = "campaign new study --protocol protocol.toml --seed 7";
    run(&folder, &format!("{new} --store {url}")).expect_success();
    run(&there, &format!("campaign join {url} study")).expect_success();
    let server = serve(&folder);
    let page = server.pages.experimenter();
    assert_eq!(server.pages.ask(&page, r#""do":"consent""#).status, 204);
    run(&there, "serve study P01 naming --by-hand --port 0")
        .expect_failure(1, &["run by another program"]);
    let looking = serving(&there, "serve study --port 0");
    let look = looking.pages.experimenter();
    let overview = || {
        let cookie = [("cookie", look.cookie.as_str())];
        looking.pages.send("GET", "/study", &cookie, "")
    };
    assert!(overview().body.contains("under way"));
    database.crash();
    let note = r#""do":"note","text":"the server crashed""#;
    let at = server.pages.mark(&page);
    let lost = server.pages.ask_as(&page, ("n", &at), note);
    assert_eq!(lost.status, 507, "{lost:?}");
    assert!(lost.body.contains("nothing was stored"), "{lost:?}");
    let unread = overview();
    assert_eq!(unread.status, 422, "{unread:?}");
    database.start_again();
    for _ in 0..2 {
        let stored = server.pages.ask_as(&page, ("n", &at), note);
        assert_eq!(stored.status, 204, "{stored:?}");
    }
    let stop = r#""do":"stop","why":"enough""#;
    assert_eq!(server.pages.ask(&page, stop).status, 204);
    assert!(overview().body.contains("stopped before its end"));
    drop(server);
    run(&there, "campaign export study --out exported").expect_success();
    let events = std::fs::read_to_string(there.path("exported/events/P01_naming.jsonl")).unwrap();
    assert_eq!(events.matches("the server crashed").count(), 1, "{events}");
    run(&there, "campaign verify study").expect_success();
}
