//! Signals seen frame by frame: fast enough for an hour of samples, fine enough for a cut.

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

    /// The mean of every frame.
    pub(super) fn means(self, signal: &[f64]) -> Vec<f64> {
        let share = 1.0 / self.size as f64;
        match self.size {
            // Known sizes become one instruction stream: 5 kHz and 10 kHz are what laboratories use.
            10 => fixed_means::<10>(signal),
            20 => fixed_means::<20>(signal),
            size => signal
                .chunks_exact(size)
                .map(|frame| frame.iter().sum::<f64>() * share)
                .collect(),
        }
    }

    /// The short-time level of what fluctuates faster than a gesture: the rms, within a window of `width` frames,
    /// of the second difference over one frame. A gesture of 2 Hz is weakened by 2e-4, what vibrates at a
    /// third of the frames' rate grows by a factor of 3.
    pub(super) fn fast_level(self, signal: &[f64], width: usize) -> Vec<f64> {
        let lag = self.size;
        let count = signal.len() / lag;
        let mut squares = vec![0.0; count];
        for (i, square) in squares.iter_mut().enumerate().skip(1) {
            let Some([before, now, after]) = self.three(signal, i) else {
                continue;
            };
            *square = before
                .iter()
                .zip(now)
                .zip(after)
                .map(|((a, b), c)| {
                    let bend = a - 2.0 * b + c;
                    bend * bend
                })
                .sum();
        }
        let samples = lag as f64;
        smoothed(&squares, width)
            .into_iter()
            .map(|square| (square.max(0.0) / samples).sqrt())
            .collect()
    }

    /// Frame `i` with the one before and the one after.
    fn three(self, signal: &[f64], i: usize) -> Option<[&[f64]; 3]> {
        let part = |k: usize| signal.get(k * self.size..(k + 1) * self.size);
        Some([part(i.checked_sub(1)?)?, part(i)?, part(i + 1)?])
    }
}

fn fixed_means<const SIZE: usize>(signal: &[f64]) -> Vec<f64> {
    let (frames, _) = signal.as_chunks::<SIZE>();
    frames
        .iter()
        .map(|frame| frame.iter().sum::<f64>() * (1.0 / SIZE as f64))
        .collect()
}

/// The mean over `width` frames around every frame; fewer at the ends.
pub(super) fn smoothed(values: &[f64], width: usize) -> Vec<f64> {
    box_sums(values, width)
        .into_iter()
        .map(|(sum, frames)| sum / frames as f64)
        .collect()
}

/// The sum over `width` values around every value, and how many there were. Summed anew every thousand values,
/// so that rounding does not pile up.
fn box_sums(values: &[f64], width: usize) -> Vec<(f64, usize)> {
    let (before, after) = ((width.max(1) - 1) / 2, width.max(1) / 2);
    let range = |i: usize| (i.saturating_sub(before), (i + after + 1).min(values.len()));
    let mut sum = 0.0;
    let mut at = (0, 0);
    (0..values.len())
        .map(|i| {
            let (from, to) = range(i);
            if i % 1024 == 0 {
                sum = values[from..to].iter().sum();
            } else {
                if from > at.0 {
                    sum -= values[at.0];
                }
                if to > at.1 {
                    sum += values[to - 1];
                }
            }
            at = (from, to);
            (sum, to - from)
        })
        .collect()
}

/// The value below which `share` of the values lie; 0 for none. Reorders them.
pub(super) fn quantile(values: &mut [f64], share: f64) -> f64 {
    if values.is_empty() {
        return 0.0;
    }
    let rank = ((values.len() - 1) as f64 * share).round() as usize;
    let (_, value, _) = values.select_nth_unstable_by(rank, f64::total_cmp);
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
        let level = |hz: f64| frames.fast_level(&tone(hz), 50)[250];
        assert!(level(2.0) < 3e-4, "{}", level(2.0));
        assert!((level(250.0) - 4.0 / 2f64.sqrt()).abs() < 0.01);
    }
}
