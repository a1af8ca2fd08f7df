//! Ways of being the same person twice in a table of answers are named, and people who agree for good reasons are not.
#![allow(
    clippy::disallowed_methods,
    clippy::unwrap_used,
    reason = "a test reads measured files and fails where it cannot go on"
)]

use std::collections::BTreeSet;

use piezotact::compare::{CompareWarning, Mixed, Named};
use piezotact::criterion::Outcome;
use piezotact::statistics::random::Random;
use piezotact_people::association::{
    Answer, AnswerTable, Association, AssociationConfig, AssociationWarning, Counted, Declared,
    Matching, PairOutcome, SameBy, SamePerson, associate, compared,
};
use piezotact_people::difference::Difference;

use crate::shared_data::shared;

const SAMPLES: [&str; 6] = ["S1", "S2", "S3", "S4", "S5", "S6"];

/// Answers of one person: right in a share `right` of the trials, else anything. Stimuli come in an order of their own.
fn person(name: &str, task: &str, trials: usize, right: f64, random: &mut Random) -> Vec<Answer> {
    let mut order: Vec<usize> = (0..trials).map(|i| i % SAMPLES.len()).collect();
    shuffle(&mut order, random);
    let any = |random: &mut Random| (random.uniform() * SAMPLES.len() as f64) as usize;
    order
        .into_iter()
        .enumerate()
        .map(|(i, presented)| {
            let said = match random.uniform() < right {
                true => presented,
                false => any(random),
            };
            answer(name, task, i + 1, SAMPLES[presented], SAMPLES[said])
        })
        .collect()
}

fn answer(name: &str, task: &str, trial: usize, presented: &str, answered: &str) -> Answer {
    Answer {
        participant: name.into(),
        session: "1".into(),
        task: task.into(),
        trial: trial.to_string(),
        presented: presented.into(),
        answered: answered.into(),
        ..Answer::default()
    }
}

fn shuffle<T>(values: &mut [T], random: &mut Random) {
    for i in (1..values.len()).rev() {
        values.swap(i, (random.uniform() * (i + 1) as f64) as usize);
    }
}

fn people(count: usize, trials: usize, right: f64, seed: u64) -> Vec<Answer> {
    let mut random = Random::stream(seed, 0, "people");
    (1..=count)
        .flat_map(|i| person(&format!("P{i:02}"), "3", trials, right, &mut random))
        .collect()
}

fn table(answers: Vec<Answer>) -> AnswerTable {
    AnswerTable::new(Declared::plain(&SAMPLES), answers).unwrap()
}

fn same(answers: Vec<Answer>) -> Vec<SamePerson> {
    table(answers).same_people()
}

fn association(answers: Vec<Answer>) -> Association {
    associate(&table(answers), &AssociationConfig::default()).unwrap()
}

/// Answers of five people who feel little: alone they decide nothing, and as ten they would be above chance.
fn little() -> Vec<Answer> {
    let found = (0..100).find_map(|seed| {
        let five = people(5, 48, 0.07, seed);
        let above = |answers: Vec<Answer>| {
            let share = association(answers).expected.remove(0).criterion;
            share.limit.judge(share.interval.unwrap()) == Outcome::Met
        };
        let ten = [five.clone(), pasted(&five, 5)].concat();
        (!above(five.clone()) && above(ten)).then_some(five)
    });
    found.unwrap()
}

/// `answers` of the first `count` people again, each under the name that many further on.
fn pasted(answers: &[Answer], count: usize) -> Vec<Answer> {
    let again = answers.iter().filter_map(|one| {
        let number: usize = one.participant[1..].parse().unwrap();
        let mut copy = one.clone();
        copy.participant = format!("P{:02}", number + count);
        (number <= count).then_some(copy)
    });
    again.collect()
}

/// The pairs that are named by their answers.
fn pairs(found: &[SamePerson]) -> BTreeSet<[String; 2]> {
    let answers = found
        .iter()
        .filter(|one| matches!(one.by, SameBy::Answers { .. }));
    answers
        .map(|one| [one.one.participant.clone(), one.other.participant.clone()])
        .collect()
}

fn copies(count: usize) -> BTreeSet<[String; 2]> {
    (1..=count)
        .map(|i| [format!("P{i:02}"), format!("P{:02}", i + count)])
        .collect()
}

#[test]
fn rows_pasted_with_other_names_are_named_and_decide_nothing() {
    let five = little();
    let once = association(five.clone());
    assert_eq!(once.expected[0].criterion.outcome, Outcome::NotDecided);
    assert!(once.same_people.is_empty() && once.expected[0].recounts.is_empty());
    let ten: Vec<Answer> = [five.clone(), pasted(&five, 5)].concat();
    let found = association(ten);
    assert_eq!(pairs(&found.same_people), copies(5));
    let share = &found.expected[0];
    let limit = share.criterion.limit;
    // The interval alone would say above chance.
    assert_eq!(limit.judge(share.criterion.interval.unwrap()), Outcome::Met);
    assert_eq!(share.criterion.outcome, Outcome::NotDecided);
    assert_eq!(share.recounts[0].counted, Counted::Once);
    assert_eq!(
        share.recounts[0].interval,
        once.expected[0].criterion.interval
    );
    let said = found.sentence();
    assert!(
        said.contains("not decided with those who may be one person counted once"),
        "{said}"
    );
    let named = found.warnings.iter().filter(|warning| {
        matches!(
            warning.kind(),
            Some(AssociationWarning::SameAnswers {
                matching: Matching::Trial,
                matched: 48,
                alike: 48,
                ..
            })
        )
    });
    assert_eq!(named.count(), 5);
    // Ten people of whom each answered are above chance.
    let honest = association(people(10, 48, 0.14, 3));
    assert_eq!(honest.expected[0].criterion.outcome, Outcome::Met);
    assert!(honest.same_people.is_empty());
}

/// What does not rest on the copies stays decided.
#[test]
fn a_strong_effect_holds_with_people_counted_once() {
    let five = people(5, 48, 0.6, 5);
    let found = association([five.clone(), pasted(&five, 5)].concat());
    assert_eq!(pairs(&found.same_people), copies(5));
    assert_eq!(found.expected[0].criterion.outcome, Outcome::Met);
    assert_eq!(found.expected[0].recounts[0].outcome, Outcome::Met);
}

#[test]
fn rows_in_another_order_are_named() {
    let five = people(5, 60, 0.4, 7);
    let mut again = pasted(&five, 5);
    shuffle(&mut again, &mut Random::stream(1, 0, "order"));
    assert_eq!(
        pairs(&same([five.clone(), again.clone()].concat())),
        copies(5)
    );
    // With other trial numbers, so that no trial is the same.
    for (i, one) in again.iter_mut().enumerate() {
        one.trial = (i + 1000).to_string();
    }
    let found = same([five, again].concat());
    assert_eq!(pairs(&found), copies(5));
    let by_counts = |one: &SamePerson| {
        matches!(
            one.by,
            SameBy::Answers {
                matching: Matching::Counts,
                ..
            }
        )
    };
    assert!(found.iter().any(by_counts), "{found:?}");
}

#[test]
fn answers_of_which_a_few_were_changed_are_named() {
    let five = people(5, 60, 0.4, 11);
    let mut again = pasted(&five, 5);
    let mut random = Random::stream(2, 0, "changed");
    for one in &mut again {
        if random.uniform() < 0.1 {
            one.answered = SAMPLES[(random.uniform() * 6.0) as usize].into();
        }
    }
    assert_eq!(pairs(&same([five, again].concat())), copies(5));
}

#[test]
fn trials_numbered_anew_and_a_part_of_them_are_named() {
    let five = people(5, 60, 0.4, 13);
    let mut again = pasted(&five, 5);
    for one in &mut again {
        let trial: usize = one.trial.parse().unwrap();
        one.trial = format!("run-{trial}");
    }
    assert_eq!(pairs(&same([five.clone(), again].concat())), copies(5));
    let mut half = pasted(&five, 5);
    half.retain(|one| one.trial.parse::<usize>().unwrap() > 25);
    assert_eq!(pairs(&same([five, half].concat())), copies(5));
}

#[test]
fn a_table_appended_as_a_second_session_is_named() {
    let five = little();
    let again = five.iter().map(|one| Answer {
        session: "2".into(),
        ..one.clone()
    });
    let both: Vec<Answer> = five.iter().cloned().chain(again).collect();
    let found = association(both);
    let sessions = found.same_people.iter().map(|one| {
        assert_eq!(one.one.participant, one.other.participant);
        [&one.one.session, &one.other.session].map(|name| name.clone().unwrap())
    });
    let sessions: Vec<[String; 2]> = sessions.collect();
    assert_eq!(sessions, vec![["1".to_owned(), "2".to_owned()]; 5]);
    // The same answers twice decide nothing more than once.
    let once = association(five);
    let recount = found.expected[0].recounts[0];
    assert_eq!(recount.interval, once.expected[0].criterion.interval);
    assert_eq!(found.expected[0].criterion.outcome, Outcome::NotDecided);
}

#[test]
fn a_session_or_a_task_of_somebody_else_is_named() {
    let mut random = Random::stream(17, 0, "sessions");
    let mut all = Vec::new();
    for name in ["P01", "P02", "P03", "P04"] {
        for session in ["1", "2"] {
            let own = person(name, "3", 48, 0.4, &mut random);
            all.extend(own.into_iter().map(|one| Answer {
                session: session.into(),
                ..one
            }));
        }
    }
    assert!(same(all.clone()).is_empty());
    let of =
        |one: &Answer, who: &str, session: &str| one.participant == who && one.session == session;
    let taken: Vec<Answer> = all
        .iter()
        .filter(|one| of(one, "P01", "1"))
        .map(|one| Answer {
            participant: "P04".into(),
            session: "2".into(),
            ..one.clone()
        })
        .collect();
    let mut other = all.clone();
    other.retain(|one| !of(one, "P04", "2"));
    other.extend(taken);
    let found = same(other);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0].one.to_string(), "P01, session 1");
    assert_eq!(found[0].other.to_string(), "P04, session 2");
    // One task of two.
    let mut tasks = Vec::new();
    for name in ["P01", "P02", "P03", "P04"] {
        for task in ["3", "4"] {
            tasks.extend(person(name, task, 48, 0.4, &mut random));
        }
    }
    let taken: Vec<Answer> = tasks
        .iter()
        .filter(|one| one.participant == "P01" && one.task == "4")
        .map(|one| Answer {
            participant: "P04".into(),
            ..one.clone()
        })
        .collect();
    tasks.retain(|one| one.participant != "P04" || one.task != "4");
    tasks.extend(taken);
    let found = same(tasks);
    assert_eq!(found.len(), 1, "{found:?}");
    assert_eq!(found[0].other.to_string(), "P04, task 4");
}

#[test]
fn names_that_differ_in_case_zeros_or_blanks_are_named() {
    for [one, other] in [["P01", "p01"], ["P1", "P01"], ["P4", "P04"], ["P 4", "P4"]] {
        let mut random = Random::stream(19, 0, "names");
        let names = [one, other, "P10", "P11"];
        let answers = names
            .into_iter()
            .flat_map(|name| person(name, "3", 24, 0.5, &mut random));
        let found = association(answers.collect());
        assert_eq!(found.same_people.len(), 1);
        assert_eq!(found.same_people[0].by, SameBy::Name);
        let named = found.warnings.iter().any(|warning| {
            warning.kind()
                == Some(CompareWarning::Mixed {
                    how: Mixed::NamesAlike {
                        of: Named::Participant,
                        one: one.into(),
                        other: other.into(),
                    },
                })
        });
        assert!(named, "{:?}", found.warnings);
        assert_eq!(found.expected[0].recounts.len(), 1);
    }
    assert!(same(people(12, 24, 0.5, 23)).is_empty());
}

/// 400 of 480 answers of one person: their effect is not that of people.
#[test]
fn answers_of_mostly_one_person_are_named_and_decide_nothing() {
    let mut random = Random::stream(29, 0, "unbalanced");
    let mut answers = person("P01", "3", 400, 0.35, &mut random);
    for i in 2..=9 {
        answers.extend(person(&format!("P{i:02}"), "3", 10, 0.0, &mut random));
    }
    let found = association(answers);
    let unbalanced = found.unbalanced.clone().unwrap();
    assert_eq!((unbalanced.answers, unbalanced.of), (400, 480));
    assert_eq!(unbalanced.participant, "P01");
    let share = &found.expected[0];
    let limit = share.criterion.limit;
    assert_eq!(limit.judge(share.criterion.interval.unwrap()), Outcome::Met);
    assert_eq!(share.criterion.outcome, Outcome::NotDecided);
    assert_eq!(share.recounts[0].counted, Counted::Alike);
    let said = found.warnings.iter().map(ToString::to_string);
    let said: Vec<String> = said.collect();
    assert!(
        said.iter()
            .any(|one| one.contains("P01 gave 400 of 480 answers")),
        "{said:?}"
    );
    // Where everybody is right it stays decided.
    let mut answers = person("P01", "3", 400, 0.6, &mut random);
    for i in 2..=9 {
        answers.extend(person(&format!("P{i:02}"), "3", 12, 0.7, &mut random));
    }
    let found = association(answers);
    assert!(found.unbalanced.is_some());
    assert_eq!(found.expected[0].criterion.outcome, Outcome::Met);
    // Twice as many trials of one are nothing to mention.
    let mut answers = person("P01", "3", 48, 0.4, &mut random);
    for i in 2..=9 {
        answers.extend(person(&format!("P{i:02}"), "3", 24, 0.4, &mut random));
    }
    assert_eq!(association(answers).unbalanced, None);
}

/// Pairs of samples and comparisons that rest on copies are not decided.
#[test]
fn confused_pairs_and_differences_that_rest_on_copies_are_not_decided() {
    let mut random = Random::stream(31, 0, "pairs");
    let mut three = Vec::new();
    for (name, confused) in [("P01", 0.42), ("P02", 0.3), ("P03", 0.55)] {
        for trial in 1..=40 {
            let presented = ["S1", "S2"][trial % 2];
            let said = match random.uniform() < confused {
                true => ["S2", "S1"][trial % 2],
                false => presented,
            };
            three.push(answer(name, "3", trial, presented, said));
        }
    }
    let twice: Vec<Answer> = [3, 6, 9].into_iter().fold(three.clone(), |mut all, step| {
        all.extend(pasted(&three, 3).into_iter().map(|one| {
            let number: usize = one.participant[1..].parse().unwrap();
            Answer {
                participant: format!("P{:02}", number + step - 3),
                ..one
            }
        }));
        all
    });
    let outcome = |answers: Vec<Answer>| {
        let found = association(answers);
        let mut pairs = found.pairs.into_iter();
        pairs.find(|pair| pair.pair == ["S1", "S2"]).unwrap()
    };
    assert_eq!(outcome(three.clone()).outcome, PairOutcome::NotDecided);
    let found = outcome(twice.clone());
    assert_eq!(found.criterion.outcome, Outcome::Met);
    assert_eq!(found.outcome, PairOutcome::NotDecided);
    let samples = Difference::Samples(["S1".into(), "S2".into()]);
    let config = AssociationConfig::default().matrix;
    let found = compared(&table(twice), &config, &samples).unwrap();
    assert_eq!(found.participants, [12; 2]);
    assert_eq!(found.outcome(), Outcome::NotDecided);
    // Three people cannot show it.
    assert_eq!(found.p_once.map(|p| p > 0.05), Some(true));
}

/// Tables of people who answered for themselves, of which none may name two.
fn names_nobody(what: &str, tables: u64, make: impl Fn(&mut Random) -> Vec<Answer>) {
    let named = (0..tables).filter(|seed| {
        let mut random = Random::stream(*seed, 1, what);
        !same(make(&mut random)).is_empty()
    });
    let named: Vec<u64> = named.collect();
    assert!(named.is_empty(), "{what}: {named:?} of {tables}");
}

/// Answers of `count` people to `trials` in an order that all share, as `says` has it.
fn crowd(
    count: usize,
    trials: usize,
    random: &mut Random,
    says: impl Fn(usize, usize, usize, &mut Random) -> usize,
) -> Vec<Answer> {
    let mut order: Vec<usize> = (0..trials).map(|i| i % SAMPLES.len()).collect();
    shuffle(&mut order, random);
    let mut answers = Vec::new();
    for who in 1..=count {
        for (i, presented) in order.iter().enumerate() {
            let said = says(who, i, *presented, random);
            let name = format!("P{who:02}");
            answers.push(answer(
                &name,
                "3",
                i + 1,
                SAMPLES[*presented],
                SAMPLES[said],
            ));
        }
    }
    answers
}

fn any(random: &mut Random) -> usize {
    (random.uniform() * SAMPLES.len() as f64) as usize
}

#[test]
fn people_who_agree_for_good_reasons_are_not_named() {
    let tables = 40;
    let rightly = |share: f64| {
        move |_: usize, _: usize, presented: usize, random: &mut Random| {
            if random.uniform() < share {
                presented
            } else {
                any(random)
            }
        }
    };
    for right in [0.0, 0.5, 0.95, 0.99, 1.0] {
        for (count, trials) in [(2, 6), (3, 12), (10, 18), (10, 54)] {
            let what = format!("{right} right, {count} people, {trials} trials");
            names_nobody(&what, tables, |random| {
                crowd(count, trials, random, rightly(right))
            });
        }
    }
    names_nobody("always the first", tables, |random| {
        crowd(6, 54, random, |_, _, _, _| 0)
    });
    names_nobody("mostly the first", tables, |random| {
        crowd(6, 54, random, |_, _, _, random| {
            if random.uniform() < 0.9 {
                0
            } else {
                any(random)
            }
        })
    });
    // Everybody calls the fourth the sixth, and some the fifth the second.
    names_nobody("the same confusions", tables, |random| {
        crowd(8, 54, random, |who, _, presented, random| {
            match (presented, who % 2) {
                _ if random.uniform() < 0.05 => any(random),
                (3, _) => 5,
                (4, 0) => 1,
                (other, _) => other,
            }
        })
    });
    // All learn: the first answers are wrong, the last right.
    names_nobody("learning", tables, |random| {
        crowd(8, 120, random, |_, i, presented, random| {
            if random.uniform() < 0.2 + 0.8 * i as f64 / 120.0 {
                presented
            } else {
                any(random)
            }
        })
    });
    // The sample that was presented before is often said again: in one order that all share.
    let presented_before = |random: &mut Random| {
        let answers = crowd(8, 60, random, |_, _, presented, _| presented);
        let mut said = answers.clone();
        for i in 1..said.len() {
            if random.uniform() < 0.3 {
                said[i].answered = answers[i - 1].presented.clone();
            } else if random.uniform() < 0.2 {
                said[i].answered = SAMPLES[any(random)].into();
            }
        }
        said
    };
    names_nobody("the one before", tables, presented_before);
}

/// Two samples on offer in each trial, few trials.
#[test]
fn people_of_few_trials_with_few_alternatives_are_not_named() {
    names_nobody("two samples", 300, |random| {
        let mut answers = crowd(8, 12, random, |_, _, presented, random| {
            if random.uniform() < 0.7 {
                presented
            } else {
                presented ^ 1
            }
        });
        for one in &mut answers {
            let pair = SAMPLES.iter().position(|name| *name == one.presented);
            let pair = pair.unwrap() / 2 * 2;
            one.offered = SAMPLES[pair..pair + 2].iter().map(|&s| s.into()).collect();
        }
        answers
    });
}

/// The answers of a table with a header, of which the columns are participant, task, trial, position, presented, offered and answered.
fn read(path: &std::path::Path) -> Vec<Answer> {
    let text = std::fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let rows = lines.map(|line| {
        let cells: Vec<&str> = line.split(',').collect();
        let cell = |name: &str| {
            let place = header.iter().position(|column| *column == name);
            place.map_or("", |place| cells[place]).to_owned()
        };
        Answer {
            participant: cell("participant"),
            task: cell("task"),
            trial: cell("trial"),
            presented: cell("presented"),
            answered: cell("answered"),
            position: cell("position").parse().ok(),
            offered: match cell("offered").as_str() {
                "" => Vec::new(),
                names => names.split('|').map(Into::into).collect(),
            },
            ..Answer::default()
        }
    });
    rows.collect()
}

/// Everything that answers name.
fn declared(answers: &[Answer]) -> Declared {
    let names = answers
        .iter()
        .flat_map(|one| [&one.presented, &one.answered]);
    let names: BTreeSet<&str> = names.map(String::as_str).collect();
    Declared::plain(&names.into_iter().collect::<Vec<_>>())
}

/// 32 judges put four samples in one of 24 orders: several have the same, and are not one.
#[test]
fn judges_with_the_same_order_of_four_are_not_named() {
    let Some(path) = shared("data/psychophysics/tartness_orders.csv") else {
        return;
    };
    let answers = read(&path);
    let table = AnswerTable::new(declared(&answers), answers).unwrap();
    assert_eq!(table.same_people(), []);
}

/// 5,040 comparisons with a reference are no associations.
#[test]
fn a_table_of_forced_choices_is_refused_with_what_is_missing() {
    if let Some(path) = shared("data/psychophysics/speed_under_vibration_answers.csv") {
        let answers = read(&path);
        let said = AnswerTable::new(declared(&answers), answers).unwrap_err();
        let said = said.to_string();
        for part in [
            "a table of forced choices: expected the name of a sample",
            "found only `faster`, `slower` in 5040 answers",
            "what is missing is the reference",
            "`c1.0`, `c11.0` and 5 more",
        ] {
            assert!(said.contains(part), "no {part} in: {said}");
        }
    }
    let of = |said: &dyn Fn(usize) -> &'static str, count: usize| -> Result<AnswerTable, _> {
        let answers = (0..count).map(|i| answer("P1", "3", i + 1, SAMPLES[i % 4], said(i)));
        let answers: Vec<Answer> = answers.collect();
        AnswerTable::new(declared(&answers), answers)
    };
    assert!(of(&|i| ["yes", "no"][i % 2], 20).is_err());
    assert!(of(&|i| ["rougher", "smoother", "same"][i % 3], 20).is_err());
    // Names of samples, once of what was presented; and few answers, all wrong.
    assert!(of(&|i| ["S5", "S1"][usize::from(i > 18)], 20).is_ok());
    assert!(of(&|i| ["S5", "S6"][i % 2], 6).is_ok());
    // What is declared does not make samples of the words.
    let answers = (0..20).map(|i| answer("P1", "3", i + 1, SAMPLES[i % 4], ["yes", "no"][i % 2]));
    let refused = AnswerTable::new(Declared::plain(&SAMPLES), answers.collect());
    let refused = refused.unwrap_err().to_string();
    assert!(refused.contains("forced choices"), "{refused}");
}
