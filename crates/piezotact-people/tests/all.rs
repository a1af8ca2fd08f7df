//! The tests of the science of people, as one program.

mod association;
