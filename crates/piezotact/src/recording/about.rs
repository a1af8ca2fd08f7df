//! Metadata of a measured or computed value: its condition, provenance and warnings.

use serde::{Deserialize, Serialize, Serializer};

use super::{BenchKind, Condition, Provenance};
use crate::warning::{Merged, Warning, merged};

/// Metadata of a recording, a drive or a transfer function. Serialised flat: three fields of the value that holds it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct About {
    /// The experimental condition: who touched what, and how.
    pub condition: Condition,
    /// Where it comes from.
    pub provenance: Provenance,
    /// What a person should know before relying on it.
    #[serde(alias = "doubts")]
    pub warnings: Vec<Warning>,
}

impl About {
    /// Whether a participant of the twin is named without the seed that says which one of that name it is.
    #[must_use]
    pub fn lacks_twin_seed(&self) -> bool {
        self.condition.participant.is_some()
            && self.condition.twin_seed.is_none()
            && self.provenance.bench == Some(BenchKind::Twin)
            && self.provenance.seed.is_some()
    }

    /// Metadata without warnings.
    #[must_use]
    pub fn new(condition: Condition, provenance: Provenance) -> Self {
        Self {
            condition,
            provenance,
            warnings: Vec::new(),
        }
    }

    /// Adds those of `more` that it does not carry yet.
    pub fn add_warnings(&mut self, more: impl IntoIterator<Item = Warning>) {
        for warning in more {
            if !self.warnings.contains(&warning) {
                self.warnings.push(warning);
            }
        }
    }

    /// Serialises it without an empty list of warnings, for documents that are written before any warning can exist; for serde's
    /// `serialize_with`.
    ///
    /// # Errors
    /// Those of the serializer.
    pub fn without_empty_warnings<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        #[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
        struct Stated<'a> {
            condition: &'a Condition,
            provenance: &'a Provenance,
            #[serde(skip_serializing_if = "<[Warning]>::is_empty")]
            warnings: &'a [Warning],
        }
        Stated {
            condition: &self.condition,
            provenance: &self.provenance,
            warnings: &self.warnings,
        }
        .serialize(serializer)
    }

    /// Serialises it with the warnings of one kind as one, for documents of results; for serde's `serialize_with`.
    ///
    /// # Errors
    /// Those of the serializer.
    pub fn merged<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        MergedAbout {
            condition: &self.condition,
            provenance: &self.provenance,
            warnings: merged(&self.warnings),
        }
        .serialize(serializer)
    }
}

/// [`About`] as a document of a result has it.
#[derive(Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub(crate) struct MergedAbout<'a> {
    /// Who touched what, and how.
    condition: &'a Condition,
    /// Where it comes from.
    provenance: &'a Provenance,
    /// What limits it.
    warnings: Vec<Merged>,
}
