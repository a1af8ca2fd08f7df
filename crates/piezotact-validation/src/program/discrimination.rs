//! `piezotact-validation discrimination`: false-positive and true-positive rates of the comparison of samples.

#![allow(clippy::print_stdout, reason = "it prints a table")]

use std::time::Instant;

use anyhow::{Result, ensure};
use piezotact::compare::{
    DiscriminationConfig, Distinguishability, SampleUnit, Texture, discriminate,
};
use piezotact::discrimination::Model;
use piezotact::quantity::{Band, Hertz};

use super::studies::{
    Change, LEVEL_SD_DB, Random, SPECTRUM_SD_DB, sample, spectrum, spectrum_apart,
};

const NULL_STUDIES: u64 = 1000;
const STUDIES: u64 = 300;
/// The targets: the largest share of null studies, and the least share of studies of two JND, with a difference found.
const ASKED: (f64, f64) = (0.065, 0.80);
const POINTS_JND: [f64; 6] = [0.0, 0.5, 1.0, 1.5, 2.0, 3.0];

/// What studies said.
#[derive(Default)]
struct Counts {
    studies: u64,
    /// The number of studies in which at least one pair is told apart.
    told: u64,
    /// Studies in which the permutation test alone finds a difference.
    chance: u64,
    /// Pairs below the JND, and all.
    below: [u64; 2],
    /// Studies in which recordings were the units.
    recordings: u64,
}

impl Counts {
    fn share(&self, count: u64) -> f64 {
        100.0 * count as f64 / self.studies as f64
    }
}

fn count(
    config: &DiscriminationConfig,
    studies: u64,
    mut textures: impl FnMut(&mut Random) -> Vec<Texture>,
    seed: u64,
) -> Result<Counts> {
    let mut counts = Counts::default();
    for study in 0..studies {
        let mut random = Random::new(seed + study);
        let found = discriminate(&[textures(&mut random)], config)?;
        let pairs = || found.settings.iter().flat_map(|groups| &groups.pairs);
        counts.studies += 1;
        counts.told += u64::from(pairs().any(|p| p.outcome == Distinguishability::ToldApart));
        counts.chance +=
            u64::from(pairs().any(|p| p.p_adjusted.is_some_and(|p| p <= config.alpha)));
        counts.below[0] += pairs()
            .filter(|p| p.outcome == Distinguishability::BelowJnd)
            .count() as u64;
        counts.below[1] += pairs().count() as u64;
        counts.recordings += u64::from(found.units == SampleUnit::Recordings);
    }
    Ok(counts)
}

/// The share of studies in which a sample with the spectrum `other` differs significantly from an unchanged one.
fn told_share(config: &DiscriminationConfig, change: Change, other: &[f64]) -> Result<f64> {
    let mut told = 0;
    for study in 0..STUDIES {
        let mut random = Random::new(10_000 + study);
        let plain = spectrum(change, 0.0);
        let textures = ["D", "N1", "N2", "N3"]
            .map(|name| {
                let texture = if name == "D" { other } else { &plain };
                sample(&mut random, name, texture, [1, 15], 0.0)
            })
            .to_vec();
        let found = discriminate(&[textures], config)?;
        let pair = found.settings.first().and_then(|groups| groups.pair(0, 1));
        told += u64::from(pair.is_some_and(|p| p.outcome == Distinguishability::ToldApart));
    }
    Ok(told as f64 / STUDIES as f64)
}

/// Measures and prints the tables.
pub(crate) fn run() -> Result<()> {
    let start = Instant::now();
    let config = DiscriminationConfig::usual(Model::over(Band::new(Hertz(20.0), Hertz(1000.0))?));
    println!(
        "\nC1 samples told apart: synthetic strokes of 1 s whose level differs by {LEVEL_SD_DB} dB and whose spectrum by {SPECTRUM_SD_DB} dB an octave (standard deviations); errors of 5 % over all pairs of a study; seeds from 0"
    );
    let plain = spectrum(Change::Level, 0.0);
    let mut worst = 0.0f64;
    let names = ["N1", "N2", "N3", "N4"];
    println!(
        "  null studies (strokes of one sample under four names), {NULL_STUDIES} of each kind: told apart anywhere in a study / a difference by the permutation test alone / pairs below the JND / studies by recording"
    );
    // Recordings a sample, strokes a recording, dB between recordings.
    for (what, recordings, strokes, session_db) in [
        ("8–15 strokes, 1 recording", 1, None, 0.0),
        ("15 strokes, 1 recording", 1, Some(15), 0.0),
        ("3 recordings of 5 strokes", 3, Some(5), 0.0),
        ("3 recordings of 5, 3 dB apart", 3, Some(5), 3.0),
        ("8 recordings of 3, 3 dB apart", 8, Some(3), 3.0),
    ] {
        let counts = count(
            &config,
            NULL_STUDIES,
            |random| {
                let mut textures = Vec::new();
                for name in names {
                    let strokes = strokes.unwrap_or(8 + (8.0 * random.uniform()) as usize);
                    textures.push(sample(
                        random,
                        name,
                        &plain,
                        [recordings, strokes],
                        session_db,
                    ));
                }
                textures
            },
            0,
        )?;
        println!(
            "    {what:<32} {:>5.1} %  {:>5.1} %  {:>5.1} %  {:>5.1} %",
            counts.share(counts.told),
            counts.share(counts.chance),
            100.0 * counts.below[0] as f64 / counts.below[1] as f64,
            counts.share(counts.recordings),
        );
        worst = worst.max(counts.told as f64 / counts.studies as f64);
    }
    let noticed = config.model.level_jnd_high.0;
    println!(
        "  power: share of {STUDIES} studies in which the fourth of four samples (15 strokes each) is told apart from the first, by their true difference in JND. Upper rows: one JND is {noticed} dB, the upper end of the published range, which decides. Lower rows: one JND is {} dB, its lower end",
        config.model.level_jnd.0
    );
    let mut least = 1.0f64;
    for jnd_db in [noticed, config.model.level_jnd.0] {
        println!(
            "    JND of {jnd_db} dB: {}",
            POINTS_JND.map(|jnd| format!("{jnd:>7}")).concat()
        );
        for change in Change::ALL {
            let mut row = String::new();
            for jnd in POINTS_JND {
                let other = spectrum_apart(
                    &config.model,
                    change,
                    jnd * jnd_db / config.model.level_jnd.0,
                );
                let share = told_share(&config, change, &other)?;
                row += &format!("{:>5.0} %", 100.0 * share);
                let is = |a: f64, b: f64| (a - b).abs() < 1e-9;
                if is(jnd_db, noticed) && is(jnd, 2.0) {
                    least = least.min(share);
                }
            }
            println!("    {:>15}  {row}", change.name());
        }
    }
    println!("  {:.0} s", start.elapsed().as_secs_f64());
    ensure!(
        worst <= ASKED.0,
        "told apart in {:.1} % of null studies, at most {:.1} % are asked for",
        100.0 * worst,
        100.0 * ASKED.0
    );
    ensure!(
        least >= ASKED.1,
        "told apart in {:.0} % of studies of two JND, {:.0} % are asked for",
        100.0 * least,
        100.0 * ASKED.1
    );
    Ok(())
}
