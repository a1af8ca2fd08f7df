//! The pulses of a force: where the hits are, and whether a drive consists of nothing else.

use std::ops::Range;

use crate::quantity::SampleRate;
use crate::statistics::median;

/// A hit has to be this many times as large as the noise of the force, to be found where hits are stated, and to be taken for
/// one where nothing is stated. Gaussian noise of ten million samples reaches 5.3.
const STANDS_OUT: f64 = 10.0;
const STANDS_OUT_UNASKED: f64 = 20.0;
/// The level above which the force belongs to a pulse: times its noise, and re the largest pulse.
const ABOVE_NOISE: f64 = 8.0;
const ABOVE_REST: f64 = 0.05;
/// Parts of a pulse closer than this are one: an anti-aliasing filter makes a short pulse ring.
const JOINED_SAMPLES: usize = 4;
/// Pulses within this time are one hit: a hammer that bounces comes back within it.
const BOUNCES_WITHIN_S: f64 = 0.1;
/// Noise is estimated from at most this many samples, evenly over the recording.
const SAMPLED: usize = 16_384;

/// A drive consists of pulses when it rests this share of the time at least, when the pulses hold this share of its energy at
/// least, and when most hits have 80 % of their energy in so many half-waves.
const RESTS: f64 = 0.9;
const ENERGY_IN_PULSES: f64 = 0.5;
const ENERGY_OF_A_HIT: f64 = 0.8;
const HALF_WAVES: usize = 3;
/// Only hits that are not much smaller than the largest count for that.
const COUNTS: f64 = 0.3;

/// One pulse of the force, in samples.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Pulse {
    /// Where it is above the level of pulses.
    pub(super) at: Range<usize>,
    /// Its largest value re the force at rest, with its sign.
    pub(super) peak: f64,
}

/// The pulses of one hit: one, or several where the hammer bounced.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Struck {
    /// The largest pulse.
    pub(super) main: Pulse,
    /// The others.
    pub(super) others: Vec<Pulse>,
}

impl Struck {
    /// The first sample that is not at rest.
    pub(super) fn start(&self) -> usize {
        let others = self.others.iter().map(|pulse| pulse.at.start);
        others.fold(self.main.at.start, usize::min)
    }

    fn end(&self) -> usize {
        let others = self.others.iter().map(|pulse| pulse.at.end);
        others.fold(self.main.at.end, usize::max)
    }
}

/// What is found in a force.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Force {
    /// Its value at rest.
    pub(super) rest: f64,
    /// The standard deviation of its noise at rest.
    pub(super) noise: f64,
    /// Its largest magnitude re rest.
    pub(super) largest: f64,
    /// The hits in the order of time; none where nothing stands out of the noise.
    pub(super) hits: Vec<Struck>,
}

impl Force {
    /// The hits in `samples`.
    pub(super) fn of(samples: &[f64], rate: SampleRate) -> Self {
        let (rest, noise) = rest_and_noise(samples);
        let largest = largest(samples, rest);
        let hits = if largest > STANDS_OUT * noise && largest > 0.0 {
            let level = (ABOVE_NOISE * noise).max(ABOVE_REST * largest);
            let within = (BOUNCES_WITHIN_S * rate.hz()) as usize;
            struck(pulses(samples, rest, level), within)
        } else {
            Vec::new()
        };
        Self {
            rest,
            noise,
            largest,
            hits,
        }
    }

    /// Whether most hits are pulses of a few half-waves, and not bursts of an oscillation.
    pub(super) fn is_of_pulses(&self, samples: &[f64]) -> bool {
        let counting: Vec<&Struck> = self
            .hits
            .iter()
            .filter(|hit| hit.main.peak.abs() >= COUNTS * self.largest)
            .collect();
        let short = counting
            .iter()
            .filter(|hit| half_waves(&samples[hit.start()..hit.end()], self.rest) <= HALF_WAVES)
            .count();
        !counting.is_empty() && 2 * short >= counting.len()
    }

    /// The share of the recording of `samples` that the pulses take.
    pub(super) fn share(&self, samples: usize) -> f64 {
        let pulses = self
            .hits
            .iter()
            .flat_map(|hit| std::iter::once(&hit.main).chain(&hit.others));
        pulses.map(|pulse| pulse.at.len()).sum::<usize>() as f64 / samples.max(1) as f64
    }
}

/// A drive that consists of a few pulses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transient {
    /// The number of hits.
    pub hits: usize,
    /// The share of the recording in which it is not at rest, 0–1.
    pub share: f64,
}

/// The hits of a drive that consists of short pulses and is at rest between them: their number, and their share of the time
/// (0–1); `None` for noise, sweeps, multisines and bursts of them.
///
/// Formula: the largest value is above 20 times the noise at rest (1.4826 times the median deviation from the median); pulses,
/// which lie above 5 % of it, take 10 % of the time or less and hold half of the energy or more; most hits have 80 % of their
/// energy in three half-waves or less.
///
/// Source: decision 0050 of this project.
#[must_use]
pub fn transient(samples: &[f64], rate: SampleRate) -> Option<Transient> {
    // A signal of pulses that take a tenth of the time has a crest factor above 3.
    let energy: f64 = samples.iter().map(|v| v * v).sum();
    if samples.len() < 8 || energy <= 0.0 {
        return None;
    }
    let (rest, noise) = rest_and_noise(samples);
    if largest(samples, rest) < STANDS_OUT_UNASKED * noise {
        return None;
    }
    let force = Force::of(samples, rate);
    let share = force.share(samples.len());
    let energy = |part: &[f64]| -> f64 { part.iter().map(|v| (v - rest).powi(2)).sum() };
    let in_hits: f64 = force
        .hits
        .iter()
        .map(|hit| energy(&samples[hit.start()..hit.end()]))
        .sum();
    let found = share <= 1.0 - RESTS
        && in_hits >= ENERGY_IN_PULSES * energy(samples)
        && force.is_of_pulses(samples);
    found.then_some(Transient {
        hits: force.hits.len(),
        share,
    })
}

/// The median, and the standard deviation of Gaussian noise with the same median deviation from it.
fn rest_and_noise(samples: &[f64]) -> (f64, f64) {
    // An odd step does not keep pace with a periodic signal.
    let step = samples.len().div_ceil(SAMPLED) | 1;
    let mut some: Vec<f64> = samples.iter().copied().step_by(step).collect();
    let rest = median(&mut some).unwrap_or(0.0);
    some.iter_mut().for_each(|v| *v = (*v - rest).abs());
    (rest, 1.4826 * median(&mut some).unwrap_or(0.0))
}

fn largest(samples: &[f64], rest: f64) -> f64 {
    samples
        .iter()
        .fold(0.0, |most, v| (v - rest).abs().max(most))
}

/// The parts of `samples` above `level`.
fn pulses(samples: &[f64], rest: f64, level: f64) -> Vec<Pulse> {
    let mut found: Vec<Pulse> = Vec::new();
    for (i, v) in samples.iter().enumerate() {
        let value = v - rest;
        if value.abs() <= level {
            continue;
        }
        match found.last_mut() {
            Some(last) if i <= last.at.end + JOINED_SAMPLES => {
                last.at.end = i + 1;
                if value.abs() > last.peak.abs() {
                    last.peak = value;
                }
            }
            _ => found.push(Pulse {
                at: i..i + 1,
                peak: value,
            }),
        }
    }
    found
}

/// Pulses that follow each other `within` so many samples as one hit.
fn struck(pulses: Vec<Pulse>, within: usize) -> Vec<Struck> {
    let mut hits: Vec<Struck> = Vec::new();
    for pulse in pulses {
        match hits.last_mut() {
            Some(hit) if pulse.at.start < hit.end() + within => {
                if pulse.peak.abs() > hit.main.peak.abs() {
                    hit.others.push(std::mem::replace(&mut hit.main, pulse));
                } else {
                    hit.others.push(pulse);
                }
            }
            _ => hits.push(Struck {
                main: pulse,
                others: Vec::new(),
            }),
        }
    }
    hits
}

/// How many half-waves hold 80 % of the energy.
fn half_waves(samples: &[f64], rest: f64) -> usize {
    let mut energies: Vec<f64> = samples
        .chunk_by(|a, b| (*a > rest) == (*b > rest))
        .map(|half| half.iter().map(|v| (v - rest).powi(2)).sum())
        .collect();
    energies.sort_by(|a, b| b.total_cmp(a));
    let all: f64 = energies.iter().sum();
    let mut sum = 0.0;
    energies
        .iter()
        .take_while(|energy| {
            let before = sum;
            sum += *energy;
            before < ENERGY_OF_A_HIT * all
        })
        .count()
}
