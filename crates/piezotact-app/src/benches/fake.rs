//! `fake:script.toml`, `fake:script.toml,participant=2`: a bench that follows a script, for tests and for practice.

use std::path::{Path, PathBuf};

use anyhow::Context;
use piezotact_bench::fake::{FakeScript, fake};
use piezotact_bench::{Bench, DeviceError};

use super::{BenchEntry, BenchSpec, NamedBench, whole, wrong};
use crate::failure::Outcome;

/// The line of the table of benches.
pub(super) const ENTRY: BenchEntry = BenchEntry {
    name: "fake",
    example: "fake:script.toml",
    help: "fake:FILE.toml,participant=K, which follows the script in FILE.toml and simulates device faults, for tests and for \
     training",
    help_with_turns: Some(
        "fake:FILE.toml, which follows the script in FILE.toml and simulates device faults, for tests and for training",
    ),
    parse,
};

/// A script by its file, with the number of the participant.
#[derive(Clone, Debug, PartialEq, Eq)]
struct FakeSpec {
    file: PathBuf,
    participant: Option<u64>,
}

impl NamedBench for FakeSpec {
    fn open(&self) -> Outcome<Bench> {
        let called = || self.file.display().to_string();
        let text = piezotact_dataset::reads::read_to_string(&self.file).with_context(called)?;
        let script = FakeScript::from_toml(&text).with_context(called)?;
        Ok(fake(
            script,
            &format!("F{:02}", self.participant.unwrap_or(1)),
        )?)
    }

    fn file(&self) -> Option<&Path> {
        Some(&self.file)
    }

    fn participant(&self) -> Option<u64> {
        self.participant
    }

    fn with_participant(&self, number: u64) -> Result<BenchSpec, DeviceError> {
        Ok(BenchSpec::of(Self {
            participant: Some(number),
            ..self.clone()
        }))
    }

    fn apart_from_participant(&self) -> String {
        format!("fake:{}", self.file.display())
    }
}

fn parse(text: &str) -> Result<BenchSpec, DeviceError> {
    let (file, participant) = match text.rsplit_once(',') {
        Some((file, setting)) => match setting.split_once('=') {
            Some(("participant", number)) => (file, Some(whole(setting, number)?)),
            _ => return Err(wrong("fake:FILE or fake:FILE,participant=N", setting)),
        },
        None => (text, None),
    };
    if file.is_empty() {
        return Err(wrong("fake:FILE with a script in TOML", "fake:"));
    }
    Ok(BenchSpec::of(FakeSpec {
        file: file.into(),
        participant,
    }))
}
