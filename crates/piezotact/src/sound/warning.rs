//! Warnings about sound devices.

use crate::number::{digits, digits_signed, rounded};
use serde::{Deserialize, Serialize};

/// Warnings about sound devices: their calibration, their timing, and what they cannot record.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum SoundWarning {
    /// A sound device whose calibration is missing, old or contradicted.
    #[error("{fault}; {}", fault.advice())]
    #[serde(rename = "sound_calibration")]
    Calibration {
        #[serde(flatten)]
        fault: CalibrationFault,
    },
}

/// What is wrong with the calibration of a sound device.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "fault", rename_all = "snake_case")]
pub enum CalibrationFault {
    /// The calibration is old, or of a day to come.
    #[error("{}", calibration_age(what, made_on, *days, *most_days))]
    Old {
        what: String,
        made_on: String,
        days: f64,
        most_days: f64,
    },
    /// The device was not calibrated: levels are relative to full scale.
    #[error("{what} was not calibrated, so that its levels are relative to full scale")]
    Missing { what: String },
    /// Two ways of finding a level lead to different values.
    #[error("{what}: {found_by} gives {} dB re {other_by}, so that one of them is wrong", digits_signed(*by_db))]
    WaysDisagree {
        what: String,
        found_by: String,
        other_by: String,
        by_db: f64,
    },
    /// The latency is not what it was when it was measured.
    #[error(
        "the latency is {} ms now and was {} ms when it was measured on {measured_on}: cables, buffers or driver changed, and it is left out",
        digits(1e3 * found_s),
        digits(1e3 * stored_s)
    )]
    LatencyChanged {
        measured_on: String,
        stored_s: f64,
        found_s: f64,
    },
    /// The pulse of an output arrived on no input alone.
    #[error("{what}")]
    WireNotFound { what: String },
}

impl CalibrationFault {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Old { days, .. } if *days < 0.0 => "check the clock of this computer",
            Self::Old { .. } | Self::Missing { .. } => "calibrate it",
            Self::WaysDisagree { .. } | Self::WireNotFound { .. } => {
                "check readings, units and cables"
            }
            Self::LatencyChanged { .. } => "measure it again",
        }
    }
}

/// How old a calibration is.
fn calibration_age(what: &str, made_on: &str, days: f64, most_days: f64) -> String {
    if days < 0.0 {
        return format!("the calibration of {what} is dated {made_on}, a day to come");
    }
    format!(
        "{what} of the sound device was calibrated on {made_on}, {} days ago, and a calibration is old after {} days",
        rounded(days),
        rounded(most_days)
    )
}
