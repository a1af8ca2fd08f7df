//! `piezotact campaign design`: what a design can show, its faults and better plans.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::Error;
use clap::Args;
use piezotact_people::campaign::design::{Change, PowerQuestion};
use piezotact_people::campaign::overview::{CampaignDesign, campaign_design};
use piezotact_people::difference::Difference;
use piezotact_report::design::html;
use piezotact_report::report;

use super::protocol_of;
use crate::failure::{Failure, Outcome, usage};
use crate::invocation::write_report;
use crate::output::{print, print_document};
use crate::places::outputs;
use crate::progress::Work;

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// A protocol (TOML), or the name of one of the library, see `piezotact campaign protocol`.
    protocol: PathBuf,
    /// The number of participants instead of that of the protocol.
    #[arg(long, value_name = "N", value_parser = participants, allow_negative_numbers = true)]
    participants: Option<u32>,
    /// The seed of simulations and searches.
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// How many participants, repeats and sets find a difference, by a permutation of participants at 5 %, in simulated campaigns.
    /// `samples:A,B`: two samples are told apart; `tasks:A,B`: two tasks differ; `again:own,averaged`: the same people with two ways of
    /// rendering; `people:own,averaged`: two groups of people.
    #[arg(long, value_name = "WHAT:A,B", requires = "shares")]
    power: Option<Difference>,
    /// The difference of --power, in percent: answers as expected in A and in B; of two samples, right answers and those that name
    /// the other. Of the median participant.
    #[arg(long, value_name = "PERCENT,PERCENT", requires = "power")]
    shares: Option<Shares>,
    /// The task of --power, where several tasks have answers of the samples or groups.
    #[arg(long, value_name = "TASK", requires = "power")]
    task: Option<String>,
    /// How participants differ: the standard deviation of the logits of --shares. Default: that of the protocol's aims.
    #[arg(
        long,
        value_name = "LOGITS",
        requires = "power",
        allow_negative_numbers = true
    )]
    spread: Option<f64>,
    /// Writes a report.
    #[arg(long, value_name = "REPORT.html")]
    report: Option<PathBuf>,
    /// Prints the result as JSON.
    #[arg(long)]
    json: bool,
}

/// Two shares, given in percent.
#[derive(Clone, Copy, Debug)]
struct Shares([f64; 2]);

impl FromStr for Shares {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers: Option<Vec<f64>> = text
            .split(',')
            .map(|part| part.trim().parse().ok())
            .collect();
        match numbers.as_deref() {
            Some([a, b]) if *a <= 1.0 && *b <= 1.0 => Err(format!(
                "expected two percentages such as 85,70, found fractions or less than one percent: `{text}`"
            )),
            Some([a, b]) if [a, b].iter().all(|p| **p > 0.0 && **p < 100.0) => {
                Ok(Self([a / 100.0, b / 100.0]))
            }
            _ => Err(format!(
                "expected two percentages above 0 and below 100, such as 85,70, found `{text}`"
            )),
        }
    }
}

fn participants(text: &str) -> Result<u32, String> {
    match text.parse() {
        Ok(number @ 1..=10_000) => Ok(number),
        _ => Err("expected a whole number from 1 to 10000".into()),
    }
}

pub(super) fn run(args: &Arguments) -> Outcome {
    let written: Vec<&Path> = args.report.iter().map(PathBuf::as_path).collect();
    outputs(&[&args.protocol], &written)?;
    let mut protocol = protocol_of(&args.protocol)?;
    if let Some(participants) = args.participants {
        protocol.panel.participants = participants;
    }
    let work = Work::one("checking the design");
    let mut design = campaign_design(&protocol, args.seed).map_err(|error| {
        Failure::Data(Error::new(error).context(args.protocol.display().to_string()))
    })?;
    if let (Some(difference), Some(Shares(shares))) = (&args.power, args.shares) {
        let question = PowerQuestion {
            difference: difference.clone(),
            task: args.task.clone(),
            shares,
            logit_sd: args.spread,
        };
        design = design.with_power(&question).map_err(usage)?;
    }
    drop(work);
    if let Some(path) = &args.report {
        write_report(path, &html(&design)?)?;
    }
    if args.json {
        return print_document(&design);
    }
    print(&text(&design)?)?;
    for path in written {
        print(&format!("wrote {}", path.display()))?;
    }
    Ok(())
}

/// What is asked and how long it takes, what chance reaches, which pairs are tested, the precision, and the faults.
fn text(design: &CampaignDesign) -> Outcome<String> {
    let mut parts = vec![
        format!(
            "{} ({}, from {})\n{}\n{}",
            design.title,
            design.protocol,
            design.source,
            design.asked_sentence(),
            design.judged_sentence()
        ),
        report::text(&design.sessions_table())?,
        design.time_sentence(),
    ];
    if !design.report.chance.is_empty() {
        parts.push(format!(
            "{}\n{}",
            report::text(&design.chance_table())?,
            design.chance_note()
        ));
    }
    parts.extend(design.pairs_sentence());
    if let (false, Some(table)) = (design.report.never.is_empty(), design.pairs_table()) {
        parts.push(report::text(&table)?);
    }
    let precision = design.precision_sentences();
    if !precision.is_empty() {
        parts.push(precision.join("\n"));
    }
    if let Some(power) = &design.power {
        parts.push(power.sentences().join("\n"));
        parts.push(report::text(&power.table())?);
    }
    parts.push(faults(design));
    Ok(parts.join("\n\n"))
}

/// Each fault with the better plan and its cost.
fn faults(design: &CampaignDesign) -> String {
    let mut text = design.sentence();
    for (i, found) in design.report.faults.iter().enumerate() {
        let _never_fails = write!(text, "\n{}. {}", i + 1, found.fault);
        let _never_fails = match &found.better {
            None => write!(text, "\n   No better plan is known."),
            Some(better) => write!(text, "\n   Better: {better}"),
        };
        if let Some(Change::Sets { .. }) = found.better.as_ref().map(|better| &better.change) {
            text += " --report and --json list the sets.";
        }
    }
    text
}
