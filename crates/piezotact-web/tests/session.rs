//! A session over the pages: each answer once, what participants are sent, and pages that come late or hang.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact_people::campaign::plan::{AnswerForm, Plan, Presented};
use piezotact_people::campaign::session::{Answer, Event};

use crate::client::{Page, Pages, with_pages, with_pages_after};
use crate::support::{Bed, isotropic, planned};

/// Takes the session on by one step, as the pages show it; false where the participant can answer.
pub(crate) fn step(pages: &Pages, experimenter: &Page) -> bool {
    let shown = pages.shown(experimenter);
    let (_, step) = shown.split_once("class=\"step\"").unwrap();
    for (words, what) in [
        ("&quot;consent&quot;", r#""do":"consent""#),
        ("&quot;check&quot;", r#""do":"check""#),
        ("&quot;present&quot;", r#""do":"present""#),
    ] {
        if step.contains(words) {
            let reply = pages.ask(experimenter, what);
            assert_eq!(reply.status, 204, "{what}: {reply:?}");
            return true;
        }
    }
    false
}

/// The choices that a page shows, and how many are wanted.
fn draft(shown: &str) -> (Vec<String>, usize, bool) {
    let (_, draft) = shown.split_once("data-most=\"").unwrap();
    let most = draft.split('"').next().unwrap().parse().unwrap();
    let choices = draft.split("data-choice=\"").skip(1);
    let choices = choices.map(|rest| rest.split('"').next().unwrap().to_owned());
    (
        choices.collect(),
        most,
        draft.contains("data-choose=\"once\""),
    )
}

/// Answers the current trial with the choices in turn from number `from`, and confirms.
pub(crate) fn answers(pages: &Pages, page: &Page, from: usize) {
    let (choices, most, once) = draft(&pages.shown(page));
    let shift = if once { 0 } else { from };
    let words: Vec<String> = (0..most)
        .map(|i| format!("\"{}\"", choices[(i + shift) % choices.len()]))
        .collect();
    let answer = format!(r#""do":"answer","words":[{}]"#, words.join(","));
    assert_eq!(pages.ask(page, &answer).status, 204, "{answer}");
    assert_eq!(pages.ask(page, r#""do":"confirm""#).status, 204);
}

/// A session with `trials` answers of the participant; what the participant's page was sent.
fn session(plan: &Plan, trials: usize) -> (Vec<String>, Bed) {
    let (protocol, _) = isotropic();
    let mut bed = Bed::new();
    let sent = with_pages(&mut bed, (&protocol, plan), |pages| {
        let experimenter = pages.experimenter();
        let participant = pages.participant(&experimenter);
        let mut sent = vec![pages.shown(&participant).replace(&participant.mark, "")];
        for trial in 0..trials {
            while step(pages, &experimenter) {
                sent.push(pages.shown(&participant).replace(&participant.mark, ""));
            }
            sent.push(pages.shown(&participant).replace(&participant.mark, ""));
            answers(pages, &participant, trial);
            sent.push(pages.shown(&participant).replace(&participant.mark, ""));
        }
        sent
    });
    (sent, bed)
}

/// Other textures, another tray, other participants and seeds: the participant is sent the same, byte for byte.
#[test]
fn what_is_hidden_reaches_no_participant() {
    let (_, plan) = isotropic();
    let mut other = plan.clone();
    other.seed = 99;
    "P77".clone_into(&mut other.participant);
    for trial in &mut other.trials {
        match &mut trial.presented {
            Presented::Tray { samples } => samples.reverse(),
            Presented::Rendered { stimuli } => stimuli.rotate_left(1),
            Presented::Sample { .. } | Presented::Chosen { .. } => {}
        }
    }
    assert_ne!(plan.trials, other.trials);
    let trials = 7;
    let (first, bed) = session(&plan, trials);
    let (second, _) = session(&other, trials);
    assert!(first.len() > 2 * trials);
    assert_eq!(first, second);
    // It would be found: the experimenter's own events differ.
    let presented = bed.events(&plan).into_iter();
    let presented = presented.filter(|event| matches!(event, Event::Presented { .. }));
    assert_eq!(presented.count(), trials);
    for page in &first {
        for hidden in ["P01", "S10", "discrimination", "triplets"] {
            assert!(!page.contains(hidden), "{hidden}: {page}");
        }
    }
}

/// How the samples of the tray are turned stands beside them, for the experimenter alone.
#[test]
fn the_tray_shows_how_samples_are_turned() {
    let (mut protocol, plan) = isotropic();
    let turned = protocol.samples.iter().enumerate();
    let turned = turned.map(|(i, sample)| (sample.clone(), format!("notch at {i}")));
    protocol.orientation = turned.collect();
    let mut bed = Bed::new();
    with_pages(&mut bed, (&protocol, &plan), |pages| {
        let experimenter = pages.experimenter();
        let participant = pages.participant(&experimenter);
        while !pages.shown(&experimenter).contains("notch at") {
            assert!(step(pages, &experimenter), "no tray before an answer");
        }
        let shown = pages.shown(&experimenter);
        for (sample, turned) in &protocol.orientation {
            let beside = format!("{sample} <span class=\"soft\">({turned})");
            assert_eq!(shown.matches(&beside).count(), 1, "{beside}: {shown}");
        }
        assert!(!pages.shown(&participant).contains("notch at"));
    });
}

/// What is pressed twice, sent again, or comes late, is stored once.
#[test]
fn each_request_is_stored_once() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    with_pages(&mut bed, (&protocol, &plan), |pages| {
        let page = pages.experimenter();
        let at = pages.mark(&page);
        let consent = r#""do":"consent""#;
        assert_eq!(pages.ask_as(&page, ("a", &at), consent).status, 204);
        // Sent again, as its acknowledgement was lost.
        assert_eq!(pages.ask_as(&page, ("a", &at), consent).status, 204);
        // A second press, and a page that shows an earlier step.
        assert_eq!(pages.ask_as(&page, ("b", &at), consent).status, 409);
        let other = pages.experimenter();
        assert_eq!(
            pages.ask_as(&other, ("a", &at), consent).status,
            409,
            "ids of pages are their own"
        );
        // A note fits any step, and is kept once for each id.
        for id in ["n", "n", "m"] {
            assert_eq!(
                pages
                    .ask_as(&page, (id, &at), r#""do":"note","text":"quiet""#)
                    .status,
                204
            );
        }
        // Two experimenters at once: one of them does it.
        let at = pages.mark(&page);
        let both: Vec<u16> = std::thread::scope(|scope| {
            let ask = |page: Page, at: String| {
                move || pages.ask_as(&page, ("c", &at), r#""do":"check""#).status
            };
            let threads =
                [page.clone(), other.clone()].map(|page| scope.spawn(ask(page, at.clone())));
            threads.map(|thread| thread.join().unwrap()).to_vec()
        });
        assert!(both == [204, 409] || both == [409, 204], "{both:?}");
    });
    let events = bed.events(&plan);
    let count = |is: fn(&Event) -> bool| events.iter().filter(|event| is(event)).count();
    assert_eq!(
        count(|event| matches!(event, Event::ConsentGiven { .. })),
        1
    );
    assert_eq!(count(|event| matches!(event, Event::Note { .. })), 2);
    assert_eq!(count(|event| matches!(event, Event::Checked { .. })), 1);
}

/// A full disk: the page is told, keeps its answer, and sends it again.
#[test]
fn what_cannot_be_stored_is_said_and_can_be_sent_again() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    bed.volunteer((&protocol, &plan), |runner| {
        let command = crate::support::next(runner.state()).unwrap();
        runner.give(command).unwrap();
    });
    let key_events = bed.events(&plan).len();
    with_pages_after(
        &mut bed,
        (&protocol, &plan),
        |store| store.set(3),
        |pages| {
            let page = pages.experimenter();
            let at = pages.mark(&page);
            let consent = r#""do":"consent""#;
            let found: Vec<u16> = (0..4)
                .map(|_| pages.ask_as(&page, ("a", &at), consent).status)
                .collect();
            assert_eq!(found, [507, 507, 507, 204]);
            let said = pages.ask_as(&page, ("a", &at), consent);
            assert_eq!(said.status, 204);
        },
    );
    let events = bed.events(&plan);
    // Resumed, and consent once.
    assert_eq!(events.len(), key_events + 2);
}

/// A page that is opened late has the whole state, one that hangs slows nothing, and a stream ends with the program.
#[test]
fn pages_follow_hang_and_come_late() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    let mut last = with_pages(&mut bed, (&protocol, &plan), |pages| {
        let experimenter = pages.experimenter();
        let hanging: Vec<_> = (0..30).map(|_| pages.follow(&experimenter)).collect();
        let mut early = pages.follow(&experimenter);
        assert!(early.step().unwrap().contains("consent"));
        while step(pages, &experimenter) {}
        for i in 0..40 {
            let note = format!(r#""do":"note","text":"note {i}""#);
            assert_eq!(pages.ask(&experimenter, &note).status, 204);
        }
        assert!(early.until("note: note 39").len() > 3);
        let mut late = pages.follow(&experimenter);
        let whole = late.step().unwrap();
        assert!(
            whole.contains("note: note 39") && whole.contains("data-draft"),
            "{whole}"
        );
        assert!(
            whole.contains("33 experimenter pages are open")
                || whole.contains("32 experimenter pages are open"),
            "{whole}"
        );
        drop(hanging);
        late
    });
    while last.step().is_some() {}
}

/// A second device of the participant takes the place of the first, whose stream ends.
#[test]
fn the_last_device_of_a_participant_counts() {
    let (protocol, plan) = isotropic();
    with_pages(&mut Bed::new(), (&protocol, &plan), |pages| {
        let experimenter = pages.experimenter();
        let first = pages.participant(&experimenter);
        let mut stream = pages.follow(&first);
        assert!(stream.step().is_some());
        let second = pages.participant(&experimenter);
        assert!(stream.step().is_none());
        assert_eq!(
            pages
                .send("GET", "/participant", &[("cookie", &first.cookie)], "")
                .status,
            303
        );
        while step(pages, &experimenter) {}
        // In a pause nothing is answered.
        assert_eq!(pages.ask(&experimenter, r#""do":"pause""#).status, 204);
        assert_eq!(
            pages.ask(&second, r#""do":"answer","words":["1"]"#).status,
            422
        );
        assert_eq!(pages.ask(&experimenter, r#""do":"go_on""#).status, 204);
        answers(pages, &second, 0);
    });
}

/// A note whose acknowledgement was lost with the program is sent again to the next one, and is there once; another one like it is kept.
#[test]
fn what_fits_any_step_is_stored_once_over_restarts() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    let note = r#""seen":2,"do":"note","text":"quiet""#;
    for _ in 0..2 {
        with_pages(&mut bed, (&protocol, &plan), |pages| {
            let page = pages.experimenter();
            if pages.mark(&page).starts_with("consent") {
                assert_eq!(pages.ask(&page, r#""do":"consent""#).status, 204);
            }
            let at = pages.mark(&page);
            // The same id of the same page: another cookie is another page, as after a restart nothing is known by it.
            assert_eq!(pages.ask_as(&page, ("a", &at), note).status, 204);
        });
    }
    let count = |bed: &Bed| {
        let events = bed.events(&plan).into_iter();
        events
            .filter(|event| matches!(event, Event::Note { .. }))
            .count()
    };
    assert_eq!(count(&bed), 1);
    with_pages(&mut bed, (&protocol, &plan), |pages| {
        let page = pages.experimenter();
        let at = pages.mark(&page);
        let later = format!(r#""seen":{},"do":"note","text":"quiet""#, 4);
        assert_eq!(pages.ask_as(&page, ("b", &at), &later).status, 204);
        // One id for two requests.
        assert_eq!(
            pages
                .ask_as(&page, ("b", &at), r#""do":"note","text":"loud""#)
                .status,
            422
        );
        assert_eq!(
            pages
                .ask_as(&page, ("c", &at), r#""do":"note","text":" ""#)
                .status,
            422
        );
    });
    assert_eq!(count(&bed), 2);
}

/// Nothing is played where nothing is played.
#[test]
fn a_participant_plays_what_is_played_only() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    with_pages(&mut bed, (&protocol, &plan), |pages| {
        let experimenter = pages.experimenter();
        let participant = pages.participant(&experimenter);
        while step(pages, &experimenter) {}
        let play = r#""do":"play","element":1"#;
        assert_eq!(pages.ask(&participant, play).status, 422);
        for trial in 0..4 {
            while step(pages, &experimenter) {}
            answers(pages, &experimenter, trial);
        }
        while step(pages, &experimenter) {}
        assert_eq!(pages.ask(&participant, play).status, 204);
        assert!(pages.shown(&participant).contains("felt 2×"));
    });
}

/// Keys are values: the buttons of a rating have none of their own, and of a wide scale a number is typed.
#[test]
fn ratings_are_numbers() {
    let (protocol, mut plan) = isotropic();
    for (trial, to) in plan.trials.iter_mut().zip([10, 1000]) {
        trial.answer = AnswerForm::Scale { from: 0, to };
    }
    let mut bed = Bed::new();
    with_pages(&mut bed, (&protocol, &plan), |pages| {
        let page = pages.experimenter();
        let shown = || {
            while step(pages, &page) {}
            let shown = pages.shown(&page);
            let (_, draft) = shown.split_once("data-most=").unwrap();
            draft.split_once("data-undo").unwrap().0.to_owned()
        };
        let few = shown();
        assert!(
            few.contains("0 – 10") && few.contains("data-numbers"),
            "{few}"
        );
        assert_eq!(few.matches("data-choice=").count(), 11, "{few}");
        assert!(!few.contains("data-key"), "{few}");
        let said = |what: &str, status| {
            let answer = format!(r#""do":"answer","words":["{what}"]"#);
            assert_eq!(pages.ask(&page, &answer).status, status, "{what}");
        };
        said("11", 422);
        said("10", 204);
        assert_eq!(pages.ask(&page, r#""do":"confirm""#).status, 204);
        let wide = shown();
        assert!(
            wide.contains("data-to=\"1000\"") && !wide.contains("data-choice"),
            "{wide}"
        );
        said("1001", 422);
        said("750", 204);
    });
    let answers = bed
        .events(&plan)
        .into_iter()
        .filter_map(|event| match event {
            Event::Answered { answer, .. } => Some(answer),
            _ => None,
        });
    let expected = [Answer::Number(10), Answer::Number(750)];
    assert_eq!(answers.collect::<Vec<_>>(), expected);
}

/// A bench that fails while a texture plays: the trial is void, which the page says, and is presented again.
#[test]
fn a_bench_that_fails_voids_the_trial() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    let fails = std::rc::Rc::clone(&bed.tape.fails_after);
    fails.set(Some(1));
    with_pages(&mut bed, (&protocol, &plan), |pages| {
        let page = pages.experimenter();
        for trial in 0..4 {
            while step(pages, &page) {}
            answers(pages, &page, trial);
        }
        // Task 3: the second of its textures is not played to its end.
        while !pages.shown(&page).contains("THE TRIAL IS VOID") {
            assert!(step(pages, &page));
        }
        let shown = pages.shown(&page);
        assert!(
            shown.contains("the cable came off") && shown.contains("#2"),
            "{shown}"
        );
        while step(pages, &page) {}
        let shown = pages.shown(&page);
        assert!(!shown.contains("VOID") && shown.contains("data-draft"));
        assert!(shown.contains("target met"), "{shown}");
        answers(pages, &page, 0);
    });
    let voided = bed.events(&plan).into_iter();
    let voided = voided.filter(|event| matches!(event, Event::Voided { .. }));
    assert_eq!(voided.count(), 1);
}

/// A press of "done" with strokes missing says how many were found, on both pages; it is taken the second time, which is no double click.
#[test]
fn missing_strokes_of_a_touch_are_shown() {
    let (protocol, plan) = planned("isotropic_triplets", "measurement");
    let mut bed = Bed::new();
    let strokes = std::rc::Rc::clone(&bed.tape.strokes);
    strokes.set(Some(7));
    with_pages(&mut bed, (&protocol, &plan), |pages| {
        let experimenter = pages.experimenter();
        let participant = pages.participant(&experimenter);
        while step(pages, &experimenter) {}
        // The time of the strokes passes, too: a second with each look at the clock.
        let confirms = || pages.ask(&participant, r#""do":"confirm""#).status;
        let tries = (0..20).take_while(|_| {
            let status = confirms();
            assert_eq!(status, 422);
            !pages.shown(&experimenter).contains("NOT COMPLETE")
        });
        assert!(tries.count() < 20);
        for page in [&experimenter, &participant] {
            let shown = pages.shown(page);
            assert!(shown.contains("NOT COMPLETE"), "{shown}");
            assert!(shown.contains("7 / 10"), "{shown}");
        }
        assert_eq!(confirms(), 422, "the second click of a double click");
        std::thread::sleep(std::time::Duration::from_millis(1100));
        assert_eq!(confirms(), 204);
        let shown = pages.shown(&experimenter);
        // Behind it, it still stands there, for who was too quick.
        assert!(
            shown.contains("7 / 10") && shown.contains("Trial 2 of 14"),
            "{shown}"
        );
    });
    let touched = bed.events(&plan).into_iter().find_map(|event| match event {
        Event::Confirmed { touched, .. } => touched,
        _ => None,
    });
    assert_eq!(touched.unwrap().strokes, Some(7));
}
