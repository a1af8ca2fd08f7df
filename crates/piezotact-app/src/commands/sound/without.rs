//! What there is without sound devices.

use anyhow::anyhow;

use crate::failure::{Outcome, usage};

/// Words of a command that this build does not have.
#[derive(Debug, clap::Args)]
pub(crate) struct Arguments {
    /// The set-up of the sound device, and what is to be done.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    others: Vec<String>,
}

/// Says that there are no sound devices.
pub(crate) fn run(args: &Arguments) -> Outcome {
    let _others = &args.others;
    Err(usage(anyhow!(
        "this build serves no sound devices; build piezotact with ./x build"
    )))
}

pub(crate) mod calibrate {
    pub(crate) use super::{Arguments, run};
}
pub(crate) mod devices {
    pub(crate) use super::{Arguments, run};
}
pub(crate) mod plant {
    pub(crate) use super::{Arguments, run};
}
pub(crate) mod latency {
    pub(crate) use super::{Arguments, run};
}
