//! The program `piezotact`.

use std::process::ExitCode;

fn main() -> ExitCode {
    let words: Vec<_> = std::env::args_os().collect();
    ExitCode::from(piezotact_app::program(&words, Vec::new()))
}
