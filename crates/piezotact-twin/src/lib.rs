//! The digital twin: samples, people, and four benches, behind the same traits as hardware.
//!
//! A [`Participant`] is one seeded person, the same on every bench; [`TwinParameters`] are all numbers, read from a
//! documented file that a laboratory can change, in which each has its range and its origin. [`ActTouch`] and
//! [`TriboAir`] acquire what a finger does on a sample; [`ShakerBench`] measures a finger's own
//! transfer function; [`TwinBench`] plays on the PIEZOTACT device, and
//! [`TwinPlant`] is that device as a stream behind a sound output. `eeg` is what electrodes on the person's scalp show meanwhile.

mod acttouch;
mod camera;
mod causal;
pub mod document;
mod drag;
#[cfg(feature = "eeg")]
pub mod eeg;
mod error;
mod finger;
mod noise;
mod output;
pub mod parameters;
mod participant;
mod partitions;
mod passage;
mod plant;
mod protocol;
mod sensors;
mod session;
mod shaker;
mod sliding;
mod surface;
mod texture;
mod triboair;
mod varying;
mod wander;
mod world;

pub use acttouch::{ActTouch, ActiveProtocol};
pub use error::TwinError;
pub use finger::{Finger, Placement};
pub use output::OutputStage;
pub use parameters::{PARAMETERS, Sample, TwinParameters};
pub use participant::{Hand, Participant, Skin};
pub use passage::record_texture;
pub use plant::TwinPlant;
pub use protocol::{Pace, SlidingDirection};
pub use shaker::{ShakerBench, ShakerExcitation, ShakerMount};
pub use surface::{Patch, Relief};
pub use triboair::TriboAir;
pub use world::TwinBench;

/// The rate of the acquisition, Hz (*thesis* 2.5.2 and 2.5.3).
pub(crate) const RATE_HZ: f64 = 5_000.0;
