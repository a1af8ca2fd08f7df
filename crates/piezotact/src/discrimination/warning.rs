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
    /// All strokes of a sample come from one recording.
    #[error(
        "{}: all strokes are from one recording; the distance within a sample does not include the variation between placements, sessions or days; \
            record each sample several times",
        samples.join(", ")
    )]
    OneRecording { samples: Vec<String> },
    /// A sample of one stroke.
    #[error("{}: only one stroke, so the variation between strokes is not known, and nothing is decided; record 10 or more", samples.join(", "))]
    OneStroke { samples: Vec<String> },
    /// Recordings of one sample differ by more than strokes do: they, and not strokes, are what is compared.
    #[error(
        "recordings of one sample differ by more than their strokes do (p = {p_value:.3}): recordings are compared instead of strokes; record each \
            sample several times"
    )]
    RecordingsDiffer { p_value: f64 },
    /// Too few strokes or recordings for a permutation test to show anything.
    #[error(
        "with {found} {unit} of a sample, no difference can be significant at 5 % over {pairs} {}: {needed} of each are needed; record {needed} or \
            more",
        if *pairs == 1 { "pair" } else { "pairs" }
    )]
    TooFewUnits {
        unit: String,
        found: usize,
        needed: usize,
        pairs: usize,
    },
    /// Levels within a recording wander by more than noise does.
    #[error(
        "the level or the spectrum varies within a recording by more than stationary noise would: the 95 % limits are computed from the differences \
            between its parts, and later recordings may differ more; record each sample several times"
    )]
    NotStationary,
}
