//! What comparisons leave open.

use std::fmt;

use crate::doubt::words::percent;
use crate::doubt::{Advice, DoubtKind, Subject, doubts};

doubts! {
    /// What summaries of groups and comparisons between them leave open.
    pub enum CompareDoubt {
        /// Recordings that have nothing to be compared with.
        NotCompared("not_compared") {
            /// Their names.
            recordings: String,
        },
        /// Strokes that differ far more than strokes of one texture do.
        Scattered("scattered") of Group(group) {
            /// The group.
            group: String,
            /// The standard deviation of the rms as a share of its mean.
            share: f64,
        },
        /// Few strokes: their average scatters.
        FewStrokes("few_strokes") of Group(what) {
            /// What was recorded.
            what: String,
            /// Strokes kept.
            kept: usize,
            /// The number recommended.
            recommended: usize,
        },
        /// A group holds recordings that differ in more than chance.
        Pooled("pooled") of Group(group) {
            /// The group.
            group: String,
            /// In what they differ.
            what: String,
        },
        /// No spatial period stands out at all speeds.
        NoCommonPeriod("no_common_period") {
            /// How far the strongest candidate stands above the background, dB.
            prominence_db: f64,
        },
        /// A value from so few groups that it has no interval.
        NoInterval("no_interval") of Result(what) {
            /// What.
            what: String,
            /// Groups that it comes from.
            groups: usize,
        },
    }
}

impl DoubtKind for CompareDoubt {
    fn of(doubt: &crate::Doubt) -> Option<Self> {
        Self::of_doubt(doubt)
    }

    fn advice(&self) -> Vec<Advice> {
        match self {
            Self::NotCompared { .. } => vec![Advice::CompareLike],
            Self::Scattered { .. } => vec![Advice::Check(Subject::LooseSensor)],
            Self::FewStrokes { recommended, .. } => vec![Advice::RecordMore {
                count: *recommended,
            }],
            Self::Pooled { what, .. } => vec![Advice::GroupBy { by: what.clone() }],
            Self::NoCommonPeriod { .. } => vec![Advice::Check(Subject::Speeds)],
            Self::NoInterval { .. } => vec![Advice::RecordMore { count: 3 }],
        }
    }
}

impl fmt::Display for CompareDoubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotCompared { recordings } => write!(
                f,
                "nothing to compare with: {recordings} differ from the others in more than what is compared"
            ),
            Self::Scattered { group, share } => write!(
                f,
                "{group}: the rms of the strokes scatters by {} of its mean, far more than strokes of one texture do",
                percent(*share)
            ),
            Self::FewStrokes { what, kept, .. } => {
                write!(f, "{what}: strokes kept: {kept}, averages scatter")
            }
            Self::Pooled { group, what } => write!(
                f,
                "{group}: recordings of different {what} are averaged together"
            ),
            Self::NoCommonPeriod { prominence_db } => write!(
                f,
                "no spatial period stands out at every speed (the strongest candidate by {prominence_db:.1} dB): the surface may have none, or the speeds stated are not those that were reached"
            ),
            Self::NoInterval { what, groups } => {
                write!(f, "{what} comes from {groups} group(s) and has no interval")
            }
        }
    }
}
