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
    /// A panel in which somebody was not measured in every cell.
    #[error(
        "{complete} of {participants} participants were measured at every load and angle; missing: {}; each comparison uses only the participants \
            measured in both conditions; complete the missing measurements",
        first_of(missing, "; ")
    )]
    IncompletePanel {
        missing: Vec<String>,
        complete: usize,
        participants: usize,
    },
    /// Fewer people than a panel needs to estimate its uncertainty.
    #[error(
        "{participants} participants are too few to predict the result of another panel: the confidence in the worst case is not known; measure \
            {recommended} participants or more"
    )]
    FewPeople {
        participants: usize,
        recommended: usize,
    },
    /// A person whose transfer function is unlike everybody else's.
    #[error(
        "{participant} at {at} differs from the mean curve by {db_rms:.1} dB rms, a typical participant by {usual_db_rms:.1} dB: check that \
            measurement (sensor, placement, person); measure again"
    )]
    OddOneOut {
        participant: String,
        at: Example,
        db_rms: f64,
        usual_db_rms: f64,
    },
    /// Repeats of one person that differ as much as measurements of different people.
    #[error(
        "{what} of {participant} differ by up to {db_rms:.1} dB rms, typically by {usual_db_rms:.1} dB: they may be from different participants, or \
            the sensor became loose; check that measurement (sensor, placement, person); measure again"
    )]
    MixedRepeats {
        what: String,
        participant: String,
        db_rms: f64,
        usual_db_rms: f64,
    },
    /// A measurement whose sign is opposite to most others' of the same load and angle.
    #[error(
        "{measurement} has the opposite sign to {count} of the {of} others at this load and angle, such as {such_as}: one of its channels may be \
            inverted; invert that channel and add the measurement again"
    )]
    OppositeSign {
        measurement: String,
        count: usize,
        of: usize,
        such_as: Example,
    },
    /// A measurement whose provenance names another participant.
    #[error(
        "{measurement} comes from a measurement of participant {found}: check whose it is, and file it under {found}"
    )]
    OtherParticipant { measurement: String, found: Example },
    /// Measurements of digital twins of different seeds.
    #[error(
        "the measurements are of digital twins of different seeds: {one} is of seed {one_seed}, {other} is of seed {other_seed}; keep them in \
            separate panels"
    )]
    SeveralTwins {
        one: String,
        one_seed: String,
        other: String,
        other_seed: String,
    },
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
        "the average of {participants} participants: for a participant who is not in it, its error is {penalty_db_rms:.1} dB rms{}, for {worst} \
            {worst_db_rms:.1} dB; characterise the participant if this error is too large",
        interval_db_rms.map_or_else(String::new, |[low, high]| format!(" (95 %: {low:.1} to {high:.1})"))
    )]
    Averaged {
        participants: usize,
        penalty_db_rms: f64,
        interval_db_rms: Option<[f64; 2]>,
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
    /// Transfer functions in the folder of a panel that its index does not list.
    #[error(
        "the folder contains transfer functions that panel.json does not list; they are left out: {}; run the campaign again to continue it",
        first_of(files, ", ")
    )]
    NotListed { files: Vec<String> },
    /// Measurements that a panel plans and lacks.
    #[error(
        "{count} planned measurements are missing, the first is {first}: run the campaign again to continue it"
    )]
    NotMeasured { count: usize, first: String },
}
