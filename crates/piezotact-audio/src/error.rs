//! Why a sound device cannot be used.

use piezotact::sound::SoundError;
use piezotact_bench::DeviceError;

/// Why a sound device cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AudioError {
    /// The set-up is not valid.
    #[error("{0}")]
    Setup(String),
    /// No host of this name.
    #[error(
        "this program was built without the host `{found}` (only {known}): name one that `piezotact sound devices` lists"
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
        "there is no {direction} device `{wanted}`, only {found}: plug it in, or name one that `piezotact sound devices` lists"
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
        "the {direction} device `{device}` does not offer {wanted}: it offers {offered}; correct the set-up"
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
        "the sound system runs at {found_hz:.0} Hz by the clock of this computer, not at {wanted_hz} Hz: set both to one rate"
    )]
    EffectiveRate {
        /// The nominal rate, Hz.
        wanted_hz: f64,
        /// The measured rate, Hz.
        found_hz: f64,
    },
    /// No tone or loopback in what was recorded, or a calibration that does not hold.
    #[error(transparent)]
    Sound(#[from] SoundError),
    /// Samples were lost in every attempt.
    #[error(
        "samples were lost in each of {attempts} attempts: close other programs, or use larger buffers"
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
