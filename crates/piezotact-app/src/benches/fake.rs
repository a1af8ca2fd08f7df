//! `fake:script.toml`, `fake:script.toml,participant=2`: a bench that follows a script, for tests and for practice.

use piezotact_dataset::read_input_text;
use std::path::{Path, PathBuf};

use anyhow::Context;
use piezotact_bench::fake::{FakeScript, fake};
use piezotact_bench::{Bench, DeviceError};

use super::{BenchEntry, BenchSpec, NamedBench, file_and_participant};
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
        let text = read_input_text(&self.file)?;
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
    let (file, participant) = file_and_participant(text, "fake:FILE", "a script in TOML")?;
    Ok(BenchSpec::of(FakeSpec { file, participant }))
}
