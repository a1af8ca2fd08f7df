//! What pages show and take: the participant's language, one press for an answer, drafts, places, and nothing that tells what is played.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::time::{Duration, Instant};

use piezotact_people::campaign::plan::Plan;
use piezotact_people::campaign::protocol::{Protocol, TaskKind};
use piezotact_people::campaign::session::{Command, Event, Participant, State};
use piezotact_people::campaign::store::Purpose;
use piezotact_web::{Language, OpenStep, PlayedBy, View, Word};

use crate::client::{Page, Pages, with_pages};
use crate::session::{answers, step};
use crate::support::{Bed, isotropic, planned};

/// The comparison protocol with so short a pause that a test can wait for it.
fn compared() -> (Protocol, Plan) {
    let (mut protocol, plan) = planned("roughness_jnd", "discrimination");
    for task in &mut protocol.tasks {
        if let TaskKind::Compare { next_after_s, .. } = &mut task.kind {
            assert!(next_after_s.is_some(), "the library states the pause");
            *next_after_s = Some(0.5);
        }
    }
    (protocol, plan)
}

/// The mark by which `page` keeps what is chosen and not sent.
fn draft_mark(pages: &Pages, page: &Page) -> String {
    let shown = pages.shown(page);
    let (_, at) = shown.split_once("data-draft=\"").unwrap();
    at.split('"').next().unwrap().to_owned()
}

/// Waits until `page` shows `what`.
fn waits(pages: &Pages, page: &Page, what: &str) -> String {
    let began = Instant::now();
    loop {
        let shown = pages.shown(page);
        if shown.contains(what) {
            return shown;
        }
        assert!(began.elapsed() < Duration::from_secs(5), "{what}: {shown}");
        std::thread::sleep(Duration::from_millis(10));
    }
}

/// The first answer is final when it is pressed; the next trial begins by itself, but not after a pause, a stop, or where nobody could
/// stop it.
#[test]
fn a_comparison_is_one_press_and_the_next_begins_by_itself() {
    let (protocol, plan) = compared();
    let mut bed = Bed::new();
    with_pages(&mut bed, (&protocol, &plan), |pages| {
        let experimenter = pages.experimenter();
        let participant = pages.participant(&experimenter);
        let here = pages.follow(&participant);
        let beats = || assert_eq!(pages.post(&experimenter, "/beat").status, 204);
        while step(pages, &experimenter) {}
        let press = |word: &str| {
            let answer = format!(r#""do":"answer","words":["{word}"]"#);
            assert_eq!(pages.ask(&participant, &answer).status, 204);
        };
        let shown = pages.shown(&participant);
        assert!(
            shown.contains("data-final") && !shown.contains("data-slot"),
            "{shown}"
        );
        press("first");
        // The right answer to a training trial, for both; then the next pair, without a press.
        let shown = pages.shown(&participant);
        assert!(shown.contains("The right answer was"), "{shown}");
        assert!(shown.contains("begins by itself"), "{shown}");
        beats();
        waits(pages, &participant, "data-final");
        press("second");
        // A pause holds it up, and so it stays afterwards.
        beats();
        assert_eq!(pages.ask(&participant, r#""do":"pause""#).status, 204);
        std::thread::sleep(Duration::from_millis(700));
        assert!(!pages.shown(&participant).contains("data-final"));
        assert_eq!(pages.ask(&experimenter, r#""do":"go_on""#).status, 204);
        std::thread::sleep(Duration::from_millis(700));
        assert!(!pages.shown(&participant).contains("data-final"));
        assert!(step(pages, &experimenter));
        press("first");
        // The participant's page is closed: the experimenter begins by hand.
        drop(here);
        let away = "The participant's page is not open";
        waits(pages, &experimenter, away);
        beats();
        std::thread::sleep(Duration::from_millis(900));
        assert!(!pages.shown(&participant).contains("data-final"));
        assert!(pages.shown(&experimenter).contains(away));
        assert!(step(pages, &experimenter));
        let _here = pages.follow(&participant);
        while pages.shown(&experimenter).contains(away) {
            std::thread::sleep(Duration::from_millis(10));
        }
        std::thread::sleep(Duration::from_millis(200));
        press("second");
        // No page of the experimenter answers any more, though its connection may be open: nothing begins.
        let _open = pages.follow(&experimenter);
        std::thread::sleep(Duration::from_millis(900));
        assert!(!pages.shown(&participant).contains("data-final"));
        // Neither page names a texture.
        for page in [&experimenter, &participant] {
            assert!(!pages.shown(page).contains("increment"));
        }
    });
    let events = bed.events(&plan).into_iter();
    let confirmed = events.filter(|event| matches!(event, Event::Confirmed { .. }));
    assert_eq!(confirmed.count(), 4);
}

/// What is chosen and not sent is shown to the experimenter at this step alone, and is no answer.
#[test]
fn the_experimenter_sees_the_draft() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    with_pages(&mut bed, (&protocol, &plan), |pages| {
        let experimenter = pages.experimenter();
        let participant = pages.participant(&experimenter);
        while step(pages, &experimenter) {}
        let at = draft_mark(pages, &participant);
        let draft_of = |at: &str, page: &Page, words: &str| {
            let body = format!(r#"{{"at":"{at}","words":{words}}}"#);
            let headers = [
                ("cookie", page.cookie.as_str()),
                ("x-piezotact-mark", page.mark.as_str()),
                ("content-type", "application/json"),
            ];
            pages.send("POST", "/draft", &headers, &body).status
        };
        let draft = |at: &str, page: &Page| draft_of(at, page, r#"["C","A"]"#);
        assert_eq!(draft(&at, &participant), 204);
        assert!(pages.shown(&experimenter).contains("<b>C, A</b>"));
        // What is no choice does not stand on the experimenter's page.
        assert_eq!(draft_of(&at, &participant, r#"["C","<b>x</b>"]"#), 409);
        assert_eq!(draft(&at, &experimenter), 403);
        answers(pages, &participant, 0);
        assert!(!pages.shown(&experimenter).contains("<b>C, A</b>"));
        assert_eq!(draft("another step", &participant), 409);
        assert!(!pages.shown(&experimenter).contains("<b>C, A</b>"));
    });
}

/// What is chosen and not sent stays while a texture is felt once more: a page keeps its draft by this mark.
#[test]
fn a_draft_outlives_a_texture_that_is_felt_once_more() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    with_pages(&mut bed, (&protocol, &plan), |pages| {
        let experimenter = pages.experimenter();
        let plays = || pages.shown(&experimenter).contains("Once more");
        for trial in 0.. {
            while step(pages, &experimenter) {}
            if plays() {
                break;
            }
            answers(pages, &experimenter, trial);
        }
        let participant = pages.participant(&experimenter);
        let marks = || (draft_mark(pages, &participant), pages.mark(&participant));
        let (draft, mark) = marks();
        let again = r#""do":"play","element":2"#;
        assert_eq!(pages.ask(&experimenter, again).status, 204);
        let (same, other) = marks();
        assert_eq!(same, draft);
        assert_ne!(other, mark, "what is asked at the step before is late");
        answers(pages, &participant, 0);
        while step(pages, &experimenter) {}
        assert_ne!(marks().0, draft);
    });
}

/// Places on the tray are letters, ranks are numbers; "I do not know" is there where the protocol allows it, and only there.
#[test]
fn places_are_letters_and_not_knowing_is_an_answer_where_it_may_be() {
    let (mut protocol, plan) = isotropic();
    for may_not_know in [false, true] {
        let tasks = protocol.tasks.iter_mut();
        tasks.for_each(|task| task.may_not_know = may_not_know);
        let mut bed = Bed::new();
        with_pages(&mut bed, (&protocol, &plan), |pages| {
            let experimenter = pages.experimenter();
            let participant = pages.participant(&experimenter);
            while step(pages, &experimenter) {}
            let shown = pages.shown(&participant);
            assert!(shown.contains(r#"data-choice="A""#) && !shown.contains(r#"data-choice="1""#));
            assert_eq!(shown.contains("I do not know"), may_not_know);
            let unknown = pages
                .ask(&participant, r#""do":"answer","words":["?"]"#)
                .status;
            assert_eq!(unknown, if may_not_know { 204 } else { 422 });
            if may_not_know {
                assert!(pages.shown(&experimenter).contains("<b>I do not know</b>"));
            }
        });
    }
}

/// The participant reads the own language, and consents by a press of the own.
#[test]
fn the_participant_reads_and_consents_in_the_own_language() {
    let (protocol, plan) = planned("touch_control_imagery", "touch");
    let mut state = State::new(&protocol, &plan);
    let begin = Command::Begin {
        experimenter: "EX".into(),
        program: "test".into(),
        purpose: Purpose::Volunteer,
        participant: Participant {
            language: Some("fr-CH".into()),
            ..Participant::default()
        },
    };
    state.apply(0, &state.decide(&begin).unwrap()).unwrap();
    let text = "[en]\nI take part.\n[fr]\nJe participe.\n";
    let view = View::of(&state, Some(text), PlayedBy::Bench);
    assert_eq!(
        view.open.step,
        OpenStep::Consent(Some("Je participe.".into()))
    );
    // On a page: it is asked in the second person, and the press counts.
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    with_pages(&mut bed, (&protocol, &plan), |pages| {
        let experimenter = pages.experimenter();
        let participant = pages.participant(&experimenter);
        assert!(
            pages
                .shown(&experimenter)
                .contains("Does the participant consent?")
        );
        assert_eq!(pages.ask(&participant, r#""do":"consent""#).status, 204);
        assert!(
            !pages
                .shown(&experimenter)
                .contains("Does the participant consent?")
        );
    });
    assert!(
        bed.events(&plan)
            .iter()
            .any(|event| matches!(event, Event::ConsentGiven { .. }))
    );
    assert_eq!(
        Word::Training.in_language(Language::French),
        "familiarisation"
    );
}
