//! How often the 95 % intervals that a panel prints hold the truth: panels of people who are drawn from a population that is known.

use std::f64::consts::{PI, TAU};

use piezotact::fourier::Complex;
use piezotact::manipulate::DrawnPhases;
use piezotact::panel::{Cell, Entry, Filing, Panel, PanelConfig, analyse, average_of_panel};
use piezotact::quantity::{Acceleration, Band, Degrees, Force, Hertz, Newtons, SampleRate};
use piezotact::transfer::{BundleAverage, Estimator, TransferFunction};

use crate::ReplayError;

/// The lines of a transfer function, from 0 to 1000 Hz.
const LINES: usize = 21;
/// The standard deviation over people, rms over the band, dB: that of the hands of `shared/data/frf/skinsource`.
const SPREAD_DB: f64 = 3.6;
/// The standard deviation of the logarithm of a person's own spread, where people differ in it.
const UNEQUAL: f64 = 0.4;
/// People that the truth of a population is computed of.
const POPULATION: usize = 10_000;
const CELL: Cell = Cell {
    load_n: Newtons(0.2),
    angle_deg: Degrees(20.0),
};
const LOG: BundleAverage = BundleAverage::LogMagnitude;

/// How the people of a population differ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Population {
    /// By one level for all frequencies.
    Flat,
    /// By eight cosines over frequency, from a level to a narrow ripple.
    Shaped,
    /// As `Flat`; some people are unusual more often than others: their distance is multiplied by a log-normal factor.
    FlatUnequal,
    /// As `Shaped`, with that factor.
    ShapedUnequal,
}

impl Population {
    /// All.
    pub const ALL: [Self; 4] = [
        Self::Flat,
        Self::Shaped,
        Self::FlatUnequal,
        Self::ShapedUnequal,
    ];

    /// How a table calls it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Flat => "levels",
            Self::Shaped => "shapes",
            Self::FlatUnequal => "levels, unequal spread",
            Self::ShapedUnequal => "shapes, unequal spread",
        }
    }

    /// The level of one person at every line, dB.
    fn person(self, normal: &mut impl FnMut() -> f64) -> Vec<f64> {
        let weights: &[f64] = match self {
            Self::Flat | Self::FlatUnequal => &[1.0],
            Self::Shaped | Self::ShapedUnequal => &[1.0, 0.8, 0.6, 0.5, 0.4, 0.3, 0.3, 0.2],
        };
        // The mean over frequency of the square of a cosine is a half.
        let cosines: f64 = weights[1..].iter().map(|w| w * w / 2.0).sum();
        let own = match self {
            Self::Flat | Self::Shaped => 1.0,
            Self::FlatUnequal | Self::ShapedUnequal => (UNEQUAL * normal()).exp(),
        };
        let scale = SPREAD_DB * own / (1.0 + cosines).sqrt();
        let drawn: Vec<f64> = weights.iter().map(|w| scale * w * normal()).collect();
        let at = |line: usize| {
            let place = PI * line as f64 / (LINES - 1) as f64;
            let terms = drawn.iter().enumerate();
            terms
                .map(|(order, w)| w * (order as f64 * place).cos())
                .sum()
        };
        (0..LINES).map(at).collect()
    }
}

/// An interval of a panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PanelInterval {
    /// The error of the average for one new person, dB rms.
    NewPerson,
    /// The number of people that an average needs.
    PeopleNeeded,
}

/// One interval, with the truth that it should hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Simulated {
    /// Which interval.
    pub interval: PanelInterval,
    /// The truth, in its unit.
    pub truth: f64,
    /// What the panel found; absent where it is withheld.
    pub found: Option<[f64; 2]>,
}

/// Panels of one population.
#[derive(Clone, Debug)]
pub struct Simulation {
    population: Population,
    people: usize,
    /// How many people an average needs.
    needed: f64,
}

impl Simulation {
    /// Panels of `people` people of a `population`.
    #[must_use]
    pub fn new(population: Population, people: usize) -> Self {
        let mut normal = normals(0);
        let roots: f64 = (0..POPULATION)
            .map(|_| rms(&population.person(&mut normal)).sqrt())
            .sum();
        // The error of the average of very many people for a typical person; the tolerance is that of `PanelConfig::usual`.
        let error_db = (roots / POPULATION as f64).powi(2);
        let ratio = 1.0 + 0.1 / error_db;
        Self {
            population,
            people,
            needed: (1.0 / (ratio * ratio - 1.0)).ceil().max(1.0),
        }
    }

    /// The intervals of the panel that is drawn by `seed`, and their truths: for the first one, a person who is drawn after the panel.
    ///
    /// # Errors
    /// Those of [`analyse`] and [`average_of_panel`], which no drawn panel has.
    pub fn panel(&self, seed: u64) -> Result<[Simulated; 2], ReplayError> {
        let mut normal = normals(seed.wrapping_mul(1_000).wrapping_add(self.people as u64));
        let levels_db: Vec<Vec<f64>> = (0..self.people)
            .map(|_| self.population.person(&mut normal))
            .collect();
        let new_db = self.population.person(&mut normal);
        let panel = panel_of(&levels_db)?;
        let band = Band::new(Hertz(0.0), Hertz(1_000.0))?;
        let averaged = average_of_panel(&panel, CELL, LOG, band)?;
        let response = averaged.function.response().iter();
        let off = response
            .zip(&new_db)
            .map(|(h, db)| 20.0 * h.norm().log10() - db);
        let off: Vec<f64> = off.collect();
        let mut config = PanelConfig::usual(band, seed);
        (config.orders, config.resamples) = (1, 0);
        config.bands.clear();
        let said = analyse(&panel, &config)?;
        let curve = said.learning.first();
        Ok([
            Simulated {
                interval: PanelInterval::NewPerson,
                truth: rms(&off),
                found: averaged.costs.and_then(|costs| costs.new_person_db_rms),
            },
            Simulated {
                interval: PanelInterval::PeopleNeeded,
                truth: self.needed,
                found: curve.and_then(|curve| curve.enough.interval),
            },
        ])
    }
}

fn rms(values: &[f64]) -> f64 {
    let squares: f64 = values.iter().map(|v| v * v).sum();
    (squares / values.len() as f64).sqrt()
}

/// Numbers of the standard normal distribution (Box and Muller 1958).
fn normals(seed: u64) -> impl FnMut() -> f64 {
    const BLOCK: usize = 4_096;
    let (mut block, mut turns) = (0_u64, Vec::new());
    let mut uniform = move || {
        if turns.is_empty() {
            let key = seed.wrapping_mul(1 << 20).wrapping_add(block);
            turns = DrawnPhases::drawn(key, BLOCK).turns;
            block += 1;
        }
        turns.pop().unwrap_or(0.0)
    };
    move || {
        let radius = (-2.0 * (1.0 - uniform()).ln()).sqrt();
        radius * (TAU * uniform()).cos()
    }
}

fn panel_of(levels_db: &[Vec<f64>]) -> Result<Panel<Force, Acceleration>, ReplayError> {
    let entries = levels_db.iter().enumerate().map(|(i, levels_db)| {
        let lines = levels_db
            .iter()
            .map(|db| Complex::from(10f64.powf(db / 20.0)));
        let rate = SampleRate::new(2_000.0)?;
        let (coherence, estimator) = (vec![0.99; LINES], Estimator::H1);
        let resolution_hz = 1_000.0 / (LINES - 1) as f64;
        let mut function = TransferFunction::from_lines(
            lines.collect(),
            coherence,
            resolution_hz,
            rate,
            estimator,
            100,
        )?;
        let filing = Filing {
            participant: format!("P{i:02}"),
            cell: CELL,
            placement: 1,
            repeat: 1,
        };
        let condition = &mut function.about.condition;
        condition.participant = Some(filing.participant.clone());
        condition.load_n = Some(CELL.load_n);
        condition.angle_deg = Some(CELL.angle_deg);
        Ok(Entry { filing, function })
    });
    Ok(Panel::new(entries.collect::<Result<_, ReplayError>>()?)?)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every interval holds the truth in 93 to 97 % of panels, or as few times more or less as 600 panels scatter by, twice; that of three people
    /// is withheld.
    #[test]
    fn intervals_of_panels_hold() {
        const PANELS: u64 = 600;
        let scatter = 2.0 * (0.05 * 0.95 / PANELS as f64).sqrt();
        for population in Population::ALL {
            for people in [4, 6, 10, 20] {
                let simulation = Simulation::new(population, people);
                let mut held = [0; 2];
                for seed in 1..=PANELS {
                    for (held, one) in held.iter_mut().zip(simulation.panel(seed).unwrap()) {
                        let [low, high] = one.found.unwrap();
                        *held += usize::from(low <= one.truth && one.truth <= high);
                    }
                }
                let shares = held.map(|held| held as f64 / PANELS as f64);
                let within = |share: &f64| (0.93 - scatter..=0.97 + scatter).contains(share);
                assert!(
                    shares.iter().all(within),
                    "{population:?} {people}: {shares:?}"
                );
            }
            let few = Simulation::new(population, 3).panel(1).unwrap();
            assert!(few.iter().all(|one| one.found.is_none()));
        }
    }
}
