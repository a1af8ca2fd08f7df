//! The check of a design on the campaigns of the thesis, against SciPy, and on good plans in which no fault is.

use piezotact::criterion::Outcome;
use piezotact_people::campaign::design::*;
use serde_json::Value;

fn words(of: &str) -> Vec<String> {
    of.split(' ').map(str::to_owned).collect()
}

fn golden() -> Value {
    serde_json::from_str(include_str!("golden/design.json")).unwrap_or_default()
}

fn numbers(value: &Value) -> Vec<f64> {
    value
        .as_array()
        .into_iter()
        .flatten()
        .filter_map(Value::as_f64)
        .collect()
}

fn within(found: f64, truth: f64, tolerance: f64) {
    assert!(
        (found - truth).abs() < tolerance,
        "{found}, expected {truth}"
    );
}

const AIMS: Aims = Aims {
    power_share: 0.8,
    half_width_share: 0.2,
    cell_share: 0.7,
    logit_sd: 0.9,
};

fn names(letter: &str, n: usize) -> Vec<String> {
    (1..=n).map(|i| format!("{letter}{i}")).collect()
}

fn task(name: &str, task: TaskKind, repeats: usize, seconds_per_trial: f64) -> TaskDescription {
    TaskDescription {
        name: name.into(),
        task,
        repeats,
        seconds_per_trial,
        played_s: 0.0,
        uncounted_trials: 0.0,
    }
}

fn associate(sequence: SequenceRule) -> TaskKind {
    TaskKind::Associate { sequence }
}

/// Table 4 of the thesis.
fn periodic() -> CampaignDescription {
    let sets = [
        "M1 M8 M10",
        "M11 M9 M12",
        "M4 M2 M3",
        "M6 M7 M5 M11",
        "M1 M11 M4",
        "M8 M11 M2",
        "M10 M11 M3",
        "M10 M9 M4",
        "M12 M7 M1 M2",
        "M3 M6 M1",
        "M1 M5 M9",
        "M8 M9 M7 M3",
        "M12 M8 M4 M6",
        "M6 M9 M2",
        "M2 M10 M5 M12",
        "M4 M7 M5",
        "M8 M5 M3 M12",
        "M10 M7 M6",
    ];
    CampaignDescription {
        name: "periodic textures".into(),
        samples: names("M", 12),
        sets: sets.iter().map(|set| words(set)).collect(),
        tray: 4,
        sets_shared_over: 1,
        pairs_wanted: PairsWanted::All,
        tasks: vec![
            task("real", TaskKind::IdentifyFromMemory, 1, 20.0),
            task(
                "rendered",
                associate(SequenceRule::Independent {
                    shortest: 5,
                    longest: 6,
                }),
                1,
                20.0,
            ),
        ],
        task_orders: Vec::new(),
        comparisons: Vec::new(),
        counterbalanced: Vec::new(),
        participants: 30,
        aims: AIMS,
    }
}

/// Table 5 of the thesis.
fn isotropic() -> CampaignDescription {
    let sets = [
        "S2 S4 S8",
        "S5 S7 S9",
        "S6 S11 S10",
        "S1 S3 S13",
        "S5 S8 S12",
        "S5 S9 S10",
        "S2 S3 S4",
        "S1 S8 S13",
        "S1 S7 S12",
        "S4 S13 S10",
        "S4 S8 S9",
        "S13 S12 S10",
    ];
    CampaignDescription {
        name: "isotropic textures".into(),
        samples: names("S", 13),
        sets: sets.iter().map(|set| words(set)).collect(),
        tray: 3,
        tasks: vec![
            task(
                "order of all",
                TaskKind::OrderAll {
                    samples: 14,
                    scoring: Scoring::ByPosition,
                },
                3,
                300.0,
            ),
            task(
                "order of sets",
                TaskKind::OrderSet {
                    scoring: Scoring::ByPosition,
                },
                1,
                60.0,
            ),
            task(
                "rendered",
                associate(SequenceRule::Independent {
                    shortest: 3,
                    longest: 4,
                }),
                1,
                20.0,
            ),
        ],
        participants: 10,
        ..periodic()
    }
}

/// Table 6 of the thesis; an inverted texture is named by its sample.
fn inversions() -> CampaignDescription {
    let tests = [
        ["S2 S6 S13", "S6 S13 S2", "S13 S2 S6", "S2 S13 S6"],
        ["S11 S8 S5", "S5 S8 S11", "S8 S5 S11", "S8 S5 S11"],
    ];
    let tests = tests
        .iter()
        .map(|of| of.iter().map(|test| words(test)).collect())
        .collect();
    CampaignDescription {
        name: "amplitude inversion".into(),
        samples: words("S2 S6 S13 S5 S8 S11"),
        sets: vec![words("S2 S6 S13"), words("S5 S8 S11")],
        pairs_wanted: PairsWanted::WithinSets,
        tasks: vec![task(
            "rendered",
            associate(SequenceRule::Fixed {
                tests,
                stimuli: Vec::new(),
            }),
            1,
            20.0,
        )],
        participants: 5,
        ..isotropic()
    }
}

/// Chapter 6 of the thesis.
fn imagery() -> CampaignDescription {
    CampaignDescription {
        name: "mental imagery".into(),
        samples: words("P1 P2 P3"),
        sets: Vec::new(),
        tasks: ["natural", "control", "imagery"]
            .iter()
            .map(|name| {
                task(
                    name,
                    TaskKind::Rate {
                        trials: 3,
                        range: 6,
                    },
                    1,
                    120.0,
                )
            })
            .collect(),
        task_orders: vec![
            words("natural control imagery"),
            words("natural imagery control"),
        ],
        comparisons: vec![Comparison {
            tasks: words("natural control imagery"),
            smallest_effect_ratio: 0.5,
        }],
        counterbalanced: vec![
            Factor {
                name: "tasks".into(),
                orders: 2,
            },
            Factor {
                name: "surfaces".into(),
                orders: 6,
            },
        ],
        participants: 10,
        ..isotropic()
    }
}

fn never(report: &DesignReport, a: &str, b: &str) -> bool {
    report.never.contains(&[a.to_owned(), b.to_owned()])
}

#[test]
fn table_4_holds_every_pair() {
    let report = design_findings(&periodic(), 1).unwrap();
    let coverage = report.coverage.as_ref().unwrap();
    assert_eq!(
        (coverage.sets, coverage.together, coverage.pairs),
        (18, 66, 66)
    );
    assert_eq!(coverage.presentations, [5; 12]);
    assert_eq!(
        coverage.times,
        [
            Together { sets: 1, pairs: 60 },
            Together { sets: 2, pairs: 6 }
        ]
    );
    assert!(report.faults.is_empty(), "{:?}", report.faults);
    assert!(report.criteria.iter().all(|c| c.outcome == Outcome::Met));
}

#[test]
fn table_5_leaves_47_pairs_untested() {
    let report = design_findings(&isotropic(), 1).unwrap();
    let coverage = report.coverage.as_ref().unwrap();
    assert_eq!(
        (coverage.together, coverage.pairs, report.never.len()),
        (31, 78, 47)
    );
    assert!(never(&report, "S7", "S8") && !never(&report, "S2", "S3"));
    let cluster = ["S9 S11", "S9 S12", "S9 S13", "S11 S12", "S11 S13"];
    for pair in cluster.map(words) {
        assert!(never(&report, &pair[0], &pair[1]), "{pair:?}");
    }
    let within = |name: &String| ["S9", "S10", "S11", "S12", "S13"].contains(&name.as_str());
    assert_eq!(
        report
            .never
            .iter()
            .filter(|[a, b]| within(a) && within(b))
            .count(),
        5
    );
    let four: Vec<usize> = [4, 8, 10, 13]
        .map(|i: usize| coverage.presentations[i - 1])
        .to_vec();
    assert_eq!(four, [4; 4]);
    let found = &report.faults[0];
    let Fault::PairsNeverTogether { rarest, .. } = &found.fault else {
        panic!("{found:?}");
    };
    let once: Vec<(&str, usize)> = rarest
        .iter()
        .map(|of| (of.sample.as_str(), of.sets))
        .collect();
    assert_eq!(once, [("S6", 1), ("S11", 1)]);
    assert_eq!(
        found.fault.to_string(),
        "47 of 78 pairs are never together in a set (31 are): their cells stay untested."
    );
}

#[test]
fn table_5_has_a_better_plan_with_its_cost() {
    let report = design_findings(&isotropic(), 1).unwrap();
    let better = report.faults[0].better.as_ref().unwrap();
    let Change::Sets {
        sets,
        together,
        pairs,
        halves,
        ..
    } = &better.change
    else {
        panic!("{better:?}");
    };
    assert_eq!((better.sets, *together, *pairs), ([12, 26], 78, 78));
    assert_eq!(halves.iter().map(Vec::len).collect::<Vec<_>>(), [13, 13]);
    // An order of 14 three times (900 s); each set 60 s and 3.5 stimuli of 20 s.
    within(better.participant_s[0], 900.0 + 12.0 * 130.0, 1e-9);
    within(better.participant_s[1], 900.0 + 26.0 * 130.0, 1e-9);
    within(
        better.participant_shared_by_two_s.unwrap(),
        900.0 + 13.0 * 130.0,
        1e-9,
    );
    // What is offered has no such fault.
    let mended = CampaignDescription {
        sets: sets.clone(),
        ..isotropic()
    };
    let mended = design_findings(&mended, 1).unwrap();
    assert!(mended.coverage.unwrap().is_balanced());
    assert!(
        !mended
            .faults
            .iter()
            .any(|f| matches!(f.fault, Fault::PairsNeverTogether { .. }))
    );
}

#[test]
fn positions_overstate_the_confusion_of_fourteen_and_not_of_three() {
    let report = design_findings(&isotropic(), 1).unwrap();
    let of = |report: &DesignReport| -> Vec<Fault> {
        let faults = report.faults.iter().map(|found| found.fault.clone());
        faults
            .filter(|f| matches!(f, Fault::PositionOverstatesConfusion { .. }))
            .collect()
    };
    let [
        Fault::PositionOverstatesConfusion {
            task,
            samples,
            in_position,
            tau,
        },
    ] = &of(&report)[..]
    else {
        panic!("{:?}", report.faults);
    };
    assert_eq!(
        (task.as_str(), *samples, *in_position),
        ("order of all", 14, 0)
    );
    within(*tau, 0.714, 5e-4);
    let mut good = isotropic();
    good.tasks[0].task = TaskKind::OrderAll {
        samples: 14,
        scoring: Scoring::ByPositionAndDominance,
    };
    assert!(of(&design_findings(&good, 1).unwrap()).is_empty());
}

#[test]
fn table_6_is_answered_by_exclusion() {
    let report = design_findings(&inversions(), 1).unwrap();
    let chance = &report.chance[0];
    within(chance.mean, 8.0, 1e-12);
    within(chance.sd, 8f64.sqrt(), 1e-12);
    within(chance.sd_independent, (24.0 * 2.0 / 9.0_f64).sqrt(), 1e-12);
    let found = report
        .faults
        .iter()
        .find(|f| matches!(f.fault, Fault::AnswersByExclusion { .. }));
    assert!(matches!(
        found.unwrap().fault,
        Fault::AnswersByExclusion {
            permutations: Some(8),
            ..
        }
    ));
    // Only the pairs of the two sets are wanted.
    assert!(
        !report
            .faults
            .iter()
            .any(|f| matches!(f.fault, Fault::PairsNeverTogether { .. }))
    );
    // One test that repeats a sample takes exclusion away.
    let mut good = inversions();
    let TaskKind::Associate {
        sequence: SequenceRule::Fixed { tests, .. },
    } = &mut good.tasks[0].task
    else {
        panic!("not fixed");
    };
    tests[1][2] = words("S8 S8 S11");
    let report = design_findings(&good, 1).unwrap();
    assert!(
        !report
            .faults
            .iter()
            .any(|f| matches!(f.fault, Fault::AnswersByExclusion { .. }))
    );
    within(report.chance[0].sd, (24.0 * 2.0 / 9.0_f64).sqrt(), 1e-12);
    // Drawn sequences with repeats have no such fault, drawn permutations have.
    let dependent = |sequence| {
        let mut drawn = isotropic();
        drawn.tasks[2].task = associate(sequence);
        let faults = design_findings(&drawn, 1).unwrap().faults;
        faults.iter().any(|f| {
            matches!(
                f.fault,
                Fault::AnswersByExclusion {
                    permutations: None,
                    ..
                }
            )
        })
    };
    assert!(dependent(SequenceRule::Permutation));
    assert!(!dependent(SequenceRule::Independent {
        shortest: 3,
        longest: 4
    }));
}

#[test]
fn chapter_6_confounds_natural_touch_with_order() {
    let report = design_findings(&imagery(), 1).unwrap();
    let [order, power, cells] = &report.faults[..] else {
        panic!("{:?}", report.faults);
    };
    assert!(
        matches!(&order.fault, Fault::ConfoundedWithOrder { task, position: 1, .. } if task == "natural")
    );
    assert!(matches!(
        cells.fault,
        Fault::CannotBeBalanced {
            cells: 12,
            participants: 10
        }
    ));
    assert!(matches!(
        power.fault,
        Fault::PowerTooLow {
            participants: 10,
            ..
        }
    ));
    let better = power.better.as_ref().unwrap();
    assert_eq!(better.participants, [10, 34]);
    assert_eq!(cells.better.as_ref().unwrap().participants, [10, 12]);
    let orders = match &order.better.as_ref().unwrap().change {
        Change::EarlierMeasurement { orders } => orders.clone(),
        other => panic!("{other:?}"),
    };
    // With these orders and 36 people none of the faults is left.
    let mut good = imagery();
    good.task_orders = orders;
    good.participants = 36;
    good.counterbalanced[0].orders = 6;
    let report = design_findings(&good, 1).unwrap();
    assert!(report.faults.is_empty(), "{:?}", report.faults);
    // The order, its cells and its power, and the mean rating of each of the three tasks.
    assert_eq!(report.criteria.len(), 6);
    // Where the two others alone are compared, natural touch confounds nothing.
    let mut two = imagery();
    two.comparisons[0].tasks = words("control imagery");
    let report = design_findings(&two, 1).unwrap();
    assert!(
        !report
            .faults
            .iter()
            .any(|f| matches!(f.fault, Fault::ConfoundedWithOrder { .. }))
    );
}

#[test]
fn too_few_presentations_are_said_with_what_would_do() {
    let report = design_findings(&isotropic(), 1).unwrap();
    let of = &report.precision[0];
    assert_eq!(of.sample, "S6");
    within(of.presentations, 3.5 / 3.0, 1e-12);
    let found = report
        .faults
        .iter()
        .find(|f| matches!(f.fault, Fault::IntervalTooWide { .. }))
        .unwrap();
    let better = found.better.as_ref().unwrap();
    let mut good = isotropic();
    good.participants = better.participants[1];
    match better.change {
        Change::Presentations { presentations } => good.tasks[2].repeats = presentations,
        Change::Participants { .. } => {}
        ref other => panic!("{other:?}"),
    }
    let report = design_findings(&good, 1).unwrap();
    assert!(
        !report
            .faults
            .iter()
            .any(|f| matches!(f.fault, Fault::IntervalTooWide { .. }))
    );
}

/// Half-widths of simulated tables of answers that went through `piezotact answers` one by one, with their standard errors; that of
/// one presentation is enumerated.
#[test]
fn the_expected_interval_is_that_of_the_matrix() {
    let of = |participants, presentations| {
        let plan = CellPlan {
            participants,
            presentations,
            share: 0.8,
            logit_sd: 0.9,
        };
        cell_precision(&plan, 2000, 1).unwrap()
    };
    for (participants, presentations, half_width, error) in [
        (10, 1, 0.275, 0.0005_f64),
        (10, 7, 0.152, 0.0015),
        (5, 7, 0.2465, 0.0025),
        (5, 2, 0.328, 0.0029),
    ] {
        let found = of(participants, presentations);
        let own = (found.interval[1] - found.half_width_share) / 1.96;
        within(found.half_width_share, half_width, 3.0 * error.hypot(own));
        assert!(found.coverage_share > 0.95, "{found:?}");
    }
    let two = of(2, 7);
    assert_eq!((two.half_width_share, two.coverage_share), (0.5, 1.0));
}

#[test]
fn power_is_that_of_scipy() {
    for row in golden()["power"].as_array().unwrap() {
        let [n, d, power] = numbers(row)[..] else {
            panic!("{row}")
        };
        // The integral of 4000 steps.
        within(paired_power(n as usize, d).unwrap(), power, 1e-7);
    }
    for (d, rounded) in [(0.5, 0.29), (0.8, 0.62), (1.0, 0.80)] {
        within(paired_power(10, d).unwrap(), rounded, 0.005);
    }
    assert_eq!(participants_for_power(0.5, 0.8), Some(34));
}

#[test]
fn chance_is_that_of_scipy() {
    let golden = golden();
    let same = |found: &Matches, truth: &Value| {
        let truth = numbers(truth);
        assert_eq!(found.probability().len(), truth.len());
        // Rounding.
        found
            .probability()
            .iter()
            .zip(truth)
            .for_each(|(a, b)| within(*a, b, 1e-12));
    };
    for (n, truth) in golden["permutations"].as_object().unwrap() {
        same(&permutation_matches(n.parse().unwrap()), truth);
    }
    let permuted = permutation_matches(3).repeated(10);
    let independent = trial_matches(3, 30);
    same(&permuted, &golden["ten_triplets_permuted"]);
    same(&independent, &golden["ten_triplets_independent"]);
    within(permuted.mean(), 10.0, 1e-12);
    within(permuted.standard_deviation(), 3.16, 0.005);
    within(independent.standard_deviation(), 2.58, 0.005);
    within(permuted.at_least(15), 0.085, 5e-4);
    within(independent.at_least(15), 0.043, 5e-4);
    for row in golden["tau_sd"].as_array().unwrap() {
        let row = numbers(row);
        within(tau_null_sd(row[0] as usize).unwrap(), row[1], 1e-12);
    }
}

#[test]
fn chance_by_task_of_the_isotropic_campaign() {
    let report = design_findings(&isotropic(), 1).unwrap();
    let [all, sets, rendered] = &report.chance[..] else {
        panic!("{:?}", report.chance);
    };
    within(all.mean, 3.0, 1e-12);
    within(all.tau_sd.unwrap(), 0.2007, 5e-5);
    within(sets.whole_order_share.unwrap(), 1.0 / 6.0, 1e-15);
    within(rendered.mean, 14.0, 1e-9);
    within(rendered.answers, 42.0, 1e-9);
    within(rendered.permutation_share.unwrap(), 1.0 / 9.0, 1e-12);
}

#[test]
fn a_report_is_the_same_again_and_survives_json() {
    let report = design_findings(&isotropic(), 9).unwrap();
    assert_eq!(report, design_findings(&isotropic(), 9).unwrap());
    let text = serde_json::to_string(&report).unwrap();
    assert_eq!(serde_json::from_str::<DesignReport>(&text).unwrap(), report);
}

#[test]
fn bad_designs_are_refused() {
    let refused = |change: &dyn Fn(&mut CampaignDescription)| {
        let mut bad = isotropic();
        change(&mut bad);
        design_findings(&bad, 1).unwrap_err().to_string()
    };
    for (text, words) in [
        (refused(&|c| c.sets[3][1] = "S99".into()), "set 4 names S99"),
        (refused(&|c| c.tray = 2), "the tray holds 2"),
        (
            refused(&|c| c.sets[0] = words("S1 S1 S2")),
            "holds S1 twice",
        ),
        (refused(&|c| c.sets.clear()), "no set of samples"),
        (refused(&|c| c.sets_shared_over = 0), "share the sets"),
        (
            refused(&|c| c.participants = 0),
            "number of participants is 0",
        ),
        (
            refused(&|c| c.tasks[0].repeats = 0),
            "repeats of a task is 0",
        ),
        (
            refused(&|c| c.tasks[0].seconds_per_trial = f64::NAN),
            "time of a trial",
        ),
        (refused(&|c| c.aims.power_share = 1.0), "wanted power is 1"),
        (
            refused(&|c| {
                c.tasks[2].task = associate(SequenceRule::AtMost {
                    shortest: 3,
                    longest: 3,
                    of_one: 1,
                })
            }),
            "follow by exclusion",
        ),
        (
            refused(&|c| {
                c.tasks[2].task = associate(SequenceRule::Fixed {
                    stimuli: Vec::new(),
                    tests: vec![vec![words("S2 S4 S8")]],
                })
            }),
            "fixed sequences for 1 sets",
        ),
        (
            refused(&|c| {
                c.comparisons = vec![Comparison {
                    tasks: words("x y"),
                    smallest_effect_ratio: 0.5,
                }]
            }),
            "task x",
        ),
    ] {
        assert!(text.contains(words), "{text}");
    }
}
