//! Staircases and QUEST+ on 500 simulated observers, beside the same runs by programs of others (`golden/adaptive.py`).
#![allow(clippy::unwrap_used, reason = "a test fails where it cannot go on")]
#![allow(clippy::print_stdout, reason = "the figures are the result")]

use piezotact_people::campaign::adaptive::{
    QuestPlus, QuestRule, Response, Staircase, StaircaseRule, Start, weibull,
};
use serde::Deserialize;

const GOLDEN: &str = include_str!("golden/adaptive.json");

#[derive(Deserialize)]
struct Golden {
    observers: u64,
    trials: u32,
    quest: Runs,
    staircase: Runs,
}

#[derive(Deserialize)]
struct Runs {
    bias_db: f64,
    sd_db: f64,
    estimates_db: Vec<f64>,
    levels_db: Vec<Vec<f64>>,
}

/// An observer: its threshold in dB, and the numbers that decide its answers (`SplitMix64`, as in the script).
struct Observer {
    threshold_db: f64,
    state: u64,
}

impl Observer {
    fn new(index: u64) -> Self {
        let mut observer = Self {
            threshold_db: 0.0,
            state: index + 1,
        };
        observer.threshold_db = -30.0 + 20.0 * observer.uniform();
        observer
    }

    fn uniform(&mut self) -> f64 {
        self.state = self.state.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^= z >> 31;
        (z >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn answers(&mut self, level_db: f64) -> Response {
        let share = weibull(level_db, self.threshold_db, 3.5, 0.5, 0.02);
        match self.uniform() < share {
            true => Response::Correct,
            false => Response::Wrong,
        }
    }
}

fn quest_rule(trials: u32) -> QuestRule {
    let grid: Vec<f64> = (0..=40).map(|i| -40.0 + f64::from(i)).collect();
    QuestRule {
        levels_db: grid.clone(),
        thresholds_db: grid,
        slopes: vec![2.0, 3.5, 5.0],
        guess_share: 0.5,
        lapse_shares: vec![0.0, 0.02, 0.04],
        trials,
    }
}

fn staircase_rule() -> StaircaseRule {
    StaircaseRule {
        first: 0.0,
        steps: vec![4.0, 4.0, 2.0, 2.0, 1.0],
        down: 3,
        up: 1,
        start: Start::OneUpOneDown,
        lowest: -60.0,
        highest: 0.0,
        reversals: 12,
        trials: 0,
        left_out: 4,
    }
}

/// The estimate and the levels of a QUEST+ run.
fn quest(plan: &QuestPlus, rule: &QuestRule, mut observer: Observer) -> (f64, Vec<f64>) {
    let (mut run, mut levels) = (plan.clone(), Vec::new());
    while let Some(level) = run.next_level() {
        levels.push(rule.levels_db[level]);
        run.answer(level, observer.answers(rule.levels_db[level]));
    }
    (run.estimate().threshold_db, levels)
}

fn staircase(mut observer: Observer) -> (f64, Vec<f64>) {
    let (mut run, mut levels) = (Staircase::new(staircase_rule()).unwrap(), Vec::new());
    while let Some(level) = run.next_level() {
        levels.push(level);
        run.answer(observer.answers(level));
    }
    (run.estimate().unwrap().level, levels)
}

/// Mean and standard deviation of the errors in dB.
fn bias_and_sd(errors: &[f64]) -> (f64, f64) {
    let count = errors.len() as f64;
    let mean = errors.iter().sum::<f64>() / count;
    let squares: f64 = errors.iter().map(|error| (error - mean).powi(2)).sum();
    (mean, (squares / (count - 1.0)).sqrt())
}

/// Bias and spread within 10 % of the reference; the bias counts in units of the spread, as it may be near zero.
fn agrees(name: &str, estimates: &[f64], golden: &Runs) {
    let errors: Vec<f64> = estimates
        .iter()
        .enumerate()
        .map(|(i, estimate)| estimate - Observer::new(i as u64).threshold_db)
        .collect();
    let (bias, sd) = bias_and_sd(&errors);
    println!(
        "{name}: bias {bias:.4} dB (reference {:.4}), spread {sd:.4} dB ({:.4})",
        golden.bias_db, golden.sd_db
    );
    assert!((sd / golden.sd_db - 1.0).abs() < 0.1, "{name}: spread {sd}");
    assert!(
        (bias - golden.bias_db).abs() < 0.1 * golden.sd_db,
        "{name}: bias {bias}"
    );
}

#[test]
fn quest_plus_recovers_the_thresholds_of_500_observers_as_its_reference() {
    let golden: Golden = serde_json::from_str(GOLDEN).unwrap();
    let rule = quest_rule(golden.trials);
    let plan = QuestPlus::new(rule.clone()).unwrap();
    let runs: Vec<_> = (0..golden.observers)
        .map(|i| quest(&plan, &rule, Observer::new(i)))
        .collect();
    let estimates: Vec<f64> = runs.iter().map(|(estimate, _)| *estimate).collect();
    agrees("QUEST+", &estimates, &golden.quest);
    // Where two levels leave the same entropy, rounding decides, and the runs part. They are the exception.
    let same = estimates
        .iter()
        .zip(&golden.quest.estimates_db)
        .filter(|(a, b)| (*a - *b).abs() < 1e-9)
        .count();
    println!(
        "QUEST+: {same} of {} estimates are the same to 1e-9 dB",
        golden.observers
    );
    assert!(
        same as u64 * 100 >= golden.observers * 95,
        "{same} estimates are the same"
    );
    let levels = runs
        .iter()
        .zip(&golden.quest.levels_db)
        .filter(|((_, ours), theirs)| ours == *theirs)
        .count();
    assert!(
        levels >= 18,
        "{levels} of 20 runs presented the same levels"
    );
}

#[test]
fn staircases_recover_the_thresholds_of_500_observers_as_their_reference() {
    let golden: Golden = serde_json::from_str(GOLDEN).unwrap();
    let runs: Vec<_> = (0..golden.observers)
        .map(|i| staircase(Observer::new(i)))
        .collect();
    for (i, ((_, ours), theirs)) in runs.iter().zip(&golden.staircase.levels_db).enumerate() {
        assert_eq!(ours, theirs, "observer {i}");
    }
    let estimates: Vec<f64> = runs.iter().map(|(estimate, _)| *estimate).collect();
    for (i, (ours, theirs)) in estimates
        .iter()
        .zip(&golden.staircase.estimates_db)
        .enumerate()
    {
        assert!(
            (ours - theirs).abs() < 1e-9,
            "observer {i}: {ours} beside {theirs}"
        );
    }
    agrees("staircase", &estimates, &golden.staircase);
}

/// By golden/thresholds.py: questplus 2023.1, which psychopy wraps. Sums of 450 points agree to rounding.
#[test]
fn the_posterior_after_fixed_answers_is_that_of_questplus() {
    let levels_db: Vec<f64> = (0..17).map(|i| -40.0 + 2.0 * f64::from(i)).collect();
    let mut run = QuestPlus::new(QuestRule {
        levels_db: levels_db.clone(),
        thresholds_db: (-48..=0).map(f64::from).collect(),
        slopes: vec![1.0, 2.0, 3.0],
        guess_share: 0.5,
        lapse_shares: vec![0.0, 0.02, 0.04],
        trials: 50,
    })
    .unwrap();
    let levels = [
        -12, -20, -28, -24, -26, -22, -26, -28, -24, -20, -22, -26, -22, -18, -24, -20,
    ];
    let correct = [1, 1, 0, 1, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 1];
    for (level, correct) in levels.into_iter().zip(correct) {
        let at = levels_db.iter().position(|one| *one == f64::from(level));
        let said = match correct {
            1 => Response::Correct,
            _ => Response::Wrong,
        };
        run.answer(at.unwrap(), said);
    }
    let found = run.estimate();
    for (found, theirs) in [
        (found.threshold_db, -16.537_431_083_887_263),
        (found.threshold_sd_db, 6.101_098_962_834_485),
        (found.slope, 2.131_876_604_906_916_7),
        (found.lapse_share, 0.019_759_266_060_968_01),
    ] {
        assert!((found - theirs).abs() < 1e-9, "{found} beside {theirs}");
    }
    assert_eq!(levels_db[run.next_level().unwrap()], -14.0);
}
