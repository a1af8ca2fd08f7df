//! `piezotact answers`: association matrices of participants' answers.

mod source;

use std::path::{Path, PathBuf};
use std::str::FromStr;

use anyhow::{Error, anyhow};
use clap::{Args, ValueEnum};
use piezotact::Warning;
use piezotact::page::Table;
use piezotact::quantity::{Acceleration, Band};
use piezotact::series::Series;
use piezotact_dataset::{FeltFile, felt_files};
use piezotact_people::association::{
    AnswerTable, Association, AssociationConfig, AssociationError, Compared, Declared,
    FeltRecording, FlaggedTrials, Grouping, MatrixConfig, Selection, associate, compared,
    compared_studies, felt_otherwise, felt_part, felt_samples,
};
use piezotact_people::difference::Difference;
use piezotact_report::report;
use piezotact_study::AnswersFile;

use super::campaign::study::Study;
use super::score;
use crate::output::{print, say_warnings};
use crate::places::outputs;
use crate::reading::read;
#[cfg(feature = "web")]
pub(crate) use source::report_of;
use source::{Judged, Source};

use crate::cli::{Feeling, Reading};
use crate::deliver::{Outputs, deliver};
use crate::failure::{Failure, Outcome, sentence, usage};

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// A table of answers (CSV), one row for each trial, or the folder of a study. Names in the column `offered` are separated by | or blanks;
    /// n/a in `answered` is no answer.
    answers: PathBuf,
    /// All samples that could be answered, in their order, separated by commas, such as S1,S2,S3; a sample that was never presented or
    /// answered keeps its row and column. Default: those that the table names.
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    samples: Vec<String>,
    /// Only the answers of this task.
    #[arg(long, value_name = "TASK")]
    task: Option<String>,
    /// One matrix more for each task, participant or set.
    #[arg(long, value_enum)]
    by: Option<MatrixBy>,
    /// The tasks in which samples were put in order, separated by commas: places, dominance and Kendall's τ.
    #[arg(long, value_name = "TASKS", value_delimiter = ',')]
    ordering: Vec<String>,
    /// Whether two differ, by a permutation of participants at 5 %, once for each; several are adjusted by Holm. `samples:S2,S3`: right
    /// answers against those that name the other; `tasks:A,B`: shares of answers as expected in two tasks of the same people;
    /// `people:OTHER`: this study against another, of different people; `again:OTHER`: against another of the same people.
    #[arg(long, value_name = "WHAT:OF")]
    compare: Vec<Comparison>,
    /// Leaves out trials in which the stimulus missed its target or was not measured, or the wrong sample was handed over.
    #[arg(long)]
    without_flagged: bool,
    /// What was felt: a folder with one recording for each sample, named as the sample (S1.parquet, S1.wav …), such as the folder of
    /// `piezotact prepare`; or such folders, each named by the pseudonym of its participant. Draws the spectra of confused pairs side
    /// by side and states whether level, spectrum or time course separates them.
    #[arg(long, value_name = "FOLDER")]
    felt: Option<PathBuf>,
    /// The band in which --felt compares, in Hz.
    #[arg(long, default_value = "20..1000", requires = "felt")]
    band: Band,
    #[command(flatten)]
    feeling: Feeling,
    #[command(flatten)]
    reading: Reading,
    #[command(flatten)]
    outputs: Outputs,
}

/// A difference that is asked for.
#[derive(Clone, Debug)]
enum Comparison {
    /// Within these answers.
    Here(Difference),
    /// Of this study and another, by their names.
    Other(PathBuf, fn([String; 2]) -> Difference),
}

impl Comparison {
    /// Whether both are of the same two, in any order.
    fn is_same(&self, other: &Self) -> bool {
        match (self, other) {
            (Self::Here(a), Self::Here(b)) => {
                let sorted = |of: &Difference| {
                    let mut names = of.names().clone();
                    names.sort();
                    (matches!(of, Difference::Samples(_)), names)
                };
                sorted(a) == sorted(b)
            }
            (Self::Other(a, of), Self::Other(b, by)) => {
                let nobody = || [String::new(), String::new()];
                a == b && of(nobody()) == by(nobody())
            }
            _ => false,
        }
    }
}

impl FromStr for Comparison {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.split_once(':') {
            Some(("people", of)) if !of.is_empty() => {
                Ok(Self::Other(of.into(), Difference::People))
            }
            Some(("again", of)) if !of.is_empty() => Ok(Self::Other(of.into(), Difference::Again)),
            Some(("samples" | "tasks", _)) => text.parse().map(Self::Here),
            _ => Err(format!(
                "expected samples:A,B, tasks:A,B, people:OTHER or again:OTHER, found `{text}`; OTHER is a study or a table of answers"
            )),
        }
    }
}

/// What answers are divided by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum MatrixBy {
    /// The task.
    Task,
    /// The participant.
    Participant,
    /// The set of samples.
    Set,
}

pub(crate) fn run(args: &Arguments) -> Outcome {
    let compared = args.compare.iter().filter_map(|one| match one {
        Comparison::Other(path, _) => Some(path.as_path()),
        Comparison::Here(_) => None,
    });
    let read: Vec<&Path> = std::iter::once(args.answers.as_path())
        .chain(compared)
        .collect();
    outputs(&read, &args.outputs.files())?;
    if args.answers.is_dir() {
        let study = Study::open(&args.answers)?;
        let thresholds = study.thresholds()?;
        if !thresholds.rows.is_empty() && study.answers()?.1.is_empty() {
            return thresholds_alone(args, &study, &thresholds);
        }
    }
    let source = Source::open(&args.answers, &args.samples)?;
    deliver(&args.outputs, &associations(args, &source)?)
}

/// The thresholds of a study in which no answer names a sample, so that there is no matrix.
fn thresholds_alone(args: &Arguments, study: &Study, thresholds: &Table) -> Outcome {
    if args.outputs.json || !args.outputs.files().is_empty() || !args.compare.is_empty() {
        return Err(usage(anyhow!(
            "{}: expected answers that name samples, found thresholds alone: leave out all options to see them, or write them by piezotact campaign export",
            args.answers.display()
        )));
    }
    print(&report::text(thresholds)?)?;
    say_warnings(&study.warnings()?);
    Ok(())
}

/// All that is asked for.
fn associations(args: &Arguments, source: &Source) -> Outcome<Association> {
    let AnswersFile { table, warnings } = &source.file;
    let mut found = associated(args, source)?;
    found.warnings.splice(0..0, warnings.iter().cloned());
    if let Some(folder) = &args.felt {
        found = with_felt(args, folder, table, found)?;
    }
    let (compared, warnings) = comparisons(args, table, &found.config.matrix)?;
    found = found.with_comparisons(compared);
    found.warnings.extend(warnings);
    // Only documents have a place for it.
    let judged = match args.outputs.report.is_some() || args.outputs.json {
        true => Judged::Compared,
        false => Judged::LeftOut,
    };
    let found = source.with_study(found, judged)?;
    Ok(Association {
        name: crate::report::name(&args.answers),
        ..found
    })
}

/// The matrices. The orders of a study are made with them where no task is selected.
fn associated(args: &Arguments, source: &Source) -> Outcome<Association> {
    let table = &source.file.table;
    let mut asked = config(args);
    let by_itself = args.ordering.is_empty() && args.task.is_none();
    if by_itself {
        asked.ordering_tasks = source.orders();
        let has_answers = |task: &String| table.answers().iter().any(|a| a.task == *task);
        asked.ordering_tasks.retain(has_answers);
    }
    match associate(table, &asked) {
        Err(
            AssociationError::NoOrders { .. }
            | AssociationError::OtherTask { .. }
            | AssociationError::OrdersOnlyFlagged { .. }
            | AssociationError::NoOrder { .. },
        ) if by_itself => {
            let mut without = config(args);
            without.matrix.selection.without_tasks = asked.ordering_tasks;
            associate(table, &without)
        }
        other => other,
    }
    .map_err(|error| refused(args, error))
}

/// Why there are no matrices: of usage where the options select nothing.
fn refused(args: &Arguments, error: AssociationError) -> Failure {
    match error {
        AssociationError::NothingSelected { .. }
        | AssociationError::OnlyFlagged { .. }
        | AssociationError::OtherTask { .. }
        | AssociationError::OrdersOnlyFlagged { .. } => usage(error),
        error => Failure::Data(Error::new(error).context(args.answers.display().to_string())),
    }
}

/// The differences that were asked for, and warnings about the other studies.
fn comparisons(
    args: &Arguments,
    table: &AnswerTable,
    config: &MatrixConfig,
) -> Outcome<(Vec<Compared>, Vec<Warning>)> {
    let mut warnings = Vec::new();
    for (at, one) in args.compare.iter().enumerate() {
        if args.compare[..at].iter().any(|other| other.is_same(one)) {
            return Err(usage(anyhow::anyhow!(
                "--compare: expected each comparison once, found one again; state it once, as several are adjusted for their number"
            )));
        }
    }
    let found = args.compare.iter().map(|one| match one {
        Comparison::Here(difference) => compared(table, config, difference).map_err(usage),
        Comparison::Other(path, difference) => {
            let place = |path: &Path| path.canonicalize().ok();
            if place(path).is_some() && place(path) == place(&args.answers) {
                return Err(usage(anyhow::anyhow!(
                    "--compare: expected another study, found {} again; tasks:A,B and samples:A,B compare within one",
                    path.display()
                )));
            }
            let other = Source::open(path, &args.samples)?;
            warnings.extend(other.file.warnings.iter().cloned());
            warnings.extend(other.file.table.warnings_of_people());
            let names = [&args.answers, path].map(|path| crate::report::name(path));
            let own = other.config(config);
            let both = [(table, config), (&other.file.table, &own)];
            compared_studies(both, &difference(names)).map_err(|error| {
                Failure::Data(Error::new(error).context(path.display().to_string()))
            })
        }
    });
    Ok((found.collect::<Outcome<_>>()?, warnings))
}

fn config(args: &Arguments) -> AssociationConfig {
    AssociationConfig {
        matrix: MatrixConfig {
            selection: Selection {
                task: args.task.clone(),
                ..Selection::default()
            },
            flagged: if args.without_flagged {
                FlaggedTrials::LeftOut
            } else {
                FlaggedTrials::Kept
            },
        },
        by: args.by.map(|by| match by {
            MatrixBy::Task => Grouping::Task,
            MatrixBy::Participant => Grouping::Participant,
            MatrixBy::Set => Grouping::Set,
        }),
        ordering_tasks: args.ordering.clone(),
    }
}

/// `found` with what was felt in its confused pairs, by the recordings in `folder`.
fn with_felt(
    args: &Arguments,
    folder: &Path,
    table: &AnswerTable,
    found: Association,
) -> Outcome<Association> {
    let files = felt_files(folder, &felt_samples(&found.pairs))?;
    let mut left_out = Vec::new();
    let recordings = files.into_iter().map(|file| {
        let vibration = match vibration(args, &file, table.declared()) {
            Ok((vibration, warning)) => {
                left_out.extend(warning);
                Ok(vibration)
            }
            Err(Failure::Data(error)) => Err(sentence(&error)),
            Err(other) => return Err(other),
        };
        Ok(FeltRecording {
            participant: file.participant,
            sample: file.sample,
            vibration,
        })
    });
    let recordings = recordings.collect::<Outcome<Vec<_>>>()?;
    let model = score::model(&args.feeling, args.band)?;
    let mut found = found.with_felt(table, &recordings, &model);
    found.warnings.extend(left_out);
    Ok(found)
}

/// What was felt, by the recording in `file`, with a warning about what of it was left out.
fn vibration(
    args: &Arguments,
    file: &FeltFile,
    declared: &Declared,
) -> Outcome<(Series<Acceleration>, Option<Warning>)> {
    let contents = read(&file.path, &args.reading)?;
    let recording = &contents.recording;
    let refused = |error: Error| Failure::Data(error.context(file.path.display().to_string()));
    let of = declared.stimuli.iter().find(|of| of.name == file.sample);
    let stated = (&recording.about.condition, contents.lineage());
    let otherwise = of.and_then(|of| felt_otherwise(of, file.participant.as_deref(), stated));
    if let Some(otherwise) = otherwise {
        return Err(refused(anyhow!(
            "{otherwise}; put the file into the folder of whoever felt it, with the name of the texture that was felt"
        )));
    }
    felt_part(&file.sample, recording).map_err(|error| refused(Error::new(error)))
}
