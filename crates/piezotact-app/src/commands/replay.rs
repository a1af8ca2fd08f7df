//! `piezotact replay`: the thesis' measurements again, on the digital twin.

use std::path::Path;

use anyhow::{Context as _, anyhow};
use piezotact_replay::{CLAIMS, Chapter, Finding, Replay, Verdict};
use serde_json::{Value, json};

use super::outputs;
use super::twin::twin_parameters;
use crate::advice::merged_text;
use crate::cli;
use crate::failure::Outcome;
use crate::output::{print, print_json, say, write_text};
use crate::report::name;
use crate::report::replay::{Page, render, tally, word};

pub(crate) fn run(args: &cli::Replay) -> Outcome {
    let parameters = twin_parameters(args.twin.as_deref())?;
    let out = &args.out;
    std::fs::create_dir_all(out).map_err(|error| {
        anyhow!(
            "cannot make the folder {}: {error}; check the path",
            out.display()
        )
    })?;
    let (report, findings) = (out.join("report.html"), out.join("findings.json"));
    let read: Vec<&Path> = args.twin.as_deref().into_iter().collect();
    outputs(&read, &[&report, &findings])?;
    let replay = Replay {
        parameters,
        seed: args.seed,
    };
    let chapters = measured(&replay, args.chapter)?;
    let page = Page {
        replay: &replay,
        twin: args.twin.as_deref(),
        chapters: &chapters,
    };
    let result = result_json(&page);
    write_text(&report, &render(&page)?)?;
    write_text(&findings, &serde_json::to_string_pretty(&result)?)?;
    if args.json {
        return print_json(&result);
    }
    print(&table(&chapters))?;
    print(&format!("report: {}", report.display()))?;
    print(&tally(all(&chapters)))
}

/// One chapter or all.
fn measured(replay: &Replay, asked: Option<u8>) -> Outcome<Vec<Chapter>> {
    let asked: Vec<u8> = asked.map_or(Replay::CHAPTERS.to_vec(), |number| vec![number]);
    let mut chapters = Vec::new();
    for (i, number) in asked.iter().enumerate() {
        say(&format!("{}/{} chapter {number}", i + 1, asked.len()));
        let chapter = replay.chapter(*number).transpose();
        chapters.extend(chapter.with_context(|| format!("chapter {number}"))?);
    }
    Ok(chapters)
}

fn all(chapters: &[Chapter]) -> impl Iterator<Item = &Finding> {
    chapters.iter().flat_map(|chapter| &chapter.findings)
}

fn table(chapters: &[Chapter]) -> String {
    let mut lines = vec![format!("{:>5}  {:<13}  measured", "claim", "verdict")];
    lines.extend(all(chapters).map(|finding| {
        let verdict = word(&finding.verdict);
        format!("{:>5}  {verdict:<13}  {}", finding.claim, finding.measured)
    }));
    lines.join("\n")
}

fn result_json(page: &Page<'_>) -> Value {
    let chapters: Vec<Value> = page
        .chapters
        .iter()
        .map(|chapter| {
            json!({
                "number": chapter.number,
                "title": chapter.title,
                "measured": chapter.measured,
                "doubts": chapter.doubts.iter().map(merged_text).collect::<Vec<_>>(),
                "missing": chapter.missing,
            })
        })
        .collect();
    json!({
        "report": "report.html",
        "seed": page.replay.seed,
        "twin": page.twin.map(name),
        "changes": page.replay.parameters.changes(),
        "chapters": chapters,
        "findings": all(page.chapters).map(finding_json).collect::<Vec<_>>(),
    })
}

fn finding_json(finding: &Finding) -> Value {
    let claim = CLAIMS.iter().find(|claim| claim.number == finding.claim);
    let (verdict, reason) = match &finding.verdict {
        Verdict::Holds => ("holds", None),
        Verdict::DoesNot { reason } => ("does_not_hold", Some(reason.clone())),
        Verdict::NotYet { with } => ("not_yet", Some(format!("comes with {with}"))),
    };
    json!({
        "claim": finding.claim,
        "chapter": claim.map(|claim| claim.chapter),
        "at": claim.map(|claim| claim.at),
        "says": claim.map(|claim| claim.says),
        "criteria": finding.criteria,
        "holds_if": claim.map(|claim| claim.holds_if),
        "measured": finding.measured,
        "verdict": verdict,
        "reason": reason,
    })
}
