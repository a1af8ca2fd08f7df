//! What a panel says, as it is handed out.

use serde::{Deserialize, Serialize};

use super::{Filing, PanelAnalysis};
use crate::page::{Cell, Column, Table};
use crate::quantity::Unit;
use crate::run::Attempt;

/// The kind of system that a panel's transfer functions describe.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum PanelKind {
    /// A device with a finger on it: from the digital drive.
    Device,
    /// A finger alone: from the force on it.
    Finger,
    /// Something else.
    Other,
}

impl PanelKind {
    /// What transfer functions from `drive_unit` are of.
    ///
    /// Source: decision 0046 of this project.
    #[must_use]
    pub fn of(drive_unit: &Unit) -> Self {
        match drive_unit {
            Unit::FullScale => Self::Device,
            Unit::Newton => Self::Finger,
            _ => Self::Other,
        }
    }
}

/// A measurement of a panel with what was judged when it was made.
#[derive(Clone, Copy, Debug)]
pub struct JudgedFiling<'a> {
    /// Who, how, which time.
    pub filing: &'a Filing,
    /// The attempts at it.
    pub attempts: &'a [Attempt],
}

impl PanelAnalysis {
    /// How far people lie apart, one row for each cell and band, the whole band first: angle in degrees, load in N, band in Hz,
    /// deviations, spreads and penalties in dB.
    ///
    /// Source: decision 0046 of this project.
    #[must_use]
    pub fn table(&self) -> Table {
        let columns = [
            "angle_deg",
            "load_n",
            "low_hz",
            "high_hz",
            "participants",
            "max_deviation_db",
            "at_hz",
            "spread_rms_db",
            "penalty_db_rms",
        ];
        let mut table = Table::new(columns.map(|name| Column::new(name, name)));
        for spread in &self.spreads {
            let bundle = &spread.bundle;
            let costs = self.penalties_at(spread.cell);
            let whole = [
                bundle.max_deviation_db,
                bundle.max_deviation_at_hz,
                spread.spread_rms_db,
                costs.map_or(f64::NAN, |costs| costs.mean_db_rms),
            ];
            let parts = spread.bands.iter().map(|part| {
                let values = [
                    part.max_deviation_db,
                    part.at_hz,
                    part.spread_rms_db,
                    part.penalty_db_rms,
                ];
                (part.band_hz, values)
            });
            for (band, values) in std::iter::once((self.config.band, whole)).chain(parts) {
                let cell = spread.cell;
                let first = [cell.angle_deg.0, cell.load_n.0, band.low().0, band.high().0];
                let count = [bundle.count as f64];
                let row = first.into_iter().chain(count).chain(values);
                table.rows.push(row.map(Cell::from).collect());
            }
        }
        table
    }
}
