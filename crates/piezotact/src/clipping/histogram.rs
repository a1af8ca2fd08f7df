//! The distribution of amplitudes in equal bins, counted in one pass, and bounds of the counts in any interval of it.

use super::pass::tally;

/// The number of bins over the whole range: twice as many as the narrowest bins in which a peak is looked for.
const BINS: usize = 4096;

/// How many samples lie below each of the edges of equal bins.
pub(super) struct Histogram {
    /// Samples in the bins before this one; one more than there are bins, as the largest value has a bin of its own.
    below: Vec<u32>,
    low: f64,
    scale: f64,
}

impl Histogram {
    /// The histogram of `samples`, which lie between `low` and `high`.
    pub(super) fn of(samples: &[f64], low: f64, high: f64) -> Self {
        let scale = BINS as f64 / (high - low);
        let counts = tally(samples, BINS as u32, move |v| (v - low) * scale);
        let mut below = vec![0_u32; BINS + 2];
        for (k, count) in counts.into_iter().enumerate() {
            below[k + 1] = below[k] + count;
        }
        Self { below, low, scale }
    }

    /// The median, to one bin.
    pub(super) fn median(&self) -> f64 {
        let all = u64::from(*self.below.last().unwrap_or(&0));
        let half = |below: &u32| 2 * u64::from(*below) < all;
        let bin = self.below.partition_point(half).saturating_sub(1);
        self.low + (bin as f64 + 0.5) / self.scale
    }

    /// The counts seen from one end: the upper for a positive `sign`, else the lower.
    pub(super) fn seen_from(&self, sign: f64) -> FromEnd<'_> {
        FromEnd {
            histogram: self,
            upper: sign > 0.0,
        }
    }
}

/// Bounds of the number of samples within a distance of one end of the distribution: the bin that the edge falls into, and the one
/// beside it, may belong to either side.
#[derive(Clone, Copy)]
pub(super) struct FromEnd<'a> {
    histogram: &'a Histogram,
    upper: bool,
}

impl FromEnd<'_> {
    /// The number of samples in the first `bins` bins.
    fn in_bins(self, bins: usize) -> u32 {
        let below = &self.histogram.below;
        let last = below.len() - 1;
        if self.upper {
            below[last] - below[last - bins.min(last)]
        } else {
            below[bins.min(last)]
        }
    }

    /// Not fewer samples than lie within `distance` of the end.
    pub(super) fn at_most(self, distance: f64) -> u32 {
        self.in_bins((distance * self.histogram.scale) as usize + 3)
    }

    /// Not more samples than lie within `distance` of the end.
    pub(super) fn at_least(self, distance: f64) -> u32 {
        self.in_bins(((distance * self.histogram.scale) as usize).saturating_sub(1))
    }
}
