//! What a sound system has to offer: devices by their ids, and streams that call the real-time half. Hosts of this machine and the loop within the
//! process are its implementations.

use std::sync::Arc;
use std::time::Duration;

use piezotact::quantity::SampleRate;
use piezotact::sound::DeviceListing;
use piezotact_bench::{DeviceError, RunPlan, StopHandle};

use crate::board::Board;
use crate::callback::{InputCallback, OutputCallback};
use crate::error::AudioError;

/// The streams to open.
#[derive(Clone, Debug, PartialEq)]
pub struct StreamPlan {
    /// The id of the output device.
    pub output: String,
    /// The id of the input device.
    pub input: String,
    /// The rate of both.
    pub rate: SampleRate,
    /// The frames of a buffer.
    pub buffer_frames: u32,
}

/// A sound system.
pub trait AudioIo: Send {
    /// The devices there are.
    ///
    /// # Errors
    /// [`AudioError::HostUnavailable`] when the system does not answer.
    fn devices(&self) -> Result<Vec<DeviceListing>, AudioError>;
    /// Opens both streams and starts them; their channels are those of the callbacks. Drop them to close them.
    ///
    /// # Errors
    /// [`AudioError`] when a device is not there, is busy, or does not offer what is asked for. No other device is taken instead.
    fn open(
        &mut self,
        plan: &StreamPlan,
        output: OutputCallback,
        input: InputCallback,
        board: &Arc<Board>,
    ) -> Result<Box<dyn Streams>, AudioError>;
}

/// Streams that run.
pub trait Streams: Send {
    /// Waits until more may have been recorded, at most `at_most`, or until `stop`. Streams whose time passes when it is asked for let a buffer pass.
    fn wait(&mut self, at_most: Duration, stop: &StopHandle);
    /// Whether they run by themselves, so that a pause means something.
    fn run_by_themselves(&self) -> bool;
    /// Tells a simulated finger what run comes; real devices need nothing.
    ///
    /// # Errors
    /// [`DeviceError::Impossible`] for a run that cannot be simulated.
    fn run_comes(&mut self, _run: &RunPlan) -> Result<(), DeviceError> {
        Ok(())
    }
}
