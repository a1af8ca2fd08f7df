//! Why textures are not scored.

use super::*;
use crate::perception::PerceptionError;

/// Why two vibrations cannot be compared.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ScoreError {
    /// The rates differ.
    #[error(
        "cannot score: the reference is sampled at {reference_hz} Hz, the test at {test_hz} Hz; resample both to one rate"
    )]
    Rate { reference_hz: f64, test_hz: f64 },
    /// The band reaches beyond the signals.
    #[error("cannot score over {band}: the signals end at {highest}; lower the band's end")]
    BandAboveNyquist {
        /// The band asked for.
        band: Band,
        /// Where the signals end.
        highest: Hertz,
    },
    /// Shorter than any effect; or than a segment of the spectra, where it is no effect with silence around it.
    #[error(
        "expected {what} to last {} or longer, found {found:.3}; record longer, or loop it",
        match needed.0 < 0.1 {
            true => format!("{needed:.3}"),
            false => format!("{needed:.2}"),
        }
    )]
    TooShort {
        /// Which of the two.
        what: &'static str,
        needed: Seconds,
        /// How long it is.
        found: Seconds,
    },
    /// The band holds no third octave.
    #[error("cannot score over {band}: third octaves begin at 0.9 Hz; raise the band's end")]
    NoBand {
        /// The band asked for.
        band: Band,
    },
    /// A just-noticeable difference that is none.
    #[error(
        "expected a just-noticeable difference {what} above 0 and up to {most}, found {}; 1.58 dB and 0.2 are usual",
        rounded(*found)
    )]
    Jnd {
        what: &'static str,
        found: f64,
        /// The largest that is accepted.
        most: f64,
    },
    /// Nothing there.
    #[error("{what} has no signal in {band}: check the channel and the band")]
    Silent {
        /// Which of the two.
        what: &'static str,
        band: Band,
    },
    /// The perceived difference cannot be computed.
    #[error("{0}; or compare the spectra alone")]
    Perception(#[from] PerceptionError),
    /// The spectra cannot be estimated.
    #[error("cannot score: {0}")]
    Estimate(#[from] EstimateError),
    /// The lines of the spectra cannot be compared.
    #[error(transparent)]
    Lines(#[from] VerifyError),
    /// There is not one block.
    #[error(
        "expected {expected} samples at 8 kHz that both signals have, found {found}; record longer"
    )]
    FewSamples { expected: usize, found: usize },
    /// No full scale.
    #[error("expected a full scale above 0 m/s², found {found}; state the range of the sensor")]
    NoFullScale { found: f64 },
    /// A rate that has no simple ratio to 8 kHz.
    #[error(transparent)]
    Series(#[from] SeriesError),
}
