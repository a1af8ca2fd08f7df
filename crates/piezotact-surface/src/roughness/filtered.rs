//! Whether the long waves of a profile are missing as after a filter.

use piezotact::statistics::median;
use piezotact_fourier::hann;
use std::f64::consts::{LN_2, PI, TAU};

use super::filter::ALPHA;
use super::{Form, HeightProfile, mean, remove_profile_form};

/// Points to a cut-off that the spectrum needs.
const POINTS_PER_CUTOFF: f64 = 32.0;
/// Cut-offs that the profile must hold: each is one line of the spectrum below the cut-off.
const FEWEST_CUTOFFS: f64 = 4.0;
/// Rounding of lengths in files, in cut-offs.
const ROUNDING: f64 = 1e-6;
/// Beyond so many cut-offs the rest of the profile says nothing new.
const MOST_CUTOFFS: f64 = 60.0;
/// The spectrum that is continued to long waves: from this many waves to a cut-off …
const UPPER_FROM: f64 = 1.5;
/// … to this many.
const UPPER_TO: f64 = 8.0;
/// Parts of it, each with its median, so that single peaks do not count.
const PARTS: usize = 4;
/// Power rises towards long waves at most with this power of the wavelength.
const STEEPEST: f64 = 3.0;
/// The logarithm of the likelihood ratio from which the profile looks filtered.
const CONVINCING: f64 = 8.0;

/// Whether the waves of `profile` that are longer than `cutoff_m` are as weak as a Gaussian filter of that cut-off, in m, leaves
/// them; no when it holds fewer than four cut-offs.
///
/// Formula: the power of shorter waves, 1.5 to 8 to a cut-off, is continued to longer ones along a power law that does not fall
/// towards them, or stays as it is; the powers found there are more likely, by a factor of e⁸, under the better of the two
/// times (1 − e^(−π(αλc/λ)²))² than under the better of them alone (both with exponentially distributed powers, under a Hann
/// window). Of 60 simulated profiles of correlated noise of ten cut-offs it finds 59 when they are filtered and takes none for
/// filtered that is not; of five cut-offs 50 and 2.
///
/// Source: ISO 16610-21 for the filter; P. Whittle, J. R. Stat. Soc. B 15, 125 (1953) for the likelihood.
#[must_use]
pub fn looks_filtered(profile: &HeightProfile, cutoff_m: f64) -> bool {
    let cutoffs = (profile.length_m() / cutoff_m).min(MOST_CUTOFFS);
    let points = (POINTS_PER_CUTOFF * cutoffs) as usize;
    if cutoffs.is_nan() || cutoffs < FEWEST_CUTOFFS - ROUNDING || points > profile.heights_m().len()
    {
        return false;
    }
    let Ok(level) = remove_profile_form(profile, Form::Level) else {
        return false;
    };
    let length = (cutoffs * cutoff_m / profile.step_m()).round() as usize;
    let heights_m = level.heights_m();
    let coarse = blocks(&heights_m[..length.min(heights_m.len())], points);
    let power = |wave: usize| power(&coarse, wave);
    let upper = UPPER_FROM * cutoffs..UPPER_TO * cutoffs;
    let Some(law) = Law::of(upper.start.ceil() as usize, upper.end as usize, power) else {
        return false;
    };
    let flat = Law {
        at_one: law.at(upper.start.ceil() as usize).ln(),
        slope: 0.0,
    };
    // The logarithm of the likelihood under a law, as it is and after the filter; the better law counts for each.
    let likelihoods = [law, flat].map(|law| {
        (1..=(cutoffs + ROUNDING) as usize).fold([0.0, 0.0], |[plain, filtered], wave| {
            let (found, expected) = (power(wave), law.at(wave));
            let left = expected * kept(wave, cutoffs);
            [
                plain - expected.ln() - found / expected,
                filtered - left.ln() - found / left,
            ]
        })
    });
    let [one, other] = likelihoods;
    let (plain, filtered) = (one[0].max(other[0]), one[1].max(other[1]));
    filtered - plain > CONVINCING
}

/// The means of `count` blocks of equal length.
fn blocks(heights_m: &[f64], count: usize) -> Vec<f64> {
    let border = |k: usize| k * heights_m.len() / count;
    (0..count)
        .map(|k| mean(heights_m[border(k)..border(k + 1)].iter().copied()))
        .collect()
}

/// The power of `wave` whole waves along the heights, under a Hann window.
fn power(heights_m: &[f64], wave: usize) -> f64 {
    let count = heights_m.len() as f64;
    let (mut cosines, mut sines) = (0.0, 0.0);
    for (i, z) in heights_m.iter().enumerate() {
        let place = (i as f64 + 0.5) / count;
        let windowed = z * hann(place);
        let (sine, cosine) = (TAU * place * wave as f64).sin_cos();
        cosines += windowed * cosine;
        sines += windowed * sine;
    }
    cosines * cosines + sines * sines
}

/// The share of its power that a wave keeps after the filter, with what the window lets in from its neighbours.
fn kept(wave: usize, cutoffs: f64) -> f64 {
    let of = |wave: usize| {
        let left = 1.0 - (-PI * (ALPHA * wave as f64 / cutoffs).powi(2)).exp();
        left * left
    };
    (of(wave) + 0.25 * (of(wave - 1) + of(wave + 1))) / 1.5
}

/// A power law: the logarithm of power over that of the number of waves.
struct Law {
    at_one: f64,
    slope: f64,
}

impl Law {
    /// The law along the medians of parts from wave `first` to `last`; `None` where a part has no power.
    fn of(first: usize, last: usize, power: impl Fn(usize) -> f64) -> Option<Self> {
        let ratio = ((last + 1) as f64 / first as f64).powf(1.0 / PARTS as f64);
        let border = |part: usize| (first as f64 * ratio.powi(part as i32)).round() as usize;
        let mut points = Vec::with_capacity(PARTS);
        for part in 0..PARTS {
            let waves = border(part)..border(part + 1);
            if waves.is_empty() {
                continue;
            }
            let x = mean(waves.clone().map(|wave| (wave as f64).ln()));
            let mut powers: Vec<f64> = waves.map(&power).collect();
            // The median of an exponential distribution is ln 2 of its mean.
            let y = (median(&mut powers).unwrap_or(0.0) / LN_2).ln();
            points.push((x, y));
        }
        let middle_x = mean(points.iter().map(|p| p.0));
        let middle_y = mean(points.iter().map(|p| p.1));
        let products: f64 = points
            .iter()
            .map(|p| (p.0 - middle_x) * (p.1 - middle_y))
            .sum();
        let squares: f64 = points.iter().map(|p| (p.0 - middle_x).powi(2)).sum();
        let slope = (products / squares).clamp(-STEEPEST, 0.0);
        let law = Self {
            at_one: middle_y - slope * middle_x,
            slope,
        };
        (law.at_one.is_finite() && law.slope.is_finite()).then_some(law)
    }

    fn at(&self, wave: usize) -> f64 {
        (self.at_one + self.slope * (wave as f64).ln()).exp()
    }
}

#[cfg(test)]
mod tests {
    use super::super::profile_mean_line;
    use super::*;

    const CUTOFF_M: f64 = 0.8e-3;

    /// Noise whose power rises towards long waves, `cutoffs` long, at steps of 4 µm.
    fn rough(seed: u64, cutoffs: f64) -> HeightProfile {
        let mut state = seed;
        let mut z = 0.0;
        let heights = (0..(cutoffs * 200.0) as usize)
            .map(|_| {
                let mut total = -6.0;
                for _ in 0..12 {
                    state = state
                        .wrapping_mul(6_364_136_223_846_793_005)
                        .wrapping_add(1_442_695_040_888_963_407);
                    total += (state >> 11) as f64 / (1u64 << 53) as f64;
                }
                z = 0.9 * z + 1e-7 * total;
                z
            })
            .collect();
        HeightProfile::new(heights, 4e-6).unwrap()
    }

    fn filtered(profile: &HeightProfile, cutoff_m: f64) -> HeightProfile {
        let line = profile_mean_line(profile, cutoff_m).unwrap();
        let rest = profile.heights_m().iter().zip(line.heights_m());
        profile.with_heights(rest.map(|(z, line)| z - line).collect())
    }

    #[test]
    fn most_filtered_profiles_are_found_and_few_others() {
        let count = |cutoffs: f64| {
            let profiles: Vec<HeightProfile> = (1..=60).map(|seed| rough(seed, cutoffs)).collect();
            let found = |of: &dyn Fn(&HeightProfile) -> HeightProfile| {
                let found = profiles.iter().filter(|p| looks_filtered(&of(p), CUTOFF_M));
                found.count()
            };
            (found(&|p| filtered(p, CUTOFF_M)), found(&Clone::clone))
        };
        let (found, mistaken) = count(10.0);
        assert!(found >= 50 && mistaken <= 1, "{found} {mistaken}");
        let (found, mistaken) = count(5.0);
        assert!(found >= 40 && mistaken <= 6, "{found} {mistaken}");
        // fewer cut-offs say nothing
        assert_eq!(count(3.0), (0, 0));
    }

    #[test]
    fn a_wave_alone_and_waves_of_another_filter_are_none() {
        let wave = |noise: f64| {
            let rough = rough(3, 12.0);
            let heights = rough.heights_m().iter().enumerate();
            let waves =
                heights.map(|(i, z)| (i as f64 * 4e-6 / 0.1e-3 * TAU).sin() * 1e-6 + noise * z);
            rough.with_heights(waves.collect())
        };
        for cutoff_m in [0.25e-3, 0.8e-3, 2.4e-3] {
            assert!(!looks_filtered(&wave(0.05), cutoff_m), "{cutoff_m}");
            assert!(!looks_filtered(&wave(0.0), cutoff_m), "{cutoff_m}");
        }
        let flat = HeightProfile::new(vec![1e-6; 5000], 4e-6).unwrap();
        assert!(!looks_filtered(&flat, CUTOFF_M));
        // a cut-off ten times as long leaves the waves beyond this one
        assert!(!looks_filtered(&filtered(&rough(5, 12.0), 8e-3), CUTOFF_M));
    }
}
