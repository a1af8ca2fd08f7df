//! The `piezotact` command: parse, run, report.

mod advice;
mod arguments;
mod benches;
mod cli;
mod commands;
mod dashboard;
mod deliver;
mod failure;
mod interrupt;
mod invocation;
mod keeping;
mod large;
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

use std::process::ExitCode;

fn main() -> ExitCode {
    interrupt::listen();
    let words: Vec<_> = std::env::args_os().collect();
    failure::exit_code(commands::run(&words))
}
