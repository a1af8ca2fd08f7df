//! Magnitudes in dB of every person in every cell, over the lines of a band.

use super::{Cell, Panel, PanelError};
use crate::quantity::{Band, Quantity};
use crate::transfer::{BundleAverage, TransferFunction, level_db};

/// The data of every comparison: each person's own average in each cell.
pub(super) struct Levels<I: Quantity, O: Quantity> {
    pub(super) frequencies_hz: Vec<f64>,
    pub(super) people: Vec<String>,
    pub(super) cells: Vec<Cell>,
    /// By person, then by cell.
    own: Vec<Vec<Option<Own<I, O>>>>,
}

/// One person in one cell.
pub(super) struct Own<I: Quantity, O: Quantity> {
    pub(super) function: TransferFunction<I, O>,
    pub(super) db: Vec<f64>,
}

/// A magnitude below this is zero up to rounding.
const NO_RESPONSE: f64 = 1e-300;

/// The levels of the lines of `band`, dB.
pub(super) fn levels_db<I: Quantity, O: Quantity>(
    function: &TransferFunction<I, O>,
    band: Band,
) -> Vec<f64> {
    function
        .lines_in(band)
        .map(|(line, _)| level_db(function.response()[line]))
        .collect()
}

impl<I: Quantity, O: Quantity> Levels<I, O> {
    pub(super) fn of(
        panel: &Panel<I, O>,
        band: Band,
        averaging: BundleAverage,
    ) -> Result<Self, PanelError> {
        let first = &panel.entries()[0].function;
        let frequencies_hz: Vec<f64> = first.lines_in(band).map(|(_, hz)| hz).collect();
        if frequencies_hz.is_empty() {
            return Err(PanelError::Empty { band });
        }
        let mut own = Vec::new();
        for who in panel.participants() {
            let mut row = Vec::new();
            for cell in panel.cells() {
                let function = panel.person(who, *cell, averaging)?;
                if let Some(silent) = function.as_ref().and_then(|f| {
                    let mut lines = f.lines_in(band);
                    lines.find(|(line, _)| f.response()[*line].norm() <= NO_RESPONSE)
                }) {
                    return Err(PanelError::NoResponse {
                        participant: who.clone(),
                        cell: cell.to_string(),
                        at_hz: silent.1,
                    });
                }
                row.push(function.map(|function| Own {
                    db: levels_db(&function, band),
                    function,
                }));
            }
            own.push(row);
        }
        Ok(Self {
            frequencies_hz,
            people: panel.participants().to_vec(),
            cells: panel.cells().to_vec(),
            own,
        })
    }

    /// One person in one cell.
    pub(super) fn at(&self, person: usize, cell: usize) -> Option<&Own<I, O>> {
        self.own.get(person)?.get(cell)?.as_ref()
    }

    /// Everybody in one cell.
    pub(super) fn in_cell(&self, cell: usize) -> Vec<(usize, &Own<I, O>)> {
        (0..self.people.len())
            .filter_map(|person| Some((person, self.at(person, cell)?)))
            .collect()
    }

    /// The people who are in all of `cells`.
    pub(super) fn complete(&self, cells: &[usize]) -> Vec<usize> {
        (0..self.people.len())
            .filter(|person| cells.iter().all(|cell| self.at(*person, *cell).is_some()))
            .collect()
    }

    /// The index of a cell.
    pub(super) fn cell(&self, load_n: f64, angle_deg: f64) -> Option<usize> {
        self.cells.iter().position(|cell| {
            cell.is(Cell {
                load_n: crate::quantity::Newtons(load_n),
                angle_deg: crate::quantity::Degrees(angle_deg),
            })
        })
    }

    /// The loads, lightest first, and the angles, flattest first.
    pub(super) fn loads_n(&self) -> Vec<f64> {
        super::sorted(self.cells.iter().map(|cell| cell.load_n.0))
    }

    pub(super) fn angles_deg(&self) -> Vec<f64> {
        super::sorted(self.cells.iter().map(|cell| cell.angle_deg.0))
    }
}

/// Every neighbouring pair of `values`, and the first with the last if that is a different pair.
pub(super) fn steps(values: &[f64]) -> Vec<(f64, f64)> {
    let mut pairs: Vec<(f64, f64)> = values.windows(2).map(|pair| (pair[0], pair[1])).collect();
    if let ([first, _, _, ..], Some(last)) = (values, values.last()) {
        pairs.insert(0, (*first, *last));
    }
    pairs
}

/// How many robust standard deviations `value` lies above the median of `values`, a deviation being no less than
/// `least_spread`.
///
/// Formula: (x − median)/max(1.4826·MAD, least).
pub(super) fn robust_score(values: &[f64], value: f64, least_spread: f64) -> f64 {
    let middle = crate::statistics::median(&mut values.to_vec()).unwrap_or(f64::NAN);
    let mut off: Vec<f64> = values.iter().map(|v| (v - middle).abs()).collect();
    let spread = 1.4826 * crate::statistics::median(&mut off).unwrap_or(f64::NAN);
    (value - middle) / spread.max(least_spread)
}
