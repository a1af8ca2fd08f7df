//! Contact detection: the normal force above its own baseline, with hysteresis.

use super::Signals;
use super::force_warning::{ForceFault, ForceWarning};
use super::frames::{Frames, quantile, smoothed};
use crate::statistics::standard_deviation;
use crate::warning::Warning;

/// The largest drift of a force cell's zero, N/s: a strain gauge moves 1 mN a minute, a charge amplifier some
/// 50 mN in 20 s, a bad one more. The middle of a contact of 4 s thus lifts the first baseline by 40 mN.
const DRIFT_N_PER_S: f64 = 0.02;
/// The window in which the baseline is looked for, s: it must hold a lift.
const BASELINE_WINDOW_S: f64 = 5.0;
/// While the baseline is only roughly known, the finger counts as lifted only below this share of the contact threshold.
const FIRST_OFF_SHARE: f64 = 0.4;
/// The distance kept from the surrounding contacts when lifts are evaluated, s.
const GUARD_S: f64 = 0.1;
/// The share of a window's frames that lie below the baseline's first estimate.
const BASELINE_SHARE: f64 = 0.1;

/// A force that fluctuates by this share of the contact threshold where it is quietest is smoothed over this time, s.
const NOISY: f64 = 0.25;
pub(super) const HUM_SMOOTHING_S: f64 = 0.04;
/// A finger lands and leaves within twice this time, s.
const EDGE_S: f64 = 0.1;
/// One of two sides vibrates clearly more from this ratio on, and from the second one where the force changes by less than half of its distance
/// from zero; each needs so many looks.
const CLEARLY: f64 = 1.5;
const CLEARLY_HELD: f64 = 4.0;
const FEWEST_LOOKS: usize = 5;
/// A force that is lifted and pressed stands at its ends: less than this share of the time in the middle half of its range.
const WANDERS: f64 = 0.4;
/// An end of the force is near zero within this share of the other.
const AT_ZERO: f64 = 0.1;

/// The force above its baseline, frame by frame, with what was found on the way.
#[derive(Clone, Debug)]
pub(super) struct Force {
    /// N above the baseline, smoothed.
    pub(super) level_n: Vec<f64>,
    /// The baseline, N.
    pub(super) baseline: Polyline,
    /// The windows without contact, in frames.
    pub(super) lifts: Vec<(usize, usize)>,
}

impl Force {
    /// The zero of another axis of the same cell: the line through its medians in the lifts; 0 without lifts.
    pub(super) fn zero_of(&self, frames: Frames, axis: &[f64]) -> Polyline {
        let reach = frames.in_time(0.1);
        let points = self.lifts.iter().map(|(from, to)| {
            // The middle 200 ms of a lift are enough.
            let middle = (from + to) / 2;
            let (from, to) = (
                (*from).max(middle.saturating_sub(reach)),
                (*to).min(middle + reach),
            );
            (middle, quantile(&frames.means_of(axis, from, to), 0.5))
        });
        Polyline(points.collect())
    }
}

/// `means_n` of a force, smoothed over `smoothing_s`; over 40 ms, two periods of the mains, where it fluctuates by more than a quarter of `on_n` in
/// its quietest tenth, with a warning: what nobody touches would look like contacts.
pub(super) fn quiet(
    frames: Frames,
    means_n: &[f64],
    (smoothing_s, on_n): (f64, f64),
    warnings: &mut Vec<Warning>,
) -> Vec<f64> {
    let smooth_n = smoothed(means_n, frames.in_time(smoothing_s));
    let windows = smooth_n.chunks_exact(frames.in_time(0.1));
    let each: Vec<f64> = windows.map(standard_deviation).collect();
    let noise_n = quantile(&each, 0.1);
    if noise_n <= NOISY * on_n || smoothing_s >= HUM_SMOOTHING_S {
        return smooth_n;
    }
    warnings.push(Warning::from(ForceWarning::Doubtful {
        fault: ForceFault::Fluctuates {
            noise_n,
            threshold_n: on_n,
            smoothing_ms: 1e3 * HUM_SMOOTHING_S,
        },
    }));
    smoothed(means_n, frames.in_time(HUM_SMOOTHING_S))
}

/// The smoothed force above a baseline that follows the cell's drift: first the lower envelope of the force that
/// rises no faster than a cell drifts, then the line through the medians of the lifts. For touches of seconds with
/// lifts between them.
pub(super) fn above_drifting_zero(frames: Frames, smooth_n: Vec<f64>, on_n: f64) -> Force {
    let envelope = lower_envelope(frames, &smooth_n);
    above(frames, smooth_n, envelope, on_n)
}

/// The smoothed force above its rest level, and then above the line through the medians of the lifts; for touches
/// that may last for minutes. `None` when the force never leaves one level: it changes by less than a contact needs, or wanders about a
/// load far from zero without standing at its ends.
pub(super) fn above_rest(frames: Frames, smooth_n: Vec<f64>, on_n: f64) -> Option<Force> {
    let (rest_n, held_n) = (quantile(&smooth_n, 0.02), quantile(&smooth_n, 0.98));
    let quarter = 0.25 * (held_n - rest_n);
    let between = |n: &&f64| **n > rest_n + quarter && **n < held_n - quarter;
    let wanders = smooth_n.iter().filter(between).count() as f64 > WANDERS * smooth_n.len() as f64;
    let is_loaded = rest_n > 0.5 * held_n && wanders;
    (held_n - rest_n > on_n && !is_loaded).then(|| {
        let drift = drift_between_lifts(frames, &smooth_n, on_n);
        let zero = drift.unwrap_or_else(|| Polyline(vec![(0, rest_n)]));
        above(frames, smooth_n, zero, on_n)
    })
}

/// The zero through the lifts that begin with a fast fall of the force and end with a fast rise, whatever their level; `None` where they are within
/// the level of a lift, or too far from each other for a drift: a load that steps is no lift.
fn drift_between_lifts(frames: Frames, smooth_n: &[f64], on_n: f64) -> Option<Polyline> {
    let reach = frames.in_time(EDGE_S);
    let edges_n: Vec<f64> = (smooth_n.iter().zip(smooth_n.iter().skip(2 * reach)))
        .map(|(before, after)| after - before)
        .collect();
    let steps: Vec<f64> = edges_n.iter().map(|step| step.abs()).collect();
    let least_n = (0.5 * quantile(&steps, 0.995)).max(on_n);
    // Where the force has risen and where it has fallen.
    let mut edges: Vec<(usize, bool)> = Vec::new();
    for rises in [true, false] {
        let signed = edges_n.iter().map(|step| if rises { *step } else { -step });
        let found = events(signed, least_n, 0.5 * least_n);
        edges.extend(
            found
                .iter()
                .map(|(from, to)| ((from + to) / 2 + reach, rises)),
        );
    }
    edges.sort_unstable();
    let mut touches: Vec<(usize, usize)> = Vec::new();
    let mut touching = edges.first().is_some_and(|(_, rises)| !rises).then_some(0);
    for (at, rises) in edges {
        match (touching, rises) {
            (None, true) => touching = Some(at),
            (Some(from), false) => {
                touches.push((from, at));
                touching = None;
            }
            _ => return None,
        }
    }
    touches.extend(touching.map(|from| (from, smooth_n.len())));
    let lifts = lifts(frames, smooth_n.len(), &touches);
    let medians = lifts.iter().map(|(from, to)| {
        let level_n = quantile(&smooth_n[*from..*to], 0.5);
        ((from + to) / 2, level_n)
    });
    let medians: Vec<(usize, f64)> = medians.collect();
    let almost_n = FIRST_OFF_SHARE * on_n;
    let drifts = medians.windows(2).all(|pair| {
        let apart_s = frames.seconds(pair[1].0 - pair[0].0);
        (pair[1].1 - pair[0].1).abs() <= DRIFT_N_PER_S * apart_s + almost_n
    });
    let zero = Polyline(medians);
    let (low_n, high_n) = zero.range();
    (drifts && high_n - low_n > almost_n).then_some(zero)
}

fn above(frames: Frames, smooth_n: Vec<f64>, envelope: Polyline, on_n: f64) -> Force {
    // One signal of an hour's frames is moved from zero to zero in place.
    let mut level_n = smooth_n;
    envelope.take_from(&mut level_n, 0);
    // The force during a lift must be far below the contact threshold: a light touch is not a lift.
    let almost_n = FIRST_OFF_SHARE * on_n;
    let touches = events(level_n.iter().copied(), almost_n, almost_n);
    let lifts = lifts(frames, level_n.len(), &touches);
    let medians = lifts.iter().map(|(from, to)| {
        let middle = (from + to) / 2;
        (
            middle,
            quantile(&level_n[*from..*to], 0.5) + envelope.at(middle),
        )
    });
    let medians = Polyline(medians.collect());
    if medians.0.is_empty() {
        return Force {
            level_n,
            baseline: envelope,
            lifts,
        };
    }
    envelope.negated().take_from(&mut level_n, 0);
    medians.take_from(&mut level_n, 0);
    Force {
        level_n,
        baseline: medians,
        lifts,
    }
}

/// The sign that makes `force_n`, the means of frames, positive in contact, and how many times as much the finger vibrates without contact by it,
/// where that contradicts it. A force that is near zero at one of its ends is in contact at the other, unless the tangential forces say the
/// contrary: a robot vibrates on its way back too. Otherwise contact is where the finger vibrates or, where that does not tell, where the force
/// is farther from zero. Where it is known in which frames the surface `moves`, those are compared first: a finger that rests in contact does
/// not vibrate either. Short windows at some hundred places are enough.
pub(super) fn polarity(
    frames: Frames,
    force_n: &[f64],
    signals: &Signals<'_>,
    moves: Option<&[bool]>,
) -> (f64, Option<f64>) {
    let (bottom, top) = (quantile(force_n, 0.02), quantile(force_n, 0.98));
    let far = if top < 0.5 * bottom.abs() && bottom < 0.0 {
        -1.0
    } else {
        1.0
    };
    let Some(vibration) = signals.vibration else {
        return (far, None);
    };
    let width = frames.in_time(0.05);
    let step = (force_n.len() / 400).max(width);
    let places = (0..force_n.len().saturating_sub(width)).step_by(step);
    let middle = |values: &[f64]| quantile(values, 0.5);
    let all = places.clone().map(|from| {
        let level = frames.fast_level(vibration, from, from + width, width);
        (
            level.iter().sum::<f64>(),
            middle(&force_n[from..from + width]),
        )
    });
    let mut looks: Vec<(f64, f64)> = all.collect();
    let moved = moves.map_or_else(Vec::new, |moves| {
        let here = |from: usize| moves.get(from + width / 2) == Some(&true);
        let moved = places.clone().zip(&looks).filter(|(from, _)| here(*from));
        moved.map(|(_, look)| *look).collect()
    });
    // A finger that is held in contact presses and vibrates more in one direction than in the other.
    let may_be_held = top - bottom < 0.5 * top.abs().max(bottom.abs());
    let clearly = if may_be_held { CLEARLY_HELD } else { CLEARLY };
    let side = |looks: &[(f64, f64)]| louder_side(looks, 0.2 * (top - bottom), clearly);
    let louder = side(&moved).or_else(|| side(&looks));
    let near = |end: f64| end.abs() < AT_ZERO * top.abs().max(bottom.abs());
    let by_zero = match (near(bottom), near(top)) {
        (true, false) => Some(1.0),
        (false, true) => Some(-1.0),
        _ => None,
    };
    if let (Some(sign), Some((louder, ratio))) = (by_zero, louder)
        && sign != louder
    {
        let axes = signals.tangential_force_n.iter();
        let axes = axes.map(|axis| {
            let means = places.clone();
            let means = means.map(|from| middle(&frames.means_of(axis, from, from + width)));
            means.collect::<Vec<f64>>()
        });
        let contact = |n: f64| (n > 0.5 * (bottom + top)) == (sign > 0.0);
        return match more_friction_where(contact, &looks, &axes.collect::<Vec<_>>()) {
            Some(false) => (louder, None),
            Some(true) | None => (sign, Some(ratio)),
        };
    }
    if let Some((sign, _)) = louder {
        return (sign, None);
    }
    looks.sort_by(|a, b| a.0.total_cmp(&b.0));
    let share = looks.len() / 5;
    if share < 3 || moves.is_some() {
        return (far, None);
    }
    let middle_of =
        |part: &[(f64, f64)]| middle(&part.iter().map(|look| look.1).collect::<Vec<_>>());
    let rise_n = middle_of(&looks[looks.len() - share..]) - middle_of(&looks[..share]);
    // Less than a fifth of the range is not significant: a force that hardly differs, or a signal that is quiet throughout.
    let sign = if rise_n.abs() < 0.2 * (top - bottom) {
        far
    } else {
        rise_n.signum()
    };
    (sign, None)
}

/// Whether the tangential forces of `axes`, one value for each of `looks`, are farther from zero where the normal force is that of a `contact`;
/// none where neither side has twice as much.
fn more_friction_where(
    contact: impl Fn(f64) -> bool,
    looks: &[(f64, f64)],
    axes: &[Vec<f64>],
) -> Option<bool> {
    let magnitude = |touches: bool| {
        let here = looks.iter().enumerate();
        let here = here.filter(|(_, look)| contact(look.1) == touches);
        let values = here.map(|(i, _)| axes.iter().map(|axis| axis[i].powi(2)).sum::<f64>());
        quantile(&values.map(f64::sqrt).collect::<Vec<_>>(), 0.5)
    };
    let (touching, lifted) = (magnitude(true), magnitude(false));
    match (touching > 2.0 * lifted, lifted > 2.0 * touching) {
        (true, _) => Some(true),
        (_, true) => Some(false),
        _ => None,
    }
}

/// The side of the middle of the force on which `looks` (the level of the vibration and the force) vibrate `clearly` times as much in their upper
/// quartile, and not so much less in their lower one, and how many times; `None` where there is no such side, or the forces of both differ by less than `least_n`.
fn louder_side(looks: &[(f64, f64)], least_n: f64, clearly: f64) -> Option<(f64, f64)> {
    let forces: Vec<f64> = looks.iter().map(|look| look.1).collect();
    let middle_n = 0.5 * (quantile(&forces, 0.02) + quantile(&forces, 0.98));
    let side = |is_above: bool| {
        let side = looks.iter().filter(|look| (look.1 > middle_n) == is_above);
        let (levels, forces): (Vec<f64>, Vec<f64>) = side.copied().unzip();
        let quartiles = [0.25, 0.75].map(|share| quantile(&levels, share));
        (levels.len() >= FEWEST_LOOKS).then(|| (quartiles, quantile(&forces, 0.5)))
    };
    let ((high, high_n), (low, low_n)) = (side(true)?, side(false)?);
    if high_n - low_n < least_n {
        return None;
    }
    let louder = |a: [f64; 2], b: [f64; 2]| a[1] > clearly * b[1] && b[0] <= clearly * a[0];
    match (louder(high, low), louder(low, high)) {
        (true, _) => Some((1.0, high[1] / low[1])),
        (_, true) => Some((-1.0, low[1] / high[1])),
        _ => None,
    }
}

/// Straight lines between points of frames and values, level before the first and after the last; 0 without points.
#[derive(Clone, Debug)]
pub(super) struct Polyline(pub(super) Vec<(usize, f64)>);

impl Polyline {
    /// Takes the line away from `values`, the first of which stands at frame `from`.
    pub(super) fn take_from(&self, values: &mut [f64], from: usize) {
        let points = self.0.as_slice();
        let mut done = 0;
        while done < values.len() {
            let at = from + done;
            let next = points.partition_point(|(frame, _)| *frame <= at);
            let before = next.checked_sub(1).and_then(|k| points.get(k));
            let (level, slope, end) = match (before, points.get(next)) {
                (Some(a), Some(b)) => {
                    let slope = (b.1 - a.1) / (b.0 - a.0) as f64;
                    (a.1 + slope * (at - a.0) as f64, slope, b.0)
                }
                (None, Some(first)) => (first.1, 0.0, first.0),
                (Some(last), None) => (last.1, 0.0, usize::MAX),
                (None, None) => return,
            };
            let until = values.len().min(end - from);
            for (i, value) in values[done..until].iter_mut().enumerate() {
                *value -= level + slope * i as f64;
            }
            done = until;
        }
    }

    fn negated(&self) -> Self {
        Self(self.0.iter().map(|(at, value)| (*at, -value)).collect())
    }

    /// The value at one frame.
    pub(super) fn at(&self, frame: usize) -> f64 {
        let mut value = [0.0];
        self.take_from(&mut value, frame);
        -value[0]
    }

    /// The lowest and the highest value; 0 without points.
    pub(super) fn range(&self) -> (f64, f64) {
        let values = || self.0.iter().map(|(_, value)| *value);
        match self.0.as_slice() {
            [] => (0.0, 0.0),
            _ => (
                values().fold(f64::MAX, f64::min),
                values().fold(f64::MIN, f64::max),
            ),
        }
    }
}

fn lower_envelope(frames: Frames, smooth: &[f64]) -> Polyline {
    let step = frames.in_time(1.0);
    let half = frames.in_time(BASELINE_WINDOW_S) / 2;
    let mut anchors: Vec<f64> = (0..smooth.len().div_ceil(step).max(1))
        .map(|i| {
            let centre = i * step;
            let (from, to) = (
                centre.saturating_sub(half),
                (centre + half + 1).min(smooth.len()),
            );
            quantile(&smooth[from..to], BASELINE_SHARE)
        })
        .collect();
    let rise = DRIFT_N_PER_S * frames.seconds(step);
    for i in 1..anchors.len() {
        anchors[i] = anchors[i].min(anchors[i - 1] + rise);
    }
    for i in (1..anchors.len()).rev() {
        anchors[i - 1] = anchors[i - 1].min(anchors[i] + rise);
    }
    let points = anchors.into_iter().enumerate();
    Polyline(points.map(|(i, level)| (i * step, level)).collect())
}

/// The windows, in frames, in which nothing touches: every lift without its edges, in pieces of a second at most,
/// since a zero can bend in a long one.
fn lifts(frames: Frames, length: usize, touches: &[(usize, usize)]) -> Vec<(usize, usize)> {
    let guard = frames.in_time(GUARD_S);
    let shortest = frames.in_time(0.1);
    let longest = frames.in_time(1.0);
    let mut edges = vec![0];
    for (start, end) in touches {
        edges.extend([*start, *end]);
    }
    edges.push(length);
    let mut windows = Vec::new();
    for lift in edges.chunks_exact(2) {
        let from = if lift[0] > 0 { lift[0] + guard } else { 0 };
        let to = if lift[1] < length {
            lift[1].saturating_sub(guard)
        } else {
            length
        };
        if to < from + shortest {
            continue;
        }
        let parts = (to - from).div_ceil(longest);
        windows.extend((0..parts).map(|part| {
            (
                from + (to - from) * part / parts,
                from + (to - from) * (part + 1) / parts,
            )
        }));
    }
    windows
}

/// The parts above `off_n` that hold a value above `on_n`, as frames from…to.
pub(super) fn events(
    level_n: impl IntoIterator<Item = f64>,
    on_n: f64,
    off_n: f64,
) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut length = 0;
    let mut open: Option<(usize, f64)> = None;
    for (i, level) in level_n.into_iter().enumerate() {
        length = i + 1;
        if level > off_n {
            let (_, highest) = open.get_or_insert((i, level));
            *highest = highest.max(level);
        } else if let Some((start, highest)) = open.take()
            && highest > on_n
        {
            found.push((start, i));
        }
    }
    if let Some((start, highest)) = open
        && highest > on_n
    {
        found.push((start, length));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    use crate::stroke::frames::smoothed;

    const FRAMES: Frames = Frames {
        size: 10,
        rate_hz: 500.0,
    };

    /// Ten touches of 0.2 N on a zero that climbs through the threshold are ten touches.
    #[test]
    fn the_baseline_follows_a_drift_through_the_threshold() {
        let force: Vec<f64> = (0..10_000)
            .map(|i| {
                let t = f64::from(i) / 500.0;
                let touch = if t % 2.0 > 0.5 && t % 2.0 < 1.6 {
                    0.2
                } else {
                    0.0
                };
                touch + 0.008 * t
            })
            .collect();
        let found = above_drifting_zero(FRAMES, smoothed(&force, 5), 0.1);
        let touches = events(found.level_n.iter().copied(), 0.1, 0.02);
        assert_eq!(touches.len(), 10, "{touches:?}");
        for (i, (start, end)) in touches.iter().enumerate() {
            let (from, to) = (i as f64 * 2.0 + 0.5, i as f64 * 2.0 + 1.6);
            assert!((*start as f64 / 500.0 - from).abs() < 0.02, "{touches:?}");
            assert!((*end as f64 / 500.0 - to).abs() < 0.02, "{touches:?}");
        }
    }

    /// A finger that is lifted at the start and the end alone, or now and then, on a zero that drifts beyond the threshold, either way: the level in
    /// contact is the load. A load that steps is no drift.
    #[test]
    fn a_rest_that_drifts_is_followed_from_lift_to_lift() {
        for drift in [-0.01, -0.004, 0.0, 0.004, 0.01] {
            for lifts_s in [&[0.0, 21.0][..], &[0.0, 7.0, 14.0, 21.0]] {
                let force: Vec<f64> = (0..11_500)
                    .map(|i| {
                        let t = f64::from(i) / 500.0;
                        let lifted = lifts_s.iter().any(|from| t >= *from && t < from + 2.0);
                        (if lifted { 0.0 } else { 0.5 }) + drift * t
                    })
                    .collect();
                let found = above_rest(FRAMES, smoothed(&force, 5), 0.05).unwrap();
                let touches = events(found.level_n.iter().copied(), 0.05, 0.025);
                assert_eq!(touches.len(), lifts_s.len() - 1, "{drift} {lifts_s:?}");
                for (from, to) in touches {
                    let level_n = quantile(&found.level_n[from..to], 0.5);
                    assert!((level_n - 0.5).abs() < 0.003, "{drift} {level_n}");
                }
            }
        }
        let stepped: Vec<f64> = (0..11_500)
            .map(|i| match f64::from(i) / 500.0 {
                t if !(2.0..21.0).contains(&t) => 0.0,
                t if t < 10.0 => 1.0,
                _ => 0.4,
            })
            .collect();
        let found = above_rest(FRAMES, smoothed(&stepped, 5), 0.05).unwrap();
        assert!((quantile(&found.level_n[6_000..9_000], 0.5) - 0.4).abs() < 0.003);
    }

    #[test]
    fn hysteresis_needs_both_thresholds() {
        let level = [0.0, 0.05, 0.03, 0.0, 0.03, 0.15, 0.05, 0.15, 0.0, 0.2];
        assert_eq!(events(level, 0.1, 0.02), [(4, 8), (9, 10)]);
    }
}
