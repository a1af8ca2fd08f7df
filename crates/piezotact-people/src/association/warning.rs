//! Warnings about association matrices.

use std::fmt;

use piezotact::Warning;
use piezotact::warning::{Advice, FieldValue, WarningKind};

use super::answer::Flag;

/// One thing to know before relying on a matrix.
#[derive(Clone, Debug, PartialEq)]
pub enum AssociationWarning {
    /// Too few participants for intervals.
    FewParticipants {
        /// How many there are.
        participants: usize,
        /// How many an interval takes.
        needed: usize,
    },
    /// What could be answered is not stated in the answers.
    OfferedInferred { answers: usize },
    /// Answers that something was wrong with are counted.
    Flagged {
        trials: usize,
        /// How many have each flag, in the order of [`Flag::ALL`].
        of: [usize; 4],
    },
    /// Answers that something was wrong with were left out.
    FlaggedLeftOut {
        trials: usize,
        /// How many have each flag, in the order of [`Flag::ALL`].
        of: [usize; 4],
    },
    /// Rehearsals were left out.
    Rehearsals { trials: usize },
    /// Trials were answered with "I do not know": shares are of the others.
    NotKnown { trials: usize },
    /// Pairs (of samples, and of a manipulated texture and a sample) of which neither was presented while the other could be
    /// answered.
    Untested {
        pairs: usize,
        /// How many pairs there are.
        of: usize,
    },
    /// The samples were not declared: a sample that was neither presented nor answered is missing.
    SamplesNotDeclared,
    /// Two groups that are compared as different people have pseudonyms in common.
    SamePseudonyms { people: usize },
    /// Answers are not shown to be better than guesses, and pairs are called confused.
    Guesses { pairs: usize },
}

const FEW: &str = "few_participants";
const OFFERED: &str = "offered_inferred";
const FLAGGED: &str = "flagged_trials";
const LEFT_OUT: &str = "flagged_trials_left_out";
const REHEARSALS: &str = "rehearsals_left_out";
const NOT_KNOWN: &str = "not_known";
const UNTESTED: &str = "untested_pairs";
const NOT_DECLARED: &str = "samples_not_declared";
const GUESSES: &str = "guesses";
const SAME_PSEUDONYMS: &str = "same_pseudonyms";

impl From<AssociationWarning> for Warning {
    fn from(kind: AssociationWarning) -> Self {
        use AssociationWarning as Kind;
        let (code, fields) = match kind {
            Kind::FewParticipants {
                participants,
                needed,
            } => (
                FEW,
                vec![("participants", participants), ("needed", needed)],
            ),
            Kind::OfferedInferred { answers } => (OFFERED, vec![("answers", answers)]),
            Kind::Flagged { trials, of } => (FLAGGED, flagged(trials, of)),
            Kind::FlaggedLeftOut { trials, of } => (LEFT_OUT, flagged(trials, of)),
            Kind::Rehearsals { trials } => (REHEARSALS, vec![("trials", trials)]),
            Kind::NotKnown { trials } => (NOT_KNOWN, vec![("trials", trials)]),
            Kind::Untested { pairs, of } => (UNTESTED, vec![("pairs", pairs), ("of", of)]),
            Kind::SamplesNotDeclared => (NOT_DECLARED, vec![]),
            Kind::Guesses { pairs } => (GUESSES, vec![("pairs", pairs)]),
            Kind::SamePseudonyms { people } => (SAME_PSEUDONYMS, vec![("people", people)]),
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

/// The fields of flagged answers: all, and those with each flag.
fn flagged(trials: usize, of: [usize; 4]) -> Vec<(&'static str, usize)> {
    let each = Flag::ALL
        .iter()
        .zip(of)
        .map(|(flag, count)| (flag.word(), count));
    std::iter::once(("trials", trials)).chain(each).collect()
}

impl WarningKind for AssociationWarning {
    fn of(warning: &Warning) -> Option<Self> {
        let field = |name: &str| warning.field::<usize>(name, None);
        let each = || {
            let mut of = [0; Flag::ALL.len()];
            for (count, flag) in of.iter_mut().zip(Flag::ALL) {
                *count = field(flag.word())?;
            }
            Some(of)
        };
        Some(match warning.code.as_ref() {
            FEW => Self::FewParticipants {
                participants: field("participants")?,
                needed: field("needed")?,
            },
            OFFERED => Self::OfferedInferred {
                answers: field("answers")?,
            },
            FLAGGED => Self::Flagged {
                trials: field("trials")?,
                of: each()?,
            },
            LEFT_OUT => Self::FlaggedLeftOut {
                trials: field("trials")?,
                of: each()?,
            },
            REHEARSALS => Self::Rehearsals {
                trials: field("trials")?,
            },
            NOT_KNOWN => Self::NotKnown {
                trials: field("trials")?,
            },
            UNTESTED => Self::Untested {
                pairs: field("pairs")?,
                of: field("of")?,
            },
            NOT_DECLARED => Self::SamplesNotDeclared,
            SAME_PSEUDONYMS => Self::SamePseudonyms {
                people: field("people")?,
            },
            GUESSES => Self::Guesses {
                pairs: field("pairs")?,
            },
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

/// How many answers have each flag, in words.
fn each_flag(of: [usize; 4]) -> String {
    let each = Flag::ALL.iter().zip(of).filter(|(_, count)| *count > 0);
    let said: Vec<String> = each
        .map(|(flag, count)| {
            let what = match flag {
                Flag::MissedTarget => "the stimulus missed its target",
                Flag::NotMeasured => "what was played was not measured",
                Flag::WrongSample => "the wrong sample was handed over",
                Flag::Simulated => "it was played on a simulated bench",
            };
            format!("in {count} {what}")
        })
        .collect();
    match said.is_empty() {
        true => String::new(),
        false => format!(" ({})", said.join(", ")),
    }
}

impl fmt::Display for AssociationWarning {
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
            Self::Flagged { trials, of: flags } => write!(
                f,
                "{}{}: kept in the matrices, and counted in each cell",
                of(*trials, "flagged answer"),
                each_flag(*flags)
            ),
            Self::FlaggedLeftOut { trials, of: flags } => write!(
                f,
                "{}{}: left out",
                of(*trials, "flagged answer"),
                each_flag(*flags)
            ),
            Self::Rehearsals { trials } => {
                write!(f, "{}: left out", of(*trials, "rehearsal"))
            }
            Self::NotKnown { trials } => write!(
                f,
                "{} answered with \"I do not know\": in no matrix, so that shares are of the others; state how many beside them",
                match trials {
                    1 => "1 trial of the study was".to_owned(),
                    several => format!("{several} trials of the study were"),
                }
            ),
            Self::Untested { pairs, of } => write!(
                f,
                "{pairs} of {of} pairs are untested: neither was presented while the other could be answered; this is not 0 %"
            ),
            Self::SamplesNotDeclared => f.write_str(
                "the list of samples was not given: a sample that was neither presented nor answered has no row and no column; \
                    state the list",
            ),
            Self::SamePseudonyms { people } => write!(
                f,
                "the two groups have {} in common, and are compared as different people: if they are the same, compare them as the same",
                of(*people, "pseudonym")
            ),
            Self::Guesses { pairs } => write!(
                f,
                "answers are not shown to be better than guesses: that {} confused can come of people who guess, or keep to one \
                 answer, and says nothing of the samples",
                match pairs {
                    1 => "1 pair is".to_owned(),
                    pairs => format!("{pairs} pairs are"),
                }
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_warning_comes_back() {
        for kind in [
            AssociationWarning::FewParticipants {
                participants: 2,
                needed: 3,
            },
            AssociationWarning::OfferedInferred { answers: 1 },
            AssociationWarning::Flagged {
                trials: 4,
                of: [1, 0, 3, 2],
            },
            AssociationWarning::FlaggedLeftOut {
                trials: 4,
                of: [4, 0, 0, 0],
            },
            AssociationWarning::Rehearsals { trials: 1 },
            AssociationWarning::NotKnown { trials: 3 },
            AssociationWarning::Untested { pairs: 47, of: 78 },
            AssociationWarning::SamplesNotDeclared,
            AssociationWarning::Guesses { pairs: 2 },
            AssociationWarning::SamePseudonyms { people: 10 },
        ] {
            assert_eq!(Warning::from(kind.clone()).kind(), Some(kind));
        }
    }
}
