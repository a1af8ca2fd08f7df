//! Which samples are distinguishable by their vibration, from the strokes of each.

use crate::warning::{Few, FewWarning, Scatter, ScatterWarning, Warning};
use serde::{Deserialize, Serialize};

use super::chance::{self, by_name, halves_apart, permute};
use super::distinguishability::{Distinguishability, Groups, Pair, PairCriterion, SampleUnit};
use crate::criterion::{Criterion, Limit};
use crate::discrimination::{
    Difference, Evidence, Excitation, ExcitationPlan, Model, Units, differences,
};
use crate::feature::Analysis;
use crate::quantity::{Band, Hertz, Unit};
use crate::statistics::{holm, smallest_p, units_needed};

/// Recordings are pooled when the p-value of a difference between them is at least this.
pub(super) const POOLED_FROM: f64 = 0.1;
/// The divisions of a sample's units into halves that are looked at.
const HALVINGS: usize = 199;
/// The divisions of strokes among recordings that are looked at.
const SHUFFLES: usize = 499;

/// What is compared: a sample's strokes, by recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    pub name: String,
    /// The PSDs of the strokes of each recording, one-sided, with lines `resolution_hz` apart from 0 Hz.
    pub recordings: Vec<Vec<Vec<f64>>>,
    /// The step between the lines, Hz.
    pub resolution_hz: f64,
    /// The unit of the vibration.
    pub unit: Unit,
    /// The highest frequency that the PSDs hold, Hz.
    pub highest_hz: f64,
}

impl Texture {
    /// The strokes of `recordings` as those of `name`; `None` without one.
    ///
    /// Source: none; it gathers what was analysed.
    #[must_use]
    pub fn of(name: &str, recordings: &[&Analysis]) -> Option<Self> {
        let first = recordings.first()?;
        Some(Self {
            name: name.into(),
            recordings: recordings.iter().map(|a| a.psd.each.clone()).collect(),
            resolution_hz: first.psd.resolution_hz,
            unit: first.unit.clone(),
            highest_hz: first.psd.resolution_hz * first.psd.mean.len().saturating_sub(1) as f64,
        })
    }
}

/// How samples are compared.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct DiscriminationConfig {
    /// The perceptual model of excitation and just-noticeable differences.
    pub model: Model,
    /// The family-wise error rate α: the probability of declaring any two equal samples of a study distinguishable.
    pub alpha: f64,
    /// Draws the divisions.
    pub seed: u64,
}

impl DiscriminationConfig {
    /// Five per cent over all pairs, with the model `model`.
    #[must_use]
    pub fn usual(model: Model) -> Self {
        Self {
            model,
            alpha: 0.05,
            seed: 1,
        }
    }
}

/// A study in which samples were compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct AcrossSamples {
    /// One for each setting.
    pub settings: Vec<Groups>,
    /// The independent units: strokes or recordings.
    pub units: SampleUnit,
    /// The pairs of samples, over which errors are controlled.
    pub family: usize,
    /// How it was done.
    pub config: DiscriminationConfig,
    /// What decides, in a sentence.
    pub sentence: String,
    /// The lines that were left out, since they are the mains' or a machine's, Hz.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub left_out_hz: Vec<f64>,
    /// Where the just-noticeable differences come from.
    pub jnd_source: &'static str,
    /// What a person should know before relying on it; a document has these among its own.
    #[serde(skip)]
    pub warnings: Vec<Warning>,
}

impl AcrossSamples {
    /// The pairs over which errors are controlled, in words: "1 pair", "all 6 pairs".
    #[must_use]
    pub fn family_text(&self) -> String {
        pairs_text(self.family)
    }
}

fn pairs_text(count: usize) -> String {
    match count {
        1 => "1 pair".into(),
        count => format!("all {count} pairs"),
    }
}

/// What decides, in a sentence.
fn sentence(
    units: SampleUnit,
    (family, settings): (usize, usize),
    config: &DiscriminationConfig,
) -> String {
    let model = &config.model;
    format!(
        "criteria: distinguishable if the difference exceeds the variability between {} of one sample (permutation test{}, \
         {:.0} % over {}) and {:.1} dB or {:.2} JND, or over time 1 JND; below the JND if it is within {:.2} dB, and over time within \
         1 JND; distances in JND of {:.2} dB over {}. Over time the means over strokes of equal length are compared: what differs from \
         stroke to stroke (an irregular rhythm, accents, single gaps) and modulation of fewer than five periods in a stroke may be felt \
         and are not found",
        units.word(),
        if settings > 1 {
            " over all settings together"
        } else {
            ""
        },
        config.alpha * 100.0,
        pairs_text(family),
        model.level_jnd_high.0.max(model.level_jnd.0),
        model.noticed_jnd(),
        model.level_jnd.0,
        model.level_jnd.0,
        model.band,
    )
}

/// Why distinguishability is not judged: a part of the document of a study.
#[derive(Clone, Debug, PartialEq, thiserror::Error, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(tag = "withheld", rename_all = "snake_case")]
pub enum WithheldCause {
    /// The vibration is no acceleration in m/s².
    #[error(
        "it is not computed which samples are distinguishable: thresholds and JND are known for accelerations in m/s², \
            but {sample} is in {}; state the scale of the sensor",
        if unit.is_empty() { "a unit that is not stated" } else { unit }
    )]
    NotAnAcceleration {
        /// A sample.
        sample: String,
        /// Its unit.
        unit: String,
    },
    /// The recordings end below the perceptible frequencies.
    #[error(
        "it is not computed which samples are distinguishable: the spectra end at {highest_hz:.0} Hz, but vibrations are felt \
            over {band}; record at 400 Hz or faster"
    )]
    BandNotHeld {
        /// The highest frequency, Hz.
        highest_hz: f64,
        /// The band that is compared.
        band: Band,
    },
    /// Spectra with other lines.
    #[error(
        "it is not computed which samples are distinguishable: the PSDs of {one} and {other} have different spectral lines; \
            record all at one rate"
    )]
    OtherLines {
        /// One sample.
        one: String,
        /// Another.
        other: String,
    },
}

/// The least upper frequency of spectra for a comparison, Hz.
const LEAST_HIGH_HZ: f64 = 200.0;

/// The band over which `settings` can be compared: that of the model, or as much of it as the PSDs hold.
fn band_of(settings: &[Vec<Texture>], band: Band) -> Result<Band, WithheldCause> {
    let all = || settings.iter().flatten();
    if let Some(other) = all().find(|t| t.unit != Unit::MetrePerSecondSquared) {
        return Err(WithheldCause::NotAnAcceleration {
            sample: other.name.clone(),
            unit: other.unit.to_string(),
        });
    }
    let lines = |t: &Texture| (t.highest_hz / t.resolution_hz.max(f64::MIN_POSITIVE)).round();
    for textures in settings {
        if let Some(first) = textures.first()
            && let Some(other) = textures.iter().find(|t| {
                (t.resolution_hz / first.resolution_hz - 1.0).abs() > 1e-3
                    || (lines(t) - lines(first)).abs() > 0.5
            })
        {
            return Err(WithheldCause::OtherLines {
                one: first.name.clone(),
                other: other.name.clone(),
            });
        }
    }
    let highest_hz = all().map(|t| t.highest_hz).fold(f64::INFINITY, f64::min);
    if highest_hz.is_nan() || highest_hz < LEAST_HIGH_HZ.min(band.high().0) {
        return Err(WithheldCause::BandNotHeld { highest_hz, band });
    }
    Ok(Band::new(band.low(), Hertz(band.high().0.min(highest_hz))).unwrap_or(band))
}

/// The excitations of the units of a sample.
pub(super) struct Sample {
    pub(super) units: Vec<Excitation>,
    mean: Excitation,
}

/// Which samples of each of `settings` are distinguishable by their vibration, from strokes: distances in JND as
/// [`crate::score::score`] has them, of the mean power of each sample, with what strokes of one sample differ by.
///
/// A pair is *distinguishable* when three things hold: its 95 % interval lies above the published range of the JND; it lies above what
/// halves of either sample differ by; and the distance is larger than chance makes it by a permutation test over strokes, within each
/// setting, of the sum of the distances over all settings, adjusted (Holm) for all pairs of samples, so that a study of samples that are
/// alike says so anywhere with a probability of at most α. It is *below the JND* when its interval lies below it. Everything else is *not decided*. Where recordings of a sample differ
/// by more than its strokes do (a permutation of strokes among recordings, p < 0.1), recordings are the units, and the strokes of
/// one are averaged.
///
/// Formula: limits from Student's t with the degrees of freedom of Welch and Satterthwaite on the derivative of the distance;
/// [`crate::statistics::permutation_test_within`] with 200 divisions for every pair of the study, 1999 and more; [`holm`]; maximal cliques of pairs below the JND
/// (C. Bron and J. Kerbosch 1973, Commun. ACM 16(9)).
///
/// Source: docs/decisions/strokes.md and docs/decisions/verification.md.
///
/// # Errors
/// [`WithheldCause`] when the vibrations are no accelerations in m/s², or their spectra do not hold the band or have other lines.
pub fn discriminate(
    settings: &[Vec<Texture>],
    config: &DiscriminationConfig,
) -> Result<AcrossSamples, WithheldCause> {
    let config = config_over(settings, config)?;
    let Distances {
        mut found,
        samples,
        units,
        mut warnings,
    } = distances(settings, &config);
    let family = permute(&mut found, &samples, &config);
    judge(&mut found, &config);
    warnings.extend(about_units(settings, &found, units, family, config.alpha));
    Ok(AcrossSamples {
        sentence: sentence(units, (family, settings.len()), &config),
        left_out_hz: Vec::new(),
        jnd_source: config.model.jnd_source(),
        settings: found,
        units,
        family,
        config,
        warnings,
    })
}

/// `config` with its model over the band that the PSDs of `settings` hold.
pub(super) fn config_over(
    settings: &[Vec<Texture>],
    config: &DiscriminationConfig,
) -> Result<DiscriminationConfig, WithheldCause> {
    let model = Model {
        band: band_of(settings, config.model.band)?,
        ..config.model.clone()
    };
    Ok(DiscriminationConfig {
        model,
        ..config.clone()
    })
}

/// The distances of all pairs, without what chance makes of them.
pub(super) struct Distances {
    pub(super) found: Vec<Groups>,
    /// The samples of every setting.
    samples: Vec<Vec<Sample>>,
    units: SampleUnit,
    warnings: Vec<Warning>,
}

pub(super) fn distances(settings: &[Vec<Texture>], config: &DiscriminationConfig) -> Distances {
    let strokes: Vec<Vec<Vec<Vec<Excitation>>>> = settings
        .iter()
        .map(|textures| excitations(textures, &config.model))
        .collect();
    let mut warnings = config.model.warnings();
    let every: Vec<&Vec<Vec<Excitation>>> = strokes.iter().flatten().collect();
    let apart = recordings_differ(&every, config);
    let units = match apart {
        Some(p_value) if p_value < POOLED_FROM => {
            warnings.push(Warning::from(ScatterWarning::Scatter {
                of: Scatter::Recordings { p_value },
            }));
            SampleUnit::Recordings
        }
        _ => SampleUnit::Strokes,
    };
    let samples: Vec<Vec<Sample>> = strokes
        .iter()
        .map(|strokes| strokes.iter().map(|s| sample(s, units)).collect())
        .collect();
    let all = settings.iter().zip(&samples);
    Distances {
        found: all
            .map(|(textures, samples)| groups(textures, samples, config))
            .collect(),
        samples,
        units,
        warnings,
    }
}

/// The excitation of every stroke, by sample and recording.
fn excitations(textures: &[Texture], model: &Model) -> Vec<Vec<Vec<Excitation>>> {
    let Some(first) = textures.first() else {
        return Vec::new();
    };
    let bins = textures
        .iter()
        .flat_map(|t| t.recordings.iter().flatten())
        .map(Vec::len)
        .max()
        .unwrap_or(0);
    let plan = ExcitationPlan::new(model, bins, first.resolution_hz);
    textures
        .iter()
        .map(|texture| {
            texture
                .recordings
                .iter()
                .filter(|strokes| !strokes.is_empty())
                .map(|strokes| strokes.iter().map(|psd| plan.of(psd)).collect())
                .collect()
        })
        .collect()
}

fn sample(recordings: &[Vec<Excitation>], units: SampleUnit) -> Sample {
    let units: Vec<Excitation> = match units {
        SampleUnit::Strokes => recordings.iter().flatten().cloned().collect(),
        SampleUnit::Recordings => recordings.iter().map(|r| Excitation::mean(r)).collect(),
    };
    Sample {
        mean: Excitation::mean(&units),
        units,
    }
}

/// The mean of the sums of the units with these indices.
pub(super) fn mean_sums(units: &[&Excitation], of: &[usize], into: &mut Vec<f64>) {
    into.clear();
    into.resize(units.first().map_or(0, |u| u.sums.len()), 0.0);
    for &i in of {
        for (sum, value) in into.iter_mut().zip(&units[i].sums) {
            *sum += value / of.len() as f64;
        }
    }
}

/// How far recordings lie from their samples, as [`chance::recordings_differ`] has it.
fn recordings_differ(
    samples: &[&Vec<Vec<Excitation>>],
    config: &DiscriminationConfig,
) -> Option<f64> {
    let counts: Vec<Vec<usize>> = samples
        .iter()
        .map(|recordings| recordings.iter().map(Vec::len).collect())
        .collect();
    let strokes: Vec<Vec<&Excitation>> = samples
        .iter()
        .map(|recordings| recordings.iter().flatten().collect())
        .collect();
    let (mut all, mut one) = (Vec::new(), Vec::new());
    chance::recordings_differ(&counts, (SHUFFLES, config.seed), |place, order, of| {
        mean_sums(&strokes[place], order, &mut all);
        mean_sums(&strokes[place], of, &mut one);
        config.model.distance_jnd(&all, &one)
    })
}

/// How far halves of the units lie apart: in the median, and in 95 % of divisions.
fn within(sample: &Sample, config: &DiscriminationConfig) -> Option<[f64; 2]> {
    let units: Vec<&Excitation> = sample.units.iter().collect();
    let (mut a, mut b) = (Vec::new(), Vec::new());
    let divisions = (HALVINGS, config.seed);
    let found = halves_apart(units.len(), divisions, |first, second| {
        mean_sums(&units, first, &mut a);
        mean_sums(&units, second, &mut b);
        config.model.distance_jnd(&a, &b)
    });
    let at = |share: f64| {
        let place = (share * (HALVINGS - 1) as f64).round() as usize;
        found.get(place).copied()
    };
    Some([at(0.5)?, at(0.95)?])
}

/// The samples of one setting, pair by pair, before probabilities are adjusted.
fn groups(textures: &[Texture], samples: &[Sample], config: &DiscriminationConfig) -> Groups {
    let within: Vec<Option<[f64; 2]>> = samples.iter().map(|s| within(s, config)).collect();
    let mut pairs = Vec::new();
    for a in 0..samples.len() {
        for b in a + 1..samples.len() {
            pairs.push(pair(
                [(a, &samples[a], within[a]), (b, &samples[b], within[b])],
                config,
            ));
        }
    }
    Groups {
        setting: String::new(),
        names: textures.iter().map(|t| t.name.clone()).collect(),
        units: samples.iter().map(|s| s.units.len()).collect(),
        within_jnd: within.iter().map(|w| w.map(|w| w[0])).collect(),
        pairs,
        below_jnd: Vec::new(),
    }
}

fn pair(
    [(a, first, within_a), (b, second, within_b)]: [(usize, &Sample, Option<[f64; 2]>); 2],
    config: &DiscriminationConfig,
) -> Pair {
    let model = &config.model;
    let several = first.units.len() > 1 && second.units.len() > 1;
    let scales = [Evidence::Apart(
        [first, second].map(|s| Units::independent(s.units.clone())),
    )];
    let scales = if several { &scales[..] } else { &[] };
    let found = differences(&first.mean, &second.mean, model, scales);
    let distance: Difference = found.largest();
    let interval_jnd = several.then_some([distance.low_jnd, distance.high_jnd]);
    let against = |what, limit| match interval_jnd {
        Some(interval) => Criterion::new(what, "JND", distance.jnd, Some(interval), limit),
        // One stroke has no interval: it is not exact, but unknown.
        None => Criterion {
            found: Some(distance.jnd),
            ..Criterion::unmeasured(what, "JND", limit)
        },
    };
    let largest = match (within_a, within_b) {
        (Some(a), Some(b)) => a[1].max(b[1]),
        _ => 0.0,
    };
    Pair {
        a,
        b,
        distance_jnd: distance.jnd,
        interval_jnd,
        parts_jnd: [found.spectrum.jnd, found.level.jnd, found.balance.jnd],
        permuted: None,
        p_adjusted: None,
        felt_in: Vec::new(),
        neither_felt: first.mean.total() <= 1.0 && second.mean.total() <= 1.0,
        criteria: vec![
            against(PairCriterion::JustNoticeableDifference, model.limit()),
            against(PairCriterion::DistanceWithin, Limit::at_most(largest)),
        ],
        outcome: Distinguishability::NotDecided,
    }
}

/// Adjusts the probabilities over all pairs of samples, and decides.
fn judge(found: &mut [Groups], config: &DiscriminationConfig) {
    let places: Vec<Vec<(usize, usize)>> = by_name(found).into_values().collect();
    // A pair without a test counts as one that shows nothing.
    let p_value = |places: &Vec<(usize, usize)>| {
        let mut tests = places.iter();
        let tested = tests.find_map(|(setting, place)| found[*setting].pairs[*place].permuted);
        tested.map_or(1.0, |p| p.p_value)
    };
    let all: Vec<f64> = places.iter().map(p_value).collect();
    let limit = Limit::AtMost {
        met: config.alpha,
        not_met: 1.0,
    };
    for (places, p) in places.iter().zip(holm(&all)) {
        for (setting, place) in places {
            let pair = &mut found[*setting].pairs[*place];
            pair.p_adjusted = pair.permuted.map(|_| p);
            pair.criteria.push(match pair.p_adjusted {
                Some(p) => Criterion::new(PairCriterion::Chance, "", p, None, limit),
                None => Criterion::unmeasured(PairCriterion::Chance, "", limit),
            });
            pair.outcome = Distinguishability::of(&pair.criteria);
        }
    }
    for groups in found {
        groups.below_jnd = below_jnd(groups);
    }
}

/// The largest sets of two and more in which every pair is below the just-noticeable difference.
pub(super) fn below_jnd(groups: &Groups) -> Vec<Vec<usize>> {
    let near: Vec<Vec<usize>> = (0..groups.names.len())
        .map(|i| {
            let below = |j: &usize| {
                *j != i
                    && groups
                        .pair(i, *j)
                        .is_some_and(|p| p.outcome == Distinguishability::BelowJnd)
            };
            (0..groups.names.len()).filter(below).collect()
        })
        .collect();
    let mut sets = Vec::new();
    maximal(
        &near,
        &mut Vec::new(),
        (0..groups.names.len()).collect(),
        Vec::new(),
        &mut sets,
    );
    sets.retain(|set| set.len() > 1);
    sets.sort();
    sets
}

/// The warnings about too few strokes or recordings.
fn about_units(
    settings: &[Vec<Texture>],
    found: &[Groups],
    units: SampleUnit,
    family: usize,
    alpha: f64,
) -> Vec<Warning> {
    let mut warnings = Vec::new();
    let names = |of: &dyn Fn(&Texture) -> bool| -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for texture in settings.iter().flatten().filter(|t| of(t)) {
            if !names.contains(&texture.name) {
                names.push(texture.name.clone());
            }
        }
        names
    };
    let strokes = |t: &Texture| t.recordings.iter().map(Vec::len).sum::<usize>();
    let single = names(&|t| strokes(t) == 1);
    if !single.is_empty() {
        warnings.push(Warning::from(FewWarning::Few {
            found: 1,
            recommended: 10,
            what: Few::StrokesOfSample { samples: single },
        }));
    }
    let alone = names(&|t| t.recordings.len() == 1 && strokes(t) > 1);
    if !alone.is_empty() {
        warnings.push(Warning::from(FewWarning::Few {
            found: 1,
            recommended: 2,
            what: Few::RecordingsOfSample { samples: alone },
        }));
    }
    // Pairs of several units each that no division could show anything of.
    let mute = by_name(found).into_values().filter_map(|places| {
        let units = places.iter().map(|(setting, place)| {
            let pair = &found[*setting].pairs[*place];
            [pair.a, pair.b].map(|i| found[*setting].units[i])
        });
        let units: Vec<[usize; 2]> = units.filter(|[a, b]| *a.min(b) > 1).collect();
        let least: f64 = units.iter().map(|[a, b]| smallest_p(*a, *b)).product();
        let fewest = units.iter().map(|[a, b]| *a.min(b)).min()?;
        (least * family as f64 > alpha).then_some((fewest, units.len()))
    });
    if let Some((found, settings)) = mute.min() {
        warnings.push(Warning::from(FewWarning::Few {
            found,
            recommended: units_needed(family, settings, alpha),
            what: Few::Units {
                unit: units.word().into(),
                pairs: family,
            },
        }));
    }
    warnings
}

/// All maximal sets in which everyone is near everyone: `chosen` with any of `open`, none of `done`.
fn maximal(
    near: &[Vec<usize>],
    chosen: &mut Vec<usize>,
    mut open: Vec<usize>,
    mut done: Vec<usize>,
    found: &mut Vec<Vec<usize>>,
) {
    if open.is_empty() && done.is_empty() {
        let mut group = chosen.clone();
        group.sort_unstable();
        found.push(group);
        return;
    }
    // Sets that leave out one neighbour of a pivot hold the pivot, or another of its strangers.
    let shared = |i: &usize| open.iter().filter(|j| near[*i].contains(j)).count();
    let pivot = open.iter().chain(&done).copied().max_by_key(shared);
    let strangers: Vec<usize> = open
        .iter()
        .copied()
        .filter(|i| pivot.is_none_or(|pivot| !near[pivot].contains(i)))
        .collect();
    for i in strangers {
        let of = |all: &[usize]| {
            all.iter()
                .copied()
                .filter(|j| near[i].contains(j))
                .collect()
        };
        chosen.push(i);
        maximal(near, chosen, of(&open), of(&done), found);
        chosen.pop();
        open.retain(|j| *j != i);
        done.push(i);
    }
}
