//! The spatial period of a surface (or of a fingerprint) from sliding at several speeds: f = v/λ.

use crate::compare::CompareDoubt;
use serde::{Deserialize, Serialize};

use crate::criterion::{Criterion, Limit, Outcome};
use crate::doubt::Doubt;
use crate::feature::vertex;
use crate::fourier::RealTransform;
use crate::quantity::{Hertz, SampleRate};
use crate::spectrum::{Symmetry, Window};
use crate::statistics::{mean, standard_deviation, t_quantile};

/// One speed: what was recorded while sliding at it.
#[derive(Clone, Debug)]
pub struct Sliding<'a> {
    /// The speed, m/s.
    pub speed_m_s: f64,
    /// The rate.
    pub rate: SampleRate,
    /// The condition shared with other recordings apart from the speed, such as the load: recordings of one group are repeats.
    pub group: String,
    /// Every stroke of every channel.
    pub stretches: Vec<&'a [f64]>,
}

/// The peak that belongs to the common period at one speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SpeedPeak {
    /// The speed, m/s.
    pub speed_m_s: f64,
    /// The frequency of the peak, Hz.
    pub frequency_hz: f64,
    /// How far it stands above the background, dB.
    pub prominence_db: f64,
}

/// The units over which the interval of a period is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum PeriodUnit {
    /// Groups, such as loads: there are two or more.
    Groups,
    /// Single recordings of one group.
    Recordings,
}

/// The criteria for a spatial period.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum PeriodCriterion {
    /// How far it stands above the background in the mean over speeds.
    Prominence,
    /// The share of the speeds that have a peak there.
    Speeds,
    /// Its level above the background at the speed where it is lowest: a line at a fixed frequency is high at one speed and would
    /// raise the mean.
    EverySpeed,
    /// How often it fits into the shortest stroke.
    Cycles,
    /// Its level above the background in the group where it is lowest.
    EveryGroup,
}

/// The period found in one group.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct GroupPeriod {
    /// Which.
    pub group: String,
    /// The period that its own spectra agree on best, m.
    pub strongest_m: f64,
    /// How far the common period stands above its background, dB …
    pub prominence_db: f64,
    /// … and how far it has to, dB.
    pub needed_db: f64,
    /// The mean period of its recordings' peaks near the common one, m; absent where none has a peak.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period_m: Option<f64>,
}

/// A spatial period that the spectra at all speeds agree on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schemas", derive(schemars::JsonSchema))]
pub struct SpatialPeriod {
    /// The period, m.
    pub period_m: f64,
    /// Its 95 % confidence interval over `units`, m; absent for fewer than two.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval_m: Option<[f64; 2]>,
    /// What the interval is over.
    pub over: PeriodUnit,
    /// How many of them there are.
    pub units: usize,
    /// The peak at each speed.
    pub peaks: Vec<SpeedPeak>,
    /// How far the period stands above the background in the mean over speeds, dB.
    pub prominence_db: f64,
    /// The results of every group, if there are two or more.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub groups: Vec<GroupPeriod>,
    /// The criteria and their outcomes.
    pub criteria: Vec<Criterion<PeriodCriterion>>,
    /// What a person should know before relying on it.
    pub doubts: Vec<Doubt>,
}

impl SpatialPeriod {
    /// Whether it is a period: met, not met, or not decided.
    #[must_use]
    pub fn outcome(&self) -> Outcome {
        Outcome::of_all(self.criteria.iter().map(|criterion| criterion.outcome))
    }

    /// Whether the groups show different periods.
    #[must_use]
    pub fn jumps(&self) -> bool {
        self.leaves_open(PeriodCriterion::EveryGroup)
    }

    /// Whether it stands out of the noise at some of the speeds only.
    #[must_use]
    pub fn missed_at_a_speed(&self) -> bool {
        self.leaves_open(PeriodCriterion::EverySpeed)
    }

    fn leaves_open(&self, rule: PeriodCriterion) -> bool {
        let mut criteria = self.criteria.iter();
        criteria.any(|c| c.what == rule && c.outcome == Outcome::NotDecided)
    }
}

/// Zeros that a stretch is continued with, as a multiple of its length, so that lines are fine enough.
const PADDING: usize = 8;
/// Spectra are compared on lines this far apart, as a ratio.
const STEP: f64 = 1.001;
/// The peak of one speed is looked for this far from v/λ, as a share of it.
const REACH: f64 = 0.1;
/// The least level of a period above the background, dB …
const PROMINENT_DB: f64 = 6.0;
/// … nor is what noise reaches: the level of one periodogram's line scatters by this, dB, and the highest of a
/// thousand lines lies this many standard deviations up.
const SCATTER_DB: f64 = 5.57;
const HIGHEST_OF_MANY: f64 = 4.0;
/// The same for the few lines close to a period.
const HIGHEST_OF_FEW: f64 = 2.5;
/// The same for the lines close to a period at one speed, in standard deviations.
const HIGHEST_AT_A_SPEED: f64 = 3.0;
/// Close to a period is within this ratio of it.
const NEAR: f64 = 1.03;
/// The least level of a peak at one speed above the background, dB.
const PEAK_DB: f64 = 3.0;
/// A period that fits less often than this into a stroke may be the stroke's own shape.
const CYCLES: f64 = 3.0;
/// Speeds that differ by less than this share are one speed.
const SAME_SPEED: f64 = 0.01;

/// Lines above this in a spectrum of one speed, for any length.
struct Spectrum {
    speed_m_s: f64,
    /// 1/m, in steps of [`STEP`].
    wavenumbers: Vec<f64>,
    /// The mean level of all stretches, dB, and what it stands above its background by, dB.
    level_db: Vec<f64>,
    prominence_db: Vec<f64>,
    /// Stretches that were averaged.
    stretches: f64,
    /// The way that the longest of them is, m.
    length_m: f64,
}

/// The spatial period on which the spectra of `slidings` agree: the wavenumber f/v that stands highest above its
/// background in the mean over speeds; the geometric mean of the v/f of the recordings' own peaks there.
/// `None` when no stretch is long enough, or no speed is above zero.
///
/// It is not decided whether it is one where groups or speeds do not all show it, or where it fits into a stroke fewer than three
/// times. The interval is over what was repeated: over groups, such as loads, where there are two or more, else over
/// recordings. How sharp a pooled line is says nothing of how far repeats lie apart.
///
/// Formula: periodograms of whole stretches (Hann), averaged in dB over stretches and channels; background: the
/// running median; ln λ = Σw·ln(v/f) over the recordings of a group with w ∝ v² (peaks are read with the same error in Hz), and
/// the plain mean over groups; the interval ± t·s·√Σw², s the standard deviation of ln(v/f) over units, Student's t with n − 1
/// degrees of freedom.
///
/// Below `lowest` nothing is looked for: what a filter has taken away there has a slope and no period. Recordings of
/// one speed count as one where the period is looked for.
///
/// Source: f = v/λ, as used for fingerprints and ridged boards by J. Scheibert et al. (2009), Science 323(5920).
#[must_use]
pub fn spatial_period(slidings: &[Sliding<'_>], lowest: Hertz) -> Option<SpatialPeriod> {
    let spectra = by_speed(slidings.iter(), lowest);
    let (wavenumber, prominence_db) = agreed(&spectra)?;
    let peaks: Vec<SpeedPeak> = spectra.iter().filter_map(|s| s.peak(wavenumber)).collect();
    let mut names: Vec<&str> = slidings.iter().map(|s| s.group.as_str()).collect();
    names.sort_unstable();
    names.dedup();
    // The logarithm of the period of every recording that has a peak there, and its weight, by group.
    let logs: Vec<Vec<(f64, f64)>> = names
        .iter()
        .map(|name| {
            let own = slidings.iter().filter(|s| s.group == *name);
            let peaks = own.filter_map(|s| spectrum(s, lowest)?.peak(wavenumber));
            peaks
                .map(|p| ((p.speed_m_s / p.frequency_hz).ln(), p.speed_m_s.powi(2)))
                .collect()
        })
        .collect();
    let means: Vec<Option<f64>> = logs
        .iter()
        .map(|logs| (!logs.is_empty()).then(|| weighted(logs).0))
        .collect();
    let groups: Vec<GroupPeriod> = match names.as_slice() {
        [_] => Vec::new(),
        names => names
            .iter()
            .zip(&means)
            .filter_map(|(name, own)| {
                let spectra = by_speed(slidings.iter().filter(|s| s.group == *name), lowest);
                let (strongest, _) = agreed(&spectra)?;
                Some(GroupPeriod {
                    group: (*name).to_owned(),
                    strongest_m: 1.0 / strongest,
                    prominence_db: prominence_near(&spectra, wavenumber),
                    needed_db: noise_db(HIGHEST_OF_FEW, &spectra),
                    period_m: own.map(f64::exp),
                })
            })
            .collect(),
    };
    let (over, units): (_, Vec<(f64, f64)>) = match means.iter().flatten().count() {
        0 | 1 => (PeriodUnit::Recordings, logs.concat()),
        _ => {
            let groups = means.into_iter().flatten();
            (PeriodUnit::Groups, groups.map(|log| (log, 1.0)).collect())
        }
    };
    if units.is_empty() {
        return None;
    }
    let (log, interval) = weighted(&units);
    let period_m = log.exp();
    let interval_m = interval.map(|interval| interval.map(f64::exp));
    let shortest_m = spectra.iter().map(|s| s.length_m).fold(f64::MAX, f64::min);
    let mut criteria = vec![
        Criterion::new(
            PeriodCriterion::Prominence,
            "dB",
            prominence_db,
            None,
            Limit::at_least(noise_db(HIGHEST_OF_MANY, &spectra)),
        ),
        Criterion::new(
            PeriodCriterion::Speeds,
            "",
            peaks.len() as f64 / spectra.len() as f64,
            None,
            Limit::at_least(1.0),
        ),
        Criterion::new(
            PeriodCriterion::Cycles,
            "",
            shortest_m / period_m,
            None,
            Limit::AtLeast {
                met: CYCLES,
                not_met: 0.0,
            },
        ),
    ];
    let at_speed = |s: &Spectrum| {
        let needed_db = PEAK_DB.max(HIGHEST_AT_A_SPEED * SCATTER_DB / s.stretches.sqrt());
        (
            prominence_near(std::slice::from_ref(s), wavenumber),
            needed_db,
        )
    };
    let weakest = spectra
        .iter()
        .map(at_speed)
        .min_by(|a, b| (a.0 - a.1).total_cmp(&(b.0 - b.1)));
    if let Some((found_db, needed_db)) = weakest {
        criteria.push(Criterion::new(
            PeriodCriterion::EverySpeed,
            "dB",
            found_db,
            None,
            Limit::AtLeast {
                met: needed_db,
                not_met: f64::MIN,
            },
        ));
    }
    let missing = |group: &&GroupPeriod| group.needed_db - group.prominence_db;
    let least = groups
        .iter()
        .max_by(|a, b| missing(a).total_cmp(&missing(b)));
    if let Some(least) = least {
        // A group that does not show it leaves it open.
        let limit = Limit::AtLeast {
            met: least.needed_db,
            not_met: f64::MIN,
        };
        let found = least.prominence_db;
        criteria.push(Criterion::new(
            PeriodCriterion::EveryGroup,
            "dB",
            found,
            None,
            limit,
        ));
    }
    let mut found = SpatialPeriod {
        period_m,
        interval_m,
        over,
        units: units.len(),
        peaks,
        prominence_db,
        groups,
        criteria,
        doubts: Vec::new(),
    };
    if found.outcome() != Outcome::Met {
        found
            .doubts
            .push(Doubt::from(CompareDoubt::NoCommonPeriod { prominence_db }));
    }
    if interval_m.is_none() {
        found.doubts.push(Doubt::from(CompareDoubt::NoInterval {
            what: "the spatial period".into(),
            groups: units.len(),
        }));
    }
    Some(found)
}

/// The weighted mean of values, each with its weight, and its 95 % confidence interval: θ ± t·s·√Σw², s the standard
/// deviation of the values, t with n − 1 degrees of freedom.
fn weighted(values: &[(f64, f64)]) -> (f64, Option<[f64; 2]>) {
    let all: f64 = values.iter().map(|(_, weight)| weight).sum();
    let middle = values
        .iter()
        .map(|(value, weight)| value * weight)
        .sum::<f64>()
        / all;
    let squares: f64 = values
        .iter()
        .map(|(_, weight)| (weight / all).powi(2))
        .sum();
    let n = values.len() as f64;
    let plain: Vec<f64> = values.iter().map(|(value, _)| *value).collect();
    let deviation = standard_deviation(&plain) * (n / (n - 1.0)).sqrt();
    let interval = t_quantile(values.len().saturating_sub(1)).map(|t| {
        let reach = t * deviation * squares.sqrt();
        [middle - reach, middle + reach]
    });
    (middle, interval)
}

/// What noise does not reach, dB: `deviations` above the mean of as many stretches as `spectra` hold.
fn noise_db(deviations: f64, spectra: &[Spectrum]) -> f64 {
    let averaged: f64 = spectra.iter().map(|s| s.stretches).sum();
    PROMINENT_DB.max(deviations * SCATTER_DB / averaged.sqrt())
}

/// How far the mean over `spectra` stands above the background close to a wavenumber, dB.
fn prominence_near(spectra: &[Spectrum], wavenumber: f64) -> f64 {
    let reach = (NEAR.ln() / STEP.ln()) as i32;
    (-reach..=reach)
        .map(|i| {
            let near = wavenumber * STEP.powi(i);
            spectra.iter().map(|s| s.at(near)).sum::<f64>() / spectra.len() as f64
        })
        .fold(f64::MIN, f64::max)
}

/// One spectrum for each speed.
fn by_speed<'a, 's: 'a>(
    slidings: impl Iterator<Item = &'a Sliding<'s>>,
    lowest: Hertz,
) -> Vec<Spectrum> {
    let mut speeds: Vec<Sliding<'s>> = Vec::new();
    for sliding in slidings {
        let same = |other: &&mut Sliding<'s>| {
            (other.speed_m_s / sliding.speed_m_s - 1.0).abs() < SAME_SPEED
                && (other.rate.hz() / sliding.rate.hz() - 1.0).abs() < SAME_SPEED
        };
        match speeds.iter_mut().find(same) {
            Some(known) => known.stretches.extend(&sliding.stretches),
            None => speeds.push(sliding.clone()),
        }
    }
    speeds.iter().filter_map(|s| spectrum(s, lowest)).collect()
}

/// The wavenumber that stands highest above the background in the mean over `spectra`, 1/m, and how far, dB.
fn agreed(spectra: &[Spectrum]) -> Option<(f64, f64)> {
    let low = spectra.iter().map(|s| s.wavenumbers[0]).fold(0.0, f64::max);
    let high = spectra
        .iter()
        .filter_map(|s| s.wavenumbers.last())
        .copied()
        .fold(f64::MAX, f64::min);
    if spectra.is_empty() || low * STEP >= high {
        return None;
    }
    let lines = ((high / low).ln() / STEP.ln()) as usize;
    (0..lines)
        .map(|i| low * STEP.powi(i as i32))
        .map(|wavenumber| {
            let sum: f64 = spectra.iter().map(|s| s.at(wavenumber)).sum();
            (wavenumber, sum / spectra.len() as f64)
        })
        .max_by(|a, b| a.1.total_cmp(&b.1))
}

impl Spectrum {
    /// The prominence at a wavenumber, dB.
    fn at(&self, wavenumber: f64) -> f64 {
        let line = ((wavenumber / self.wavenumbers[0]).ln() / STEP.ln()).round();
        let line = (line.max(0.0) as usize).min(self.prominence_db.len() - 1);
        self.prominence_db[line]
    }

    /// The peak around a wavenumber, between lines by a parabola through the three highest in dB.
    fn peak(&self, wavenumber: f64) -> Option<SpeedPeak> {
        let last = self.wavenumbers.len().saturating_sub(1);
        let top = (1..last)
            .filter(|&i| (self.wavenumbers[i] / wavenumber - 1.0).abs() <= REACH)
            .max_by(|a, b| self.level_db[*a].total_cmp(&self.level_db[*b]))?;
        if self.prominence_db[top] < PEAK_DB {
            return None;
        }
        let place = vertex(
            self.level_db[top - 1],
            self.level_db[top],
            self.level_db[top + 1],
        );
        Some(SpeedPeak {
            speed_m_s: self.speed_m_s,
            frequency_hz: self.speed_m_s * self.wavenumbers[top] * STEP.powf(place),
            prominence_db: self.prominence_db[top],
        })
    }
}

fn spectrum(sliding: &Sliding<'_>, lowest: Hertz) -> Option<Spectrum> {
    let Sliding {
        speed_m_s,
        rate,
        ref stretches,
        ..
    } = *sliding;
    let longest = stretches.iter().map(|s| s.len()).max().unwrap_or(0);
    if !(speed_m_s > 0.0 && speed_m_s.is_finite()) || longest < 32 {
        return None;
    }
    let n = (PADDING * longest).next_power_of_two();
    let mut transform = RealTransform::new(n);
    let bins = n / 2 + 1;
    let mut sums = vec![0.0; bins];
    let mut count = 0.0;
    let mut padded = vec![0.0; n];
    for stretch in stretches.iter().filter(|s| 2 * s.len() > longest) {
        let window = Window::Hann.coefficients(stretch.len(), Symmetry::Periodic);
        let level = mean(stretch);
        padded.fill(0.0);
        for ((out, value), weight) in padded.iter_mut().zip(*stretch).zip(&window) {
            *out = (value - level) * weight;
        }
        let power = transform.forward(&padded);
        let largest = power
            .iter()
            .map(num_complex::Complex::norm_sqr)
            .fold(0.0, f64::max);
        if largest <= 0.0 {
            continue;
        }
        count += 1.0;
        for (sum, bin) in sums.iter_mut().zip(&power) {
            *sum += 10.0 * bin.norm_sqr().max(1e-15 * largest).log10();
        }
    }
    if count < 1.0 {
        return None;
    }
    // Below one and a half periods in a stretch nothing can be told.
    let low_hz = (1.5 * rate.hz() / longest as f64).max(lowest.0);
    let high_hz = 0.95 * rate.nyquist().0;
    if low_hz * STEP >= high_hz {
        return None;
    }
    let lines = ((high_hz / low_hz).ln() / STEP.ln()) as usize;
    let frequencies: Vec<f64> = (0..lines).map(|i| low_hz * STEP.powi(i as i32)).collect();
    let level_db: Vec<f64> = frequencies
        .iter()
        .map(|f| {
            let place = f / rate.hz() * n as f64;
            let k = (place as usize).min(bins - 2);
            let share = place - k as f64;
            ((1.0 - share) * sums[k] + share * sums[k + 1]) / count
        })
        .collect();
    let around = octave_median(&level_db);
    Some(Spectrum {
        speed_m_s,
        wavenumbers: frequencies.iter().map(|f| f / speed_m_s).collect(),
        prominence_db: level_db.iter().zip(&around).map(|(l, b)| l - b).collect(),
        level_db,
        stretches: count,
        length_m: speed_m_s * longest as f64 / rate.hz(),
    })
}

/// The median over an octave below and above, of every tenth line.
fn octave_median(level_db: &[f64]) -> Vec<f64> {
    let reach = (2f64.ln() / STEP.ln()) as usize;
    let mut window = Vec::new();
    let thin = 10;
    let anchors: Vec<f64> = (0..level_db.len().div_ceil(thin))
        .map(|i| {
            let centre = i * thin;
            let (from, to) = (
                centre.saturating_sub(reach),
                (centre + reach + 1).min(level_db.len()),
            );
            window.clear();
            window.extend(level_db[from..to].iter().step_by(7));
            let middle = window.len() / 2;
            *window.select_nth_unstable_by(middle, f64::total_cmp).1
        })
        .collect();
    (0..level_db.len()).map(|i| anchors[i / thin]).collect()
}

#[cfg(test)]
mod tests;
