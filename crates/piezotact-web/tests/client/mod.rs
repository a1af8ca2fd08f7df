//! Pages that are served for a test.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::cell::Cell;
use std::net::TcpListener;
use std::rc::Rc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use piezotact_people::campaign::plan::Plan;
use piezotact_people::campaign::protocol::Protocol;
use piezotact_people::campaign::store::Purpose;
use piezotact_web::{Access, PlayedBy, Role, Screen, Site, StudyPages, View};

use crate::support::{Bed, Place, next};

mod http;

pub(crate) use http::{Page, Pages};

/// A study without answers.
struct Nothing;

impl StudyPages for Nothing {
    fn matrix(&self) -> Result<String, String> {
        Ok("<!DOCTYPE html><title>matrix</title>".to_owned())
    }

    fn answers(&self) -> Result<String, String> {
        Err("there are no answers yet".to_owned())
    }
}

/// Serves the session of `plan` in `bed` while `act` uses its pages.
pub(crate) fn with_pages<T: Send>(
    bed: &mut Bed,
    of: (&Protocol, &Plan),
    act: impl FnOnce(&Pages) -> T + Send,
) -> T {
    with_pages_after(bed, of, |_| {}, act)
}

/// As [`with_pages`]; `before` has the number of events that the store refuses next, once the session is taken up.
pub(crate) fn with_pages_after<T: Send>(
    bed: &mut Bed,
    of: (&Protocol, &Plan),
    before: impl FnOnce(&Cell<usize>),
    act: impl FnOnce(&Pages) -> T + Send,
) -> T {
    let refusals = Rc::clone(&bed.store.refusals);
    let served = |runner: &mut piezotact_session::Runner<'_>| {
        let first = match runner.state().events() {
            0 => next(runner.state()),
            _ => Some(piezotact_people::campaign::session::Command::Resume {
                experimenter: "EX".into(),
                now_ms: runner.now_ms(),
            }),
        };
        runner.give(first.unwrap()).unwrap();
        before(&refusals);
        let access = Access::new("P01", None, Box::new(|_| Ok(()))).unwrap();
        let code = |role| access.code(role).unwrap();
        let (experimenter, viewer) = (code(Role::Experimenter), code(Role::Viewer));
        let view = View::of(runner.state(), None, PlayedBy::Bench);
        let (site, mut desk) = Site::new(
            (view, runner.events().unwrap()),
            None,
            PlayedBy::Bench,
            access,
            Box::new(Nothing),
        );
        Screen::default().shows(&desk);
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let pages = Pages {
            at: listener.local_addr().unwrap(),
            experimenter,
            viewer,
        };
        let served = site.serve(listener).unwrap();
        let is_over = AtomicBool::new(false);
        std::thread::scope(|scope| {
            let acting = scope.spawn(|| {
                let _ends = Ends(&is_over);
                act(&pages)
            });
            desk.run(runner, &|| is_over.load(Ordering::SeqCst))
                .unwrap();
            let began = std::time::Instant::now();
            drop(served);
            assert!(
                began.elapsed() < Duration::from_secs(2),
                "the pages do not end"
            );
            acting.join().unwrap()
        })
    };
    bed.open(of, Purpose::Volunteer, Place::Tape, served)
        .unwrap()
}

/// Ends the desk also where a test fails.
struct Ends<'a>(&'a AtomicBool);

impl Drop for Ends<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::SeqCst);
    }
}
