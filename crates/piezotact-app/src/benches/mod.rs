//! The table of benches, and how each is named on the command line: `twin:participant=3,seed=7`, `measured:hand.json`.
//!
//! A new bench is a file in this folder and a line in [`BENCHES`].

#[cfg(feature = "audio")]
pub(crate) mod audio;
#[cfg(feature = "fake")]
mod fake;
mod measured;
mod twin;

use std::fmt;
use std::path::Path;
#[cfg(any(feature = "audio", feature = "fake"))]
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;

use piezotact_bench::{Bench, DeviceError, ProcedureError};

pub(crate) use twin::TwinSpec;

use crate::failure::Outcome;
use crate::interrupt::{self, interrupted};
use crate::live;

/// One bench of the table.
struct BenchEntry {
    /// What stands before the colon.
    name: &'static str,
    /// How it may be written.
    example: &'static str,
    /// All that may be written, for the help of `--bench`.
    help: &'static str,
    /// The same for the participants that the command names; none if the bench is of one participant only.
    help_with_turns: Option<&'static str>,
    /// Reads what stands behind the colon.
    parse: fn(&str) -> Result<BenchSpec, DeviceError>,
}

/// All benches that can be named.
const BENCHES: &[BenchEntry] = &[
    twin::ENTRY,
    measured::ENTRY,
    #[cfg(feature = "audio")]
    audio::ENTRY,
    #[cfg(feature = "fake")]
    fake::ENTRY,
];

/// The help of an option that names a bench.
pub(crate) fn help(of: &str) -> String {
    let all: Vec<&str> = BENCHES.iter().map(|entry| entry.help).collect();
    format!("{of}: {}", all.join("; or "))
}

/// The help of an option that names a bench at which people take turns.
pub(crate) fn help_with_turns(of: &str, who: &str) -> String {
    let all: Vec<&str> = BENCHES
        .iter()
        .filter_map(|entry| entry.help_with_turns)
        .collect();
    format!("{of}: {}; {who}", all.join("; or "))
}

/// What a bench that was named can do before it is opened.
pub(crate) trait NamedBench: fmt::Debug + Send + Sync {
    /// Opens it.
    fn open(&self) -> Outcome<Bench>;
    /// The file that is read when it is opened, where there is one.
    fn file(&self) -> Option<&Path> {
        None
    }
    /// The participant that its settings name; none where they name nobody.
    fn participant(&self) -> Option<u64> {
        None
    }
    /// The same bench with participant `number` at it.
    fn with_participant(&self, number: u64) -> Result<BenchSpec, DeviceError>;
    /// The bench by name and settings, whoever sits at it.
    fn apart_from_participant(&self) -> String;
    /// The bench as it can be named on the command line.
    #[cfg(feature = "web")]
    fn text(&self) -> String {
        let participant = self.participant();
        let participant =
            participant.map_or(String::new(), |number| format!(",participant={number}"));
        format!("{}{participant}", self.apart_from_participant())
    }
    /// Participant and seed of the digital twin, who can touch samples too; none on other benches.
    #[cfg(feature = "study")]
    fn person_of_twin(&self) -> Option<(u64, u64)> {
        None
    }
}

/// A bench by name, with its settings.
#[derive(Clone, Debug)]
pub(crate) struct BenchSpec(Arc<dyn NamedBench>);

impl BenchSpec {
    /// The bench that `named` describes.
    pub(crate) fn of(named: impl NamedBench + 'static) -> Self {
        Self(Arc::new(named))
    }
}

impl BenchSpec {
    /// Opens it; Ctrl-C stops what runs on it, and none is opened after it.
    pub(crate) fn open(&self) -> Outcome<Bench> {
        if interrupted() {
            return Err(ProcedureError::Stopped {
                label: "next measurement".into(),
                after_s: 0.0,
            }
            .into());
        }
        let bench = live::bench(self.0.open()?);
        interrupt::stops(&bench.stop);
        Ok(bench)
    }
}

impl std::ops::Deref for BenchSpec {
    type Target = dyn NamedBench;

    fn deref(&self) -> &Self::Target {
        self.0.as_ref()
    }
}

impl FromStr for BenchSpec {
    type Err = DeviceError;

    fn from_str(text: &str) -> Result<Self, DeviceError> {
        let (name, settings) = text.split_once(':').unwrap_or((text, ""));
        match BENCHES.iter().find(|entry| entry.name == name) {
            Some(entry) => (entry.parse)(settings),
            #[cfg(not(feature = "every-command"))]
            None if ["audio", "fake"].contains(&name) => Err(DeviceError::Impossible {
                expected: "a bench of this build".into(),
                found: format!("`{name}`"),
                todo: "build piezotact with ./x build, which has it".into(),
            }),
            None => {
                let names: Vec<&str> = BENCHES.iter().map(|entry| entry.name).collect();
                let names = names.join(", ");
                let expected = format!("a bench that this program knows ({names})");
                Err(wrong(&expected, name))
            }
        }
    }
}

fn wrong(expected: &str, found: &str) -> DeviceError {
    let examples: Vec<String> = BENCHES
        .iter()
        .map(|entry| format!("--bench {}", entry.example))
        .collect();
    DeviceError::Impossible {
        expected: expected.into(),
        found: format!("`{found}`"),
        todo: format!("write for example {}", examples.join(" or ")),
    }
}

fn whole(setting: &str, value: &str) -> Result<u64, DeviceError> {
    value
        .parse()
        .map_err(|_not_a_number| wrong("a whole number from 0", setting))
}

/// `FILE` or `FILE,participant=N` behind the colon of a bench that is written as `form` and whose file `holds` something.
#[cfg(any(feature = "audio", feature = "fake"))]
fn file_and_participant(
    text: &str,
    form: &str,
    holds: &str,
) -> Result<(PathBuf, Option<u64>), DeviceError> {
    let (file, participant) = match text.rsplit_once(',') {
        Some((file, setting)) => match setting.split_once('=') {
            Some(("participant", number)) => (file, Some(whole(setting, number)?)),
            _ => return Err(wrong(&format!("{form} or {form},participant=N"), setting)),
        },
        None => (text, None),
    };
    match file.is_empty() {
        true => Err(wrong(&format!("{form} with {holds}"), "no file")),
        false => Ok((file.into(), participant)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_bench_stands_in_the_help() {
        let all = help("The bench");
        for entry in BENCHES {
            assert!(all.contains(&format!("{}:", entry.name)), "{all}");
        }
        let turns = help_with_turns("The bench", "who");
        assert!(
            turns.contains("fake:") && !turns.contains("measured:"),
            "{turns}"
        );
    }

    #[test]
    fn benches_have_names() {
        let twin: BenchSpec = "twin:participant=3,seed=9,gain=B2".parse().unwrap();
        assert_eq!(twin.apart_from_participant(), "twin:seed=9,gain=B2");
        assert!(twin.with_participant(4).is_ok());
        let measured: BenchSpec = "measured:hand.json".parse().unwrap();
        assert!(measured.with_participant(2).is_err());
        for bad in ["", "shaker", "twin:colour=red", "measured:"] {
            let said = bad.parse::<BenchSpec>().unwrap_err().to_string();
            assert!(said.contains("--bench twin:"), "{bad}: {said}");
        }
    }
}
