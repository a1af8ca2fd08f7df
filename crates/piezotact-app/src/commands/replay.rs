//! `piezotact replay`, which is a command of another program.

use std::ffi::OsString;

use anyhow::anyhow;
use clap::Args;
use piezotact_report::invocation::line_of;

use crate::failure::{Outcome, usage};

/// What was given to it.
#[derive(Debug, Args)]
pub(crate) struct Arguments {
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    words: Vec<OsString>,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let words = args
        .words
        .iter()
        .map(|word| word.to_string_lossy().into_owned());
    let given = line_of("./x validate replay", &words.collect::<Vec<_>>());
    Err(usage(anyhow!(
        "`piezotact replay` is now `piezotact-validation replay`; {given} builds and runs it"
    )))
}
