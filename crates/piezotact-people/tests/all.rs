//! The tests of the science of people, as one program.

mod adaptive;
mod answers;
mod association;
mod design;
mod felt;
mod judges;
mod sitting;
