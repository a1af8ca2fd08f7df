//! Why a recording cannot be put on the clock of a drive.

use super::burst::{LEAST_CELLS, LONGEST_S, SHORTEST_GUARD_S};
use super::line::FEWEST_BLOCKS;
use super::{MOST_BLOCK_S, MOST_DRIFT_PPM};
use crate::recording::RecordingError;
use crate::series::SeriesError;

/// Why a recording cannot be put on the clock of a drive, or a drive not have bursts.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AlignError {
    /// Settings that are none.
    #[error(
        "expected a block above 0 and up to {MOST_BLOCK_S} s and a largest drift above 0 and up to {MOST_DRIFT_PPM} ppm, found others; 1 s and \
         300 ppm are usual"
    )]
    Settings,
    /// A band that the lower rate cannot hold.
    #[error(
        "expected a band up to {highest_hz} Hz, 0.9 of half the lower rate, found one up to {high_hz} Hz; state a lower one"
    )]
    Band {
        /// Its upper end, Hz.
        high_hz: f64,
        /// The highest possible, Hz.
        highest_hz: f64,
    },
    /// A rate at which there is no usual band.
    #[error(
        "expected rates above {least_hz} Hz for the usual band from {from_hz} Hz, found {found_hz} Hz; state the rate that was used, or a band"
    )]
    Rate {
        /// The lower rate, Hz.
        found_hz: f64,
        /// The rate that would do, Hz.
        least_hz: f64,
        /// The lower end of the usual band, Hz.
        from_hz: f64,
    },
    /// A sample that is no number.
    #[error("the {what} has samples that are not finite: cut that part out")]
    NotFinite { what: &'static str },
    /// Fewer blocks than a line needs.
    #[error(
        "only {found} blocks of the recording are in the drive, and {FEWEST_BLOCKS} are needed: record longer, or take shorter blocks"
    )]
    FewBlocks { found: usize },
    /// No block in the drive.
    #[error(
        "the drive is not in the recording (largest correlation {correlation:.2}): check the channel, and that this drive was played"
    )]
    NotThere {
        /// The largest correlation of a block.
        correlation: f64,
    },
    /// Several places fit.
    #[error(
        "the recording fits the drive at {first_s:.3} s and at {second_s:.3} s: play a drive with synchronisation bursts, or cut the recording to one playback"
    )]
    SeveralPlaces { first_s: f64, second_s: f64 },
    /// The bursts are not as far apart as in the drive.
    #[error(
        "the bursts are {found_s:.4} s apart, but {expected_s:.4} s in the drive: samples are missing in the recording, or they are of two playbacks; record again, or cut the recording to one playback"
    )]
    BurstsApart {
        /// Their distance in the drive, s.
        expected_s: f64,
        /// That in the recording, s.
        found_s: f64,
    },
    /// One burst, and a drive in between that gives no times.
    #[error(
        "only {which} was found, so the drift of the clocks is unknown: record from before the first burst until after the last"
    )]
    OneBurst {
        /// Which one was found.
        which: super::Which,
    },
    /// A signal that is not a drive.
    #[error(
        "no channel is a drive in shares of full scale ({found}): give the WAV file that was played, or a recording with a channel `drive`"
    )]
    NoDrive {
        /// The channels there are.
        found: String,
    },
    /// A channel that cannot be taken.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// Samples that make no series, or a rate that cannot be changed.
    #[error(transparent)]
    Series(#[from] SeriesError),
    /// A band that the rate does not hold.
    #[error(
        "expected bursts up to {highest_hz} Hz, 0.9 of half the rate of the drive, found {high_hz} Hz; state a lower band"
    )]
    BurstBand {
        /// The upper end, Hz.
        high_hz: f64,
        /// The highest possible, Hz.
        highest_hz: f64,
    },
    /// Lengths that cannot be.
    #[error(
        "expected bursts up to {LONGEST_S} s with {SHORTEST_GUARD_S} to {LONGEST_S} s of silence, found {duration_s} s with {guard_s} s; 0.5 s with \
         0.25 s are usual"
    )]
    Lengths {
        /// The length of a burst, s.
        duration_s: f64,
        /// That of a silence, s.
        guard_s: f64,
    },
    /// A burst that is not told from others.
    #[error(
        "expected a burst whose width times length is {LEAST_CELLS} or more, found {width_hz} Hz for {duration_s} s; make it {least_s:.3} s or \
         longer, or the band wider"
    )]
    Short {
        /// The width of its band, Hz.
        width_hz: f64,
        duration_s: f64,
        /// The length that would do, s.
        least_s: f64,
    },
    /// A peak that cannot be.
    #[error(
        "expected a peak of the bursts above 0 and up to 1 of full scale, found {found}; state another"
    )]
    Peak { found: f64 },
    /// The drive contains such a sweep.
    #[error(
        "the drive itself contains such a sweep at {at_s:.3} s (correlation {correlation:.2}): choose another length or band of the bursts"
    )]
    Alike {
        at_s: f64,
        /// How alike they are.
        correlation: f64,
    },
    /// The drive has bursts already.
    #[error("the drive has bursts already: give it as it is, or the drive that it was made of")]
    Already,
}
