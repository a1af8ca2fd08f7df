//! Warnings about the place of a recording in a drive.

use crate::number::{counted, digits, digits_signed, rounded};
use serde::{Deserialize, Serialize};

/// Warnings about the place of a recording in a drive.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum AlignWarning {
    /// Times of the drive in a recording that are uncertain.
    #[error("{fault}; {}", fault.advice())]
    #[serde(rename = "align_doubtful")]
    Doubtful {
        #[serde(flatten)]
        fault: AlignFault,
    },
}

/// What makes times of an alignment uncertain.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "fault", rename_all = "snake_case")]
pub enum AlignFault {
    /// The times are less certain than a tenth of a millisecond.
    #[error(
        "times are certain to ±{} ms (95 %, {}), which is more than 0.1 ms",
        digits(1e3 * uncertainty_s),
        match blocks {
        0 => "bursts".to_owned(),
        blocks => counted(*blocks, "block"),
        }
    )]
    Uncertain { uncertainty_s: f64, blocks: usize },
    /// The places of blocks step from one line to another.
    #[error(
        "at {at_s:.2} s of the recording its times step by {} ms: samples are missing or doubled there, or the clock jumped; times are off by up to \
            this much, and the intervals were widened by it",
        digits_signed(1e3 * by_s)
    )]
    Step { at_s: f64, by_s: f64 },
    /// The places of blocks scatter more about the line than noise explains.
    #[error(
        "blocks lie {} ms (SD) from their line, up to {} ms, and noise explains {} ms: single samples may be missing, which look like a drift, or \
            the clock runs unevenly; the intervals were widened",
        digits(1e3 * spread_s),
        digits(1e3 * largest_s),
        digits(1e3 * expected_s)
    )]
    Scatter {
        spread_s: f64,
        expected_s: f64,
        largest_s: f64,
        variation_s: f64,
    },
    /// Blocks and bursts lead to other times.
    #[error(
        "blocks of the recording and the bursts lead to times that differ by {} ms: samples are missing between the bursts, or the clock jumped",
        digits(1e3 * by_s)
    )]
    BurstsApart { by_s: f64 },
    /// The phases of a drive that repeats move against the line.
    #[error(
        "where the drive repeats, its phases move by {} ms against the bursts: samples are missing between them, or the clock jumped",
        digits(1e3 * by_s)
    )]
    Uneven { by_s: f64 },
    /// Parts of the recording are not what the drive is there.
    #[error(
        "{missed} of {} between {from_s:.2} s and {to_s:.2} s of the recording do not hold what the drive is there: another drive was played, the \
            signal is below the noise, or samples are missing",
        counted(*of, "block")
    )]
    DriveNotThere {
        missed: usize,
        of: usize,
        from_s: f64,
        to_s: f64,
    },
    /// What lies between the bursts could not be compared.
    #[error(
        "the recording is too short to compare the drive between its bursts: only these say where it is"
    )]
    BetweenNotSeen,
    /// Channels of other clocks were placed as if these ran evenly with that of the channel.
    #[error(
        "{channels}: sampled by another clock, assumed to drift like that of the compared channel"
    )]
    OtherClocks { channels: String },
    /// Many blocks do not lie on the line.
    #[error(
        "{left_out} of {of} blocks do not lie on one line and were left out: samples may be missing in the recording, or its clock jumped"
    )]
    LeftOut { left_out: usize, of: usize },
    /// The drift is near the largest one that was looked for.
    #[error(
        "the drift of {drift_ppm:+.1} ppm is {} {} ppm, the largest that was looked for",
        if drift_ppm.abs() > *most_ppm { "beyond" } else { "near" },
        rounded(*most_ppm)
    )]
    DriftAtLimit { drift_ppm: f64, most_ppm: f64 },
}

impl AlignFault {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Uncertain { .. } | Self::BetweenNotSeen => "record longer",
            Self::DriftAtLimit { .. } => "allow a larger drift",
            Self::OtherClocks { .. } => "align these channels too",
            Self::Step { .. }
            | Self::Scatter { .. }
            | Self::BurstsApart { .. }
            | Self::Uneven { .. }
            | Self::DriveNotThere { .. }
            | Self::LeftOut { .. } => "record again",
        }
    }
}
