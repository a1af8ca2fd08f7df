//! What a score leaves open.

use std::fmt;

use super::literature::LiteratureError;
use crate::quantity::Band;
use crate::verify::VerifyError;
use crate::warning::{Advice, Subject, WarningKind, causes, warnings};

warnings! {
    /// What a score of two vibrations leaves open.
    pub enum ScoreWarning {
        /// The short-time levels of two textures vary differently, which spectra do not show.
        OtherModulation("other_modulation") {
            /// The spread of short-time levels of the reference, dB.
            reference_db: f64,
            /// That of the other, dB.
            test_db: f64,
        },
        /// A vibration below the detection threshold.
        NotFelt("not_felt") of Signal(what) {
            /// Which.
            what: String,
            /// Its excitation re the detection threshold, dB.
            level_db: f64,
        },
        /// An index of the literature that is not a real number for these signals.
        NoRealIndex("no_real_index") {
            /// The temporal similarity, below zero.
            temporal: f64,
        },
        /// An index of the literature above its range.
        IndexBeyondRange("index_beyond_range") {
            /// ST-SIM.
            value: f64,
        },
        /// The indices of the literature could not be computed.
        NoIndices("no_indices") {
            /// Why.
            why: NoIndicesCause,
        },
        /// Waveforms that were not compared.
        WaveformNotCompared("waveform_not_compared") {
            /// Why.
            why: NotComparedCause,
        },
    }
}

causes! {
    /// Why the indices of the literature could not be computed.
    pub enum NoIndicesCause {
        /// There is not one block.
        TooShort("too_short") {
            /// Samples of a block.
            expected: usize,
            /// Samples that both have.
            found: usize,
        },
        /// No full scale.
        FullScale("full_scale") {
            /// What was given, m/s².
            found_m_s2: f64,
        },
        /// A cause in words, as of a rate that cannot be brought to 8 kHz.
        Said("said") {
            /// What was said.
            text: String,
        },
    }
}

causes! {
    /// Why waveforms were not compared.
    pub enum NotComparedCause {
        /// The rates differ.
        Rates("rates_differ") {
            /// The reference's rate, Hz.
            target_hz: f64,
            /// The other's, Hz.
            measured_hz: f64,
        },
        /// The band holds no line of the spectra.
        NoLine("no_line") {
            /// The band.
            band: Band,
            /// The step between lines, Hz.
            resolution_hz: f64,
        },
        /// Too little in common.
        TooShort("too_short") {
            /// Samples of a segment.
            expected: usize,
            /// Samples that they share.
            found: usize,
        },
        /// A cause in words, as of a rate that cannot be converted.
        Said("said") {
            /// What was said.
            text: String,
        },
    }
}

impl From<LiteratureError> for NoIndicesCause {
    fn from(error: LiteratureError) -> Self {
        match error {
            LiteratureError::TooShort { expected, found } => Self::TooShort { expected, found },
            LiteratureError::FullScale { found } => Self::FullScale { found_m_s2: found },
            other @ LiteratureError::Rate(_) => Self::Said {
                text: other.to_string(),
            },
        }
    }
}

impl fmt::Display for NoIndicesCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let error = match self {
            Self::TooShort { expected, found } => LiteratureError::TooShort {
                expected: *expected,
                found: *found,
            },
            Self::FullScale { found_m_s2 } => LiteratureError::FullScale { found: *found_m_s2 },
            Self::Said { text } => return f.write_str(text),
        };
        error.fmt(f)
    }
}

impl From<VerifyError> for NotComparedCause {
    fn from(error: VerifyError) -> Self {
        match error {
            VerifyError::Rate {
                target_hz,
                measured_hz,
            } => Self::Rates {
                target_hz,
                measured_hz,
            },
            VerifyError::NoLine {
                band,
                resolution_hz,
            } => Self::NoLine {
                band,
                resolution_hz,
            },
            VerifyError::TooShort { expected, found } => Self::TooShort { expected, found },
            other => Self::Said {
                text: other.to_string(),
            },
        }
    }
}

impl fmt::Display for NotComparedCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let error = match self {
            Self::Rates {
                target_hz,
                measured_hz,
            } => VerifyError::Rate {
                target_hz: *target_hz,
                measured_hz: *measured_hz,
            },
            Self::NoLine {
                band,
                resolution_hz,
            } => VerifyError::NoLine {
                band: *band,
                resolution_hz: *resolution_hz,
            },
            Self::TooShort { expected, found } => VerifyError::TooShort {
                expected: *expected,
                found: *found,
            },
            Self::Said { text } => return f.write_str(text),
        };
        error.fmt(f)
    }
}

impl WarningKind for ScoreWarning {
    fn of(warning: &crate::Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        match self {
            Self::OtherModulation { .. } => vec![Advice::CompareByHand],
            Self::NotFelt { .. } => vec![Advice::Check(Subject::UnitAndScale), Advice::RaiseLevel],
            Self::NoRealIndex { .. } => vec![Advice::UseScore],
            Self::IndexBeyondRange { .. } => {
                vec![Advice::ExchangeReferenceAndTest, Advice::UseScore]
            }
            Self::NoIndices { .. } | Self::WaveformNotCompared { .. } => Vec::new(),
        }
    }
}

impl fmt::Display for ScoreWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OtherModulation {
                reference_db,
                test_db,
            } => write!(
                f,
                "the spread of short-time levels is {reference_db:.1} dB in the reference and {test_db:.1} dB in the test: the \
                    level of one varies more over time, or has more bursts; spectra and the score do not show this"
            ),
            Self::NotFelt { what, level_db } => write!(
                f,
                "{what} is {:.1} dB below the detection threshold: it is not felt",
                -level_db
            ),
            Self::NoRealIndex { temporal } => write!(
                f,
                "ST-SIM has no value: the temporal similarity is {temporal:.3}, and a negative number has no real power 2/3 (vibromaf 0.0.8 gives a complex one)"
            ),
            Self::IndexBeyondRange { value } => write!(
                f,
                "ST-SIM is {value:.3}, above its range of 0 to 1: the published formula does not cover a test that excites more \
                    than the reference"
            ),
            Self::NoIndices { why } => write!(f, "ST-SIM and SPQI are left out: {why}"),
            Self::WaveformNotCompared { why } => write!(f, "the waveforms are not compared: {why}"),
        }
    }
}
