//! Why a target cannot be rendered.

use crate::quantity::{Band, Decibels, Hertz};
use crate::series::SeriesError;

/// Why a target cannot be rendered.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RenderError {
    /// The band extends beyond the known frequencies.
    #[error(
        "cannot render over {band}: {what} ends at {highest}; lower the band's end or measure at a higher rate"
    )]
    BandAboveNyquist {
        /// The band asked for.
        band: Band,
        /// What does not reach that far.
        what: &'static str,
        highest: Hertz,
    },
    /// The plan is for another length.
    #[error(
        "cannot render: the plan is for {expected} samples, the target has {found}; make a plan for its length"
    )]
    Length { expected: usize, found: usize },
    /// The regularisation is not a number from zero up.
    #[error("expected a regularisation of 0 or more, found {found}; 9e-6 is the usual one")]
    Regularisation { found: f64 },
    /// There is nothing to render.
    #[error(
        "cannot render: expected a texture, found silence (every sample is the same); check the channel"
    )]
    Silent,
    /// A waveform is requested from a minimum-phase inverse, which reproduces spectra only.
    #[error(
        "cannot replicate a waveform with the minimum phase, which reproduces spectra alone; use the linear phase, or correct \
            the texture"
    )]
    Phase,
    /// The band falls between two lines.
    #[error(
        "cannot render over {band}: it contains no line of the transfer function, which has one every {resolution_hz:.2} Hz; \
            use a wider band"
    )]
    NoLine {
        band: Band,
        /// The step between lines, Hz.
        resolution_hz: f64,
    },
    /// The device does not answer.
    #[error(
        "cannot render over {band}: the device does not respond well enough to be inverted at any frequency of it; measure it \
            again, at a higher level or longer, or use another band"
    )]
    NoResponse { band: Band },
    /// The condition of the measurement differs from the requested one.
    #[error(
        "cannot render: transfer function measured at {what} {measured}, drive requested at {requested}; characterise \
            at {requested}, or set the amplifier as in the measurement"
    )]
    ConditionMismatch {
        what: &'static str,
        /// How it was measured.
        measured: String,
        /// How it is asked for.
        requested: String,
    },
    /// The drive does not fit.
    #[error(
        "the target needs a drive of {peak:.3}, but the limit of {limited_by} is {limit:.3} (full scale = 1): lower the target \
            by {:.1} dB, or allow clipping", -fits_at.0
    )]
    ExceedsFullScale {
        /// The largest sample needed.
        peak: f64,
        limit: f64,
        limited_by: String,
        /// The level at which it would fit.
        fits_at: Decibels,
    },
    /// The drive is steeper than the amplifier follows.
    #[error(
        "the target needs a slew rate of {asked_v_per_s:.3e} V/s, but the amplifier reaches {limit_v_per_s:.3e} V/s with this \
            load: lower the target by {:.1} dB", -fits_at.0
    )]
    ExceedsSlew {
        /// The steepest slope needed, V/s.
        asked_v_per_s: f64,
        /// What the amplifier follows, V/s.
        limit_v_per_s: f64,
        /// The level at which it would fit.
        fits_at: Decibels,
    },
    /// The drive is warmer than the actuator bears.
    #[error(
        "the target needs an rms current of {asked_a:.3} A over its loudest second, but the actuator bears {limit_a:.3} A: lower the \
            target by {:.1} dB", -fits_at.0
    )]
    ExceedsCurrent {
        /// A rms.
        asked_a: f64,
        /// A rms.
        limit_a: f64,
        /// The level at which it would fit.
        fits_at: Decibels,
    },
    /// The vibration moves the actuator further than it can move.
    #[error(
        "the target needs an excursion of {:.3} mm, but the actuator moves by {:.3} mm: lower the target by {:.1} dB, or raise the \
            lower end of the band", asked_m * 1e3, limit_m * 1e3, -fits_at.0
    )]
    ExceedsExcursion {
        asked_m: f64,
        limit_m: f64,
        /// The level at which it would fit.
        fits_at: Decibels,
    },
    /// The drive is no signal, or does not fit the output rate.
    #[error(transparent)]
    Signal(#[from] SeriesError),
}

impl RenderError {
    /// The level, re the target, at which its drive would fit the device; `None` where another level changes nothing.
    #[must_use]
    pub fn fits_at(&self) -> Option<Decibels> {
        match self {
            Self::ExceedsFullScale { fits_at, .. }
            | Self::ExceedsSlew { fits_at, .. }
            | Self::ExceedsCurrent { fits_at, .. }
            | Self::ExceedsExcursion { fits_at, .. } => Some(*fits_at),
            _ => None,
        }
    }
}
