//! `piezotact eeg info`: what a file holds, and how the clock of another one runs against it.

use std::path::{Path, PathBuf};

use clap::Args;
use piezotact_people::eeg::info::{EegInfo, info};
use piezotact_people::eeg::pulses::{PulseConfig, SharedClock, shared_clock};
use piezotact_people::eeg::source::{Segment, times_of};
use piezotact_report::report::{self, html};

use super::{Source, of_file, outputs_beside};
use crate::advice::OptionWords;
use crate::failure::Outcome;
use crate::invocation::write_report;
use crate::output::{print, print_document, say_warnings, write_text};

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
    /// Writes a report.
    #[arg(long, value_name = "REPORT.html")]
    report: Option<PathBuf>,
    /// Writes the table of channels.
    #[arg(long, value_name = "CHANNELS.csv")]
    csv: Option<PathBuf>,
    /// Prints the result as JSON.
    #[arg(long)]
    json: bool,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let written: Vec<&Path> = [&args.report, &args.csv]
        .into_iter()
        .flatten()
        .map(PathBuf::as_path)
        .collect();
    let others = args.against.iter().chain(&args.events);
    let read: Vec<&Path> = (std::iter::once(&args.file).chain(others))
        .map(PathBuf::as_path)
        .collect();
    outputs_beside(&read, &written)?;
    let source = Source::read(&args.file, args.events.as_deref())?;
    let parts = source.segments();
    let mut found = info(
        &crate::report::name(&args.file),
        &source.source.kind,
        &parts,
    );
    if let Some(clock) = clock(args, &parts)? {
        found = found.with_clock(clock);
    }
    if let Some(path) = &args.csv {
        write_text(path, &report::csv(&found.channels_table())?)?;
    }
    if let Some(path) = &args.report {
        write_report(path, &html(&found.page(), &OptionWords)?)?;
    }
    if args.json {
        return print_document(&found);
    }
    print(&text(&found)?)?;
    for path in written {
        print(&format!("wrote {}", path.display()))?;
    }
    say_warnings(&found.warnings);
    Ok(())
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

fn text(found: &EegInfo) -> Outcome<String> {
    let mut lines = vec![found.sentence(), found.montage_sentence()];
    lines.extend(found.signal_sentences());
    lines.extend(found.tasks_sentence());
    lines.extend(found.clock.iter().map(SharedClock::sentence));
    let mut parts = vec![lines.join("\n")];
    parts.push(report::text(&found.parts_table())?);
    parts.push(match found.markers.is_empty() {
        true => "No marker: no epoch can be cut".to_owned(),
        false => report::text(&found.markers_table())?,
    });
    Ok(parts.join("\n\n"))
}
