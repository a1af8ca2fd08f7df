//! `piezotact panel analyse`: what a panel says.

use std::path::Path;

use anyhow::{Context as _, anyhow};
use piezotact::criterion::Outcome as Judged;
use piezotact::panel::{
    Artefact, ArtefactConfig, Dip, Entry, Filing, Panel, PanelAnalysis, PanelConfig, analyse,
    artefact_of,
};
use piezotact::quantity::Uncalibrated;
use piezotact::transfer::TransferFunction;
use piezotact_dataset::{PanelFolder, function_of_any_unit, panel_of, read_transfer};
use serde_json::{Value, json};

use crate::cli::panel::Analyse;
use crate::commands::outputs;
use crate::failure::{Outcome, usage};
use crate::output::{counted, doubts_json, print, print_json, say_doubts, write_text};
use crate::report::panel::{
    Cleaning, Page, enough_text, falls_text, needed_text, render, share_text, will_do_word as word,
};

type Function = TransferFunction<Uncalibrated, Uncalibrated>;
type AnyPanel = Panel<Uncalibrated, Uncalibrated>;

pub(crate) fn run(args: &Analyse) -> Outcome {
    if !(args.criterion.is_finite() && args.criterion > 0.0) {
        return Err(usage(anyhow!(
            "expected a criterion above zero in dB, found {}; 3 is usual",
            args.criterion
        )));
    }
    let written: Vec<&Path> = [&args.report, &args.csv]
        .into_iter()
        .flatten()
        .map(AsRef::as_ref)
        .collect();
    let folder = PanelFolder::open(&args.folder)?;
    let mut read: Vec<_> = folder
        .index
        .entries
        .iter()
        .map(|e| args.folder.join(&e.file))
        .collect();
    read.push(args.folder.join(piezotact_dataset::PANEL_INDEX));
    read.extend(args.control.clone());
    let read: Vec<&Path> = read.iter().map(AsRef::as_ref).collect();
    outputs(&read, &written)?;
    let contents = folder.read()?;
    let named = || args.folder.display().to_string();
    let mut panel = panel_of(&contents).with_context(named)?;
    let cleaning = match &args.control {
        Some(path) => {
            let (cleaned, cleaning) = without_artefact(&panel, path, args)?;
            panel = cleaned;
            Some(cleaning)
        }
        None => None,
    };
    let mut config = PanelConfig::usual(args.band, args.seed);
    config.averaging = args.average.averaging();
    config.criterion.db_rms = args.criterion;
    let said = analyse(&panel, &config).with_context(named)?;
    if let Some(path) = &args.csv {
        write_text(path, &table(&said)?)?;
    }
    if let Some(path) = &args.report {
        let page = Page {
            said: &said,
            panel: &panel,
            folder: &folder,
            drive_unit: &contents.drive_unit,
            response_unit: &contents.response_unit,
            cleaning: cleaning.as_ref(),
        };
        write_text(path, &render(&page)?)?;
    }
    if args.json {
        return print_json(&result(&said, &folder, cleaning.as_ref())?);
    }
    say_doubts(&said.doubts);
    print(&words(&said).join("\n"))?;
    if let Some(path) = &args.report {
        print(&format!("report: {}", path.display()))?;
    }
    Ok(())
}

/// The panel with the bench's artefact taken out of every measurement, and what that did.
fn without_artefact(
    panel: &AnyPanel,
    path: &Path,
    args: &Analyse,
) -> Outcome<(AnyPanel, Cleaning)> {
    let named = || path.display().to_string();
    let control: Function = function_of_any_unit(read_transfer(path)?, path)?;
    let artefact: Artefact =
        artefact_of(&control, &ArtefactConfig::usual(args.band)).with_context(named)?;
    let mut dips: Vec<(Filing, Dip, Dip)> = Vec::new();
    let mut entries = Vec::new();
    for entry in panel.entries() {
        let removed = artefact.removed_from(&entry.function).with_context(named)?;
        dips.push((entry.filing.clone(), removed.before, removed.after));
        entries.push(Entry {
            filing: entry.filing.clone(),
            function: removed.function,
        });
    }
    let mut cleaned = Panel::new(entries)?;
    cleaned.doubts.extend(panel.doubts.iter().cloned());
    cleaned.doubts.extend(artefact.doubts.iter().cloned());
    let example = panel.entries().first().map(|entry| entry.function.clone());
    Ok((
        cleaned,
        Cleaning {
            control,
            artefact,
            dips,
            before: example,
        },
    ))
}

fn words(said: &PanelAnalysis) -> Vec<String> {
    let mut lines = vec![format!(
        "{}, {}, {}, {}",
        counted(said.participants.len(), "participant"),
        counted(said.measurements, "measurement"),
        match said.cells.len() {
            1 => "1 load and angle".into(),
            many => format!("{many} loads and angles"),
        },
        said.config.band
    )];
    if let Some(worst) = &said.worst {
        let sure = worst.share.map_or(String::new(), |share| {
            format!(
                ", the worst in {:.0} % of draws of half of them",
                share * 100.0
            )
        });
        let found = if worst.outcome() == Judged::Met {
            "people lie furthest apart at"
        } else {
            "where people lie furthest apart is not decided; as measured, at"
        };
        lines.push(format!(
            "{found} {}: {:.1} dB at {:.0} Hz{sure}",
            worst.cell, worst.max_deviation_db, worst.at_hz
        ));
    }
    for falls in &said.falls {
        let each: Vec<String> = falls
            .loads_n
            .iter()
            .zip(&falls.deviations_db)
            .map(|(load, db)| format!("{load}: {db:.1} dB"))
            .collect();
        lines.push(format!(
            "maximum deviation at {}°: {}; {}",
            falls.angle_deg.0,
            each.join(", "),
            falls_text(falls)
        ));
    }
    if let Some((cell, costs)) = said
        .judged()
        .and_then(|cell| Some((cell, said.penalties_at(cell)?)))
    {
        let interval = costs.interval_db_rms.map_or(String::new(), |[low, high]| {
            format!(" (95 %: {low:.1} to {high:.1})")
        });
        lines.push(format!(
            "will the average do at {cell}? {}: a new person is {:.1} dB rms off{interval}, criterion {} dB for the interval and {:.0} % of people; {}; most for {}: {:.1} dB",
            word(costs.verdict.outcome),
            costs.mean_db_rms,
            costs.verdict.criterion.db_rms,
            costs.verdict.criterion.least_share * 100.0,
            share_text(costs),
            costs.worst.participant,
            costs.worst.db_rms
        ));
        lines.extend(needed_text(costs));
        let curve = said.learning.iter().find(|curve| curve.cell.is(cell));
        lines.extend(curve.map(|curve| {
            format!(
                "for more people in the average to gain less than {} dB: {}",
                curve.within_db,
                enough_text(curve)
            )
        }));
    }
    lines
}

fn result(
    said: &PanelAnalysis,
    folder: &PanelFolder,
    cleaning: Option<&Cleaning>,
) -> Outcome<Value> {
    let mut value = serde_json::to_value(said)?;
    if let Some(fields) = value.as_object_mut() {
        fields.insert("doubts".into(), doubts_json(&said.doubts)?);
        fields.insert("kind".into(), json!(folder.index.kind));
        fields.insert("accepted".into(), json!(folder.accepted()));
        fields.insert("judged".into(), json!(said.judged()));
        let costs = said.judged().and_then(|cell| said.penalties_at(cell));
        fields.insert(
            "will_the_average_do".into(),
            json!(costs.map(|c| word(c.verdict.outcome))),
        );
        if let Some(cleaning) = cleaning {
            let dips: Vec<Value> = cleaning
                .dips
                .iter()
                .map(|(filing, before, after)| json!({"of": filing, "before": before, "after": after}))
                .collect();
            fields.insert(
                "artefact".into(),
                json!({
                    "at_hz": cleaning.artefact.at_hz,
                    "depth_db": cleaning.artefact.depth_db,
                    "window_hz": cleaning.artefact.window_hz,
                    "fingers": dips,
                }),
            );
        }
    }
    Ok(value)
}

/// One row for each cell and band; the whole band first.
fn table(said: &PanelAnalysis) -> Outcome<String> {
    let mut rows = csv::Writer::from_writer(Vec::new());
    rows.write_record([
        "angle_deg",
        "load_n",
        "low_hz",
        "high_hz",
        "participants",
        "max_deviation_db",
        "at_hz",
        "spread_rms_db",
        "penalty_db_rms",
    ])?;
    for spread in &said.spreads {
        let bundle = &spread.bundle;
        let whole = said
            .penalties_at(spread.cell)
            .map_or(f64::NAN, |c| c.mean_db_rms);
        let first = (
            said.config.band,
            [
                bundle.max_deviation_db,
                bundle.max_deviation_at_hz,
                spread.spread_rms_db,
                whole,
            ],
        );
        let parts = spread.bands.iter().map(|part| {
            let values = [
                part.max_deviation_db,
                part.at_hz,
                part.spread_rms_db,
                part.penalty_db_rms,
            ];
            (part.band_hz, values)
        });
        for (band, values) in std::iter::once(first).chain(parts) {
            let mut row = vec![
                spread.cell.angle_deg.0.to_string(),
                spread.cell.load_n.0.to_string(),
                band.low().0.to_string(),
                band.high().0.to_string(),
                bundle.count.to_string(),
            ];
            row.extend(values.map(|value| value.to_string()));
            rows.write_record(&row)?;
        }
    }
    let bytes = rows
        .into_inner()
        .map_err(|error| anyhow!("the table could not be made: {error}"))?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
