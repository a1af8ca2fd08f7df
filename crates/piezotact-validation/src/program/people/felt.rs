//! What `piezotact answers --felt` says of two textures: how far apart they are in level and in spectrum, JND.

use std::collections::BTreeSet;

use anyhow::{Context as _, Result};
use piezotact::criterion::{Criterion, Limit};
use piezotact::discrimination::Model;
use piezotact::quantity::{Acceleration, Band, Hertz, SampleRate};
use piezotact::series::Series;
use piezotact::statistics::random::Random;
use piezotact_people::association::{
    CONFUSED_SHARE, ConfusedPair, FeltCriterion, FeltRecording, PairCriterion, PairOutcome,
    felt_pairs,
};

use super::{Found, Printed, Question, Scenario};

const STUDIES: usize = 200;
const RATE_HZ: f64 = 2_100.0;
/// How long each texture is recorded, and how long for the truth, s.
const RECORDED_S: f64 = 10.0;
const LONG_S: f64 = 200.0;
/// The level of textures that are well felt, m/s² rms.
const LEVEL_M_S2: f64 = 5.0;
const QUESTIONS: [FeltCriterion; 2] = [FeltCriterion::Level, FeltCriterion::Spectrum];

/// Noise whose power falls over frequency the more, the nearer `smooth` is to 1.
fn texture(
    sample: &str,
    level: f64,
    smooth: f64,
    (duration_s, random): (f64, &mut Random),
) -> Result<FeltRecording> {
    let mut last = 0.0;
    let scale = level * (1.0 - smooth * smooth).sqrt();
    let samples = (0..(duration_s * RATE_HZ) as usize).map(|_| {
        last = smooth * last + scale * random.normal();
        last
    });
    let series = Series::<Acceleration>::new(samples.collect(), SampleRate::new(RATE_HZ)?)?;
    Ok(FeltRecording {
        participant: None,
        sample: sample.to_owned(),
        vibration: Ok(series),
    })
}

/// What is found of two textures whose amplitudes have this ratio.
fn criteria(ratio: f64, duration_s: f64, seed: u64) -> Result<Vec<Criterion<FeltCriterion>>> {
    let mut random = Random::stream(seed, 0, "felt");
    let recordings = [
        texture("A", LEVEL_M_S2, 0.5, (duration_s, &mut random))?,
        texture("B", LEVEL_M_S2 * ratio, 0.8, (duration_s, &mut random))?,
    ];
    let pair = ConfusedPair {
        pair: ["A", "B"].map(str::to_owned),
        declared: [5, 5],
        presented: [10, 10],
        criterion: Criterion::unmeasured(
            PairCriterion::ConfusedShare,
            "",
            Limit::at_least(CONFUSED_SHARE),
        ),
        outcome: PairOutcome::NotDecided,
    };
    let model = Model::over(Band::new(Hertz(20.0), Hertz(1_000.0))?);
    let people = BTreeSet::from(["P1".to_owned()]);
    let (felt, _) = felt_pairs(&[pair], &recordings, &people, &model);
    let compared = felt.pairs.first().and_then(|pair| pair.comparisons.first());
    Ok(compared.context("nothing is compared")?.criteria.clone())
}

fn of(
    criteria: &[Criterion<FeltCriterion>],
    what: FeltCriterion,
) -> Option<&Criterion<FeltCriterion>> {
    criteria.iter().find(|one| one.what == what)
}

pub(super) fn scenarios() -> Vec<Scenario> {
    let all = [("other spectrum, 5 dB apart", 5.0)];
    let scenario = |(name, apart_db): (&'static str, f64)| -> Option<Scenario> {
        let ratio = 10f64.powf(apart_db / 20.0);
        let long = criteria(ratio, LONG_S, 0).ok()?;
        let truths = QUESTIONS.map(|what| of(&long, what).and_then(|one| one.found));
        let study = move |seed: u64| -> Result<Vec<Found>> {
            let found = criteria(ratio, RECORDED_S, seed)?;
            let each = QUESTIONS.iter().zip(truths).map(|(what, truth)| {
                let interval = of(&found, *what).and_then(|one| one.interval);
                Found::estimated(interval, truth.unwrap_or(f64::NAN))
            });
            Ok(each.collect())
        };
        Some(Scenario {
            questions: ["level, JND", "spectrum, JND"]
                .map(|question| Question::of(question, Printed::Interval))
                .into(),
            name,
            people: "1".into(),
            studies: STUDIES,
            study: Box::new(move |seed, _| study(seed)),
        })
    };
    all.into_iter().filter_map(scenario).collect()
}
