//! The digital twins of the two benches of the thesis, behind the same traits as hardware: the PIEZOTACT bench (a
//! sound output, the amplifier, the actuator with a finger on it, and the sensors) and the shaker bench (a shaker
//! that the acquisition drives, a plate on a force cell with a finger on it, and the sensors).
//!
//! Every number says where it comes from: *thesis*, a cited *source*, or *chosen* for the twin.

mod finger;
mod noise;
mod output;
mod sensors;
mod shaker;
mod texture;
mod varying;
mod world;

pub use finger::{Finger, Placement};
pub use output::OutputStage;
pub use shaker::{ShakerBench, ShakerExcitation, ShakerMount, ShakerParameters};
pub use texture::{TextureParameters, record_texture};
pub use world::TwinBench;

/// The rate of the acquisition, Hz (*thesis* 2.5.2 and 2.5.3).
const ACQUISITION_RATE_HZ: f64 = 5_000.0;
