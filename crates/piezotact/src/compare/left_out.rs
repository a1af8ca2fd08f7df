//! Lines of the mains or of a machine, left out where samples are compared, and what may hide behind them.

use super::groups::{
    AcrossSamples, DiscriminationConfig, Texture, WithheldCause, below_jnd, discriminate, distances,
};
use super::{Distinguishability, Groups, PairCriterion};
use crate::criterion::{Criterion, Limit};
use crate::feature::Analysis;
use crate::integrity::RestLine;
use crate::number::digits;

/// Half a third of an octave, as a share of its middle.
const THIRD_OCTAVE: f64 = 0.115;
/// Rests of one sensor differ from their mean by less, dB rms over lines.
const OTHER_REST_DB: f64 = 3.0;
/// A Hann window spreads a line over so many bins on either side.
const SPREAD: f64 = 2.5;

/// A sample with the lines that each of its recordings has at rest.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureWithLines {
    texture: Texture,
    at_rest: Vec<Vec<RestLine>>,
    /// The mean PSD at rest, smoothed; absent where a recording has none, or one that is silent.
    rest_psd: Option<Vec<f64>>,
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
            rest_psd: mean_rest(recordings),
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

    /// The texture with the noise of its sensor at rest made `usual`.
    fn at_usual_rest(&self, usual: &[f64]) -> Texture {
        self.changed(|_, psd, _| {
            let rest = self.rest_psd.iter().flatten();
            for ((value, rest), usual) in psd.iter_mut().zip(rest).zip(usual) {
                *value *= usual / rest;
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

/// The mean PSD of `recordings` at rest, each bin the mean over a third of an octave around it and five bins or more.
fn mean_rest(recordings: &[&Analysis]) -> Option<Vec<f64>> {
    let all: Vec<&Vec<f64>> = recordings
        .iter()
        .map(|a| a.rest_psd.as_ref())
        .collect::<Option<_>>()?;
    let bins = all.first()?.len();
    let mean: Vec<f64> = (0..bins)
        .map(|k| {
            all.iter()
                .map(|psd| psd.get(k).unwrap_or(&0.0))
                .sum::<f64>()
        })
        .collect();
    let smooth = (0..bins).map(|k| {
        let reach = ((k as f64 * THIRD_OCTAVE) as usize).max(2);
        let part = &mean[k.saturating_sub(reach)..(k + reach + 1).min(bins)];
        part.iter().sum::<f64>() / part.len() as f64 / all.len() as f64
    });
    let smooth: Vec<f64> = smooth.collect();
    smooth.iter().all(|power| *power > 0.0).then_some(smooth)
}

/// The geometric mean of the PSDs at rest of `textures`; `None` where one has none, and where all are within 3 dB of it in the mean over
/// lines, as rests of one sensor are.
fn usual_rest(textures: &[TextureWithLines]) -> Option<Vec<f64>> {
    let all: Vec<&Vec<f64>> = textures
        .iter()
        .map(|one| one.rest_psd.as_ref())
        .collect::<Option<_>>()?;
    let bins = all.first()?.len();
    let of_bin = |k: usize| {
        let logs: Option<Vec<f64>> = all.iter().map(|psd| Some(psd.get(k)?.ln())).collect();
        Some(crate::statistics::mean(&logs?).exp())
    };
    let usual: Vec<f64> = (0..bins).map(of_bin).collect::<Option<_>>()?;
    let differs = all.iter().any(|rest| {
        let ratios = rest.iter().zip(&usual).map(|(rest, usual)| rest / usual);
        let squares = ratios.map(|ratio| (10.0 * ratio.log10()).powi(2));
        crate::statistics::mean(&squares.collect::<Vec<_>>()) > OTHER_REST_DB.powi(2)
    });
    differs.then_some(usual)
}

/// The bins of `psd` that a line at `place`, in bins, reaches, each with the power on the straight line, of the logarithm, between the bins
/// beside them.
pub(super) fn beside(psd: &[f64], place: f64) -> Vec<(usize, f64)> {
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
/// own. Where it is not known whether the textures make the lines `in_doubt_hz` of a setting, the outcome has to be the same with and without.
/// Samples are distinguishable only where they are so with the noise of their sensors at rest made equal too: a sensor in another unit, or of
/// another gain, differs at rest as it does in the strokes.
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
    in_doubt_hz: &[Vec<f64>],
    config: &DiscriminationConfig,
) -> Result<AcrossSamples, WithheldCause> {
    let of = |texture: &dyn Fn(&TextureWithLines, &[f64]) -> Texture| -> Vec<Vec<Texture>> {
        let settings = settings.iter().enumerate();
        settings
            .map(|(i, textures)| {
                let in_doubt_hz = in_doubt_hz.get(i).map_or(&[][..], Vec::as_slice);
                let textures = textures.iter();
                textures.map(|one| texture(one, in_doubt_hz)).collect()
            })
            .collect()
    };
    let mut found = discriminate(&of(&|texture, _| texture.without(lines_hz)), config)?;
    if in_doubt_hz.iter().any(|lines| !lines.is_empty()) {
        let without = |texture: &TextureWithLines, in_doubt_hz: &[f64]| {
            texture.without(&[lines_hz, in_doubt_hz].concat())
        };
        let without = distances(&of(&without), &found.config).found;
        add(&mut found, &without, |distance| Criterion {
            what: PairCriterion::InDoubt,
            ..distance.clone()
        });
    }
    let usual: Vec<Option<Vec<f64>>> = settings.iter().map(|all| usual_rest(all)).collect();
    let equal: Vec<Vec<Texture>> = settings
        .iter()
        .zip(&usual)
        .map(|(textures, usual)| {
            let textures = textures.iter();
            let equal = |one: &TextureWithLines| match usual {
                Some(usual) => one.at_usual_rest(usual),
                None => one.texture.clone(),
            };
            textures.map(equal).collect()
        })
        .collect();
    if usual.iter().any(Option::is_some) {
        let equal = distances(&equal, &found.config).found;
        add(&mut found, &equal, |distance| Criterion {
            what: PairCriterion::AtRest,
            ..distance.clone()
        });
    }
    if lines_hz.is_empty() {
        return Ok(found);
    }
    let with_lines = distances(&of(&|texture, _| texture.less_rest()), &found.config).found;
    add(&mut found, &with_lines, |with| {
        let limit = Limit::AtMost {
            met: with.limit.value(),
            not_met: f64::MAX,
        };
        let distance = with.found.unwrap_or(f64::NAN);
        Criterion::new(
            PairCriterion::LeftOut,
            "JND",
            distance,
            with.interval,
            limit,
        )
    });
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

/// Adds to every pair what its distance in `other` says, and decides again.
fn add(
    found: &mut AcrossSamples,
    other: &[Groups],
    criterion: impl Fn(&Criterion<PairCriterion>) -> Criterion<PairCriterion>,
) {
    for (groups, other) in found.settings.iter_mut().zip(other) {
        for (pair, other) in groups.pairs.iter_mut().zip(&other.pairs) {
            let jnd = other.criteria.iter();
            let jnd = jnd.filter(|c| c.what == PairCriterion::JustNoticeableDifference);
            pair.criteria.extend(jnd.map(&criterion));
            pair.outcome = Distinguishability::of(&pair.criteria);
        }
        groups.below_jnd = below_jnd(groups);
    }
}
