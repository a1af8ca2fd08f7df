//! Fits a drive into the limits of a device: its crests are limited first, then the lines that cost most drive are attenuated.

use num_complex::Complex;

use super::Mode;
use crate::fourier::RealTransform;
use crate::render::share_of_least_error;
use crate::statistics::{correlation, peak, rms};

/// Iterations of clipping and restoring the magnitudes, for a texture.
const TURNS: usize = 60;
/// Iterations of clipping and filtering, for a waveform.
const ROUNDS: usize = 24;
/// A line this much weaker than their mean keeps its phase.
const WEAK: f64 = 0.1;
/// The tolerated change of a line when crests are limited: its level in dB, and the power of its error in dB re its intended
/// power.
const LEVEL_DB: f64 = 0.3;
const ERROR_DB: f64 = -20.0;
/// The number of iterations between two convergence checks, and the share to which the excess over the limit must have fallen at
/// each check, or limiting stops.
const CHECK_INTERVAL: usize = 8;
const MIN_PROGRESS_SHARE: f64 = 0.9;
/// The range of the attenuation strength λ as powers of ten, the resolution of the search, and the range around the last strength
/// that is searched first.
const STRENGTHS: (f64, f64) = (-4.0, 8.0);
const FINE: f64 = 0.01;
const NEAR: f64 = 0.2;

/// The limits that a drive has to fit into.
pub(super) struct DriveLimits {
    /// No sample beyond this, full scale = 1.
    pub(super) limit: f64,
    /// The slew limit, full scale = 1 per sample; none if steepness is not limited.
    pub(super) slope: Option<f64>,
    /// Nothing is played after so many samples.
    pub(super) length: usize,
    /// Lines over which the cost of a line is averaged on either side.
    pub(super) smooth: usize,
    /// Whether phases are free.
    pub(super) mode: Mode,
}

impl DriveLimits {
    /// The steepest slope of the drive with the lines `bins` re the slew limit; more than 1 does not fit.
    ///
    /// Formula: the largest of the derivative, on its samples and at three places between them.
    pub(super) fn slope_taken(&self, transform: &mut RealTransform, bins: &[Complex<f64>]) -> f64 {
        let Some(slope) = self.slope else {
            return 0.0;
        };
        let turn = std::f64::consts::TAU / transform.length() as f64;
        let mut steepest: f64 = 0.0;
        for quarter in 0..4 {
            let between = 0.25 * f64::from(quarter);
            let lines = bins.iter().enumerate().map(|(k, bin)| {
                let radians = turn * k as f64;
                bin * Complex::new(0.0, radians) * Complex::from_polar(1.0, radians * between)
            });
            steepest = steepest.max(peak(&transform.inverse(lines.collect())));
        }
        steepest / slope.max(f64::MIN_POSITIVE)
    }
}

/// A drive that fits.
pub(super) struct Fitted {
    pub(super) samples: Vec<f64>,
    /// The share of every line that remains, 0–1; 1 where no attenuation was needed.
    pub(super) shares: Vec<f64>,
    /// The correlation with the same drive before its crests were limited.
    pub(super) crest_correlation: f64,
    /// How strongly lines were turned down, where they had to be.
    pub(super) strength: Option<f64>,
}

/// The drive with the lines `bins`, within `room`: its crests are limited as far as the lines hardly change; if it still does
/// not fit, the lines that cost most drive (those with the most power) are attenuated. The search starts at the strength `last`.
pub(super) fn fitted(
    transform: &mut RealTransform,
    bins: &[Complex<f64>],
    room: &DriveLimits,
    last: Option<f64>,
) -> Fitted {
    if let Some(Pressed {
        samples,
        crest_correlation,
    }) = pressed(transform, bins, room)
    {
        return Fitted {
            samples,
            shares: vec![1.0; bins.len()],
            crest_correlation,
            strength: None,
        };
    }
    let loud = peak(&transform.inverse(bins.to_vec())) / room.limit;
    let cost = match room.slope_taken(transform, bins) > loud {
        // A drive that is too steep is attenuated at high frequencies.
        true => {
            let steep = bins.iter().enumerate().map(|(k, bin)| bin * k as f64);
            costs(&steep.collect::<Vec<_>>(), room.smooth)
        }
        false => costs(bins, room.smooth),
    };
    let mut at = |strength: f64| -> Option<Fitted> {
        let shares: Vec<f64> = cost
            .iter()
            .map(|cost| share_of_least_error(10f64.powf(strength) * cost))
            .collect();
        let turned: Vec<Complex<f64>> = bins
            .iter()
            .zip(&shares)
            .map(|(bin, share)| bin * *share)
            .collect();
        let Pressed {
            samples,
            crest_correlation,
        } = pressed(transform, &turned, room)?;
        Some(Fitted {
            samples,
            shares,
            crest_correlation,
            strength: Some(strength),
        })
    };
    // Consecutive drives of a loop need about the same strength.
    let near = last.map(|last| (last - NEAR, last + NEAR));
    let mut best = near.and_then(|(_, strong)| at(strong));
    let (mut weak, mut strong) = match (near, &best) {
        (Some(near), Some(_)) => near,
        _ => STRENGTHS,
    };
    while strong - weak > FINE {
        let middle = 0.5 * (weak + strong);
        match at(middle) {
            Some(fitted) => {
                strong = middle;
                best = Some(fitted);
            }
            None => weak = middle,
        }
    }
    best.unwrap_or_else(|| {
        // Nothing in the range fits: everything is turned down alike.
        let samples = transform.inverse(bins.to_vec());
        let taken = room.slope_taken(transform, bins);
        let share = (room.limit / peak(&samples)).min(1.0 / taken.max(f64::MIN_POSITIVE));
        Fitted {
            samples: samples.iter().map(|x| x * share).collect(),
            shares: vec![share; bins.len()],
            crest_correlation: 1.0,
            strength: None,
        }
    })
}

/// A drive within its room, with nothing turned down.
pub(super) struct Pressed {
    pub(super) samples: Vec<f64>,
    pub(super) crest_correlation: f64,
}

/// The drive with the lines `bins`, its crests limited to `room`; `None` when that changes a line by more than is tolerated.
///
/// For a texture every line gets its magnitude back after clipping, and keeps the phase that clipping gave it: E. Van der
/// Ouderaa, J. Schoukens and J. Renneboog (1988), IEEE Trans. Instrum. Meas. 37(1). Otherwise, and for the rest, what
/// clipping adds outside of the excited lines is taken away: J. Armstrong (2002), Electronics Letters 38(5), repeated.
pub(super) fn pressed(
    transform: &mut RealTransform,
    bins: &[Complex<f64>],
    room: &DriveLimits,
) -> Option<Pressed> {
    if room.slope_taken(transform, bins) > 1.0 {
        return None;
    }
    let mut samples = transform.inverse(bins.to_vec());
    let mut highest = peak(&samples);
    if highest <= room.limit {
        return Some(Pressed {
            samples,
            crest_correlation: 1.0,
        });
    }
    // A drive whose rms is close to its limit would have to be a square wave, which lines in a band cannot form.
    if rms(&samples) > 0.9 * room.limit {
        return None;
    }
    let asked = samples.clone();
    let turns = match room.mode {
        Mode::Texture => TURNS,
        Mode::Replicate => 0,
    };
    let clip = 0.97 * room.limit;
    let asked_power = smoothed(bins.iter().map(Complex::norm_sqr), room.smooth);
    let excited = asked_power.iter().filter(|power| **power > 0.0).count();
    let weak = WEAK * asked_power.iter().sum::<f64>() / excited.max(1) as f64;
    for round in 0..turns + ROUNDS {
        for sample in &mut samples[..room.length] {
            *sample = sample.clamp(-clip, clip);
        }
        samples[room.length..].fill(0.0);
        let mut lines = transform.forward(&samples);
        for ((line, bin), power) in lines.iter_mut().zip(bins).zip(&asked_power) {
            let (is, was) = (line.norm_sqr(), bin.norm_sqr());
            if *power <= weak {
                // These lines contribute almost nothing to the crest, but dominate the response where the device is most
                // sensitive.
                *line = *bin;
            } else if round < turns && is > 0.0 {
                *line *= (was / is).sqrt();
            }
        }
        samples = transform.inverse(lines);
        let now = peak(&samples);
        if now <= room.limit {
            break;
        }
        if round % CHECK_INTERVAL == CHECK_INTERVAL - 1 {
            // An excess that hardly decreases will not fall below the limit.
            if now - room.limit > MIN_PROGRESS_SHARE * (highest - room.limit) {
                return None;
            }
            highest = now;
        }
    }
    if peak(&samples) > room.limit || !kept(transform, &samples, bins, room) {
        return None;
    }
    if room.slope.is_some() {
        let lines = transform.forward(&samples);
        if room.slope_taken(transform, &lines) > 1.0 {
            return None;
        }
    }
    let crest_correlation = correlation(&samples, &asked);
    Some(Pressed {
        samples,
        crest_correlation,
    })
}

/// Whether `samples` still have the requested lines, averaged over the neighbours of each.
fn kept(
    transform: &mut RealTransform,
    samples: &[f64],
    bins: &[Complex<f64>],
    room: &DriveLimits,
) -> bool {
    let lines = transform.forward(samples);
    let asked = smoothed(bins.iter().map(Complex::norm_sqr), room.smooth);
    let least = 1e-12 * asked.iter().copied().fold(0.0, f64::max);
    match room.mode {
        Mode::Texture => {
            let level = 10f64.powf(LEVEL_DB / 10.0);
            let is = smoothed(lines.iter().map(Complex::norm_sqr), room.smooth);
            let mut both = is.iter().zip(&asked);
            both.all(|(is, asked)| *asked <= least || (1.0 / level..=level).contains(&(is / asked)))
        }
        Mode::Replicate => {
            let most = 10f64.powf(ERROR_DB / 10.0);
            let missed = lines
                .iter()
                .zip(bins)
                .map(|(is, bin)| (is - bin).norm_sqr());
            let missed = smoothed(missed, room.smooth);
            let mut both = missed.iter().zip(&asked);
            both.all(|(missed, asked)| *asked <= least || *missed <= most * asked)
        }
    }
}

/// `power` averaged over `smooth` neighbours on either side.
pub(super) fn smoothed(power: impl Iterator<Item = f64>, smooth: usize) -> Vec<f64> {
    let mut sums = vec![0.0];
    let mut sum = 0.0;
    sums.extend(power.map(|power| {
        sum += power;
        sum
    }));
    let lines = sums.len() - 1;
    (0..lines)
        .map(|k| {
            let (from, to) = (k.saturating_sub(smooth), (k + smooth + 1).min(lines));
            (sums[to] - sums[from]) / (to - from) as f64
        })
        .collect()
}

/// The power of every line, averaged over `smooth` neighbours on either side, re the median of the excited ones.
fn costs(bins: &[Complex<f64>], smooth: usize) -> Vec<f64> {
    let mut cost = smoothed(bins.iter().map(Complex::norm_sqr), smooth);
    let mut excited: Vec<f64> = cost.iter().copied().filter(|c| *c > 0.0).collect();
    let median = crate::statistics::median(&mut excited).unwrap_or(1.0);
    for value in &mut cost {
        *value /= median;
    }
    cost
}
