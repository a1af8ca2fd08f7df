//! `piezotact campaign design`: what a design can show, its faults and better plans.

use std::path::PathBuf;
use std::str::FromStr;

use anyhow::Error;
use clap::Args;
use piezotact_people::campaign::design::PowerQuestion;
use piezotact_people::campaign::overview::campaign_design;
use piezotact_people::difference::Difference;

use super::protocol_of;
use crate::deliver::{Outputs, deliver};
use crate::failure::{Failure, Outcome, usage};
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
    /// Simulates campaigns to find how many participants, repeats and sets are needed to show a difference (permutation of participants at 5 %).
    /// `samples:A,B`: two samples are distinguished; `tasks:A,B`: two tasks differ; `again:own,averaged`: the same people with two ways of
    /// rendering; `people:own,averaged`: two groups of people.
    #[arg(long, value_name = "WHAT:A,B", requires = "shares")]
    power: Option<Difference>,
    /// The difference that --power looks for, in percent, for the median participant: expected answers in A and in B; for two samples, right
    /// answers and answers that name the other sample.
    #[arg(long, value_name = "PERCENT,PERCENT", requires = "power")]
    shares: Option<Shares>,
    /// The task of --power, where several tasks have answers of the samples or groups.
    #[arg(long, value_name = "TASK", requires = "power")]
    task: Option<String>,
    /// How participants differ: the standard deviation of the logits of --shares. Default: from the protocol's aims.
    #[arg(
        long,
        value_name = "LOGITS",
        requires = "power",
        allow_negative_numbers = true
    )]
    spread: Option<f64>,
    #[command(flatten)]
    outputs: Outputs,
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
    outputs(&[&args.protocol], &args.outputs.files())?;
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
    deliver(&args.outputs, &design)
}
