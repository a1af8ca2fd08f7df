//! The `piezotact` command: parse, run, report.

mod advice;
mod benches;
mod cli;
mod commands;
mod failure;
mod keeping;
mod manipulations;
mod memory;
mod output;
mod report;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    let outcome = commands::run(cli::Cli::parse());
    failure::exit_code(outcome)
}
