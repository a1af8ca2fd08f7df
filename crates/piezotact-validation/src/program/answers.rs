//! `piezotact-validation score-answers`: answers of virtual people who judge by other features than the score, predicted by the score, by the
//! level alone, and by the difference of the spectra.
//!
//! A person compares two intervals and feels d′ = √(Σ (wᵢ·Δᵢ)²) between two vibrations, of features of the acceleration as it is: levels of
//! third octaves in dB (20–630 Hz, lifted to 0.01 m/s²), the standard deviation of levels of 10 ms in dB, the spectral centroid in Hz, and
//! the crest factor in dB. None of them knows thresholds, channels or modulation bands. Answers are right with Φ(d′/√2) (Thurstone), and
//! guessed in 4 of 100. The weights are drawn for each world, and for each person about those of the world.

#![allow(clippy::print_stdout, reason = "it prints a table")]

use std::f64::consts::TAU;

use anyhow::{Context as _, Result};
use piezotact::perception::{D_PRIME_OF_JND, percent_correct};
use piezotact::quantity::{Acceleration, Band, Hertz, SampleRate, Seconds};
use piezotact::score::{ScoreConfig, score};
use piezotact::series::Series;
use piezotact::spectrum::{WelchConfig, welch};
use piezotact::statistics::random::Random;
use piezotact::statistics::{mean, rms, spearman, standard_deviation};
use piezotact_twin::{Participant, TwinParameters, record_texture};

use super::signal::RATE_HZ;
use super::verdicts::in_threads;

const SEED: u64 = 52;
const SECONDS: f64 = 2.0;
const SPEED_M_S: f64 = 0.03;
/// Textures of the twin, and how many pairs are made with each as the reference.
const SAMPLES: [&str; 8] = ["S2", "S4", "S6", "S8", "S10", "M4", "M8", "M11"];
const PAIRS_EACH: usize = 20;
/// The levels of vibrations, m/s² rms, and by how much the two of a pair differ, dB.
const LEVEL_M_S2: [f64; 2] = [0.7, 4.0];
const LEVEL_APART_DB: f64 = 3.0;
/// Modulation, Hz.
const RATES_HZ: [f64; 5] = [4.0, 8.0, 15.0, 25.0, 40.0];
/// The worlds, each with weights of its own, people and a split of the pairs.
const WORLDS: usize = 60;
const PEOPLE: usize = 12;
const TRIALS: usize = 24;
/// By so much, as a standard deviation of the logarithm, weights differ between worlds and between people.
const WORLD_SPREAD: f64 = 0.6;
const PERSON_SPREAD: f64 = 0.3;
const GUESSED: f64 = 0.04;
/// The weights in the middle of all worlds, with which each feature alone gives the d′ of one JND at the published JND: 2.3 dB of all third
/// octaves (Israr 2006), a depth of modulation of 0.3 on noise (Weisenberger 1986), which is 0.5 dB of the deviation of its levels, 30 Hz
/// of centroid (Israr 2006: 0.2 at 150 Hz); 3 dB of crest are chosen.
const WEIGHTS: [f64; FEATURES] = [
    D_PRIME_OF_JND / 2.3,
    D_PRIME_OF_JND / 0.5,
    D_PRIME_OF_JND / 30.0,
    D_PRIME_OF_JND / 3.0,
];
const FEATURES: usize = 4;
const PREDICTORS: [&str; 3] = [
    "perceived difference",
    "level alone",
    "difference of spectra",
];

const FIGURES: [&str; 3] = ["deviance, scale", "and floor", "rank correlation"];
const RANK: usize = 2;

/// A pair: how far apart it is for people, by feature, and for each predictor.
struct Pair {
    apart: [f64; FEATURES],
    predicted: [f64; PREDICTORS.len()],
}

/// A vibration of the twin, of one level.
fn passage(
    name: &str,
    person: u64,
    level_m_s2: f64,
    parameters: &TwinParameters,
) -> Result<Vec<f64>> {
    let participant = Participant::of(0, person, parameters);
    let sample = parameters.sample(name)?;
    let (series, ..) = record_texture(
        parameters,
        &participant,
        sample,
        SPEED_M_S,
        Seconds(SECONDS),
    )?;
    let x = series.into_samples();
    let gain = level_m_s2 / rms(&x);
    Ok(x.into_iter().map(|v| gain * v).collect())
}

fn modulated(x: &[f64], rate_hz: f64, depth: f64, turn: f64) -> Vec<f64> {
    let gain = |i: usize| 1.0 + depth * (TAU * (rate_hz * i as f64 / RATE_HZ + turn)).sin();
    let scale = (1.0 + 0.5 * depth * depth).sqrt();
    let all = x.iter().enumerate();
    all.map(|(i, v)| v * gain(i) / scale).collect()
}

/// The features that people judge by.
fn features(x: &[f64]) -> Result<([f64; 16], [f64; 3])> {
    let series = Series::<Acceleration>::new(x.to_vec(), SampleRate::new(RATE_HZ)?)?;
    let psd = welch(&series, &WelchConfig::hann(1024))?;
    let lines = || {
        let values = psd.values.iter().enumerate();
        values.map(|(k, power)| (k as f64 * psd.resolution_hz, *power))
    };
    let band_db = |i: usize| {
        let centre_hz = 20.0 * 2f64.powf(i as f64 / 3.0);
        let ends_hz = [-1.0, 1.0].map(|side: f64| centre_hz * 2f64.powf(side / 6.0));
        // Of the lowest bands a line is wider than the band.
        let share = |hz: f64| {
            let half = 0.5 * psd.resolution_hz;
            ((hz + half).min(ends_hz[1]) - (hz - half).max(ends_hz[0])).max(0.0)
        };
        let power: f64 = lines().map(|(hz, power)| power * share(hz)).sum();
        10.0 * power.max(1e-4).log10()
    };
    let all: f64 = lines().map(|(_, power)| power).sum();
    let centroid_hz = lines().map(|(hz, power)| hz * power).sum::<f64>() / all;
    let levels: Vec<f64> = x
        .chunks_exact((0.01 * RATE_HZ) as usize)
        .map(|cut| 20.0 * rms(cut).max(1e-4).log10())
        .collect();
    let crest = x.iter().fold(0.0f64, |top, v| top.max(v.abs())) / rms(x);
    let single = [
        standard_deviation(&levels),
        centroid_hz,
        20.0 * crest.log10(),
    ];
    Ok((std::array::from_fn(band_db), single))
}

impl Pair {
    fn of([a, b]: [&[f64]; 2]) -> Result<Self> {
        let ((bands_a, single_a), (bands_b, single_b)) = (features(a)?, features(b)?);
        let bands: Vec<f64> = bands_a.iter().zip(bands_b).map(|(a, b)| a - b).collect();
        let [variation, centroid, crest] = std::array::from_fn(|i| single_a[i] - single_b[i]);
        let rate = SampleRate::new(RATE_HZ)?;
        let [x, y] = [a, b].map(|x| Series::<Acceleration>::new(x.to_vec(), rate));
        let band = Band::new(Hertz(20.0), Hertz(1_000.0))?;
        let found = score(&x?, &y?, &ScoreConfig::over(band, RATE_HZ))?;
        let perceived = found.perceived.context("nothing is perceived")?;
        Ok(Self {
            apart: [rms(&bands), variation, centroid, crest],
            predicted: [
                perceived.difference.jnd.value,
                20.0 * (rms(b) / rms(a)).log10().abs(),
                found.spectral.jnd,
            ],
        })
    }

    /// A third of the pairs are two textures, a third one texture modulated, a third one texture at two levels; all are two realisations.
    fn drawn(i: usize, parameters: &TwinParameters) -> Result<Self> {
        let mut random = Random::stream(SEED, i as u64, "pairs");
        let mut between = |low: f64, high: f64| low + (high - low) * random.uniform();
        let one = SAMPLES[i % SAMPLES.len()];
        let level_m_s2 = between(LEVEL_M_S2[0].ln(), LEVEL_M_S2[1].ln()).exp();
        let apart_db = between(-LEVEL_APART_DB, LEVEL_APART_DB);
        let [rate, depth, turn, other] = [0.0; 4].map(|_: f64| between(0.0, 1.0));
        let kind = (i / SAMPLES.len()) % 3;
        let place = i + 1 + (other * (SAMPLES.len() - 1) as f64) as usize;
        let other = match kind {
            0 => SAMPLES[place % SAMPLES.len()],
            _ => one,
        };
        let gain = 10f64.powf(apart_db / 20.0);
        let a = passage(one, 2 * i as u64, level_m_s2, parameters)?;
        let mut b = passage(other, 2 * i as u64 + 1, gain * level_m_s2, parameters)?;
        if kind == 1 {
            let rate_hz = RATES_HZ[(rate * RATES_HZ.len() as f64) as usize];
            b = modulated(&b, rate_hz, 0.2 + 0.8 * depth, turn);
        }
        Self::of([&a, &b])
    }
}

/// The share of right answers at `d_prime`.
fn right(d_prime: f64) -> f64 {
    let listening = percent_correct(d_prime / D_PRIME_OF_JND) / 100.0;
    0.5 * GUESSED + (1.0 - GUESSED) * listening
}

/// How many of all trials are answered rightly, by pair, in the world of `seed`.
fn answers(pairs: &[Pair], random: &mut Random) -> Vec<usize> {
    let world = WEIGHTS.map(|w| w * (WORLD_SPREAD * random.normal()).exp());
    let mut counts = vec![0; pairs.len()];
    for _ in 0..PEOPLE {
        let weights = world.map(|w| w * (PERSON_SPREAD * random.normal()).exp());
        for (count, pair) in counts.iter_mut().zip(pairs) {
            let apart = weights.iter().zip(pair.apart);
            let square: f64 = apart.map(|(w, delta)| (w * delta).powi(2)).sum();
            let share = right(square.sqrt());
            *count += (0..TRIALS).filter(|_| random.uniform() < share).count();
        }
    }
    counts
}

/// The deviance of `share` of right answers where `count` of `of` were.
fn deviance(count: usize, of: usize, share: f64) -> f64 {
    let term = |count: usize, share: f64| match count {
        0 => 0.0,
        count => count as f64 * (count as f64 / (of as f64 * share)).ln(),
    };
    2.0 * (term(count, share) + term(of - count, 1.0 - share))
}

/// The figures of a predictor: deviance a pair with one scale; with a scale and a d′ that every pair has, as any two realisations differ;
/// rank correlation.
type Figures = [f64; FIGURES.len()];

/// The figures of each predictor on the half of the pairs that its scale was not fitted to.
fn world(pairs: &[Pair], seed: u64) -> Result<[Figures; PREDICTORS.len()]> {
    let mut random = Random::stream(SEED, seed, "worlds");
    let counts = answers(pairs, &mut random);
    let mut order: Vec<(f64, usize)> = (0..pairs.len()).map(|i| (random.uniform(), i)).collect();
    order.sort_by(|x, y| x.0.total_cmp(&y.0));
    let order: Vec<usize> = order.into_iter().map(|(_, i)| i).collect();
    let (fitted, held_out) = order.split_at(pairs.len() / 2);
    let of = PEOPLE * TRIALS;
    let mut found = [[0.0; FIGURES.len()]; PREDICTORS.len()];
    for (p, found) in found.iter_mut().enumerate() {
        let total = |(scale, floor): (f64, f64), chosen: &[usize]| -> f64 {
            let d_prime = |i: usize| (scale * pairs[i].predicted[p]).hypot(floor);
            let each = chosen.iter();
            each.map(|i| deviance(counts[*i], of, right(d_prime(*i))))
                .sum()
        };
        let best = |floors: usize| {
            let all = (0..floors * 150).map(|k| {
                let scale = 1e-2 * 10f64.powf((k % 150) as f64 / 40.0);
                (scale, 0.1 * (k / 150) as f64)
            });
            let best = all.min_by(|x, y| total(*x, fitted).total_cmp(&total(*y, fitted)));
            best.context("no scale")
        };
        let predicted: Vec<f64> = held_out.iter().map(|i| pairs[*i].predicted[p]).collect();
        let answered: Vec<f64> = held_out.iter().map(|i| counts[*i] as f64).collect();
        *found = [
            total(best(1)?, held_out) / held_out.len() as f64,
            total(best(30)?, held_out) / held_out.len() as f64,
            spearman(&predicted, &answered).unwrap_or(0.0),
        ];
    }
    Ok(found)
}

/// "3.1 (2.0–4.4)": the median and 90 % of `values`.
fn words(mut values: Vec<f64>) -> String {
    values.sort_by(f64::total_cmp);
    let at = |q: f64| values[((values.len() - 1) as f64 * q).round() as usize];
    format!("{:.2} ({:.2}–{:.2})", at(0.5), at(0.05), at(0.95))
}

/// Prints how well each predictor says the answers that its scale was not fitted to.
pub(crate) fn run() -> Result<()> {
    let parameters = TwinParameters::built_in();
    let count = SAMPLES.len() * PAIRS_EACH;
    let pairs = in_threads(count, |i| Pair::drawn(i, &parameters))?;
    let worlds = in_threads(WORLDS, |i| world(&pairs, i as u64))?;
    println!(
        "Answers of people who judge by third octaves in dB, variation of the level, centroid in Hz and crest factor: {WORLDS} worlds of \
         weights, each with {PEOPLE} people, {TRIALS} trials a pair, {count} pairs; one scale is fitted to half of the pairs, the other half \
         is predicted\n"
    );
    let medians: [f64; FEATURES] = std::array::from_fn(|f| {
        let mut all: Vec<f64> = pairs
            .iter()
            .map(|p| (WEIGHTS[f] * p.apart[f]).abs())
            .collect();
        all.sort_by(f64::total_cmp);
        all[all.len() / 2]
    });
    println!("  d′ of the features, median over pairs: {medians:.2?}");
    let shares = (0..WORLDS).map(|i| {
        let counts = answers(&pairs, &mut Random::stream(SEED, i as u64, "worlds"));
        let all: Vec<f64> = counts.iter().map(|count| *count as f64).collect();
        100.0 * mean(&all) / (PEOPLE * TRIALS) as f64
    });
    println!("  right answers, %: {}\n", words(shares.collect()));
    println!(
        "  {:<24}{:>26}{:>26}{:>26}",
        "predictor, best in worlds", FIGURES[0], FIGURES[1], FIGURES[2]
    );
    let better = |figure: usize, x: f64, y: f64| match figure {
        RANK => x > y,
        _ => x < y,
    };
    for (p, name) in PREDICTORS.iter().enumerate() {
        let cells: [String; FIGURES.len()] = std::array::from_fn(|figure| {
            let is_best = |found: &&[Figures; PREDICTORS.len()]| {
                (0..PREDICTORS.len())
                    .all(|q| q == p || better(figure, found[p][figure], found[q][figure]))
            };
            let best = worlds.iter().filter(is_best).count();
            let all = worlds.iter().map(|found| found[p][figure]).collect();
            format!("{}{best:>5}", words(all))
        });
        println!(
            "  {name:<24}{:>26}{:>26}{:>26}",
            cells[0], cells[1], cells[2]
        );
    }
    for (figure, what) in FIGURES.iter().enumerate() {
        for p in 1..PREDICTORS.len() {
            let apart = worlds
                .iter()
                .map(|found| found[p][figure] - found[0][figure]);
            println!(
                "  {what}: {} less {}: {}",
                PREDICTORS[p],
                PREDICTORS[0],
                words(apart.collect())
            );
        }
    }
    Ok(())
}
