//! The `piezotact` command: parse, run, report; as the program, and as functions of another language ([`library`]).

mod advice;
mod arguments;
mod benches;
mod calls;
mod cli;
mod commands;
mod dashboard;
mod deliver;
mod failure;
mod interrupt;
mod invocation;
mod keeping;
mod large;
pub mod library;
mod live;
mod made;
mod manipulations;
mod memory;
mod output;
mod parts;
#[cfg(feature = "full")]
mod pictures;
mod places;
mod progress;
mod reading;
mod replacing;
mod report;
mod runs;
mod shown;

use std::ffi::OsString;

/// Does what `words` ask for, the first of which is the name of the program, prints it, and gives the exit code. `again` is what
/// starts this program, for commands that start it; empty: the file of this process.
///
/// It takes over Ctrl-C and SIGTERM, and is called once in a process.
#[must_use]
pub fn program(words: &[OsString], again: Vec<OsString>) -> u8 {
    interrupt::listen();
    invocation::started_by(again);
    failure::exit_code(commands::run(words))
}
