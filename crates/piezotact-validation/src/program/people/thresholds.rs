//! Thresholds of adaptive runs, as `piezotact campaign export` writes them, by the rules of the library: JND of level and detection.

use anyhow::{Context as _, Result};
use piezotact::criterion::Outcome;
use piezotact::statistics::random::Random;
use piezotact_people::campaign::adaptive::{
    AdaptiveRule, AdaptiveRun, GUESS_SHARE, Response, ThresholdEstimate, weibull,
};
use piezotact_people::campaign::protocol::{Adaptive, Method, TaskKind, from_library};

use super::{Found, Printed, Question, Scenario, World};

const STUDIES: usize = 1_000;
/// The slopes and lapses of people, which are those that the rules hold possible.
const SLOPES: [f64; 3] = [1.0, 2.0, 3.0];
const LAPSE_SHARES: [f64; 2] = [0.0, 0.04];
/// Thresholds of people lie in the levels without this share at both ends.
const AT_ENDS_SHARE: f64 = 0.2;
/// How far beyond the levels a threshold is that no level reaches, dB.
const BEYOND_DB: f64 = 20.0;

/// How the answers of people follow from the level.
#[derive(Clone, Copy)]
enum People {
    /// By the Weibull function of the rules.
    Weibull,
    /// By a logistic function of the amplitude, which is nearly what two levels with normal noise give (Thurstone 1927, case V).
    Logistic,
}

/// The share of right answers at `level_db` of one with the threshold `at_db`, at which `share` of them are right.
fn right(people: People, level_db: f64, (at_db, share): (f64, f64), slope: f64, lapse: f64) -> f64 {
    match people {
        People::Weibull => {
            let of = ((1.0 - lapse - share) / (1.0 - GUESS_SHARE - lapse)).ln();
            let threshold_db = at_db - 20.0 / slope * (-of).log10();
            weibull(level_db, threshold_db, slope, GUESS_SHARE, lapse)
        }
        People::Logistic => {
            let at = (share / (1.0 - share)).ln();
            1.0 / (1.0 + (-at * 10_f64.powf((level_db - at_db) / 20.0)).exp())
        }
    }
}

/// What a run says of one with the threshold `at_db`; of one who guesses where it is infinite.
fn ran(
    (start, adaptive): (&AdaptiveRun, &Adaptive),
    people: People,
    at_db: f64,
    random: &mut Random,
) -> ThresholdEstimate {
    let levels_db = adaptive.levels();
    let slope = SLOPES[(random.uniform() * SLOPES.len() as f64) as usize];
    let lapse = LAPSE_SHARES[(random.uniform() * LAPSE_SHARES.len() as f64) as usize];
    // QUEST+ means its Weibull threshold, whatever the lapses; a staircase the share that it converges to.
    let share = match &adaptive.rule {
        AdaptiveRule::QuestPlus { .. } => weibull(
            0.0,
            0.0,
            slope,
            GUESS_SHARE,
            match people {
                People::Weibull => lapse,
                People::Logistic => 0.0,
            },
        ),
        AdaptiveRule::Staircase { staircase, .. } => 0.5_f64.powf(1.0 / f64::from(staircase.down)),
    };
    let mut run = start.clone();
    while let Some(level) = run.next_level() {
        let correct = right(people, levels_db[level], (at_db, share), slope, lapse);
        let answer = match random.uniform() < correct {
            true => Response::Correct,
            false => Response::Wrong,
        };
        run.answer(level, answer);
    }
    run.estimate(adaptive.largest_sd)
}

pub(super) fn scenarios() -> Vec<Scenario> {
    [
        (
            "roughness_jnd",
            "quest",
            80,
            People::Weibull,
            "JND, QUEST+ of 80 trials",
        ),
        (
            "roughness_jnd",
            "quest",
            50,
            People::Weibull,
            "JND, QUEST+ of 50 trials",
        ),
        (
            "roughness_jnd",
            "quest",
            50,
            People::Logistic,
            "JND, QUEST+, logistic people",
        ),
        (
            "roughness_jnd",
            "staircase",
            0,
            People::Weibull,
            "JND, staircase",
        ),
        (
            "detection_threshold",
            "quest",
            50,
            People::Weibull,
            "detection, QUEST+ of 50 trials",
        ),
        (
            "detection_threshold",
            "staircase",
            0,
            People::Weibull,
            "detection, staircase",
        ),
    ]
    .into_iter()
    .filter_map(scenario)
    .collect()
}

/// Runs of a task of a protocol of the library: with people of a threshold within the levels, with one beyond them, with people who guess.
fn scenario(
    (protocol, task, of_trials, people, name): (&str, &str, u32, People, &'static str),
) -> Option<Scenario> {
    let protocol = from_library(protocol).ok()??;
    let TaskKind::Compare {
        method: Method::Adaptive(mut adaptive),
        ..
    } = protocol.task(task)?.kind.clone()
    else {
        return None;
    };
    if let AdaptiveRule::QuestPlus { trials, .. } = &mut adaptive.rule {
        *trials = of_trials;
    }
    let levels_db = adaptive.levels();
    let (lowest, highest) = (*levels_db.first()?, *levels_db.last()?);
    let start = AdaptiveRun::new(&levels_db, &adaptive.rule).ok()?;
    let study = move |seed: u64, world: World| -> Result<Vec<Found>> {
        let mut random = Random::stream(seed, u64::from(of_trials), name);
        let inner = lowest
            + (highest - lowest) * (AT_ENDS_SHARE + (1.0 - 2.0 * AT_ENDS_SHARE) * random.uniform());
        let run = |at_db: f64, random: &mut Random| ran((&start, &adaptive), people, at_db, random);
        let found = run(inner, &mut random);
        let level = found.level.context("no level")?;
        let decided = |one: &ThresholdEstimate| one.decided() == Outcome::Met;
        let mut threshold = Found::estimated(found.interval, inner);
        threshold.error = decided(&found).then_some(level - inner);
        let [guessing, beyond] = match world {
            World::Effect => [run(inner, &mut random), run(inner, &mut random)],
            World::Null => {
                let beyond = match random.uniform() < 0.5 {
                    true => lowest - BEYOND_DB,
                    false => highest + BEYOND_DB,
                };
                [run(f64::INFINITY, &mut random), run(beyond, &mut random)]
            }
        };
        let concluded = |one: ThresholdEstimate| Found::tested(decided(&one).then_some(true));
        Ok(vec![threshold, concluded(guessing), concluded(beyond)])
    };
    Some(Scenario {
        questions: vec![
            Question::of("threshold", Printed::Interval),
            Question::of("threshold of one who guesses", Printed::Test),
            Question::of("threshold beyond the levels", Printed::Test),
        ],
        name,
        people: "1".into(),
        studies: STUDIES,
        study: Box::new(study),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A threshold is where the share is: 81.6 % for QUEST+ of one who never lapses, 79.4 % for three down and one up.
    #[test]
    fn people_have_the_threshold_that_is_stated() {
        for share in [0.816_060_279, 0.793_700_526] {
            for people in [People::Weibull, People::Logistic] {
                let at = |db: f64| right(people, db, (-20.0, share), 2.0, 0.0);
                assert!((at(-20.0) - share).abs() < 1e-6);
                assert!(at(-40.0) < share && at(0.0) > share);
                assert!((right(people, -8.0, (f64::INFINITY, share), 2.0, 0.0) - 0.5).abs() < 1e-9);
            }
        }
    }
}
