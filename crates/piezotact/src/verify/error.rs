//! Why a measurement cannot be compared with its target.

use crate::quantity::{Band, Hertz, QuantityError};
use crate::series::SeriesError;
use crate::spectrum::EstimateError;

/// Why a measurement cannot be compared with its target.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum VerifyError {
    /// The rates differ.
    #[error(
        "cannot compare: the target is sampled at {target_hz} Hz, the measurement at {measured_hz} Hz; resample both to one rate"
    )]
    Rate { target_hz: f64, measured_hz: f64 },
    /// The band reaches beyond the signals.
    #[error("cannot compare over {band}: the signals end at {highest}; lower the band's end")]
    BandAboveNyquist {
        /// The band asked for.
        band: Band,
        /// Where the signals end.
        highest: Hertz,
    },
    /// The band falls between two lines.
    #[error(
        "cannot compare over {band}: it contains no line of the spectra, which have one every {resolution_hz:.2} Hz; use a \
            wider band"
    )]
    NoLine {
        band: Band,
        /// The step between lines, Hz.
        resolution_hz: f64,
    },
    /// Too little in common.
    #[error(
        "expected {expected} samples in common to target and measurement, found {found}; check that they belong together"
    )]
    TooShort { expected: usize, found: usize },
    /// Nothing there.
    #[error("{what} has no signal in {band}: check the channel and the band")]
    Silent {
        /// Which of the two.
        what: &'static str,
        band: Band,
    },
    /// The transfer function does not reach the band.
    #[error(
        "the transfer function has no valid line in {band}: compare over another band, or measure it there"
    )]
    OutOfReach {
        /// The band asked for.
        band: Band,
    },
    /// The spectra cannot be estimated.
    #[error(transparent)]
    Estimate(#[from] EstimateError),
    /// The computed samples do not form a valid signal.
    #[error(transparent)]
    Series(#[from] SeriesError),
    /// An invalid rate or band.
    #[error(transparent)]
    Quantity(#[from] QuantityError),
}
