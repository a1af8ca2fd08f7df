//! Comparisons whose stimuli follow from the answers.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact_people::campaign::plan::{Plan, Presented};
use piezotact_people::campaign::protocol::Protocol;
use piezotact_people::campaign::session::{Command, Stage, State, Step};
use piezotact_study::session::state_of;

use crate::support::{Bed, done, next, planned, said};

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
