//! Whether two samples, tasks or groups of people differ: people who guess, who have habits, and who tell them apart.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact::criterion::Outcome;
use piezotact::statistics::random::Random;
use piezotact_people::association::{
    Answer, AnswerTable, Association, AssociationConfig, AssociationWarning, Compared, Declared,
    MatrixConfig, Stimulus, associate, compared, compared_studies,
};
use piezotact_people::difference::{
    Difference, LEVEL_SHARE, between_interval, between_people, paired_interval,
};
use serde_json::Value;

fn two(a: &str, b: &str) -> [String; 2] {
    [a.into(), b.into()]
}

fn samples(a: &str, b: &str) -> Difference {
    Difference::Samples(two(a, b))
}

/// The answers of people to S1, S2 and S3, all on offer, each `times`; `says` gives the answer of a person to a sample in a task.
fn table(
    people: usize,
    tasks: &[&str],
    times: usize,
    mut says: impl FnMut(usize, &str, usize) -> usize,
) -> AnswerTable {
    let names = ["S1", "S2", "S3"].map(str::to_owned);
    let mut answers = Vec::new();
    for person in 0..people {
        for task in tasks {
            for trial in 0..3 * times {
                answers.push(Answer {
                    participant: format!("P{person:02}"),
                    task: (*task).into(),
                    trial: trial.to_string(),
                    presented: names[trial % 3].clone(),
                    answered: names[says(person, task, trial % 3)].clone(),
                    offered: names.to_vec(),
                    ..Answer::default()
                });
            }
        }
    }
    let stimuli = names.iter().map(|name| Stimulus::plain(name)).collect();
    let declared = Declared {
        samples: names.to_vec(),
        stimuli,
    };
    AnswerTable::new(declared, answers).unwrap()
}

fn of(table: &AnswerTable, difference: &Difference) -> Compared {
    compared(table, &MatrixConfig::default(), difference).unwrap()
}

/// The matrices of `table` with comparisons.
fn with(table: &AnswerTable, found: Vec<Compared>) -> Association {
    let matrices = associate(table, &AssociationConfig::default()).unwrap();
    matrices.with_comparisons(found)
}

fn below(random: &mut Random, n: usize) -> usize {
    (random.uniform() * n as f64) as usize
}

/// Guessers, each with a habit: some prefer one name, some two. At most 5 % are told apart.
#[test]
fn guessers_with_habits_tell_nothing_apart() {
    let mut found = 0;
    let campaigns = 300;
    for campaign in 0..campaigns {
        let mut random = Random::stream(campaign, 0, "habits");
        let habits: Vec<[f64; 3]> = (0..8)
            .map(|_| [0; 3].map(|_| random.uniform().powi(2)))
            .collect();
        let table = table(8, &["naming"], 4, |person, _, _| {
            let habit = habits[person];
            let drawn = random.uniform() * habit.iter().sum::<f64>();
            usize::from(drawn > habit[0]) + usize::from(drawn > habit[0] + habit[1])
        });
        found += u64::from(of(&table, &samples("S1", "S2")).outcome() == Outcome::Met);
    }
    // 5 % and three standard deviations.
    assert!(
        found as f64 <= campaigns as f64 * 0.05 + 3.0 * (campaigns as f64 * 0.0475).sqrt(),
        "{found}"
    );
}

#[test]
fn constant_answers_tell_nothing_apart_and_right_ones_do() {
    let always = table(10, &["naming"], 3, |_, _, _| 0);
    let always = of(&always, &samples("S1", "S2"));
    assert_eq!((always.less_share, always.test.p_value), (0.0, 1.0));
    assert_eq!(always.verdict(), "not decided");
    let right = table(10, &["naming"], 3, |_, _, presented| presented);
    let right = of(&right, &samples("S1", "S2"));
    assert_eq!(
        (right.shares, right.verdict()),
        ([1.0, 0.0], "told apart better than by guessing")
    );
    assert_eq!(right.by_sample, Some([[1.0, 0.0]; 2]));
    // All alike: nothing says how people differ.
    assert_eq!(right.interval, None);
    assert!((right.test.p_value - 2f64.powi(-9)).abs() < 1e-12);
    let swapped = table(10, &["naming"], 3, |_, _, presented| match presented {
        0 => 1,
        1 => 0,
        other => other,
    });
    let swapped = of(&swapped, &samples("S1", "S2"));
    assert_eq!(swapped.verdict(), "called the other more often than right");
    // Five people cannot show it, however right they are.
    let few = table(5, &["naming"], 9, |_, _, presented| presented);
    let few = of(&few, &samples("S1", "S2"));
    assert_eq!(few.outcome(), Outcome::NotDecided);
    assert!(
        few.sentence()
            .contains("not decided: with so few participants no difference reaches 5 %"),
        "{}",
        few.sentence()
    );
}

#[test]
fn tasks_differ_over_people_and_not_over_answers() {
    // One person who is always right in one task: many answers, and no difference of people.
    let one = table(9, &["a", "b"], 30, |person, task, presented| {
        match (person, task) {
            (0, "a") => presented,
            _ => (presented + 1) % 3,
        }
    });
    let one = of(&one, &Difference::Tasks(two("a", "b")));
    assert_eq!(one.test.p_value, 1.0, "{one:?}");
    let all = table(9, &["a", "b"], 2, |_, task, presented| match task {
        "a" => presented,
        _ => 0,
    });
    let all = of(&all, &Difference::Tasks(two("a", "b")));
    assert_eq!(all.verdict(), "they differ");
    assert_eq!((all.less_share * 3.0).round(), 2.0);
    for chance in all.chance_shares.unwrap() {
        assert!((chance - 1.0 / 3.0).abs() < 1e-12);
    }
}

/// Answers of ten people to S1 (always right), S2 (every other time) and S3 (never), each so many times, in a task.
fn unlike(task: &str, times: [usize; 3]) -> Vec<Answer> {
    let names = ["S1", "S2", "S3"];
    let mut answers = Vec::new();
    for person in 0..10 {
        for (sample, times) in times.into_iter().enumerate() {
            for time in 0..times {
                let said = match sample {
                    1 if time % 2 == 0 => "S2",
                    _ => "S1",
                };
                answers.push(Answer {
                    participant: format!("P{person:02}"),
                    task: task.into(),
                    trial: format!("{sample}.{time}"),
                    presented: names[sample].into(),
                    answered: said.into(),
                    offered: names.map(str::to_owned).to_vec(),
                    ..Answer::default()
                });
            }
        }
    }
    answers
}

/// The easy sample more often in one task, the hard one in the other: nobody is better in either.
#[test]
fn a_task_with_more_of_the_easy_sample_is_not_better() {
    let of = |first: [usize; 3], second: [usize; 3]| {
        let answers = [unlike("a", first), unlike("b", second)].concat();
        let table = AnswerTable::new(Declared::plain(&["S1", "S2", "S3"]), answers).unwrap();
        of(&table, &Difference::Tasks(two("a", "b")))
    };
    let found = of([16, 4, 4], [4, 4, 16]);
    assert_eq!(
        (found.shares, found.less_share, found.stimuli),
        ([0.5; 2], 0.0, Some(3))
    );
    assert_eq!(found.outcome(), Outcome::NotDecided);
    // The sample that one task alone has does not count.
    let found = of([8, 4, 0], [8, 4, 8]);
    assert_eq!(
        (found.less_share, found.stimuli, found.stimuli_left_out),
        (0.0, Some(2), 1)
    );
    assert!(
        found
            .sentence()
            .contains("1 presented sample of one only left out")
    );
    let found = of([8, 4, 0], [0, 0, 8]);
    assert_eq!((found.shares, found.stimuli), ([0.75, 0.0], Some(0)));
    assert_eq!(
        found.verdict(),
        "they differ, and so do the samples: not decided why"
    );
}

/// The weak drop out: whether two groups with pseudonyms in common differ depends on who they are.
#[test]
fn groups_with_pseudonyms_in_common_differ_on_a_condition() {
    let config = MatrixConfig::default();
    let right = |people: std::ops::Range<usize>, share: f64| {
        let all = table(people.end, &["3"], 8, |person, _, presented| {
            match (person as f64) < share * people.end as f64 {
                true => presented,
                false => (presented + 1) % 3,
            }
        });
        let answers = all.answers().iter();
        let kept = answers.filter(|one| one.participant >= format!("P{:02}", people.start));
        AnswerTable::new(all.declared().clone(), kept.cloned().collect()).unwrap()
    };
    let (one, other) = (right(0..12, 0.1), right(10..22, 1.0));
    let found = compared_studies(
        [(&one, &config), (&other, &config)],
        &Difference::People(two("a", "b")),
    );
    let found = found.unwrap();
    assert_eq!(found.in_both, 2);
    assert!(found.p_value < 0.001 && found.verdict().contains("same pseudonym"));
}

/// Answers in a task of people who are all right with one probability, of two samples in turn.
fn drawn(task: &str, people: usize, trials: usize, right: f64, random: &mut Random) -> Vec<Answer> {
    let names = ["S1", "S2"];
    let mut answers = Vec::new();
    for person in 0..people {
        for trial in 0..trials {
            let sample = trial % 2;
            let said = if random.uniform() < right {
                sample
            } else {
                1 - sample
            };
            answers.push(Answer {
                participant: format!("P{person:02}"),
                task: task.into(),
                trial: trial.to_string(),
                presented: names[sample].into(),
                answered: names[said].into(),
                offered: names.map(str::to_owned).to_vec(),
                ..Answer::default()
            });
        }
    }
    answers
}

/// Near 100 and 0 %, with unequal numbers of trials, people who are alike show no spread in one condition: 25 % of such studies of tasks, and
/// 15 % of groups, differed by their permutation alone.
#[test]
fn conditions_at_the_ceiling_with_unequal_trials_do_not_differ() {
    let config = MatrixConfig::default();
    let table =
        |answers: Vec<Answer>| AnswerTable::new(Declared::plain(&["S1", "S2"]), answers).unwrap();
    let studies = 150;
    let (mut tasks, mut groups) = ([0; 2], [0; 2]);
    for study in 0..studies {
        let mut random = Random::stream(study, 0, "ceiling");
        let both = [
            drawn("a", 12, 6, 0.98, &mut random),
            drawn("b", 12, 60, 0.98, &mut random),
        ];
        let found = of(&table(both.concat()), &Difference::Tasks(two("a", "b")));
        tasks[0] += usize::from(found.outcome() == Outcome::Met);
        tasks[1] += usize::from(found.test.p_value <= LEVEL_SHARE);
        let mut other = drawn("a", 6, 6, 0.04, &mut random);
        for answer in &mut other {
            answer.participant.insert(0, 'Q');
        }
        let one = table(drawn("a", 8, 24, 0.04, &mut random));
        let found = compared_studies(
            [(&one, &config), (&table(other), &config)],
            &Difference::People(two("a", "b")),
        );
        let found = found.unwrap();
        groups[0] += usize::from(found.outcome() == Outcome::Met);
        groups[1] += usize::from(found.test.p_value <= LEVEL_SHARE);
        let [low, high] = found.interval.unwrap_or([-1.0, 1.0]);
        assert_eq!(
            found.p_value > LEVEL_SHARE,
            low <= 0.0 && 0.0 <= high,
            "{found:?}"
        );
    }
    // 5 % and three standard deviations are 15 of 150; by the permutation alone twice as many and more.
    assert!(tasks[0] <= 15 && tasks[1] > 20, "{tasks:?}");
    assert!(groups[0] <= 15 && groups[1] > 10, "{groups:?}");
}

/// The same people under other names, a quarter of their answers mended: they are found in both groups by their answers.
#[test]
fn people_renamed_in_the_other_group_are_found() {
    let config = MatrixConfig::default();
    let mut random = Random::stream(31, 0, "renamed");
    let one = table(10, &["3"], 20, |_, _, presented| {
        if random.uniform() < 0.6 {
            presented
        } else {
            below(&mut random, 3)
        }
    });
    let renamed = one.answers().iter().map(|answer| {
        let mut other = answer.clone();
        other.participant = format!("X{}", other.participant);
        if random.uniform() < 0.1 {
            other.answered.clone_from(&other.presented);
        }
        other
    });
    let other = AnswerTable::new(one.declared().clone(), renamed.collect()).unwrap();
    let people = Difference::People(two("a", "b"));
    let found = compared_studies([(&one, &config), (&other, &config)], &people).unwrap();
    assert!(found.same_answers >= 8, "{}", found.same_answers);
    assert!(found.verdict().contains("may be the same people"));
    // Others with the same habits are not.
    let stranger = table(10, &["3"], 20, |_, _, presented| {
        if random.uniform() < 0.6 {
            presented
        } else {
            below(&mut random, 3)
        }
    });
    let renamed = stranger.answers().iter().map(|answer| {
        let mut other = answer.clone();
        other.participant = format!("X{}", other.participant);
        other
    });
    let other = AnswerTable::new(one.declared().clone(), renamed.collect()).unwrap();
    let found = compared_studies([(&one, &config), (&other, &config)], &people).unwrap();
    assert_eq!(found.same_answers, 0);
}

#[test]
fn groups_differ_over_people() {
    let mut random = Random::stream(3, 0, "groups");
    let guessers = table(8, &["naming"], 6, |_, _, _| below(&mut random, 3));
    let others = table(9, &["naming"], 6, |_, _, _| below(&mut random, 3));
    let right = table(9, &["naming"], 6, |_, _, presented| presented);
    let people = Difference::People(two("own", "averaged"));
    let of = |a, b, difference| {
        let all = MatrixConfig::default();
        compared_studies([(a, &all), (b, &all)], difference).unwrap()
    };
    let alike = of(&guessers, &others, &people);
    assert_eq!(alike.verdict(), "not decided");
    let apart = of(&guessers, &right, &people);
    assert_eq!(
        (apart.participants, apart.verdict()),
        (
            [8, 9],
            "they differ, if those with the same pseudonym are different people"
        )
    );
    assert!(
        apart.sentence().contains("groups of 8 and 9 participants"),
        "{}",
        apart.sentence()
    );
    // The same people again: the ninth is left out.
    let again = of(
        &guessers,
        &right,
        &Difference::Again(two("own", "averaged")),
    );
    assert_eq!((again.participants, again.left_out), ([8, 8], 1));
}

#[test]
fn welch_s_t_and_its_permutation_are_those_of_scipy() {
    let golden: Value = serde_json::from_str(include_str!("golden/differences.json")).unwrap();
    for case in golden["groups"].as_array().unwrap() {
        let [a, b] = ["a", "b"].map(|group| -> Vec<f64> {
            let shares = case[group].as_array().unwrap().iter();
            shares.map(|share| share.as_f64().unwrap()).collect()
        });
        let found = between_people(&a, &b, 99, 1).unwrap();
        let of = |name: &str| case[name].as_f64().unwrap();
        assert!((found.t - of("t")).abs() < 1e-9, "{found:?}");
        assert!(found.permuted.exhaustive);
        // Both count divisions: no more than rounding.
        assert!(
            (found.permuted.p_value - of("p_permuted")).abs() < 1e-12,
            "{found:?}"
        );
        // The five of 12 and 5, and the six of 6 and 7, vary more than the larger group.
        let is_welch = ![[12, 5], [6, 7]].contains(&[a.len(), b.len()]);
        let freedom = match is_welch {
            true => of("freedom_welch"),
            false => a.len().min(b.len()) as f64 - 1.0,
        };
        assert!((found.freedom - freedom).abs() < 1e-9, "{found:?}");
        if is_welch {
            let p = of("p_permuted").max(of("p_welch"));
            assert!((found.p_value - p).abs() < 1e-9, "{found:?}");
        } else {
            let least = of("p_permuted") - 1e-12;
            assert!(
                found.p_value >= least && found.p_value > of("p_welch"),
                "{found:?}"
            );
        }
    }
}

/// People whose share is `middle` on average: their logits have a standard deviation, or 15 % of them guess among three.
#[derive(Clone, Copy)]
struct Group {
    people: usize,
    trials: usize,
    logit_sd: f64,
    guessers: f64,
    middle: f64,
}

impl Group {
    fn new(people: usize, trials: usize, logit_sd: f64) -> Self {
        Self {
            people,
            trials,
            logit_sd,
            guessers: 0.0,
            middle: 0.5,
        }
    }

    fn shares(&self, random: &mut Random) -> Vec<f64> {
        let person = |_| {
            let logit = (self.middle / (1.0 - self.middle)).ln() + self.logit_sd * random.normal();
            let right = match random.uniform() < self.guessers {
                true => 1.0 / 3.0,
                false => 1.0 / (1.0 + (-logit).exp()),
            };
            let right = (0..self.trials).filter(|_| random.uniform() < right);
            right.count() as f64 / self.trials as f64
        };
        (0..self.people).map(person).collect()
    }
}

/// Of groups with the same mean, which differ in spread, trials and size, at most 6.5 % are said to differ; means exchanged without their
/// spread differ in 19 % of the second. And a difference is found.
#[test]
fn groups_that_differ_in_spread_or_size_do_not_differ() {
    let equal = Group::new(10, 30, 0.9);
    let guess = Group {
        guessers: 0.15,
        middle: 0.8,
        ..equal
    };
    let studies = 300;
    let conclusions = |groups: [Group; 2]| {
        let found = (0..studies).filter(|study| {
            let mut random = Random::stream(*study, 0, "null groups");
            let [a, b] = groups.map(|group| group.shares(&mut random));
            between_people(&a, &b, 199, *study).unwrap().p_value <= LEVEL_SHARE
        });
        found.count() as f64
    };
    // 6.5 % and two and a half standard deviations of 300 studies.
    let most = studies as f64 * 0.065 + 2.5 * (studies as f64 * 0.065 * 0.935).sqrt();
    for groups in [
        [equal, equal],
        [Group::new(12, 42, 0.3), Group::new(5, 12, 1.2)],
        [Group::new(12, 12, 1.2), Group::new(5, 42, 0.3)],
        [Group::new(10, 60, 0.6), Group::new(10, 12, 0.6)],
        [guess, guess],
    ] {
        let found = conclusions(groups);
        assert!(
            found <= most,
            "{} {}: {found}",
            groups[0].people,
            groups[1].people
        );
    }
    let apart = Group {
        middle: 0.9,
        ..equal
    };
    let found = conclusions([equal, apart]);
    assert!(found > 0.85 * studies as f64, "{found}");
}

/// An interval holds 0 exactly where its test decides nothing, and the truth in 95 % of studies.
#[test]
fn intervals_agree_with_their_tests_and_hold_the_truth() {
    let studies = 150;
    let (mut between, mut paired) = (0, 0);
    for study in 0..studies {
        let mut random = Random::stream(study, 0, "intervals");
        let a = Group::new(6, 30, 0.9).shares(&mut random);
        let b = Group::new(8, 12, 0.6).shares(&mut random);
        let [low, high] = between_interval(&a, &b, 199, 1).unwrap();
        let test = between_people(&a, &b, 199, 1).unwrap();
        let holds = low <= 0.0 && high >= 0.0;
        assert_eq!(holds, test.p_value > LEVEL_SHARE, "{test:?} {low} {high}");
        between += usize::from(holds);
        let differences: Vec<f64> = b.iter().zip(&a).map(|(x, y)| x - y).collect();
        let [low, high] = paired_interval(&differences, 199, 1).unwrap();
        let test = piezotact::statistics::sign_flip_test(&differences, 199, 1).unwrap();
        let holds = low <= 0.0 && high >= 0.0;
        assert_eq!(holds, test.p_value > LEVEL_SHARE, "{test:?} {low} {high}");
        paired += usize::from(holds);
    }
    // 93 % less two standard deviations of 150 studies.
    for held in [between, paired] {
        assert!(held as f64 >= 0.93 * studies as f64 - 6.2, "{held}");
    }
}

#[test]
fn groups_too_small_for_their_spread_decide_nothing() {
    let right = table(4, &["naming"], 9, |_, _, presented| presented);
    let wrong = table(20, &["naming"], 9, |_, _, presented| (presented + 1) % 3);
    let all = MatrixConfig::default();
    let people = Difference::People(two("own", "averaged"));
    let found = compared_studies([(&right, &all), (&wrong, &all)], &people).unwrap();
    assert_eq!(
        (found.outcome(), found.interval),
        (Outcome::NotDecided, None)
    );
    let said = found.sentence();
    assert!(
        said.contains("groups of fewer than 5 participants decide nothing"),
        "{said}"
    );
    let right = table(5, &["naming"], 9, |_, _, presented| presented);
    let found = compared_studies([(&right, &all), (&wrong, &all)], &people).unwrap();
    assert_eq!(found.outcome(), Outcome::Met);
}

/// Five differ from twenty who guess; four of whom one stands twice are too few.
#[test]
fn a_person_who_stands_twice_makes_no_group_large_enough() {
    let mut random = Random::stream(6, 0, "twice");
    let guess = table(20, &["naming"], 20, |_, _, _| below(&mut random, 3));
    let mut of = |people_apart: usize| {
        let mut last = Vec::new();
        let mut again = 0;
        let five = table(5, &["naming"], 20, |person, _, presented| {
            if person >= people_apart {
                again += 1;
                return last[again - 1];
            }
            let says = match random.uniform() < 0.6 {
                true => presented,
                false => below(&mut random, 3),
            };
            if person + 1 == people_apart {
                last.push(says);
            }
            says
        });
        let all = MatrixConfig::default();
        let people = Difference::People(two("own", "averaged"));
        compared_studies([(&five, &all), (&guess, &all)], &people).unwrap()
    };
    let five = of(5);
    assert_eq!((five.p_once, five.outcome()), (None, Outcome::Met));
    let four = of(4);
    assert_eq!(
        (four.p_once, four.outcome()),
        (Some(1.0), Outcome::NotDecided)
    );
    assert!(four.p_value <= LEVEL_SHARE, "{four:?}");
}

/// Two of ten who always say S1 beside eight who are right in nine of ten: said. Ten who guess, or who are right in six to nine of ten, are no
/// mixture.
#[test]
fn people_who_guess_beside_others_are_named() {
    let of = |says: &dyn Fn(&mut Random, usize, usize) -> usize| {
        let mut random = Random::stream(4, 0, "mixture");
        let table = table(10, &["naming"], 14, |person, _, presented| {
            says(&mut random, person, presented)
        });
        with(&table, Vec::new())
    };
    let knows = |random: &mut Random, share: f64, presented: usize| match random.uniform() < share {
        true => presented,
        false => below(random, 3),
    };
    let mixed = of(&|random, person, presented| match person {
        0 | 1 => 0,
        _ => knows(random, 0.85, presented),
    });
    let found = mixed.expected[0].guessing.unwrap();
    assert_eq!((found.participants, found.of), (2, 10));
    let warning = AssociationWarning::SomeGuess { guessing: found }.into();
    assert!(mixed.warnings.contains(&warning));
    let said = "two kinds of people: 2 of 10 participants answer no better than guessing";
    assert!(mixed.sentence().contains(said), "{}", mixed.sentence());
    let guess = of(&|random, _, _| below(random, 3));
    let gradual =
        of(&|random, person, presented| knows(random, 0.4 + 0.05 * person as f64, presented));
    for alike in [guess, gradual] {
        assert_eq!(alike.expected[0].guessing, None);
    }
}

/// Three pairs and a share, and two differences that count together as one.
#[test]
fn conclusions_are_counted_beside_those_of_chance() {
    let right = table(8, &["naming"], 9, |_, _, presented| presented);
    let questions = [samples("S1", "S2"), samples("S1", "S3")];
    let found = questions.iter().map(|question| of(&right, question));
    let all = with(&right, found.collect());
    assert_eq!(
        all.conclusions_sentence().unwrap(),
        "Conclusions at 5 %: 1 of 1 on shares as expected, 3 of 3 on pairs, 2 of 2 on differences. Expected by chance, were every truth \
         at its limit: 0.2 (differences together as one, Holm)."
    );
    let mut random = Random::stream(8, 0, "conclusions");
    let guessed = table(8, &["naming"], 9, |_, _, _| below(&mut random, 3));
    let said = with(&guessed, Vec::new()).conclusions_sentence().unwrap();
    assert!(said.contains("0 of 1 on shares as expected"), "{said}");
}

#[test]
fn several_are_adjusted_and_bad_questions_refused() {
    let right = table(6, &["naming"], 2, |_, _, presented| presented);
    let questions = [
        samples("S1", "S2"),
        samples("S1", "S3"),
        samples("S2", "S3"),
    ];
    let found = questions.iter().map(|question| of(&right, question));
    let found = with(&right, found.collect()).comparisons;
    for one in &found {
        // 2/64 alone would be below 5 %.
        assert!((one.p_adjusted - 3.0 / 32.0).abs() < 1e-12);
        assert_eq!(one.verdict(), "not decided");
        assert!(one.sentence().contains("(Holm's, of 3)"));
    }
    for (question, words) in [
        (samples("S1", "S9"), "cannot compare `S9`"),
        (samples("S1", "S1"), "`S1`"),
        (Difference::Tasks(two("naming", "order")), "`order`"),
    ] {
        let refused = compared(&right, &MatrixConfig::default(), &question).unwrap_err();
        assert!(refused.to_string().contains(words), "{refused}");
    }
}

/// A, presented nine times of fifteen: who always says A, or says A as often as it comes, is no better than chance.
#[test]
fn a_preference_for_what_is_presented_most_is_not_above_chance() {
    let share = |seed: u64, says: &dyn Fn(&mut Random, usize) -> usize| {
        let names = ["A", "B", "C"];
        let mut random = Random::stream(seed, 0, "preferences");
        let mut answers = Vec::new();
        for person in 0..8 {
            for trial in 0..15 {
                let presented = [0, 0, 0, 1, 2][trial % 5];
                answers.push(Answer {
                    participant: format!("P{person}"),
                    task: "3".into(),
                    trial: trial.to_string(),
                    presented: names[presented].into(),
                    answered: names[says(&mut random, presented)].into(),
                    offered: names.map(Into::into).to_vec(),
                    ..Answer::default()
                });
            }
        }
        let table = AnswerTable::new(Declared::plain(&names), answers).unwrap();
        let found = associate(&table, &AssociationConfig::default()).unwrap();
        found.expected[0].clone()
    };
    let always = share(1, &|_, _| 0);
    assert_eq!(always.criterion.outcome, Outcome::NotDecided);
    assert!((always.habit_share - 0.6).abs() < 1e-12);
    let said = always.words();
    assert!(
        said.contains("60.0 % by what people answer whatever is presented: not told from chance"),
        "{said}"
    );
    let matching = |random: &mut Random, _| [0, 0, 0, 1, 2][below(random, 5)];
    let above = (0..200).filter(|seed| share(*seed, &matching).criterion.outcome == Outcome::Met);
    // 2.5 % of the intervals lie above.
    assert!(above.count() <= 12);
    let right = share(1, &|_, presented| presented);
    assert_eq!(right.criterion.outcome, Outcome::Met);
}
