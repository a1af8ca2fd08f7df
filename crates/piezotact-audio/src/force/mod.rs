//! The force from another device than the sound input.
//!
//! A sound input is AC-coupled: it cannot measure a force that is held. The force comes as lines of text from a serial port
//! ([`SerialForceCell`]) or from a file that another program appends to ([`GrowingFile`]), in the protocol of
//! `docs/guide/force-cell.md`. [`ForceJoiner`] puts its readings on the clock of the sound device.

mod error;
mod growing;
mod joiner;
mod late;
mod lines;
mod progress;
mod protocol;
mod serial;
mod table;
mod unit;

use std::time::Instant;

use piezotact::Warning;

pub use error::ForceError;
pub use growing::{Columns, GrowingFile, GrowingSettings, TimeUnit};
pub use joiner::{ForceJoiner, JoinerConfig};
pub use serial::{SerialForceCell, SerialSettings};
pub use unit::ForceUnit;

/// A device or a program that measures a force and sends its readings.
pub trait ForceSource: Send {
    /// What it is, as far as it is known by now.
    fn describe(&self) -> ForceDescription;

    /// Opens it and begins to read; what it sent before is left out. After a stop it can be started again; the readings and clocks of before are discarded.
    ///
    /// # Errors
    /// [`ForceError`] when it cannot be opened.
    fn start(&mut self) -> Result<(), ForceError>;

    /// The readings since the last call, in their order; none when there is none yet. It does not wait.
    ///
    /// # Errors
    /// [`ForceError`] when the source fails or stops sending; what came before is returned first, and the error stays until the
    /// source is started again.
    fn poll(&mut self) -> Result<Vec<ForceReading>, ForceError>;

    /// Stops reading and closes it. A source that was not started is left as it is.
    fn stop(&mut self);

    /// What its readings leave open since it was started.
    fn warnings(&self) -> Vec<Warning>;
}

/// What a source of force is.
#[derive(Clone, Debug, PartialEq)]
pub struct ForceDescription {
    /// Its name for people: the port or the file.
    pub name: String,
    /// The unit of its lines; none before one was stated.
    pub unit: Option<ForceUnit>,
    /// The rate that it states, Hz; none where it states none.
    pub nominal_rate_hz: Option<f64>,
}

/// One reading of a force.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ForceReading {
    pub at: Instant,
    /// When it was measured, by the clock of the device, s since the first reading of this clock; none where the device states no
    /// times.
    pub device_s: Option<f64>,
    /// How often the clock of the device began again before it.
    pub clock: u32,
    pub force_n: f64,
}
