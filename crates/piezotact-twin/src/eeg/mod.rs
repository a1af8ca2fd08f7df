//! The EEG of the twin's participants while they touch, feel a texture on the device, or imagine touching it (*thesis* chapter 6).
//!
//! [`EegProtocol`] + [`Participant`](crate::Participant) + parameters → [`record`] → a `Recording` in V with events. [`truth`] says, from
//! the same three, by how much the power of a band was made to change. No crate that analyses can use this one, so that no analysis
//! can read it.
//!
//! A channel is the sum of a background 1/f^β correlated over the scalp, three sources of alpha (left sensorimotor cortex and
//! SMA, whose power follows the task, and the occiput, whose power does not), an evoked response, blinks, movements of the eyes, muscles and
//! the mains. It is the same whichever other channels are recorded.

mod brain;
mod generate;
mod head;
mod positions;
mod protocol;
mod session;
mod spectrum;
mod truth;

#[cfg(test)]
mod tests;

pub use brain::Brain;
pub use generate::record;
pub use head::{HEOG, VEOG, all_channels};
pub use protocol::{EegProtocol, REST, Task};
pub use truth::{EegTruth, PowerChange, TruthWindows, truth};
