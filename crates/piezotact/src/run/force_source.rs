//! Warnings about a force that another device measures, and its place in time.

use crate::number::{counted, digits, rounded};
use serde::{Deserialize, Serialize};

/// Warnings about a force that another device measures: what it sent, and when that was.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum ForceSourceWarning {
    /// Many of its lines could not be read.
    #[error(
        "{unreadable} of {lines} lines of {signal} could not be read, such as `{example}`; their readings are missing: check its cable and its range"
    )]
    #[serde(rename = "force_lines_unreadable")]
    LinesUnreadable {
        signal: String,
        unreadable: usize,
        lines: usize,
        example: String,
    },
    /// When the force was measured is less certain than force and acceleration need.
    #[error(
        "the time of each force reading is known to ±{} ms only, which is more than {} ms: force and acceleration may be out of step; close other \
            programs; measure again",
        digits(1e3 * uncertainty_s),
        rounded(1e3 * most_s)
    )]
    #[serde(rename = "force_clock_uncertain")]
    ClockUncertain { uncertainty_s: f64, most_s: f64 },
    /// Readings are missing over some time; straight lines stand in their place.
    #[error(
        "the force has no readings in {} longer than {} s, {} s together and {} s at the longest; it was interpolated linearly: close other \
            programs; measure again",
        counted(*gaps, "gap"),
        rounded(*longer_than_s),
        digits(*total_s),
        digits(*longest_s)
    )]
    #[serde(rename = "force_gaps_interpolated")]
    GapsInterpolated {
        gaps: usize,
        longest_s: f64,
        total_s: f64,
        longer_than_s: f64,
    },
    /// The file of the force began again while it was followed.
    #[error(
        "{file} was emptied or replaced, or its time began again, {} while it was followed: the zero of the force may have changed; check the zero \
            of the force cell, and any weight on it",
        counted(*times, "time")
    )]
    #[serde(rename = "force_file_began_again")]
    FileBeganAgain { file: String, times: usize },
}
