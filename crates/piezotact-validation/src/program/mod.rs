//! What the program does: chapters of the thesis measured again, verdicts and conclusions against the truth, and our part of `./x bench`.

mod advice;
mod answers;
mod bench;
mod conclusions;
mod discrimination;
mod failure;
mod intervals;
mod made;
mod output;
mod outputs;
mod pairs;
mod panels;
mod people;
mod rendering;
mod replay;
mod report;
mod signal;
#[path = "../../../piezotact/tests/perception/signals.rs"]
#[allow(
    dead_code,
    clippy::unwrap_used,
    reason = "the pairs of the literature are those of the tests, which need more of it"
)]
mod signals;
mod stops;
#[path = "../../../piezotact/tests/studies/mod.rs"]
mod studies;
mod verdicts;
mod work;

use std::path::PathBuf;
use std::process::ExitCode;

use clap::{CommandFactory as _, FromArgMatches as _, Parser, Subcommand};

use failure::Outcome;
use made::Called;
use outputs::Existing;

/// Validates Piezotact: the measurements of the thesis on the digital twin, verdicts against the truth, and benchmarks.
#[derive(Debug, Parser)]
#[command(
    name = "piezotact-validation",
    version,
    after_help = "Exit codes: 0 done; 1 error in the data, or a bound that is not reached; 2 invalid command."
)]
struct Cli {
    #[command(subcommand)]
    command: Command,
    /// The date that reports and documents carry, in UTC, such as 2026-03-01T10:22:33Z; default: now.
    #[arg(long, global = true, display_order = 900, value_name = "DATE", value_parser = made::date)]
    date: Option<String>,
    /// Replaces existing files that this command did not write before (a report or document says so itself, a table or figure
    /// cannot).
    #[arg(long, global = true, display_order = 901)]
    force: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Repeats the measurements of the thesis on the digital twin and reports which of its claims hold there.
    #[command(
        after_help = "A claim that does not hold is a finding, not an error: the exit code is still 0.\n\nExample:\n  piezotact-validation replay --chapter 3 --out replay\n  piezotact-validation replay --panels 40 --out replay\n  piezotact-validation replay --twin laboratory.toml --out replay --json"
    )]
    Replay(replay::Arguments),
    /// Verdicts of `piezotact verify` against the truth: renderings that are known to be right or wrong.
    Verdicts {
        /// A part: textures=taps,tonal seeds=1 modes=replicate kinds=drop,hum list=all.
        part: Vec<String>,
    },
    /// Conclusions of `piezotact strokes` and `piezotact compare` against the truth: recordings that are known to be right, odd or wrong.
    Conclusions {
        /// A part: textures=fine,rough seeds=1 kinds=mains,copies list=all.
        part: Vec<String>,
    },
    /// How often 95 % intervals hold the truth.
    Intervals,
    /// How often tests of people, panels and EEG find a difference where there is none, and how often their 95 % intervals hold the truth.
    People {
        /// Parts: people, tasks, samples, shares, felt, panels, eeg, thresholds; default: all.
        part: Vec<String>,
    },
    /// Answers of people who judge by other features than the score, as the score, the level and the spectra predict them.
    ScoreAnswers,
    /// Rendering errors by method and level, for many people of the twin.
    Rendering,
    /// False-positive and true-positive rates of the comparison of samples.
    Discrimination,
    /// The time from a stop to silence, on the twin in real time and on sound devices.
    Stops,
    /// Our part of `./x bench`, beside programs of others.
    Bench {
        /// The Python that has the programs of others.
        python: String,
        /// Works, such as W1a; default: all of them.
        only: Vec<String>,
    },
    /// One piece of work of `bench` in a process of its own.
    #[command(hide = true)]
    Work {
        name: String,
        folder: PathBuf,
        repetitions: usize,
    },
}

/// Does what the command line asks for.
pub(crate) fn run() -> ExitCode {
    let words: Vec<_> = std::env::args_os().collect();
    let mut command = Cli::command();
    let matches = command
        .try_get_matches_from_mut(&words)
        .unwrap_or_else(|error| error.exit());
    let cli =
        Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.format(&mut command).exit());
    let called = Called::of(&words, &command, &matches, cli.date.clone());
    failure::exit_code(done(&cli, &called))
}

fn words(given: &[String]) -> Vec<&str> {
    given.iter().map(String::as_str).collect()
}

fn done(cli: &Cli, called: &Called) -> Outcome {
    match &cli.command {
        Command::Replay(args) => {
            let existing = match cli.force {
                true => Existing::Replaced,
                false => Existing::Compared,
            };
            return replay::run(args, called, existing);
        }
        Command::Verdicts { part } => verdicts::run(&words(part))?,
        Command::Conclusions { part } => conclusions::run(&words(part))?,
        Command::Intervals => intervals::run()?,
        Command::People { part } => people::run(&words(part))?,
        Command::ScoreAnswers => answers::run()?,
        Command::Rendering => rendering::run()?,
        Command::Discrimination => discrimination::run()?,
        Command::Stops => stops::run()?,
        Command::Bench { python, only } => bench::run(python, &words(only))?,
        Command::Work {
            name,
            folder,
            repetitions,
        } => work::run(name, folder, *repetitions)?,
    }
    Ok(())
}
