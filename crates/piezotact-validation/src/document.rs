//! A replay as it is handed out: its findings, without its figures.

use piezotact::criterion::Criterion;
use piezotact::document::{Content, Words};
use serde::Serialize;

use crate::count::PanelCount;
use crate::{CLAIMS, Chapter, ClaimRule, Finding, Verdict};
use piezotact_volunteers::Laboratory;

/// A chapter of the thesis that was measured again.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ChapterDocument<'a> {
    /// Its number in the thesis.
    pub number: u8,
    /// What it is about.
    pub title: &'static str,
    /// What was measured, in sentences.
    pub measured: &'a [String],
    /// What limits it, in sentences.
    pub warnings: Vec<String>,
    /// What is not there yet.
    pub missing: &'a [String],
}

/// What was found of a claim.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct FindingDocument<'a> {
    /// The number of the claim.
    pub claim: u8,
    /// The chapter of the thesis; absent for a claim that is not listed.
    pub chapter: Option<u8>,
    /// Where it stands there.
    pub at: Option<&'static str>,
    /// What the thesis says.
    pub says: Option<&'static str>,
    /// The sentence of the thesis that the criterion follows; absent where none is quoted.
    pub quote: Option<&'static str>,
    /// What was looked at, what was found, and whether it is met.
    pub criteria: &'a [Criterion<ClaimRule>],
    /// When it holds, in words.
    pub holds_if: Option<&'static str>,
    /// What was measured, with its unit.
    pub measured: &'a str,
    /// `holds`, `does_not_hold` or `not_yet`.
    pub verdict: &'static str,
    /// Why it does not hold, or what brings it.
    pub reason: Option<String>,
}

impl<'a> From<&'a Finding> for FindingDocument<'a> {
    fn from(finding: &'a Finding) -> Self {
        let claim = CLAIMS.iter().find(|claim| claim.number == finding.claim);
        let (verdict, reason) = match &finding.verdict {
            Verdict::Holds => ("holds", None),
            Verdict::DoesNot { reason } => ("does_not_hold", Some(reason.clone())),
            Verdict::NotYet { with } => (
                "not_yet",
                Some(format!("not measured yet: requires {with}")),
            ),
        };
        Self {
            claim: finding.claim,
            chapter: claim.map(|claim| claim.chapter),
            at: claim.map(|claim| claim.at),
            says: claim.map(|claim| claim.says),
            quote: claim.and_then(|claim| claim.quote),
            criteria: &finding.criteria,
            holds_if: claim.map(|claim| claim.holds_if),
            measured: &finding.measured,
            verdict,
            reason,
        }
    }
}

/// The measurements of the thesis again, on the twin.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct ReplayDocument<'a> {
    /// The name of the report.
    pub report: &'a str,
    /// What everything was drawn with.
    pub seed: u64,
    /// The name of the file that changes the parameters of the twin; absent without one.
    pub twin: Option<String>,
    /// What it changes.
    pub changes: &'a [String],
    /// The chapters.
    pub chapters: Vec<ChapterDocument<'a>>,
    /// What was found of every claim.
    pub findings: Vec<FindingDocument<'a>>,
    /// How many panels meet each claim; absent where one panel alone was measured.
    pub panels: Option<&'a PanelCount>,
}

impl Content for ReplayDocument<'_> {
    const SCHEMA: &'static str = "replay";
}

impl<'a> ReplayDocument<'a> {
    /// What `chapters` found, and `panels` where several were counted, with the parameters of the file `twin`, the report `report`
    /// beside it, and warnings in `words`.
    #[must_use]
    pub fn of(
        laboratory: &'a Laboratory,
        chapters: &'a [Chapter],
        panels: Option<&'a PanelCount>,
        (report, twin): (&'a str, Option<String>),
        words: &dyn Words,
    ) -> Self {
        let findings = chapters.iter().flat_map(|chapter| &chapter.findings);
        Self {
            report,
            seed: laboratory.seed,
            twin,
            changes: laboratory.parameters.changes(),
            chapters: (chapters.iter())
                .map(|chapter| ChapterDocument {
                    number: chapter.number,
                    title: chapter.title,
                    measured: &chapter.measured,
                    warnings: (chapter.warnings.iter())
                        .map(|warning| words.merged(warning))
                        .collect(),
                    missing: &chapter.missing,
                })
                .collect(),
            findings: findings.map(FindingDocument::from).collect(),
            panels,
        }
    }
}
