//! The command line of `piezotact manipulate`: operations in the order in which they are given.

use std::path::PathBuf;

use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};
use piezotact::quantity::{Band, Measure};
use piezotact_dataset::recording_formats;

use super::Reading;
use crate::deliver::Outputs;
use crate::manipulations::{MANIPULATIONS, Requested};

#[derive(Debug, Args)]
pub(crate) struct Manipulate {
    #[arg(help = format!("The texture: a recording in m/s² ({})", recording_formats()))]
    pub(crate) input: PathBuf,
    /// The texture to write (WAV, 32-bit float); its sidecar is written beside it.
    #[arg(long, value_name = "OUT.wav")]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) operations: Operations,
    /// Uses one stroke of INPUT, numbered from 1 and with the movement of the hand (the gesture) filtered out, instead of
    /// the whole recording; RECORDING.cuts is applied.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) stroke: Option<u32>,
    /// The stroke of the other recordings; default: that of --stroke.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(crate) of_stroke: Option<u32>,
    /// The band in which --rms-of measures both levels; default: all frequencies.
    #[arg(long, value_name = "LOW..HIGH", requires = "rms-of")]
    pub(crate) rms_band: Option<Band>,
    /// Seed of the random phases of --randomise-phases.
    #[arg(long, default_value_t = 1)]
    pub(crate) seed: u64,
    /// The channel; optional if there is only one, or only one of acceleration.
    #[arg(long)]
    pub(crate) channel: Option<String>,
    /// The channel of the other recordings.
    #[arg(long)]
    pub(crate) of_channel: Option<String>,
    /// What the number 1 in the other recordings means; default: what they state, otherwise --scale.
    #[arg(long, value_name = "VALUE UNIT")]
    pub(crate) of_scale: Option<Measure>,
    #[command(flatten)]
    pub(crate) reading: Reading,
    #[command(flatten)]
    pub(crate) outputs: Outputs,
}

/// The operations, in the order of the command line. Each is an option of its own, as options are everywhere here;
/// what a derived parser would lose is their order, so it is put together from where they stood.
#[derive(Clone, Debug)]
pub(crate) struct Operations(pub(crate) Vec<Requested>);

/// The heading of the operations in the help.
pub(crate) const OPERATIONS: &str = "Operations, applied in the order given";

impl Args for Operations {
    fn augment_args(command: Command) -> Command {
        MANIPULATIONS.iter().fold(command, |command, row| {
            let arg = Arg::new(row.option)
                .long(row.option)
                .help(row.help)
                .help_heading(OPERATIONS);
            command.arg(match row.form {
                None => arg.action(ArgAction::SetTrue),
                Some(form) => arg
                    .value_name(form)
                    .action(ArgAction::Append)
                    .allow_hyphen_values(true)
                    .value_parser(row.read),
            })
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for Operations {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let mut placed: Vec<(usize, Requested)> = Vec::new();
        for row in &MANIPULATIONS {
            if row.form.is_none() {
                if matches.get_flag(row.option) {
                    let at = matches.index_of(row.option);
                    placed.extend(at.zip((row.read)("").ok()));
                }
                continue;
            }
            let places = matches.indices_of(row.option).into_iter().flatten();
            let requested = matches.get_many::<Requested>(row.option);
            placed.extend(places.zip(requested.into_iter().flatten().cloned()));
        }
        placed.sort_by_key(|(at, _)| *at);
        Ok(Self(placed.into_iter().map(|(_, one)| one).collect()))
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}
