//! `piezotact-validation intervals`: how often the 95 % intervals that `strokes`, `compare`, `score` and `verify` print hold the truth.

#![allow(clippy::print_stdout, reason = "it prints a table")]

use std::f64::consts::TAU;

use anyhow::{Result, ensure};
use piezotact::compare::{DiscriminationConfig, Sliding, discriminate, spatial_period};
use piezotact::discrimination::Model;
use piezotact::quantity::{Acceleration, Band, Hertz, SampleRate};
use piezotact::series::Series;
use piezotact::statistics::{log_fit, mean_interval, paired_difference};
use piezotact::verify::{Measured, VerifyConfig, VerifyCriterion, verify};

use super::signal::{Draws, RATE_HZ};
use super::studies::{Change, Random, sample, spectrum, spectrum_apart};
use super::verdicts::in_threads;

/// The share of intervals that have to hold the truth.
const ASKED: (f64, f64) = (0.93, 0.97);

/// An interval, with what it is for and how it is simulated.
struct Row {
    name: &'static str,
    simulations: u64,
    /// The truth.
    truth: f64,
    /// One interval from a seed; none where it is withheld.
    interval: fn(u64) -> Result<Option<[f64; 2]>>,
}

/// A power law of the exponent 0.8 with 10 % of scatter, over so many points.
fn exponent<const POINTS: usize>(seed: u64) -> Result<Option<[f64; 2]>> {
    let mut draws = Draws::of(seed, "exponent");
    let x: Vec<f64> = (0..POINTS).map(|i| 1.5f64.powi(i as i32)).collect();
    let y = x.iter().map(|x| x.powf(0.8) * (0.1 * draws.normal()).exp());
    let y: Vec<f64> = y.collect();
    Ok(log_fit(&x, &y).and_then(|fit| fit.slope_interval))
}

/// Levels of two directions, 2 dB apart, with a scatter of 1 dB, in so many settings.
fn difference<const UNITS: usize>(seed: u64) -> Result<Option<[f64; 2]>> {
    let mut draws = Draws::of(seed, "difference");
    let levels = (0..UNITS).map(|_| 2.0 + draws.normal());
    let found = paired_difference(&[0.0; UNITS], &levels.collect::<Vec<_>>());
    Ok(found.map(|found| found.interval))
}

/// The mean of so many levels of 5 dB with a scatter of 2 dB, as that of recordings or people.
fn middle<const UNITS: usize>(seed: u64) -> Result<Option<[f64; 2]>> {
    let mut draws = Draws::of(seed, "mean");
    let levels: Vec<f64> = (0..UNITS).map(|_| 5.0 + 2.0 * draws.normal()).collect();
    Ok(mean_interval(&levels))
}

/// The period of lines of 1 mm, with two harmonics and noise, at 10, 20 and 30 mm/s under `loads` loads; the speed of a recording is off by
/// 0.5 %.
fn period(seed: u64, loads: usize) -> Result<Option<[f64; 2]>> {
    let mut draws = Draws::of(seed, "period");
    let rate = SampleRate::new(2_000.0)?;
    let mut recorded = Vec::new();
    for load in 0..loads {
        for speed_m_s in [0.01, 0.02, 0.03] {
            let true_m_s = speed_m_s * (1.0 + 0.005 * draws.normal());
            let strokes: Vec<Vec<f64>> = (0..5)
                .map(|_| {
                    let turn = draws.uniform();
                    let wave = |i: usize, order: f64| {
                        let turns = order * true_m_s / 1e-3 * i as f64 / rate.hz();
                        (TAU * (turns + order * turn)).sin() / order
                    };
                    let noise = draws.white(3_000).into_iter().enumerate();
                    noise
                        .map(|(i, v)| v + wave(i, 1.0) + wave(i, 2.0) + wave(i, 3.0))
                        .collect()
                })
                .collect();
            recorded.push((load, speed_m_s, strokes));
        }
    }
    let slidings = recorded.iter().map(|(load, speed_m_s, strokes)| Sliding {
        speed_m_s: *speed_m_s,
        rate,
        group: format!("{load}"),
        stretches: strokes.iter().map(Vec::as_slice).collect(),
    });
    let found = spatial_period(&slidings.collect::<Vec<_>>(), Hertz(5.0));
    Ok(found.and_then(|found| found.interval_m))
}

fn model() -> Result<Model> {
    Ok(Model::over(Band::new(Hertz(20.0), Hertz(1_000.0))?))
}

/// The distance of samples of 15 strokes each whose spectra are `jnd` apart, in a change of level.
fn distance(seed: u64, jnd: f64) -> Result<Option<[f64; 2]>> {
    let model = model()?;
    let config = DiscriminationConfig::usual(model.clone());
    let mut random = Random::new(seed);
    let plain = spectrum(Change::Level, 0.0);
    let other = spectrum_apart(&model, Change::Level, jnd);
    let textures = [("A", &plain), ("B", &other)]
        .map(|(name, texture)| sample(&mut random, name, texture, [1, 15], 0.0));
    let found = discriminate(&[textures.to_vec()], &config)?;
    Ok(found.settings[0].pairs[0].interval_jnd)
}

/// The level of a measurement of noise of 10 s with a gain of 0.7 dB and noise of its own of −10 dB.
fn level(seed: u64) -> Result<Option<[f64; 2]>> {
    let mut draws = Draws::of(seed, "level");
    let rate = SampleRate::new(RATE_HZ)?;
    let smooth = |x: Vec<f64>| -> Vec<f64> {
        let mut last = 0.0;
        let step = |v: f64| {
            last += 0.3 * (v - last);
            last
        };
        x.into_iter().map(step).collect()
    };
    let count = (10.0 * RATE_HZ) as usize;
    let target = smooth(draws.white(count));
    let added = smooth(draws.white(count));
    let gain = 10f64.powf(0.7 / 20.0);
    let silence = vec![0.0; RATE_HZ as usize / 2];
    let measured = target.iter().zip(&added);
    let measured: Vec<f64> = measured
        .map(|(v, n)| gain * v + 10f64.powf(-0.5) * n)
        .collect();
    let measured = [silence.clone(), measured, silence].concat();
    let series = |samples| Series::<Acceleration>::new(samples, rate);
    let config = VerifyConfig::over(Band::new(Hertz(30.0), Hertz(500.0))?, RATE_HZ);
    let seen = series(measured)?;
    let found = verify(&series(target)?, Measured::alone(&seen), &config)?;
    let criteria = found.criteria.iter();
    let mut level = criteria.filter(|c| c.what == VerifyCriterion::Level);
    Ok(level.next().and_then(|c| c.interval))
}

/// The level of [`level`]: of all that was measured.
fn level_db() -> f64 {
    10.0 * (10f64.powf(0.07) + 0.1).log10()
}

fn rows() -> Vec<Row> {
    let row = |name, simulations, truth, interval| Row {
        name,
        simulations,
        truth,
        interval,
    };
    vec![
        row("exponent over 3 points", 2_000, 0.8, exponent::<3>),
        row("exponent over 4 points", 2_000, 0.8, exponent::<4>),
        row("exponent over 6 points", 2_000, 0.8, exponent::<6>),
        row(
            "difference in level over 3 settings",
            2_000,
            2.0,
            difference::<3>,
        ),
        row(
            "difference in level over 8 settings",
            2_000,
            2.0,
            difference::<8>,
        ),
        row("mean level over 3 recordings", 2_000, 5.0, middle::<3>),
        row("mean level over 10 people", 2_000, 5.0, middle::<10>),
        row("period over 3 recordings", 600, 1e-3, |seed| {
            period(seed, 1)
        }),
        row("period over 3 loads", 600, 1e-3, |seed| period(seed, 3)),
        row("distance of samples, 1 JND", 600, 1.0, |seed| {
            distance(seed, 1.0)
        }),
        row("distance of samples, 3 JND", 600, 3.0, |seed| {
            distance(seed, 3.0)
        }),
        row("level of a verification", 400, level_db(), level),
    ]
}

/// Prints the table.
pub(crate) fn run() -> Result<()> {
    println!(
        "\nI1 intervals of 95 % that hold the truth, below and above it, and those that are withheld"
    );
    println!(
        "  {:<40}{:>12}{:>9}{:>9}{:>9}{:>10}",
        "interval", "simulations", "hold, %", "below", "above", "withheld"
    );
    let mut missed = Vec::new();
    for row in rows() {
        let found = in_threads(row.simulations as usize, |i| (row.interval)(i as u64 + 1))?;
        let known: Vec<[f64; 2]> = found.iter().flatten().copied().collect();
        let below = known.iter().filter(|[_, high]| *high < row.truth).count();
        let above = known.iter().filter(|[low, _]| *low > row.truth).count();
        let share = 1.0 - (below + above) as f64 / known.len().max(1) as f64;
        println!(
            "  {:<40}{:>12}{:>9.1}{below:>9}{above:>9}{:>10}",
            row.name,
            row.simulations,
            100.0 * share,
            found.len() - known.len()
        );
        // What so many simulations scatter by, twice.
        let scatter = 2.0 * (0.05 * 0.95 / known.len().max(1) as f64).sqrt();
        if share < ASKED.0 - scatter || share > ASKED.1 + scatter {
            missed.push(format!("{} ({:.1} %)", row.name, 100.0 * share));
        }
    }
    ensure!(
        missed.is_empty(),
        "not within {:.0} to {:.0} %: {}",
        100.0 * ASKED.0,
        100.0 * ASKED.1,
        missed.join(", ")
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::studies::{BINS, RESOLUTION_HZ};
    use super::*;
    use piezotact::discrimination::ExcitationPlan;

    /// The distance that is simulated is the one that is asked for, and an interval is near its truth.
    #[test]
    fn the_truth_of_a_distance_is_that_of_the_spectra() {
        let model = model().unwrap();
        let plan = ExcitationPlan::new(&model, BINS, RESOLUTION_HZ);
        let [plain, other] =
            [0.0, 3.0].map(|jnd| plan.of(&spectrum_apart(&model, Change::Level, jnd)).sums);
        assert!((model.distance_jnd(&plain, &other) - 3.0).abs() < 1e-6);
        for row in rows() {
            let [low, high] = (row.interval)(5).unwrap().unwrap();
            let reach = (high - low).max(1e-9);
            assert!(
                low - 3.0 * reach < row.truth && row.truth < high + 3.0 * reach,
                "{}: {low} {high} {}",
                row.name,
                row.truth
            );
        }
    }
}
