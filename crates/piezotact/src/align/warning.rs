//! Warnings about the place of a recording in a drive.

use std::fmt;

use crate::number::{counted, digits, digits_signed, rounded};
use crate::warning::{Advice, WarningKind, warnings};

warnings! {
    /// Warnings about the place of a recording in a drive.
    pub enum AlignWarning {
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
            /// Of how many blocks; 0 where the bursts decide.
            blocks: usize,
        },
        /// The places of blocks step from one line to another.
        Step("align_step") {
            /// Where, by the clock of the recording, s.
            at_s: f64,
            /// By how much later in the drive, s.
            by_s: f64,
        },
        /// The places of blocks scatter more about the line than noise explains.
        Scatter("align_blocks_scatter") {
            /// Their standard deviation about the line, s.
            spread_s: f64,
            /// What their correlation leads to expect, s.
            expected_s: f64,
            /// The largest distance of one of them, s.
            largest_s: f64,
            /// The sum of the steps from one to the next, s.
            variation_s: f64,
        },
        /// Blocks and bursts lead to other times.
        Apart("align_blocks_and_bursts_apart") {
            /// By how much at one end of the recording, s.
            by_s: f64,
        },
        /// The phases of a drive that repeats move against the line.
        Uneven("align_uneven") {
            /// By how much, s.
            by_s: f64,
        },
        /// Parts of the recording are not what the drive is there.
        NotThere("align_drive_not_there") {
            /// How many blocks.
            missed: usize,
            /// Of how many.
            of: usize,
            /// From this time of the recording, s.
            from_s: f64,
            /// To this one, s.
            to_s: f64,
        },
        /// What lies between the bursts could not be compared.
        BetweenNotSeen("align_between_not_seen") {},
        /// Channels of other clocks were placed as if these ran evenly with that of the channel.
        OtherClocks("align_other_clocks") {
            /// Their names.
            channels: String,
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

impl WarningKind for AlignWarning {
    fn of(warning: &crate::Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        match self {
            Self::Uncertain { .. } => vec![Advice::RecordLonger],
            Self::ManyLeftOut { .. }
            | Self::Step { .. }
            | Self::Scatter { .. }
            | Self::Apart { .. }
            | Self::Uneven { .. } => vec![Advice::RecordAgain],
            Self::BetweenNotSeen {} => vec![Advice::RecordLonger],
            Self::PartCovered { .. }
            | Self::NotThere { .. }
            | Self::OtherClocks { .. }
            | Self::DriftAtLimit { .. } => Vec::new(),
        }
    }
}

impl fmt::Display for AlignWarning {
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
                "times are certain to ±{} ms (95 %, {}), which is more than 0.1 ms",
                digits(1e3 * uncertainty_s),
                match blocks {
                    0 => "bursts".to_owned(),
                    blocks => counted(*blocks, "block"),
                }
            ),
            Self::Step { at_s, by_s } => write!(
                f,
                "at {at_s:.2} s of the recording its times step by {} ms: samples are missing or doubled there, or the clock jumped; times are off by up to \
                 this much, and the intervals were widened by it",
                digits_signed(1e3 * by_s)
            ),
            Self::Scatter {
                spread_s,
                expected_s,
                largest_s,
                ..
            } => write!(
                f,
                "blocks lie {} ms (SD) from their line, up to {} ms, and noise explains {} ms: single samples may be missing, which look like a drift, or \
                 the clock runs unevenly; the intervals were widened",
                digits(1e3 * spread_s),
                digits(1e3 * largest_s),
                digits(1e3 * expected_s)
            ),
            Self::Apart { by_s } => write!(
                f,
                "blocks of the recording and the bursts lead to times that differ by {} ms: samples are missing between the bursts, or the clock jumped",
                digits(1e3 * by_s)
            ),
            Self::Uneven { by_s } => write!(
                f,
                "where the drive repeats, its phases move by {} ms against the bursts: samples are missing between them, or the clock jumped",
                digits(1e3 * by_s)
            ),
            Self::NotThere {
                missed,
                of,
                from_s,
                to_s,
            } => write!(
                f,
                "{missed} of {} between {from_s:.2} s and {to_s:.2} s of the recording do not hold what the drive is there: another drive was played, the \
                 signal is below the noise, or samples are missing",
                counted(*of, "block")
            ),
            Self::BetweenNotSeen {} => f.write_str(
                "the recording is too short to compare the drive between its bursts: only these say where it is",
            ),
            Self::OtherClocks { channels } => write!(
                f,
                "{channels}: sampled by another clock, which is assumed to drift as the one that was compared"
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
                "the drift of {drift_ppm:+.1} ppm is {} {} ppm, the largest that was looked for: state a larger one",
                if drift_ppm.abs() > *most_ppm { "beyond" } else { "near" },
                rounded(*most_ppm)
            ),
        }
    }
}
