//! `piezotact bids`: a study in the Brain Imaging Data Structure, which other programs open.

mod check;
mod derived;
mod export;
mod import;
mod laboratory;
mod recordings;

use clap::{Args, Subcommand};

use crate::failure::Outcome;

#[derive(Debug, Args)]
pub(crate) struct Bids {
    #[command(subcommand)]
    command: BidsCommand,
}

#[derive(Debug, Subcommand)]
enum BidsCommand {
    /// Writes a study, or recordings alone, as a BIDS data set: drives, strokes, answers, what was derived, what is not carried.
    #[command(
        after_help = "Recordings of strokes are given with --recordings; they name their participant and sample, or --meta reads them from the file\nnames. Drives and recordings of playings are those in the study. Nothing is written where something stands.\n\nWithout STUDY, the recordings and transfer functions of a laboratory are a data set without sessions.\n\nPrivacy: dates are shifted, ages of 89 and more are written as 89, texts that somebody typed, consents, identities and\nparticipants who withdrew are left out. The command lists what the data set does not carry.\n\nExample:\n  piezotact bids export study --recordings strokes/*.parquet --transfer tf/*.json --license CC0 --out touch-bids\n  piezotact bids export --recordings strokes/*.csv --meta '{participant}_{sample}' --out laboratory-bids"
    )]
    Export(Box<export::Arguments>),
    /// Reads a BIDS data set with touch data: recordings as Parquet files, answers and trials as tables.
    #[command(
        after_help = "The tables are those of `piezotact campaign export`, the recordings those that `piezotact strokes` reads.\n\nExample:\n  piezotact bids import touch-bids --out imported\n  piezotact answers imported/answers.csv --by task"
    )]
    Import(import::Arguments),
    /// Checks a BIDS data set beyond the official validators: every cell, sidecars against samples, people, answers.
    #[command(
        after_help = "Where the official validator is installed (bids-validator-deno), it is asked too, and what it finds is listed apart. Exit\ncodes: 0 nothing wrong was found, 3 something is wrong, 5 nothing could be checked.\n\nExample:\n  piezotact bids check touch-bids\n  piezotact bids check touch-bids --json"
    )]
    Check(check::Arguments),
}

pub(crate) fn run(args: &Bids) -> Outcome {
    match &args.command {
        BidsCommand::Export(args) => export::run(args),
        BidsCommand::Import(args) => import::run(args),
        BidsCommand::Check(args) => check::run(args),
    }
}
