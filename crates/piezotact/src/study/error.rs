//! Why a study cannot be analysed.

use super::COARSEST_HZ;
use super::Factor;
use super::take::FASTEST_M_S;
use crate::compare::CompareError;
use crate::feature::FeatureError;
use crate::number::rounded;
use crate::quantity::{Newtons, QuantityError, Seconds};
use crate::recording::RecordingError;
use crate::stroke::SegmentError;
use crate::warning::{Merged, Warning};

/// Why a study cannot be cut or analysed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum StudyError {
    /// More than two channels of tangential force.
    #[error(
        "expected one or two channels of tangential force, found {found}; add the forces along one axis first"
    )]
    TangentialForces { found: usize },
    /// A load that cannot be.
    #[error("expected a load above 0 N, found {}; give it in N", found.0)]
    Load { found: Newtons },
    /// A sliding speed that no finger has.
    #[error(
        "expected a sliding speed above 0 and up to {FASTEST_M_S} m/s, found {} m/s; correct its unit",
        rounded(*found_m_s)
    )]
    Speed { found_m_s: f64 },
    /// Segments so short that a comparison of what is felt says nothing.
    #[error(
        "expected segments of {needed} samples or more, whose lines are up to {COARSEST_HZ} Hz apart, to compare what is felt, found {found}; state more"
    )]
    Coarse { needed: usize, found: usize },
    /// A recording whose channels are not what they must be.
    #[error("{file}: {error}")]
    Recording {
        file: String,
        #[source]
        error: RecordingError,
    },
    /// A recording that cannot be cut into strokes.
    #[error("{file}: {error}")]
    Segment {
        file: String,
        #[source]
        error: SegmentError,
    },
    /// A recording that is larger than memory and has no moment in which it could be divided.
    #[error(
        "{file}: expected pauses without contact, or a force or speed that shows them, as it is larger than memory and is cut there, found none in \
         {:.0} s from {:.0} s on; cut it into files",
        lasts.0, from.0
    )]
    Undivided {
        file: String,
        from: Seconds,
        lasts: Seconds,
    },
    /// A recording of whose strokes no features can be computed.
    #[error("{file}: {error}")]
    Feature {
        file: String,
        #[source]
        error: FeatureError,
    },
    /// No recording has a stroke.
    #[error("{}", found.sentence_with(&Warning::to_string))]
    NoStrokes {
        /// What was found instead.
        found: Box<NoStrokes>,
    },
    /// Two recordings hold the same stroke, or one that was scaled or shifted: a copy is no second recording.
    #[error(
        "expected recordings that differ, found the same signal in {one} and {other}; give each recording once: a copy would count as a repeat, also a scaled or shifted one"
    )]
    Copy { one: String, other: String },
    /// A recording does not say what recordings are grouped by.
    #[error("expected {} for every recording, found none for {recording}", by.noun())]
    Unknown { by: Factor, recording: String },
    /// A recording does not have the label that recordings are compared by.
    #[error("expected the label `{name}` for every recording, found none for {recording}")]
    Label {
        name: String,
        recording: String,
        /// The labels that some recording has.
        known: Vec<String>,
    },
    /// One recording cannot be compared.
    #[error(
        "expected two or more recordings that differ in {by}, found only {recording}; give the others too"
    )]
    OneRecording { by: Factor, recording: String },
    /// There are no recordings that differ in what is compared and agree in all else.
    #[error(
        "expected recordings that differ in {by} and agree in all else, found none{}{}; give more recordings, or state more of their conditions",
        if differ_in.is_empty() { String::new() } else { format!(" (they differ in {})", listed(differ_in)) },
        without_strokes(rejected)
    )]
    NothingToCompare {
        by: Factor,
        /// What else they differ in.
        differ_in: Vec<Factor>,
        /// The recordings without strokes, each with the warnings about its strokes, where that is known.
        rejected: Vec<(String, Option<Warning>)>,
    },
    /// Groups that cannot be averaged or compared.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// A band that cannot be.
    #[error(transparent)]
    Quantity(#[from] QuantityError),
}

/// A study in which no recording has a stroke.
#[derive(Clone, Debug, PartialEq)]
pub struct NoStrokes {
    pub recordings: Vec<String>,
    /// Why, where that is known.
    pub because: Option<Warning>,
    /// All warnings about the recordings.
    pub warnings: Vec<Merged>,
}

impl NoStrokes {
    /// What is missing and why, with `words` for a warning.
    #[must_use]
    pub fn sentence_with(&self, words: &dyn Fn(&Warning) -> String) -> String {
        let recordings = match self.recordings.as_slice() {
            [only] => only.clone(),
            all => format!("all {} recordings", all.len()),
        };
        let because = self.because.as_ref();
        let because = because.map_or(String::new(), |warning| format!(": {}", words(warning)));
        format!("expected strokes, found none in {recordings}{because}")
    }
}

/// How many recordings have no strokes, and why the first of them has none.
fn without_strokes(rejected: &[(String, Option<Warning>)]) -> String {
    let Some((first, because)) = rejected.first() else {
        return String::new();
    };
    let because = because.as_ref();
    let because = because.map_or(String::new(), |warning| format!(": {warning}"));
    let all = crate::number::counted(rejected.len(), "recording");
    format!(", and {all} without strokes are not compared (such as {first}{because})")
}

fn listed(parts: &[Factor]) -> String {
    let parts: Vec<&str> = parts.iter().map(|by| by.word()).collect();
    parts.join(" and ")
}
