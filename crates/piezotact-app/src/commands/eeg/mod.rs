//! `piezotact eeg`: what a file holds, epochs, desynchronisation, and what differs over people.

mod epochs;
mod erd;
mod info;
mod options;
mod stats;

use std::path::{Path, PathBuf};

use anyhow::anyhow;
use clap::{Args, Subcommand};
use piezotact_dataset::eeg::{EegSource, files_of, read_eeg_source};
use piezotact_people::eeg::source::{Segment, StatedChannel, Subject};
use piezotact_people::eeg::{EegWarning, MarkersFault};

use crate::failure::{Failure, Outcome, usage};
use crate::memory::reading_fits;
use crate::places::outputs;
use options::Preparing;

#[derive(Debug, Args)]
pub(crate) struct Eeg {
    #[command(subcommand)]
    command: EegCommand,
}

#[derive(Debug, Subcommand)]
enum EegCommand {
    /// Shows what an EEG file holds: channels, rate, parts, markers, known positions, flat and saturated channels, mains.
    #[command(
        after_help = "Files: BrainVision (.vhdr), EDF, EDF+, BDF, EEGLAB (.set), XDF, and recordings of this program. A `_eeg.json` or\n`_channels.tsv` of BIDS beside the file is held against it; channels\nthat it marks as bad are not analysed. `_events.tsv` gives the markers of a file that has none. `EEG C3-Ref` of an EDF file is called C3. With --pulses and --against, drift and jitter between the clocks of\ntwo files are estimated from pulses that both recorded.\n\nExample:\n  piezotact eeg info P01_control.vhdr --report info.html\n  piezotact eeg info P01_control.vhdr --pulses \"S 15\" --against P01_touch.parquet"
    )]
    Info(info::Arguments),
    /// Cuts epochs around markers, rejects the bad ones by stated limits, and counts them by condition.
    #[command(
        after_help = "No epoch crosses a gap of the recording. Every epoch that is left out or rejected is listed with its reason.\nEye movements are taken away by regression (--eog); bad electrodes are left out (--without) or interpolated (--interpolate).\nIndependent components, evoked responses and current source density are those of MNE: docs/guide/mne.md.\n\nExample:\n  piezotact eeg epochs P01_control.vhdr --event \"S 2=M8\" --event \"S 8=BIO\" --epoch -1.5,0.8 --reject-above 100 --report epochs.html --out epochs.vhdr\n  piezotact eeg epochs P01.edf --event touch --high-pass 1 --eog VEOG,HEOG --interpolate F3 --reference average --report epochs.html"
    )]
    Epochs(Box<epochs::Arguments>),
    /// Computes event-related desynchronisation (ERD) and synchronisation of one person in one task, by surface, band and region.
    #[command(
        after_help = "Power is averaged over epochs before it is divided by the baseline. Negative: desynchronisation. Participant and task come from a BIDS name\n(sub-01_task-control_eeg.vhdr), from a marker `task`, or from the options. `piezotact eeg stats` reads the file of --out.\n\nExample:\n  piezotact eeg erd sub-01_task-control_eeg.vhdr --event \"S 2=M8\" --event \"S 8=BIO\" --out sub-01_control.json --report erd.html\n  piezotact eeg erd P01.edf --participant P01 --task control --event touch --baseline -1.2,-0.4 --window 0,0.8 --reject-above 100 --out P01.json"
    )]
    Erd(Box<erd::Arguments>),
    /// Compares tasks over participants: paired contrasts, the order of tasks, cluster tests, scalp maps.
    #[command(
        after_help = "Each document is one participant in one task. Two tasks differ where p is 0.05 or less after Holm's adjustment. A larger p\ndecides nothing, unless --margin states how large a difference is of no interest. The exit code is 0 whatever it finds.\n\nExample:\n  piezotact eeg stats erd/*.json --gradient control,imagery,natural --report stats.html --csv contrasts.csv"
    )]
    Stats(stats::Arguments),
}

pub(crate) fn run(args: &Eeg) -> Outcome {
    match &args.command {
        EegCommand::Info(args) => info::run(args),
        EegCommand::Epochs(args) => epochs::run(args),
        EegCommand::Erd(args) => erd::run(args),
        EegCommand::Stats(args) => stats::run(args),
    }
}

/// A file with what stands beside it.
struct Source {
    source: EegSource,
    stated: Vec<StatedChannel>,
}

impl Source {
    /// The file at `path`, with the markers of the table `events` where one is given.
    fn read(path: &Path, events: Option<&Path>) -> Outcome<Self> {
        // The header of a recording is small; its samples are not.
        for file in files_of(path).iter().map(PathBuf::as_path).chain(events) {
            reading_fits(file)?;
        }
        let mut source = read_eeg_source(path)?;
        if let Some(table) = events {
            source.take_events(table)?;
        }
        let differing = source
            .events
            .iter()
            .filter(|table| table.without_marker > 0);
        let warnings = differing.map(|table| EegWarning::Markers {
            fault: MarkersFault::OtherTable {
                table: table.name.clone(),
                without: table.without_marker,
                of: table.events,
                markers: table.markers,
            },
        });
        let warnings: Vec<EegWarning> = warnings.collect();
        source.segments[0]
            .recording
            .about
            .warnings
            .extend(warnings.into_iter().map(piezotact::Warning::from));
        let rows = source.channels.iter();
        let stated = rows.map(|row| {
            StatedChannel::of_bids(&row.name, row.kind.as_deref(), row.status.as_deref())
        });
        Ok(Self {
            stated: stated.collect(),
            source,
        })
    }

    /// The parts of the file as the science takes them.
    fn segments(&self) -> Vec<Segment<'_>> {
        let parts = self.source.segments.iter();
        parts
            .map(|part| Segment {
                recording: &part.recording,
                start_s: part.start_s,
                event_samples: &part.event_samples,
                stated: &self.stated,
            })
            .collect()
    }

    /// Participant and task: as stated, or as the file says.
    fn subject(&self, path: &Path, options: &Preparing) -> Outcome<[Option<String>; 2]> {
        let participant = options.participant.as_deref().map(|name| {
            let label = name.strip_prefix("sub-").unwrap_or(name);
            label.to_owned()
        });
        let of_file = [&self.source.participant, &self.source.task].map(Option::as_ref);
        Ok([
            agreed(path, "participant", participant.as_ref(), of_file[0])?,
            agreed(path, "task", options.task.as_ref(), of_file[1])?,
        ])
    }
}

/// Refuses an output that would replace a file that is read: samples, markers and tables beside it too.
fn outputs_beside(read: &[&Path], written: &[&Path]) -> Outcome {
    let files: Vec<PathBuf> = read.iter().flat_map(|path| files_of(path)).collect();
    let all: Vec<&Path> = files
        .iter()
        .map(PathBuf::as_path)
        .chain(read.iter().copied())
        .collect();
    outputs(&all, written)
}

/// An error of the science about the file at `path`.
fn of_file<E: Into<anyhow::Error>>(path: &Path) -> impl Fn(E) -> Failure {
    let name = path.display().to_string();
    move |error| Failure::Data(error.into().context(name.clone()))
}

/// What an option and a file say about one thing; refused where both do and differ.
fn agreed(
    path: &Path,
    what: &str,
    stated: Option<&String>,
    of_file: Option<&String>,
) -> Outcome<Option<String>> {
    match (stated, of_file) {
        (Some(stated), Some(found)) if stated != found => Err(usage(anyhow!(
            "{}: expected {what} {stated}, found {found} in its name or beside it; leave the option out, or rename the file",
            path.display()
        ))),
        (stated, found) => Ok(stated.or(found).cloned()),
    }
}

/// Who and what the file is of; both have to be known where people are compared.
fn subject(path: &Path, participant: Option<String>, task: &str) -> Outcome<Subject> {
    let missing = |what: &str, option: &str| {
        usage(anyhow!(
            "{}: expected to know the {what}, found neither a BIDS name (sub-01_task-control_eeg) nor an option; state it with {option}",
            path.display()
        ))
    };
    let participant = participant.ok_or_else(|| missing("participant", "--participant"))?;
    if task.is_empty() {
        return Err(missing("task", "--task"));
    }
    Ok(Subject {
        participant,
        task: task.to_owned(),
    })
}
