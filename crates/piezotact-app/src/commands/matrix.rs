//! `piezotact matrix`: association matrices of participants' answers.

use std::path::{Path, PathBuf};

use anyhow::Error;
use clap::{Args, ValueEnum};
use piezotact_dataset::{AnswersFile, read_answers};
use piezotact_people::association::{
    Association, AssociationConfig, AssociationError, FlaggedTrials, Grouping, MatrixConfig,
    OrderError, Selection, associate,
};
use piezotact_report::association::{html, svg};
use piezotact_report::report;

use super::outputs;
use crate::advice::OptionWords;
use crate::failure::{Failure, Outcome, usage};
use crate::invocation::write_report;
use crate::output::{print, print_document, say_doubts, write_text};

#[derive(Debug, Args)]
pub(crate) struct Arguments {
    /// A table of answers (CSV), one row for each trial.
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
    /// Leaves out trials in which the stimulus missed its target or the wrong sample was handed over.
    #[arg(long)]
    without_flagged: bool,
    /// Writes a tidy table, one row for each cell.
    #[arg(long, value_name = "TABLE.csv")]
    csv: Option<PathBuf>,
    /// Writes the heat map of all answers.
    #[arg(long, value_name = "OUT.svg")]
    svg: Option<PathBuf>,
    /// Writes a report.
    #[arg(long, value_name = "REPORT.html")]
    report: Option<PathBuf>,
    /// Prints the result as JSON.
    #[arg(long)]
    json: bool,
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
    let written: Vec<&Path> = [&args.csv, &args.svg, &args.report]
        .into_iter()
        .flatten()
        .map(PathBuf::as_path)
        .collect();
    outputs(&[&args.answers], &written)?;
    let AnswersFile { table, doubts } = read_answers(&args.answers, &args.samples)?;
    let mut found =
        associate(&table, &config(args)).map_err(|error| match error {
            AssociationError::NothingSelected { .. }
            | AssociationError::OnlyFlagged { .. }
            | AssociationError::Order(
                OrderError::OtherTask { .. } | OrderError::OnlyFlagged { .. },
            ) => usage(error),
            error => Failure::Data(Error::new(error).context(args.answers.display().to_string())),
        })?;
    found.doubts.splice(0..0, doubts);
    if let Some(path) = &args.csv {
        write_text(path, &report::csv(&found.cells_table())?)?;
    }
    if let Some(path) = &args.svg {
        write_text(path, &svg(&found)?)?;
    }
    if let Some(path) = &args.report {
        let name = crate::report::name(&args.answers);
        write_report(path, &html(&name, &found, &OptionWords)?)?;
    }
    if args.json {
        return print_document(&found);
    }
    print(&text(&found)?)?;
    for path in written {
        print(&format!("wrote {}", path.display()))?;
    }
    say_doubts(&found.doubts);
    Ok(())
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

/// What was found, the matrix of all answers, and the orders.
fn text(found: &Association) -> Outcome<String> {
    let mut parts = vec![found.sentence()];
    if let Some(table) = found.matrix_table() {
        parts.push(report::text(&table)?);
        parts.push("%: declared / presented; n/a: untested".to_owned());
    }
    parts.extend(found.orderings.iter().map(|ordering| ordering.sentence()));
    Ok(parts.join("\n\n"))
}
