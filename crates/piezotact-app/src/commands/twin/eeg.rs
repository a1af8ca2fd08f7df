//! `piezotact twin record --bench eeg`: the EEG of a participant in one task.

use std::path::Path;

use anyhow::anyhow;
use piezotact::Warning;
use piezotact::recording::Recording;
use piezotact::run::{Acquired, TwinRecorded};
use piezotact_dataset::eeg::{markers_of, write_brainvision, write_edf};
use piezotact_dataset::{WriteError, write_recording};
use piezotact_twin::eeg::{EegProtocol, Task, record};
use piezotact_twin::{Participant, TwinParameters};

use crate::cli::twin::{Record, TaskName};
use crate::failure::{Outcome, usage};
use crate::keeping::Earlier;
use crate::output::{print, print_kept, say_warnings};
use crate::places::{has_ending, outputs};
use crate::progress::Work;

pub(super) fn run(args: &Record, parameters: &TwinParameters) -> Outcome {
    let protocol = protocol(args, parameters)?;
    let ending = has_ending(&args.out, &["parquet", "vhdr", "edf"])?;
    can_be_kept(args, ending)?;
    let participant = Participant::of(args.who.participant, args.who.seed, parameters);
    let work = Work::one("simulating");
    let recording = record(parameters, &participant, &protocol, &args.label).map_err(usage)?;
    let warnings = write(&args.out, ending, &recording)?;
    drop(work);
    say_warnings(&warnings);
    let mut acquired = Acquired::of(&recording);
    acquired.about.warnings.extend(warnings);
    if args.json {
        return print_kept(&args.out, &TwinRecorded(acquired));
    }
    print(&format!(
        "wrote {}: {:.2}, {} channels, {} trials of the task {} on the {}",
        args.out.display(),
        acquired.duration_s,
        acquired.channels.len(),
        protocol.surfaces.len() * protocol.trials_per_surface,
        protocol.task,
        acquired.about.provenance.source
    ))
}

/// The usual session of the task, with what the command changes.
fn protocol(args: &Record, parameters: &TwinParameters) -> Outcome<EegProtocol> {
    let task = match args.task {
        Some(TaskName::Natural) => Task::Natural,
        Some(TaskName::Control) => Task::Control,
        Some(TaskName::Imagery) => Task::Imagery,
        None => {
            return Err(usage(anyhow!(
                "expected a task, found none; name one of {} with --task",
                Task::ALL.map(Task::event_kind).join(", ")
            )));
        }
    };
    let usual = EegProtocol::usual(parameters, task).map_err(usage)?;
    Ok(EegProtocol {
        trials_per_surface: args.trials.unwrap_or(usual.trials_per_surface),
        ..usual
    })
}

/// Refuses outputs that cannot be.
fn can_be_kept(args: &Record, ending: &str) -> Outcome {
    let read: Vec<&Path> = args.who.twin.as_deref().into_iter().collect();
    if ending != "vhdr" {
        return outputs(&read, &[&args.out]);
    }
    let written = ["vhdr", "eeg", "vmrk"].map(|ending| args.out.with_extension(ending));
    outputs(&read, &written.each_ref().map(std::path::PathBuf::as_path))
}

/// Writes `recording` in the format of its ending; what the format does not carry.
fn write(out: &Path, ending: &str, recording: &Recording) -> Outcome<Vec<Warning>> {
    if ending == "vhdr" {
        let written = write_brainvision(out, recording, &markers_of(recording));
        return written.map_err(|error| match error {
            WriteError::Differs { path, .. } => usage(anyhow!(
                "{} is of another recording, and the three files of a header name each other, so that none is set aside; give --out \
                 another name",
                path.display()
            )),
            error => error.into(),
        });
    }
    let earlier = Earlier::at(out, "the earlier recording")?;
    let warnings = match ending {
        "edf" => write_edf(out, recording)?,
        _ => {
            write_recording(out, recording)?;
            Vec::new()
        }
    };
    earlier.settle()?;
    Ok(warnings)
}
