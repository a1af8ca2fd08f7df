//! Pairs of samples, and who keeps to one name.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact::criterion::Outcome;
use piezotact_people::association::{
    Answer, AnswerTable, AssociationConfig, ConfusedPair, Declared, PairOutcome, associate,
};

/// Answers of ten people in a task: of each sample (of S1 to S3) so many, with what is answered to its n-th.
fn of_ten(
    task: &str,
    times: [usize; 3],
    says: impl Fn(usize, usize, usize) -> usize,
) -> Vec<Answer> {
    let names = ["S1", "S2", "S3"];
    let mut all = Vec::new();
    for person in 0..10 {
        for (sample, times) in times.into_iter().enumerate() {
            for time in 0..times {
                all.push(Answer {
                    participant: format!("P{person}"),
                    task: task.into(),
                    trial: format!("{sample}.{time}"),
                    presented: names[sample].into(),
                    answered: names[says(person, sample, time)].into(),
                    ..Answer::default()
                });
            }
        }
    }
    all
}

fn pair_of(answers: Vec<Answer>, task: Option<&str>) -> PairOutcome {
    let table = AnswerTable::new(Declared::plain(&["S1", "S2", "S3"]), answers).unwrap();
    let mut config = AssociationConfig::default();
    config.matrix.selection.task = task.map(Into::into);
    let found = associate(&table, &config).unwrap().pairs;
    let pair = found.iter().find(|one| one.pair == ["S1", "S2"]).unwrap();
    pair.outcome
}

/// A sample that is presented rarely weighs as its partner: 37 of 40 presentations of S2 are called S1.
#[test]
fn a_rare_sample_that_is_always_called_the_other_is_confused() {
    let says = |person: usize, sample: usize, time: usize| match sample {
        1 if (person, time) == (0, 0) => 1,
        1 => 0,
        0 if time == 0 && person.is_multiple_of(2) => 1,
        sample => sample,
    };
    assert_eq!(
        pair_of(of_ten("3", [24, 4, 24], says), None),
        PairOutcome::Confused
    );
    // Always S1: right in three quarters of both together, and nothing felt.
    let always = pair_of(of_ten("3", [24, 4, 4], |_, _, _| 0), None);
    assert_ne!(always, PairOutcome::NotConfused);
}

/// Everybody keeps to one name of their own, which is presented to them most often: right, and nothing felt.
#[test]
fn who_keeps_to_one_name_is_not_above_chance() {
    let names = ["S1", "S2", "S3", "S4", "S5", "S6"];
    let answers = (0..12).flat_map(|person| {
        (0..60).map(move |trial| {
            let sample = if trial % 10 < 7 {
                person % 6
            } else {
                trial % 6
            };
            Answer {
                participant: format!("P{person:02}"),
                task: "3".into(),
                trial: trial.to_string(),
                presented: names[sample].into(),
                answered: names[person % 6].into(),
                ..Answer::default()
            }
        })
    });
    let table = AnswerTable::new(Declared::plain(&names), answers.collect()).unwrap();
    let found = associate(&table, &AssociationConfig::default()).unwrap();
    let share = &found.expected[0];
    assert!(share.criterion.found.unwrap() > 0.7);
    assert_ne!(share.criterion.outcome, Outcome::Met, "{}", share.words());
    let not_confused = |pair: &&ConfusedPair| pair.outcome == PairOutcome::NotConfused;
    assert_eq!(found.pairs.iter().filter(not_confused).count(), 0);
}

/// Told apart when touched and confused when rendered: neither is said of both together.
#[test]
fn pairs_that_tasks_decide_otherwise_are_not_decided_together() {
    let coin = |person: usize, sample: usize, time: usize| match sample {
        2 => 2,
        sample if (person + time).is_multiple_of(2) => 1 - sample,
        sample => sample,
    };
    let real = of_ten("real", [20; 3], |_, sample, _| sample);
    let both = [real, of_ten("rendered", [6; 3], coin)].concat();
    let of = |task: Option<&str>| pair_of(both.clone(), task);
    assert_eq!(of(Some("rendered")), PairOutcome::Confused);
    assert_eq!(of(Some("real")), PairOutcome::NotConfused);
    assert_eq!(of(None), PairOutcome::NotDecided);
}

/// A name that stands twice in what was offered is one name.
#[test]
fn a_name_offered_twice_counts_once() {
    let mut of = of_ten("3", [4, 4, 0], |_, sample, _| sample);
    for answer in &mut of {
        answer.offered = ["S1", "S2", "S2", "S2"].map(Into::into).to_vec();
    }
    let table = AnswerTable::new(Declared::plain(&["S1", "S2"]), of).unwrap();
    let found = associate(&table, &AssociationConfig::default()).unwrap();
    assert_eq!(found.expected[0].chance_share, 0.5);
}
