//! The digital twin of the PIEZOTACT bench: a sound output, the amplifier, the actuator with a finger on it,
//! and the sensors, behind the same traits as hardware.
//!
//! Every number says where it comes from: *thesis*, a cited *source*, or *chosen* for the twin.

mod finger;
mod output;
mod sensors;
mod surface;
mod texture;
mod world;

pub use finger::{Finger, Placement};
pub use output::OutputStage;
pub use surface::{Patch, Relief, SurfaceError};
pub use texture::{TextureParameters, record_texture};
pub use world::TwinBench;
