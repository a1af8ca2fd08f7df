//! Verifications as they are handed out.

use serde::Serialize;

use super::{Changed, UncompensatedOutcome, Verification};
use crate::document::{Content, Named};

/// A verification with its verdict as a yes or no and as a sentence, which follow from it and change with it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct JudgedVerification<'a> {
    /// What was found.
    #[serde(flatten)]
    pub verification: &'a Verification,
    /// Whether every criterion is met.
    pub passed: bool,
    /// The verdict in one sentence.
    pub sentence: String,
}

impl<'a> JudgedVerification<'a> {
    /// `verification` with its verdict.
    ///
    /// Source: docs/decisions/documents.md.
    #[must_use]
    pub fn of(verification: &'a Verification) -> Self {
        Self {
            verification,
            passed: verification.passed(),
            sentence: verification.sentence(),
        }
    }
}

/// How close a measurement came to its target, with the other measurements that were asked for: several values of one command.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct VerifyDocument<'a> {
    /// The measurement that decides.
    #[serde(flatten)]
    pub verification: JudgedVerification<'a>,
    /// What the texture itself as a drive would give; absent without a transfer function.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uncompensated_predicted: Option<&'a UncompensatedOutcome>,
    /// Further measurements.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub also: Vec<Named<'a, JudgedVerification<'a>>>,
    /// Textures before their manipulation.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub before: Vec<Named<'a, &'a Changed>>,
}

impl Content for VerifyDocument<'_> {
    const SCHEMA: &'static str = "verify";
}

/// A texture that was rendered, played and measured on the twin, and the same texture played as it stands: several values of one command.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct DemoDocument<'a> {
    /// The name of the report.
    pub report: &'a str,
    /// What was rendered.
    pub verification: JudgedVerification<'a>,
    /// The texture itself as a drive.
    pub uncompensated: JudgedVerification<'a>,
    /// The same, turned down until nothing clips.
    pub uncompensated_level_matched: JudgedVerification<'a>,
}

impl Content for DemoDocument<'_> {
    const SCHEMA: &'static str = "demo";
}
