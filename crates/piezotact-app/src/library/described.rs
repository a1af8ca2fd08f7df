//! The commands with their arguments as data, from which functions of another language are made.

use std::any::TypeId;

use clap::builder::PossibleValue;
use clap::{Arg, ArgAction, Command};
use serde::Serialize;

use crate::arguments::{is_output, is_path};
use crate::cli::manipulate::OPERATIONS;

/// A command.
#[derive(Clone, Debug, Serialize)]
pub struct CommandDescription {
    /// Its name: `panel analyse`.
    pub name: String,
    /// What it does.
    pub about: String,
    /// Its arguments, in the order of its help.
    pub arguments: Vec<Argument>,
}

/// An argument of a command.
#[derive(Clone, Debug, Serialize)]
pub struct Argument {
    /// Its name: `max_frequency`.
    pub name: String,
    /// The option that it is: `max-frequency`; absent where it has no name on the command line.
    pub option: Option<String>,
    /// What it means.
    pub help: String,
    /// What its value is called: `HZ`.
    pub value: Option<String>,
    /// Its default, in words.
    pub default: Option<String>,
    /// The only values that it can have; empty where others can be.
    pub choices: Vec<String>,
    /// The type of its value.
    pub kind: ArgumentKind,
    pub is_required: bool,
    /// Whether it can be given several times.
    pub is_several: bool,
    /// Whether it names what the command writes.
    pub is_output: bool,
    /// Whether it is done in its turn, after those of its kind that are given before it.
    pub is_operation: bool,
}

/// The type of a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ArgumentKind {
    /// Given or not.
    Flag,
    /// A file or a folder.
    Path,
    /// A number, which may have a fraction.
    Number,
    /// A number from 0 on, without a fraction.
    Integer,
    /// A text that the command reads: a band, a measure, a name.
    Text,
}

/// Every command that does something, those of other commands behind them.
#[must_use]
pub fn commands() -> Vec<CommandDescription> {
    let mut root = crate::commands::command();
    root.build();
    let mut found = Vec::new();
    for command in root.get_subcommands().filter(|one| !one.is_hide_set()) {
        describe(command, "", &mut found);
    }
    found
}

fn describe(command: &Command, within: &str, found: &mut Vec<CommandDescription>) {
    if command.get_name() == "help" {
        return;
    }
    let name = format!("{within}{}", command.get_name());
    if command.has_subcommands() {
        let within = format!("{name} ");
        for below in command.get_subcommands() {
            describe(below, &within, found);
        }
        return;
    }
    let is_own = |argument: &&Arg| {
        !argument.is_hide_set()
            && !argument.is_global_set()
            && matches!(
                argument.get_action(),
                ArgAction::Set | ArgAction::Append | ArgAction::SetTrue
            )
    };
    let arguments = command.get_arguments().filter(is_own);
    found.push(CommandDescription {
        about: command
            .get_about()
            .map(ToString::to_string)
            .unwrap_or_default(),
        arguments: arguments.map(described).collect(),
        name,
    });
}

fn described(argument: &Arg) -> Argument {
    let help = argument.get_long_help().or_else(|| argument.get_help());
    let defaults: Vec<_> = argument
        .get_default_values()
        .iter()
        .map(|value| value.to_string_lossy())
        .collect();
    let most = argument
        .get_num_args()
        .map_or(1, |range| range.max_values());
    let possible = argument.get_possible_values();
    let kind = kind(argument);
    Argument {
        name: argument.get_id().to_string(),
        option: argument.get_long().map(str::to_owned),
        help: help.map(ToString::to_string).unwrap_or_default(),
        value: (argument.get_value_names().and_then(|names| names.first()))
            .map(ToString::to_string),
        default: (kind != ArgumentKind::Flag && !defaults.is_empty()).then(|| defaults.join(" ")),
        choices: match kind {
            ArgumentKind::Flag => Vec::new(),
            _ => possible
                .iter()
                .map(PossibleValue::get_name)
                .map(str::to_owned)
                .collect(),
        },
        kind,
        is_required: argument.is_required_set(),
        is_several: matches!(argument.get_action(), ArgAction::Append)
            || argument.get_value_delimiter().is_some()
            || most > 1,
        is_output: is_output(argument),
        is_operation: argument.get_help_heading() == Some(OPERATIONS),
    }
}

fn kind(argument: &Arg) -> ArgumentKind {
    let found = argument.get_value_parser().type_id();
    let whole = [
        TypeId::of::<u32>(),
        TypeId::of::<u64>(),
        TypeId::of::<usize>(),
    ];
    if matches!(argument.get_action(), ArgAction::SetTrue) {
        ArgumentKind::Flag
    } else if is_path(argument) {
        ArgumentKind::Path
    } else if whole.iter().any(|whole| found == *whole) {
        ArgumentKind::Integer
    } else if found == TypeId::of::<f64>() && reads(argument, "3") && !reads(argument, "3mm") {
        // Numbers with a unit are texts, whatever becomes of them.
        ArgumentKind::Number
    } else {
        ArgumentKind::Text
    }
}

/// Whether `text` is a value of `argument`.
fn reads(argument: &Arg, text: &str) -> bool {
    let alone = Arg::new("value").value_parser(argument.get_value_parser().clone());
    Command::new("command")
        .arg(alone)
        .try_get_matches_from(["command", text])
        .is_ok()
}
