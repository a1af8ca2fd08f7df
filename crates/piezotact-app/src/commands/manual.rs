//! `piezotact manual`: completions for the shells, and man pages.

use std::path::PathBuf;

use anyhow::Context as _;
use clap::{Args, ValueEnum as _};
use clap_complete::{Shell, generate_to};

use crate::failure::Outcome;
use crate::output::print;

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// The folder in which `completions` and `man` are made.
    folder: PathBuf,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let made = |name: &str| -> anyhow::Result<PathBuf> {
        let folder = args.folder.join(name);
        std::fs::create_dir_all(&folder)
            .with_context(|| format!("{}: cannot be made", folder.display()))?;
        Ok(folder)
    };
    let (completions, pages) = (made("completions")?, made("man")?);
    let mut command = super::command();
    for shell in Shell::value_variants() {
        generate_to(*shell, &mut command, "piezotact", &completions)
            .with_context(|| format!("{}: cannot be written", completions.display()))?;
    }
    clap_mangen::generate_to(super::command(), &pages)
        .with_context(|| format!("{}: cannot be written", pages.display()))?;
    print(&format!("completions: {}", completions.display()))?;
    print(&format!("man pages: {}", pages.display()))
}
