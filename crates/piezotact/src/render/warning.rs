//! Warnings about a rendering.

use std::fmt;

use crate::quantity::Band;
use crate::warning::words::{bands as list, percent};
use crate::warning::{Advice, Subject, WarningKind, warnings};

warnings! {
    /// Warnings about a rendering.
    pub enum RenderWarning {
        /// Frequencies in the band that the inverse gives up.
        GivenUp("given_up") {
            /// The bands given up.
            bands: Vec<Band>,
            /// Their share of the band's lines, 0–1.
            share: f64,
        },
        /// Frequencies that were intentionally attenuated so that the drive fits.
        TurnedDown("turned_down") {
            /// The bands attenuated by more than 0.5 dB.
            bands: Vec<Band>,
            /// Their share of the band's lines, 0–1.
            share: f64,
            /// The level re the requested one at which no attenuation is needed, dB.
            fits_at_db: f64,
        },
        /// The device of a transfer function is not described: only the digital full scale limits the drive.
        DeviceNotDescribed("device_not_described"),
        /// The target and the transfer function come from recordings of different rates.
        RatesDiffer("rates_differ") {
            /// The target's rate in Hz.
            target_hz: f64,
            /// The rate of the recording behind the transfer function, in Hz.
            transfer_hz: f64,
        },
        /// The amplifier cannot follow the drive into the capacitive load.
        SlewLimited("slew_limited") {
            /// The steepest slope asked for, V/s.
            asked_v_per_s: f64,
            /// What the amplifier can do, V/s.
            limit_v_per_s: f64,
        },
        /// Much of a texture's power lies outside the band that is rendered.
        PowerOutsideBand("power_outside_band") {
            /// The share of its power, 0–1.
            share: f64,
            /// The band.
            band: Band,
        },
    }
}

impl WarningKind for RenderWarning {
    fn of(warning: &crate::Warning) -> Option<Self> {
        Self::of_warning(warning)
    }

    fn advice(&self) -> Vec<Advice> {
        match self {
            Self::GivenUp { .. } => Vec::new(),
            Self::TurnedDown { fits_at_db, .. } => vec![Advice::LowerLevel {
                to_db: Some(*fits_at_db),
            }],
            Self::DeviceNotDescribed => vec![Advice::DescribeDevice],
            Self::RatesDiffer { .. } => vec![Advice::Check(Subject::Belonging)],
            Self::SlewLimited { .. } => {
                vec![Advice::LowerLevel { to_db: None }, Advice::NarrowBand]
            }
            Self::PowerOutsideBand { .. } => {
                vec![Advice::WidenBand, Advice::Check(Subject::OutsideBand)]
            }
        }
    }
}

impl fmt::Display for RenderWarning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::GivenUp { bands, share } => write!(
                f,
                "the inverse gives up {} of the band ({}): the device hardly responds there or was not measured well, and the vibration there may be missing or wrong",
                percent(*share),
                list(bands)
            ),
            Self::TurnedDown { bands, share, fits_at_db } => write!(
                f,
                "{} of the band ({}) was attenuated by more than 0.5 dB so that the drive fits, and the vibration there is too \
                    weak; at a level {:.1} dB lower, no attenuation is needed",
                percent(*share),
                list(bands),
                -fits_at_db
            ),
            Self::DeviceNotDescribed => f.write_str(
                "the transfer function does not say its amplifier gain and volts at full scale: only the digital full scale was \
                    checked, and the amplifier may clip at a lower drive",
            ),
            Self::RatesDiffer { target_hz, transfer_hz } => write!(
                f,
                "the target is sampled at {target_hz} Hz and the transfer function was measured at {transfer_hz} Hz: the band fits both and is rendered"
            ),
            Self::SlewLimited { asked_v_per_s, limit_v_per_s } => write!(
                f,
                "the drive needs a slew rate of {asked_v_per_s:.2e} V/s, but the amplifier reaches {limit_v_per_s:.2e} V/s with \
                    this load: high frequencies will be distorted"
            ),
            Self::PowerOutsideBand { share, band } => write!(
                f,
                "{} of the texture's power lies outside {band} and is not rendered",
                percent(*share)
            ),
        }
    }
}
