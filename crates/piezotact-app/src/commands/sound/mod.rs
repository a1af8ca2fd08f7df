//! Sound devices: which there are, their calibration, their latency.

#[cfg(feature = "audio")]
pub(super) mod calibrate;
#[cfg(feature = "audio")]
pub(super) mod devices;
#[cfg(feature = "audio")]
pub(super) mod latency;
#[cfg(feature = "audio")]
pub(crate) mod plant;
#[cfg(not(feature = "audio"))]
mod without;

#[cfg(not(feature = "audio"))]
pub(crate) use without::plant;
#[cfg(not(feature = "audio"))]
pub(super) use without::{calibrate, devices, latency};
