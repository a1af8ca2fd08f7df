//! Errors of answers and associations.

/// Why answers give no table, matrix, order or comparison.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum AssociationError {
    /// No answer is of the task, participant and set that were asked for.
    #[error("there are no answers of {wanted}, only of tasks {tasks}, sets {sets}")]
    NothingSelected {
        /// What was asked for.
        wanted: String,
        /// The tasks that have answers.
        tasks: String,
        /// The sets that have answers.
        sets: String,
    },
    /// All answers are of flagged trials.
    #[error("all {flagged} answers belong to flagged trials: keep flagged trials")]
    OnlyFlagged { flagged: usize },
    /// There is no answer that counts.
    #[error("no answers ({found}): the table needs at least one trial that is not a rehearsal")]
    Empty {
        /// "none" or "rehearsals only".
        found: &'static str,
    },
    /// Too few samples are declared.
    #[error(
        "at least two samples must be declared, found {found}: declare the samples that could be answered"
    )]
    TooFewSamples { found: usize },
    /// A name is declared twice.
    #[error("`{name}` is declared twice: declare each sample and stimulus once")]
    DeclaredTwice { name: String },
    /// A name that is not declared.
    #[error(
        "{place}: expected one of the declared {kind} ({known}), found `{name}`; correct the name or declare it"
    )]
    Unknown {
        /// Which answer or stimulus.
        place: String,
        /// "samples" or "stimuli".
        kind: &'static str,
        known: String,
        name: String,
    },
    /// An answer that was not offered.
    #[error(
        "{place}: expected an answer among the samples offered ({offered}), found `{answered}`; correct the answer or the samples offered"
    )]
    OutsideSet {
        place: String,
        /// The samples that were offered.
        offered: String,
        answered: String,
    },
    /// Comparisons with a reference, which no matrix can hold.
    #[error(
        "this is a table of forced choices: expected the name of a sample as the answer to each presentation, found only {choices} in {answers} answers to \
            {stimuli}, and none of them is presented or expected. Comparisons with a reference have no association matrix: what is missing is the reference, and \
            the value of each stimulus with its unit, from which a threshold would be estimated. Give a table in which samples are named; where these \
            are names of samples, state in a column `expected` which one is right for each stimulus"
    )]
    ForcedChoices {
        answers: usize,
        /// What was answered.
        choices: String,
        /// What was presented.
        stimuli: String,
    },
    /// A trial has two answers.
    #[error(
        "{place}: expected one answer for each trial, found two (`{first}` and `{second}`); number the trials, or keep the confirmed answer only"
    )]
    TrialTwice {
        place: String,
        first: String,
        second: String,
    },
    /// A cell that is no number.
    #[error(
        "row {row}: expected a number in the column `{column}`, found `{found}`; correct the cell"
    )]
    Number {
        /// The row, from 1.
        row: usize,
        column: String,
        found: String,
    },
    /// A cell without a name.
    #[error("row {row}: the column `{column}` has no name: complete the cell")]
    Missing {
        /// The row, from 1.
        row: usize,
        column: String,
    },
    /// A flag that is not known.
    #[error("row {row}: expected flags of {known}, found `{found}`; correct the cell")]
    Flag {
        /// The row, from 1.
        row: usize,
        /// Those that are known.
        known: String,
        found: String,
    },
    /// A name that is none.
    #[error(
        "cannot compare `{name}`: name two different ones of the {what} whose answers name a sample ({known})"
    )]
    NotToCompare {
        /// "samples" or "tasks".
        what: &'static str,
        name: String,
        /// Those that there are.
        known: String,
    },
    /// Nobody has answers of both.
    #[error("no participant gave answers of {of} that can be right or wrong{both}; {advice}")]
    Nobody {
        of: String,
        /// " with both", or nothing.
        both: &'static str,
        advice: &'static str,
    },
    /// The task has no answers.
    #[error("task {task} has no answers that order samples: name one of the tasks ({known})")]
    NoOrders {
        task: String,
        /// The tasks that have answers.
        known: String,
    },
    /// Orders of one task, from the answers of another.
    #[error(
        "only answers of task {selected} count, so task {task} cannot be ordered: order task {selected}, or take the answers of all tasks"
    )]
    OtherTask {
        /// The task that was to be ordered.
        task: String,
        /// The task whose answers count.
        selected: String,
    },
    /// All orders have flagged trials.
    #[error(
        "task {task}: every one of the {orders} orders has a flagged trial, so none is left; include flagged trials"
    )]
    OrdersOnlyFlagged { task: String, orders: usize },
    /// The answers of a repetition do not put its samples in an order.
    #[error(
        "task {task}, participant {participant}, set `{set}`: {name} was {found}, but an order needs each sample once; give each repetition its own session or set"
    )]
    NoOrder {
        task: String,
        participant: String,
        set: String,
        name: String,
        /// "presented twice", "answered, but not presented", …
        found: &'static str,
    },
}
