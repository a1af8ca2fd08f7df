//! Errors of texture manipulations.

use crate::quantity::{Band, Hertz, SampleRate, Seconds};
use crate::resample::ResampleError;
use crate::series::SeriesError;
use crate::spectrum::EstimateError;

/// Why a texture manipulation is not possible.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ManipulateError {
    /// The other texture is missing.
    #[error("expected a second texture for this manipulation, found none; name its recording")]
    NoOther,
    /// A texture has no spectrum in the usual segments.
    #[error("{said}")]
    Segments {
        /// Why.
        said: String,
    },
    /// The texture is constant.
    #[error(
        "expected a texture, found {duration:.3} of constant {quantity}; check the channel and the cable"
    )]
    Silent {
        /// What it holds.
        quantity: &'static str,
        /// Its length.
        duration: Seconds,
    },
    /// The texture has no power within a band.
    #[error(
        "expected power within {band} in {what}, found none; use a band in which both textures vibrate"
    )]
    SilentWithin {
        /// The texture.
        what: String,
        /// The band.
        band: Band,
    },
    /// The operation leaves nothing.
    #[error("expected a signal after `{after}`, found silence; use a smaller change")]
    NothingLeft {
        /// The operation.
        after: String,
    },
    /// The band does not fit the rate.
    #[error(
        "expected a band within half of the texture's rate, {nyquist}, found one up to {}; lower its end",
        band.high()
    )]
    BandAboveNyquist {
        /// The band.
        band: Band,
        /// Half the rate.
        nyquist: Hertz,
    },
    /// A number outside its range.
    #[error("expected {expected}, found {found}; {todo}")]
    Range {
        /// What is possible.
        expected: String,
        /// What was asked for.
        found: String,
        /// What to do.
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
        /// From which texture.
        of: String,
        /// At what rate.
        its_rate: SampleRate,
        /// The texture's own.
        rate: SampleRate,
    },
    /// The texture is too short to be joined.
    #[error(
        "expected a texture of {expected:.3} or longer for looping, found {found:.3}; use a longer stroke or a shorter crossfade"
    )]
    TooShort {
        /// The least length.
        expected: Seconds,
        /// What there is.
        found: Seconds,
    },
    /// Too few or too many phases.
    #[error(
        "expected one phase for each of {expected} lines, found {found}; draw as many as `phases_needed` says"
    )]
    Phases {
        /// What it takes.
        expected: usize,
        /// What there is.
        found: usize,
    },
    /// A ratio that the resampler cannot realise.
    #[error(
        "expected a warp with few decimals, found {found} ({why}); write it with four decimals"
    )]
    Ratio {
        /// The ratio.
        found: f64,
        /// Why not.
        why: ResampleError,
    },
    /// The other texture gives no spectrum.
    #[error("cannot estimate the spectrum of {of}: {why}")]
    Spectrum {
        /// The texture.
        of: String,
        /// Why not.
        why: EstimateError,
    },
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
