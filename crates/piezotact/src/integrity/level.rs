//! Detection of frozen parts (held values) and drop-outs (abrupt falls to the noise floor) in a signal.

use super::Span;
use crate::clipping::step;
use crate::quantity::{SampleRate, Seconds};
use crate::statistics::{median, rms};

/// Defective parts of a signal.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Lost {
    /// One value is held.
    pub(super) frozen: Vec<Span>,
    /// The signal is at its floor.
    pub(super) gaps: Vec<Span>,
}

/// A value held for less is not looked at.
const SHORTEST_HELD: Seconds = Seconds(0.005);
/// A fall to the floor for less is not looked at.
const SHORTEST_GAP: Seconds = Seconds(0.010);
/// The fewest samples of either.
const FEWEST: usize = 16;
/// The level beside a lost part is taken over this time,
const AROUND: Seconds = Seconds(0.050);
/// and next to its edge over this time.
const EDGE: Seconds = Seconds(0.005);
/// The level next to an edge, re the level around and the usual one, that makes the edge abrupt: a finger that leaves a surface
/// rings down, and is below 0.15 in its last period before the floor is reached.
const ABRUPT: f64 = 0.25;
/// The same of changes next to a value that is held exactly, which nothing that rings down is.
const ABRUPT_HELD: f64 = 0.15;
/// The level around a lost part, re the usual one: a stroke is not lost that had ended.
const ALIVE: f64 = 0.3;
/// The least ratio of the duration of a held value to those of its neighbours.
const LONGER: usize = 5;
/// Signals of fewer steps of a converter hold still by themselves.
const FEWEST_STEPS: f64 = 5.0;
/// The floor, re the usual level: −28 dB.
pub(super) const FLOOR: f64 = 0.04;
/// More than this share at the floor are pauses of a stimulus.
const PAUSES: f64 = 0.5;
/// A value that is held in this many separate runs or more is the resting level of the signal, and not a frozen sensor.
pub(super) const RESTS: usize = 3;

/// Properties of the intact parts of a signal.
pub(super) struct Usual {
    pub(super) middle: f64,
    /// The upper quartile of its level over 20 ms.
    pub(super) level: f64,
    /// The time between two crossings upwards, in samples.
    pub(super) period: usize,
}

impl Usual {
    pub(super) fn of(samples: &[f64], rate: SampleRate) -> Self {
        let middle = median(&mut samples.to_vec()).unwrap_or(0.0);
        let block = rate.samples_in(Seconds(0.02)).max(8);
        let mut levels: Vec<f64> = samples
            .chunks(block)
            .map(|part| rms_about(part, middle))
            .collect();
        levels.sort_unstable_by(f64::total_cmp);
        let level = levels[levels.len() * 3 / 4];
        // Between ± a part of the level nothing crosses: noise in pauses is no vibration.
        let (mut crossings, mut below) = (0_usize, false);
        for v in samples {
            if v - middle < -0.1 * level {
                below = true;
            } else if v - middle > 0.1 * level {
                crossings += usize::from(below);
                below = false;
            }
        }
        let period = samples.len() / crossings.max(1);
        let longest = rate.samples_in(Seconds(0.02)).max(8);
        Self {
            middle,
            level,
            period: period.clamp(8, longest),
        }
    }
}

fn rms_about(samples: &[f64], middle: f64) -> f64 {
    let sum: f64 = samples.iter().map(|v| (v - middle) * (v - middle)).sum();
    (sum / samples.len().max(1) as f64).sqrt()
}

/// The parts of `samples` in which one value is held, and what is usual in the others; `None` where there are too few.
fn lost_by_a_held_value(samples: &[f64], rate: SampleRate) -> Option<(Lost, Usual)> {
    if samples.len() < 4 * FEWEST {
        return None;
    }
    let mut found = Lost::default();
    let held = held(samples, rate);
    let mut moving = Vec::new();
    let mut at = 0;
    for span in &held {
        moving.extend_from_slice(&samples[at..span.from]);
        at = span.to;
    }
    moving.extend_from_slice(&samples[at..]);
    let usual = Usual::of(&moving, rate);
    for span in held {
        let off = (samples[span.from] - usual.middle).abs();
        if off <= FLOOR * usual.level || samples[span.from] == 0.0 {
            found.gaps.push(span);
        } else {
            found.frozen.push(span);
        }
    }
    Some((found, usual))
}

/// The parts of a force that are lost: a force does not oscillate about a floor, so that a finger which lifts, or a steady load, is no lost
/// signal. One value that is held is.
pub(super) fn lost_of_force(samples: &[f64], rate: SampleRate) -> Lost {
    lost_by_a_held_value(samples, rate).map_or_else(Lost::default, |(found, _)| found)
}

/// The parts of `samples` that are lost, in their order.
pub(super) fn lost(samples: &[f64], rate: SampleRate) -> Lost {
    let Some((mut found, usual)) = lost_by_a_held_value(samples, rate) else {
        return Lost::default();
    };
    // Of a few steps one is the floor, and the next one is an abrupt edge.
    let floors = match usual.level >= FEWEST_STEPS * step(samples) {
        true => at_the_floor(samples, rate, &usual, FLOOR, SHORTEST_GAP),
        false => Vec::new(),
    };
    for span in floors {
        let within = |known: &Span| known.from < span.to && span.from < known.to;
        let inside = span.from > 0 && span.to < samples.len();
        if inside
            && abrupt(samples, rate, &usual, span)
            && !found.gaps.iter().chain(&found.frozen).any(within)
        {
            found.gaps.push(span);
        }
    }
    found.gaps.sort_unstable_by_key(|span| span.from);
    let paused: usize = found.gaps.iter().map(|span| span.len()).sum();
    if paused as f64 > PAUSES * samples.len() as f64 {
        found.gaps.clear();
    }
    found
}

/// Runs of one value that are implausible for the surrounding signal.
fn held(samples: &[f64], rate: SampleRate) -> Vec<Span> {
    let least = rate.samples_in(SHORTEST_HELD).max(FEWEST);
    let around = rate.samples_in(AROUND).max(2 * FEWEST);
    let edge = rate.samples_in(EDGE).max(8);
    let changes: Vec<f64> = samples.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let usual = rms(&changes);
    let rounding = 1e-9 * usual;
    let still = |change: &f64| change.abs() <= rounding;
    // Spans of changes: the change k leads from the sample k to k + 1.
    let mut runs: Vec<Span> = Vec::new();
    let mut at = 0;
    for run in changes.chunk_by(|a, b| still(a) == still(b)) {
        if still(&run[0]) && run.len() >= least {
            runs.push(Span {
                from: at,
                to: at + run.len() + 1,
            });
        }
        at += run.len();
    }
    if runs.is_empty() {
        return runs;
    }
    let step = step(samples);
    let alive = {
        let moving: Vec<f64> = changes
            .chunks(around)
            .map(rms)
            .filter(|level| *level > 0.0)
            .collect();
        let mut moving = moving;
        moving.sort_unstable_by(f64::total_cmp);
        moving.get(moving.len() * 3 / 4).copied().unwrap_or(0.0)
    };
    let longest_still = |part: &[f64]| {
        let runs = part.chunk_by(|a, b| still(a) == still(b));
        runs.filter(|run| still(&run[0]))
            .map(<[f64]>::len)
            .max()
            .unwrap_or(0)
    };
    let side = |part: &[f64], near: &[f64], length: usize| {
        let level = rms(part);
        part.len() >= edge
            && level >= ALIVE * alive
            && level >= FEWEST_STEPS * step
            && rms(near) >= ABRUPT_HELD * level
            && LONGER * longest_still(part) <= length
    };
    let value = |span: &Span| samples[span.from];
    let often = |span: &Span| {
        let alike = |other: &&Span| (value(other) - value(span)).abs() <= 1.5 * step;
        value(span) != 0.0 && runs.iter().filter(alike).count() >= RESTS
    };
    let broken = |span: &&Span| {
        // The changes that lead into the span and out of it are jumps of the defect.
        let before = &changes[span.from.saturating_sub(around + 1)..span.from.saturating_sub(1)];
        let after = &changes[(span.to).min(changes.len())..(span.to + around).min(changes.len())];
        let near_before = &before[before.len().saturating_sub(edge)..];
        let near_after = &after[..edge.min(after.len())];
        let (first, last) = (span.from == 0, span.to >= samples.len());
        // Silence at the ends of a file is put there by programs.
        let silence = value(span) == 0.0 && (first || last);
        !(silence || first && last)
            && (first || side(before, near_before, span.len()))
            && (last || side(after, near_after, span.len()))
            && !often(span)
    };
    runs.iter().filter(broken).copied().collect()
}

/// Runs of samples within `floor` of the middle, re the usual level, of at least `shortest` and two periods.
pub(super) fn at_the_floor(
    samples: &[f64],
    rate: SampleRate,
    usual: &Usual,
    floor: f64,
    shortest: Seconds,
) -> Vec<Span> {
    let least = rate
        .samples_in(shortest)
        .max(FEWEST)
        .max(2 * usual.period.min(rate.samples_in(Seconds(0.01)).max(8)));
    let near = |v: &f64| (v - usual.middle).abs() <= floor * usual.level;
    let (mut spans, mut at) = (Vec::new(), 0);
    for run in samples.chunk_by(|a, b| near(a) == near(b)) {
        if near(&run[0]) && run.len() >= least {
            spans.push(Span {
                from: at,
                to: at + run.len(),
            });
        }
        at += run.len();
    }
    spans
}

/// Whether the signal is alive up to both edges of `span`; at an end of the signal the other edge alone counts.
pub(super) fn abrupt(samples: &[f64], rate: SampleRate, usual: &Usual, span: Span) -> bool {
    let around = rate.samples_in(AROUND).max(2 * FEWEST);
    let alive = |part: &[f64], near: &[f64]| {
        let level = rms_about(part, usual.middle);
        let edge = rms_about(near, usual.middle);
        level >= ALIVE * usual.level && edge >= ABRUPT * level.max(usual.level)
    };
    let before = &samples[span.from.saturating_sub(around)..span.from];
    let after = &samples[span.to..(span.to + around).min(samples.len())];
    let left =
        before.is_empty() || alive(before, &before[before.len().saturating_sub(usual.period)..]);
    let right = after.is_empty() || alive(after, &after[..usual.period.min(after.len())]);
    left && right && !(before.is_empty() && after.is_empty())
}
