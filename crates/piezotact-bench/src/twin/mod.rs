//! The digital twin of the PIEZOTACT bench: a sound output, the amplifier, the actuator with a finger on it,
//! and the sensors, behind the same traits as hardware.
//!
//! Every number says where it comes from: *thesis*, a cited *source*, or *chosen* for the twin.

mod finger;
mod output;
mod sensors;
mod texture;
mod varying;
mod world;

pub use finger::{Finger, Placement};
pub use output::OutputStage;
pub use texture::{TextureParameters, record_texture};
pub use world::TwinBench;

/// The rate of the acquisition, Hz (*thesis* 2.5.2 and 2.5.3).
const ACQUISITION_RATE_HZ: f64 = 5_000.0;
