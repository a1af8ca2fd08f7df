//! What a closed loop leaves open.

use std::fmt;

use crate::doubt::words::{bands as list, percent};
use crate::doubt::{Advice, DoubtKind, Subject, doubts};
use crate::quantity::Band;

doubts! {
    /// What a closed loop leaves open.
    pub enum LoopDoubt {
        /// A closed loop got worse and was stopped.
        LoopStopped("loop_stopped") {
            /// The iteration that was best.
            best: usize,
            /// Why it was stopped.
            why: String,
        },
        /// A loop ended further from its target than the limit.
        TargetMissed("target_missed") {
            /// The rms error of the spectrum that is left, dB.
            error_db_rms: f64,
            /// The limit, dB.
            limit_db: f64,
        },
        /// Lines of the target that the sensor's noise hides.
        TargetInNoise("target_in_noise") {
            /// Their share of the band's lines, 0–1.
            share: f64,
            /// The bands in which they lie.
            bands: Vec<Band>,
        },
        /// The crests of a drive were limited, and its waveform changed with them.
        CrestsPressed("crests_pressed") {
            /// The correlation with the drive as it was asked for.
            correlation: f64,
        },
    }
}

impl DoubtKind for LoopDoubt {
    fn of(doubt: &crate::Doubt) -> Option<Self> {
        Self::of_doubt(doubt)
    }

    fn advice(&self) -> Vec<Advice> {
        match self {
            Self::LoopStopped { .. } => vec![Advice::CharacteriseAgain],
            Self::TargetMissed { .. } => {
                vec![Advice::Check(Subject::Lines), Advice::CharacteriseAgain]
            }
            Self::TargetInNoise { .. } => vec![Advice::RaiseLevel, Advice::QuieterSensor],
            Self::CrestsPressed { .. } => vec![Advice::LowerLevel { to_db: None }],
        }
    }
}

impl fmt::Display for LoopDoubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LoopStopped { best, why } => write!(
                f,
                "the closed loop ended early ({why}); the drive is that of iteration {best}: the device or the finger may have changed"
            ),
            Self::TargetMissed {
                error_db_rms,
                limit_db,
            } => write!(
                f,
                "the best drive of the loop misses its target by {error_db_rms:.1} dB rms (limit {limit_db} dB): the device may not respond in all of the band"
            ),
            Self::TargetInNoise { share, bands } => write!(
                f,
                "the target's lines in {} of the band ({}) are so soft there that the sensor's noise hides them: much of the error is the noise's, and little of it can be corrected",
                percent(*share),
                list(bands)
            ),
            Self::CrestsPressed { correlation } => write!(
                f,
                "so that the drive fits, its crests were limited (correlation {correlation:.2} with the drive asked for): the spectrum is kept, sudden bursts are softer"
            ),
        }
    }
}
