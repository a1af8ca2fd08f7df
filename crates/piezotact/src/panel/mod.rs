//! Transfer functions of a panel of people, by load and angle: differences between people, effects of load and angle,
//! repeatability of measurements, and the penalty of an average over people for a new person.
//!
//! A [`Panel`] holds all of them as one value; it is refused when they cannot be combined. [`analyse`] computes everything
//! that is reported about it.

mod analysis;
mod average;
mod cleaning;
mod control;
mod document;
mod learning;
mod levels;
mod membership;
mod page;
mod page_figures;
mod page_members;
mod page_tables;
mod placement;
mod prediction;
mod random;
mod repeat;
mod same_person;
mod sentences;
mod spread;
mod together;
mod trend;
mod warning;

pub use analysis::{PanelAnalysis, PanelConfig, analyse};
pub use average::{
    AverageCriterion, AverageDifference, CellAverage, CellPenalties, Criterion, PanelAverage,
    ParticipantPenalty, Verdict, average_of_panel, share_interval,
};
pub use cleaning::{CleanedDip, Cleaning, without_artefact};
pub use control::{Artefact, Dip, Removed, artefact_of};
pub use document::{AnalysedPanel, FiledMeasurement, PanelKind, PanelOrigin};
pub use learning::{LearningCriterion, LearningCurve, LearningPoint};
pub use membership::{Completeness, Member, MemberCriterion, ParticipantCriterion};
pub use placement::{PlacementSpread, SpreadKind, placement_spread};
pub use repeat::{Components, PairDistances, Repeatability, repeatability};
pub use same_person::SameResponse;
pub use spread::{
    BandSpread, CellSpread, FallsWithLoad, ParticipantDistance, WorstCase, WorstCriterion,
};
pub use trend::{AngleEffect, LoadStep, ParticipantShape, ParticipantStep};
pub use warning::{MissingMeasurements, PanelWarning};

use std::collections::BTreeMap;
use std::fmt;

use serde::{Deserialize, Serialize};

use crate::number::rounded;
use crate::quantity::{Degrees, Newtons, Quantity};
use crate::transfer::{BundleAverage, TransferError, TransferFunction, average};
use crate::warning::{Warning, Warnings};

/// Loads and angles that differ by less than this count as equal.
const SAME: f64 = 1e-9;

/// A load and an angle at which people are measured.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Cell {
    /// The normal force, N.
    pub load_n: Newtons,
    /// The angle between finger and surface.
    pub angle_deg: Degrees,
}

impl Cell {
    /// Whether two cells are one.
    #[must_use]
    pub fn is(self, other: Self) -> bool {
        (self.load_n.0 - other.load_n.0).abs() < SAME
            && (self.angle_deg.0 - other.angle_deg.0).abs() < SAME
    }
}

impl fmt::Display for Cell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}°, {}", self.angle_deg.0, self.load_n)
    }
}

/// The key of a transfer function in a panel: participant, load and angle, placement and repeat.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Filing {
    /// The participant's pseudonym.
    pub participant: String,
    /// Load and angle.
    #[serde(flatten)]
    pub cell: Cell,
    /// The number of the placement of the finger, from 1.
    pub placement: u32,
    /// Which measurement of that placement, from 1.
    pub repeat: u32,
}

impl Filing {
    /// Whether two are the same measurement.
    #[must_use]
    pub fn is(&self, other: &Self) -> bool {
        self.participant == other.participant
            && self.cell.is(other.cell)
            && (self.placement, self.repeat) == (other.placement, other.repeat)
    }
}

impl fmt::Display for Filing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "participant {} at {}, placement {}, repeat {}",
            self.participant, self.cell, self.placement, self.repeat
        )
    }
}

/// One measured transfer function of a panel, with its filing.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry<I: Quantity, O: Quantity> {
    /// Participant, load and angle, placement and repeat.
    pub filing: Filing,
    pub function: TransferFunction<I, O>,
}

/// Transfer functions of participants × loads × angles × repeats, from `I` to `O`, that belong together: one axis of
/// lines, one rate, one device.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel<I: Quantity, O: Quantity> {
    entries: Vec<Entry<I, O>>,
    participants: Vec<String>,
    cells: Vec<Cell>,
    /// Participants who may be one person.
    same_people: Vec<SameResponse>,
    /// What a person should know before relying on it.
    pub warnings: Warnings,
}

impl<I: Quantity, O: Quantity> Panel<I, O> {
    /// The panel of `entries`. Cells that a participant lacks, twins of several seeds, and measurements whose
    /// provenance names somebody else come back as warnings.
    ///
    /// # Errors
    /// [`PanelError`] naming what does not belong together: no entry, lines, rates, devices, estimators or kinds of bench
    /// that differ, an unknown or impossible condition, one that is not what the entry is filed under, the same
    /// measurement twice.
    pub fn new(entries: Vec<Entry<I, O>>) -> Result<Self, PanelError> {
        let first = entries.first().ok_or(PanelError::Nothing)?;
        for (i, entry) in entries.iter().enumerate() {
            together::belongs(entry)?;
            together::fits(first, entry, &entries[..i])?;
            if let Some(other) = entries[..i].iter().find(|e| e.filing.is(&entry.filing)) {
                return Err(PanelError::Twice {
                    filing: other.filing.clone(),
                });
            }
        }
        together::distinct(&entries)?;
        together::require_distinct_people(&entries)?;
        let same_people = same_person::same_people(&entries);
        let mut participants: Vec<String> = entries
            .iter()
            .map(|e| e.filing.participant.clone())
            .collect();
        participants.sort();
        participants.dedup();
        let mut cells: Vec<Cell> = Vec::new();
        for entry in &entries {
            if !cells.iter().any(|cell| cell.is(entry.filing.cell)) {
                cells.push(entry.filing.cell);
            }
        }
        cells.sort_by(|a, b| {
            let angles = a.angle_deg.0.total_cmp(&b.angle_deg.0);
            angles.then(a.load_n.0.total_cmp(&b.load_n.0))
        });
        let mut panel = Self {
            entries,
            participants,
            cells,
            same_people,
            warnings: Warnings::new(),
        };
        panel.warnings.extend(panel.of_same_people());
        panel.warnings.extend(panel.incomplete());
        panel.warnings.extend(panel.of_several_twins());
        Ok(panel)
    }

    /// All transfer functions, in the order they were given.
    #[must_use]
    pub fn entries(&self) -> &[Entry<I, O>] {
        &self.entries
    }

    /// Participants whose responses are the same but for a constant gain and noise.
    #[must_use]
    pub fn same_people(&self) -> &[SameResponse] {
        &self.same_people
    }

    /// The participants' pseudonyms, sorted.
    #[must_use]
    pub fn participants(&self) -> &[String] {
        &self.participants
    }

    /// The cells that somebody was measured in, by angle and then by load.
    #[must_use]
    pub fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// The loads, lightest first, in N.
    #[must_use]
    pub fn loads_n(&self) -> Vec<f64> {
        sorted(self.cells.iter().map(|cell| cell.load_n.0))
    }

    /// The angles, flattest first, in degrees.
    #[must_use]
    pub fn angles_deg(&self) -> Vec<f64> {
        sorted(self.cells.iter().map(|cell| cell.angle_deg.0))
    }

    /// The measurements of one participant in one cell.
    pub fn of<'a>(
        &'a self,
        participant: &'a str,
        cell: Cell,
    ) -> impl Iterator<Item = &'a Entry<I, O>> {
        self.entries
            .iter()
            .filter(move |e| e.filing.participant == participant && e.filing.cell.is(cell))
    }

    /// The participants who were measured in every cell.
    #[must_use]
    pub fn complete(&self) -> Vec<&str> {
        let everywhere = |who: &&str| self.cells.iter().all(|c| self.of(who, *c).next().is_some());
        let people = self.participants.iter().map(String::as_str);
        people.filter(everywhere).collect()
    }

    /// The measurements of one participant in one cell, by the number of the placement.
    fn placements<'a>(
        &'a self,
        participant: &'a str,
        cell: Cell,
    ) -> BTreeMap<u32, Vec<&'a TransferFunction<I, O>>> {
        let mut placements = BTreeMap::<u32, Vec<_>>::new();
        for entry in self.of(participant, cell) {
            let repeats = placements.entry(entry.filing.placement).or_default();
            repeats.push(&entry.function);
        }
        placements
    }

    /// The transfer function of one participant in one cell: the average of the repeats of each placement, and of the
    /// placements; `None` when there is none.
    ///
    /// # Errors
    /// Those of [`average`].
    pub fn person(
        &self,
        participant: &str,
        cell: Cell,
        averaging: BundleAverage,
    ) -> Result<Option<TransferFunction<I, O>>, TransferError> {
        let placements = self.placements(participant, cell);
        if placements.is_empty() {
            return Ok(None);
        }
        let placements = placements.values().map(|own| average(own, averaging));
        let placements: Vec<_> = placements.collect::<Result<_, _>>()?;
        let all: Vec<&TransferFunction<I, O>> = placements.iter().collect();
        let mut own = average(&all, averaging)?;
        own.about.condition.participant = Some(participant.to_owned());
        Ok(Some(own))
    }

    fn incomplete(&self) -> Option<Warning> {
        let missing: Vec<String> = self
            .participants
            .iter()
            .flat_map(|who| self.cells.iter().map(move |cell| (who, *cell)))
            .filter(|(who, cell)| self.of(who, *cell).next().is_none())
            .map(|(who, cell)| format!("{who} at {cell}"))
            .collect();
        (!missing.is_empty()).then(|| {
            Warning::from(PanelWarning::IncompletePanel {
                what: MissingMeasurements::Cells {
                    missing,
                    complete: self.complete().len(),
                    participants: self.participants.len(),
                },
            })
        })
    }
}

fn sorted(values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.dedup_by(|a, b| (*a - *b).abs() < SAME);
    values
}

/// Why transfer functions cannot form a panel.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PanelError {
    /// There is none.
    #[error("there are no transfer functions of participants: measure or add some")]
    Nothing,
    /// Two people under one name: participants of twins of different seeds.
    #[error("{} is {one_is} in {one}, but {other_is} in {other}: give each person one name, or use separate panels",
        .one.participant
    )]
    TwoPeople {
        one: Box<Filing>,
        one_is: String,
        other: Box<Filing>,
        other_is: String,
    },
    /// Nobody was measured twice in a cell.
    #[error(
        "no participant was measured more than once at a load and angle, so the variation between placements is not known: measure a few participants with the finger repositioned"
    )]
    NothingRepeated,
    /// A name, load, angle or number that no measurement has.
    #[error("expected the {what} of {filing} as {expected}, found {found}; correct it")]
    Impossible {
        filing: Filing,
        what: &'static str,
        /// What it may be.
        expected: &'static str,
        found: String,
    },
    /// One measurement under two names.
    #[error("{one} and {other} have a bit-identical response: remove one of them")]
    Same { one: String, other: String },
    /// One measurement under two names, on two axes.
    #[error(
        "{one} and {other} have the same response, on other lines: two measurements never are the same; remove one of them"
    )]
    Resampled { one: String, other: String },
    /// Transfer functions that cancel in the complex mean.
    #[error("cannot average participants: {what}")]
    Opposite {
        /// Whose sign is opposite.
        what: String,
    },
    /// A transfer function that does not say who touched how.
    #[error(
        "expected the {what} of the transfer function filed as {filing}, found no statement of it; state it"
    )]
    Unknown {
        filing: Filing,
        /// Participant, load or angle.
        what: &'static str,
    },
    /// A transfer function of somebody else.
    #[error(
        "cannot mix participants: the transfer function filed as {filing} is of participant {found}; file it under {found}"
    )]
    Mixed { filing: Filing, found: String },
    /// A transfer function of another load or angle.
    #[error(
        "cannot file a transfer function as {filing}: it was measured at {found}; file it under this load and angle"
    )]
    Misfiled {
        filing: Filing,
        /// Its own load and angle.
        found: String,
    },
    /// Two that cannot be combined.
    #[error(
        "cannot combine transfer functions of different {what}: {one} has {one_has}, {other} has {other_has}; measure and \
            estimate them in the same way"
    )]
    Differ {
        /// Lines, rate or device.
        what: &'static str,
        one: String,
        one_has: String,
        other: String,
        other_has: String,
    },
    /// The same measurement twice.
    #[error("{filing} is there twice: give one another repeat number")]
    Twice { filing: Filing },
    /// A line without a level.
    #[error(
        "cannot compare levels: the transfer function of participant {participant} at {cell} is 0 at {at_hz:.1} Hz, which is \
            not a valid measurement; narrow the band to the measured part"
    )]
    NoResponse {
        participant: String,
        /// At which load and angle.
        cell: String,
        /// At which line, Hz.
        at_hz: f64,
    },
    /// No line lies in the band.
    #[error("no line of the transfer functions lies within {band}: widen the band")]
    Empty { band: crate::quantity::Band },
    /// Fewer people than a comparison needs.
    #[error(
        "expected at least {expected} participants at {cell}, found {found}; measure more participants"
    )]
    Few {
        cell: String,
        expected: usize,
        found: usize,
    },
    /// Transfer functions that cannot be averaged, or what is left of one.
    #[error(transparent)]
    Transfer(#[from] TransferError),
    /// Nothing narrow is in the control.
    #[error("the control measurement has no dip of {least_db} dB in {band}: check that it was made without a finger, or leave it out",
        least_db = rounded(*least_db)
    )]
    NoDip {
        /// Where it was looked for.
        band: crate::quantity::Band,
        /// How deep it would have to be, dB.
        least_db: f64,
    },
    /// Different frequency axes.
    #[error(
        "cannot compensate the dip of the control: the control has {control}, the transfer function {function}; estimate both \
            with the same rate and segment length"
    )]
    ControlLines {
        control: String,
        /// Of the transfer function.
        function: String,
    },
}

#[cfg(test)]
mod belonging;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod verdicts;
