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
/// Former options of commands, and what does the same now.
const FORMER_OPTIONS: [(&str, &str, &str); 5] = [
    (
        "campaign simulate",
        "--study",
        "the first argument: piezotact campaign simulate STUDY --protocol PROTOCOL",
    ),
    (
        "campaign status",
        "--csv-text",
        "--csv TABLE.csv, which writes the table to a file",
    ),
    (
        "spectrum",
        "--spectrogram",
        "--over-time with --report REPORT.html, and --figures DIR for the figure as a file",
    ),
    (
        "spectrum",
        "--svg",
        "--report REPORT.html with --figures DIR",
    ),
    (
        "twin record",
        "--duration",
        "--seconds, a number without unit",
    ),
];
/// A former command that is one of another program.
const ELSEWHERE: (&str, &str) = ("replay", "piezotact-validation replay");

/// The present name of the command or option that `words` call by a former one, or the nearest name of a command, in a sentence, where
/// `refused` is for its name.
pub(crate) fn renamed<'w>(
    refused: &Error,
    root: &Command,
    words: impl Iterator<Item = &'w str>,
) -> Option<String> {
    if let (ErrorKind::UnknownArgument, Some(ContextValue::String(option))) =
        (refused.kind(), refused.get(ContextKind::InvalidArg))
    {
        return renamed_option(option, root, words);
    }
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
    let Some((_, now)) = FORMER.iter().find(|(former, _)| *former == name) else {
        let nearest = nearest(unknown, command)?;
        let before = name.trim_end_matches(unknown.as_str());
        return Some(format!(
            "there is no command `{name}`; did you mean `{before}{nearest}`? `piezotact --help` lists all commands"
        ));
    };
    Some(format!("`piezotact {name}` is now `piezotact {now}`"))
}

/// What `option` of the command that `words` call is now, in a sentence, where it is a former one.
fn renamed_option<'w>(
    option: &str,
    root: &Command,
    words: impl Iterator<Item = &'w str>,
) -> Option<String> {
    let (mut command, mut names) = (root, Vec::new());
    for word in words {
        if let Some(below) = command.find_subcommand(word) {
            command = below;
            names.push(word);
        }
    }
    let name = names.join(" ");
    let mut former = FORMER_OPTIONS.iter();
    let (_, _, now) = former.find(|(of, former, _)| *of == name && *former == option)?;
    Some(format!("{option} of `piezotact {name}` is now {now}"))
}

/// The command below `command` whose name is nearest to `word`, at most two errors of typing away; `None` where none or several are.
fn nearest<'c>(word: &str, command: &'c Command) -> Option<&'c str> {
    const MOST_ERRORS: usize = 2;
    let names = command.get_subcommands().map(Command::get_name);
    let mut near: Vec<(usize, &str)> = names.map(|name| (errors(word, name), name)).collect();
    near.sort_unstable();
    match near[..] {
        [(first, name), (second, _), ..] if first <= MOST_ERRORS && first < second => Some(name),
        _ => None,
    }
}

/// How many letters were left out, added, exchanged, or swapped with their neighbour between `a` and `b`.
///
/// Source: optimal string alignment distance, R. A. Wagner and R. Lowrance, J. ACM 22 (1975) 177.
fn errors(a: &str, b: &str) -> usize {
    let [a, b] = [a, b].map(|text| text.chars().collect::<Vec<char>>());
    let mut rows: Vec<Vec<usize>> = vec![(0..=b.len()).collect()];
    for i in 1..=a.len() {
        let mut row = vec![i];
        for j in 1..=b.len() {
            let other = usize::from(a[i - 1] != b[j - 1]);
            let mut least = (rows[i - 1][j] + 1)
                .min(row[j - 1] + 1)
                .min(rows[i - 1][j - 1] + other);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                least = least.min(rows[i - 2][j - 2] + 1);
            }
            row.push(least);
        }
        rows.push(row);
    }
    rows[a.len()][b.len()]
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
