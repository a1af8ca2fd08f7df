//! Benches: devices that play a drive and acquire what comes of it, and the procedures that run on any of
//! them. The digital twin is one implementation of the two traits, hardware another, and a device and finger whose
//! transfer function was [`measured`] a third; no procedure knows which one it runs on.

mod excitation;
mod gate;
pub mod halves;
pub mod measured;
pub mod procedure;
pub mod random;
mod traits;

pub use excitation::{Excitation, ExcitationConfig, excitation};
pub use gate::{Breach, Gate, GateConfig, GateRoles};
pub use random::drawn_phases;
pub use traits::{
    Acquire, AcquireDescription, Bench, BenchError, Chunk, Lying, Play, PlayDescription,
    PlayReport, RunPlan, SensorCalibration,
};
