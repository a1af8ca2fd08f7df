//! Frame-wise analysis of signals: fast enough for hours of samples, with the time resolution of a cut.

use crate::quantity::SampleRate;

/// The length of a frame in s: cuts fall on whole frames.
const FRAME_S: f64 = 0.002;

/// Non-overlapping frames over a signal: the last one may be incomplete and is left out.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frames {
    /// Samples in a frame.
    pub(super) size: usize,
    pub(super) rate_hz: f64,
}

impl Frames {
    pub(super) fn at(rate: SampleRate) -> Self {
        let size = (rate.hz() * FRAME_S).round().max(1.0) as usize;
        Self {
            size,
            rate_hz: rate.hz() / size as f64,
        }
    }

    /// Frames in `seconds`, at least one.
    pub(super) fn in_time(self, seconds: f64) -> usize {
        (seconds * self.rate_hz).round().max(1.0) as usize
    }

    pub(super) fn seconds(self, frames: usize) -> f64 {
        frames as f64 / self.rate_hz
    }

    /// The number of whole frames in a signal.
    pub(super) fn count(self, signal: &[f64]) -> usize {
        signal.len() / self.size
    }

    /// The mean of every frame.
    pub(super) fn means(self, signal: &[f64]) -> Vec<f64> {
        self.means_of(signal, 0, self.count(signal))
    }

    /// The means of the frames `from`…`to`; as many as there are.
    pub(super) fn means_of(self, signal: &[f64], from: usize, to: usize) -> Vec<f64> {
        let part = self.part(signal, from, to);
        pulp::Arch::new().dispatch(
            #[inline(always)]
            || match self.size {
                // Known sizes become one instruction stream: 5 kHz and 10 kHz are what laboratories use.
                10 => fixed_means::<10>(part),
                20 => fixed_means::<20>(part),
                size => part
                    .chunks_exact(size)
                    .map(|frame| frame.iter().sum::<f64>() / size as f64)
                    .collect(),
            },
        )
    }

    fn part(self, signal: &[f64], from: usize, to: usize) -> &[f64] {
        let to = to.min(self.count(signal));
        &signal[from.min(to) * self.size..to * self.size]
    }

    /// The short-time level, for the frames `from`…`to`, of what fluctuates faster than a gesture: within a window of
    /// `width` frames, the root of the mean squares of the second difference over one frame and of the first over
    /// one sample, which sees what the other does not (multiples of the frames' rate). At 5 kHz a gesture of 2 Hz is
    /// weakened to 0.3 %.
    pub(super) fn fast_level(
        self,
        signal: &[f64],
        from: usize,
        to: usize,
        width: usize,
    ) -> Vec<f64> {
        // One frame more on each side for the difference; the first and the last of the signal have none.
        let outer = from.saturating_sub(1);
        let part = self.part(signal, outer, to + 1);
        let mut squares = pulp::Arch::new().dispatch(
            #[inline(always)]
            || match self.size {
                10 => fixed_bends::<10>(part),
                20 => fixed_bends::<20>(part),
                size => bends(part, size),
            },
        );
        squares.drain(..from - outer);
        squares.truncate(to.saturating_sub(from));
        let mut level = smoothed(&squares, width);
        for value in &mut level {
            *value = (value.max(0.0) / self.size as f64).sqrt();
        }
        level
    }
}

#[inline(always)]
fn fixed_means<const SIZE: usize>(signal: &[f64]) -> Vec<f64> {
    let (frames, _) = signal.as_chunks::<SIZE>();
    frames
        .iter()
        .map(|frame| sum_of(frame) * (1.0 / SIZE as f64))
        .collect()
}

/// A sum of a few values as a tree, so that no addition waits for more than it must.
#[inline(always)]
fn sum_of<const SIZE: usize>(values: &[f64; SIZE]) -> f64 {
    let (fours, rest) = values.as_chunks::<4>();
    let mut sums = [0.0; 4];
    for four in fours {
        for (sum, value) in sums.iter_mut().zip(four) {
            *sum += value;
        }
    }
    (sums[0] + sums[2]) + (sums[1] + sums[3]) + rest.iter().sum::<f64>()
}

/// The sum over each frame of (a − 2b + c)², with its neighbours, and of the squared steps from sample to sample; 0
/// for the first and the last.
#[inline(always)]
fn fixed_bends<const SIZE: usize>(signal: &[f64]) -> Vec<f64> {
    let (frames, _) = signal.as_chunks::<SIZE>();
    let mut squares = vec![0.0; frames.len()];
    for (square, three) in squares.iter_mut().skip(1).zip(frames.windows(3)) {
        let mut bend = [0.0; SIZE];
        for (i, bend) in bend.iter_mut().enumerate() {
            let off = three[0][i] - 2.0 * three[1][i] + three[2][i];
            let before = if i > 0 {
                three[1][i - 1]
            } else {
                three[0][SIZE - 1]
            };
            let step = three[1][i] - before;
            *bend = off * off + step * step;
        }
        *square = sum_of(&bend);
    }
    squares
}

fn bends(signal: &[f64], size: usize) -> Vec<f64> {
    let frames: Vec<&[f64]> = signal.chunks_exact(size).collect();
    let mut squares = vec![0.0; frames.len()];
    for (square, three) in squares.iter_mut().skip(1).zip(frames.windows(3)) {
        let before = three[0].last().into_iter().chain(three[1]);
        let steps = before.zip(three[1]).map(|(a, b)| (b - a).powi(2));
        let bends = three[0].iter().zip(three[1]).zip(three[2]);
        *square = bends
            .map(|((a, b), c)| (a - 2.0 * b + c).powi(2))
            .chain(steps)
            .sum();
    }
    squares
}

/// The mean over `width` frames around every frame; fewer at the ends. The sum is computed again every thousand values, so that
/// rounding does not pile up.
pub(crate) fn smoothed(values: &[f64], width: usize) -> Vec<f64> {
    let (before, after) = ((width.max(1) - 1) / 2, width.max(1) / 2);
    let n = values.len();
    let mut means = Vec::with_capacity(n);
    for block in (0..n).step_by(1024) {
        let (mut from, mut to) = (block.saturating_sub(before), (block + after + 1).min(n));
        let mut sum: f64 = values[from..to].iter().sum();
        means.push(sum / (to - from) as f64);
        let end = (block + 1024).min(n);
        if block >= before && end + after <= n {
            // Away from the ends every window is whole.
            let share = 1.0 / (to - from) as f64;
            let (old, new) = (&values[from..], &values[to..]);
            let steps = old.iter().zip(new).take(end - block - 1);
            means.extend(steps.map(|(old, new)| {
                sum += new - old;
                sum * share
            }));
            continue;
        }
        for i in block + 1..end {
            if i > before {
                sum -= values[from];
                from += 1;
            }
            if to < n {
                sum += values[to];
                to += 1;
            }
            means.push(sum / (to - from) as f64);
        }
    }
    means
}

/// The number of evenly spread values from which a threshold is estimated.
const ENOUGH: usize = 120;

/// The value below which some `share` of the values lie, from at most 240 of them, evenly spread; 0 for none.
pub(super) fn quantile(values: &[f64], share: f64) -> f64 {
    let step = (values.len() / ENOUGH).max(1);
    let mut some: Vec<f64> = values.iter().step_by(step).copied().collect();
    if some.is_empty() {
        return 0.0;
    }
    let rank = ((some.len() - 1) as f64 * share).round() as usize;
    let (_, value, _) = some.select_nth_unstable_by(rank, f64::total_cmp);
    *value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn boxes_are_means_of_what_is_there() {
        let values: Vec<f64> = (0..3000).map(|i| (f64::from(i) * 0.37).sin()).collect();
        for width in [1, 2, 5, 250] {
            let fast = smoothed(&values, width);
            for (i, found) in fast.iter().enumerate() {
                let from = i.saturating_sub((width - 1) / 2);
                let to = (i + width / 2 + 1).min(values.len());
                let mean = values[from..to].iter().sum::<f64>() / (to - from) as f64;
                assert!((found - mean).abs() < 1e-12, "{width}, {i}");
            }
        }
    }

    #[test]
    fn the_fast_level_sees_vibration_and_no_gesture() {
        let frames = Frames {
            size: 10,
            rate_hz: 500.0,
        };
        let tone = |hz: f64| -> Vec<f64> {
            (0..5000)
                .map(|i| (std::f64::consts::TAU * hz * f64::from(i) / 5000.0).sin())
                .collect()
        };
        // The window holds a whole period of each.
        let level = |hz: f64| frames.fast_level(&tone(hz), 0, 500, 250)[250] * 2f64.sqrt();
        assert!(level(2.0) < 3e-3, "{}", level(2.0));
        assert!((level(250.0) - 4.01).abs() < 0.02, "{}", level(250.0));
        for hz in [50.0, 100.0, 500.0, 800.0, 1000.0, 2000.0] {
            assert!(level(hz) > 0.35, "{hz}: {}", level(hz));
        }
    }
}
