//! The tests of the science of people, as one program.

mod adaptive;
mod answers;
mod association;
mod compared;
mod design;
mod felt;
mod judges;
mod power;
mod sitting;
