//! Why a sound device cannot be used.

use piezotact::sound::{CalibrationError, DelayError, ToneError};
use piezotact_bench::DeviceError;

/// Why a sound device cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AudioError {
    /// The set-up is not valid.
    #[error("{0}")]
    Setup(String),
    /// No host of this name.
    #[error(
        "expected a host that this program was built with ({known}), found `{found}`; `piezotact devices` lists them"
    )]
    NoHost {
        /// The hosts there are.
        known: String,
        /// The host asked for.
        found: String,
    },
    /// The sound server or system does not run.
    #[error("the sound system `{host}` does not answer ({why}); start it, or name another host")]
    HostUnavailable { host: String, why: String },
    /// The device is not there. It is never replaced by another.
    #[error(
        "expected the {direction} device `{wanted}`, found {found}; plug it in, or name one that `piezotact devices` lists"
    )]
    NoDevice {
        direction: &'static str,
        /// The id asked for.
        wanted: String,
        /// The ids there are.
        found: String,
    },
    /// Another program has it.
    #[error(
        "the {direction} device `{device}` is in use by another program; close that program, then try again"
    )]
    Busy {
        direction: &'static str,
        device: String,
    },
    /// The device cannot do what the set-up asks for.
    #[error(
        "expected {wanted} on the {direction} device `{device}`, found {offered}; write what it offers into the set-up"
    )]
    NotOffered {
        direction: &'static str,
        device: String,
        /// Rate, channels and buffer asked for.
        wanted: String,
        offered: String,
    },
    /// The sound system fails otherwise.
    #[error("the {direction} device `{device}` failed: {why}")]
    Backend {
        direction: &'static str,
        device: String,
        /// What the system said.
        why: String,
    },
    /// The streams run at another rate.
    #[error(
        "expected {wanted_hz} Hz, found {found_hz:.0} Hz by the clock of this computer: the sound system resamples or stalls; set the device to {wanted_hz} Hz, or write its rate into the set-up"
    )]
    EffectiveRate {
        /// The nominal rate, Hz.
        wanted_hz: f64,
        /// The measured rate, Hz.
        found_hz: f64,
    },
    /// The calibration does not hold.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// No tone in what was recorded.
    #[error(transparent)]
    Tone(#[from] ToneError),
    /// No loopback in what was recorded.
    #[error(transparent)]
    Delay(#[from] DelayError),
    /// Samples were lost in every attempt.
    #[error(
        "expected a measurement without lost samples, found losses in each of {attempts} attempts; close other programs, or use larger buffers"
    )]
    Losses { attempts: usize },
    /// A device fails while it runs.
    #[error(transparent)]
    Device(#[from] DeviceError),
}

impl From<AudioError> for DeviceError {
    fn from(error: AudioError) -> Self {
        match error {
            AudioError::Device(error) => error,
            other => Self::Unusable(other.to_string()),
        }
    }
}

pub(crate) fn wrong(expected: &str, found: &str) -> AudioError {
    AudioError::Setup(format!(
        "expected {expected}; found {found}; correct the set-up of the sound device"
    ))
}
