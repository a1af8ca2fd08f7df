//! The strokes of several recordings taken together: one sample, one speed, one participant.

use std::collections::BTreeMap;

use crate::compare::{CompareWarning, Mixed};
use serde::Serialize;

use super::CompareError;
use super::{ReceptorLevel, receptor_levels};
use crate::feature::{
    Analysis, Peak, RECOMMENDED_STROKES, STROKE_COLUMNS, Statistics, StrokeFeatures, StrokeSpectra,
    peaks, peaks_above,
};
use crate::quantity::{Band, Hertz, Unit};
use crate::recording::Condition;
use crate::warning::{Few, FewWarning, Scatter, ScatterWarning, Warning};

/// The ridges of a fingertip are this far apart, m: the widest range of the literature.
const RIDGES_M: std::ops::RangeInclusive<f64> = 0.3e-3..=0.8e-3;
/// A peak where one is expected stands out by at least this, dB.
const EXPECTED_DB: f64 = 3.0;
/// A peak this far from where it is expected belongs there, as a share.
const NEAR: f64 = 0.12;

/// Speeds (and loads) whose ratio is above this are different ones.
const OTHER_SPEED: f64 = 1.1;

/// The frequency that the ridges of the finger make, f = v/λ, and what was found of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Fingerprint {
    /// Where it is expected, Hz; absent while the ridges' wavelength is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub expected_hz: Option<f64>,
    /// The peak that was found in its range, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub found_hz: Option<f64>,
    /// The wavelength that this peak speaks for, λ = v/f, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub ridge_wavelength_m: Option<f64>,
}

/// One tooth of the comb that a periodic texture makes, f = n·v/λ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Tooth {
    /// n.
    pub order: usize,
    /// n·v/λ, Hz.
    pub expected_hz: f64,
    /// The peak near it, Hz.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub found_hz: Option<f64>,
}

/// Summary of the strokes of one group. Statistics are over strokes; `u` is the unit of the vibration.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct Summary {
    /// The condition that they have in common.
    pub name: String,
    /// The number of recordings.
    pub recordings: usize,
    /// The number of strokes.
    pub strokes: usize,
    /// The unit of the vibration.
    pub unit: Unit,
    /// Length of the strokes, s.
    pub duration_s: Statistics,
    /// Rms, u.
    pub rms: Statistics,
    /// Rms of each stroke, u.
    #[serde(skip)]
    pub rms_each: Vec<f64>,
    /// Largest departure from the mean, u.
    pub peak: Statistics,
    /// Peak over rms.
    pub crest_factor: Statistics,
    /// The numbers of strokes that have a heading in reports ([`STROKE_COLUMNS`]), by name.
    pub features: BTreeMap<&'static str, Statistics>,
    /// Mean power in the bands of the four mechanoreceptors, u²; absent for a band that some recording does not hold.
    pub receptor_power: [Option<f64>; 4],
    /// Mean frequency of the power, Hz.
    pub centroid_hz: Statistics,
    /// Its spread, Hz.
    pub spread_hz: Statistics,
    /// Friction coefficient: of the means of the strokes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub friction_coefficient: Option<Statistics>,
    /// Mean friction coefficient of each stroke that has one.
    #[serde(skip)]
    pub friction_each: Vec<f64>,
    /// Normal force, N: of the means of the strokes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub normal_force_n: Option<Statistics>,
    /// Speed, m/s: of the means of the strokes, or what the recordings state.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_m_s: Option<Statistics>,
    /// Pacinian-weighted power, multiples of threshold power.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pacinian_power: Option<Statistics>,
    /// Detection-threshold-weighted power, multiples of threshold power.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub detection_power: Option<Statistics>,
    /// The levels re the thresholds of mechanoreceptors; empty for what is no acceleration.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub receptors: Vec<ReceptorLevel>,
    /// The strongest line of the mean PSD in the band, Hz.
    pub strongest_hz: f64,
    /// Peaks of the mean PSD.
    pub peaks: Vec<Peak>,
    /// Lines that every sample has and that do not move with the speed, Hz: the machine's; see [`super::common_lines`].
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub machine_lines_hz: Vec<f64>,
    /// Lines that may not be the texture's, Hz: the machine's, those that all samples have at this speed, and those of the mains.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lines_in_doubt_hz: Vec<f64>,
    /// The share of the power of the mean PSD that lies around them.
    #[serde(skip_serializing_if = "is_zero")]
    pub share_in_doubt: f64,
    /// The share of the power of the strokes that is there while nothing is touched too: the noise of the sensor; 0 without a rest.
    #[serde(skip)]
    pub share_at_rest: f64,
    /// The finger's own frequency; absent while the speed is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fingerprint: Option<Fingerprint>,
    /// The texture's comb; absent for a texture without a known period.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub comb: Vec<Tooth>,
    /// PSDs of the strokes, u²/Hz; in documents their mean and standard deviation.
    pub psd: StrokeSpectra,
    /// What a person should know before relying on it; written with those of one kind as one.
    #[serde(serialize_with = "crate::warning::serialize_merged")]
    pub warnings: Vec<Warning>,
}

fn is_zero(share: &f64) -> bool {
    *share == 0.0
}

impl Summary {
    /// The mean rms without the lines that may not be the texture's, u.
    pub(super) fn rms_without_lines(&self) -> f64 {
        self.rms.mean * (1.0 - self.share_in_doubt).max(0.0).sqrt()
    }

    /// The mean rms without what is there while nothing is touched, u.
    pub(super) fn rms_without_rest(&self) -> f64 {
        self.rms.mean * (1.0 - self.share_at_rest).max(0.0).sqrt()
    }
}

/// Known spatial periods of finger and texture; lengths in m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Periods {
    /// The wavelength of the finger's ridges.
    pub ridge_m: Option<f64>,
    /// The wavelength of the texture.
    pub texture_m: Option<f64>,
}

/// The strokes of `members`, each with its condition, taken together under `name`.
///
/// Formula: mean, standard deviation and median over strokes; PSDs averaged in power.
///
/// Source: L. Felicetti's thesis (2024), section 3.1: averages over at least ten strokes.
///
/// # Errors
/// [`CompareError::Nothing`] without strokes; [`CompareError::NotTogether`] when units or lines differ.
pub fn summarise(
    name: &str,
    members: &[(&Analysis, &Condition)],
    periods: Periods,
) -> Result<Summary, CompareError> {
    let Some((first, _)) = members.first() else {
        return Err(CompareError::Nothing);
    };
    require_together(first, members)?;
    let strokes: Vec<&StrokeFeatures> = members.iter().flat_map(|(a, _)| &a.strokes).collect();
    let over = |value: &dyn Fn(&StrokeFeatures) -> f64| -> Result<Statistics, CompareError> {
        let mut values: Vec<f64> = strokes.iter().map(|s| value(s)).collect();
        Statistics::of(&mut values).ok_or(CompareError::Nothing)
    };
    let over_some = |value: &dyn Fn(&StrokeFeatures) -> Option<f64>| {
        let mut values: Vec<f64> = strokes.iter().filter_map(|s| value(s)).collect();
        Statistics::of(&mut values)
    };
    let receptor_power = [0, 1, 2, 3].map(|i| {
        let powers: Option<Vec<f64>> = strokes.iter().map(|s| s.receptor_power[i]).collect();
        powers.map(|powers| crate::statistics::mean(&powers))
    });
    let measured = over_some(&|s| s.speed_m_s.map(|v| v.mean));
    let speed_m_s = measured.or_else(|| {
        let mut stated: Vec<f64> = members.iter().filter_map(|(_, c)| c.speed_m_s).collect();
        Statistics::of(&mut stated)
    });
    let psd = match members {
        [(only, _)] => only.psd.clone(),
        several => {
            let each = several.iter().flat_map(|(a, _)| &a.psd.each);
            let (resolution_hz, unit) = (first.psd.resolution_hz, first.psd.unit.clone());
            StrokeSpectra::over(each.cloned().collect(), resolution_hz, unit)
        }
    };
    let band = first.config.band;
    let found = peaks(&psd.mean, psd.resolution_hz, band);
    let comb = match (speed_m_s, periods.texture_m) {
        (Some(speed), Some(wavelength_m)) => comb(&found, speed.mean, wavelength_m, band.high()),
        _ => Vec::new(),
    };
    let rms = over(&|s| s.rms)?;
    let warnings = warnings(name, strokes.len(), &pooled(members, speed_m_s), &rms);
    Ok(Summary {
        name: name.into(),
        recordings: members.len(),
        strokes: strokes.len(),
        unit: first.unit.clone(),
        duration_s: over(&|s| s.duration_s)?,
        rms,
        rms_each: strokes.iter().map(|s| s.rms).collect(),
        peak: over(&|s| s.peak)?,
        crest_factor: over(&|s| s.crest_factor)?,
        features: STROKE_COLUMNS
            .iter()
            .filter(|column| column.heading.is_some())
            .filter_map(|column| Some((column.name, over_some(&column.value)?)))
            .collect(),
        receptor_power,
        centroid_hz: over(&|s| s.centroid_hz)?,
        spread_hz: over(&|s| s.spread_hz)?,
        friction_coefficient: over_some(&|s| s.friction_coefficient.map(|v| v.mean)),
        friction_each: (strokes.iter())
            .filter_map(|s| s.friction_coefficient.map(|v| v.mean))
            .collect(),
        normal_force_n: over_some(&|s| s.normal_force_n.map(|v| v.mean)),
        pacinian_power: over_some(&|s| s.pacinian_power),
        detection_power: over_some(&|s| s.detection_power),
        receptors: receptor_levels(members),
        strongest_hz: strongest(&psd, band),
        machine_lines_hz: Vec::new(),
        lines_in_doubt_hz: Vec::new(),
        share_in_doubt: 0.0,
        share_at_rest: share_at_rest(members),
        fingerprint: speed_m_s.map(|speed| match periods.ridge_m {
            // At its expected frequency a smaller peak is accepted.
            Some(_) => {
                let low = peaks_above(&psd.mean, psd.resolution_hz, band, EXPECTED_DB);
                fingerprint(&low, &comb, speed.mean, periods.ridge_m)
            }
            None => fingerprint(&found, &comb, speed.mean, None),
        }),
        comb,
        speed_m_s,
        peaks: found,
        psd,
        warnings,
    })
}

/// The share of the power of the strokes that stands in the rests of the same recordings, of those that have some.
fn share_at_rest(members: &[(&Analysis, &Condition)]) -> f64 {
    let with_rest = members
        .iter()
        .filter_map(|(analysis, _)| Some((analysis.rest_psd.as_ref()?, analysis)));
    let (mut at_rest, mut all) = (0.0, 0.0);
    for (rest, analysis) in with_rest {
        let strokes = analysis.strokes.len() as f64;
        at_rest += strokes * rest.iter().sum::<f64>();
        all += strokes * analysis.psd.mean.iter().sum::<f64>();
    }
    match at_rest > 0.0 && all > 0.0 {
        true => (at_rest / all).min(1.0),
        false => 0.0,
    }
}

/// Whether the PSDs of `members` can be averaged with the first's.
fn require_together(
    first: &Analysis,
    members: &[(&Analysis, &Condition)],
) -> Result<(), CompareError> {
    for (other, _) in members {
        if other.unit != first.unit {
            return Err(CompareError::NotTogether {
                what: "the unit of the vibration",
                one: first.unit.to_string(),
                other: other.unit.to_string(),
            });
        }
        let (a, b) = (first.psd.resolution_hz, other.psd.resolution_hz);
        if (a / b - 1.0).abs() > 1e-3 || first.psd.mean.len() != other.psd.mean.len() {
            return Err(CompareError::NotTogether {
                what: "the step between the lines of the PSDs",
                one: format!("{a:.4} Hz"),
                other: format!("{b:.4} Hz"),
            });
        }
    }
    Ok(())
}

/// The warnings about `strokes` that are averaged although they differ in what is `pooled`, or in their `rms`.
fn warnings(name: &str, strokes: usize, pooled: &[&str], rms: &Statistics) -> Vec<Warning> {
    let mut warnings = Vec::new();
    if strokes < RECOMMENDED_STROKES {
        warnings.push(Warning::from(FewWarning::Few {
            found: strokes,
            recommended: RECOMMENDED_STROKES,
            what: Few::Strokes { group: name.into() },
        }));
    }
    warnings.extend(pooled.iter().map(|what| {
        Warning::from(CompareWarning::Mixed {
            how: Mixed::Pooled {
                group: name.into(),
                what: (*what).into(),
            },
        })
    }));
    if rms.sd > 0.5 * rms.mean && pooled.is_empty() {
        warnings.push(Warning::from(ScatterWarning::Scatter {
            of: Scatter::Strokes {
                group: name.into(),
                share: rms.sd / rms.mean,
            },
        }));
    }
    warnings
}

/// In what recordings that are averaged together differ: speed, samples, touch, participants or load.
fn pooled(members: &[(&Analysis, &Condition)], speed_m_s: Option<Statistics>) -> Vec<&'static str> {
    let mut stated: Vec<f64> = members.iter().filter_map(|(_, c)| c.speed_m_s).collect();
    stated.sort_by(f64::total_cmp);
    let apart = match stated.as_slice() {
        [slowest, .., fastest] => *fastest > OTHER_SPEED * slowest,
        _ => false,
    };
    let scattered = speed_m_s.is_some_and(|s| s.sd > 0.25 * s.mean);
    let touch = members
        .windows(2)
        .any(|pair| pair[0].1.touch != pair[1].1.touch);
    let mut differ = Vec::new();
    if apart || scattered {
        differ.push("speed");
    }
    if members
        .windows(2)
        .any(|pair| pair[0].1.sample != pair[1].1.sample)
    {
        differ.push("samples");
    }
    if touch {
        differ.push("touch (active and passive)");
    }
    if members
        .windows(2)
        .any(|pair| pair[0].1.participant != pair[1].1.participant)
    {
        differ.push("participants");
    }
    let mut loads: Vec<f64> = members
        .iter()
        .filter_map(|(_, c)| Some(c.load_n?.0))
        .collect();
    loads.sort_by(f64::total_cmp);
    if let [lightest, .., heaviest] = loads.as_slice()
        && *heaviest > OTHER_SPEED * lightest
    {
        differ.push("load");
    }
    differ
}

fn strongest(psd: &StrokeSpectra, band: Band) -> f64 {
    let lines = psd
        .mean
        .iter()
        .enumerate()
        .map(|(k, p)| (k as f64 * psd.resolution_hz, p));
    lines
        .filter(|(f, _)| band.contains(*f))
        .max_by(|a, b| a.1.total_cmp(b.1))
        .map_or(0.0, |(f, _)| f)
}

/// The peak of the finger's ridges is not assigned to the texture, unless the texture's frequency is known.
fn fingerprint(
    found: &[Peak],
    comb: &[Tooth],
    speed_m_s: f64,
    ridge_m: Option<f64>,
) -> Fingerprint {
    let expected_hz = ridge_m.map(|ridge_m| speed_m_s / ridge_m);
    let belongs = |peak: &&Peak| match expected_hz {
        Some(expected_hz) => (peak.frequency_hz / expected_hz - 1.0).abs() <= NEAR,
        None => {
            let of_texture = |tooth: &Tooth| tooth.found_hz == Some(peak.frequency_hz);
            RIDGES_M.contains(&(speed_m_s / peak.frequency_hz)) && !comb.iter().any(of_texture)
        }
    };
    let found_hz = found
        .iter()
        .filter(|peak| peak.harmonic == 1)
        .find(belongs)
        .map(|peak| peak.frequency_hz);
    Fingerprint {
        expected_hz,
        found_hz,
        ridge_wavelength_m: found_hz.map(|hz| speed_m_s / hz),
    }
}

fn comb(found: &[Peak], speed_m_s: f64, wavelength_m: f64, highest: Hertz) -> Vec<Tooth> {
    (1..=10)
        .map(|order| (order, order as f64 * speed_m_s / wavelength_m))
        .take_while(|(_, expected_hz)| *expected_hz <= highest.0)
        .map(|(order, expected_hz)| Tooth {
            order,
            expected_hz,
            found_hz: found
                .iter()
                .map(|peak| peak.frequency_hz)
                .filter(|hz| (hz / expected_hz - 1.0).abs() <= NEAR / order as f64)
                .min_by(|a, b| (a - expected_hz).abs().total_cmp(&(b - expected_hz).abs())),
        })
        .collect()
}
