//! Which parts of a band an inverse reaches, and which it gives up.

use serde::{Deserialize, Serialize};

use super::{Limiting, RenderConfig, RenderError};
use crate::quantity::{Band, Decibels, Hertz, Quantity};
use crate::transfer::{COHERENCE_ROUNDING, TransferFunction};

/// The parts of a band that an inverse, or the drive made with it, reaches, and those that it gives up.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Coverage {
    /// The parts that are reached, from the lowest.
    pub reached: Vec<Band>,
    /// The parts that are given up, from the lowest.
    pub given_up: Vec<Band>,
}

impl Coverage {
    /// The coverage of `band` by lines `step_hz` apart, each with its frequency in Hz and whether it is reached.
    pub(crate) fn of(lines: &[(f64, bool)], band: Band, step_hz: f64) -> Self {
        let [reached, given_up] = runs(lines, band, step_hz);
        Self { reached, given_up }
    }

    /// Whether the line at `frequency_hz` is reached.
    #[must_use]
    pub fn reaches(&self, frequency_hz: f64) -> bool {
        self.reached.iter().any(|band| band.contains(frequency_hz))
    }
}

/// The parts of the band that the inverse reaches, and those that it gives up.
///
/// A line is reached when the share of the target that the inverse requests loses no more than `largest_loss` and the coherence
/// is at least `lowest_coherence`.
///
/// Source: the delivered-to-target ratio H·Z/FIV of the inverse in [`super::invert`].
///
/// # Errors
/// [`RenderError::NoResponse`] when not one line is reached, [`RenderError::NoLine`] when the transfer function has none in the band.
pub fn coverage<I: Quantity, O: Quantity>(
    function: &TransferFunction<I, O>,
    config: &RenderConfig,
) -> Result<Coverage, RenderError> {
    Ok(known(function, config)?.bands)
}

/// A coverage with its share of lines.
pub(super) struct Known {
    pub(super) bands: Coverage,
    /// The share of lines given up, 0–1.
    pub(super) given_up_share: f64,
}

/// As [`coverage`], with the share of lines that are given up.
pub(super) fn known<I: Quantity, O: Quantity>(
    function: &TransferFunction<I, O>,
    config: &RenderConfig,
) -> Result<Known, RenderError> {
    let known = limited(function, config, None)?;
    if known.bands.reached.is_empty() {
        return Err(RenderError::NoResponse {
            band: config.inverse.band,
        });
    }
    Ok(known)
}

/// The coverage of the inverse, attenuated by `limiting` if there is one.
pub(super) fn limited<I: Quantity, O: Quantity>(
    function: &TransferFunction<I, O>,
    config: &RenderConfig,
    limiting: Option<&Limiting>,
) -> Result<Known, RenderError> {
    let band = config.inverse.band;
    let largest = function.peak_magnitude(band).powi(2).max(f64::MIN_POSITIVE);
    let least = Decibels(-config.largest_loss.0).amplitude_ratio();
    // A coherence above 1 is impossible: such a line counts as not reached.
    let believable = config.lowest_coherence..=1.0 + COHERENCE_ROUNDING;
    let excited = |hz: f64| function.excited.is_none_or(|excited| excited.contains(hz));
    if function.lines_in(band).next().is_none() {
        return Err(RenderError::NoLine {
            band,
            resolution_hz: function.resolution_hz(),
        });
    }
    let reached: Vec<(f64, bool)> = function
        .lines_in(band)
        .map(|(k, frequency_hz)| {
            let power = function.response()[k].norm_sqr() / largest;
            let left = limiting.map_or(1.0, |limiting| limiting.share_at(frequency_hz));
            let delivered = left * config.inverse.share(power, function.coherence()[k]);
            (
                frequency_hz,
                delivered >= least
                    && excited(frequency_hz)
                    && believable.contains(&function.coherence()[k]),
            )
        })
        .collect();
    let lost = reached.iter().filter(|(_, reached)| !reached).count();
    Ok(Known {
        bands: Coverage::of(&reached, band, function.resolution_hz()),
        given_up_share: lost as f64 / reached.len() as f64,
    })
}

/// The parts of `band` whose lines, `step_hz` apart, are flagged true, and the parts whose lines are flagged false.
pub(crate) fn runs(lines: &[(f64, bool)], band: Band, step_hz: f64) -> [Vec<Band>; 2] {
    let half = step_hz / 2.0;
    [true, false].map(|wanted| {
        let mut from = 0;
        let mut bands: Vec<Band> = Vec::new();
        for run in lines.chunk_by(|a, b| a.1 == b.1) {
            let (first, last) = (from, from + run.len() - 1);
            from += run.len();
            if run[0].1 != wanted {
                continue;
            }
            // The outermost lines stand for the rest of the band up to its ends.
            let low = if first == 0 {
                band.low().0
            } else {
                lines[first].0 - half
            };
            let high = if last + 1 == lines.len() {
                band.high().0
            } else {
                lines[last].0 + half
            };
            bands.extend(Band::new(Hertz(low), Hertz(high)));
        }
        bands
    })
}

/// The parts of `bands` outside `others`; each of `others` lies within one of `bands`.
pub(super) fn without(bands: &[Band], others: &[Band]) -> Vec<Band> {
    let mut left = Vec::new();
    for band in bands {
        let mut low = band.low();
        for other in others.iter().filter(|other| other.common(*band).is_some()) {
            left.extend(Band::new(low, other.low()));
            low = other.high();
        }
        left.extend(Band::new(low, band.high()));
    }
    left
}
