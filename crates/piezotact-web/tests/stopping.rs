//! What plays ends at once when it is stopped, from any page, and when no page is there that could stop it.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::time::{Duration, Instant};

use piezotact_people::campaign::plan::Plan;
use piezotact_people::campaign::session::{Event, Stage};

use crate::client::{Page, Pages, with_pages};
use crate::session::{answers, step};
use crate::support::{Bed, isotropic, said};

/// Longer than any test waits.
const LONG: Duration = Duration::from_secs(60);

/// Goes on until textures are to be played, and begins to play them; `then` is done while they play. Gives how long the request to play
/// took from then on.
fn playing(bed: &mut Bed, then: impl FnOnce(&Pages, &Page, &Page) + Send) -> Duration {
    let (protocol, plan) = isotropic();
    let stop = bed.stop.clone();
    with_pages(bed, (&protocol, &plan), |pages| {
        let experimenter = pages.experimenter();
        let participant = pages.participant(&experimenter);
        let waits = |what| pages.shown(&experimenter).contains(what);
        for trial in 0.. {
            while !waits("Textures on the device") && step(pages, &experimenter) {}
            if waits("Textures on the device") {
                break;
            }
            answers(pages, &experimenter, trial);
        }
        std::thread::scope(|scope| {
            let plays = scope.spawn(|| pages.ask(&experimenter, r#""do":"present""#).status);
            while !stop.is_playing() {
                std::thread::sleep(Duration::from_millis(1));
            }
            let began = Instant::now();
            then(pages, &experimenter, &participant);
            assert_eq!(plays.join().unwrap(), 204);
            began.elapsed()
        })
    })
}

/// The last trial that was played, as its events tell it: the elements that began, and why it is void.
fn told(bed: &Bed, plan: &Plan) -> (usize, Vec<String>) {
    let events = bed.events(plan);
    let began = |event: &&Event| matches!(event, Event::PlayBegan { .. });
    let void = |event: &Event| match event {
        Event::Voided { why, .. } => Some(why.clone()),
        _ => None,
    };
    (
        events.iter().filter(began).count(),
        events.iter().filter_map(void).collect(),
    )
}

#[test]
fn a_texture_ends_at_once_from_any_page() {
    let (protocol, plan) = isotropic();
    for (what, by_participant, why, stage) in [
        (
            r#""do":"silence""#,
            false,
            "experimenter's page",
            Stage::Running,
        ),
        (
            r#""do":"pause""#,
            false,
            "experimenter's page",
            Stage::Paused,
        ),
        (
            r#""do":"pause""#,
            true,
            "the participant stopped it",
            Stage::Paused,
        ),
        (
            r#""do":"stop","why":"it hurts""#,
            false,
            "the session was stopped",
            Stage::Stopped,
        ),
        (
            r#""do":"withdraw""#,
            false,
            "the participant withdrew",
            Stage::Withdrawn,
        ),
    ] {
        let mut bed = Bed::new();
        bed.tape.lasts.set(LONG);
        let took = playing(&mut bed, |pages, experimenter, participant| {
            // Of another tab, which shows an earlier step, and twice.
            let page = if by_participant {
                participant
            } else {
                experimenter
            };
            let other = if by_participant {
                page.clone()
            } else {
                pages.experimenter()
            };
            // A second press finds that it is so.
            let again = if what.contains("silence") { 409 } else { 204 };
            for (page, id, found) in [(&other, "a", 204), (page, "b", again)] {
                let status = pages.ask_as(page, (id, "consent"), what).status;
                assert!(status == 204 || status == found, "{what}: {status}");
            }
        });
        assert!(took < LONG / 4, "{what}: {took:?}");
        let (began, void) = told(&bed, &plan);
        assert!(
            began == 1 && void.len() == 1 && void[0].contains(why),
            "{what}: {void:?}"
        );
        let events = bed.events(&plan).into_iter().enumerate();
        let events = events.map(|(i, event)| (i as i64, event));
        let state = piezotact_people::campaign::session::State::after(&protocol, &plan, events);
        let state = state.unwrap();
        assert_eq!(state.stage(), stage, "{what}: {:?}", said(&state));
        // What was heard in part counts as felt; the trial is to be presented again.
        let (_, of) = state.current().unwrap();
        assert_eq!(
            (of.attempts, of.voided, of.felt.as_slice()),
            (1, 1, &[1][..])
        );
    }
}

/// A stop that comes while the request to play waits for its turn is obeyed: nothing sounds. One that came before it was pressed is over.
#[test]
fn a_stop_before_the_first_sound_holds() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    let stop = bed.stop.clone();
    bed.volunteer((&protocol, &plan), |runner| {
        crate::support::until_presenting(runner, "task3");
        stop.stop("earlier");
        stop.plays_after(stop.asked());
        crate::support::done(runner, crate::support::present());
        let asked = stop.asked();
        assert!(!stop.stop("too soon"), "nothing is played");
        stop.plays_after(asked);
        let given = runner.give(crate::support::replay(0)).unwrap();
        let void = piezotact_study::session::Given::Void {
            why: "too soon".to_owned(),
        };
        assert_eq!(given, void);
    });
    assert_eq!(bed.tape.begun.borrow().len(), 3);
}

/// A note is no reason to stop: it is stored behind what plays.
#[test]
fn a_note_waits_for_the_texture() {
    let (_, plan) = isotropic();
    let mut bed = Bed::new();
    bed.tape.lasts.set(Duration::from_millis(300));
    playing(&mut bed, |pages, experimenter, _| {
        assert_eq!(
            pages
                .ask(experimenter, r#""do":"note","text":"quiet""#)
                .status,
            204
        );
    });
    let (began, void) = told(&bed, &plan);
    assert!(began == 3 && void.is_empty(), "{began} {void:?}");
    let last = bed.events(&plan).pop();
    assert!(matches!(last, Some(Event::Note { .. })), "{last:?}");
}

/// A page that was closed, hidden, or has lost the network answers no more.
#[test]
fn a_texture_that_nobody_could_stop_ends() {
    let (_, plan) = isotropic();
    let mut bed = Bed::new();
    bed.tape.lasts.set(LONG);
    let took = playing(&mut bed, |pages, experimenter, participant| {
        let beat = |page: &Page| pages.post(page, "/beat").status;
        // A participant's page stops it by a press alone.
        assert_eq!(beat(participant), 403);
        for _ in 0..9 {
            assert_eq!(beat(experimenter), 204);
            std::thread::sleep(Duration::from_millis(400));
        }
        let void = |page: &Page| pages.shown(page).contains("VOID");
        assert!(!void(experimenter), "it ended while a page answered");
    });
    assert!(took < LONG / 4, "{took:?}");
    let (_, void) = told(&bed, &plan);
    assert!(
        void.len() == 1 && void[0].contains("no page of the experimenter"),
        "{void:?}"
    );
}
