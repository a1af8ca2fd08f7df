//! `piezotact eeg epochs`: epochs around markers, counted.

use std::path::{Path, PathBuf};

use clap::Args;
use piezotact_people::eeg::counts::EegEpochs;
use piezotact_people::eeg::prepare::{PrepareConfig, PrepareError, Prepared, prepare_at};
use piezotact_people::eeg::reference::Montage;
use piezotact_people::eeg::source::{Segment, Subject};
use piezotact_report::report::{self, html};

use super::options::{Preparing, Span};
use super::{Source, of_file, outputs_beside};
use crate::advice::OptionWords;
use crate::failure::{Failure, Outcome, usage};
use crate::invocation::write_report;
use crate::output::{print, print_document, say_warnings, write_text};

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// An EEG file.
    file: PathBuf,
    /// The first and the last time of epochs from the marker, s.
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
    /// Writes how many epochs there are: one row for each condition.
    #[arg(long, value_name = "EPOCHS.csv")]
    csv: Option<PathBuf>,
    /// Writes a report.
    #[arg(long, value_name = "REPORT.html")]
    report: Option<PathBuf>,
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
    let mut read = vec![args.file.as_path()];
    read.extend(args.preparing.events.as_deref());
    outputs_beside(&read, &written)?;
    let found = found(args)?;
    if let Some(path) = &args.csv {
        write_text(path, &report::csv(&found.counts.table())?)?;
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

fn text(found: &EegEpochs) -> Outcome<String> {
    let mut parts = vec![found.sentence(), report::text(&found.counts.table())?];
    if let Some(refused) = found.counts.refused_table() {
        parts.push(report::text(&refused)?);
    }
    parts.push(found.config.steps().join("\n"));
    Ok(parts.join("\n\n"))
}
