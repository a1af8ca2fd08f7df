//! `piezotact panel`: transfer functions of a panel of people, measured, filed, analysed and averaged.

mod add;
mod analyse;
mod average;
mod run;

use std::path::Path;

use anyhow::anyhow;
use piezotact_dataset::PanelFolder;

use crate::cli::panel::{Panel, PanelCommand};
use crate::failure::Outcome;

pub(crate) fn run(args: &Panel) -> Outcome {
    match &args.command {
        PanelCommand::Run(args) => run::run(args),
        PanelCommand::Add(args) => add::run(args),
        PanelCommand::Analyse(args) => analyse::run(args),
        PanelCommand::Average(args) => average::run(args),
    }
}

/// The panel in a folder, which is made where there is none.
fn open_or_begin(folder: &Path) -> Outcome<PanelFolder> {
    std::fs::create_dir_all(folder).map_err(|error| {
        anyhow!(
            "cannot create the folder {}: {error}; check the path",
            folder.display()
        )
    })?;
    Ok(PanelFolder::open_or_begin(folder)?)
}
