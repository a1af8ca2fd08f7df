//! Seeded draws. The generator is `ChaCha8` by name, so that one seed gives one sequence on every machine.

use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

pub(super) struct Draws(ChaCha8Rng);

impl Draws {
    pub(super) fn new(seed: u64) -> Self {
        Self(ChaCha8Rng::seed_from_u64(seed))
    }

    /// A whole number from 0 up to, not including, `below`, which is small beside 2^53.
    pub(super) fn below(&mut self, below: usize) -> usize {
        let share = (self.0.next_u64() >> 11) as f64 * 2f64.powi(-53);
        ((share * below as f64) as usize).min(below.saturating_sub(1))
    }

    /// `things` in a random order (Fisher and Yates).
    pub(super) fn shuffle(&mut self, things: &mut [usize]) {
        for i in (1..things.len()).rev() {
            things.swap(i, self.below(i + 1));
        }
    }
}
