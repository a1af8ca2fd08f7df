//! The tests of the science of people, as one program.

mod adaptive;
mod association;
mod design;
mod felt;
