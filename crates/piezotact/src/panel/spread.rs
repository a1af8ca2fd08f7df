//! Differences between people: by cell, in the worst cell, and whether they fall with load.

use serde::{Deserialize, Serialize};

use super::levels::{Levels, Own, left_out_db, robust_score};
use super::random::Draws;
use super::{Cell, PanelError};
use crate::criterion::{Criterion, Limit, Outcome};
use crate::quantity::{Band, Degrees, Newtons};
use crate::statistics::{Direction, mean, rms};
use crate::transfer::{BundleAverage, Ensemble};
use crate::warning::{Example, Scatter, ScatterWarning, Warning};

/// A person this many robust standard deviations further from the mean curve than the median person is an outlier.
const OUTLIER: f64 = 3.5;
/// The smallest robust standard deviation of distances that is used, dB: smaller differences are imperceptible.
const LEAST_SPREAD_DB: f64 = 0.25;
/// The fewest people for which outliers are identified.
const ENOUGH_FOR_OUTLIERS: usize = 4;
/// The fewest people for which resampling estimates what another panel would find.
pub(super) const ENOUGH_FOR_RESAMPLES: usize = 4;

/// With fewer people than this there are too few exchanges of loads to reach p < 0.05 …
const ENOUGH_FOR_EXCHANGE: usize = 6;
/// … and up to this number of people all exchanges are evaluated.
const ALL_EXCHANGES: usize = 11;
/// The share of resamples from which on they count as agreeing.
const MIN_RESAMPLE_AGREEMENT: f64 = 0.95;
/// The significance level for a direction.
const SIGNIFICANT: f64 = 0.05;

/// How far people lie apart in one cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct CellSpread {
    /// Load and angle.
    pub cell: Cell,
    /// The curves of all, line by line: each person's own average counts once.
    pub bundle: Ensemble,
    /// The mean of the levels of every line, dB.
    pub mean_db: Vec<f64>,
    /// The rms over the band of the standard deviation over people, dB.
    pub spread_rms_db: f64,
    /// How far everybody is from the mean curve.
    pub people: Vec<ParticipantDistance>,
    /// The same by bands.
    pub bands: Vec<BandSpread>,
}

/// How far one person is from the mean curve of a cell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ParticipantDistance {
    /// The pseudonym.
    pub participant: String,
    /// The rms over the band, dB.
    pub db_rms: f64,
    /// The largest distance, dB, with its sign.
    pub db_max: f64,
    /// Where it is, Hz.
    pub at_hz: f64,
    /// Whether it is an outlier among four people or more: far beyond the distances of the others.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub is_odd: bool,
}

/// How far people lie apart in a part of the band.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct BandSpread {
    /// The part.
    pub band_hz: Band,
    /// The largest distance between highest and lowest, dB.
    pub max_deviation_db: f64,
    /// Where it is, Hz.
    pub at_hz: f64,
    /// The rms over its lines of the standard deviation over people, dB.
    pub spread_rms_db: f64,
    /// What the average of the others costs a person there: the mean of the rms differences, dB.
    pub penalty_db_rms: f64,
}

/// The cell in which people lie furthest apart, and how sure that is.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct WorstCase {
    /// The cell.
    pub cell: Cell,
    /// Its maximum deviation, dB, over those people who were measured in all cells.
    pub max_deviation_db: f64,
    /// Where it is, Hz.
    pub at_hz: f64,
    /// The deviation of every cell over the same people, dB, widest first.
    pub ranking: Vec<(Cell, f64)>,
    /// How many people that are.
    pub people: usize,
    /// The share of resamples (half of the people each) in which this cell stays the worst; absent for fewer than four people,
    /// or one cell.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share: Option<f64>,
    /// How many resamples.
    pub resamples: usize,
}

/// The criteria by which one cell is the worst.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WorstCriterion {
    /// How many people were measured in all cells.
    People,
    /// The share of resamples in which this cell stays the worst.
    Agreement,
}

impl WorstCase {
    /// The criteria by which this cell is the worst: six or more people, and the same cell in 95 % of the resamples; none where it is
    /// the only cell. What does not meet them is not decided.
    #[must_use]
    pub fn criteria(&self) -> Vec<Criterion<WorstCriterion>> {
        if self.ranking.len() < 2 {
            return Vec::new();
        }
        let from = |met: f64| Limit::AtLeast { met, not_met: 0.0 };
        let (enough, agreed) = (
            from(ENOUGH_FOR_EXCHANGE as f64),
            from(MIN_RESAMPLE_AGREEMENT),
        );
        let agreement = WorstCriterion::Agreement;
        vec![
            Criterion::new(
                WorstCriterion::People,
                "people",
                self.people as f64,
                None,
                enough,
            ),
            match self.share {
                Some(share) => Criterion::new(agreement, "", share, None, agreed),
                None => Criterion::unmeasured(agreement, "", agreed),
            },
        ]
    }

    /// Whether this cell is the worst, by its criteria.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        Outcome::of_all(self.criteria().iter().map(|rule| rule.outcome))
    }
}

/// Whether the maximum deviation falls with load at one angle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct FallsWithLoad {
    /// The angle.
    pub angle_deg: Degrees,
    /// The loads, lightest first.
    pub loads_n: Vec<Newtons>,
    /// The maximum deviation at each, dB, over those people who were measured at all of them.
    pub deviations_db: Vec<f64>,
    /// Whether it falls at every step, as measured.
    pub falls: bool,
    /// From the lightest to the heaviest load, dB.
    pub change_db: f64,
    /// The two-sided p-value of the change, under the hypothesis that load does not change the differences between people; absent
    /// when there are too few people.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub p_value: Option<f64>,
    /// Whether it rises or falls from the lightest to the heaviest load, at p < 0.05.
    pub direction: Direction,
    /// How many people that are.
    pub people: usize,
    /// The share of resamples (half of the people each) in which it falls at every step; absent for fewer than four people.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share: Option<f64>,
    /// The share in which it is less at the heaviest load than at the lightest.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share_overall: Option<f64>,
}

/// The differences between all transfer functions of the panel, over people and cells: each person's own average in each
/// cell counts once.
///
/// Source: L. Felicetti's thesis (2024), figure 67d.
pub(super) fn all_together(levels: &Levels) -> Ensemble {
    let cells = (0..levels.cells.len()).flat_map(|cell| levels.in_cell(cell));
    let curves: Vec<&[f64]> = cells.map(|(_, own)| own.db.as_slice()).collect();
    Ensemble::of(&levels.frequencies_hz, &curves)
}

/// How far people lie apart in every cell with two or more, over the band and its parts `bands`; and the warnings about
/// single people.
///
/// Formula: [`Ensemble::of`] each person's own average. A person is an outlier whose rms distance d from the mean curve
/// has (d − median)/(1.4826·MAD) > 3.5, MAD the median absolute deviation of the distances of all.
///
/// Source: L. Felicetti's thesis (2024), figures 67, 76 and 77; the rule: B. Iglewicz and D. C. Hoaglin, *How to Detect
/// and Handle Outliers*, 1993.
///
/// # Errors
/// [`PanelError::Transfer`] when people cancel.
pub(super) fn by_cell(
    levels: &Levels,
    averaging: BundleAverage,
    bands: &[Band],
) -> Result<(Vec<CellSpread>, Vec<Warning>), PanelError> {
    let (mut spreads, mut warnings) = (Vec::new(), Vec::new());
    for (i, cell) in levels.cells.iter().enumerate() {
        let (names, inside): (Vec<&str>, Vec<&Own>) = levels.in_cell(i).into_iter().unzip();
        if inside.len() < 2 {
            continue;
        }
        let curves: Vec<&[f64]> = inside.iter().map(|own| own.db.as_slice()).collect();
        let bundle = Ensemble::of(&levels.frequencies_hz, &curves);
        let mean_db = mean_curve(&curves);
        let people = names.iter().zip(&curves);
        let mut people: Vec<ParticipantDistance> = people
            .map(|(who, db)| distance(who, db, &mean_db, &levels.frequencies_hz))
            .collect();
        warnings.extend(odd_ones(&mut people, *cell));
        let left_out_db = left_out_db(&inside, averaging)?;
        let parts = bands.iter();
        spreads.push(CellSpread {
            cell: *cell,
            spread_rms_db: rms(&bundle.spread_db),
            bands: parts
                .filter_map(|part| in_part(*part, &bundle, &left_out_db))
                .collect(),
            bundle,
            mean_db,
            people,
        });
    }
    Ok((spreads, warnings))
}

/// The mean of several curves, line by line.
pub(super) fn mean_curve(curves: &[&[f64]]) -> Vec<f64> {
    let lines = curves.first().map_or(0, |curve| curve.len());
    (0..lines)
        .map(|line| curves.iter().map(|curve| curve[line]).sum::<f64>() / curves.len() as f64)
        .collect()
}

fn distance(who: &str, own: &[f64], mean: &[f64], frequencies_hz: &[f64]) -> ParticipantDistance {
    let off: Vec<f64> = own.iter().zip(mean).map(|(own, mean)| own - mean).collect();
    let (db_max, at_hz) = off
        .iter()
        .zip(frequencies_hz)
        .max_by(|a, b| a.0.abs().total_cmp(&b.0.abs()))
        .map_or((0.0, f64::NAN), |(off, hz)| (*off, *hz));
    ParticipantDistance {
        participant: who.to_owned(),
        db_rms: rms(&off),
        db_max,
        at_hz,
        is_odd: false,
    }
}

/// Marks the outliers among `people`, each with its warning.
fn odd_ones(people: &mut [ParticipantDistance], cell: Cell) -> Vec<Warning> {
    if people.len() < ENOUGH_FOR_OUTLIERS {
        return Vec::new();
    }
    let distances: Vec<f64> = people.iter().map(|p| p.db_rms).collect();
    let usual_db_rms = crate::statistics::median(&mut distances.clone()).unwrap_or(f64::NAN);
    for p in &mut *people {
        p.is_odd = robust_score(&distances, p.db_rms, LEAST_SPREAD_DB) > OUTLIER;
    }
    people
        .iter()
        .filter(|p| p.is_odd)
        .map(|p| {
            Warning::from(ScatterWarning::Scatter {
                of: Scatter::Participant {
                    participant: p.participant.clone(),
                    at: Example::from(cell.to_string()),
                    db_rms: p.db_rms,
                    usual_db_rms,
                },
            })
        })
        .collect()
}

/// The spread in a part of the band, with the errors of the average of the others, `left_out_db`.
fn in_part(part: Band, bundle: &Ensemble, left_out_db: &[Vec<f64>]) -> Option<BandSpread> {
    let inside = |line: &usize| part.contains(bundle.frequencies_hz[*line]);
    let lines: Vec<usize> = (0..bundle.frequencies_hz.len()).filter(inside).collect();
    let range = |line: usize| bundle.highest_db[line] - bundle.lowest_db[line];
    let widest = lines.iter().copied();
    let widest = widest.max_by(|a, b| range(*a).total_cmp(&range(*b)))?;
    let over = |db: &[f64]| rms(&lines.iter().map(|line| db[*line]).collect::<Vec<_>>());
    let penalties: Vec<f64> = left_out_db.iter().map(|off| over(off)).collect();
    Some(BandSpread {
        band_hz: part,
        max_deviation_db: range(widest),
        at_hz: bundle.frequencies_hz[widest],
        spread_rms_db: over(&bundle.spread_db),
        penalty_db_rms: mean(&penalties),
    })
}

/// The largest range over people in a cell, dB, and where.
fn deviation(levels: &Levels, people: &[usize], cell: usize) -> (f64, f64) {
    let mut curves = people
        .iter()
        .filter_map(|person| Some(levels.at(*person, cell)?.db.as_slice()));
    let Some(first) = curves.next() else {
        return (0.0, f64::NAN);
    };
    let (mut low, mut high) = (first.to_vec(), first.to_vec());
    for curve in curves {
        for ((low, high), db) in low.iter_mut().zip(&mut high).zip(curve) {
            *low = low.min(*db);
            *high = high.max(*db);
        }
    }
    let ranges = low.iter().zip(&high).map(|(low, high)| high - low);
    ranges
        .zip(&levels.frequencies_hz)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map_or((0.0, f64::NAN), |(range, hz)| (range, *hz))
}

/// The share of `resamples`, each half of `people` at random, in which `holds`; `None` for fewer people than say anything.
fn share_of(
    people: &[usize],
    resamples: usize,
    seed: u64,
    mut holds: impl FnMut(&[usize]) -> bool,
) -> Option<f64> {
    if people.len() < ENOUGH_FOR_RESAMPLES || resamples == 0 {
        return None;
    }
    let mut draws = Draws::new(seed);
    let mut order = people.to_vec();
    let half = people.len().div_ceil(2);
    let held = (0..resamples).filter(|_| {
        draws.shuffle(&mut order);
        holds(&order[..half])
    });
    Some(held.count() as f64 / resamples as f64)
}

/// The cell in which people lie furthest apart over `band`, and in which share of `resamples`, each half of the people drawn
/// by `seed`, it stays so. Only people who were measured in all cells count.
///
/// A largest distance depends on two people. Resamples drawn with replacement mostly hold both, and the share would be too high:
/// half of the people drawn without replacement are closer to what another panel would find.
///
/// Formula: the largest over cells of max over lines of max − min over people, in dB.
///
/// Source: L. Felicetti's thesis (2024), section 5.1.2, for the worst case; D. N. Politis and J. P. Romano
/// (1994), Ann. Statist. 22(4), for subsampling.
///
/// # Errors
/// [`PanelError::Few`] when fewer than two people are complete.
pub(super) fn worst(levels: &Levels, resamples: usize, seed: u64) -> Result<WorstCase, PanelError> {
    let cells: Vec<usize> = (0..levels.cells.len()).collect();
    let people = levels.complete(&cells);
    if people.len() < 2 {
        return Err(PanelError::Few {
            cell: "every load and angle".into(),
            expected: 2,
            found: people.len(),
        });
    }
    let ranked = |people: &[usize]| {
        let mut ranked: Vec<(usize, (f64, f64))> = cells
            .iter()
            .map(|cell| (*cell, deviation(levels, people, *cell)))
            .collect();
        ranked.sort_by(|a, b| b.1.0.total_cmp(&a.1.0));
        ranked
    };
    let ranking = ranked(&people);
    let (worst, (max_deviation_db, at_hz)) = ranking[0];
    let several = if cells.len() > 1 { resamples } else { 0 };
    Ok(WorstCase {
        cell: levels.cells[worst],
        max_deviation_db,
        at_hz,
        ranking: ranking
            .iter()
            .map(|(cell, (db, _))| (levels.cells[*cell], *db))
            .collect(),
        people: people.len(),
        share: share_of(&people, several, seed, |drawn| ranked(drawn)[0].0 == worst),
        resamples: several,
    })
}

/// Whether the maximum deviation over `band` falls with load, at every angle with two or more loads, and in which share
/// of `resamples`, each half of the people drawn by `seed`. Only people who were measured at all loads count.
///
/// Formula: p is the share of exchanges of the lightest and the heaviest load, person by person, of the curves less the mean
/// curve of each load, in which the maximum deviation changes at least as much: all of them for up to eleven people, else
/// `resamples` of them, itself counted.
///
/// Source: L. Felicetti's thesis (2024), figures 68 and 77; [`worst`] for the share; P. I. Good, *Permutation,
/// Parametric, and Bootstrap Tests of Hypotheses*, 3rd ed., section 3.7, for p.
pub(super) fn falls(levels: &Levels, resamples: usize, seed: u64) -> Vec<FallsWithLoad> {
    let loads_n = levels.loads_n();
    let mut found = Vec::new();
    for angle_deg in levels.angles_deg() {
        let (loads_n, cells): (Vec<f64>, Vec<usize>) = loads_n
            .iter()
            .filter_map(|load_n| Some((*load_n, levels.cell(*load_n, angle_deg)?)))
            .unzip();
        let people = levels.complete(&cells);
        if cells.len() < 2 || people.len() < 2 {
            continue;
        }
        let over = |people: &[usize]| -> Vec<f64> {
            let each = cells.iter().map(|cell| deviation(levels, people, *cell).0);
            each.collect()
        };
        let falling = |db: &[f64]| db.windows(2).all(|pair| pair[0] > pair[1]);
        let overall = |db: &[f64]| db.first() > db.last();
        let deviations_db = over(&people);
        let change_db = deviations_db[cells.len() - 1] - deviations_db[0];
        let ends = [cells[0], cells[cells.len() - 1]];
        let p_value = exchanged(levels, &people, ends, resamples, seed);
        found.push(FallsWithLoad {
            change_db,
            p_value,
            direction: match p_value {
                Some(p) if p < SIGNIFICANT && change_db > 0.0 => Direction::Rises,
                Some(p) if p < SIGNIFICANT => Direction::Falls,
                _ => Direction::NotShown,
            },
            angle_deg: Degrees(angle_deg),
            loads_n: loads_n.into_iter().map(Newtons).collect(),
            falls: falling(&deviations_db),
            people: people.len(),
            share: share_of(&people, resamples, seed, |drawn| falling(&over(drawn))),
            share_overall: share_of(&people, resamples, seed, |drawn| overall(&over(drawn))),
            deviations_db,
        });
    }
    found
}

/// The p-value of the change of the maximum deviation from one cell to another, under the hypothesis of no difference between the
/// cells; `None` for too few people.
fn exchanged(
    levels: &Levels,
    people: &[usize],
    ends: [usize; 2],
    resamples: usize,
    seed: u64,
) -> Option<f64> {
    if people.len() < ENOUGH_FOR_EXCHANGE || resamples == 0 {
        return None;
    }
    let about_mean = |cell: usize| -> Option<Vec<Vec<f64>>> {
        let curves: Vec<&[f64]> = people
            .iter()
            .map(|person| Some(levels.at(*person, cell)?.db.as_slice()))
            .collect::<Option<_>>()?;
        let middle = mean_curve(&curves);
        let off = |curve: &&[f64]| curve.iter().zip(&middle).map(|(db, m)| db - m).collect();
        Some(curves.iter().map(off).collect())
    };
    let curves = [about_mean(ends[0])?, about_mean(ends[1])?];
    let lines = levels.frequencies_hz.len();
    let widest = |end: usize, swapped: &[bool]| -> f64 {
        let range = |line: usize| {
            let values = swapped.iter().enumerate();
            let (low, high) = values.fold((f64::MAX, f64::MIN), |(low, high), (person, swap)| {
                let db = curves[end ^ usize::from(*swap)][person][line];
                (low.min(db), high.max(db))
            });
            high - low
        };
        (0..lines).map(range).fold(0.0, f64::max)
    };
    let change = |swapped: &[bool]| (widest(1, swapped) - widest(0, swapped)).abs();
    let mut swapped = vec![false; people.len()];
    let found = change(&swapped) - 1e-9;
    // Exchanging everybody only changes the sign, so the last person is never exchanged.
    let (as_large, of) = if people.len() <= ALL_EXCHANGES {
        let all = 1_usize << (people.len() - 1);
        let mut count = 0;
        for set in 0..all {
            for (person, swap) in swapped.iter_mut().enumerate() {
                *swap = set >> person & 1 == 1;
            }
            count += usize::from(change(&swapped) >= found);
        }
        (count, all)
    } else {
        let mut draws = Draws::new(seed);
        let mut count = 1;
        for _ in 0..resamples {
            swapped.fill_with(|| draws.below(2) == 1);
            count += usize::from(change(&swapped) >= found);
        }
        (count, resamples + 1)
    };
    Some(as_large as f64 / of as f64)
}
