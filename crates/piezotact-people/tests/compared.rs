//! Whether two samples, tasks or groups of people differ: people who guess, who have habits, and who tell them apart.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact::criterion::Outcome;
use piezotact::statistics::random::Random;
use piezotact_people::association::{
    Answer, AnswerTable, Association, AssociationConfig, Compared, Declared, MatrixConfig,
    Stimulus, associate, compared, compared_studies,
};
use piezotact_people::difference::Difference;

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
        ([8, 9], "they differ")
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
