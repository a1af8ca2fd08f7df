//! `piezotact panel add`: transfer functions that were measured elsewhere.

use std::path::Path;

use anyhow::{Context as _, anyhow};
use piezotact::panel::{Cell, Entry, Filing, Panel};
use piezotact::quantity::{Degrees, Newtons, Uncalibrated};
use piezotact_dataset::document::PanelAddDocument;
use piezotact_dataset::{PanelFolder, TransferDocument, function_of_any_unit, read_transfer};

use super::open_or_begin;
use crate::cli::panel::Add;
use crate::deliver::{Outputs, deliver};
use crate::failure::{Failure, Outcome, usage};
use crate::output::say;

pub(crate) fn run(args: &Add) -> Outcome {
    require_finite(args)?;
    // Everything is read, and fits together, before anything is written.
    let mut documents = Vec::new();
    for path in &args.files {
        documents.push((path.as_path(), read_transfer(path)?));
    }
    let mut folder = open_or_begin(&args.folder)?;
    let mut entries = if folder.index.entries.is_empty() {
        Vec::new()
    } else {
        folder.read()?.panel
    };
    let filed = new_of(args, documents, &folder, &mut entries)?;
    Panel::<Uncalibrated, Uncalibrated>::new(entries)
        .with_context(|| args.folder.display().to_string())?;
    for (filing, document) in &filed {
        folder.file(filing, document)?;
    }
    let added = PanelAddDocument {
        folder: &args.folder,
        filed: filed.iter().map(|(filing, _)| filing).collect(),
        measurements: folder.index.entries.len(),
    };
    deliver(
        &Outputs {
            json: args.json,
            ..Outputs::default()
        },
        &added,
    )
}

/// The transfer functions among `documents` that the panel has not yet, added to its `entries`.
fn new_of(
    args: &Add,
    documents: Vec<(&Path, TransferDocument)>,
    folder: &PanelFolder,
    entries: &mut Vec<Entry<Uncalibrated, Uncalibrated>>,
) -> Outcome<Vec<(Filing, TransferDocument)>> {
    let there = entries.len();
    let mut filed: Vec<(Filing, TransferDocument)> = Vec::new();
    for (path, mut document) in documents {
        let filing = filing_of(args, path, &mut document, folder, &filed)?;
        let function = function_of_any_unit(&document, path)?;
        let entry = Entry { filing, function };
        if let Some(same) = entries[..there].iter().find(|one| is_same(one, &entry)) {
            say(&format!(
                "{} is there already as {}",
                path.display(),
                same.filing
            ));
            continue;
        }
        filed.push((entry.filing.clone(), document));
        entries.push(entry);
    }
    Ok(filed)
}

/// Whether `there` is the measurement `new`, which a command that was killed had added.
fn is_same(
    there: &Entry<Uncalibrated, Uncalibrated>,
    new: &Entry<Uncalibrated, Uncalibrated>,
) -> bool {
    let (a, b) = (&there.filing, &new.filing);
    a.participant == b.participant
        && a.cell.is(b.cell)
        && a.placement == b.placement
        && there.function.response() == new.function.response()
}

fn require_finite(args: &Add) -> Outcome {
    let mut stated = [args.load, args.angle].into_iter().flatten();
    match stated.find(|v| !v.is_finite()) {
        Some(found) => Err(usage(anyhow!(
            "expected a number for --load and --angle, found {found}; state it in N and degrees"
        ))),
        None => Ok(()),
    }
}

/// Under what a transfer function goes: what it says of itself, or else what the person says.
fn filing_of(
    args: &Add,
    path: &Path,
    document: &mut TransferDocument,
    folder: &PanelFolder,
    filed: &[(Filing, TransferDocument)],
) -> Outcome<Filing> {
    let lacks = |what: &str, option: &str| -> Failure {
        anyhow!(
            "{}: expected the {what}, found none; state it with {option}",
            path.display()
        )
        .into()
    };
    let known = &mut document.about.condition;
    let participant = args
        .participant
        .clone()
        .or_else(|| known.participant.clone());
    let load_n = args.load.map(Newtons).or(known.load_n);
    let angle_deg = args.angle.map(Degrees).or(known.angle_deg);
    let participant = participant.ok_or_else(|| lacks("participant", "--participant"))?;
    let cell = Cell {
        load_n: load_n.ok_or_else(|| lacks("load", "--load"))?,
        angle_deg: angle_deg.ok_or_else(|| lacks("angle", "--angle"))?,
    };
    // What the file states stays, and is compared with what it is filed under.
    known.participant.get_or_insert_with(|| participant.clone());
    known.load_n.get_or_insert(cell.load_n);
    known.angle_deg.get_or_insert(cell.angle_deg);
    let first = Filing {
        participant,
        cell,
        placement: args.placement,
        repeat: 1,
    };
    let there = folder.index.entries.iter().map(|entry| &entry.filing);
    let there = there.chain(filed.iter().map(|(filing, _)| filing));
    let repeat = match args.repeat {
        Some(repeat) if filed.is_empty() => repeat,
        _ => next_repeat(&first, there),
    };
    Ok(Filing { repeat, ..first })
}

/// The number of the next repeat of the placement of `filing`.
fn next_repeat<'a>(filing: &Filing, there: impl Iterator<Item = &'a Filing>) -> u32 {
    let same = there.filter(|f| {
        f.participant == filing.participant
            && f.cell.is(filing.cell)
            && f.placement == filing.placement
    });
    let last = same.map(|f| f.repeat).max();
    last.map_or(1, |last| last.saturating_add(1))
}
