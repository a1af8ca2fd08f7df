//! The nodes of a test and which of them are neighbours.

use crate::eeg::cluster::ClusterError;

/// Channels × frequencies × times, and which channels are neighbours. Nodes are numbered in this order, times fastest.
///
/// Neighbours are: the same channel and frequency at the next time; the same channel and time at the next frequency; neighbouring channels at the
/// same frequency and time (MNE-Python's `combine_adjacency`).
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Grid {
    channels: usize,
    frequencies: usize,
    times: usize,
    /// The neighbours of each channel with a lower index.
    lower: Vec<Vec<usize>>,
}

impl Grid {
    /// A grid with the pairs of neighbouring channels, in any order.
    ///
    /// # Errors
    /// [`ClusterError`] without a channel, frequency or time, with more than 2³¹ nodes, or a pair of a channel that does not exist.
    pub fn new(
        channels: usize,
        frequencies: usize,
        times: usize,
        neighbours: &[[usize; 2]],
    ) -> Result<Self, ClusterError> {
        let nodes = channels
            .checked_mul(frequencies)
            .and_then(|nodes| nodes.checked_mul(times))
            .filter(|nodes| (1..1 << 31).contains(nodes));
        if nodes.is_none() {
            return Err(ClusterError::Shape {
                expected: "1 to 2³¹ nodes".to_owned(),
                found: format!("{channels} channels × {frequencies} frequencies × {times} times"),
            });
        }
        let mut lower = vec![Vec::new(); channels];
        for &[a, b] in neighbours {
            let found = a.max(b);
            if found >= channels {
                return Err(ClusterError::Shape {
                    expected: format!("neighbours below {channels}"),
                    found: found.to_string(),
                });
            }
            if a != b {
                lower[found].push(a.min(b));
            }
        }
        for list in &mut lower {
            list.sort_unstable();
            list.dedup();
        }
        Ok(Self {
            channels,
            frequencies,
            times,
            lower,
        })
    }

    /// The number of nodes.
    #[must_use]
    pub fn nodes(&self) -> usize {
        self.channels * self.frequencies * self.times
    }

    /// The channel, the frequency and the time of a node, by their indices.
    #[must_use]
    pub fn place(&self, node: usize) -> [usize; 3] {
        let line = node / self.times;
        [
            line / self.frequencies,
            line % self.frequencies,
            node % self.times,
        ]
    }

    /// Calls `to` with each neighbour of a node that has a lower number.
    #[inline]
    pub(super) fn for_each_lower(&self, node: usize, mut to: impl FnMut(usize)) {
        let [channel, frequency, time] = self.place(node);
        if time > 0 {
            to(node - 1);
        }
        if frequency > 0 {
            to(node - self.times);
        }
        for other in &self.lower[channel] {
            to(node - (channel - other) * self.frequencies * self.times);
        }
    }
}
