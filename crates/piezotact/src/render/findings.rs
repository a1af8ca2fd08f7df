//! What gives warnings about a rendering.

use super::{Headroom, PartLost, RenderConfig, RenderWarning};
use crate::clipping::{ClippedAt, ClippingWarning};
use crate::quantity::{Band, Decibels, Drive, Quantity, Seconds};
use crate::transfer::TransferFunction;
use crate::warning::{Warning, not_found_again};

/// What gives warnings about a rendering, as it was found: whoever settles a part of it takes it out before the warnings are made.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RenderFindings {
    /// The warnings about the transfer function, which apply to everything derived from it.
    pub function: Vec<Warning>,
    /// Whether the transfer function does not say its device.
    pub is_device_unknown: bool,
    /// The parts of the band that are given up, and their share of it, 0–1.
    pub given_up: Option<(Vec<Band>, f64)>,
    /// The parts of the band that are turned down so that the drive fits.
    pub turned_down: Option<TurnedDown>,
    /// The share of the target's power outside the band, 0–1, where it is a tenth or more.
    pub power_outside: Option<f64>,
    /// What the fade at both ends takes of the texture, where that is much.
    pub faded: Option<FadeLoss>,
    /// The limit at which samples are clipped; none where none is.
    pub clipped_at: Option<String>,
    /// The slope at the actuator and what the amplifier follows, V/s, where it is too steep.
    pub too_steep: Option<(f64, f64)>,
}

/// What a fade takes of a texture.
#[derive(Clone, Debug, PartialEq)]
pub struct FadeLoss {
    /// How long the fade is.
    pub fade: Seconds,
    /// The change of the level.
    pub level: Decibels,
    /// The change of the largest sample.
    pub peak: Decibels,
}

/// Parts of the band that are turned down so that a drive fits.
#[derive(Clone, Debug, PartialEq)]
pub struct TurnedDown {
    /// The parts.
    pub bands: Vec<Band>,
    /// Their share of the band, 0–1.
    pub share: f64,
    /// The level at which all of the band would fit, dB.
    pub fits_at_db: f64,
    /// The share of samples of the whole band's drive that exceed a limit of the device, 0–1.
    pub beyond_limit: f64,
}

impl RenderFindings {
    /// What `function` gives over the band of `config`.
    pub(super) fn of<O: Quantity>(
        function: &TransferFunction<Drive, O>,
        config: &RenderConfig,
    ) -> Self {
        let band = config.inverse.band;
        let mut found = Self {
            is_device_unknown: function.drive.is_none(),
            ..Self::default()
        };
        let over_band = [
            function.low_coherence(band, config.lowest_coherence),
            function.not_excited(band),
        ];
        found.function.extend(over_band.into_iter().flatten());
        // What is found for this band is not said again for that of the estimate.
        let others = not_found_again(&function.about.warnings, &found.function);
        found.function.extend(others);
        found
    }

    /// The warnings about a drive with `headroom` for the part of a texture in `band`.
    #[must_use]
    pub fn warnings(self, band: Band, headroom: &Headroom) -> Vec<Warning> {
        let unknown = self
            .is_device_unknown
            .then_some(RenderWarning::DeviceNotDescribed);
        let given_up = self
            .given_up
            .map(|(bands, share)| RenderWarning::BandPartLost {
                bands,
                share,
                why: PartLost::GivenUp,
            });
        let turned_down = self.turned_down.map(|found| RenderWarning::BandPartLost {
            share: found.share,
            bands: found.bands,
            why: PartLost::TurnedDown {
                fits_at_db: found.fits_at_db,
                beyond_limit: Some(found.beyond_limit),
            },
        });
        let faded = self.faded.map(|loss| RenderWarning::Faded {
            fade_s: loss.fade.0,
            level_db: loss.level.0,
            peak_db: loss.peak.0,
        });
        let outside = self
            .power_outside
            .map(|share| RenderWarning::PowerOutsideBand { share, band });
        let clipped = self.clipped_at.map(|limited_by| ClippingWarning::Clipped {
            signal: "the drive".into(),
            at: ClippedAt::Rendered {
                limited_by,
                fraction: headroom.clipped_fraction,
            },
        });
        let steep =
            self.too_steep.map(
                |(asked_v_per_s, limit_v_per_s)| RenderWarning::SlewLimited {
                    asked_v_per_s,
                    limit_v_per_s,
                },
            );
        let first = [unknown, given_up, turned_down, outside, faded];
        let mut warnings = self.function;
        warnings.extend(first.into_iter().flatten().map(Warning::from));
        warnings.extend(clipped.map(Warning::from));
        warnings.extend(steep.map(Warning::from));
        warnings
    }
}
