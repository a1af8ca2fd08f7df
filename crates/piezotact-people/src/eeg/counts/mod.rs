//! Epochs of a recording, counted, as a document.

mod page;

use piezotact::Warning;
use piezotact::document::Content;
use piezotact::quantity::SampleRate;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

use super::prepare::{EpochCounts, PrepareConfig, Prepared};
use super::source::Subject;

/// Epochs of a recording, counted.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct EegEpochs {
    /// The file.
    pub file: String,
    /// Who and what it is of.
    pub subject: Subject,
    /// How epochs were made.
    pub config: PrepareConfig,
    /// The rate.
    pub rate_hz: SampleRate,
    /// The electrodes.
    pub channels: Vec<String>,
    /// Which markers have an epoch.
    pub counts: EpochCounts,
    /// What to know before relying on it.
    #[serde(alias = "doubts")]
    pub warnings: Vec<Warning>,
}

impl Content for EegEpochs {
    const SCHEMA: &'static str = "eeg_epochs";
    const VERSION: u32 = 2;

    /// The first version also held averages.
    fn outdated(version: u64, _: &Map<String, Value>) -> Option<String> {
        (version < 2).then(|| "make it again with `piezotact eeg epochs`; evoked responses are those of MNE (docs/guide/mne.md)".to_owned())
    }
}

impl EegEpochs {
    /// How many epochs of a file there are, and why the others are not.
    ///
    /// # Errors
    /// None.
    ///
    /// Source: none; what [`super::prepare::prepare`] counted.
    #[must_use]
    pub fn of(file: &str, subject: &Subject, prepared: &Prepared) -> Self {
        Self {
            file: file.to_owned(),
            subject: subject.clone(),
            config: prepared.config.clone(),
            rate_hz: prepared.rate(),
            channels: prepared.epochs.channels().to_vec(),
            counts: prepared.counts.clone(),
            warnings: prepared.warnings.clone(),
        }
    }
}
