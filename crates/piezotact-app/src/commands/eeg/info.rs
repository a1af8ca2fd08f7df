//! `piezotact eeg info`: what a file holds, and how the clock of another one runs against it.

use std::path::{Path, PathBuf};

use clap::Args;
use piezotact_people::eeg::info::info;
use piezotact_people::eeg::pulses::{PulseConfig, SharedClock, shared_clock};
use piezotact_people::eeg::source::{Segment, times_of};

use super::{Source, of_file, outputs_beside};
use crate::deliver::{Outputs, deliver};
use crate::failure::Outcome;

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// An EEG file.
    file: PathBuf,
    /// The marker of pulses that this file and another one recorded.
    #[arg(long, value_name = "MARKER", requires = "against")]
    pulses: Option<String>,
    /// The other file with these pulses as markers: a second EEG file, or a recording of touch or drive.
    #[arg(long, value_name = "FILE", requires = "pulses")]
    against: Option<PathBuf>,
    /// The marker of the pulses in the other file; default: the same.
    #[arg(long, value_name = "MARKER", requires = "against")]
    against_pulses: Option<String>,
    /// A table of markers that is read in the place of those of the file (BIDS `_events.tsv`).
    #[arg(long, value_name = "EVENTS.tsv")]
    events: Option<PathBuf>,
    #[command(flatten)]
    outputs: Outputs,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let others = args.against.iter().chain(&args.events);
    let read: Vec<&Path> = (std::iter::once(&args.file).chain(others))
        .map(PathBuf::as_path)
        .collect();
    outputs_beside(&read, &args.outputs.files())?;
    let source = Source::read(&args.file, args.events.as_deref())?;
    let parts = source.segments();
    let found = info(
        &crate::report::name(&args.file),
        &source.source.kind,
        &parts,
    );
    let found = match clock(args, &parts)? {
        Some(clock) => found.with_clock(clock),
        None => found,
    };
    deliver(&args.outputs, &found)
}

/// How the clock of the other file runs, where there is one.
fn clock(args: &Arguments, parts: &[Segment<'_>]) -> Outcome<Option<SharedClock>> {
    let (Some(pulses), Some(against)) = (&args.pulses, &args.against) else {
        return Ok(None);
    };
    let other = Source::read(against, None)?;
    let others = times_of(
        &other.segments(),
        args.against_pulses.as_ref().unwrap_or(pulses),
    );
    let own = times_of(parts, pulses);
    let found = shared_clock(&own, &others, &PulseConfig::of_devices());
    Ok(Some(found.map_err(of_file(against))?))
}
