//! `piezotact campaign`: campaigns with volunteers, from their protocol on.

mod design;
mod dictionary;
pub(super) mod export;
mod identity;
mod join;
mod new;
mod plan;
mod protocol;
pub(super) mod run;
mod simulate;
pub(crate) mod status;
pub(crate) mod study;
mod verify;
mod withdraw;

use std::path::Path;

use anyhow::{Error, anyhow};
use clap::{Args, Subcommand};
use piezotact_dataset::{read_input_text, reads};
use piezotact_people::campaign::protocol::{LIBRARY, Protocol, read};

use crate::failure::{Failure, Outcome, usage};
use crate::output::say;

pub(super) use simulate::which::which_of;

/// How a study was simulated, in words; `None` for one with people.
pub(super) fn simulated_as(study: &study::Study) -> Outcome<Option<String>> {
    let settings = study.store.simulation::<simulate::settings::Settings>()?;
    Ok(settings.map(|settings| settings.words()))
}

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
    /// Writes a protocol of the library as a file, lists the library, or prints the data dictionary of a protocol.
    #[command(
        after_help = "The dictionary says what each column of the table of answers means, task by task; the columns are those that\n`piezotact answers` reads.\n\nExample:\n  piezotact campaign protocol\n  piezotact campaign protocol isotropic_triplets --out own.toml\n  piezotact campaign protocol isotropic_triplets --dictionary\n  piezotact campaign protocol --explain"
    )]
    Protocol(protocol::Arguments),
    /// Makes a study: a folder with the protocol, its seed, and the store of all sessions.
    #[command(
        after_help = "Example:\n  piezotact campaign new study --protocol isotropic_triplets --seed 7 --consent consent.txt"
    )]
    New(new::Arguments),
    /// Makes the folder of a further station of a study that is kept in a database.
    #[command(
        after_help = "Every station has the same protocol, seed, plans and answers; recordings and drives stay in the folder of the station where they were made.\n\nExample:\n  piezotact campaign new study --protocol isotropic_triplets --seed 7 --store postgres://lab@db.example.org/touch\n  piezotact campaign join postgres://lab@db.example.org/touch study"
    )]
    Join(join::Arguments),
    /// Prints the trials of a session as they are planned.
    #[command(
        after_help = "The plan follows from the protocol, the seed and the sessions that were completed; it is written when the session begins.\n\nExample:\n  piezotact campaign plan study P01 discrimination"
    )]
    Plan(plan::Arguments),
    /// Runs a session with a participant on the terminal, or goes on with one that was cut off.
    #[command(
        after_help = "Every answer is on the disk before it is shown as noted. /help in the session explains the keys.\n\nExample:\n  piezotact campaign run study P01 measurement --experimenter AB\n  piezotact campaign run study P01 discrimination --drives P01 --bench twin:participant=1,seed=7"
    )]
    Run(Box<run::Arguments>),
    /// Simulates a campaign with virtual volunteers on the digital twin, from their strokes to their answers.
    #[command(
        after_help = "The study that is made is read as any other: `piezotact answers STUDY`, `campaign status`, `campaign export`. A simulation that was interrupted goes on with the same command.\n\nExample:\n  piezotact campaign simulate simulated --protocol isotropic_triplets --participants 10 --seed 7"
    )]
    Simulate(simulate::Arguments),
    /// Prints where every session of a study stands.
    #[command(after_help = "Example:\n  piezotact campaign status study")]
    Status(status::Arguments),
    /// Writes the answers, the trials, the participants and the events of a study as tables.
    #[command(after_help = "Example:\n  piezotact campaign export study --out exported")]
    Export(export::Arguments),
    /// Verifies that no stored event was changed, removed or exchanged.
    #[command(after_help = "Example:\n  piezotact campaign verify study")]
    Verify(verify::Arguments),
    /// Stores or prints who the participants are, in an encrypted file of its own.
    #[command(
        after_help = "Example:\n  piezotact campaign identity study P01 --name \"A Name\" --contact a.name@example.org --signed 1 --passphrase secret.txt\n  piezotact campaign identity study --passphrase secret.txt"
    )]
    Identity(identity::Arguments),
    /// Erases everything of a participant who withdraws; a tombstone stays, with which the journals still verify.
    #[command(after_help = "Example:\n  piezotact campaign withdraw study P01")]
    Withdraw(withdraw::Arguments),
}

pub(crate) fn run(args: &Campaign) -> Outcome {
    match &args.command {
        CampaignCommand::Design(args) => design::run(args),
        CampaignCommand::Protocol(args) => protocol::run(args),
        CampaignCommand::New(args) => new::run(args),
        CampaignCommand::Join(args) => join::run(args),
        CampaignCommand::Plan(args) => plan::run(args),
        CampaignCommand::Run(args) => run::run(args),
        CampaignCommand::Simulate(args) => simulate::run(args),
        CampaignCommand::Status(args) => status::run(args),
        CampaignCommand::Export(args) => export::run(args),
        CampaignCommand::Verify(args) => verify::run(args),
        CampaignCommand::Identity(args) => identity::run(args),
        CampaignCommand::Withdraw(args) => withdraw::run(args),
    }
}

/// The protocol in the file `named`, or that of the library with this name; a file is preferred.
pub(in crate::commands) fn protocol_of(named: &Path) -> Outcome<Protocol> {
    Ok(protocol_text(named)?.0)
}

/// As [`protocol_of`], with the text that it was read from.
fn protocol_text(named: &Path) -> Outcome<(Protocol, String)> {
    let name = named.to_str().unwrap_or_default();
    let in_library = LIBRARY.iter().find(|(known, _)| *known == name);
    let text = match (reads::is_there(named), in_library) {
        (false, None) => return Err(usage(no_protocol(&named.display().to_string()))),
        (false, Some((_, toml))) => (*toml).to_owned(),
        (true, in_library) => {
            if in_library.is_some() {
                say(&format!(
                    "{name} is a file here and a protocol of the library: the file is read; rename it to use the library"
                ));
            }
            read_input_text(named)?
        }
    };
    let protocol = read(&text)
        .map_err(|error| Failure::Data(Error::new(error).context(named.display().to_string())))?;
    Ok((protocol, text))
}

/// That there is no protocol called `name`.
fn no_protocol(name: &str) -> Error {
    let known: Vec<&str> = LIBRARY.iter().map(|(known, _)| *known).collect();
    anyhow!(
        "expected the file of a protocol or one of the library ({}), found neither called `{name}`; correct the name",
        known.join(", ")
    )
}
