//! The options of what goes to other devices and programs.

use std::path::PathBuf;

use clap::Args;

use super::Reading;

#[derive(Debug, Args)]
pub(crate) struct Export {
    /// A recording, a drive, a haptic file or a transfer function.
    pub(crate) input: PathBuf,
    /// The file to write: .wav, .hjif, .haptic, .ahap, or .uff.
    #[arg(long)]
    #[cfg_attr(
        not(feature = "haptic"),
        arg(
            help = "The file to write: .wav or .uff; .hjif, .haptic and .ahap are not in this build: ./x build has them"
        )
    )]
    pub(crate) out: PathBuf,
    #[command(flatten)]
    pub(crate) reading: Reading,
    /// The channel; optional if there is only one, or only one of acceleration. By default, a universal file (.uff) holds all channels.
    #[arg(long)]
    pub(crate) channel: Option<String>,
    /// The transfer function of the device that a .hjif file is for: its gain, band and resonance are written to the file.
    #[arg(long, value_name = "TF.json")]
    pub(crate) transfer: Option<PathBuf>,
    /// Prints the result as JSON.
    #[arg(long)]
    pub(crate) json: bool,
}
