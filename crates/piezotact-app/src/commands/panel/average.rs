//! `piezotact panel average`: the people of one load and angle as one transfer function.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, anyhow};
use piezotact::document::Kept;
use piezotact::panel::{Cell, average_of_panel};
use piezotact_dataset::{
    PANEL_INDEX, PanelFolder, TransferDocument, TransferFormat, panel_of, write_transfer,
};

use crate::cli::panel::Average;
use crate::deliver::deliver_and;
use crate::failure::{Outcome, usage};
use crate::places::outputs;

pub(crate) fn run(args: &Average) -> Outcome {
    let folder = PanelFolder::open(&args.folder)?;
    check_output(args, &folder)?;
    let contents = folder.read()?;
    let named = || args.folder.display().to_string();
    let panel = panel_of(&contents).with_context(named)?;
    let cell = chosen(args, panel.cells())?;
    let mut averaged =
        average_of_panel(&panel, cell, args.average.averaging(), args.band).with_context(named)?;
    averaged.units = [contents.drive_unit, contents.response_unit];
    let [drive_unit, response_unit] = averaged.units.clone();
    let stored = TransferDocument::of(&averaged.function, drive_unit, response_unit);
    write_transfer(&args.out, &stored)?;
    let warnings = &mut averaged.function.about.warnings;
    warnings.extend(TransferFormat::of_ending(&args.out).losses());
    let averaged = Kept {
        out: &args.out,
        value: &averaged,
    };
    deliver_and(&args.outputs, &averaged, &[&args.out])
}

/// Refuses an output that would replace the panel.
fn check_output(args: &Average, folder: &PanelFolder) -> Outcome {
    let entries = folder.index.entries.iter();
    let mut inputs: Vec<PathBuf> = entries.map(|e| args.folder.join(&e.file)).collect();
    inputs.push(args.folder.join(PANEL_INDEX));
    let inputs: Vec<&Path> = inputs.iter().map(PathBuf::as_path).collect();
    let out = std::iter::once(args.out.as_path());
    let written: Vec<&Path> = out.chain(args.outputs.files()).collect();
    outputs(&inputs, &written)
}

/// The cell that is meant.
fn chosen(args: &Average, cells: &[Cell]) -> Outcome<Cell> {
    let fits = |cell: &&Cell| {
        let same =
            |asked: Option<f64>, found: f64| asked.is_none_or(|asked| (asked - found).abs() < 1e-9);
        same(args.load, cell.load_n.0) && same(args.angle, cell.angle_deg.0)
    };
    let fitting: Vec<&Cell> = cells.iter().filter(fits).collect();
    let told = |cells: &mut dyn Iterator<Item = &Cell>| {
        let names: Vec<String> = cells.map(ToString::to_string).collect();
        names.join("; ")
    };
    match fitting[..] {
        [only] => Ok(*only),
        [] => Err(usage(anyhow!(
            "expected a measured load and angle ({}), found no match; choose one of these with --load and --angle",
            told(&mut cells.iter())
        ))),
        _ => Err(usage(anyhow!(
            "expected one load and angle to average, found {}; choose one with --load and --angle",
            told(&mut fitting.into_iter())
        ))),
    }
}
