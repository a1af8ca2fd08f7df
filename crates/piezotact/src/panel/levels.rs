//! Every person's own average in every cell, line by line over a band, and the averages over people that are made of them.

use num_complex::Complex;

use super::{Cell, Panel, PanelError};
use crate::quantity::{Band, Degrees, Newtons, Quantity};
use crate::statistics::rms;
use crate::transfer::{BundleAverage, TransferError, TransferFunction, level_db};

/// The data of every comparison: each person's own average in each cell.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Levels {
    pub(super) frequencies_hz: Vec<f64>,
    pub(super) people: Vec<String>,
    pub(super) cells: Vec<Cell>,
    /// By person, then by cell.
    own: Vec<Vec<Option<Own>>>,
}

/// One person in one cell.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Own {
    pub(super) response: Vec<Complex<f64>>,
    pub(super) db: Vec<f64>,
    /// Whether the whole band was excited.
    pub(super) excited: bool,
}

/// A magnitude below this is zero up to rounding.
const NO_RESPONSE: f64 = 1e-300;

impl Own {
    pub(super) fn of<I: Quantity, O: Quantity>(
        function: &TransferFunction<I, O>,
        band: Band,
    ) -> Self {
        let lines = function.lines_in(band);
        let response: Vec<_> = lines.map(|(line, _)| function.response()[line]).collect();
        Self {
            db: response.iter().map(|h| level_db(*h)).collect(),
            response,
            excited: function.unexcited_share(band) <= 0.0,
        }
    }
}

/// An average over people.
pub(super) struct Mean {
    averaging: BundleAverage,
    /// The sums over people: of responses, or of levels in dB.
    sums: Vec<Complex<f64>>,
    pub(super) people: usize,
}

impl Mean {
    pub(super) fn of<'a>(
        averaging: BundleAverage,
        people: impl IntoIterator<Item = &'a Own>,
    ) -> Self {
        let mut mean = Self {
            averaging,
            sums: Vec::new(),
            people: 0,
        };
        people.into_iter().for_each(|own| mean.add(own));
        mean
    }

    pub(super) fn add(&mut self, own: &Own) {
        self.sums.resize(own.db.len(), Complex::ZERO);
        self.people += 1;
        for (line, sum) in self.sums.iter_mut().enumerate() {
            *sum += match self.averaging {
                BundleAverage::LogMagnitude => Complex::from(own.db[line]),
                BundleAverage::Complex => own.response[line],
            };
        }
    }

    /// Its level at every line, dB.
    fn db(&self) -> impl Iterator<Item = f64> {
        let n = self.people as f64;
        self.sums.iter().map(move |sum| match self.averaging {
            BundleAverage::LogMagnitude => sum.re / n,
            BundleAverage::Complex => level_db(sum / n),
        })
    }

    /// The same.
    ///
    /// # Errors
    /// [`TransferError::Cancel`] when the sum of the responses is 0 at every line.
    pub(super) fn levels_db(&self) -> Result<Vec<f64>, PanelError> {
        let cancel = self.sums.iter().all(|sum| sum.norm() == 0.0);
        if cancel && self.averaging == BundleAverage::Complex {
            return Err(TransferError::Cancel { count: self.people }.into());
        }
        Ok(self.db().collect())
    }

    /// How far it is from `own`, dB rms.
    pub(super) fn off_db_rms(&self, own: &Own) -> f64 {
        let off = self.db().zip(&own.db).map(|(db, own)| db - own);
        rms(&off.collect::<Vec<_>>())
    }
}

/// For each of `people` the average of the others less the own level at every line, dB.
///
/// Formula: `20·log10|H of the others' average| − 20·log10|own H|`.
///
/// Source: leave-one-out, as in T. Hastie, R. Tibshirani and J. Friedman, *The Elements of Statistical Learning*, 2nd ed., section 7.10.
///
/// # Errors
/// [`TransferError::Cancel`] when others cancel.
pub(super) fn left_out_db(
    people: &[&Own],
    averaging: BundleAverage,
) -> Result<Vec<Vec<f64>>, PanelError> {
    let each = people.iter().enumerate().map(|(i, own)| {
        let others = people.iter().enumerate().filter(|(j, _)| *j != i);
        let others = Mean::of(averaging, others.map(|(_, other)| *other)).levels_db()?;
        let off = others.iter().zip(&own.db).map(|(db, own)| db - own);
        Ok(off.collect())
    });
    each.collect()
}

impl Levels {
    pub(super) fn of<I: Quantity, O: Quantity>(
        panel: &Panel<I, O>,
        band: Band,
        averaging: BundleAverage,
    ) -> Result<Self, PanelError> {
        let first = &panel.entries()[0].function;
        let frequencies_hz: Vec<f64> = first.lines_in(band).map(|(_, hz)| hz).collect();
        if frequencies_hz.is_empty() {
            return Err(PanelError::Empty { band });
        }
        let own = |who: &String, cell: &Cell| -> Result<Option<Own>, PanelError> {
            let Some(function) = panel.person(who, *cell, averaging)? else {
                return Ok(None);
            };
            let own = Own::of(&function, band);
            match own.response.iter().position(|h| h.norm() <= NO_RESPONSE) {
                Some(line) => Err(PanelError::NoResponse {
                    participant: who.clone(),
                    cell: cell.to_string(),
                    at_hz: frequencies_hz[line],
                }),
                None => Ok(Some(own)),
            }
        };
        let people = panel.participants().iter();
        let rows = people.map(|who| panel.cells().iter().map(|cell| own(who, cell)).collect());
        Ok(Self {
            own: rows.collect::<Result<_, _>>()?,
            people: panel.participants().to_vec(),
            cells: panel.cells().to_vec(),
            frequencies_hz,
        })
    }

    /// One person in one cell.
    pub(super) fn at(&self, person: usize, cell: usize) -> Option<&Own> {
        self.own.get(person)?.get(cell)?.as_ref()
    }

    /// The levels of one person in one cell, by name.
    pub(super) fn named(&self, who: &str, cell: Cell) -> Option<&[f64]> {
        let person = self.people.iter().position(|name| name == who)?;
        let cell = self.cells.iter().position(|one| one.is(cell))?;
        Some(&self.at(person, cell)?.db)
    }

    /// Everybody in one cell.
    pub(super) fn in_cell(&self, cell: usize) -> Vec<(&str, &Own)> {
        let people = self.people.iter().enumerate();
        people
            .filter_map(|(person, who)| Some((who.as_str(), self.at(person, cell)?)))
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
        let (load_n, angle_deg) = (Newtons(load_n), Degrees(angle_deg));
        let asked = Cell { load_n, angle_deg };
        self.cells.iter().position(|cell| cell.is(asked))
    }

    /// The loads, lightest first, N.
    pub(super) fn loads_n(&self) -> Vec<f64> {
        super::sorted(self.cells.iter().map(|cell| cell.load_n.0))
    }

    /// The angles, flattest first, degrees.
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
