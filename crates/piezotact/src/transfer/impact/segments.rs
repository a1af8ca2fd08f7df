//! The segments of an impact test: how long they are, and which hits have one that can be used.

use std::ops::Range;

use super::fault::HitFault;
use super::pulses::{Force, Struck};
use super::{ExponentialWindow, ImpactConfig, ImpactError, ImpactSegment};
use crate::clipping::step;
use crate::quantity::SampleRate;
use crate::statistics::{mean, median, rms};

/// The shortest segment, samples.
const SHORTEST: usize = 16;
/// The part before the hit: this share of the segment at least, so many durations of the pulse, and so many samples.
const BEFORE: (f64, usize, usize) = (0.005, 2, 8);
/// Fewer samples before the hit than these are no rest.
const LEAST_BEFORE: usize = 2;
/// Hits that are followed by the next in less than this part of the usual time do not shorten the segments of the others.
const USUAL_PART: f64 = 0.5;
/// The response is at rest when it falls to this share of its largest level: −40 dB.
pub(super) const AT_REST: f64 = 0.01;
/// A larger share that is left at the end of a segment is that of a hit without an end.
const MOST_LEFT: f64 = 0.5;
/// A larger share of the largest level before the hit is not rest: −30 dB.
const MOST_BEFORE: f64 = 0.03;
/// The level of the response is that of blocks of this part of a segment.
const BLOCKS: usize = 50;
/// Below this ratio to its noise a level is noise.
const OVER_NOISE: f64 = 1.5;
/// A response stands out when its largest sample is this many times its noise.
const ANSWERS: f64 = 5.0;
/// The blocks in which a response is looked for before its hit, s.
const ONSET_S: f64 = 0.0005;
/// A second pulse of a smaller share of the first is the ringing of a filter or of the hammer.
const SECOND: f64 = 0.05;
/// As many samples at a limit are an overload; of a pulse, also a top of more than this share of its length above 97 % of its
/// peak (a half-sine has 0.16), when the pulse has samples enough to tell.
const FLAT_SAMPLES: usize = 3;
const FLAT_SHARE: f64 = 0.3;
const FLAT_FROM: f64 = 0.97;
const FLAT_PULSE: usize = 12;
/// A side of a response that reaches less than this part of the other is not limited.
const ONE_SIDED: f64 = 0.1;
/// Beside a limit the signal falls by more than this many steps of its converter.
const FALLS_STEPS: f64 = 5.0;

/// The hits with their segments.
pub(super) struct Segments {
    /// The length of a segment, samples.
    pub(super) length: usize,
    /// How many of them lie before the hit.
    pub(super) before: usize,
    /// One for each hit.
    pub(super) hits: Vec<Segment>,
}

/// One hit with its segment.
pub(super) struct Segment {
    /// Where it begins; the hit itself lies `before` samples later.
    pub(super) from: usize,
    /// The level of the response at the end re its largest, 0–1; absent where it was not judged.
    pub(super) left: Option<f64>,
    /// Why it cannot be used.
    pub(super) faults: Vec<HitFault>,
}

/// What a recording of an impact test holds.
pub(super) struct Signals<'a> {
    pub(super) force: &'a [f64],
    pub(super) response: &'a [f64],
    pub(super) rate: SampleRate,
    pub(super) lost_s: &'a [[f64; 2]],
}

impl Segments {
    /// The segments of the hits of `found`, judged.
    pub(super) fn of(
        signals: &Signals<'_>,
        found: &Force,
        config: &ImpactConfig,
    ) -> Result<Self, ImpactError> {
        let samples = signals.force.len();
        let starts: Vec<usize> = found.hits.iter().map(Struck::start).collect();
        let sound = sound(signals, found);
        let first = first_sound(&starts, &sound);
        let mut pulse: Vec<f64> = found.hits.iter().map(|h| h.main.at.len() as f64).collect();
        let pulse = median(&mut pulse).unwrap_or(1.0) as usize;
        // From one hit to the next, or to the end of the recording.
        let spans: Vec<usize> = (0..starts.len())
            .map(|i| starts.get(i + 1).unwrap_or(&samples) - starts[i])
            .collect();
        let usual = usual_span(&spans, &sound);
        let share = (BEFORE.0 * usual as f64) as usize;
        let before = share.max(BEFORE.1 * pulse).max(BEFORE.2).min(first);
        let noise = noise_before(&signals.response[..first.saturating_sub(pulse / 2)]);
        let length = match config.segment {
            ImpactSegment::Samples(length) => length,
            ImpactSegment::Fitted => {
                let decays = (0..spans.len())
                    .filter(|i| sound[*i] && spans[*i] >= usual)
                    .map(|i| decay(&signals.response[starts[i]..starts[i] + spans[i]], noise))
                    .max();
                // A segment may reach up to the next hit's own beginning.
                let length = usual.min(before + 2 * decays.unwrap_or(usual));
                // Lengths with small factors are transformed faster.
                let step = if length >= 4096 { 64 } else { 2 };
                length / step * step
            }
        };
        if length < SHORTEST.max(before + pulse) || length > samples {
            return Err(ImpactError::Segment {
                least: SHORTEST.max(before + pulse),
                samples,
                found: length,
            });
        }
        let mut segments = Self {
            length,
            before,
            hits: Vec::with_capacity(starts.len()),
        };
        let polarity = polarity(found);
        for (i, hit) in found.hits.iter().enumerate() {
            let mut faults = Vec::new();
            if starts[i] < LEAST_BEFORE || starts[i] < before {
                faults.push(HitFault::AtTheBeginning);
            }
            faults.extend(double(hit, signals.rate));
            faults.extend(force_overload(signals.force, hit, found.rest));
            if hit.main.peak.signum() != polarity {
                faults.push(HitFault::Opposite);
            }
            let from = starts[i].saturating_sub(before);
            let left = segments.judge(signals, &starts, i, (noise, config), &mut faults);
            segments.hits.push(Segment { from, left, faults });
        }
        Ok(segments)
    }

    /// Judges the response to hit `i`, and returns its level at the end of the segment.
    fn judge(
        &self,
        signals: &Signals<'_>,
        starts: &[usize],
        i: usize,
        (noise, config): (f64, &ImpactConfig),
        faults: &mut Vec<HitFault>,
    ) -> Option<f64> {
        let (samples, rate) = (signals.force.len(), signals.rate);
        let seconds = |samples: usize| rate.duration_of(samples).0;
        let start = starts[i];
        let after = self.length - self.before;
        let next = starts.get(i + 1).copied();
        let last = next.unwrap_or(samples);
        let ends = |needed_s: f64| match next {
            Some(next) => HitFault::NextTooClose {
                after_s: seconds(next - start),
                needed_s,
            },
            None => HitFault::AtTheEnd {
                left_s: seconds(samples - start),
                needed_s,
            },
        };
        let cut = start.saturating_sub(self.before)..(start + after).min(last);
        if super::super::touches(&cut, signals.lost_s, rate) {
            faults.push(HitFault::LostSamples);
        }
        let answer = &signals.response[start..cut.end];
        let rest = mean(&signals.response[cut.start..start.max(cut.start + 1)]);
        let clipped = overload(answer, rest);
        if clipped > 0 {
            faults.push(HitFault::ResponseOverload { samples: clipped });
        }
        let peak = answer
            .iter()
            .fold(0.0_f64, |peak, v| peak.max((v - rest).abs()));
        if peak <= ANSWERS * noise {
            faults.push(HitFault::NoResponse);
            return None;
        }
        faults.extend(moved_before(signals, starts, i, (self.before, noise)));
        if start + after > last {
            faults.push(ends(seconds(after)));
            return None;
        }
        let left = left(answer, rest, noise);
        // Without an end to go by, a response that has hardly fallen is that to a hit that is cut off.
        let limit = match config.exponential {
            ExponentialWindow::Damping(damping_per_s) => {
                MOST_LEFT * (damping_per_s * seconds(after)).exp()
            }
            _ => MOST_LEFT,
        };
        if left > limit && config.segment == ImpactSegment::Fitted {
            // As far as it decays evenly from one end to the other.
            let falls = -left.min(0.99).ln() / seconds(after);
            faults.push(ends(-AT_REST.ln() / falls));
        }
        Some(left)
    }
}

/// Which hits are no double hits and do not begin the recording: they say how long a hit lasts.
fn sound(signals: &Signals<'_>, found: &Force) -> Vec<bool> {
    let hits = found.hits.iter();
    hits.map(|hit| double(hit, signals.rate).is_none() && hit.start() >= LEAST_BEFORE)
        .collect()
}

/// Where the first hit begins that does not begin the recording.
fn first_sound(starts: &[usize], sound: &[bool]) -> usize {
    let mut found = starts.iter().zip(sound).filter(|(_, sound)| **sound);
    match (found.next(), starts) {
        (Some((start, _)), _) => *start,
        (None, [.., last]) => *last,
        (None, []) => 0,
    }
}

/// The shortest of the spans that are not much shorter than usual, in samples.
fn usual_span(spans: &[usize], sound: &[bool]) -> usize {
    let mut counting: Vec<usize> = spans
        .iter()
        .zip(sound)
        .filter_map(|(span, sound)| sound.then_some(*span))
        .collect();
    if counting.is_empty() {
        counting = spans.to_vec();
    }
    counting.sort_unstable();
    // Of two, the longer one.
    let middle = counting.get(counting.len() / 2).copied().unwrap_or(0) as f64;
    let mut usual = counting
        .into_iter()
        .filter(|span| *span as f64 >= USUAL_PART * middle);
    usual.next().unwrap_or(0)
}

/// The sign that most hits have.
pub(super) fn polarity(found: &Force) -> f64 {
    let signs: f64 = found.hits.iter().map(|hit| hit.main.peak.signum()).sum();
    let peaks: f64 = found.hits.iter().map(|hit| hit.main.peak).sum();
    if signs == 0.0 { peaks } else { signs }.signum()
}

/// The second pulse of a hit.
fn double(hit: &Struck, rate: SampleRate) -> Option<HitFault> {
    let main = &hit.main;
    let counts = |other: &&super::pulses::Pulse| other.peak.abs() >= SECOND * main.peak.abs();
    let second = hit
        .others
        .iter()
        .filter(counts)
        .max_by(|a, b| a.peak.abs().total_cmp(&b.peak.abs()))?;
    Some(HitFault::Double {
        after_s: rate.duration_of(second.at.start.abs_diff(main.at.start)).0,
        share: second.peak.abs() / main.peak.abs(),
    })
}

/// A pulse that is cut off at a limit.
fn force_overload(force: &[f64], hit: &Struck, rest: f64) -> Option<HitFault> {
    let pulse = &force[hit.main.at.clone()];
    let sign = hit.main.peak.signum();
    let upright: Vec<f64> = pulse.iter().map(|v| sign * (v - rest)).collect();
    let top = upright
        .iter()
        .filter(|v| **v >= FLAT_FROM * hit.main.peak.abs())
        .count();
    let broad = pulse.len() >= FLAT_PULSE && top as f64 > FLAT_SHARE * pulse.len() as f64;
    let samples = if broad { top } else { at_a_limit(&upright) };
    (samples > 0).then_some(HitFault::ForceOverload { samples })
}

/// How many samples of a response stand at a limit above or below its value at `rest`.
fn overload(response: &[f64], rest: f64) -> usize {
    let above: Vec<f64> = response.iter().map(|v| v - rest).collect();
    let below: Vec<f64> = above.iter().map(|v| -v).collect();
    let top = |side: &[f64]| side.iter().copied().fold(f64::MIN, f64::max);
    let (high, low) = (top(&above), top(&below));
    // A signal that goes to one side only rests on the other.
    let limit = |side: &[f64], own: f64| {
        if own >= ONE_SIDED * high.max(low) {
            at_a_limit(side)
        } else {
            0
        }
    };
    limit(&above, high) + limit(&below, low)
}

/// How many samples equal the largest one, in runs of three or more that a signal does not have of itself: it falls abruptly
/// on a side of the run.
fn at_a_limit(samples: &[f64]) -> usize {
    let largest = samples.iter().copied().fold(f64::MIN, f64::max);
    let equal = |v: f64| (largest - v).abs() <= 1e-12 * largest.abs();
    // A signal that never rests on a value has no steps to be counted in.
    let falls = match step(samples) {
        step if step < f64::MAX => FALLS_STEPS * step,
        _ => return 0,
    };
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

/// The rms of the noise of a response in the part before the first hit; 0 where that is too short to say.
fn noise_before(response: &[f64]) -> f64 {
    if response.len() < SHORTEST {
        return 0.0;
    }
    // The quietest of some parts: the response may begin before the hit.
    let part = (response.len() / 8).max(SHORTEST);
    let levels = response.chunks_exact(part).map(|part| {
        let about = mean(part);
        rms(&part.iter().map(|v| v - about).collect::<Vec<_>>())
    });
    let mut levels: Vec<f64> = levels.collect();
    levels.sort_by(f64::total_cmp);
    levels.get(levels.len() / 4).copied().unwrap_or(0.0)
}

/// The levels of `blocks` of a response about its value at `rest`.
fn levels(response: &[f64], rest: f64, block: usize) -> Vec<f64> {
    response
        .chunks(block.max(1))
        .filter(|part| 2 * part.len() >= block)
        .map(|part| {
            (part.iter().map(|v| (v - rest).powi(2)).sum::<f64>() / part.len() as f64).sqrt()
        })
        .collect()
}

/// A level without its noise; 0 where it is noise.
fn without_noise(level: f64, noise: f64) -> f64 {
    if level <= OVER_NOISE * noise {
        return 0.0;
    }
    (level * level - noise * noise).max(0.0).sqrt()
}

/// After how many samples the response that begins with the hit is at rest.
fn decay(answer: &[f64], noise: f64) -> usize {
    let block = (answer.len() / (4 * BLOCKS)).max(SHORTEST);
    let tail = &answer[answer.len() - answer.len().min(block)..];
    let levels = levels(answer, mean(tail), block);
    let largest = levels.iter().copied().fold(0.0, f64::max);
    let moving = levels
        .iter()
        .rposition(|level| without_noise(*level, noise) > AT_REST * largest);
    moving.map_or(block, |last| (last + 1) * block)
}

/// The level of the response at the end of its segment re its largest, 0–1.
fn left(answer: &[f64], rest: f64, noise: f64) -> f64 {
    let levels = levels(answer, rest, (answer.len() / BLOCKS).max(SHORTEST));
    let largest = levels.iter().copied().fold(0.0, f64::max);
    let end = levels.last().copied().unwrap_or(0.0);
    if largest > 0.0 {
        without_noise(end, noise) / largest
    } else {
        0.0
    }
}

/// A response that moves before its hit: it has not come to rest, or it begins before the hit.
fn moved_before(
    signals: &Signals<'_>,
    starts: &[usize],
    i: usize,
    (before, noise): (usize, f64),
) -> Option<HitFault> {
    let (start, response) = (starts[i], signals.response);
    let block = ((ONSET_S * signals.rate.hz()) as usize).max(SHORTEST / 2);
    let earlier = if i == 0 { 0 } else { starts[i - 1] };
    // The rise of the pulse up to the level that counts as a hit is no time before it.
    let until = start.saturating_sub((before / 4).max(LEAST_BEFORE));
    let window = before.max(block);
    let level_of = |part: Range<usize>| {
        let about = mean(&response[earlier..until.max(earlier + 1)]);
        let values: Vec<f64> = response[part].iter().map(|v| v - about).collect();
        rms(&values)
    };
    let from = until.saturating_sub(window).max(earlier);
    if until <= from + LEAST_BEFORE {
        return None;
    }
    let level = without_noise(level_of(from..until), noise);
    let end = (start + 20 * window).min(starts.get(i + 1).copied().unwrap_or(response.len()));
    let largest = (start..end)
        .step_by(window)
        .map(|at| level_of(at..(at + window).min(end)))
        .fold(0.0, f64::max);
    let share = level / largest.max(f64::MIN_POSITIVE);
    if share <= MOST_BEFORE {
        return None;
    }
    // Back to where it was at rest.
    let quiet = (OVER_NOISE * noise).max(0.25 * level);
    let mut at = until;
    while at >= earlier + block && level_of(at - block..at) > quiet {
        at -= block;
    }
    let rests = at >= earlier + block;
    let lead = start - at;
    // A response to the hit before falls all the way; one that begins early was at rest before.
    Some(if rests && 2 * lead < start - earlier {
        HitFault::ResponseFirst {
            lead_s: signals.rate.duration_of(lead).0,
        }
    } else {
        HitFault::StillMoving { share }
    })
}
