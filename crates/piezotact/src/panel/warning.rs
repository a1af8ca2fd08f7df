//! Warnings about a panel of people.

use crate::Warning;
use crate::number::rounded;
use crate::warning::Example;
use crate::warning::words::first_of;
use serde::{Deserialize, Serialize};

/// Warnings about a panel of people.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum PanelWarning {
    /// Measurements that carry warnings of their own.
    #[error(
        "{count} of {of} measurements have warnings of their own, such as {measurement}: {example}"
    )]
    OfMembers {
        count: usize,
        of: usize,
        measurement: Example,
        example: Warning,
    },
    /// A transfer function that is an average over people.
    #[error(
        "the average of {participants} participants: for a participant who is not in it, its error is {penalty_db_rms:.1} dB rms on average ({}), for \
            {worst} {worst_db_rms:.1} dB; characterise the participant if this error is too large",
        new_person_text(*new_person_db_rms)
    )]
    Averaged {
        participants: usize,
        penalty_db_rms: f64,
        new_person_db_rms: Option<[f64; 2]>,
        worst: String,
        worst_db_rms: f64,
    },
    /// A control measurement with low coherence at the artefact.
    #[error(
        "the control's coherence falls to {lowest:.2} at {at_hz:.0} Hz, below {asked}: the compensation at this frequency is partly noise; measure \
            the control longer or at a higher level",
        asked = rounded(*asked)
    )]
    ControlIncoherent { lowest: f64, at_hz: f64, asked: f64 },
    /// Two participants with one response.
    #[error(
        "{one} and {other} may be one person: their responses differ by a constant gain of {gain_db:.1} dB and by {residual_db:.2} dB rms of noise alone; \
            check who was measured, and remove one of them"
    )]
    SameResponse {
        one: String,
        other: String,
        gain_db: f64,
        residual_db: f64,
    },
    /// A panel that lacks measurements.
    #[error("{what}; {}", what.advice())]
    IncompletePanel {
        #[serde(flatten)]
        what: MissingMeasurements,
    },
}

/// The interval of the error for one new participant, or that it is withheld.
pub(super) fn new_person_text(interval_db: Option<[f64; 2]>) -> String {
    interval_db.map_or_else(
        || "too few participants for an interval".into(),
        |[low, high]| format!("95 % for one new participant: {low:.1} to {high:.1} dB"),
    )
}

/// Which measurements a panel lacks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum MissingMeasurements {
    /// Somebody was not measured in every cell.
    #[error(
        "{complete} of {participants} participants were measured at every load and angle; missing: {}; each comparison uses only the participants \
            measured in both conditions",
        first_of(missing, "; ")
    )]
    Cells {
        missing: Vec<String>,
        complete: usize,
        participants: usize,
    },
    /// Measurements that the panel plans.
    #[error("{count} planned measurements are missing, the first is {first}")]
    Planned { count: usize, first: String },
}

impl MissingMeasurements {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Cells { .. } => "complete the missing measurements",
            Self::Planned { .. } => {
                "run the same command `panel run` again: it continues the panel"
            }
        }
    }
}
