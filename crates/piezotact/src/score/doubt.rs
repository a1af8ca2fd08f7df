//! What a score leaves open.

use std::fmt;

use crate::doubt::{Advice, DoubtKind, Subject, doubts};

doubts! {
    /// What a score of two vibrations leaves open.
    pub enum ScoreDoubt {
        /// Two textures swell and fade differently, which spectra do not show.
        OtherModulation("other_modulation") {
            /// The spread of short-time levels of the reference, dB.
            reference_db: f64,
            /// That of the other, dB.
            test_db: f64,
        },
        /// A vibration below what can be felt.
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
            why: String,
        },
        /// Waveforms that were not compared.
        WaveformNotCompared("waveform_not_compared") {
            /// Why.
            why: String,
        },
    }
}

impl DoubtKind for ScoreDoubt {
    fn of(doubt: &crate::Doubt) -> Option<Self> {
        Self::of_doubt(doubt)
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

impl fmt::Display for ScoreDoubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::OtherModulation {
                reference_db,
                test_db,
            } => write!(
                f,
                "short-time levels spread by {reference_db:.1} dB in the reference and {test_db:.1} dB in the other: one changes its level, or bursts, more than the other, which spectra and the score do not show"
            ),
            Self::NotFelt { what, level_db } => write!(
                f,
                "{what} lies {:.1} dB below the detection threshold: it is not felt",
                -level_db
            ),
            Self::NoRealIndex { temporal } => write!(
                f,
                "ST-SIM has no value: the temporal similarity is {temporal:.3}, and a negative number has no real power 2/3 (vibromaf 0.0.8 gives a complex one)"
            ),
            Self::IndexBeyondRange { value } => write!(
                f,
                "ST-SIM is {value:.3}, above its range of 0 to 1: the published formula says nothing where the test excites more than the reference"
            ),
            Self::NoIndices { why } => write!(f, "ST-SIM and SPQI are left out: {why}"),
            Self::WaveformNotCompared { why } => write!(f, "the waveforms are not compared: {why}"),
        }
    }
}
