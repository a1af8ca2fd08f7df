//! Commands that this build does not have, and which build has them.

use std::ffi::OsString;

use anyhow::anyhow;
use clap::{Args, Command};

use crate::failure::{Failure, Outcome, usage};

/// The build that has every command.
const FULL: &str = "./x build";
const WORDS: &str = "words of a command that this build lacks";

/// What was given to a command that this build lacks.
#[derive(Debug, Args)]
pub(crate) struct Lacking {
    #[arg(id = WORDS, trailing_var_arg = true, allow_hyphen_values = true, hide = true)]
    words: Vec<OsString>,
}

/// Refuses the command `name`, called with `given`.
pub(super) fn refuse(name: &str, given: &Lacking) -> Outcome {
    let below = given.words.first().map(|word| word.to_string_lossy());
    let below = below.filter(|word| word.chars().all(|c| c.is_ascii_lowercase() || c == '-'));
    let called = below.map_or(name.to_owned(), |below| format!("{name} {below}"));
    Err(usage(anyhow!(
        "{called}: this build does not have `piezotact {name}`; build piezotact with {FULL}"
    )))
}

/// Refuses `what`, which is a part of a command.
#[allow(dead_code, reason = "a full build has every part")]
pub(super) fn other(what: &str) -> Outcome {
    Err(without(what))
}

/// That this build lacks `what`, which is a part of a command.
#[allow(dead_code, reason = "a full build has every part")]
pub(super) fn without(what: &str) -> Failure {
    usage(anyhow!(
        "{what}: this build does not have it; build piezotact with {FULL}"
    ))
}

/// `command`, in whose help the commands that this build lacks say which build has them.
pub(super) fn marked(command: Command) -> Command {
    command.mut_subcommands(|below| {
        let lacks = below.get_arguments().any(|given| given.get_id() == WORDS);
        match (lacks, below.get_about().map(ToString::to_string)) {
            (true, Some(about)) => below
                .about(format!("{about}. Not in this build: {FULL} has it"))
                .after_help(format!("Not in this build; build piezotact with {FULL}.")),
            _ => marked(below),
        }
    })
}

/// Stands in for the modules of commands that this build lacks: `MODULE(ARGUMENTS), "NAME"`.
macro_rules! lacking {
    ($($module:ident($arguments:ident), $name:literal;)*) => {$(
        pub(crate) mod $module {
            pub(crate) use crate::commands::lacking::Lacking as $arguments;

            pub(crate) fn run(given: &$arguments) -> crate::failure::Outcome {
                crate::commands::lacking::refuse($name, given)
            }
        }
    )*};
}
pub(super) use lacking;
