//! How a measurement is compared with its target, and what counts as passed.

use serde::{Deserialize, Serialize};

use crate::clipping::{Clipping, clipping};
use crate::feature::Weighting;
use crate::lineage::Mode;
use crate::quantity::{Band, Decibels, Quantity};
use crate::render::RenderConfig;
use crate::series::Series;
use crate::spectrum::WelchConfig;

/// How a measurement is compared with its target.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct VerifyConfig {
    /// The band over which they are compared.
    pub band: Band,
    /// The parts of it that the drive reaches, as its [`Coverage`](crate::render::Coverage) says; empty when that is not known.
    #[serde(rename = "achievable")]
    pub reached: Vec<Band>,
    /// How the spectra are estimated.
    pub welch: WelchConfig,
    /// The level re the target at which it was intentionally rendered, dB; the comparison is made at that level.
    pub level: Decibels,
    /// The band that the rendering kept of the target; the target is limited to it before the comparison. Absent: all of it.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub rendered: Option<RenderedBand>,
    /// The detection threshold with which power is weighted by perceptibility.
    pub weighting: Weighting,
    /// Whether the waveform is judged, or the spectrum alone.
    pub mode: Mode,
    /// What counts as passed.
    pub limits: Limits,
}

/// The band that a rendering kept of a texture.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct RenderedBand {
    /// The band.
    pub band: Band,
    /// The width of its raised-cosine edges, as a share of its ends.
    pub edge_ratio: f64,
}

/// What counts as passed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Limits {
    /// The largest level error either way, dB.
    pub level_db: f64,
    /// The largest spectrum error, dB rms over the lines of the band: unweighted, weighted by power and by felt power.
    pub error_db_rms: f64,
    /// The lowest waveform correlation, where the waveform counts.
    pub waveform_correlation: f64,
    /// The largest power of the waveforms' difference over that of the target (NMSE), where the waveform counts, dB.
    pub waveform_nmse_db: f64,
    /// The largest share of samples at a limit, 0–1.
    pub clipped_fraction: f64,
    /// The largest added power (power on lines without target) re the target's: in the band, and weighted by perceptibility
    /// outside it.
    pub added_power: f64,
    /// The longest drop-out that the target does not have, s.
    pub drop_out_s: f64,
    /// The largest departure of a short-time level, dB.
    pub short_time_level_db: f64,
    /// The share of the target's power in the band that must be judged for a full verdict, 0–1; below it the verdict is partial.
    pub judged_power: f64,
    /// The share of the target's length that must be measured for a full verdict, 0–1; below it the verdict is partial.
    pub covered: f64,
    /// Below this judged share of the target's power, or of the lines of the band, a verification does not pass, 0–1.
    pub least_judged: f64,
}

impl Limits {
    /// 1 dB in level and 1 dB rms in the spectrum, below the just-noticeable difference of 1.58 dB (a fifth in amplitude); a
    /// correlation of 0.95 and an NMSE of −10 dB, which goes with it; one sample in a thousand at a limit; a tenth of the
    /// power added; no drop-out of 15 ms; short-time levels within 3 dB; 95 % of the power and 98 % of the length, and never
    /// less than half.
    #[must_use]
    pub fn individual_transfer_function() -> Self {
        Self {
            level_db: 1.0,
            error_db_rms: 1.0,
            waveform_correlation: 0.95,
            waveform_nmse_db: -10.0,
            clipped_fraction: 1e-3,
            added_power: 0.1,
            drop_out_s: 0.015,
            short_time_level_db: 3.0,
            judged_power: 0.95,
            covered: 0.98,
            least_judged: 0.5,
        }
    }
}

impl VerifyConfig {
    /// Over `band`, Hann segments of about 5 Hz at `rate_hz`, the limits for an individual transfer function.
    #[must_use]
    pub fn over(band: Band, rate_hz: f64) -> Self {
        let segment = 2f64.powf((rate_hz / 5.0).log2().round()).max(16.0) as usize;
        Self {
            band,
            reached: Vec::new(),
            welch: WelchConfig::hann(segment),
            level: Decibels(0.0),
            rendered: None,
            weighting: Weighting::DetectionThreshold,
            mode: Mode::Replicate,
            limits: Limits::individual_transfer_function(),
        }
    }

    /// The same configuration for a target rendered with `render`: with its band (what its fades took is missing), and judged by the spectrum alone
    /// when `mode` leaves the phases free.
    #[must_use]
    pub fn rendered_as(self, render: &RenderConfig, mode: Mode) -> Self {
        Self {
            rendered: Some(RenderedBand {
                band: render.inverse.band,
                edge_ratio: render.inverse.edge_ratio,
            }),
            mode,
            ..self
        }
    }
}

/// What was measured while a drive was played.
#[derive(Clone, Debug)]
pub struct Measured<'a, Q: Quantity> {
    /// The response, in the unit of the target, at its rate.
    pub response: &'a Series<Q>,
    /// What is known about clipping in the device and the sensor; see [`clipping`].
    pub clipping: Clipping,
}

impl<'a, Q: Quantity> Measured<'a, Q> {
    /// A response without information about clipping, except flat tops found in the response itself.
    #[must_use]
    pub fn alone(response: &'a Series<Q>) -> Self {
        Self {
            response,
            clipping: clipping(response, None, None),
        }
    }
}
