//! Errors of devices and procedures.

use std::fmt;

use piezotact::criterion::{Criterion, Outcome};
use piezotact::device::GainName;
use piezotact::quantity::{SampleRate, Seconds};
use piezotact::run::{Judged, RunCriterion, SinkError};

/// Why a device refuses a request or fails.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DeviceError {
    /// The drive has another rate than the output.
    #[error("cannot play: the drive is sampled at {drive}, the output of {name} runs at {output}; render with --drive-rate {}", output.hz())]
    Rate {
        drive: SampleRate,
        output: SampleRate,
        name: String,
    },
    /// What is asked for cannot be.
    #[error("expected {expected}, found {found}; {todo}")]
    Impossible {
        expected: String,
        /// What was asked for.
        found: String,
        todo: String,
    },
    /// A drive that is too short or too long to measure with.
    #[error("expected a duration from 1 to 600 s, found {found}; 60 s is usual")]
    Duration { found: Seconds },
    /// A device cannot be used, for a reason that its driver states: expected, found, what to do.
    #[error("{0}")]
    Unusable(String),
    /// A step out of order.
    #[error("internal error: `{asked}` was called before the bench was {before}; please report it")]
    Order {
        /// The step asked for.
        asked: &'static str,
        /// What should have come before.
        before: &'static str,
    },
    /// A device is no longer there.
    #[error(
        "the {name} no longer answers after {after_s:.2} s; check its cable and its power, then measure again"
    )]
    Lost {
        name: String,
        /// What was acquired before, s.
        after_s: f64,
    },
    /// A device delivers no more samples.
    #[error(
        "no samples for {pause_s} s: the {name} delivers nothing after {after_s:.2} s; check its cable and its power, then measure again"
    )]
    Silent {
        name: String,
        /// For how long nothing came, s.
        pause_s: f64,
        /// What was acquired before, s.
        after_s: f64,
    },
    /// A device lost so many samples that the rest is no measurement.
    #[error(
        "the {name} lost {samples} samples ({lost_s:.2} s) after {after_s:.2} s, as the computer is too busy: close other programs, use larger buffers, or allow real-time priority"
    )]
    LostSamples {
        name: String,
        /// Of each channel, in the run so far.
        samples: u64,
        /// How long they are, s.
        lost_s: f64,
        /// What was acquired before, s.
        after_s: f64,
    },
    /// The acquired samples were not fetched in time, and the buffer of the device overflowed.
    #[error(
        "the input buffer of the {name} overflowed after {after_s:.2} s, since the computer was too slow; close other programs, \
            then measure again"
    )]
    InputFull {
        name: String,
        /// What was acquired before, s.
        after_s: f64,
    },
    /// A device breaks the contract of a bench.
    #[error(
        "the {name} does not follow the bench interface: expected {expected}, found {found}; this is a bug in its driver: \
            report it"
    )]
    Contract {
        name: String,
        /// What the contract says.
        expected: String,
        /// What the device did.
        found: String,
    },
}

impl DeviceError {
    /// That the device `name` lost `samples` of each channel at `rate`, the last of them `after` so much was acquired.
    #[must_use]
    pub fn lost_samples(name: &str, samples: u64, rate: SampleRate, after: Seconds) -> Self {
        Self::LostSamples {
            name: name.into(),
            samples,
            lost_s: samples as f64 / rate.hz(),
            after_s: after.0,
        }
    }
}

/// Why a procedure on a bench was not completed.
#[derive(Debug, thiserror::Error)]
pub enum ProcedureError {
    /// A device refuses or fails.
    #[error(transparent)]
    Device(#[from] DeviceError),
    /// The drive was made for another gain.
    #[error(
        "cannot play: the drive was rendered for gain {drive}, but {name} is set to {bench}; set the amplifier to {drive}, or \
            characterise and render at {bench}"
    )]
    Gain {
        /// The gain the drive is for.
        drive: GainName,
        /// The gain that is set.
        bench: GainName,
        name: String,
    },
    /// The drive was made for another device.
    #[error(
        "cannot play: the drive was rendered for {drive}, but {name} is described as {bench}; use the description that the \
            transfer function was measured with, or characterise and render again"
    )]
    Described {
        /// The device the drive is for.
        drive: String,
        /// The device of the bench.
        bench: String,
        name: String,
    },
    /// The output gives another voltage at full scale than the drive was made for.
    #[error(
        "cannot play: the drive was rendered for {drive:.3} V at full scale, {name} now gives {bench:.3} V; set the volume back, or characterise and render again"
    )]
    OutputLevel {
        /// The potential the drive is for, V.
        drive: f64,
        /// The potential that is found, V.
        bench: f64,
        name: String,
    },
    /// A target cannot be rendered.
    #[error(transparent)]
    Render(#[from] piezotact::render::RenderError),
    /// The first measurement of a closed loop is not reliable.
    #[error("no correction was made: {0}")]
    Broken(String),
    /// A run did not pass the gate.
    #[error("the measurement was refused: {0}")]
    Refused(Refusal),
    /// A repeat did not pass the gate in any attempt.
    #[error("repeat {repeat} was rejected in all {attempts} attempts; in the last, {refusal}")]
    RepeatRefused {
        repeat: usize,
        /// How often it was tried.
        attempts: usize,
        /// Why it was refused the last time.
        refusal: Refusal,
    },
    /// Somebody stopped it.
    #[error("{}", stopped(label, *after_s))]
    Stopped {
        label: String,
        /// What was acquired of it, s.
        after_s: f64,
    },
    /// The acquired samples could not be stored.
    #[error("the recording could not be saved: {0}; free space, or give another folder")]
    Keep(SinkError),
    /// No transfer function can be estimated from the acquired samples.
    #[error("the characterisation gave no transfer function: {0}")]
    Transfer(#[from] piezotact::transfer::TransferError),
    /// The acquired samples do not form a recording.
    #[error("the bench delivered no recording: {0}")]
    Recording(#[from] piezotact::recording::RecordingError),
    /// The drive is not a valid signal.
    #[error("there is nothing to play: {0}")]
    Drive(#[from] piezotact::series::SeriesError),
}

/// The error for a run called `label` that was stopped; the keeper knows what was stored of it.
fn stopped(label: &str, after_s: f64) -> String {
    match after_s > 0.0 {
        true => format!("stopped by hand after {after_s:.2} s of `{label}`"),
        false => format!("stopped by hand before `{label}` began"),
    }
}

impl ProcedureError {
    /// Whether a procedure whose runs are stored can be resumed after this error: a device failed, somebody
    /// stopped it, or the disk was full. Neither the request nor the measurements are at fault.
    #[must_use]
    pub fn continues(&self) -> bool {
        match self {
            Self::Device(error) => matches!(
                error,
                DeviceError::Lost { .. }
                    | DeviceError::Silent { .. }
                    | DeviceError::InputFull { .. }
                    | DeviceError::LostSamples { .. }
                    | DeviceError::Unusable(_)
                    | DeviceError::Contract { .. }
            ),
            Self::Stopped { .. } | Self::Keep(_) => true,
            _ => false,
        }
    }
}

/// Why a measurement is repeated: its judgement, with at least one criterion that is not met.
#[derive(Clone, Debug, PartialEq)]
pub struct Refusal(pub Judged);

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [from, to] = self.0.window_s;
        let not_met = |c: &&Criterion<RunCriterion>| c.outcome == Outcome::NotMet;
        let Some(criterion) = self.0.criteria.iter().find(not_met) else {
            return f.write_str("nothing was refused");
        };
        let found = criterion.found.unwrap_or(f64::NAN);
        let limit = criterion.limit.value();
        match criterion.what {
            RunCriterion::Force => {
                let target_n = self.0.target_n.unwrap_or(f64::NAN);
                write!(
                    f,
                    "the mean force was {:.3} N from {from:.0} to {to:.0} s, expected {target_n} N ± {:.0} %: hold the finger so that the display shows {target_n} N",
                    target_n * (1.0 + found),
                    limit * 100.0
                )
            }
            RunCriterion::Coherence => write!(
                f,
                "coherence was {found:.4} from {from:.0} to {to:.0} s, expected {limit} or more: put the finger on the actuator, and check the sensor and its wax"
            ),
            RunCriterion::Polarity => write!(
                f,
                "the response has the opposite sign to the first repeat \
                    (correlation {found:.2}): check the polarity of the sensor and the actuator"
            ),
        }
    }
}

impl std::error::Error for Refusal {}
