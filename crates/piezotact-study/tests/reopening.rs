//! Sessions that are opened again.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact_people::campaign::chain::Sha;
use piezotact_people::campaign::session::SessionError;
use piezotact_people::campaign::session::{Command, Event, Stage, Step};
use piezotact_people::campaign::store::{
    MemoryStore, NewEvent, Purpose, SessionKey, Store as _, StoreError,
};
use piezotact_study::session::{RunError, state_of};

use crate::support::{
    Bed, Place, START_MS, current, done, isotropic, next, present, said, until_presenting,
};

fn resume(now_ms: i64) -> Command {
    Command::Resume {
        experimenter: "EY".to_owned(),
        now_ms,
    }
}

#[test]
fn a_session_that_was_cut_off_is_resumed_before_anything_else() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    let presented = bed.volunteer((&protocol, &plan), |runner| {
        until_presenting(runner, "task3");
        done(runner, present());
        current(runner)
    });
    bed.volunteer((&protocol, &plan), |runner| {
        assert!(runner.is_cut_off());
        assert_eq!(current(runner), presented);
        let was = said(runner.state());
        let answer = next(runner.state()).unwrap();
        assert!(matches!(answer, Command::Answer { .. }));
        for command in [answer, Command::Pause, crate::support::replay(0)] {
            let refused = runner.give(command).unwrap_err().to_string();
            assert!(refused.contains("resume it first"), "{refused}");
        }
        assert_eq!(said(runner.state()), was);
        let text = "the computer was restarted".to_owned();
        done(runner, Command::Note { text });
        assert!(runner.is_cut_off());
        let now_ms = runner.now_ms();
        done(runner, resume(now_ms));
        assert!(!runner.is_cut_off());
        // The trial is repeated from its beginning, under the next number.
        let (name, of) = current(runner);
        assert_eq!((&name, of.attempts, of.interrupted), (&presented.0, 1, 1));
        until_presenting(runner, "task3");
        done(runner, present());
        let (_, of) = current(runner);
        let journal = of.evidence[0].1.journal.clone().unwrap();
        assert_eq!(journal, format!("{name}-2-0-1"));
        while let Some(command) = next(runner.state()) {
            done(runner, command);
        }
        assert_eq!(runner.state().stage(), Stage::Ended);
    });
}

#[test]
fn after_too_long_it_does_not_go_on() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    bed.volunteer((&protocol, &plan), |runner| {
        until_presenting(runner, "task1")
    });
    bed.now_ms.set(START_MS + 13 * 3_600_000);
    bed.volunteer((&protocol, &plan), |runner| {
        let now_ms = runner.now_ms();
        let event = done(runner, resume(now_ms));
        assert!(matches!(event, Event::ResumeRefused { after_hours } if after_hours > 12.0));
        assert_eq!(runner.state().stage(), Stage::Stopped);
        assert!(!runner.is_cut_off());
        assert!(runner.give(present()).is_err());
    });
}

#[test]
fn a_rehearsal_is_not_a_session_with_a_volunteer() {
    let (protocol, plan) = isotropic();
    for [begun, asked] in [
        [Purpose::Rehearsal, Purpose::Volunteer],
        [Purpose::Volunteer, Purpose::Rehearsal],
    ] {
        let mut bed = Bed::new();
        bed.open((&protocol, &plan), begun, Place::Tape, |_| ())
            .unwrap();
        let refused = bed.open((&protocol, &plan), asked, Place::Tape, |_| ());
        let found = matches!(refused, Err(RunError::Purpose { begun: was, .. }) if was == begun);
        assert!(found, "{refused:?}");
        let entries = bed.store.sessions().unwrap();
        assert_eq!((entries.len(), entries[0].purpose), (1, begun));
    }
}

#[test]
fn a_rehearsal_that_the_store_lists_as_a_session_with_a_volunteer_is_found() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    bed.volunteer((&protocol, &plan), |runner| {
        until_presenting(runner, "task1")
    });
    let key = SessionKey::new(&plan.participant, &plan.session);
    let mut relabelled = MemoryStore::new();
    relabelled.begin(&key, Purpose::Rehearsal).unwrap();
    for link in bed.store.events(&key).unwrap() {
        let payload = link.payload.unwrap();
        let event = NewEvent {
            at_ms: link.at_ms,
            json: &payload.json,
            salt: payload.salt,
        };
        relabelled.append(&key, link.number, event).unwrap();
    }
    assert_eq!(relabelled.verify().unwrap(), 1);
    let refused = state_of(&relabelled, &protocol, &plan);
    let found = matches!(
        refused,
        Err(RunError::PurposeChanged {
            begun: Purpose::Volunteer,
            listed: Purpose::Rehearsal,
            ..
        })
    );
    assert!(found, "{refused:?}");
    // Nor does a front end begin it as another than the runner was opened for.
    let mut bed = Bed::new();
    let refused = bed.open(
        (&protocol, &plan),
        Purpose::Rehearsal,
        Place::Tape,
        |runner| runner.give(next(runner.state()).unwrap()),
    );
    assert!(
        matches!(refused, Ok(Err(RunError::Purpose { .. }))),
        "{refused:?}"
    );
}

#[test]
fn another_plan_or_protocol_is_refused_with_both_choices() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    bed.volunteer((&protocol, &plan), |runner| {
        until_presenting(runner, "task1")
    });
    let stored = bed.events(&plan);
    let mut moved = plan.clone();
    moved.trials.swap(3, 5);
    let mut other = plan.clone();
    other.protocol_sha = Sha::of(b"another protocol");
    for (changed, what) in [(moved, "plan"), (other, "protocol")] {
        let refused = bed.open(
            (&protocol, &changed),
            Purpose::Volunteer,
            Place::Tape,
            |_| (),
        );
        let error = refused.unwrap_err();
        assert!(
            matches!(error, RunError::Replay(SessionError::Changed { what: found, .. }) if found == what),
            "{error:?}"
        );
        let text = error.to_string();
        assert!(
            text.contains(&format!("restore the earlier {what}"))
                && text.contains("begin a new session"),
            "{text}"
        );
    }
    assert_eq!(bed.events(&plan), stored);
}

#[test]
fn what_another_program_wrote_is_refused_with_its_number() {
    let (protocol, plan) = isotropic();
    for (json, expected) in [
        (
            r#"{"event":"danced"}"#,
            "event 2 of the session cannot be read",
        ),
        ("{", "event 2 of the session cannot be read"),
        (
            r#"{"event":"confirmed","trial":"none"}"#,
            "event 2 cannot follow the events before it",
        ),
    ] {
        let mut bed = Bed::new();
        bed.volunteer((&protocol, &plan), |runner| {
            while runner.state().events() < 2 {
                let command = next(runner.state()).unwrap();
                done(runner, command);
            }
        });
        let key = SessionKey::new("P01", "discrimination");
        let event = NewEvent {
            at_ms: START_MS,
            json,
            salt: [1; 16],
        };
        bed.store.append(&key, 2, event).unwrap();
        let refused = bed.open((&protocol, &plan), Purpose::Volunteer, Place::Tape, |_| ());
        let text = refused.unwrap_err().to_string();
        assert!(text.starts_with(expected), "{text}");
    }
}

#[test]
fn nothing_is_added_to_a_session_that_was_withdrawn() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    bed.volunteer((&protocol, &plan), |runner| {
        assert!(runner.give(Command::Withdraw).is_err(), "nothing began");
        until_presenting(runner, "task2");
        let (confirmed, _) = runner.state().trials().next().unwrap();
        done(runner, Command::Withdraw);
        assert_eq!(runner.state().stage(), Stage::Withdrawn);
        assert_eq!(runner.state().step(), Step::Nothing);
        let events = runner.state().events();
        let words = confirmed.presented.names().to_vec();
        for command in [
            present(),
            Command::Withdraw,
            Command::Note {
                text: "said on leaving".to_owned(),
            },
            Command::AnswerTo {
                trial: confirmed.name.clone(),
                words: words.clone(),
            },
            Command::Correct {
                trial: confirmed.name.clone(),
                words,
                why: "noted wrongly".to_owned(),
            },
        ] {
            let refused = runner.give(command.clone());
            assert!(
                matches!(refused, Err(RunError::Refused(_))),
                "{command:?}: {refused:?}"
            );
        }
        assert_eq!(runner.state().events(), events);
    });
    bed.store.erase("P01", START_MS).unwrap();
    let refused = bed.open((&protocol, &plan), Purpose::Volunteer, Place::Tape, |_| ());
    assert!(matches!(
        refused,
        Err(RunError::Store(StoreError::Withdrawn { .. }))
    ));
    assert!(matches!(
        state_of(&bed.store, &protocol, &plan),
        Err(RunError::Store(StoreError::Withdrawn { .. }))
    ));
    // Nor is another session begun under the name.
    let mut first = plan.clone();
    first.session = "measurement".to_owned();
    let refused = bed.open((&protocol, &first), Purpose::Volunteer, Place::Tape, |_| ());
    assert!(matches!(
        refused,
        Err(RunError::Store(StoreError::Withdrawn { .. }))
    ));
}

/// That a texture begins is stored before its sound: what a kill cut off counts as felt, and what was not stored does not sound.
#[test]
fn what_a_kill_cut_off_counts_as_felt() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    let trial = bed.volunteer((&protocol, &plan), |runner| {
        until_presenting(runner, "task3");
        current(runner).0
    });
    bed.volunteer((&protocol, &plan), |runner| {
        let now_ms = runner.now_ms();
        done(runner, resume(now_ms));
        // Nothing was felt.
        let (_, of) = current(runner);
        assert_eq!((of.attempts, of.interrupted), (0, 0));
        until_presenting(runner, "task3");
    });
    let began = |element| Event::PlayBegan {
        trial: trial.clone(),
        element,
    };
    // The program is killed while the second texture sounds.
    let key = SessionKey::new(&plan.participant, &plan.session);
    for element in 0..2 {
        let known = bed.store.events(&key).unwrap().len() as u64;
        let json = serde_json::to_string(&began(element)).unwrap();
        let new = NewEvent {
            at_ms: bed.now_ms.get(),
            json: &json,
            salt: [7; 16],
        };
        bed.store.append(&key, known, new).unwrap();
    }
    bed.volunteer((&protocol, &plan), |runner| {
        let now_ms = runner.now_ms();
        done(runner, resume(now_ms));
        let (_, of) = current(runner);
        assert_eq!((of.attempts, of.interrupted), (1, 1));
        assert_eq!(of.felt, [1, 1]);
        until_presenting(runner, "task3");
        done(runner, present());
        let (_, of) = current(runner);
        assert_eq!(of.attempts, 2);
        assert_eq!(of.felt, [2, 2, 1]);
        done(runner, crate::support::replay(2));
        assert_eq!(current(runner).1.felt, [2, 2, 2]);
    });
    let events = bed.events(&plan);
    let stored = events
        .iter()
        .filter(|event| matches!(event, Event::PlayBegan { .. }));
    assert_eq!(stored.count(), 2 + 3 + 1);
}

/// A texture that cannot be stored does not sound.
#[test]
fn what_is_not_stored_does_not_sound() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    let (begun, refusals) = (bed.tape.begun.clone(), bed.store.refusals.clone());
    bed.store.with_begins.set(true);
    bed.volunteer((&protocol, &plan), |runner| {
        until_presenting(runner, "task3");
        let before = begun.borrow().len();
        refusals.set(1);
        assert!(matches!(
            runner.give(present()),
            Err(RunError::Store(StoreError::Place { .. }))
        ));
        assert_eq!(begun.borrow().len(), before);
        done(runner, present());
        assert_eq!(begun.borrow().len(), before + 3);
        assert_eq!(current(runner).1.felt, [1, 1, 1]);
    });
}
