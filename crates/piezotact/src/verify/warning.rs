//! Warnings about a verification.

use serde::{Deserialize, Serialize};

/// Warnings about a verification.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum VerifyWarning {
    /// The measurement ends before the target does.
    #[error(
        "target and measurement overlap for {compared_s:.2} s of the {target_s:.2} s of the target: start recording before the playback and stop \
            after its end; check that they belong together"
    )]
    Cut { compared_s: f64, target_s: f64 },
    /// Noise before and after the texture that is too loud to be taken for that of the sensor.
    #[error(
        "the noise before and after the texture is {level_db:.1} dB above the detection threshold: it may be sensor noise, or a vibration of \
            amplifier and actuator that a finger feels. It is not subtracted; record the sensor at rest with the amplifier switched off, and use \
            the quieter of the two"
    )]
    NoiseCouldBeFelt { level_db: f64 },
}
