//! Association matrices against the thesis, published examples and SciPy.
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]

use piezotact::compare::{CompareWarning, Mixed, Named};
use piezotact::criterion::Outcome;
use piezotact::statistics::random::Random;
use piezotact::warning::{Few, FewWarning};
use piezotact_people::association::{
    Answer, AnswerTable, Association, AssociationConfig, AssociationError, AssociationMatrix,
    AssociationWarning, Declared, Flag, FlaggedTrials, Grouping, MatrixConfig, PairOutcome,
    Purpose, Selection, Stimulus, associate, association_matrix, confused_pairs, kendall_tau_b,
    ordering,
};
use piezotact_people::interval::{clopper_pearson, clustered_interval};
use serde_json::Value;

/// Rounding of beta and t quantiles of two libraries.
const QUANTILES: f64 = 1e-7;

fn near(found: f64, golden: &Value, what: &str) {
    let golden = golden.as_f64().unwrap();
    assert!(
        (found - golden).abs() < QUANTILES,
        "{what}: {found}, golden {golden}"
    );
}

fn whole(value: &Value) -> usize {
    usize::try_from(value.as_u64().unwrap()).unwrap()
}

#[test]
fn intervals_and_tau_are_those_of_scipy() {
    let golden: Value = serde_json::from_str(include_str!("golden/association.json")).unwrap();
    for case in golden["shares"].as_array().unwrap() {
        let (x, n) = (whole(&case["declared"]), whole(&case["presented"]));
        for i in 0..2 {
            near(clopper_pearson(x, n)[i], &case["exact"][i], "exact");
        }
    }
    for case in golden["clustered"].as_array().unwrap() {
        let people = case["people"].as_array().unwrap().iter();
        let people: Vec<(usize, usize)> = people.map(|p| (whole(&p[0]), whole(&p[1]))).collect();
        let found = clustered_interval(&people).unwrap();
        near(found.share, &case["share"], "share");
        near(found.effective, &case["effective"], "effective");
        for (end, golden) in found
            .interval
            .unwrap()
            .iter()
            .zip(case["interval"].as_array().unwrap())
        {
            near(*end, golden, &format!("{people:?}"));
        }
    }
    for case in golden["tau_b"].as_array().unwrap() {
        let list = |name: &str| -> Vec<f64> {
            let values = case[name].as_array().unwrap().iter();
            values.map(|value| value.as_f64().unwrap()).collect()
        };
        near(
            kendall_tau_b(&list("a"), &list("b")).unwrap(),
            &case["tau"],
            "tau",
        );
    }
}

/// Answers of (participant, presented, answered), each a trial of its own.
fn answers(of: &[(&str, &str, &str)]) -> Vec<Answer> {
    let numbered = of.iter().enumerate();
    numbered
        .map(|(i, (participant, presented, answered))| Answer {
            participant: (*participant).into(),
            task: "3".into(),
            trial: i.to_string(),
            presented: (*presented).into(),
            answered: (*answered).into(),
            ..Answer::default()
        })
        .collect()
}

fn percent(matrix: &AssociationMatrix, presented: &str, answered: &str) -> Option<f64> {
    matrix.cell(presented, answered).unwrap().percent
}

/// Four samples, each presented three times; SC was declared once to be SD.
fn figure_25() -> AnswerTable {
    let of = [
        ("P1", "SA", "SA"),
        ("P1", "SB", "SB"),
        ("P1", "SC", "SC"),
        ("P1", "SD", "SD"),
        ("P2", "SA", "SB"),
        ("P2", "SB", "SA"),
        ("P2", "SC", "SD"),
        ("P2", "SD", "SD"),
        ("P3", "SA", "SA"),
        ("P3", "SB", "SB"),
        ("P3", "SC", "SC"),
        ("P3", "SD", "SA"),
    ];
    AnswerTable::new(Declared::plain(&["SA", "SB", "SC", "SD"]), answers(&of)).unwrap()
}

#[test]
fn claim_34_sc_declared_sd_is_a_third_of_its_presentations() {
    let matrix = association_matrix(&figure_25(), &MatrixConfig::default());
    let cell = matrix.cell("SC", "SD").unwrap();
    assert_eq!((cell.declared, cell.offered), (1, 3));
    assert_eq!(cell.percent, Some(100.0 / 3.0));
    assert_eq!(percent(&matrix, "SC", "SC"), Some(200.0 / 3.0));
    // The direction counts: SD was never declared to be SC.
    assert_eq!(percent(&matrix, "SD", "SC"), Some(0.0));
    for row in &matrix.rows {
        assert_eq!(row.presented, 3);
        let sum: f64 = row.cells.iter().filter_map(|cell| cell.percent).sum();
        assert!((sum - 100.0).abs() < 1e-9);
    }
}

/// A keyboard's `s1` beside `S1`: three samples count as four, and chance is lower than it was.
#[test]
fn samples_whose_names_differ_in_case_are_named() {
    let of = |last: &'static str| {
        let of = [("P1", "S1", "S1"), ("P1", "S2", "S2"), ("P2", "S3", last)];
        let declared = Declared::plain(&["S1", "S2", "S3", "s1"]);
        let table = AnswerTable::new(declared, answers(&of)).unwrap();
        let warnings = associate(&table, &AssociationConfig::default())
            .unwrap()
            .warnings;
        let alike = Mixed::NamesAlike {
            of: Named::Sample,
            one: "S1".into(),
            other: "s1".into(),
        };
        let named = CompareWarning::Mixed { how: alike };
        warnings
            .iter()
            .any(|warning| warning.kind() == Some(named.clone()))
    };
    assert!(of("s1") && !of("S1"));
}

#[test]
fn samples_keep_rows_and_columns_and_untested_is_not_zero() {
    let mut of = answers(&[("P1", "S1", "S1"), ("P1", "S2", "S1"), ("P2", "S1", "S1")]);
    for answer in &mut of {
        answer.offered = vec!["S1".into(), "S2".into(), "S3".into()];
    }
    let declared = Declared::plain(&["S1", "S2", "S3", "S4"]);
    let table = AnswerTable::new(declared, of).unwrap();
    let matrix = association_matrix(&table, &MatrixConfig::default());
    assert_eq!((matrix.rows.len(), matrix.samples.len()), (4, 4));
    assert_eq!(percent(&matrix, "S1", "S3"), Some(0.0));
    assert_eq!(percent(&matrix, "S1", "S4"), None);
    assert_eq!(matrix.rows[3].presented, 0);
    let outcome = |first: &str, second: &str| {
        let pairs = confused_pairs(&table, &MatrixConfig::default());
        let mut pairs = pairs.into_iter().filter(|p| p.pair == [first, second]);
        pairs.next().unwrap().outcome
    };
    assert_eq!(outcome("S1", "S4"), PairOutcome::Untested);
    // Two participants decide nothing.
    assert_eq!(outcome("S1", "S2"), PairOutcome::NotDecided);
}

#[test]
fn inverted_textures_have_a_key_of_their_own_and_lie_on_the_diagonal() {
    let declared = Declared {
        samples: ["S2", "S6", "S13"].map(String::from).into(),
        stimuli: vec![
            Stimulus::manipulated("S2 INVERTED", "S2", "S13"),
            Stimulus::plain("S6"),
            Stimulus::manipulated("S13 INVERTED", "S13", "S2"),
        ],
    };
    let of = answers(&[
        ("P1", "S2 INVERTED", "S13"),
        ("P1", "S6", "S6"),
        ("P1", "S13 INVERTED", "S2"),
        ("P2", "S2 INVERTED", "S6"),
    ]);
    let table = AnswerTable::new(declared, of).unwrap();
    let matrix = association_matrix(&table, &MatrixConfig::default()).by_expected();
    let rows: Vec<&str> = matrix.rows.iter().map(|row| &*row.stimulus.name).collect();
    assert_eq!(rows, ["S13 INVERTED", "S6", "S2 INVERTED"]);
    assert_eq!(percent(&matrix, "S2 INVERTED", "S13"), Some(50.0));
    assert_eq!(matrix.expected_share(), Some(0.75));
    let pairs = confused_pairs(&table, &MatrixConfig::default());
    let found = pairs
        .iter()
        .find(|p| p.pair == ["S2 INVERTED", "S6"])
        .unwrap();
    assert_eq!((found.declared, found.presented), ([1, 0], [2, 0]));
    // What an inverted texture is expected to be declared as is no confusion.
    assert!(!pairs.iter().any(|p| p.pair == ["S2 INVERTED", "S13"]));
}

#[test]
fn flagged_trials_and_rehearsals_are_counted() {
    let mut of = answers(&[("P1", "S1", "S2"), ("P1", "S1", "S1"), ("P1", "S2", "S2")]);
    of[0].flags = vec![Flag::MissedTarget];
    of[2].purpose = Purpose::Rehearsal;
    let table = AnswerTable::new(Declared::plain(&["S1", "S2"]), of).unwrap();
    let made = |flagged| {
        let mut config = AssociationConfig::default();
        config.matrix.flagged = flagged;
        associate(&table, &config).unwrap()
    };
    let kept = made(FlaggedTrials::Kept);
    assert_eq!((kept.answers, kept.rehearsals), (2, 1));
    assert_eq!(kept.all().unwrap().cell("S1", "S2").unwrap().flagged, 1);
    let without = made(FlaggedTrials::LeftOut);
    assert_eq!(percent(without.all().unwrap(), "S1", "S2"), Some(0.0));
    let kinds = |found: &Association| -> Vec<AssociationWarning> {
        found
            .warnings
            .iter()
            .filter_map(piezotact::Warning::kind)
            .collect()
    };
    assert!(kinds(&kept).contains(&AssociationWarning::Flagged {
        trials: 1,
        of: [1, 0, 0, 0],
        kept: true
    }));
    assert!(kinds(&without).contains(&AssociationWarning::Flagged {
        trials: 1,
        of: [1, 0, 0, 0],
        kept: false
    }));
    let few = FewWarning::Few {
        found: 1,
        recommended: 3,
        what: Few::Answering,
    };
    assert!(kept.warnings.contains(&few.into()));
}

#[test]
fn groups_have_matrices_of_their_own() {
    let config = AssociationConfig {
        by: Some(Grouping::Participant),
        ..AssociationConfig::default()
    };
    let found = associate(&figure_25(), &config).unwrap();
    let groups: Vec<&str> = found.matrices.iter().map(|m| &*m.group).collect();
    assert_eq!(groups, ["all", "P1", "P2", "P3"]);
    assert_eq!(percent(&found.matrices[2].matrix, "SC", "SD"), Some(100.0));
    let other = AssociationConfig {
        matrix: MatrixConfig {
            selection: Selection {
                task: Some("9".into()),
                ..Selection::default()
            },
            ..MatrixConfig::default()
        },
        ..AssociationConfig::default()
    };
    let refused = associate(&figure_25(), &other).unwrap_err();
    assert!(
        matches!(&refused, AssociationError::NothingSelected { wanted, .. } if wanted == "task 9")
    );
}

/// What one participant makes of `samples`: `made[i]` stands in the place of `samples[i]`.
fn placed(participant: &str, session: &str, samples: &[&str], made: &[&str]) -> Vec<Answer> {
    let pairs = made.iter().zip(samples);
    pairs
        .map(|(presented, place)| Answer {
            participant: participant.into(),
            session: session.into(),
            task: "1".into(),
            trial: (*presented).into(),
            presented: (*presented).into(),
            answered: (*place).into(),
            ..Answer::default()
        })
        .collect()
}

/// The first of 14 samples put last: nothing is in its place, and 78 of 91 pairs are in order.
#[test]
fn one_sample_moved_leaves_the_diagonal_empty_and_tau_high() {
    let names: Vec<String> = (1..=14).map(|i| format!("S{i}")).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let mut moved = names.clone();
    moved.rotate_left(1);
    let table =
        AnswerTable::new(Declared::plain(&names), placed("P1", "", &names, &moved)).unwrap();
    let found = ordering(&table, &MatrixConfig::default(), "1").unwrap();
    assert_eq!((found.in_place, found.placed), (0, 14));
    let tau = found.repetitions[0].tau.unwrap();
    assert!((tau - 65.0 / 91.0).abs() < 1e-12, "{tau}");
    assert_eq!(found.repetitions[0].order, moved);
    assert_eq!(
        (found.dominance[0][13].before, found.dominance[13][0].before),
        (0, 1)
    );
    assert_eq!(found.dominance[3][4].before, 1);
    // S1 stands in the last place.
    assert_eq!(found.places[0][13], 1);
    assert_eq!((found.mean_tau, found.tau_interval), (Some(tau), None));
}

#[test]
fn what_is_no_order_is_refused() {
    let names = ["S1", "S2", "S3"];
    let refused = |made: [&str; 3]| {
        let mut of = placed("P1", "", &names, &made);
        for (i, answer) in of.iter_mut().enumerate() {
            answer.trial = i.to_string();
        }
        let table = AnswerTable::new(Declared::plain(&names), of).unwrap();
        ordering(&table, &MatrixConfig::default(), "1").unwrap_err()
    };
    let twice = refused(["S1", "S1", "S3"]);
    assert!(
        matches!(
            &twice,
            AssociationError::NoOrder {
                found: "presented twice",
                ..
            }
        ),
        "{twice}"
    );
    let table =
        AnswerTable::new(Declared::plain(&names), placed("P1", "", &names, &names)).unwrap();
    assert!(matches!(
        ordering(&table, &MatrixConfig::default(), "7"),
        Err(AssociationError::NoOrders { .. })
    ));
}

/// Ten participants, ten presentations each of S1 and S2, of which `confused` are confused; S3 is always told.
fn confusing(confused: impl Fn(usize) -> usize) -> PairOutcome {
    let mut of = Vec::new();
    for person in 0..10 {
        for trial in 0..10 {
            for (presented, other) in [("S1", "S2"), ("S2", "S1")] {
                let answered = if trial < confused(person) {
                    other
                } else {
                    presented
                };
                of.push(Answer {
                    participant: format!("P{person}"),
                    trial: format!("{presented} {trial}"),
                    presented: presented.into(),
                    answered: answered.into(),
                    ..Answer::default()
                });
            }
        }
    }
    let table = AnswerTable::new(Declared::plain(&["S1", "S2", "S3"]), of).unwrap();
    let pairs = confused_pairs(&table, &MatrixConfig::default());
    pairs
        .into_iter()
        .find(|p| p.pair == ["S1", "S2"])
        .unwrap()
        .outcome
}

#[test]
fn a_pair_is_confused_only_where_people_agree() {
    assert_eq!(confusing(|_| 5), PairOutcome::Confused);
    assert_eq!(confusing(|_| 0), PairOutcome::NotConfused);
    assert_eq!(
        confusing(|person| usize::from(person < 5)),
        PairOutcome::NotConfused
    );
    // Half of all answers, but all of them from half of the people: 72 of 200 pooled answers would decide it.
    assert_eq!(
        confusing(|person| if person < 4 { 9 } else { 0 }),
        PairOutcome::NotDecided
    );
    let [low, _] = clopper_pearson(72, 200);
    assert!(low > 0.25);
}

#[test]
fn a_document_comes_back() {
    let config = AssociationConfig {
        by: Some(Grouping::Task),
        ..AssociationConfig::default()
    };
    let found = associate(&figure_25(), &config).unwrap();
    let text = serde_json::to_string(&found).unwrap();
    assert_eq!(serde_json::from_str::<Association>(&text).unwrap(), found);
}

/// Two participants order three samples in two sets; one trial of the first is flagged.
fn ordered_with_a_flag() -> AnswerTable {
    let names = ["S1", "S2", "S3"];
    let mut of = placed("P1", "", &names, &["S3", "S2", "S1"]);
    of[1].flags = vec![Flag::MissedTarget];
    of.extend(placed("P2", "", &names, &names));
    AnswerTable::new(Declared::plain(&names), of).unwrap()
}

/// An order with a flagged trial is left out whole: what remains of it would be no order.
#[test]
fn orders_are_made_of_the_answers_that_count() {
    let table = ordered_with_a_flag();
    let of = |flagged, participant: Option<&str>| {
        let config = MatrixConfig {
            flagged,
            selection: Selection {
                participant: participant.map(Into::into),
                ..Selection::default()
            },
        };
        ordering(&table, &config, "1")
    };
    let kept = of(FlaggedTrials::Kept, None).unwrap();
    assert_eq!((kept.repetitions.len(), kept.left_out), (2, 0));
    assert_eq!(kept.mean_tau, Some(0.0));
    let left = of(FlaggedTrials::LeftOut, None).unwrap();
    assert_eq!((left.repetitions.len(), left.left_out), (1, 1));
    assert_eq!((left.mean_tau, left.placed), (Some(1.0), 3));
    assert!(left.sentence().contains("1 with flagged trials left out"));
    let one = of(FlaggedTrials::Kept, Some("P2")).unwrap();
    assert_eq!((one.repetitions.len(), one.mean_tau), (1, Some(1.0)));
    let none = of(FlaggedTrials::LeftOut, Some("P1")).unwrap_err();
    assert!(matches!(
        none,
        AssociationError::OrdersOnlyFlagged { orders: 1, .. }
    ));
}

#[test]
fn orders_of_another_task_than_the_selected_one_are_refused() {
    let config = MatrixConfig {
        selection: Selection {
            task: Some("2".into()),
            ..Selection::default()
        },
        ..MatrixConfig::default()
    };
    let refused = ordering(&ordered_with_a_flag(), &config, "1").unwrap_err();
    assert!(matches!(refused, AssociationError::OtherTask { .. }));
    let text = refused.to_string();
    assert!(text.contains("task 2") && text.contains("task 1"), "{text}");
}

/// `people` who answer eight sequences of three as `answer` says: the sequence that was presented and a source of randomness.
fn triplets(
    people: usize,
    seed: u64,
    answer: impl Fn(&[usize], &mut Random) -> Vec<usize>,
) -> Association {
    let names = ["S1", "S2", "S3"];
    let mut random = Random::stream(seed, people as u64, "triplets");
    let mut of = Vec::new();
    for person in 0..people {
        for trial in 0..8 {
            let presented = shuffled(&mut random);
            let answered = answer(&presented, &mut random);
            for (place, (is, said)) in presented.iter().zip(&answered).enumerate() {
                of.push(Answer {
                    participant: format!("P{person}"),
                    task: "task3".into(),
                    trial: trial.to_string(),
                    position: Some(place + 1),
                    presented: names[*is].into(),
                    answered: names[*said].into(),
                    offered: names.map(Into::into).to_vec(),
                    ..Answer::default()
                });
            }
        }
    }
    let table = AnswerTable::new(Declared::plain(&names), of).unwrap();
    associate(&table, &AssociationConfig::default()).unwrap()
}

fn shuffled(random: &mut Random) -> Vec<usize> {
    let mut keyed: Vec<(f64, usize)> = (0..3).map(|i| (random.uniform(), i)).collect();
    keyed.sort_by(|a, b| a.0.total_cmp(&b.0));
    keyed.into_iter().map(|(_, i)| i).collect()
}

/// Guessers are told above chance in 2.5 of a hundred campaigns, whether they use each answer once or not; people who know a third of
/// the sequences nearly always.
#[test]
fn guessers_are_not_above_chance_and_people_who_feel_something_are() {
    type Guess = fn(&[usize], &mut Random) -> Vec<usize>;
    let once: Guess = |_, random| shuffled(random);
    let repeated: Guess = |_, random| (0..3).map(|_| (3.0 * random.uniform()) as usize).collect();
    let feels: Guess = |presented, random| match random.uniform() < 0.35 {
        true => presented.to_vec(),
        false => shuffled(random),
    };
    let above = |guess: Guess| {
        let campaigns = (0..200).filter(|seed| {
            let found = triplets(10, *seed, guess);
            let [share] = found.expected.as_slice() else {
                panic!("{:?}", found.expected);
            };
            assert!((share.chance_share - 1.0 / 3.0).abs() < 1e-12);
            share.criterion.outcome == Outcome::Met
        });
        campaigns.count()
    };
    // 2.5 % of 200, and three binomial standard deviations above.
    assert!(above(once) <= 12, "{}", above(once));
    assert!(above(repeated) <= 12, "{}", above(repeated));
    assert!(above(feels) >= 195, "{}", above(feels));
    let guessed = triplets(10, 7, once).sentence();
    assert!(
        guessed.contains("chance 33.3 %: not told from chance"),
        "{guessed}"
    );
}

#[test]
fn orders_are_no_associations() {
    let order = |participant: &str, placed: [&str; 2]| {
        ["S1", "S2"]
            .iter()
            .zip(placed)
            .enumerate()
            .map(|(i, (stands, placed))| Answer {
                participant: participant.into(),
                task: "order".into(),
                trial: "1".into(),
                position: Some(i + 1),
                presented: placed.into(),
                answered: (*stands).into(),
                ..Answer::default()
            })
            .collect::<Vec<_>>()
    };
    let mut of = answers(&[("P1", "S1", "S2"), ("P2", "S1", "S1")]);
    of.extend(order("P1", ["S1", "S2"]));
    of.extend(order("P2", ["S2", "S1"]));
    let table = AnswerTable::new(Declared::plain(&["S1", "S2"]), of).unwrap();
    let mut config = AssociationConfig {
        ordering_tasks: vec!["order".into()],
        ..AssociationConfig::default()
    };
    let found = associate(&table, &config).unwrap();
    assert_eq!(
        (found.answers, found.orderings[0].repetitions.len()),
        (2, 2)
    );
    assert_eq!(percent(found.all().unwrap(), "S1", "S2"), Some(50.0));
    assert_eq!(found.pairs[0].presented, [2, 0]);
    // Flagged answers that are left out leave nothing: places in orders do not stand for them.
    let flagged = table.answers().iter().cloned().map(|mut answer| {
        if answer.task != "order" {
            answer.flags = [Flag::MissedTarget].into();
        }
        answer
    });
    let flagged = AnswerTable::new(Declared::plain(&["S1", "S2"]), flagged.collect()).unwrap();
    config.matrix.flagged = FlaggedTrials::LeftOut;
    let refused = associate(&flagged, &config).unwrap_err();
    assert!(
        matches!(refused, AssociationError::OnlyFlagged { .. }),
        "{refused}"
    );
    config.matrix.flagged = FlaggedTrials::Kept;
    // The matrix of their places, where nothing else is asked for.
    config.matrix.selection.task = Some("order".into());
    assert_eq!(associate(&table, &config).unwrap().answers, 4);
}

/// Six samples, ten people, 36 guesses each: every pair is named in a sixth, below a quarter, and nothing is told apart. Who always gives
/// one name tells nothing apart either.
#[test]
fn guessers_among_many_are_never_said_to_tell_a_pair_apart() {
    let names: Vec<String> = (1..=6).map(|i| format!("S{i}")).collect();
    let declared = Declared {
        stimuli: names.iter().map(|name| Stimulus::plain(name)).collect(),
        samples: names.clone(),
    };
    let campaign = |seed: u64, guess: &dyn Fn(usize, &mut Random) -> usize| {
        let mut random = Random::stream(seed, 6, "guesses among six");
        let mut of = Vec::new();
        for person in 0..10 {
            for trial in 0..36 {
                let presented = trial % 6;
                of.push(Answer {
                    participant: format!("P{person}"),
                    task: "t".into(),
                    trial: trial.to_string(),
                    presented: names[presented].clone(),
                    answered: names[guess(presented, &mut random)].clone(),
                    offered: names.clone(),
                    ..Answer::default()
                });
            }
        }
        let table = AnswerTable::new(declared.clone(), of).unwrap();
        let pairs = confused_pairs(&table, &MatrixConfig::default());
        let apart = pairs
            .iter()
            .filter(|pair| pair.outcome == PairOutcome::NotConfused);
        apart.count()
    };
    let guessed: usize = (0..40)
        .map(|seed| campaign(seed, &|_, random| (6.0 * random.uniform()) as usize))
        .sum();
    // 15 pairs each: 2.5 % one-sided, and three standard deviations.
    assert!(guessed <= 15 + 12, "{guessed} of 600");
    assert_eq!(campaign(1, &|_, _| 0), 0);
    let known = campaign(1, &|presented, random| match random.uniform() < 0.9 {
        true => presented,
        false => (6.0 * random.uniform()) as usize,
    });
    assert_eq!(known, 15);
}

/// Who is never offered the right answer is neither right nor above chance; a task of guesses is not hidden by one of right answers.
#[test]
fn what_cannot_be_right_is_not_counted_and_each_task_is_said() {
    let mut of = Vec::new();
    for person in 0..6 {
        for trial in 0..12 {
            // Of one sample alone nobody knows whether it was felt.
            let shown = ["S1", "S2"][trial % 2];
            let answer = |task: &str, answered: &str, offered: [&str; 2]| Answer {
                participant: format!("P{person}"),
                task: task.into(),
                trial: trial.to_string(),
                presented: match task {
                    "closed" => "S1".into(),
                    _ => shown.into(),
                },
                answered: answered.into(),
                offered: offered.map(Into::into).to_vec(),
                ..Answer::default()
            };
            of.push(answer("closed", "S3", ["S2", "S3"]));
            of.push(answer("right", shown, ["S1", "S2"]));
            let guessed = if (trial / 2 + person) % 2 == 0 {
                "S1"
            } else {
                "S2"
            };
            of.push(answer("guessed", guessed, ["S1", "S2"]));
        }
    }
    let table = AnswerTable::new(Declared::plain(&["S1", "S2", "S3"]), of).unwrap();
    let config = AssociationConfig {
        by: Some(Grouping::Task),
        ..AssociationConfig::default()
    };
    let found = associate(&table, &config).unwrap();
    assert_eq!((found.answers, found.expected[0].answers), (216, 144));
    let of_task = |task: &str| {
        let group = found.matrices.iter().find(|group| group.group == task);
        group
            .unwrap()
            .expected
            .as_ref()
            .map(|share| share.criterion.outcome)
    };
    assert_eq!(of_task("closed"), None);
    assert_eq!(of_task("right"), Some(Outcome::Met));
    assert_eq!(of_task("guessed"), Some(Outcome::NotDecided));
    let said = found.group_sentences();
    assert!(
        said.len() == 2 && said[0].starts_with("task guessed: 72 answers, 50.0 % as expected"),
        "{said:?}"
    );
    // Forced to name another, nobody confuses anything.
    let mut closed = config;
    closed.matrix.selection.task = Some("closed".into());
    let closed = associate(&table, &closed).unwrap();
    assert!(closed.expected.is_empty());
    assert!(
        closed
            .pairs
            .iter()
            .all(|pair| pair.outcome == PairOutcome::Untested)
    );
}
