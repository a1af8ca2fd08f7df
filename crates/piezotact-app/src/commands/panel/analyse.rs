//! `piezotact panel analyse`: what a panel says.

use std::path::Path;

use anyhow::{Context as _, anyhow};
use piezotact::criterion::Outcome as Judged;
use piezotact::panel::{
    AnalysedPanel, ArtefactConfig, Cell, CellPenalties, Cleaning, FallsWithLoad, Panel,
    PanelAnalysis, PanelConfig, WorstCase, analyse, panel_curves, without_artefact,
};
use piezotact::quantity::Uncalibrated;
use piezotact_dataset::{PanelFolder, function_of_any_unit, panel_of, read_transfer};
use piezotact_report::panel::{Page, html};
use piezotact_report::report;

use crate::advice::OptionWords;
use crate::cli::panel::Analyse;
use crate::failure::{Outcome, usage};
use crate::invocation::write_report;
use crate::output::{counted, print, print_document, say_warnings, write_text};
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
    if let Some(path) = &args.csv {
        write_text(path, &report::csv(&said.table())?)?;
    }
    let kind = folder.index.kind;
    let analysed = AnalysedPanel::of(&said, kind, folder.accepted(), cleaning.as_ref());
    if let Some(path) = &args.report {
        let page = Page {
            analysed: &analysed,
            panel: &panel,
            curves: &panel_curves(&panel, &said, cleaning.as_ref()).with_context(named)?,
            bench: folder.index.bench.as_deref(),
            drive_unit: &contents.drive_unit,
            response_unit: &contents.response_unit,
        };
        write_report(path, &html(&page, &OptionWords)?)?;
    }
    if args.json {
        return print_document(&analysed);
    }
    say_warnings(&said.warnings);
    print(&words(&said).join("\n"))?;
    if let Some(path) = &args.report {
        print(&format!("report: {}", path.display()))?;
    }
    Ok(())
}

/// The folder, unless the criterion is none or an output would replace something of it.
fn checked(args: &Analyse) -> Outcome<PanelFolder> {
    if !(args.criterion.is_finite() && args.criterion > 0.0) {
        return Err(usage(anyhow!(
            "expected a criterion above zero in dB, found {}; 3 is usual",
            args.criterion
        )));
    }
    let written = [&args.report, &args.csv].into_iter().flatten();
    let written: Vec<&Path> = written.map(AsRef::as_ref).collect();
    let folder = PanelFolder::open(&args.folder)?;
    let entries = folder.index.entries.iter();
    let mut read: Vec<_> = entries.map(|e| args.folder.join(&e.file)).collect();
    read.push(args.folder.join(piezotact_dataset::PANEL_INDEX));
    read.extend(args.control.clone());
    let read: Vec<&Path> = read.iter().map(AsRef::as_ref).collect();
    outputs(&read, &written)?;
    Ok(folder)
}

/// The panel, with the bench's artefact taken out of every measurement where there is a control measurement.
fn cleaned(args: &Analyse, panel: AnyPanel) -> Outcome<(AnyPanel, Option<Cleaning>)> {
    let Some(path) = &args.control else {
        return Ok((panel, None));
    };
    let control = function_of_any_unit(&read_transfer(path)?, path)?;
    let config = ArtefactConfig::usual(args.band);
    let cleaned = without_artefact(&panel, control, &config);
    let (panel, cleaning) = cleaned.with_context(|| path.display().to_string())?;
    Ok((panel, Some(cleaning)))
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
    lines.extend(said.worst.as_ref().map(worst_words));
    lines.extend(said.falls.iter().map(falls_words));
    if let Some((cell, costs)) = said
        .judged()
        .and_then(|cell| Some((cell, said.penalties_at(cell)?)))
    {
        lines.push(average_words(cell, costs));
        lines.extend(costs.needed_text());
        let curve = said.learning.iter().find(|curve| curve.cell.is(cell));
        lines.extend(curve.map(|curve| {
            format!(
                "number of participants beyond which one more improves the average by less than {} dB: {}",
                curve.within_db,
                curve.enough_text()
            )
        }));
    }
    lines
}

/// Where participants differ most.
fn worst_words(worst: &WorstCase) -> String {
    let sure = worst.share.map_or(String::new(), |share| {
        format!(
            ", the largest in {:.0} % of random halves of the participants",
            share * 100.0
        )
    });
    let found = if worst.outcome() == Judged::Met {
        "largest difference between participants at"
    } else {
        "condition of the largest difference between participants not decided; in this panel at"
    };
    format!(
        "{found} {}: {:.1} dB at {:.0} Hz{sure}",
        worst.cell, worst.max_deviation_db, worst.at_hz
    )
}

/// How the maximum deviation depends on load at one angle.
fn falls_words(falls: &FallsWithLoad) -> String {
    let each: Vec<String> = falls
        .loads_n
        .iter()
        .zip(&falls.deviations_db)
        .map(|(load, db)| format!("{load}: {db:.1} dB"))
        .collect();
    format!(
        "maximum deviation at {}°: {}; {}",
        falls.angle_deg.0,
        each.join(", "),
        falls.text()
    )
}

/// Whether the average is sufficient in one cell.
fn average_words(cell: Cell, costs: &CellPenalties) -> String {
    let interval = costs.interval_db_rms.map_or(String::new(), |[low, high]| {
        format!(" (95 %: {low:.1} to {high:.1})")
    });
    format!(
        "is the average sufficient at {cell}? {}: error for a new participant {:.1} dB rms{interval}, criterion {} dB for \
         the interval and for {:.0} % of participants; {}; largest for {}: {:.1} dB",
        costs.verdict.outcome.answer(),
        costs.mean_db_rms,
        costs.verdict.criterion.db_rms,
        costs.verdict.criterion.least_share * 100.0,
        costs.share_text(),
        costs.worst.participant,
        costs.worst.db_rms
    )
}
