//! Warnings about a change of rate.

use std::fmt;

use crate::warning::{Advice, WarningKind, warnings};

warnings! {
    /// Warnings about a change of rate.
    pub enum ResampleWarning {
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

impl WarningKind for ResampleWarning {
    fn of(warning: &crate::Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        let Self::RateConverted { from_hz, to_hz, .. } = self;
        vec![Advice::KeepBandBelow {
            to_hz: 0.45 * from_hz.min(*to_hz),
        }]
    }
}

impl fmt::Display for ResampleWarning {
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
