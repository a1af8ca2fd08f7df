//! Errors of texture manipulations.

use crate::quantity::{Band, Hertz, SampleRate, Seconds};
use crate::series::SeriesError;
use crate::spectrum::EstimateError;

/// Why a texture manipulation is not possible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ManipulateError {
    /// The other texture is missing.
    #[error("this manipulation needs a second texture: name its recording")]
    NoOther,
    /// A texture has no spectrum in the usual segments.
    #[error("{said}")]
    Segments { said: String },
    /// The texture is constant.
    #[error(
        "expected a texture, found {duration:.3} of constant {quantity}; check the channel and the cable"
    )]
    Silent {
        quantity: &'static str,
        duration: Seconds,
    },
    /// The texture has no power within a band.
    #[error("{what} has no power within {band}: use a band in which both textures vibrate")]
    SilentWithin { what: String, band: Band },
    /// The operation leaves nothing.
    #[error("expected a signal after `{after}`, found silence; use a smaller change")]
    NothingLeft { after: String },
    /// The band does not fit the rate.
    #[error(
        "expected a band within half of the texture's rate, {nyquist}, found one up to {}; lower its end",
        band.high()
    )]
    BandAboveNyquist { band: Band, nyquist: Hertz },
    /// A number outside its range.
    #[error("expected {expected}, found {found}; {todo}")]
    Range {
        expected: String,
        /// What was asked for.
        found: String,
        todo: &'static str,
    },
    /// Two textures of different rates.
    #[error(
        "cannot use the {taken} of {of}: it is sampled at {its_rate} and the texture at {rate}; resample both to one rate with \
            `resample`"
    )]
    RatesDiffer {
        /// The property to be taken from the other texture.
        taken: &'static str,
        of: String,
        its_rate: SampleRate,
        rate: SampleRate,
    },
    /// The texture is too short to be joined.
    #[error(
        "expected a texture of {expected:.3} or longer for looping, found {found:.3}; use a longer stroke or a shorter crossfade"
    )]
    TooShort { expected: Seconds, found: Seconds },
    /// Too few or too many phases.
    #[error(
        "expected one phase for each of {expected} lines, found {found}; draw as many as `phases_needed` says"
    )]
    Phases { expected: usize, found: usize },
    /// A ratio that the resampler cannot realise.
    #[error(
        "expected a warp with few decimals, found {found} ({why}); write it with four decimals"
    )]
    Ratio { found: f64, why: SeriesError },
    /// The other texture gives no spectrum.
    #[error("cannot estimate the spectrum of {of}: {why}")]
    Spectrum { of: String, why: EstimateError },
    /// The result is not a valid signal.
    #[error("the result is not a valid texture: {0}")]
    Series(#[from] SeriesError),
}

/// `value` where it is from `low` to `high`.
pub(super) fn require_range(
    what: &str,
    value: f64,
    (low, high): (f64, f64),
    unit: &str,
    todo: &'static str,
) -> Result<(), ManipulateError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(ManipulateError::Range {
        expected: format!("{what} from {low} to {high}{unit}"),
        found: format!("{value}{unit}"),
        todo,
    })
}
