//! Tests of the audio crate as others use it: a loop within the program instead of a device.

mod bench;
mod clocks;
mod force;
mod forced;
mod loops;
mod stops;
