//! The contract of a bench, and the procedures that run on any bench.
//!
//! A bench is two halves, [`Play`] and [`Acquire`]. The digital twin is one, hardware another, and a device and finger whose
//! transfer function was [`measured`] a third; no [`procedure`] knows which one it runs on. Every bench passes the same
//! tests.

#[cfg(feature = "testing")]
pub mod conformance;
pub mod document;
mod error;
mod excitation;
#[cfg(feature = "testing")]
pub mod fake;
mod gate;
pub mod halves;
pub mod measured;
mod paced;
mod plan;
mod plant;
pub mod procedure;
mod stop;
mod traits;
mod watch;

pub use error::{DeviceError, ProcedureError, Refusal};
pub use excitation::{Excitation, ExcitationConfig, excitation};
pub use gate::{Gate, GateConfig, GateRoles, LOWEST_JUDGED};
pub use paced::Paced;
pub use piezotact::statistics::random;
pub use plan::{DriveSource, Placement, Playback, RunPlan, Until};
pub use plant::Plant;
pub use stop::StopHandle;
pub use traits::{
    Acquire, AcquireDescription, Bench, Play, PlayDescription, PlayProgress, SensorCalibration,
};
pub use watch::{LONGEST_PAUSE, MOST_LOST};
