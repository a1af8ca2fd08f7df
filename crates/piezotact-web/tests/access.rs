//! Who may do what: every route with every role, and what attackers try.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

use piezotact_web::{For, ROUTES, Role};

use crate::client::{PASSWORD, Page, Pages, with_console, with_pages, with_pages_on_network};
use crate::support::{Bed, isotropic};

fn served(act: impl FnOnce(&Pages) + Send) {
    let (protocol, plan) = isotropic();
    with_pages(&mut Bed::new(), (&protocol, &plan), act);
}

/// The status of a route; of a stream without reading it to its end.
fn status(
    pages: &Pages,
    (method, path): (&str, &str),
    page: Option<&Page>,
    mark: Option<&str>,
) -> u16 {
    let mut headers = vec![("content-type", "application/json")];
    if let Some(page) = page {
        headers.push(("cookie", &page.cookie));
    }
    if let Some(mark) = mark {
        headers.push(("x-piezotact-mark", mark));
    }
    if !path.ends_with("/stream") && path != "/live" && path != "/participant/force" {
        return pages.send(method, path, &headers, "{}").status;
    }
    let mut stream = pages.connect(Duration::from_secs(10)).unwrap();
    let headers: String = headers
        .iter()
        .map(|(name, value)| format!("{name}: {value}\r\n"))
        .collect();
    write!(
        stream,
        "{method} {path} HTTP/1.1\r\nhost: {}\r\n{headers}\r\n",
        pages.at
    )
    .unwrap();
    let mut head = [0; 12];
    stream.read_exact(&mut head).unwrap();
    std::str::from_utf8(&head[9..]).unwrap().parse().unwrap()
}

fn on_network(act: impl FnOnce(&Pages) + Send) {
    let (protocol, plan) = isotropic();
    with_pages_on_network(&mut Bed::new(), (&protocol, &plan), act);
}

#[test]
fn every_route_is_for_its_roles_alone() {
    served(routes);
}

#[test]
fn every_route_on_a_network_is_for_its_roles_alone() {
    on_network(routes);
}

#[test]
fn every_route_of_a_console_is_for_its_roles_alone() {
    with_console(|pages| {
        let known = [
            (Role::Viewer, pages.enter(&pages.viewer)),
            (Role::Experimenter, pages.experimenter()),
        ];
        let is_here = |path: &str| path.starts_with("/console") || path == "/live";
        assert!(allowed(pages, &known, is_here) >= 30);
    });
}

fn routes(pages: &Pages) {
    let experimenter = pages.experimenter();
    let known = [
        (Role::Viewer, pages.enter(&pages.viewer)),
        (Role::Participant, pages.participant(&experimenter)),
        (Role::Experimenter, experimenter),
    ];
    // Without a bench there is nothing live.
    let is_here = |path: &str| {
        let others = ["/console", "/live", "/participant/force"];
        !others.iter().any(|other| path.starts_with(other))
    };
    assert!(allowed(pages, &known, is_here) >= 51);
}

/// Tries every route as `known` pages, and without a page; how many were tried. What `is_here` of this site is not, is not found.
fn allowed(pages: &Pages, known: &[(Role, Page)], is_here: impl Fn(&str) -> bool) -> usize {
    let mut checked = 0;
    for route in ROUTES {
        let to = (route.method, route.path);
        let For::Roles(roles) = route.whose else {
            // Everybody sees no more than that there is a door.
            let reply = pages.send(
                route.method,
                route.path,
                &[("content-type", "application/x-www-form-urlencoded")],
                "code=x",
            );
            assert!(
                [200, 204, 303, 403].contains(&reply.status),
                "{to:?} {reply:?}"
            );
            assert!(!reply.body.contains("data-mark=\""), "{to:?}");
            continue;
        };
        assert!(
            [303, 401].contains(&status(pages, to, None, None)),
            "{to:?}"
        );
        let (_, leads) = known.last().unwrap();
        let forged = Page {
            cookie: leads.cookie.replace(char::is_numeric, "0"),
            ..leads.clone()
        };
        assert!(
            [303, 401].contains(&status(pages, to, Some(&forged), Some(&forged.mark))),
            "{to:?}"
        );
        for (role, page) in known {
            let found = status(pages, to, Some(page), Some(&page.mark));
            let may = roles.contains(role);
            // 400, 422: let in, and asked for nothing that there is.
            let is_let_in = match is_here(route.path) {
                true => {
                    [200, 204, 400, 415, 422].contains(&found)
                        || found == 404 && route.path.contains('{')
                }
                false => found == 404,
            };
            assert_eq!(is_let_in, may, "{to:?} as {role:?}: {found}");
            assert_eq!(found == 403, !may, "{to:?} as {role:?}: {found}");
            if route.method == "POST" {
                for mark in [
                    None,
                    Some(""),
                    Some("0"),
                    Some(known[0].1.mark.as_str()).filter(|m| *m != page.mark),
                ] {
                    assert_eq!(
                        status(pages, to, Some(page), mark),
                        403,
                        "{to:?} as {role:?} with {mark:?}"
                    );
                }
            }
            checked += 1;
        }
    }
    checked
}

#[test]
fn a_participant_and_who_looks_on_command_nothing() {
    served(|pages| {
        let experimenter = pages.experimenter();
        let participant = pages.participant(&experimenter);
        let viewer = pages.enter(&pages.viewer);
        let before = pages.mark(&experimenter);
        for what in [
            r#""do":"check""#,
            r#""do":"present""#,
            r#""do":"present_instead","names":["S1"]"#,
            r#""do":"correct","trial":"x","words":["S1"],"why":"x""#,
            r#""do":"silence""#,
            r#""do":"go_on""#,
            r#""do":"note","text":"x""#,
            r#""do":"stop","why":"x""#,
            r#""do":"withdraw""#,
            r#""do":"end""#,
        ] {
            assert_eq!(pages.ask(&participant, what).status, 403, "{what}");
            assert_eq!(
                pages.ask_as(&viewer, ("1", &before), what).status,
                403,
                "{what}"
            );
        }
        // What is refused to a participant is refused without a reason: it would name what is presented.
        let refused = pages.ask(&participant, r#""do":"answer","words":["S1"]"#);
        assert_eq!((refused.status, refused.body.as_str()), (422, ""));
        assert_eq!(pages.mark(&experimenter), before);
    });
}

#[test]
fn what_attackers_send_is_refused() {
    served(|pages| {
        let page = pages.experimenter();
        let cookie = ("cookie", page.cookie.as_str());
        // Another name for the same machine, as of a site that resolves to it.
        for host in ["evil.example", "127.0.0.1", "localhost:1", ""] {
            assert_eq!(
                pages
                    .send("GET", "/experimenter", &[("host", host), cookie], "")
                    .status,
                421,
                "{host}"
            );
        }
        // Posts of other sites are refused before a code is looked at.
        let form = ("content-type", "application/x-www-form-urlencoded");
        for origin in ["http://evil.example", "null", "https://127.0.0.1"] {
            for _ in 0..6 {
                let posted = pages.send("POST", "/enter", &[("origin", origin), form], "code=x");
                assert_eq!(
                    (posted.status, posted.body.as_str()),
                    (403, "from another site")
                );
            }
        }
        let own = format!("http://{}", pages.at);
        let code = format!("code={}", pages.viewer);
        let posted = pages.send("POST", "/enter", &[("origin", &own), form], &code);
        assert_eq!(posted.status, 303);
        let local = format!("localhost:{}", pages.at.port());
        assert_eq!(
            pages
                .send("GET", "/experimenter", &[("host", &local), cookie], "")
                .status,
            200
        );
        for path in [
            "/assets/../Cargo.toml",
            "/assets/%2e%2e/x",
            "/../../etc/passwd",
            "/assets/session.js/..",
            "//",
            "/study.sqlite",
        ] {
            let reply = pages.send("GET", path, &[cookie], "");
            assert_eq!(reply.status, 404, "{path}: {reply:?}");
        }
        let large = format!(
            r#"{{"id":"1","at":"x","do":"note","text":"{}"}}"#,
            "a".repeat(100_000)
        );
        let headers = [
            cookie,
            ("x-piezotact-mark", page.mark.as_str()),
            ("content-type", "application/json"),
        ];
        assert!([413, 0].contains(&pages.send("POST", "/ask", &headers, &large).status));
        for body in [
            "",
            "{",
            "[]",
            "null",
            r#"{"do":"check"}"#,
            r#"{"id":"1","at":"x","do":"erase"}"#,
            r#"{"id":1,"at":"x","do":"check"}"#,
            "\u{0}",
        ] {
            let found = pages.send("POST", "/ask", &headers, body).status;
            assert!([400, 422].contains(&found), "{body}: {found}");
        }
        // A mark that was there before entering counts for nothing, and another one is given.
        let fixed = "piezotact_experimenter=attackersattackersattackersattackers";
        let form = [
            ("cookie", fixed),
            ("content-type", "application/x-www-form-urlencoded"),
        ];
        let entered = pages.send(
            "POST",
            "/enter",
            &form,
            &format!("code={}", pages.experimenter),
        );
        assert_eq!(entered.status, 303);
        assert!(!entered.head.contains("attackers"));
        assert_eq!(
            pages
                .send("GET", "/experimenter", &[("cookie", fixed)], "")
                .status,
            303
        );
        // A pairing code is valid once.
        let _device = pages.participant(&page);
        let headers = [cookie, ("x-piezotact-mark", page.mark.as_str())];
        assert_eq!(pages.send("POST", "/pairing", &headers, "").status, 204);
        let code = pages.pairing_code(&page);
        let form = [("content-type", "application/x-www-form-urlencoded")];
        let enter = |code: &str| {
            pages
                .send("POST", "/enter", &form, &format!("code={code}"))
                .status
        };
        assert_eq!([enter(&code), enter(&code)], [303, 403]);
        // Codes cannot be tried out.
        let tried: Vec<u16> = (0..8).map(|i| enter(&format!("aaaaaaaaa{i}"))).collect();
        assert_eq!(
            tried.iter().filter(|status| **status == 403).count(),
            4,
            "{tried:?}"
        );
        assert_eq!(tried.last(), Some(&429));
        assert_eq!(
            pages.send("GET", "/experimenter", &[cookie], "").status,
            200,
            "who is in stays in"
        );
    });
}

/// A body that never comes holds nobody up, and is given up.
#[test]
fn a_slow_body_holds_nobody_up() {
    served(|pages| {
        let page = pages.experimenter();
        let mut slow: Vec<TcpStream> = (0..20)
            .map(|_| {
                let mut stream = TcpStream::connect(pages.at).unwrap();
                stream
                    .set_read_timeout(Some(Duration::from_secs(20)))
                    .unwrap();
                write!(
                    stream,
                    "POST /ask HTTP/1.1\r\nhost: {}\r\ncookie: {}\r\ncontent-length: 100\r\n\r\n{{",
                    pages.at, page.cookie
                )
                .unwrap();
                stream
            })
            .collect();
        assert_eq!(pages.ask(&page, r#""do":"consent""#).status, 204);
        let mut head = [0; 12];
        slow[0].read_exact(&mut head).unwrap();
        assert_eq!(&head[9..], b"408");
    });
}

/// The pages of the experimenter and of the participant on two screens of one machine, in one browser.
#[test]
fn one_browser_holds_both_pages() {
    served(|pages| {
        let experimenter = pages.experimenter();
        let participant = pages.participant(&experimenter);
        let device = participant.clone();
        let both = format!("{}; {}", participant.cookie, experimenter.cookie);
        let of = |page: &Page| Page {
            cookie: both.clone(),
            ..page.clone()
        };
        let (experimenter, participant) = (of(&experimenter), of(&participant));
        assert_eq!(pages.ask(&experimenter, r#""do":"consent""#).status, 204);
        // By its mark a request is the participant's.
        assert_eq!(pages.ask(&participant, r#""do":"check""#).status, 403);
        assert_eq!(pages.ask(&experimenter, r#""do":"check""#).status, 204);
        // A cookie under the name of another role is none.
        let renamed = device.cookie.replace("participant", "experimenter");
        let shown = pages.send("GET", "/experimenter", &[("cookie", &renamed)], "");
        assert_eq!(shown.status, 303);
    });
}

/// The status of an attempt to enter with a filled form, and what is said.
fn entering(pages: &Pages, filled: &str) -> (u16, String) {
    let form = [("content-type", "application/x-www-form-urlencoded")];
    let reply = pages.send("POST", "/enter", &form, filled);
    (reply.status, reply.head)
}

#[test]
fn on_a_network_the_experimenter_enters_with_the_password_alone() {
    on_network(|pages| {
        let (status, head) = entering(pages, &format!("password={PASSWORD}"));
        assert_eq!(status, 303);
        assert!(head.contains("; secure"), "{head}");
        for wrong in [
            format!("code={PASSWORD}"),
            "password=".to_owned(),
            format!("password={}", pages.viewer),
            format!("password={PASSWORD}x"),
        ] {
            assert_eq!(entering(pages, &wrong).0, 403, "{wrong}");
        }
        // Who looks on has a code, and no more tries than anybody else.
        assert_eq!(entering(pages, &format!("code={}", pages.viewer)).0, 303);
        for _ in 0..2 {
            assert_eq!(entering(pages, "password=x").0, 403);
        }
        assert_eq!(entering(pages, &format!("password={PASSWORD}")).0, 429);
        // Codes are counted by themselves.
        assert_eq!(entering(pages, &format!("code={}", pages.viewer)).0, 303);
    });
}

#[test]
fn what_is_not_encrypted_is_led_to_what_is() {
    on_network(|pages| {
        let mut plain = TcpStream::connect(pages.at).unwrap();
        plain
            .set_read_timeout(Some(Duration::from_secs(20)))
            .unwrap();
        // At once: the answer may come, and the connection end, after the first line.
        let asked = format!(
            "GET /experimenter HTTP/1.1\r\nhost: {}\r\ncookie: x=y\r\n\r\n",
            pages.at
        );
        plain.write_all(asked.as_bytes()).unwrap();
        let mut all = String::new();
        plain.read_to_string(&mut all).unwrap();
        assert!(all.starts_with("HTTP/1.1 307 "), "{all}");
        assert!(
            all.contains(&format!("location: https://{}/experimenter\r\n", pages.at)),
            "{all}"
        );
        // Whoever says nothing, or something else, keeps nobody out.
        let silent: Vec<TcpStream> = (0..60)
            .map(|i| {
                let mut stream = TcpStream::connect(pages.at).unwrap();
                if i % 2 == 0 {
                    stream.write_all(&[22, 3, 1, 255]).unwrap();
                }
                stream
            })
            .collect();
        let page = pages.experimenter();
        assert_eq!(pages.ask(&page, r#""do":"consent""#).status, 204);
        // A host that is not the name of these pages is refused also here.
        let cookie = ("cookie", page.cookie.as_str());
        let local = format!("localhost:{}", pages.at.port());
        for host in [local.as_str(), "evil.example"] {
            let reply = pages.send("GET", "/experimenter", &[("host", host), cookie], "");
            assert_eq!(reply.status, 421, "{host}");
        }
        // Stated twice, each may be read by another program on the way.
        let own = pages.at.to_string();
        let twice = [("host", own.as_str()), ("host", own.as_str()), cookie];
        let reply = pages.send("GET", "/experimenter", &twice, "");
        assert!([400, 421].contains(&reply.status), "{reply:?}");
        let plain = format!("http://{}", pages.at);
        let form = ("content-type", "application/x-www-form-urlencoded");
        let posted = pages.send("POST", "/enter", &[("origin", &plain), form], "code=x");
        assert_eq!(posted.status, 403);
        drop(silent);
    });
}

/// One address opens as many connections as it may, and says nothing.
#[test]
fn connections_that_say_nothing_are_closed() {
    served(|pages| {
        let page = pages.experimenter();
        let mut idle: Vec<TcpStream> = (0..200)
            .map(|_| TcpStream::connect(pages.at).unwrap())
            .collect();
        // The first ones are held as long as a request may take, later ones are closed at once.
        for stream in &idle {
            stream
                .set_read_timeout(Some(Duration::from_secs(30)))
                .unwrap();
        }
        let mut byte = [0];
        for stream in idle.iter_mut().rev() {
            assert!(matches!(stream.read(&mut byte), Ok(0) | Err(_)));
        }
        assert_eq!(pages.ask(&page, r#""do":"consent""#).status, 204);
    });
}
