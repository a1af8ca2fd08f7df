//! Warnings about a rendering.

use crate::quantity::Band;
use crate::warning::words::{bands as list, percent};
use serde::{Deserialize, Serialize};

/// Warnings about a rendering.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum RenderWarning {
    /// Frequencies in the band that the inverse gives up.
    #[error(
        "the inverse gives up {} of the band ({}): the device hardly responds there or was not measured well, and the vibration there may be \
            missing or wrong",
        percent(*share),
        list(bands)
    )]
    GivenUp { bands: Vec<Band>, share: f64 },
    /// Frequencies that were intentionally attenuated so that the drive fits.
    #[error(
        "{} of the band ({}) was attenuated by more than 0.5 dB so that the drive fits, and the vibration there is too weak; at a level {:.1} dB \
            lower, no attenuation is needed",
        percent(*share),
        list(bands),
        -fits_at_db
    )]
    TurnedDown {
        bands: Vec<Band>,
        share: f64,
        fits_at_db: f64,
    },
    /// The device of a transfer function is not described: only the digital full scale limits the drive.
    #[error(
        "the transfer function does not say its amplifier gain and volts at full scale: only the digital full scale was checked, and the amplifier \
            may clip at a lower drive; state amplifier gain and volts at full scale when the transfer function is estimated"
    )]
    DeviceNotDescribed,
    /// The target and the transfer function come from recordings of different rates.
    #[error(
        "the target is sampled at {target_hz} Hz and the transfer function was measured at {transfer_hz} Hz: the band fits both and is rendered; \
            check that they belong together"
    )]
    RatesDiffer { target_hz: f64, transfer_hz: f64 },
    /// The amplifier cannot follow the drive into the capacitive load.
    #[error(
        "the drive needs a slew rate of {asked_v_per_s:.2e} V/s, but the amplifier reaches {limit_v_per_s:.2e} V/s with this load: high frequencies \
            will be distorted; lower the level; narrow the band"
    )]
    SlewLimited {
        asked_v_per_s: f64,
        limit_v_per_s: f64,
    },
    /// Much of a texture's power lies outside the band that is rendered.
    #[error(
        "{} of the texture's power lies outside {band} and is not rendered: widen the band where the device responds; check whether the power \
            outside the band belongs to the texture",
        percent(*share)
    )]
    PowerOutsideBand { share: f64, band: Band },
}
