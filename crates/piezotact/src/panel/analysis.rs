//! The complete analysis of a panel, as one value.

use serde::{Deserialize, Serialize};

use super::average::{averages, of_members};
use super::learning::curves;
use super::levels::Levels;
use super::spread::{ENOUGH_FOR_RESAMPLES, all_together, by_cell, falls, worst};
use super::together::Sign;
use super::trend::{by_angle, by_load};
use super::{
    AngleEffect, Cell, CellAverage, CellPenalties, CellSpread, Completeness, Criterion,
    FallsWithLoad, LearningCurve, LoadStep, Member, Panel, PanelError, Repeatability, SameResponse,
    WorstCase, repeatability,
};
use crate::quantity::{Band, Hertz, Quantity};
use crate::transfer::{BundleAverage, Ensemble, TransferError};
use crate::warning::{Few, FewWarning, Warning, Warnings};

/// How a panel is analysed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PanelConfig {
    /// The band.
    pub band: Band,
    /// Parts of the band that are reported separately in tables.
    pub bands: Vec<Band>,
    /// How a person's own measurements are averaged, and which average over people a new person would be rendered with.
    pub averaging: BundleAverage,
    /// The criterion for an average to be acceptable for a new person.
    pub criterion: Criterion,
    /// The tolerance for "enough people": the largest excess of the penalty of a small average over its limit for many people,
    /// dB.
    pub enough_within_db: f64,
    /// Random orders of people for the learning curve, where there are too many for every subset.
    pub orders: usize,
    /// Resamples of half of the people each, for the reliability of the worst case.
    pub resamples: usize,
    /// The seed of the random orders and resamples.
    pub seed: u64,
}

impl PanelConfig {
    /// Over `band` and its parts 20–50, 50–100, 100–250, 250–500 and 500–1000 Hz, with the mean of log magnitudes, the
    /// thesis' criterion, 0.1 dB for enough people, 100 orders and 1000 resamples.
    #[must_use]
    pub fn usual(band: Band, seed: u64) -> Self {
        let edges = [20.0, 50.0, 100.0, 250.0, 500.0, 1000.0];
        let bands = edges
            .windows(2)
            .filter_map(|pair| Band::new(Hertz(pair[0]), Hertz(pair[1])).ok()?.common(band))
            .collect();
        Self {
            band,
            bands,
            averaging: BundleAverage::LogMagnitude,
            criterion: Criterion::thesis_2024(),
            enough_within_db: 0.1,
            orders: 100,
            resamples: 1000,
            seed,
        }
    }
}

/// The complete analysis of a panel.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct PanelAnalysis {
    /// How it was analysed.
    pub config: PanelConfig,
    /// The participants.
    pub participants: Vec<String>,
    /// The number of loads and angles at which each participant was measured; participants without a cell are left out of
    /// comparisons that need it.
    pub attendances: Vec<Completeness>,
    /// Every measurement with the criteria that decide whether it is a member of the panel and its averages.
    pub members: Vec<Member>,
    /// How many participants were measured in every cell.
    pub complete: usize,
    /// How many transfer functions there are.
    pub measurements: usize,
    /// The cells, by angle and load.
    pub cells: Vec<Cell>,
    /// The cell with the largest difference between people; absent when fewer than two people were measured in all cells.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub worst: Option<WorstCase>,
    /// All curves together.
    pub all: Ensemble,
    /// How far people lie apart, by cell.
    pub spreads: Vec<CellSpread>,
    /// Whether the difference between people falls with load, by angle.
    pub falls: Vec<FallsWithLoad>,
    /// The effect of load.
    pub load_steps: Vec<LoadStep>,
    /// The effect of angle.
    pub angle_effects: Vec<AngleEffect>,
    /// How well measurements repeat.
    pub repeatability: Repeatability,
    /// Participants who may be one person: nothing is decided for a new person from an average with them.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub same_people: Vec<SameResponse>,
    /// Averages over people, by cell.
    pub averages: Vec<CellAverage>,
    /// How many people an average needs, by cell.
    pub learning: Vec<LearningCurve>,
    /// What a person should know before relying on it.
    pub warnings: Warnings,
    /// The curves of everybody.
    #[serde(skip)]
    pub(super) levels: Levels,
}

impl PanelAnalysis {
    /// The cell that represents the panel in the verdict: the worst case, with the largest difference between people.
    #[must_use]
    pub fn judged(&self) -> Option<Cell> {
        let widest = || {
            let widest = self.spreads.iter().max_by(|a, b| {
                let (a, b) = (a.bundle.max_deviation_db, b.bundle.max_deviation_db);
                a.total_cmp(&b)
            });
            widest.map(|spread| spread.cell)
        };
        self.worst.as_ref().map(|worst| worst.cell).or_else(widest)
    }

    /// What the average costs a new person in one cell, by the average that is asked for in the configuration.
    #[must_use]
    pub fn penalties_at(&self, cell: Cell) -> Option<&CellPenalties> {
        let found = self.averages.iter().find(|a| a.cell.is(cell))?;
        Some(found.penalties_of(self.config.averaging))
    }
}

/// Adds to an error about curves that cancel in a complex mean the names of the measurements with opposite sign, if known.
pub(super) fn with_opposite_names(error: PanelError, opposite: Option<&Sign<'_>>) -> PanelError {
    match (error, opposite.and_then(Sign::warning)) {
        (PanelError::Transfer(TransferError::Cancel { .. }), Some(warning)) => {
            PanelError::Opposite {
                what: warning.to_string(),
            }
        }
        (error, _) => error,
    }
}

/// The complete analysis of `panel` over the band of `config`: differences between people and the worst cell, the effects of load
/// and angle, repeatability, and the penalty of an average over people for a new person. Levels in dB re 1 unit of `O` per `I`.
///
/// Source: L. Felicetti's thesis (2024), chapter 5; B. Iglewicz and D. C. Hoaglin, *How to Detect and Handle Outliers*, 1993; D. N. Politis
/// and J. P. Romano (1994), Ann. Statist. 22(4); K. V. Mardia and P. E. Jupp, *Directional Statistics*, 2000; T. Hastie, R. Tibshirani and
/// J. Friedman, *The Elements of Statistical Learning*, 2nd ed., section 7.10; and the sources of [`repeatability`].
///
/// # Errors
/// [`PanelError::Few`] for fewer than two participants, [`PanelError::Empty`] when no line lies in the band,
/// [`PanelError::Transfer`] when people cannot be averaged.
pub fn analyse<I: Quantity, O: Quantity>(
    panel: &Panel<I, O>,
    config: &PanelConfig,
) -> Result<PanelAnalysis, PanelError> {
    let people = panel.participants().len();
    if people < 2 {
        return Err(PanelError::Few {
            cell: "any load and angle".into(),
            expected: 2,
            found: people,
        });
    }
    let (band, seed) = (config.band, config.seed);
    let signs = panel.signs(band);
    let opposites: Vec<&Sign<'_>> = signs.iter().filter(|sign| sign.is_opposite()).collect();
    let named = |error| with_opposite_names(error, opposites.first().copied());
    let levels = Levels::of(panel, band, config.averaging).map_err(named)?;
    let mut warnings = panel.warnings.clone();
    if people < ENOUGH_FOR_RESAMPLES {
        warnings.push(Warning::from(FewWarning::Few {
            found: people,
            recommended: ENOUGH_FOR_RESAMPLES,
            what: Few::Participants,
        }));
    }
    let (spreads, odd) = by_cell(&levels, config.averaging, &config.bands).map_err(named)?;
    let (repeatability, mixed) = repeatability(panel, band, &config.bands)?;
    warnings.extend(opposites.iter().filter_map(|sign| sign.warning()));
    warnings.extend(panel.unsound(band, None));
    warnings.extend(mixed);
    warnings.extend(odd);
    let members = panel.entries().iter();
    warnings.extend(of_members(
        members.map(|e| (e.filing.to_string(), e.function.about.warnings.as_slice())),
    ));
    Ok(PanelAnalysis {
        config: config.clone(),
        participants: panel.participants().to_vec(),
        attendances: panel.attendances(),
        members: panel.members(&signs, band),
        complete: panel.complete().len(),
        measurements: panel.entries().len(),
        cells: panel.cells().to_vec(),
        worst: worst(&levels, config.resamples, seed).ok(),
        all: all_together(&levels),
        spreads,
        falls: falls(&levels, config.resamples, seed),
        load_steps: by_load(&levels),
        angle_effects: by_angle(&levels),
        repeatability,
        same_people: panel.same_people().to_vec(),
        averages: averages(&levels, config.criterion)
            .map_err(named)?
            .into_iter()
            .map(|found| found.beside_same(panel.same_people()))
            .collect(),
        learning: curves(&levels, config),
        levels,
        warnings,
    })
}
