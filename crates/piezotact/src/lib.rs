//! The science of Piezotact: functions from values to values.
//!
//! A texture vibration and the transfer function of a device with a finger on it go in; spectra, the
//! drive signal that makes the finger feel that texture, and the proof of how close it came, come out.
//! Nothing here touches a file, a clock, a thread or a device: what a function needs is an argument.
//!
//! The modules stand in four layers, and a module uses only what stands before it; `docs/layers.md` has the table and
//! `xtask tidy` checks it:
//!
//! - ground: units, statistics, checksums, criteria, warnings, lineages;
//! - signals: series, recordings, spectra, filters, rates, clipping, integrity;
//! - touch: surfaces, strokes, what they say, what is distinguishable by touch, whole studies;
//! - device: transfer functions, panels, rendering, verification, closed loops, manipulations, scores.

// Ground.
pub mod checksum;
pub mod criterion;
pub mod document;
pub mod figure;
pub mod fourier;
pub mod invocation;
pub mod lineage;
pub mod number;
pub mod page;
pub mod quantity;
pub mod statistics;
pub mod warning;

// Signals.
pub mod align;
pub mod clipping;
pub mod convolve;
mod delay;
pub mod filter;
pub mod integrity;
pub mod noise;
pub mod recording;
pub mod resample;
pub mod series;
pub mod share;
pub mod sound;
pub mod spectrum;

// Touch.
pub mod compare;
pub mod discrimination;
pub mod feature;
pub mod perception;
pub mod roles;
pub mod stroke;
pub mod study;
pub mod surface;

// Device.
pub mod correct;
pub mod device;
pub mod manipulate;
pub mod monitor;
pub mod panel;
pub mod prepare;
pub mod render;
pub mod run;
pub mod score;
pub mod transfer;
pub mod verify;

pub use series::Series;
pub use warning::Warning;
