//! `piezotact twin`: recordings, surfaces and numbers of the digital twin.

#[cfg(feature = "study")]
mod eeg;
mod record;
#[cfg(feature = "surface")]
pub(crate) mod surface;

use std::path::Path;

use anyhow::anyhow;
use piezotact_dataset::read_input_text;
use piezotact_twin::{PARAMETERS, TwinParameters};

use crate::cli::twin::{Parameters, Twin, TwinCommand};
use crate::failure::{Failure, Outcome};
use crate::output::print;

/// In place of the EEG of a person.
#[cfg(not(feature = "study"))]
mod eeg {
    use piezotact_twin::TwinParameters;

    use crate::cli::twin::Record;
    use crate::failure::Outcome;

    pub(super) fn run(_: &Record, _: &TwinParameters) -> Outcome {
        crate::commands::lacking::other("--bench eeg")
    }
}

#[cfg(not(feature = "surface"))]
super::lacking::lacking! { surface(Arguments), "twin surface"; }

pub(crate) fn run(args: &Twin) -> Outcome {
    match &args.command {
        TwinCommand::Record(args) => record::run(args),
        TwinCommand::Surface(args) => surface::run(args),
        TwinCommand::Plant(args) => super::sound::plant::run(args),
        TwinCommand::Parameters(args) => show(args),
    }
}

/// The twin's numbers, with what a laboratory's own file changes.
pub(crate) fn twin_parameters(file: Option<&Path>) -> Outcome<TwinParameters> {
    let Some(file) = file else {
        return Ok(TwinParameters::built_in());
    };
    let text = read_input_text(file).map_err(|error| {
        Failure::Data(anyhow!(
            "{}: expected a parameter file, see `piezotact twin parameters`: {error}",
            file.display()
        ))
    })?;
    TwinParameters::changed_by(&text).map_err(|error| {
        Failure::Data(anyhow::Error::new(error).context(file.display().to_string()))
    })
}

fn show(args: &Parameters) -> Outcome {
    let Some(file) = &args.twin else {
        return print(PARAMETERS.trim_end());
    };
    let parameters = twin_parameters(Some(file))?;
    match parameters.changes() {
        [] => print("no parameter is changed"),
        changes => print(&changes.join("\n")),
    }
}
