//! The science of people: campaigns with volunteers, what their answers say, and what their EEG says.
//!
//! Pure, as the science of signals is: functions from values to values. No files, clock, threads, devices or entropy; time and
//! seeds are arguments.

pub mod association;
pub mod campaign;
pub mod difference;
pub mod eeg;
pub mod interval;
pub mod judge;
