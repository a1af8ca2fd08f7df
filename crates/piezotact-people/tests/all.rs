//! The tests of the science of people, as one program.

mod adaptive;
mod answers;
mod association;
mod compared;
mod confused;
mod design;
mod eeg;
mod felt;
mod judges;
mod power;
mod same_person;
#[path = "../../piezotact/tests/shared_data/mod.rs"]
mod shared_data;
mod sitting;
