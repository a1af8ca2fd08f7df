//! `piezotact campaign protocol --dictionary`: what the columns of a campaign's answers mean.

use std::path::Path;

use piezotact_people::campaign::dictionary::{DataDictionary, TaskDictionary, dictionary};

use super::protocol_of;
use crate::failure::Outcome;

/// The dictionary of the protocol `named`.
pub(super) fn of(named: &Path) -> Outcome<DataDictionary> {
    Ok(dictionary(&protocol_of(named)?))
}

/// Its tasks with their columns.
pub(super) fn in_words(found: &DataDictionary) -> String {
    let tasks: Vec<String> = found.tasks.iter().map(text).collect();
    tasks.join("\n\n")
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
