//! Warnings about a run.

use super::Ended;
use crate::number::rounded;
use serde::{Deserialize, Serialize};

/// Warnings about a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum RunWarning {
    /// The run ended before its planned end.
    #[error("the run ended early, after {after_s:.2} s: {ended}")]
    EndedEarly { ended: Ended, after_s: f64 },
    /// No channel says whether the load was held.
    #[error(
        "no force was measured: it is not known whether {load_n} N was held; measure the force together with the acceleration",
        load_n = rounded(*load_n)
    )]
    ForceNotMeasured { load_n: f64 },
}
