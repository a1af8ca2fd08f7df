//! `piezotact campaign`: campaigns with volunteers, from their protocol on.

mod design;
mod dictionary;
mod protocol;

use std::path::Path;

use anyhow::{Error, anyhow};
use clap::{Args, Subcommand};
use piezotact_dataset::{read_input_text, reads};
use piezotact_people::campaign::protocol::{LIBRARY, Protocol, from_library, read};

use crate::failure::{Failure, Outcome, usage};
use crate::output::say;

#[derive(Debug, Args)]
pub(crate) struct Campaign {
    #[command(subcommand)]
    command: CampaignCommand,
}

#[derive(Debug, Subcommand)]
enum CampaignCommand {
    /// Checks the design of a campaign before the first participant: time, chance, pairs, precision, faults and better plans.
    #[command(
        after_help = "A fault is a finding, not an error: the exit code is 0 whatever is found.\n\nExample:\n  piezotact campaign design isotropic_triplets --report design.html\n  piezotact campaign design isotropic_triplets --participants 20 --json"
    )]
    Design(design::Arguments),
    /// Writes a protocol of the library as a file to start from, or lists the library.
    #[command(
        after_help = "Example:\n  piezotact campaign protocol\n  piezotact campaign protocol isotropic_triplets --out own.toml"
    )]
    Protocol(protocol::Arguments),
    /// Prints the data dictionary of a campaign: what each column of its table of answers means, task by task.
    #[command(
        after_help = "The columns are those that `piezotact matrix` reads.\n\nExample:\n  piezotact campaign dictionary isotropic_triplets\n  piezotact campaign dictionary isotropic_triplets --json"
    )]
    Dictionary(dictionary::Arguments),
}

pub(crate) fn run(args: &Campaign) -> Outcome {
    match &args.command {
        CampaignCommand::Design(args) => design::run(args),
        CampaignCommand::Protocol(args) => protocol::run(args),
        CampaignCommand::Dictionary(args) => dictionary::run(args),
    }
}

/// The protocol in the file `named`, or that of the library with this name; a file is preferred.
fn protocol_of(named: &Path) -> Outcome<Protocol> {
    let name = named.to_str().unwrap_or_default();
    let in_library = from_library(name)?;
    if !reads::is_there(named) {
        return in_library.ok_or_else(|| usage(no_protocol(&named.display().to_string())));
    }
    if in_library.is_some() {
        say(&format!(
            "{name} is a file here and a protocol of the library: the file is read; rename it to use the library"
        ));
    }
    let text = read_input_text(named)?;
    read(&text)
        .map_err(|error| Failure::Data(Error::new(error).context(named.display().to_string())))
}

/// That there is no protocol called `name`.
fn no_protocol(name: &str) -> Error {
    let known: Vec<&str> = LIBRARY.iter().map(|(known, _)| *known).collect();
    anyhow!(
        "expected the file of a protocol or one of the library ({}), found neither called `{name}`; correct the name",
        known.join(", ")
    )
}
