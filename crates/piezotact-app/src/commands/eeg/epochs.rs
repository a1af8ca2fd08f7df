//! `piezotact eeg epochs`: epochs around markers, counted.

use std::path::{Path, PathBuf};

use clap::Args;
use piezotact::Warning;
use piezotact::recording::RecordingWarning;
use piezotact_dataset::eeg::{markers_of, write_brainvision};
use piezotact_people::eeg::counts::EegEpochs;
use piezotact_people::eeg::prepare::{PrepareConfig, PrepareError, Prepared, prepare_at};
use piezotact_people::eeg::reference::Montage;
use piezotact_people::eeg::source::{Segment, Subject};

use super::options::{Preparing, Span};
use super::{Source, of_file, outputs_beside};
use crate::deliver::{Outputs, deliver_and};
use crate::failure::{Failure, Outcome, usage};
use crate::places::has_ending;

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// An EEG file.
    file: PathBuf,
    /// Start and end of the epochs relative to the marker, s.
    #[arg(
        long,
        visible_alias = "window",
        value_name = "FROM,TO",
        default_value = "-1.5,0.8",
        allow_hyphen_values = true
    )]
    epoch: Span,
    /// The fewest epochs of a condition.
    #[arg(long, value_name = "COUNT", default_value_t = 1)]
    min_epochs: usize,
    #[command(flatten)]
    preparing: Preparing,
    /// Writes the epochs that are kept, with their filters and reference, as BrainVision: one segment each, with a marker of its condition.
    #[arg(long, value_name = "OUT.vhdr")]
    out: Option<PathBuf>,
    #[command(flatten)]
    outputs: Outputs,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let mut read = vec![args.file.as_path()];
    read.extend(args.preparing.events.as_deref());
    if let Some(path) = &args.out {
        has_ending(path, &["vhdr"])?;
    }
    let beside = |path: &PathBuf| ["vhdr", "eeg", "vmrk"].map(|ending| path.with_extension(ending));
    let files: Vec<PathBuf> = args.out.iter().flat_map(beside).collect();
    let out: Vec<&Path> = files.iter().map(PathBuf::as_path).collect();
    outputs_beside(&read, &[out.clone(), args.outputs.files()].concat())?;
    let (found, prepared) = found(args)?;
    if let Some(path) = &args.out {
        let recording = prepared.epochs.joined().map_err(usage)?;
        // What the format leaves out is nothing that epochs have.
        let _said = write_brainvision(path, &recording, &markers_of(&recording))?;
    }
    deliver_and(&args.outputs, &found, &out[..out.len().min(1)])
}

fn found(args: &Arguments) -> Outcome<(EegEpochs, Prepared)> {
    let source = Source::read(&args.file, args.preparing.events.as_deref())?;
    let options = &args.preparing;
    let [participant, task] = source.subject(&args.file, options)?;
    let config = options.config(args.epoch.into(), task, &source.stated, args.min_epochs);
    let prepared = prepared(&args.file, &source.segments(), &config, None)?;
    let stated = |text: String| match text.is_empty() {
        true => "not stated".to_owned(),
        false => text,
    };
    let subject = Subject {
        participant: stated(participant.unwrap_or_default()),
        task: stated(prepared.task.clone()),
    };
    let mut found = EegEpochs::of(&crate::report::name(&args.file), &subject, &prepared);
    if let (Some(_), Some(first)) = (&args.out, source.segments().first()) {
        found.warnings.extend(lost_in(first, &found.channels));
    }
    Ok((found, prepared))
}

/// What the file of epochs of these channels does not hold of those of the recording.
fn lost_in(recording: &Segment<'_>, names: &[String]) -> Vec<Warning> {
    let [among, others] = recording.no_electrodes(names);
    let loses = |what: &str, format: &str, names: &[String]| {
        let what = format!("{what}: {}", names.join(", "));
        let format = format.into();
        (!names.is_empty()).then(|| RecordingWarning::FormatLoses { format, what }.into())
    };
    let left_out = loses(
        "channels that are no electrodes",
        "The file of epochs",
        &others,
    );
    let kinds = loses(
        "what channels record, so state it in MNE (set_channel_types)",
        "BrainVision",
        &among,
    );
    left_out.into_iter().chain(kinds).collect()
}

/// The epochs of a file; what an option leaves open is a matter of usage.
pub(super) fn prepared(
    path: &Path,
    segments: &[Segment<'_>],
    config: &PrepareConfig,
    measured: Option<&Montage>,
) -> Outcome<Prepared> {
    prepare_at(segments, config, measured).map_err(|error| {
        let by_options = matches!(
            error,
            PrepareError::NoMarkerStated { .. } | PrepareError::SeveralTasks { .. }
        );
        match of_file(path)(error) {
            Failure::Data(error) if by_options => usage(error),
            other => other,
        }
    })
}
