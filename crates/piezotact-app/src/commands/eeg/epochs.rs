//! `piezotact eeg epochs`: epochs around markers, counted.

use std::path::{Path, PathBuf};

use clap::Args;
use piezotact_people::eeg::counts::EegEpochs;
use piezotact_people::eeg::prepare::{PrepareConfig, PrepareError, Prepared, prepare_at};
use piezotact_people::eeg::reference::Montage;
use piezotact_people::eeg::source::{Segment, Subject};

use super::options::{Preparing, Span};
use super::{Source, of_file, outputs_beside};
use crate::deliver::{Outputs, deliver};
use crate::failure::{Failure, Outcome, usage};

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
    #[command(flatten)]
    outputs: Outputs,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let mut read = vec![args.file.as_path()];
    read.extend(args.preparing.events.as_deref());
    outputs_beside(&read, &args.outputs.files())?;
    deliver(&args.outputs, &found(args)?)
}

fn found(args: &Arguments) -> Outcome<EegEpochs> {
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
    Ok(EegEpochs::of(
        &crate::report::name(&args.file),
        &subject,
        &prepared,
    ))
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
