//! Doubts about a session.

use std::fmt;

use piezotact::Doubt;
use piezotact::doubt::{Advice, DoubtKind, FieldValue};

/// One thing to know before relying on the answers of a session.
#[derive(Clone, Debug, PartialEq)]
pub enum CampaignDoubt {
    /// More catch trials were answered wrongly than the protocol allows.
    CatchTrialsFailed {
        /// The task.
        task: String,
        /// How many were wrong.
        failed: usize,
        /// How many were answered.
        answered: usize,
        /// How many may be wrong.
        allowed: usize,
    },
}

const CATCH: &str = "catch_trials_failed";

impl From<CampaignDoubt> for Doubt {
    fn from(kind: CampaignDoubt) -> Self {
        let CampaignDoubt::CatchTrialsFailed {
            task,
            failed,
            answered,
            allowed,
        } = kind;
        let fields = [
            ("task", task.into_value()),
            ("failed", failed.into_value()),
            ("answered", answered.into_value()),
            ("allowed", allowed.into_value()),
        ];
        Self::of_fields(CATCH, fields, None, Vec::new())
    }
}

impl DoubtKind for CampaignDoubt {
    fn of(doubt: &Doubt) -> Option<Self> {
        let field = |name: &str| doubt.field::<usize>(name, None);
        match doubt.code.as_ref() {
            CATCH => Some(Self::CatchTrialsFailed {
                task: doubt.field("task", None)?,
                failed: field("failed")?,
                answered: field("answered")?,
                allowed: field("allowed")?,
            }),
            _ => None,
        }
    }

    fn advice(&self) -> Vec<Advice> {
        Vec::new()
    }
}

impl fmt::Display for CampaignDoubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::CatchTrialsFailed {
            task,
            failed,
            answered,
            allowed,
        } = self;
        write!(
            f,
            "{task}: {failed} of {answered} catch trials, whose answer is known and easy, were answered wrongly, and the protocol allows \
                {allowed}: the participant may not have done the task; look at the other answers before they are used"
        )
    }
}
