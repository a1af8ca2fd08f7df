//! What a panel says, as it is handed out.

use serde::{Deserialize, Serialize};

use super::{AverageCriterion, Cell, Cleaning, Filing, Panel, PanelAnalysis};
use crate::document::Content;
use crate::page::{self, Column, Table};
use crate::quantity::{Uncalibrated, Unit};
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
    /// Source: docs/decisions/documents.md.
    #[must_use]
    pub fn of(drive_unit: &Unit) -> Self {
        match drive_unit {
            Unit::FullScale => Self::Device,
            Unit::Newton => Self::Finger,
            _ => Self::Other,
        }
    }
}

/// One measurement of a panel on disk, as its index lists it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct FiledMeasurement {
    /// The file in the folder.
    pub file: String,
    /// Who, how, which time.
    #[serde(flatten)]
    pub filing: Filing,
    /// The attempts at it with what was judged of each; none where nothing was judged, or nobody knows.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub attempts: Vec<Attempt>,
}

/// What is known of the measurements of a panel.
#[derive(Clone, Debug, PartialEq)]
pub struct PanelOrigin<'a> {
    /// What its transfer functions are of; absent where nothing says it.
    pub kind: Option<PanelKind>,
    /// The measurements that were judged when they were made.
    pub accepted: Vec<&'a FiledMeasurement>,
    /// Which bench measured it; absent where nothing says it.
    pub bench: Option<&'a str>,
    /// The units of the drive and of the response.
    pub units: [&'a Unit; 2],
}

/// What a panel says, with what is known of its measurements: what a report shows and what is handed out as JSON.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct AnalysedPanel<'a> {
    /// The analysis.
    #[serde(flatten)]
    pub analysis: &'a PanelAnalysis,
    /// What its transfer functions are of; absent where nothing says it.
    pub kind: Option<PanelKind>,
    /// The measurements that were judged when they were made.
    pub accepted: Vec<&'a FiledMeasurement>,
    /// The load and angle by which it is judged; absent where there is none.
    pub judged: Option<Cell>,
    /// Whether the average will do there for a new person: "yes", "no" or "not decided".
    pub will_the_average_do: Option<&'static str>,
    /// What a control measurement took out; absent without one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub artefact: Option<&'a Cleaning>,
    /// The transfer functions that were analysed.
    #[serde(skip)]
    pub panel: &'a Panel<Uncalibrated, Uncalibrated>,
    /// Which bench measured it; absent where nothing says it.
    #[serde(skip)]
    pub bench: Option<&'a str>,
    /// The units of the drive and of the response.
    #[serde(skip)]
    pub units: [&'a Unit; 2],
}

impl Content for AnalysedPanel<'_> {
    const SCHEMA: &'static str = "panel_analysis";
}

impl<'a> AnalysedPanel<'a> {
    /// What `analysis` says of the `panel` that comes from `origin`.
    ///
    /// Source: docs/decisions/documents.md.
    #[must_use]
    pub fn of(
        analysis: &'a PanelAnalysis,
        panel: &'a Panel<Uncalibrated, Uncalibrated>,
        origin: PanelOrigin<'a>,
        artefact: Option<&'a Cleaning>,
    ) -> Self {
        let judged = analysis.judged();
        let costs = judged.and_then(|cell| analysis.penalties_at(cell));
        Self {
            analysis,
            kind: origin.kind,
            accepted: origin.accepted,
            judged,
            will_the_average_do: costs.map(|costs| costs.verdict.outcome.answer()),
            artefact,
            panel,
            bench: origin.bench,
            units: origin.units,
        }
    }
}

impl PanelAnalysis {
    /// How far people lie apart, one row for each cell and band, the whole band first: angle in degrees, load in N, band in Hz,
    /// deviations, spreads and penalties in dB, and whether all were measured with a drive over the whole band.
    ///
    /// Source: docs/decisions/documents.md.
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
            "excited",
        ];
        let mut table = Table::new(columns.map(|name| Column::new(name, name)));
        for spread in &self.spreads {
            let bundle = &spread.bundle;
            let costs = self.penalties_at(spread.cell);
            let excited = costs.and_then(|costs| costs.criterion(AverageCriterion::Excited));
            let excited = excited.map_or(page::Cell::Missing(()), |rule| rule.outcome.into());
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
                let row = row.map(page::Cell::from).chain([excited.clone()]);
                table.rows.push(row.collect());
            }
        }
        table
    }
}
