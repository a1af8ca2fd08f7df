//! What a sound device does to a signal: the level of a tone, the delay of a loopback, which channel is which, parts that an engine left
//! silent; and its calibration as a document.

mod calibration;
mod delay;
mod devices;
mod error;
mod latency;
mod page;
mod tone;
mod warning;
mod wiring;

#[cfg(test)]
mod tests;

pub use calibration::{
    Exciter, InputCalibration, LoopbackLevel, MadeOn, OutputCalibration, SensorMethod,
    SoundCalibration, VoltsMethod,
};
pub(crate) use delay::phase_slope;
pub use delay::{Delay, LoopResidual, burst_delay, delay, loop_residual, silent_runs};
pub use devices::{Answers, DeviceListing, Offer, SoundDevices, SoundHost};
pub use error::SoundError;
pub use latency::{LatencyRun, LatencySummary, Spread};
pub use tone::{Tone, tone, tone_near};
pub use warning::{CalibrationFault, SoundWarning};
pub use wiring::{Wire, wiring};
