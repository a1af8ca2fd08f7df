//! Warnings about a force that another device measures, and its place in time.

use std::fmt;

use crate::number::{counted, digits, rounded};
use crate::warning::{Advice, Subject, WarningKind, warnings};

warnings! {
    /// Warnings about a force that another device measures: what it sent, and when that was.
    pub enum ForceSourceWarning {
        /// Many of its lines could not be read.
        LinesUnreadable("force_lines_unreadable") of Signal(source) {
            /// The source.
            source: String,
            /// How many.
            unreadable: usize,
            /// Of how many lines.
            lines: usize,
            /// One of them.
            example: String,
        },
        /// When the force was measured is less certain than force and acceleration need.
        ClockUncertain("force_clock_uncertain") {
            /// How far times may be off, s.
            uncertainty_s: f64,
            /// The largest uncertainty without a warning, s.
            most_s: f64,
        },
        /// Readings are missing over some time; straight lines stand in their place.
        GapsInterpolated("force_gaps_interpolated") {
            /// How many gaps.
            gaps: usize,
            /// The longest, s.
            longest_s: f64,
            /// Together, s.
            total_s: f64,
            /// From which length on a gap counts, s.
            longer_than_s: f64,
        },
        /// The file of the force began again while it was followed.
        FileBeganAgain("force_file_began_again") of File(file) {
            /// The file.
            file: String,
            /// How often.
            times: usize,
        },
    }
}

impl WarningKind for ForceSourceWarning {
    fn of(warning: &crate::Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        match self {
            Self::LinesUnreadable { .. } => vec![Advice::Check(Subject::CableAndRange)],
            Self::ClockUncertain { .. } | Self::GapsInterpolated { .. } => {
                vec![Advice::CloseOtherPrograms, Advice::MeasureAgain]
            }
            Self::FileBeganAgain { .. } => vec![Advice::Check(Subject::ForceCell)],
        }
    }
}

impl fmt::Display for ForceSourceWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::LinesUnreadable {
                source,
                unreadable,
                lines,
                example,
            } => write!(
                f,
                "{unreadable} of {lines} lines of {source} could not be read, such as `{example}`; their readings are missing"
            ),
            Self::ClockUncertain {
                uncertainty_s,
                most_s,
            } => write!(
                f,
                "the time of each force reading is known to ±{} ms only, which is more than {} ms: force and acceleration may be out of step",
                digits(1e3 * uncertainty_s),
                rounded(1e3 * most_s)
            ),
            Self::GapsInterpolated {
                gaps,
                longest_s,
                total_s,
                longer_than_s,
            } => write!(
                f,
                "the force has no readings in {} longer than {} s, {} s together and {} s at the longest; it was interpolated \
                    linearly",
                counted(*gaps, "gap"),
                rounded(*longer_than_s),
                digits(*total_s),
                digits(*longest_s)
            ),
            Self::FileBeganAgain { file, times } => write!(
                f,
                "{file} was emptied or replaced, or its time began again, {} while it was followed: the zero of the force may have \
                    changed",
                counted(*times, "time")
            ),
        }
    }
}
