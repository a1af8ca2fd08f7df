//! Errors of transfer functions: estimated, read, compared and averaged.

use crate::number::{digits, rounded};
use crate::quantity::{Band, Unit};
use crate::recording::RecordingError;
use crate::series::SeriesError;
use crate::spectrum::EstimateError;

use super::FEWEST_LEFT;
use super::impact::HitFault;

/// Why transfer functions cannot be estimated, read, compared or averaged.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TransferError {
    /// The spectra cannot be estimated.
    #[error(transparent)]
    Estimate(#[from] EstimateError),
    /// Lines beyond half the rate.
    #[error(
        "expected frequencies up to {nyquist_hz} Hz, half the rate, found up to {highest_hz} Hz; correct the rate or the frequencies",
        nyquist_hz = rounded(*nyquist_hz),
        highest_hz = rounded(*highest_hz)
    )]
    BeyondNyquist {
        /// The highest line, Hz.
        highest_hz: f64,
        /// Half the rate, Hz.
        nyquist_hz: f64,
    },
    /// A magnitude of no device.
    #[error(
        "expected a transfer function whose largest magnitude is between 1e-30 and 1e12, found {largest:e}; check its units, or \
            measure again"
    )]
    Magnitude { largest: f64 },
    /// More effective averages than averages.
    #[error(
        "expected at most {averages} effective averages, as many as segments were averaged, found {effective}; measure again, or \
            restore the file",
        effective = rounded(*effective)
    )]
    Averages { averages: usize, effective: f64 },
    /// The lines do not make an axis.
    #[error(
        "expected the same number of values and coherences, 2 or more, found {response} and {coherence}; export the transfer function whole"
    )]
    Lines {
        /// The number of complex values.
        response: usize,
        /// The number of coherences.
        coherence: usize,
    },
    /// The step between lines is not above zero.
    #[error(
        "expected evenly spaced frequencies from 0 Hz, found a step of {found} Hz; export the transfer function on a uniform axis",
        found = rounded(*found)
    )]
    Resolution { found: f64 },
    /// A line is NaN, infinite, or so large that its square is.
    #[error(
        "expected valid response values, found an invalid one at {frequency_hz:.2} Hz (NaN, infinite, or beyond 1e100); measure \
            again or cut the band"
    )]
    NotFinite { frequency_hz: f64 },
    /// Too many segments contain lost samples.
    #[error(
        "expected {FEWEST_LEFT} segments or more without lost samples, found {left} of {of}; close other programs and measure \
            again, or use shorter segments"
    )]
    FewLeft {
        /// How many are left.
        left: usize,
        of: usize,
    },
    /// Too many repetitions of a periodic drive contain lost samples.
    #[error(
        "expected {needed} sweeps or realisations or more without lost samples, found {left} of {of}; close other programs and \
            measure again"
    )]
    FewRowsLeft {
        /// How many are needed.
        needed: usize,
        /// How many are left.
        left: usize,
        of: usize,
    },
    /// A drive of short pulses, in an estimate for drives that last.
    #[error("the drive consists of short pulses ({hits} in {:.2} % of it), for which averaged segments are invalid: evaluate it as an impact test",
        .share * 100.0
    )]
    Transient {
        /// The number of pulses.
        hits: usize,
        /// The share of the recording that they take, 0–1.
        share: f64,
    },
    /// The response is zero at every line.
    #[error("the response is zero at every frequency: check the sensor and the amplifier")]
    Zero,
    /// The force holds no hit.
    #[error("no hit was found: the largest force is {}, less than 10 times its noise of {}; check the channel of the hammer, or hit harder",
        digits(*.largest),
        digits(*.noise)
    )]
    NoHit {
        /// The largest magnitude re rest, in the unit of the force.
        largest: f64,
        /// The standard deviation of the noise, in the unit of the force.
        noise: f64,
    },
    /// The force is no series of pulses.
    #[error(
        "the force oscillates or does not rest between hits: check whether drive and response are exchanged, or evaluate it as a random drive"
    )]
    NoPulses,
    /// No hit can be used.
    #[error("expected one usable hit or more, found {} and none usable: {}", .faults.len(), listed(.faults))]
    NoneUsable {
        /// Where each hit is, s, and its first fault.
        faults: Vec<(f64, HitFault)>,
    },
    /// The segment cannot hold a hit, or has no line in the excited band.
    #[error(
        "expected a segment of {least} samples or more, and no longer than the recording of {samples}, found {found}; state another \
            length, or none"
    )]
    Segment {
        /// The shortest segment, samples.
        least: usize,
        /// The length of the recording, samples.
        samples: usize,
        /// The segment asked for, samples.
        found: usize,
    },
    /// An exponential window that leaves nothing of a segment.
    #[error(
        "expected an added damping of at most {most:.0} 1/s for a segment of {segment_s:.3} s, found {found}; state less, or a shorter \
            segment",
        found = rounded(*found)
    )]
    Overdamped {
        /// What was found, 1/s.
        found: f64,
        /// The most for this segment, 1/s.
        most: f64,
        segment_s: f64,
    },
    /// An added damping that is none.
    #[error(
        "expected an added damping above 0 1/s, found {found}; state the damping in 1/s, or none"
    )]
    Damping {
        /// What was found, 1/s.
        found: f64,
    },
    /// One channel is named twice.
    #[error("`{channel}` is both drive and response: name the channel of the response")]
    SameChannel { channel: String },
    /// Volts per full scale were stated for a drive in another unit.
    #[error("expected the drive channel in V or FS, found {found}")]
    NotVolts { found: Unit },
    /// A channel holds no signal.
    #[error(
        "expected the channel `{channel}` to hold a signal, found the constant value {}; check its cable, its range \
                     and its name",
        digits(*.value)
    )]
    Constant {
        channel: String,
        /// Its only value, in its unit.
        value: f64,
    },
    /// The recording lacks a channel, or the two do not share a clock.
    #[error(transparent)]
    Recording(#[from] RecordingError),
    /// Samples that make no series.
    #[error(transparent)]
    Series(#[from] SeriesError),
    /// Too few.
    #[error("expected at least {expected} transfer functions, found {found}; measure more")]
    Few { expected: usize, found: usize },
    /// Different line spacings.
    #[error(
        "cannot combine transfer functions: one has lines every {one_hz} Hz, another every {other_hz} Hz; estimate them with one segment length",
        one_hz = rounded(*one_hz),
        other_hz = rounded(*other_hz)
    )]
    OtherLines {
        /// The step of the first.
        one_hz: f64,
        /// The step of another.
        other_hz: f64,
    },
    /// Devices that are not the same.
    #[error(
        "cannot average transfer functions: one was measured with {one}, another with {other}; average them separately"
    )]
    OtherDevice { one: String, other: String },
    /// Excited bands that do not overlap.
    #[error(
        "cannot average transfer functions: one was excited over {one}, another over {other}; average them separately"
    )]
    Excited { one: Band, other: Band },
    /// A complex mean in which the transfer functions cancel.
    #[error(
        "the {count} transfer functions cancel in the mean: look for an inverted channel, or average the magnitudes"
    )]
    Cancel {
        /// How many they are.
        count: usize,
    },
    /// They were measured through two amplifications.
    #[error(
        "expected the response at rest through the stored {stored}, found {found}; set the amplifier back, or measure the stored response again"
    )]
    RestDevice { stored: String, found: String },
    /// They are of two people, or of somebody and nobody.
    #[error(
        "expected the response at rest with {stored} on the device as in the stored one, found {found}; measure it so"
    )]
    RestPerson { stored: String, found: String },
}

/// The first faults, each with its time, and what to do.
fn listed(faults: &[(f64, HitFault)]) -> String {
    let mut said: Vec<String> = faults
        .iter()
        .take(4)
        .map(|(at_s, fault)| format!("at {at_s:.3} s {fault}"))
        .collect();
    if faults.len() > said.len() {
        said.push(format!("and {} more", faults.len() - said.len()));
    }
    let mut advice: Vec<&str> = Vec::new();
    for (_, fault) in faults {
        let one = fault.advice();
        if !advice.contains(&one) {
            advice.push(one);
        }
    }
    format!("{}; {}", said.join("; "), advice.join("; "))
}
