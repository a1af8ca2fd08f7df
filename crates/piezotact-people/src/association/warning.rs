//! Warnings about association matrices.

use piezotact::number::counted;
use serde::{Deserialize, Serialize};

use super::answer::Flag;
use super::chance_agreement::Matching;
use super::guessing::Guessing;
use super::same_person::AnswersPart;

/// One thing to know before relying on a matrix.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum AssociationWarning {
    /// Trials have no answer, or "I do not know": shares are of the others.
    #[error(
        "{} {} no answer, or \"I do not know\": in no matrix, so that shares are of the others; state how many beside them",
        counted(*trials, "trial"),
        if *trials == 1 { "has" } else { "have" }
    )]
    NotKnown { trials: usize },
    /// Pairs (of samples, and of a manipulated texture and a sample) of which neither was presented while the other could be answered.
    #[error(
        "{pairs} of {of} pairs are untested: neither was presented while the other could be answered; this is not 0 %"
    )]
    #[serde(rename = "untested_pairs")]
    Untested { pairs: usize, of: usize },
    /// Two groups that are compared as different people have pseudonyms in common.
    #[error(
        "the two groups have {} in common, and are compared as different people: if they are the same, compare them with again:",
        counted(*people, "pseudonym")
    )]
    SamePseudonyms { people: usize },
    /// Answers of two people agree more than what was presented and their habits explain.
    #[error(
        "{one} and {other} may be one person, or the same answers twice: {alike} of {matched} answers {}, where at most {expected:.1} would agree by chance; \
            check who answered, and leave out what is there twice",
        match matching {
            Matching::Trial => "to the same trials are the same",
            Matching::Presentation => "to the same presentations are the same",
            Matching::Counts => "to the same stimuli are the same, whatever their order",
        }
    )]
    SameAnswers {
        one: AnswersPart,
        other: AnswersPart,
        matching: Matching,
        matched: usize,
        alike: usize,
        expected: f64,
    },
    /// One person gave most of the answers.
    #[error(
        "{participant} gave {answers} of {of} answers: the {people} participants weigh as {effective_people:.1} with equal numbers would; \
            give each the same number of trials"
    )]
    UnbalancedAnswers {
        participant: String,
        answers: usize,
        of: usize,
        people: usize,
        effective_people: f64,
    },
    /// Answers are not shown to be better than guesses, and pairs are called confused.
    #[error(
        "answers are not shown to be better than guesses: that {} confused can come of people who guess, or keep to one answer, and says nothing of \
            the samples",
        match pairs {
        1 => "1 pair is".to_owned(),
        pairs => format!("{pairs} pairs are"),
        }
    )]
    Guesses { pairs: usize },
    /// Some participants answer as guessing does, and the others far better.
    #[error(
        "{}: a mean over both groups describes neither; look at each alone, and ask whether the task was understood",
        guessing.words()
    )]
    SomeGuess { guessing: Guessing },
    /// Answers that something was wrong with are counted, or were left out; `of` has how many have each flag, in the order of [`Flag::ALL`].
    #[error(
        "{}{}: {}; compare the matrices with and without them",
        counted(*trials, "flagged answer"),
        each_flag(*of),
        if *kept { "kept in the matrices, and counted in each cell" } else { "left out of the matrices" }
    )]
    #[serde(rename = "flagged_trials")]
    Flagged {
        trials: usize,
        of: [usize; 4],
        kept: bool,
    },
    /// What could be presented or answered is not stated, and is assumed.
    #[error("{what}; {}", what.advice())]
    NotDeclared {
        #[serde(flatten)]
        what: NotDeclared,
    },
}

/// What is not stated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "what", rename_all = "snake_case")]
pub enum NotDeclared {
    /// What could be answered is not stated in the answers.
    #[error(
        "for {} it is not stated what could be answered: assumed are the samples of its task and set, or all samples without sets",
        counted(*answers, "answer")
    )]
    Offered { answers: usize },
    /// The samples were not declared: a sample that was neither presented nor answered is missing.
    #[error(
        "the list of samples was not given: a sample that was neither presented nor answered has no row and no column"
    )]
    Samples,
}

impl NotDeclared {
    /// What a person can do.
    fn advice(&self) -> &'static str {
        match self {
            Self::Offered { .. } => "state it in a column `offered`",
            Self::Samples => "state the list of samples",
        }
    }
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
