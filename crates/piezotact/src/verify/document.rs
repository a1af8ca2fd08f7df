//! Verifications as they are handed out.

use serde::Serialize;

use super::{Changed, Compared, UncompensatedOutcome, Verification};
use crate::document::Content;
use crate::quantity::Acceleration;
use crate::series::Series;
use crate::warning::Warning;

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

/// A further measurement of the same target.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct FurtherVerification<'a> {
    /// The name of its file.
    pub file: &'a str,
    #[serde(flatten)]
    pub verification: JudgedVerification<'a>,
    /// The level that it states to be rendered at re the target, dB; absent where it states none.
    #[serde(skip)]
    pub rendered_at_db: Option<f64>,
    /// The warnings about it and not of its target alone.
    #[serde(skip)]
    pub warnings: Vec<Warning>,
}

/// A texture that the target was made from, or that it took something of.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct TextureBefore<'a> {
    /// The name of its file.
    pub file: &'a str,
    /// What it differs by from the target.
    #[serde(flatten)]
    pub changed: &'a Changed,
    /// The texture, m/s².
    #[serde(skip)]
    pub series: &'a Series<Acceleration>,
}

/// How close a measurement came to its target, with the other measurements that were asked for: several values of one command.
#[derive(Clone, Debug, Serialize)]
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
    pub also: Vec<FurtherVerification<'a>>,
    /// Textures before their manipulation.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub before: Vec<TextureBefore<'a>>,
    /// What was compared.
    #[serde(skip)]
    pub compared: Compared<'a>,
}

impl Content for VerifyDocument<'_> {
    const SCHEMA: &'static str = "verify";
}

/// A texture that was rendered, played and measured on the twin, and the same texture played as it stands: several values of one command.
#[derive(Clone, Debug, Serialize)]
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
    /// What was compared.
    #[serde(skip)]
    pub compared: Compared<'a>,
}

impl Content for DemoDocument<'_> {
    const SCHEMA: &'static str = "demo";
}
