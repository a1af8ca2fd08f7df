//! `piezotact panel average`: the people of one load and angle as one transfer function.

use anyhow::{Context as _, anyhow};
use piezotact::panel::{Cell, average_of_panel};
use piezotact_dataset::{
    PANEL_INDEX, PanelFolder, TransferDocument, TransferFormat, panel_of, write_transfer,
};
use serde_json::json;

use crate::cli::panel::Average;
use crate::commands::outputs;
use crate::failure::{Outcome, usage};
use crate::output::{doubts_json, print, print_json, say_doubts};

pub(crate) fn run(args: &Average) -> Outcome {
    let folder = PanelFolder::open(&args.folder)?;
    let listed: Vec<_> = folder
        .index
        .entries
        .iter()
        .map(|e| args.folder.join(&e.file))
        .collect();
    let mut inputs: Vec<&std::path::Path> =
        listed.iter().map(std::path::PathBuf::as_path).collect();
    let index = args.folder.join(PANEL_INDEX);
    inputs.push(&index);
    outputs(&inputs, &[&args.out])?;
    let contents = folder.read()?;
    let named = || args.folder.display().to_string();
    let panel = panel_of(&contents).with_context(named)?;
    let cell = chosen(args, panel.cells())?;
    let mut function =
        average_of_panel(&panel, cell, args.average.averaging(), args.band).with_context(named)?;
    let document = TransferDocument::of(&function, contents.drive_unit, contents.response_unit);
    write_transfer(&args.out, &document)?;
    function
        .about
        .doubts
        .extend(TransferFormat::of_ending(&args.out).losses());
    let people: Vec<&str> = panel
        .participants()
        .iter()
        .map(String::as_str)
        .filter(|who| panel.of(who, cell).next().is_some())
        .collect();
    if args.json {
        return print_json(&json!({
            "out": args.out,
            "condition": function.about.condition,
            "participants": people,
            "average": args.average.averaging(),
            "averages": function.averages,
            "provenance": function.about.provenance,
            "doubts": doubts_json(&function.about.doubts)?,
        }));
    }
    say_doubts(&function.about.doubts);
    print(&format!(
        "wrote {}: the average of {} people at {cell}",
        args.out.display(),
        people.len()
    ))
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
            "expected a load and angle at which people were measured ({}), found none that fits; take one of these with --load and --angle",
            told(&mut cells.iter())
        ))),
        _ => Err(usage(anyhow!(
            "expected one load and angle to average, found {}; choose one with --load and --angle",
            told(&mut fitting.into_iter())
        ))),
    }
}
