//! Doubts about association matrices.

use std::fmt;

use piezotact::Doubt;
use piezotact::doubt::{Advice, DoubtKind, FieldValue};

/// One thing to know before relying on a matrix.
#[derive(Clone, Debug, PartialEq)]
pub enum AssociationDoubt {
    /// Too few participants for intervals.
    FewParticipants {
        /// How many there are.
        participants: usize,
        /// How many an interval takes.
        needed: usize,
    },
    /// What could be answered is not stated in the answers.
    OfferedInferred {
        /// How many answers.
        answers: usize,
    },
    /// Trials that something was wrong with are among the answers.
    Flagged {
        /// How many.
        trials: usize,
    },
    /// Trials that something was wrong with were left out.
    FlaggedLeftOut {
        /// How many.
        trials: usize,
    },
    /// Rehearsals were left out.
    Rehearsals {
        /// How many.
        trials: usize,
    },
    /// Pairs (of samples, and of a manipulated texture and a sample) that were never offered together.
    Untested {
        /// How many.
        pairs: usize,
        /// How many pairs there are.
        of: usize,
    },
    /// The samples were not declared: a sample that was neither presented nor answered is missing.
    SamplesNotDeclared,
}

const FEW: &str = "few_participants";
const OFFERED: &str = "offered_inferred";
const FLAGGED: &str = "flagged_trials";
const LEFT_OUT: &str = "flagged_trials_left_out";
const REHEARSALS: &str = "rehearsals_left_out";
const UNTESTED: &str = "untested_pairs";
const NOT_DECLARED: &str = "samples_not_declared";

impl From<AssociationDoubt> for Doubt {
    fn from(kind: AssociationDoubt) -> Self {
        use AssociationDoubt as Kind;
        let (code, fields) = match kind {
            Kind::FewParticipants {
                participants,
                needed,
            } => (
                FEW,
                vec![("participants", participants), ("needed", needed)],
            ),
            Kind::OfferedInferred { answers } => (OFFERED, vec![("answers", answers)]),
            Kind::Flagged { trials } => (FLAGGED, vec![("trials", trials)]),
            Kind::FlaggedLeftOut { trials } => (LEFT_OUT, vec![("trials", trials)]),
            Kind::Rehearsals { trials } => (REHEARSALS, vec![("trials", trials)]),
            Kind::Untested { pairs, of } => (UNTESTED, vec![("pairs", pairs), ("of", of)]),
            Kind::SamplesNotDeclared => (NOT_DECLARED, vec![]),
        };
        let fields = fields.into_iter();
        Self::of_fields(
            code,
            fields.map(|(name, value)| (name, value.into_value())),
            None,
            Vec::new(),
        )
    }
}

impl DoubtKind for AssociationDoubt {
    fn of(doubt: &Doubt) -> Option<Self> {
        let field = |name: &str| doubt.field::<usize>(name, None);
        Some(match doubt.code.as_ref() {
            FEW => Self::FewParticipants {
                participants: field("participants")?,
                needed: field("needed")?,
            },
            OFFERED => Self::OfferedInferred {
                answers: field("answers")?,
            },
            FLAGGED => Self::Flagged {
                trials: field("trials")?,
            },
            LEFT_OUT => Self::FlaggedLeftOut {
                trials: field("trials")?,
            },
            REHEARSALS => Self::Rehearsals {
                trials: field("trials")?,
            },
            UNTESTED => Self::Untested {
                pairs: field("pairs")?,
                of: field("of")?,
            },
            NOT_DECLARED => Self::SamplesNotDeclared,
            _ => return None,
        })
    }

    fn advice(&self) -> Vec<Advice> {
        Vec::new()
    }
}

/// `count` and `noun`, in the plural where there are several.
fn of(count: usize, noun: &str) -> String {
    let s = if count == 1 { "" } else { "s" };
    format!("{count} {noun}{s}")
}

impl fmt::Display for AssociationDoubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::FewParticipants {
                participants,
                needed,
            } => write!(
                f,
                "{}: how much people differ is not known, so cells have no interval and no pair is decided; ask at least {needed}",
                of(*participants, "participant")
            ),
            Self::OfferedInferred { answers } => write!(
                f,
                "{} not stated what could be answered: assumed are the samples of its task and set, or all samples without sets; \
                    state it in a column `offered`",
                match answers {
                    1 => "for 1 answer it is".to_owned(),
                    several => format!("for {several} answers it is"),
                }
            ),
            Self::Flagged { trials } => write!(
                f,
                "{} in which the stimulus missed its target or was not measured, or the wrong sample was handed over: kept in the matrices, and \
                    counted in each cell",
                of(*trials, "answer")
            ),
            Self::FlaggedLeftOut { trials } => write!(
                f,
                "{} in which the stimulus missed its target or was not measured, or the wrong sample was handed over: left out",
                of(*trials, "answer")
            ),
            Self::Rehearsals { trials } => {
                write!(f, "{}: left out", of(*trials, "rehearsal"))
            }
            Self::Untested { pairs, of } => write!(
                f,
                "{pairs} of {of} pairs were never offered together: untested, which is not 0 %"
            ),
            Self::SamplesNotDeclared => f.write_str(
                "the list of samples was not given: a sample that was neither presented nor answered has no row and no column; \
                    state the list",
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_doubt_comes_back() {
        for kind in [
            AssociationDoubt::FewParticipants {
                participants: 2,
                needed: 3,
            },
            AssociationDoubt::OfferedInferred { answers: 1 },
            AssociationDoubt::Flagged { trials: 4 },
            AssociationDoubt::FlaggedLeftOut { trials: 4 },
            AssociationDoubt::Rehearsals { trials: 1 },
            AssociationDoubt::Untested { pairs: 47, of: 78 },
            AssociationDoubt::SamplesNotDeclared,
        ] {
            assert_eq!(Doubt::from(kind.clone()).kind(), Some(kind));
        }
    }
}
