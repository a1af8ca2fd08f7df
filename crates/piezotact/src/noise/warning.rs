//! What noise leaves open, in fields and in words.

use std::fmt;

use crate::warning::{Advice, WarningKind, warnings};

warnings! {
    /// What noise leaves open.
    pub enum NoiseWarning {
        /// Something moved.
        NotAtRest("not_at_rest") of Channel(channel) {
            /// The channel.
            channel: String,
        },
        /// Something may have moved.
        PerhapsNotAtRest("perhaps_not_at_rest") of Channel(channel) {
            /// The channel.
            channel: String,
        },
    }
}

impl WarningKind for NoiseWarning {
    fn of(warning: &crate::Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        vec![Advice::RecordAgain]
    }
}

impl fmt::Display for NoiseWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotAtRest { channel } => write!(
                f,
                "`{channel}` was not at rest: knocks, strokes or changes of level are in the recording, and its numbers are not those of the sensor's noise"
            ),
            Self::PerhapsNotAtRest { channel } => write!(
                f,
                "the recording does not show whether `{channel}` was at rest"
            ),
        }
    }
}
