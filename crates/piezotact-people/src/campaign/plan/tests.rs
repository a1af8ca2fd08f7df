use std::collections::BTreeSet;

use super::super::protocol::{LIBRARY, from_library, read};
use super::*;

fn library(name: &str) -> Protocol {
    from_library(name).unwrap().unwrap()
}

fn made(
    protocol: &Protocol,
    participant: &str,
    session: &str,
    completed: &[CompletedSession],
) -> Plan {
    let request = PlanRequest {
        seed: 2024,
        participant,
        session,
        completed,
    };
    plan(protocol, Sha::of(b"protocol"), request).unwrap()
}

#[test]
fn every_session_of_every_protocol_of_the_library_has_a_plan_with_names_of_its_own() {
    for (name, _) in LIBRARY {
        let protocol = library(name);
        for session in &protocol.sessions {
            let plan = made(&protocol, "P01", &session.name, &[]);
            assert!(!plan.trials.is_empty(), "{name} {}", session.name);
            let names: BTreeSet<&str> = plan
                .trials
                .iter()
                .map(|trial| trial.name.as_str())
                .collect();
            assert_eq!(names.len(), plan.trials.len(), "{name} {}", session.name);
        }
    }
}

#[test]
fn the_isotropic_session_is_that_of_the_thesis() {
    let protocol = library("isotropic_triplets");
    let plan = made(&protocol, "P01", "discrimination", &[]);
    // Task 1 three times, then tasks 2 and 3 of twelve sets, one at once after the other.
    assert_eq!(plan.trials.len(), 3 + 24);
    assert!(plan.trials[..3].iter().all(|trial| trial.task == "task1"));
    for pair in plan.trials[3..].chunks(2) {
        assert_eq!(
            (pair[0].task.as_str(), pair[1].task.as_str()),
            ("task2", "task3")
        );
        assert_eq!(pair[0].set, pair[1].set);
        assert_eq!(
            pair[1].answer,
            AnswerForm::EachOfOrder {
                trial: pair[0].name.clone()
            }
        );
        let set = protocol.set(pair[0].set.as_deref().unwrap()).unwrap();
        let sequence = pair[1].presented.names();
        assert!((3..=4).contains(&sequence.len()));
        assert!(
            sequence
                .iter()
                .all(|stimulus| set.samples.contains(stimulus))
        );
        assert!(!sequence.contains(&"NO".to_owned()));
    }
}

#[test]
fn fixed_sequences_are_the_same_for_all_and_permutations_hold_each_sample_once() {
    let protocol = library("amplitude_inversion");
    let tests = |participant: &str| -> Vec<Vec<String>> {
        let plan = made(&protocol, participant, "discrimination", &[]);
        let task3 = plan.trials.iter().filter(|trial| trial.task == "task3");
        task3
            .map(|trial| trial.presented.names().to_vec())
            .collect()
    };
    assert_eq!(tests("P01").len(), 8);
    assert_eq!(tests("P01"), tests("P02"));
    let imagery = made(&library("touch_control_imagery"), "P01", "feedback", &[]);
    // How well it went is asked once of each texture.
    let asked = imagery
        .trials
        .iter()
        .filter(|trial| trial.task == "vividness");
    assert_eq!(asked.count(), 3);
    for trial in imagery
        .trials
        .iter()
        .filter(|trial| trial.task != "vividness")
    {
        let distinct: BTreeSet<_> = trial.presented.names().iter().collect();
        assert_eq!(distinct.len(), 3);
    }
}

#[test]
fn the_same_inputs_give_the_same_bytes_and_others_other_ones() {
    let protocol = library("isotropic_triplets");
    let plan = made(&protocol, "P01", "discrimination", &[]);
    assert_eq!(
        plan.bytes(),
        made(&protocol, "P01", "discrimination", &[]).bytes()
    );
    assert_ne!(
        plan.trials,
        made(&protocol, "P02", "discrimination", &[]).trials
    );
    let again: Plan = serde_json::from_slice(&plan.bytes()).unwrap();
    assert_eq!(again, plan);
    // Written down once: a change of the generator or the drawing would change every plan of a running campaign.
    assert_eq!(plan.sha().to_string(), PINNED);
    // With rules, training and catch trials.
    let jnd = made(&library("roughness_jnd"), "P01", "discrimination", &[]);
    let again: Plan = serde_json::from_slice(&jnd.bytes()).unwrap();
    assert_eq!(again.bytes(), jnd.bytes());
    assert_eq!(jnd.sha().to_string(), PINNED_JND);
}

const PINNED_JND: &str = "c53483119e2ccebcbd0e35f519d31a383958bed9fb114dc8ea350146df36ac5a";

const PINNED: &str = "ef05fcb9e051491b49823b4d8622676fb20456d9122b9f977333459aa2bc0573";

#[test]
fn another_task_elsewhere_changes_no_draw_of_the_others() {
    let (_, toml) = LIBRARY[1];
    let longer = toml.replacen("repeats = 3", "repeats = 7", 1);
    let (a, b) = (read(toml).unwrap(), read(&longer).unwrap());
    let triplets = |protocol: &Protocol| -> Vec<Trial> {
        let plan = made(protocol, "P01", "discrimination", &[]);
        plan.trials
            .into_iter()
            .filter(|trial| trial.block == "triplets")
            .collect()
    };
    assert_eq!(triplets(&a), triplets(&b));
}

/// Twenty-four people come; the 4th, 8th … leave. Gives the completed sessions.
fn with_six_of_24_leaving(protocol: &Protocol, session: &str) -> Vec<CompletedSession> {
    let mut completed = Vec::new();
    for person in 1..=24 {
        let plan = made(protocol, &format!("P{person:02}"), session, &completed);
        if person % 4 != 0 {
            completed.push(plan.as_completed());
        }
    }
    completed
}

#[test]
fn when_six_of_24_leave_completed_cells_differ_by_one_at_most() {
    let protocol = library("isotropic_triplets");
    let (_, toml) = LIBRARY[1];
    let balanced =
        read(&toml.replacen("set_order = \"shuffled\"", "set_order = \"balanced\"", 1)).unwrap();
    let completed = with_six_of_24_leaving(&balanced, "discrimination");
    assert_eq!(completed.len(), 18);
    let orders = balanced_orders(12);
    // Each set stands at each place equally often, up to one.
    for set in 0..12 {
        let mut at = [0_usize; 12];
        for done in &completed {
            let row = &orders[done.cells["triplets.sets"]];
            at[row.iter().position(|item| *item == set).unwrap()] += 1;
        }
        let spread = at.iter().max().unwrap() - at.iter().min().unwrap();
        assert!(spread <= 1, "set {set}: {at:?} of {} orders", orders.len());
    }
    // Without balance nothing is promised.
    assert!(
        with_six_of_24_leaving(&protocol, "discrimination")
            .iter()
            .all(|done| done.cells.is_empty())
    );
}

#[test]
fn shares_of_sets_and_the_order_of_two_tasks_stay_balanced_too() {
    let imagery = library("touch_control_imagery");
    let completed = with_six_of_24_leaving(&imagery, "feedback");
    let first = completed
        .iter()
        .filter(|done| done.cells["rendered.tasks"] == 0)
        .count();
    assert_eq!(first, 9);
    let (_, toml) = LIBRARY[1];
    let shared = toml
        .replacen(
            "over = \"every_set\"",
            "over = { shares_of_sets = [[\"A\", \"B\", \"C\"], [\"D\", \"E\", \"F\"]] }",
            1,
        )
        .replacen("set_order = \"shuffled\"", "set_order = \"balanced\"", 1);
    let protocol = read(&shared).unwrap();
    let completed = with_six_of_24_leaving(&protocol, "discrimination");
    let mut cells = BTreeMap::<String, usize>::new();
    for done in &completed {
        for (name, which) in &done.cells {
            *cells.entry(format!("{name} {which}")).or_default() += 1;
        }
    }
    assert_eq!(cells["triplets.share 0"], 9);
    let orders = cells.iter().filter(|(name, _)| name.contains("of share"));
    assert!(
        orders.clone().count() == 12 && orders.map(|(_, n)| *n).all(|n| (1..=2).contains(&n)),
        "{cells:?}"
    );
}

#[test]
fn drawn_sequences_repeat_and_omit_and_are_uniform() {
    let protocol = library("isotropic_triplets");
    let (mut all, mut permutations, mut counts) = (0, 0, BTreeMap::<usize, u32>::new());
    for person in 0..200 {
        let plan = made(&protocol, &format!("P{person}"), "discrimination", &[]);
        for trial in plan.trials.iter().filter(|trial| trial.task == "task3") {
            let names = trial.presented.names();
            let distinct: BTreeSet<_> = names.iter().collect();
            *counts.entry(names.len()).or_default() += 1;
            all += 1;
            permutations += usize::from(names.len() == 3 && distinct.len() == 3);
        }
    }
    // 3 of 3 without repeats: 1/2 · 3!/27 = 1/9 of all; 2400 draws, so 0.111 ± 0.02 at three standard errors.
    let share = permutations as f64 / f64::from(all);
    assert!((share - 1.0 / 9.0).abs() < 0.02, "{share}");
    assert!(counts[&3].abs_diff(counts[&4]) < 150, "{counts:?}");
}

#[test]
fn what_cannot_be_planned_is_said() {
    let protocol = library("amplitude_inversion");
    let request = |session, participant, completed| PlanRequest {
        seed: 1,
        participant,
        session,
        completed,
    };
    let says = |request: PlanRequest<'_>, protocol: &Protocol, part: &str| {
        let text = plan(protocol, Sha::of(b""), request)
            .unwrap_err()
            .to_string();
        assert!(text.contains(part), "{text}");
    };
    says(
        request("eating", "P01", &[]),
        &protocol,
        "its sessions are measurement, discrimination",
    );
    let done = [made(&protocol, "P01", "discrimination", &[]).as_completed()];
    says(
        request("discrimination", "P01", &done),
        &protocol,
        "takes part once",
    );
    let mut more = protocol.clone();
    more.sets.push(super::super::protocol::SampleSet {
        name: "3".to_owned(),
        samples: vec!["S2".to_owned()],
    });
    says(
        request("discrimination", "P01", &[]),
        &more,
        "no fixed sequence for set 3",
    );
}

#[test]
fn training_and_catch_trials_change_no_draw_of_the_counted_ones() {
    let counted = |toml: &str| -> Vec<(String, Presented)> {
        let plan = made(&read(toml).unwrap(), "P01", "discrimination", &[]);
        let counted = plan.trials.into_iter();
        let counted = counted.filter(|trial| trial.kind.is_counted());
        counted.map(|trial| (trial.name, trial.presented)).collect()
    };
    let (_, with) = LIBRARY[5];
    let without: String = with
        .lines()
        .filter(|line| !line.starts_with("training") && !line.starts_with("catch"))
        .map(|line| format!("{line}\n"))
        .collect();
    let only_catch: String = with
        .lines()
        .filter(|line| !line.starts_with("training"))
        .map(|line| format!("{line}\n"))
        .collect();
    assert_eq!(counted(with), counted(&without));
    assert_eq!(counted(with).len(), 50 + 90);
    let others = |toml: &str, kind: fn(&TrialKind) -> bool| -> Vec<Trial> {
        let plan = made(&read(toml).unwrap(), "P01", "discrimination", &[]);
        let trials = plan.trials.into_iter();
        trials.filter(|trial| kind(&trial.kind)).collect()
    };
    let caught: fn(&TrialKind) -> bool = |kind| matches!(kind, TrialKind::Catch { .. });
    let trained: fn(&TrialKind) -> bool = |kind| matches!(kind, TrialKind::Training { .. });
    assert_eq!(others(with, caught), others(&only_catch, caught));
    let trained = others(with, trained);
    assert_eq!(trained.len(), 12);
    let drawn: BTreeSet<_> = trained
        .iter()
        .map(|trial| trial.presented.names())
        .collect();
    assert!(drawn.len() > 4, "levels are drawn: {drawn:?}");
}

#[test]
fn the_standard_and_the_catch_trials_stand_at_random_places() {
    let protocol = library("roughness_jnd");
    let (mut first, mut all, mut places) = (0, 0, BTreeSet::new());
    for person in 0..40 {
        let plan = made(&protocol, &format!("P{person}"), "discrimination", &[]);
        for (place, trial) in plan.trials.iter().enumerate() {
            match (&trial.kind, &trial.presented) {
                (_, Presented::Chosen { standard, run }) => {
                    assert!(plan.runs.contains_key(run));
                    all += 1;
                    first += i32::from(*standard == Interval::First);
                }
                (TrialKind::Catch { right }, presented) => {
                    let names = presented.names();
                    let stronger = names.iter().position(|name| name != "S8").unwrap();
                    assert_eq!(right[0], ["first", "second"][stronger]);
                    places.insert(place);
                    // Never behind the last counted trial of its task.
                    let next = plan.trials[place..]
                        .iter()
                        .find(|one| one.kind.is_counted());
                    assert_eq!(next.unwrap().task, trial.task);
                }
                _ => {}
            }
        }
    }
    // 5600 draws: a share of 0.5 ± 0.02 at three standard errors.
    let share = f64::from(first) / f64::from(all);
    assert!((share - 0.5).abs() < 0.02, "{share}");
    assert!(places.len() > 80, "{} places", places.len());
}

#[test]
fn constant_stimuli_are_presented_in_both_orders_equally_often() {
    let (_, toml) = LIBRARY[5];
    let (before, after) = toml.split_once("question = \"stronger\"").unwrap();
    let (_, after) = after.split_once("[[tasks]]").unwrap();
    let constant = format!(
        "{before}question = \"same_different\"\nmethod = {{ how = \"constant\", pairs = [[\"S8\", \"S8 increment -6\"], [\"S8\", \"S8\"]], repeats = 5 }}\n[[tasks]]{after}"
    );
    let plan = made(&read(&constant).unwrap(), "P01", "discrimination", &[]);
    let mut counts = BTreeMap::<Vec<String>, u32>::new();
    for trial in &plan.trials {
        if trial.task == "quest" && trial.kind.is_counted() {
            *counts.entry(trial.presented.names().to_vec()).or_default() += 1;
        }
        if let (TrialKind::Training { feedback }, "quest") = (&trial.kind, trial.task.as_str()) {
            let names = trial.presented.names();
            let right = if names[0] == names[1] {
                "same"
            } else {
                "different"
            };
            assert_eq!(feedback.as_deref(), Some(&[right.to_owned()][..]));
        }
    }
    assert_eq!(counts.into_values().collect::<Vec<_>>(), [10, 5, 5]);
}

#[test]
fn the_orders_of_chapter_6_fill_their_twelve_cells_equally_often() {
    let protocol = library("touch_control_imagery");
    let mut completed = Vec::new();
    let mut cells: BTreeMap<(String, Vec<String>), u32> = Default::default();
    for number in 1..=24 {
        let plan = made(&protocol, &format!("P{number:02}"), "feedback", &completed);
        // Each person has both tasks: the first of them with the order of its textures is a cell, and so is the second.
        for trial in plan.trials.iter().filter(|trial| trial.task != "vividness") {
            let place = plan.trials.iter().position(|one| one.name == trial.name);
            let cell = (
                format!("{} {place:?}", trial.task),
                trial.presented.names().to_vec(),
            );
            *cells.entry(cell).or_default() += 1;
        }
        completed.push(plan.as_completed());
    }
    // Two tasks at two places with six orders, 24 people with two trials each.
    assert_eq!(cells.len(), 24);
    assert!(cells.values().all(|count| *count == 2), "{cells:?}");
}
