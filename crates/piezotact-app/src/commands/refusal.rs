//! Command lines that are refused with what to write instead: former names of commands, and options that need others.

use std::ffi::OsString;

use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Command, Error};
use piezotact_report::invocation::line_of;

/// Former names, and what does the same now.
const FORMER: [(&str, &str); 12] = [
    ("align", "sound align"),
    ("analyse", "strokes"),
    ("analyze", "strokes"),
    ("burst", "sound burst"),
    ("calibrate", "sound calibrate"),
    (
        "campaign dictionary",
        "campaign protocol PROTOCOL --dictionary",
    ),
    ("campaign verify-journal", "campaign verify"),
    ("devices", "sound devices"),
    ("latency", "sound latency"),
    ("matrix", "answers"),
    ("noise", "spectrum --rest"),
    ("segment", "strokes --cuts-only"),
];
/// A former command that is one of another program.
const ELSEWHERE: (&str, &str) = ("replay", "piezotact-validation replay");

/// The present name of the command that `words` call by a former one, in a sentence, where `refused` is for its name.
pub(crate) fn renamed<'w>(
    refused: &Error,
    root: &Command,
    words: impl Iterator<Item = &'w str>,
) -> Option<String> {
    let unknown = match (refused.kind(), refused.get(ContextKind::InvalidSubcommand)) {
        (ErrorKind::InvalidSubcommand, Some(ContextValue::String(unknown))) => unknown,
        _ => return None,
    };
    let (mut command, mut names, mut rest) = (root, Vec::new(), words);
    for word in rest.by_ref() {
        if word == unknown {
            names.push(word);
            break;
        }
        if let Some(below) = command.find_subcommand(word) {
            command = below;
            names.push(word);
        }
    }
    let name = names.join(" ");
    if name == ELSEWHERE.0 {
        let given: Vec<String> = rest.map(str::to_owned).collect();
        let line = line_of("./x validate replay", &given);
        return Some(format!(
            "`piezotact {name}` is now `{}`; {line} builds and runs it",
            ELSEWHERE.1
        ));
    }
    let (_, now) = FORMER.iter().find(|(former, _)| *former == name)?;
    Some(format!("`piezotact {name}` is now `piezotact {now}`"))
}

/// Which of `words` needs an option that is missing, in a sentence, where `refused` is for it.
pub(crate) fn needing(refused: &Error, root: &Command, words: &[OsString]) -> Option<String> {
    let missing = missing_in(refused);
    words.iter().enumerate().skip(1).find_map(|(at, word)| {
        let option = word.to_str().filter(|word| word.starts_with("--"))?;
        let name = option.split('=').next()?;
        // Without the option, or without it and its value.
        let unneeded = [at + 1, at + 2].into_iter().find_map(|end| {
            let rest = words.get(end..)?;
            let without = [words.get(..at)?, rest].concat();
            let still = match root.clone().try_get_matches_from(without) {
                Ok(_) => Vec::new(),
                Err(error) if error.kind() == ErrorKind::MissingRequiredArgument => {
                    missing_in(&error)
                }
                Err(_) => return None,
            };
            let needed = missing.iter().filter(|one| !still.contains(one));
            let needed: Vec<&str> = needed.filter_map(|one| one.split(' ').next()).collect();
            (!needed.is_empty()).then_some(needed)
        })?;
        let all = if unneeded.len() > 1 { "all" } else { "both" };
        let needed = unneeded.join(" and ");
        Some(format!(
            "{name} needs {needed}: give {all}, or leave {name} out"
        ))
    })
}

/// The arguments that `refused` misses.
fn missing_in(refused: &Error) -> Vec<String> {
    match (refused.kind(), refused.get(ContextKind::InvalidArg)) {
        (ErrorKind::MissingRequiredArgument, Some(ContextValue::Strings(missing))) => {
            missing.clone()
        }
        _ => Vec::new(),
    }
}
