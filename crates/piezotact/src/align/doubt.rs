//! Doubts about the place of a recording in a drive.

use std::fmt;

use crate::doubt::{Advice, DoubtKind, doubts};
use crate::number::{digits, rounded};

doubts! {
    /// Doubts about the place of a recording in a drive.
    pub enum AlignDoubt {
        /// A part of the drive was not recorded.
        PartCovered("align_part_covered") {
            /// The first time of the drive that was recorded, s.
            from_s: f64,
            /// The last one, s.
            to_s: f64,
            /// The length of the drive, s.
            length_s: f64,
        },
        /// The times are less certain than a tenth of a millisecond.
        Uncertain("align_uncertain") {
            /// Half the largest 95 % interval, s.
            uncertainty_s: f64,
            /// Of how many blocks.
            blocks: usize,
        },
        /// Many blocks do not lie on the line.
        ManyLeftOut("align_many_blocks_left_out") {
            /// How many.
            left_out: usize,
            /// Of how many.
            of: usize,
        },
        /// The drift is near the largest one that was looked for.
        DriftAtLimit("align_drift_at_limit") {
            /// The drift, ppm.
            drift_ppm: f64,
            /// The largest one, ppm.
            most_ppm: f64,
        },
    }
}

impl DoubtKind for AlignDoubt {
    fn of(doubt: &crate::Doubt) -> Option<Self> {
        Self::of_doubt(doubt)
    }

    fn advice(&self) -> Vec<Advice> {
        match self {
            Self::Uncertain { .. } => vec![Advice::RecordLonger],
            Self::ManyLeftOut { .. } => vec![Advice::RecordAgain],
            Self::PartCovered { .. } | Self::DriftAtLimit { .. } => Vec::new(),
        }
    }
}

impl fmt::Display for AlignDoubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::PartCovered {
                from_s,
                to_s,
                length_s,
            } => write!(
                f,
                "the recording holds {from_s:.3} s to {to_s:.3} s of a drive of {length_s:.3} s: what lies outside was not recorded"
            ),
            Self::Uncertain {
                uncertainty_s,
                blocks,
            } => write!(
                f,
                "times are certain to ±{} ms (95 %, {blocks} blocks), which is more than 0.1 ms",
                digits(1e3 * uncertainty_s)
            ),
            Self::ManyLeftOut { left_out, of } => write!(
                f,
                "{left_out} of {of} blocks do not lie on one line and were left out: samples may be missing in the recording, or its clock jumped"
            ),
            Self::DriftAtLimit {
                drift_ppm,
                most_ppm,
            } => write!(
                f,
                "the drift of {drift_ppm:+.1} ppm is near {} ppm, the largest that was looked for: state a larger one",
                rounded(*most_ppm)
            ),
        }
    }
}
