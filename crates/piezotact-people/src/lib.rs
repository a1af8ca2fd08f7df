//! The science of people: campaigns with volunteers and what their answers say.
//!
//! Pure, as the science of signals is: functions from values to values. No files, clock, threads, devices or entropy; time and
//! seeds are arguments.

pub mod association;
pub mod campaign;
pub mod difference;
pub mod interval;
pub mod judge;
