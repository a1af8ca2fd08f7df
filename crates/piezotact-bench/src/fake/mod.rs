//! A scripted fake of a bench, for tests of procedures: two clocks, drop-outs, late and short chunks, lost devices, a
//! full input, output underruns, and breaches of the contract. Like hardware, it does not detect by itself when a playback ends.

mod halves;
mod script;
mod world;

pub use script::{
    Breach, DropOut, FakeDevice, FakeScript, Fault, Half, Late, LostHalf, Pace, TimeOrigin,
    Underrun,
};

use crate::error::DeviceError;
use crate::traits::Bench;

/// The bench that follows `script`, with a participant called `participant`.
///
/// # Errors
/// [`DeviceError::Impossible`] when a number of the script cannot be.
pub fn fake(script: FakeScript, participant: &str) -> Result<Bench, DeviceError> {
    let wrong = |found: String| DeviceError::Impossible {
        expected: "a script whose numbers can be".into(),
        found,
        todo: "write other numbers".into(),
    };
    let script = script.checked().map_err(|error| wrong(error.to_string()))?;
    let rates = script.rates().map_err(|error| wrong(error.to_string()))?;
    Ok(halves::halves(script, rates, participant))
}
