//! The `piezotact-validation` program: parse, run, report.

mod program;

use std::process::ExitCode;

fn main() -> ExitCode {
    program::run()
}
