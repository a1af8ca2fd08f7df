//! The answers of sessions as rows.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact_people::campaign::session::SessionError;
use std::collections::BTreeSet;

use piezotact::Warning;
use piezotact::criterion::Outcome;
use piezotact_people::association::{
    Answer, AnswerTable, Flag, MatrixConfig, Purpose, Stimulus, answers_of, answers_table,
    declared, ordering, participants_table,
};
use piezotact_people::campaign::dictionary::{ANSWER_COLUMNS, dictionary};
use piezotact_people::campaign::plan::TrialKind;
use piezotact_people::campaign::protocol::{LIBRARY, OrderKey, Protocol, TaskKind};
use piezotact_people::campaign::session::{CampaignWarning, Command, Refusal};
use piezotact_people::campaign::store;

use crate::sitting::{Sitting, evidence, library, planned};

fn rows(sitting: &Sitting<'_>) -> Vec<Answer> {
    answers_of(&sitting.state, store::Purpose::Volunteer)
}

fn of_task(sitting: &Sitting<'_>, task: &str) -> Vec<Answer> {
    let rows = rows(sitting).into_iter();
    rows.filter(|row| row.task == task).collect()
}

fn pairs(rows: &[Answer]) -> Vec<[&str; 2]> {
    rows.iter()
        .map(|row| [row.presented.as_str(), row.answered.as_str()])
        .collect()
}

fn keyed(key: OrderKey) -> Protocol {
    let mut protocol = library("isotropic_triplets");
    for task in &mut protocol.tasks {
        if let TaskKind::Order { key: own, .. } = &mut task.kind {
            *own = key;
        }
    }
    protocol
}

/// The samples from the roughest to the smoothest.
fn roughest_first(protocol: &Protocol) -> Vec<String> {
    protocol.samples.clone()
}

#[test]
fn an_order_says_which_sample_stands_in_whose_place() {
    let protocol = library("isotropic_triplets");
    let plan = planned(&protocol, "discrimination");
    let mut sitting = Sitting::begun(&protocol, &plan);
    let right = roughest_first(&protocol);
    let mut moved = right.clone();
    moved.swap(0, 3);
    for order in [&right, &moved, &right] {
        sitting.presents(&[]);
        sitting.answers(order);
    }
    let rows = rows(&sitting);
    assert_eq!(rows.len(), 3 * 14);
    let second = &rows[14..28];
    assert_eq!(
        pairs(&second[..4]),
        [["S4", "S1"], ["S2", "S2"], ["S3", "S3"], ["S1", "S4"]]
    );
    assert!(
        pairs(&rows[..14])
            .iter()
            .all(|[placed, stands]| placed == stands)
    );
    assert_eq!(second[3].position, Some(4));
    let sessions: Vec<&str> = rows
        .iter()
        .step_by(14)
        .map(|row| row.session.as_str())
        .collect();
    assert_eq!(
        sessions,
        [
            "discrimination",
            "discrimination, repetition 2",
            "discrimination, repetition 3"
        ]
    );
    let table = AnswerTable::new(declared(&protocol), rows).unwrap();
    let found = ordering(&table, &MatrixConfig::default(), "task1").unwrap();
    let taus: Vec<f64> = found
        .repetitions
        .iter()
        .map(|one| one.tau.unwrap())
        .collect();
    // Two samples that are exchanged over two others change the order of five of 91 pairs.
    let five = 1.0 - 10.0 / 91.0;
    assert_eq!(taus.len(), 3);
    for (tau, expected) in taus.iter().zip([1.0, five, 1.0]) {
        assert!((tau - expected).abs() < 1e-12, "{taus:?}");
    }
    assert_eq!((found.in_place, found.placed), (40, 42));
}

/// Ra of Table 3 of the thesis, µm; S7 and S8, which have the same, stand in the order of their grades.
const RA_UM: [(&str, f64); 14] = [
    ("S1", 74.6),
    ("S2", 43.7),
    ("S3", 33.6),
    ("S4", 14.4),
    ("S5", 11.7),
    ("S6", 6.6),
    ("S7", 5.2),
    ("S8", 5.2),
    ("S9", 4.6),
    ("S10", 4.5),
    ("S11", 4.4),
    ("S12", 4.3),
    ("S13", 3.8),
    ("NO", 0.1),
];

#[test]
fn the_physical_order_of_the_isotropic_samples_is_that_of_their_roughness() {
    for name in [
        "isotropic_triplets",
        "averaged_transfer_function",
        "amplitude_inversion",
    ] {
        let protocol = library(name);
        let table = RA_UM.iter().map(|(sample, _)| (*sample).to_owned());
        let roughest_first: Vec<String> = table
            .filter(|sample| protocol.samples.contains(sample))
            .collect();
        let mut orders = 0;
        for task in &protocol.tasks {
            if let TaskKind::Order { from, key, .. } = &task.kind {
                assert_eq!((from.as_str(), *key), ("roughest", OrderKey::AsListed));
                assert_eq!(protocol.samples, roughest_first, "{name}");
                orders += 1;
            }
        }
        assert!(orders > 0, "{name}");
    }
}

#[test]
fn the_key_of_an_order_is_the_protocols() {
    for key in [OrderKey::AsListed, OrderKey::Reversed, OrderKey::None] {
        let protocol = keyed(key);
        let plan = planned(&protocol, "discrimination");
        let mut sitting = Sitting::begun(&protocol, &plan);
        sitting.presents(&[]);
        sitting.answers(&roughest_first(&protocol));
        let rows = rows(&sitting);
        let found = pairs(&rows);
        match key {
            OrderKey::AsListed => assert!(found.iter().all(|[placed, stands]| placed == stands)),
            OrderKey::Reversed => {
                assert_eq!(found[..2], [["S1", "NO"], ["S2", "S13"]]);
                assert_eq!(found[13], ["NO", "S1"]);
            }
            OrderKey::None => assert!(found.is_empty(), "no order is right or wrong"),
        }
    }
}

#[test]
fn repetitions_count_counted_orders_wherever_they_stand() {
    let protocol = library("isotropic_triplets");
    let mut plan = planned(&protocol, "discrimination");
    // An order to learn the task, and one in a block of its own.
    plan.trials[0].kind = TrialKind::Training { feedback: None };
    plan.trials[2].block = "again".to_owned();
    let mut sitting = Sitting::begun(&protocol, &plan);
    sitting.until("task2");
    let rows = of_task(&sitting, "task1");
    let sessions: BTreeSet<&str> = rows.iter().map(|row| row.session.as_str()).collect();
    assert_eq!(rows.len(), 2 * 14);
    let expected = ["discrimination", "discrimination, repetition 2"];
    assert_eq!(sessions, BTreeSet::from(expected));
    let table = AnswerTable::new(declared(&protocol), rows).unwrap();
    assert_eq!(
        ordering(&table, &MatrixConfig::default(), "task1")
            .unwrap()
            .repetitions
            .len(),
        2
    );
}

#[test]
fn training_catch_trials_and_what_is_not_confirmed_are_no_rows() {
    let protocol = library("isotropic_triplets");
    let mut plan = planned(&protocol, "discrimination");
    let sequences: Vec<usize> = (0..plan.trials.len())
        .filter(|i| plan.trials[*i].task == "task3")
        .collect();
    plan.trials[sequences[0]].kind = TrialKind::Training {
        feedback: Some(Vec::new()),
    };
    plan.trials[sequences[1]].kind = TrialKind::Catch { right: Vec::new() };
    let mut sitting = Sitting::begun(&protocol, &plan);
    for _ in 0..sequences[3] {
        sitting.anyhow(&[]);
    }
    // The fourth is answered and not confirmed.
    sitting.presents(&[]);
    let (_, _, presented) = sitting.current();
    sitting.does(Command::Answer {
        words: vec!["A".to_owned(); presented.len()],
    });
    let trials: BTreeSet<String> = of_task(&sitting, "task3")
        .iter()
        .map(|row| row.trial.clone())
        .collect();
    assert_eq!(
        trials,
        BTreeSet::from([plan.trials[sequences[2]].name.clone()])
    );
    sitting.does(Command::Confirm);
    assert!(
        of_task(&sitting, "task3")
            .iter()
            .any(|row| row.trial.starts_with(&plan.trials[sequences[3]].name))
    );
    let rehearsed = answers_of(&sitting.state, store::Purpose::Rehearsal);
    assert_eq!(rehearsed.len(), rows(&sitting).len());
    assert!(
        rehearsed
            .iter()
            .all(|row| row.purpose == Purpose::Rehearsal)
    );
    assert!(
        rows(&sitting)
            .iter()
            .all(|row| row.purpose == Purpose::Trial)
    );
}

#[test]
fn the_wrong_sample_on_the_tray_is_the_one_that_is_put_in_order() {
    let protocol = library("isotropic_triplets");
    let plan = planned(&protocol, "discrimination");
    let mut sitting = Sitting::begun(&protocol, &plan);
    sitting.until("task2");
    let (_, _, presented) = sitting.current();
    let wrong = protocol
        .samples
        .iter()
        .find(|one| !presented.contains(one))
        .unwrap();
    let tray = [presented[0].clone(), presented[1].clone(), wrong.clone()];
    let twice = refused_after_checks(&protocol, &plan, &[&tray[0], &tray[0], &tray[1]]);
    assert!(
        matches!(twice, Refusal::Answer(SessionError::NamedTwice { .. })),
        "{twice:?}"
    );
    sitting.presents_instead(&tray);
    // The sample that is not there cannot be named.
    let absent = Command::Answer {
        words: presented.clone(),
    };
    assert!(sitting.state.decide(&absent).is_err());
    let order = [tray[2].clone(), tray[0].clone(), tray[1].clone()];
    sitting.answers(&order);
    let orders = of_task(&sitting, "task2");
    let placed: Vec<&String> = orders.iter().map(|row| &row.presented).collect();
    assert_eq!(placed, order.iter().collect::<Vec<_>>());
    let mut stands: Vec<String> = orders.iter().map(|row| row.answered.clone()).collect();
    let physical = roughest_first(&protocol);
    let physical: Vec<String> = physical
        .into_iter()
        .filter(|one| tray.contains(one))
        .collect();
    assert_eq!(stands, physical);
    stands.sort();
    assert!(stands.contains(wrong));
    for row in &orders {
        assert_eq!(row.flags, [Flag::WrongSample]);
        assert_eq!(
            row.offered.iter().collect::<BTreeSet<_>>(),
            tray.iter().collect()
        );
    }
    // A is what stood first.
    sitting.presents(&[]);
    let (_, _, sequence) = sitting.current();
    sitting.answers(&vec!["A".to_owned(); sequence.len()]);
    for row in of_task(&sitting, "task3") {
        assert_eq!(row.answered, *wrong);
        assert!(row.offered.contains(wrong));
        // Nothing was measured in this session.
        assert_eq!(row.flags, [Flag::NotMeasured]);
    }
    AnswerTable::new(declared(&protocol), rows(&sitting)).unwrap();
}

/// Why `names` cannot be presented instead in the first trial of task 2.
fn refused_after_checks(
    protocol: &Protocol,
    plan: &piezotact_people::campaign::plan::Plan,
    names: &[&String],
) -> Refusal {
    let mut sitting = Sitting::begun(protocol, plan);
    sitting.until("task2");
    sitting.checks();
    let names = names.iter().map(|name| (*name).clone()).collect();
    let evidence = Vec::new();
    let command = Command::PresentInstead { names, evidence };
    sitting.state.decide(&command).unwrap_err()
}

#[test]
fn flags_are_of_the_element_they_are_about() {
    let protocol = library("isotropic_triplets");
    let plan = planned(&protocol, "discrimination");
    let mut sitting = Sitting::begun(&protocol, &plan);
    sitting.until("task3");
    let (_, _, presented) = sitting.current();
    let met = vec![Outcome::Met; presented.len()];
    // A void attempt, in which everything missed, leaves nothing.
    sitting.presents(&vec![Outcome::NotMet; presented.len()]);
    let why = "the cable came off".to_owned();
    sitting.does(Command::Void { why });
    sitting.presents(&met);
    // The second one misses when it is played again.
    sitting.does(Command::Play {
        element: 1,
        evidence: Some(evidence(&presented[1], Outcome::NotMet)),
    });
    sitting.answers(&vec!["A".to_owned(); presented.len()]);
    let found = of_task(&sitting, "task3");
    for (i, row) in found.iter().enumerate() {
        let expected: &[Flag] = if i == 1 { &[Flag::MissedTarget] } else { &[] };
        assert_eq!(row.flags, expected, "element {i}");
        assert_eq!(
            (row.presented.as_str(), row.position),
            (presented[i].as_str(), Some(i + 1))
        );
    }
    // Not decided is not missed.
    sitting.until("task3");
    let (name, _, presented) = sitting.current();
    sitting.presents(&vec![Outcome::NotDecided; presented.len()]);
    sitting.answers(&vec!["A".to_owned(); presented.len()]);
    let of_trial = |sitting: &Sitting<'_>, name: &str| -> Vec<Answer> {
        let rows = of_task(sitting, "task3").into_iter();
        rows.filter(|row| row.trial == name).collect()
    };
    assert!(
        of_trial(&sitting, &name)
            .iter()
            .all(|row| row.flags.is_empty())
    );
    // Another stimulus than the planned one in the last place.
    sitting.until("task3");
    let (name, _, mut felt) = sitting.current();
    let last = felt.len() - 1;
    felt[last] = protocol
        .samples
        .iter()
        .find(|one| **one != felt[last])
        .unwrap()
        .clone();
    sitting.presents_instead(&felt);
    sitting.answers(&vec!["B".to_owned(); felt.len()]);
    let rows = of_trial(&sitting, &name);
    let presented: Vec<String> = rows.iter().map(|row| row.presented.clone()).collect();
    assert_eq!(presented, felt);
    for (i, row) in rows.iter().enumerate() {
        let mut expected = vec![Flag::NotMeasured];
        expected.extend((i == last).then_some(Flag::WrongSample));
        assert_eq!(row.flags, expected, "element {i}");
    }
}

#[test]
fn a_correction_of_an_order_moves_what_a_b_and_c_mean() {
    let protocol = library("isotropic_triplets");
    let plan = planned(&protocol, "discrimination");
    let mut sitting = Sitting::begun(&protocol, &plan);
    sitting.until("task2");
    let (order, _, samples) = sitting.current();
    sitting.presents(&[]);
    sitting.answers(&samples);
    sitting.presents(&[]);
    let (_, _, sequence) = sitting.current();
    let letters = ["A", "B", "C"].iter().cycle().take(sequence.len());
    let letters: Vec<String> = letters.map(|letter| (*letter).to_owned()).collect();
    sitting.answers(&letters);
    let answered = |sitting: &Sitting<'_>| -> Vec<String> {
        of_task(sitting, "task3")
            .into_iter()
            .map(|row| row.answered)
            .collect()
    };
    let meant = |order: &[String]| -> Vec<String> {
        order.iter().cycle().take(sequence.len()).cloned().collect()
    };
    assert_eq!(answered(&sitting), meant(&samples));
    let mut corrected = samples.clone();
    corrected.rotate_left(1);
    sitting.does(Command::Correct {
        trial: order,
        words: corrected.clone(),
        why: "noted one slot off".to_owned(),
    });
    assert_eq!(answered(&sitting), meant(&corrected));
    let warnings: Vec<CampaignWarning> = sitting
        .state
        .warnings()
        .iter()
        .filter_map(Warning::kind)
        .collect();
    let anew = |warning: &CampaignWarning| {
        matches!(warning, CampaignWarning::OrderCorrected { answers: 1, .. })
    };
    assert!(warnings.iter().any(anew), "{warnings:?}");
    let orders = of_task(&sitting, "task2");
    let placed: Vec<String> = orders.into_iter().map(|row| row.presented).collect();
    assert_eq!(placed, corrected);
}

#[test]
fn inverted_textures_are_declared_with_the_sample_they_are_expected_as() {
    let protocol = library("amplitude_inversion");
    let found = declared(&protocol);
    assert_eq!(found.samples, protocol.samples);
    let inverted = found.stimuli.iter().find(|one| one.name == "S2 INVERTED");
    assert_eq!(
        inverted,
        Some(&Stimulus::manipulated("S2 INVERTED", "S2", "S13"))
    );
    assert_eq!(
        found.stimuli.len(),
        protocol.samples.len() + protocol.stimuli.len()
    );
    let session = &protocol.sessions.last().unwrap().name;
    let plan = planned(&protocol, session);
    let mut sitting = Sitting::begun(&protocol, &plan);
    sitting.finishes();
    let table = AnswerTable::new(found.clone(), rows(&sitting)).unwrap();
    assert!(
        table
            .answers()
            .iter()
            .any(|row| row.presented == "S2 INVERTED")
    );
    let written = answers_table(&found, table.answers());
    let at = |name: &str| {
        ANSWER_COLUMNS
            .iter()
            .position(|column| *column == name)
            .unwrap()
    };
    for row in &written.rows {
        let of = |name: &str| row[at(name)].whole();
        let expected = match of("presented").strip_suffix(" INVERTED") {
            Some(source) => {
                let made = protocol
                    .stimuli
                    .iter()
                    .find(|one| one.name == of("presented"));
                [source.to_owned(), made.unwrap().expected().to_owned()]
            }
            None => [String::new(), String::new()],
        };
        assert_eq!([of("source"), of("expected")], expected);
    }
}

/// Every cell that is written has a meaning in the dictionary, and is one of the levels where these are listed.
#[test]
fn the_dictionary_describes_what_is_written() {
    let mut cells = 0;
    for (name, _) in LIBRARY {
        let protocol = library(name);
        let described = dictionary(&protocol);
        for session in &protocol.sessions {
            let plan = planned(&protocol, &session.name);
            let mut sitting = Sitting::begun(&protocol, &plan);
            while sitting.state.current().is_some() {
                sitting.anyhow(&[Outcome::NotMet, Outcome::Met]);
            }
            let table = answers_table(&declared(&protocol), &rows(&sitting));
            let columns: Vec<&str> = table.columns.iter().map(|one| one.name.as_str()).collect();
            assert_eq!(columns, ANSWER_COLUMNS);
            for row in &table.rows {
                let task = row[2].whole();
                let task = described.tasks.iter().find(|one| one.task == task).unwrap();
                for (column, cell) in columns.iter().zip(row) {
                    let cell = cell.whole();
                    if cell.is_empty() {
                        continue;
                    }
                    let place = format!("{name} {} {column} `{cell}`", task.task);
                    let meaning = task.meanings.get(*column);
                    let meaning = meaning.unwrap_or_else(|| panic!("{place}: not described"));
                    let separator = if *column == "flags" { ' ' } else { '|' };
                    for part in cell.split(separator) {
                        let listed = &meaning.levels;
                        assert!(listed.is_empty() || listed.contains_key(part), "{place}");
                    }
                    if *column == "session" && cell != session.name {
                        let (own, number) = cell.split_once(", repetition ").unwrap();
                        assert_eq!(own, session.name);
                        assert!(number.parse::<u32>().unwrap() > 1);
                        assert!(
                            meaning.description.contains("`NAME, repetition 2`"),
                            "{place}"
                        );
                    }
                    cells += 1;
                }
            }
        }
    }
    assert!(cells > 1000, "{cells}");
}

#[test]
fn an_adaptive_run_that_ended_planned_no_more_trials_than_it_had() {
    let protocol = library("roughness_jnd");
    let plan = planned(&protocol, "discrimination");
    let mut sitting = Sitting::begun(&protocol, &plan);
    sitting.finishes();
    let states = [(&sitting.state, store::Purpose::Volunteer)];
    let table = participants_table(states);
    let of = |name: &str| {
        let at = table
            .columns
            .iter()
            .position(|column| column.name == name)
            .unwrap();
        table.rows[0][at].whole()
    };
    assert_eq!(of("confirmed"), of("planned"));
    let most = plan.trials.len();
    assert!(of("planned").parse::<usize>().unwrap() < most, "{most}");
}
