//! Where a finger touches: the normal force above its own baseline, with hysteresis.

use super::frames::{Frames, quantile, smoothed};

/// How fast a force cell's zero may wander, N/s: a strain gauge moves 1 mN a minute, a charge amplifier some
/// 50 mN in 20 s. A contact of 4 s thus lifts the baseline by 40 mN at most.
const DRIFT_N_PER_S: f64 = 0.01;
/// The window in which the baseline is looked for, s: it must hold a lift.
const BASELINE_WINDOW_S: f64 = 5.0;
/// Where a contact ends while the baseline is only roughly known, as a share of where it begins.
const FIRST_OFF_SHARE: f64 = 0.4;
/// Lifts are looked at this far from the contacts around them, s.
const GUARD_S: f64 = 0.1;
/// The share of a window's frames that lie below the baseline's first estimate.
const BASELINE_SHARE: f64 = 0.1;

/// The force above its baseline, frame by frame, with what was found on the way.
#[derive(Clone, Debug)]
pub(super) struct Force {
    /// N above the baseline, smoothed.
    pub(super) level_n: Vec<f64>,
    /// The baseline, N.
    pub(super) baseline_n: Vec<f64>,
    /// The windows in which nothing touches, in frames.
    pub(super) lifts: Vec<(usize, usize)>,
}

impl Force {
    /// The zero of another axis of the same cell: the line through its medians in the lifts; 0 without lifts.
    pub(super) fn zero_of(&self, means: &[f64]) -> Vec<f64> {
        interpolated(&medians(means, &self.lifts), means.len())
    }

    /// The zeros at the middle of every lift: sample, and one value for each axis, the normal one first.
    pub(super) fn zeros(&self, frames: Frames, tangential: &[Vec<f64>]) -> Vec<(usize, Vec<f64>)> {
        self.lifts
            .iter()
            .map(|(from, to)| {
                let at = (from + to) / 2;
                let normal = self.baseline_n.get(at).copied().unwrap_or(0.0);
                let others = tangential.iter().map(|means| {
                    let (from, to) = (*from, (*to).min(means.len()));
                    quantile(&mut means[from.min(to)..to].to_vec(), 0.5)
                });
                let all = std::iter::once(normal).chain(others).collect();
                (at * frames.size, all)
            })
            .collect()
    }
}

/// The smoothed force above a baseline that follows the cell's drift: the lower envelope of the force that
/// rises no faster than a cell drifts, then the line through the medians of the lifts.
pub(super) fn above_baseline(
    frames: Frames,
    force_n: &[f64],
    smoothing: usize,
    on_n: f64,
) -> Force {
    let smooth = smoothed(force_n, smoothing);
    let envelope = lower_envelope(frames, &smooth);
    let first: Vec<f64> = smooth.iter().zip(&envelope).map(|(f, b)| f - b).collect();
    let touches = events(&first, on_n, FIRST_OFF_SHARE * on_n);
    let lifts = lifts(frames, smooth.len(), &touches);
    let baseline_n = if lifts.is_empty() {
        envelope
    } else {
        interpolated(&medians(&smooth, &lifts), smooth.len())
    };
    Force {
        level_n: smooth.iter().zip(&baseline_n).map(|(f, b)| f - b).collect(),
        baseline_n,
        lifts,
    }
}

fn lower_envelope(frames: Frames, smooth: &[f64]) -> Vec<f64> {
    let step = frames.in_time(1.0);
    let half = frames.in_time(BASELINE_WINDOW_S) / 2;
    let mut window = Vec::with_capacity(2 * half);
    // Every tenth frame is enough for a quantile of seconds.
    let thin = (frames.in_time(0.02)).max(1);
    let mut anchors: Vec<f64> = (0..smooth.len().div_ceil(step).max(1))
        .map(|i| {
            let centre = i * step;
            let (from, to) = (
                centre.saturating_sub(half),
                (centre + half + 1).min(smooth.len()),
            );
            window.clear();
            window.extend(smooth[from..to].iter().step_by(thin));
            quantile(&mut window, BASELINE_SHARE)
        })
        .collect();
    let rise = DRIFT_N_PER_S * frames.seconds(step);
    for i in 1..anchors.len() {
        anchors[i] = anchors[i].min(anchors[i - 1] + rise);
    }
    for i in (1..anchors.len()).rev() {
        anchors[i - 1] = anchors[i - 1].min(anchors[i] + rise);
    }
    let points: Vec<(usize, f64)> = anchors
        .into_iter()
        .enumerate()
        .map(|(i, level)| (i * step, level))
        .collect();
    interpolated(&points, smooth.len())
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

/// The median of `means` in every window, at its middle.
fn medians(means: &[f64], windows: &[(usize, usize)]) -> Vec<(usize, f64)> {
    windows
        .iter()
        .map(|(from, to)| {
            let median = quantile(&mut means[*from..*to].to_vec(), 0.5);
            ((from + to) / 2, median)
        })
        .collect()
}

/// Straight lines between points, level before the first and after the last.
fn interpolated(points: &[(usize, f64)], length: usize) -> Vec<f64> {
    let mut values = Vec::with_capacity(length);
    let (Some(first), Some(last)) = (points.first(), points.last()) else {
        return vec![0.0; length];
    };
    values.resize(first.0.min(length), first.1);
    for pair in points.windows(2) {
        let ((from, a), (to, b)) = (pair[0], pair[1]);
        let slope = (b - a) / (to - from).max(1) as f64;
        values.extend((from..to.min(length)).map(|i| a + slope * (i - from) as f64));
    }
    values.resize(length, last.1);
    values
}

/// The parts above `off_n` that hold a value above `on_n`, as frames from…to.
pub(super) fn events(level_n: &[f64], on_n: f64, off_n: f64) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut open: Option<(usize, f64)> = None;
    for (i, level) in level_n.iter().enumerate() {
        if *level > off_n {
            let (_, highest) = open.get_or_insert((i, *level));
            *highest = highest.max(*level);
        } else if let Some((start, highest)) = open.take()
            && highest > on_n
        {
            found.push((start, i));
        }
    }
    if let Some((start, highest)) = open
        && highest > on_n
    {
        found.push((start, level_n.len()));
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

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
        let found = above_baseline(FRAMES, &force, 5, 0.1);
        let touches = events(&found.level_n, 0.1, 0.02);
        assert_eq!(touches.len(), 10, "{touches:?}");
        for (i, (start, end)) in touches.iter().enumerate() {
            let (from, to) = (i as f64 * 2.0 + 0.5, i as f64 * 2.0 + 1.6);
            assert!((*start as f64 / 500.0 - from).abs() < 0.02, "{touches:?}");
            assert!((*end as f64 / 500.0 - to).abs() < 0.02, "{touches:?}");
        }
    }

    #[test]
    fn hysteresis_needs_both_thresholds() {
        let level = [0.0, 0.05, 0.03, 0.0, 0.03, 0.15, 0.05, 0.15, 0.0, 0.2];
        assert_eq!(events(&level, 0.1, 0.02), [(4, 8), (9, 10)]);
    }
}
