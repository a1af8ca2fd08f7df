//! `piezotact panel analyse`: what a panel says.

use std::path::Path;

use anyhow::{Context as _, anyhow};
use piezotact::panel::{
    AnalysedPanel, Cleaning, Panel, PanelConfig, PanelOrigin, analyse, without_artefact,
};
use piezotact::quantity::Uncalibrated;
use piezotact_dataset::{PanelFolder, function_of_any_unit, panel_of, read_transfer};

use crate::cli::panel::Analyse;
use crate::deliver::deliver;
use crate::failure::{Outcome, usage};
use crate::places::outputs;

type AnyPanel = Panel<Uncalibrated, Uncalibrated>;

pub(crate) fn run(args: &Analyse) -> Outcome {
    let folder = checked(args)?;
    let contents = folder.read()?;
    let named = || args.folder.display().to_string();
    let panel = panel_of(&contents).with_context(named)?;
    let (panel, cleaning) = cleaned(args, panel)?;
    let mut config = PanelConfig::usual(args.band, args.seed);
    config.averaging = args.average.averaging();
    config.criterion.db_rms = args.criterion;
    let said = analyse(&panel, &config).with_context(named)?;
    let origin = PanelOrigin {
        kind: folder.index.kind,
        accepted: folder.accepted(),
        bench: folder.index.bench.as_deref(),
        units: [&contents.drive_unit, &contents.response_unit],
    };
    let analysed = AnalysedPanel::of(&said, &panel, origin, cleaning.as_ref());
    deliver(&args.outputs, &analysed)
}

/// The folder, unless the criterion is none or an output would replace something of it.
fn checked(args: &Analyse) -> Outcome<PanelFolder> {
    if !(args.criterion.is_finite() && args.criterion > 0.0) {
        return Err(usage(anyhow!(
            "expected a criterion above zero in dB, found {}; 3 is usual",
            args.criterion
        )));
    }
    let folder = PanelFolder::open(&args.folder)?;
    let entries = folder.index.entries.iter();
    let mut read: Vec<_> = entries.map(|e| args.folder.join(&e.file)).collect();
    read.push(args.folder.join(piezotact_dataset::PANEL_INDEX));
    read.extend(args.control.clone());
    let read: Vec<&Path> = read.iter().map(AsRef::as_ref).collect();
    outputs(&read, &args.outputs.files())?;
    Ok(folder)
}

/// The panel, with the bench's artefact taken out of every measurement where there is a control measurement.
fn cleaned(args: &Analyse, panel: AnyPanel) -> Outcome<(AnyPanel, Option<Cleaning>)> {
    let Some(path) = &args.control else {
        return Ok((panel, None));
    };
    let control = function_of_any_unit(&read_transfer(path)?, path)?;
    let cleaned = without_artefact(&panel, control, args.band);
    let (panel, cleaning) = cleaned.with_context(|| path.display().to_string())?;
    Ok((panel, Some(cleaning)))
}
