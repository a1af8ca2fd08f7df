//! Stores and devices that fail.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::collections::BTreeSet;
use std::rc::Rc;

use piezotact_people::campaign::session::{Command, Event, Step};
use piezotact_people::campaign::store::StoreError;
use piezotact_study::session::{Given, RunError};

use crate::support::{
    Bed, current, done, isotropic, next, present, replay, said, until_presenting,
};

#[test]
fn a_command_that_is_not_stored_changes_nothing_and_works_when_it_is_given_again() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    let (refusals, saltless) = (Rc::clone(&bed.store.refusals), Rc::clone(&bed.saltless));
    let begun = Rc::clone(&bed.tape.begun);
    let mut given = 0;
    bed.volunteer((&protocol, &plan), |runner| {
        while let Some(command) = next(runner.state()) {
            let was = said(runner.state()).but_begun();
            for _ in 0..2 {
                refusals.set(1);
                let refused = runner.give(command.clone());
                assert!(
                    matches!(refused, Err(RunError::Store(StoreError::Place { .. }))),
                    "{command:?}: {refused:?}"
                );
                assert_eq!(said(runner.state()).but_begun(), was, "{command:?}");
            }
            saltless.set(true);
            let refused = runner.give(command.clone());
            assert!(matches!(refused, Err(RunError::Salt(_))), "{refused:?}");
            assert_eq!(said(runner.state()).but_begun(), was);
            saltless.set(false);
            done(runner, command);
            given += 1;
            // Once more is another command, and refused or another event. That a texture begins is an event of its own.
            assert_eq!(runner.state().events(), given + begun.borrow().len() as u64);
        }
        let state = runner.state();
        assert_eq!(state.confirmed(), plan.trials.len());
        assert!(state.trials().all(|(_, of)| of.attempts == 1));
    });
    assert_eq!(
        bed.events(&plan).len() as u64,
        given + begun.borrow().len() as u64
    );
    // Each stimulus was felt once, although it was commanded four times.
    let begun = bed.tape.begun.borrow();
    let names: BTreeSet<&String> = begun.iter().collect();
    assert_eq!(names.len(), begun.len());
    let evidence = bed.events(&plan).into_iter().map(|event| match event {
        Event::Presented { evidence, .. } => evidence.len(),
        _ => 0,
    });
    assert_eq!(begun.len(), evidence.sum::<usize>());
}

#[test]
fn what_was_played_is_stored_before_what_follows() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    let refusals = Rc::clone(&bed.store.refusals);
    let tape = bed.tape.clone();
    bed.volunteer((&protocol, &plan), |runner| {
        until_presenting(runner, "task3");
        refusals.set(1);
        runner.give(present()).unwrap_err();
        let played = tape.begun.borrow().len();
        let at_ms = runner.now_ms();
        let text = "it took a while".to_owned();
        refusals.set(1);
        runner
            .give(Command::Note { text: text.clone() })
            .unwrap_err();
        done(runner, Command::Note { text });
        let (_, of) = current(runner);
        assert_eq!((of.attempts, of.evidence.len()), (1, played));
        assert!(matches!(runner.state().step(), Step::Answer { .. }));
        // It was presented when it was played, not when it could be stored.
        assert!(of.at_ms[0].unwrap() < at_ms);
        // Presenting it is over: the same command is refused now.
        assert!(matches!(runner.give(present()), Err(RunError::Refused(_))));
        assert_eq!(tape.begun.borrow().len(), played);
    });
    let events = bed.events(&plan);
    assert!(matches!(
        events[events.len() - 2..],
        [Event::Presented { .. }, Event::Note { .. }]
    ));
}

/// The numbers of all playings are different, and no evidence is of a playing in a void attempt.
fn once(bed: &Bed) {
    let begun = bed.tape.begun.borrow();
    let names: BTreeSet<&String> = begun.iter().collect();
    assert_eq!(names.len(), begun.len(), "{begun:?}");
}

#[test]
fn a_device_that_fails_makes_the_trial_void_and_it_is_presented_again() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    let refusals = Rc::clone(&bed.store.refusals);
    let tape = bed.tape.clone();
    bed.volunteer((&protocol, &plan), |runner| {
        until_presenting(runner, "task3");
        let (name, of) = current(runner);
        assert_eq!(of.attempts, 0);
        let void = Given::Void {
            why: "the cable came off".to_owned(),
        };
        // In the second element.
        tape.fails_after.set(Some(1));
        let was = said(runner.state()).but_begun();
        refusals.set(1);
        assert!(runner.give(present()).is_err());
        assert_eq!(said(runner.state()).but_begun(), was);
        // The failure itself is stored, not a second presentation.
        assert_eq!(runner.give(present()).unwrap(), void);
        assert_eq!(tape.begun.borrow().len(), 2);
        let (again, of) = current(runner);
        assert_eq!(again, name);
        assert_eq!((of.attempts, of.voided, of.evidence.len()), (1, 1, 0));
        let Step::Present { attempt: 2, .. } = runner.state().step() else {
            panic!("{:?}", runner.state().step());
        };
        done(runner, present());
        let (_, of) = current(runner);
        let elements = of.plays.len();
        assert_eq!((of.attempts, of.evidence.len()), (2, elements));
        done(runner, replay(1));
        // In a replay, after an answer was given.
        let Some(answer @ Command::Answer { .. }) = next(runner.state()) else {
            panic!("an answer is awaited");
        };
        done(runner, answer);
        tape.fails_after.set(Some(0));
        assert_eq!(runner.give(replay(0)).unwrap(), void);
        let (again, of) = current(runner);
        assert_eq!(again, name);
        assert_eq!((of.attempts, of.voided), (2, 2));
        assert!(of.answers.is_empty() && of.evidence.is_empty() && of.plays.is_empty());
        done(runner, present());
        let (_, of) = current(runner);
        assert_eq!(of.attempts, 3);
        let expected: Vec<String> = (0..elements).map(|i| format!("{name}-3-{i}-1")).collect();
        let found = of.evidence.iter().map(|(_, one)| one.journal.clone());
        assert_eq!(found.flatten().collect::<Vec<_>>(), expected);
        while let Some(command) = next(runner.state()) {
            done(runner, command);
        }
        assert_eq!(runner.state().confirmed(), plan.trials.len());
    });
    once(&bed);
    let voids = bed.events(&plan).into_iter();
    let voids = voids
        .filter(|event| matches!(event, Event::Voided { why, .. } if why == "the cable came off"));
    assert_eq!(voids.count(), 2);
}

#[test]
fn replays_are_numbered_and_an_element_that_is_not_there_is_refused() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    let refusals = Rc::clone(&bed.store.refusals);
    bed.volunteer((&protocol, &plan), |runner| {
        until_presenting(runner, "task3");
        done(runner, present());
        let (name, of) = current(runner);
        let elements = of.plays.len();
        assert!(matches!(
            runner.give(replay(elements)),
            Err(RunError::Refused(_))
        ));
        refusals.set(1);
        runner.give(replay(1)).unwrap_err();
        done(runner, replay(1));
        done(runner, replay(1));
        let (_, of) = current(runner);
        assert_eq!(of.plays[..2], [1, 3]);
        let journals: Vec<String> = of
            .evidence_of(1)
            .filter_map(|one| one.journal.clone())
            .collect();
        assert_eq!(journals, [1, 2, 3].map(|play| format!("{name}-1-1-{play}")));
    });
    once(&bed);
}

#[test]
fn an_event_of_another_program_in_the_same_session_stops_this_one() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    let overtakes = Rc::clone(&bed.store.overtakes);
    bed.volunteer((&protocol, &plan), |runner| {
        until_presenting(runner, "task1");
        let was = said(runner.state());
        overtakes.set(true);
        for _ in 0..2 {
            let refused = runner.give(present());
            assert!(
                matches!(refused, Err(RunError::Store(StoreError::Overtaken { .. }))),
                "{refused:?}"
            );
            assert_eq!(said(runner.state()), was);
        }
    });
    // What the other program did is taken up by the next one.
    let events = bed.events(&plan);
    assert!(matches!(events.last(), Some(Event::Note { text }) if text == "of another program"));
    bed.volunteer((&protocol, &plan), |runner| {
        assert_eq!(runner.state().events(), events.len() as u64);
    });
}

/// The answer of the store is lost after each event is stored: the same command again stores nothing more.
#[test]
fn what_was_stored_without_a_word_is_not_stored_again() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    let (losses, begun) = (Rc::clone(&bed.store.losses), Rc::clone(&bed.tape.begun));
    let mut given = 0;
    let all = |given: u64| given + begun.borrow().len() as u64;
    bed.volunteer((&protocol, &plan), |runner| {
        while let Some(command) = next(runner.state()) {
            losses.set(1);
            let refused = runner.give(command.clone());
            assert!(
                matches!(refused, Err(RunError::Store(StoreError::Place { .. }))),
                "{command:?}: {refused:?}"
            );
            assert_eq!(runner.state().events(), all(given));
            // In between another command: it stands behind the one that was stored.
            if given % 2 == 1 {
                let text = "it took a while".to_owned();
                done(runner, Command::Note { text });
                given += 2;
            } else {
                done(runner, command);
                given += 1;
            }
            assert_eq!(runner.state().events(), all(given));
        }
        assert_eq!(runner.state().confirmed(), plan.trials.len());
    });
    assert_eq!(bed.events(&plan).len() as u64, all(given));
    // Each stimulus was felt once.
    let begun = bed.tape.begun.borrow();
    let names: BTreeSet<&String> = begun.iter().collect();
    assert_eq!(names.len(), begun.len());
}
