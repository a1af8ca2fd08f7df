//! Doubts about a change of rate.

use std::fmt;

use crate::doubt::{Advice, DoubtKind, doubts};

doubts! {
    /// Doubts about a change of rate.
    pub enum ResampleDoubt {
        /// A signal was brought to another rate.
        RateConverted("rate_converted") of Signal(what) {
            /// What was converted.
            what: String,
            /// Its own rate in Hz.
            from_hz: f64,
            /// The rate it was brought to, in Hz.
            to_hz: f64,
        },
    }
}

impl DoubtKind for ResampleDoubt {
    fn of(doubt: &crate::Doubt) -> Option<Self> {
        Self::of_doubt(doubt)
    }

    fn advice(&self) -> Vec<Advice> {
        let Self::RateConverted { from_hz, to_hz, .. } = self;
        vec![Advice::KeepBandBelow {
            to_hz: 0.45 * from_hz.min(*to_hz),
        }]
    }
}

impl fmt::Display for ResampleDoubt {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self::RateConverted {
            what,
            from_hz,
            to_hz,
        } = self;
        write!(
            f,
            "{what} is sampled at {from_hz} Hz and was resampled to {to_hz} Hz: frequencies above 0.45 of the lower rate are \
                attenuated"
        )
    }
}
