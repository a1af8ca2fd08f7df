//! `piezotact replay`, which is a command of another program.

use std::ffi::OsString;

use anyhow::anyhow;
use clap::Args;

use crate::failure::{Outcome, usage};

/// What was given to it.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    words: Vec<OsString>,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let words = args.words.iter().map(|word| word.to_string_lossy());
    let given: String = words.map(|word| format!(" {word}")).collect();
    Err(usage(anyhow!(
        "`piezotact replay` is now `piezotact-validation replay`; ./x validate replay{given} builds and runs it"
    )))
}
