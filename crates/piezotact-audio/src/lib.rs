//! Sound hardware as a bench: a device that plays and records, calibrated and timed, and the real-time half that serves it.

pub mod force;
