//! Warnings about a rendering.

use crate::number::plus;
use crate::quantity::Band;
use crate::warning::words::{bands as list, percent};
use serde::{Deserialize, Serialize};

/// Warnings about a rendering.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "code", rename_all = "snake_case")]
pub enum RenderWarning {
    /// The device of a transfer function is not described: only the digital full scale limits the drive.
    #[error(
        "the transfer function states neither amplifier gain nor volts at full scale: only the digital full scale was checked, and the amplifier \
            may clip at a lower drive; state both when the transfer function is estimated"
    )]
    DeviceNotDescribed,
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
    /// The fade at both ends takes much of a short or abrupt texture.
    #[error(
        "the fade of {:.0} ms at both ends changes the level of the texture by {} dB and its peak by {} dB; render it without a fade",
        fade_s * 1e3,
        plus(*level_db, 1),
        plus(*peak_db, 1)
    )]
    Faded {
        fade_s: f64,
        level_db: f64,
        peak_db: f64,
    },
    /// A part of the band is not reached, or not compared.
    #[error("{} of the band{} {why}; {}", percent(*share), in_bands(bands), why.advice())]
    BandPartLost {
        share: f64,
        bands: Vec<Band>,
        #[serde(flatten)]
        why: PartLost,
    },
}

/// Why a part of the band is not reached or not compared.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, thiserror::Error)]
#[serde(tag = "why", rename_all = "snake_case")]
pub enum PartLost {
    /// Frequencies in the band that the inverse gives up.
    #[error(
        "is given up by the inverse: the device hardly responds there or was not measured well, and the vibration there may be missing or wrong"
    )]
    GivenUp,
    /// Frequencies that were intentionally attenuated so that the drive fits.
    #[error(
        "was attenuated by more than 0.5 dB so that the drive fits{}; the vibration there is too weak",
        beyond_limit.map_or(String::new(), |beyond| format!(", for the {} of its samples that exceeded a limit of the device", percent(beyond)))
    )]
    TurnedDown {
        fits_at_db: f64,
        /// The share of samples of the drive for the whole band that exceed a limit, 0–1; absent for a corrected drive.
        #[serde(skip_serializing_if = "Option::is_none", default)]
        beyond_limit: Option<f64>,
    },
    /// Lines of the target that the sensor's noise hides.
    #[error(
        "holds a target below the noise of the sensor: most of the error there is noise, and little of it can be corrected"
    )]
    TargetInNoise,
    /// Part of the target's lines is hidden by the sensor's noise and was not compared.
    #[error("is hidden by the noise of the sensor, with {:.2} % of the power of the target, and is not compared", power_share * 100.0)]
    HiddenByNoise { power_share: f64 },
    /// Part of the band holds almost no target power: errors in dB are meaningless there and are left out.
    #[error("holds almost no power of the target, and is left out of the error")]
    NoTarget,
}

impl PartLost {
    /// What a person can do.
    fn advice(&self) -> String {
        match self {
            Self::GivenUp => "narrow the band, or measure the transfer function again".into(),
            Self::TurnedDown { fits_at_db, .. } => {
                format!(
                    "lower the level by {:.1} dB to keep the whole band",
                    -fits_at_db
                )
            }
            Self::TargetInNoise => "raise the level, or use a sensor with less noise".into(),
            Self::HiddenByNoise { .. } => "use a sensor with less noise".into(),
            Self::NoTarget => "narrow the band".into(),
        }
    }
}

/// The parts of the band, where they are known.
fn in_bands(bands: &[Band]) -> String {
    match bands {
        [] => String::new(),
        bands => format!(" ({})", list(bands)),
    }
}
