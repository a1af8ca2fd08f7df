//! What `piezotact panel` says over people: effects of load, whether people lie closer together, what an average costs somebody new.

use std::f64::consts::TAU;

use anyhow::{Context as _, Result};
use num_complex::Complex;
use piezotact::panel::{Cell, Entry, Filing, Panel, PanelAnalysis, PanelConfig, analyse};
use piezotact::quantity::{Acceleration, Band, Degrees, Force, Hertz, Newtons, SampleRate};
use piezotact::statistics::random::Random;
use piezotact::statistics::{Direction, rms};
use piezotact::transfer::{Estimator, TransferFunction};

use super::ability::{GUESSERS_SHARE, skewed};
use super::{Found, Printed, Question, Scenario, World};

const STUDIES: usize = 1_000;
const LINES: usize = 21;
const STEP_HZ: f64 = 50.0;
/// How far people are off the mean, and off it once more at each load, dB.
const PEOPLE_DB: f64 = 2.0;
const LOAD_DB: f64 = 1.0;
/// What the heavier load changes, where it does: the level, and how far people are apart.
const LOUDER_DB: f64 = 1.0;
const CLOSER: f64 = 0.5;
/// Panels of which the error for somebody new is taken.
const POPULATION: usize = 10_000;
/// The criterion of the average, dB rms.
const WITHIN_DB: f64 = 3.0;

/// How people differ.
#[derive(Clone, Copy)]
enum People {
    /// In level.
    Flat,
    /// From line to line.
    Shaped,
    /// In level, with a long tail.
    Skewed,
    /// In level, 15 % of them by three times as much.
    Outliers,
}

impl People {
    fn name(self) -> &'static str {
        match self {
            Self::Flat => "in level",
            Self::Shaped => "in shape",
            Self::Skewed => "in level, skewed",
            Self::Outliers => "in level, 15 % threefold",
        }
    }

    /// How far a person is off the mean, line by line, dB.
    fn curve(self, sd_db: f64, random: &mut Random) -> Vec<f64> {
        let flat = |db: f64| vec![db; LINES];
        match self {
            Self::Flat => flat(sd_db * random.normal()),
            Self::Skewed => flat(sd_db * skewed(random)),
            Self::Outliers => {
                let more = if random.uniform() < GUESSERS_SHARE {
                    3.0
                } else {
                    1.0
                };
                flat(sd_db * more * random.normal())
            }
            Self::Shaped => {
                // Six waves along the lines.
                let waves: Vec<[f64; 2]> =
                    (0..6).map(|_| [random.normal(), random.normal()]).collect();
                let line = |k: usize| {
                    let at = |(order, [cos, sin]): (usize, &[f64; 2])| {
                        let phase = TAU * order as f64 * k as f64 / LINES as f64 / 2.0;
                        cos * phase.cos() + sin * phase.sin()
                    };
                    sd_db * waves.iter().enumerate().map(at).sum::<f64>() / 6f64.sqrt()
                };
                (0..LINES).map(line).collect()
            }
        }
    }

    /// The levels of a person at two loads, dB.
    fn levels(self, world: World, random: &mut Random) -> [Vec<f64>; 2] {
        let own = self.curve(PEOPLE_DB, random);
        [0, 1].map(|load| {
            let at_load = self.curve(LOAD_DB, random);
            let [louder_db, closer] = match (load, world) {
                (1, World::Effect) => [LOUDER_DB, CLOSER],
                _ => [0.0, 1.0],
            };
            // No two measurements are the same bit by bit.
            let both = own.iter().zip(at_load);
            both.map(|(own, at)| louder_db + closer * (own + at) + 1e-3 * random.normal())
                .collect()
        })
    }

    /// The error of the average of very many people for a typical one, dB rms: the mean of its square roots, squared.
    fn typical_db(self) -> f64 {
        let mut random = Random::stream(49, 0, self.name());
        let root = |_| rms(&self.levels(World::Null, &mut random)[0]).sqrt();
        let roots: f64 = (0..POPULATION).map(root).sum();
        (roots / POPULATION as f64).powi(2)
    }

    /// The error of the average of so many people for each of many who are not in it, dB rms.
    fn errors_db(self, in_average: usize) -> Vec<f64> {
        let mut random = Random::stream(49, in_average as u64, self.name());
        let mut one = || self.levels(World::Null, &mut random)[0].clone();
        let error = |_| {
            let own = one();
            let mut sums = [0.0; LINES];
            for _ in 0..in_average {
                let other = one();
                sums.iter_mut().zip(other).for_each(|(sum, db)| *sum += db);
            }
            let off: Vec<f64> = sums
                .iter()
                .zip(own)
                .map(|(sum, own)| sum / in_average as f64 - own)
                .collect();
            rms(&off)
        };
        (0..POPULATION).map(error).collect()
    }
}

fn band() -> Result<Band> {
    Ok(Band::new(Hertz(50.0), Hertz(1_000.0))?)
}

fn entry(person: &str, load: usize, levels_db: &[f64]) -> Result<Entry<Force, Acceleration>> {
    let rate = SampleRate::new(2_000.0)?;
    let lines = levels_db
        .iter()
        .map(|db| Complex::from(10f64.powf(db / 20.0)));
    let coherence = vec![0.99; LINES];
    let (lines, estimator) = (lines.collect(), Estimator::H1);
    let mut function =
        TransferFunction::from_lines(lines, coherence, STEP_HZ, rate, estimator, 100)?;
    let cell = Cell {
        load_n: Newtons(0.2 * (load + 1) as f64),
        angle_deg: Degrees(20.0),
    };
    function.about.condition.participant = Some(person.to_owned());
    function.about.condition.load_n = Some(cell.load_n);
    function.about.condition.angle_deg = Some(cell.angle_deg);
    let filing = Filing {
        participant: person.to_owned(),
        cell,
        placement: 1,
        repeat: 1,
    };
    Ok(Entry { filing, function })
}

fn analysed(people: &[[Vec<f64>; 2]]) -> Result<PanelAnalysis> {
    let mut entries = Vec::new();
    for (i, loads) in people.iter().enumerate() {
        for (load, levels) in loads.iter().enumerate() {
            entries.push(entry(&format!("P{i:02}"), load, levels)?);
        }
    }
    let config = PanelConfig {
        // Fewer than usual: time.
        orders: 5,
        resamples: 199,
        bands: Vec::new(),
        ..PanelConfig::usual(band()?, 1)
    };
    Ok(analyse(&Panel::new(entries)?, &config)?)
}

pub(super) fn scenarios() -> Vec<Scenario> {
    use People as P;
    let all = [
        (P::Flat, 4),
        (P::Flat, 6),
        (P::Flat, 10),
        (P::Flat, 20),
        (P::Shaped, 4),
        (P::Shaped, 6),
        (P::Shaped, 10),
        (P::Shaped, 20),
        (P::Skewed, 10),
        (P::Outliers, 10),
    ];
    all.map(|(kind, people)| scenario(kind, people)).into()
}

fn scenario(kind: People, people: usize) -> Scenario {
    let errors_db = kind.errors_db(people);
    let within = errors_db.iter().filter(|db| **db <= WITHIN_DB).count();
    let within_share = within as f64 / errors_db.len() as f64;
    let typical_db = kind.typical_db();
    let study = move |seed: u64, world: World| -> Result<Vec<Found>> {
        let mut random = Random::stream(seed, people as u64, kind.name());
        let all: Vec<[Vec<f64>; 2]> = (0..people)
            .map(|_| kind.levels(world, &mut random))
            .collect();
        let somebody_new = kind.levels(world, &mut random);
        let found = analysed(&all)?;
        let step = found.load_steps.first().context("no step of load")?;
        let fall = found.falls.first().context("no loads")?;
        let average = found.averages.first().context("no average")?;
        let off: Vec<f64> = (average.log_magnitude_db.iter())
            .zip(&somebody_new[0][1..])
            .map(|(of_all, own)| of_all - own)
            .collect();
        let costs = &average.penalties[0];
        let share = costs.criterion(piezotact::panel::AverageCriterion::ShareWithin);
        let share = share.and_then(|rule| rule.interval);
        let curve = found.learning.first().context("no curve")?;
        let enough = needed(typical_db, curve.within_db);
        Ok(vec![
            Found {
                concluded: step.paired.map(|paired| paired.p_value <= 0.05),
                ..Found::estimated(step.paired.map(|paired| paired.interval), 0.0)
            },
            Found::tested(step.sign_test_p.map(|p| p <= 0.05)),
            Found::tested(fall.p_value.map(|_| fall.direction != Direction::NotShown)),
            Found::estimated(costs.new_person_db_rms, rms(&off)),
            Found::estimated(share, within_share),
            Found::estimated(curve.enough.interval, enough),
        ])
    };
    Scenario {
        questions: vec![
            Question::of("step with load", Printed::Both),
            Question::of("step with load, sign test", Printed::Test),
            Question::of("closer together under load", Printed::Test),
            Question::of("error for somebody new", Printed::Interval),
            Question::of("share within 3 dB", Printed::Interval),
            Question::of("participants needed", Printed::Interval),
        ],
        name: kind.name(),
        people: people.to_string(),
        studies: STUDIES,
        study: Box::new(study),
    }
}

/// How many people are enough where a typical one is `error_db` off the average of very many.
fn needed(error_db: f64, within_db: f64) -> f64 {
    let enough = |n: &u32| error_db * ((1.0 + 1.0 / f64::from(*n)).sqrt() - 1.0) <= within_db;
    (1..10_000).find(enough).map_or(f64::NAN, f64::from)
}
