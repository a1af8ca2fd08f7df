//! The science of Piezotact: functions from values to values.
//!
//! A texture vibration and the transfer function of a device with a finger on it go in; spectra, the
//! drive signal that makes the finger feel that texture, and the proof of how close it came, come out.
//! Nothing here touches a file, a clock, a thread or a device: what a function needs is an argument.
//!
//! The modules stand in the order of the work:
//! [`quantity`] → [`series`], [`recording`] → [`spectrum`] → [`transfer`] → [`render`] → [`verify`],
//! with [`correct`] for a loop that measures again, [`manipulate`] for textures made otherwise on purpose, [`score`] for whether a
//! finger could tell, [`envelope`] for files that hold no waveform, [`resample`] between rates, [`convolve`] for what comes of a drive through an impulse response, [`device`] for what a drive passes
//! through, [`integrity`] for whether a signal came whole, and [`doubt`] for what
//! a result leaves open.

pub mod compare;
pub mod convolve;
pub mod correct;
pub mod criterion;
pub mod device;
pub mod discrimination;
pub mod doubt;
pub mod envelope;
pub mod feature;
pub mod filter;
mod fourier;
pub mod integrity;
pub mod manipulate;
mod order;
pub mod panel;
pub mod quantity;
pub mod recording;
pub mod render;
pub mod resample;
pub mod roles;
pub mod run;
pub mod score;
pub mod series;
pub mod spectrum;
pub mod stroke;
pub mod surface;
pub mod transfer;
pub mod verify;

pub use doubt::Doubt;
pub use series::Series;
