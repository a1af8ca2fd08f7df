//! The segments of an impact test: how long they are, and which hits have one that can be used.

use crate::transfer::TransferError;
use std::ops::Range;

use super::decay::{Decay, Judged, Left};
use super::fault::HitFault;
use super::overload::{
    beyond, force_overload, impulses, limit_of, overload, shared_limit, shared_limit_in_noise,
};
use super::pulses::{Force, Struck};
use super::{ExponentialWindow, ImpactConfig, ImpactSegment};
use crate::clipping::step;
use crate::integrity::{Span, lost_parts};
use crate::quantity::{SampleRate, Seconds};
use crate::statistics::{mean, median, rms};

/// The shortest segment, samples.
const SHORTEST: usize = 16;
/// The part before the hit: this share of the segment at least, so many durations of the pulse, and so many samples.
const BEFORE: (f64, usize, usize) = (0.005, 2, 8);
/// Fewer samples before the hit than these are no rest.
const LEAST_BEFORE: usize = 2;
/// The rest before a hit is this part of the usual time between hits: long enough for hum and tremor to be nothing in its mean.
const RESTS: usize = 4;
/// Hits that are followed by the next in less than this part of the usual time do not shorten the segments of the others.
const USUAL_PART: f64 = 0.5;
/// The response is at rest when it falls to this share of its largest level: −40 dB.
pub(super) const AT_REST: f64 = 0.01;
/// A larger share that is left at the end of a segment is that of a hit without an end: −14 dB.
pub(super) const MOST_LEFT: f64 = 0.2;
/// A larger share of the largest level before the hit is not rest: −26 dB. Up to `MOST_LEFT` it is a warning.
pub(super) const MOST_BEFORE: f64 = 0.05;
/// Below this ratio to its noise a level is noise.
const OVER_NOISE: f64 = 1.5;
/// A response stands out when its largest sample is this many times its noise.
const ANSWERS: f64 = 5.0;
/// The blocks in which a response is looked for before its hit, s.
const ONSET_S: f64 = 0.0005;
/// So many of them in a row at this share of the level before the hit, or in the noise, are rest.
const QUIET: (usize, f64) = (4, 0.1);
/// A second pulse of a smaller share of the first is the ringing of a filter or of the hammer.
const SECOND: f64 = 0.05;
/// A response that stops moving is lost where its level was so many times its noise, and this part of its peak, just before.
const STOPS: f64 = 5.0;
const STOPS_PART: f64 = 0.03;
const JUST_BEFORE: Seconds = Seconds(0.005);
/// What remains of an earlier response is contradicted by a level this many times lower just before the hit, in an octave of which
/// so many periods fit there.
const JOINT: f64 = 3.0;
const JOINT_FROM: f64 = 0.25;
/// A response begins early that is above so many times its noise and this part of its peak, as many samples and this part of a pulse
/// before the force.
const EARLY_NOISE: f64 = 10.0;
const EARLY_PART: f64 = 0.1;
const EARLY_SAMPLES: usize = 4;
const EARLY_PULSES: usize = 5;
/// A pulse of as many samples that begins with a jump of more than this share of its peak is cut off by a trigger.
const CUT_PULSE: usize = 8;
const CUT_FROM: f64 = 0.4;
/// The hits with their segments.
pub(super) struct Segments {
    /// The length of a segment, samples.
    pub(super) length: usize,
    /// How many of them lie before the hit.
    pub(super) before: usize,
    /// The rest before a hit over which the response is 0, samples.
    pub(super) rest: usize,
    /// The level of the response that is left at the end, in the octave that has decayed least.
    pub(super) left: Left,
    /// One for each hit.
    pub(super) hits: Vec<Segment>,
}

/// One hit with its segment.
pub(super) struct Segment {
    /// Where it begins; the hit itself lies `before` samples later.
    pub(super) from: usize,
    /// The level of the response before it re its largest, 0–1, where that does not stand still.
    pub(super) remains: f64,
    /// Why it cannot be used.
    pub(super) faults: Vec<HitFault>,
}

/// What hits are judged by.
#[derive(Clone, Copy)]
struct Known<'a> {
    signals: &'a Signals<'a>,
    /// The rms of the noise of the response.
    noise: f64,
    /// Where the hits begin, and their peaks.
    starts: &'a [usize],
    peaks: &'a [f64],
    /// How the response decays.
    decay: &'a Decay,
    /// The length of a pulse, samples.
    pulse: usize,
    /// The step of the converter of the response.
    step: f64,
    /// The limits of the response above and below that several hits share.
    limits: [Option<f64>; 2],
    /// Where the response is lost.
    lost: &'a [Span],
    config: &'a ImpactConfig,
}

/// What a recording of an impact test holds.
pub(super) struct Signals<'a> {
    /// The force re rest.
    pub(super) force: &'a [f64],
    /// The force as it was recorded.
    pub(super) recorded: &'a [f64],
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
    ) -> Result<Self, TransferError> {
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
        let quiet = 0..first.saturating_sub(pulse / 2);
        let noise = noise_before(&signals.response[quiet.clone()]);
        let long = |reach: usize| -> Vec<(usize, f64)> {
            let long = (0..spans.len()).filter(|i| sound[*i] && spans[*i] >= reach);
            long.map(|i| (starts[i], found.hits[i].main.peak)).collect()
        };
        let mut reach = usual;
        if let ImpactSegment::Samples(length) = config.segment
            && !long(length.saturating_sub(before)).is_empty()
        {
            reach = reach.max(length.saturating_sub(before));
        }
        let decay = Decay::of(&Judged {
            response: signals.response,
            rate: signals.rate,
            hits: &long(reach),
            reach,
            pulse,
            quiet,
        });
        let length = match config.segment {
            ImpactSegment::Samples(length) => length,
            ImpactSegment::Fitted => fitted_length(usual, before, pulse, &decay),
        };
        if length < SHORTEST.max(before + pulse) || length > samples {
            return Err(TransferError::Segment {
                least: SHORTEST.max(before + pulse),
                samples,
                found: length,
            });
        }
        let mut segments = Self {
            length,
            before,
            rest: usual / RESTS,
            left: decay.left(length - before),
            hits: Vec::with_capacity(starts.len()),
        };
        let peaks: Vec<f64> = found.hits.iter().map(|hit| hit.main.peak).collect();
        let polarity = polarity(found);
        let steps = [step(signals.recorded), step(signals.response)];
        let limit = limit_of(signals, found, polarity, steps[0]);
        let lost = lost_parts(signals.response, signals.rate);
        let after = length - before;
        let limits = response_limits((signals, found), &starts, after, steps[1], noise);
        for (i, hit) in found.hits.iter().enumerate() {
            let mut faults = Vec::new();
            let cut = starts[i] < LEAST_BEFORE || starts[i] < before || begins_within(signals, hit);
            faults.extend(cut.then_some(HitFault::AtTheBeginning));
            faults.extend(double(hit, signals.rate));
            faults.extend(force_overload(signals, hit, (limit, steps[0])));
            if hit.main.peak.signum() != polarity {
                faults.push(HitFault::Opposite);
            }
            let from = starts[i].saturating_sub(before);
            let known = Known {
                signals,
                noise,
                starts: &starts,
                peaks: &peaks,
                decay: &decay,
                pulse,
                step: steps[1],
                limits,
                lost: &lost,
                config,
            };
            let remains = if cut {
                0.0
            } else {
                segments.judge(&known, i, &mut faults)
            };
            segments.hits.push(Segment {
                from,
                remains,
                faults,
            });
        }
        Ok(segments)
    }

    /// Judges the response to hit `i`, and returns what remains of the response before it, re its own largest level.
    fn judge(&self, known: &Known<'_>, i: usize, faults: &mut Vec<HitFault>) -> f64 {
        let Known {
            signals,
            starts,
            config,
            ..
        } = *known;
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
        let clipped = overload(answer, rest, known.step).max(beyond(answer, known.limits));
        if clipped > 0 {
            faults.push(HitFault::ResponseOverload { samples: clipped });
        }
        let peak = answer
            .iter()
            .fold(0.0_f64, |peak, v| peak.max((v - rest).abs()));
        faults.extend(stops(known, start..cut.end, peak));
        if peak <= ANSWERS * known.noise {
            faults.push(HitFault::NoResponse);
            return 0.0;
        }
        let remains = match moved_before(known, i, self.before) {
            Some(HitFault::StillMoving { share }) => share.max(remains(known, i)),
            Some(first) => {
                faults.push(first);
                0.0
            }
            None => {
                let early = begins_early(known, start, (rest, peak));
                faults.extend(early);
                remains(known, i)
            }
        };
        faults.extend((remains > MOST_LEFT).then_some(HitFault::StillMoving { share: remains }));
        if start + after > last {
            faults.push(ends(seconds(after)));
            return remains;
        }
        // Without an end to go by, a response that has hardly fallen is that to a hit that is cut off.
        let limit = match config.exponential {
            ExponentialWindow::Damping(damping_per_s) => {
                MOST_LEFT * (damping_per_s * seconds(after)).exp()
            }
            _ => MOST_LEFT,
        };
        let left = known.decay.spoils(after).share;
        if left > limit && config.segment == ImpactSegment::Fitted {
            // As far as it decays evenly from one end to the other.
            let falls = -left.min(0.99).ln() / seconds(after);
            faults.push(ends(-AT_REST.ln() / falls));
        }
        remains
    }
}

/// The length of a segment in which a response decays, in samples: not beyond the next hit's own beginning.
fn fitted_length(usual: usize, before: usize, pulse: usize, decay: &Decay) -> usize {
    let length = usual.min(before + 2 * decay.until_rest().unwrap_or(usual));
    // A hit that ends the recording leaves less; its fault says so.
    let length = length.max(SHORTEST.max(before + pulse).next_multiple_of(2));
    // Lengths with small factors are transformed faster.
    let step = if length >= 4096 { 64 } else { 2 };
    length / step * step
}

/// The limits of the response above and below that several hits share.
fn response_limits(
    (signals, found): (&Signals<'_>, &Force),
    starts: &[usize],
    after: usize,
    step: f64,
    noise: f64,
) -> [Option<f64>; 2] {
    let impulses = impulses(signals, found);
    let reached = starts.iter().map(|start| {
        let end = (start + after).min(signals.force.len());
        &signals.response[*start..end]
    });
    let reached: Vec<&[f64]> = reached.collect();
    [1.0, -1.0].map(|sign| {
        shared_limit(&reached, sign, step)
            .or_else(|| shared_limit_in_noise(&reached, sign, noise, &impulses))
    })
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
    // A hammer pushes: what has the other sign is a filter that rings or drains.
    let counts = |other: &&super::pulses::Pulse| other.peak / main.peak >= SECOND;
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

/// Whether a pulse begins with a jump from rest, as in a block that was recorded too late.
fn begins_within(signals: &Signals<'_>, hit: &Struck) -> bool {
    let (pulse, force) = (&hit.main, signals.force);
    let start = pulse.at.start;
    let jump = force[start] - force[start.saturating_sub(1)];
    pulse.at.len() >= CUT_PULSE && jump / pulse.peak > CUT_FROM
}

/// A response that stops while it moves.
fn stops(known: &Known<'_>, span: Range<usize>, peak: f64) -> Option<HitFault> {
    let Signals { response, rate, .. } = *known.signals;
    let before = rate.samples_in(JUST_BEFORE).max(SHORTEST);
    let least = (STOPS * known.noise).max(STOPS_PART * peak);
    let mut parts = known.lost.iter().filter(|part| {
        let within = span.contains(&part.from);
        within && {
            let moving = &response[part.from.saturating_sub(before).max(span.start)..part.from];
            let about = mean(moving);
            rms(&moving.iter().map(|v| v - about).collect::<Vec<_>>()) > least
        }
    });
    parts.next().map(|part| HitFault::ResponseStops {
        after_s: rate.duration_of(part.from - span.start).0,
        lasts_s: rate.duration_of(part.len()).0,
    })
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

/// A level without its `noise`; 0 where it is noise.
fn without_noise(level: f64, noise: f64) -> f64 {
    if level <= OVER_NOISE * noise {
        return 0.0;
    }
    (level * level - noise * noise).max(0.0).sqrt()
}

/// A response that begins within the last milliseconds before its hit, when it was at rest before.
fn begins_early(known: &Known<'_>, start: usize, (rest, peak): (f64, f64)) -> Option<HitFault> {
    let rate = known.signals.rate;
    let limit = (EARLY_NOISE * known.noise).max(EARLY_PART * peak);
    let from = start.saturating_sub(rate.samples_in(JUST_BEFORE).max(SHORTEST));
    let response = &known.signals.response[from..start];
    let onset = from + response.iter().position(|v| (v - rest).abs() > limit)?;
    // The force counts as a pulse a little after it begins.
    (start - onset >= EARLY_SAMPLES.max(known.pulse / EARLY_PULSES)).then(|| {
        HitFault::ResponseFirst {
            lead_s: rate.duration_of(start - onset).0,
        }
    })
}

/// The level that an octave of the response to the hit before still has, as the mean decay says, re the largest of this hit.
fn remains(known: &Known<'_>, i: usize) -> f64 {
    let Some(earlier) = i.checked_sub(1) else {
        return 0.0;
    };
    let left = known.decay.spoils(known.starts[i] - known.starts[earlier]);
    // Where the response is quieter before the hit than that, the recording was put together from blocks.
    let (start, response) = (known.starts[i], known.signals.response);
    let block = known.signals.rate.samples_in(JUST_BEFORE).max(SHORTEST);
    let until = start.saturating_sub(LEAST_BEFORE);
    let just_before = &response[until.saturating_sub(block).max(known.starts[earlier])..until];
    let about = mean(just_before);
    let level = rms(&just_before.iter().map(|v| v - about).collect::<Vec<_>>());
    if left
        .octave_hz
        .is_some_and(|[low, _]| low > JOINT_FROM / JUST_BEFORE.0)
        && left.level * known.peaks[earlier].abs() > JOINT * level
    {
        return 0.0;
    }
    left.share * (known.peaks[earlier] / known.peaks[i]).abs()
}

/// A response that moves before its hit: it has not come to rest, or it begins before the hit.
fn moved_before(known: &Known<'_>, i: usize, before: usize) -> Option<HitFault> {
    let (starts, rate) = (known.starts, known.signals.rate);
    let (start, samples) = (starts[i], known.signals.response);
    let block = ((ONSET_S * rate.hz()) as usize).max(SHORTEST / 2);
    let earlier = if i == 0 { 0 } else { starts[i - 1] };
    // The rise of the pulse up to the level that counts as a hit is no time before it.
    let until = start.saturating_sub((before / 4).max(LEAST_BEFORE));
    let window = before.max(block);
    let from = until.saturating_sub(window).max(earlier);
    if until <= from + LEAST_BEFORE {
        return None;
    }
    let about = mean(&samples[earlier..until]);
    let level_of = |part: Range<usize>| {
        let squares: f64 = samples[part.clone()]
            .iter()
            .map(|v| (v - about).powi(2))
            .sum();
        (squares / part.len().max(1) as f64).sqrt()
    };
    let level = without_noise(level_of(from..until), known.noise);
    let next = starts.get(i + 1).copied().unwrap_or(samples.len());
    let after = (start + known.pulse).min(next);
    let end = (after + 20 * window).min(next);
    let largest = (after..end)
        .step_by(window)
        .map(|at| level_of(at..(at + window).min(end)))
        .fold(0.0, f64::max);
    // Nothing after it tells nothing of it.
    let share = if largest > 0.0 { level / largest } else { 0.0 };
    if share <= MOST_BEFORE {
        return None;
    }
    // Back to where it was at rest for a while.
    let limit = (OVER_NOISE * known.noise).max(QUIET.1 * level);
    let (mut at, mut onset, mut quiet) = (until, until, 0);
    while at >= earlier + block && quiet < QUIET.0 {
        if level_of(at - block..at) > limit {
            (onset, quiet) = (at - block, 0);
        } else {
            quiet += 1;
        }
        at -= block;
    }
    let lead = start - onset;
    // The response to the hit before falls all the way; one that begins early was at rest before.
    Some(if quiet >= QUIET.0 && 2 * lead < start - earlier {
        HitFault::ResponseFirst {
            lead_s: rate.duration_of(lead).0,
        }
    } else {
        HitFault::StillMoving { share }
    })
}
