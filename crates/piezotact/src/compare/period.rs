//! The spatial period of a surface (or of a fingerprint) from sliding at several speeds: f = v/λ.

use serde::{Deserialize, Serialize};

use super::t_quantile;
use crate::doubt::Doubt;
use crate::feature::vertex;
use crate::fourier::RealTransform;
use crate::quantity::{Hertz, SampleRate};
use crate::series::mean;
use crate::spectrum::{Symmetry, Window};

/// One speed: what was recorded while sliding at it.
#[derive(Clone, Debug)]
pub struct Sliding<'a> {
    /// The speed, m/s.
    pub speed_m_s: f64,
    /// The rate.
    pub rate: SampleRate,
    /// Every stroke of every channel.
    pub stretches: Vec<&'a [f64]>,
}

/// The peak that belongs to the common period at one speed.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpeedPeak {
    /// The speed, m/s.
    pub speed_m_s: f64,
    /// The frequency of the peak, Hz.
    pub frequency_hz: f64,
    /// How far it stands above the background, dB.
    pub prominence_db: f64,
}

/// A spatial period that the spectra at all speeds agree on.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SpatialPeriod {
    /// The period, m.
    pub period_m: f64,
    /// Its 95 % confidence interval, m; absent for one speed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval_m: Option<[f64; 2]>,
    /// The peak at each speed.
    pub peaks: Vec<SpeedPeak>,
    /// How far the period stands above the background in the mean over speeds, dB.
    pub prominence_db: f64,
    /// What a person should know before relying on it.
    pub doubts: Vec<Doubt>,
}

/// Zeros that a stretch is continued with, as a multiple of its length, so that lines are fine enough.
const PADDING: usize = 8;
/// Spectra are compared on lines this far apart, as a ratio.
const STEP: f64 = 1.001;
/// The peak of one speed is looked for this far from v/λ, as a share of it.
const REACH: f64 = 0.1;
/// Less than this above the background is no period, dB …
const PROMINENT_DB: f64 = 6.0;
/// … nor is what noise reaches: the level of one periodogram's line scatters by this, dB, and the highest of a
/// thousand lines lies this many standard deviations up.
const SCATTER_DB: f64 = 5.57;
const HIGHEST_OF_MANY: f64 = 4.0;
/// A peak of one speed that stands lower than this above the background is none, dB.
const PEAK_DB: f64 = 3.0;
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
}

/// The spatial period on which the spectra of `slidings` agree: the wavenumber f/v that stands highest above its
/// background in the mean over speeds; then the line through the origin of the peak frequencies on the speeds.
/// `None` when no stretch is long enough, or no speed is above zero.
///
/// Formula: periodograms of whole stretches (Hann), averaged in dB over stretches and channels; background: the
/// running median; 1/λ = Σvf/Σv², its interval from the residuals with Student's t and n − 1 degrees of freedom.
///
/// Below `lowest` nothing is looked for: what a filter has taken away there has a slope and no period. Recordings of
/// one speed count as one.
///
/// Source: f = v/λ, as used for fingerprints and ridged boards by J. Scheibert et al. (2009), Science 323(5920).
#[must_use]
pub fn spatial_period(slidings: &[Sliding<'_>], lowest: Hertz) -> Option<SpatialPeriod> {
    let mut speeds: Vec<Sliding<'_>> = Vec::new();
    for sliding in slidings {
        let same = |other: &&mut Sliding<'_>| {
            (other.speed_m_s / sliding.speed_m_s - 1.0).abs() < SAME_SPEED
                && (other.rate.hz() / sliding.rate.hz() - 1.0).abs() < SAME_SPEED
        };
        match speeds.iter_mut().find(same) {
            Some(known) => known.stretches.extend(&sliding.stretches),
            None => speeds.push(sliding.clone()),
        }
    }
    let spectra: Vec<Spectrum> = speeds.iter().filter_map(|s| spectrum(s, lowest)).collect();
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
    let (wavenumber, prominence_db) = (0..lines)
        .map(|i| low * STEP.powi(i as i32))
        .map(|wavenumber| {
            let sum: f64 = spectra.iter().map(|s| s.at(wavenumber)).sum();
            (wavenumber, sum / spectra.len() as f64)
        })
        .max_by(|a, b| a.1.total_cmp(&b.1))?;
    let peaks: Vec<SpeedPeak> = spectra.iter().filter_map(|s| s.peak(wavenumber)).collect();
    let (vf, vv) = peaks.iter().fold((0.0, 0.0), |(vf, vv), p| {
        (
            vf + p.speed_m_s * p.frequency_hz,
            vv + p.speed_m_s * p.speed_m_s,
        )
    });
    if vf <= 0.0 {
        return None;
    }
    let slope = vf / vv;
    let left: f64 = peaks
        .iter()
        .map(|p| (p.frequency_hz - slope * p.speed_m_s).powi(2))
        .sum();
    let freedom = peaks.len() - 1;
    let interval_m = t_quantile(freedom).map(|t| {
        let reach = (t * (left / freedom as f64 / vv).sqrt()).min(0.99 * slope);
        [1.0 / (slope + reach), 1.0 / (slope - reach)]
    });
    let mut doubts = Vec::new();
    let averaged: f64 = spectra.iter().map(|s| s.stretches).sum();
    let noise_db = HIGHEST_OF_MANY * SCATTER_DB / averaged.sqrt();
    if prominence_db < PROMINENT_DB.max(noise_db) || peaks.len() < spectra.len() {
        doubts.push(Doubt::NoCommonPeriod { prominence_db });
    }
    if interval_m.is_none() {
        doubts.push(Doubt::NoInterval {
            what: "the spatial period".into(),
            groups: peaks.len(),
        });
    }
    Some(SpatialPeriod {
        period_m: 1.0 / slope,
        interval_m,
        peaks,
        prominence_db,
        doubts,
    })
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
mod tests {
    use super::*;

    /// Ridges 2 mm apart under three speeds, in noise: the period, with an interval that holds it.
    #[test]
    fn ridges_are_found_at_all_speeds() {
        let rate = SampleRate::new(200.0).unwrap();
        let mut state = 1u64;
        let mut noise = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let signals: Vec<(f64, Vec<f64>)> = [0.01, 0.02, 0.04]
            .into_iter()
            .map(|v: f64| {
                let samples = (0.1 / v * 200.0) as usize;
                let signal = (0..samples)
                    .map(|i| {
                        let place_m = v * i as f64 / 200.0;
                        (std::f64::consts::TAU * place_m / 0.002).sin() + noise() + 5.0
                    })
                    .collect();
                (v, signal)
            })
            .collect();
        let slidings: Vec<Sliding<'_>> = signals
            .iter()
            .map(|(v, signal)| Sliding {
                speed_m_s: *v,
                rate,
                stretches: vec![signal],
            })
            .collect();
        let found = spatial_period(&slidings, Hertz(0.0)).unwrap();
        assert!((found.period_m / 0.002 - 1.0).abs() < 0.005, "{found:?}");
        let [low, high] = found.interval_m.unwrap();
        assert!(
            low < 0.002 && 0.002 < high && found.doubts.is_empty(),
            "{found:?}"
        );
        assert_eq!(spatial_period(&[], Hertz(0.0)), None);
        // Noise has no period, however often it is recorded.
        let rough: Vec<Vec<f64>> = (0..12)
            .map(|_| (0..1000).map(|_| noise()).collect())
            .collect();
        let slidings: Vec<Sliding<'_>> = rough
            .iter()
            .zip([0.01, 0.02, 0.03].into_iter().cycle())
            .map(|(signal, speed_m_s)| Sliding {
                speed_m_s,
                rate,
                stretches: vec![signal],
            })
            .collect();
        if let Some(none) = spatial_period(&slidings, Hertz(5.0)) {
            assert!(
                matches!(none.doubts[..], [Doubt::NoCommonPeriod { .. }]),
                "{none:?}"
            );
            assert!(none.peaks.len() <= 3);
        }
    }
}
