//! What noise leaves open, in fields and in words.

use std::fmt;

use crate::doubt::{Advice, DoubtKind, doubts};

doubts! {
    /// What noise leaves open.
    pub enum NoiseDoubt {
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

impl DoubtKind for NoiseDoubt {
    fn of(doubt: &crate::Doubt) -> Option<Self> {
        Self::of_doubt(doubt)
    }

    fn advice(&self) -> Vec<Advice> {
        vec![Advice::RecordAgain]
    }
}

impl fmt::Display for NoiseDoubt {
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
