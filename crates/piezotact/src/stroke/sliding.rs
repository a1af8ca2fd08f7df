//! Detection of sliding and of stick-slip of a finger in contact.

use super::force_warning::{ForceFault, ForceWarning};
use super::frames::{Frames, quantile, smoothed};
use crate::criterion::Limit;
use crate::statistics::{rms, standard_deviation};
use crate::warning::Warning;

/// The window of the short-time level of the vibration, s.
const LEVEL_WINDOW_S: f64 = 0.02;
/// The lag and the window of the level of the slower part, s.
const SLOW_LAG_S: f64 = 0.01;
const SLOW_WINDOW_S: f64 = 0.04;
/// Sliding vibrates this many times louder than a finger in the air.
pub(super) const ABOVE_FLOOR: f64 = 4.0;
/// Contacts whose vibration stands less than this many times above that without contact cross the limit of sliding by chance.
pub(super) const CLEARLY_ABOVE_FLOOR: f64 = 1.5 * ABOVE_FLOOR;
/// Sliding vibrates at least at this share of the contact's own level.
const OF_LEVEL: f64 = 0.1;
/// Pauses shorter than this do not interrupt sliding, s.
const LONGEST_GAP_S: f64 = 0.08;
/// Shorter sliding is the impact of landing, s.
const SHORTEST_RUN_S: f64 = 0.1;
/// Within a slip the friction falls by this share of its level …
const SLIP_DROP: f64 = 0.2;
/// … and by this many times the rms of what the noise of the forces changes it …
const ABOVE_NOISE: f64 = 4.0;
/// … within this time, s.
const SLIP_TIME_S: f64 = 0.016;
/// Friction is smoothed over this time before slips are looked for, s.
const SLIP_SMOOTHING_S: f64 = 0.006;
/// The noise of the friction is that at this quantile of the normal force.
const LIGHTEST: f64 = 0.1;
/// With a friction coefficient below this, slips are not looked for.
const LEAST_FRICTION: f64 = 0.1;
/// Friction that rises as fast as it falls in this share of its falls, more often than this, oscillates.
const SYMMETRIC: f64 = 0.9;
const OSCILLATES_HZ: f64 = 15.0;
/// The least number of slips for stick-slip …
const SLIPS: usize = 3;
/// … when they follow each other at this rate or faster, Hz.
const SLIP_RATE_HZ: f64 = 1.5;

/// The short-time level of a vibration in the frames `from`…`to`, which a gesture does not reach.
pub(super) fn vibration_level(
    frames: Frames,
    vibration: &[f64],
    from: usize,
    to: usize,
) -> Vec<f64> {
    frames.fast_level(vibration, from, to, frames.in_time(LEVEL_WINDOW_S))
}

/// The short-time level of the slower part of a vibration in the frames `from`…`to`, around 50 Hz, which a coarse texture makes at a low speed: the
/// root of the mean squares of the second difference of the frames' means over 10 ms, within 40 ms. A gesture of 2 Hz is weakened to 0.4 %.
fn slow_level(frames: Frames, vibration: &[f64], from: usize, to: usize) -> Vec<f64> {
    let lag = frames.in_time(SLOW_LAG_S);
    let outer = from.saturating_sub(lag);
    let means = frames.means_of(vibration, outer, to + lag);
    let Some(last) = means.len().checked_sub(1) else {
        return Vec::new();
    };
    let at = |i: usize| means[i.min(last)];
    let bend = |i: usize| {
        let here = i + from - outer;
        at(here + lag) - 2.0 * at(here) + at(here.saturating_sub(lag))
    };
    let squares: Vec<f64> = (0..to.saturating_sub(from))
        .map(|i| bend(i).powi(2))
        .collect();
    let mut level = smoothed(&squares, frames.in_time(SLOW_WINDOW_S));
    level
        .iter_mut()
        .for_each(|square| *square = square.max(0.0).sqrt());
    level
}

/// [`vibration_level`] of what is not alike after one period of a mains of `mains_hz`: hum and its harmonics cancel.
fn level_without_mains(
    mains_hz: f64,
    frames: Frames,
    vibration: &[f64],
    (from, to): (usize, usize),
) -> Vec<f64> {
    let period = frames.size as f64 * frames.rate_hz / mains_hz;
    let outer = from.saturating_sub(1);
    let last = ((to + 1) * frames.size).min(vibration.len());
    let before = |i: usize| {
        let at = (i as f64 - period).max(0.0);
        let (low, share) = (at as usize, at.fract());
        let next = vibration[(low + 1).min(i)];
        vibration[low] + share * (next - vibration[low])
    };
    let places = (outer * frames.size).min(last)..last;
    let changed: Vec<f64> = places.map(|i| vibration[i] - before(i)).collect();
    vibration_level(frames, &changed, from - outer, to - outer)
}

/// What else than the usual level of the vibration may show that a finger slides.
#[derive(Clone, Copy)]
enum OtherLevel {
    /// That of the slower part: a coarse texture at a low speed.
    Slow,
    /// That without a mains of 50 or 60 Hz.
    WithoutMains(f64),
}

impl OtherLevel {
    const ALL: [Self; 3] = [
        Self::Slow,
        Self::WithoutMains(50.0),
        Self::WithoutMains(60.0),
    ];

    fn of(self, frames: Frames, vibration: &[f64], from: usize, to: usize) -> Vec<f64> {
        match self {
            Self::Slow => slow_level(frames, vibration, from, to),
            Self::WithoutMains(hz) => level_without_mains(hz, frames, vibration, (from, to)),
        }
    }
}

/// The levels of a vibration while nothing touches: the usual one, and the others.
#[derive(Clone, Copy)]
pub(super) struct Floors {
    usual: f64,
    others: [Option<f64>; 3],
}

impl Floors {
    /// Those in the `lifts`; `None` where there are too few.
    pub(super) fn of(frames: Frames, vibration: &[f64], lifts: &[(usize, usize)]) -> Option<Self> {
        Some(Self {
            usual: floor(frames, vibration, lifts, vibration_level)?,
            others: OtherLevel::ALL.map(|level| {
                floor(frames, vibration, lifts, |frames, all, from, to| {
                    level.of(frames, all, from, to)
                })
            }),
        })
    }

    /// The level of the vibration in the frames `from`…`to`, and that without contact: another level where the usual one does not show that the
    /// finger slides and that one does, clearly.
    pub(super) fn level_in(
        self,
        frames: Frames,
        vibration: &[f64],
        (from, to): (usize, usize),
    ) -> (Vec<f64>, f64) {
        let level = vibration_level(frames, vibration, from, to);
        if loudness(&level) >= CLEARLY_ABOVE_FLOOR * self.usual {
            return (level, self.usual);
        }
        let others = OtherLevel::ALL.into_iter().zip(self.others);
        let others = others.filter_map(|(other, floor)| {
            let (level, floor) = (other.of(frames, vibration, from, to), floor?);
            (loudness(&level) >= CLEARLY_ABOVE_FLOOR * floor).then_some((level, floor))
        });
        let ratio = |(level, floor): &(Vec<f64>, f64)| loudness(level) / floor;
        let clearest = others.max_by(|a, b| ratio(a).total_cmp(&ratio(b)));
        clearest.unwrap_or((level, self.usual))
    }
}

/// The level of a vibration while nothing touches: the 90 % quantile of the frames in the lifts, the first 100 ms
/// of each; `None` where there are too few.
fn floor(
    frames: Frames,
    vibration: &[f64],
    lifts: &[(usize, usize)],
    level: impl Fn(Frames, &[f64], usize, usize) -> Vec<f64>,
) -> Option<f64> {
    let most = frames.in_time(0.1);
    let levels: Vec<f64> = lifts
        .iter()
        .flat_map(|(from, to)| level(frames, vibration, *from, (*to).min(from + most)))
        .collect();
    (levels.len() > 20).then(|| quantile(&levels, 0.9))
}

/// The parts of a contact in which the vibration says that the finger slides, in frames of the contact.
pub(super) fn sliding_parts(frames: Frames, level: &[f64], floor: f64) -> Vec<(usize, usize)> {
    let threshold = (ABOVE_FLOOR * floor).max(OF_LEVEL * loudness(level));
    runs(frames, level, threshold)
}

/// The level of the vibration in a contact: its upper quartile.
pub(super) fn loudness(level: &[f64]) -> f64 {
    quantile(level, 0.75)
}

/// The parts of a contact in which the friction says that the finger slides: half of what is `usual` in the
/// contacts of the recording, or of its own level where that is more.
pub(super) fn sliding_by_friction(
    frames: Frames,
    ratio: &[f64],
    usual: f64,
) -> Vec<(usize, usize)> {
    runs(frames, ratio, 0.5 * friction_level(ratio).max(usual))
}

/// The level of friction in a contact: its upper quartile.
pub(super) fn friction_level(ratio: &[f64]) -> f64 {
    quantile(ratio, 0.75)
}

fn runs(frames: Frames, values: &[f64], threshold: f64) -> Vec<(usize, usize)> {
    let mut found: Vec<(usize, usize)> = Vec::new();
    let gap = frames.in_time(LONGEST_GAP_S);
    let mut open = None;
    for i in 0..=values.len() {
        let above = values.get(i).is_some_and(|value| *value > threshold);
        match (above, open) {
            (true, None) => open = Some(i),
            (false, Some(start)) => {
                match found.last_mut() {
                    Some(last) if start - last.1 <= gap => last.1 = i,
                    _ => found.push((start, i)),
                }
                open = None;
            }
            _ => {}
        }
    }
    let shortest = frames.in_time(SHORTEST_RUN_S);
    found.retain(|(start, end)| end - start >= shortest);
    // The window shows an edge up to half its width too early, and less the weaker the vibration is.
    let blur = frames.in_time(LEVEL_WINDOW_S) / 4;
    for (start, end) in &mut found {
        *start = if *start > 0 {
            (*start + blur).min(*end)
        } else {
            0
        };
        *end = if *end < values.len() {
            end.saturating_sub(blur).max(*start)
        } else {
            *end
        };
    }
    found
}

/// Slips in a stretch of friction (tangential over normal force, frame by frame): how many, and how many a
/// second; `None` unless they make stick-slip.
///
/// A slip is a fall of the friction by a fifth of its level within 16 ms, which a hand cannot do, and by more than the `noise` of the forces
/// makes of it in that time: the rms of the change, smoothed over 6 ms. Where friction rises as fast as it falls more than 15 times a second, nothing sticks.
pub(super) fn stick_slip_in_friction(
    frames: Frames,
    ratio: &[f64],
    noise: f64,
) -> Option<(usize, f64)> {
    let level = quantile(ratio, 0.5);
    // Next to no friction is a finger at rest, or noise.
    if level < LEAST_FRICTION {
        return None;
    }
    let smooth = smoothed(ratio, frames.in_time(SLIP_SMOOTHING_S));
    let reach = frames.in_time(SLIP_TIME_S);
    let drop = (SLIP_DROP * level).max(ABOVE_NOISE * noise);
    let falls = |sign: f64| {
        let (mut count, mut i) = (0, reach);
        while i < smooth.len() {
            if sign * (smooth[i - reach] - smooth[i]) > drop {
                count += 1;
                i += 2 * reach;
            } else {
                i += 1;
            }
        }
        count
    };
    let slips = falls(1.0);
    // What rises as fast as it falls, and often, is no sticking: a coarse texture, or the cell that rings.
    let is_fast = slips as f64 > OSCILLATES_HZ * frames.seconds(ratio.len().max(1));
    if is_fast && falls(-1.0) as f64 > SYMMETRIC * slips as f64 {
        return None;
    }
    enough(frames, slips, ratio.len())
}

/// What forces change without contact, as the noise of their sensors.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct ForceNoise {
    /// The rms of the samples of the noisiest axis, N.
    pub(super) rms_n: f64,
    /// The rms of the change within the time of a slip, smoothed as friction is: of the normal force, N.
    normal_n: f64,
    /// That of all tangential forces together, N.
    tangential_n: f64,
}

impl ForceNoise {
    /// The noise in the `lifts`: the median over them, as some may hold light touches; 0 without lifts. `level_n` is the normal force above its
    /// zero frame by frame, `normal_n` its samples.
    pub(super) fn of(
        frames: Frames,
        (level_n, normal_n): (&[f64], &[f64]),
        tangential_n: &[&[f64]],
        lifts: &[(usize, usize)],
    ) -> Self {
        // The middle 200 ms of a lift are enough.
        let reach = frames.in_time(0.1);
        let over_lifts = |of: &dyn Fn(usize, usize) -> f64| {
            let each = lifts.iter().map(|(from, to)| {
                let middle = (from + to) / 2;
                of(
                    (*from).max(middle.saturating_sub(reach)),
                    (*to).min(middle + reach),
                )
            });
            quantile(&each.collect::<Vec<_>>(), 0.5)
        };
        let axes = tangential_n.iter();
        let squares = axes.map(|axis| {
            over_lifts(&|from, to| change(frames, &frames.means_of(axis, from, to))).powi(2)
        });
        let size = frames.size;
        let all = tangential_n.iter().chain([&normal_n]);
        let rms = all.map(|axis| {
            over_lifts(&|from, to| {
                standard_deviation(&axis[from * size..(to * size).min(axis.len())])
            })
        });
        Self {
            rms_n: rms.fold(0.0, f64::max),
            normal_n: over_lifts(&|from, to| change(frames, &level_n[from..to])),
            tangential_n: squares.sum::<f64>().sqrt(),
        }
    }

    /// The rms of what it changes a friction of `ratio` under a normal force of `level_n` within the time of a slip.
    ///
    /// Formula: δµ² = (δt² + µ²·δn²)/n², n where the finger presses least: the 10 % quantile.
    pub(super) fn of_friction(self, ratio: &[f64], level_n: &[f64]) -> f64 {
        let (friction, level_n) = (quantile(ratio, 0.5), quantile(level_n, LIGHTEST));
        let noise_n = self.tangential_n.hypot(friction * self.normal_n);
        if level_n > 0.0 {
            noise_n / level_n
        } else {
            0.0
        }
    }

    /// The warning that it hides slips, where the least that shows is more than stick-slip makes.
    pub(super) fn warning(self, least_slip: f64) -> Option<Warning> {
        (least_slip > SLIP_DROP).then(|| {
            let fault = ForceFault::SlipsHidden {
                noise_n: self.rms_n,
                least_slip,
            };
            Warning::from(ForceWarning::Doubtful { fault })
        })
    }

    /// The least slip that shows above it, as a share of a friction of `ratio` under `level_n`: a fifth where there is no noise.
    pub(super) fn least_slip(self, ratio: &[f64], level_n: &[f64]) -> f64 {
        let friction = quantile(ratio, 0.5).max(f64::MIN_POSITIVE);
        (ABOVE_NOISE * self.of_friction(ratio, level_n) / friction).max(SLIP_DROP)
    }
}

/// The rms of the change of `values`, frame by frame, within the time of a slip, smoothed as friction is; 0 where they are too few.
fn change(frames: Frames, values: &[f64]) -> f64 {
    let smooth = smoothed(values, frames.in_time(SLIP_SMOOTHING_S));
    let reach = frames.in_time(SLIP_TIME_S);
    let (before, after) = (smooth.iter(), smooth.iter().skip(reach));
    let changes: Vec<f64> = before.zip(after).map(|(a, b)| b - a).collect();
    rms(&changes)
}

/// Slips in a stretch of vibration where no tangential force was measured: bursts out of near silence.
pub(super) fn stick_slip_in_vibration(frames: Frames, level: &[f64]) -> Option<(usize, f64)> {
    let [quiet, middle, loud] = [0.25, 0.5, 0.95].map(|share| quantile(level, share));
    // Noise-like vibration spreads by a factor of two in 20 ms; bursts by ten.
    if loud < 8.0 * quiet.max(f64::MIN_POSITIVE) {
        return None;
    }
    let threshold = (3.0 * middle).min(0.5 * loud);
    let mut bursts = 0;
    let mut armed = true;
    for value in level {
        if armed && *value > threshold {
            bursts += 1;
            armed = false;
        } else if *value < 0.5 * threshold {
            armed = true;
        }
    }
    enough(frames, bursts, level.len())
}

/// Slips that follow each other so slowly are no stick-slip.
pub(super) fn slower_slips() -> Limit {
    Limit::AtMost {
        met: SLIP_RATE_HZ.next_down(),
        not_met: SLIP_RATE_HZ.next_down(),
    }
}

fn enough(frames: Frames, slips: usize, length: usize) -> Option<(usize, f64)> {
    let rate_hz = slips as f64 / frames.seconds(length.max(1));
    (slips >= SLIPS && rate_hz >= SLIP_RATE_HZ).then_some((slips, rate_hz))
}

#[cfg(test)]
mod tests {
    use super::*;

    const FRAMES: Frames = Frames {
        size: 10,
        rate_hz: 500.0,
    };

    #[test]
    fn a_sawtooth_of_friction_is_stick_slip_and_a_wandering_one_is_not() {
        let saw: Vec<f64> = (0..500)
            .map(|i| 0.8 + 0.8 * (f64::from(i) / 80.0).fract())
            .collect();
        let (slips, rate_hz) = stick_slip_in_friction(FRAMES, &saw, 0.0).unwrap();
        assert!((5..=6).contains(&slips) && (rate_hz - 6.0).abs() < 1.5);
        let wander: Vec<f64> = (0..500)
            .map(|i| 0.8 + 0.4 * (f64::from(i) / 60.0).sin())
            .collect();
        assert_eq!(stick_slip_in_friction(FRAMES, &wander, 0.0), None);
        // A grating of 1 mm at 30 mm/s changes friction by 15 % of either sign, 30 times a second.
        let grating: Vec<f64> = (0..500)
            .map(|i| 0.6 + 0.09 * (f64::from(i) / 500.0 * 30.0 * std::f64::consts::TAU).sin())
            .collect();
        assert_eq!(stick_slip_in_friction(FRAMES, &grating, 0.0), None);
        // Slips of half of the friction within noise that changes it by a quarter of that at the most.
        assert!(stick_slip_in_friction(FRAMES, &saw, 0.1).is_some());
        assert_eq!(stick_slip_in_friction(FRAMES, &saw, 0.3), None);
    }

    #[test]
    fn a_knock_is_no_sliding_and_a_short_pause_no_interruption() {
        let mut level = vec![0.01; 600];
        level[0..20].fill(1.0);
        level[200..400].fill(1.0);
        level[280..300].fill(0.01);
        let parts = sliding_parts(FRAMES, &level, 0.01);
        assert_eq!(parts, [(202, 398)]);
    }
}
