//! Lines of the mains or of a machine, left out where samples are compared, and what may hide behind them.

use super::groups::{
    AcrossSamples, DiscriminationConfig, Texture, WithheldCause, below_jnd, discriminate,
};
use super::{Distinguishability, PairCriterion};
use crate::criterion::{Criterion, Limit};
use crate::feature::Analysis;
use crate::integrity::RestLine;
use crate::number::digits;

/// A Hann window spreads a line over so many bins on either side.
const SPREAD: f64 = 2.5;

/// A sample with the lines that each of its recordings has at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureWithLines {
    texture: Texture,
    at_rest: Vec<Vec<RestLine>>,
}

impl TextureWithLines {
    /// The strokes of `recordings` as those of `name`; `None` without one.
    ///
    /// Source: none; it gathers what was analysed.
    #[must_use]
    pub fn of(name: &str, recordings: &[&Analysis]) -> Option<Self> {
        Some(Self {
            texture: Texture::of(name, recordings)?,
            at_rest: recordings.iter().map(|a| a.rest_lines.clone()).collect(),
        })
    }

    /// The texture without what lies around `lines_hz`, whoever made it.
    fn without(&self, lines_hz: &[f64]) -> Texture {
        self.changed(|_, psd, resolution_hz| {
            for hz in lines_hz {
                let straight = beside(psd, hz / resolution_hz);
                for (bin, power) in straight {
                    psd[bin] = power;
                }
            }
        })
    }

    /// The texture less the power that its lines have at rest; what strokes hold more around them stays.
    fn less_rest(&self) -> Texture {
        self.changed(|recording, psd, resolution_hz| {
            for line in &self.at_rest[recording] {
                let place = line.frequency_hz / resolution_hz;
                for (bin, straight) in beside(psd, place) {
                    let line = line.mean_square * hann_lobe(bin as f64 - place) / resolution_hz;
                    psd[bin] = (psd[bin] - line).max(straight.min(psd[bin]));
                }
            }
        })
    }

    fn changed(&self, change: impl Fn(usize, &mut [f64], f64)) -> Texture {
        let mut texture = self.texture.clone();
        for (recording, strokes) in texture.recordings.iter_mut().enumerate() {
            for psd in strokes {
                change(recording, psd, texture.resolution_hz);
            }
        }
        texture
    }
}

/// The bins of `psd` that a line at `place`, in bins, reaches, each with the power on the straight line, of the logarithm, between the bins
/// beside them.
fn beside(psd: &[f64], place: f64) -> Vec<(usize, f64)> {
    let low = (place - SPREAD).floor().max(0.0) as usize;
    let high = (place + SPREAD).ceil() as usize;
    if high >= psd.len() {
        return Vec::new();
    }
    let [from, to] = [low, high].map(|bin| psd[bin].max(f64::MIN_POSITIVE).ln());
    let straight = |bin: usize| {
        let share = (bin - low) as f64 / (high - low) as f64;
        (bin, (from + share * (to - from)).exp())
    };
    (low + 1..high).map(straight).collect()
}

/// The share of a line's power in a bin so many bins beside it, through a Hann window.
fn hann_lobe(bins: f64) -> f64 {
    let turn = std::f64::consts::PI * bins;
    let amplitude = match bins.abs() {
        near if near < 1e-6 => 1.0,
        near if (near - 1.0).abs() < 1e-6 => 0.5,
        _ => turn.sin() / (turn * (1.0 - bins * bins)),
    };
    amplitude * amplitude / 1.5
}

/// [`discriminate`] without the lines at `lines_hz`, which are the mains' or a machine's. Samples are below the just-noticeable difference only
/// where they are so with what lies around these lines too, less the power that they have at rest: a texture may have a line there of its
/// own.
///
/// Formula: left out are two and a half bins on either side of a line, on the straight line, of the logarithm, between the bins beside
/// them. The power of a line at rest lies in the bins as the Hann window spreads it: sin(πd)/(πd·(1 − d²)), squared, over 1.5.
///
/// Source: house rule; F. J. Harris (1978), Proc. IEEE 66(1), for the window.
///
/// # Errors
/// As [`discriminate`].
pub fn discriminate_without(
    settings: &[Vec<TextureWithLines>],
    lines_hz: &[f64],
    config: &DiscriminationConfig,
) -> Result<AcrossSamples, WithheldCause> {
    let of = |texture: &dyn Fn(&TextureWithLines) -> Texture| -> Vec<Vec<Texture>> {
        let settings = settings.iter();
        settings
            .map(|textures| textures.iter().map(texture).collect())
            .collect()
    };
    if lines_hz.is_empty() {
        return discriminate(&of(&|texture| texture.texture.clone()), config);
    }
    let mut found = discriminate(&of(&|texture| texture.without(lines_hz)), config)?;
    let with_lines = discriminate(&of(&TextureWithLines::less_rest), config)?;
    for (groups, with) in found.settings.iter_mut().zip(&with_lines.settings) {
        for (pair, with) in groups.pairs.iter_mut().zip(&with.pairs) {
            let jnd = with.criteria.iter();
            let jnd = jnd.filter(|c| c.what == PairCriterion::JustNoticeableDifference);
            pair.criteria.extend(jnd.map(|found| {
                let limit = Limit::AtMost {
                    met: found.limit.value(),
                    not_met: f64::MAX,
                };
                let distance = found.found.unwrap_or(f64::NAN);
                Criterion::new(
                    PairCriterion::LeftOut,
                    "JND",
                    distance,
                    found.interval,
                    limit,
                )
            }));
            pair.outcome = Distinguishability::of(&pair.criteria);
        }
        groups.below_jnd = below_jnd(groups);
    }
    let resolution_hz = settings.iter().flatten().map(|t| t.texture.resolution_hz);
    let reach_hz = SPREAD * resolution_hz.fold(0.0, f64::max);
    let lines: Vec<String> = lines_hz.iter().map(|hz| digits(*hz)).collect();
    found.sentence += &format!(
        "; lines at {} Hz, of the mains or a machine, are left out with what lies within {} Hz of them",
        lines.join(", "),
        digits(reach_hz)
    );
    found.left_out_hz = lines_hz.to_vec();
    Ok(found)
}
