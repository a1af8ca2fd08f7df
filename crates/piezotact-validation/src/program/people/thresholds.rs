//! Thresholds of adaptive runs, as `piezotact campaign export` writes them.

use anyhow::{Context as _, Result};
use piezotact::criterion::Outcome;
use piezotact::statistics::random::Random;
use piezotact_people::campaign::adaptive::{
    AdaptiveRule, AdaptiveRun, GUESS_SHARE, Response, ThresholdCriterion, weibull,
};

use super::{Found, Printed, Question, Scenario};

const STUDIES: usize = 1_000;
/// The levels, dB.
const LOWEST_DB: i32 = -30;
const HIGHEST_DB: i32 = 10;
/// The slopes and lapses of people, which are those that the rule holds possible.
const SLOPES: [f64; 3] = [1.0, 2.0, 3.0];
const LAPSE_SHARES: [f64; 2] = [0.0, 0.04];
/// Usual for a threshold in dB.
const LARGEST_SD_DB: f64 = 3.0;

fn levels_db() -> Vec<f64> {
    (LOWEST_DB..=HIGHEST_DB).map(f64::from).collect()
}

/// A run with a person of this threshold.
fn ran(start: &AdaptiveRun, threshold_db: f64, random: &mut Random) -> AdaptiveRun {
    let levels_db = levels_db();
    let slope = SLOPES[(random.uniform() * SLOPES.len() as f64) as usize];
    let lapse = LAPSE_SHARES[(random.uniform() * LAPSE_SHARES.len() as f64) as usize];
    let mut run = start.clone();
    while let Some(level) = run.next_level() {
        let correct = weibull(levels_db[level], threshold_db, slope, GUESS_SHARE, lapse);
        let answer = match random.uniform() < correct {
            true => Response::Correct,
            false => Response::Wrong,
        };
        run.answer(level, answer);
    }
    run
}

pub(super) fn scenarios() -> Vec<Scenario> {
    [20, 40, 80].map(quest).into_iter().flatten().collect()
}

/// QUEST+ of so many trials.
fn quest(trials: u32) -> Option<Scenario> {
    let rule = AdaptiveRule::QuestPlus {
        thresholds_db: levels_db(),
        slopes: SLOPES.to_vec(),
        lapse_shares: LAPSE_SHARES.to_vec(),
        trials,
    };
    let start = AdaptiveRun::new(&levels_db(), &rule).ok()?;
    let study = move |seed: u64| -> Result<Vec<Found>> {
        let mut random = Random::stream(seed, u64::from(trials), "quest");
        let threshold_db = -20.0 + 20.0 * random.uniform();
        let found = ran(&start, threshold_db, &mut random).estimate(LARGEST_SD_DB);
        let mut criteria = found.criteria.iter();
        let interval = criteria
            .find(|one| one.what == ThresholdCriterion::AboveLowest)
            .context("no interval")?
            .interval;
        let decided = found.decided() == Outcome::Met;
        Ok(vec![Found::estimated(
            interval.filter(|_| decided),
            threshold_db,
        )])
    };
    Some(Scenario {
        questions: vec![Question::of("threshold of QUEST+", Printed::Interval)],
        name: match trials {
            20 => "20 trials",
            40 => "40 trials",
            _ => "80 trials",
        },
        people: "1".into(),
        studies: STUDIES,
        study: Box::new(move |seed, _| study(seed)),
    })
}
