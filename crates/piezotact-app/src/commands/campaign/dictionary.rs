//! `piezotact campaign dictionary`: what the columns of a campaign's answers mean.

use std::path::PathBuf;

use clap::Args;
use piezotact_people::campaign::dictionary::{TaskDictionary, dictionary};
use piezotact_report::report;

use super::protocol_of;
use crate::failure::Outcome;
use crate::output::{print, print_document};

#[derive(Debug, Args)]
pub(super) struct Arguments {
    /// A protocol (TOML), or the name of one of the library, see `piezotact campaign protocol`.
    protocol: PathBuf,
    /// Prints the dictionary as JSON, with the fields that BIDS has for a column.
    #[arg(long)]
    json: bool,
}

pub(super) fn run(args: &Arguments) -> Outcome {
    let found = dictionary(&protocol_of(&args.protocol)?);
    if args.json {
        return print_document(&found);
    }
    let tasks = found.tasks.iter().map(text);
    print(&tasks.collect::<Outcome<Vec<_>>>()?.join("\n\n"))
}

/// A task with its columns.
fn text(task: &TaskDictionary) -> Outcome<String> {
    let head = format!("{}: {}. A row: {}.", task.task, task.title, task.row);
    match task.columns.is_empty() {
        true => Ok(format!(
            "{}: {}. {}.",
            task.task, task.title, "Nothing is answered"
        )),
        false => Ok(format!("{head}\n{}", report::text(&task.table())?)),
    }
}
