//! What the help of a command shows: commands by what a person wants, and of each command the options that people use.

use std::ffi::OsString;

use clap::Command;

/// What a person wants to do, and the commands for it.
const WANTED: [(&str, &[&str]); 9] = [
    ("Start", &["demo", "twin"]),
    ("Look", &["info", "spectrum", "roughness"]),
    ("Touch", &["record", "strokes", "compare"]),
    ("Know a device", &["characterise", "transfer", "panel"]),
    (
        "Render",
        &[
            "render",
            "manipulate",
            "play",
            "verify",
            "score",
            "prepare",
            "export",
        ],
    ),
    ("Ask people", &["campaign", "answers", "serve", "bids"]),
    ("Look at the brain", &["eeg"]),
    ("Use sound hardware", &["sound"]),
    ("Repeat", &["rerun"]),
];

/// The options that people use, of the commands that have more.
const USUAL: [(&str, &[&str]); 26] = [
    (
        "answers",
        &[
            "samples",
            "task",
            "by",
            "ordering",
            "compare",
            "without-flagged",
            "felt",
            "csv",
            "report",
            "json",
        ],
    ),
    (
        "bids export",
        &[
            "out",
            "recordings",
            "meta",
            "participant",
            "eeg",
            "transfer",
            "name",
            "author",
            "license",
            "json",
        ],
    ),
    (
        "campaign design",
        &[
            "participants",
            "seed",
            "power",
            "shares",
            "task",
            "report",
            "json",
        ],
    ),
    (
        "campaign run",
        &[
            "experimenter",
            "bench",
            "drives",
            "by-hand",
            "at-rest",
            "rehearsal",
            "finger",
            "language",
        ],
    ),
    (
        "characterise",
        &[
            "bench",
            "excitation",
            "seconds",
            "repeats",
            "gate",
            "band",
            "record",
            "out",
            "report",
            "json",
        ],
    ),
    (
        "compare",
        &[
            "by", "meta", "load", "scale", "ridge", "csv", "report", "json", "figures",
        ],
    ),
    (
        "eeg epochs",
        &[
            "out",
            "event",
            "epoch",
            "without",
            "eog",
            "interpolate",
            "reference",
            "reject-above",
            "report",
            "json",
        ],
    ),
    (
        "eeg erd",
        &[
            "baseline",
            "window",
            "band",
            "region",
            "participant",
            "task",
            "event",
            "without",
            "eog",
            "interpolate",
            "reference",
            "reject-above",
            "out",
            "report",
            "json",
        ],
    ),
    (
        "eeg stats",
        &[
            "unit", "gradient", "margin", "band", "region", "csv", "report", "json", "figures",
        ],
    ),
    (
        "manipulate",
        &[
            "out",
            "gain",
            "band",
            "tilt",
            "rms-of",
            "spectrum-of",
            "randomise-phases",
            "loop",
            "stroke",
            "report",
        ],
    ),
    (
        "panel analyse",
        &[
            "control",
            "band",
            "average",
            "criterion",
            "csv",
            "report",
            "json",
            "figures",
        ],
    ),
    (
        "panel average",
        &[
            "angle", "load", "band", "average", "out", "csv", "report", "json", "figures",
        ],
    ),
    (
        "panel run",
        &[
            "bench",
            "participants",
            "loads",
            "angles",
            "repeats",
            "placements",
            "excitation",
            "seconds",
            "out",
            "json",
        ],
    ),
    (
        "prepare",
        &[
            "transfer", "bench", "out", "band", "level", "mode", "meta", "scale", "report", "json",
        ],
    ),
    (
        "record",
        &[
            "bench",
            "seconds",
            "sample",
            "touch",
            "speed",
            "load",
            "strokes",
            "metronome",
            "out",
            "json",
        ],
    ),
    (
        "render",
        &[
            "transfer", "out", "channel", "scale", "level", "inverse", "mode", "bench", "report",
            "json",
        ],
    ),
    (
        "roughness",
        &[
            "standard", "cutoff", "filter", "form", "along", "x-unit", "z-unit", "csv", "report",
            "json",
        ],
    ),
    (
        "score",
        &[
            "channel",
            "test-channel",
            "scale",
            "band",
            "model",
            "contact-map",
            "report",
            "json",
        ],
    ),
    (
        "serve",
        &[
            "bench",
            "drives",
            "by-hand",
            "rehearsal",
            "experimenter",
            "language",
            "folder",
            "port",
            "network",
            "password",
        ],
    ),
    (
        "sound align",
        &[
            "channel", "band", "block", "scale", "out", "csv", "report", "json",
        ],
    ),
    (
        "sound calibrate",
        &[
            "tone",
            "voltmeter",
            "input-volts",
            "exciter",
            "wires",
            "out",
            "report",
            "json",
        ],
    ),
    (
        "spectrum",
        &[
            "channel",
            "rest",
            "segment",
            "scale",
            "over-time",
            "csv",
            "report",
            "figures",
            "json",
        ],
    ),
    (
        "strokes",
        &[
            "by",
            "meta",
            "load",
            "scale",
            "ridge",
            "cuts-only",
            "write-cuts",
            "csv",
            "report",
            "json",
        ],
    ),
    (
        "transfer",
        &[
            "drive",
            "response",
            "excitation",
            "segment",
            "estimator",
            "gain",
            "volts-per-full-scale",
            "out",
            "report",
            "json",
        ],
    ),
    (
        "verify",
        &[
            "target", "measured", "scale", "drive", "band", "transfer", "also", "before", "report",
            "json",
        ],
    ),
    (
        "twin record",
        &[
            "bench",
            "sample",
            "participant",
            "seed",
            "speed",
            "load",
            "strokes",
            "task",
            "out",
            "json",
        ],
    ),
];

/// `root`, whose help lists its commands by what a person wants to do.
pub(crate) fn grouped(root: Command) -> Command {
    let about = |name: &&str| {
        let below = root.find_subcommand(name)?;
        Some(format!("  {name:<14}{}\n", below.get_about()?))
    };
    let groups = WANTED.iter().map(|(wanted, names)| {
        let rows: String = names.iter().filter_map(about).collect();
        format!("{wanted}:\n{rows}")
    });
    let groups: Vec<String> = groups.collect();
    let template = format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{}\nOptions:\n{{options}}{{after-help}}",
        groups.join("\n")
    );
    root.help_template(template)
}

/// The command line and its words, where they ask for help: all options with `--all`, else those that people use.
pub(crate) fn asked(root: Command, words: &[OsString]) -> (Command, Vec<OsString>) {
    let asks = |word: &OsString| word == "--help" || word == "-h";
    let asked = words.iter().any(asks) || words.get(1).is_some_and(|word| word == "help");
    let all = |word: &OsString| word == "--all";
    if !asked {
        return (root, words.to_vec());
    }
    if words.iter().any(all) {
        let words = words.iter().filter(|word| !all(word));
        return (root, words.cloned().collect());
    }
    let is_command = |word: &OsString| root.find_subcommand(word).is_some();
    if !words.iter().skip(1).any(is_command) {
        return (root, words.to_vec());
    }
    (usual("", root), words.to_vec())
}

/// The command `name`, and those below it, with the options that people use; those of every command are among the rest.
fn usual(name: &str, command: Command) -> Command {
    let below: Vec<String> = command
        .get_subcommands()
        .map(|below| below.get_name().to_owned())
        .collect();
    if !below.is_empty() {
        let command = command.mut_args(|option| option.hide(true));
        return below.iter().fold(command, |command, one| {
            let name = format!("{name} {one}");
            command.mut_subcommand(one, |below| usual(name.trim(), below))
        });
    }
    let shown = USUAL.iter().find(|(of, _)| *of == name);
    let mut more = OF_EVERY_COMMAND;
    let command = command.mut_args(|option| match (option.get_long(), shown) {
        (Some(long), Some((_, shown))) if !shown.contains(&long) && !option.is_hide_set() => {
            more += 1;
            option.hide(true)
        }
        _ => option,
    });
    let after = command.get_after_help().map(ToString::to_string);
    let after = after.unwrap_or_default();
    command.after_help(format!(
        "{more} more options: piezotact {name} --help --all\n\n{after}"
    ))
}

/// `--date` and `--force`.
const OF_EVERY_COMMAND: usize = 2;

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;
    use std::path::Path;

    use super::*;

    /// A line of shell as words, with what stands in quotes kept together.
    fn words(line: &str) -> Vec<String> {
        let parts = line.split(['"', '\'']).enumerate();
        let words = parts.flat_map(|(i, part)| match i % 2 {
            1 => vec![part.to_owned()],
            _ => part.split_whitespace().map(str::to_owned).collect(),
        });
        words.collect()
    }

    /// The command `name` and all below it.
    fn every(name: &str, command: &Command, found: &mut Vec<(String, Command)>) {
        found.push((name.to_owned(), command.clone()));
        for below in command.get_subcommands() {
            every(format!("{name} {}", below.get_name()).trim(), below, found);
        }
    }

    /// What a command and what is below it must have: help in one line, a reviewed snapshot of it, help of every option, examples
    /// that are understood, and at most ten options that are shown.
    #[test]
    fn every_command_has_help_and_examples() {
        let mut found = Vec::new();
        every("", &crate::commands::command(), &mut found);
        let snapshots = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/snapshots");
        for (name, command) in &found {
            let about = command.get_about().map(ToString::to_string);
            let about = about.unwrap_or_default();
            assert!(!about.is_empty(), "{name} has no help");
            if command.is_hide_set() {
                continue;
            }
            let of = format!("help {name}").trim().replace(' ', "_");
            let snapshot = snapshots.join(format!("all__snapshots__{of}.snap"));
            assert!(
                snapshot.exists(),
                "the help of {name} has no snapshot: add it to COMMANDS in tests/support/mod.rs"
            );
            for argument in command.get_arguments() {
                assert!(
                    argument.get_help().is_some(),
                    "{} of {name} has no help",
                    argument.get_id()
                );
            }
            if command.has_subcommands() {
                continue;
            }
            assert!(
                about.chars().count() <= 125,
                "{name}: {} letters",
                about.len()
            );
            let after = command.get_after_help().map(ToString::to_string);
            let after = after.unwrap_or_default();
            let (_, examples) = after.split_once("Example:").unwrap_or_default();
            let lines = examples.lines().filter_map(|line| {
                let line = line.trim();
                line.starts_with("piezotact ").then_some(line)
            });
            let lines: Vec<&str> = lines.collect();
            let own = format!("piezotact {name}");
            assert!(
                lines.iter().any(|line| line.starts_with(&own)),
                "{name} has no example in its help"
            );
            for line in lines {
                let given = line.split(" > ").next().unwrap_or_default();
                let parsed = crate::commands::command().try_get_matches_from(words(given));
                assert!(parsed.is_ok(), "{line}: {}", parsed.unwrap_err());
            }
            let shown = usual(name, command.clone());
            let options = shown.get_arguments();
            let options = options.filter(|option| !option.is_hide_set());
            let options: BTreeSet<_> = options.filter_map(|option| option.get_long()).collect();
            // EEG has fifteen at most, and is cut.
            let most = if name == "eeg erd" { 15 } else { 10 };
            assert!(
                options.len() <= most,
                "{name} shows {options:?}: state in USUAL those that people use"
            );
            let required = command.get_arguments().filter(|one| one.is_required_set());
            for required in required.filter_map(|one| one.get_long()) {
                assert!(options.contains(required), "{name} hides --{required}");
            }
        }
        let stored = std::fs::read_dir(snapshots).unwrap();
        let stored = stored.filter(|file| {
            let name = file.as_ref().unwrap().file_name();
            name.to_string_lossy().starts_with("all__snapshots__help")
        });
        let seen = found.iter().filter(|(_, command)| !command.is_hide_set());
        // One more is that of all options of a command.
        assert_eq!(stored.count(), seen.count() + 1, "snapshots of no command");
    }

    /// What the tables name exists, and every command stands in a group.
    #[test]
    fn tables_of_help_name_what_exists() {
        let root = crate::commands::command();
        let named: BTreeSet<&str> = WANTED
            .iter()
            .flat_map(|(_, names)| *names)
            .copied()
            .collect();
        let seen = root.get_subcommands().filter(|below| !below.is_hide_set());
        let seen: BTreeSet<&str> = seen.map(Command::get_name).collect();
        assert_eq!(named, seen);
        for (name, options) in USUAL {
            let command = name
                .split(' ')
                .try_fold(&root, |above, below| above.find_subcommand(below));
            let command = command.unwrap_or_else(|| panic!("there is no command {name}"));
            for option in options {
                let mut own = command.get_arguments();
                assert!(
                    own.any(|one| one.get_long() == Some(*option)),
                    "{name} has no option --{option}"
                );
            }
        }
    }

    #[test]
    fn help_with_all_shows_the_rest() {
        let shown = |line: &str| {
            let words: Vec<OsString> = line.split(' ').map(OsString::from).collect();
            let (mut root, words) = asked(crate::commands::command(), &words);
            root.try_get_matches_from_mut(words)
                .unwrap_err()
                .to_string()
        };
        let usual = shown("piezotact strokes --help");
        assert!(
            usual.contains("--cuts-only") && !usual.contains("--every-contact"),
            "{usual}"
        );
        assert!(
            usual.contains("more options: piezotact strokes --help --all"),
            "{usual}"
        );
        let all = shown("piezotact strokes --help --all");
        assert!(
            all.contains("--every-contact") && all.contains("--force"),
            "{all}"
        );
        // What is hidden is proposed as what is shown.
        let near = shown("piezotact strokes a.csv --every-contac");
        assert!(near.contains("'--every-contact'"), "{near}");
        let root = shown("piezotact --help");
        assert!(
            root.contains("Ask people:\n  campaign") && root.contains("--force"),
            "{root}"
        );
    }
}
