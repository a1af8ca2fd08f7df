//! `piezotact segment`: recordings cut into strokes.

use anyhow::anyhow;
use piezotact::doubt::merged;
use piezotact::study::Take;
use piezotact_dataset::cuts_text;
use serde_json::{Value, json};

use super::{check_outputs, tables, take_all};
use crate::advice::merged_text;
use crate::cli::Segment;
use crate::failure::{Outcome, usage};
use crate::output::{doubts_json, print, print_json, say, write_text};
use crate::report;

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
        print(&take.cuts_text())?;
    }
    for path in [&args.write_cuts, &args.csv, &args.report]
        .into_iter()
        .flatten()
    {
        print(&format!("wrote {}", path.display()))?;
    }
    Ok(())
}

/// A recording's strokes and rejects.
pub(crate) fn cuts_json(take: &Take) -> Outcome<Value> {
    let segmentation = &take.segmentation;
    let s = |sample: usize| take.seconds(sample);
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
        "file": take.file,
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
        "cuts_are_looked_for_in": take.cuts_are_looked_for_in,
    }))
}
