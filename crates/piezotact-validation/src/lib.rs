//! The thesis' measurements again, on the twin and through the ordinary analysis: record, segment, analyse,
//! compare; characterise, render, play, verify. What comes out is held against what the thesis says.

mod averaged;
mod brain;
mod campaigns;
mod chapter3;
mod chapter4;
mod chapter5;
mod chapter6;
mod claims;
mod comb;
pub mod count;
pub mod document;
mod exchange;
mod figure;
mod measured;
mod rendering;

use chapter3::chapter3;
use chapter4::chapter4;
use chapter5::chapter5;
use chapter6::chapter6;
pub use claims::{CLAIMS, Claim, ClaimRule, Counting, Finding, Verdict};
pub use figure::Counterpart;

use piezotact_volunteers::Laboratory;
use serde::Serialize;

/// The chapters that can be measured again.
pub const CHAPTERS: [u8; 4] = [3, 4, 5, 6];

/// Chapter `number`, measured again in `laboratory`; `None` unless it is one of [`CHAPTERS`].
///
/// # Errors
/// [`ReplayError`] where the analysis refuses what the benches gave.
pub fn chapter(laboratory: &Laboratory, number: u8) -> Option<Result<Chapter, ReplayError>> {
    match number {
        3 => Some(chapter3(laboratory)),
        4 => Some(chapter4(laboratory)),
        5 => Some(chapter5(laboratory)),
        6 => Some(chapter6(laboratory)),
        _ => None,
    }
}

/// One chapter of the thesis, measured again.
#[derive(Clone, Debug, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Chapter {
    /// Its number in the thesis.
    pub number: u8,
    /// What it is about.
    pub title: &'static str,
    /// What was measured, in sentences.
    pub measured: Vec<String>,
    /// What was found of its claims, in their order.
    pub findings: Vec<Finding>,
    /// The counterparts of its figures.
    #[serde(skip)]
    pub figures: Vec<Counterpart>,
    /// What a person should know before relying on it, each once, with how often it was said.
    pub warnings: Vec<piezotact::warning::Merged>,
    /// What is not there yet: figures and the issue that brings them.
    pub missing: Vec<String>,
}

/// Warnings of many recordings, those of one kind once and with what they are about.
fn said_once<'a>(
    warnings: impl Iterator<Item = (&'a str, &'a piezotact::Warning)>,
) -> Vec<piezotact::warning::Merged> {
    piezotact::warning::merged_of(warnings.map(|(of, warning)| (Some(of), warning)))
}

/// Why a chapter could not be measured: what the bench, the twin or the analysis refused.
pub type ReplayError = Box<dyn std::error::Error + Send + Sync>;
