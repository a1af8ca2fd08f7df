//! Warnings about the distinguishability of vibrations.

use serde::{Deserialize, Serialize};

/// One thing to know before relying on a difference in JND.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum DiscriminationWarning {
    /// Thresholds of skin displacement are applied to the acceleration of a nail.
    #[error(
        "detection thresholds and JND are for skin displacement under a large contactor; they are applied to the measured acceleration, assuming \
            that the skin moves with the nail; published thresholds differ by 15 to 35 dB at 250 Hz: give a nail-to-skin map if one was measured"
    )]
    ThresholdsOfSkin,
    /// A nail-to-skin map that was not measured over all of the band.
    #[error(
        "the nail-to-skin map was measured from {:.0} to {:.0} Hz: outside this range, its first or last value is used; give a nail-to-skin map if \
            one was measured",
        measured_hz[0],
        measured_hz[1]
    )]
    ContactMapEnds { measured_hz: [f64; 2] },
}
