//! Warnings about the distinguishability of vibrations.

use std::fmt;

use crate::warning::{Advice, WarningKind, warnings};

warnings! {
    /// One thing to know before relying on a difference in JND.
    pub enum DiscriminationWarning {
        /// Thresholds of skin displacement are applied to the acceleration of a nail.
        ThresholdsOfSkin("thresholds_of_skin"),
        /// A nail-to-skin map that was not measured over all of the band.
        ContactMapEnds("contact_map_ends") {
            /// Where it was measured, Hz.
            measured_hz: [f64; 2],
        },
        /// All strokes of a sample come from one recording.
        OneRecording("one_recording") {
            /// The samples.
            samples: Vec<String>,
        },
        /// A sample of one stroke.
        OneStroke("one_stroke") {
            /// The samples.
            samples: Vec<String>,
        },
        /// Recordings of one sample differ by more than strokes do: they, and not strokes, are what is compared.
        RecordingsDiffer("recordings_differ") {
            /// The probability of such differences were they strokes of one recording.
            p_value: f64,
        },
        /// Too few strokes or recordings for a permutation test to show anything.
        TooFewUnits("too_few_units") {
            /// "strokes" or "recordings".
            unit: String,
            /// How many the smallest sample has.
            found: usize,
            /// How many of each sample it takes.
            needed: usize,
            /// Pairs that are compared.
            pairs: usize,
        },
        /// Levels within a recording wander by more than noise does.
        NotStationary("not_stationary"),
    }
}

impl WarningKind for DiscriminationWarning {
    fn of(warning: &crate::Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        match self {
            Self::ThresholdsOfSkin | Self::ContactMapEnds { .. } => vec![Advice::GiveContactMap],
            Self::OneRecording { .. } | Self::RecordingsDiffer { .. } => {
                vec![Advice::RecordEachSampleAgain]
            }
            Self::OneStroke { .. } => vec![Advice::RecordMore { count: 10 }],
            Self::TooFewUnits { needed, .. } => vec![Advice::RecordMore { count: *needed }],
            Self::NotStationary => vec![Advice::RecordEachSampleAgain],
        }
    }
}

impl fmt::Display for DiscriminationWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ThresholdsOfSkin => f.write_str(
                "detection thresholds and JND are for skin displacement under a large contactor; they are applied to the \
                    measured acceleration, assuming that the skin moves with the nail; published thresholds differ by 15 to 35 \
                    dB at 250 Hz",
            ),
            Self::ContactMapEnds {
                measured_hz: [low_hz, high_hz],
            } => write!(
                f,
                "the nail-to-skin map was measured from {low_hz:.0} to {high_hz:.0} Hz: outside this range, its first or last \
                    value is used"
            ),
            Self::OneRecording { samples } => write!(
                f,
                "{}: all strokes are from one recording; the distance within a sample does not include the variation between \
                    placements, sessions or days",
                samples.join(", ")
            ),
            Self::OneStroke { samples } => write!(
                f,
                "{}: only one stroke, so the variation between strokes is not known, and nothing is decided",
                samples.join(", ")
            ),
            Self::RecordingsDiffer { p_value } => write!(
                f,
                "recordings of one sample differ by more than their strokes do (p = {p_value:.3}): recordings are compared \
                    instead of strokes"
            ),
            Self::TooFewUnits {
                unit,
                found,
                needed,
                pairs,
            } => write!(
                f,
                "with {found} {unit} of a sample, no difference can be significant at 5 % over {pairs} {}: {needed} of each are \
                    needed",
                if *pairs == 1 { "pair" } else { "pairs" }
            ),
            Self::NotStationary => f.write_str(
                "the level or the spectrum varies within a recording by more than stationary noise would: the 95 % limits are \
                    computed from the differences between its parts, and later recordings may differ more",
            ),
        }
    }
}
