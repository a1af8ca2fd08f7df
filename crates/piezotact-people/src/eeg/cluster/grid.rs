//! The nodes of a test and which of them are neighbours.

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
    /// [`GridError`] without a channel, frequency or time, with more than 2³¹ nodes, or a pair of a channel that does not exist.
    pub fn new(
        channels: usize,
        frequencies: usize,
        times: usize,
        neighbours: &[[usize; 2]],
    ) -> Result<Self, GridError> {
        let nodes = channels
            .checked_mul(frequencies)
            .and_then(|nodes| nodes.checked_mul(times))
            .filter(|nodes| (1..1 << 31).contains(nodes));
        if nodes.is_none() {
            return Err(GridError::Size {
                channels,
                frequencies,
                times,
            });
        }
        let mut lower = vec![Vec::new(); channels];
        for &[a, b] in neighbours {
            let found = a.max(b);
            if found >= channels {
                return Err(GridError::Neighbour { found, channels });
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

/// A grid that cannot be.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum GridError {
    /// No node, or too many.
    #[error(
        "expected 1 to 2³¹ nodes, found {channels} channels × {frequencies} frequencies × {times} times; state at least one of each, or decimate"
    )]
    Size {
        channels: usize,
        frequencies: usize,
        times: usize,
    },
    /// A neighbour that does not exist.
    #[error(
        "expected neighbours below {channels}, found {found}; take them from the montage of the same channels"
    )]
    Neighbour {
        found: usize,
        /// The number of channels.
        channels: usize,
    },
}
