//! Comparisons whose stimuli follow from the answers.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact::page::Cell;
use piezotact_people::association::{StimulusFiles, behaviour};
use piezotact_people::campaign::plan::{Plan, Presented};
use piezotact_people::campaign::protocol::Protocol;
use piezotact_people::campaign::session::{Command, Stage, State, Step};
use piezotact_study::session::{Given, state_of};

use crate::support::{Bed, done, next, planned, present, said, until_presenting};

/// A session of somebody who always, or never, names the comparison; gives what each counted trial of QUEST+ presented.
fn session(
    protocol: &Protocol,
    plan: &Plan,
    names_comparison: impl Fn() -> bool,
) -> Vec<Vec<String>> {
    let mut bed = Bed::new();
    let ended = bed.volunteer((protocol, plan), |runner| {
        while let Some(command) = next(runner.state()) {
            let command = match runner.state().step() {
                Step::Answer { trial, .. } => {
                    let presented = runner.state().presented(trial);
                    let standard_first = presented[0] == "S8";
                    let word = match standard_first == names_comparison() {
                        true => "second",
                        false => "first",
                    };
                    Command::Answer {
                        words: vec![word.to_owned()],
                    }
                }
                _ => command,
            };
            done(runner, command);
        }
        said(runner.state())
    });
    let state = state_of(&bed.store, protocol, plan).unwrap();
    assert_eq!(said(&state), ended);
    assert_eq!(state.stage(), Stage::Ended);
    chosen(&state)
}

fn chosen(state: &State<'_>) -> Vec<Vec<String>> {
    let mut found = Vec::new();
    for (trial, of) in state.trials() {
        if !matches!(trial.presented, Presented::Chosen { .. }) || of.plays.is_empty() {
            continue;
        }
        let chosen = of.chosen.clone().unwrap();
        let felt: Vec<String> = of
            .evidence
            .iter()
            .map(|(_, one)| one.stimulus.clone())
            .collect();
        assert_eq!(felt, chosen, "{}: played is what was chosen", trial.name);
        assert!(chosen.contains(&"S8".to_owned()));
        found.push(chosen);
    }
    found
}

#[test]
fn what_is_played_follows_from_the_answers_and_is_found_again_in_the_store() {
    let (protocol, plan) = planned("roughness_jnd", "discrimination");
    let right = session(&protocol, &plan, || true);
    let wrong = session(&protocol, &plan, || false);
    // The first comparison is the same, and those of the one who is always right become weaker.
    assert_eq!(right[0], wrong[0]);
    assert_ne!(right, wrong);
    let last = |of: &[Vec<String>]| {
        let gain = |name: &str| protocol.stimuli.iter().find(|one| one.name == name);
        let gains = of.last().unwrap().iter().filter_map(|name| gain(name));
        gains.map(|one| one.gain_db.unwrap()).sum::<f64>()
    };
    assert!(
        last(&right) < last(&wrong),
        "{} {}",
        last(&right),
        last(&wrong)
    );
}

struct NoFiles;

impl StimulusFiles for NoFiles {
    fn drive(&self, _stimulus: &str) -> Option<String> {
        None
    }

    fn recording(&self, _journal: &str) -> Option<String> {
        None
    }
}

/// The tables say one thing of a comparison: either texture missing its target is a miss, and an attempt that was stopped is no replay.
#[test]
fn a_comparison_has_the_flags_of_both_textures_and_no_replays_of_a_void_attempt() {
    let (protocol, plan) = planned("roughness_jnd", "discrimination");
    for (misses, flags) in [
        (None, ""),
        (Some(0), "missed_target"),
        (Some(1), "missed_target"),
    ] {
        let mut bed = Bed::new();
        bed.tape.misses.set(misses);
        bed.tape.fails_after.set(Some(1));
        bed.volunteer((&protocol, &plan), |runner| {
            until_presenting(runner, "quest");
            assert!(matches!(runner.give(present()), Ok(Given::Void { .. })));
            done(runner, present());
            // Past the training.
            for _ in 0..60 {
                let command = next(runner.state()).unwrap();
                done(runner, command);
            }
        });
        let state = state_of(&bed.store, &protocol, &plan).unwrap();
        let quest = &state.thresholds("quest")[0];
        assert!(quest.course.len() > 1, "{quest:?}");
        let all = usize::from(misses.is_some()) * quest.course.len();
        assert_eq!(quest.missed_target, all);
        let found = behaviour(&state, &NoFiles);
        let first = |table: &piezotact::page::Table, name: &str| {
            let column = table.columns.iter().position(|one| one.name == name);
            let cells = table.rows.iter().map(|row| &row[column.unwrap()]);
            let mut known = cells.filter(|cell| **cell != Cell::Missing(()));
            known.next().cloned().unwrap_or(Cell::Missing(()))
        };
        let text = |text: &str| match text {
            "" => Cell::Missing(()),
            text => Cell::from(text),
        };
        let answers = &found[0].responses;
        assert_eq!(first(answers, "flags"), text(flags), "{misses:?}");
        assert_eq!(first(answers, "n_replays"), Cell::from(0.0));
        let events = &found[0].events;
        let missed = if flags.is_empty() { "no" } else { "yes" };
        assert_eq!(first(events, "missed_target"), text(missed), "{misses:?}");
    }
}
