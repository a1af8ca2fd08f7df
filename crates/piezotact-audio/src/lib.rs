//! Sound hardware as a bench: a device that plays and records, calibrated and timed, and the real-time half that serves it.
//!
//! `callback.rs` runs on the threads of the sound system; `streams.rs` is the other half. Between them are rings without locks, one each way. An
//! [`AudioIo`] is a sound system: the hosts of this machine, or a loop within the program.

mod bench;
mod board;
mod calibrate;
mod callback;
mod error;
pub mod force;
mod forced;
#[cfg(feature = "hardware")]
mod hardware;
mod io;
mod latency;
mod loop_settings;
mod looped;
#[cfg(feature = "hardware")]
mod plant;
mod setup;
mod streams;

pub use bench::AudioBench;
pub use board::{Board, Side};
pub use calibrate::{
    Loopback, VOLTMETER_TONE, check_level_hz, measured_loopback, play_tone, record_tone, wires,
};
pub use callback::{Happened, InputCallback, OutputCallback};
pub use error::AudioError;
#[cfg(feature = "hardware")]
pub use hardware::{HardwareIo, hosts};
pub use io::{AudioIo, StreamPlan, Streams};
pub use latency::latency_run;
pub use loop_settings::{LoopFailure, LoopFault, LoopPace, LoopSettings, SilentPart};
pub use looped::{LoopIo, PlantMaker};
#[cfg(feature = "hardware")]
pub use plant::{ForceReading, JackPlant, PlantSettings};
pub use setup::{ForceSettings, Measures, PlayChannels, RecordedChannel, SoundSetup};
pub use streams::{Fetched, Loaded, PieceProgress, RunningStreams, StreamChannels};
