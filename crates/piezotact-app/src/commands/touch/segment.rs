//! `piezotact segment`: recordings cut into strokes.

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use piezotact::doubt::merged;
use piezotact_dataset::{cuts_path, cuts_text};
use serde_json::{Value, json};

use super::{Take, tables, take_all};
use crate::advice::merged_text;
use crate::cli::{Segment, Takes};
use crate::commands::outputs;
use crate::failure::{Outcome, usage};
use crate::output::{doubts_json, print, print_json, say, write_text};
use crate::report;

/// The files that are read and written, so that nothing that is read is written.
pub(crate) fn check_outputs(takes: &Takes, written: &[&Option<PathBuf>]) -> Outcome {
    let mut read: Vec<&Path> = takes.recordings.iter().map(PathBuf::as_path).collect();
    read.extend(takes.cuts.as_deref());
    let written: Vec<&Path> = written.iter().filter_map(|path| path.as_deref()).collect();
    outputs(&read, &written)
}

pub(crate) fn run(args: &Segment) -> Outcome {
    if args.write_cuts.is_some() && args.takes.recordings.len() > 1 {
        return Err(usage(anyhow!(
            "--write-cuts is for one recording, found {}: cut one at a time",
            args.takes.recordings.len()
        )));
    }
    check_outputs(&args.takes, &[&args.write_cuts, &args.csv, &args.report])?;
    if let Some(path) = &args.write_cuts
        && path.exists()
    {
        return Err(usage(anyhow!(
            "{} is there and may hold a person's cuts: give another name, or move it away",
            path.display()
        )));
    }
    let takes = take_all(&args.takes)?;
    if let (Some(path), [take]) = (&args.write_cuts, takes.as_slice()) {
        write_text(path, &cuts_text(&take.segmentation, take.recording.rate()))?;
    }
    if let Some(path) = &args.csv {
        tables::write_cuts(path, &takes)?;
    }
    if let Some(path) = &args.report {
        write_text(path, &report::touch::cuts(&takes)?)?;
    }
    if args.json {
        let recordings = takes.iter().map(cuts_json).collect::<Outcome<Vec<_>>>()?;
        return print_json(&json!({ "recordings": recordings }));
    }
    for take in &takes {
        for doubt in merged(&take.doubts()) {
            say(&format!("doubt: {}: {}", take.name, merged_text(&doubt)));
        }
        print(&summary(take))?;
    }
    for path in [&args.write_cuts, &args.csv, &args.report]
        .into_iter()
        .flatten()
    {
        print(&format!("wrote {}", path.display()))?;
    }
    Ok(())
}

fn summary(take: &Take) -> String {
    let segmentation = &take.segmentation;
    let mut text = format!(
        "{}: {} stroke{}, {} rejected",
        take.name,
        segmentation.strokes.len(),
        if segmentation.strokes.len() == 1 {
            ""
        } else {
            "s"
        },
        segmentation.rejected.len()
    );
    let seconds = |sample: usize| take.recording.rate().duration_of(sample).0;
    for stroke in &segmentation.strokes {
        let (from, to) = (seconds(stroke.steady.start), seconds(stroke.steady.end));
        text += &format!(
            "\n  stroke    {from:9.3} – {to:9.3} s  ({:.3} s)",
            to - from
        );
    }
    for rejected in &segmentation.rejected {
        let (from, to) = (
            seconds(rejected.interval.start),
            seconds(rejected.interval.end),
        );
        text += &format!("\n  rejected  {from:9.3} – {to:9.3} s  {}", rejected.reason);
    }
    if let Some(file) = &segmentation.cuts {
        text += &format!("\n  with the cuts of {file}");
    }
    text
}

/// A recording's strokes and rejects.
pub(crate) fn cuts_json(take: &Take) -> Outcome<Value> {
    let segmentation = &take.segmentation;
    let s = |sample: usize| take.recording.rate().duration_of(sample).0;
    let strokes: Vec<Value> = segmentation
        .strokes
        .iter()
        .map(|stroke| {
            json!({
                "start_s": s(stroke.steady.start),
                "end_s": s(stroke.steady.end),
                "contact_start_s": s(stroke.contact.start),
                "contact_end_s": s(stroke.contact.end),
                "cut_by": stroke.cut_by,
                "criteria": stroke.criteria,
            })
        })
        .collect();
    let rejected: Vec<Value> = segmentation
        .rejected
        .iter()
        .map(|rejected| {
            json!({
                "start_s": s(rejected.interval.start),
                "end_s": s(rejected.interval.end),
                "reason": rejected.reason,
                "text": rejected.reason.to_string(),
                "criteria": rejected.criteria,
            })
        })
        .collect();
    Ok(json!({
        "file": take.path,
        "rate_hz": take.recording.rate(),
        "duration_s": take.recording.duration(),
        "condition": take.condition(),
        "labels": take.labels,
        "roles": segmentation.roles,
        "cut": segmentation.rule,
        "cuts_file": segmentation.cuts,
        "strokes": strokes,
        "rejected": rejected,
        "doubts": doubts_json(&take.doubts())?,
        "cuts_are_looked_for_in": cuts_path(&take.path),
    }))
}
