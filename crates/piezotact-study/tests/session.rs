//! Whole sessions.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use std::collections::{BTreeMap, BTreeSet};

use piezotact_people::campaign::plan::Presented;
use piezotact_people::campaign::session::{Command, Stage, Step};
use piezotact_people::campaign::store::{MemoryStore, NewEvent, Purpose, SessionKey, Store as _};
use piezotact_study::session::{RunError, state_of};

use crate::support::{
    Bed, Place, done, evidence, isotropic, next, present, replay, said, until_presenting,
};

#[test]
fn a_whole_session_is_stored_with_the_evidence_of_its_stimuli_and_nothing_else() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    // What the state says after each event.
    // By the number of events.
    let mut after = BTreeMap::new();
    bed.volunteer((&protocol, &plan), |runner| {
        after.insert(0, said(runner.state()));
        assert!(!runner.is_cut_off());
        while let Some(command) = next(runner.state()) {
            done(runner, command);
            after.insert(runner.state().events() as usize, said(runner.state()));
            assert!(!runner.is_cut_off());
        }
        let state = runner.state();
        assert_eq!(state.stage(), Stage::Ended);
        assert_eq!(state.confirmed(), plan.trials.len());
        let mut journals = BTreeSet::new();
        for (trial, of) in state.trials() {
            let Presented::Rendered { stimuli } = &trial.presented else {
                assert!(of.evidence.is_empty(), "{}", trial.name);
                continue;
            };
            assert_eq!(of.evidence.len(), stimuli.len());
            for (i, (element, one)) in of.evidence.iter().enumerate() {
                assert_eq!((*element, &one.stimulus), (i, &stimuli[i]));
                let name = one.journal.clone().unwrap();
                assert_eq!(name, format!("{}-1-{i}-1", trial.name));
                journals.insert(name);
            }
        }
        assert!(journals.len() >= 12 * 3);
    });
    assert_eq!(bed.store.verify().unwrap(), 1);
    let key = SessionKey::new("P01", "discrimination");
    let links = bed.store.events(&key).unwrap();
    let begun = bed.tape.begun.borrow().len();
    assert_eq!(links.len() + 1, after.len() + begun);
    // Cut off behind any event, what is stored says the same.
    let mut cut = MemoryStore::new();
    cut.begin(&key, Purpose::Volunteer).unwrap();
    for known in 0..=links.len() {
        let found = state_of(&cut, &protocol, &plan).unwrap();
        if let Some(expected) = after.get(&known) {
            assert_eq!(said(&found), *expected, "after {known} events");
        }
        let Some(link) = links.get(known) else { break };
        let payload = link.payload.as_ref().unwrap();
        let event = NewEvent {
            at_ms: link.at_ms,
            json: &payload.json,
            salt: payload.salt,
        };
        cut.append(&key, known as u64, event).unwrap();
    }
    // Ended: opened again, there is nothing to resume, and nothing is added.
    bed.volunteer((&protocol, &plan), |runner| {
        assert!(!runner.is_cut_off());
        assert!(matches!(runner.give(present()), Err(RunError::Refused(_))));
    });
    assert_eq!(bed.store.events(&key).unwrap().len(), links.len());
}

#[test]
fn without_a_drive_or_a_bench_nothing_is_played_or_stored() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    bed.volunteer((&protocol, &plan), |runner| {
        until_presenting(runner, "task3");
    });
    let before = bed.events(&plan).len();
    let resume = |now_ms| Command::Resume {
        experimenter: "EX".to_owned(),
        now_ms,
    };
    let tape = bed.tape.clone();
    bed.volunteer((&protocol, &plan), |runner| {
        let now_ms = runner.now_ms();
        done(runner, resume(now_ms));
        until_presenting(runner, "task3");
        let (trial, _) = runner.state().current().unwrap();
        let Presented::Rendered { stimuli } = &trial.presented else {
            panic!("{trial:?}");
        };
        // The last element alone has none: the first is not played in vain.
        let last = stimuli.last().unwrap().clone();
        let other = stimuli.iter().find(|one| **one != last).cloned();
        *tape.missing.borrow_mut() = Some(last.clone());
        let was = said(runner.state());
        let refused = runner.give(present()).unwrap_err();
        assert!(matches!(refused, RunError::NoDrive { .. }), "{refused}");
        assert!(refused.to_string().contains(&last), "{refused}");
        let instead = Command::PresentInstead {
            names: vec![last; stimuli.len()],
            evidence: Vec::new(),
        };
        assert!(matches!(
            runner.give(instead),
            Err(RunError::NoDrive { .. })
        ));
        assert_eq!(said(runner.state()), was);
        assert!(tape.begun.borrow().is_empty());
        // Others can be presented instead, and are played then.
        if let Some(other) = other {
            let instead = Command::PresentInstead {
                names: vec![other.clone(); stimuli.len()],
                evidence: Vec::new(),
            };
            done(runner, instead);
            let (_, of) = runner.state().current().unwrap();
            assert!(of.evidence.iter().all(|(_, one)| one.stimulus == other));
            assert_eq!(of.evidence.len(), stimuli.len());
        }
    });
    assert!(bed.events(&plan).len() > before);
    let stored = bed.events(&plan).len();
    let opened = bed.open(
        (&protocol, &plan),
        Purpose::Volunteer,
        Place::Nowhere,
        |runner| {
            let now_ms = runner.now_ms();
            done(runner, resume(now_ms));
            until_presenting(runner, "task3");
            let was = said(runner.state());
            assert!(matches!(
                runner.give(present()),
                Err(RunError::NoBench { .. })
            ));
            assert_eq!(said(runner.state()), was);
            runner.state().events()
        },
    );
    let events = opened.unwrap();
    assert_eq!(bed.events(&plan).len() as u64, events);
    assert!(events > stored as u64);
}

#[test]
fn by_hand_nothing_is_known_of_what_was_felt_whatever_a_front_end_says() {
    let (protocol, plan) = isotropic();
    let mut bed = Bed::new();
    let opened = bed.open(
        (&protocol, &plan),
        Purpose::Volunteer,
        Place::ByHand,
        |runner| {
            until_presenting(runner, "task1");
            // Evidence of a real sample there is none.
            done(
                runner,
                Command::Present {
                    evidence: vec![evidence("S8")],
                },
            );
            until_presenting(runner, "task3");
            done(
                runner,
                Command::Present {
                    evidence: vec![evidence("S8")],
                },
            );
            assert!(matches!(runner.state().step(), Step::Answer { .. }));
            done(
                runner,
                Command::Play {
                    element: 0,
                    evidence: Some(evidence("S8")),
                },
            );
            done(runner, replay(1));
            let (_, of) = runner.state().current().unwrap();
            assert_eq!(of.plays[..2], [2, 2]);
            assert!(
                runner
                    .state()
                    .trials()
                    .all(|(_, of)| of.evidence.is_empty())
            );
        },
    );
    opened.unwrap();
    assert!(bed.tape.begun.borrow().is_empty());
}
