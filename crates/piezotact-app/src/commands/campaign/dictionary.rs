//! `piezotact campaign dictionary`: what the columns of a campaign's answers mean.

use std::path::PathBuf;

use clap::Args;
use piezotact_people::campaign::dictionary::{TaskDictionary, dictionary};

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
    let tasks: Vec<String> = found.tasks.iter().map(text).collect();
    print(&tasks.join("\n\n"))
}

/// A task with its columns, one below the other: levels stand below the meaning.
fn text(task: &TaskDictionary) -> String {
    let row = task.row.as_ref();
    let row = row.map_or("Nothing is answered".into(), |row| format!("A row: {row}"));
    let mut text = format!("{}: {}. {row}.", task.task, task.title);
    for name in &task.columns {
        let Some(meaning) = task.meanings.get(name) else {
            continue;
        };
        text += &format!("\n  {name:<12} {}", meaning.description);
        if let Some(unit) = &meaning.units {
            text += &format!(" Unit: {unit}.");
        }
        if !meaning.levels.is_empty() {
            text += &format!("\n  {:<12} {}", "", meaning.level_names().join(", "));
        }
    }
    text
}
