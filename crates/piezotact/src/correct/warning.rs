//! Warnings about a closed loop.

use crate::number::{digits, rounded};
use crate::warning::Warning;
use serde::{Deserialize, Serialize};

/// Warnings about a closed loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum LoopWarning {
    /// A closed loop got worse and was stopped.
    #[error(
        "the closed loop ended early ({why}): the device or the finger may have changed; the drive is from iteration {best}; characterise again"
    )]
    LoopStopped { best: usize, why: LoopStop },
    /// A loop ended further from its target than the limit.
    #[error(
        "the best drive of the loop has an error of {error_db_rms:.1} dB rms (limit {limit_db} dB): the device may not respond over the whole band; \
            check the lines in the report; characterise again",
        limit_db = rounded(*limit_db)
    )]
    TargetMissed { error_db_rms: f64, limit_db: f64 },
    /// The crests of a drive were limited, which changed its waveform.
    #[error(
        "the peaks of the drive were limited so that it fits (correlation {correlation:.2} with the requested drive): the spectrum is kept, but \
            sudden bursts are weaker; lower the level"
    )]
    CrestsPressed { correlation: f64 },
}

/// Why a closed loop was stopped.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum LoopStop {
    /// It got clearly worse.
    #[error("stopped: the error became clearly larger")]
    GotWorse,
    /// A measurement was not reliable.
    #[error("a measurement was invalid: {cause}")]
    NotBelieved { cause: Warning },
    /// The confirmation measurement of the drive that was kept failed.
    #[error("the confirmation measurement of the kept drive failed: {cause}")]
    NotConfirmed { cause: Warning },
    /// A cause in words.
    #[error("{text}")]
    Said { text: String },
}

/// What can be wrong with one measurement of a closed loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum MeasurementFaultWarning {
    /// A measurement of a closed loop failed.
    #[error("{fault}")]
    #[serde(rename = "measurement_failed")]
    Failed {
        #[serde(flatten)]
        fault: MeasurementFault,
    },
}

/// What can be wrong with one measurement of a closed loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "fault", rename_all = "snake_case")]
pub enum MeasurementFault {
    /// The bench failed.
    #[error("{said}")]
    Bench { said: String },
    /// The force was not held.
    #[error(
        "from {from_s:.0} s on, the mean force was {mean_n:.3} N, expected {asked_n} N ± {:.0} %: hold the finger so that the display shows this \
            force",
        share * 100.0,
        asked_n = rounded(*asked_n)
    )]
    Force {
        from_s: f64,
        mean_n: f64,
        asked_n: f64,
        share: f64,
    },
    /// The sensor clips.
    #[error(
        "{:.1} % of the samples of the response are at a limit: the sensor clips; use its larger range, or render at a lower level",
        fraction * 100.0
    )]
    SensorClips { fraction: f64 },
    /// The response is no louder than its noise.
    #[error(
        "the response ({} m/s² rms) is less than twice its noise ({}): the finger lifted, the sensor came off, the amplifier is off, or the level is too low; check them",
        digits(*rms_m_s2),
        digits(*noise_m_s2)
    )]
    ResponseFaint { rms_m_s2: f64, noise_m_s2: f64 },
    /// No correction could be computed from this measurement.
    #[error("{said}")]
    Correction { said: String },
}
