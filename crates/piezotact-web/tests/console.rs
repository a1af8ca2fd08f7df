//! The console of a bench: who may start what, and which files are given.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use crate::client::{Page, Pages, with_console};

fn ask(pages: &Pages, page: &Page, body: &str) -> (u16, String) {
    let headers = [
        ("cookie", page.cookie.as_str()),
        ("x-piezotact-mark", &page.mark),
        ("content-type", "application/json"),
    ];
    let reply = pages.send("POST", "/console/ask", &headers, body);
    (reply.status, reply.body)
}

#[test]
fn procedures_are_started_by_the_experimenter_alone() {
    with_console(|pages| {
        let (experimenter, viewer) = (pages.experimenter(), pages.enter(&pages.viewer));
        let start = r#"{"do":"start","procedure":"play","values":{}}"#;
        assert_eq!(ask(pages, &viewer, start).0, 403);
        assert_eq!(ask(pages, &experimenter, start).0, 204);
        let (status, why) = ask(pages, &experimenter, r#"{"do":"stop"}"#);
        assert_eq!((status, why.as_str()), (422, "nothing runs"));
        for wrong in [
            "",
            "{}",
            "[]",
            r#"{"do":"erase"}"#,
            r#"{"do":"start","procedure":1,"values":{}}"#,
        ] {
            let (status, _) = ask(pages, &experimenter, wrong);
            assert!([400, 422].contains(&status), "{wrong}: {status}");
        }
        let shown = pages.shown(&viewer);
        assert!(!shown.contains("data-procedure") && !shown.contains("id=\"stop\""));
        assert!(
            pages
                .shown(&experimenter)
                .contains("data-procedure=\"play\"")
        );
    });
}

#[test]
fn files_that_were_made_are_given_and_no_others() {
    with_console(|pages| {
        let page = pages.experimenter();
        let cookie = [("cookie", page.cookie.as_str())];
        let get = |name: &str| pages.send("GET", &format!("/console/files/{name}"), &cookie, "");
        assert_eq!(get("play-1.html").status, 404, "nothing was made yet");
        assert_eq!(
            ask(
                pages,
                &page,
                r#"{"do":"start","procedure":"play","values":{}}"#
            )
            .0,
            204
        );
        let report = get("play-1.html");
        assert_eq!(report.status, 200);
        assert!(
            report.head.contains("default-src 'none'"),
            "{}",
            report.head
        );
        let recording = get("play-1.parquet");
        assert!(
            recording
                .head
                .contains("attachment; filename=\"play-1.parquet\""),
            "{}",
            recording.head
        );
        for name in [
            "pages.json",
            "..%2Fpages.json",
            "%2Fetc%2Fpasswd",
            "play-1.html%00",
            "play-1.html/",
        ] {
            let found = get(name).status;
            assert!([400, 404].contains(&found), "{name}: {found}");
        }
    });
}
