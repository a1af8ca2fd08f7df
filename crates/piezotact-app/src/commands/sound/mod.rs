//! Sound devices: which there are, their calibration, their latency.

pub(crate) mod calibrate;
pub(crate) mod devices;
pub(crate) mod latency;
