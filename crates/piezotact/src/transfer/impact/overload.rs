//! Forces and responses of hits at the limits of what recorded them.

use super::fault::HitFault;
use super::pulses::{Force, Struck};
use super::segments::Signals;

/// As many samples at a limit are an overload; of a pulse, also a top of more than this share of its length above 97 % of its
/// peak (a half-sine has 0.16), when the pulse has samples enough to tell.
const FLAT_SAMPLES: usize = 3;
const FLAT_SHARE: f64 = 0.3;
const FLAT_FROM: f64 = 0.97;
const FLAT_PULSE: usize = 12;
const SHORT_PULSE: usize = 5;
/// A peak that several hits share to the last digit although they differ is a limit: so many hits with a single sample there,
/// or with a run of two; of a converter with steps finer than this part of it, on which hits meet by chance.
const MEET: usize = 3;
const MEET_IN_RUNS: usize = 2;
const FINEST_STEPS: f64 = 200.0;
/// Peaks within this many times the noise of each other, if that is less than this part of them, are one where the impulses of their
/// hits differ by this factor.
const SATURATED: f64 = 5.0;
const SATURATED_PART: f64 = 0.01;
const OTHER_IMPULSE: f64 = 1.05;
/// A side of a response that reaches less than this part of the other is not limited.
const ONE_SIDED: f64 = 0.1;
/// Beside a limit the signal falls by more than this many steps of its converter.
const FALLS_STEPS: f64 = 5.0;

/// A pulse that is cut off at a limit: one that it shows itself, or the `limit` of others.
pub(super) fn force_overload(
    signals: &Signals<'_>,
    hit: &Struck,
    (limit, step): (Option<f64>, f64),
) -> Option<HitFault> {
    let sign = hit.main.peak.signum();
    let upright = |samples: &[f64]| -> Vec<f64> {
        let pulse = &samples[hit.main.at.clone()];
        pulse.iter().map(|v| sign * v).collect()
    };
    let pulse = upright(signals.force);
    let top = pulse
        .iter()
        .filter(|v| **v >= FLAT_FROM * hit.main.peak.abs())
        .count();
    // Of a short pulse one sample more may lie there by chance.
    let chance = if pulse.len() < FLAT_PULSE { 1.0 } else { 0.0 };
    let broad = pulse.len() >= SHORT_PULSE && top as f64 > FLAT_SHARE * pulse.len() as f64 + chance;
    let recorded = upright(signals.recorded);
    let samples = if broad {
        top
    } else {
        let shared = limit.map_or(0, |limit| at_level(&recorded, limit));
        at_a_limit(&recorded, step).max(shared)
    };
    (samples > 0).then_some(HitFault::ForceOverload { samples })
}

/// The limit that several pulses of one `polarity` share.
pub(super) fn limit_of(
    signals: &Signals<'_>,
    found: &Force,
    polarity: f64,
    step: f64,
) -> Option<f64> {
    let pulses = |samples| -> Vec<&[f64]> {
        let hits = found.hits.iter();
        hits.map(|hit| pulse_of(samples, hit)).collect()
    };
    let recorded = pulses(signals.recorded);
    shared_limit(&recorded, polarity, step).or_else(|| {
        let impulses = impulses(signals, found);
        shared_limit_in_noise(&recorded, polarity, found.noise, &impulses)
    })
}

fn pulse_of<'a>(samples: &'a [f64], hit: &Struck) -> &'a [f64] {
    &samples[hit.main.at.clone()]
}

/// The sums of the force over the pulses: the impulses of the hits but for the rate.
pub(super) fn impulses(signals: &Signals<'_>, found: &Force) -> Vec<f64> {
    let hits = found.hits.iter();
    hits.map(|hit| pulse_of(signals.force, hit).iter().sum::<f64>().abs())
        .collect()
}

/// The level at which several `parts` end within `noise` although their hits have other `impulses`: what comes before the converter
/// is saturated. A little below their largest value, so that the samples there are counted.
pub(super) fn shared_limit_in_noise(
    parts: &[&[f64]],
    sign: f64,
    noise: f64,
    impulses: &[f64],
) -> Option<f64> {
    let tops: Vec<f64> = parts
        .iter()
        .map(|part| part.iter().map(|v| sign * v).fold(f64::MIN, f64::max))
        .collect();
    let level = tops.iter().copied().fold(0.0, f64::max);
    let reach = SATURATED * noise;
    if noise <= 0.0 || reach > SATURATED_PART * level {
        return None;
    }
    let there: Vec<f64> = (tops.iter().zip(impulses))
        .filter(|(top, _)| level - **top <= reach)
        .map(|(_, impulse)| *impulse)
        .collect();
    let (low, high) = there.iter().fold((f64::MAX, 0.0_f64), |(low, high), v| {
        (low.min(*v), high.max(*v))
    });
    (there.len() >= MEET && high > OTHER_IMPULSE * low).then_some(level - reach)
}

/// Whether a value is `level` but for rounding.
fn meets(value: f64, level: f64) -> bool {
    (value - level).abs() <= 1e-12 * level.abs()
}

/// How many samples stand at `level` or above.
fn at_level(samples: &[f64], level: f64) -> usize {
    let at = samples.iter().filter(|v| **v > level || meets(**v, level));
    at.count()
}

/// How many samples of a response stand at the limits above and below.
pub(super) fn beyond(response: &[f64], [above, below]: [Option<f64>; 2]) -> usize {
    let upright = above.map_or(0, |limit| at_level(response, limit));
    let turned: Vec<f64> = response.iter().map(|v| -v).collect();
    upright + below.map_or(0, |limit| at_level(&turned, limit))
}

/// The largest value of `parts` on one side, where several of them end there although they differ: a limit of the converter.
pub(super) fn shared_limit(parts: &[&[f64]], sign: f64, step: f64) -> Option<f64> {
    let largest = |part: &[f64]| part.iter().map(|v| sign * v).fold(f64::MIN, f64::max);
    let level = parts.iter().map(|part| largest(part)).fold(0.0, f64::max);
    if level <= FINEST_STEPS * step {
        return None;
    }
    let there: Vec<&&[f64]> = parts
        .iter()
        .filter(|part| meets(largest(part), level))
        .collect();
    let in_runs = there.iter().filter(|part| {
        let mut pairs = part.windows(2);
        pairs.any(|pair| pair.iter().all(|v| meets(sign * v, level)))
    });
    // Hits of a simulation without noise are all one.
    let energy = |part: &[f64]| part.iter().map(|v| v * v).sum::<f64>();
    let first = there.first().map_or(0.0, |part| energy(part));
    let differ = there
        .iter()
        .any(|part| (energy(part) - first).abs() > 1e-9 * first);
    (differ && (there.len() >= MEET || in_runs.count() >= MEET_IN_RUNS)).then_some(level)
}

/// How many samples of a response stand at a limit above or below its value at `rest`.
pub(super) fn overload(response: &[f64], rest: f64, step: f64) -> usize {
    let above: Vec<f64> = response.iter().map(|v| v - rest).collect();
    let below: Vec<f64> = above.iter().map(|v| -v).collect();
    let top = |side: &[f64]| side.iter().copied().fold(f64::MIN, f64::max);
    let (high, low) = (top(&above), top(&below));
    // A signal that goes to one side only rests on the other.
    let limit = |side: &[f64], own: f64| {
        if own >= ONE_SIDED * high.max(low) {
            at_a_limit(side, step)
        } else {
            0
        }
    };
    limit(&above, high) + limit(&below, low)
}

/// How many samples equal the largest one, in runs of three or more that a signal does not have of itself: it falls abruptly
/// on a side of the run, by more than some `step`s of its converter.
fn at_a_limit(samples: &[f64], step: f64) -> usize {
    let largest = samples.iter().copied().fold(f64::MIN, f64::max);
    let equal = |v: f64| (largest - v).abs() <= 1e-12 * largest.abs();
    let falls = FALLS_STEPS * step;
    let (mut count, mut i) = (0, 0);
    while i < samples.len() {
        if !equal(samples[i]) {
            i += 1;
            continue;
        }
        let from = i;
        while i < samples.len() && equal(samples[i]) {
            i += 1;
        }
        let beside = [from.checked_sub(1), Some(i)];
        let abrupt = beside
            .into_iter()
            .flatten()
            .filter_map(|k| samples.get(k))
            .any(|v| largest - v > falls);
        if i - from >= FLAT_SAMPLES && abrupt {
            count += i - from;
        }
    }
    count
}
