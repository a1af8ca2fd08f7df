//! Repeatability of measurements with and without replacing the finger, and the components of their variance.

use serde::{Deserialize, Serialize};

use super::levels::{Own, robust_score};
use super::{Cell, Panel, PanelError};
use crate::quantity::{Band, Quantity};
use crate::statistics::{mean, rms};
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
    /// The share of the variance that lies between people, 0–1: an intraclass correlation.
    pub persons_share: f64,
}

/// One measurement.
struct Single {
    person: usize,
    cell: usize,
    placement: u32,
    db: Vec<f64>,
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
    let singles = singles(panel, band);
    let (mut lying, mut put_back) = (Vec::new(), Vec::new());
    for (person, who) in panel.participants().iter().enumerate() {
        for (cell, at) in panel.cells().iter().enumerate() {
            let own: Vec<&Single> = singles
                .iter()
                .filter(|s| (s.person, s.cell) == (person, cell))
                .collect();
            let placements = by_placement(&own);
            lying.extend(placements.iter().filter_map(|repeats| {
                let name = match placements.len() {
                    1 => format!("{who} at {at}"),
                    _ => format!("{who} at {at}, placement {}", repeats[0].placement),
                };
                Group::of(name, &pairs(repeats), repeats.iter().map(|s| s.db.clone()))
            }));
            let name = format!("{who} at {at}");
            let means = placements.iter().map(|repeats| mean_of(repeats));
            put_back.extend(Group::of(name, &pairs_across(&placements), means));
        }
    }
    let mut warnings = mixed(&lying, "repeats", Some(MOST_APART_DB));
    warnings.extend(mixed(&put_back, "placements", None));
    let mut parts = vec![band];
    parts.extend_from_slice(bands);
    let components = parts
        .into_iter()
        .filter_map(|part| components(&singles, panel.cells(), &frequencies_hz, part))
        .collect();
    let repeatability = Repeatability {
        lying: distances(&lying),
        put_back: distances(&put_back),
        frequencies_hz,
        components,
    };
    Ok((repeatability, warnings))
}

fn singles<I: Quantity, O: Quantity>(panel: &Panel<I, O>, band: Band) -> Vec<Single> {
    panel
        .entries()
        .iter()
        .filter_map(|entry| {
            let filing = &entry.filing;
            Some(Single {
                person: panel
                    .participants()
                    .iter()
                    .position(|p| *p == filing.participant)?,
                cell: panel.cells().iter().position(|c| c.is(filing.cell))?,
                placement: filing.placement,
                db: Own::of(&entry.function, band).db,
            })
        })
        .collect()
}

fn by_placement<'a>(own: &[&'a Single]) -> Vec<Vec<&'a Single>> {
    let mut numbers: Vec<u32> = own.iter().map(|s| s.placement).collect();
    numbers.sort_unstable();
    numbers.dedup();
    numbers
        .into_iter()
        .map(|number| {
            own.iter()
                .copied()
                .filter(|s| s.placement == number)
                .collect()
        })
        .collect()
}

fn mean_of(repeats: &[&Single]) -> Vec<f64> {
    let curves: Vec<&[f64]> = repeats.iter().map(|s| s.db.as_slice()).collect();
    super::spread::mean_curve(&curves)
}

fn apart(a: &Single, b: &Single) -> f64 {
    let off: Vec<f64> = a.db.iter().zip(&b.db).map(|(a, b)| a - b).collect();
    rms(&off)
}

fn pairs(repeats: &[&Single]) -> Vec<f64> {
    repeats
        .iter()
        .enumerate()
        .flat_map(|(i, a)| repeats[..i].iter().map(|b| apart(a, b)))
        .collect()
}

fn pairs_across(placements: &[Vec<&Single>]) -> Vec<f64> {
    let mut found = Vec::new();
    for (i, one) in placements.iter().enumerate() {
        for other in &placements[..i] {
            found.extend(one.iter().flat_map(|a| other.iter().map(|b| apart(a, b))));
        }
    }
    found
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
    fn of(
        name: String,
        distances_db: &[f64],
        curves: impl Iterator<Item = Vec<f64>>,
    ) -> Option<Self> {
        if distances_db.is_empty() {
            return None;
        }
        let curves: Vec<Vec<f64>> = curves.collect();
        let slices: Vec<&[f64]> = curves.iter().map(Vec::as_slice).collect();
        let middle = super::spread::mean_curve(&slices);
        let squares = middle
            .iter()
            .enumerate()
            .map(|(line, middle)| curves.iter().map(|c| (c[line] - middle).powi(2)).sum())
            .collect();
        Some(Self {
            name,
            distances_db: distances_db.to_vec(),
            squares,
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

fn mixed(groups: &[Group], what: &str, most_apart_db: Option<f64>) -> Vec<Warning> {
    if groups.len() < ENOUGH_GROUPS {
        let far = |group: &&Group| most_apart_db.is_some_and(|most| group.largest() > most);
        let warning = |group: &Group| {
            Warning::from(ScatterWarning::Scatter {
                of: Scatter::RepeatsOfParticipant {
                    kind: what.into(),
                    participant: group.name.clone(),
                    db_rms: group.largest(),
                    usual_db_rms: most_apart_db.unwrap_or_default(),
                },
            })
        };
        return groups.iter().filter(far).map(warning).collect();
    }
    let largest: Vec<f64> = groups.iter().map(Group::largest).collect();
    let usual_db_rms = crate::statistics::median(&mut largest.clone()).unwrap_or(f64::NAN);
    groups
        .iter()
        .zip(&largest)
        .filter(|(_, db)| {
            **db > MIXED_LEAST_DB
                && **db > MIXED_RATIO * usual_db_rms
                && robust_score(&largest, **db, 1e-3) > MIXED_SCORE
        })
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

/// Sums of squares and the coefficients of their expectations, added over cells.
#[derive(Default)]
struct Sums {
    persons: f64,
    placements: f64,
    repeats: f64,
    persons_freedom: f64,
    placements_freedom: f64,
    repeats_freedom: f64,
    /// Of the persons' variance in the persons' squares, of the placements' in theirs, and in the persons'.
    persons_in_persons: f64,
    placements_in_placements: f64,
    placements_in_persons: f64,
}

fn components(
    singles: &[Single],
    cells: &[Cell],
    frequencies_hz: &[f64],
    part: Band,
) -> Option<Components> {
    let lines: Vec<usize> = (0..frequencies_hz.len())
        .filter(|line| part.contains(frequencies_hz[*line]))
        .collect();
    if lines.is_empty() {
        return None;
    }
    let mut sums = Sums::default();
    for cell in 0..cells.len() {
        let inside: Vec<&Single> = singles.iter().filter(|s| s.cell == cell).collect();
        add_cell(&mut sums, &inside, &lines);
    }
    let count = lines.len() as f64;
    let (persons, placements, repeats) = (
        sums.persons / count,
        sums.placements / count,
        sums.repeats / count,
    );
    let repeats_var = (sums.repeats_freedom > 0.0).then(|| repeats / sums.repeats_freedom);
    let noise = repeats_var.unwrap_or(0.0);
    let placements_var = (sums.placements_freedom > 0.0).then(|| {
        ((placements - sums.placements_freedom * noise) / sums.placements_in_placements).max(0.0)
    });
    if sums.persons_freedom <= 0.0 {
        return None;
    }
    let placed = placements_var.unwrap_or(0.0);
    let persons_var =
        ((persons - sums.persons_freedom * noise - sums.placements_in_persons * placed)
            / sums.persons_in_persons)
            .max(0.0);
    let total = persons_var + placed + noise;
    Some(Components {
        band_hz: part,
        persons_db: persons_var.sqrt(),
        placements_db: placements_var.map(f64::sqrt),
        repeats_db: repeats_var.map(f64::sqrt),
        persons_share: if total > 0.0 {
            persons_var / total
        } else {
            0.0
        },
    })
}

fn add_cell(sums: &mut Sums, inside: &[&Single], lines: &[usize]) {
    let mut people: Vec<usize> = inside.iter().map(|s| s.person).collect();
    people.sort_unstable();
    people.dedup();
    if people.is_empty() {
        return;
    }
    let nested: Vec<Vec<Vec<&Single>>> = people
        .iter()
        .map(|person| {
            let own: Vec<&Single> = inside
                .iter()
                .copied()
                .filter(|s| s.person == *person)
                .collect();
            by_placement(&own)
        })
        .collect();
    let size = |person: &[Vec<&Single>]| person.iter().map(Vec::len).sum::<usize>() as f64;
    let squared = |person: &[Vec<&Single>]| -> f64 {
        person
            .iter()
            .map(|repeats| (repeats.len() as f64).powi(2))
            .sum()
    };
    let all = inside.len() as f64;
    let placements: usize = nested.iter().map(Vec::len).sum();
    let within: f64 = nested.iter().map(|p| squared(p) / size(p)).sum();
    let over: f64 = nested.iter().map(|p| squared(p)).sum::<f64>() / all;
    let people_squared: f64 = nested.iter().map(|p| size(p).powi(2)).sum::<f64>() / all;
    sums.persons_freedom += people.len() as f64 - 1.0;
    sums.placements_freedom += (placements - people.len()) as f64;
    sums.repeats_freedom += all - placements as f64;
    sums.persons_in_persons += all - people_squared;
    sums.placements_in_placements += all - within;
    sums.placements_in_persons += within - over;
    for &line in lines {
        let grand = mean(&inside.iter().map(|s| s.db[line]).collect::<Vec<_>>());
        for person in &nested {
            let own: Vec<f64> = person.iter().flatten().map(|s| s.db[line]).collect();
            let own_mean = mean(&own);
            sums.persons += own.len() as f64 * (own_mean - grand).powi(2);
            for repeats in person {
                let db: Vec<f64> = repeats.iter().map(|s| s.db[line]).collect();
                let middle = mean(&db);
                sums.placements += db.len() as f64 * (middle - own_mean).powi(2);
                sums.repeats += db.iter().map(|v| (v - middle).powi(2)).sum::<f64>();
            }
        }
    }
}
