//! Warnings about a spectrum.

use std::fmt;

use crate::warning::{Advice, WarningKind, warnings};

warnings! {
    /// Warnings about a spectrum.
    pub enum SpectrumWarning {
        /// A signal with few segments: too short for a stable spectrum.
        ShortSignal("short_signal") {
            /// Segments in the average.
            segments: usize,
        },
        /// The signal uses so few steps of the converter that quantisation shows.
        CoarseQuantisation("coarse_quantisation") of Channel(channel) {
            /// The channel.
            channel: String,
            /// The rms level in quantisation steps.
            rms_in_steps: f64,
        },
    }
}

impl WarningKind for SpectrumWarning {
    fn of(warning: &crate::Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        match self {
            Self::ShortSignal { .. } => vec![Advice::RecordLonger],
            Self::CoarseQuantisation { .. } => vec![Advice::RaiseGain],
        }
    }
}

impl fmt::Display for SpectrumWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ShortSignal { segments } => write!(
                f,
                "the spectrum is the mean of {segments} segment(s): its standard deviation is about {:.1} dB",
                4.34 * (1.0 / (*segments).max(1) as f64).sqrt()
            ),
            Self::CoarseQuantisation {
                channel,
                rms_in_steps,
            } => write!(
                f,
                "{channel} is only {rms_in_steps:.1} converter steps rms; quantisation noise is only {:.0} dB below it",
                20.0 * (rms_in_steps * 12f64.sqrt()).max(1.0).log10()
            ),
        }
    }
}
