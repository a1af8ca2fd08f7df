//! Repeatability of measurements with and without replacing the finger, and the components of their variance.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::levels::{Own, robust_score};
use super::{Cell, Panel, PanelError};
use crate::quantity::{Band, Quantity};
use crate::statistics::{mean, rms};
use crate::transfer::TransferFunction;
use crate::warning::{Scatter, ScatterWarning, Warning};

/// Repeats of one person that are this many times further apart than those of the usual person may be of two people.
const MIXED_RATIO: f64 = 3.0;
/// … and by at least this many robust standard deviations …
const MIXED_SCORE: f64 = 6.0;
/// … and by at least this, dB: single estimates scatter by as much.
const MIXED_LEAST_DB: f64 = 0.5;
/// The expected limit for repeats of one placement, dB rms, when there are too few groups to estimate it (claim 6).
const MOST_APART_DB: f64 = 1.0;
/// The fewest groups of repeats from which the usual distance is estimated.
const ENOUGH_GROUPS: usize = 5;

/// How well measurements repeat over a band.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Repeatability {
    /// The lines of the band, Hz.
    pub frequencies_hz: Vec<f64>,
    /// Repeats of one placement, the finger left where it was; absent without any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lying: Option<PairDistances>,
    /// Placements: the finger taken off and put back; absent without any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub put_back: Option<PairDistances>,
    /// The components of the variance within a cell, over the whole band and in its parts.
    pub components: Vec<Components>,
}

/// How far measurements of one person in one cell are apart, two by two.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PairDistances {
    /// How many pairs.
    pub pairs: usize,
    /// In how many groups of repeats, or of placements.
    pub groups: usize,
    /// The median over pairs of the rms distance, dB.
    pub median_db_rms: f64,
    /// The largest, dB.
    pub largest_db_rms: f64,
    /// Who and where that is.
    pub largest_in: String,
    /// The standard deviation of every line, pooled over groups, dB.
    pub spread_db: Vec<f64>,
    /// Its rms over the band, dB.
    pub spread_rms_db: f64,
}

/// Components of the standard deviation within a cell (people, placements, repeats), pooled over cells and lines.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Components {
    /// The band.
    pub band_hz: Band,
    /// Between people, dB; with the placements where everybody had one.
    pub persons_db: f64,
    /// Between placements of one person, dB, with the repeats where every placement had one; absent where everybody had
    /// one placement.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub placements_db: Option<f64>,
    /// Between repeats of one placement, dB; absent where every placement had one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub repeats_db: Option<f64>,
    /// The share of the variance that lies between people, 0–1: an intraclass correlation; absent where nothing was measured twice.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub persons_share: Option<f64>,
}

/// The measurements of one person in one cell.
struct Placed<'a> {
    who: &'a str,
    cell: Cell,
    /// The levels of the repeats of every placement, dB, by its number.
    placements: BTreeMap<u32, Vec<Vec<f64>>>,
}

impl Placed<'_> {
    fn measurements(&self) -> f64 {
        self.placements.values().map(Vec::len).sum::<usize>() as f64
    }

    /// The sum of the squares of the numbers of repeats.
    fn squared(&self) -> f64 {
        let repeats = self.placements.values();
        repeats.map(|repeats| (repeats.len() as f64).powi(2)).sum()
    }
}

/// The repeatability of the measurements of `panel` over `band`, with the variance components there and in its parts `bands`; and
/// the warnings about cells in which repeats may be of different people.
///
/// Formula: rms over lines of the difference of levels in dB, for all pairs of repeats of a placement, and of
/// measurements of different placements. Variances of people, placements and repeats by the nested analysis of variance
/// of every line (sums of squares set equal to their expectations, numbers of repeats may differ), pooled over cells and
/// lines; an estimate below zero is 0. Repeats give a warning whose largest distance is more than 3 times the median of all
/// groups', at least 0.5 dB, and 6 robust standard deviations (1.4826·MAD) above it; with fewer than 5 groups, repeats of
/// one placement that are more than 1 dB apart.
///
/// Source: L. Felicetti's thesis (2024), figure 78; S. R. Searle and others (1992), *Variance Components*, chapter 5.
///
/// # Errors
/// [`PanelError::Empty`] when no line lies in the band.
pub fn repeatability<I: Quantity, O: Quantity>(
    panel: &Panel<I, O>,
    band: Band,
    bands: &[Band],
) -> Result<(Repeatability, Vec<Warning>), PanelError> {
    let first = &panel.entries()[0].function;
    let frequencies_hz: Vec<f64> = first.lines_in(band).map(|(_, hz)| hz).collect();
    if frequencies_hz.is_empty() {
        return Err(PanelError::Empty { band });
    }
    let mut placed = Vec::new();
    for who in panel.participants() {
        for cell in panel.cells() {
            let levels = |own: Vec<&TransferFunction<I, O>>| {
                own.iter().map(|f| Own::of(*f, band).db).collect()
            };
            let placements = panel.placements(who, *cell).into_iter();
            let placements = placements
                .map(|(number, own)| (number, levels(own)))
                .collect();
            placed.push(Placed {
                who,
                cell: *cell,
                placements,
            });
        }
    }
    let (mut lying, mut put_back) = (Vec::new(), Vec::new());
    for Placed {
        who,
        cell,
        placements,
    } in &placed
    {
        let name = format!("{who} at {cell}");
        for (number, repeats) in placements {
            let name = match placements.len() {
                1 => name.clone(),
                _ => format!("{name}, placement {number}"),
            };
            let pairs = repeats.iter().enumerate();
            let pairs = pairs.flat_map(|(i, a)| repeats[..i].iter().map(|b| apart(a, b)));
            lying.extend(Group::of(name, pairs.collect(), repeats));
        }
        let mut across = Vec::new();
        for (i, one) in placements.values().enumerate() {
            for other in placements.values().take(i) {
                across.extend(one.iter().flat_map(|a| other.iter().map(|b| apart(a, b))));
            }
        }
        let means: Vec<Vec<f64>> = placements
            .values()
            .map(|repeats| mean_of(repeats))
            .collect();
        put_back.extend(Group::of(name, across, &means));
    }
    let mut warnings = mixed(&lying, "repeats", MOST_APART_DB);
    // How far few placements may lie apart is not known.
    warnings.extend(mixed(&put_back, "placements", f64::INFINITY));
    let parts = std::iter::once(&band).chain(bands);
    let repeatability = Repeatability {
        lying: distances(&lying),
        put_back: distances(&put_back),
        components: parts
            .filter_map(|part| components(&placed, panel.cells(), &frequencies_hz, *part))
            .collect(),
        frequencies_hz,
    };
    Ok((repeatability, warnings))
}

fn mean_of(curves: &[Vec<f64>]) -> Vec<f64> {
    let curves: Vec<&[f64]> = curves.iter().map(Vec::as_slice).collect();
    super::spread::mean_curve(&curves)
}

fn apart(a: &[f64], b: &[f64]) -> f64 {
    let off: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
    rms(&off)
}

/// Measurements that should be alike.
struct Group {
    name: String,
    distances_db: Vec<f64>,
    /// The sum of squares about the group's mean by line, dB².
    squares: Vec<f64>,
    freedom: usize,
}

impl Group {
    fn of(name: String, distances_db: Vec<f64>, curves: &[Vec<f64>]) -> Option<Self> {
        if distances_db.is_empty() {
            return None;
        }
        let middle = mean_of(curves);
        let off = |line: usize| curves.iter().map(move |c| c[line]);
        let lines = middle.iter().enumerate();
        Some(Self {
            name,
            distances_db,
            squares: lines
                .map(|(line, middle)| off(line).map(|db| (db - middle).powi(2)).sum())
                .collect(),
            freedom: curves.len() - 1,
        })
    }

    fn largest(&self) -> f64 {
        self.distances_db.iter().copied().fold(0.0, f64::max)
    }
}

fn distances(groups: &[Group]) -> Option<PairDistances> {
    let widest = groups
        .iter()
        .max_by(|a, b| a.largest().total_cmp(&b.largest()))?;
    let mut all: Vec<f64> = groups.iter().flat_map(|g| g.distances_db.clone()).collect();
    let freedom: usize = groups.iter().map(|g| g.freedom).sum();
    let spread_db: Vec<f64> = (0..widest.squares.len())
        .map(|line| {
            let squares: f64 = groups.iter().map(|g| g.squares[line]).sum();
            (squares / freedom.max(1) as f64).sqrt()
        })
        .collect();
    Some(PairDistances {
        pairs: all.len(),
        groups: groups.len(),
        largest_db_rms: widest.largest(),
        largest_in: widest.name.clone(),
        median_db_rms: crate::statistics::median(&mut all)?,
        spread_rms_db: rms(&spread_db),
        spread_db,
    })
}

/// A warning for every group whose largest distance is unusual; of few groups, one beyond `most_apart_db`.
fn mixed(groups: &[Group], what: &str, most_apart_db: f64) -> Vec<Warning> {
    let few = groups.len() < ENOUGH_GROUPS;
    let largest: Vec<f64> = groups.iter().map(Group::largest).collect();
    let median = crate::statistics::median(&mut largest.clone()).unwrap_or(f64::NAN);
    let usual_db_rms = if few { most_apart_db } else { median };
    let is_unusual = |db: f64| match few {
        true => db > most_apart_db,
        false => {
            db > MIXED_LEAST_DB
                && db > MIXED_RATIO * usual_db_rms
                && robust_score(&largest, db, 1e-3) > MIXED_SCORE
        }
    };
    let unusual = groups.iter().zip(&largest);
    let unusual = unusual.filter(|(_, db)| is_unusual(**db));
    unusual
        .map(|(group, db)| {
            Warning::from(ScatterWarning::Scatter {
                of: Scatter::RepeatsOfParticipant {
                    kind: what.into(),
                    participant: group.name.clone(),
                    db_rms: *db,
                    usual_db_rms,
                },
            })
        })
        .collect()
}

/// Of people, placements and repeats, added over cells.
#[derive(Default)]
struct Sums {
    /// The sums of squares, with those of all lines together.
    squares: [f64; 3],
    freedom: [f64; 3],
    /// The coefficient in the expectations of the squares: of the variance of people in those of people, and of placements in those of
    /// placements and of people.
    people: f64,
    placements: f64,
    placements_in_people: f64,
}

fn components(
    placed: &[Placed<'_>],
    cells: &[Cell],
    frequencies_hz: &[f64],
    part: Band,
) -> Option<Components> {
    let lines: Vec<usize> = (0..frequencies_hz.len())
        .filter(|line| part.contains(frequencies_hz[*line]))
        .collect();
    let mut sums = Sums::default();
    for cell in cells {
        let inside = placed.iter().filter(|p| p.cell.is(*cell));
        sums.add(
            &inside
                .filter(|p| !p.placements.is_empty())
                .collect::<Vec<_>>(),
            &lines,
        );
    }
    if lines.is_empty() || sums.freedom[0] <= 0.0 {
        return None;
    }
    let [people, placements, repeats] = sums.squares.map(|sum| sum / lines.len() as f64);
    let [people_freedom, placements_freedom, repeats_freedom] = sums.freedom;
    let repeats_var = (repeats_freedom > 0.0).then(|| repeats / repeats_freedom);
    let noise = repeats_var.unwrap_or(0.0);
    let placements_var = (placements_freedom > 0.0)
        .then(|| ((placements - placements_freedom * noise) / sums.placements).max(0.0));
    let placed = placements_var.unwrap_or(0.0);
    let people = people - people_freedom * noise - sums.placements_in_people * placed;
    let people_var = (people / sums.people).max(0.0);
    let total = people_var + placed + noise;
    Some(Components {
        band_hz: part,
        persons_db: people_var.sqrt(),
        placements_db: placements_var.map(f64::sqrt),
        repeats_db: repeats_var.map(f64::sqrt),
        persons_share: (placements_var.or(repeats_var))
            .map(|_| if total > 0.0 { people_var / total } else { 0.0 }),
    })
}

impl Sums {
    /// Adds the people of one cell.
    fn add(&mut self, inside: &[&Placed<'_>], lines: &[usize]) {
        if inside.is_empty() {
            return;
        }
        let people = inside.len() as f64;
        let placements = inside.iter().map(|p| p.placements.len()).sum::<usize>() as f64;
        let over =
            |value: &dyn Fn(&Placed<'_>) -> f64| inside.iter().map(|p| value(p)).sum::<f64>();
        let all = over(&|p| p.measurements());
        let within = over(&|p| p.squared() / p.measurements());
        for (sum, add) in
            self.freedom
                .iter_mut()
                .zip([people - 1.0, placements - people, all - placements])
        {
            *sum += add;
        }
        self.people += all - over(&|p| p.measurements().powi(2)) / all;
        self.placements += all - within;
        self.placements_in_people += within - over(&|p| p.squared()) / all;
        for &line in lines {
            let at = |repeats: &[Vec<f64>]| repeats.iter().map(|db| db[line]).collect::<Vec<f64>>();
            let own: Vec<Vec<Vec<f64>>> = inside
                .iter()
                .map(|p| p.placements.values().map(|repeats| at(repeats)).collect())
                .collect();
            let grand = mean(&own.concat().concat());
            for person in &own {
                let own_mean = mean(&person.concat());
                self.squares[0] += person.concat().len() as f64 * (own_mean - grand).powi(2);
                for repeats in person {
                    let middle = mean(repeats);
                    self.squares[1] += repeats.len() as f64 * (middle - own_mean).powi(2);
                    self.squares[2] += repeats.iter().map(|db| (db - middle).powi(2)).sum::<f64>();
                }
            }
        }
    }
}
