//! What a design can be refused for.

use std::ops::{Bound, RangeBounds};

use thiserror::Error;

/// Why a design cannot be checked, built or drawn: what was found, what was expected, and what to do.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum DesignError {
    /// There are too few samples.
    #[error("{found} samples, at least {expected} are needed: name the samples of the campaign")]
    TooFewSamples {
        /// How many there are.
        found: usize,
        /// How many are needed.
        expected: usize,
    },
    /// A sample is named twice in the list of samples.
    #[error("sample {sample} is named twice in the list of samples: name it once")]
    SampleTwice { sample: String },
    /// There is no set.
    #[error("no set of samples: give the sets that are presented together")]
    NoSets,
    /// A set has fewer than two samples.
    #[error("set {set} has {found} samples, at least 2 are needed: add samples or take it out")]
    SetTooSmall {
        /// The set, counted from 1.
        set: usize,
        /// How many samples it has.
        found: usize,
    },
    /// A set does not fit on the tray.
    #[error("set {set} has {found} samples and the tray holds {tray}: divide the set")]
    SetTooLarge {
        /// The set, counted from 1.
        set: usize,
        /// How many samples it has.
        found: usize,
        /// How many the tray holds.
        tray: usize,
    },
    /// A set or a sequence names a sample that is not expected there.
    #[error(
        "set {set} names {sample}, which is not among its samples: correct the name or add the sample"
    )]
    UnknownSample {
        /// The set, counted from 1.
        set: usize,
        sample: String,
    },
    /// A set holds a sample twice.
    #[error(
        "set {set} holds {sample} twice: a set holds each sample once, repeats belong to sequences"
    )]
    SampleTwiceInSet {
        /// The set, counted from 1.
        set: usize,
        sample: String,
    },
    /// No design of this kind is known to exist.
    #[error(
        "no balanced design of {points} samples in sets of {size} is known here: use a covering"
    )]
    NoBalancedDesign {
        /// The number of samples.
        points: usize,
        /// The size of a set.
        size: usize,
    },
    /// Sets of this size cannot be built of so many samples.
    #[error(
        "sets of {size} of {points} samples are not possible: use 2 to {points} samples a set and at most {most} samples"
    )]
    ImpossibleSize {
        /// The number of samples.
        points: usize,
        /// The size of a set.
        size: usize,
        /// The largest number of samples.
        most: usize,
    },
    /// Lengths of sequences that no sequence can have.
    #[error("sequences of {shortest} to {longest}: expected 1 ≤ shortest ≤ longest")]
    ImpossibleLengths { shortest: usize, longest: usize },
    /// Repeats that a sequence cannot have without exclusion.
    #[error(
        "{length} samples of a set of {set_size}, each at most {of_one} times: the last answers would follow by exclusion; allow more of each, or a shorter sequence"
    )]
    ImpossibleRepeats {
        /// The size of the set.
        set_size: usize,
        /// The length of the sequence.
        length: usize,
        /// The largest number of one sample.
        of_one: usize,
    },
    /// There are too many sequences to count them.
    #[error(
        "sequences of {length} of {set_size} samples are more than {most}, too many to enumerate: make them shorter"
    )]
    TooManySequences {
        /// The size of the set.
        set_size: usize,
        /// The length of the sequence.
        length: usize,
        /// The largest number that is enumerated.
        most: usize,
    },
    /// Fixed sequences are not given for every set.
    #[error(
        "fixed sequences for {found} sets, {expected} expected, each with one or more: give them for every set"
    )]
    FixedSequences {
        /// For how many sets they are given.
        found: usize,
        /// The number of sets.
        expected: usize,
    },
    /// Fixed sequences are not drawn.
    #[error("these sequences are given in the protocol, and nothing is drawn: read them there")]
    FixedNotDrawn,
    /// An order does not hold each treatment once.
    #[error("order {order} does not hold each of {expected} treatments once: correct it")]
    NotAnOrder {
        /// The order, counted from 1.
        order: usize,
        /// The number of treatments.
        expected: usize,
    },
    /// A number is out of its range.
    #[error("{what} is {found}, expected {expected}: correct it")]
    OutOfRange {
        what: &'static str,
        found: f64,
        expected: &'static str,
    },
    /// Two samples that no participant can take for each other.
    #[error("{} and {} never occur in one set, so no answer compares them: name another pair", .pair[0], .pair[1]
    )]
    NeverTogether { pair: Box<[String; 2]> },
    /// Too few tasks to compare.
    #[error("tasks cannot be compared: {} has answers that name a sample; compare samples or people", match .known[..] { [] => "no task".to_owned(), _ => format!("{} alone", .known.join(", ")) }
    )]
    TooFewToCompare {
        /// Those that there are.
        known: Vec<String>,
    },
    /// Several tasks can be meant.
    #[error("state the task whose answers count, one of {known}")]
    WhichTask { known: String },
    /// A task or sample that cannot be compared.
    #[error(
        "expected a {what} of which answers name a sample, one of {known}, found `{name}`; name it"
    )]
    NotToCompare {
        /// "task", "other task" or "sample, each once,".
        what: &'static str,
        name: String,
        known: String,
    },
    /// There is too much to count in a time that somebody waits.
    #[error("{what}: expected at most {most}, found {found}; make the design smaller")]
    TooLarge {
        what: &'static str,
        /// How much there is.
        found: usize,
        most: usize,
    },
    /// A name of a task is not that of a task, or of several.
    #[error(
        "the design names task {task}, but not exactly one task of that name is described: correct its name"
    )]
    UnknownTask { task: String },
}

/// Refuses a number out of its range; one that is none is in no range.
pub(super) fn must(
    what: &'static str,
    found: f64,
    within: impl RangeBounds<f64>,
    expected: &'static str,
) -> Result<(), DesignError> {
    match within.contains(&found) {
        true => Ok(()),
        false => Err(DesignError::OutOfRange {
            what,
            found,
            expected,
        }),
    }
}

/// Above 0 and below `end`.
pub(super) fn above_0_below(end: f64) -> (Bound<f64>, Bound<f64>) {
    (Bound::Excluded(0.0), Bound::Excluded(end))
}
