//! Errors of measurements on sound devices.

use crate::number::digits;

use super::calibration::LEAST_ABOVE_DB;
use super::tone::FEWEST_PERIODS;

/// Why a tone, a delay or a wiring cannot be measured, or a calibration is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SoundError {
    /// The set-up states another sensitivity than it did then.
    #[error(
        "expected the sensitivity of input {channel} with which it was calibrated, {} mV per unit, found {found} in the set-up; calibrate again with \
         `piezotact sound calibrate`", digits(*expected_mv)
    )]
    OtherSensor {
        channel: u32,
        /// The sensitivity then, mV per unit.
        expected_mv: f64,
        /// What is stated now.
        found: String,
    },
    /// A number that cannot be.
    #[error("expected {} to {} {what}, found {found}; check the reading and its unit", range[0], range[1])]
    Numbers {
        what: &'static str,
        range: [f64; 2],
        found: f64,
    },
    /// The recording is clipped.
    #[error(
        "expected input {channel} below full scale, found a peak of {peak:.3}; lower the gain of the input, then calibrate again"
    )]
    Clipped {
        channel: u32,
        /// The peak, full scale = 1.
        peak: f64,
    },
    /// The tone of the calibrator is not there.
    #[error(
        "expected the tone of {hz} Hz at least {LEAST_ABOVE_DB} dB above the rest of input {channel}, found {above_db:.1} dB; switch the calibrator on, check which input the sensor is on"
    )]
    NoTone {
        channel: u32,
        /// The frequency, Hz.
        hz: f64,
        /// How far the tone stands above the rest, dB.
        above_db: f64,
    },
    /// The calibration is of another device or rate.
    #[error("the calibration is of {found}, not of {expected}: calibrate this device")]
    OtherDevice {
        /// The device at hand.
        expected: String,
        /// The device that was calibrated.
        found: String,
    },
    /// The level of the loopback changed.
    #[error(
        "the loopback is {off_db:+.2} dB off the calibration, above {most_db} dB: set volume and gains back, switch effects and enhancements off, or calibrate again"
    )]
    LevelChanged {
        /// By how much, dB.
        off_db: f64,
        /// The largest change, dB.
        most_db: f64,
    },
    /// The polarity of the loopback changed.
    #[error(
        "the loopback is inverted against the calibration: check the cables, or calibrate again"
    )]
    Inverted,
    /// Drive or recording hold nothing.
    #[error("the {what} is silent: check level and cable")]
    Silent { what: &'static str },
    /// The recording does not hold the drive.
    #[error(
        "the drive explains only {explained:.3} of the energy of the recording: check on which channel the loopback cable is"
    )]
    NotFound {
        /// The share of the energy that is explained at the best place.
        explained: f64,
    },
    /// A sample is no number.
    #[error("the {what} has samples that are not finite: record again")]
    NotFinite { what: &'static str },
    /// The frequency does not lie between 0 and half the rate.
    #[error("expected a tone above 0 and below {below_hz} Hz, half the rate; found {found_hz} Hz")]
    Frequency {
        /// Half the rate, Hz.
        below_hz: f64,
        /// What was asked for, Hz.
        found_hz: f64,
    },
    /// The signal is too short.
    #[error(
        "expected at least {FEWEST_PERIODS} periods of a tone of {hz} Hz, found {found:.1}; record longer"
    )]
    Short {
        /// The frequency, Hz.
        hz: f64,
        found: f64,
    },
    /// It arrives nowhere.
    #[error(
        "the pulse of output {output} arrived on no input: check the cable and the level of the input"
    )]
    Nowhere {
        /// The channel of the output.
        output: u32,
    },
    /// It arrives on several.
    #[error(
        "the pulse of output {output} arrived on the inputs {inputs:?}: check for crosstalk, monitoring of inputs, or cables that are joined"
    )]
    Several {
        /// The channel of the output.
        output: u32,
        /// The channels of the inputs.
        inputs: Vec<u32>,
    },
}
