//! Why a recording cannot be put on the clock of a drive.

use super::line::FEWEST_BLOCKS;
use super::{MOST_BLOCK_S, MOST_DRIFT_PPM};
use crate::recording::RecordingError;
use crate::resample::ResampleError;

/// Why a recording cannot be put on the clock of a drive.
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
    #[error("expected finite samples, found one of the {what} that is none; cut that part out")]
    NotFinite { what: &'static str },
    /// Fewer blocks than a line needs.
    #[error(
        "expected at least {FEWEST_BLOCKS} blocks of the recording in the drive, found {found}; record longer, or take shorter blocks"
    )]
    FewBlocks { found: usize },
    /// No block in the drive.
    #[error(
        "expected the drive in the recording, found none of it (largest correlation {correlation:.2}); check the channel, and that this drive was played"
    )]
    NotThere {
        /// The largest correlation of a block.
        correlation: f64,
    },
    /// Several places fit.
    #[error(
        "expected one place of the recording in the drive, found it at {first_s:.3} s and at {second_s:.3} s alike: the drive repeats, or it was \
         played twice; record its beginning or its end too and cut the recording to one of them, or play a drive with a synchronisation burst at \
         both ends"
    )]
    SeveralPlaces { first_s: f64, second_s: f64 },
    /// The bursts are not as far apart as in the drive.
    #[error(
        "expected the bursts {expected_s:.4} s apart, as in the drive, found them {found_s:.4} s apart: samples are missing in the recording, or they \
         are of two playbacks; record again, or cut the recording to one playback"
    )]
    BurstsApart {
        /// Their distance in the drive, s.
        expected_s: f64,
        /// That in the recording, s.
        found_s: f64,
    },
    /// One burst, and a drive in between that gives no times.
    #[error(
        "expected both bursts of a drive that repeats, found only {which}: its drift cannot be told; record from before the first burst until \
         after the last one"
    )]
    OneBurst {
        /// Which one was found.
        which: super::Which,
    },
    /// A signal that is not a drive.
    #[error(
        "expected the drive in shares of full scale, found none of its channels in that unit ({found}); give the WAV file that was played, or a \
         recording with a channel `drive`"
    )]
    NoDrive {
        /// The channels there are.
        found: String,
    },
    /// A channel that cannot be taken.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// A change of rate that cannot be.
    #[error(transparent)]
    Resample(#[from] ResampleError),
}
