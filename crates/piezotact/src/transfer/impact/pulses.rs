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
/// The baseline is that of medians over this time, s, of at least so many samples; it is followed where it departs from its
/// median by more than this many times the noise.
const BASELINE_S: f64 = 1.0;
const BASELINE_SAMPLES: usize = 64;
const DRIFTS: f64 = 1.0;

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
    pub(super) main: Pulse,
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
    /// The force re rest; a baseline that drifts is subtracted.
    pub(super) samples: Vec<f64>,
    /// By how much the baseline departs from its median at most, 0 where it does not drift.
    pub(super) drift: f64,
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
        let (samples, drift) = without_baseline(samples, rate);
        let noise = noise(&samples);
        let largest = samples.iter().fold(0.0_f64, |most, v| v.abs().max(most));
        let hits = if largest > STANDS_OUT * noise && largest > 0.0 {
            let level = (ABOVE_NOISE * noise).max(ABOVE_REST * largest);
            let within = (BOUNCES_WITHIN_S * rate.hz()) as usize;
            struck(pulses(&samples, level), within)
        } else {
            Vec::new()
        };
        Self {
            samples,
            drift,
            noise,
            largest,
            hits,
        }
    }

    /// Whether most hits are pulses of a few half-waves, and not bursts of an oscillation.
    pub(super) fn is_of_pulses(&self) -> bool {
        let counting: Vec<&Struck> = self
            .hits
            .iter()
            .filter(|hit| hit.main.peak.abs() >= COUNTS * self.largest)
            .collect();
        let short = counting
            .iter()
            .filter(|hit| half_waves(&self.samples[hit.start()..hit.end()]) <= HALF_WAVES)
            .count();
        !counting.is_empty() && 2 * short >= counting.len()
    }

    /// The share of the recording that the pulses take.
    fn share(&self) -> f64 {
        let pulses = self
            .hits
            .iter()
            .flat_map(|hit| std::iter::once(&hit.main).chain(&hit.others));
        pulses.map(|pulse| pulse.at.len()).sum::<usize>() as f64 / self.samples.len().max(1) as f64
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
/// Formula: the largest value is above 20 times the noise at rest (1.4826 times the median deviation from the median, or from a
/// baseline of medians over 1 s where that drifts, by 30 % of the largest value or less); not one sample alone; pulses,
/// which lie above 5 % of it, take 10 % of the time or less and hold half of the energy or more; most hits have 80 % of their
/// energy in three half-waves or less.
///
/// Source: docs/decisions/transfer-functions.md.
#[must_use]
pub fn transient(samples: &[f64], rate: SampleRate) -> Option<Transient> {
    let Found {
        pulses,
        energy,
        click,
        drifts,
    } = short_pulses(samples, rate)?;
    (energy >= ENERGY_IN_PULSES && !click && !drifts).then_some(pulses)
}

/// Short pulses in a drive, whatever else it holds.
pub(crate) struct Found {
    pub(crate) pulses: Transient,
    /// Their share of the energy, 0–1.
    pub(crate) energy: f64,
    /// One sample alone, which is a click as well as a hit.
    click: bool,
    /// A baseline that moves by more than hits leave clear.
    drifts: bool,
}

/// The short pulses of a drive; `None` where there are none.
pub(crate) fn short_pulses(samples: &[f64], rate: SampleRate) -> Option<Found> {
    // A signal of pulses that take a tenth of the time has a crest factor above 3.
    let energy: f64 = samples.iter().map(|v| v * v).sum();
    if samples.len() < 8 || energy <= 0.0 {
        return None;
    }
    let force = Force::of(samples, rate);
    if force.largest < STANDS_OUT_UNASKED * force.noise {
        return None;
    }
    let share = force.share();
    let energy = |part: &[f64]| -> f64 { part.iter().map(|v| v * v).sum() };
    let in_hits: f64 = force
        .hits
        .iter()
        .map(|hit| energy(&force.samples[hit.start()..hit.end()]))
        .sum();
    let found = share <= 1.0 - RESTS && force.is_of_pulses();
    found.then(|| {
        let hits = force.hits.len();
        let lengths = force.hits.iter().map(|hit| hit.main.at.len());
        Found {
            pulses: Transient { hits, share },
            energy: in_hits / energy(&force.samples),
            click: hits == 1 && lengths.max() == Some(1),
            drifts: force.drift > COUNTS * force.largest,
        }
    })
}

/// `samples` less their median, or less a baseline of medians where that drifts; and by how much it does.
pub(super) fn without_baseline(samples: &[f64], rate: SampleRate) -> (Vec<f64>, f64) {
    let rest = sampled_median(samples.iter().copied());
    let mut level: Vec<f64> = samples.iter().map(|v| v - rest).collect();
    let block = ((BASELINE_S * rate.hz()) as usize).max(BASELINE_SAMPLES);
    let blocks = level.chunks_exact(block);
    let medians: Vec<f64> = blocks
        .map(|part| sampled_median(part.iter().copied()))
        .collect();
    if medians.len() < 2 {
        return (level, 0.0);
    }
    // A line through two medians, beyond the first and the last centre too.
    let at = |i: usize| {
        let place = i as f64 / block as f64 - 0.5;
        let k = (place.max(0.0) as usize).min(medians.len() - 2);
        medians[k] + (place - k as f64) * (medians[k + 1] - medians[k])
    };
    let about = noise_of((0..level.len()).map(|i| level[i] - at(i)), level.len());
    let drift = medians.iter().fold(0.0_f64, |most, v| v.abs().max(most));
    if drift <= DRIFTS * about {
        return (level, 0.0);
    }
    for (i, v) in level.iter_mut().enumerate() {
        *v -= at(i);
    }
    (level, drift)
}

/// The median of some of the values.
fn sampled_median(samples: impl ExactSizeIterator<Item = f64>) -> f64 {
    // An odd step does not keep pace with a periodic signal.
    let step = samples.len().div_ceil(SAMPLED) | 1;
    median(&mut samples.step_by(step).collect::<Vec<f64>>()).unwrap_or(0.0)
}

/// The standard deviation of Gaussian noise with the same median deviation from 0 as `count` values.
fn noise_of(samples: impl Iterator<Item = f64>, count: usize) -> f64 {
    let step = count.div_ceil(SAMPLED) | 1;
    let mut some: Vec<f64> = samples.step_by(step).map(f64::abs).collect();
    1.4826 * median(&mut some).unwrap_or(0.0)
}

/// The noise of a force re rest.
fn noise(samples: &[f64]) -> f64 {
    noise_of(samples.iter().copied(), samples.len())
}

/// The parts of one sign of a force re rest whose magnitude is above `level`.
fn pulses(samples: &[f64], level: f64) -> Vec<Pulse> {
    let mut found: Vec<Pulse> = Vec::new();
    for (i, value) in samples.iter().copied().enumerate() {
        if value.abs() <= level {
            continue;
        }
        // A filter that rings, or drains, has another sign in between.
        let last = found.iter_mut().rev().take(2);
        let mut last =
            last.filter(|last| i <= last.at.end + JOINED_SAMPLES && last.peak * value > 0.0);
        if let Some(last) = last.next() {
            last.at.end = i + 1;
            if value.abs() > last.peak.abs() {
                last.peak = value;
            }
        } else {
            found.push(Pulse {
                at: i..i + 1,
                peak: value,
            });
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
fn half_waves(samples: &[f64]) -> usize {
    let mut energies: Vec<f64> = samples
        .chunk_by(|a, b| (*a > 0.0) == (*b > 0.0))
        .map(|half| half.iter().map(|v| v * v).sum())
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
