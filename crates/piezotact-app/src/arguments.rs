//! What was given on the command line, argument by argument, whatever the command: settings, outputs, and the command to run again.

use std::any::TypeId;
use std::ffi::{OsStr, OsString};
use std::path::{Path, PathBuf};

use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Command};
use piezotact::invocation::Setting;

/// The arguments that name what a command writes, whatever the command: files, or folders for files. A test holds every argument
/// that is a path against this list.
pub(crate) const OUTPUTS: [&str; 7] = [
    "out",
    "record",
    "report",
    "figures",
    "tables",
    "csv",
    "write_cuts",
];

/// One argument of a command that has a value.
struct Valued<'a> {
    argument: &'a Arg,
    /// The values of each occurrence.
    occurrences: Vec<Vec<&'a OsStr>>,
    /// Where each occurrence stood; empty for a default.
    places: Vec<usize>,
    given: bool,
}

/// A command with its arguments.
pub(crate) struct Arguments<'a> {
    /// Its name: `panel run`.
    pub(crate) names: Vec<String>,
    valued: Vec<Valued<'a>>,
}

/// An output that was given, or is the default.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) struct OutputPath {
    /// The name of its argument.
    pub(crate) setting: String,
    pub(crate) path: PathBuf,
}

impl<'a> Arguments<'a> {
    /// The arguments of the command that `matches` of `root` ends in.
    pub(crate) fn of(root: &'a Command, matches: &'a ArgMatches) -> Self {
        let (mut command, mut found, mut names) = (root, matches, Vec::new());
        while let Some((name, below)) = found.subcommand() {
            let Some(next) = command.find_subcommand(name) else {
                break;
            };
            names.push(name.to_owned());
            (command, found) = (next, below);
        }
        let own = |argument: &&Arg| !argument.is_global_set() && !is_shown_only(argument);
        let valued = command.get_arguments().filter(own);
        let valued = valued.filter_map(|argument| valued_in(argument, found));
        Self {
            names,
            valued: valued.collect(),
        }
    }

    /// Every setting that has a value, in the order of the help.
    pub(crate) fn settings(&self) -> Vec<Setting> {
        let setting = |valued: &Valued<'_>| {
            let occurrences = valued.occurrences.iter();
            Setting {
                name: valued.argument.get_id().to_string(),
                values: occurrences
                    .flat_map(|values| valued.shown(values))
                    .map(|value| value.to_string_lossy().into_owned())
                    .collect(),
                given: valued.given,
            }
        };
        self.valued.iter().map(setting).collect()
    }

    /// What the command writes: the values of its outputs.
    pub(crate) fn outputs(&self) -> Vec<OutputPath> {
        let outputs = self
            .valued
            .iter()
            .filter(|valued| is_output(valued.argument));
        let paths = outputs.flat_map(|valued| {
            let paths = valued.occurrences.iter().flatten();
            paths.map(|path| OutputPath {
                setting: valued.argument.get_id().to_string(),
                path: path.into(),
            })
        });
        paths.collect()
    }

    /// The value of the setting `name`, in words.
    pub(crate) fn value(&self, name: &str) -> Option<String> {
        let settings = self.settings().into_iter();
        let mut found = settings.filter(|setting| setting.name == name);
        found.next().map(|setting| setting.values.join(" "))
    }

    /// The files that arguments name and that are no outputs.
    pub(crate) fn named_inputs(&self) -> Vec<PathBuf> {
        let inputs = self.valued.iter();
        let inputs =
            inputs.filter(|valued| is_path(valued.argument) && !is_output(valued.argument));
        let paths = inputs.flat_map(|valued| valued.occurrences.iter().flatten());
        paths.map(PathBuf::from).collect()
    }

    /// The command that does the same, with each output at the path that `led` gives for it. Options stand in their order, with
    /// their values attached; what is no option stands behind `--`.
    pub(crate) fn again(&self, led: &mut dyn FnMut(&OutputPath) -> PathBuf) -> Vec<OsString> {
        let mut options: Vec<(usize, OsString)> = Vec::new();
        let mut positional: Vec<(usize, OsString)> = Vec::new();
        for valued in &self.valued {
            let output = is_output(valued.argument);
            if !valued.given && !output {
                continue;
            }
            for (i, values) in valued.occurrences.iter().enumerate() {
                let place = valued.places.get(i).copied().unwrap_or_default();
                let value = match output {
                    false => valued.joined(values),
                    true => led(&OutputPath {
                        setting: valued.argument.get_id().to_string(),
                        path: valued.joined(values).into(),
                    })
                    .into_os_string(),
                };
                match valued.argument.get_long() {
                    None => positional.extend(
                        values
                            .iter()
                            .map(|one| (place, if output { value.clone() } else { one.into() })),
                    ),
                    Some(name) => options.push((place, option(name, valued.argument, &value))),
                }
            }
        }
        options.sort_by_key(|(place, _)| *place);
        let names = self.names.iter().map(OsString::from);
        let options = options.into_iter().map(|(_, option)| option);
        let end = (!positional.is_empty()).then(|| OsString::from("--"));
        let positional = positional.into_iter().map(|(_, value)| value);
        names.chain(options).chain(end).chain(positional).collect()
    }
}

impl Valued<'_> {
    /// The values of one occurrence as they are listed: apart, unless one text held them all.
    fn shown(&self, values: &[&OsStr]) -> Vec<OsString> {
        match self.argument.get_value_delimiter() {
            Some(_) => vec![self.joined(values)],
            None => values.iter().map(OsString::from).collect(),
        }
    }

    /// The values of one occurrence as one text, as they were given.
    fn joined(&self, values: &[&OsStr]) -> OsString {
        let delimiter = self.argument.get_value_delimiter().unwrap_or(' ');
        values.join(OsStr::new(&delimiter.to_string()))
    }
}

fn option(name: &str, argument: &Arg, value: &OsStr) -> OsString {
    let mut option = OsString::from(format!("--{name}"));
    if !is_flag(argument) {
        option.push("=");
        option.push(value);
    }
    option
}

fn valued_in<'a>(argument: &'a Arg, found: &'a ArgMatches) -> Option<Valued<'a>> {
    let id = argument.get_id().as_str();
    let source = found.value_source(id)?;
    let raw = found.get_raw_occurrences(id)?;
    let occurrences: Vec<Vec<&OsStr>> = raw.map(Iterator::collect).collect();
    if is_flag(argument) && source == ValueSource::DefaultValue {
        return None;
    }
    let all: Vec<usize> = found.indices_of(id)?.collect();
    let mut firsts = 0;
    let places = occurrences.iter().map(|values| {
        let place = all.get(firsts).copied().unwrap_or_default();
        firsts += values.len();
        place
    });
    Some(Valued {
        places: places.collect(),
        argument,
        given: source == ValueSource::CommandLine,
        occurrences,
    })
}

fn is_flag(argument: &Arg) -> bool {
    matches!(argument.get_action(), ArgAction::SetTrue)
}

/// Whether an argument only asks for help.
fn is_shown_only(argument: &Arg) -> bool {
    !matches!(
        argument.get_action(),
        ArgAction::Set | ArgAction::Append | ArgAction::SetTrue
    )
}

/// Whether the value of an argument is a path.
pub(crate) fn is_path(argument: &Arg) -> bool {
    argument.get_value_parser().type_id() == TypeId::of::<PathBuf>()
}

/// Whether an argument names what a command writes.
pub(crate) fn is_output(argument: &Arg) -> bool {
    is_path(argument) && OUTPUTS.contains(&argument.get_id().as_str())
}

/// The output that `path` is, or stands in, with its path in the folder of that output.
pub(crate) fn output_of<'o, 'p>(
    outputs: &'o [OutputPath],
    path: &'p Path,
) -> Option<(&'o OutputPath, &'p Path)> {
    let below = |output: &'o OutputPath| Some((output, path.strip_prefix(&output.path).ok()?));
    outputs
        .iter()
        .filter_map(below)
        .min_by_key(|(_, below)| below.as_os_str().len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory as _;

    use crate::cli::Cli;

    /// The arguments that name what a command reads, and those that name a folder that it changes.
    const INPUTS: &[&str] = &[
        "answers",
        "against",
        "at_rest",
        "drive",
        "electrodes",
        "events",
        "felt",
        "file",
        "files",
        "folder",
        "input",
        "certificate",
        "consent",
        "drives",
        "key",
        "passphrase",
        "password",
        "protocol",
        "study",
        "recording",
        "recordings",
        "reference",
        "test",
        "target",
        "targets",
        "measured",
        "transfer",
        "also",
        "before",
        "cuts",
        "set",
        "setup",
        "contact_map",
        "control",
        "twin",
        "eeg",
    ];

    /// Every path of every command is known as read or as written: a new output that is not led into the folder of a rerun
    /// would be written over.
    #[test]
    fn every_path_is_known_as_read_or_written() {
        fn check(command: &Command, checked: &mut usize) {
            for argument in command.get_arguments().filter(|argument| is_path(argument)) {
                let id = argument.get_id().as_str();
                let known = [OUTPUTS.contains(&id), INPUTS.contains(&id)];
                assert!(
                    known[0] != known[1],
                    "{} of {}: state in OUTPUTS or INPUTS whether it is written or read",
                    id,
                    command.get_name()
                );
                *checked += 1;
            }
            command
                .get_subcommands()
                .for_each(|below| check(below, checked));
        }
        let mut checked = 0;
        check(&crate::commands::command(), &mut checked);
        assert!(checked > 60, "{checked}");
    }

    fn again(line: &str) -> Vec<String> {
        let mut root = Cli::command();
        let words = std::iter::once("piezotact").chain(line.split(' '));
        let matches = root.try_get_matches_from_mut(words).unwrap();
        let arguments = Arguments::of(&root, &matches);
        let led = &mut |output: &OutputPath| Path::new("/tmp/again").join(&output.path);
        let again = arguments.again(led).into_iter();
        again.map(|word| word.into_string().unwrap()).collect()
    }

    #[test]
    fn a_command_is_given_again_with_its_order_and_other_outputs() {
        assert_eq!(
            again(
                "manipulate S8.wav --tilt 3dB/oct@200Hz --gain -3dB --randomise-phases --gain=1dB --out m.wav --json"
            ),
            [
                "manipulate",
                "--tilt=3dB/oct@200Hz",
                "--gain=-3dB",
                "--randomise-phases",
                "--gain=1dB",
                "--out=/tmp/again/m.wav",
                "--json",
                "--",
                "S8.wav"
            ]
        );
        assert_eq!(
            again("panel run --bench twin:seed=7 --participants 1 --loads 0.2,0.6 --out p"),
            [
                "panel",
                "run",
                "--bench=twin:seed=7",
                "--participants=1",
                "--loads=0.2,0.6",
                "--out=/tmp/again/p"
            ]
        );
        // An output that is the default is led too.
        assert_eq!(again("demo"), ["demo", "--out=/tmp/again/piezotact-demo"]);
        assert_eq!(
            again("spectrum --json a.wav --csv out.csv"),
            [
                "spectrum",
                "--json",
                "--csv=/tmp/again/out.csv",
                "--",
                "a.wav"
            ]
        );
    }
}
