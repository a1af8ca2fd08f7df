//! Association matrices: what was presented, and what it was declared to be (thesis 2.6.3).
//!
//! [`AnswerTable`] holds checked answers, [`associate`] makes of it an [`Association`]: matrices with an interval for every cell,
//! pairs that are confused, and, for tasks in which samples are put in order, places, dominance and Kendall's τ.

mod answer;
mod asked;
mod behaviour;
mod chance_agreement;
mod compared;
mod conclusions;
mod confused;
mod document;
mod error;
mod expected;
mod felt;
mod guessing;
mod level;
mod matrix;
mod of_session;
mod order;
mod page;
mod same_person;
mod session_page;
mod tables;
mod warning;

pub use answer::{Answer, AnswerTable, Declared, Flag, Purpose, Stimulus};
pub use asked::{Asked, AskedTask};
pub use behaviour::{
    BETWEEN, Behaviour, BehaviourMeanings, ReadBehaviour, StimulusFiles, behaviour,
    behaviour_meanings, evidence_of_behaviour, holds_orders, is_recorded, playing_events,
    read_behaviour, trials_of_behaviour,
};
pub use chance_agreement::Matching;
pub use compared::{Compared, compared, compared_studies};
pub use confused::{CONFUSED_SHARE, ConfusedPair, PairCriterion, PairOutcome, confused_pairs};
pub use document::{Association, AssociationConfig, GroupMatrix, Grouping, associate};
pub use error::AssociationError;
pub use expected::{Counted, ExpectedCriterion, ExpectedShare, Recount, StimulusKind};
pub use felt::{
    Felt, FeltComparison, FeltCriterion, FeltPair, FeltRecording, FeltSpectrum, FeltUnknown,
    FeltWarning, Separates, felt_otherwise, felt_pairs, felt_part, felt_samples,
};
pub use guessing::Guessing;
pub use matrix::{
    AssociationMatrix, Cell, FlaggedTrials, MatrixConfig, Row, Selection, association_matrix,
};
pub use of_session::{REPETITION, answers_of, declared, not_known};
pub use order::{Dominance, Ordering, Repetition, kendall_tau_b, ordering};
pub use same_person::{AnswersPart, SameBy, SamePerson, Unbalanced};
pub use session_page::session_page;
pub use tables::{
    DONE, THRESHOLD_COLUMNS, answers_table, evidence_table, participants_table, thresholds_table,
    trials_table,
};
pub use warning::{AssociationWarning, NotDeclared};
