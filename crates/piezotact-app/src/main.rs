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
mod shown;

use std::process::ExitCode;

use clap::Parser;

fn main() -> ExitCode {
    match cli::Cli::try_parse() {
        Ok(cli) => failure::exit_code(commands::run(cli)),
        Err(error) => refused(&error),
    }
}

/// Shows why a command line is refused, or the help that it asks for.
fn refused(error: &clap::Error) -> ExitCode {
    let text = error.render().to_string();
    let shown = output::message(&text);
    if shown == text {
        error.exit();
    }
    output::say(shown.trim_end());
    ExitCode::from(2)
}
